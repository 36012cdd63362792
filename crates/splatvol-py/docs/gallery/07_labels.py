"""Labels: cells of an embryo, each in its own colour, nothing interpolated between them."""

import numpy as np

import splatvol as sv

grid = np.stack(np.mgrid[-1:1:96j, -1:1:96j, -1:1:96j], axis=-1)
seeds = np.random.default_rng(11).normal(size=(26, 3)) * 0.45
distance = np.sum(seeds**2, axis=1) - 2 * grid @ seeds.T
cells = np.where(np.linalg.norm(grid, axis=-1) < 0.9, distance.argmin(axis=-1) + 1, 0)
cells[np.diff(np.partition(distance, 1)[..., :2])[..., 0] < 0.08] = 0
scene = sv.Scene(size=360, view="iso", zoom=0.93)
scene.add_labels(cells)
frame = scene.render()
