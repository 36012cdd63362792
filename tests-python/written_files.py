"""Files written by splatvol, that pynrrd, SimpleITK and numpy must read as splatvol reads the source."""

import nibabel
import numpy as np

from comparison import compare
from generated_files import TYPES, noise, oblique_affine
from other_readers import with_nibabel, with_pynrrd, with_simpleitk
from splatvol_cli import Volume

SAMPLES = ["head:24", "marschner-lobb", "ball:16", "slab", "zebra:64x32x3"]


def cases(splatvol, folder):
    """Named checks."""
    for dtype in TYPES:
        yield f"write NRRD of {dtype}", lambda dtype=dtype: converted(splatvol, folder, dtype)
    yield "write NRRD of rescaled values", lambda: rescaled(splatvol, folder)
    for sample in SAMPLES:
        yield f"write sample {sample}", lambda sample=sample: from_sample(splatvol, folder, sample)


def converted(splatvol, folder, dtype):
    """From NIfTI to NRRD: type, position and every voxel are kept."""
    source, output = folder / f"source_{dtype}.nii.gz", folder / f"written_{dtype}.nrrd"
    nibabel.save(nibabel.Nifti1Image(noise(dtype), oblique_affine()), source)
    splatvol.run("convert", source, output)
    expected = with_nibabel(source)
    for reader in [with_pynrrd, with_simpleitk]:
        found = reader(output)
        assert found.values.dtype.newbyteorder("=") == np.dtype(dtype), f"{found.values.dtype}"
        compare(expected, found)


def rescaled(splatvol, folder):
    """NRRD has no slope: real values are written."""
    source, output = folder / "source_rescaled.nii", folder / "written_rescaled.nrrd"
    image = nibabel.Nifti1Image(noise("i2") / 32768 * 700 - 300, oblique_affine())
    image.header.set_data_dtype(np.int16)
    image.header.set_slope_inter(0.03125, -300.5)
    image.to_filename(source)
    splatvol.run("convert", source, output)
    for reader in [with_pynrrd, with_simpleitk]:
        compare(with_nibabel(source), reader(output), exact=False)


def from_sample(splatvol, folder, sample):
    """Built-in volumes as NRRD and as an array."""
    name, _, size = sample.partition(":")
    options = ["--size", size] if size else []
    nrrd_path, npy_path = folder / f"{name}.nrrd", folder / f"{name}.npy"
    splatvol.run("sample", name, "-o", nrrd_path, *options)
    splatvol.run("sample", name, "-o", npy_path, *options)
    actual = splatvol.read(f"sample:{sample}")
    for reader in [with_pynrrd, with_simpleitk]:
        read = reader(nrrd_path)
        compare(read, actual)
        compare(Volume(np.load(npy_path), None), read)
