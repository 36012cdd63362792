"""The engine for browsers, with data that are made to fit, on its way to the pages of a widget.

A page that has them draws by itself while the camera moves, also where the kernel is busy; by WebGPU where it has a
device, and has asked for the GPU engine. They are sent in pieces, by a thread, and not faster than a notebook's server
lets messages through: 1 MB per second (``iopub_data_rate_limit``).
"""

from __future__ import annotations

import hashlib
import json
import threading
import time
from collections.abc import Callable
from functools import cache
from typing import Literal

from . import _core
from ._vocabulary import Keys

#: Most bytes of data that a page gets, packed.
MOST_BYTES = 4_000_000
#: Bytes of a piece, and the pause after it, seconds.
PIECE = 1 << 18
PAUSE = 0.4

#: What a page asks for: engine and data, data alone, or the GPU engine.
Wish = Literal["scene", "data", "gpu"]
Send = Callable[..., object]


@cache
def engine() -> tuple[str, bytes] | None:
    """The engine and its digest; `None` where the package was built without it."""
    module = _core.browser_engine()
    return None if module is None else (_digest(module), module)


def notice() -> str | None:
    """A sentence where the engine was built of other sources than the package."""
    return _core.browser_notice()


@cache
def gpu_engine() -> tuple[str, bytes, bytes] | None:
    """The GPU engine: its digest, bindings and module; `None` where the package was built without it."""
    parts = _core.browser_gpu_engine()
    return None if parts is None else (_digest(parts[0] + parts[1]), *parts)


def _digest(module: bytes) -> str:
    return hashlib.sha256(module).hexdigest()[:16]


class ToPages:
    """Sends the engine and the data of one scene to those pages of a widget that ask for them.

    Parameters
    ----------
    send : callable
        Sends a message and its buffers, from any thread.
    picture : callable
        The scene's picture, with everything decided, and what it says beside camera and size.
    """

    def __init__(self, send: Send, picture: Callable[[], tuple[_core.Picture, list[Keys]]]) -> None:
        self._send = send
        self._picture = picture
        self._change = threading.Lock()
        self._waiting: list[tuple[str, Wish]] = []
        self._is_sending = False
        self._is_closed = False
        self._parts: tuple[str, str, bytes, list[float | None]] | None = None
        self._edits: list[Keys] = []
        self._is_known = False

    def begin(self, view: str, *, has_engine: bool) -> None:
        """Sends them to a page; without the engine if it has that."""
        if engine() is not None:
            self._want(view, "data" if has_engine else "scene")

    def begin_gpu(self, view: str) -> None:
        """Sends the GPU engine to a page that has a device."""
        if gpu_engine() is not None:
            self._want(view, "gpu")

    def _want(self, view: str, wish: Wish) -> None:
        with self._change:
            if self._is_closed:
                return
            self._waiting.append((view, wish))
            if not self._is_sending:
                self._is_sending = True
                threading.Thread(target=self._serve, name="splatvol-pages", daemon=True).start()

    def leave(self, view: str) -> None:
        """Takes note that a page is gone."""
        with self._change:
            self._waiting = [wish for wish in self._waiting if wish[0] != view]

    def close(self) -> None:
        """Sends nothing more."""
        with self._change:
            self._is_closed = True
            self._waiting.clear()

    def _serve(self) -> None:
        while (wish := self._next()) is not None:
            # What a page cannot draw, or what cannot be read, the kernel draws alone, and says what is wrong.
            try:
                self._give(*wish)
            except Exception:
                self.close()

    def _next(self) -> tuple[str, Wish] | None:
        with self._change:
            if self._waiting and not self._is_closed:
                return self._waiting[0]
            self._is_sending = False
            return None

    def _give(self, view: str, wish: Wish) -> None:
        if wish == "gpu":
            self._give_gpu(view)
        else:
            self._give_scene(view, has_engine=wish == "data")
        with self._change:
            self._waiting = [other for other in self._waiting if other != (view, wish)]

    def _give_scene(self, view: str, *, has_engine: bool) -> None:
        if not self._is_known:
            picture, self._edits = self._picture()
            self._parts, self._is_known = _core.browser_parts(picture, MOST_BYTES), True
        own, gpu = engine(), gpu_engine()
        if own is None or self._parts is None:
            return
        key, module = own
        document, data, samples, distances = self._parts
        facts = {
            "key": key,
            "gpu": None if gpu is None else gpu[0],
            "document": json.loads(document),
            "data": json.loads(data),
            "distances": distances,
            "edits": self._edits,
        }
        self._pieces(view, b"" if has_engine else module, samples, facts=facts)

    def _give_gpu(self, view: str) -> None:
        if (own := gpu_engine()) is not None:
            _, bindings, module = own
            self._pieces(view, bindings, module)

    def _pieces(self, view: str, first: bytes, second: bytes, **facts: object) -> None:
        lengths = [len(first), len(second)]
        self._send({"kind": "browser", "view": view, "lengths": lengths, **facts}, [])
        data = first + second
        for start in range(0, len(data), PIECE):
            with self._change:
                if all(other != view for other, _ in self._waiting):
                    return
            self._send({"kind": "browser", "view": view}, [data[start : start + PIECE]])
            time.sleep(PAUSE)


__all__ = ["ToPages", "engine", "gpu_engine"]
