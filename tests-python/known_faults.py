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
KNOWN_FAULTS = {
    "DICOM JPEG 2000 cut to 30 dB": MIDDLE,
    "DICOM JPEG 2000 cut to 40 dB": MIDDLE,
    "DICOM JPEG 2000 cut to 60 dB": MIDDLE,
}
