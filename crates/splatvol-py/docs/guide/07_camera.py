"""A camera can be taken, turned and put back; a parallel projection has a height in world lengths."""

import splatvol as sv

scene = sv.Scene("sample:head:48", size=(240, 240), view="front")
scene.camera = scene.camera.orbit(azimuth=35, elevation=20).zoom(1.2)
frame = scene.render()
flat = scene.render(camera=sv.Camera((0, -500, 0), (0, 0, 0), height=260.0))
