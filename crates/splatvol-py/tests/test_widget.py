"""The widget without a browser: messages in, frames out."""

from __future__ import annotations

import base64
import gzip
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import splatvol as sv

pytest.importorskip("anywidget", reason="anywidget is not installed")

from splatvol import _browser, _progressive
from splatvol._widget import Widget

SIZE = (96, 64)


class Page:
    """A page with one view of a widget: it hears what the kernel sends, and says that it has shown it."""

    def __init__(self, widget: Widget, *, answers: bool = True) -> None:
        self.widget = widget
        self.answers = answers
        self.heard: list[dict[str, Any]] = []
        self.pictures: list[bytes] = []
        self.pieces: list[bytes] = []
        widget.send = self.hear
        self.say(kind="ready")

    def say(self, **message: Any) -> None:
        self.widget._receive(self.widget, {"view": "page", **message}, [])

    def hear(self, message: dict[str, Any], buffers: list[bytes] | None = None) -> None:
        self.heard.append(message)
        if message["kind"] == "browser":
            self.pieces.extend(buffers or [])
        if message["kind"] == "frame":
            assert buffers is not None
            self.pictures.append(buffers[0])
            if self.answers:
                self.say(kind="shown", number=message["number"])

    def frames(self) -> list[dict[str, Any]]:
        return [message for message in self.heard if message["kind"] == "frame"]

    def state(self) -> dict[str, Any]:
        return [message for message in self.heard if message["kind"] == "state"][-1]

    def errors(self) -> list[str]:
        return [message["text"] for message in self.heard if message["kind"] == "error"]

    def rest(self) -> bytes:
        """The picture after everything that was wished for."""
        assert self.widget._renders.join(60)
        assert self.frames()[-1]["final"]
        return self.pictures[-1]


def png(frame: sv.Frame) -> bytes:
    return frame._core.encode("png", 8, None)


def turned(page: Page, degrees: float) -> dict[str, Any]:
    return page.widget.camera.orbit(azimuth=degrees)._keys()


@pytest.fixture
def make() -> Iterator[Callable[..., Widget]]:
    made: list[Widget] = []

    def show(data: Any = "sample:head:24", **options: Any) -> Widget:
        made.append(sv.show(data, **{"size": SIZE, **options}))
        return made[-1]

    yield show
    for widget in made:
        widget.close()


def test_at_rest_the_picture_is_the_scenes(make: Callable[..., Widget]) -> None:
    page = Page(make())
    assert page.rest() == png(sv.render("sample:head:24", size=SIZE))
    page.say(kind="camera", camera=turned(page, 40))
    page.say(kind="camera", camera=turned(page, 5))
    assert page.rest() == png(page.widget.scene.render()) != page.pictures[0]
    assert png(page.widget.snapshot()) == page.pictures[-1]
    assert page.frames()[-1]["width"] == SIZE[0]
    assert page.errors() == []


def test_drafts_come_first_and_are_smaller(make: Callable[..., Widget]) -> None:
    page = Page(make())
    page.rest()
    start = time.monotonic()
    page.say(kind="camera", camera=turned(page, 20))
    page.rest()
    assert time.monotonic() - start >= _progressive.REST
    _, draft, final = page.frames()
    assert (draft["final"], final["final"]) == (False, True)
    assert draft["width"] == 48 and draft["height"] == 32


@pytest.mark.parametrize(
    ("seconds", "divisor"),
    [
        (lambda divisor: 0.15 / divisor**2, 2.5),
        (lambda divisor: 0.01, 1.0),
        (lambda divisor: 1.0 / divisor, 4.0),
        # Radiographs: what is smaller takes longer.
        (lambda divisor: 0.03 * divisor, 2.0),
        (lambda divisor: 0.06 + 0.01 * divisor, 2.0),
    ],
)
def test_the_size_of_drafts_follows_their_time(seconds: Callable[[float], float], divisor: float) -> None:
    pace = _progressive.Pace()
    for _ in range(20):
        pace.took(seconds(pace.divisor))
    assert pace.divisor == divisor
    pace.took(0.5)
    assert pace.divisor == divisor


def test_a_size_that_was_too_slow_is_tried_again() -> None:
    pace = _progressive.Pace()
    for _ in range(20):
        pace.took(1.0 / pace.divisor)
    assert pace.divisor == 4.0
    for _ in range(150):
        pace.took(0.001)
    assert pace.divisor == 1.0


def arrived(page: Page) -> tuple[dict[str, Any], bytes, bytes]:
    """What a page needs to draw: facts, engine, and samples; or nothing, bindings and module of the GPU engine."""
    for _ in range(1000):
        last = [message for message in page.heard if "lengths" in message][-1:]
        bytes_there = b"".join(page.pieces)
        if last and len(bytes_there) == sum(last[0]["lengths"]):
            first, _ = last[0]["lengths"]
            return last[0].get("facts", {}), bytes_there[:first], bytes_there[first:]
        time.sleep(0.02)
    raise AssertionError(f"{len(page.pieces)} pieces arrived")


def test_a_page_that_draws_itself_gets_no_drafts(make: Callable[..., Widget], monkeypatch: pytest.MonkeyPatch) -> None:
    if _browser.engine() is None or _browser.notice():
        pytest.skip("the package has no engine for browsers of its own sources: cargo xtask web --dev")
    monkeypatch.setattr(_browser, "PAUSE", 0.0)
    page = Page(make())
    page.rest()
    facts, engine, samples = arrived(page)
    assert gzip.decompress(engine)[:4] == b"\0asm"
    assert len(gzip.decompress(samples)) == 2 * 24**3
    assert facts["data"][0]["dims"] == [24, 24, 24]
    assert [item["file"] for item in facts["document"]["item"]] == ["data"]
    page.say(kind="draws", value=True)
    edits = [message["edits"] for message in page.heard if message["kind"] == "browser" and "edits" in message]
    assert [edit["path"] for edit in edits[-1]] == ["settings", "effects", "item[0].transfer-function"]
    seen = len(page.frames())
    page.say(kind="camera", camera=turned(page, 20))
    assert page.rest() == png(page.widget.scene.render())
    assert [message["final"] for message in page.frames()[seen:]] == [True]
    camera = page.frames()[-1]["camera"]
    assert camera["position"] == pytest.approx(page.widget.camera.position)
    # Another page has the engine already; and of another scene both get the data.
    page.pieces.clear()
    page.say(kind="ready", view="other", engines=[facts["key"]])
    assert arrived(page)[1] == b""
    page.pieces.clear()
    page.widget.scene = sv.Scene("sample:shells:16", size=SIZE)
    assert {"kind": "browser", "end": True} in page.heard


def test_pages_with_a_device_get_the_gpu_engine(make: Callable[..., Widget], monkeypatch: pytest.MonkeyPatch) -> None:
    if _browser.engine() is None or _browser.notice() or _browser.gpu_engine() is None:
        pytest.skip("the package has no GPU engine for browsers of its own sources: cargo xtask-webgpu --dev")
    monkeypatch.setattr(_browser, "PAUSE", 0.0)
    page = Page(make())
    page.rest()
    facts, _, _ = arrived(page)
    page.pieces.clear()
    page.say(kind="gpu")
    nothing, bindings, module = arrived(page)
    assert nothing == {}
    assert b"wasm_bindgen" in gzip.decompress(bindings)
    assert gzip.decompress(module)[:4] == b"\0asm"
    # Another page that has it has no need to ask.
    page.pieces.clear()
    page.say(kind="ready", view="other", engines=[facts["key"], facts["gpu"]])
    assert arrived(page)[0]["gpu"] == facts["gpu"]


def test_pages_draw_points_themselves(make: Callable[..., Widget], monkeypatch: pytest.MonkeyPatch) -> None:
    if _browser.engine() is None or _browser.notice():
        pytest.skip("the package has no engine for browsers of its own sources: cargo xtask web --dev")
    monkeypatch.setattr(_browser, "PAUSE", 0.0)
    page = Page(make())
    page.rest()
    arrived(page)
    page.pieces.clear()
    place = np.random.default_rng(7).normal(size=(500, 3))
    page.widget.scene = sv.Scene(sv.Points(place, rgb=np.full((500, 3), 200, np.uint8)), size=SIZE)
    page.rest()
    facts, _, _ = arrived(page)
    assert facts["distances"] == [None]
    assert (facts["data"][0]["kind"], facts["data"][0]["count"]) == ("points", 500)


def test_data_stay_with_the_kernel_if_asked(make: Callable[..., Widget], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_browser, "PAUSE", 0.0)
    page = Page(make(engine="kernel"))
    page.rest()
    time.sleep(0.2)
    assert not any("facts" in message for message in page.heard) and page.pieces == []
    with pytest.raises(sv.InvalidValue, match="engine: 'gpu'"):
        make(engine="gpu")


def test_frames_do_not_queue_up(make: Callable[..., Widget]) -> None:
    page = Page(make(), answers=False)
    first = page.widget._renders
    for _ in range(200):
        page.say(kind="camera", camera=turned(page, 1))
        time.sleep(0.001)
    # One is under way to the page, which says nothing, and nothing follows.
    assert len(page.frames()) <= 1
    page.answers = True
    for message in page.frames():
        page.say(kind="shown", number=message["number"])
    last = page.rest()
    assert last == png(page.widget.scene.render())
    assert len(page.frames()) <= 5
    assert first.join(1)


def test_a_page_that_says_nothing_does_not_stop_the_rest(
    make: Callable[..., Widget], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_progressive, "PATIENCE", 0.05)
    page = Page(make(), answers=False)
    page.say(kind="camera", camera=turned(page, 10))
    assert page.rest() == png(page.widget.scene.render())


def test_a_newer_camera_stops_the_exact_picture(make: Callable[..., Widget]) -> None:
    page = Page(make("sample:head:96", size=(900, 700), preset="best"))
    page.rest()
    resolved = page.widget._renders.resolved
    render, under_way, stopped = resolved.render, threading.Event(), []

    def watched(decided: dict[str, Any], stop: sv.CancelToken) -> sv.Frame:
        if decided["size"] == "900x700":
            under_way.set()
        try:
            return render(decided, stop)
        except sv.Cancelled:
            stopped.append(decided["camera"])
            raise

    resolved.render = watched
    page.say(kind="camera", camera=turned(page, 30))
    assert under_way.wait(30)
    skipped = page.widget.camera
    page.say(kind="camera", camera=turned(page, 1))
    assert page.rest() == png(page.widget.scene.render())
    assert [tuple(camera["position"]) for camera in stopped] == [pytest.approx(skipped.position)]
    assert [frame["final"] for frame in page.frames()] == [True, False, False, True]


def test_the_kernel_is_free_meanwhile(make: Callable[..., Widget]) -> None:
    page = Page(make("sample:head:96", size=(700, 500), preset="best"))
    start = time.monotonic()
    page.say(kind="camera", camera={**sv.Camera((0, -400, 60), (0, 0, 0))._keys()})
    assert time.monotonic() - start < 0.2
    assert page.widget._renders._thread is not None
    page.widget.close()
    assert page.widget._renders.join(10)


def test_the_look_is_edited(make: Callable[..., Widget]) -> None:
    page = Page(make())
    first = page.rest()
    state = page.state()["items"][0]
    assert len(state["histogram"]) == 128 and max(state["histogram"]) == 1
    low, high = state["range"]
    look = {**state["look"], "opacities": [{"value": low, "opacity": 0.0}, {"value": high, "opacity": 0.9}]}
    camera = page.widget.camera
    page.say(kind="look", item=0, look=look)
    edited = page.rest()
    assert edited != first and edited == png(page.widget.scene.render())
    # An edit does not move the camera, though what is visible has changed.
    assert page.widget.camera == camera

    page.say(kind="cmap", item=0, name="viridis")
    colored = page.rest()
    assert page.state()["items"][0]["map"] == "viridis"
    shown = page.state()["items"][0]["look"]
    assert shown["colors"][0]["rgb"] == pytest.approx([0.267, 0.005, 0.329], abs=0.01)
    assert [point["opacity"] for point in shown["opacities"]] == [0.0, 0.9]
    page.say(kind="reset")
    assert page.rest() == first != colored
    assert page.state()["items"][0]["map"] == ""


def test_kinds_of_pictures_and_clips(make: Callable[..., Widget]) -> None:
    page = Page(make())
    first = page.rest()
    page.say(kind="compositing", value="mip")
    assert page.rest() == png(sv.render("sample:head:24", size=SIZE, compositing="mip", camera=page.widget.camera))
    page.say(kind="compositing", value="")
    assert page.rest() == first
    low, high = page.state()["bounds"]
    page.say(kind="clip", box=[0, high[0], low[1], high[1], low[2], high[2]])
    clip = sv.Clip.box((0, high[0]), (low[1], high[1]), (low[2], high[2]))
    assert page.rest() == png(sv.render("sample:head:24", size=SIZE, clip=clip, camera=page.widget.camera)) != first
    page.say(kind="clip", box=None)
    assert page.rest() == first
    assert page.errors() == []


def test_what_goes_wrong_is_said_and_undone(make: Callable[..., Widget]) -> None:
    page = Page(make())
    first = page.rest()
    low, high = page.state()["bounds"]
    page.say(kind="compositing", value="mip")
    page.rest()
    page.say(kind="clip", box=[0, high[0], low[1], high[1], low[2], high[2]])
    page.widget._renders.join(30)
    assert any("clip" in text for text in page.errors())
    page.say(kind="clip", box=None)
    page.say(kind="compositing", value="")
    assert page.rest() == first
    page.say(kind="look", item=7, look={})
    assert page.errors()[-1].startswith("IndexError")


def test_from_python(make: Callable[..., Widget]) -> None:
    widget = make()
    page = Page(widget)
    page.rest()
    changes: list[str] = []
    end = widget.on_change(changes.append)
    widget.camera = sv.Camera((0, -500, 0), (0, 0, 0))
    assert page.heard[-1]["kind"] in ("camera", "frame") and widget.camera.position == (0, -500, 0)
    page.rest()
    widget.size = (40, 30)
    assert widget.size == (40, 30) and page.state()["size"] == (40, 30)
    page.rest()
    assert page.frames()[-1]["width"] == 40
    widget.scene.items[0].set(cmap="magma")
    widget.update()
    assert page.rest() == png(widget.scene.render())
    assert changes == ["camera", "size"]
    end()
    widget.scene = sv.Scene("sample:tomato:16", size=32)
    assert page.rest() == png(sv.render("sample:tomato:16", size=32))
    assert changes == ["camera", "size"]
    widget.on_change(lambda what: 1 / 0)
    widget.size = 20
    assert page.errors()[-1] == "ZeroDivisionError: division by zero"


def test_linked_widgets_have_one_camera(make: Callable[..., Widget]) -> None:
    one, other = make(), make(compositing="mip")
    pages = Page(one), Page(other)
    end = one.link(other, "camera")
    assert other.camera == one.camera
    pages[1].say(kind="camera", camera=turned(pages[1], 33))
    assert one.camera == other.camera
    for page in pages:
        assert page.rest() == png(page.widget.scene.render())
    end()
    pages[0].say(kind="camera", camera=turned(pages[0], 5))
    assert one.camera != other.camera
    with pytest.raises(sv.InvalidValue, match="camera"):
        one.link(other, "look")


def test_the_given_scene_is_not_changed() -> None:
    scene = sv.Scene("sample:head:16", size=SIZE)
    before = scene.to_dict()
    widget = scene.show(azimuth=20)
    widget.camera = widget.camera.zoom(2)
    assert scene.to_dict() == before
    assert sv.read("sample:head:16").show(size=SIZE).snapshot().size == SIZE
    assert sv.show(np.ones((6, 6, 6), np.float32)).size == (640, 480)


def test_notebooks_keep_a_picture(make: Callable[..., Widget], monkeypatch: pytest.MonkeyPatch) -> None:
    widget = make(np.random.default_rng(1).random((32, 32, 32)), size=(800, 800))
    bundle, _ = widget._repr_mimebundle_()
    picture = base64.b64decode(bundle["image/png"])
    assert picture.startswith(b"\x89PNG") and len(picture) <= 300_000
    assert bundle["application/vnd.jupyter.widget-view+json"]["model_id"] == widget.model_id
    assert bundle["text/plain"].startswith("<splatvol.Widget")

    published: list[dict[str, Any]] = []
    monkeypatch.setattr("IPython.display.publish_display_data", published.append)
    widget._ipython_display_()
    still, view = published
    assert still["image/png"] == bundle["image/png"] and "image/png" not in view
    # A view is told which picture is its own, and hides it; its first frame is there already.
    page = Page(widget)
    assert still["image/png"].endswith(page.state()["still"]) and page.frames()[0]["final"]
    assert page.widget._renders._thread is None


def test_the_front_end_is_small() -> None:
    folder = Path(sv.__file__).parent
    files = [folder / "_widget.js", folder / "_widget.css"]
    assert sum(file.stat().st_size for file in files) <= 60_000
    assert not any("//cdn" in file.read_text() or "https:" in file.read_text() for file in files)


def test_without_anywidget_show_says_what_to_install() -> None:
    text = (
        "import sys; sys.modules['anywidget'] = None\n"
        "import splatvol as sv\n"
        "try: sv.show('sample:head:16')\n"
        "except ImportError as error: print(error)"
    )
    run = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    assert "pip install anywidget" in run.stdout
