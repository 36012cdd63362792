"""Scenes in matplotlib's figures: rendered at the figure's final resolution."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import splatvol as sv

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("agg")
pyplot = pytest.importorskip("matplotlib.pyplot")


@pytest.fixture
def figure() -> Iterator[Any]:
    made = pyplot.figure(figsize=(2, 1.5), dpi=50, facecolor="white")
    yield made
    pyplot.close(made)


def pixels(figure: Any, dpi: float) -> np.ndarray[Any, Any]:
    file = io.BytesIO()
    figure.savefig(file, format="rgba", dpi=dpi)
    width, height = (figure.get_size_inches() * dpi).round().astype(int)
    return np.frombuffer(file.getvalue(), np.uint8).reshape(height, width, 4)


def test_a_figure_has_the_pixels_of_a_render_at_its_resolution(figure: Any) -> None:
    scene = sv.Scene("sample:head:24", view="left")
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    scene.artist(axes)
    for dpi in (50, 120):
        shown = pixels(figure, dpi)
        frame = scene.render(size=shown.shape[1::-1], background="none")
        # The figure is white, and mixes codes, not light.
        codes = np.asarray(frame).astype(float)
        alpha = codes[..., 3:] / 255
        expected = codes[..., :3] * alpha + 255 * (1 - alpha)
        assert np.abs(shown[..., :3] - expected).max() <= 2


def test_it_is_rendered_again_only_where_something_changed(figure: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = sv.Scene("sample:head:16")
    artist = scene.artist(figure.add_subplot())
    count = [0]
    render = sv.Scene.render

    def counted(self: sv.Scene, **options: Any) -> sv.Frame:
        count[0] += 1
        return render(self, **options)

    monkeypatch.setattr(sv.Scene, "render", counted)
    figure.canvas.draw()
    figure.canvas.draw()
    assert count == [1]
    scene.set(azimuth=30)
    figure.canvas.draw()
    artist.set_clim(0, 200)
    figure.canvas.draw()
    assert count == [3]


def test_the_colour_bar_has_the_scenes_colours_and_range(figure: Any, ball: np.ndarray[Any, Any]) -> None:
    scene = sv.Scene(ball, cmap="magma", clim=(0.25, 1.0), compositing="mip")
    axes = figure.add_subplot()
    artist = axes.add_artist(scene.artist(axes))
    bar = figure.colorbar(artist)
    assert (bar.vmin, bar.vmax) == pytest.approx((0.25, 1.0))
    own = matplotlib.colormaps["magma"](np.linspace(0, 1, 5))[:, :3]
    np.testing.assert_allclose(artist.to_rgba(np.linspace(0.25, 1.0, 5))[:, :3], own, atol=0.02)
    assert len([child for child in axes.get_children() if child is artist]) == 1


def test_pdf_has_the_pixels_of_its_dpi(figure: Any, tmp_path: Path) -> None:
    sv.Scene("sample:head:16").artist(figure.add_axes((0, 0, 1, 1)))
    path = tmp_path / "figure.pdf"
    figure.savefig(path, dpi=300)
    assert re.search(rb"/Width 600\b", path.read_bytes()) and re.search(rb"/Height 450\b", path.read_bytes())


def test_a_norm_keeps_its_kind_and_gets_the_scenes_range(figure: Any, ball: np.ndarray[Any, Any]) -> None:
    scene = sv.Scene(ball, cmap="magma", clim=(0.25, 1.0))
    artist = scene.artist(figure.add_subplot())
    # Zero is a number, and no number is none.
    artist.set_norm(matplotlib.colors.Normalize(vmax=0.75))
    figure.canvas.draw()
    assert (artist.norm.vmin, artist.norm.vmax) == pytest.approx((0.25, 0.75))
    norm = matplotlib.colors.PowerNorm(0.5, 0.0, 0.9)
    kept = sv.Scene(ball, cmap="magma", norm=norm)
    assert kept.artist(figure.add_subplot()).norm is norm
    assert kept.copy().artist(figure.add_subplot()).norm is norm
    # Other limits leave the norm's kind.
    kept.items[0].set(cmap="viridis", clim=(0, 1))
    again = kept.artist(figure.add_subplot()).norm
    assert type(again) is matplotlib.colors.PowerNorm and (again.vmin, again.vmax) == (0, 1) and norm.vmax == 0.9
    kept.items[0].set(norm=None)
    assert type(kept.artist(figure.add_subplot()).norm) is matplotlib.colors.Normalize


def test_long_lists_that_print_alike_are_told_apart(figure: Any, ball: np.ndarray[Any, Any]) -> None:
    values = np.linspace(0, 1, 2000)
    first = np.stack([values, values], axis=1)
    second = first.copy()
    second[900:1100, 1] = 0
    assert repr(first) == repr(second)
    scene = sv.Scene(ball)
    artist = scene.artist(figure.add_axes((0, 0, 1, 1)), opacity=first)
    one = pixels(figure, 50)
    artist._options["opacity"] = second
    assert not np.array_equal(one, pixels(figure, 50))


@pytest.mark.parametrize("compositing", ["mip", "mean"])
def test_projections_are_light_on_black(compositing: Any, figure: Any, ball: np.ndarray[Any, Any]) -> None:
    scene = sv.Scene(ball, cmap="gray", compositing=compositing)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    scene.artist(axes)
    shown = pixels(figure, 50)
    frame = np.asarray(scene.render(size=shown.shape[1::-1], background="black"))
    assert np.abs(shown.astype(int) - frame).max() <= 2 and shown[0, 0, :3].max() <= 2
    scene.set(background="white")
    assert pixels(figure, 50)[0, 0, 0] >= 253
