"""What the command `splatvol` says of a volume file, as numpy arrays."""

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass
class Volume:
    """A volume in memory. `values[z, y, x]` are real values; `ras_from_voxel` is 4 x 4, None where unknown."""

    values: np.ndarray
    ras_from_voxel: np.ndarray | None
    minimum: float | None = None
    maximum: float | None = None
    mean: float | None = None
    unit: str | None = None


class Refused(Exception):
    """splatvol refused a file: its exit code and what it said."""

    def __init__(self, code, text):
        super().__init__(f"exit code {code}: {text.strip()}")
        self.code = code


class Splatvol:
    """The program, and a folder for what it writes."""

    def __init__(self, program, folder):
        self.program = str(program)
        self.folder = Path(folder)

    def run(self, *arguments):
        """Runs a command and returns its stdout."""
        command = [self.program, "--quiet", *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
        if done.returncode != 0:
            raise Refused(done.returncode, done.stderr)
        return done.stdout

    def info(self, path, *options):
        """What `splatvol info --json` says."""
        return json.loads(self.run("info", "--json", path, *options))

    def read(self, path, *options):
        """`splatvol info --json` and the samples of `splatvol convert PATH OUT.npy`."""
        info = self.info(path, *options)
        output = self.folder / "read.npy"
        self.run("convert", path, output, "--overwrite", *options)
        values = np.load(output)
        shape = tuple(reversed(info["dims"]))
        if values.shape != shape:
            raise AssertionError(f"info says {shape}, the array is {values.shape}")
        affine = np.eye(4)
        affine[:3, :3] = np.array(info["directions"]).T * np.array(info["spacing"])
        affine[:3, 3] = info["origin"]
        return Volume(values, affine, info["min"], info["max"], info["mean"], info["unit"])
