"""What napari's viewer shows, as scenes and a camera."""

from __future__ import annotations

import math
import warnings
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from .. import _core
from .._camera import Camera
from .._data import Data, Points, Volume
from .._errors import Combination, DataWarning, InvalidValue
from .._frame import Frame
from .._look import COLORS, TransferFunction
from .._scene import Scene
from .layers import MAX_BYTES, Part, Space, kind_of, part_of, placed

#: Kinds of pictures that show one value of each ray.
Kind = Literal["mip", "minip", "mean"]
#: Kinds of pictures by napari's names; the others are refused.
COMPOSITING: dict[str, Kind | None] = {
    "mip": "mip",
    "minip": "minip",
    "average": "mean",
    "translucent": None,
    "iso": None,
}
#: Lengths of a voxel between two samples of a ray of napari's: what the opacities of its colour maps are for.
STEP = 0.8
#: Share of the range of values over which a surface becomes solid, and its opacity then.
SURFACE, SOLID = 0.02, 0.9999
#: Height and width of a canvas that is not there, pixels.
CANVAS = (600, 800)
BLENDING = ("opaque", "translucent", "translucent_no_depth", "additive", "minimum")
#: Volumes that are kept for the next picture.
KEPT = 16


@dataclass(frozen=True, eq=False)
class Dots:
    """Points that face the camera, as napari's do."""

    name: str
    world: npt.NDArray[np.float64]
    colors: npt.NDArray[np.float64]
    radii: npt.NDArray[np.float64]

    def points(self, camera: Camera) -> Points:
        """Points seen from a camera."""
        towards = np.subtract(camera.position, camera.target)
        normals = np.broadcast_to(towards / np.linalg.norm(towards), self.world.shape)
        return Points(self.world, rgb=self.colors[:, :3], radius=self.radii, normal=normals, name=self.name)


@dataclass(frozen=True, eq=False)
class Shown:
    """One layer as it is shown."""

    name: str
    part: Part | Dots
    #: Keywords of its look, without its transfer function.
    look: dict[str, Any]
    tf: _Colors | None
    #: Kind of picture, where the layer is a picture of its own.
    compositing: Kind | None
    blending: str
    labels: dict[int, Any] | None = None
    opacity: float | dict[int, float] = 1.0


@dataclass(frozen=True)
class _Colors:
    """A layer's colour map and range."""

    colors: npt.NDArray[np.float64]
    clim: tuple[float, float]
    gamma: float
    opacity: float
    blending: str
    #: Value of the surface that is shown.
    iso: float | None

    def function(self, compositing: str | None, spacing: float) -> TransferFunction:
        """Colours and opacities of values."""
        low, high = self.clim
        shares = np.linspace(0.0, 1.0, len(self.colors))
        # napari looks up colours at share ** gamma.
        values = low + (high - low) * shares ** (1.0 / self.gamma)
        colors = [(float(v), [float(c) for c in row[:3]]) for v, row in zip(values, self.colors, strict=True)]
        if self.iso is not None:
            half = 0.5 * SURFACE * (high - low)
            return TransferFunction(colors, [(self.iso - half, 0.0), (self.iso + half, SOLID * self.opacity)], spacing)
        if compositing is None:
            alphas = [(float(v), float(row[3]) * self.opacity) for v, row in zip(values, self.colors, strict=True)]
            return TransferFunction(colors, alphas, STEP * spacing)
        alpha, edge = self.opacity, 1e-3 * (high - low)
        ends = [(low, alpha), (high, alpha)]
        if self.blending.startswith("translucent"):
            # napari leaves out pixels whose maximum does not exceed the lower limit, or minimum the upper one.
            ends = {
                "mip": [(low, 0.0), (low + edge, alpha), (high, alpha)],
                "minip": [(low, alpha), (high - edge, alpha), (high, 0.0)],
            }.get(compositing, ends)
        return TransferFunction(colors, ends)


@dataclass(frozen=True, eq=False)
class Picture:
    """What a viewer shows: layers, a camera, a background. It holds no part of the viewer but the arrays."""

    layers: list[Shown]
    camera: Camera
    background: tuple[float, float, float]
    size: tuple[int, int]
    #: What is visible there and is left out here.
    left_out: list[str] = field(default_factory=list)

    def scenes(self, volumes: Volumes | None = None, **options: Any) -> list[tuple[Scene, str]]:
        """Scenes in the order in which they are drawn, each with the way in which it is blended with those below.

        Layers whose material has a place are one scene, because they hide each other; a maximum, minimum or mean is
        one of its own.
        """
        volumes = volumes or Volumes()
        found: list[tuple[Scene, str]] = []
        solid: Scene | None = None
        for layer in self.layers:
            scene = solid if layer.compositing is None else None
            if scene is None:
                scene = Scene(camera=self.camera, size=self.size, background="none")
                if layer.compositing is None:
                    scene.set(shade=False)
                else:
                    scene.set(compositing=layer.compositing)
                found.append((scene, layer.blending))
                solid = scene if layer.compositing is None else solid
            part = layer.part
            _add(scene, layer, part.points(self.camera) if isinstance(part, Dots) else volumes.of(part))
        for scene, _ in found:
            scene.set(**options)
        return found

    def scene(self, **options: Any) -> Scene:
        """The only scene."""
        found = self.scenes(**options)
        if len(found) > 1:
            names = [layer.name for layer in self.layers if layer.compositing]
            raise Combination(
                f"layers {names}: maxima, minima and means are pictures of their own, not one scene: hide all layers "
                "but one, or write splatvol.render(viewer), which blends the pictures"
            )
        scene = found[0][0] if found else Scene(camera=self.camera, size=self.size)
        return scene.set(**{"background": self.background, **options})

    def render(
        self, volumes: Volumes | None = None, *, progress: Any = None, cancel: _core.Stop | None = None, **options: Any
    ) -> Frame:
        """The picture; several scenes are blended as napari blends its layers."""
        background = options.pop("background", None)
        found = self.scenes(volumes, **options)
        if len(found) < 2:
            scene = found[0][0] if found else Scene(camera=self.camera, size=self.size).set(**options)
            scene.set(background=self.background if background is None else background)
            return scene.render(progress=progress, cancel=cancel)
        if background is not None:
            raise InvalidValue("background: several layers are blended over the viewer's own", field="background")
        frames = [(scene.render(progress=progress, cancel=cancel), blending) for scene, blending in found]
        return _blended(frames, self.background)


class Volumes:
    """Volumes of the parts that were shown last: a picture from another side needs no new ones."""

    def __init__(self) -> None:
        self._known: OrderedDict[tuple[Any, ...], tuple[Part, Volume]] = OrderedDict()

    def of(self, part: Part) -> Volume:
        """The volume of a part."""
        kept = self._known.pop(part.key, None) or (part, part.volume())
        self._known[part.key] = kept
        while len(self._known) > KEPT:
            self._known.popitem(last=False)
        return kept[1]

    def clear(self) -> None:
        """Forgets them: an array was written to."""
        self._known.clear()


def _add(scene: Scene, layer: Shown, data: Data) -> None:
    if layer.labels is not None:
        scene.add_labels(data, colors=layer.labels, opacity=layer.opacity)
        scene.set(shade=True)
        return
    look = dict(layer.look)
    if layer.tf is not None and isinstance(data, Volume):
        look["tf"] = layer.tf.function(layer.compositing, float(np.mean(data.spacing)))
    scene.add(data, **look)
    if layer.tf is not None and layer.tf.iso is not None:
        scene.set(shade=True)


def _blended(frames: list[tuple[Frame, str]], background: tuple[float, float, float]) -> Frame:
    """Pictures over each other, as codes: OpenGL blends those, too."""
    width, height = frames[0][0].size
    codes = np.broadcast_to(np.asarray(background), (height, width, 3)).astype(np.float32)
    for frame, blending in frames:
        picture = np.asarray(frame).astype(np.float32) / 255.0
        color, alpha = picture[..., :3], picture[..., 3:]
        if blending == "additive":
            codes = np.minimum(codes + color * alpha, 1.0)
        elif blending == "minimum":
            codes = np.where(alpha > 0, np.minimum(codes, color), codes)
        else:
            codes = codes * (1.0 - alpha) + color * alpha
    linear = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    planes = np.ones((height, width, 4), np.float32)
    planes[..., :3] = linear
    depth = np.min([frame.depth for frame, _ in frames], axis=0).astype(np.float32)
    optical = np.sum([frame.optical_depth for frame, _ in frames], axis=0).astype(np.float32)
    linear, depth, optical = (
        np.ascontiguousarray(plane, np.float32).view(np.uint8).ravel() for plane in (planes, depth, optical)
    )
    core = _core.Frame.from_planes((width, height), linear, depth, optical, None)
    return Frame(core, "", 8)


def space_of(viewer: Any) -> Space:
    """How the viewer's world becomes splatvol's.

    Raises
    ------
    InvalidValue
        The viewer shows slices, or a grid of layers.
    """
    dims = viewer.dims
    if dims.ndisplay != 3:
        raise InvalidValue("the viewer shows a slice: write viewer.dims.ndisplay = 3", field="ndisplay", value="2")
    grid = getattr(getattr(viewer, "canvas", None), "grid", None) or viewer.grid
    if grid.enabled:
        raise InvalidValue("the viewer shows a grid of layers: write viewer.grid.enabled = False", field="grid")
    if len(dims.displayed) < 3:
        raise InvalidValue("the viewer has no three axes to show: add a layer with three", field="ndim")
    extent = getattr(viewer.layers, "extent", None)
    units = tuple(str(unit) for unit in getattr(extent, "units", None) or ())
    units = units if len(units) == dims.ndim else ()
    return Space(tuple(dims.displayed), tuple(dims.point), units, is_mirrored(_camera(viewer)))


def is_mirrored(camera: Any) -> bool:
    """Whether x, y, z of the world are shown left-handed.

    They are right-handed where x points to the right, y down and z away from the viewer; each axis that points the
    other way mirrors them. napari before 0.6 had no orientation, and was that.
    """
    orientation = [str(side) for side in getattr(camera, "orientation", ("away", "down", "right"))]
    turned = sum(a != b for a, b in zip(orientation, ("away", "down", "right"), strict=True))
    return turned % 2 == 1


def _camera(viewer: Any) -> Any:
    """The viewer's camera: since napari 0.9 its scene's."""
    return getattr(viewer, "scene", viewer).camera


def canvas_of(viewer: Any) -> tuple[int, int]:
    """Height and width of the viewer's canvas, pixels; a viewer without a window has the size of a new one."""
    viewer = getattr(viewer, "__wrapped__", viewer)
    window = getattr(viewer, "window", None)
    canvas = getattr(getattr(window, "_qt_viewer", None), "canvas", None)
    try:
        height, width = canvas.size  # type: ignore[union-attr]
    except (AttributeError, TypeError, RuntimeError):
        return CANVAS
    return int(height), int(width)


def camera_of(viewer: Any, canvas: tuple[int, int] | None = None) -> Camera:
    """The camera of napari's viewer; what its canvas shows from top to bottom, the picture shows."""
    space, camera = space_of(viewer), _camera(viewer)
    rows = space.rows
    target = rows @ np.asarray(camera.center[-3:], dtype=float)
    view, up = (rows @ np.asarray(v, dtype=float) for v in (camera.view_direction, camera.up_direction))
    pixels = (canvas or canvas_of(viewer))[0]
    height = pixels / float(camera.zoom)
    fov = float(camera.perspective)
    if fov > 0:
        distance = height / (2.0 * math.tan(math.radians(fov) / 2.0))
        return Camera(target - view * distance, target, up, fov=fov)
    extent = np.asarray(viewer.layers.extent.world, dtype=float)[:, list(space.displayed)]
    # A parallel projection has no place to look from: it is put outside of everything.
    reach = float(np.linalg.norm(extent[1] - extent[0]) + np.abs(camera.center[-3:] - extent).sum())
    return Camera(target - view * (reach + height), target, up, height=height)


def background_of(viewer: Any) -> tuple[float, float, float]:
    """The colour of the viewer's canvas, sRGB."""
    color = getattr(getattr(viewer, "canvas", None), "background_color", None)
    if color is None:
        from napari.utils.theme import get_theme

        color = [c / 255 for c in get_theme(viewer.theme).canvas.as_rgb_tuple()]
    return (float(color[0]), float(color[1]), float(color[2]))


def picture_of(viewer: Any, *, canvas: tuple[int, int] | None = None, max_bytes: int = MAX_BYTES) -> Picture:
    """What the viewer shows now."""
    space = space_of(viewer)
    canvas = canvas or canvas_of(viewer)
    layers: list[Shown] = []
    left_out: list[str] = []
    for layer in viewer.layers:
        if not layer.visible:
            continue
        makers: dict[str, Callable[..., Shown | None]] = {"image": _image, "labels": _labels, "points": _points}
        made = makers.get(kind_of(layer))
        missing = len(space.point) - layer.ndim
        if made is None:
            left_out.append(f"layer {layer.name!r}: a {type(layer).__name__} layer is not shown")
        elif min(space.displayed) < missing:
            left_out.append(f"layer {layer.name!r}: it does not lie along all of the three axes that are displayed")
        elif (shown := made(layer, space, max_bytes)) is not None:
            layers.append(shown)
    # An opaque layer hides what is below.
    opaque = [i for i, layer in enumerate(layers) if layer.blending == "opaque" and layer.compositing]
    layers = layers[opaque[-1] :] if opaque else layers
    size = (canvas[1], canvas[0])
    return Picture(layers, camera_of(viewer, canvas), background_of(viewer), size, left_out)


def scene_of_viewer(viewer: Any, *, canvas: tuple[int, int] | None, max_bytes: int, **options: Any) -> Scene:
    """A scene of what the viewer shows."""
    picture = picture_of(viewer, canvas=canvas, max_bytes=max_bytes)
    _warn(picture)
    return picture.scene(**options)


def render_viewer(viewer: Any, **options: Any) -> Frame:
    """The picture of what the viewer shows."""
    picture = picture_of(viewer)
    _warn(picture)
    return picture.render(**options)


def _warn(picture: Picture) -> None:
    for note in picture.left_out:
        warnings.warn(note, DataWarning, stacklevel=4)


def _blending(layer: Any) -> str:
    name = str(layer.blending)
    if name not in BLENDING:
        raise _unknown(layer, "blending", name, BLENDING)
    return name


def _unknown(layer: Any, setting: str, value: str, known: Any) -> InvalidValue:
    message = f"layer {layer.name!r}: {setting}={value!r} is not known here ({', '.join(known)})"
    return InvalidValue(message, field=setting, value=value)


def _image(layer: Any, space: Space, max_bytes: int) -> Shown:
    rendering = str(layer.rendering)
    if rendering not in COMPOSITING:
        raise _unknown(layer, "rendering", rendering, COMPOSITING)
    if str(getattr(layer, "depiction", "volume")) != "volume":
        raise _unknown(layer, "depiction", str(layer.depiction), ["volume"])
    low, high = (float(value) for value in layer.contrast_limits)
    colors = np.asarray(layer.colormap.map(np.linspace(0.0, 1.0, COLORS)), dtype=float)
    blending = _blending(layer)
    iso = float(layer.iso_threshold) if rendering == "iso" else None
    tf = _Colors(colors, (low, high), float(layer.gamma), float(layer.opacity), blending, iso)
    part = part_of(layer, space, max_bytes)
    return Shown(layer.name, part, {}, tf, COMPOSITING[rendering], blending)


def _labels(layer: Any, space: Space, max_bytes: int) -> Shown:
    part = part_of(layer, space, max_bytes)
    ids = [int(name) for name in np.unique(np.asarray(part.array[part.index]))]
    colors = {name: layer.get_color(name) for name in ids if name != 0}
    shown = {name: color for name, color in colors.items() if color is not None and color[3] > 0}
    opacity = {name: float(layer.opacity) if name in shown else 0.0 for name in colors}
    known = {name: [float(c) for c in shown.get(name, (0, 0, 0))[:3]] for name in colors}
    return Shown(layer.name, part, {}, None, None, _blending(layer), known, opacity)


def _points(layer: Any, space: Space, max_bytes: int) -> Shown | None:
    axes, affine = placed(layer, space)
    places = np.asarray(layer.data, dtype=float)
    sizes = np.broadcast_to(np.asarray(layer.size, dtype=float), (len(places),))
    visible = np.broadcast_to(np.asarray(layer.shown, dtype=bool), (len(places),)).copy()
    spot = np.asarray(layer.world_to_data(space.point[-layer.ndim :]), dtype=float)
    for axis in set(range(layer.ndim)) - set(axes):
        visible &= np.round(places[:, axis]) == round(float(spot[axis]))
    if not visible.any():
        return None
    world = places[visible][:, list(axes)] @ affine[:3, :3].T + affine[:3, 3]
    scale = abs(np.linalg.det(affine[:3, :3])) ** (1 / 3)
    colors = np.asarray(layer.face_color, dtype=float)[visible]
    dots = Dots(layer.name, world, colors, sizes[visible] / 2 * scale)
    return Shown(layer.name, dots, {"opacity": float(layer.opacity)}, None, None, _blending(layer))
