"""Several things in one scene: a volume, points around it, and a segmentation."""

import numpy as np

import splatvol as sv

head = sv.read("sample:head:48")
scene = sv.Scene(head, size=(240, 240), view="left", compositing="image-sheets")
turns = np.linspace(0, 6 * np.pi, 240)
ring = 110 * np.stack([np.cos(turns), np.sin(turns), np.linspace(-0.9, 0.9, 240)], axis=1)
scene.add(sv.Points(ring, radius=4.0), color="#ffcc33")
frame = scene.render()
