"""Scenes, frames, cameras: what they keep, say and write."""

from __future__ import annotations

import json
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import splatvol as sv


def test_a_frame_is_an_array() -> None:
    frame = sv.render("sample:head:24", size=(40, 30))
    codes = np.asarray(frame)
    assert codes.shape == (30, 40, 4) and codes.dtype == np.uint8 and frame.size == (40, 30)
    assert np.asarray(frame) is codes or np.shares_memory(np.asarray(frame), codes)
    with pytest.raises(ValueError, match="read-only"):
        codes[...] = 0
    assert np.array(frame).flags.writeable
    assert np.asarray(frame, dtype=float).dtype == float
    assert frame.linear.shape == (30, 40, 4) and frame.alpha.shape == (30, 40)
    assert np.isinf(frame.depth[frame.alpha == 0]).all() and np.isfinite(frame.depth[frame.alpha > 0]).all()
    dense = frame.optical_depth[frame.alpha > 0.01]
    np.testing.assert_allclose(1 - np.exp(-dense), frame.alpha[frame.alpha > 0.01], atol=1e-5)
    assert frame.stats["threads"] >= 1
    white = frame.over("white" if _has_matplotlib() else "#ffffff")
    np.testing.assert_allclose(
        white[..., :3].astype(int),
        np.asarray(sv.render("sample:head:24", size=(40, 30), background="white"))[..., :3],
        atol=1,
    )


def _has_matplotlib() -> bool:
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        return False
    return True


def test_files(tmp_path: Path) -> None:
    frame = sv.render("sample:head:16", size=20)
    for name in ("a.png", "a.exr"):
        assert frame.save(tmp_path / name).stat().st_size > 0
    with pytest.raises(FileExistsError):
        frame.save(tmp_path / "a.png", overwrite=False)
    with pytest.raises(sv.InvalidValue, match="extension"):
        frame.save(tmp_path / "a.jpg")
    with pytest.raises(sv.InvalidValue, match="extension"):
        frame.save(tmp_path / "a")
    with pytest.raises(FileNotFoundError):
        frame.save(tmp_path / "nowhere" / "a.png")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.exr", "a.png"], "no half files are left"
    same = sv.compare(frame, tmp_path / "a.png")
    assert same.psnr == float("inf") and same.share == 0


def test_reprs_are_small() -> None:
    noise = np.random.default_rng(1).normal(size=(32, 32, 32))
    scene = sv.Scene(noise, size=1200, compositing="mip")
    png = scene._repr_png_()
    assert png is not None and png.startswith(b"\x89PNG") and len(png) <= 300_000
    assert sv.Scene()._repr_png_() is None
    assert "1200x1200" in repr(scene.render())


def test_scenes_change_by_keywords() -> None:
    scene = sv.Scene("sample:head:24", size=40)
    plain = np.asarray(scene.render())
    turned = np.asarray(scene.render(azimuth=40))
    assert not np.array_equal(plain, turned)
    np.testing.assert_array_equal(np.asarray(scene.render()), plain)
    scene.set(azimuth=40)
    np.testing.assert_array_equal(np.asarray(scene.render()), turned)
    scene.set(azimuth=None)
    np.testing.assert_array_equal(np.asarray(scene.render()), plain)
    scene.items[0].set(cmap="magma", clim=(0, 300))
    assert not np.array_equal(np.asarray(scene.render()), plain)
    scene.items[0].set(cmap=None, clim=None)
    np.testing.assert_array_equal(np.asarray(scene.render()), plain)


def test_cameras() -> None:
    scene = sv.Scene("sample:head:24", size=48, view="front")
    camera = scene.camera
    np.testing.assert_array_equal(np.asarray(scene.render(camera=camera)), np.asarray(scene.render()))
    chosen = scene.copy().set(azimuth=35, elevation=20).camera
    ours = camera.orbit(35, 20)
    np.testing.assert_allclose(ours.target, chosen.target, atol=1e-9)
    assert np.linalg.norm(np.subtract(ours.position, ours.target)) == pytest.approx(
        np.linalg.norm(np.subtract(camera.position, camera.target))
    )
    assert sv.Camera.from_pyvista(camera.to_pyvista(), view_angle=camera.fov) == camera
    eye = camera.matrix @ [*camera.position, 1]
    np.testing.assert_allclose(eye, [0, 0, 0, 1], atol=1e-9)
    ahead = camera.matrix @ [*camera.target, 1]
    assert ahead[2] < 0 and np.allclose(ahead[:2], 0)
    assert camera.zoom(2).fov < camera.fov
    with pytest.raises(sv.InvalidValue):
        sv.Camera((0, 0), (0, 0, 0))


def test_several_things_keep_their_looks() -> None:
    scene = sv.Scene("sample:head:16", size=40)
    scene.add("sample:marschner-lobb", scale=10.0, visible=False)
    assert [item.name for item in scene.items] == ["sample:head:16", "sample:marschner-lobb"]
    with pytest.raises(sv.InvalidValue, match="items"):
        scene.render(cmap="gray")
    assert scene.copy() == scene


def test_arrays_of_scenes_are_not_saved_silently(tmp_path: Path) -> None:
    scene = sv.Scene(np.ones((4, 4, 4), np.float32), size=16)
    with pytest.raises(sv.InvalidValue, match="array"):
        scene.save(tmp_path / "scene.toml")
    picture = scene.render().save(tmp_path / "a.png")
    with pytest.raises(sv.InvalidValue, match="like"):
        sv.like(picture)
    again = sv.like(picture, np.ones((4, 4, 4), np.float32))
    np.testing.assert_array_equal(np.asarray(again.render()), np.asarray(scene.render()))


def test_structural_similarity_is_the_commands(tmp_path: Path) -> None:
    one = sv.render("sample:head:24", size=(61, 45)).save(tmp_path / "a.png")
    other = sv.render("sample:head:24", size=(61, 45), azimuth=15).save(tmp_path / "b.png")
    compare = [sys.executable, "-m", "splatvol", "compare", str(one), str(other), "--json"]
    said = json.loads(subprocess.run(compare, check=False, capture_output=True, text=True).stdout)
    assert sv.compare(one, other).ssim == pytest.approx(said["ssim"], abs=1e-9)
    assert sv.compare(one, one).ssim == 1


def test_pictures_name_files_elsewhere_in_vain(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    there, here = tmp_path / "there", tmp_path / "here"
    there.mkdir()
    here.mkdir()
    data = np.random.default_rng(3).random((8, 8, 8)).astype(np.float32)
    np.save(there / "a.npy", data)
    monkeypatch.chdir(here)
    frame = sv.render(there / "a.npy", size=16)
    picture = frame.save(here / "a.png")
    with pytest.raises(sv.InvalidValue, match="allow_outside=True"):
        sv.like(picture)
    np.testing.assert_array_equal(np.asarray(sv.like(picture, allow_outside=True).render()), np.asarray(frame))
    np.testing.assert_array_equal(np.asarray(sv.like(picture, there / "a.npy").render()), np.asarray(frame))


def test_files_beside_the_picture_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    there = tmp_path / "there"
    there.mkdir()
    generator = np.random.default_rng(4)
    np.save(there / "a.npy", generator.random((8, 8, 8)).astype(np.float32))
    monkeypatch.chdir(there)
    sv.render("sample:ball", size=8).save("bump.png")
    frame = sv.render("a.npy", size=16, bump="bump.png")
    frame.save("a.png")
    monkeypatch.chdir(tmp_path)
    for picture in (Path("there/a.png"), there / "a.png"):
        np.testing.assert_array_equal(np.asarray(sv.like(picture).render()), np.asarray(frame))
    # The current folder goes first.
    np.save(tmp_path / "a.npy", generator.random((8, 8, 8)).astype(np.float32))
    assert not np.array_equal(np.asarray(sv.like("there/a.png").render()), np.asarray(frame))


def test_other_data_do_not_bring_in_files_elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here = tmp_path / "here"
    here.mkdir()
    sv.render("sample:ball", size=8).save(tmp_path / "bump.png")
    monkeypatch.chdir(here)
    picture = sv.render("sample:head:16", size=16, bump="../bump.png").save("a.png")
    ones = np.ones((4, 4, 4), np.float32)
    with pytest.raises(sv.InvalidValue, match=r"bump\.png"):
        sv.like(picture, ones)
    assert sv.like(picture, ones, allow_outside=True).render().size == (16, 16)


def nrrd(path: Path, samples: np.ndarray, data_file: str = "") -> Path:
    """Writes an NRRD of three or four axes, time being the last, with its samples in another file if one is named."""
    sizes = " ".join(str(n) for n in samples.shape[::-1])
    rest = samples.ndim - 3
    kinds = " ".join(["space"] * 3 + ["time"] * rest)
    steps = " ".join(["(1,0,0)", "(0,1,0)", "(0,0,1)"] + ["none"] * rest)
    head = (
        f"NRRD0004\ntype: uchar\nencoding: raw\ndimension: {samples.ndim}\nspace dimension: 3\nsizes: {sizes}\n"
        f"kinds: {kinds}\nspace directions: {steps}\n"
    )
    if data_file:
        path.write_text(f"{head}data file: {data_file}\n")
    else:
        path.write_bytes(f"{head}\n".encode() + samples.tobytes())
    return path


def test_links_out_of_the_folder_are_read_if_allowed(tmp_path: Path) -> None:
    samples = np.random.default_rng(5).integers(0, 255, (4, 4, 4), np.uint8)
    (tmp_path / "elsewhere.raw").write_bytes(samples.tobytes())
    here = tmp_path / "here"
    here.mkdir()
    try:
        (here / "a.raw").symlink_to(tmp_path / "elsewhere.raw")
    except OSError:
        pytest.skip("no symbolic links here")
    header = nrrd(here / "a.nhdr", samples, "a.raw")
    with pytest.raises(sv.SplatvolError, match="leads out of its folder"):
        sv.read(header)
    data = sv.read(header, allow_outside=True)
    assert isinstance(data, sv.Volume)
    np.testing.assert_array_equal(np.asarray(data), samples)
    # What was allowed is allowed where it is read again.
    np.testing.assert_array_equal(np.asarray(pickle.loads(pickle.dumps(data))), samples)
    picture = sv.render(data, size=16).save(here / "a.png")
    with pytest.raises(sv.SplatvolError, match="leads out of its folder"):
        sv.like(picture)
    again = sv.like(picture, allow_outside=True).render()
    np.testing.assert_array_equal(np.asarray(again), np.asarray(sv.render(data, size=16)))


def test_memory_for_samples_is_limited(tmp_path: Path) -> None:
    samples = np.random.default_rng(6).integers(0, 255, (4, 4, 4), np.uint8)
    path = nrrd(tmp_path / "a.nrrd", samples)
    assert sv.read(path, max_memory=64).kind == "volume"
    with pytest.raises(sv.LimitError, match="63"):
        sv.read(path, max_memory=63)
    picture = sv.render(path, size=16).save(tmp_path / "a.png")
    with pytest.raises(sv.LimitError, match="63"):
        sv.like(picture, max_memory=63)
    with pytest.raises(sv.LimitError, match="63"):
        sv.like(picture, path, max_memory=63)
    for wrong in (-1, 1.5, "8G", True):
        with pytest.raises(sv.InvalidValue, match="max_memory"):
            sv.read(path, max_memory=wrong)  # type: ignore[arg-type]
    with pytest.raises(sv.InvalidValue, match="max_memory"):
        sv.read(samples, max_memory=64)


def test_another_time_looks_the_same(tmp_path: Path) -> None:
    samples = np.random.default_rng(7).integers(0, 255, (2, 4, 4, 4), np.uint8)
    path = nrrd(tmp_path / "a.nrrd", samples)
    picture = sv.render(path, time=0, size=16, clim=(0, 255)).save(tmp_path / "a.png")
    wanted = np.asarray(sv.render(path, time=1, size=16, clim=(0, 255)))
    np.testing.assert_array_equal(np.asarray(sv.like(picture, time=1).render()), wanted)
    np.testing.assert_array_equal(np.asarray(sv.like(picture, path, time=1).render()), wanted)
    with pytest.raises(sv.SplatvolError, match="time point 2"):
        sv.like(picture, time=2)


def test_pickles(ball: np.ndarray) -> None:
    for scene in (sv.Scene(ball, size=24, cmap="magma"), sv.Scene("sample:head:16", size=24, azimuth=10)):
        again = pickle.loads(pickle.dumps(scene))
        np.testing.assert_array_equal(np.asarray(again.render()), np.asarray(scene.render()))
    frame = sv.render(ball, size=24)
    again = pickle.loads(pickle.dumps(frame))
    np.testing.assert_array_equal(np.asarray(again), np.asarray(frame))
    np.testing.assert_array_equal(again.linear, frame.linear)
    camera = sv.Camera((0, 1, 2), (0, 0, 0))
    assert pickle.loads(pickle.dumps(camera)) == camera
    error = sv.InvalidValue("x", field="y")
    assert pickle.loads(pickle.dumps(error)).field == "y"


def test_what_is_wrong_in_a_file_is_said(tmp_path: Path) -> None:
    broken = tmp_path / "broken.nrrd"
    broken.write_bytes(b"NRRD0004\ntype: float\ndimension: 3\nsizes: 4 4\nencoding: raw\n\n")
    with pytest.raises(sv.FormatError) as raised:
        sv.read(broken)
    assert raised.value.path == str(broken) and isinstance(raised.value, ValueError)
    with pytest.raises(FileNotFoundError):
        sv.read(tmp_path / "absent.nrrd")
    scene = tmp_path / "scene.toml"
    scene.write_text("[[item]]\nfile = 'sample:head:8'\ncmapp = 'gray'\n")
    with pytest.raises(sv.FormatError, match="cmapp"):
        sv.load(scene)


def test_info_and_lists() -> None:
    about = sv.info("sample:head:16")
    assert about["dims"] == [16, 16, 16] and about["kind"] == "volume"
    assert "head" in sv.samples() and "viridis" in sv.colormaps()


def test_none_leaves_camera_and_clips_open_again() -> None:
    scene = sv.Scene("sample:head:16", size=24)
    chosen = np.asarray(scene.render())
    scene.set(camera=sv.Camera((90, 20, 10), (0, 0, 0), (0, 0, 1)), clip=sv.Clip.plane((0, 0, 0), (1, 0, 0)))
    assert (np.asarray(scene.render()) != chosen).any()
    scene.set(clip=None, camera=None)
    np.testing.assert_array_equal(np.asarray(scene.render()), chosen)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"fov": "x"}, "fov: 'x' is not allowed, expected a number"),
        ({"bits": "x"}, "bits: 'x' is not allowed, expected a whole number"),
        ({"visible": 3}, "visible: 3 is not allowed, expected True or False"),
    ],
)
def test_refusals_name_no_types_of_rust(options: dict[str, object], words: str) -> None:
    with pytest.raises(sv.InvalidValue) as error:
        sv.render("sample:head:16", size=8, **options)
    assert str(error.value).startswith(words)
    assert not any(name in str(error.value) for name in ("f64", "u32", "invalid type"))


@pytest.mark.parametrize("kind", ["points", "gaussians", "mesh"])
def test_places_far_from_zero_keep_their_digits(kind: str) -> None:
    near = np.random.default_rng(5).integers(-500, 500, (60, 3)) / 256.0
    cells = np.random.default_rng(6).integers(0, 60, (40, 4))
    cells = [cell for cell in cells if len(set(cell)) == 4]

    def picture(places: np.ndarray) -> np.ndarray:
        if kind == "points":
            data: sv.Data = sv.Points(places, radius=0.1)
        elif kind == "gaussians":
            quats = np.tile([1.0, 0.0, 0.0, 0.0], (60, 1))
            data = sv.Gaussians(places, quats, np.full((60, 3), 0.1), 0.8, colors=np.full((60, 3), 0.7))
        else:
            data = sv.Mesh(places, cells, np.arange(60.0))
        return np.asarray(sv.render(data, size=64)).astype(int)

    # A town in UTM: a float32 there is half a metre.
    far = picture(near + np.array([500_000.0, 5_400_000.0, 300.0]))
    assert far[..., 3].max() > 0 and np.ptp(far[..., :3]) > 20
    assert np.abs(far - picture(near)).max() <= 2


def test_points_gaussians_and_meshes_of_arrays() -> None:
    random = np.random.default_rng(3)
    xyz = random.normal(size=(400, 3))
    xyz /= np.linalg.norm(xyz, axis=1, keepdims=True)
    points = sv.Points(xyz, rgb=(xyz + 1) / 2, radius=0.15, normal=xyz)
    gaussians = sv.Gaussians(xyz, np.tile([1.0, 0, 0, 0], (400, 1)), np.full((400, 3), 0.1), 0.8, colors=(xyz + 1) / 2)
    corners = np.array([[x, y, z] for z in range(6) for y in range(6) for x in range(6)], float)
    around = np.array([0, 1, 7, 6, 36, 37, 43, 42])
    hexahedra = [z * 36 + y * 6 + x + around for z in range(5) for y in range(5) for x in range(5)]
    mesh = sv.Mesh(corners, hexahedra, corners.sum(axis=1))
    for data in (points, gaussians, mesh):
        frame = data.render(size=48, background="none")
        assert 0.02 < (frame.alpha > 0.3).mean() < 0.98, data
    assert len(points) == len(gaussians) == 400
    blended = gaussians.render(size=16)
    with pytest.raises(sv.InvalidValue, match="none"):
        blended._encoded("exr")
    assert gaussians.render(size=16, background="none")._encoded("exr")
    with pytest.raises(sv.InvalidValue, match="colors or sh"):
        sv.Gaussians(xyz, np.zeros((400, 4)), np.ones((400, 3)), 1.0)
    with pytest.raises(sv.InvalidValue, match="shape"):
        sv.Points(np.zeros((3, 2)))
    with pytest.raises(sv.InvalidValue):
        sv.Mesh(corners, [[0, 1, 3, 999, 4, 5, 7, 6]], corners.sum(axis=1))


def test_parts_of_volumes_keep_their_place(ball: np.ndarray) -> None:
    volume = sv.Volume(ball, spacing=(3, 2, 1), unit="mm", name="ball")
    part = volume[2:, ::2, 4:20:3]
    assert part.shape == ball[2:, ::2, 4:20:3].shape and part.spacing == (3, 4, 3) and part.unit == "mm"
    np.testing.assert_array_equal(np.asarray(part), ball[2:, ::2, 4:20:3])
    np.testing.assert_allclose(part.affine @ [1, 1, 1, 1], volume.affine @ [4 + 3, 2, 3, 1])
    turned = volume[::-1]
    np.testing.assert_allclose(turned.affine @ [0, 0, 19, 1], volume.affine @ [0, 0, 0, 1])
    with pytest.raises(sv.InvalidValue, match="slices"):
        volume[3]
    assert volume.stats()["max"] == ball.max()


def test_what_is_written_to_an_array_is_shown_after_a_touch(ball: np.ndarray) -> None:
    own = ball.copy()
    volume = sv.Volume(own)
    before = np.asarray(volume.render(size=32))
    own[...] = own[:, ::-1, ::-1] ** 3
    volume.touch()
    after = np.asarray(volume.render(size=32))
    assert not np.array_equal(before, after)
    np.testing.assert_array_equal(after, np.asarray(sv.render(own, size=32)))


def test_volumes_and_transfer_functions_are_written(ball: np.ndarray, tmp_path: Path) -> None:
    volume = sv.Volume(ball, affine=np.diag([3.0, 2, 1, 1])[[2, 1, 0, 3]])
    again = sv.read(volume.save(tmp_path / "ball.nrrd"))
    assert isinstance(again, sv.Volume)
    np.testing.assert_array_equal(np.asarray(again), ball)
    np.testing.assert_allclose(again.affine, volume.affine)
    tf = sv.TransferFunction([(0, "#102030"), (1, "#ffffff")], [(0, 0), (1, 0.5)], 2.0)
    tf.save(tmp_path / "look.vp.json")
    read = sv.TransferFunction.load(tmp_path / "look.vp.json")
    assert [value for value, _ in read.colors] == [0, 1] and read.opacities == tf.opacities


def test_segmentations(ball: np.ndarray) -> None:
    ids = (ball > 0.2).astype(np.uint8) + (ball > 0.7).astype(np.uint8)
    scene = sv.Scene(size=48, background="none")
    scene.add_labels(ids, colors={1: "#ff0000", 2: "#00ff00"}, opacity={1: 0.02})
    frame = scene.render(shade=False)
    red, green, _ = frame.linear[24, 24, :3]
    assert green > red > 0
    shown = scene.add_labels(ids, visible=False)
    assert shown.keys["labels"] is True
    beside = sv.Scene(sv.Volume(ball, spacing=(3, 2, 1)), size=32)
    for label in (beside.add_labels(ids), beside.add_labels(ids.transpose(2, 1, 0), axes="xyz")):
        assert isinstance(label.data, sv.Volume) and label.data.spacing == (3, 2, 1)
        np.testing.assert_array_equal(np.asarray(label.data), ids)


def test_opaque_ids_keep_their_colours() -> None:
    ids = np.zeros((24, 24, 24), np.uint8)
    ids[6:18, 6:18, 2:10] = 1
    ids[6:18, 6:18, 14:22] = 9
    scene = sv.Scene(size=(96, 48), view="front", background="none")
    scene.add_labels(ids, colors={1: "#ff0000", 9: "#0000ff"})
    colors = np.asarray(scene.render(shade=False))[24]
    seen = {tuple(color[:3]) for color in colors if color[3] == 255}
    assert seen == {(255, 0, 0), (0, 0, 255)}


@pytest.mark.parametrize("name", ["front", "left", "top", "iso"])
def test_cameras_by_name_are_those_of_render(name: str, ball: np.ndarray) -> None:
    camera = sv.Camera.view(name, ball, size=(64, 48))
    ours = sv.render(ball, camera=camera, size=(64, 48))
    np.testing.assert_array_equal(np.asarray(ours), np.asarray(sv.render(ball, view=name, size=(64, 48))))
    with pytest.raises(sv.InvalidValue, match="frnt"):
        sv.Camera.view("frnt", ball)
