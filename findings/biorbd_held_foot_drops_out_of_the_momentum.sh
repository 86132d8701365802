#!/usr/bin/env bash
# Version:  biorbd 1.12.4
# Does:     a model may stand on a segment without coordinates, as a foot held to the ground. mass, CoM and CoMdot count that segment;
#           CoMddot, angularMomentum, CalcAngularMomentum and CalcSegmentsAngularMomentum are those of what moves, about the
#           centre of what moves. So CoMddot is not the rate of CoMdot. With coordinates for the foot, in the same
#           motion of the same bodies, all agree with difference quotients and with a sum by hand.
# Guess:    one centre of mass for place, speed and acceleration.
# Means:    mass times (CoMddot minus gravity) is no longer the force of the ground: the dynamic part is too large by the share of
#           what is held. Optimal controls with the stance foot as root, and cameras' data fitted to such a model, see it.
#           Take the sum of mass times CoMddotBySegment, or give the root coordinates and hold them.
# Seen:     foot of 4 of 12 kg held: acceleration (0.642, 0.162, -1.871) for (0.428, 0.108, -1.247) m/s², 12/8 of it; angular
#           momentum about y 0.635 for 1.209 kg·m²/s; with six coordinates at the foot, standing still, both right to 1e-5
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check biorbd==1.12.4 numpy==2.4.6
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import biorbd
import numpy as np

SEGMENT = """segment {}
 parent {}
 rtinmatrix 0
 rt 0 0 0 xyz 0 0 {}
{} mass {}
 com 0.02 0 0.2
 inertia 0.03 0 0 0 0.03 0 0 0 0.004
endsegment
"""


def written(dofs):
    leg = SEGMENT.format("foot", "root", 0, dofs, 4) + SEGMENT.format("shin", "foot", 0.1, " rotations y\n", 3)
    return "version 4\ngravity 0 0 -9.81\n" + leg + SEGMENT.format("trunk", "shin", 0.4, " rotations xy\n", 5)


def seen(name, dofs):
    file = Path(name.replace(" ", "_") + ".bioMod")
    file.write_text(written(dofs))
    model = biorbd.Model(str(file))
    held = model.nbQ() - 3  # the foot stands still in either file
    q, v, a = (np.r_[np.zeros(held), each] for each in ([0.3, 0.2, -0.4], [1.0, -2.0, 1.5], [3.0, 2.0, -4.0]))

    def differenced(function):
        step = 1e-5
        there, back = (function(q + s * v + s * s / 2 * a, v + s * a).to_array() for s in (step, -step))
        return (there - back) / (2 * step)

    assert np.allclose(model.CoMdot(q, v).to_array(), differenced(lambda q, v: model.CoM(q)), atol=1e-8)
    true = differenced(model.CoMdot)
    own = np.array(model.CoMddot(q, v, a).to_array())
    # the spin about the centre of mass, by hand from the segments
    spin = np.zeros(3)
    centre, moving = model.CoM(q).to_array(), model.CoMdot(q, v).to_array()
    for each, mass in enumerate((4.0, 3.0, 5.0)):
        turn = model.globalJCS(q, each).to_array()[:3, :3]
        w = model.segmentAngularVelocity(q, v, each, True).to_array()
        arm = model.CoMbySegment(q, each).to_array() - centre
        speed = model.CoMdotBySegment(q, v, each).to_array() - moving
        spin += turn @ np.diag([0.03, 0.03, 0.004]) @ turn.T @ w + mass * np.cross(arm, speed)
    print(f"{name}: {model.mass()} kg; acceleration {own.round(3)} for {true.round(3)} m/s²,"
          f" angular momentum {model.angularMomentum(q, v).to_array().round(3)} for {spin.round(3)}")
    return own, true, np.array(model.angularMomentum(q, v).to_array()), spin


free = seen("foot with six coordinates", " translations xyz\n rotations xyz\n")
assert np.allclose(free[0], free[1], atol=1e-5) and np.allclose(free[2], free[3], atol=1e-8)
fixed = seen("foot held by the file", "")
assert np.allclose(fixed[1], free[1], atol=1e-5) and np.allclose(fixed[3], free[3])  # the same motion of the same bodies
assert np.allclose(fixed[0], 12 / 8 * fixed[1], atol=1e-5) and np.abs(fixed[2] - fixed[3]).max() > 0.5
PY
