"""Looks: what is said anew, what holds on, what contradicts itself, and norms."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import splatvol as sv

colors = pytest.importorskip("matplotlib.colors")

TF = sv.TransferFunction([(0, "#ff0000"), (1.2, "#00ff00")], [(0, 0), (1.2, 0.5)], 1.0)


def pixels(data: Any, **options: Any) -> np.ndarray:
    """Pixels of data or of a scene."""
    return np.asarray(sv.render(data, **options) if isinstance(data, sv.Scene) else sv.render(data, size=40, **options))


@pytest.mark.parametrize(
    ("before", "change", "after"),
    [
        ({"tf": TF}, {"cmap": "magma"}, {"cmap": "magma"}),
        ({"tf": TF}, {"tf": None}, {}),
        ({"tf": TF}, {"tf": None, "clim": (0, 0.6)}, {"clim": (0, 0.6)}),
        ({"tf": TF}, {"iso": 0.5}, {"iso": 0.5}),
        ({"cmap": "magma"}, {"tf": TF}, {"tf": TF}),
        ({"cmap": "tab10"}, {"clim": (0, 0.4)}, {"cmap": "tab10", "clim": (0, 0.4)}),
        ({"cmap": "tab10", "clim": (0, 0.4)}, {"vmax": 0.9}, {"cmap": "tab10", "vmin": 0, "vmax": 0.9}),
        ({"cmap": "tab10", "vmin": 0.1}, {"clim": (0, 0.4)}, {"cmap": "tab10", "clim": (0, 0.4)}),
        ({"cmap": "tab10", "clim": (0, 0.4)}, {"clim": None}, {"cmap": "tab10"}),
        ({"cmap": "tab10", "clim": (0, 0.4)}, {"clim": "auto"}, {"cmap": "tab10"}),
        ({"cmap": "tab10"}, {"cmap": "magma"}, {"cmap": "magma"}),
        ({"cmap": "tab10"}, {"cmap": None}, {}),
        ({"cmap": "magma"}, {"opacity": [(0.2, 0), (1, 0.5)]}, {"cmap": "magma", "opacity": [(0.2, 0), (1, 0.5)]}),
        ({"cmap": "tab10", "unit_distance": 3}, {"unit_distance": 1}, {"cmap": "tab10", "unit_distance": 1}),
        (
            {"norm": colors.PowerNorm(2, 0.1, 0.9)},
            {"clim": (0, 1)},
            {"norm": colors.PowerNorm(2, 0, 1)},
        ),
        ({"clim": (0, 0.5)}, {"norm": colors.PowerNorm(2, 0.1, 0.9)}, {"norm": colors.PowerNorm(2, 0.1, 0.9)}),
    ],
)
def test_what_is_said_anew_is_seen(ball: np.ndarray, before: Any, change: Any, after: Any) -> None:
    expected = pixels(ball, **after)
    scene = sv.Scene(ball, size=40, **before)
    assert not np.array_equal(pixels(scene), expected)
    np.testing.assert_array_equal(pixels(scene, **change), expected)
    np.testing.assert_array_equal(pixels(scene), pixels(ball, **before), "for one picture only")
    np.testing.assert_array_equal(pixels(scene.copy(), **change), expected)
    scene.items[0].set(**change)
    np.testing.assert_array_equal(pixels(scene), expected)


@pytest.mark.parametrize("look", [{"cmap": "tab10"}, {"tf": TF}])
def test_looks_that_were_said_hold_for_other_kinds_of_pictures(ball: np.ndarray, look: Any) -> None:
    expected = pixels(ball, compositing="mip", **look)
    assert not np.array_equal(expected, pixels(ball, compositing="mip"))
    scene = sv.Scene(ball, size=40, **look)
    np.testing.assert_array_equal(pixels(scene, compositing="mip"), expected)
    np.testing.assert_array_equal(pixels(pickle.loads(pickle.dumps(scene)), compositing="mip"), expected)
    np.testing.assert_array_equal(pixels(sv.Scene(ball, size=40), compositing="mip", **look), expected)
    scene.add(ball, visible=False)
    np.testing.assert_array_equal(pixels(scene, compositing="mip"), expected)


@pytest.mark.parametrize(
    ("keyword", "value"),
    [
        ("cmap", "gray"),
        ("clim", (0, 1)),
        ("vmin", 0.1),
        ("norm", colors.Normalize()),
        ("opacity", "linear"),
        ("unit_distance", 2),
        ("iso", 0.5),
    ],
)
def test_looks_that_contradict_themselves_are_refused(
    ball: np.ndarray, keyword: str, value: Any, tmp_path: Path
) -> None:
    with pytest.raises(sv.InvalidValue, match=f"{keyword}: ") as raised:
        sv.Scene(ball, tf=TF, **{keyword: value})
    assert raised.value.field == keyword
    TF.save(tmp_path / "q.vp.json")
    beside: dict[str, Any] = {"tf": str(tmp_path / "q.vp.json"), keyword: value}
    if keyword in ("clim", "vmin", "unit_distance"):
        assert not np.array_equal(pixels(ball, **beside), pixels(ball, tf=beside["tf"]))
    else:
        with pytest.raises(sv.InvalidValue, match=f"{keyword}: "):
            sv.Scene(ball, **beside)
    if keyword not in ("cmap", "iso"):
        with pytest.raises(sv.InvalidValue, match=f"{keyword}: "):
            sv.Scene(ball, tf=TF).items[0].set(**{keyword: value})
        with pytest.raises(sv.InvalidValue, match=f"{keyword}: "):
            sv.Scene(ball, tf=TF).render(**{keyword: value})


def test_surfaces_at_their_place_have_the_colour_of_a_transfer_function(ball: np.ndarray) -> None:
    scene = sv.Scene(ball, size=40, tf=TF, iso=0.5, iso_exact=True)
    before = pixels(scene)
    scene.items[0].set(iso=0.9)
    np.testing.assert_array_equal(pixels(scene), pixels(ball, tf=TF, iso=0.9, iso_exact=True))
    assert not np.array_equal(pixels(scene), before)
    with pytest.raises(sv.InvalidValue, match="iso_exact"):
        sv.render(ball, cmap="tab10", iso=0.5)


def values(norm: Any, clim: tuple[float, float] = (10.0, 90.0)) -> np.ndarray:
    return np.array([value for value, _ in sv.TransferFunction.from_cmap("gray", clim, norm=norm).colors])


@pytest.mark.parametrize(
    ("norm", "same"),
    [
        (colors.PowerNorm(2), colors.PowerNorm(2, 10, 90)),
        (colors.SymLogNorm(1), colors.SymLogNorm(1, vmin=10, vmax=90)),
        (colors.TwoSlopeNorm(20), colors.TwoSlopeNorm(20, 10, 90)),
        (colors.CenteredNorm(50), colors.Normalize(10, 90)),
        (colors.CenteredNorm(40), colors.Normalize(-10, 90)),
        (colors.FuncNorm((np.square, np.sqrt)), colors.FuncNorm((np.square, np.sqrt), 10, 90)),
        (colors.AsinhNorm(3), colors.AsinhNorm(3, 10, 90)),
        (colors.LogNorm(vmax=90), colors.LogNorm(10, 90)),
        ("log", colors.LogNorm(10, 90)),
    ],
)
def test_norms_without_limits_keep_what_they_are(norm: Any, same: Any) -> None:
    limits = getattr(norm, "vmin", None), getattr(norm, "vmax", None)
    found = values(norm)
    np.testing.assert_allclose(found, same.inverse(np.linspace(0, 1, len(found))))
    assert (getattr(norm, "vmin", None), getattr(norm, "vmax", None)) == limits, "the caller's norm stays as it is"


@pytest.mark.parametrize(
    ("norm", "clim", "says"),
    [
        (colors.BoundaryNorm([0, 1, 2], 256), (0, 2), "BoundaryNorm is not invertible"),
        (colors.LogNorm(), (0, 100), "LogNorm from 0 to 100"),
        (colors.NoNorm(), (0, 100), "NoNorm"),
        (colors.TwoSlopeNorm(500), (0, 100), "TwoSlopeNorm"),
        ("lag", (0, 100), "lag"),
        (3, (0, 100), "3 is not one of matplotlib's norms"),
    ],
)
def test_norms_without_places_are_refused(norm: Any, clim: tuple[float, float], says: str) -> None:
    with pytest.raises(sv.InvalidValue, match=says) as raised:
        values(norm, clim)
    assert raised.value.field == "norm"


def test_limits_are_said_once(ball: np.ndarray) -> None:
    with pytest.raises(sv.InvalidValue, match="which the norm says"):
        sv.Scene(ball, norm=colors.Normalize(0, 1), clim=(0, 2))
    one = pixels(ball, norm=colors.PowerNorm(2, vmax=0.9), vmin=0.1)
    np.testing.assert_array_equal(one, pixels(ball, norm=colors.PowerNorm(2, 0.1, 0.9)))
