"""Pictures by many processes: the bits of one, whoever makes the parts, and errors that say what is wrong."""

from __future__ import annotations

import multiprocessing
import os
import random
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import splatvol as sv

distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def head(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A volume in chunks with levels, as the command converts it."""
    path = tmp_path_factory.mktemp("head") / "head.ome.zarr"
    line = [sys.executable, "-m", "splatvol", "convert", "sample:head:48", str(path), "--chunk", "16", "-q"]
    subprocess.run(line, check=True, capture_output=True)
    return path


@pytest.fixture(scope="module")
def scenes(head: Path) -> dict[str, sv.Scene]:
    """Six looks of it: opaque, translucent, a maximum, an X-ray, two channels, and a close view."""
    near = sv.Camera((-120, 8, -4), (0, 8, -4), fov=70)
    two = sv.Scene(size=(70, 60), view="left")
    two.add(head)
    two.add(head, opacity=[(10, 0), (900, 0.3)], cmap="viridis")
    return {
        "opaque": sv.Scene(head, size=(70, 60), view="left"),
        "translucent": sv.Scene(head, size=(70, 60), opacity=[(-500, 0), (900, 0.1)]),
        "maximum": sv.Scene(head, size=(70, 60), compositing="mip"),
        "xray": sv.Scene(head, size=(70, 60), compositing="xray"),
        "two": two,
        # Three levels behind each other.
        "close": sv.Scene(head, size=(70, 60), camera=near, level_bias=3),
    }


def linear(frame: sv.Frame) -> bytes:
    return frame.linear.tobytes() + frame.depth.tobytes()


def test_parts_are_the_picture_in_any_order_and_twice(scenes: dict[str, sv.Scene], command: Any) -> None:
    for name, scene in scenes.items():
        whole = scene.render()
        assert whole.stats["levels"] == 3 or name != "close"
        recipe = sv.recipe(scene)
        keys = ["0,0,32x60", "32,0,38x30", "32,30,38x30"]
        parts = [sv.part(recipe, key, memory=24 << 20) for key in keys]
        assert parts[1] == sv.part(recipe, keys[1])
        again = sv.assemble([parts[2], parts[0], parts[1], parts[2]])
        assert linear(again) == linear(whole), name
        assert np.array_equal(np.asarray(again), np.asarray(whole)), name


def test_files_are_read_by_whoever_makes_the_parts(head: Path) -> None:
    look: dict[str, Any] = {"size": (70, 60), "view": "left"}
    recipe = sv.recipe(head, **look)
    assert recipe == sv.recipe(sv.Scene(head), **look)
    assert linear(sv.assemble([sv.part(recipe, "0/1")])) == linear(sv.render(head, **look))


def test_a_file_that_has_changed_is_read_again(tmp_path: Path) -> None:
    path = tmp_path / "a.npy"
    z, y, x = np.mgrid[-1:1:12j, -1:1:12j, -1:1:12j]
    ball = (1 - np.sqrt(x**2 + y**2 + z**2)).astype(np.float32)
    np.save(path, ball)
    recipe = sv.recipe(path, size=24)
    first = sv.part(recipe, "0/1")
    np.save(path, 0.8 * ball)
    os.utime(path, ns=(1, 1))
    changed = sv.part(recipe, "0/1")
    assert changed != first
    np.save(path, ball)
    os.utime(path, ns=(2, 2))
    assert sv.part(recipe, "0/1") == first


def test_parts_are_those_of_the_command(scenes: dict[str, sv.Scene], tmp_path: Path) -> None:
    recipe = sv.recipe(scenes["opaque"])
    path = tmp_path / "recipe.json"
    path.write_text(recipe)
    line = [sys.executable, "-m", "splatvol", "part", str(path), "1/4", "-o", str(tmp_path / "a.part"), "-q"]
    subprocess.run(line, check=True, capture_output=True)
    assert (tmp_path / "a.part").read_bytes() == sv.part(recipe, "1/4")


@pytest.mark.parametrize("kind", ["threads", "processes"])
def test_executors_make_the_same_bytes(scenes: dict[str, sv.Scene], kind: str) -> None:
    executor: Executor
    if kind == "threads":
        executor = ThreadPoolExecutor(2)
    else:
        executor = ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn"))
    with executor:
        for name in ["opaque", "xray"]:
            shares: list[float] = []
            frame = scenes[name].render(executor=executor, progress=shares.append)
            assert linear(frame) == linear(scenes[name].render())
            assert shares[-1] == 1


@pytest.fixture(scope="module")
def cluster() -> Iterator[Callable[[int], Any]]:
    """Clusters of so many worker processes of a thread each."""
    open_ones: dict[int, Any] = {}

    def of(workers: int) -> Any:
        if workers not in open_ones:
            local = distributed.LocalCluster(
                n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=":0"
            )
            open_ones[workers] = distributed.Client(local)
        return open_ones[workers]

    yield of
    for client in open_ones.values():
        client.close()
        client.cluster.close()


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_any_number_of_dask_workers_makes_the_same_bytes(
    scenes: dict[str, sv.Scene], cluster: Callable[[int], Any], workers: int
) -> None:
    import splatvol.dask

    for name, scene in scenes.items():
        frame = splatvol.dask.render(scene, cluster(workers), block=32)
        assert linear(frame) == linear(scene.render()), name


def test_workers_that_die_change_nothing(head: Path, cluster: Callable[[int], Any]) -> None:
    import splatvol.dask

    client = cluster(2)
    scene = sv.Scene(head, size=96, preset="best")
    whole = linear(scene.render())
    killed: list[int] = []

    def kill(share: float) -> None:
        if share > 0.2 and not killed:
            victim = random.Random(7).choice(list(client.cluster.workers.values()))
            killed.append(victim.pid)
            os.kill(victim.pid, signal.SIGKILL)

    frame = splatvol.dask.render(scene, client, block=16, progress=kill)
    assert killed
    assert linear(frame) == whole


def test_animations_of_a_cluster_are_those_of_one_machine(
    scenes: dict[str, sv.Scene], cluster: Callable[[int], Any], tmp_path: Path
) -> None:
    import splatvol.dask

    scene = scenes["opaque"]
    scene.animate(tmp_path / "one.gif", frames=4, turntable=90)
    splatvol.dask.animate(scene, tmp_path / "many.gif", cluster(2), frames=4, turntable=90, block=40)
    assert (tmp_path / "many.gif").read_bytes() == (tmp_path / "one.gif").read_bytes()
    splatvol.dask.animate(scene, tmp_path / "f-##.png", cluster(2), frames=3, turntable=90)
    scene.animate(tmp_path / "one-##.png", frames=3, turntable=90)
    for index in range(3):
        # Put together and encoded by workers.
        assert (tmp_path / f"f-0{index}.png").read_bytes() == (tmp_path / f"one-0{index}.png").read_bytes()
    (tmp_path / "f-01.png").unlink()
    before = (tmp_path / "f-00.png").stat().st_mtime_ns
    splatvol.dask.animate(scene, tmp_path / "f-##.png", cluster(2), frames=3, turntable=90, resume=True)
    assert (tmp_path / "f-01.png").exists()
    assert (tmp_path / "f-00.png").stat().st_mtime_ns == before


def test_damaged_chunks_are_named_whoever_reads_them(head: Path, cluster: Callable[[int], Any], tmp_path: Path) -> None:
    import shutil

    import splatvol.dask

    damaged = tmp_path / "damaged.ome.zarr"
    shutil.copytree(head, damaged)
    scene = sv.Scene(damaged, size=32, view="left")
    chunks = sorted(path for path in (damaged / "0").rglob("*") if path.is_file() and path.parent.name.isdigit())
    for chunk in chunks:
        chunk.write_bytes(chunk.read_bytes()[:-3])
    recipe = sv.recipe(scene)
    for render in [
        lambda: sv.assemble([sv.part(recipe, "0/1")]),
        lambda: splatvol.dask.render(scene, cluster(2)),
    ]:
        with pytest.raises(sv.FormatError, match="chunk"):
            render()


def test_what_cannot_be_made_is_refused_by_name(ball: np.ndarray) -> None:
    with pytest.raises(sv.InvalidValue, match="is an array"):
        sv.recipe(ball)
    recipe = sv.recipe("sample:head:16", size=32)
    for key, says in [("0,0,40x40", "32x32 has no block"), ("3/2", "I/N"), ("", "expected")]:
        with pytest.raises(sv.InvalidValue, match=says):
            sv.part(recipe, key)
    one = sv.part(recipe, "0/2")
    with pytest.raises(sv.FormatError, match="have no part"):
        sv.assemble([one])
    with pytest.raises(sv.FormatError, match="not those that were written"):
        sv.assemble([one[:-1] + b"x", sv.part(recipe, "1/2")])
    with pytest.raises(sv.FormatError, match="recipe"):
        sv.assemble([one, sv.part(sv.recipe("sample:head:16", size=32, view="left"), "1/2")])
    with pytest.raises(sv.InvalidValue, match="at least one"):
        sv.assemble([])
