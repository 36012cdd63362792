"""What the manifest of the plugin names: readers and samples. Both give layers as napari's tuples."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .._data import Volume
from .._errors import DataWarning, SplatvolError
from .._verbs import read

#: Values, keywords, and kind of a layer.
LayerData = tuple[Any, dict[str, Any], str]
#: Samples along an axis of the built-in volumes.
SAMPLE = 128
#: napari's colour maps of channels, in the order in which it gives them.
COLORS = ("cyan", "yellow", "magenta", "red", "green", "blue")
#: Order of axes reversed: an affine map of x y z becomes one of z y x.
REVERSED = np.array([2, 1, 0, 3])


def reader_of(path: str | Sequence[str]) -> Callable[[Any], list[LayerData]] | None:
    """A function that reads the path, or `None` where it is no volume that splatvol reads.

    Folders are looked into, because only their contents say whether they are series of DICOM slices or OME-Zarr.
    """
    paths = [path] if isinstance(path, (str, os.PathLike)) else list(path)
    if not paths:
        return None
    if any(os.path.isdir(one) for one in paths):
        try:
            found = [layer for one in paths for layer in _layers(one)]
        except (SplatvolError, OSError):
            return None
        return lambda _: found
    return lambda _: [layer for one in paths for layer in _layers(one)]


def _layers(path: str) -> list[LayerData]:
    """The layers of a file or folder: one, or one for each channel."""
    with warnings.catch_warnings():
        # That there are other channels is no news where all are read.
        warnings.filterwarnings("ignore", ".*channel 0 is read", DataWarning)
        first = _volume(path)
    channels = first._describe()["channels"]
    if len(channels) < 2:
        return [layer_data(first)]
    rest = [_volume(path, channel=number) for number in range(1, len(channels))]
    layers = []
    for number, volume in enumerate([first, *rest]):
        values, keywords, kind = layer_data(volume)
        color = COLORS[number % len(COLORS)]
        named = {"name": f"{keywords['name']} {channels[number]}", "colormap": color, "blending": "additive"}
        layers.append((values, {**keywords, **named}, kind))
    return layers


def _volume(path: str, **options: Any) -> Volume:
    data = read(path, **options)
    if not isinstance(data, Volume):
        raise SplatvolError(f"{path}: it holds {data.kind}, no volume")
    return data


def layer_data(volume: Volume) -> LayerData:
    """A volume as an image layer: values, and where they lie in napari's world, z y x."""
    affine = volume.affine[np.ix_(REVERSED, REVERSED)]
    linear, offset = affine[:3, :3], affine[:3, 3]
    steps = np.diag(linear)
    keywords: dict[str, Any] = {"name": _title(volume)}
    if np.array_equal(linear, np.diag(steps)) and (steps > 0).all():
        keywords |= {"scale": steps.tolist(), "translate": offset.tolist()}
    else:
        keywords["affine"] = affine
    if volume.unit:
        keywords["units"] = [volume.unit] * 3
    low, high = volume.range
    if low < high:
        keywords["contrast_limits"] = (low, high)
    return values_of(volume), keywords, "image"


def _title(volume: Volume) -> str:
    """The file's name without its endings."""
    name = volume.name or "volume"
    stem = os.path.splitext(name.removesuffix(".gz"))[0].removesuffix(".ome")
    return stem or name


def values_of(volume: Volume) -> npt.NDArray[Any]:
    """The values, z y x: rescaled samples, in whole numbers where they are whole."""
    samples = np.asarray(volume)
    slope, intercept = volume._describe()["rescale"]
    if (slope, intercept) == (1.0, 0.0):
        return samples
    if samples.dtype.kind in "iu" and float(slope).is_integer() and float(intercept).is_integer():
        low, high = volume.range
        fitting = np.result_type(np.min_scalar_type(int(low)), np.min_scalar_type(int(high)))
        wide = samples.astype(np.int64) * int(slope) + int(intercept)
        return wide.astype(fitting)
    return samples.astype(np.float32) * np.float32(slope) + np.float32(intercept)


def _sample(name: str) -> list[LayerData]:
    volume = _volume(f"sample:{name}:{SAMPLE}")
    values, keywords, kind = layer_data(volume)
    return [(values, {**keywords, "name": name}, kind)]


def head() -> list[LayerData]:
    """The head phantom."""
    return _sample("head")


def tomato() -> list[LayerData]:
    """The tomato."""
    return _sample("tomato")


def nerve() -> list[LayerData]:
    """The nerve cell, in voxels that are five times as deep as wide."""
    return _sample("nerve")


def microtubules() -> list[LayerData]:
    """The microtubules."""
    return _sample("microtubules")
