#!/usr/bin/env bash
# Version:  mujoco 4.0.0
# Does:     the sensors force and torque count contacts, pushes (xfrc_applied), loop closures and tendons, and leave
#           out what a motor on a site pulls (transmission "site": a crane's rope, a thruster) and what gravcomp
#           takes of the weight. The motion counts both. A foot that is pulled up with twice its weight hangs on the
#           ankle for the sensor, and one that is weightless weighs what it did. The reference says that all forces
#           are taken into account.
# Guess:    the load of a joint follows from all that acts beyond it, whichever element of the file it comes from.
# Means:    loads of ankles, bearings and prosthetic sockets under body-weight support, and of a robot that is helped
#           by thrust, are those without help; a load cell of the robot disagrees by the whole help. Write the
#           help as xfrc_applied, or subtract it from the sensor.
# Seen:     foot of 1 kg on a hinge at rest, load of the ankle along z: as it is 9.81, pulled with 19.62 N: by
#           xfrc_applied and by a tendon -9.81, by a site motor 9.81 for -9.81; gravcomp 1: 9.81 for 0; torque of
#           a pull 0.1 m ahead: 0 for 1.962 (by xfrc_applied 1.962)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import mujoco
import numpy as np

PULL, WEIGHT = 19.62, 9.81
ROBOT = """<mujoco><option><flag contact="disable"/></option><worldbody><site name="hook" pos="0 0 1"/>
<body name="shank" pos="0 0 .5">
<geom type="capsule" size=".04" fromto="0 0 0 0 0 -.4" mass="3"/>
<body name="foot" pos="0 0 -.4"{compensation}>{joint}<site name="ankle"/><site name="toe" pos="{ahead} 0 0"/>
<geom type="box" size=".1 .05 .02" mass="1"/></body></body></worldbody>{more}
<sensor><force site="ankle"/><torque site="ankle"/></sensor></mujoco>"""
HINGE = '<joint name="ankle" axis="0 1 0"/>'
MOTOR = '<actuator><motor site="toe" gear="0 0 1 0 0 0"/></actuator>'
ROPE = '<tendon><spatial name="rope"><site site="hook"/><site site="toe"/></spatial></tendon>' \
       '<actuator><motor tendon="rope" gear="-1"/></actuator>'


def load(joint=HINGE, more="", compensation="", ahead=0.0, push=0.0):
    model = mujoco.MjModel.from_xml_string(
        ROBOT.format(joint=joint, more=more, compensation=compensation, ahead=ahead))
    data = mujoco.MjData(model)
    data.ctrl[:] = PULL
    data.xfrc_applied[2, 2] = push
    data.xfrc_applied[2, 4] = -ahead * push
    mujoco.mj_forward(model, data)
    assert np.allclose(data.qacc, 0.0, atol=1e-9)
    return data.sensordata.copy()


alone, pushed, rope = load()[2], load(push=PULL)[2], load(more=ROPE)[2]
motor, weightless = load(more=MOTOR)[2], load(compensation=' gravcomp="1"')[2]
print(f"load along z: alone {alone:.2f}, pushed {pushed:.2f}, by a rope {rope:.2f}, by a site motor {motor:.2f}"
      f" (weight less pull {WEIGHT - PULL:.2f}), gravcomp 1 {weightless:.2f} (0)")
assert np.isclose(alone, WEIGHT) and np.allclose([pushed, rope], WEIGHT - PULL)
assert np.isclose(motor, WEIGHT) and np.isclose(weightless, WEIGHT)

ahead_pushed, ahead_motor = load(joint="", ahead=0.1, push=PULL), load(joint="", ahead=0.1, more=MOTOR)
print(f"welded foot pulled 0.1 m ahead: torque {abs(ahead_pushed[4]):.3f} pushed, {abs(ahead_motor[4]):.3f} by a motor"
      f" (by hand {0.1 * PULL:.3f})")
assert np.isclose(abs(ahead_pushed[4]), 0.1 * PULL) and abs(ahead_motor[4]) < 1e-9

# the motion counts both: a foot without a shank rises with pull / mass - g, and floats with gravcomp
FREE = """<mujoco><worldbody><body name="foot"{}><freejoint/><site name="toe"/>
<geom type="box" size=".1 .05 .02" mass="1"/></body></worldbody>{}</mujoco>"""
for compensation, more, right in (("", MOTOR, PULL - WEIGHT), (' gravcomp="1"', "", 0.0)):
    model = mujoco.MjModel.from_xml_string(FREE.format(compensation, more))
    data = mujoco.MjData(model)
    data.ctrl[:] = PULL
    mujoco.mj_forward(model, data)
    assert np.isclose(data.qacc[2], right, atol=1e-9)
PY
