#!/usr/bin/env bash
# Version:  mink 1.3.0 with mujoco 4.0.0 (daqp solves)
# Does:     CollisionAvoidanceLimit bounds the displacement of a step, in metres, by gain (d - minimum) / dt, a speed: at steps of
#           0.02 s fifty times the room, at 0.002 s five hundred times. The limit binds only once the minimum distance
#           is broken already. All the other limits of mink are displacements and multiply by dt.
# Guess:    gain, "how fast the geoms are allowed to move towards each other at each iteration", takes at most 85 % of
#           the room that is left in one step; the minimum distance is kept.
# Means:    legs that swing past each other are not held off as they come near: what they overrun is the way of a step, and
#           a fast leg or a coarse step goes right into the other one. Choose gain = 0.85 dt to get what is told,
#           and a detection distance above the way of a step.
# Seen:     0.06 m of room, gain 0.85: bound 0.51, 2.55 and 10.2 m for 0.051 m at steps of 0.1, 0.02 and 0.005 s; shanks
#           closing at 2 m/s, 0.02 s, minimum 0.01 m: 0.010 m of overlap; with gain 0.85 dt 0.010 m of room
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mink==1.3.0 mujoco==4.0.0 daqp==0.11.0 qpsolvers==4.13.0 numpy==2.4.6
"$work/env/bin/python" - <<'PY'
import mink
import mujoco
import numpy as np

SHANK = '<geom name="{0}" type="capsule" size=".05 .2" mass="1"/>'
LEGS = f"""<mujoco><worldbody>
<body name="left"><joint name="left" type="slide" axis="1 0 0"/>{SHANK.format("left")}</body>
<body name="right" pos=".2 0 0"><joint name="right" type="slide" axis="1 0 0"/>{SHANK.format("right")}</body>
</worldbody></mujoco>"""
MINIMUM, GAIN = 0.01, 0.85
model = mujoco.MjModel.from_xml_string(LEGS)
speed = mink.VelocityLimit(model, {"left": 2.0, "right": 2.0})


def limit(gain):
    return mink.CollisionAvoidanceLimit(model, [(["left"], ["right"])], gain, MINIMUM, collision_detection_distance=0.1)


def nearest(dt, gain):
    """Least room while the left shank is sent 0.11 m, which would be 0.01 m into the right one, that would rather stay."""
    here = mink.Configuration(model, np.zeros(2))
    sent, stay = mink.PostureTask(model, cost=1.0), mink.DampingTask(model, np.array([0.0, 100.0]))
    sent.set_target(np.array([0.11, 0.0]))
    rooms = []
    for _ in range(100):
        here.integrate_inplace(mink.solve_ik(here, [sent, stay], dt, "daqp", limits=[limit(gain), speed]), dt)
        rooms.append(0.1 + here.q[1] - here.q[0])
    return min(rooms)


near = mink.Configuration(model, np.array([0.03, 0.0]))  # 0.07 m between the shanks
for dt in (0.1, 0.02, 0.005):
    told = limit(GAIN).compute_qp_inequalities(near, dt)
    assert np.allclose(told.G, [[1.0, -1.0]])  # the row takes the displacement of the step
    room = GAIN * (0.07 - MINIMUM)
    print(f"steps of {dt} s: at most {told.h[0]:.4g} m nearer for {room:.3f} m; {speed.compute_qp_inequalities(near, dt).h[0]:.3g} m by the speed")
    assert np.isclose(told.h[0], room / dt) and np.isclose(speed.compute_qp_inequalities(near, dt).h[0], 2.0 * dt)
loose, tight = nearest(0.02, GAIN), nearest(0.02, GAIN * 0.02)
print(f"nearest at 2 m/s and 0.02 s: {loose:+.3f} m, with the gain times the step {tight:+.3f} m")
assert loose < -0.0099 and abs(tight - MINIMUM) < 1e-6
PY
