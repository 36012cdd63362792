"""Checks splatvol's readers and writers against those of other programs (requirements.txt).

Usage: check_readers.py PROGRAM [FOLDER_OF_SCANS [PART_OF_NAME]]

Every file is read by splatvol and by a reader that shares no code with it: dimensions, world positions of the
corners, range, mean and every voxel must agree. Checks that were skipped, and those that fail for a known fault, are
counted and named at the end. Exit code 1 where anything else fails.
"""

import sys
import tempfile
from pathlib import Path

import analyze_files
import dicom_colors
import dicom_files
import generated_files
import mgh_files
import point_files
import shared_files
import tiff_files
import vtk_files
import written_files
import zarr_files
from outcomes import Outcomes, Skipped
from splatvol_cli import Splatvol

MODULES = [
    generated_files,
    written_files,
    dicom_files,
    dicom_colors,
    analyze_files,
    mgh_files,
    tiff_files,
    zarr_files,
    vtk_files,
    point_files,
]


def main(program, scans, wanted=""):
    """Runs the checks whose names contain `wanted`, and returns how many failed."""
    outcomes = Outcomes()
    with tempfile.TemporaryDirectory(prefix="splatvol-readers-") as name:
        folder = Path(name)
        splatvol = Splatvol(program, folder)
        for label, check in checks(splatvol, folder, scans):
            if wanted in label:
                outcomes.run(label, check)
    outcomes.report()
    return len(outcomes.failed)


def checks(splatvol, folder, scans):
    """All named checks."""
    for module in MODULES:
        yield from module.cases(splatvol, folder)
    if scans is not None and scans.is_dir():
        yield from shared_files.cases(splatvol, scans)
    else:
        yield "scans of many origins", absent


def absent():
    raise Skipped("no folder of scans")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3, 4):
        sys.exit(__doc__)
    folder = Path(sys.argv[2]) if len(sys.argv) > 2 else None
    sys.exit(1 if main(sys.argv[1], folder, *sys.argv[3:]) else 0)
