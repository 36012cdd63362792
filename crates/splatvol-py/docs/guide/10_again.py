"""A picture remembers how it was made, and its scene can be made again, by Python or by the command."""

import splatvol as sv

first = sv.render("sample:head:48", size=(160, 160), azimuth=40, cmap="magma", clim=(50, 300))
first.save("first.png")
scene = sv.like("first.png")
frame = scene.render(zoom=1.5)
assert sv.compare(scene.render(), first).psnr == float("inf")
