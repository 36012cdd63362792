"""Work beside Python: interruption, threads, processes, memory."""

from __future__ import annotations

import concurrent.futures
import hashlib
import multiprocessing
import os
import pickle
import resource
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import splatvol as sv


def digest(frame: sv.Frame) -> str:
    return hashlib.sha256(np.asarray(frame).tobytes()).hexdigest()


def rendered(text: bytes) -> str:
    return digest(pickle.loads(text).render())


def test_progress_and_its_end() -> None:
    shares: list[float] = []
    scene = sv.Scene("sample:head:96", size=500, preset="best")
    scene.render(progress=shares.append)
    assert shares == sorted(shares) and all(0 <= share <= 1 for share in shares)
    with pytest.raises(sv.Cancelled):
        scene.render(progress=lambda share: False)
    with pytest.raises(ZeroDivisionError):
        scene.render(progress=lambda share: 1 / 0)


def test_cancelling_from_another_thread() -> None:
    scene = sv.Scene("sample:head:96", size=700, preset="best")
    scene.render(size=16)
    token = sv.CancelToken()
    threading.Timer(0.15, token.set).start()
    with pytest.raises(sv.Cancelled):
        while not token.is_set():
            scene.render(cancel=token)
    assert token.is_set()


def test_ctrl_c() -> None:
    # A shell's jobs in the background begin deaf to it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    scene = sv.Scene("sample:head:96", size=900, preset="best")
    scene.render(size=16)
    late: list[float] = []
    for _ in range(5):
        sent: list[float] = []

        def interrupt(sent: list[float] = sent) -> None:
            sent.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)

        threading.Timer(0.2, interrupt).start()
        with pytest.raises(KeyboardInterrupt):
            while True:
                scene.render()
        late.append(time.monotonic() - sent[0])
    # A benchmark measures; this finds a render that does not hear at all.
    assert max(late) < 2.0


def test_other_threads_run_meanwhile() -> None:
    counted = [0]
    done = threading.Event()

    def count() -> None:
        while not done.is_set():
            counted[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    before = counted[0]
    sv.render("sample:head:96", size=500, preset="best")
    after = counted[0]
    done.set()
    thread.join()
    assert after > before + 1000


def test_threads_of_python_render_at_once() -> None:
    scenes = [sv.Scene("sample:head:24", size=64, azimuth=10 * n) for n in range(8)]
    expected = [digest(scene.render()) for scene in scenes]
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        assert list(pool.map(lambda scene: digest(scene.render()), scenes * 3)) == expected * 3
    assert digest(scenes[0].submit().result()) == expected[0]


def test_arrays_are_given_back_by_threads_that_render() -> None:
    """Renderers hold the last references to arrays, and are dropped by threads without the interpreter's lock."""

    def render(seed: int) -> str:
        array = np.random.default_rng(seed).random((8, 8, 8), dtype=np.float32)
        return digest(sv.render(array, size=16))

    expected = [render(seed) for seed in range(8)]
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        futures = [pool.submit(render, seed % 8) for seed in range(160)]
        assert [future.result(timeout=60) for future in futures] == expected * 20


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
@pytest.mark.parametrize("method", ["spawn", "fork"])
def test_processes(method: str, ball: np.ndarray) -> None:
    scenes = [sv.Scene(ball, size=16, azimuth=7 * n) for n in range(200)]
    expected = [digest(scene.render()) for scene in scenes]
    context = multiprocessing.get_context(method)
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as pool:
        assert list(pool.map(rendered, map(pickle.dumps, scenes), timeout=120, chunksize=10)) == expected


def test_memory_does_not_grow(ball: np.ndarray) -> None:
    scene = sv.Scene(ball, size=48)
    for azimuth in range(50):
        np.asarray(scene.render(azimuth=azimuth))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for azimuth in range(250):
        np.asarray(scene.render(azimuth=azimuth))
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 5 * 1024


def test_the_command_is_in_the_package() -> None:
    run = subprocess.run([sys.executable, "-m", "splatvol", "--version"], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["splatvol", sv.__version__]
    wrong = subprocess.run([sys.executable, "-m", "splatvol", "rendr"], capture_output=True, text=True, check=False)
    assert wrong.returncode == 2 and "render" in wrong.stderr


def test_importing_loads_numpy_and_nothing_else() -> None:
    others = ("matplotlib", "xarray", "vtk", "PIL", "pyvista")
    text = f"import sys, splatvol; print([m for m in {others} if m in sys.modules])"
    run = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


def test_threads_are_refused_by_name() -> None:
    with pytest.raises(sv.InvalidValue, match="threads"):
        sv.set_threads(0)


@pytest.mark.parametrize(("said", "printed"), [("3", "3"), ("0", "InvalidValue"), ("many", "InvalidValue")])
def test_the_environment_says_how_many_threads(said: str, printed: str) -> None:
    text = (
        "import splatvol as sv\ntry: print(sv.threads())\nexcept sv.SplatvolError as error: print(type(error).__name__)"
    )
    environment = {**os.environ, "SPLATVOL_THREADS": said}
    run = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True, env=environment)
    assert run.stdout.strip() == printed
