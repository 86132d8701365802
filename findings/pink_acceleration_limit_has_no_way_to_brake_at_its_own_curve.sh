#!/usr/bin/env bash
# Version:  pin-pink 4.4.0 with pin 4.1.0 (daqp, HiGHS and Clarabel solve)
# Does:     AccelerationLimit bounds the change of speed by a_max dt, and the speed by sqrt(2 a_max d) for the room d up
#           to the stop of the joint. The second is the braking of continuous time: who goes at that speed for one
#           step needs a change of more than a_max dt in the next, whatever dt is, and the two bounds exclude each other.
# Guess:    bounds that are obeyed from a start at rest can be obeyed on, step by step; the docstring cites two papers
#           on just that question.
# Means:    a knee that is sent fast towards its stop, or towards a posture well before it, ends in NoSolutionFound half
#           way; daqp, which lets 1e-6 pass, gets further at short steps and brakes harder than asked. Where it
#           happens brake by hand (the last speed less a_max dt), or give the task a low gain so that it stays below.
# Seen:     range ±1 rad, 3 rad/s, 10 rad/s², from rest at -0.5 rad towards 0.8 rad, at steps of 0.01 s: no solution at 0.594
#           rad and 2.95 rad/s (at most 0.028478 rad a step, at least 0.028496), at 0.002 s for HiGHS at 0.559 rad;
#           a task of gain 0.05 arrives at 0.01 s; by hand both as far apart as seen
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin-pink==4.4.0 pin==4.1.0 qpsolvers==4.13.0 numpy==2.4.6 \
    daqp==0.11.0 highspy==1.16.0 clarabel==0.11.1
"$work/env/bin/python" -W ignore - <<'PY' | sed -n 's/^## //p'
import numpy as np
import pink
import pinocchio as pin
from pink.exceptions import NoSolutionFound
from pink.limits import AccelerationLimit, ConfigurationLimit, VelocityLimit
from pink.tasks import PostureTask

MOST, STOP = 10.0, 1.0
model = pin.Model()
knee = model.addJoint(0, pin.JointModelRY(), pin.SE3.Identity(), "knee")
model.appendBodyToJoint(knee, pin.Inertia(1.0, np.zeros(3), 0.01 * np.eye(3)), pin.SE3.Identity())
model.lowerPositionLimit[:], model.upperPositionLimit[:], model.velocityLimit[:] = -STOP, STOP, 3.0


def sent(solver, dt, gain):
    """Where and how fast the knee is when no step is left, or at the end of 3 s; the bounds of the next step."""
    change = AccelerationLimit(model, np.array([MOST]))
    limits = [change, VelocityLimit(model), ConfigurationLimit(model)]
    here, goal = pink.Configuration(model, model.createData(), np.array([-0.5])), PostureTask(cost=1.0, gain=gain)
    goal.set_target(np.array([0.8]))
    speed = np.zeros(1)
    for _ in range(round(3.0 / dt)):
        change.set_last_integration(speed, dt)
        try:
            new = pink.solve_ik(here, [goal], dt, solver=solver, limits=limits)
        except NoSolutionFound:
            (most, least), arrived = change.compute_qp_inequalities(here, dt)[1] * (1, -1), False
            return here.q[0], speed[0], most, least, arrived
        speed = new
        here.integrate_inplace(speed, dt)
    return here.q[0], speed[0], 0.0, 0.0, True


for solver in ("daqp", "highs", "clarabel"):
    for dt in (0.01, 0.002):
        q, speed, most, least, arrived = sent(solver, dt, 1.0)
        by_hand = dt * np.sqrt(2 * MOST * (STOP - q)), dt * (speed - MOST * dt)
        print(f"## {solver}, steps of {dt} s: stuck at {q:.3f} rad and {speed:.2f} rad/s; a step at most {most:.6f}, at least {least:.6f} rad")
        assert not arrived and most < least and np.allclose([most, least], by_hand, rtol=1e-9)
        if (solver, dt) != ("daqp", 0.002):
            assert q < 0.6 and speed > 2.9  # well before the target, at full speed
q, _, _, _, arrived = sent("daqp", 0.01, 0.05)
print(f"## with gain 0.05: {q:.3f} rad")
assert arrived and abs(q - 0.8) < 1e-6
PY
