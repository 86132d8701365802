#!/usr/bin/env bash
# Version:  ruckig 0.19.4
# Does:     Trajectory.position_extrema gives the place and time where the position turns only if that happens while the
#           jerk is not zero. Where a joint turns back under constant acceleration, the usual case, the value is that
#           at the end of a phase before or after: 0.0867 rad at 0.200 s for 0.1092 rad at 0.350 s. The trajectory
#           itself is right, keeps its limits and reaches its target. (Known: issue 215 of Ruckig, open.)
# Guess:    the extrema are the largest and smallest position on the way ("position extrema and their times").
# Means:    a check of the joint range (or of a clearance) by these numbers lets through a motion that goes a quarter
#           of its overshoot further, up to 0.09 rad here. Sample the trajectory at the zeros of its velocity.
# Seen:     from 0 rad at +0.5 rad/s to -1 rad (1 rad/s, 2 rad/s², 10 rad/s³): 0.0867 for 0.1092; from 0 at rest through
#           -0.5 rad at +0.8 rad/s: -0.6467 for -0.7367; of 1000 random motions 387 go beyond by more than 1e-6
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check ruckig==0.19.4 numpy==2.4.6
"$work/env/bin/python" - <<'PY'
import numpy as np
from ruckig import InputParameter, Ruckig, RuckigError, Trajectory


def plan(now, target, limits):
    task, result = InputParameter(1), Trajectory(1)
    task.current_position, task.current_velocity, task.current_acceleration = ([x] for x in now)
    task.target_position, task.target_velocity, task.target_acceleration = ([x] for x in target)
    task.max_velocity, task.max_acceleration, task.max_jerk = ([x] for x in limits)
    Ruckig(1).calculate(task, result)
    return result


def reached(motion):
    places = [motion.at_time(float(t))[0][0] for t in np.linspace(0.0, motion.duration, 4001)]
    return min(places), max(places)


LIMITS = 1.0, 2.0, 10.0  # rad/s, rad/s², rad/s³
back = plan((0.0, 0.5, 0.0), (-1.0, 0.0, 0.0), LIMITS)
swing = plan((0.0, 0.0, 0.0), (-0.5, 0.8, 0.0), LIMITS)
# by hand: 0.2 s of jerk -10 to -2 rad/s², then 0.15 s of -2 rad/s² from 0.3 rad/s to a stand
ramp = 0.5 * 0.2 - 10.0 * 0.2**3 / 6.0
by_hand = ramp + 0.3**2 / (2.0 * 2.0)
told, true = back.position_extrema[0], reached(back)
print(f"back: told {told.max:.4f} rad at {told.t_max:.3f} s, reached {true[1]:.4f} rad, by hand {by_hand:.4f} rad")
assert np.isclose(true[1], by_hand, atol=1e-6) and abs(back.at_time(0.35)[1][0]) < 1e-9
assert np.isclose(told.max, ramp, atol=1e-9) and np.isclose(told.t_max, 0.2, atol=1e-9)
told, true = swing.position_extrema[0], reached(swing)
print(f"swing: told {told.min:.4f} rad, reached {true[0]:.4f} rad")
assert np.isclose(true[0], -0.7367, atol=1e-4) and np.isclose(told.min, -0.6467, atol=1e-4)

random, beyond, made = np.random.default_rng(0), 0, 0
while made < 1000:
    limits = random.uniform((0.5, 1.0, 5.0), (3.0, 10.0, 100.0))
    now, target = random.normal(size=(2, 3)) * (1.0, 0.3 * limits[0], 0.0)
    try:
        motion = plan(now, target, limits)
    except RuckigError:
        continue
    made += 1
    told, true = motion.position_extrema[0], reached(motion)
    beyond += true[0] < told.min - 1e-6 or true[1] > told.max + 1e-6
print(f"{beyond} of {made} random motions go beyond what they tell by more than 1e-6 rad")
assert 350 < beyond < 420
PY
