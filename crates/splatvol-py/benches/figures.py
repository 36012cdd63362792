"""Figures of the Python package: times and memory, each in a fresh process. Run it on an idle machine.

``python benches/figures.py`` prints a line each: what, the median of some runs, and what it should be.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
from collections.abc import Callable

#: A ball in an array of 256^3 bytes: opaque within.
BALL = """
import numpy as np
z, y, x = np.ogrid[-1:1:256j, -1:1:256j, -1:1:256j]
ball = (np.clip(1.2 - np.sqrt(x**2 + y**2 + z**2), 0, 1) * 200).astype(np.uint8)
"""

IMPORT = """
import time, numpy
start = time.perf_counter()
import splatvol
print((time.perf_counter() - start) * 1000)
"""

FIRST_PICTURE = (
    BALL
    + """
import time
start = time.perf_counter()
import splatvol as sv
np.asarray(sv.render(ball, size=512))
print(time.perf_counter() - start)
"""
)

FIRST_PICTURE_PYVISTA = (
    BALL
    + """
import time
start = time.perf_counter()
import pyvista as pv
plotter = pv.Plotter(off_screen=True, window_size=(512, 512))
plotter.add_volume(ball)
plotter.screenshot(return_img=True)
print(time.perf_counter() - start)
"""
)

MEMORY = """
import resource, sys
import numpy as np
import splatvol as sv
def peak(): return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
z, y, x = np.ogrid[-1:1:1024j, -1:1:1024j, -1:1:1024j]
ball = np.zeros((1024, 1024, 1024), np.uint8)
for plane, z in zip(ball, z):
    plane[...] = np.clip(1.2 - np.sqrt(x**2 + y**2 + z**2), 0, 1)[0] * 200
before = peak()
volume = sv.Volume(ball)
made = peak()
volume.render(size=512)
print(made - before if sys.argv[1] == "volume" else peak() - before)
"""

CTRL_C = """
import os, signal, statistics, threading, time
import splatvol as sv
scene = sv.Scene("sample:head:160", size=1024, preset="best")
scene.render(size=16)
late = []
for n in range(20):
    sent = []
    def interrupt():
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)
    threading.Timer(0.1 + 0.02 * n, interrupt).start()
    try:
        while True:
            scene.render()
    except KeyboardInterrupt:
        late.append(time.perf_counter() - sent[0])
print(max(late) * 1000)
"""

GROWTH = """
import resource
import numpy as np
import splatvol as sv
scene = sv.Scene("sample:head:64", size=128)
def peak(): return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
for n in range(100): np.asarray(scene.render(azimuth=n))
before = peak()
for n in range(1000): np.asarray(scene.render(azimuth=n))
print(peak() - before)
"""

LOCK = """
import sys, threading, time
import splatvol as sv
scene = sv.Scene("sample:head:160", size=1024, preset="best")
scene.render(size=16)
sys.setswitchinterval(1e-4)
held, done = [0.0], threading.Event()
def watch():
    last = time.perf_counter()
    while not done.is_set():
        time.sleep(1e-3)
        now = time.perf_counter()
        held[0] += max(now - last - 6e-3, 0.0)
        last = now
thread = threading.Thread(target=watch)
thread.start()
start = time.perf_counter()
for _ in range(3): scene.render()
took = time.perf_counter() - start
done.set()
thread.join()
print(100 * held[0] / took)
"""


def measured(program: str, *arguments: str, runs: int = 5) -> float:
    """Median of what a program prints."""
    line = [sys.executable, "-c", program, *arguments]
    printed = [subprocess.run(line, check=True, capture_output=True, text=True).stdout for _ in range(runs)]
    return statistics.median(float(text.splitlines()[-1]) for text in printed)


def main() -> None:
    """Prints the figures."""
    figures: list[tuple[str, Callable[[], float], str]] = [
        ("import splatvol, beyond numpy, ms", lambda: measured(IMPORT, runs=9), "60"),
        ("first picture of 256^3 bytes, import included, s", lambda: measured(FIRST_PICTURE), "1.0"),
        ("the same by PyVista, s", lambda: measured(FIRST_PICTURE_PYVISTA), "at least 4 times ours"),
        ("Volume of a 1 GiB array, more memory, MiB", lambda: measured(MEMORY, "volume", runs=1), "1"),
        ("its first picture, more memory, MiB", lambda: measured(MEMORY, "picture", runs=1), "512"),
        ("Ctrl-C in preset best, longest of 20, ms", lambda: measured(CTRL_C, runs=1), "100"),
        ("1000 renders, more memory, MiB", lambda: measured(GROWTH, runs=1), "5"),
        ("other threads held up while it renders, %", lambda: measured(LOCK, runs=3), "1"),
    ]
    for name, figure, limit in figures:
        try:
            print(f"{name}: {figure():.3g} (limit {limit})", flush=True)
        except subprocess.CalledProcessError as error:
            print(f"{name}: failed: {error.stderr.splitlines()[-1]}", flush=True)


if __name__ == "__main__":
    main()
