#!/usr/bin/env bash
# Version:  brax 0.14.2 (generalized pipeline), mujoco 4.0.0 to compare (with mujoco-mjx 3.17.0)
# Does:     in State.xd, the velocities of the bodies, a body with two or three hinges has another angular velocity than
#           the one it moves with, and a body whose hinge is not in its origin has another linear one; what hangs
#           on them inherits both. Places, mass matrix, bias forces and accelerations are right.
#           (A remark in the source of kinematics.forward asks to fix it; the documentation calls xd the
#           motion in the world frame.)
# Guess:    xd is the rate of x.
# Means:    hips and waists of MuJoCo's humanoids are two or three hinges of a body: the speed of a foot and the turning
#           of trunk and legs are off in observations and rewards made of xd, by as much as themselves, while
#           the simulation itself is right. Difference x, or take MuJoCo's or MJX's velocities.
# Seen:     thigh of two hinges at (0.5, 0.6) rad and (1, 2) rad/s: angular velocity (2.03, 0.83, -0.46) for
#           (1.76, 1.00, -0.96) rad/s; the foot below it 0.09 m/s off; hinge 0.2 m above the origin of its body:
#           velocity 0 for 0.2 m/s. With one hinge in its origin all agree to 1e-6
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check brax==0.14.2 jax==0.10.2 mujoco==4.0.0 mujoco-mjx==3.17.0
JAX_PLATFORMS=cpu JAX_ENABLE_X64=1 "$work/env/bin/python" -W ignore - 2>/dev/null <<'PY'
import jax.numpy as jnp
import mujoco
import numpy as np
from brax.generalized import pipeline
from brax.io import mjcf

ROD = '<geom type="capsule" size=".05" fromto="0 0 0 0 0 -.4" mass="2"/>'
LEG = f"""<mujoco><worldbody><body name="thigh" pos="0 .1 1">{{}}{ROD}<body name="foot" pos=".1 0 -.4">
<joint axis="0 1 0"/>{ROD}</body></body></worldbody></mujoco>"""
HIPS = {
    "one hinge": '<joint axis="0 1 0"/>',
    "two hinges": '<joint axis="0 1 0"/><joint axis="1 0 0"/>',
    "hinge above": '<joint axis="0 1 0" pos="0 0 .2"/>',
}
angles, rates = np.array([0.5, 0.6, 0.3]), np.array([1.0, 2.0, 0.5])
off = {}
for name, hip in HIPS.items():
    text = LEG.format(hip)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    q, v = angles[: model.nq], rates[: model.nv]
    data.qpos[:], data.qvel[:] = q, v
    mujoco.mj_forward(model, data)
    system = mjcf.loads(text)
    state = pipeline.init(system, jnp.array(q), jnp.array(v))
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    assert np.allclose(state.x.pos, data.xpos[1:], atol=1e-6) and np.allclose(state.mass_mx, mass, atol=1e-6)
    # the rates of Brax's own places, differenced
    ahead, behind = (pipeline.init(system, jnp.array(q + s * v), jnp.array(v)).x.pos for s in (1e-6, -1e-6))
    differenced = np.asarray(ahead - behind) / 2e-6
    off[name] = []
    for body, label in ((1, "thigh"), (2, "foot")):
        true = np.zeros(6)
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, true, 0)
        assert np.allclose(true[3:], differenced[body - 1], atol=1e-5)
        linear, angular = np.asarray(state.xd.vel[body - 1]), np.asarray(state.xd.ang[body - 1])
        off[name] += [float(np.linalg.norm(linear - true[3:])), float(np.linalg.norm(angular - true[:3]))]
        print(f"{name}, {label}: velocity {linear.round(4)} for {true[3:].round(4)} m/s,"
              f" turning {angular.round(4)} for {true[:3].round(4)} rad/s")
assert max(off["one hinge"]) < 1e-5
assert off["two hinges"][0] < 1e-5 and 0.55 < off["two hinges"][1] < 0.65 and 0.08 < off["two hinges"][2] < 0.1
assert 0.19 < off["hinge above"][0] < 0.21
PY
