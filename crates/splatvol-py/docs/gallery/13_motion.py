"""Motion blur: a landscape turns by 8 degrees while the shutter is open."""

import splatvol as sv

turn = {"spin": 8, "spin_axis": (0, 0, 1), "motion_blur": "subframes", "subframes": 16}
frame = sv.render("sample:terrain:160", elevation=25, size=360, **turn)
