"""Scans of many origins, read by splatvol and by another reader.

Each entry is a file below `shared/data/volumes`, the reader, and whether values must be equal (they are rounded to
f32 where the header rescales them).
"""

import zlib

import numpy as np

from comparison import compare
from other_readers import with_nibabel, with_numpy, with_pynrrd, with_simpleitk
from splatvol_cli import Volume

FILES = [
    ("chris_t1.nii.gz", with_nibabel, True),
    ("MNI152_2009_template.nii.gz", with_nibabel, True),
    ("FLAIR.nii.gz", with_nibabel, True),
    ("shear.nii.gz", with_nibabel, False),
    ("avg152T1_RL_nifti.nii.gz", with_nibabel, True),
    ("zstat1.nii.gz", with_nibabel, True),
    ("anatomical.nii", with_nibabel, True),
    ("dwi_b0.nii.gz", with_nibabel, True),
    *[
        (f"nifti_space/{code}.nii.gz", with_nibabel, False)
        for code in ["RAS", "LPI", "PSR", "ASL", "IAR", "SPL", "ILP", "ARS"]
    ],
    ("FLAIR.nrrd", with_pynrrd, True),
    ("FLAIR.nrrd", with_simpleitk, True),
    ("tooth.nrrd", with_pynrrd, True),
    ("tooth.nrrd", with_simpleitk, True),
    ("LIDC2.mha", with_simpleitk, True),
    ("HeadMRVolume.mhd", with_simpleitk, True),
    ("ironProt.vtk", with_simpleitk, True),
    ("stent.npz", with_numpy, True),
]

# Headerless files, whose layout is in their names.
RAW = [
    ("tooth_103x94x161_uint8.raw", (161, 94, 103)),
    ("neghip_64x64x64_uint8.raw", (64, 64, 64)),
]


def whole_frog(folder):
    """ITK reads as many bytes as CompressedDataSize says and leaves zeros behind them; the file holds them all."""
    volume = with_simpleitk(folder / "frogtissue.mhd")
    samples = zlib.decompress((folder / "frogtissue.zraw").read_bytes())
    volume.values = np.frombuffer(samples, np.uint8).reshape(volume.values.shape)
    return volume


def numbered_slices(folder):
    """Neither pynrrd nor ITK takes this header: slices `quarter.1` to `quarter.93`, a left-handed space."""
    slices = [np.fromfile(folder / f"headsq/quarter.{i}", "<i2").reshape(64, 64) for i in range(1, 94)]
    return Volume(np.stack(slices), np.diag([3.2, 3.2, -1.5, 1.0]))


def cases(splatvol, folder):
    """Named checks of the files in `folder`."""
    yield "frogtissue.mhd by zlib", lambda: compare(
        whole_frog(folder), splatvol.read(folder / "frogtissue.mhd")
    )
    yield "headsq/quarter.nhdr by numpy", lambda: compare(
        numbered_slices(folder), splatvol.read(folder / "headsq/quarter.nhdr")
    )
    for name, reader, exact in FILES:
        label = f"{name} by {reader.__name__.removeprefix('with_')}"
        yield label, lambda path=folder / name, reader=reader, exact=exact: compare(
            reader(path), splatvol.read(path), exact
        )
    for name, shape in RAW:
        yield f"{name} by numpy", lambda path=folder / name, shape=shape: compare(
            Volume(np.fromfile(path, np.uint8).reshape(shape), np.eye(4)), splatvol.read(path)
        )
