"""Names of units of length."""

from __future__ import annotations

UNITS = {
    **dict.fromkeys(("mm", "millimeter", "millimeters", "millimetre", "millimetres"), "mm"),
    **dict.fromkeys(("um", "µm", "μm", "micron", "microns", "micrometer", "micrometers"), "um"),
    **dict.fromkeys(("micrometre", "micrometres"), "um"),
    **dict.fromkeys(("nm", "nanometer", "nanometers", "nanometre", "nanometres"), "nm"),
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), "m"),
}


def unit_of(name: str) -> str | None:
    """The unit of a name, as the command reads it; `None` where it is unknown."""
    return UNITS.get(name.strip().lower())
