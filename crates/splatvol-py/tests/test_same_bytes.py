"""Pictures by Python and by the command are equal, pixel for pixel."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import splatvol as sv

from .conftest import shared

Command = Callable[..., np.ndarray]

#: Samples with keywords, and the flags that say the same: every compositing, presets, clips, motion, cameras.
CASES: list[tuple[str, dict[str, Any], list[str]]] = [
    ("head:40", {}, []),
    ("head:40", {"preset": "best", "view": "left"}, ["--preset", "best", "--view", "left"]),
    ("head:40", {"compositing": "mip", "cmap": "gray"}, ["--compositing", "mip", "--cmap", "gray"]),
    ("head:40", {"compositing": "minip"}, ["--compositing", "minip"]),
    ("head:40", {"compositing": "mean"}, ["--compositing", "mean"]),
    ("head:40", {"compositing": "xray", "orthographic": True}, ["--compositing", "xray", "--orthographic"]),
    ("head:40", {"compositing": "per-splat"}, ["--compositing", "per-splat"]),
    ("head:40", {"compositing": "axis-sheets"}, ["--compositing", "axis-sheets"]),
    ("head:40", {"classification": "pre", "shade": False}, ["--classification", "pre", "--no-shade"]),
    (
        "marschner-lobb",
        {"clim": (0.2, 0.8), "opacity": "linear", "azimuth": 30, "elevation": -10, "zoom": 1.5},
        ["--clim", "0.2,0.8", "--opacity", "linear", "--azimuth", "30", "--elevation=-10", "--zoom", "1.5"],
    ),
    (
        "head:40",
        {"clip": sv.Clip.plane((0, 0, 0), (1, 0, 0)), "background": "white"},
        ["--clip-plane", "0,0,0:1,0,0", "--background", "white"],
    ),
    (
        "head:32",
        {"spin": 20, "motion_blur": "subframes", "subframes": 3},
        ["--spin", "20", "--motion-blur", "subframes", "--subframes", "3"],
    ),
]


@pytest.mark.parametrize(("sample", "options", "flags"), CASES)
def test_samples(sample: str, options: dict[str, Any], flags: list[str], command: Command) -> None:
    ours = sv.render(f"sample:{sample}", size=(120, 96), **options)
    theirs = command(f"sample:{sample}", "--size", "120x96", *flags)
    np.testing.assert_array_equal(np.asarray(ours), theirs)


def test_an_array_is_the_file_of_its_samples(ball: np.ndarray, tmp_path: Path, command: Command) -> None:
    np.save(tmp_path / "ball.npy", ball)
    theirs = command(tmp_path / "ball.npy", "--size", "90")
    np.testing.assert_array_equal(np.asarray(sv.render(ball, size=90)), theirs)
    np.testing.assert_array_equal(np.asarray(sv.render(tmp_path / "ball.npy", size=90)), theirs)


#: Small files of every kind but volumes, by name: two tetrahedra, a spiral, three Gaussians, and a slope.
MADE = {
    "cells.vtk": b"# vtk DataFile Version 3.0\ntwo\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 float\n"
    b"0 0 0 1 0 0 0 1 0 0 0 1 1 1 1\nCELLS 2 10\n4 0 1 2 3\n4 1 2 3 4\nCELL_TYPES 2\n10 10\n"
    b"POINT_DATA 5\nSCALARS T float 1\nLOOKUP_TABLE default\n1 2 3 4 5\n",
    "spiral.xyz": "\n".join(f"{np.cos(t / 9):.6f} {np.sin(t / 9):.6f} {t / 99:.6f}" for t in range(200)).encode(),
    "three.splat": b"".join(
        struct.pack("<6f8B", x, 0, 0, 0.3, 0.2, 0.1, 255 - 90 * x, 90 * x, 60, 220, 255, 128, 128, 128)
        for x in range(3)
    ),
    "slope.heights": b"0 1 2 3\n1 2 3 5\n2 3 5 8\n",
}


@pytest.mark.parametrize("name", MADE)
def test_every_kind_of_made_data(name: str, tmp_path: Path, command: Command) -> None:
    path = tmp_path / name
    path.write_bytes(MADE[name])
    theirs = command(path, "--size", "64")
    assert np.unique(theirs.reshape(-1, theirs.shape[-1]), axis=0).shape[0] > 10
    np.testing.assert_array_equal(np.asarray(sv.render(path, size=64)), theirs)


@pytest.mark.parametrize(
    "parts",
    [
        ("meshes", "can.vtu"),
        ("points", "autzen_trim.laz"),
        ("gaussians", "biker.spz"),
        ("volumes", "FLAIR.nii.gz"),
        ("terrain", "SainteHelens.dem"),
    ],
)
def test_every_kind_of_data(parts: tuple[str, str], command: Command) -> None:
    found = [path for path in shared(parts[0]).rglob(parts[1])]
    if not found:
        pytest.skip(f"{parts[1]} of the shared data is not here")
    theirs = command(found[0], "--size", "128")
    np.testing.assert_array_equal(np.asarray(sv.render(found[0], size=128)), theirs)


def test_a_scene_of_several_things(tmp_path: Path, command: Command) -> None:
    scene = sv.Scene("sample:head:24", size=96, view="iso")
    scene.add("sample:marschner-lobb", scale=20.0, translate=(60, 0, 0), cmap="magma")
    path = scene.save(tmp_path / "scene.toml")
    theirs = command(path)
    np.testing.assert_array_equal(np.asarray(scene.render()), theirs)
    np.testing.assert_array_equal(np.asarray(sv.load(path).render()), theirs)


def test_pictures_are_made_again(tmp_path: Path, command: Command) -> None:
    frame = sv.render("sample:head:24", size=64, azimuth=25, cmap="magma", clim=(100, 300))
    picture = frame.save(tmp_path / "picture.png")
    np.testing.assert_array_equal(np.asarray(sv.like(picture).render()), np.asarray(frame))
    np.testing.assert_array_equal(command("--like", picture), np.asarray(frame))


def test_threads_change_nothing() -> None:
    before = sv.threads()
    pictures = []
    for count in (1, 2, 3):
        sv.set_threads(count)
        assert sv.threads() == count
        pictures.append(np.asarray(sv.render("sample:head:24", size=64)))
    sv.set_threads(None)
    assert sv.threads() == before
    for picture in pictures[1:]:
        np.testing.assert_array_equal(picture, pictures[0])
