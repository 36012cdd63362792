"""The widget of notebooks: a scene that the mouse turns, rendered by the kernel, and by the page while it moves."""

from __future__ import annotations

import base64
import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import anywidget
import numpy as np

from . import _browser, _core
from ._camera import Camera
from ._data import Volume
from ._errors import InvalidValue
from ._frame import Frame, shown
from ._look import COLORS, Clip
from ._options import LOOK
from ._progressive import Progressive, Shot, is_fixed, size_of
from ._scene import Scene
from ._verbs import colormaps
from ._vocabulary import Keys

#: Size where the scene says none: a notebook's column has room for it.
SIZE = (640, 480)
BINS = 128
#: What the menu calls kinds of pictures; the first leaves it to the data's kind.
COMPOSITING = {"": "Volume", "mip": "MIP", "minip": "MinIP", "mean": "Mean", "xray": "X-ray"}

#: Who draws drafts.
ENGINES = ("auto", "kernel")

_FILES = Path(__file__).parent


class Widget(anywidget.AnyWidget):
    """A scene in a notebook that is turned, zoomed and edited: what :func:`splatvol.show` returns.

    Drag turns, the wheel zooms, shift and drag moves, a double click resets; arrows, plus, minus and ``r`` do the
    same. At rest, the picture is that of ``scene.render()``. While something moves, drafts are shown. The page draws
    them by itself, also where the kernel is busy, as soon as it has the engine and the data: at most 4 MB, in fewer
    bits or at a coarser level where they have to be; by WebGPU where the browser has it. Of volumes beyond memory, and
    where the package was built without the engine for browsers, the kernel renders drafts.

    Parameters
    ----------
    scene : Scene
        It is copied: the widget's own is :attr:`scene`.
    engine : str
        ``"auto"``, or ``"kernel"``: the page gets pictures and histograms, and no data.

    Examples
    --------
    >>> import splatvol as sv
    >>> widget = sv.show("sample:head:16", size=(64, 48))
    >>> widget.camera = widget.camera.orbit(azimuth=30)
    >>> widget.snapshot().size
    (64, 48)
    """

    _esm = "".join((_core.browser_script(), *((_FILES / name).read_text() for name in ("_browser.js", "_widget.js"))))
    _css = _FILES / "_widget.css"

    def __init__(self, scene: Scene, engine: str = "auto") -> None:
        if engine not in ENGINES:
            raise InvalidValue(f"engine: {engine!r} is neither 'auto' nor 'kernel'", field="engine", value=repr(engine))
        super().__init__()
        self._engine = engine
        self._views: set[str] = set()
        #: Views that draw drafts themselves.
        self._drawing: set[str] = set()
        self._listeners: list[Callable[[str], object]] = []
        self._still: tuple[str, Frame] | None = None
        #: End of the text of the still in the notebook, by which views find it.
        self._shown_still = ""
        self._take(scene)
        self.on_msg(self._receive)

    def _take(self, scene: Scene) -> None:
        self._scene = scene.copy()
        if "size" not in self._scene._document:
            self._scene.set(size=SIZE)
        self._given = [dict(item.keys) for item in self._scene.items]
        #: Items whose look was edited.
        self._by_hand: set[int] = set()
        #: Colour maps that were chosen for items.
        self._maps = {index: str(keys.get("cmap", "")) for index, keys in enumerate(self._given)}
        self._is_frozen = False
        self._home: Camera | None = None
        self._bounds: tuple[list[float], list[float]] | None = None
        self._histograms: dict[int, tuple[Volume, list[float]]] = {}
        self._renders = Progressive(self._scene, self._present, self._complain)
        self._to_pages = _browser.ToPages(lambda message, buffers: self.send(message, buffers), self._for_pages)

    # What is shown.

    @property
    def scene(self) -> Scene:
        """The scene as it is shown. After changes call :meth:`update`; assign another one to show that."""
        return self._scene

    @scene.setter
    def scene(self, scene: Scene) -> None:
        self._renders.close()
        self._to_pages.close()
        self.send({"kind": "browser", "end": True})
        self._take(scene)
        for view in self._views:
            self._begin_page(view, has_engine=view in self._drawing)
        self._tell()
        self.update()
        self._changed("scene")

    @property
    def camera(self) -> Camera:
        """The camera: assign one to look from there, or `None` to have it chosen."""
        document = self._scene._document
        return Camera._of_keys((document if is_fixed(document) else self._decided())["camera"])

    @camera.setter
    def camera(self, camera: Camera | None) -> None:
        self._scene.camera = camera
        self._send_camera(None)
        self._ask(moving=True)
        self._changed("camera")

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture at rest, pixels."""
        return size_of(self._decided())

    @size.setter
    def size(self, size: int | tuple[int, int]) -> None:
        self._scene.set(size=size)
        self._tell()
        self._ask(moving=False)
        self._changed("size")

    def update(self) -> None:
        """Shows the scene's present state."""
        self._renders.look_changed()
        self._tell()
        self._ask(moving=False)

    def snapshot(self) -> Frame:
        """The picture at rest, as it is now: that of ``scene.render()``."""
        document = self._scene.to_dict()
        text = json.dumps(document)
        if self._still is None or self._still[0] != text:
            resolved = self._renders.resolved
            self._still = text, resolved.render(resolved.document(document), _core.Stop())
        return self._still[1]

    def on_change(self, callback: Callable[[str], object]) -> Callable[[], None]:
        """Calls back with what was changed: ``"camera"``, ``"look"``, ``"compositing"``, ``"clip"``, ``"size"``...

        What is returned ends it. Errors of the callback are shown in the widget.
        """
        self._listeners.append(callback)
        return lambda: self._listeners.remove(callback)

    def link(self, other: Widget, what: str = "camera") -> Callable[[], None]:
        """Lets both widgets have one camera, this one's; what is returned ends it.

        Raises
        ------
        InvalidValue
            Anything but ``"camera"``.
        """
        if what != "camera":
            raise InvalidValue(f"what: {what!r} is not linked: write 'camera'", field="what", value=repr(what))

        def follow(source: Widget, target: Widget) -> Callable[[str], None]:
            def copy(change: str) -> None:
                # The camera that is equal already ends the circle.
                if change in ("camera", "scene") and target.camera != source.camera:
                    target.camera = source.camera

            return copy

        ends = [self.on_change(follow(self, other)), other.on_change(follow(other, self))]
        if other.camera != self.camera:
            other.camera = self.camera

        def unlink() -> None:
            for end in ends:
                end()

        return unlink

    def close(self) -> None:
        """Ends the widget: its rendering stops, and its views go."""
        if hasattr(self, "_renders"):
            self._renders.close()
            self._to_pages.close()
        super().close()

    # What notebooks keep.

    def _repr_mimebundle_(self, **_: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        view = {"version_major": 2, "version_minor": 1, "model_id": self.model_id}
        bundle: dict[str, Any] = {"text/plain": repr(self), "application/vnd.jupyter.widget-view+json": view}
        png = self._png()
        return (bundle if png is None else {**bundle, "image/png": png}), {}

    def _ipython_display_(self) -> None:
        """Shows a still and the widget, which hides it: where the notebook has no kernel, the still is what is seen.

        JupyterLab prefers a widget without a kernel, of which it shows nothing, to a picture in the same output.
        """
        bundle, _ = self._repr_mimebundle_()
        png = bundle.pop("image/png", None)
        if png is not None:
            _publish({"text/plain": repr(self), "image/png": png})
            bundle["text/plain"] = ""
            self._shown_still = png[-80:]
        _publish(bundle)

    def _png(self) -> str | None:
        try:
            return base64.b64encode(shown(self.snapshot())).decode()
        except Exception as error:
            self._complain(error)
            return None

    def __repr__(self) -> str:
        return f"<splatvol.Widget of {self._scene!r}>"

    # What views say and hear.

    def _receive(self, _: Any, message: dict[str, Any], __: Any) -> None:
        try:
            getattr(self, f"_hear_{message['kind']}")(message)
        except Exception as error:
            # ipywidgets swallows it otherwise.
            self._complain(error)

    def _hear_ready(self, message: dict[str, Any]) -> None:
        self._views.add(message["view"])
        self._tell()
        if self._still is not None and self._still[0] == json.dumps(self._scene.to_dict()):
            self._present(Shot(0, self._still[1], True, self._still[1].size))
        else:
            self._ask(moving=False)
        own = _browser.engine()
        self._begin_page(message["view"], has_engine=own is not None and own[0] in message.get("engines", ()))

    def _begin_page(self, view: str, *, has_engine: bool) -> None:
        if self._engine == "auto":
            self._to_pages.begin(view, has_engine=has_engine)

    def _hear_gpu(self, message: dict[str, Any]) -> None:
        self._to_pages.begin_gpu(message["view"])

    def _hear_draws(self, message: dict[str, Any]) -> None:
        (self._drawing.add if message["value"] else self._drawing.discard)(message["view"])
        # What was changed while the data were on their way.
        self.send({"kind": "browser", "view": message["view"], "edits": self._edits(self._decided())})

    def _hear_gone(self, message: dict[str, Any]) -> None:
        self._views.discard(message["view"])
        self._drawing.discard(message["view"])
        self._to_pages.leave(message["view"])

    def _hear_shown(self, message: dict[str, Any]) -> None:
        self._renders.shown(message["number"])

    def _hear_camera(self, message: dict[str, Any]) -> None:
        self._scene.camera = Camera._of_keys(message["camera"])
        if len(self._views) > 1:
            self._send_camera(message["view"])
        self._ask(moving=True)
        self._changed("camera")

    def _hear_home(self, _: dict[str, Any]) -> None:
        self.camera = self._home

    def _hear_look(self, message: dict[str, Any]) -> None:
        self._freeze()
        self._set_look(message["item"], message["look"])
        self._edited("look")

    def _hear_cmap(self, message: dict[str, Any]) -> None:
        self._freeze()
        look = dict(self._scene.items[message["item"]].keys["transfer-function"])
        low, high = look["colors"][0]["value"], look["colors"][-1]["value"]
        colors = _core.colormap(message["name"], COLORS) or []
        values = np.linspace(low, high, len(colors)).tolist()
        look["colors"] = [{"value": value, "rgb": rgb} for value, rgb in zip(values, colors, strict=True)]
        self._set_look(message["item"], look)
        self._maps[message["item"]] = message["name"]
        self._edited("look", tell=True)

    def _hear_compositing(self, message: dict[str, Any]) -> None:
        self._fix_camera()
        # A look that was not chosen by hand suits the kind of picture.
        for index, item in enumerate(self._scene.items):
            if index not in self._by_hand:
                item.keys = dict(self._given[index])
        self._is_frozen = False
        self._scene.set(compositing=message["value"] or None)
        self._edited("compositing", tell=True)

    def _hear_clip(self, message: dict[str, Any]) -> None:
        self._freeze()
        effects = self._scene._document.setdefault("effects", {})
        effects.pop("clip-box", None)
        if message["box"] is not None:
            x0, x1, y0, y1, z0, z1 = message["box"]
            effects.update(Clip.box((x0, x1), (y0, y1), (z0, z1)).keys)
        self._edited("clip")

    def _hear_reset(self, _: dict[str, Any]) -> None:
        self._fix_camera()
        self._by_hand.clear()
        self._is_frozen = False
        for index, (item, keys) in enumerate(zip(self._scene.items, self._given, strict=True)):
            item.keys = dict(keys)
            self._maps[index] = str(keys.get("cmap", ""))
        self._edited("look", tell=True)

    # Helpers.

    def _for_pages(self) -> tuple[_core.Picture, list[Keys]]:
        decided = self._decided()
        return self._scene._picture(decided), self._edits(decided)

    def _edits(self, decided: Keys) -> list[Keys]:
        """What the engine in a page has to know of a document, beside the camera and the size."""
        visible = [item for item in decided["item"] if item.get("visible", True)]
        looks = {
            f"item[{index}].transfer-function": item.get("transfer-function") for index, item in enumerate(visible)
        }
        tables = {name: decided.get(name) for name in ("settings", "effects")}
        return [{"path": path, "value": value} for path, value in {**tables, **looks}.items()]

    def _decided(self) -> Keys:
        return self._renders.resolved.document(self._scene.to_dict())

    def _fix_camera(self) -> None:
        """Keeps the camera where it is: edits of the look do not move it."""
        if not is_fixed(self._scene._document):
            self._scene.camera = self.camera

    def _freeze(self) -> None:
        """Writes down what was chosen, looks and camera, so that an edit changes nothing else, and at once."""
        if self._is_frozen:
            return
        decided = self._decided()
        for item, keys in zip(self._scene.items, decided["item"], strict=True):
            item.keys = dict(keys)
        self._fix_camera()
        self._is_frozen = True

    def _set_look(self, index: int, look: Keys) -> None:
        keys = self._scene.items[index].keys
        for key in set(LOOK.values()) - {"iso"}:
            keys.pop(key, None)
        keys["transfer-function"] = look
        self._by_hand.add(index)

    def _edited(self, what: str, *, tell: bool = False) -> None:
        self._renders.look_changed()
        if tell:
            self._tell()
        self._ask(moving=True)
        self._changed(what)

    def _changed(self, what: str) -> None:
        for listener in list(self._listeners):
            try:
                listener(what)
            except Exception as error:
                self._complain(error)

    def _ask(self, *, moving: bool) -> None:
        if self._views:
            drafts = not self._views <= self._drawing
            self._renders.ask(self._scene.to_dict(), moving=moving, drafts=drafts)

    def _tell(self) -> None:
        """Tells the views what their controls show."""
        if not self._views:
            return
        decided = self._decided()
        camera = decided["camera"]
        self._home = self._home or Camera._of_keys(camera)
        if self._bounds is None:
            self._bounds = self._scene._picture(decided).bounds()
        self.send(
            {
                "kind": "state",
                "size": size_of(decided),
                "camera": camera,
                "edits": self._edits(decided),
                "home": self._home._keys(),
                "items": [self._controls(index, keys) for index, keys in enumerate(decided["item"])],
                "maps": colormaps(),
                "compositing": self._scene._document.get("settings", {}).get("compositing", ""),
                "kinds": list(COMPOSITING.items()),
                "bounds": self._bounds,
                "clip": decided.get("effects", {}).get("clip-box"),
                "still": self._shown_still,
            }
        )

    def _controls(self, index: int, keys: Keys) -> Keys:
        """What the editor of an item's look shows."""
        item = self._scene.items[index]
        look = {"look": keys.get("transfer-function"), "map": self._maps.get(index, "")}
        shown: Keys = {"name": item.name, **look, "histogram": [], "range": [0, 1]}
        if isinstance(item.data, Volume):
            shown |= {"histogram": self._histogram(item.data), "range": list(item.data.range)}
        return shown

    def _histogram(self, volume: Volume) -> list[float]:
        """Logarithms of the counts, as shares of the highest; counted once, for large volumes take a while."""
        known = self._histograms.get(id(volume))
        if known is None:
            heights = np.log1p(volume.histogram(BINS)[0])
            # The volume is kept, so that no other one gets its id.
            known = volume, (heights / max(heights.max(), 1)).round(3).tolist()
            self._histograms[id(volume)] = known
        return known[1]

    def _send_camera(self, source: str | None) -> None:
        if self._views:
            self.send({"kind": "camera", "camera": self.camera._keys(), "view": source})

    def _present(self, shot: Shot) -> None:
        width, height = shot.frame.size
        data = shot.frame._core.encode("png", 8, None)
        self.send(
            {
                "kind": "frame",
                "number": shot.number,
                "final": shot.is_final,
                "camera": json.loads(shot.frame._document)["camera"],
                "width": width,
                "height": height,
            },
            [data],
        )

    def _complain(self, error: Exception) -> None:
        self.send({"kind": "error", "text": f"{type(error).__name__}: {error}"})


def _publish(bundle: dict[str, Any]) -> None:
    import IPython.display

    publish: Any = IPython.display.publish_display_data
    publish(bundle)


def widget_of(data: Any, options: dict[str, Any], engine: str) -> Widget:
    """A widget of anything that can be shown."""
    note = _browser.notice() if engine == "auto" else None
    if note is not None:
        warnings.warn(note, stacklevel=3)
    if not isinstance(data, Scene):
        return Widget(Scene(data, **options), engine)
    if not options:
        return Widget(data, engine)
    return Widget(data.copy().set_document(data.to_dict(**options)), engine)


__all__ = ["Widget", "widget_of"]
