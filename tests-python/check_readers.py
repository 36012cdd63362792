"""Checks splatvol's readers and writers against nibabel, pynrrd, SimpleITK and numpy.

Usage: check_readers.py PROGRAM [FOLDER_OF_SCANS]

Every file is read by splatvol and by a reader that shares no code with it: dimensions, world positions of the
corners, range, mean and every voxel must agree. Exit code 1 where anything does not.
"""

import sys
import tempfile
from pathlib import Path

import generated_files
import shared_files
import written_files
from splatvol_cli import Splatvol


def main(program, scans):
    """Runs all checks and returns how many failed."""
    with tempfile.TemporaryDirectory(prefix="splatvol-readers-") as name:
        folder = Path(name)
        splatvol = Splatvol(program, folder)
        checks = list(generated_files.Generator(splatvol, folder).cases())
        checks += written_files.cases(splatvol, folder)
        if scans is not None and scans.is_dir():
            checks += shared_files.cases(splatvol, scans)
        else:
            print("skipped: ../shared absent, generated files only")
        failures = [label for label, check in checks if not passes(label, check)]
    print(f"independent readers: {len(checks) - len(failures)} of {len(checks)} checks passed")
    return len(failures)


def passes(label, check):
    """Runs one check; a failure is printed."""
    try:
        check()
    except Exception as error:  # Whatever a reader raises, the files do not agree.
        print(f"FAILED {label}: {type(error).__name__}: {error}")
        return False
    return True


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    sys.exit(1 if main(sys.argv[1], Path(sys.argv[2]) if len(sys.argv) == 3 else None) else 0)
