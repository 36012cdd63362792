"""Appearance: transfer functions, light, clips."""

from __future__ import annotations

import copy
import json
import os
import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import _checks, _core
from ._errors import DataWarning, InvalidValue
from ._vocabulary import plain

#: Points of a colour map that is sampled.
COLORS = 64
#: What limits are.
CLIM = "two finite numbers, (low, high)"


def _rgb(color: Any) -> list[float]:
    """SRGB of a colour: three numbers from 0 to 1, ``#rrggbb``, or one of matplotlib's names."""
    if isinstance(color, str):
        if re.fullmatch("#(?:[0-9a-fA-F]{3}){1,2}", color):
            text = color[1:]
            step = len(text) // 3
            return [int(text[i : i + step] * (3 - step), 16) / 255 for i in range(0, len(text), step)]
        try:
            from matplotlib.colors import to_rgb
        except ImportError:
            message = f"color: {color!r} is not #rrggbb, and matplotlib, which knows names, is not installed"
            raise InvalidValue(message, field="color", value=color) from None
        try:
            return [float(c) for c in to_rgb(color)]
        except ValueError as error:
            raise InvalidValue(f"color: {error}", field="color", value=color) from None
    try:
        numbers = [float(c) for c in color]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) not in (3, 4) or not all(0 <= c <= 1 for c in numbers):
        raise InvalidValue(f"color: {color!r} is not three numbers from 0 to 1", field="color", value=repr(color))
    return numbers[:3]


@dataclass(frozen=True)
class TransferFunction:
    """Colour and opacity of values.

    Parameters
    ----------
    colors : sequence of (value, color)
        Colours: three numbers from 0 to 1 (sRGB), ``"#rrggbb"``, or matplotlib's names.
    opacities : sequence of (value, opacity)
        Opacity, from 0 to 1, of material that is `unit_distance` thick.
    unit_distance : float, optional
        World length to which opacities refer, above 0; by default a voxel.

    Raises
    ------
    InvalidValue
        No points, a number that is not finite, or one outside its range.

    Examples
    --------
    >>> import splatvol as sv
    >>> tf = sv.TransferFunction([(0, "#000000"), (1, "#ffffff")], [(0.2, 0), (1, 0.8)])
    >>> sv.render("sample:head:16", tf=tf, size=32).size
    (32, 32)
    """

    colors: Sequence[tuple[float, Any]]
    opacities: Sequence[tuple[float, float]]
    unit_distance: float | None = None

    def __post_init__(self) -> None:
        pairs = _pairs(self.colors, "colors", "pairs of a value and a colour")
        colors = tuple((_checks.number(value, "colors"), tuple(_rgb(color))) for value, color in pairs)
        object.__setattr__(self, "colors", colors)
        object.__setattr__(self, "opacities", _opacities(self.opacities, "opacities"))
        if self.unit_distance is not None:
            object.__setattr__(self, "unit_distance", _checks.positive(self.unit_distance, "unit_distance"))

    @classmethod
    def from_cmap(
        cls,
        cmap: Any,
        clim: tuple[float, float],
        opacity: str | Sequence[tuple[float, float]] = "linear",
        *,
        norm: Any = None,
        unit_distance: float | None = None,
    ) -> TransferFunction:
        """A colour map over a range of values.

        `cmap` is a name of splatvol's or of matplotlib's, or one of matplotlib's colour maps. `norm` is one of
        matplotlib's norms or the name of one, by which values become places in the map; `clim` has the limits that it
        lacks itself, and one with a centre reaches to the farther of them on either side. `opacity` is ``"linear"``
        along the map, or points of value and opacity.

        Raises
        ------
        InvalidValue
            A norm that cannot be inverted, such as ``BoundaryNorm``, or has no places for the limits, such as
            ``LogNorm`` for 0.
        """
        shares = np.linspace(0.0, 1.0, COLORS)
        values = _values_at(shares, _checks.pair(clim, "clim", CLIM), norm)
        colors = _map_colors(cmap, shares)
        if isinstance(opacity, str):
            if opacity != "linear":
                message = f"opacity: {opacity!r} is not known beside a colour map of matplotlib's (linear, or points)"
                raise InvalidValue(message, field="opacity", value=opacity)
            opacities: Any = list(zip(values, shares, strict=True))
        else:
            opacities = _opacities(opacity, "opacity")
        return cls(list(zip(values, colors, strict=True)), opacities, unit_distance)

    @classmethod
    def load(cls, path: str | os.PathLike[str], clim: tuple[float, float] = (0.0, 1.0)) -> TransferFunction:
        """The transfer function of a file of 3D Slicer, ParaView, Inviwo or ImageJ.

        `clim` is the range of values that files without values of their own are for.
        """
        text, notes = _core.read_transfer_function(os.fspath(path), clim)
        for note in notes:
            warnings.warn(f"{os.fspath(path)}: {note}", DataWarning, stacklevel=2)
        return cls._of_document(json.loads(text))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the transfer function: ``.vp.json`` for 3D Slicer, ``.json`` for ParaView."""
        _core.write_transfer_function(os.fspath(path), json.dumps(self._document()))

    def _document(self) -> dict[str, Any]:
        return {
            "colors": [{"value": value, "rgb": list(rgb)} for value, rgb in self.colors],
            "opacities": [{"value": value, "opacity": opacity} for value, opacity in self.opacities],
            "unit_distance": self.unit_distance,
        }

    @classmethod
    def _of_document(cls, keys: dict[str, Any]) -> TransferFunction:
        colors = [(point["value"], point["rgb"]) for point in keys["colors"]]
        opacities = [(point["value"], point["opacity"]) for point in keys["opacities"]]
        return cls(colors, opacities, keys.get("unit_distance"))


def _values_at(shares: Any, clim: tuple[float, float], norm: Any) -> list[float]:
    """Values at the shares of a colour map."""
    if norm is None:
        low, high = clim
        return [float(low + (high - low) * share) for share in shares]
    scale = _with_limits(norm_of(norm), clim)
    what = f"norm: {type(scale).__name__} from {scale.vmin:g} to {scale.vmax:g}"
    try:
        values = np.asarray(scale.inverse(shares), dtype=float)
    except (TypeError, ValueError) as error:
        raise InvalidValue(f"{what}: {error}", field="norm", value=repr(norm)) from None
    span = scale.vmax - scale.vmin
    ends = np.allclose(values[[0, -1]], (scale.vmin, scale.vmax), rtol=1e-6, atol=1e-6 * abs(span))
    if not ends or not (np.diff(values) >= -1e-6 * span).all():
        raise InvalidValue(f"{what} does not increase from one to the other", field="norm", value=repr(norm))
    return [float(value) for value in np.maximum.accumulate(values)]


def norm_of(norm: Any) -> Any:
    """One of matplotlib's norms, which may be given by its name.

    Raises
    ------
    InvalidValue
        What is none.
    """
    if isinstance(norm, str):
        try:
            from matplotlib.cm import ScalarMappable

            of_name: Any = ScalarMappable
            return of_name(norm=norm).norm
        except (ImportError, ValueError) as error:
            raise InvalidValue(f"norm: {norm!r}: {error}", field="norm", value=norm) from None
    if not callable(getattr(norm, "inverse", None)) or not hasattr(norm, "vmin") or not hasattr(norm, "vmax"):
        raise _checks.refused("norm", norm, "one of matplotlib's norms, or the name of one")
    return norm


def without_limits(norm: Any, ends: set[str]) -> Any:
    """A copy of a norm that lacks its limits, or one of them: ``"vmin"`` and ``"vmax"``."""
    if isinstance(norm, str):
        return norm
    scale = copy.deepcopy(norm)
    if hasattr(scale, "halfrange"):
        scale.halfrange = None
    for end in ends:
        setattr(scale, end, None)
    return scale


def _with_limits(norm: Any, clim: tuple[float, float]) -> Any:
    """A copy of a norm, with limits where it has none."""
    scale = copy.deepcopy(norm)
    if hasattr(scale, "halfrange"):
        # Both of its limits are as far from its centre.
        scale.autoscale_None(np.asarray(clim))
    for end, value in zip(("vmin", "vmax"), clim, strict=True):
        if getattr(scale, end) is None:
            setattr(scale, end, value)
    return scale


def _pairs(points: Any, field: str, expected: str) -> list[tuple[Any, Any]]:
    """Points of a curve, one at least."""
    try:
        pairs = [(value, what) for value, what in points]
    except (TypeError, ValueError):
        pairs = []
    if not pairs:
        raise _checks.refused(field, points, expected)
    return pairs


def _opacities(points: Any, field: str) -> tuple[tuple[float, float], ...]:
    """Points of value and opacity."""
    pairs = _pairs(points, field, "pairs of a value and an opacity from 0 to 1")
    return tuple((_checks.number(value, field), _checks.share(opacity, field)) for value, opacity in pairs)


def _map_colors(cmap: Any, shares: Any) -> list[list[float]]:
    """Colours of a map, sRGB."""
    if isinstance(cmap, str):
        own = _core.colormap(cmap, len(shares))
        if own is not None:
            return own
        cmap = matplotlib_cmap(cmap)
    if not callable(cmap):
        expected = "a colour map: a name, or one of matplotlib's, as LinearSegmentedColormap.from_list(name, colors)"
        raise _checks.refused("cmap", cmap, expected)
    return [[float(c) for c in cmap(float(share))[:3]] for share in shares]


def matplotlib_cmap(name: str) -> Any:
    """One of matplotlib's colour maps.

    Raises
    ------
    InvalidValue
        Where matplotlib is not installed, or does not know the name either.
    """
    try:
        from matplotlib import colormaps
    except ImportError:
        message = f"cmap: {name!r} is not a colour map of splatvol's, and matplotlib is not installed"
        raise InvalidValue(message, field="cmap", value=name) from None
    try:
        return colormaps[name]
    except KeyError:
        message = f"cmap: {name!r} is a colour map neither of splatvol's nor of matplotlib's"
        raise InvalidValue(message, field="cmap", value=name) from None


@dataclass(frozen=True)
class Light:
    """A light far away, and how surfaces reflect it (Blinn and Phong); what is left out is the command's default.

    Parameters
    ----------
    direction : three numbers, optional
        Towards the light, as the camera sees it: x to the right, y down, z forward.
    ambient, diffuse, specular : float, optional
        Shares of the light.
    specular_power : float, optional
        Sharpness of highlights.
    """

    direction: Sequence[float] | None = None
    ambient: float | None = None
    diffuse: float | None = None
    specular: float | None = None
    specular_power: float | None = None

    def _keys(self) -> dict[str, Any]:
        keys = {
            "shade": True,
            "light": self.direction,
            "ambient": self.ambient,
            "diffuse": self.diffuse,
            "specular": self.specular,
            "specular-power": self.specular_power,
        }
        return {key: plain(value) for key, value in keys.items() if value is not None}


@dataclass(frozen=True)
class Clip:
    """What is cut away: see :meth:`box` and :meth:`plane`."""

    keys: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def box(
        cls, x: tuple[float, float], y: tuple[float, float], z: tuple[float, float], *, keep: str = "inside"
    ) -> Clip:
        """A box, world lengths: its inside is kept, or with ``keep="outside"`` what is around it."""
        if keep not in ("inside", "outside"):
            raise InvalidValue(f"keep: {keep!r} is not inside or outside", field="keep", value=keep)
        keys: dict[str, Any] = {"clip-box": [float(side) for side in (*x, *y, *z)]}
        return cls({**keys, "clip-inside": True} if keep == "outside" else keys)

    @classmethod
    def plane(cls, point: Sequence[float], normal: Sequence[float]) -> Clip:
        """A plane through a point, world: the side to which its normal points is kept."""
        return cls({"clip-plane": [{"point": plain(point), "normal": plain(normal)}]})


def clips(clip: Clip | Sequence[Clip]) -> dict[str, Any]:
    """Keys of clips: one box at most, and any number of planes."""
    keys: dict[str, Any] = {}
    for one in [clip] if isinstance(clip, Clip) else clip:
        if "clip-box" in one.keys and "clip-box" in keys:
            raise InvalidValue("clip: one box at most; planes cut further", field="clip")
        planes = keys.get("clip-plane", []) + one.keys.get("clip-plane", [])
        keys.update(one.keys)
        if planes:
            keys["clip-plane"] = planes
    return keys
