"""Batches of frames, and what else kept the machine busy meanwhile."""

import dataclasses
import os
import time
from pathlib import Path


@dataclasses.dataclass
class Batch:
    """Milliseconds per frame; `others` is the share of the machine that other programs used (None: unknown)."""

    wall_ms: list[float]
    cpu_ms: list[float]
    others: float | None = None


class Machine:
    """Watches who uses the processors, from `__enter__` on."""

    def __enter__(self):
        self.start = self._read()
        self.others = None
        return self

    def __exit__(self, *_):
        end = self._read()
        if self.start and end and end[1] > self.start[1]:
            busy, total, own = (b - a for a, b in zip(self.start, end, strict=True))
            self.others = max(0.0, busy - own) / total

    @staticmethod
    def _read():
        """Busy, total and own processor seconds; None outside Linux."""
        try:
            ticks = [int(word) for word in Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:9]]
        except OSError:
            return None
        second = os.sysconf("SC_CLK_TCK")
        return (sum(ticks) - ticks[3] - ticks[4]) / second, sum(ticks) / second, sum(os.times()[:4])


def measure(frame, frames, warm_up):
    """Calls `frame(i)` in this process, i from 0 where the clock runs, negative before."""
    for i in range(-warm_up, 0):
        frame(i)
    batch = Batch([], [])
    with Machine() as machine:
        for i in range(frames):
            wall, cpu = time.perf_counter(), time.process_time()
            frame(i)
            batch.wall_ms.append((time.perf_counter() - wall) * 1e3)
            batch.cpu_ms.append((time.process_time() - cpu) * 1e3)
    batch.others = machine.others
    return batch
