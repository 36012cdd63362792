"""Images of nibabel, SimpleITK and itk."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from .._data import Volume
from .._errors import InvalidValue


def from_nibabel(image: Any) -> Volume:
    """A volume of a nibabel image: scaled integers stay integers, and it lies as its affine says (RAS+)."""
    array = np.asanyarray(image.dataobj.get_unscaled() if hasattr(image.dataobj, "get_unscaled") else image.dataobj)
    slope = float(getattr(image.dataobj, "slope", 1.0) or 1.0)
    intercept = float(getattr(image.dataobj, "inter", 0.0) or 0.0)
    array = array.reshape(array.shape[:3]) if array.shape[3:] == (1,) * (array.ndim - 3) else array
    if array.ndim != 3:
        message = f"the image has shape {array.shape}: choose a volume, img.slicer[..., 0]"
        raise InvalidValue(message, field="data", value=str(array.shape))
    units = getattr(image.header, "get_xyzt_units", lambda: ("mm",))()[0]
    unit = {"mm": "mm", "micron": "um", "meter": "m"}.get(units)
    name = os.path.basename(image.get_filename() or "") or None
    return Volume(array, axes="xyz", affine=image.affine, unit=unit, name=name, rescale=(slope, intercept))


class _Kept:
    """Memory of an array, and the object that must live as long."""

    def __init__(self, array: Any, owner: Any) -> None:
        self.__array_interface__ = array.__array_interface__
        self.owner = owner


def simple_itk(image: Any) -> Volume | None:
    if not hasattr(image, "GetDirection"):
        return None
    import SimpleITK

    # A view does not keep its image alive. A copy of the image, made after the view, shares the samples; an image that
    # is written to later gets others.
    view = SimpleITK.GetArrayViewFromImage(image)
    copy: Any = SimpleITK.Image
    array = np.asarray(_Kept(view, copy(image)))
    affine = _lps_to_ras(
        np.reshape(image.GetDirection(), (-1, image.GetDimension())), image.GetSpacing(), image.GetOrigin()
    )
    return Volume(array, axes="zyx", affine=affine[:, [2, 1, 0, 3]], unit="mm")


def itk_image(image: Any) -> Volume | None:
    if not hasattr(image, "GetLargestPossibleRegion"):
        return None
    import itk

    array = itk.array_view_from_image(image)
    direction = itk.array_from_matrix(image.GetDirection())
    affine = _lps_to_ras(direction, list(image.GetSpacing()), list(image.GetOrigin()))
    return Volume(array, axes="zyx", affine=affine[:, [2, 1, 0, 3]], unit="mm")


def from_itk(image: Any) -> Volume:
    """A volume of an image of SimpleITK or itk, turned from LPS to RAS+."""
    found = simple_itk(image) if type(image).__module__.startswith("SimpleITK") else itk_image(image)
    if found is None:
        raise TypeError(f"{type(image).__qualname__} is not an image of ITK")
    return found


def _lps_to_ras(direction: Any, spacing: Any, origin: Any) -> Any:
    """World from index x y z, RAS+, of ITK's direction, spacing and origin, which are LPS+."""
    affine = np.eye(4)
    affine[:3, :3] = np.asarray(direction) * np.asarray(spacing)
    affine[:3, 3] = origin
    return np.diag([-1.0, -1.0, 1.0, 1.0]) @ affine
