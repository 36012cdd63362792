"""3-D Gaussians from arrays: means, rotations, standard deviations, opacities and colours."""

import numpy as np

import splatvol as sv

random = np.random.default_rng(7)
means = random.normal(size=(2000, 3)) * (1.0, 0.6, 0.3)
colors = 0.5 + 0.4 * np.tanh(means)
scales = random.uniform(0.02, 0.08, size=(2000, 3))
quaternions = random.normal(size=(2000, 4))
cloud = sv.Gaussians(means, quaternions, scales, 0.7, colors=colors)
frame = cloud.render(size=(240, 240), gaussians="volumetric")
