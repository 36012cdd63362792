"""Objects of other packages as data. They are known by their module's name, so that nothing is imported for them."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from .._data import RULES, Data, Rules, Volume, read_item
from .._errors import InvalidValue
from .._napari.layers import from_napari
from .._vocabulary import tables
from ._dask import from_dask
from ._dicom import from_dicom
from ._medical import from_itk, from_nibabel, itk_image, simple_itk
from ._meshio import from_meshio
from ._tifffile import from_tifffile
from ._vtk import from_vtk, vtk_object
from ._xarray import from_xarray
from ._zarr import from_zarr

__all__ = [
    "data_of",
    "from_dask",
    "from_dicom",
    "from_itk",
    "from_napari",
    "from_nibabel",
    "from_vtk",
    "from_xarray",
    "from_zarr",
]


def data_of(thing: Any, reading: Mapping[str, Any] | None = None, rules: Rules = RULES) -> Data:
    """Data of anything that is understood; `reading` are keywords that say how a file is read, `rules` what is refused.

    Raises
    ------
    TypeError
        What is no data; the message says what is.
    InvalidValue
        Keywords of files, of what is none.
    """
    if isinstance(thing, (str, os.PathLike)):
        return read_item({"file": os.fspath(thing), **tables(reading or {}).get("item", {})}, rules)
    module = _module_of(thing)
    said = {name: value for name, value in (reading or {}).items() if value is not None}
    asked = {**said, **rules._asked()}
    for name in sorted(set(asked) - set(KEYWORDS.get(module, ()))):
        message = f"{name}: says how a file is read, and these data are none"
        raise InvalidValue(message, field=name, value=repr(asked[name]))
    if isinstance(thing, Data):
        return thing
    reader = READERS.get(module)
    data = reader(thing, **said) if reader else None
    if data is not None:
        return data
    if isinstance(thing, np.ndarray) or hasattr(thing, "__array__") or hasattr(thing, "__dlpack__"):
        return Volume(thing)
    if isinstance(thing, (list, tuple)):
        raise TypeError(f"a {type(thing).__name__} is no volume: write np.array(..., dtype=np.float32)")
    message = (
        f"{type(thing).__module__}.{type(thing).__qualname__} is no data: expected an array, a path or Volume(...)"
    )
    raise TypeError(message)


def _module_of(thing: Any) -> str:
    """The package of an object; of a list of slices or of levels that of its first one."""
    if isinstance(thing, (list, tuple)) and thing:
        inside = _module_of(thing[0])
        return inside if inside in ("pydicom", "dask") else "builtins"
    return type(thing).__module__.split(".")[0]


READERS: dict[str, Callable[..., Data | None]] = {
    "nibabel": from_nibabel,
    "SimpleITK": simple_itk,
    "itk": itk_image,
    "xarray": from_xarray,
    "pyvista": vtk_object,
    "vtkmodules": vtk_object,
    "zarr": from_zarr,
    "dask": from_dask,
    "pydicom": from_dicom,
    "meshio": from_meshio,
    "tifffile": from_tifffile,
    "napari": from_napari,
}
#: Keywords of reading that objects of a package take.
KEYWORDS = {
    "zarr": ("level", "channel", "time"),
    "dask": ("level",),
    "pydicom": ("time",),
    "tifffile": ("channel", "time"),
    "meshio": ("array",),
    "pyvista": ("array",),
    "vtkmodules": ("array",),
}
