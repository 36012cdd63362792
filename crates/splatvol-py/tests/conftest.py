"""Helpers of the tests: the command, and pictures compared by their pixels."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from splatvol._verbs import pixels_of

SHARED = Path(os.environ.get("SPLATVOL_SHARED_DATA", Path(__file__).parents[4] / "shared" / "data"))


def shared(*parts: str) -> Path:
    """A file of the shared data; the test is skipped where it is absent."""
    path = SHARED.joinpath(*parts)
    if not path.exists():
        pytest.skip(f"{'/'.join(parts)} of the shared data is not here")
    return path


@pytest.fixture
def command(tmp_path: Path) -> Callable[..., np.ndarray]:
    """Pixels of the command's picture: of the program that SPLATVOL_COMMAND names, or of the one in the package."""

    def run(*arguments: object, folder: Path = tmp_path) -> np.ndarray:
        picture = tmp_path / "command.png"
        program = os.environ.get("SPLATVOL_COMMAND")
        start = [program] if program else [sys.executable, "-m", "splatvol"]
        line = [*start, "render", *map(str, arguments), "-o", str(picture), "--overwrite", "-q"]
        subprocess.run(line, check=True, cwd=folder, capture_output=True, text=True)
        codes = pixels_of(picture)
        return np.asarray(codes)

    return run


@pytest.fixture(scope="session")
def ball() -> np.ndarray:
    """A soft ball, float32, z y x."""
    z, y, x = np.mgrid[-1:1:20j, -1:1:24j, -1:1:28j]
    return np.clip(1.2 - np.sqrt(x**2 + 2 * y**2 + 3 * z**2), 0, 1).astype(np.float32)


@pytest.fixture
def scan(tmp_path: Path, ball: np.ndarray) -> Callable[[str], Path]:
    """A file of the shared data, or one that another package writes: of the ball, where the name begins with it."""

    def find(name: str) -> Path:
        if not name.startswith("ball"):
            return shared("volumes", name)
        path = tmp_path / name
        write(path, ball)
        return path

    return find


def write(path: Path, ball: np.ndarray) -> None:
    """Writes a volume by the package that the ending belongs to; a path without one becomes a folder of slices."""
    if path.name.endswith(".nii.gz"):
        nibabel = pytest.importorskip("nibabel")
        # Tilted, with spacings of 0.5, 0.5 and 1.
        affine = [[-0.5, 0, 0, 9], [0, 0.4, 0.6, -7], [0, -0.3, 0.8, 3], [0, 0, 0, 1]]
        nibabel.save(nibabel.Nifti1Image(ball.transpose(2, 1, 0), affine), path)
    elif path.suffix == ".mhd":
        simple = pytest.importorskip("SimpleITK")
        image = simple.GetImageFromArray(ball)
        image.SetSpacing((0.5, 0.75, 1.25))
        simple.WriteImage(image, str(path))
    elif path.suffix == ".tif":
        pytest.importorskip("tifffile").imwrite(path, codes_of(ball))
    elif path.suffix == ".vti":
        pyvista = pytest.importorskip("pyvista")
        grid = pyvista.ImageData(dimensions=ball.shape[::-1], spacing=(0.5, 0.75, 1.25))
        grid.point_data["density"] = ball.ravel()
        grid.save(path)
    else:
        path.mkdir()
        for number, plane in enumerate(codes_of(ball)):
            pytest.importorskip("tifffile").imwrite(path / f"slice{number:03}.tif", plane)


def codes_of(ball: np.ndarray) -> np.ndarray:
    """The ball in bytes."""
    return (ball * 200).astype(np.uint8)


def program() -> str | None:
    """The command's program, if there is one."""
    return os.environ.get("SPLATVOL_COMMAND") or shutil.which("splatvol")
