"""An isosurface at its exact place, cut from marble."""

import splatvol as sv

light = sv.Light(direction=(-0.7, -0.6, -0.6), specular=0.4, specular_power=40)
marble = {"iso": -500, "iso_exact": True, "texture": "marble", "texture_scale": 0.12}
frame = sv.render("sample:head:192", light=light, view="front", azimuth=-30, size=360, **marble)
