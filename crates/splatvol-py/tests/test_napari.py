"""napari, the real one, without a window: its layers, its camera, the plugin; where Xvfb is, its own picture, too."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import splatvol as sv
from splatvol._napari import plugin

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    pytest.importorskip("napari", reason="napari is not installed")
    components = pytest.importorskip("napari.components", exc_type=ImportError)

# napari's and Qt's own; those of splatvol are asked for below.
pytestmark = pytest.mark.filterwarnings("ignore")

SIZE = (160, 120)


def corners() -> np.ndarray[Any, Any]:
    """Three blocks: one at the first corner, one along x from it, and one along z from that, of values 4, 7, 10."""
    values = np.zeros((20, 24, 28), np.float32)
    values[1:5, 1:5, 1:5] = 4
    values[1:5, 1:5, 23:27] = 7
    values[15:19, 19:23, 23:27] = 10
    return values


@pytest.fixture
def viewer() -> Any:
    """A viewer without a window that looks along its first axis."""
    made = components.ViewerModel()
    made.add_image(corners(), name="corners", contrast_limits=(0, 10))
    made.dims.ndisplay = 3
    camera(made).angles = (0, 0, 0)
    camera(made).zoom = 20
    return made


def camera(viewer: Any) -> Any:
    return getattr(viewer, "scene", viewer).camera


def places(picture: Any) -> dict[int, tuple[bool, bool]]:
    """Whether the block of a value is in the picture's left and upper half: each quarter's largest value."""
    gray = np.asarray(picture)[..., 0].astype(float) / 25.5
    rows, columns = np.array(gray.shape) // 2
    found = {}
    for left, part in ((True, gray[:, :columns]), (False, gray[:, columns:])):
        for upper, quarter in ((True, part[:rows]), (False, part[rows:])):
            found[round(float(quarter.max()))] = (left, upper)
    return found


#: Without overshoot beside the blocks.
SMOOTH = {"prefilter": False}


@pytest.mark.parametrize(
    ("orientation", "low"),
    [
        (("towards", "down", "right"), (True, True)),
        (("away", "down", "right"), (True, True)),
        (("away", "up", "right"), (True, False)),
        (("towards", "down", "left"), (False, True)),
    ],
)
def test_axes_point_where_napari_points_them(viewer: Any, orientation: Any, low: tuple[bool, bool]) -> None:
    camera(viewer).orientation = orientation
    found = places(sv.render(viewer, size=SIZE, **SMOOTH))
    left, upper = low
    corners_of = {4: (left, upper), 7: (not left, upper), 10: (not left, not upper), 0: (left, not upper)}
    assert found == corners_of


@pytest.mark.parametrize(("depth", "nearer"), [("towards", 10), ("away", 7)])
def test_the_first_axis_points_where_napari_points_it(viewer: Any, depth: str, nearer: int) -> None:
    camera(viewer).orientation = (depth, "down", "right")
    camera(viewer).perspective = 60
    frame = sv.render(viewer, size=SIZE, **SMOOTH)
    gray = np.asarray(frame)[..., 0].astype(float) / 25.5
    areas = {value: int((np.abs(gray - value) < 0.7).sum()) for value in (7, 10)}
    assert max(areas, key=areas.__getitem__) == nearer, areas


@pytest.mark.parametrize("perspective", [0, 40])
def test_the_canvas_height_is_the_pictures(viewer: Any, perspective: float) -> None:
    camera(viewer).perspective = perspective
    seen = sv.Camera.from_napari(viewer, canvas=(500, 700))
    height = seen.height
    if height is None:
        distance = np.linalg.norm(np.subtract(seen.position, seen.target))
        height = 2 * distance * np.tan(np.radians(seen.fov) / 2)
    assert height == pytest.approx(500 / 20)
    assert sv.Scene.from_napari(viewer, canvas=(50, 70)).render().size == (70, 50)


def test_layers_lie_where_napari_has_them() -> None:
    layers = pytest.importorskip("napari.layers")
    layer = layers.Image(np.arange(24.0).reshape(2, 3, 4), scale=(4, 2, 1), translate=(10, 20, 30), units="um")
    volume = sv.from_napari(layer)
    assert volume.unit == "um"
    index = np.array([3, 2, 1, 1])
    np.testing.assert_allclose((volume.affine @ index)[:3][::-1], layer.data_to_world((1, 2, 3)))
    assert sv.render(layer, size=16).size == (16, 16)
    assert repr(sv.Volume.from_napari(layer)) == repr(volume)
    turned = layers.Image(np.zeros((2, 3, 4)), rotate=(10, 20, 30), shear=(0.1, 0, 0), scale=(2, 1, 1))
    np.testing.assert_allclose((sv.from_napari(turned).affine @ index)[:3][::-1], turned.data_to_world((1, 2, 3)))


def test_the_current_slice_and_the_order_of_axes_are_shown(viewer: Any) -> None:
    viewer.layers.clear()
    series = np.stack([np.zeros_like(corners()), corners()])
    layer = viewer.add_image(series, contrast_limits=(0, 10))
    viewer.dims.set_point(0, 1)
    data = sv.Scene.from_napari(viewer).items[0].data
    np.testing.assert_array_equal(np.asarray(data), corners())
    assert layer.ndim == 4
    viewer.dims.set_point(0, 0)
    assert np.asarray(sv.Scene.from_napari(viewer).items[0].data).max() == 0
    viewer.dims.set_point(0, 1)
    viewer.dims.order = (0, 3, 1, 2)
    data = sv.Scene.from_napari(viewer).items[0].data
    np.testing.assert_array_equal(np.asarray(data), corners().transpose(2, 0, 1))


def test_the_finest_level_that_fits_is_taken_and_lies_alike(viewer: Any) -> None:
    viewer.layers.clear()
    fine = corners()
    coarse = fine.reshape(10, 2, 12, 2, 14, 2).mean(axis=(1, 3, 5))
    viewer.add_image([fine, coarse], multiscale=True, contrast_limits=(0, 10))
    finest, coarser = (
        sv.Scene.from_napari(viewer, max_bytes=size).items[0].data for size in (fine.nbytes, fine.nbytes - 1)
    )
    assert (finest.shape, coarser.shape) == (fine.shape, coarse.shape)
    middle = [volume.affine @ [*(np.array(volume.shape[::-1]) / 2 - 0.5), 1] for volume in (finest, coarser)]
    np.testing.assert_allclose(*middle)
    with pytest.raises(sv.InvalidValue, match="no coarser level"):
        sv.Scene.from_napari(viewer, max_bytes=100)


def test_colours_are_the_layers(viewer: Any) -> None:
    layer = viewer.layers[0]
    layer.colormap, layer.gamma, layer.contrast_limits = "magma", 0.5, (0, 20)
    (item,) = sv.Scene.from_napari(viewer).items
    points = item.keys["transfer-function"]["colors"]
    at = min(points, key=lambda point: abs(point["value"] - 5.0))
    expected = layer.colormap.map(np.array([(at["value"] / 20) ** 0.5]))[0][:3]
    np.testing.assert_allclose(at["rgb"], expected, atol=1e-6)


@pytest.mark.parametrize("rendering", ["mip", "minip", "average", "translucent", "iso"])
def test_renderings(viewer: Any, rendering: str) -> None:
    viewer.layers[0].rendering = rendering
    viewer.layers[0].iso_threshold = 2
    if rendering == "minip":
        viewer.layers[0].data = 10 - viewer.layers[0].data
    if rendering == "translucent":
        viewer.layers[0].colormap = {"colors": [[0, 0, 0, 0], [1, 1, 1, 1]], "name": "clear"}
    codes = np.asarray(sv.render(viewer, size=SIZE))[..., :3]
    assert codes.max() > 0 and len(np.unique(codes)) > 3


def test_what_is_not_known_is_refused_by_name(viewer: Any) -> None:
    layer = viewer.layers[0]
    for setting, value in [("rendering", "attenuated_mip"), ("depiction", "plane"), ("blending", "multiplicative")]:
        before = getattr(layer, setting)
        setattr(layer, setting, value)
        with pytest.raises(sv.InvalidValue, match=f"'corners'.*{value}"):
            sv.render(viewer)
        setattr(layer, setting, before)
    viewer.dims.ndisplay = 2
    with pytest.raises(sv.InvalidValue, match="ndisplay = 3"):
        sv.render(viewer)
    with pytest.raises(TypeError, match=r"Scene\.from_napari"):
        sv.read(viewer)


def test_layers_of_other_kinds_are_left_out_with_a_warning(viewer: Any) -> None:
    viewer.add_vectors(np.zeros((1, 2, 3)), name="arrows")
    with pytest.warns(sv.DataWarning, match="arrows"):
        sv.render(viewer, size=SIZE)


def test_maxima_are_blended_as_napari_blends_them(viewer: Any) -> None:
    viewer.layers[0].colormap = "red"
    viewer.add_image(corners(), colormap="green", blending="additive", contrast_limits=(0, 10))
    with pytest.raises(sv.Combination, match="one scene"):
        sv.Scene.from_napari(viewer)
    both = np.asarray(sv.render(viewer, size=SIZE))
    viewer.layers[1].visible = False
    red = np.asarray(sv.render(viewer, size=SIZE))
    np.testing.assert_allclose(both[..., 0].astype(int), red[..., 0], atol=1)
    np.testing.assert_allclose(both[..., 1].astype(int), red[..., 0], atol=2)
    assert both[..., 2].max() == 0


def test_labels_and_points_have_their_colours(viewer: Any) -> None:
    viewer.layers.clear()
    labels = viewer.add_labels((corners() == 4).astype(np.int64) * 3, opacity=1)
    viewer.dims.ndisplay = 3
    codes = np.asarray(sv.render(viewer, size=SIZE))[..., :3].reshape(-1, 3).astype(float)
    shown = codes[codes.max(axis=1) > 60]
    expected = np.asarray(labels.get_color(3))[:3]
    found = shown.mean(axis=0)
    np.testing.assert_allclose(found / found.max(), expected / expected.max(), atol=0.1)
    assert np.asarray(sv.from_napari(labels)).max() == 3
    viewer.layers.clear()
    viewer.add_points([[10, 4, 4]], size=6, face_color="lime", ndim=3)
    viewer.dims.ndisplay = 3
    codes = np.asarray(sv.render(viewer, size=SIZE))
    assert codes[..., 1].max() > 200 and codes[..., 0].max() < 30


# The plugin.


def test_the_manifest_is_valid_and_names_what_there_is() -> None:
    npe2 = pytest.importorskip("npe2")
    pytest.importorskip("qtpy.QtWidgets", reason="Qt cannot load", exc_type=ImportError)
    manifest = npe2.PluginManifest.from_file(Path(plugin.__file__).with_name("napari.yaml"))
    manifest.validate_imports()
    assert {sample.key for sample in manifest.contributions.sample_data} <= sv.samples().keys()


SCANS = ["ball.nii.gz", "ball.mhd", "ball.tif", "FLAIR.nii.gz", "HeadMRVolume.mhd", "100_fiberform.tif"]


@pytest.mark.parametrize("name", SCANS)
def test_files_come_as_layers_and_go_back(name: str, scan: Callable[[str], Path]) -> None:
    layers = pytest.importorskip("napari.layers")
    path = scan(name)
    reader = plugin.reader_of(str(path))
    assert reader is not None
    ((values, keywords, kind),) = reader(str(path))
    assert kind == "image"
    volume = sv.read(path)
    again = sv.from_napari(layers.Image(values, **keywords))
    np.testing.assert_allclose(again.affine, volume.affine, atol=1e-5)
    assert (again.unit, again.range) == (volume.unit, pytest.approx(volume.range))
    assert keywords["name"] == name.split(".")[0]


def test_channels_are_layers(tmp_path: Path) -> None:
    tifffile = pytest.importorskip("tifffile")
    path = tmp_path / "cells.ome.tif"
    values = np.random.default_rng(1).integers(0, 200, (4, 2, 6, 8)).astype(np.uint8)
    lengths = {"PhysicalSizeX": 0.5, "PhysicalSizeY": 0.5, "PhysicalSizeZ": 2}
    tifffile.imwrite(path, values, ome=True, metadata={"axes": "ZCYX", "Channel": {"Name": ["DAPI", "GFP"]}, **lengths})
    reader = plugin.reader_of(str(path))
    assert reader is not None
    layers = reader(str(path))
    assert [keywords["name"] for _, keywords, _ in layers] == ["cells DAPI", "cells GFP"]
    for number, (data, keywords, _) in enumerate(layers):
        np.testing.assert_array_equal(data, values[:, number])
        np.testing.assert_allclose(keywords["scale"], (2, 0.5, 0.5))
        assert keywords["units"] == ["um"] * 3 and keywords["blending"] == "additive"


@pytest.mark.parametrize("name", ["ball", "dicom_transfer_syntaxes/anatomical"])
def test_a_folder_is_read_only_if_it_is_one_volume(name: str, tmp_path: Path, scan: Callable[[str], Path]) -> None:
    (tmp_path / "notes.txt").write_text("nothing to see")
    assert plugin.reader_of(str(tmp_path)) is None
    folder = scan(name)
    reader = plugin.reader_of(str(folder))
    assert reader is not None
    ((values, keywords, _),) = reader(str(folder))
    assert values.ndim == 3 and {"scale", "affine"} & keywords.keys()


def test_samples_are_layers() -> None:
    ((values, keywords, kind),) = plugin.nerve()
    assert kind == "image" and values.ndim == 3
    assert keywords["scale"][0] > keywords["scale"][2]


@pytest.fixture
def dock(viewer: Any) -> Iterator[Any]:
    widgets = pytest.importorskip("qtpy.QtWidgets", reason="Qt cannot load", exc_type=ImportError)
    from splatvol._napari.dock import Dock

    application = widgets.QApplication.instance() or widgets.QApplication([])
    made = Dock(viewer)
    made.application = application
    yield made
    made.stop()


def wait(dock: Any, until: Any, seconds: float = 20.0) -> None:
    end = time.monotonic() + seconds
    while not until():
        assert time.monotonic() < end, dock.note.text()
        dock.application.processEvents()
        time.sleep(0.01)


def picture_in(dock: Any) -> bytes | None:
    pixmap = dock.preview.pixmap()
    if pixmap is None or pixmap.isNull():
        return None
    image = pixmap.toImage()
    return bytes(image.constBits().asarray(image.sizeInBytes()))


def test_the_preview_follows_the_camera(viewer: Any, dock: Any) -> None:
    wait(dock, lambda: picture_in(dock) is not None)
    before = picture_in(dock)
    camera(viewer).angles = (20, 40, 60)
    wait(dock, lambda: picture_in(dock) != before)
    viewer.layers[0].rendering = "attenuated_mip"
    wait(dock, lambda: "attenuated_mip" in dock.note.text())


def test_the_saved_picture_has_the_size_that_was_asked_for(dock: Any, tmp_path: Path) -> None:
    assert (dock.width_field.value(), dock.height_field.value()) == (3200, 2400)
    dock.width_field.setValue(90)
    dock.height_field.setValue(70)
    path = tmp_path / "picture.png"
    dock.save(path)
    wait(dock, lambda: "wrote" in dock.note.text())
    assert sv._verbs.pixels_of(path).shape == (70, 90, 4)


def test_the_copied_program_makes_the_picture(viewer: Any, dock: Any, tmp_path: Path, monkeypatch: Any) -> None:
    napari = pytest.importorskip("napari")
    monkeypatch.setattr(napari, "current_viewer", lambda: viewer)
    monkeypatch.chdir(tmp_path)
    dock.width_field.setValue(90)
    dock.height_field.setValue(70)
    exec(compile(dock.python(), "copied", "exec"), {})
    expected = sv.render(viewer, size=(90, 70))
    assert sv.compare(tmp_path / "picture.png", expected).maximum == 0


#: Renders by napari's own canvas and by splatvol, and prints the share of pixels that both or only one of them show.
BOTH = """
import sys, time, warnings
warnings.simplefilter("ignore")
import napari, numpy as np, splatvol as sv
from qtpy.QtWidgets import QApplication

bars = np.zeros((40, 50, 60), np.float32)
bars[18:22, 23:27, 5:55] = bars[18:22, 5:27, 5:9] = bars[18:38, 23:27, 51:55] = 1
viewer = napari.Viewer(show=True)
viewer.add_image(bars, scale=(2, 1, 1), translate=(3, 4, 5), contrast_limits=(0, 1))
viewer.dims.ndisplay = 3
camera = getattr(viewer, "scene", viewer).camera
camera.zoom *= 0.6
for orientation in (("towards", "down", "right"), ("away", "down", "right"), ("towards", "up", "right")):
    for perspective in (0, 50):
        camera.orientation, camera.perspective, camera.angles = orientation, perspective, (10, 30, 60)
        for _ in range(4):
            QApplication.processEvents()
            time.sleep(0.02)
        theirs = viewer.screenshot(canvas_only=True, flash=False)
        ours = np.asarray(sv.render(viewer, size=theirs.shape[1::-1], prefilter=False))
        a, b = theirs[..., 0] > 100, ours[..., 0] > 100
        assert a.sum() > 1000
        print("share", (a & b).sum() / (a | b).sum(), (a & b[:, ::-1]).sum() / (a | b[:, ::-1]).sum(), flush=True)
viewer.close()
"""


def test_the_outline_is_that_of_naparis_own_picture(tmp_path: Path) -> None:
    xvfb = shutil.which("xvfb-run")
    if xvfb is None:
        pytest.skip("xvfb-run is not installed: napari's own pictures are not compared")
    program = tmp_path / "both.py"
    program.write_text(BOTH)
    environment = {**os.environ, "QT_QPA_PLATFORM": "xcb", "PYTHONPATH": os.pathsep.join(map(str, sys.path))}
    line = [xvfb, "-a", "-s", "-screen 0 1200x900x24", sys.executable, str(program)]
    done = subprocess.run(line, env=environment, capture_output=True, text=True, timeout=300)
    if "Could not load the Qt platform plugin" in done.stderr:
        pytest.skip("Qt opens no window here (libxcb-cursor0 is missing): napari's own pictures are not compared")
    assert done.returncode == 0, done.stderr[-3000:]
    shares = [tuple(map(float, row.split()[1:])) for row in done.stdout.splitlines() if row.startswith("share")]
    assert len(shares) == 6
    assert min(own for own, _ in shares) > 0.9, shares
    assert max(mirrored for _, mirrored in shares) < 0.5, shares
