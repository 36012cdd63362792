"""A cloud of points with normals and colours."""

import numpy as np

import splatvol as sv

n = np.arange(60_000)
u, v = n * 2.399963, 2 * np.pi * n / n.size
tube = np.stack([np.cos(u) * np.cos(2 * v), np.cos(u) * np.sin(2 * v), np.sin(u)], axis=1)
knot = np.stack([(2 + np.cos(3 * v)) * np.cos(2 * v), (2 + np.cos(3 * v)) * np.sin(2 * v), np.sin(3 * v)], axis=1)
rgb = 128 + 127 * np.cos(v[:, None] * 2 + np.array([0, 2.1, 4.2]))
frame = sv.Points(knot + 0.4 * tube, rgb=rgb.astype(np.uint8), normal=tube, radius=0.03).render(view="top", size=360)
