"""Measures what the model of many workers needs, on this machine, and writes `measured.json` beside it.

Needs the Python package with Dask (`pip install "splatvol[dask]"`). Workers are processes of one thread each, so that
rates are those of a core.

    python3 benches/scale/measure.py
    python3 benches/scale/model.py
"""

from __future__ import annotations

import argparse
import json
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from datetime import date
from pathlib import Path

import distributed

import splatvol as sv
import splatvol.dask

LOOK = {"size": 512, "view": "left", "preset": "fast"}


def median_seconds(work: Callable[[], object], times: int) -> float:
    """The median of several runs."""
    seconds = []
    for _ in range(times):
        start = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - start)
    return statistics.median(seconds)


def rates(path: Path) -> dict[str, float]:
    """Seconds of one core for a picture whose chunks are read, and for the same once they are at hand."""
    sv.set_threads(1)
    cold, warm = [], []
    for n in range(3):
        recipe = sv.recipe(path, azimuth=100.0 * n, **LOOK)
        for seconds in (cold, warm):
            start = time.perf_counter()
            sv.part(recipe, "0/1")
            seconds.append(time.perf_counter() - start)
    sv.set_threads(None)
    size = sum(file.stat().st_size for file in (path / "0").rglob("*") if file.is_file())
    return {"cold_seconds": statistics.median(cold), "warm_seconds": statistics.median(warm), "coded_bytes": size}


def client_of(workers: int) -> distributed.Client:
    """A cluster of processes of one thread each."""
    cluster = distributed.LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=":0")
    return distributed.Client(cluster)


def overhead(client: distributed.Client) -> float:
    """Seconds that a task takes beyond its part: of blocks of 32 x 32 pixels of a volume that costs nothing."""
    recipe = sv.recipe("sample:ball:8", size=512, preset="draft")
    keys = sv._parts.blocks(recipe, 32)
    sv.set_threads(1)
    alone = median_seconds(lambda: [sv.part(recipe, key) for key in keys], 3)
    sv.set_threads(None)
    seconds = []
    for azimuth in (10.0, 20.0, 30.0):
        # Dask knows a task of the same recipe again, and would not repeat it.
        look = {"size": 512, "preset": "draft", "azimuth": azimuth}
        start = time.perf_counter()
        splatvol.dask.render("sample:ball:8", client, block=32, **look)
        seconds.append(time.perf_counter() - start)
    return max(0.0, statistics.median(seconds) - alone) / len(keys)


def turntable(path: Path, client: distributed.Client, frames: int, first: float) -> float:
    """Frames a second of a turntable."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        splatvol.dask.animate(
            path, Path(folder) / "f-###.png", client, frames=frames, turntable=frames * 1.0, azimuth=first, **LOOK
        )
        return frames / (time.perf_counter() - start)


def main() -> None:
    """Measures and writes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--edge", type=int, default=256, help="samples along the edges of the volume")
    parser.add_argument("--frames", type=int, default=24, help="frames of the turntable")
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).with_name("measured.json"))
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shells.ome.zarr"
        line = [sys.executable, "-m", "splatvol", "convert", f"sample:shells:{asked.edge}", str(path), "--chunk", "64"]
        subprocess.run([*line, "--levels", "1", "-q"], check=True)
        found: dict[str, object] = {"edge": asked.edge, **rates(path)}
        speeds = {}
        for workers in (1, 2):
            client = client_of(workers)
            if workers == 1:
                found["overhead_seconds"] = overhead(client)
            turntable(path, client, 4, 200.0)
            speeds[str(workers)] = [turntable(path, client, asked.frames, 30.0 * n) for n in range(3)]
            client.close()
            client.cluster.close()
        found["frames_per_second"] = {workers: statistics.median(all_of) for workers, all_of in speeds.items()}
    found |= {"date": date.today().isoformat(), "processor": platform.processor() or platform.machine()}
    asked.output.write_text(json.dumps(found, indent=2) + "\n")
    print(json.dumps(found, indent=2))


if __name__ == "__main__":
    main()
