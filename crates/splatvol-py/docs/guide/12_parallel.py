"""Many pictures at once: scenes are pickled, and every process makes the same bytes."""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np

import splatvol as sv


def rendered(scene: sv.Scene) -> np.ndarray:
    """The codes of a scene's picture."""
    return np.asarray(scene.render())


if __name__ == "__main__":
    scenes = [sv.Scene("sample:head:24", size=(80, 80), azimuth=30 * n) for n in range(4)]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        pictures = list(pool.map(rendered, scenes))
    assert all(np.array_equal(picture, rendered(scene)) for picture, scene in zip(pictures, scenes, strict=True))
frame = sv.render("sample:head:24", size=(80, 80))
