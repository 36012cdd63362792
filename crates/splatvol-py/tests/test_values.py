"""Values of keywords: numpy's numbers, and what is refused by the keyword's name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import splatvol as sv

NAN = float("nan")
TF = sv.TransferFunction
CUBE = np.arange(27, dtype=np.float32).reshape(3, 3, 3)
XYZ = np.random.default_rng(2).random((10, 3))
FOUR = XYZ[:4]


def drawn(**options: Any) -> sv.Frame:
    return sv.render(CUBE, **{"size": 8, **options})


def test_numbers_of_numpy_are_numbers() -> None:
    assert sv.Camera((0, 0, 5), (0, 0, 0), fov=np.float32(20)).fov == 20
    assert TF([(0, "#000000")], [(0, 1)], np.float32(2)).unit_distance == 2
    points = sv.Points(XYZ)
    half = np.asarray(sv.render(points, size=16, opacity=np.float32(0.5)))
    np.testing.assert_array_equal(half, np.asarray(sv.render(points, size=16, opacity=0.5)))
    for rescale in ([2, 1], np.array([2, 1]), (np.float32(2), np.int8(1))):
        assert sv.Volume(CUBE, rescale=rescale).range == (1, 53)
    camera = sv.Camera((0, 0, 50), (0, 0, 0), (0, 1, 0), fov=np.float32(20))
    assert drawn(camera=camera, unit_distance=np.float32(2), vmin=np.int16(1)).size == (8, 8)


REFUSED: list[tuple[str, Callable[[], object]]] = [
    ("colors", lambda: TF([(NAN, "#ffffff")], [(0, 1)])),
    ("colors", lambda: TF([], [(0, 1)])),
    ("colors", lambda: TF(3, [(0, 1)])),  # type: ignore[arg-type]
    ("color", lambda: TF([(0, "#ggg")], [(0, 1)])),
    ("color", lambda: TF([(0, 3)], [(0, 1)])),
    ("opacities", lambda: TF([(0, "#ffffff")], [(NAN, 1)])),
    ("opacities", lambda: TF([(0, "#ffffff")], [(0, 1.5)])),
    ("unit_distance", lambda: TF([(0, "#ffffff")], [(0, 1)], 0)),
    ("clim", lambda: TF.from_cmap("gray", 3)),  # type: ignore[arg-type]
    ("cmap", lambda: TF.from_cmap(3, (0, 1))),
    ("vmin", lambda: drawn(vmin=NAN)),
    ("vmax", lambda: drawn(vmax="x")),
    ("clim", lambda: drawn(clim=3)),
    ("opacity", lambda: drawn(opacity=[(NAN, 0)])),
    ("opacity", lambda: drawn(opacity=[(0, 2)])),
    ("opacity", lambda: drawn(opacity=[0, 0.5, 1])),
    ("opacity", lambda: sv.render(sv.Points(XYZ), size=8, opacity=2.0)),
    ("cmap", lambda: drawn(cmap=["red", "blue"])),
    ("cmap", lambda: drawn(cmap=np.zeros((3, 3)))),
    ("cmap", lambda: drawn(cmap=3)),
    ("tf", lambda: drawn(tf=3)),
    ("tf", lambda: drawn(tf=[(0, 1)])),
    ("unit_distance", lambda: drawn(unit_distance=0)),
    ("size", lambda: drawn(size=1.5)),
    ("size", lambda: drawn(size=(8, 8, 8))),
    ("background", lambda: drawn(background="no-such-color")),
    ("progress", lambda: sv.render(CUBE, size=8, progress="x")),  # type: ignore[arg-type]
    ("fov", lambda: sv.Camera((0, 0, 5), (0, 0, 0), fov=NAN)),
    ("fov", lambda: sv.Camera((0, 0, 5), (0, 0, 0), fov="x")),  # type: ignore[arg-type]
    ("fov", lambda: sv.Camera((0, 0, 5), (0, 0, 0), fov=180)),
    ("height", lambda: sv.Camera((0, 0, 5), (0, 0, 0), height=0)),
    ("position", lambda: sv.Camera("abc", (0, 0, 0))),  # type: ignore[arg-type]
    ("axes", lambda: sv.Volume(CUBE, axes=None)),  # type: ignore[arg-type]
    ("spacing", lambda: sv.Volume(CUBE, spacing="abc")),  # type: ignore[arg-type]
    ("spacing", lambda: sv.Volume(CUBE, spacing=-1)),
    ("spacing", lambda: sv.Volume(CUBE, spacing={"z": NAN})),
    ("spacing", lambda: sv.lazy(CUBE, spacing=(1, 0, 1))),
    ("origin", lambda: sv.Volume(CUBE, origin="abc")),  # type: ignore[arg-type]
    ("rescale", lambda: sv.Volume(CUBE, rescale=2)),  # type: ignore[arg-type]
    ("bins", lambda: sv.Volume(CUBE).histogram(0)),
    ("bins", lambda: sv.Volume(CUBE).histogram(-1)),
    ("bits", lambda: drawn().save("never.png", bits=300)),
    ("threads", lambda: sv.set_threads(-1)),
    ("threads", lambda: sv.set_threads("x")),  # type: ignore[arg-type]
    ("memory", lambda: sv.lazy(CUBE, memory=-1)),
    ("xyz", lambda: sv.Points("abc")),
    ("xyz", lambda: sv.Points(np.ma.masked_less(XYZ, 0.5))),
    ("normal", lambda: sv.Points(XYZ, normal=XYZ[:3])),
    ("radius", lambda: sv.Points(XYZ, radius=[1, 2])),
    ("rgb", lambda: sv.Points(XYZ, rgb=np.zeros((3, 3)))),
    ("rgb", lambda: sv.Points(XYZ, rgb=np.full((10, 3), 300))),
    ("rgb", lambda: sv.Points(XYZ, rgb=np.full((10, 3), -1))),
    ("rgb", lambda: sv.Points(XYZ, rgb=np.ones((10, 3), bool))),
    ("rgb", lambda: sv.Points(XYZ, rgb=np.full((10, 3), 1.5))),
    ("rgb", lambda: sv.Points(XYZ, rgb=np.full((10, 3), NAN))),
    ("sh", lambda: sv.Gaussians(FOUR, np.ones((4, 4)), FOUR, 1, sh=np.zeros((4, 0, 3)))),
    ("opacities", lambda: sv.Gaussians(FOUR, np.ones((4, 4)), FOUR, [1, 1], colors=FOUR)),
    ("scales", lambda: sv.Gaussians(FOUR, np.ones((4, 4)), FOUR[:2], 1, colors=FOUR)),
    ("cells", lambda: sv.Mesh(FOUR, [[0, 1, 2, -1]], np.ones(4))),
    ("types", lambda: sv.Mesh(FOUR, [[0, 1, 2, 3]], np.ones(4), types=[300])),
    ("types", lambda: sv.Mesh(FOUR, [[0, 1, 2, 3]], np.ones(4), types=[10, 10])),
    ("axes", lambda: sv.Scene().add_labels(sv.Volume(CUBE), axes="xyz")),
]


@pytest.mark.parametrize(("field", "call"), REFUSED, ids=[f"{field}-{n}" for n, (field, _) in enumerate(REFUSED)])
def test_values_are_refused_by_the_keywords_name(field: str, call: Callable[[], object]) -> None:
    with pytest.raises(sv.InvalidValue) as raised:
        call()
    assert raised.value.field == field and str(raised.value).startswith(f"{field}: ")


def test_whole_numbers_of_16_bits_are_colours_as_in_las_files() -> None:
    def shown(rgb: np.ndarray) -> np.ndarray:
        return np.asarray(sv.render(sv.Points(XYZ, rgb=rgb, radius=0.1), size=24))

    codes = np.random.default_rng(3).integers(0, 256, (10, 3))
    codes[0] = 255
    expected = shown(codes.astype(np.uint8))
    np.testing.assert_array_equal(shown((codes * 257).astype(np.uint16)), expected)
    np.testing.assert_array_equal(shown(codes.astype(np.uint16)), expected)
    np.testing.assert_array_equal(shown(codes), expected)
    np.testing.assert_array_equal(shown(codes / 255), expected)


def test_backgrounds_have_the_names_of_colours() -> None:
    pytest.importorskip("matplotlib")
    np.testing.assert_array_equal(np.asarray(drawn(background="red")), np.asarray(drawn(background=(1, 0, 0))))


def test_data_sets_of_xarray_are_refused() -> None:
    xarray = pytest.importorskip("xarray")
    with pytest.raises(TypeError, match="choose one of its arrays"):
        sv.render(xarray.Dataset({"a": (("z", "y", "x"), CUBE)}))


def test_files_that_are_not_there_and_endings_of_scenes(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as raised:
        sv.load(tmp_path / "missing.toml")
    assert str(raised.value) == f"[Errno 2] No such file or directory: '{tmp_path / 'missing.toml'}'"
    for data in ("https://example.org/brain.zarr", "sample:head"):
        with pytest.raises(sv.InvalidValue, match=r"is no scene: splatvol\.read reads data"):
            sv.load(data)
    with pytest.raises(sv.InvalidValue, match=r"\.toml or \.json"):
        sv.Scene("sample:head:8").save(tmp_path / "s.yaml")
    assert not list(tmp_path.iterdir())


def test_misspelt_keywords_of_animations(tmp_path: Path) -> None:
    with pytest.raises(sv.UnknownKeyword, match="did you mean frames="):
        sv.animate(CUBE, tmp_path / "a.gif", frame=2)
