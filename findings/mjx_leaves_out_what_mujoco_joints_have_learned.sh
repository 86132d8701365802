#!/usr/bin/env bash
# Version:  mujoco-mjx 3.17.0 with mujoco 3.17.0 (one release)
# Does:     put_model takes a model and leaves out, without a word, the polynomial part of stiffness and damping (of
#           joints and of tendons), damping and armature of an <actuator>, and its delay. Put on a single hinge, each
#           changes the acceleration by a third up to four times. The linear parts agree to 1e-6, and what else MJX
#           does not know (a dcmotor, say) is refused in words.
# Guess:    what put_model accepts it computes; what it cannot do it refuses, as it does elsewhere.
# Means:    a hardening ankle spring, a quadratic damper, rotors and friction that are written at the motor, and the
#           lag of its command are no part of the robot on which a policy is trained or a gait is tuned by
#           gradients, and are there again in MuJoCo. Compare qacc of both at one moving state before the rest.
# Seen:     acceleration in rad/s², MuJoCo and MJX: joint spring "30 20 10" -237.48 and -156.24 (that of "30"), joint
#           damper "3 2 1" -107.41 and -39.06, tendon spring "300 500 800" -300.92 and -123.75, tendon damper
#           "30 50 80" -4.91 and -3.76; motor 6.08 and 6.08, with damping 2 -19.96 and 6.08, with armature 0.3
#           1.69 and 6.08, with a delay of 4 ms 0 and 6.08
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==3.17.0 mujoco-mjx==3.17.0
cd "$work"
JAX_PLATFORMS=cpu "$work/env/bin/python" - 2> "$work/said" <<'PY' || { cat "$work/said" >&2; exit 1; }
import jax
import mujoco
import numpy as np

jax.config.update("jax_enable_x64", True)
from mujoco import mjx

ROBOT = """<mujoco><option gravity="0 0 0"><flag contact="disable"/></option><worldbody>
<site name="heel" pos=".3 0 .1"/><body><joint name="ankle" axis="0 1 0"{joint}/>
<geom type="capsule" size=".04" fromto="0 0 0 0 0 -.4" mass="2"/>
<site name="calf" pos="0 0 -.3"/></body></worldbody>{more}</mujoco>"""
TENDON = '<tendon><spatial{}><site site="heel"/><site site="calf"/></spatial></tendon>'
MOTOR = '<actuator><motor joint="ankle"{}/></actuator>'
ANGLE, RATE, COMMAND = 0.6, 1.5, 0.7


def accelerations(joint="", more=""):
    model = mujoco.MjModel.from_xml_string(ROBOT.format(joint=joint, more=more))
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0], data.ctrl[:] = ANGLE, RATE, COMMAND
    ported = jax.jit(mjx.forward)(mjx.put_model(model), mjx.put_data(model, data))
    mujoco.mj_forward(model, data)
    return float(data.qacc[0]), float(ported.qacc[0]), model


def inertia(model):
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    out = np.zeros(1)
    mujoco.mj_mulM(model, data, out, np.ones(1))
    return out[0]


bare = inertia(accelerations()[2])
# by hand: spring -(k0 + k1 |x| + k2 x²) x, damper alike, motor (command - damping rate) over inertia and armature
cases = [
    ("linear spring and damper", dict(joint=' stiffness="30" damping="3"'), (-30 * ANGLE - 3 * RATE) / bare, True),
    ("joint spring 30 20 10", dict(joint=' stiffness="30 20 10"'),
     -(30 + 20 * ANGLE + 10 * ANGLE**2) * ANGLE / bare, False),
    ("joint damper 3 2 1", dict(joint=' damping="3 2 1"'), -(3 + 2 * RATE + RATE**2) * RATE / bare, False),
    ("tendon spring 300 500 800", dict(more=TENDON.format(' stiffness="300 500 800" springlength=".1"')), None, False),
    ("tendon damper 30 50 80", dict(more=TENDON.format(' damping="30 50 80"')), None, False),
    ("motor", dict(more=MOTOR.format("")), COMMAND / bare, True),
    ("motor with damping 2", dict(more=MOTOR.format(' damping="2"')), (COMMAND - 2 * RATE) / bare, False),
    ("motor with armature 0.3", dict(more=MOTOR.format(' armature=".3"')), COMMAND / (bare + 0.3), False),
    ("motor with a delay", dict(more=MOTOR.format(' nsample="3" delay=".004"')), 0.0, False),
]
for name, robot, by_hand, same in cases:
    here, ported, _ = accelerations(**robot)
    print(f"{name}: MuJoCo {here:.4f}, MJX {ported:.4f}" + ("" if by_hand is None else f", by hand {by_hand:.4f}"))
    if by_hand is not None:
        assert np.isclose(here, by_hand, atol=1e-6), name
    assert np.isclose(here, ported, atol=1e-6) if same else abs(here - ported) > 0.5, name
PY
