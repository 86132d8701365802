#!/usr/bin/env bash
# Version:  crocoddyl 3.2.1 with pin 4.0.0 (with pin 4.1.0 it installs and computes garbage)
# Does:     under DifferentialActionModelFreeFwdDynamics the cost on momentum (ResidualModelCentroidalMomentum) is not
#           computed by calc: its value is that of the state at which calcDiff ran last on the same data, and 0 before,
#           and calcDiff makes its gradient with that value, too. The Jacobian Rx is right. Under
#           ContactFwdDynamics all is right.
# Guess:    calc computes the value for the state that it is given, whether a foot stands or not.
# Means:    DDP rolls a trial out with calc and compares its cost with the last: the momentum term of all flight
#           instants stays what it was, so a step that lowers it brings nothing, one that raises it costs nothing, and
#           the cost that is printed is none of the trajectory's. Jumps and runs with such a cost end anywhere.
#           Call calcDiff and calc once more before reading the cost, or take momentum from a residual of your own.
# Seen:     moving: first calc 0 of 795.5, gradient 0 of 1521; after calcDiff 795.5; then at rest calc says 795.5 for 0;
#           with a foot on the ground 795.5, 1521, 795.5, 0
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check crocoddyl==3.2.1 pin==4.0.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import crocoddyl
import numpy as np
import pinocchio as pin

robot = pin.Model()
trunk = robot.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root_joint")
robot.appendBodyToJoint(trunk, pin.Inertia.FromBox(30.0, 0.3, 0.4, 0.5), pin.SE3.Identity())
leg = robot.addJoint(trunk, pin.JointModelRY(), pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.3])), "hip")
robot.appendBodyToJoint(leg, pin.Inertia.FromSphere(9.0, 0.1), pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.4])))
foot = robot.addFrame(pin.Frame("foot", leg, 0, pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.8])),
                                pin.FrameType.OP_FRAME))
state = crocoddyl.StateMultibody(robot)
motors = crocoddyl.ActuationModelFloatingBase(state)
moving = np.concatenate([pin.neutral(robot), [0.3, -0.2, 1.0, 0.4, 0.5, -0.1, 2.0]])
resting = state.zero()
torque = np.zeros(1)


def momentum(x):
    return pin.computeCentroidalMomentum(robot, robot.createData(), x[:robot.nq], x[robot.nq:]).vector


def by_hand(x):
    return 0.5 * momentum(x) @ momentum(x)


def seen(stands):
    costs = crocoddyl.CostModelSum(state, 1)
    residual = crocoddyl.ResidualModelCentroidalMomentum(state, np.zeros(6), 1)
    costs.addCost("momentum", crocoddyl.CostModelResidual(state, residual), 1.0)
    if stands:
        contacts = crocoddyl.ContactModelMultiple(state, 1)
        contacts.addContact("foot", crocoddyl.ContactModel3D(state, foot, np.zeros(3), pin.LOCAL, 1, np.zeros(2)))
        model = crocoddyl.DifferentialActionModelContactFwdDynamics(state, motors, contacts, costs, 0.0, True)
    else:
        model = crocoddyl.DifferentialActionModelFreeFwdDynamics(state, motors, costs)
    data = model.createData()
    model.calc(data, moving, torque)
    first = data.cost
    model.calcDiff(data, moving, torque)
    slope = np.array(data.Lx), np.array(data.costs.costs["momentum"].residual.Rx)
    model.calc(data, moving, torque)
    second = data.cost
    model.calc(data, resting, torque)
    return first, second, data.cost, slope


h = 1e-6
quotient = np.array([(momentum(state.integrate(moving, h * e)) - momentum(state.integrate(moving, -h * e))) / (2 * h)
                     for e in np.eye(state.ndx)]).T
right, gradient = by_hand(moving), quotient.T @ momentum(moving)
assert by_hand(resting) == 0.0 and right > 100.0
for name, stands in (("in flight", False), ("foot on the ground", True)):
    first, second, other, (slope, jacobian) = seen(stands)
    print(f"{name}: moving {first:.1f}, after calcDiff {second:.1f}, by hand {right:.1f}; at rest {other:.1f}, by hand"
          f" 0.0; first gradient {abs(slope).max():.1f}, by hand {abs(gradient).max():.1f}")
    assert np.isclose(second, right) and np.allclose(jacobian, quotient, rtol=1e-5, atol=1e-5)
    if stands:
        assert np.isclose(first, right) and abs(other) < 1e-12 and np.allclose(slope, gradient, rtol=1e-5, atol=1e-3)
    else:
        assert first == 0.0 and np.isclose(other, right) and not slope.any()
PY
