"""Faces as triangles, in the order in which files of them become triangles."""

from __future__ import annotations

from typing import Any

import numpy as np


def fans(connectivity: Any, offsets: Any) -> Any:
    """Triangles of convex polygons, each from its first corner; `offsets` has one more than polygons."""
    places, step = _triangles(connectivity, offsets)
    corners = np.asarray(connectivity)
    return np.column_stack([corners[places], corners[places + step + 1], corners[places + step + 2]])


def strips(connectivity: Any, offsets: Any) -> Any:
    """Triangles of strips: every corner after the second makes one with the two before it, every other one turned."""
    places, step = _triangles(connectivity, offsets)
    corners = np.asarray(connectivity)
    places = places + step
    odd = step % 2
    return np.column_stack([corners[places + odd], corners[places + 1 - odd], corners[places + 2]])


def _triangles(connectivity: Any, offsets: Any) -> tuple[Any, Any]:
    """Of every triangle the place of its face's first corner, and its number in the face."""
    offsets = np.asarray(offsets, dtype=np.int64)
    counts = np.maximum(np.diff(offsets) - 2, 0)
    starts = np.cumsum(counts) - counts
    step = np.arange(counts.sum()) - np.repeat(starts, counts)
    return np.repeat(offsets[:-1], counts), step
