"""A depth map: distances of what is seen, coloured by one of matplotlib's maps."""

import numpy as np
from matplotlib import colormaps

import splatvol as sv

depth = sv.render("sample:head:192", iso=-500, iso_exact=True, view="front", azimuth=35, size=360).depth
near, far = np.min(depth), np.max(depth[np.isfinite(depth)])
frame = colormaps["magma"]((far - depth) / (far - near), bytes=True)
