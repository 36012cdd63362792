"""The verbs: read, render, compare, and so on."""

from __future__ import annotations

import errno
import json
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from . import _checks, _core, _foreign
from ._data import Progress, Rules, read_item
from ._errors import InvalidValue
from ._frame import Frame
from ._scene import Scene, scene_of
from ._vocabulary import check, tables

#: More threads than any machine has.
MOST_THREADS = 1 << 16

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from ._render_options import ReadOptions, RenderOptions
    from ._widget import Widget


def read(
    source: Any,
    *,
    strict: bool = False,
    allow_outside: bool = False,
    max_memory: int | None = None,
    progress: Progress | None = None,
    **options: Unpack[ReadOptions],
) -> Any:
    """Reads data: a file, a folder, ``"sample:NAME"``, or an object of another package.

    Parameters
    ----------
    source
        Path, or an array, or an object of nibabel, SimpleITK, itk, xarray, zarr, dask, PyVista, VTK or napari.
    strict : bool
        Whether oddities of the file are errors.
    allow_outside : bool
        Whether links are followed that lead out of the folder of the file.
    max_memory : int, optional
        Most bytes of samples; half of the machine's memory by default.
    **options
        Keywords of :class:`splatvol.ReadOptions`: `level`, `channel`, `time`, `array`...

    Returns
    -------
    Volume, Mesh, Points or Gaussians
        Which one, the file decides; to type checkers it is any.

    Examples
    --------
    >>> import splatvol as sv
    >>> sv.read("sample:head:16").shape
    (16, 16, 16)
    """
    rules = Rules(strict, allow_outside, max_memory)
    if isinstance(source, (str, os.PathLike)):
        check(options)
        keys = tables(options).get("item", {})
        return read_item({"file": os.fspath(source), **keys}, rules, progress=progress)
    return _foreign.data_of(source, options, rules)


def info(source: Any) -> dict[str, Any]:
    """What is known about data: format, dimensions, range, levels, channels, warnings."""
    return dict(_foreign.data_of(source)._describe())


def render(
    data: Any,
    *,
    progress: Progress | bool | None = None,
    cancel: _core.Stop | None = None,
    executor: Executor | None = None,
    **options: Unpack[RenderOptions],
) -> Frame:
    """Renders data, as the command ``splatvol render`` does: the same pixels.

    Parameters
    ----------
    data
        Anything that :func:`read` takes, a :class:`Scene`, or napari's viewer: what it shows.
    progress, cancel, executor
        See :meth:`Scene.render`.
    **options
        Keywords of :class:`splatvol.RenderOptions`: the command's flags with ``_`` for ``-``.

    Examples
    --------
    >>> import numpy as np, splatvol as sv
    >>> frame = sv.render(np.ones((8, 8, 8), np.float32), size=16)
    >>> np.asarray(frame).shape
    (16, 16, 4)
    """
    if executor is not None:
        from . import _parts

        return _parts.render_on(executor, _parts.recipe(data, **options), progress=progress, cancel=cancel)
    if isinstance(data, Scene):
        return data.render(progress=progress, cancel=cancel, **options)
    if type(data).__module__.startswith("napari.") and hasattr(data, "dims"):
        from ._napari.viewer import render_viewer

        return render_viewer(data, progress=progress, cancel=cancel, **options)
    return Scene(data, **options).render(progress=progress, cancel=cancel)


def animate(data: Any, path: str | os.PathLike[str], **options: Any) -> Path:
    """Writes an animation of data or a scene: see :meth:`Scene.animate`, which has the keywords."""
    scene = data if isinstance(data, Scene) else Scene(data)
    return scene.animate(path, **options)


def show(data: Any, *, engine: str = "auto", **options: Unpack[RenderOptions]) -> Widget:
    """Shows data in a notebook: a widget that turns, zooms and edits them.

    Parameters
    ----------
    data
        Anything that :func:`read` takes, or a :class:`Scene`, which is copied.
    engine : str
        Who draws while something moves: ``"auto"``, the page where it can, also if the kernel is busy, or
        ``"kernel"``, which sends no data to the page. At rest it is always the kernel.
    **options
        Keywords of :class:`splatvol.RenderOptions`; `size` is (640, 480) by default.

    Raises
    ------
    ImportError
        Where anywidget is not installed.

    Examples
    --------
    >>> import splatvol as sv
    >>> sv.show("sample:head:16", size=32)
    <splatvol.Widget of <splatvol.Scene of sample:head:16>>
    """
    try:
        from ._widget import widget_of
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("anywidget", "ipywidgets", "traitlets"):
            raise
        raise ImportError("show() needs the package anywidget: pip install anywidget") from error
    return widget_of(data, dict(options), engine)


def like(
    picture: str | os.PathLike[str],
    data: Any = None,
    *,
    strict: bool = False,
    allow_outside: bool = False,
    max_memory: int | None = None,
    time: int | None = None,
) -> Scene:
    """The scene of a picture that splatvol made, by what its file says.

    Files that the picture names are looked for in the current folder, then in the picture's, as ``--like`` does. What
    lies elsewhere is read with `allow_outside` only: whoever made the picture chose it.

    Parameters
    ----------
    picture : path
        A picture that carries its document.
    data : optional
        Takes the place of its only item: necessary where that was an array.
    strict, allow_outside, max_memory
        Rules for files, as in :func:`read`.
    time : int, optional
        Another time point of its only item.

    Raises
    ------
    InvalidValue
        The picture names files elsewhere, or arrays; `data` or `time` for a picture of several things.
    """
    rules = Rules(strict, allow_outside, max_memory)
    text, outside = _core.read_like(os.fspath(picture), data is not None)
    if outside is not None and not allow_outside:
        other = "" if data is not None else ", or like(picture, data) for other data"
        message = (
            f"{os.fspath(picture)} names {outside}, which lies outside its folder and the current one:"
            f" write like(picture, allow_outside=True){other}"
        )
        raise InvalidValue(message, field="picture")
    document = json.loads(text)
    items = document.get("item", [])
    if data is None:
        arrays = [keys["file"] for keys in items if keys["file"].startswith("array:")]
        if arrays:
            message = (
                f"{os.fspath(picture)}: {arrays[0].removeprefix('array:')} was an array: write like(picture, data)"
            )
            raise InvalidValue(message, field="data")
        if time is not None:
            only_item(picture, items, "time")["time"] = time
        return scene_of(document, rules)
    only_item(picture, items, "data")
    if not isinstance(data, (str, os.PathLike)):
        # Leave to read the picture's files elsewhere; the data are no file.
        rules = replace(rules, allow_outside=False)
    scene = Scene(_foreign.data_of(data, {"time": time}, rules))
    scene._document = {key: value for key, value in document.items() if key != "item"}
    chosen = {} if time is None else {"time": time}
    scene.items[0].keys = {**items[0], **chosen, "file": scene.items[0].keys["file"]}
    return scene


def only_item(picture: str | os.PathLike[str], items: list[dict[str, Any]], field: str) -> dict[str, Any]:
    """The one item of a picture that a keyword is about."""
    if len(items) != 1:
        raise InvalidValue(f"{os.fspath(picture)}: it shows {len(items)} things, not one", field=field)
    return items[0]


def load(path: str | os.PathLike[str]) -> Scene:
    """The scene of a scene's file, TOML or JSON.

    Raises
    ------
    FileNotFoundError
        There is no such file.
    InvalidValue
        A file that is no scene; an address or a sample.
    FormatError
        A scene with keys or values that do not exist.
    """
    name = os.fspath(path)
    no_scene = InvalidValue(f"{name} is no scene: splatvol.read reads data", field="path")
    if not os.path.exists(name):
        if "://" in name or name.startswith("sample:"):
            raise no_scene
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), name)
    text = _core.read_document(name)
    if text is None:
        raise no_scene
    return scene_of(json.loads(text))


def set_threads(count: int | None) -> None:
    """Sets how many threads of this process render: one for each processor where it is `None`. No byte changes.

    Raises
    ------
    InvalidValue
        What is no whole number above 0.
    """
    if count is not None:
        count = _checks.whole(count, "threads", 1, MOST_THREADS, "a whole number above 0, or None")
    _core.set_threads(count)


def samples() -> dict[str, str]:
    """Built-in volumes, generated on the spot, and what they are: ``read("sample:NAME")``."""
    return dict(_core.samples())


def colormaps() -> list[str]:
    """Names of splatvol's colour maps; matplotlib's are understood too."""
    return list(_core.colormaps())


@dataclass(frozen=True)
class Difference:
    """How far two pictures are apart, in codes from 0 to 255."""

    #: Peak signal to noise ratio, decibels; infinite for equal pictures.
    psnr: float
    #: Largest difference of a channel.
    maximum: int
    #: Mean difference of the channels.
    mean: float
    #: Row and column of the largest difference.
    where: tuple[int, int]
    #: Share of pixels that differ.
    share: float
    #: Structural similarity (Wang et al. 2004), of the worst of red, green and blue, over windows of 8 x 8 pixels.
    ssim: float


def compare(a: Any, b: Any) -> Difference:
    """How far two pictures are apart: frames, arrays or paths of pictures.

    Raises
    ------
    InvalidValue
        Pictures of different sizes.
    """
    one, other = pixels_of(a).astype(np.int32), pixels_of(b).astype(np.int32)
    if one.shape != other.shape:
        raise InvalidValue(f"the pictures have shapes {one.shape} and {other.shape}", field="size")
    apart = np.abs(one - other)
    square = float(np.mean(apart.astype(float) ** 2))
    worst = apart.max(axis=2)
    row, column = np.unravel_index(int(worst.argmax()), worst.shape)
    return Difference(
        psnr=float("inf") if square == 0 else float(10 * np.log10(255**2 / square)),
        maximum=int(worst.max()),
        mean=float(apart.mean()),
        where=(int(row), int(column)),
        share=float((worst > 0).mean()),
        ssim=min(_similarity(one[..., channel], other[..., channel]) for channel in range(3)),
    )


def _similarity(one: Any, other: Any) -> float:
    """Structural similarity of two planes, as the command's: (co)variances are sums, windows count by their areas."""

    def sums(values: Any) -> Any:
        columns = np.add.reduceat(values.astype(float), np.arange(0, values.shape[1], 8), axis=1)
        return np.add.reduceat(columns, np.arange(0, values.shape[0], 8), axis=0)

    area = sums(np.ones(one.shape))
    means = [sums(one) / area, sums(other) / area]
    of_one, of_other, both = (
        sums(a * b) - area * p * q
        for a, b, p, q in [
            (one, one, means[0], means[0]),
            (other, other, means[1], means[1]),
            (one, other, means[0], means[1]),
        ]
    )
    small = [2.55**2, 7.65**2]
    luminance = (2 * means[0] * means[1] + small[0]) / (means[0] ** 2 + means[1] ** 2 + small[0])
    structure = (2 * both + small[1]) / (of_one + of_other + small[1])
    return float((luminance * structure * area).sum() / area.sum())


def pixels_of(picture: Any) -> Any:
    """The codes of a picture: a frame's, an array's, or those of a file, PNG or EXR; height x width x 4."""
    if isinstance(picture, (str, os.PathLike)):
        width, height, stored = _core.read_picture(os.fspath(picture))
        return np.frombuffer(stored, np.uint8).reshape(height, width, 4)
    codes: Any = np.asarray(picture)
    if codes.ndim != 3 or codes.shape[2] not in (3, 4) or codes.dtype != np.uint8:
        raise InvalidValue(f"an array of shape {codes.shape} and type {codes.dtype} is no picture", field="picture")
    if codes.shape[2] == 3:
        codes = np.concatenate([codes, np.full((*codes.shape[:2], 1), 255, np.uint8)], axis=2)
    return codes
