"""A Python environment of this folder's own, so that nothing needs to be installed by hand.

Only the standard library may be used here: it runs before the environment exists.
"""

import hashlib
import os
import subprocess
import sys
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
FOLDER = HERE / ".venv"
REQUIREMENTS = HERE / "requirements.txt"
OLDEST = (3, 11)


def enter():
    """Returns inside the environment; otherwise makes it where necessary and runs the program again in it."""
    if Path(sys.prefix).resolve() == FOLDER.resolve():
        return
    if sys.version_info < OLDEST:
        sys.exit(f"compare.py: Python {OLDEST[0]}.{OLDEST[1]} or newer is needed, this is {sys.version.split()[0]}")
    python = FOLDER / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    stamp = FOLDER / "requirements.sha256"
    wanted = hashlib.sha256(REQUIREMENTS.read_bytes()).hexdigest()
    if not stamp.is_file() or stamp.read_text() != wanted:
        create(python)
        stamp.write_text(wanted)
    choose_off_screen_window()
    command = [str(python), *sys.argv]
    if os.name == "nt":  # There exec returns to the shell before the program has ended.
        sys.exit(subprocess.run(command).returncode)
    os.execv(python, command)


def create(python):
    """Makes the environment and installs the peers into it."""
    print(f"compare.py: installing VTK and others into {FOLDER} (once, 400 MB)", file=sys.stderr)
    venv.create(FOLDER, clear=True, with_pip=True)
    install = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r", str(REQUIREMENTS)]
    if subprocess.run(install).returncode != 0:
        sys.exit(f"compare.py: pip could not install {REQUIREMENTS} (see above)")


def choose_off_screen_window():
    """Keeps VTK from looking for an X server, where there is none."""
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
