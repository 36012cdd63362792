"""Two volumes in one scene: activity, as of PET, in a head of glass."""

import numpy as np

import splatvol as sv

z, y, x = np.mgrid[-1:1:48j, -1:1:48j, -1:1:48j]
hot = np.exp(-25 * ((x + 0.35) ** 2 + y**2 + z**2)) + np.exp(-25 * ((x - 0.4) ** 2 + (y - 0.3) ** 2 + (z - 0.2) ** 2))
scene = sv.Scene(size=360, view="front", azimuth=40, compositing="image-sheets")
glass = {"cmap": "bone", "clim": (-800, 1200), "opacity": [(-600, 0), (-300, 0.06), (150, 0.01), (500, 0.08)]}
scene.add("sample:head:160", unit_distance=4, **glass)
glow = {"cmap": "hot", "clim": (0, 0.8), "opacity": [(0.1, 0), (0.8, 0.9)]}
scene.add(sv.Volume(hot, spacing=3), unit_distance=4, translate=(0, 0, 40), **glow)
frame = scene.render()
