"""Meshes of meshio."""

from __future__ import annotations

from typing import Any

import numpy as np

from .._data import Mesh, Points
from .._errors import InvalidValue
from ._faces import fans

#: VTK's numbers of the kinds of solid cells that meshio has in VTK's order of points.
SOLID = {"tetra": 10, "hexahedron": 12, "wedge": 13, "pyramid": 14}


#: Kinds of flat cells whose corners go round.
FLAT = ("triangle", "quad", "polygon")


def from_meshio(mesh: Any, array: str | None = None) -> Mesh | Points | None:
    """A mesh of meshio's solid cells, or a surface of its flat ones where there are no others; the rest is left out.

    `array` is the name of a mesh's values, of points or cells.

    Raises
    ------
    InvalidValue
        No solid cells, or no array of one number each.
    """
    if not hasattr(mesh, "cells") or not hasattr(mesh, "point_data"):
        return None
    solid = [i for i, block in enumerate(mesh.cells) if block.type in SOLID]
    if not solid and array is None and any(block.type in FLAT for block in mesh.cells):
        return _surface(mesh)
    if not solid:
        kinds = ", ".join(sorted({block.type for block in mesh.cells})) or "none"
        message = f"cells: {kinds} are not solid ({', '.join(SOLID)} are): write splatvol.Points(mesh.points)"
        raise InvalidValue(message, field="cells", value=kinds)
    fields = {name: np.asarray(values) for name, values in mesh.point_data.items()}
    of_cells = {name: np.concatenate([values[i] for i in solid]) for name, values in mesh.cell_data.items()}
    # Arrays of points come first, and before those of cells with their name.
    every = [*fields.items(), *((name, values) for name, values in of_cells.items() if name not in fields)]
    fields = {name: values for name, values in every if values.size == len(values)}
    names = list(fields)
    varying = [name for name in names if np.ptp(fields[name]) > 0]
    chosen = array or next(iter([*varying, *names]), "")
    if chosen not in fields:
        message = f"array: {array!r} is not there (there are {names})" if array else "array: none has one number each"
        raise InvalidValue(message, field="array", value=repr(array))
    lists = [cell for i in solid for cell in mesh.cells[i].data]
    types = [SOLID[mesh.cells[i].type] for i in solid for _ in range(len(mesh.cells[i].data))]
    points = np.asarray(mesh.points)
    return Mesh(points, lists, fields[chosen].ravel(), types=types, name=chosen)


def _surface(mesh: Any) -> Points:
    """The surface of the flat cells."""
    faces = [np.asarray(cell) for block in mesh.cells if block.type in FLAT for cell in block.data]
    offsets = np.cumsum([0, *(len(face) for face in faces)])
    return Points(np.asarray(mesh.points), triangles=fans(np.concatenate(faces), offsets))
