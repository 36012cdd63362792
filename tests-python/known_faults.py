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
EDGES = Fault("TIFF: LZW in tiles that stick out over the right edge is refused", "no lzw end code found")
WHITE = Fault(
    "TIFF: where white is zero, unsigned samples and floats are turned round without a warning, but not if zstd coded"
    " them",
    "voxels differ",
)
WHITE_SIGNED = Fault(
    "TIFF: signed samples are refused where white is zero, but not if zstd coded them",
    "unknown photometric interpretation",
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
    **{f"TIFF u1 LZW, tiles, {endian}": EDGES for endian in ["little", "big"]},
    **{f"TIFF white is zero, {dtype} {code}": WHITE for dtype in ["u1", "u2", "f4"] for code in ["none", "LZW"]},
    **{f"TIFF white is zero, i2 {code}": WHITE_SIGNED for code in ["none", "LZW"]},
    "DICOM JPEG 2000 cut to 30 dB": MIDDLE,
    "DICOM JPEG 2000 cut to 40 dB": MIDDLE,
    "DICOM JPEG 2000 cut to 60 dB": MIDDLE,
}
