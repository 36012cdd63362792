"""Scenes: things that are shown together, a camera, a method; all of it one document."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from . import _checks, _core, _foreign
from ._animation import animate, volume_at
from ._camera import Camera
from ._data import RULES, Data, Progress, Rules, Volume, read_item
from ._errors import DataWarning, InvalidValue, SplatvolError
from ._frame import Frame, _replace
from ._lazy import LazyVolume
from ._look import Clip, TransferFunction
from ._options import LOOK, OWN, READING, document_of, item_keys, over_look
from ._series import Series
from ._vocabulary import Keys, keywords, tables

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._matplotlib import SceneArtist
    from ._render_options import RenderOptions
    from ._widget import Widget

#: Colours of kinds that have none of their own: matplotlib's first ten.
TEN = ["#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f", "#bcbd22", "#17becf"]

#: Keywords of a look that its keys hold as they were said.
PLAIN = ("tf", "cmap", "clim", "opacity", "iso", "unit_distance")
_BACKGROUND = ThreadPoolExecutor(1, thread_name_prefix="splatvol-submit")


class Item:
    """A thing in a scene: data, and how they look and where they lie."""

    def __init__(self, data: Data | None, keys: Keys, look: Keys | None = None) -> None:
        #: The data; `None` where the document names a file that is read when it is rendered.
        self.data = data
        self.keys = keys
        #: Keywords of the look, and the transfer function that was made by them.
        self._said = look or {}
        self._made = keys.get("transfer-function") if look else None

    @property
    def name(self) -> str:
        """Name of the data."""
        return os.path.basename(str(self.keys["file"]).removeprefix("array:"))

    @property
    def _function(self) -> Keys | None:
        """The transfer function that keywords made, unless the document has another one by now."""
        function: Keys | None = self.keys.get("transfer-function")
        return function if self._made is not None and function == self._made else None

    @property
    def _look(self) -> Keys:
        """Keywords of the look; a transfer function that came with a document was chosen, and is none of them."""
        if self._function is not None:
            return self._said
        return {name: self.keys[LOOK[name]] for name in PLAIN if LOOK[name] in self.keys}

    @property
    def _norm(self) -> Any:
        """The norm by which the colours were chosen, for a colour bar; the document has the colours alone."""
        return self._look.get("norm")

    def _held(self, frame: int = 0, frames: int = 1) -> _core.Data | None:
        """The data in memory, of a series those of the time that a frame shows."""
        if isinstance(self.data, Series):
            return volume_at(self.data, frame, frames)._core
        return self.data._core if self.data is not None else None

    def set(self, **look: Any) -> Item:
        """Changes the look or the place; `None` leaves a keyword to be chosen from the data again.

        What was said of a look holds until it is said anew: other limits leave the colour map and a norm's kind as they
        are. A colour map takes the place of a transfer function, and the other way round.

        Raises
        ------
        InvalidValue
            A keyword that contradicts the look that stays, as `clim` beside a :class:`TransferFunction`.
        """
        said = self._look
        is_changed = bool(LOOK.keys() & look.keys())
        whole = over_look(said, look) if is_changed else {}
        options = {name: value for name, value in look.items() if name not in LOOK}
        keys, rest = item_keys({**options, **whole}, self.data, is_exact="iso" in said and self._function is not None)
        if rest:
            raise InvalidValue(f"{sorted(look)}: of these some are the scene's, not an item's", field="item")
        if is_changed:
            self.keys = _without_look(self.keys)
        for name, value in options.items():
            if value is None and name in keywords():
                self.keys.pop(keywords()[name][1], None)
        self.keys.update(keys)
        if is_changed:
            self._said, self._made = whole, keys.get("transfer-function")
        return self

    def __repr__(self) -> str:
        return f"<splatvol.Item {self.name!r}>"


def _without_look(keys: Keys) -> Keys:
    """Keys of an item without those of its look."""
    return {key: value for key, value in keys.items() if key not in LOOK.values()}


class Scene:
    """Things that are shown together.

    Parameters
    ----------
    *things
        Arrays, files, data, or objects of other packages (see :func:`splatvol.read`).
    **options
        Keywords of :class:`splatvol.RenderOptions`; those of a look are for each of the things.

    Examples
    --------
    >>> import splatvol as sv
    >>> scene = sv.Scene("sample:head:16", size=32, view="left")
    >>> frame = scene.render(azimuth=20)
    >>> frame.size
    (32, 32)
    """

    def __init__(self, *things: Any, **options: Unpack[RenderOptions]) -> None:
        self._document: Keys = {"version": 2}
        #: The things.
        self.items: list[Item] = []
        self._warned: set[str] = set()
        if not things:
            self._merge(document_of(options, None))
        for thing in things:
            self._add(thing, options)

    @classmethod
    def from_napari(
        cls, viewer: Any, *, canvas: tuple[int, int] | None = None, max_bytes: int = 1 << 30, **options: Any
    ) -> Scene:
        """A scene of what napari's viewer shows in 3-D: visible image, labels and points layers, camera, background.

        Where the viewer shows x, y, z mirrored, which is its default orientation, the scene's world has y negated.

        Parameters
        ----------
        viewer : napari.Viewer or napari.components.ViewerModel
            Layers of other kinds are left out, with a warning.
        canvas : (height, width), optional
            Pixels of a canvas that is not there: 600 x 800 where the viewer has no window. It is the size, too.
        max_bytes : int
            Of a multiscale layer the finest level is taken that has at most so many bytes.
        **options
            Keywords of :class:`splatvol.RenderOptions` for the scene: `size`, `preset`, `camera`...

        Raises
        ------
        InvalidValue
            A layer's rendering, depiction or blending is not known here; the viewer shows slices or a grid.
        Combination
            Several layers are pictures of their own (maxima, minima, means): ``splatvol.render(viewer)`` blends them.
        """
        from ._napari.viewer import scene_of_viewer

        return scene_of_viewer(viewer, canvas=canvas, max_bytes=max_bytes, **options)

    def add(self, thing: Any, **look: Any) -> Item:
        """Adds a thing: its look and its place (`scale`, `rotate`, `translate`, `up`) by keywords."""
        return self._add(thing, look)

    def add_labels(
        self,
        ids: Any,
        *,
        axes: str | None = None,
        colors: Mapping[int, Any] | None = None,
        opacity: float | Mapping[int, float] = 1.0,
        **place: Any,
    ) -> Item:
        """Adds a segmentation: an array, file or volume whose values are names of kinds, which are never interpolated.

        Parameters
        ----------
        ids
            As for :meth:`add`. Where it is an array, it lies as the scene's first volume of the same shape.
        axes : str, optional
            What an array's axes are, in their order: ``"zyx"`` by default, ``"xyz"`` as in nibabel.
        colors : dict, optional
            Colours of ids; the others have one of ten in turn. 0 is nothing.
        opacity : float or dict
            Opacity of one voxel of a kind, for all ids or by id.

        Raises
        ------
        InvalidValue
            `ids` that are no volume, or `axes` of what is no array.
        """
        data = self._ids_of(ids, axes)
        if not isinstance(data, Volume):
            raise InvalidValue(f"ids: a segmentation is a volume, not {data.kind}", field="ids")
        names = [int(name) for name in np.unique(np.asarray(data)) if name != 0]
        chosen = dict(colors or {})
        known = {name: chosen.get(name, TEN[index % len(TEN)]) for index, name in enumerate(names)}
        opacities = {name: opacity.get(name, 1.0) if isinstance(opacity, Mapping) else opacity for name in names}
        tf = TransferFunction(
            [(0, "#000000"), *known.items()],
            [(0, 0.0), *opacities.items()],
            unit_distance=float(np.mean(data.spacing)),
        )
        return self._add(data, {"labels": True, "tf": tf, **place})

    def _ids_of(self, ids: Any, axes: str | None) -> Data:
        """A segmentation's data; of an array those that lie as the first volume of its shape."""
        if not isinstance(ids, np.ndarray):
            if axes is not None:
                raise InvalidValue(f"axes: names the axes of arrays, and ids are {type(ids).__name__}", field="axes")
            return _foreign.data_of(ids)
        made = Volume(ids, axes=axes or "zyx")
        for item in self.items:
            if isinstance(item.data, Volume) and item.data.shape == made.shape:
                like = item.data
                oriented = bool(like._describe()["is_oriented"])
                affine, unit = like.affine[:, [2, 1, 0, 3]], like.unit or None
                return Volume(np.asarray(made), affine=affine, unit=unit, oriented=oriented)
        return made

    def _add(self, thing: Any, options: Mapping[str, Any]) -> Item:
        reading = {name: value for name, value in options.items() if name in READING}
        options = {name: value for name, value in options.items() if name not in READING}
        data = self._data_of(thing, reading, whole=bool(options.get("labels")))
        keys, rest = item_keys(options, data, is_exact=self._is_exact)
        self._merge(rest)
        item = Item(data, {**data._keys, **keys}, over_look({}, options))
        self.items.append(item)
        return item

    @staticmethod
    def _data_of(thing: Any, reading: Mapping[str, Any], *, whole: bool) -> Data:
        """Data of a thing. Files are read as the command reads them, so that pictures are the same: some in chunks."""
        if whole or not isinstance(thing, (str, os.PathLike)):
            return _foreign.data_of(thing, reading)
        keys = {"file": os.fspath(thing), **tables(reading).get("item", {})}
        return read_item(keys, in_chunks=LazyVolume)

    @property
    def _is_exact(self) -> bool:
        """Whether surfaces lie at their exact places."""
        return bool(self._document.get("effects", {}).get("iso-exact"))

    def _merge(self, keys: Keys) -> None:
        for table, values in keys.items():
            if isinstance(values, dict):
                self._document.setdefault(table, {}).update(values)
            else:
                self._document[table] = values

    def to_dict(self, **overrides: Any) -> Keys:
        """The document: what is said, without what is chosen when it is rendered."""
        below: Keys = {**self._document, "item": [dict(item.keys) for item in self.items]}
        if not overrides:
            return below
        single = self.items[0] if len(self.items) == 1 else None
        functions = [item._function for item in self.items]
        is_changed = single is not None and bool(LOOK.keys() & overrides.keys())
        if single is not None and is_changed:
            rest = {name: value for name, value in overrides.items() if name not in LOOK}
            overrides = {**rest, **over_look(single._look, overrides)}
            below["item"] = [_without_look(single.keys)]
        above = document_of(overrides, single.data if single else None, is_exact=self._is_exact)
        item = above.pop("item", {})
        if is_changed:
            functions = [item.get("transfer-function")]
        if item and single is None:
            raise InvalidValue(
                f"{sorted(overrides)}: looks are the items' in a scene of several: scene.items[0].set(...)",
                field="item",
            )
        if single is not None:
            above["item"] = [{"file": single.keys["file"], **item}]
        text = _core.document_over(json.dumps({"version": 2, **above}), json.dumps(below))
        merged: Keys = json.loads(text)
        for keys, function in zip(merged.get("item", []), functions, strict=True):
            # Another kind of picture has another look that is chosen, but not of what was said.
            if function is not None:
                keys["transfer-function"] = function
        return merged

    def to_toml(self) -> str:
        """The document as a scene's file has it."""
        return _core.document_text(json.dumps(self.to_dict()), "toml")

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Writes the scene as a file, ``.toml`` or ``.json``, that the command renders too.

        Raises
        ------
        InvalidValue
            Where a thing is an array: its file has to be written first. Another ending of the name.
        """
        path = Path(path)
        if path.suffix not in (".toml", ".json"):
            raise InvalidValue(f"path: {str(path)!r} does not end in .toml or .json", field="path", value=str(path))
        arrays = [item.name for item in self.items if str(item.keys["file"]).startswith("array:")]
        if arrays:
            raise InvalidValue(f"{arrays[0]} is an array, and scenes name files: write it to one first", field="item")
        form = "json" if path.suffix == ".json" else "toml"
        _replace(path, _core.document_text(json.dumps(self.to_dict()), form).encode())
        return path

    @property
    def camera(self) -> Camera:
        """The camera: the one that was set, or the one that is chosen."""
        resolved = json.loads(self._picture(self.to_dict()).document())
        return Camera._of_keys(resolved["camera"])

    @camera.setter
    def camera(self, camera: Camera | None) -> None:
        self._document.pop("camera", None)
        if camera is not None:
            self._merge(document_of({"camera": camera}, None))

    def set(self, **options: Unpack[RenderOptions]) -> Scene:
        """Changes camera, method, size and so on; `None` leaves a keyword open again."""
        keys = document_of(options, None)
        if "item" in keys:
            raise InvalidValue("looks are the items': scene.items[0].set(...)", field="item")
        for name in (name for name, value in options.items() if value is None):
            self._open(name)
        self._merge(keys)
        return self

    def _open(self, name: str) -> None:
        """Forgets what a keyword said."""
        if name == "camera":
            self._document.pop("camera", None)
        elif name == "clip":
            for key in ("clip-box", "clip-plane"):
                self._document.get("effects", {}).pop(key, None)
        elif name not in OWN:
            table, key = keywords()[name]
            (self._document.get(table, {}) if table else self._document).pop(key, None)

    def render(
        self,
        *,
        progress: Progress | bool | None = None,
        cancel: _core.Stop | None = None,
        executor: Executor | None = None,
        **overrides: Any,
    ) -> Frame:
        """Renders the scene; keywords hold for this picture only.

        Parameters
        ----------
        progress : callable or bool, optional
            Called with the finished share from 0 to 1, some twenty times a second; returns ``False`` to stop.
            ``True`` prints the share, ``False`` is silent.
        cancel : CancelToken, optional
            Stops the render from another thread: its method ``set``.
        executor : concurrent.futures.Executor, optional
            Workers that render blocks of the picture, the same bytes: processes of this machine, or those of mpi4py.
            The scene's things are files that they read. For Dask see :mod:`splatvol.dask`.

        Raises
        ------
        Cancelled
            The render was stopped.
        """
        if executor is not None:
            from . import _parts

            return _parts.render_on(executor, _parts.recipe(self, **overrides), progress=progress, cancel=cancel)
        document = self.to_dict(**overrides)
        listener = _progress(progress)
        picture = self._picture(document, cancel, listener)
        frame = picture.render(cancel, listener)
        return Frame(frame, picture.document(), int(document.get("bits") or 8))

    def animate(
        self,
        path: str | os.PathLike[str],
        *,
        turntable: float | None = None,
        keys: Sequence[tuple[float, Camera]] | str | os.PathLike[str] | None = None,
        frames: int | None = None,
        fps: float | None = None,
        ease: bool | None = None,
        shutter: float | None = None,
        resume: bool = False,
        progress: Progress | bool | None = None,
        **overrides: Any,
    ) -> Path:
        """Writes an animation: ``.gif``, ``.apng``, a film (``.mp4``, ``.webm``; by ffmpeg), or ``name-####.png``.

        A :class:`Series` in the scene runs once through its times, with one look for all of them.

        Parameters
        ----------
        turntable : float, optional
            Degrees by which the camera turns around its target: 360 unless there are keys.
        keys : sequence of (time, Camera), or path, optional
            Cameras at times, seconds, and a smooth path through them; or a file with such keys.
        frames, fps, ease, shutter
            Number of frames; frames per second; whether it starts and stops gently; share of a frame's time that the
            shutter is open, 0 to 1, which blurs motion.
        resume : bool
            Whether frames that are there already, made by the same settings, are kept.
        progress : callable or bool, optional
            As for :meth:`render`, by frames.

        Examples
        --------
        >>> import splatvol as sv, tempfile, pathlib
        >>> folder = pathlib.Path(tempfile.mkdtemp())
        >>> sv.Scene("sample:head:16", size=24).animate(folder / "spin.gif", frames=4).name
        'spin.gif'
        """
        return animate(
            self,
            path,
            turntable=turntable,
            keys=keys,
            frames=frames,
            fps=fps,
            ease=ease,
            shutter=shutter,
            resume=resume,
            progress=progress,
            **overrides,
        )

    def show(self, **overrides: Any) -> Widget:
        """Shows a copy of the scene in a notebook: see :func:`splatvol.show`."""
        from ._verbs import show

        return show(self, **overrides)

    def artist(self, ax: Axes | None = None, **options: Any) -> SceneArtist:
        """An artist for matplotlib, which is rendered at the resolution at which its figure is drawn or saved.

        It fills its axes with square pixels, in ``savefig(dpi=600)`` and in PDF, too. Without a background of the
        scene's the axes' face shows. It is a ``ScalarMappable``: ``fig.colorbar(artist)`` has the scene's colours.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes that it is added to. Without it, add it: ``ax.add_artist(artist)``, ``fig.add_artist(artist)``.
        **options
            Keywords of :class:`splatvol.RenderOptions`, for this artist only; matplotlib's `norm` is the colour
            bar's, too.

        Examples
        --------
        >>> import matplotlib, splatvol as sv
        >>> matplotlib.use("agg")
        >>> import matplotlib.pyplot as plt
        >>> fig, ax = plt.subplots(figsize=(1, 1), dpi=40)
        >>> artist = sv.Scene("sample:head:16").artist(ax, view="left")
        >>> bar = fig.colorbar(artist)
        >>> fig.canvas.draw()
        """
        try:
            from . import _matplotlib
        except ModuleNotFoundError as error:
            if (error.name or "").split(".")[0] != "matplotlib":
                raise
            raise ImportError("Scene.artist needs matplotlib: pip install matplotlib") from error
        return _matplotlib.artist(self, ax, options)

    def submit(self, **overrides: Any) -> Future[Frame]:
        """Renders in the background: a future of the frame."""
        document = self.to_dict(**overrides)
        return _BACKGROUND.submit(lambda: self.copy().set_document(document).render())

    def set_document(self, document: Keys) -> Scene:
        """Takes over a document whose items are this scene's, one by one."""
        items = document.get("item", [])
        if len(items) != len(self.items):
            raise InvalidValue(f"the document has {len(items)} items, the scene {len(self.items)}", field="item")
        self._document = {key: value for key, value in document.items() if key != "item"}
        for item, keys in zip(self.items, items, strict=True):
            item.keys = dict(keys)
        return self

    def copy(self) -> Scene:
        """A scene of the same data, whose looks and method change on their own."""
        other = Scene()
        other._document = json.loads(json.dumps(self._document))
        for item in self.items:
            again = Item(item.data, dict(item.keys))
            again._said, again._made = item._said, item._made
            other.items.append(again)
        return other

    def _picture(
        self, document: Keys, stop: _core.Stop | None = None, progress: Progress | None = None
    ) -> _core.Picture:
        held = [item._held() for item in self.items]
        picture = _core.Picture(json.dumps(document), held, stop=stop, progress=progress)
        for is_warning, note in picture.notes:
            if is_warning and note not in self._warned:
                self._warned.add(note)
                warnings.warn(note, DataWarning, stacklevel=4)
        return picture

    def _repr_png_(self) -> bytes | None:
        from ._frame import shown

        try:
            return shown(self.render()) if self.items else None
        except SplatvolError:
            return None

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scene):
            return NotImplemented
        same = all(a.data is b.data for a, b in zip(self.items, other.items, strict=False))
        return same and self.to_dict() == other.to_dict()

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[object, ...]:
        # Norms and colour maps may hold functions, which are not pickled: the transfer function that they made is.
        items = [(item.data, item.keys, item._function is not None) for item in self.items]
        return _scene_again, (self._document, items)

    def __repr__(self) -> str:
        return f"<splatvol.Scene of {', '.join(item.name for item in self.items) or 'nothing'}>"


def _scene_again(document: Keys, items: list[tuple[Data | None, Keys, bool]]) -> Scene:
    scene = Scene()
    scene._document = document
    for data, keys, is_made in items:
        look = {"tf": TransferFunction._of_document(keys["transfer-function"])} if is_made else None
        scene.items.append(Item(data, keys, look))
    return scene


def scene_of(document: Keys, rules: Rules = RULES, *, read: bool = True) -> Scene:
    """A scene of a document, its files read."""
    scene = Scene()
    scene._document = {key: value for key, value in document.items() if key != "item"}
    for keys in document.get("item", []):
        visible = keys.get("visible", True)
        scene.items.append(Item(read_item(_reading(keys), rules) if read and visible else None, dict(keys)))
    return scene


def _reading(keys: Keys) -> Keys:
    """The keys that say how a file is read."""
    names = {"file", *(keywords()[name][1] for name in READING)}
    return {name: value for name, value in keys.items() if name in names}


def _progress(progress: Progress | bool | None) -> Progress | None:
    if progress is True:
        import sys

        def show(share: float) -> None:
            sys.stderr.write(f"\r{share:4.0%}" + ("\n" if share >= 1 else ""))
            sys.stderr.flush()

        return show
    if progress is None or progress is False:
        return None
    if not callable(progress):
        raise _checks.refused("progress", progress, "a function of the finished share, True or False")
    return progress


__all__ = ["Clip", "Item", "Scene"]
