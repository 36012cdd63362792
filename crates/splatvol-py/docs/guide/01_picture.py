"""A volume becomes a picture: any file that the command reads, or an array, or a built-in sample."""

import splatvol as sv

frame = sv.render("sample:head:64", view="left", size=(240, 240))
frame.save("head.png")
