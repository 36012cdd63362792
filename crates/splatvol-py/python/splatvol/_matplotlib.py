"""Scenes in matplotlib's figures: an artist that is rendered at the resolution at which its figure is drawn."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, ListedColormap, Normalize

from ._look import TransferFunction, norm_of
from ._options import LOOK
from ._scene import Scene
from ._vocabulary import Keys

#: Projections whose values are light: over the face of white axes they would be washed out, so that they have black.
LIGHT = ("mip", "minip", "mean")
#: Colours of the map that a colour bar shows.
SHADES = 256


class SceneArtist(Artist, ScalarMappable):
    """A scene that fills its axes, or its figure where it is in none: see :meth:`splatvol.Scene.artist`.

    Its colour map and range are those of the scene's first item that has them. A map, range or norm that is set here
    (:meth:`set_cmap`, :meth:`set_clim`, :meth:`set_norm`) is the picture's, too.
    """

    def __init__(self, scene: Scene, **options: Any) -> None:
        Artist.__init__(self)
        #: What is shown. Its changes are seen when the figure is drawn again.
        self.scene = scene
        self._options = options
        self._picture: tuple[Any, Any] = (None, None)
        index, function = self._first_look()
        self._item = index
        self._function = function
        own = None if index is None else scene.items[index]._norm
        said = options.get("norm") or own
        norm = _norm_of(function) if said is None else norm_of(said)
        ScalarMappable.__init__(self, norm=norm, cmap=_cmap_of(function, norm))
        self._chosen = self._look()
        self.set_zorder(0)

    @Artist.axes.setter  # type: ignore[attr-defined,untyped-decorator]
    def axes(self, axes: Axes | None) -> None:
        """The axes that are filled."""
        # Axes that it is added to twice, as by ``ax.add_artist(scene.artist(ax))``, draw it once.
        remove = getattr(self, "_remove_method", None)
        if axes is not None and remove is not None and list(axes.get_children()).count(self) > 1:
            remove(self)
        Artist.axes.fset(self, axes)  # type: ignore[attr-defined]

    def draw(self, renderer: Any) -> None:
        """Draws the scene, rendered at the pixels that its axes have now."""
        if not self.get_visible():
            return
        box = self.get_window_extent(renderer)
        # Formats that keep no pixels, such as PDF, say how many of them a point has.
        scale = float(renderer.get_image_magnification())
        left, bottom = round(box.x0 * scale), round(box.y0 * scale)
        width, height = round(box.x1 * scale) - left, round(box.y1 * scale) - bottom
        if width < 1 or height < 1:
            return
        codes = self._codes((width, height))
        context = renderer.new_gc()
        self._set_gc_clip(context)  # type: ignore[attr-defined]
        context.set_url(self.get_url())
        renderer.open_group("splatvol", self.get_gid())
        renderer.draw_image(context, left / scale, bottom / scale, codes)
        renderer.close_group("splatvol")
        context.restore()
        self.stale = False

    def get_window_extent(self, renderer: Any = None) -> Any:
        """The box that is filled, pixels of the figure."""
        place = self.axes if self.axes is not None else self.get_figure()
        if place is None:
            raise RuntimeError("the artist is in no figure: write ax.add_artist(artist)")
        return place.bbox

    def contains(self, mouseevent: Any) -> tuple[bool, dict[str, Any]]:
        """Whether the mouse is over the picture."""
        return bool(self.get_window_extent().contains(mouseevent.x, mouseevent.y)), {}

    def _codes(self, size: tuple[int, int]) -> Any:
        """RGBA of the scene, bottom row first; rendered again only where something has changed."""
        scene, overrides = self._shown()
        data = [getattr(item.data, "_core", item.data) for item in scene.items]
        # The document has the overrides too, number by number.
        key = (size, json.dumps(scene.to_dict(**overrides), sort_keys=True), data)
        if key != self._picture[0]:
            self._picture = (key, np.asarray(scene.render(**overrides, size=size))[::-1])
        codes = self._picture[1]
        alpha = self.get_alpha()
        if alpha is not None:
            codes = codes.copy()
            codes[..., 3] = np.rint(codes[..., 3] * float(alpha))
        return codes

    def _shown(self) -> tuple[Scene, Keys]:
        """The scene and its keywords, with the map and range of the artist where those were set."""
        overrides = {name: value for name, value in self._options.items() if name != "size"}
        document = self.scene.to_dict(**overrides)
        if "background" not in document:
            # The face of the axes is seen behind the scene.
            is_light = document.get("settings", {}).get("compositing") in LIGHT
            overrides["background"] = "black" if is_light else "none"
        if self._look() == self._chosen or self._item is None or self._function is None:
            return self.scene, overrides
        scene = self.scene.copy()
        for name in LOOK.keys() - {"iso"}:
            overrides.pop(name, None)
        low, high = self._range(self._function)
        points, unit = self._function.opacities, self._function.unit_distance
        tf = TransferFunction.from_cmap(self.cmap, (low, high), points, norm=self.norm, unit_distance=unit)
        scene.items[self._item].set(tf=tf)
        return scene, overrides

    def _range(self, function: TransferFunction) -> tuple[float, float]:
        """Ends of the norm; where it has none, those of the scene's colours, which it gets for its colour bar."""
        own: Any = _norm_of(function)
        norm: Any = self.norm
        if norm.vmin is None or norm.vmax is None:
            low = own.vmin if norm.vmin is None else norm.vmin
            self.set_clim(low, own.vmax if norm.vmax is None else norm.vmax)
        return float(norm.vmin), float(norm.vmax)

    def _look(self) -> tuple[Any, ...]:
        return (self.cmap, type(self.norm), self.norm.vmin, self.norm.vmax)

    def _first_look(self) -> tuple[int | None, TransferFunction | None]:
        """The first item that has a transfer function, and that."""
        small = {name: value for name, value in self._options.items() if name != "size"}
        document = json.loads(self.scene._picture(self.scene.to_dict(**small)).document())
        for index, keys in enumerate(document["item"]):
            function = keys.get("transfer-function")
            if function and len(function["colors"]) > 1 and keys.get("visible", True):
                return index, TransferFunction._of_document(function)
        return None, None


def _norm_of(function: TransferFunction | None) -> Normalize:
    values = [0.0, 1.0] if function is None else [value for value, _ in function.colors]
    return Normalize(min(values), max(values))


def _cmap_of(function: TransferFunction | None, norm: Normalize) -> Colormap | None:
    """The colours of a transfer function, as a map by a norm."""
    if function is None:
        return None
    places = np.array([value for value, _ in function.colors])
    colors = np.array([color for _, color in function.colors])
    norm.autoscale_None(places)
    values = np.asarray(norm.inverse(np.linspace(0.0, 1.0, SHADES)), dtype=float)
    shades = np.stack([np.interp(values, places, channel) for channel in colors.T], axis=1)
    return ListedColormap(shades, name="splatvol")


def artist(scene: Scene, ax: Axes | None, options: dict[str, Any]) -> SceneArtist:
    """An artist of a scene, in axes where there are some."""
    made = SceneArtist(scene, **options)
    if ax is not None:
        ax.add_artist(made)
    return made
