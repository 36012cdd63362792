"""The dock: a preview that follows napari's camera, and pictures of any size."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from qtpy.QtCore import QObject, Qt, QTimer, Signal
from qtpy.QtGui import QImage, QPixmap
from qtpy.QtWidgets import (
    QApplication,
    QFileDialog,
    QGridLayout,
    QLabel,
    QPushButton,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from .. import _core
from .._errors import Cancelled, SplatvolError
from .._frame import Frame
from .layers import kind_of
from .viewer import Picture, Volumes, camera_of, canvas_of, picture_of

#: Milliseconds between two looks at what the viewer shows while it changes.
THROTTLE = 40
#: Milliseconds after the last change until the preview is rendered with care.
REST = 250
#: Width of the preview, pixels; a draft has half of it.
PREVIEW = 400
#: Pixels of a picture for one of the canvas, each way, until other numbers are typed.
ENLARGEMENT = 4
LARGEST = 32768


class Follower:
    """One thread that renders, and a mailbox of one: a newer job takes the place of one that waits."""

    def __init__(self, done: Callable[[Any, Frame | Exception], object]) -> None:
        self._done = done
        self._change = threading.Condition()
        self._job: tuple[Any, Callable[[_core.Stop], Frame]] | None = None
        self._stop = _core.Stop()
        self._is_closed = False
        self._thread: threading.Thread | None = None

    def ask(self, tag: Any, job: Callable[[_core.Stop], Frame], *, stops: bool) -> None:
        """Wishes for a picture; `stops` ends the one under way."""
        with self._change:
            self._job = (tag, job)
            if stops:
                self._stop.set()
            if self._thread is None and not self._is_closed:
                self._thread = threading.Thread(target=self._serve, name="splatvol-napari", daemon=True)
                self._thread.start()

    def close(self) -> None:
        """Stops what is under way, for good."""
        with self._change:
            self._is_closed, self._job = True, None
            self._stop.set()

    def _serve(self) -> None:
        while True:
            with self._change:
                if self._job is None:
                    self._thread = None
                    return
                (tag, job), self._job = self._job, None
                self._stop = stop = _core.Stop()
            try:
                result: Frame | Exception = job(stop)
            except Cancelled:
                continue
            except Exception as error:
                # Whatever it is, the one who looks should read it; a thread has nobody else to tell.
                result = error
            if not self._is_closed:
                self._done(tag, result)


class _Post(QObject):  # type: ignore[misc]
    """Pictures on their way to the thread of the window."""

    arrived = Signal(object, object)


class Dock(QWidget):  # type: ignore[misc]
    """Shows what napari's viewer shows, by splatvol, and saves it at any size."""

    def __init__(self, napari_viewer: Any) -> None:
        super().__init__()
        # napari hides private names from plugins; the size of the canvas has no public one.
        self.viewer = getattr(napari_viewer, "__wrapped__", napari_viewer)
        self._volumes = Volumes()
        self._picture: Picture | None = None
        self._is_stale = True
        self._post = _Post()
        self._post.arrived.connect(self._show, Qt.ConnectionType.QueuedConnection)
        self._preview_work = Follower(self._post.arrived.emit)
        self._save_work = Follower(self._post.arrived.emit)
        self._build()
        self._draft_timer, self._rest_timer = QTimer(self), QTimer(self)
        for timer, milliseconds, action in (
            (self._draft_timer, THROTTLE, self._draft),
            (self._rest_timer, REST, self._final),
        ):
            timer.setSingleShot(True)
            timer.setInterval(milliseconds)
            timer.timeout.connect(action)
        self._listen()
        self._changed()

    def _build(self) -> None:
        self.preview = QLabel()
        self.preview.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.preview.setMinimumSize(160, 120)
        self.note = QLabel()
        self.note.setWordWrap(True)
        self.width_field, self.height_field = QSpinBox(), QSpinBox()
        grid = QGridLayout()
        #: Whether width and height are the canvas's, enlarged: until others are typed.
        self._follows_canvas = True
        for row, (name, field) in enumerate((("Width", self.width_field), ("Height", self.height_field))):
            field.setRange(1, LARGEST)
            field.valueChanged.connect(self._typed)
            field.setSuffix(" px")
            field.setAccessibleName(name)
            grid.addWidget(QLabel(name), row, 0)
            grid.addWidget(field, row, 1)
        self.save_button, self.copy_button = QPushButton("Save picture…"), QPushButton("Copy Python")
        self.save_button.clicked.connect(self._choose_file)
        self.copy_button.clicked.connect(self._copy)
        self._take_size()
        layout = QVBoxLayout(self)
        layout.addWidget(self.preview, 1)
        layout.addLayout(grid)
        for widget in (self.save_button, self.copy_button, self.note):
            layout.addWidget(widget)

    def _typed(self, value: int) -> None:
        self._follows_canvas = False

    def _take_size(self) -> None:
        """Width and height of the canvas, enlarged: it changes with the window."""
        if not self._follows_canvas:
            return
        for field, pixels in zip((self.height_field, self.width_field), canvas_of(self.viewer), strict=True):
            field.setValue(max(min(pixels * ENLARGEMENT, LARGEST), 1))
        self._follows_canvas = True

    # What the viewer shows.

    def _listen(self) -> None:
        scene = getattr(self.viewer, "scene", self.viewer)
        self._sources: list[tuple[Any, Callable[[Any], None]]] = [
            (scene.camera.events, self._turned),
            (self.viewer.dims.events, self._changed),
        ]
        layers = self.viewer.layers.events
        self._sources += [(layers.inserted, self._grown), (layers.removed, self._changed)]
        self._sources += [(layers.reordered, self._changed)]
        for layer in self.viewer.layers:
            self._sources.append((layer.events, self._layer_changed))
        for emitter, action in self._sources:
            emitter.connect(action)

    def _grown(self, event: Any) -> None:
        event.value.events.connect(self._layer_changed)
        self._sources.append((event.value.events, self._layer_changed))
        self._changed()

    def _layer_changed(self, event: Any) -> None:
        if event.type in ("data", "set_data", "paint", "labels_update"):
            # An array may have been written to in place.
            self._volumes.clear()
        if event.type not in ("thumbnail", "status", "cursor", "loaded", "extent", "help", "select", "mode"):
            self._changed()

    def _turned(self, event: Any = None) -> None:
        if not self._draft_timer.isActive():
            self._draft_timer.start()
        self._rest_timer.start()

    def _changed(self, event: Any = None) -> None:
        self._is_stale = True
        self._turned()

    def _look(self) -> Picture | None:
        """What the viewer shows now, or `None` and a line that says why not."""
        self._take_size()
        try:
            if self._is_stale or self._picture is None:
                self._picture = picture_of(self.viewer)
                self._is_stale = False
                self._say("; ".join(self._picture.left_out))
            else:
                self._picture = dataclasses.replace(
                    self._picture, camera=camera_of(self.viewer), size=canvas_of(self.viewer)[::-1]
                )
        except (SplatvolError, TypeError) as error:
            self._picture = None
            self._say(str(error))
        return self._picture

    # The preview.

    def _draft(self) -> None:
        self._ask_preview(2, {"preset": "fast"}, stops=False)

    def _final(self) -> None:
        self._ask_preview(1, {}, stops=True)

    def _ask_preview(self, divisor: int, options: dict[str, Any], *, stops: bool) -> None:
        picture = self._look()
        if picture is None or not picture.layers:
            self.preview.clear()
            return
        width, height = picture.size
        wide = max(min(PREVIEW, self.preview.width()) // divisor, 1)
        size = (wide, max(round(wide * height / max(width, 1)), 1))
        volumes = self._volumes
        self._preview_work.ask(
            "preview", lambda stop: picture.render(volumes, cancel=stop, size=size, **options), stops=stops
        )

    def _show(self, tag: Any, result: Any) -> None:
        if isinstance(tag, Path):
            self._saved(tag, result)
        elif isinstance(result, Exception):
            self._say(str(result))
        else:
            codes = np.ascontiguousarray(np.asarray(result))
            height, width = codes.shape[:2]
            image = QImage(codes.data, width, height, 4 * width, QImage.Format.Format_RGBA8888)
            shown = QPixmap.fromImage(image.copy()).scaled(
                self.preview.size(),
                Qt.AspectRatioMode.KeepAspectRatio,
                Qt.TransformationMode.SmoothTransformation,
            )
            self.preview.setPixmap(shown)

    # Pictures that stay.

    def _choose_file(self) -> None:
        name, _ = QFileDialog.getSaveFileName(self, "Save picture", "picture.png", "Pictures (*.png *.exr)")
        if name:
            self.save(name)

    def save(self, path: str | Path) -> None:
        """Renders the picture in the background, and writes it."""
        path = Path(path)
        picture = self._look()
        if picture is None:
            return
        size = (self.width_field.value(), self.height_field.value())

        def job(stop: _core.Stop) -> Frame:
            # Its own volumes: the preview's thread changes the others.
            frame = picture.render(cancel=stop, size=size)
            frame.save(path)
            return frame

        self.save_button.setEnabled(False)
        self._say(f"rendering {size[0]} x {size[1]} pixels…")
        self._save_work.ask(path, job, stops=False)

    def _saved(self, path: Path, result: Any) -> None:
        self.save_button.setEnabled(True)
        self._say(str(result) if isinstance(result, Exception) else f"wrote {path}")

    def python(self) -> str:
        """A program for napari's console that makes the picture again, from this side."""
        camera = camera_of(self.viewer)
        size = (self.width_field.value(), self.height_field.value())
        names = [layer.name for layer in self.viewer.layers if layer.visible and kind_of(layer) == "image"]
        return "\n".join(
            [
                "import napari",
                "import splatvol as sv",
                "",
                f"# shows {', '.join(names)}" if names else "# shows no image",
                f"camera = sv.{camera!r}",
                "viewer = napari.current_viewer()",
                f'sv.render(viewer, camera=camera, size={size}).save("picture.png")',
                "",
            ]
        )

    def _copy(self) -> None:
        try:
            QApplication.clipboard().setText(self.python())
        except (SplatvolError, TypeError) as error:
            self._say(str(error))
            return
        self._say("copied: paste it into napari's console, or a notebook")

    def _say(self, text: str) -> None:
        self.note.setText(text)

    def closeEvent(self, event: Any) -> None:
        """Ends the work with the window."""
        self.stop()
        super().closeEvent(event)

    def stop(self) -> None:
        """Ends the work, and forgets the viewer."""
        self._preview_work.close()
        self._save_work.close()
        self._draft_timer.stop()
        self._rest_timer.stop()
        for emitter, action in self._sources:
            emitter.disconnect(action)
        self._sources = []
