"""Pictures that follow a camera: drafts while it moves, the exact picture at rest, on a thread of their own.

The mailbox holds one wish: a newer one takes its place, so that pictures never queue up. At most one picture is under
way to those who look at it; the next one is rendered meanwhile and waits.
"""

from __future__ import annotations

import json
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from . import _core
from ._errors import Cancelled
from ._frame import Frame
from ._vocabulary import Keys

if TYPE_CHECKING:
    from ._scene import Scene

#: Seconds without a newer wish after which the exact picture is made.
REST = 0.15
#: Seconds to wait for word that a picture was shown: a page that was closed says nothing.
PATIENCE = 2.0
#: How much smaller drafts are, finest first.
DIVISORS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0)
#: Settings that the preset ``fast`` decides for drafts.
COSTLY = ("preset", "sheet-thickness", "termination", "coverage")
#: Seconds that a draft may take, and below which a finer one is tried. Its way to the page takes as long again.
SLOW, QUICK = 0.032, 0.014
#: Quick drafts in a row after which a size that was too slow is tried again.
RETRY = 24


@dataclass(frozen=True)
class Shot:
    """A picture on its way to those who look."""

    number: int
    frame: Frame
    is_final: bool
    #: The document's size, which a draft is stretched to.
    size: tuple[int, int]


class Resolved:
    """Pictures of one scene's documents. What a look needs is decided once; then only camera and size change."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._lock = threading.Lock()
        self._known = ""
        self._exact: Keys = {}
        self._draft: Keys | None = None

    def document(self, document: Keys, stop: _core.Stop | None = None) -> Keys:
        """The document with everything decided."""
        apart = ("camera", "size") if is_fixed(document) else ()
        text = json.dumps({key: value for key, value in document.items() if key not in apart}, sort_keys=True)
        with self._lock:
            if text != self._known:
                self._exact = json.loads(self._scene._picture(document, stop).document())
                self._known, self._draft = text, None
            decided = dict(self._exact)
        return {**decided, **{key: document[key] for key in apart if key in document}}

    def draft(self, document: Keys, divisor: float, stop: _core.Stop | None = None) -> Keys:
        """The document of a quick picture of the same look, smaller and by the preset ``fast``."""
        decided = self.document(document, stop)
        with self._lock:
            if self._draft is None:
                said = {key: value for key, value in document.get("settings", {}).items() if key not in COSTLY}
                quick = {**decided, "settings": {**said, "preset": "fast"}}
                self._draft = json.loads(self._scene._picture(quick, stop).document())
            settings = self._draft["settings"]
        width, height = size_of(decided)
        small = f"{max(round(width / divisor), 1)}x{max(round(height / divisor), 1)}"
        return {**decided, "settings": settings, "size": small, "motion": {}}

    def render(self, decided: Keys, stop: _core.Stop) -> Frame:
        """The picture of a document with everything decided."""
        picture = self._scene._picture(decided, stop)
        return Frame(picture.render(stop), picture.document(), int(decided.get("bits") or 8))


def is_fixed(document: Keys) -> bool:
    """Whether a document says all of its camera."""
    camera = document.get("camera", {})
    return {"position", "target", "up"} <= camera.keys() and ("fov" in camera or "orthographic" in camera)


def size_of(document: Keys) -> tuple[int, int]:
    """Width and height of a document with everything decided."""
    width, _, height = str(document["size"]).partition("x")
    return int(width), int(height or width)


class Pace:
    """How much smaller drafts are, by the times that the last ones took."""

    def __init__(self) -> None:
        self._level = 2
        self._times: list[deque[float]] = [deque(maxlen=3) for _ in DIVISORS]
        self._quick = 0

    @property
    def divisor(self) -> float:
        """By what width and height are divided."""
        return DIVISORS[self._level]

    def forget(self) -> None:
        """Takes note that drafts may take another time now."""
        self._times = [deque(maxlen=3) for _ in DIVISORS]

    def took(self, seconds: float) -> None:
        """Takes note of the time of a draft."""
        times = self._times[self._level]
        times.append(seconds)
        self._quick = self._quick + 1 if seconds < QUICK else 0
        # One late draft says little: other work of the computer delays one now and then.
        if len(times) > 1 and _typical(times) > SLOW:
            self._level = self._quicker()
        elif self._level > 0 and self._quick:
            finer = self._times[self._level - 1]
            if self._quick >= RETRY or not finer or _typical(finer) <= SLOW:
                finer.clear()
                self._level -= 1
                self._quick = 0

    def _quicker(self) -> int:
        """The level to go on with where this one is slow."""
        known = {level: _typical(times) for level, times in enumerate(self._times) if times}
        # Smaller is not always quicker: where the last step gained nothing, the next is not tried.
        gains = known[self._level] < known.get(self._level - 1, float("inf"))
        coarser = self._level + 1
        if coarser < len(DIVISORS) and (gains if coarser not in known else known[coarser] <= SLOW):
            return coarser
        return min(known, key=known.__getitem__)


def _typical(times: deque[float]) -> float:
    return sorted(times)[(len(times) - 1) // 2]


class Progressive:
    """A mailbox of one, and the thread that serves it; the thread lives only while there is something to do.

    Parameters
    ----------
    scene : Scene
        Whose data are shown.
    present : callable
        Called with each :class:`Shot`, on the thread; :meth:`shown` has to follow before the next one.
    failed : callable
        Called with what went wrong, on the thread.
    """

    def __init__(self, scene: Scene, present: Callable[[Shot], object], failed: Callable[[Exception], object]) -> None:
        self.resolved = Resolved(scene)
        self._present = present
        self._failed = failed
        self._change = threading.Condition()
        self._thread: threading.Thread | None = None
        self._wish: str | None = None
        self._is_draft_due = False
        self._final_due = 0.0
        self._stop = _core.Stop()
        self._number = 0
        self._unseen: int | None = None
        self._is_closed = False
        self._pace = Pace()

    def ask(self, document: Keys, *, moving: bool, drafts: bool = True) -> None:
        """Wishes for a picture of the document: a draft first where it is `moving`, and the exact one at rest.

        Without `drafts`, somebody else draws them.
        """
        text = json.dumps(document)
        with self._change:
            if self._is_closed:
                return
            self._wish, self._is_draft_due = text, moving and drafts
            self._final_due = time.monotonic() + (REST if moving else 0.0)
            # A draft is never stopped by a newer wish: there is one with every move, and none would be finished.
            self._stop.set()
            if self._thread is None:
                self._thread = threading.Thread(target=self._serve, name="splatvol-widget", daemon=True)
                self._thread.start()
            self._change.notify_all()

    def shown(self, number: int) -> None:
        """Takes note that a picture was shown."""
        with self._change:
            if number == self._unseen:
                self._unseen = None
                self._change.notify_all()

    def look_changed(self) -> None:
        """Takes note that drafts may now take another time."""
        self._pace.forget()

    def close(self) -> None:
        """Stops what is under way, for good."""
        with self._change:
            self._is_closed = True
            self._wish = None
            self._stop.set()
            self._change.notify_all()

    def join(self, timeout: float | None = None) -> bool:
        """Waits until there is nothing more to do; returns whether that is so."""
        thread = self._thread
        if thread is not None:
            thread.join(timeout)
        return self._thread is None

    def _serve(self) -> None:
        while (job := self._next()) is not None:
            document, is_draft, stop = job
            try:
                self._make(json.loads(document), is_draft, stop)
            except Cancelled:
                continue
            except Exception as error:
                # Whatever it is, the one who looks should read it; a thread has nobody else to tell.
                self._failed(error)

    def _next(self) -> tuple[str, bool, _core.Stop] | None:
        """The next picture to make; `None` ends the thread."""
        with self._change:
            while True:
                if self._wish is None:
                    self._thread = None
                    return None
                if self._is_draft_due:
                    self._is_draft_due = False
                    # Nothing sets this flag: see `ask`.
                    return self._wish, True, _core.Stop()
                wait = self._final_due - time.monotonic()
                if wait <= 0:
                    document, self._wish = self._wish, None
                    self._stop = _core.Stop()
                    return document, False, self._stop
                self._change.wait(wait)

    def _make(self, document: Keys, is_draft: bool, stop: _core.Stop) -> None:
        size = size_of(self.resolved.document(document, stop))
        if is_draft:
            decided = self.resolved.draft(document, self._pace.divisor, stop)
            start = time.perf_counter()
            frame = self.resolved.render(decided, stop)
            self._pace.took(time.perf_counter() - start)
        else:
            frame = self.resolved.render(self.resolved.document(document, stop), stop)
        with self._change:
            self._change.wait_for(lambda: self._unseen is None or self._is_closed or stop.is_set(), PATIENCE)
            if self._is_closed or stop.is_set():
                return
            self._number += 1
            self._unseen = self._number
        self._present(Shot(self._unseen, frame, not is_draft, size))
