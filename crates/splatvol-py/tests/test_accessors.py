"""Accessors: ``.splat`` on objects of xarray and PyVista, and class methods of Volume."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import splatvol as sv


def printed(program: str, *folders: Path) -> str:
    """What a program prints in a fresh process, with these folders to import from."""
    path = os.pathsep.join([*map(str, folders), os.environ.get("PYTHONPATH", "")])
    run = subprocess.run(
        [sys.executable, "-W", "error::UserWarning", "-c", program],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": path},
    )
    assert run.returncode == 0, run.stderr
    return run.stdout.strip()


RENDER = "print(xarray.DataArray(numpy.ones((4, 4, 4)), dims=('z', 'y', 'x')).splat.render(size=16).size)"


@pytest.mark.parametrize("order", ["xarray, splatvol", "splatvol, xarray", "xarray, splatvol, importlib"])
def test_xarray_has_the_accessor_whichever_is_imported_first(order: str) -> None:
    pytest.importorskip("xarray")
    again = "; importlib.reload(splatvol)" if "importlib" in order else ""
    assert printed(f"import numpy, {order}{again}; {RENDER}") == "(16, 16)"


def test_waiting_for_xarray_changes_no_other_import(tmp_path: Path) -> None:
    program = (
        "import sys, splatvol, importlib.util\n"
        "assert 'xarray' not in sys.modules\n"
        "before = len(sys.meta_path)\n"
        "import xarray, json, wave\n"
        "assert len(sys.meta_path) == before - 1, sys.meta_path\n"
        "print(xarray.__spec__.name, xarray.DataArray.splat.__name__)"
    )
    pytest.importorskip("xarray")
    assert printed(program) == "xarray ArrayAccessor"


def test_without_xarray_its_import_says_so(tmp_path: Path) -> None:
    program = (
        "import sys, splatvol\n"
        "sys.path[:] = [folder for folder in sys.path if 'site-packages' not in folder]\n"
        "for _ in range(2):\n"
        "    try: import xarray\n"
        "    except ModuleNotFoundError as error: print(error.name)"
    )
    assert printed(program).split() == ["xarray", "xarray"]


def test_xarrays_accessor_makes_what_render_makes(ball: np.ndarray) -> None:
    xarray = pytest.importorskip("xarray")
    array = xarray.DataArray(ball, dims=("lev", "lat", "lon"), coords={"lev": np.arange(20) * 2.0})
    volume = array.splat.volume()
    assert isinstance(volume, sv.Volume) and volume.spacing == (2, 1, 1)
    expected = np.asarray(sv.render(array, size=48, view="left"))
    np.testing.assert_array_equal(np.asarray(array.splat.render(size=48, view="left")), expected)
    with pytest.raises(sv.UnknownKeyword, match="sise"):
        array.splat.render(sise=48)


def test_pyvistas_entry_point_gives_the_accessor(tmp_path: Path) -> None:
    """The entry point of pyproject.toml, as an installed wheel has it: nothing but PyVista is imported."""
    pytest.importorskip("pyvista")
    text = (Path(__file__).parents[1] / "pyproject.toml").read_text()
    name = "pyvista.accessors"
    points = tomllib.loads(text)["project"]["entry-points"][name]
    folder = tmp_path / "splatvol_accessor-1.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: splatvol-accessor\nVersion: 1\n")
    lines = [f"{point} = {value}" for point, value in points.items()]
    (folder / "entry_points.txt").write_text("\n".join([f"[{name}]", *lines, ""]))
    program = (
        "import numpy, sys, pyvista\n"
        "grid = pyvista.ImageData(dimensions=(5, 6, 7))\n"
        "grid['a'], grid['b'] = numpy.arange(210.0), numpy.arange(210.0) ** 2\n"
        "assert 'splatvol' not in sys.modules\n"
        "print(grid.splat.volume('b').range, grid.splat.render('b', size=16).size)\n"
        "print(pyvista.Sphere().splat.data().kind)\n"
        "try: pyvista.Sphere().splat.volume()\n"
        "except TypeError as error: print(error)"
    )
    lines = printed(program, tmp_path).splitlines()
    assert lines[:2] == ["(0.0, 43681.0) (16, 16)", "points"]
    assert "splatvol.from_vtk" in lines[2]


def test_volumes_are_made_by_class_methods(ball: np.ndarray) -> None:
    xarray = pytest.importorskip("xarray")
    dask = pytest.importorskip("dask.array")
    zarr = pytest.importorskip("zarr")
    nibabel = pytest.importorskip("nibabel")
    simple = pytest.importorskip("SimpleITK")
    made = [
        sv.Volume.from_xarray(xarray.DataArray(ball, dims=("z", "y", "x"))),
        sv.Volume.from_dask(dask.from_array(ball)),
        sv.Volume.from_zarr(zarr.array(ball)),
        sv.Volume.from_nibabel(nibabel.Nifti1Image(ball.T, np.eye(4))),
        sv.Volume.from_itk(simple.GetImageFromArray(ball)),
    ]
    for volume in made:
        assert isinstance(volume, sv.Volume)
        np.testing.assert_array_equal(np.asarray(volume), ball)
