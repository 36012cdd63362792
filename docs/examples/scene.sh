#!/bin/sh
# Makes docs/images/scene.png: a volume, a ring of points and a helix of 3-D Gaussians. SPLATVOL: the command, if it is not to be built.
set -eu
cd "$(dirname "$0")"
awk 'BEGIN { pi = 3.14159265; print "x y z nx ny nz r g b"
  for (i = 0; i < 220; i++) for (j = 0; j < 40; j++) {
    u = 2 * pi * i / 220; v = 2 * pi * (j + 0.5 * (i % 2)) / 40; r = 125 + 10 * cos(v)
    print r * cos(u), r * sin(u), 10 * sin(v), cos(v) * cos(u), cos(v) * sin(u), sin(v), 230, 180 - 60 * cos(3 * u), 60 } }' > ring.txt
awk 'BEGIN { n = 160; pi = 3.14159265
  print "ply\nformat ascii 1.0\nelement vertex " n
  split("x y z scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3 opacity f_dc_0 f_dc_1 f_dc_2", p, " ")
  for (i = 1; i <= 14; i++) print "property float " p[i]
  print "end_header"
  for (i = 0; i < n; i++) { t = i / n; a = 6 * pi * t
    print 135 * cos(a), 110 - 220 * t, 135 * sin(a), 2.6, 1.6, 1.6, cos(a / 2), 0, -sin(a / 2), 0, 1.5, 1.6 * cos(2 * pi * t), 1.6 * cos(2 * pi * t - 2.1), 1.6 * cos(2 * pi * t + 2.1) } }' > helix.ply
render="render scene.toml --size 512x512 --view front --elevation 15 -w -o ../images/scene.png"
# shellcheck disable=SC2086
if [ -n "${SPLATVOL:-}" ]; then "$SPLATVOL" $render; else cargo run --quiet --release -- $render; fi
rm ring.txt helix.ply
