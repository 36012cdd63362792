"""A turntable as one file; frames, films and animated PNGs are made likewise."""

import splatvol as sv

scene = sv.Scene("sample:head:32", size=(120, 120))
scene.animate("turn.gif", turntable=90, frames=6, fps=6)
frame = scene.render()
