"""Arrays of zarr, and OME-Zarr images: groups with `multiscales`, of every version, in any store."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .._data import Volume
from .._errors import DataWarning, InvalidValue
from ._levels import choose_level
from ._units import unit_of


def from_zarr(
    node: Any,
    *,
    level: int | str | None = "auto",
    channel: int | None = None,
    time: int | None = None,
    max_bytes: int | None = None,
) -> Volume:
    """A volume of one of zarr's arrays, or of a group that is an OME-Zarr image.

    Parameters
    ----------
    node : zarr.Array or zarr.Group
        In a folder, in memory, or remote: only the chunks of what is chosen are read.
    level : int or "auto"
        Level of a group, 0 the finest; by default the finest one of at most `max_bytes`.
    channel, time : int, optional
        Which ones, of axes c and t: 0 by default.
    max_bytes : int, optional
        Most bytes of samples, 4 GiB by default.

    Examples
    --------
    >>> import numpy as np, splatvol as sv, zarr
    >>> group = zarr.group(attributes={"multiscales": [{"datasets": [{"path": "0"}, {"path": "1"}]}]})
    >>> for level, n in enumerate((16, 8)):
    ...     group[str(level)] = np.zeros((n, n, n), np.uint8)
    >>> sv.from_zarr(group, max_bytes=1000).shape
    (8, 8, 8)
    """
    if hasattr(node, "ndim"):
        array, scales, image = node, Transform(), Image()
        choose_level([node.shape], node.dtype.itemsize, "auto" if level in (None, 0) else level, max_bytes)
    else:
        image = _image_of(node)
        arrays = [node[path] for path in image.paths]
        shapes = [[array.shape[i] for i in _spatial(image.axes_of(array.ndim))] for array in arrays]
        chosen = choose_level(shapes, arrays[0].dtype.itemsize, level, max_bytes)
        array, scales = arrays[chosen], image.transforms[chosen]
    axes = image.axes_of(array.ndim)
    spatial = _spatial(axes)
    place = _place(array.shape, axes, image, {"c": channel, "t": time})
    samples = np.asarray(array[place]).reshape((1,) * (3 - len(spatial)) + tuple(array.shape[i] for i in spatial))
    name = str(getattr(node, "name", "") or "").strip("/").rpartition("/")[2] or None
    if not scales.scale:
        return Volume(samples, name=name)
    affine = _affine(axes, spatial, scales)
    return Volume(samples, axes="zyx", affine=affine, unit=_unit(axes, spatial), name=name, oriented=False)


@dataclass(frozen=True)
class Axis:
    """An axis as OME names it."""

    name: str
    kind: str = ""
    unit: str = ""

    @property
    def letter(self) -> str:
        """S for space, t for time, c for channels; empty for others."""
        if self.kind == "space" or (not self.kind and self.name in ("x", "y", "z")):
            return "s"
        return {"time": "t", "channel": "c"}.get(self.kind) or {"t": "t", "c": "c"}.get(self.name, "")


@dataclass(frozen=True)
class Transform:
    """``scale * index + translation``; what is missing at the end is 1 and 0."""

    scale: tuple[float, ...] = ()
    translation: tuple[float, ...] = ()

    def at(self, axis: int) -> tuple[float, float]:
        """Scale and translation along an axis."""
        scale = self.scale[axis] if axis < len(self.scale) else 1.0
        return scale, self.translation[axis] if axis < len(self.translation) else 0.0

    def then(self, after: Transform) -> Transform:
        """The map that another one follows."""
        count = max(map(len, (self.scale, self.translation, after.scale, after.translation)))
        ours, theirs = [self.at(i) for i in range(count)], [after.at(i) for i in range(count)]
        return Transform(
            tuple(a[0] * b[0] for a, b in zip(ours, theirs, strict=True)),
            tuple(a[1] * b[0] + b[1] for a, b in zip(ours, theirs, strict=True)),
        )


@dataclass(frozen=True)
class Image:
    """The metadata of a multi-scale image."""

    axes: tuple[Axis, ...] = ()
    paths: tuple[str, ...] = ()
    transforms: tuple[Transform, ...] = ()
    channels: tuple[str, ...] = ()

    def axes_of(self, count: int) -> tuple[Axis, ...]:
        """The axes; without names the last of time, channel, z, y, x."""
        if len(self.axes) == count:
            return self.axes
        return tuple(Axis(name) for name in ["?"] * max(count - 5, 0) + list("tczyx")[-count:])


def _image_of(group: Any) -> Image:
    attributes: Mapping[str, Any] = dict(group.attrs)
    attributes = attributes.get("ome", attributes)
    images = attributes.get("multiscales") or []
    if not images:
        inside = ", ".join(map(str, group.keys())) or "nothing"
        message = f"the zarr group is no OME-Zarr image, it has no multiscales: write group[...] (there is {inside})"
        raise InvalidValue(message, field="multiscales")
    if len(images) > 1:
        warnings.warn(f"the first of {len(images)} multi-scale images is read", DataWarning, stacklevel=5)
    first = images[0]
    axes = tuple(
        Axis(axis) if isinstance(axis, str) else Axis(axis["name"], axis.get("type", ""), axis.get("unit", ""))
        for axis in first.get("axes", [])
    )
    outer = _transform(first.get("coordinateTransformations"))
    levels = first.get("datasets", [])
    if not levels:
        raise InvalidValue("multiscales: it has no datasets", field="multiscales")
    channels = attributes.get("omero", {}).get("channels", [])
    return Image(
        axes,
        tuple(str(level["path"]) for level in levels),
        tuple(_transform(level.get("coordinateTransformations")).then(outer) for level in levels),
        tuple(str(channel.get("label", "")) for channel in channels),
    )


def _transform(steps: Any) -> Transform:
    whole = Transform()
    for step in steps or []:
        kind = step.get("type")
        if kind not in ("scale", "translation", "identity") or (kind != "identity" and kind not in step):
            message = f"coordinateTransformations: {step!r} is not supported, scale and translation are"
            raise InvalidValue(message, field="coordinateTransformations", value=repr(step))
        if kind != "identity":
            whole = whole.then(Transform(**{kind: tuple(float(number) for number in step[kind])}))
    return whole


def _spatial(axes: tuple[Axis, ...]) -> list[int]:
    spatial = [i for i, axis in enumerate(axes) if axis.letter == "s"]
    if not 1 <= len(spatial) <= 3:
        names = ", ".join(axis.name for axis in axes)
        raise InvalidValue(f"{len(spatial)} axes of space among {names}: 1 to 3 are read", field="axes", value=names)
    return spatial


def _place(
    shape: tuple[int, ...], axes: tuple[Axis, ...], image: Image, asked: Mapping[str, int | None]
) -> tuple[int | slice, ...]:
    """What is read of each axis: all of space, one channel, one time."""
    place: list[int | slice] = []
    for axis, size in zip(axes, shape, strict=True):
        letter = axis.letter
        if letter == "s":
            place.append(slice(None))
        elif letter:
            place.append(_chosen(letter, size, image.channels, asked[letter]))
        elif size == 1:
            place.append(0)
        else:
            message = f"axis {axis.name!r} of {size} places is neither space, time nor channel: write group[...][i]"
            raise InvalidValue(message, field="axes", value=axis.name)
    return tuple(place)


def _chosen(letter: str, size: int, names: tuple[str, ...], asked: int | None) -> int:
    field = {"c": "channel", "t": "time"}[letter]
    spelt = ", ".join(f"{i}: {name or f'channel {i}'}" for i, name in enumerate(names[:size]))
    if asked is not None and not 0 <= asked < size:
        message = f"{field}: {asked} is not there, there are {size}" + (f" ({spelt})" if letter == "c" else "")
        raise InvalidValue(message, field=field, value=str(asked))
    if asked is None and size > 1:
        listed = f" ({spelt})" if letter == "c" and spelt else ""
        warnings.warn(f"{field} 0 of {size} is read: write {field}={listed}", DataWarning, stacklevel=5)
    return asked or 0


def _affine(axes: tuple[Axis, ...], spatial: list[int], scales: Transform) -> npt.NDArray[np.float64]:
    """World from index z, y, x: an axis goes along the direction that its name says."""
    columns = np.eye(3)
    free, origin = [0, 1, 2], np.zeros(3)
    for voxel, axis in enumerate(reversed(spatial)):
        direction = "xyz".find(axes[axis].name) if axes[axis].name in ("x", "y", "z") else voxel
        scale, translation = scales.at(axis)
        columns[:, voxel] = np.eye(3)[direction] * scale
        origin[direction] += translation
        free = [other for other in free if other != direction]
    # Flat axes take the remaining directions and the first axis's spacing.
    for voxel, direction in zip(range(len(spatial), 3), free, strict=False):
        columns[:, voxel] = np.eye(3)[direction] * np.linalg.norm(columns[:, 0])
    affine = np.eye(4)
    affine[:3] = np.column_stack([columns[:, ::-1], origin])
    return affine


def _unit(axes: tuple[Axis, ...], spatial: list[int]) -> str | None:
    names = [axes[i].unit for i in spatial]
    unit = unit_of(names[0]) if len(set(names)) == 1 else None
    if unit is None and any(names):
        warnings.warn(f"units are not kept: {', '.join(names)}", DataWarning, stacklevel=5)
    return unit
