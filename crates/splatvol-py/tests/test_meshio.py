"""Meshes of meshio are those of PyVista."""

from __future__ import annotations

import numpy as np
import pytest

import splatvol as sv

meshio = pytest.importorskip("meshio")

POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1], [2, 0, 0.5]])
CELLS = [("triangle", [[0, 1, 2]]), ("hexahedron", [[0, 1, 2, 3, 4, 5, 6, 7]]), ("tetra", [[1, 2, 5, 8]])]


def test_solid_cells_with_values_of_points_and_of_cells() -> None:
    height = POINTS[:, 2]
    data = {"flat": np.ones(9), "height": height, "vectors": POINTS}
    mesh = meshio.Mesh(POINTS, CELLS, point_data=data, cell_data={"part": [[9.0], [1.0], [2.0]]})
    cells = [cell for _, block in CELLS[1:] for cell in block]
    for array, values in ((None, height), ("part", [1.0, 2.0])):
        own = sv.Mesh(POINTS, cells, values, types=[12, 10], name=array or "height")
        frame = sv.render(mesh, array=array, size=48)
        np.testing.assert_array_equal(np.asarray(frame), np.asarray(own.render(size=48)))
        assert np.ptp(np.asarray(frame)[..., :3]) > 50
    assert sv.info(mesh)["count"] == 2
    with pytest.raises(sv.InvalidValue, match="vectors"):
        sv.render(mesh, array="vectors")
    surface = sv.render(meshio.Mesh(POINTS, CELLS[:1]), size=24)
    assert np.asarray(surface)[..., 3].max() > 0, "flat cells alone are a surface"
    with pytest.raises(sv.InvalidValue, match="line"):
        sv.render(meshio.Mesh(POINTS, [("line", np.array([[0, 1]]))]))
