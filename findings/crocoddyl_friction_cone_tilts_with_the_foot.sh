#!/usr/bin/env bash
# Version:  crocoddyl 3.2.1 with pin 4.0.0 (with pin 4.1.0 it installs and computes garbage)
# Does:     the rotation of a FrictionCone is "the cone orientation w.r.t. the inertial frame". That holds for contacts
#           given in WORLD or LOCAL_WORLD_ALIGNED axes. For one in LOCAL axes the cone is multiplied with the force
#           in the axes of the foot, and so stands on the sole, not on the ground. Motion, torques and force are the same
#           for all three. Nothing is said.
# Guess:    whether a force is in the cone of the ground does not depend on the axes that a contact is written in.
# Means:    as a foot is pitched by more than atan(mu), one that carries the weight straight down "slides", and one
#           that slides keeps the cone: toe-off and heel strike come out with forces for another slope. Give
#           contacts in LOCAL_WORLD_ALIGNED axes where cones are used.
# Seen:     foot pitched by 0.6 rad, weight of 98.1 N straight down, mu 0.5: smallest margin 49.05 N in WORLD and
#           LOCAL_WORLD_ALIGNED axes, -14.91 N (a slide) in LOCAL ones: 98.1 (mu cos 0.6 - sin 0.6)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check crocoddyl==3.2.1 pin==4.0.0
"$work/env/bin/python" - <<'PY'
import crocoddyl
import numpy as np
import pinocchio as pin

MU, PITCH = 0.5, 0.6
robot = pin.Model()
free = robot.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root_joint")
robot.appendBodyToJoint(free, pin.Inertia(7.0, np.array([0.02, 0.0, 0.1]), 0.2 * np.eye(3)), pin.SE3.Identity())
leg = robot.addJoint(free, pin.JointModelRY(), pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.1])), "hip")
robot.appendBodyToJoint(leg, pin.Inertia(3.0, np.array([0.0, 0.0, -0.3]), 0.05 * np.eye(3)), pin.SE3.Identity())
foot = robot.addFrame(pin.Frame("foot", leg, pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.6])), pin.OP_FRAME))
q = pin.neutral(robot)
q[7] = PITCH
v = np.zeros(robot.nv)
weight = 10.0 * 9.81  # N
torque = pin.rnea(robot, robot.createData(), q, v, v)
state = crocoddyl.StateMultibody(robot)
actuation = crocoddyl.ActuationModelFloatingBase(state)
# the torque with which all is at rest: what the foot's wrench, known from the root's six rows, leaves for the hip
jacobian = pin.computeFrameJacobian(robot, robot.createData(), q, foot, pin.LOCAL_WORLD_ALIGNED)
wrench = np.linalg.solve(jacobian[:, :6].T, torque[:6])
hip = torque[6:] - jacobian[:, 6:].T @ wrench
assert np.allclose(wrench[:3], [0, 0, weight])
data = robot.createData()
pin.framesForwardKinematics(robot, data, q)
margins = {}
for axes in (pin.WORLD, pin.LOCAL_WORLD_ALIGNED, pin.LOCAL):
    contacts = crocoddyl.ContactModelMultiple(state, 1)
    contacts.addContact("foot", crocoddyl.ContactModel6D(state, foot, data.oMf[foot], axes, 1, np.zeros(2)))
    cone = crocoddyl.FrictionCone(np.eye(3), MU, 4, False)
    costs = crocoddyl.CostModelSum(state, 1)
    residual = crocoddyl.ResidualModelContactFrictionCone(state, foot, cone, 1)
    costs.addCost("cone", crocoddyl.CostModelResidual(state, residual), 1.0)
    model = crocoddyl.DifferentialActionModelContactFwdDynamics(state, actuation, contacts, costs, 0.0, True)
    record = model.createData()
    model.calc(record, np.concatenate([q, v]), hip)
    assert np.allclose(record.xout, 0.0, atol=1e-9)  # all at rest, whatever the axes
    value = record.costs.costs["cone"].residual.r
    margins[axes.name] = float(min(np.min((value - cone.lb)[np.isfinite(cone.lb)], initial=np.inf),
                                   np.min((cone.ub - value)[np.isfinite(cone.ub)], initial=np.inf)))
    print(f"{axes.name}: smallest margin {margins[axes.name]:.2f} N")
# by hand: mu times the normal force less the tangential one, on the ground and on the sole
on_ground, on_sole = MU * weight, weight * (MU * np.cos(PITCH) - np.sin(PITCH))
assert np.isclose(margins["WORLD"], on_ground) and np.isclose(margins["LOCAL_WORLD_ALIGNED"], on_ground)
assert np.isclose(margins["LOCAL"], on_sole) and on_sole < -10
PY
