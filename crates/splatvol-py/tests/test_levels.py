"""OME-Zarr groups and arrays of dask: the level by budget, the place, and the command's picture."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import splatvol as sv

zarr = pytest.importorskip("zarr")
Command = Callable[..., np.ndarray]


def steps(scale: list[float], translation: list[float]) -> list[dict[str, Any]]:
    return [{"type": "scale", "scale": scale}, {"type": "translation", "translation": translation}]


def image(store: Any, samples: np.ndarray, version: int, axes: str = "zyx") -> Any:
    """An OME-Zarr image of three levels, with a place, of version 0.4 or 0.5."""
    kinds = {"t": "time", "c": "channel"}
    spare = len(axes) - 3
    described: list[dict[str, Any]] = [
        {"name": axis, "type": kinds[axis]} if axis in kinds else {"name": axis, "type": "space", "unit": "micrometer"}
        for axis in axes
    ]
    levels = []
    for level in range(3):
        scale = [1.0] * spare + [0.5 * 2**level, 0.25 * 2**level, 0.25 * 2**level]
        shift = [0.0] * spare + [0.25 * (2**level - 1) + 10, 3.0, 0.125 * (2**level - 1)]
        levels.append({"path": f"s{level}", "coordinateTransformations": steps(scale, shift)})
    outer = steps([1.0] * spare + [2.0, 1.0, 1.0], [0.0] * spare + [1.0, 0.0, 0.0])
    scales = [{"axes": described, "datasets": levels, "coordinateTransformations": outer, "version": "0.4"}]
    attributes: dict[str, Any] = {"multiscales": scales}
    attributes = {"ome": {"version": "0.5", **attributes}} if version == 3 else attributes
    group = zarr.create_group(store, zarr_format=version, attributes=attributes)
    for level in range(3):
        part = samples[(Ellipsis, *[slice(None, None, 2**level)] * 3)]
        group.create_array(f"s{level}", data=np.ascontiguousarray(part), chunks=(1,) * spare + (8,) * 3)
    return group


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("level", [None, 1, 2])
def test_groups_make_the_commands_picture(
    version: int, level: int | None, ball: np.ndarray, tmp_path: Path, command: Command
) -> None:
    path = tmp_path / "image.zarr"
    group = image(path, ball, version)
    flags = [] if level is None else ["--level", level]
    frame = sv.render(group, size=96, level=level, azimuth=30)
    np.testing.assert_array_equal(np.asarray(frame), command(path, "--size", "96", "--azimuth", "30", *flags))
    ours, theirs = sv.from_zarr(group, level=level or 0), sv.read(path, level=level)
    assert isinstance(theirs, sv.Volume)
    np.testing.assert_array_equal(ours.affine, theirs.affine)
    assert (ours.unit, ours.shape) == (theirs.unit, theirs.shape) == ("um", theirs.shape)


def test_channels_and_times_are_the_commands(ball: np.ndarray, tmp_path: Path, command: Command) -> None:
    samples = np.stack([[ball, ball[::-1] ** 2], [ball * 0.5, ball[:, ::-1]]])
    path = tmp_path / "image.zarr"
    group = image(path, samples, 3, "tczyx")
    frame = sv.render(group, channel=1, time=1, size=64)
    np.testing.assert_array_equal(np.asarray(frame), command(path, "--channel", 1, "--time", 1, "--size", 64))
    with pytest.warns(sv.DataWarning, match="0 of 2") as warned:
        np.testing.assert_array_equal(np.asarray(sv.Volume.from_zarr(group)), ball)
    assert [str(one.message).split()[0] for one in warned] == ["time", "channel"]
    with pytest.raises(sv.InvalidValue, match="channel: 2"):
        sv.from_zarr(group, channel=2, time=0)
    with pytest.raises(sv.InvalidValue, match="time: 5"):
        sv.from_zarr(group, time=5, channel=0)


@pytest.mark.parametrize("version", [2, 3])
def test_the_finest_level_of_a_budget_is_read_from_memory(version: int, ball: np.ndarray) -> None:
    group = image(zarr.storage.MemoryStore(), ball, version)
    assert sv.from_zarr(group).shape == ball.shape
    assert sv.from_zarr(group, max_bytes=ball.nbytes).shape == ball.shape
    coarse = sv.from_zarr(group, max_bytes=ball.nbytes - 1)
    np.testing.assert_array_equal(np.asarray(coarse), ball[::2, ::2, ::2])
    with pytest.raises(sv.LimitError, match="max_bytes=840"):
        sv.from_zarr(group, max_bytes=800)
    with pytest.raises(sv.InvalidValue, match="level: 3"):
        sv.render(group, level=3)


def test_only_what_is_chosen_is_read(ball: np.ndarray) -> None:
    inner = zarr.storage.MemoryStore()
    image(inner, np.stack([ball] * 4), 3, "tzyx")
    read: list[str] = []

    class Remote(zarr.storage.WrapperStore):
        """A store that says what is fetched."""

        async def get(self, key: str, *rest: Any, **named: Any) -> Any:
            read.append(key)
            return await super().get(key, *rest, **named)

    sv.from_zarr(zarr.open_group(Remote(inner), mode="r"), time=2, level=1)
    chunks = [key for key in read if "/c/" in key]
    assert chunks and all(key.startswith("s1/c/2/") for key in chunks), chunks


def test_groups_that_are_no_images_say_what_is_there(ball: np.ndarray) -> None:
    plain = zarr.create_group(zarr.storage.MemoryStore())
    plain.create_array("density", data=ball)
    with pytest.raises(sv.InvalidValue, match="density"):
        sv.render(plain)
    np.testing.assert_array_equal(np.asarray(sv.from_zarr(plain["density"])), ball)
    spiral = image(zarr.storage.MemoryStore(), ball[None], 2, "tzyx")
    scales = spiral.attrs["multiscales"]
    scales[0]["axes"][0] = {"name": "angle", "type": "angle"}
    spiral.attrs["multiscales"] = scales
    assert sv.from_zarr(spiral).shape == ball.shape
    scales[0]["coordinateTransformations"] = [{"type": "rotation"}]
    spiral.attrs["multiscales"] = scales
    with pytest.raises(sv.InvalidValue, match="rotation"):
        sv.from_zarr(spiral)


def test_dask_levels_and_thinning(ball: np.ndarray) -> None:
    dask = pytest.importorskip("dask.array")
    levels = [dask.from_array(np.ascontiguousarray(ball[:: 2**k, :: 2**k, :: 2**k]), chunks=8) for k in range(3)]
    volume = sv.Volume.from_dask(levels, spacing={"z": 3}, max_bytes=ball.nbytes // 2)
    assert volume.shape == (10, 12, 14) and volume.spacing == (6, 2, 2)
    assert sv.from_dask(levels).shape == ball.shape
    frame = sv.render(levels, size=48, level=1)
    np.testing.assert_array_equal(np.asarray(frame), np.asarray(sv.from_dask(levels, level=1).render(size=48)))
    thin = sv.from_dask(levels[0], level=1)
    np.testing.assert_array_equal(np.asarray(thin), ball[::2, ::2, ::2])
    first = sv.Volume(ball).affine[:3, 3]
    assert thin.spacing == (2, 2, 2) and np.array_equal(thin.affine[:3, 3], first)
    with pytest.raises(sv.LimitError, match="level=2"):
        sv.from_dask(levels[0], level=1, max_bytes=ball.nbytes // 20)
    with pytest.raises(sv.InvalidValue, match="axes"):
        sv.from_dask(dask.zeros((2, 3, 4, 5)))


def test_dask_refuses_before_it_computes() -> None:
    dask = pytest.importorskip("dask.array")

    def fail(block: np.ndarray) -> np.ndarray:
        raise AssertionError("computed")

    huge = dask.zeros((4096, 4096, 4096), dtype="u1", chunks=512).map_blocks(fail, dtype="u1", meta=np.zeros(0, "u1"))
    with pytest.raises(sv.LimitError, match="level=2"):
        sv.from_dask(huge, max_bytes=1 << 31)
