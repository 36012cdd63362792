"""Skin: everything denser than air is opaque."""

import splatvol as sv

skin = sv.TransferFunction([(-200, "#e0a184"), (300, "#f3cdb8")], [(-650, 0), (-250, 0.9)])
frame = sv.render("sample:head", tf=skin, view="front", azimuth=35, elevation=5, size=360)
