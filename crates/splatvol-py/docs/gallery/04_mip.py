"""Maximum intensity projection: seeds shine through the flesh of a tomato."""

import splatvol as sv

frame = sv.render("sample:tomato:128", compositing="mip", cmap="inferno", view="top", size=360)
