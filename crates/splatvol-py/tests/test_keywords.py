"""Keywords: all of the document's keys, with their types; those of other programs are translated."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import splatvol as sv
from splatvol import _translations, _vocabulary

TOOL = Path(__file__).parent.parent / "tools" / "render_options.py"


def test_every_key_has_a_keyword_and_a_type() -> None:
    typed = {*sv.RenderOptions.__annotations__, *sv.ReadOptions.__annotations__}
    missing = {keyword for keyword in _vocabulary.keywords() if keyword not in typed}
    assert missing == set()


def test_the_typed_keywords_are_those_of_the_schema() -> None:
    spec = importlib.util.spec_from_file_location("render_options", TOOL)
    assert spec is not None and spec.loader is not None
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    assert tool.PATH.read_text() == tool.generated(), "run tools/render_options.py"


def test_at_least_forty_foreign_keywords_are_translated() -> None:
    assert len(_translations.TABLE) >= 40
    own = {*_vocabulary.keywords(), "camera", "clip", "norm", "vmin", "vmax"}
    assert not own & set(_translations.TABLE), "translations of keywords that exist"


@pytest.mark.parametrize("keyword", sorted(_translations.TABLE))
def test_foreign_keywords(keyword: str) -> None:
    options: dict[str, Any] = {keyword: 1}
    with pytest.raises(TypeError) as raised:
        sv.render("sample:head:8", size=8, **options)
    assert isinstance(raised.value, sv.UnknownKeyword) and raised.value.field == keyword
    message = str(raised.value)
    assert keyword in message and ("write" in message or "not needed" in message)


@pytest.mark.parametrize(
    ("keyword", "near"), [("azimut", "azimuth"), ("clims", "clim"), ("sise", "size"), ("colour", "color")]
)
def test_misspelt_keywords(keyword: str, near: str) -> None:
    options: dict[str, Any] = {keyword: 1}
    with pytest.raises(sv.UnknownKeyword, match=f"did you mean {near}="):
        sv.render("sample:head:8", **options)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"view": "frnt"}, "front"),
        ({"cmap": "no-such-map"}, "no-such-map"),
        ({"compositing": "additive"}, "additive"),
        ({"size": (0, 5)}, "size"),
        ({"size": 1 << 20}, "size"),
        ({"bits": 12}, "bits"),
        ({"preset": "ultra"}, "ultra"),
        ({"fov": 200.0}, "200"),
        ({"clim": (1, 2, 3)}, "clim"),
        ({"camera": (1, 2, 3)}, "Camera("),
        ({"color": "no-such-color"}, "no-such-color"),
        ({"light": (1, 2)}, "light"),
        ({"kernel_sigma": -1.0}, "-1"),
        ({"azimuth": float("nan")}, "azimuth"),
        ({"azimuth": "far"}, "azimuth"),
        ({"sheet_thickness": 0}, "thickness"),
    ],
)
def test_wrong_values_are_refused_by_name(options: dict[str, Any], says: str) -> None:
    if "size" not in options:
        options = {**options, "size": 8}
    with pytest.raises((sv.InvalidValue, sv.Combination)) as raised:
        sv.render("sample:head:8", **options)
    assert says in str(raised.value)


def test_keywords_of_files_are_refused_elsewhere(ball: np.ndarray) -> None:
    with pytest.raises(sv.InvalidValue, match="channel"):
        sv.render(ball, channel=1)


def test_looks_by_points_norms_and_foreign_maps(ball: np.ndarray) -> None:
    colors = pytest.importorskip("matplotlib.colors")
    maps = pytest.importorskip("matplotlib").colormaps

    def pixels(**options: Any) -> np.ndarray:
        return np.asarray(sv.render(ball, size=40, **options))

    assert not np.array_equal(pixels(cmap="Blues_r"), pixels(cmap="Reds_r"))
    np.testing.assert_array_equal(pixels(cmap="Blues_r"), pixels(cmap=maps["Blues_r"]))
    np.testing.assert_array_equal(pixels(vmin=0.2, vmax=0.9, cmap="gray"), pixels(clim=(0.2, 0.9), cmap="gray"))
    linear = pixels(cmap="Blues_r", clim=(0.2, 0.9))
    np.testing.assert_array_equal(pixels(cmap="Blues_r", norm=colors.Normalize(0.2, 0.9)), linear)
    assert not np.array_equal(pixels(cmap="Blues_r", norm=colors.LogNorm(0.2, 0.9)), linear)
    curve = pixels(cmap="gray", opacity=[(0.3, 0.0), (1.2, 0.9)], unit_distance=1.0)
    tf = sv.TransferFunction.from_cmap("gray", (0.0, 1.2), [(0.3, 0.0), (1.2, 0.9)], unit_distance=1.0)
    low, high = float(ball.min()), float(ball.max())
    same = sv.TransferFunction.from_cmap("gray", (low, high), [(0.3, 0.0), (1.2, 0.9)], unit_distance=1.0)
    np.testing.assert_array_equal(curve, pixels(tf=same))
    assert not np.array_equal(curve, pixels(tf=tf))
    with pytest.raises(sv.InvalidValue, match="vmin and vmax, or clim"):
        pixels(vmin=0, clim=(0, 1))
