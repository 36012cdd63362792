"""Animations: a camera that moves, or data that change, frame by frame into one file or many."""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _core
from ._camera import Camera
from ._data import Progress, Volume
from ._errors import Cancelled, InvalidValue
from ._frame import Frame, _replace
from ._options import OWN
from ._series import Series
from ._vocabulary import Keys, check

if TYPE_CHECKING:
    from ._scene import Scene

#: Keywords of animations.
KEYWORDS = ("turntable", "keys", "frames", "fps", "ease", "shutter", "resume", "progress")


def animate(
    scene: Scene,
    output: str | os.PathLike[str],
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
    """Writes an animation of a scene: see :meth:`splatvol.Scene.animate`."""
    asked = {"turntable": turntable, "keys": keys, "frames": frames, "fps": fps, "ease": ease, "shutter": shutter}
    film = Film(scene, animation_document(scene, asked, overrides))
    return write(film, Path(output), resume=resume, progress=progress)


def animation_document(scene: Scene, asked: dict[str, Any], overrides: dict[str, Any]) -> Keys:
    """The document of a scene with the table of an animation."""
    check(overrides, (*OWN, *KEYWORDS))
    return {**scene.to_dict(**overrides), "animation": _table(**asked)}


def write(film: Film, output: Path, *, resume: bool, progress: Progress | bool | None) -> Path:
    """Writes frames to one file, or a file each."""
    if "#" in output.name:
        return film.write_frames(output, resume=resume, progress=progress)
    if resume:
        raise InvalidValue("resume: frames can be continued, name-####.png, one file cannot", field="resume")
    return film.write_movie(output, progress=progress)


def _table(*, keys: Any, **rest: Any) -> Keys:
    """The document's table of an animation."""
    table = {name: value for name, value in rest.items() if value is not None}
    if keys is None:
        return table
    if isinstance(keys, (str, os.PathLike)):
        return {**table, "path": os.fspath(keys)}
    return {**table, "key": [{"time": float(time), **_key(camera)} for time, camera in keys]}


def _key(camera: Camera) -> Keys:
    if not isinstance(camera, Camera):
        raise InvalidValue("keys: expected pairs of a time and a Camera", field="keys")
    return camera._keys()


class Film:
    """The frames of an animation: each a document, rendered when it is due."""

    def __init__(self, scene: Scene, document: Keys) -> None:
        self._scene = scene
        self._series = [item.data for item in scene.items if isinstance(item.data, Series)]
        held = [item._held() for item in scene.items]
        self._animation = _core.Animation(json.dumps(document), held)

    def __len__(self) -> int:
        return self._animation.frames

    def picture(self, index: int) -> tuple[_core.Picture, str]:
        """The picture of a frame, and its document."""
        text = self._animation.document(index)
        held = [item._held(index, len(self)) for item in self._scene.items]
        return _core.Picture(text, held), text

    def frames(self, indices: Sequence[int]) -> Iterator[tuple[int, Frame]]:
        """Some of the frames, in order."""
        for index in indices:
            picture, text = self.picture(index)
            yield index, Frame(picture.render(), text, int(json.loads(text).get("bits") or 8))

    def files(self, indices: Sequence[int], extension: str) -> Iterator[tuple[int, bytes]]:
        """Some of the frames, in order, as files."""
        for index, frame in self.frames(indices):
            yield index, frame._encoded(extension)

    def write_frames(self, output: Path, *, resume: bool, progress: Progress | bool | None) -> Path:
        """A picture of each frame: ``name-####.png``."""
        before, _, after = output.name.partition("#")
        digits = 1 + len(after) - len(after.lstrip("#"))
        after = after.lstrip("#")
        if "#" in after:
            raise InvalidValue(f"{output}: all # of a name must be together", field="path")
        if len(str(len(self) - 1)) > digits:
            raise InvalidValue(f"{output}: {len(self)} frames need more # in the name", field="path")
        paths = [output.with_name(f"{before}{index:0{digits}d}{after}") for index in range(len(self))]
        missing = [index for index, path in enumerate(paths) if not (resume and self._is_made(path, index))]
        self._report(progress, len(self) - len(missing))
        files = self.files(missing, output.suffix.removeprefix("."))
        for count, (index, file) in enumerate(files, len(self) - len(missing) + 1):
            _replace(paths[index], file)
            self._report(progress, count)
        return output

    def _report(self, progress: Progress | bool | None, count: int) -> None:
        from ._scene import _progress

        report = _progress(progress)
        if report is not None and report(count / len(self)) is False:
            raise Cancelled("stopped before the animation was finished")

    def _is_made(self, path: Path, index: int) -> bool:
        """Whether the file holds the frame that would be made: its own record says so."""
        if not path.exists():
            return False
        try:
            text, _ = _core.read_record(path)
        except (ValueError, OSError):
            return False
        return _named(text) == _named(self._animation.document(index))

    def write_movie(self, output: Path, *, progress: Progress | bool | None) -> Path:
        """One file of all frames, complete or not there at all."""
        if not output.absolute().parent.is_dir():
            raise FileNotFoundError(f"folder {output.parent} does not exist")
        handle, scratch = tempfile.mkstemp(prefix=".", suffix=output.suffix, dir=output.absolute().parent)
        os.close(handle)
        movie: _core.Movie | None = None
        try:
            for index, frame in self.frames(range(len(self))):
                if movie is None:
                    record = (frame.document, "splatvol for Python")
                    movie = _core.Movie(scratch, output, frame._core, (len(self), self._animation.rate), record)
                movie.write(frame._core)
                self._report(progress, index + 1)
            if movie is not None:
                movie.finish()
            os.chmod(scratch, 0o644)
            os.replace(scratch, output)
        finally:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(scratch)
        return output


def _named(text: str) -> Keys:
    """A document whose files have no folders: pictures carry their names alone."""
    document: Keys = json.loads(text)
    for item in document.get("item", []):
        item["file"] = Path(item["file"]).name
    return document


def volume_at(series: Series, frame: int, frames: int) -> Volume:
    """The volume of a series that a frame shows: all its times over all the frames."""
    return series[min(frame * len(series) // max(frames, 1), len(series) - 1)]
