"""A mesh of hexahedra: cells may be curved, and need no grid."""

import numpy as np

import splatvol as sv

sides = np.linspace(1, 2, 9), np.linspace(0, 4.7, 65), np.linspace(-0.5, 0.5, 9)
r, a, z = np.meshgrid(*sides, indexing="ij")
points = np.stack([r * np.cos(a), r * np.sin(a), z * (1 + np.sin(3 * a) / 2)], axis=-1)
corner = np.arange(r.size).reshape(r.shape)[:-1, :-1, :-1].reshape(-1, 1)
cells = corner + np.array([0, 585, 594, 9, 1, 586, 595, 10])
mesh = sv.Mesh(points.reshape(-1, 3), cells, np.sin(6 * a) * np.cos(4 * r) * np.cos(2 * z))
frame = mesh.render(cmap="Spectral", opacity=[(-1, 1), (1, 1)], unit_distance=0.01, elevation=40, zoom=0.9, size=360)
