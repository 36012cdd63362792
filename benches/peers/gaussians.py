"""Writes Gaussians on a dome, as a trained scene has them on surfaces: gaussians.py COUNT FILE.ply.

The same on every machine. They have harmonics of degree 3, and cover the dome as densely however many there are.
"""

import sys
from pathlib import Path

import numpy as np

RADIUS = 12.0
# Mean size of an axis with as many Gaussians as the scenes of 3-D Gaussian splatting have at most.
SIZE, COUNT = 0.02, 5.8e6


def dome(count: int) -> dict[str, np.ndarray]:
    """Properties of so many Gaussians, by their names in files."""
    random = np.random.default_rng(7)
    directions = random.normal(size=(count, 3)).astype(np.float32)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    directions[:, 1] = np.abs(directions[:, 1])
    places = directions * (RADIUS * (1 + random.normal(scale=0.02, size=(count, 1))))
    size = np.log(SIZE * (COUNT / count) ** 0.5)
    return {
        "x y z": places,
        " ".join(f"f_dc_{i}" for i in range(3)): random.normal(scale=0.8, size=(count, 3)),
        " ".join(f"f_rest_{i}" for i in range(45)): random.normal(scale=0.05, size=(count, 45)),
        "opacity": random.normal(scale=2, size=(count, 1)),
        " ".join(f"scale_{i}" for i in range(3)): random.normal(loc=size, scale=0.6, size=(count, 3)),
        " ".join(f"rot_{i}" for i in range(4)): random.normal(size=(count, 4)),
    }


def write(count: int, path: Path) -> None:
    """Writes them as PLY."""
    properties = dome(count)
    names = " ".join(properties).split()
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {count}"]
    header += [f"property float {name}" for name in names] + ["end_header", ""]
    rows = np.concatenate(list(properties.values()), axis=1, dtype=np.float32, casting="same_kind")
    with path.open("wb") as file:
        file.write("\n".join(header).encode())
        rows.tofile(file)


if __name__ == "__main__":
    write(int(sys.argv[1]), Path(sys.argv[2]))
