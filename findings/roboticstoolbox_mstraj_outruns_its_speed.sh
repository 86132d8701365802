#!/usr/bin/env bash
# Version:  roboticstoolbox-python 1.5.0 (numpy 2.4.6)
# Does:     mstraj(..., qdmax=..., tacc=...) joins via points by straight parts and polynomial blends, "governed by the speed of the
#           slowest axis"; qdmax is the "maximum speed". The straight parts keep below it. In the first and the last
#           blend the axis goes faster, by 37 % here and by up to half: they bring it from rest to its speed in the time in
#           which, at that speed throughout, it would have come as far, so that it must overtake. With tsegment the same blends
#           go at 1.49 times the speed of the straight part. The qd that is returned says so. Nothing else does.
# Guess:    no axis is faster than qdmax anywhere; blends smooth the speed, they do not raise it.
# Means:    a leg that is moved by such a trajectory between poses trips the speed limit of its drives at the first and the last
#           blend of every motion. Plan with qdmax / 1.5, or time the path with a method that has limits.
# Seen:     0 to 1 rad, 1 rad/s, blends of 0.2 s: straight part 0.909, largest 1.375 rad/s; four via points, two axes, limits 1 and
#           2 rad/s: 1.375 and 2.750; blends of 0.02 s: 1.50 rad/s; differences of q say the same
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check roboticstoolbox-python==1.5.0 numpy==2.4.6
"$work/env/bin/python" -W ignore - <<'PY'
import numpy as np
from roboticstoolbox import mstraj

DT = 0.001


def fastest(via, **how):
    """Largest speeds of the axes: as returned, by differences of q, and in the straight parts."""
    motion = mstraj(np.array(via, dtype=float), DT, **how)
    speed = np.diff(motion.q, axis=0) / DT
    straight = np.abs(np.diff(speed, axis=0)).max(axis=1) < 1e-9
    return np.abs(motion.qd).max(axis=0), np.abs(speed).max(axis=0), np.abs(speed[1:][straight]).max(axis=0)


for name, limit, (told, seen, straight) in (
    ("one segment", np.array([1.0]), fastest([[0], [1]], tacc=0.2, qdmax=[1.0])),
    ("four points", np.array([1.0, 2.0]), fastest([[0, 0], [1, 2], [2, -1], [0, 0.5]], tacc=0.2, qdmax=[1.0, 2.0])),
    ("short blends", np.array([1.0]), fastest([[0], [2]], tacc=0.02, qdmax=[1.0])),
):
    print(f"{name}: limit {limit}, straight part {straight.round(3)}, largest {seen.round(3)} rad/s (qd {told.round(3)})")
    assert (straight < limit).all() and (seen > 1.3 * limit).all() and np.allclose(told, seen, rtol=0.02)

told, seen, straight = fastest([[0], [1]], tacc=0.2, tsegment=[1.0])
print(f"one second for 1 rad: straight part {straight.round(3)}, largest {seen.round(3)} rad/s")
assert np.isclose(straight, 1.0) and 1.45 < seen < 1.52
PY
