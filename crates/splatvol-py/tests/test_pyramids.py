"""OME-Zarr that the command writes, as zarr-python reads it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

zarr = pytest.importorskip("zarr")


def halved(samples: np.ndarray) -> np.ndarray:
    """Means of boxes of two samples along each axis, halves to the even number."""
    z, y, x = (n // 2 for n in samples.shape)
    boxes = samples.reshape(z, 2, y, 2, x, 2).astype(np.float64)
    return np.rint(boxes.mean(axis=(1, 3, 5))).astype(samples.dtype)


@pytest.mark.parametrize("version", ["0.4", "0.5"])
@pytest.mark.parametrize("compression", ["lz4", "zlib", "none"])
@pytest.mark.parametrize("dtype", ["uint8", "int16", "float32"])
def test_images_are_read_by_zarr(tmp_path: Path, version: str, compression: str, dtype: str) -> None:
    random = np.random.default_rng(20)
    smooth = np.cumsum(random.integers(-3, 4, (48, 40, 32)), axis=2)
    samples = (smooth - smooth.min()).astype(dtype)
    np.save(tmp_path / "a.npy", samples)
    flags = ["--chunk", "16", "--levels", "2", "--ome-version", version, "--compression", compression]
    program = os.environ.get("SPLATVOL_COMMAND")
    start = [program] if program else [sys.executable, "-m", "splatvol"]
    subprocess.run([*start, "convert", "a.npy", "a.ome.zarr", *flags], cwd=tmp_path, check=True)
    group = zarr.open_group(tmp_path / "a.ome.zarr", mode="r")
    attributes = dict(group.attrs)
    image = attributes.get("ome", attributes)["multiscales"][0]
    names = [dataset["path"] for dataset in image["datasets"]]
    levels = [np.asarray(group[name]) for name in names]
    assert [level.dtype for level in levels] == [samples.dtype] * 2
    np.testing.assert_array_equal(levels[0], samples)
    if dtype == "float32":
        np.testing.assert_allclose(levels[1], samples.reshape(24, 2, 20, 2, 16, 2).mean(axis=(1, 3, 5)), rtol=1e-6)
    else:
        np.testing.assert_array_equal(levels[1], halved(samples))
    scale, translation = image["datasets"][1]["coordinateTransformations"]
    assert scale["scale"] == [2.0] * 3
    assert translation["translation"] == [0.5] * 3
