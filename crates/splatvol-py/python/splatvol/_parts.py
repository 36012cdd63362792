"""Pictures by many processes: recipes, parts, and who puts them together.

A recipe is text, a part is bytes; nothing else passes between processes. A part follows from recipe and key, so to make
one twice is harmless, and the parts together are the picture that :func:`splatvol.render` makes, bit for bit.
"""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from functools import lru_cache
from pathlib import Path
from typing import Any, Unpack

from . import _core
from ._data import Progress
from ._errors import Cancelled, DataWarning, InvalidValue
from ._frame import Frame
from ._options import READING
from ._render_options import RenderOptions
from ._scene import Item, Scene, _progress
from ._vocabulary import tables

#: Pixels along the edges of blocks, if nobody says otherwise: two or three for each process keep all busy.
BLOCK = 512
#: Seconds between two looks whether the render was stopped.
SLICE = 0.05


def recipe(data: Any, **options: Unpack[RenderOptions]) -> str:
    """The recipe of a picture, JSON: a scene with nothing left open, whose paths lead to its files from any folder.

    Parameters
    ----------
    data
        A file, which is not read here; or a :class:`Scene` of files.
    **options
        Keywords of :class:`splatvol.RenderOptions`.

    Raises
    ------
    InvalidValue
        Where a thing is an array: other processes read files.

    Examples
    --------
    >>> import splatvol as sv
    >>> made = sv.recipe("sample:head:16", size=32)
    >>> sv.assemble(sv.part(made, f"{i}/4") for i in range(4)).size
    (32, 32)
    """
    scene, options = of_files(data, options)
    arrays = [item.name for item in scene.items if str(item.keys["file"]).startswith("array:")]
    if arrays:
        raise InvalidValue(
            f"{arrays[0]} is an array, and other processes read files: write it to one first", field="data"
        )
    return _core.recipe_of(scene._picture(scene.to_dict(**options)))


def of_files(data: Any, options: Any) -> tuple[Scene, Any]:
    """A scene, and the rest of the keywords. A file is not read here: whoever makes parts reads what these need."""
    if isinstance(data, Scene):
        return data, options
    reading = {name: value for name, value in options.items() if name in READING}
    rest = {name: value for name, value in options.items() if name not in READING}
    if not isinstance(data, (str, os.PathLike)):
        return Scene(data, **reading), rest
    scene = Scene()
    scene.items.append(Item(None, {"file": os.fspath(data), **tables(reading).get("item", {})}))
    return scene, rest


def _picture_of(recipe: str, memory: int | None) -> _core.Picture:
    """The picture of a recipe, whose files are as they are now."""
    return _kept_picture(recipe, memory, _state_of(recipe))


@lru_cache(maxsize=2)
def _kept_picture(recipe: str, memory: int | None, _state: tuple[object, ...]) -> _core.Picture:
    """The picture of a recipe; the last ones are kept, with what was read and prepared for them."""
    items = json.loads(recipe).get("item", [])
    return _core.Picture(recipe, [None] * len(items), memory=memory)


def _state_of(recipe: str) -> tuple[object, ...]:
    """Sizes and times of the files that a recipe names; of Zarr those of the metadata, not of the chunks."""
    files: list[Path] = []
    for path in map(Path, _core.paths_of(recipe)):
        files += [path, *(sorted(path.iterdir()) if path.is_dir() else [])]
    states = [(str(path), path.stat()) for path in files if path.exists()]
    return tuple((name, state.st_size, state.st_mtime_ns) for name, state in states)


def part(recipe: str, key: str, *, memory: int | None = None, progress: Progress | bool | None = None) -> bytes:
    """Makes a part of a picture, as ``splatvol part`` does.

    The process keeps what it read for the last recipes, so that its next parts of them cost less, unless the files have
    changed. Parts of files that changed meanwhile are not put together: each holds the lengths of its files and a hash
    of pieces of them (of Zarr those of the metadata, not of the chunks).

    Parameters
    ----------
    recipe : str
        What :func:`recipe` returned.
    key : str
        ``"X,Y,WIDTHxHEIGHT"``, pixels; or ``"I/N"``, the I-th of N blocks, from 0.
    memory : int, optional
        Budget for volumes that are read in chunks, bytes; half of the machine's memory by default.
    progress : callable or bool, optional
        As for :meth:`Scene.render`.

    Raises
    ------
    InvalidValue
        The picture has no such block.
    FormatError
        A file that is damaged or not there; of volumes in chunks with level, chunk and key.
    """
    return _core.part_of(_picture_of(recipe, memory), key, progress=_progress(progress))


def assemble(parts: Iterable[bytes]) -> Frame:
    """Puts parts together, in any order, and some of them twice.

    Raises
    ------
    FormatError
        Pixels without a part, damaged parts, or parts of different recipes, programs or instruction sets.
    """
    frame, holes = assembled(parts)
    warn_of_holes(holes)
    return frame


def assembled(parts: Iterable[bytes]) -> tuple[Frame, int]:
    """The parts together, and how many chunks were lost."""
    core, document, holes = _core.assembled(list(parts))
    return Frame(core, document, int(json.loads(document).get("bits") or 8)), holes


def warn_of_holes(holes: int) -> None:
    """Says that a picture has some."""
    if holes:
        warnings.warn(f"{holes} chunks were lost, and are holes in the picture", DataWarning, stacklevel=3)


def blocks(recipe: str, edge: int = BLOCK) -> list[str]:
    """The keys of the blocks, `edge` pixels wide and high, that make up the picture of a recipe."""
    width, _, height = str(json.loads(recipe)["size"]).partition("x")
    return _core.blocks_of((int(width), int(height or width)), edge)


def render_on(
    executor: Executor,
    recipe: str,
    *,
    block: int = BLOCK,
    memory: int | None = None,
    progress: Progress | bool | None = None,
    cancel: _core.Stop | None = None,
) -> Frame:
    """Renders a recipe's picture by the workers of an executor."""
    futures = [executor.submit(part, recipe, key, memory=memory) for key in blocks(recipe, block)]
    try:
        return assemble(_finished(futures, _progress(progress), cancel))
    finally:
        for future in futures:
            future.cancel()


def _finished(futures: list[Future[bytes]], report: Progress | None, cancel: _core.Stop | None) -> Iterator[bytes]:
    """What futures return, as they end; the first that fails raises."""
    pending = set(futures)
    while pending:
        done, pending = wait(pending, timeout=SLICE, return_when=FIRST_COMPLETED)
        for future in done:
            yield future.result()
        share = 1 - len(pending) / len(futures)
        if (cancel is not None and cancel.is_set()) or (report is not None and report(share) is False):
            raise Cancelled("the render was stopped")
