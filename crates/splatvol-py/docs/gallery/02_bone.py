"""Bone: opacity begins at 180 Hounsfield units."""

import splatvol as sv

bone = sv.TransferFunction([(200, "#c9b58c"), (1200, "#fffdf2")], [(180, 0), (320, 1)])
light = sv.Light(direction=(-0.6, -0.7, -0.8), ambient=0.25, diffuse=0.8, specular=0.25)
frame = sv.render("sample:head", tf=bone, light=light, view="front", azimuth=35, size=360)
