"""Pictures and animations on a Dask cluster: the bits of one machine, whatever the number of workers, and if some die.

Workers get a recipe and the key of a block, read what they need from the files, and return the block's pixels. So the
files lie where all workers can read them at the same path. Nothing here schedules: Dask does.

>>> import splatvol.dask, splatvol as sv
>>> from dask.distributed import Client
>>> with Client(processes=False, n_workers=1, dashboard_address=":0") as client:
...     frame = splatvol.dask.render("sample:head:16", client, size=32)
>>> frame.size
(32, 32)
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _core, _parts
from ._animation import Film, animation_document, write
from ._camera import Camera
from ._data import Progress
from ._errors import Cancelled
from ._frame import Frame
from ._scene import Scene, _progress

try:
    from distributed import as_completed, default_client, get_worker
except ImportError as error:
    raise ImportError('splatvol.dask needs Dask: pip install "splatvol[dask]"') from error

if TYPE_CHECKING:
    from distributed import Client, Future

#: Frames that are under way for each thread of the cluster, so that none waits for the one that writes them.
AHEAD = 2


def render(
    data: Any,
    client: Client | None = None,
    *,
    block: int = _parts.BLOCK,
    memory: int | None = None,
    retries: int = 0,
    progress: Progress | bool | None = None,
    **options: Any,
) -> Frame:
    """Renders data or a scene of files on a cluster: the pixels of :func:`splatvol.render`.

    Parameters
    ----------
    data
        A file, which workers read, in chunks where it has any; or a :class:`splatvol.Scene` of files.
    client : distributed.Client, optional
        The cluster; the current one by default.
    block : int
        Pixels along the edges of blocks, each a task. The pixels do not depend on it.
    memory : int, optional
        Budget of a task for volumes that are read in chunks, bytes; by default half of the worker's memory, divided by
        its threads.
    retries : int
        How often a task is run again that has failed, where stores fail now and then. Tasks of workers that died run
        again without it.
    progress : callable or bool, optional
        As for :meth:`splatvol.Scene.render`, by blocks.
    **options
        Keywords of :class:`splatvol.RenderOptions`.

    Raises
    ------
    InvalidValue
        Where a thing is an array: workers read files.
    FormatError
        A file that is damaged, or not there for a worker.
    """
    client = default_client() if client is None else client
    recipe = _parts.recipe(data, **options)
    futures = _submit(client, recipe, block, memory, retries, priority=0)
    try:
        return _parts.assemble(_finished(futures, _progress(progress)))
    finally:
        client.cancel(futures)


def animate(
    data: Any,
    path: str | os.PathLike[str],
    client: Client | None = None,
    *,
    turntable: float | None = None,
    keys: Sequence[tuple[float, Camera]] | str | os.PathLike[str] | None = None,
    frames: int | None = None,
    fps: float | None = None,
    ease: bool | None = None,
    shutter: float | None = None,
    resume: bool = False,
    block: int = _parts.BLOCK,
    memory: int | None = None,
    retries: int = 0,
    progress: Progress | bool | None = None,
    **options: Any,
) -> Path:
    """Writes an animation whose frames a cluster renders: the bytes of :func:`splatvol.animate`, its keywords.

    Frames are rendered ahead of the one that is written, two for each thread of the cluster.
    """
    client = default_client() if client is None else client
    scene, options = _parts.of_files(data, options)
    asked = {"turntable": turntable, "keys": keys, "frames": frames, "fps": fps, "ease": ease, "shutter": shutter}
    film = _ClusterFilm(scene, animation_document(scene, asked, options), (client, block, memory, retries))
    return write(film, Path(path), resume=resume, progress=progress)


class _ClusterFilm(Film):
    """Frames that a cluster renders."""

    def __init__(self, scene: Scene, document: dict[str, Any], means: tuple[Client, int, int | None, int]) -> None:
        super().__init__(scene, document)
        self._means = means

    def frames(self, indices: Sequence[int]) -> Iterator[tuple[int, Frame]]:
        for index, text, parts in self._rendered(indices, lambda _, parts: parts):
            frame = _parts.assemble(_finished(parts, None))
            yield index, Frame(frame._core, text, frame._bits)

    def files(self, indices: Sequence[int], extension: str) -> Iterator[tuple[int, bytes]]:
        """Workers put the parts together and encode them: only the writing is left."""
        client = self._means[0]

        def encode(text: str, parts: list[Future]) -> list[Future]:
            name = hashlib.sha256(json.dumps([text, extension, [part.key for part in parts]]).encode()).hexdigest()[:20]
            return [client.submit(_file, parts, text, extension, key=f"splatvol-file-{name}")]

        for index, _, [file] in self._rendered(indices, encode):
            data, holes = file.result()
            _parts.warn_of_holes(holes)
            yield index, data

    def _rendered(
        self, indices: Sequence[int], then: Callable[[str, list[Future]], list[Future]]
    ) -> Iterator[tuple[int, str, list[Future]]]:
        """Frames in order, each with its document and what becomes of its parts, which are under way."""
        client, block, memory, retries = self._means
        ahead = AHEAD * max(1, sum(client.nthreads().values()))
        under_way: dict[int, tuple[str, list[Future]]] = {}
        try:
            for place, index in enumerate(indices):
                for coming in indices[place : place + ahead]:
                    if coming not in under_way:
                        picture, text = self.picture(coming)
                        recipe = _core.recipe_of(picture)
                        parts = _submit(client, recipe, block, memory, retries, priority=-coming)
                        under_way[coming] = text, then(text, parts)
                yield index, *under_way.pop(index)
        finally:
            client.cancel([future for _, futures in under_way.values() for future in futures])


def _submit(
    client: Client, recipe: str, block: int, memory: int | None, retries: int, *, priority: int
) -> list[Future]:
    """A future per block. Dask knows tasks by their keys: the same recipe and program is the same result."""
    name = hashlib.sha256(json.dumps([_core.__version__, recipe, memory]).encode()).hexdigest()[:20]
    # The recipe goes with each task: what is scattered is lost with the worker that has it.
    return [
        client.submit(_part, recipe, key, memory, key=f"splatvol-{name}-{key}", retries=retries, priority=priority)
        for key in _parts.blocks(recipe, block)
    ]


def _part(recipe: str, key: str, memory: int | None) -> bytes:
    """A part, by as many threads and within as much memory as the worker has."""
    worker = get_worker()
    threads = worker.state.nthreads
    if _core.threads() != threads:
        _core.set_threads(threads)
    limit = worker.memory_manager.memory_limit
    if memory is None and limit:
        memory = int(limit) // (2 * threads)
    return _parts.part(recipe, key, memory=memory)


def _file(parts: list[bytes], document: str, extension: str) -> tuple[bytes, int]:
    """The file of a frame, from its parts, and how many chunks were lost."""
    frame, holes = _parts.assembled(parts)
    return Frame(frame._core, document, frame._bits)._encoded(extension), holes


def _finished(futures: list[Future], report: Progress | None) -> Iterable[bytes]:
    # The loop of this client: by default it is that of the last one, in which its events must not be waited for.
    loop = futures[0].client.loop if futures else None
    for count, future in enumerate(as_completed(futures, loop=loop), 1):
        # What was lost with its worker meanwhile is waited for again.
        yield future.result()
        if report is not None and report(count / len(futures)) is False:
            raise Cancelled("the render was stopped")


__all__ = ["animate", "render"]
