#!/usr/bin/env bash
# Version:  drake 1.51.1
# Does:     Toppra.AddJointTorqueLimit ("constrains the generalized torques applied to the plant") counts inertia, rotors,
#           Coriolis and gravity, and leaves out the damping of the joints, which the plant has from the file
#           and which its own inverse dynamics and simulation count. Nothing warns. The effort bounds of
#           KinematicTrajectoryOptimization, of the same plant, count it.
# Guess:    the torque of a trajectory is what the motors of this plant must give to follow it.
# Means:    a swing leg timed by it asks for more than the motor has, most where it is fastest, and falls
#           behind. Damping is a tenth of the torque of a knee with a good gear and most of that of a worm.
#           Take c times the largest rate off the limit, or check the result by CalcInverseDynamics.
# Seen:     shin of 3 kg, damping 5 N·m·s/rad, limit 12 N·m: torque up to 19.8 N·m, up to 12.0 without the damping;
#           with the damping set to 0 both 12.0. KinematicTrajectoryOptimization: torque of inverse dynamics, to 1e-9
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check drake==1.51.1 numpy==2.4.6
"$work/env/bin/python" - <<'PY'
import numpy as np
from pydrake.multibody.optimization import Toppra
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.planning import KinematicTrajectoryOptimization
from pydrake.trajectories import BsplineTrajectory, PathParameterizedTrajectory, PiecewisePolynomial

MASS, LENGTH, INERTIA, LIMIT = 3.0, 0.2, 0.1, 12.0
LEG = """<robot name="leg"><link name="thigh"/><link name="shin"><inertial><origin xyz="0 0 -{length}"/><mass value="{mass}"/>
<inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="knee" type="revolute"><parent link="thigh"/><child link="shin"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="100" velocity="9"/><dynamics damping="{damping}"/></joint>
<transmission type="SimpleTransmission"><type>SimpleTransmission</type><joint name="knee"/><actuator name="motor"/></transmission></robot>"""


def leg(damping):
    plant = MultibodyPlant(0.0)
    text = LEG.format(mass=MASS, length=LENGTH, inertia=INERTIA, damping=damping)
    Parser(plant).AddModelsFromString(text, "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("thigh"))
    plant.Finalize()
    return plant


def torque(angle, rate, acceleration, damping):
    """By hand: a pendulum."""
    weight = MASS * 9.81 * LENGTH * np.sin(angle)
    return (INERTIA + MASS * LENGTH**2) * acceleration + weight + damping * rate


path = PiecewisePolynomial.CubicShapePreserving([0.0, 0.5, 1.0], np.array([[0.0, 0.5, 1.0]]), True)
for damping in (5.0, 0.0):
    plant = leg(damping)
    timing = Toppra(path, plant, np.linspace(0.0, 1.0, 201))
    timing.AddJointTorqueLimit([-LIMIT], [LIMIT])
    timing.AddJointVelocityLimit([-1.6], [1.6])
    motion = PathParameterizedTrajectory(path, timing.SolvePathParameterization())
    states = [[motion.EvalDerivative(t, k).item() for k in range(3)]
              for t in np.linspace(0.02, motion.end_time() - 0.02, 400)]
    whole = max(abs(torque(*state, damping)) for state in states)
    without = max(abs(torque(*state, 0.0)) for state in states)
    print(f"Toppra, damping {damping}: torque up to {whole:.2f} N·m, without damping {without:.2f}, limit {LIMIT}")
    assert LIMIT * 0.98 < without < LIMIT * 1.02
    assert whole > 1.5 * LIMIT if damping else whole == without

# The other planner of the same library, at one instant, with the same plant.
search = KinematicTrajectoryOptimization(1, 8, 4, 1.0)
plant = leg(5.0)
(bound,) = search.AddEffortBoundsAtNormalizedTimes(plant, np.array([0.5]))
values = np.random.default_rng(0).normal(size=search.prog().num_vars())
values[search.prog().FindDecisionVariableIndex(search.duration())] = 1.0
points = values[search.prog().FindDecisionVariableIndices(search.control_points().ravel())]
curve = BsplineTrajectory(search.basis(), [np.array([[x]]) for x in points])
state = [curve.EvalDerivative(0.5, k).item() for k in range(3)]
own = bound.evaluator().Eval(values[search.prog().FindDecisionVariableIndices(bound.variables())]).item()
print(f"KinematicTrajectoryOptimization: {own:.4f} N·m, by hand {torque(*state, 5.0):.4f}, without damping "
      f"{torque(*state, 0.0):.4f}")
assert np.isclose(own, torque(*state, 5.0), atol=1e-9) and abs(own - torque(*state, 0.0)) > 1.0
PY
