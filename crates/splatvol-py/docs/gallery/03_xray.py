"""X-ray: light that gets through, as on a film."""

import splatvol as sv

film = {"compositing": "xray", "cmap": "bone", "opacity": [(-900, 0), (1700, 0.06)]}
frame = sv.render("sample:head:192", view="left", size=360, **film)
