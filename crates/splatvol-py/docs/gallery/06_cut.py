"""Cut open: a box is taken out, and cut faces have the colours of what was cut."""

import splatvol as sv

quarter = sv.Clip.box((-200, 0), (0, 200), (15, 200), keep="outside")
colors = [(-150, "#d9a58b"), (-20, "#c9877a"), (100, "#b5635a"), (220, "#f0e6cf"), (1000, "#fffdf5")]
tf = sv.TransferFunction(colors, [(-650, 0), (-250, 1)])
frame = sv.render("sample:head:192", tf=tf, clip=quarter, view="front", azimuth=30, elevation=30, size=360, zoom=0.92)
