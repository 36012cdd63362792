"""A surface of one value, and a cut through it."""

import splatvol as sv

frame = sv.render(
    "sample:head:64", size=(240, 240), iso=200, iso_exact=True, clip=sv.Clip.plane((0, 0, 0), (0.3, 1, 0))
)
