"""Arrays of xarray."""

from __future__ import annotations

from typing import Any

import numpy as np

from .._data import Volume
from .._errors import InvalidValue


def from_xarray(array: Any) -> Volume:
    """A volume of a DataArray with three dimensions; its coordinates, evenly spaced, are places in the world.

    Raises
    ------
    TypeError
        A Dataset: one of its arrays is a volume.
    InvalidValue
        Other dimensions, or coordinates that are not evenly spaced.
    """
    if hasattr(array, "data_vars"):
        names = ", ".join(map(str, array.data_vars))
        raise TypeError(f"a Dataset is no volume: choose one of its arrays, dataset['...'], of {names}")
    if array.ndim != 3:
        message = f"the DataArray has dimensions {array.dims}: choose with .isel(...) until three are left"
        raise InvalidValue(message, field="data", value=str(array.dims))
    axes = _axes_of([str(name) for name in array.dims])
    spacing, origin = {}, {}
    for axis, name in zip(axes, array.dims, strict=True):
        places = (
            np.asarray(array[name], dtype=float) if name in array.coords else np.arange(array.sizes[name], dtype=float)
        )
        steps = np.diff(places)
        if len(steps) and not np.allclose(steps, steps.mean(), rtol=1e-3, atol=0):
            message = f"{name}: its coordinates are not evenly spaced: write .interp({name}=...)"
            raise InvalidValue(message, field=str(name))
        spacing[axis], origin[axis] = (float(steps.mean()) if len(steps) else 1.0), float(places[0])
    affine = np.eye(4)[:, [("xyz").index(axis) for axis in axes] + [3]]
    for column, axis in enumerate(axes):
        affine[:3, column] *= spacing[axis]
        affine["xyz".index(axis), 3] = origin[axis]
    return Volume(array.data, axes=axes, affine=affine, name=str(array.name) if array.name else None)


#: Names of dimensions, and the axes that they are.
DIMENSIONS = {
    "x": "x", "lon": "x", "longitude": "x", "easting": "x", "column": "x", "i": "x",
    "y": "y", "lat": "y", "latitude": "y", "northing": "y", "row": "y", "j": "y",
    "z": "z", "lev": "z", "level": "z", "plev": "z", "height": "z", "altitude": "z", "depth": "z", "plane": "z",
    "k": "z",
    "pressure_level": "z", "model_level_number": "z",
}  # fmt: skip


def _axes_of(names: list[str]) -> str:
    axes = "".join(DIMENSIONS.get(name.lower(), "?") for name in names)
    if sorted(axes) != ["x", "y", "z"]:
        message = f"dimensions {names} are not x, y and z: write Volume(array.data, axes=...) or .rename(...)"
        raise InvalidValue(message, field="axes", value=str(names))
    return axes
