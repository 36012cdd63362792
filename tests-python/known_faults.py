"""Checks that fail because of a fault of splatvol that is known. One that passes must leave this list."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Fault:
    """What is wrong, and a part of the message by which the check fails."""

    reason: str
    says: str


MIDDLE = Fault(
    "DICOM: JPEG 2000 coefficients whose low bits were cut off are put at the near end of their interval, not in its"
    " middle: errors are 1.3 to 1.8 times OpenJPEG's",
    "root mean square error",
)
COLOR_SCALARS = Fault(
    "legacy VTK: COLOR_SCALARS in text, which VTK writes for bytes, are read as 0 to 1; in binary files they are bytes",
    "voxels differ",
)
COLORS_BY_JPEG_LS = Fault("DICOM: colours coded as JPEG-LS are not read", "coloured pixels coded as JPEG-LS")
JPEG_12 = Fault("DICOM: JPEG of 12 bits (extended) is not read", "SamplePrecision(12)")

KNOWN_FAULTS = {
    "DICOM colours, JPEG-LS": COLORS_BY_JPEG_LS,
    "DICOM JPEG of 12 bits": JPEG_12,
    **{f"legacy VTK {version} image u1 ascii": COLOR_SCALARS for version in ["4.2", "5.1"]},
    "DICOM JPEG 2000 cut to 30 dB": MIDDLE,
    "DICOM JPEG 2000 cut to 40 dB": MIDDLE,
    "DICOM JPEG 2000 cut to 60 dB": MIDDLE,
}
