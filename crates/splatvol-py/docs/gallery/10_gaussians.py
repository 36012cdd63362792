"""3-D Gaussians: a galaxy of thirty thousand."""

import numpy as np

import splatvol as sv

random = np.random.default_rng(5)
r, arm = random.gamma(2, 0.2, 30_000), random.integers(2, size=30_000)
turn = np.pi * arm + 3.2 * np.log(r + 0.08) + random.normal(0, 0.3, r.size)
means = np.stack([r * np.cos(turn), r * np.sin(turn), random.normal(0, 0.03, r.size)], axis=1)
blue = np.clip(r / 0.9, 0, 1)[:, None]
colors = (1 - blue) * (1.0, 0.8, 0.5) + blue * (0.35, 0.55, 1.0)
galaxy = sv.Gaussians(means, [[1, 0, 0, 0]] * r.size, random.uniform(0.004, 0.02, (r.size, 3)), 0.15, colors=colors)
frame = galaxy.render(view="front", elevation=40, zoom=1.8, size=360, gaussians="volumetric", background="#05060c")
