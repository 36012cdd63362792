"""Animations have the frames of the command's; series run through their times."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import splatvol as sv
from splatvol._verbs import pixels_of


def frames_by_command(folder: Path, *flags: str) -> list[np.ndarray[Any, Any]]:
    line = [sys.executable, "-m", "splatvol", "animate", "sample:head:24", *flags, "-o", str(folder / "c-##.png"), "-q"]
    subprocess.run(line, check=True, capture_output=True)
    return [np.asarray(pixels_of(path)) for path in sorted(folder.glob("c-*.png"))]


@pytest.mark.parametrize(
    ("options", "flags"),
    [
        ({"turntable": 120, "frames": 3}, ["--turntable", "120", "--frames", "3"]),
        (
            {"frames": 2, "shutter": 0.5, "ease": True, "view": "left"},
            ["--frames", "2", "--shutter", "0.5", "--ease", "--view", "left"],
        ),
    ],
)
def test_frames_are_the_commands(options: dict[str, Any], flags: list[str], tmp_path: Path) -> None:
    theirs = frames_by_command(tmp_path, *flags, "--size", "40")
    sv.animate("sample:head:24", tmp_path / "p-##.png", size=40, **options)
    ours = [np.asarray(pixels_of(path)) for path in sorted(tmp_path.glob("p-*.png"))]
    assert len(ours) == len(theirs) == options["frames"]
    for one, other in zip(ours, theirs, strict=True):
        np.testing.assert_array_equal(one, other)


def test_files(tmp_path: Path) -> None:
    scene = sv.Scene("sample:head:16", size=24)
    for name in ("a.gif", "a.apng"):
        path = scene.animate(tmp_path / name, frames=3, fps=10)
        assert path.stat().st_size > 100
    with pytest.raises(sv.InvalidValue, match="gif"):
        scene.animate(tmp_path / "a.avi", frames=2)
    with pytest.raises(sv.InvalidValue, match="together"):
        scene.animate(tmp_path / "a-#-#.png", frames=2)
    with pytest.raises(sv.InvalidValue, match="more #"):
        scene.animate(tmp_path / "a-#.png", frames=12)
    with pytest.raises(FileNotFoundError):
        scene.animate(tmp_path / "nowhere" / "a.gif", frames=2)
    with pytest.raises(sv.Cancelled):
        scene.animate(tmp_path / "b.gif", frames=4, progress=lambda share: share < 0.4)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.apng", "a.gif"], "no half files are left"


def test_frames_are_continued(tmp_path: Path) -> None:
    scene = sv.Scene("sample:head:16", size=24)
    scene.animate(tmp_path / "f-#.png", frames=3)
    (tmp_path / "f-1.png").unlink()
    kept = (tmp_path / "f-0.png").stat().st_mtime_ns
    scene.animate(tmp_path / "f-#.png", frames=3, resume=True)
    assert (tmp_path / "f-0.png").stat().st_mtime_ns == kept and (tmp_path / "f-1.png").exists()


def test_paths_of_cameras(tmp_path: Path) -> None:
    scene = sv.Scene("sample:head:16", size=24, view="front")
    first = scene.camera
    scene.animate(tmp_path / "k-#.png", keys=[(0, first), (1, first.orbit(60))], frames=3)
    seen = np.asarray(pixels_of(tmp_path / "k-0.png"))
    np.testing.assert_array_equal(seen, np.asarray(scene.render()))
    with pytest.raises(sv.InvalidValue, match="Camera"):
        scene.animate(tmp_path / "k.gif", keys=[(0, (1, 2, 3)), (1, (1, 2, 3))])


def test_series(tmp_path: Path, ball: np.ndarray) -> None:
    stack = np.stack([ball * share for share in (0.25, 0.5, 1.0)])
    series = sv.Series(stack, axes="tzyx", spacing=(3, 2, 1), times=[0, 10, 20])
    assert len(series) == 3 and series.sel(11) is series[1] and series[0].is_shared
    np.testing.assert_array_equal(np.asarray(sv.Series(np.moveaxis(stack, 0, 3), axes="zyxt")[2]), stack[2])
    scene = sv.Scene(series, size=32, clim=(0.1, 1.0), cmap="gray", compositing="mip")
    scene.camera = scene.camera
    scene.animate(tmp_path / "t-#.png", frames=3, turntable=0)
    seen = [np.asarray(pixels_of(path)) for path in sorted(tmp_path.glob("t-*.png"))]
    brightest = [picture[..., :3].max() for picture in seen]
    assert brightest[0] < brightest[1] < brightest[2]
    still = sv.Scene(sv.Volume(stack[2], spacing=(3, 2, 1)), size=32, clim=(0.1, 1.0), cmap="gray", compositing="mip")
    np.testing.assert_array_equal(seen[2], np.asarray(still.render(camera=scene.camera)))
    with pytest.raises(sv.InvalidValue, match="t for time"):
        sv.Series(stack, axes="zyx")
    with pytest.raises(sv.InvalidValue, match="times"):
        sv.Series(stack, times=[1])
