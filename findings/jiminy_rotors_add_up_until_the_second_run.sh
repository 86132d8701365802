#!/usr/bin/env bash
# Version:  jiminy-py 1.8.13 with numpy 2.2.6
# Does:     each time the options of a motor are set (motor.set_options, and so robot.set_options and the reading of a hardware file),
#           its armature is added once more to the inertia of the joint: it stands there twice after the first time, three times
#           after the second, and so on, also where nothing was changed. The first run is simulated with it. As a
#           run begins or ends anew the sum is taken anew, and the second run, of the same robot, is right. What
#           get_options returns is right throughout. (Pull request 355, merged, is about its being set at all.)
# Guess:    to set an option to the value that it has changes nothing; two runs from one state are one motion.
# Means:    rotors behind gears are most of the inertia of an ankle: the first episode, and each single run of a study, walks on
#           motors of two to many times their inertia, later episodes on the right ones. Start and stop once before
#           the run that counts, or look at pinocchio_model.rotorInertia.
# Seen:     shin of 0.11 kg·m² with a motor of 0.2 kg·m², 1 N·m: 3.23 rad/s² by hand; options set once 1.96, twice 1.41, five times
#           0.76 in the first run (inertia of the rotor 0.4, 0.6, 1.2); in the second run 3.23 each time; without armature
#           9.09, by hand too
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check jiminy-py==1.8.13 numpy==2.2.6 2>/dev/null
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import jiminy_py.core as jiminy
import numpy as np

MASS, LEVER, MOMENT, ROTOR, TORQUE = 2.0, 0.2, 0.03, 0.2, 1.0
Path("leg.urdf").write_text(f"""<robot name="leg"><link name="trunk"/><link name="shin"><inertial><origin xyz="0 0 -{LEVER}"/>
<mass value="{MASS}"/><inertia ixx="{MOMENT}" ixy="0" ixz="0" iyy="{MOMENT}" iyz="0" izz="0.01"/></inertial></link>
<joint name="knee" type="revolute"><parent link="trunk"/><child link="shin"/><axis xyz="0 1 0"/>
<limit lower="-90" upper="90" effort="100" velocity="500"/></joint></robot>""")


class Push(jiminy.BaseController):
    def compute_command(self, t, q, v, command):
        command[:] = TORQUE


def run_twice(times):
    """Acceleration of the knee in two runs, after the options were set so many times [rad/s^2]."""
    robot = jiminy.Robot("leg")
    robot.initialize(str(Path("leg.urdf").resolve()), has_freeflyer=False)
    motor = jiminy.SimpleMotor("knee")
    robot.attach_motor(motor)
    motor.initialize("knee")
    wanted = {**motor.get_options(), "enableArmature": True, "armature": ROTOR}
    assert wanted.keys() == motor.get_options().keys()
    for _ in range(times):
        motor.set_options(wanted)
        assert motor.get_options()["armature"] == ROTOR
    controller = Push()
    controller.initialize(robot)
    robot.controller = controller
    engine = jiminy.Engine()
    engine.add_robot(robot)
    options = engine.get_options()
    options["world"]["gravity"][:] = 0.0
    engine.set_options(options)
    found = []
    for _ in range(2):
        engine.start(np.zeros(1), np.zeros(1))
        for _ in range(10):
            engine.step(1e-3)
        (state,) = engine.robot_states
        assert np.isclose(state.v[0] / 0.01, state.a[0])  # the speed reached is that of the acceleration
        found.append(float(state.a[0]))
        engine.stop()
    return found


limb = MOMENT + MASS * LEVER**2
assert np.allclose(run_twice(0), TORQUE / limb)
for times in (1, 2, 5):
    first, second = run_twice(times)
    print(f"options set {times} times: {first:.4f} rad/s² in the first run, {second:.4f} in the second ({TORQUE / (limb + ROTOR):.4f})")
    assert np.isclose(second, TORQUE / (limb + ROTOR))
    assert np.isclose(first, TORQUE / (limb + (times + 1) * ROTOR))
PY
