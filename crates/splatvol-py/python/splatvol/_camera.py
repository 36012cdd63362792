"""Cameras: from where a scene is seen."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _checks
from ._errors import InvalidValue

Vector = tuple[float, float, float]
#: What a field of view is.
ANGLE = "degrees between 0 and 180"


def _vector(value: Any, field: str) -> Vector:
    try:
        numbers = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.shape != (3,) or not np.isfinite(numbers).all():
        raise InvalidValue(f"{field}: {value!r} is not three finite numbers", field=field, value=repr(value))
    return (float(numbers[0]), float(numbers[1]), float(numbers[2]))


@dataclass(frozen=True)
class Camera:
    """A camera in world space.

    Parameters
    ----------
    position, target : three numbers
        Where the eye is, and the point that it looks at; world lengths.
    up : three numbers
        Direction that is up in the picture.
    fov : float
        Vertical field of view, degrees, above 0 and below 180.
    height : float, optional
        Height of the picture in world lengths, above 0: the projection is parallel.

    Raises
    ------
    InvalidValue
        A number that is not finite, or outside its range.

    Examples
    --------
    >>> import splatvol as sv
    >>> camera = sv.Camera((0, -400, 0), (0, 0, 0)).orbit(azimuth=30)
    >>> camera.fov
    30.0
    """

    position: Vector
    target: Vector
    up: Vector = (0.0, 0.0, 1.0)
    fov: float = 30.0
    height: float | None = None

    def __post_init__(self) -> None:
        for name in ("position", "target", "up"):
            object.__setattr__(self, name, _vector(getattr(self, name), name))
        degrees = _checks.number(self.fov, "fov", ANGLE)
        if not 0 < degrees < 180:
            raise _checks.refused("fov", self.fov, ANGLE)
        object.__setattr__(self, "fov", degrees)
        if self.height is not None:
            object.__setattr__(self, "height", _checks.positive(self.height, "height"))

    def orbit(self, azimuth: float = 0.0, elevation: float = 0.0) -> Camera:
        """The camera turned around its target: to its right, and upwards; degrees."""
        target, back, up = (np.asarray(v) for v in (self.target, self._back(), self._unit_up()))
        back = _rotated(back, up, math.radians(azimuth))
        right = np.cross(up, back)
        right /= np.linalg.norm(right)
        back = _rotated(back, right, -math.radians(elevation))
        upright = np.cross(back, right)
        upright /= np.linalg.norm(upright)
        return replace(self, position=_tuple(target + back), up=_tuple(upright))

    def roll(self, degrees: float) -> Camera:
        """The camera turned around its line of sight, counter-clockwise as it sees."""
        forward = -np.asarray(self._back())
        forward /= np.linalg.norm(forward)
        return replace(self, up=_tuple(_rotated(self._unit_up(), forward, -math.radians(degrees))))

    def zoom(self, factor: float) -> Camera:
        """The camera with its picture enlarged by a factor, from the same place."""
        if not factor > 0:
            raise InvalidValue(f"zoom: {factor!r} is not above 0", field="zoom", value=repr(factor))
        if self.height is not None:
            return replace(self, height=self.height / factor)
        half = math.tan(math.radians(self.fov) / 2) / factor
        return replace(self, fov=math.degrees(2 * math.atan(half)))

    @property
    def matrix(self) -> npt.NDArray[np.float64]:
        """4x4, camera from world: x to the right, y up, looking along -z (as OpenGL)."""
        back = np.asarray(self._back())
        back /= np.linalg.norm(back)
        right = np.cross(np.asarray(self.up), back)
        right /= np.linalg.norm(right)
        rows = np.stack([right, np.cross(back, right), back])
        matrix = np.eye(4)
        matrix[:3, :3] = rows
        matrix[:3, 3] = -rows @ np.asarray(self.position)
        return matrix

    @classmethod
    def view(cls, name: str, fit: Any, **options: Any) -> Camera:
        """The camera of a view by name, all of `fit` in the picture: the one that ``render(fit, view=name)`` takes.

        Parameters
        ----------
        name : str
            ``"front"``, ``"back"``, ``"left"``, ``"right"``, ``"top"``, ``"bottom"`` or ``"iso"``.
        fit
            A scene, or anything that :func:`splatvol.render` takes.
        **options
            Keywords on which it depends, as `size` and `fov`.

        Examples
        --------
        >>> import splatvol as sv
        >>> sv.Camera.view("left", "sample:head:16").up
        (0.0, 0.0, 1.0)
        """
        from ._scene import Scene

        scene = fit if isinstance(fit, Scene) else Scene(fit)
        document = json.loads(scene._picture(scene.to_dict(**options, view=name)).document())
        return cls._of_keys(document["camera"])

    @classmethod
    def from_pyvista(cls, position: Any, *, view_angle: float = 30.0) -> Camera:
        """A camera from PyVista's `camera_position`: position, focal point and view up."""
        eye, target, up = position
        return cls(eye, target, up, fov=view_angle)

    def to_pyvista(self) -> list[Vector]:
        """PyVista's `camera_position`."""
        return [self.position, self.target, self.up]

    @classmethod
    def from_napari(cls, viewer: Any, *, canvas: tuple[int, int] | None = None) -> Camera:
        """The camera of napari's viewer, in the world of :meth:`Scene.from_napari`; `canvas` is height and width.

        A viewer without a window has no canvas: 600 x 800 is assumed.
        """
        from ._napari.viewer import camera_of

        return camera_of(viewer, canvas)

    def _back(self) -> npt.NDArray[np.float64]:
        back: npt.NDArray[np.float64] = np.asarray(self.position) - np.asarray(self.target)
        return back

    def _unit_up(self) -> npt.NDArray[np.float64]:
        back = self._back()
        up = np.asarray(self.up) - back * (np.dot(self.up, back) / np.dot(back, back))
        unit: npt.NDArray[np.float64] = up / np.linalg.norm(up)
        return unit

    def _keys(self) -> dict[str, Any]:
        keys: dict[str, Any] = {"position": self.position, "target": self.target, "up": self.up}
        return {**keys, "fov": self.fov} if self.height is None else {**keys, "orthographic": self.height}

    @classmethod
    def _of_keys(cls, keys: dict[str, Any]) -> Camera:
        height = keys.get("orthographic")
        projection = {"fov": keys["fov"]} if height is None else {"height": height}
        return cls(keys["position"], keys["target"], keys["up"], **projection)


def _tuple(vector: npt.NDArray[np.float64]) -> Vector:
    return (float(vector[0]), float(vector[1]), float(vector[2]))


def _rotated(vector: Any, axis: npt.NDArray[np.float64], angle: float) -> npt.NDArray[np.float64]:
    """A vector turned around a unit axis (Rodrigues)."""
    vector = np.asarray(vector, dtype=float)
    along = axis * np.dot(axis, vector)
    turned: npt.NDArray[np.float64] = (
        along + (vector - along) * math.cos(angle) + np.cross(axis, vector) * math.sin(angle)
    )
    return turned
