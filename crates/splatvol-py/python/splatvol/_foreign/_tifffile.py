"""Files, series and pages of tifffile, placed by ImageJ's or OME's description as the command places them."""

from __future__ import annotations

import warnings
import xml.etree.ElementTree as ElementTree
from typing import Any

from .._data import Volume
from .._errors import DataWarning, InvalidValue
from ._units import unit_of

Spacing = dict[str, float]


def from_tifffile(thing: Any, *, channel: int | None = None, time: int | None = None) -> Volume | None:
    """A volume of a TiffFile, of one of its series, or of a page; `channel` and `time` are 0 by default."""
    series = thing.series[0] if hasattr(thing, "series") else thing
    if not hasattr(series, "axes") or not hasattr(series, "asarray"):
        return None
    pages = getattr(series, "keyframe", series)
    file = getattr(thing, "parent", None) or getattr(pages, "parent", None) or thing
    array, axes = series.asarray(), str(series.axes)
    asked = {"C": channel, "T": time}
    for letter in axes:
        if letter in "CTS":
            at = axes.index(letter)
            array, axes = array.take(_chosen(letter, array.shape[at], asked), axis=at), axes.replace(letter, "")
    # Pages without a description are slices.
    axes = axes if "Z" in axes else axes.replace("I", "Z", 1) if "I" in axes else axes.replace("Q", "Z", 1)
    if "Z" not in axes:
        array, axes = array[None], "Z" + axes
    if sorted(axes) != ["X", "Y", "Z"]:
        message = f"axes {series.axes} are not x, y, z, c and t: write Volume(file.asarray()[...], axes=...)"
        raise InvalidValue(message, field="axes", value=str(series.axes))
    spacing, unit = _placement(file, pages)
    return Volume(array, axes=axes.lower(), spacing=spacing, unit=unit, name=getattr(file, "filename", None))


def _chosen(letter: str, size: int, asked: dict[str, int | None]) -> int:
    if letter == "S":
        if size > 1:
            message = f"{size} samples a pixel are colours: write Volume(file.asarray()[..., 0])"
            raise InvalidValue(message, field="axes", value="S")
        return 0
    field = {"C": "channel", "T": "time"}[letter]
    chosen = asked[letter]
    if not 0 <= (chosen or 0) < size:
        raise InvalidValue(f"{field}: {chosen} is not there, there are {size}", field=field, value=str(chosen))
    if chosen is None and size > 1:
        warnings.warn(f"{field} 0 of {size} is read: write {field}=", DataWarning, stacklevel=5)
    return chosen or 0


def _placement(file: Any, page: Any) -> tuple[Spacing | None, str | None]:
    if getattr(file, "is_imagej", False):
        return _of_imagej(file.imagej_metadata or {}, page)
    if getattr(file, "is_ome", False):
        return _of_ome(file.ome_metadata or "")
    return None, None


def _of_imagej(known: dict[str, Any], page: Any) -> tuple[Spacing | None, str | None]:
    """ImageJ writes "inch" or "pixel" if nobody has calibrated anything: then only the slices' distance counts."""
    name = str(known.get("unit", "")).replace("\\u00B5", "µ")
    scale, unit = (10.0, "mm") if name == "cm" else (1.0, unit_of(name))
    between = abs(float(known.get("spacing", 0.0))) or None
    if unit is None:
        return {"z": between or 1.0}, None
    x = _length(page, "XResolution") or 1.0
    y = _length(page, "YResolution") or x
    return {"x": x * scale, "y": y * scale, "z": (between or x) * scale}, unit


def _length(page: Any, tag: str) -> float | None:
    """Length of a pixel: the inverse of the resolution."""
    found = page.tags.get(tag)
    pixels, lengths = found.value if found is not None else (0, 0)
    return lengths / pixels if pixels and lengths else None


def _of_ome(text: str) -> tuple[Spacing | None, str | None]:
    pixels = next((node for node in ElementTree.fromstring(text).iter() if node.tag.endswith("}Pixels")), None)
    if pixels is None:
        return None, None
    sizes = {axis: pixels.get(f"PhysicalSize{axis.upper()}") for axis in "xyz"}
    units = {pixels.get(f"PhysicalSize{axis.upper()}Unit", "µm") for axis in "xyz" if sizes[axis]}
    lengths = {axis: float(size) for axis, size in sizes.items() if size}
    unit = unit_of(units.pop()) if len(units) == 1 else None
    if "x" in lengths:
        lengths = {"y": lengths["x"], "z": lengths["x"], **lengths}
    return lengths or None, unit
