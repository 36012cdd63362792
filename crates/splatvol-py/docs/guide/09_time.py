"""Volumes over time: one look for all of them."""

import numpy as np

import splatvol as sv

z, y, x = np.mgrid[-1:1:32j, -1:1:32j, -1:1:32j]
beat = np.stack([np.clip(1 - np.hypot(np.hypot(x, y), z) / size, 0, 1) for size in (0.5, 0.7, 0.9)])
series = sv.Series(beat, axes="tzyx", spacing=0.5, times=[0.0, 0.4, 0.8])
scene = sv.Scene(series, size=(120, 120), clim=(0.05, 1.0), cmap="viridis")
scene.animate("beat-#.png", turntable=30, frames=3)
frame = sv.render(series.sel(0.8), size=(240, 240), clim=(0.05, 1.0), cmap="viridis")
