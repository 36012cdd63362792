"""Volumes as nibabel, pynrrd, SimpleITK and numpy read them."""

import nibabel
import nrrd
import numpy as np
import SimpleITK

from comparison import LPS_TO_RAS
from splatvol_cli import Volume

# What NRRD calls spaces, and their way to RAS.
NRRD_SPACES = {
    "left-posterior-superior": LPS_TO_RAS,
    "lps": LPS_TO_RAS,
    "left-anterior-superior": np.diag([-1.0, 1.0, 1.0, 1.0]),
    "las": np.diag([-1.0, 1.0, 1.0, 1.0]),
    "right-anterior-superior": np.eye(4),
    "ras": np.eye(4),
}


def with_nibabel(path, time=0):
    """NIfTI and MGH; nibabel's affine is RAS+, its first axis is x. One time point of a series."""
    image = nibabel.load(path)
    values = np.asanyarray(image.dataobj)
    while values.ndim > 3:
        values = values[..., time]
    return Volume(values.T, image.affine)


def with_pynrrd(path):
    """NRRD of three axes; pynrrd's first axis is x."""
    values, header = nrrd.read(str(path))
    affine = np.eye(4)
    if "space directions" in header:
        affine[:3, :3] = np.array(header["space directions"]).T
        affine[:3, 3] = header.get("space origin", np.zeros(3))
    elif "spacings" in header:
        affine[:3, :3] = np.diag(header["spacings"])
    space = header.get("space", "").lower()
    return Volume(values.T, NRRD_SPACES.get(space, np.eye(4)) @ affine)


def with_simpleitk(path):
    """Anything that ITK reads, or an image of its own. Its space is LPS for formats that say how a patient lies."""
    image = path if isinstance(path, SimpleITK.Image) else SimpleITK.ReadImage(str(path))
    affine = np.eye(4)
    direction = np.array(image.GetDirection()).reshape(3, 3)
    affine[:3, :3] = direction * np.array(image.GetSpacing())
    affine[:3, 3] = image.GetOrigin()
    if not str(path).endswith(".vtk"):
        affine = LPS_TO_RAS @ affine
    return Volume(SimpleITK.GetArrayFromImage(image), affine)


def with_numpy(path, name=None):
    """.npy and .npz; no geometry. C order is z y x, Fortran order x y z."""
    loaded = np.load(path)
    values = loaded[name or loaded.files[0]] if hasattr(loaded, "files") else loaded
    if not values.flags.c_contiguous:
        values = values.T
    return Volume(values, np.eye(4))
