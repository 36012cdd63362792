"""An array is a volume whose axes are named, never guessed. Its memory is shared, not copied."""

import numpy as np

import splatvol as sv

z, y, x = np.mgrid[-1:1:40j, -1:1:60j, -1:1:80j]
stack = np.exp(-6 * (x**2 + y**2 + 2 * z**2)) * (1 + np.sin(12 * x) * np.sin(12 * y))
volume = sv.Volume(stack, axes="zyx", spacing=(2.0, 0.7, 0.7), unit="um")
assert volume.is_shared
frame = volume.render(size=(240, 240), cmap="inferno")
