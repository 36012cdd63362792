"""Analyze 7.5 images of nibabel, whose samples and spacings splatvol must read. They do not say how a body lies."""

import itertools

import nibabel
import numpy as np

from comparison import compare
from generated_files import noise
from splatvol_cli import Volume

SPACING = [0.75, 1.5, 2.25]


def cases(splatvol, folder):
    """Named checks: types, byte orders."""
    (folder / "analyze").mkdir()
    for dtype, endian in itertools.product(["u1", "i2", "i4", "f4", "f8"], "<>"):
        name = f"Analyze {dtype} {'little' if endian == '<' else 'big'}-endian"
        yield name, lambda n=name, d=dtype, e=endian: one(splatvol, folder / "analyze", n, d, e)


def one(splatvol, folder, name, dtype, endian):
    header = nibabel.AnalyzeHeader(endianness=endian)
    header.set_data_dtype(np.dtype(endian + dtype))
    values = noise(dtype)
    path = folder / f"{name.replace(' ', '_')}.img"
    nibabel.save(nibabel.AnalyzeImage(values, np.diag([*SPACING, 1.0]), header), path)
    actual = splatvol.read(path)
    compare(Volume(np.asanyarray(nibabel.load(path).dataobj).T, None), actual)
    spacing = np.linalg.norm(actual.ras_from_voxel[:3, :3], axis=0)
    assert np.allclose(spacing, SPACING, rtol=1e-6), f"spacing {spacing}"
    assert actual.unit == "mm", f"unit {actual.unit!r}"
