"""FreeSurfer's MGH and MGZ files written by nibabel, that splatvol must read as nibabel does."""

import itertools

import nibabel
import numpy as np

from comparison import compare
from generated_files import SHAPE_XYZ, noise, oblique_affine, rotation
from other_readers import with_nibabel

TYPES = ["u1", "i2", "i4", "f4"]


def cases(splatvol, folder):
    """Named checks: types, compression, orientations, frames."""
    for dtype, suffix in itertools.product(TYPES, [".mgh", ".mgz"]):
        yield (
            f"MGH {dtype}{suffix}",
            lambda d=dtype, s=suffix: one(splatvol, folder / f"{d}{s}", noise(d), oblique_affine()),
        )
    for seed in range(4):
        affine = oblique_affine()
        affine[:3, :3] = rotation(seed) @ np.diag([-0.5, 1.25, 3.0])
        yield f"MGH oblique {seed}", lambda a=affine, s=seed: one(splatvol, folder / f"oblique_{s}.mgz", noise("i2"), a)
    for suffix in [".mgh", ".mgz"]:
        yield f"MGH frames{suffix}", lambda s=suffix: frames(splatvol, folder / f"frames{s}")


def write(path, values, affine):
    image = nibabel.MGHImage(values, affine)
    image.header.set_data_dtype(values.dtype)
    nibabel.save(image, path)


def one(splatvol, path, values, affine):
    write(path, values, affine)
    actual = splatvol.read(path)
    assert actual.unit == "mm", f"unit {actual.unit!r}"
    compare(with_nibabel(path), actual)


def frames(splatvol, path):
    write(path, noise("i2", 5, (*SHAPE_XYZ, 3)), oblique_affine())
    for time in range(3):
        compare(with_nibabel(path, time), splatvol.read(path, "--time", time))
