"""Layers of napari as data: which samples are shown now, and where they lie.

Arrays are chosen on the thread of the caller, and read (from disk, where they are lazy) only when a volume is made.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from .._data import Volume
from .._errors import InvalidValue

Floats = npt.NDArray[np.float64]

#: Bytes of a layer beyond which a coarser level is taken, where there is one.
MAX_BYTES = 1 << 30
#: Pint's names of the lengths that have a name here.
LENGTHS = {"meter": "m", "millimeter": "mm", "micrometer": "um", "micron": "um", "nanometer": "nm"}


@dataclass(frozen=True)
class Space:
    """How napari's world becomes splatvol's: x, y, z are the last three of its displayed axes, backwards.

    napari shows the axes of its world in either handedness; a camera here has one only. Where the viewer shows x, y,
    z mirrored, which is its default, y is negated.
    """

    displayed: tuple[int, ...]
    point: tuple[float, ...]
    units: tuple[str, ...] = ()
    mirrored: bool = False

    @property
    def rows(self) -> Floats:
        """3x3: x, y, z from the displayed axes."""
        rows = np.eye(3)[::-1].copy()
        if self.mirrored:
            rows[1] *= -1.0
        return rows

    @property
    def unit(self) -> str | None:
        """The unit of lengths, where it is the same for all displayed axes and has a name here."""
        shown = {LENGTHS.get(self.units[axis]) for axis in self.displayed} if self.units else set()
        return shown.pop() if len(shown) == 1 else None


@dataclass(frozen=True, eq=False)
class Part:
    """The part of a layer that is shown: an array, which may be lazy, an index into it, and where that lies."""

    name: str
    array: Any
    index: tuple[Any, ...]
    order: tuple[int, ...]
    affine: Floats = field(repr=False)
    unit: str | None

    @property
    def key(self) -> tuple[Any, ...]:
        """Equal for parts that make the same volume; the array is the same object, which the one who keeps it holds."""
        return id(self.array), str(self.index), self.order, self.affine.tobytes(), self.unit

    def volume(self) -> Volume:
        """The volume; samples that are an array already are shared."""
        samples = np.asarray(self.array[self.index]).transpose(self.order)
        return Volume(samples, axes="zyx", affine=self.affine, unit=self.unit, name=self.name)


def from_napari(layer: Any, *, max_bytes: int = MAX_BYTES) -> Volume:
    """A volume of one of napari's image or labels layers, its last three axes as z, y, x, with its place.

    Parameters
    ----------
    layer : napari.layers.Image or Labels
        Of axes before the last three, the first index is taken: slice the data for another one.
    max_bytes : int
        Of a multiscale layer the finest level is taken that has at most so many bytes.
    """
    kind = kind_of(layer)
    if kind == "viewer":
        raise TypeError("a viewer of napari is no data: write Scene.from_napari(viewer), or render(viewer)")
    if kind not in ("image", "labels"):
        raise TypeError(f"a {type(layer).__name__} layer of napari is no volume: expected Image or Labels")
    if layer.ndim < 3:
        message = f"{layer.name}: the layer has {layer.ndim} axes, a volume has three"
        raise InvalidValue(message, field="data", value=layer.name)
    first = layer.data_to_world((0.0,) * layer.ndim)
    axes = tuple(range(layer.ndim - 3, layer.ndim))
    space = Space(axes, tuple(float(place) for place in first), units_of(layer))
    volume = part_of(layer, space, max_bytes).volume()
    if kind == "labels":
        volume._keys["labels"] = True
    return volume


def kind_of(thing: Any) -> str:
    """``"image"``, ``"labels"``, ``"points"``... of a layer; ``"viewer"``."""
    if hasattr(thing, "layers") and hasattr(thing, "dims"):
        return "viewer"
    # Plugins get napari's objects in a wrapping that tells its class, but not its private names.
    names: list[str] = [kind.__name__.lower() for kind in thing.__class__.__mro__]
    return next((name for name in names if name in ("image", "labels", "points")), names[0])


def units_of(layer: Any) -> tuple[str, ...]:
    """Names of the units of a layer's axes, or none where this napari has no units."""
    return tuple(str(unit) for unit in getattr(layer, "units", None) or ())


def placed(layer: Any, space: Space) -> tuple[tuple[int, ...], Floats]:
    """The layer's axes that are displayed, in the order of the display, and 4x4: x, y, z from indices along them."""
    missing = len(space.point) - layer.ndim
    axes = tuple(axis - missing for axis in space.displayed)
    if min(axes) < 0:
        message = f"layer {layer.name!r} has {layer.ndim} axes, and does not lie along all of the three that are shown"
        raise InvalidValue(message, field="layer", value=layer.name)
    linear, offset = _world_from_data(layer, space)
    affine = np.eye(4)
    affine[:3, :3] = space.rows @ linear[np.ix_(axes, axes)]
    affine[:3, 3] = space.rows @ offset[list(axes)]
    return axes, affine


def _world_from_data(layer: Any, space: Space) -> tuple[Floats, Floats]:
    """World of the viewer from data of the layer, a matrix and a shift."""
    origin = np.asarray(layer.data_to_world(np.zeros(layer.ndim)), dtype=float)
    columns = [np.asarray(layer.data_to_world(row), dtype=float) - origin for row in np.eye(layer.ndim)]
    factors = _factors(layer, space)
    return np.stack(columns, axis=1) * factors[:, None], origin * factors


def _factors(layer: Any, space: Space) -> Floats:
    """Lengths of the viewer's units in the layer's, by axis: napari shows layers of different units to scale."""
    own, others = units_of(layer), space.units[-layer.ndim :]
    if not own or own == others or len(own) != len(others):
        return np.ones(layer.ndim)
    import pint

    registry: Any = pint.get_application_registry()
    return np.array([float(registry(a).to(b).magnitude) for a, b in zip(own, others, strict=True)])


def part_of(layer: Any, space: Space, max_bytes: int = MAX_BYTES) -> Part:
    """What is shown of an image or labels layer."""
    if getattr(layer, "rgb", False):
        message = f"layer {layer.name!r} has colours for values: split it into channels (Layer > Split RGB)"
        raise InvalidValue(message, field="rgb", value=layer.name)
    axes, affine = placed(layer, space)
    levels = list(layer.data) if layer.multiscale else [layer.data]
    sizes = [math.prod(level.shape[axis] for axis in axes) * level.dtype.itemsize for level in levels]
    number = next((i for i, size in enumerate(sizes) if size <= max_bytes), len(levels) - 1)
    level = levels[number]
    if sizes[number] > max_bytes:
        message = (
            f"layer {layer.name!r} has {sizes[number]} bytes, more than max_bytes={max_bytes}, and no coarser level"
        )
        raise InvalidValue(message, field="max_bytes", value=str(max_bytes))
    steps = np.array(levels[0].shape[: layer.ndim]) / np.array(level.shape[: layer.ndim])
    place = np.asarray(space.point[-layer.ndim :]) / _factors(layer, space)
    spot = np.asarray(layer.world_to_data(place), dtype=float)
    index: list[Any] = [slice(None)] * layer.ndim
    for axis in set(range(layer.ndim)) - set(axes):
        index[axis] = round(float(np.clip(round(float(spot[axis])) / steps[axis], 0, level.shape[axis] - 1)))
    shown = steps[list(axes)]
    # A voxel of a coarser level lies in the middle of those of which it was made.
    affine[:3, 3] += affine[:3, :3] @ ((shown - 1.0) / 2.0)
    affine[:3, :3] *= shown
    order = tuple(sorted(axes).index(axis) for axis in axes)
    return Part(str(layer.name), level, tuple(index), order, affine, space.unit)
