"""Data sets of VTK and PyVista."""

from __future__ import annotations

from typing import Any

import numpy as np

from .._data import Data, Mesh, Points, Volume
from .._errors import InvalidValue
from ._faces import fans, strips


def from_vtk(grid: Any, array: str | None = None) -> Data:
    """A volume, mesh or points of one of VTK's or PyVista's data sets; `array` is the name of its scalars."""
    from vtkmodules.util import numpy_support

    vtk_to_numpy: Any = numpy_support.vtk_to_numpy
    if grid.IsA("vtkPolyData"):
        return _cloud(grid, array)
    of_cells = grid.GetCellData()
    fields, scalars = _array_of([grid.GetPointData(), of_cells], array)
    values = vtk_to_numpy(scalars)
    if values.ndim != 1:
        message = f"array: {scalars.GetName()!r} has {values.shape[1]} components: add one, or their norm, as an array"
        raise InvalidValue(message, field="array", value=str(scalars.GetName()))
    if grid.IsA("vtkImageData"):
        return _image_data(grid, values, of_cells=fields is of_cells)
    if not grid.IsA("vtkUnstructuredGrid"):
        grid = _as_unstructured(grid)
    points = vtk_to_numpy(grid.GetPoints().GetData())
    cells = grid.GetCells()
    offsets = vtk_to_numpy(cells.GetOffsetsArray())
    connectivity = vtk_to_numpy(cells.GetConnectivityArray())
    lists = np.split(connectivity, offsets[1:-1])
    types = [grid.GetCellType(cell) for cell in range(grid.GetNumberOfCells())]
    return Mesh(points, lists, values, types=types, name=scalars.GetName() or "values")


def _cloud(poly: Any, name: str | None) -> Points:
    """The surface of polygonal data, or its points where there are no polygons.

    It has the data's normals, and the colours of an array of RGB or RGBA.
    """
    from vtkmodules.util import numpy_support

    vtk_to_numpy: Any = numpy_support.vtk_to_numpy
    fields = poly.GetPointData()
    arrays = [fields.GetArray(i) for i in range(fields.GetNumberOfArrays())]
    arrays = [array for array in arrays if array is not None]
    normals = fields.GetNormals() or next((a for a in arrays if a.GetName() in ("Normals", "normals")), None)
    bytes_of_colors = [
        array
        for array in arrays
        if array is not normals
        and array.GetNumberOfComponents() in (3, 4)
        and array.GetDataTypeAsString() == "unsigned char"
    ]
    if name is not None:
        _array_of([fields], name)
        bytes_of_colors = [array for array in bytes_of_colors if array.GetName() == name]
        if not bytes_of_colors:
            message = f"array: {name!r} is no RGB or RGBA of bytes: points have colours, not values"
            raise InvalidValue(message, field="array", value=repr(name))
    active = [array for array in bytes_of_colors if array is fields.GetScalars()]
    colors = [*active, *bytes_of_colors][:1]
    return Points(
        vtk_to_numpy(poly.GetPoints().GetData()),
        normal=None if normals is None else vtk_to_numpy(normals),
        rgb=vtk_to_numpy(colors[0]) if colors else None,
        triangles=_triangles(poly),
    )


def _triangles(poly: Any) -> Any:
    """Triangles of the polygons, then of the strips; `None` where there are none."""
    from vtkmodules.util import numpy_support

    vtk_to_numpy: Any = numpy_support.vtk_to_numpy
    found = []
    for cells, divide in [(poly.GetPolys(), fans), (poly.GetStrips(), strips)]:
        if cells.GetNumberOfCells():
            connectivity, offsets = cells.GetConnectivityArray(), cells.GetOffsetsArray()
            found.append(divide(vtk_to_numpy(connectivity), vtk_to_numpy(offsets)))
    triangles = np.concatenate(found) if found else np.empty((0, 3), np.int64)
    return triangles if len(triangles) else None


def _array_of(fields: list[Any], name: str | None) -> tuple[Any, Any]:
    """An array by its name; else the active scalars, or the first array of one component that varies."""
    arrays = [(field, field.GetArray(i)) for field in fields for i in range(field.GetNumberOfArrays())]
    known = [(field, array) for field, array in arrays if array is not None]
    if name is not None:
        known = [(field, array) for field, array in known if array.GetName() == name]
        if known:
            return known[0]
        names = [array.GetName() for _, array in arrays if array is not None]
        raise InvalidValue(f"array: {name!r} is not there (there are {names})", field="array", value=repr(name))
    known = [(field, array) for field, array in known if array.GetNumberOfComponents() == 1]
    if not known:
        raise InvalidValue("array: the data set has no array of one component", field="array")
    active = [(field, array) for field, array in known if array is field.GetScalars()]
    varying = [(field, array) for field, array in known if len(set(array.GetRange())) == 2]
    return [*active, *varying, *known][0]


def _as_unstructured(grid: Any) -> Any:
    from vtkmodules.vtkFiltersCore import vtkAppendFilter

    append = vtkAppendFilter()
    append.AddInputData(grid)
    append.Update()
    return append.GetOutput()


def _image_data(grid: Any, values: Any, *, of_cells: bool) -> Volume:
    dims = np.asarray(grid.GetDimensions())
    origin = np.asarray(grid.GetOrigin(), dtype=float)
    spacing = np.asarray(grid.GetSpacing(), dtype=float)
    direction = np.eye(3)
    matrix = grid.GetDirectionMatrix() if hasattr(grid, "GetDirectionMatrix") else None
    if matrix is not None:
        direction = np.array([[matrix.GetElement(i, j) for j in range(3)] for i in range(3)])
    first = np.asarray(grid.GetExtent(), dtype=float)[::2]
    # Values of cells lie in their middle.
    first = first + (0.5 if of_cells else 0.0)
    dims = dims - 1 if of_cells else dims
    affine = np.eye(4)
    affine[:3, :3] = direction * spacing
    affine[:3, 3] = origin + direction @ (spacing * first)
    return Volume(values.reshape(dims[::-1]), axes="zyx", affine=affine[:, [2, 1, 0, 3]], oriented=False)


def vtk_object(thing: Any, array: str | None = None) -> Data | None:
    return from_vtk(thing, array) if hasattr(thing, "IsA") else None
