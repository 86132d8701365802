#!/usr/bin/env bash
# Version:  placo 0.10.2
# Does:     SwingFoot.make_trajectory(..., height, start, target) is one cubic whose velocities at lift-off and
#           touchdown follow from height and from the difference in level. On level ground it rises to 4/3 of
#           height and lands at 0.44 m/s. Onto a stair of 0.1 m it rises all the way and arrives from below,
#           moving upward; at 5/6 of the way it is half a stair below the tread. SwingFootQuintic rises to 16/9 of
#           height and comes from below, too, at rest. Nothing is said of either.
# Guess:    height is how high the foot goes, over the higher of the two footholds, and a foot comes down to land.
#           (SwingFootCubic goes to height on level ground; onto a stair as high as height it never rises above.)
# Means:    swing feet from these functions run through the edge of a stair, and the first contact is a stub of
#           the toe that no plan of the zero-moment point foresees. Give height at least twice the stair and look at
#           the velocity at the end, or make the swing of two pieces with a point above the edge.
# Seen:     height 0.05, 0.6 s, 0.3 m ahead: level: top 0.0667 (Quintic 0.0889, Cubic 0.0500), landing at
#           -0.444 m/s; stair 0.1 m: top 0.1000 at the very end, landing at +0.611 m/s, 0.049 m high at
#           0.25 m; stair of 0.1 m downward: landing at -1.5 m/s
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check placo==0.10.2
"$work/env/bin/python" - <<'PY'
import numpy as np
import placo

HEIGHT, END = 0.05, 0.6


def swing(kind, level):
    """Top, height where 5/6 of the way are gone, and upward velocity at touchdown."""
    start, target = np.array([0.0, 0.1, 0.0]), np.array([0.3, 0.1, level])
    if kind == "SwingFootCubic":  # rises and sinks in a fifth of the time each
        path = placo.SwingFootCubic.make_trajectory(0.0, END, HEIGHT, 0.2, start, target, 0.0, np.zeros(3))
    else:
        path = getattr(placo, kind).make_trajectory(0.0, END, HEIGHT, start, target)
    times = np.linspace(0.0, END, 6001)
    places = np.array([path.pos(t) for t in times])
    assert np.abs(places[0] - start).max() < 1e-9 and np.abs(places[-1] - target).max() < 1e-9
    late = places[np.argmax(places[:, 0] >= 0.25), 2]
    return places[:, 2].max(), late, path.vel(END)[2]


seen = {}
for level in (0.0, 0.1, -0.1):
    for kind in ("SwingFoot", "SwingFootQuintic", "SwingFootCubic"):
        seen[kind, level] = top, late, rate = swing(kind, level)
        print(f"target {level:4} m, {kind:16}: top {top:.4f} m, {late:.3f} m high at 0.25 m, lands at {rate:+.3f} m/s")
assert abs(seen["SwingFoot", 0.0][0] - HEIGHT * 4 / 3) < 1e-6
assert abs(seen["SwingFootQuintic", 0.0][0] - HEIGHT * 16 / 9) < 1e-6
assert abs(seen["SwingFootCubic", 0.0][0] - HEIGHT) < 1e-6
assert abs(seen["SwingFoot", 0.0][2] + 0.4444) < 1e-3 and abs(seen["SwingFoot", -0.1][2] + 1.5) < 1e-3
for kind in ("SwingFoot", "SwingFootQuintic"):
    assert abs(seen[kind, 0.1][0] - 0.1) < 1e-9 and seen[kind, 0.1][1] < 0.051  # below the tread until the end
assert abs(seen["SwingFoot", 0.1][2] - 0.6111) < 1e-3
PY
