"""Volumes in chunks that Python gives: pictures are those of the same samples in a file."""

from __future__ import annotations

import pickle
import subprocess
import sys
import threading
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import splatvol as sv

LOOK: dict[str, Any] = {"size": (70, 60), "view": "left"}


@pytest.fixture(scope="module")
def head(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("lazy") / "head.ome.zarr"
    line = [sys.executable, "-m", "splatvol", "convert", "sample:head:48", str(path), "--chunk", "16", "-q"]
    subprocess.run(line, check=True, capture_output=True)
    return path


def contents(folder: Path) -> dict[str, bytes]:
    files = [path for path in folder.rglob("*") if path.is_file()]
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def test_stores_have_the_picture_of_their_files(head: Path) -> None:
    expected = sv.render(str(head), **LOOK)
    keys = contents(head)
    asked: Counter[str] = Counter()

    def get(key: str, start: int, length: int | None) -> bytes | None:
        asked[key] += 1
        found = keys.get(key)
        return None if found is None else found[start:] if length is None else found[start : start + length]

    for source in (keys, get):
        volume = sv.lazy(source, memory=64 << 20)
        assert volume.levels[0] == (48, 48, 48) and volume.kind == "volume"
        assert volume.render(**LOOK).linear.tobytes() == expected.linear.tobytes()
    assert asked["0/c/0/0/0"] > 2
    fsspec = pytest.importorskip("fsspec")
    mapped = sv.lazy(fsspec.get_mapper(str(head)))
    assert mapped.name == "head.ome.zarr" and "48 x 48 x 48" in repr(mapped)
    assert mapped.render(**LOOK).linear.tobytes() == expected.linear.tobytes()


def test_files_are_read_when_they_are_drawn(head: Path) -> None:
    volume = sv.lazy(str(head), memory=64 << 20)
    assert volume.source == str(head) and volume.levels[0] == (48, 48, 48)
    expected = sv.render(str(head), **LOOK).linear.tobytes()
    assert volume.render(**LOOK).linear.tobytes() == expected
    again = pickle.loads(pickle.dumps(volume))
    assert again.render(**LOOK).linear.tobytes() == expected
    recipe = sv.recipe(sv.Scene(volume, **LOOK))
    assert sv.assemble([sv.part(recipe, f"{i}/2") for i in range(2)]).linear.tobytes() == expected
    with pytest.raises(sv.SplatvolError, match="memory"):
        sv.lazy(str(head), memory=1 << 20).render(**LOOK)
    with pytest.raises(FileNotFoundError):
        sv.lazy("nothing.ome.zarr")


def test_addresses_are_read_like_files(head: Path) -> None:
    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *_: object) -> None:
            pass

    # This server knows no byte ranges: an image without shards needs none.
    plain = head.parent / "plain.ome.zarr"
    line = [sys.executable, "-m", "splatvol", "convert", str(head), str(plain), "--ome-version", "0.4", "-q"]
    subprocess.run(line, check=True, capture_output=True)
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(head.parent)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    address = f"http://127.0.0.1:{server.server_port}"
    found = sv.lazy(f"{address}/plain.ome.zarr").render(**LOOK)
    assert found.linear.tobytes() == sv.render(str(plain), **LOOK).linear.tobytes()
    with pytest.raises(sv.SplatvolError, match="ange"):
        sv.lazy(f"{address}/{head.name}")
    server.shutdown()
    server.server_close()


def test_arrays_are_levels_in_one_box(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    fine = np.zeros((50, 40, 60), ">f4")
    fine[10:40, 8:32, 12:48] = rng.random((30, 24, 36)) + 2
    levels = [fine, fine.reshape(25, 2, 20, 2, 30, 2).mean((1, 3, 5)).astype(np.float32)]
    look: dict[str, Any] = {"size": 120, "view": "iso", "opacity": [(0.5, 0), (3, 0.4)], "fit": "volume"}
    whole = sv.render(sv.Volume(fine.astype(np.float32), spacing=(2, 1, 1)), **look)
    found = sv.lazy(levels, spacing=(2, 1, 1), name="noise").render(**look)
    assert whole.linear.tobytes() == found.linear.tobytes()
    dask = pytest.importorskip("dask.array")
    chunked = [dask.from_array(level, chunks=17) for level in levels]
    assert sv.lazy(chunked, spacing=(2, 1, 1)).render(**look).linear.tobytes() == found.linear.tobytes()
    file = np.memmap(tmp_path / "a.raw", np.uint16, "w+", shape=(8, 9, 10))
    assert sv.lazy(file).levels == [(8, 9, 10)]


def test_scenes_that_share_a_volume_take_turns(head: Path) -> None:
    """Whoever rendered it before keeps none of its memory."""
    volume = sv.lazy(str(head))
    scenes = [sv.Scene(volume, **LOOK), sv.Scene(volume, size=40, compositing="xray"), sv.Scene(volume, **LOOK)]
    scenes[2].add("sample:ball:16")
    expected = [scene.render().linear.tobytes() for scene in scenes]
    for index in (1, 0, 2, 0, 1, 2, 1):
        assert scenes[index].render().linear.tobytes() == expected[index], index


def test_one_array_has_the_levels_that_pictures_need() -> None:
    z, y, x = np.ogrid[-1:1:272j, -1:1:256j, -1:1:257j]  # type: ignore[misc]
    array = (255 * np.exp(-3 * (z * z + y * y + x * x)) * (1 + 0.1 * np.sin(40 * x))).clip(0, 255).astype(np.uint8)
    look: dict[str, Any] = {"size": 100, "view": "iso", "opacity": [(60, 0), (160, 0.5)], "fit": "volume"}
    found = sv.lazy(array, memory=64 << 20).render(**look)
    assert found.stats["level"] >= 1
    assert found.linear.tobytes() == sv.render(sv.Volume(array), **look).linear.tobytes()


def test_what_is_no_volume_is_refused() -> None:
    with pytest.raises(sv.FormatError, match="neither multiscales nor an array"):
        sv.lazy({})
    with pytest.raises(sv.InvalidValue, match="level 1 is no array with axes z, y, x, but ndarray of shape"):
        sv.lazy([np.zeros((2, 2, 2)), np.zeros((2, 2))])
    with pytest.raises(sv.InvalidValue, match="says it itself"):
        sv.lazy({}, spacing=2)
    with pytest.raises(sv.InvalidValue, match="read files"):
        sv.recipe(sv.lazy(np.zeros((4, 4, 4), np.uint8)))


def test_errors_of_a_store_name_the_chunk(head: Path) -> None:
    keys = contents(head)
    broken = False

    def get(key: str, start: int, length: int | None) -> bytes | None:
        if broken and "/c/" in key:
            raise TimeoutError("the store sleeps")
        found = keys.get(key)
        return None if found is None else found[start:] if length is None else found[start : start + length]

    volume = sv.lazy(get)
    broken = True
    with pytest.raises(sv.SplatvolError, match=r"level 0, chunk .*TimeoutError: the store sleeps"):
        volume.render(**LOOK)
    broken = False
    assert volume.render(**LOOK).linear.tobytes() == sv.render(str(head), **LOOK).linear.tobytes()


def test_lazy_volumes_say_what_they_are_and_are_not_read_whole() -> None:
    samples = np.random.default_rng(1).integers(0, 200, (20, 24, 28), np.uint8)
    volume = sv.lazy(samples)
    assert volume.shape == samples.shape and volume.dtype == samples.dtype
    low, high = volume.range
    assert 0 <= low < high <= 200
    with pytest.raises(TypeError, match="not read whole"):
        np.asarray(volume)


def test_masked_samples_are_refused() -> None:
    samples = np.ma.masked_less(np.random.default_rng(1).random((20, 24, 28)), 0.5)
    with pytest.raises(sv.InvalidValue, match="source: some samples are masked"):
        sv.lazy(samples)
    dask = pytest.importorskip("dask.array")
    with pytest.raises(sv.SplatvolError, match="some samples are masked"):
        sv.lazy(dask.from_array(samples)).render(size=16)


def test_a_source_may_ask_splatvol_for_its_samples() -> None:
    # In a process of its own: what waits for itself cannot be stopped.
    code = """
import numpy as np, splatvol as sv
sv.set_threads(1)
samples = np.random.default_rng(0).integers(0, 255, (40, 32, 24), np.uint8)
own = sv.lazy(sv.Volume(samples)).render(size=32)
assert np.array_equal(np.asarray(own), np.asarray(sv.lazy(samples).render(size=32)))
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=120)


def test_pictures_of_one_volume_wait_for_each_other() -> None:
    samples = np.random.default_rng(1).integers(0, 255, (40, 32, 24), np.uint8)
    volume = sv.lazy(samples)

    def picture(angle: int) -> Any:
        return np.asarray(volume.render(size=50, azimuth=angle))

    expected = [picture(angle) for angle in range(6)]
    with ThreadPoolExecutor(3) as threads:
        for found, wanted in zip(threads.map(picture, range(6)), expected, strict=True):
            assert np.array_equal(found, wanted)
