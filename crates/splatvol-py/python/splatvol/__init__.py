"""Volume rendering by splatting: volumes, meshes, points and 3-D Gaussians become pictures, without a GPU or a display.

>>> import splatvol as sv
>>> frame = sv.render("sample:head:32", view="left", size=64)
>>> frame.size
(64, 64)

A picture has the pixels that the command ``splatvol`` makes by the same settings, whatever the number of threads.
"""

from ._accessor import register_with_xarray as _register_with_xarray
from ._camera import Camera
from ._core import Stop as CancelToken
from ._core import __version__, threads
from ._data import Data, Gaussians, Mesh, Points, Volume
from ._errors import (
    Cancelled,
    Combination,
    DataWarning,
    FormatError,
    InternalError,
    InvalidValue,
    LimitError,
    SplatvolError,
    UnknownKeyword,
)
from ._foreign import from_dask, from_dicom, from_itk, from_napari, from_nibabel, from_vtk, from_xarray, from_zarr
from ._frame import Frame
from ._lazy import LazyVolume, lazy
from ._look import Clip, Light, TransferFunction
from ._parts import assemble, part, recipe
from ._render_options import ReadOptions, RenderOptions
from ._scene import Item, Scene
from ._series import Series
from ._verbs import Difference, animate, colormaps, compare, info, like, load, read, render, samples, set_threads, show

__all__ = [
    "Camera",
    "CancelToken",
    "Cancelled",
    "Clip",
    "Combination",
    "Data",
    "DataWarning",
    "Difference",
    "FormatError",
    "Frame",
    "Gaussians",
    "InternalError",
    "InvalidValue",
    "Item",
    "LazyVolume",
    "Light",
    "LimitError",
    "Mesh",
    "Points",
    "ReadOptions",
    "RenderOptions",
    "Scene",
    "Series",
    "SplatvolError",
    "TransferFunction",
    "UnknownKeyword",
    "Volume",
    "__version__",
    "animate",
    "assemble",
    "colormaps",
    "compare",
    "from_dask",
    "from_dicom",
    "from_itk",
    "from_napari",
    "from_nibabel",
    "from_vtk",
    "from_xarray",
    "from_zarr",
    "info",
    "lazy",
    "like",
    "load",
    "part",
    "read",
    "recipe",
    "render",
    "samples",
    "set_threads",
    "show",
    "threads",
]

_register_with_xarray()
