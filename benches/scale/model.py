"""What many workers would take, computed from `measured.json`: the tables of docs/scale.md.

    seconds = max(bytes / store, (decode and solve + draw) / cores, tasks * overhead)

`decode and solve` is what a picture takes longer whose chunks have to be read, per sample; `draw` the rest, per pixel.
A scheduler gives tasks away one after the other, so it bounds, and does not add to, what workers do side by side.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

#: Bytes a second that a parallel file system or an object store gives a cluster.
STORE = 25e9
#: Pixels along the edges of a block.
BLOCK = 512


@dataclass(frozen=True)
class Picture:
    """A picture or a film of a large volume."""

    name: str
    #: Samples of the level that is drawn, and bytes of each as they are stored.
    samples: float
    coded: float
    pixels: float
    frames: int = 1
    #: Share of the samples whose chunks are read.
    touched: float = 0.6


PICTURES = [
    Picture("2048³, 16 bits, 1024 x 1024", 2048**3, 1.2, 1024**2),
    Picture("10240 x 7680 x 1356 at full resolution, 30,000 x 20,000", 10240 * 7680 * 1356, 1.2, 6e8),
    Picture("10¹⁵ samples, 4K (its level of 3.1·10¹⁰)", 1e15 / 8**5, 1.2, 3840 * 2160),
    Picture("the same, 360 frames", 1e15 / 8**5, 1.2, 3840 * 2160, frames=360),
]


def seconds(picture: Picture, measured: dict[str, float], cores: int) -> dict[str, float]:
    """What bounds it, each by itself."""
    voxels = measured["edge"] ** 3
    per_sample = max(0.0, measured["cold_seconds"] - measured["warm_seconds"]) / voxels
    per_pixel = measured["warm_seconds"] / 512**2
    read = picture.samples * picture.touched
    tasks = picture.frames * max(1.0, picture.pixels / BLOCK**2)
    return {
        "store": picture.frames * read * picture.coded / STORE,
        "cores": picture.frames * (read * per_sample + picture.pixels * per_pixel) / cores,
        "scheduler": tasks * measured["overhead_seconds"],
    }


def main() -> None:
    """Prints the tables."""
    measured = json.loads(Path(__file__).with_name("measured.json").read_text())
    print("| picture | cores | store | cores' work | scheduler | all |\n|---|---|---|---|---|---|")
    for picture in PICTURES:
        for cores in (16, 1000):
            bounds = seconds(picture, measured, cores)
            figures = " | ".join(f"{bounds[name]:.3g} s" for name in ("store", "cores", "scheduler"))
            print(f"| {picture.name} | {cores} | {figures} | {max(bounds.values()):.3g} s |")


if __name__ == "__main__":
    main()
