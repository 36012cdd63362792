"""A look: a colour map, the values at its ends, opacity by value, and the length to which opacity refers."""

import splatvol as sv

frame = sv.render(
    "sample:head:64",
    size=(240, 240),
    cmap="magma",
    clim=(40, 320),
    opacity=[(60, 0.0), (120, 0.05), (240, 0.9)],
    unit_distance=2.0,
)
