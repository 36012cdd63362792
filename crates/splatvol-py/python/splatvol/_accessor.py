"""Accessors: ``array.splat.render()`` for xarray's arrays, ``grid.splat.render()`` for PyVista's data sets."""

from __future__ import annotations

import importlib.abc
import importlib.util
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import TYPE_CHECKING, Any, Unpack

from . import _foreign
from ._data import Data, Volume

if TYPE_CHECKING:
    from ._frame import Frame
    from ._render_options import RenderOptions
    from ._widget import Widget


class ArrayAccessor:
    """``array.splat`` of xarray's arrays, once splatvol is imported.

    Examples
    --------
    >>> import numpy as np, splatvol as sv, xarray as xr
    >>> array = xr.DataArray(np.ones((8, 8, 8), np.float32), dims=("z", "y", "x"))
    >>> array.splat.render(size=16).size
    (16, 16)
    """

    def __init__(self, array: Any) -> None:
        self._array = array

    def volume(self) -> Volume:
        """The array as a volume: see :func:`splatvol.from_xarray`."""
        return _foreign.from_xarray(self._array)

    def render(self, **options: Unpack[RenderOptions]) -> Frame:
        """Renders the array: see :func:`splatvol.render`."""
        return self.volume().render(**options)

    def show(self, **options: Unpack[RenderOptions]) -> Widget:
        """Shows the array in a notebook: see :func:`splatvol.show`."""
        return self.volume().show(**options)


class GridAccessor:
    """``grid.splat`` of PyVista's data sets; `array` is the name of the array that is shown.

    Examples
    --------
    >>> import numpy as np, pyvista, splatvol as sv
    >>> grid = pyvista.ImageData(dimensions=(8, 8, 8))
    >>> grid["values"] = np.arange(512.0)
    >>> sv.from_vtk(grid).shape
    (8, 8, 8)
    """

    def __init__(self, grid: Any) -> None:
        self._grid = grid

    def data(self, array: str | None = None) -> Data:
        """The data set as a volume, a mesh or points: see :func:`splatvol.from_vtk`."""
        return _foreign.from_vtk(self._grid, array)

    def volume(self, array: str | None = None) -> Volume:
        """The data set as a volume.

        Raises
        ------
        TypeError
            A data set that is not a regular grid.
        """
        return Volume.from_vtk(self._grid, array)

    def render(self, array: str | None = None, **options: Unpack[RenderOptions]) -> Frame:
        """Renders the data set: see :func:`splatvol.render`."""
        return self.data(array).render(**options)

    def show(self, array: str | None = None, **options: Unpack[RenderOptions]) -> Widget:
        """Shows the data set in a notebook: see :func:`splatvol.show`."""
        return self.data(array).show(**options)


def register_with_xarray() -> None:
    """Gives xarray's arrays their accessor: now if xarray is there, or as soon as it is imported."""
    xarray = sys.modules.get("xarray")
    if xarray is None:
        sys.meta_path.insert(0, _AfterXarray())
    else:
        _register(xarray)


def _register(xarray: ModuleType) -> None:
    # A second import of splatvol, as by importlib.reload, would be warned about.
    if not hasattr(xarray.DataArray, "splat"):
        xarray.register_dataarray_accessor("splat")(ArrayAccessor)


class _AfterXarray(importlib.abc.MetaPathFinder):
    """Finds xarray where it is, and registers the accessor when its code has run. xarray has no entry point for it."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname != "xarray":
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(fullname)
        if spec is None or spec.loader is None:
            # It may be installed later in this session.
            sys.meta_path.insert(0, self)
            return None
        run = spec.loader.exec_module

        def run_and_register(module: ModuleType) -> None:
            run(module)
            _register(module)

        spec.loader.exec_module = run_and_register  # type: ignore[method-assign]
        return spec
