"""Arrays of dask, and lists of levels of detail."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .. import _arrays
from .._data import Volume
from .._errors import InvalidValue, LimitError
from ._levels import MOST_BYTES, choose_level


def from_dask(
    array: Any,
    *,
    axes: str = "zyx",
    spacing: _arrays.Lengths = None,
    level: int | str | None = "auto",
    max_bytes: int | None = None,
) -> Volume:
    """A volume of a dask array, or of a list of its levels of detail, computed.

    Parameters
    ----------
    array : dask array, or a list or tuple of them
        The samples; or levels of detail, the finest first, all of the same extent.
    axes : str
        What the axes are.
    spacing : optional
        World length between samples of the finest level: see :class:`splatvol.Volume`.
    level : int or "auto"
        Which level; by default the finest one of at most `max_bytes`. One array is thinned to every 2nd, 4th, ...
        sample by 1, 2, ..., and never by itself.
    max_bytes : int, optional
        Most bytes of samples, 4 GiB by default; more are refused before they are computed.

    Examples
    --------
    >>> import dask.array as da, splatvol as sv
    >>> levels = [da.zeros((n, n, n), dtype="u1") for n in (32, 16, 8)]
    >>> sv.from_dask(levels, max_bytes=5000).spacing
    (2.0, 2.0, 2.0)
    """
    if isinstance(array, (list, tuple)):
        return _of_levels(array, axes, spacing, level, max_bytes)
    _arrays.check_axes(axes, array.ndim)
    steps = _arrays.steps_of(spacing, axes)
    factor = 1
    if level is not None and level != "auto":
        if isinstance(level, str) or not 0 <= level < 32:
            raise InvalidValue(f"level: {level!r} is not 'auto', 0, 1, 2, ...", field="level", value=repr(level))
        factor = 2**level
    thin = array[(slice(None, None, factor),) * 3]
    limit = MOST_BYTES if max_bytes is None else max_bytes
    if thin.nbytes > limit:
        more = 1
        while thin.nbytes / 8**more > limit:
            more += 1
        step = factor * 2**more
        raise LimitError(
            f"{thin.nbytes} bytes exceed max_bytes={limit}: write level={step.bit_length() - 1}, which is "
            f"array[::{step}, ::{step}, ::{step}], or max_bytes={thin.nbytes}"
        )
    # The first sample stays where it is.
    sizes = [array.shape[axes.index(axis)] for axis in "xyz"]
    origin = {axis: -0.5 * (n - 1) * step for axis, n, step in zip("xyz", sizes, steps, strict=True)}
    wide = {axis: step * factor for axis, step in zip("xyz", steps, strict=True)}
    return Volume(np.asarray(thin), axes=axes, spacing=wide, origin=origin)


def _of_levels(
    levels: Sequence[Any], axes: str, spacing: _arrays.Lengths, level: int | str | None, max_bytes: int | None
) -> Volume:
    if not levels:
        raise InvalidValue("data: a list of no levels", field="data")
    for array in levels:
        _arrays.check_axes(axes, array.ndim)
    chosen = levels[choose_level([array.shape for array in levels], levels[0].dtype.itemsize, level, max_bytes)]
    steps = _arrays.steps_of(spacing, axes)
    ratio = [levels[0].shape[axes.index(axis)] / chosen.shape[axes.index(axis)] for axis in "xyz"]
    wide = {axis: step * times for axis, step, times in zip("xyz", steps, ratio, strict=True)}
    return Volume(np.asarray(chosen), axes=axes, spacing=wide)
