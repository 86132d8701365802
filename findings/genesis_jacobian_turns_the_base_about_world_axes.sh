#!/usr/bin/env bash
# Version:  genesis-world 1.4.5 (torch 2.14.1, on the CPU in double precision), mujoco 4.0.0 to compare
# Does:     get_jacobian of a robot with a free base has the turning of the base about the axes of the world in columns 3 to 5;
#           the velocities of get_dofs_velocity, set_dofs_velocity and the mass matrix have it about the axes of the base. So the
#           Jacobian times the velocity is not the velocity of the link as soon as the base has turned. The
#           columns of a ball joint are zero altogether. With a held base and hinges all is right.
#           ("Get the spatial Jacobian for a point on a target link"; a remark in the source of the inverse kinematics
#           knows of the ball joint.)
# Guess:    J v is what get_vel and get_ang of the link say, and J' f the effect of a force on the same coordinates.
# Means:    operational-space control, foot Jacobians in a whole-body program and contact forces mapped to the trunk are wrong by
#           the attitude of the trunk: none upright and facing x, all after a turn. Multiply columns 3 to 5 by the
#           rotation matrix of the base.
# Seen:     velocity of the shin (0.80, -1.23, 0.30) m/s and (-0.52, -0.42, 0.08) rad/s, of the product (0.51, -1.06, 0.59) and
#           (-0.25, 0.42, -0.15); below a ball hip the product lacks the three columns of the hip; held base and hinges agree
#           to 1e-6
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check genesis-world==1.4.5 torch==2.14.1 mujoco==4.0.0
cd "$work"
"$work/env/bin/python" -W ignore - 2>/dev/null <<'PY'
from pathlib import Path

import genesis as gs
import mujoco
import numpy as np

ROD = '<geom type="capsule" size=".05" fromto="0 0 0 0 0 -.4" mass="2"/>'
LEG = f"""<body name="thigh" pos=".02 .1 -.1"><joint type="{{}}" axis="0 1 0" armature=".01"/>{ROD}
<body name="shin" pos=".01 .02 -.4"><joint axis="0 1 0" armature=".01"/>{ROD}</body></body>"""
BASE = '<mujoco><worldbody><body name="base" pos="0 0 1">{}<geom type="box" size=".1 .1 .1" mass="5"/>{}</body></worldbody></mujoco>'
ROBOTS = {
    "held base": BASE.format("", LEG.format("hinge")),
    "free base": BASE.format("<freejoint/>", LEG.format("hinge")),
    "ball hip": BASE.format("", LEG.format("ball")),
}
gs.init(backend=gs.cpu, precision="64", logging_level="error")
rng = np.random.default_rng(0)
off = {}
for name, text in ROBOTS.items():
    file = Path(name.replace(" ", "_") + ".xml")
    file.write_text(text)
    scene = gs.Scene(show_viewer=False, sim_options=gs.options.SimOptions(dt=1e-3))
    robot = scene.add_entity(gs.morphs.MJCF(file=str(file), default_armature=None))
    scene.build()
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_integratePos(model, data.qpos, rng.uniform(-1, 1, model.nv), 1.0)
    data.qvel[:] = rng.uniform(-1, 1, model.nv)
    mujoco.mj_forward(model, data)
    robot.set_qpos(data.qpos.copy())
    robot.set_dofs_velocity(data.qvel.copy())
    shin = robot.get_link("shin")
    body = model.body("shin").id
    true = np.zeros(6)
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, true, 0)
    own = np.r_[shin.get_vel().numpy(), shin.get_ang().numpy()]
    assert np.allclose(own, np.r_[true[3:], true[:3]], atol=1e-6)  # the velocities themselves are right
    jacobian, theirs = robot.get_jacobian(shin).numpy(), np.zeros((6, model.nv))
    mujoco.mj_jac(model, data, theirs[:3], theirs[3:], data.xpos[body], body)
    assert np.allclose(theirs @ data.qvel, own, atol=1e-6)
    product = jacobian @ robot.get_dofs_velocity().numpy()
    columns = [k for k in range(model.nv) if not np.allclose(jacobian[:, k], theirs[:, k], atol=1e-6)]
    zero = [k for k in range(model.nv) if not jacobian[:, k].any()]
    off[name] = columns, zero, np.linalg.norm(product - own)
    print(f"{name}: shin moves with {own.round(3)}, Jacobian times velocity {product.round(3)}; wrong columns {columns}, zero {zero}")
assert off["held base"][0] == [] and off["held base"][2] < 1e-6
assert off["free base"][0] == [3, 4, 5] and off["free base"][1] == [] and off["free base"][2] > 0.1
assert off["ball hip"][0] == off["ball hip"][1] == [0, 1, 2] and off["ball hip"][2] > 0.1
PY
