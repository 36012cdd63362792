"""Objects of other packages: the same picture as the command makes of the file, lying alike."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import splatvol as sv

from .conftest import shared

Command = Callable[..., np.ndarray]
Scan = Callable[[str], Path]


def close(ours: Any, theirs: np.ndarray, at_least: float) -> None:
    """Pictures of one volume whose places are computed in another order of sums."""
    difference = sv.compare(ours, theirs)
    assert difference.psnr >= at_least, difference


@pytest.mark.parametrize("name", ["ball.nii.gz", "FLAIR.nii.gz", "zstat1.nii.gz"])
def test_nibabel(name: str, command: Command, scan: Scan) -> None:
    nibabel = pytest.importorskip("nibabel")
    path = scan(name)
    close(sv.render(nibabel.load(path), size=128), command(path, "--size", "128"), 50)


@pytest.mark.parametrize("name", ["ball.nii.gz", "ball.mhd", "FLAIR.nii.gz", "HeadMRVolume.mhd"])
def test_simple_itk(name: str, command: Command, scan: Scan) -> None:
    simple = pytest.importorskip("SimpleITK")
    path = scan(name)
    close(sv.render(simple.ReadImage(str(path)), size=128), command(path, "--size", "128"), 50)


def test_volumes_of_simple_itk_keep_their_samples(ball: np.ndarray) -> None:
    simple = pytest.importorskip("SimpleITK")
    image = simple.GetImageFromArray(ball)
    memory = simple.GetArrayViewFromImage(image).ctypes.data
    volume = sv.from_itk(image)
    assert np.asarray(volume).ctypes.data == memory
    image[0, 0, 0] = 7.0
    image += 1.0
    del image
    others = [simple.GetImageFromArray(np.full_like(ball, 9)) for _ in range(20)]
    assert len(others) == 20
    np.testing.assert_array_equal(np.asarray(volume), ball)


@pytest.mark.parametrize("name", ["ball.tif", "100_fiberform.tif"])
def test_tifffile(name: str, command: Command, scan: Scan) -> None:
    tifffile = pytest.importorskip("tifffile")
    path = scan(name)
    close(sv.render(tifffile.imread(path), size=128), command(path, "--size", "128"), 50)


def test_pydicom(command: Command) -> None:
    pydicom = pytest.importorskip("pydicom")
    folder = shared("volumes", "dicom_transfer_syntaxes", "anatomical")
    datasets = [pydicom.dcmread(path) for path in folder.rglob("*") if path.is_file()]
    close(sv.from_dicom(datasets).render(size=128), command(folder, "--size", "128"), 50)


def test_xarray(ball: np.ndarray) -> None:
    xarray = pytest.importorskip("xarray")
    coords = {"lev": np.arange(20) * 2.0, "lat": np.arange(24) * -1.0 + 90, "lon": np.arange(28) * 0.5}
    array = xarray.DataArray(ball, dims=("lev", "lat", "lon"), coords=coords, name="cloud")
    volume = sv.from_xarray(array)
    assert volume.name == "cloud" and volume.spacing == (2, 1, 0.5)
    assert volume.affine[1, 1] == -1 and volume.affine[1, 3] == 90
    same = sv.Volume(np.ascontiguousarray(ball[:, ::-1]), affine=[[0, 0, 0.5, 0], [0, 1, 0, 67], [2, 0, 0, 0]])
    close(volume.render(size=64), np.asarray(same.render(size=64)), 50)
    with pytest.raises(sv.InvalidValue, match="isel"):
        sv.from_xarray(array.expand_dims("time"))
    uneven = array.assign_coords(lev=np.arange(20) ** 2)
    with pytest.raises(sv.InvalidValue, match="evenly"):
        sv.from_xarray(uneven)
    with pytest.raises(sv.InvalidValue, match="rename"):
        sv.from_xarray(array.rename(lev="band"))


def test_zarr_and_dask(ball: np.ndarray) -> None:
    zarr = pytest.importorskip("zarr")
    dask = pytest.importorskip("dask.array")
    expected = np.asarray(sv.render(ball, size=48))
    np.testing.assert_array_equal(np.asarray(sv.render(zarr.array(ball), size=48)), expected)
    lazy = dask.from_array(ball, chunks=8)
    np.testing.assert_array_equal(np.asarray(sv.render(lazy, size=48)), expected)
    with pytest.raises(sv.LimitError, match="::2"):
        sv.from_dask(lazy, max_bytes=ball.nbytes // 2)


def test_torch_by_dlpack(ball: np.ndarray) -> None:
    class Tensor:
        """As torch presents a tensor on the CPU."""

        def detach(self) -> Tensor:
            return self

        def __dlpack__(self, **options: Any) -> Any:
            return ball.__dlpack__(**options)

        def __dlpack_device__(self) -> Any:
            return ball.__dlpack_device__()

    np.testing.assert_array_equal(np.asarray(sv.render(Tensor(), size=32)), np.asarray(sv.render(ball, size=32)))


def test_pyvista_grids(ball: np.ndarray) -> None:
    pyvista = pytest.importorskip("pyvista")
    grid = pyvista.ImageData(dimensions=ball.shape[::-1], spacing=(1, 2, 3), origin=(5, 6, 7))
    grid.point_data["values"] = ball.ravel()
    volume = sv.from_vtk(grid)
    assert isinstance(volume, sv.Volume)
    assert volume.shape == ball.shape and volume.spacing == (3, 2, 1)
    np.testing.assert_array_equal(volume.affine[:3, 3], [5, 6, 7])
    cells = pyvista.ImageData(dimensions=np.array(ball.shape[::-1]) + 1, origin=(4.5, 5.5, 6.5))
    cells.cell_data["values"] = ball.ravel()
    of_cells = sv.from_vtk(cells)
    assert isinstance(of_cells, sv.Volume)
    np.testing.assert_array_equal(of_cells.affine[:3, 3], [5, 6, 7])
    with pytest.raises(sv.InvalidValue, match="values"):
        sv.from_vtk(grid, "nothing")


def test_pyvista_clouds_need_no_array() -> None:
    pyvista = pytest.importorskip("pyvista")
    xyz = np.random.default_rng(2).normal(size=(50, 3))
    cloud = sv.from_vtk(pyvista.PolyData(xyz))
    assert isinstance(cloud, sv.Points) and len(cloud) == 50


def test_normals_and_colours_of_polygonal_data() -> None:
    pyvista = pytest.importorskip("pyvista")
    sphere = pyvista.Sphere(theta_resolution=40, phi_resolution=40)
    plain = pyvista.PolyData(sphere.points)
    red = np.tile(np.array([255, 0, 0], np.uint8), (sphere.n_points, 1))
    cloud = pyvista.PolyData(sphere.points)
    cloud["tangents"], cloud["rgb"] = np.zeros_like(sphere.points), red
    cloud["Normals"] = sphere.point_data["Normals"]
    expected = sv.Points(sphere.points, rgb=red, normal=sphere.point_data["Normals"])
    shown = np.asarray(sv.render(cloud, size=48, view="left"))
    np.testing.assert_array_equal(shown, np.asarray(expected.render(size=48, view="left")))
    middle = shown[24, 24].astype(int)
    assert middle[0] > middle[1] + 60 and not np.array_equal(shown, np.asarray(sv.render(plain, size=48, view="left")))
    cloud["rgba"] = np.tile(np.array([0, 0, 255, 255], np.uint8), (sphere.n_points, 1))
    blue = np.asarray(sv.render(cloud, array="rgba", size=48, view="left"))[24, 24].astype(int)
    assert blue[2] > blue[0] + 60
    with pytest.raises(sv.InvalidValue, match="tangents"):
        sv.from_vtk(cloud, "tangents")
    with pytest.raises(sv.InvalidValue, match="nothing"):
        sv.from_vtk(cloud, "nothing")


def test_triangles_become_the_surface_that_their_file_becomes(tmp_path: Path) -> None:
    pyvista, meshio = pytest.importorskip("pyvista"), pytest.importorskip("meshio")
    sphere = pyvista.Sphere(theta_resolution=12, phi_resolution=9)
    sphere.save(tmp_path / "sphere.vtp")
    of_file = np.asarray(sv.read(tmp_path / "sphere.vtp").render(size=64))
    np.testing.assert_array_equal(np.asarray(sv.render(sphere, size=64)), of_file)
    faces = sphere.regular_faces
    made = sv.Points(sphere.points, normal=sphere.point_data["Normals"], triangles=faces)
    np.testing.assert_array_equal(np.asarray(made.render(size=64)), of_file)
    cube = meshio.Mesh(pyvista.Cube().clean().points, [("quad", pyvista.Cube().clean().regular_faces)])
    surface = sv.render(cube, size=48)
    assert np.asarray(surface)[24, 24, 3] == 255, "a face of the cube is opaque between its corners"
    strip = pyvista.PolyData(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], float), strips=[4, 0, 1, 2, 3])
    plane = sv.Points(strip.points, triangles=[[0, 1, 2], [2, 1, 3]])
    np.testing.assert_array_equal(np.asarray(sv.render(strip, size=32)), np.asarray(plane.render(size=32)))
    for triangles, expected in [([[0, 1]], "shape"), ([[0.0, 1, 2]], "type"), ([[0, 1, 4]], "indices of 4")]:
        with pytest.raises(sv.InvalidValue, match=expected):
            sv.Points(strip.points, triangles=triangles)
    with pytest.raises(sv.InvalidValue, match="radius"):
        sv.Points(strip.points, triangles=faces[:1] * 0, radius=1)


@pytest.mark.parametrize("name", ["ball.vti", "bonsai.vti"])
def test_pyvista_reads_what_the_command_reads(name: str, command: Command, scan: Scan) -> None:
    pyvista = pytest.importorskip("pyvista")
    path = scan(name)
    close(sv.render(pyvista.read(path), size=128), command(path, "--size", "128"), 50)


@pytest.mark.parametrize("name", ["ball.vtu", "can.vtu"])
def test_meshes_of_pyvista_have_their_cells(name: str, scan: Scan, tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    if name == "ball.vtu":
        mesh = tmp_path / name
        pyvista.read(scan("ball.vti")).cast_to_unstructured_grid().save(mesh)
    else:
        mesh = shared("meshes", name)
    grid = pyvista.read(mesh)
    assert sv.info(grid)["count"] == grid.n_cells
