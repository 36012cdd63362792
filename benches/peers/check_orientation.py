#!/usr/bin/env python3
"""Checks that both renderers show a volume the same way up: silhouettes of their pictures must cover each other.

splatvol turns volumes that stand on a heavy base across y, unless it is told which way is up. The bonsai does, where the
scans lie beside the repository: turned, 10 % of its silhouettes are in common, as it should be 89 % (the rest are leaves,
and edges). A tree on a plate, of which no turn looks the same, needs no scan. Exit code 1 where silhouettes differ.
"""

import environment

if __name__ == "__main__":
    environment.enter()

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

import scenes
from compare import SCANS, find_splatvol
from splatvol_renderer import Splatvol
from vtk_renderer import VtkRenderer

SIZE = 192
SHOWN = 24
"""Level of 8 bits from which a pixel belongs to the silhouette."""
DEMANDED_OVERLAP = 0.8
"""Pixels of both silhouettes, share of those of either. VTK shows half a voxel less on each side."""


def tree():
    """A trunk on a heavy plate across y, off the middle, so that no turn of it looks the same."""
    z, y, x = np.mgrid[0:64, 0:64, 0:64].astype(np.float32)
    trunk = (np.hypot(x - 26, z - 36) < 5) & (y < 50)
    crown = np.hypot(np.hypot(x - 26, z - 36), y - 48) < 12
    plate = (y < 8) & (abs(x - 32) < 26) & (abs(z - 32) < 26)
    values = np.where(trunk | crown | plate, 200, 0).astype(np.uint8)
    return scenes.Volume("tree", values, np.ones(3), iso=100.0, window=(0.0, 255.0))


def overlap(picture, other):
    """Common pixels of two silhouettes, share of those of either."""
    both = [p.max(2) >= SHOWN for p in (picture, other)]
    either = (both[0] | both[1]).sum()
    return (both[0] & both[1]).sum() / either if either else 0.0


def main():
    """Compares both renderers' pictures; returns whether all silhouettes agree."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--splatvol", type=Path, help="the program [default: as compare.py]")
    args = parser.parse_args()
    vtk, lighting, agree = VtkRenderer(SIZE, threads=2), scenes.Lighting(), True
    with tempfile.TemporaryDirectory(prefix="splatvol-peers-") as folder:
        splatvol = Splatvol(find_splatvol(args.splatvol), Path(folder), SIZE, 2, ["--preset=fast"])
        volumes = [tree()]
        if (SCANS / "bonsai.vti").is_file():
            volumes.append(splatvol.read(str(SCANS / "bonsai.vti")))
        else:
            print(f"skipped: bonsai: no {SCANS}")
        for volume in volumes:
            camera, look = scenes.camera(volume, "side", False), scenes.transfer_function(volume, "opaque")
            arguments = splatvol.scene(volume, look, lighting, camera)
            vtk.show(look, lighting, vtk.fixed_point(volume))
            theirs = vtk.frame(camera).copy()
            for name, ours in (("render", splatvol.picture(arguments)[0]), ("bench", splatvol.first_frame(arguments))):
                share = overlap(ours, theirs)
                print(f"{volume.name}, {name}: {share:.3f} of the silhouettes in common")
                agree &= bool(share >= DEMANDED_OVERLAP)
    return agree


if __name__ == "__main__":
    sys.exit(0 if main() else f"check_orientation.py: below {DEMANDED_OVERLAP}")
