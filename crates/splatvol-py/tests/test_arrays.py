"""Arrays as volumes: axes, types, memory, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import splatvol as sv


def pixels(data: Any, **options: Any) -> np.ndarray:
    return np.asarray(sv.render(data, size=48, **options))


def test_memory_is_shared_where_it_can_be(ball: np.ndarray) -> None:
    assert sv.Volume(ball).is_shared
    assert sv.Volume(np.asfortranarray(ball.transpose(2, 1, 0)), axes="xyz").is_shared
    assert not sv.Volume(ball, copy=True).is_shared
    assert not sv.Volume(ball[:, ::-1]).is_shared
    with pytest.raises(sv.InvalidValue, match="copy=False"):
        sv.Volume(ball[:, ::-1], copy=False)


def test_axes_are_named_and_never_guessed(ball: np.ndarray) -> None:
    expected = pixels(sv.Volume(ball, spacing=(3, 2, 1)))
    for axes in ("zyx", "xyz", "yxz"):
        turned = ball.transpose(["zyx".index(axis) for axis in axes])
        spacing = [{"z": 3, "y": 2, "x": 1}[axis] for axis in axes]
        volume = sv.Volume(turned, axes=axes, spacing=spacing)
        assert volume.shape == ball.shape and volume.spacing == (3, 2, 1)
        np.testing.assert_array_equal(pixels(volume), expected)
    np.testing.assert_array_equal(pixels(sv.Volume(ball, spacing={"z": 3, "y": 2})), expected)
    for wrong in ("zy", "abc", "zyxc"):
        with pytest.raises(sv.InvalidValue, match="axes="):
            sv.Volume(ball, axes=wrong)


@pytest.mark.parametrize("dtype", ["u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8", "f2", "i8", "u8", ">f4", ">u2", "?"])
def test_types(ball: np.ndarray, dtype: str) -> None:
    scaled = ball * (1 if np.dtype(dtype).kind in "fb" else 100)
    array = (scaled > 0.5) if dtype == "?" else scaled.astype(dtype)
    volume = sv.Volume(array)
    np.testing.assert_array_equal(np.asarray(volume), array)
    expected = sv.Volume(array.astype(volume.dtype))
    np.testing.assert_array_equal(pixels(volume), pixels(expected))


def test_strides_orders_and_read_only_memory(ball: np.ndarray) -> None:
    expected = pixels(ball)
    frozen = ball.copy()
    frozen.flags.writeable = False
    odd = np.zeros(np.array(ball.shape) * 2, np.float32)[::2, ::2, ::2]
    odd[...] = ball
    for array in (np.asfortranarray(ball), frozen, odd, ball[::-1][::-1], np.flip(np.flip(ball).copy())):
        np.testing.assert_array_equal(pixels(array), expected)


def test_missing_samples(ball: np.ndarray) -> None:
    holes = ball.copy()
    holes[5:9, 5:9, 5:9] = np.nan
    masked = np.ma.masked_array(ball, np.isnan(holes))
    np.testing.assert_array_equal(pixels(masked), pixels(holes))
    whole = np.ma.masked_array((ball * 200).astype(np.uint8), np.isnan(holes))
    assert sv.Volume(whole).dtype == np.float32
    assert np.isnan(np.asarray(sv.Volume(whole))).sum() == 64


class OnGpu:
    """As a tensor of torch on a GPU presents itself."""

    class device:
        type = "cuda"

        def __str__(self) -> str:
            return "cuda:0"

    device = device()  # type: ignore[assignment]

    def __array__(self) -> None:
        raise RuntimeError("cannot convert")


class Cupy:
    __cuda_array_interface__: dict[str, int] = {}


@pytest.mark.parametrize(
    ("wrong", "error", "says"),
    [
        (np.zeros((3, 3)), ValueError, "names 3 axes, and the array has 2"),
        (np.zeros((2, 3, 3, 3)), ValueError, "choose one"),
        (np.zeros(5), ValueError, "axes"),
        (np.array(1.0), ValueError, "axes"),
        (np.zeros((0, 3, 3)), ValueError, "no samples"),
        (np.full((3, 3, 3), np.nan), ValueError, "no finite sample"),
        (np.full((3, 3, 3), np.inf), ValueError, "no finite sample"),
        (np.zeros((3, 3, 3), complex), TypeError, "np.abs"),
        (np.zeros((3, 3, 3), object), TypeError, "astype"),
        (np.zeros((3, 3, 3), "S4"), TypeError, "astype"),
        (np.zeros((3, 3, 3), "U4"), TypeError, "astype"),
        (np.zeros((3, 3, 3), "M8[s]"), TypeError, "times"),
        (np.zeros((3, 3, 3), "m8[s]"), TypeError, "times"),
        (np.zeros((3, 3, 3), [("a", "f4"), ("b", "f4")]), TypeError, "a, b"),
        ([[[1.0]]], TypeError, "np.array"),
        ((1, 2, 3), TypeError, "np.array"),
        (None, TypeError, "expected an array"),
        (3.5, TypeError, "expected an array"),
        ({"a": 1}, TypeError, "expected an array"),
        (OnGpu(), TypeError, ".cpu()"),
        (Cupy(), TypeError, "asnumpy"),
        ("no-such-file.nrrd", FileNotFoundError, "no-such-file"),
    ],
)
def test_wrong_arrays_are_refused_with_what_to_write(wrong: object, error: type[Exception], says: str) -> None:
    with pytest.raises(error) as raised:
        sv.Volume(wrong) if isinstance(wrong, (OnGpu, Cupy)) else sv.render(wrong, size=8)
    assert says in str(raised.value)


def test_one_voxel_and_flat_arrays() -> None:
    for shape in ((1, 1, 1), (1, 5, 7), (4, 1, 1)):
        array = np.arange(np.prod(shape), dtype=np.float32).reshape(shape) + 1
        assert pixels(array).shape == (48, 48, 4)


def test_placement(ball: np.ndarray) -> None:
    affine = np.diag([2.0, 3.0, 4.0, 1.0])
    affine[:3, 3] = (10, 20, 30)
    volume = sv.Volume(ball, axes="zyx", affine=affine[:, [2, 1, 0, 3]])
    np.testing.assert_array_equal(volume.affine, affine)
    assert volume.spacing == (4, 3, 2)
    with pytest.raises(sv.InvalidValue, match="spacing and origin already"):
        sv.Volume(ball, affine=affine, spacing=2)
    with pytest.raises(sv.InvalidValue, match="shape"):
        sv.Volume(ball, affine=np.eye(3))
    with pytest.raises(sv.InvalidValue, match="unit"):
        sv.Volume(ball, unit="parsec")
    assert sv.Volume(ball, unit="um").unit == "um"


def test_what_a_volume_says(ball: np.ndarray) -> None:
    volume = sv.Volume(ball, name="ball")
    assert volume.name == "ball" and volume.source is None and volume.nbytes == ball.nbytes
    assert "z 20 y 24 x 28" in repr(volume)
    counts, edges = volume.histogram(10)
    np.testing.assert_array_equal(counts, np.histogram(ball, 10)[0])
    assert edges[0] == ball.min() and edges[-1] == ball.max()


@pytest.mark.parametrize("dtype", ["f2", "i8", ">f4"])
def test_copies_are_not_touched(ball: np.ndarray, dtype: str) -> None:
    volume = sv.Volume((ball * 100).astype(dtype))
    assert not volume.is_shared
    with pytest.raises(sv.InvalidValue, match="copy"):
        volume.touch()


def test_odd_addresses_are_copied(ball: np.ndarray, tmp_path: Path) -> None:
    (tmp_path / "odd.raw").write_bytes(b"x" + ball.tobytes())
    odd: Any = np.memmap(tmp_path / "odd.raw", np.float32, "r", offset=1, shape=ball.shape)
    assert not odd.flags.aligned and not sv.Volume(odd).is_shared
    np.testing.assert_array_equal(pixels(odd), pixels(ball))
    with pytest.raises(sv.InvalidValue, match="aligned"):
        sv.Volume(odd, copy=False)


def test_tensors_are_shared(ball: np.ndarray) -> None:
    class Tensor:
        """As a tensor of torch on the CPU presents itself."""

        def __init__(self, array: np.ndarray) -> None:
            self.array = array

        def detach(self) -> np.ndarray:
            return self.array

        def __dlpack__(self) -> None: ...

    assert sv.Volume(Tensor(ball), copy=False).is_shared
