"""Maximum intensity, minimum intensity, mean and X-ray are kinds of compositing."""

import splatvol as sv

head = sv.read("sample:head:64")
frames = [
    head.render(compositing=kind, view="left", size=160, cmap="gray") for kind in ("mip", "minip", "mean", "xray")
]
frame = frames[0]
