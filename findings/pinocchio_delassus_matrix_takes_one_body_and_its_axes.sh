#!/usr/bin/env bash
# Version:  pin 4.1.0 (Pinocchio)
# Does:     computeDelassusMatrix is J M^-1 J' for a contact with the world in LOCAL axes. In LOCAL_WORLD_ALIGNED axes it is
#           the LOCAL one all the same. For a tie between two bodies the second is left out. From Python
#           computeDampedDelassusMatrixInverse is 1/mu times the unit matrix whatever the robot, the posture and the contact.
#           constraintDynamics has all of it right for the same constraints. (In C++ both are marked as an interface
#           that will change, and the inverse wants an initialisation that Python has not; Python says nothing.
#           No report was found.)
# Guess:    "the Delassus matrix associated to a set of given constraints", with their axes and both of their bodies, and
#           its inverse, damped by mu.
# Means:    contact forces, effective masses at a foot and friction cones solved with it are those of a tilted ground, or
#           of a limb that is not tied to the other. The eigenvalues do not show the turned axes. Form J M^-1 J'.
# Seen:     sample humanoid, right foot in a bent posture: off by 4e-15 in LOCAL axes, by 45 % (3 rows) and 62 % (6 rows) of
#           the largest entry in LOCAL_WORLD_ALIGNED with the same eigenvalues, by 53 and 50 % tied to the left foot;
#           inverse with mu = 0.01 exactly 100 times the unit matrix, where the largest entry should be 1.3 to 4.6
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import numpy as np
import pinocchio as pin

robot = pin.buildSampleModelHumanoid()
rng = np.random.default_rng(1)
q = pin.integrate(robot, pin.neutral(robot), 0.5 * rng.normal(size=robot.nv))
right, left = robot.getJointId("rleg_wrist2_joint"), robot.getJointId("lleg_wrist2_joint")
data, zero = robot.createData(), np.zeros(robot.nv)
pin.computeJointJacobians(robot, data, q)
upper = np.triu(pin.crba(robot, robot.createData(), q))
M = upper + np.triu(upper, 1).T
sole = pin.SE3(np.eye(3), np.array([0.1, 0.0, -0.1]))
there = data.oMi[right] * sole
for kind in (pin.ContactType.CONTACT_3D, pin.ContactType.CONTACT_6D):
    for axes, other in ((pin.LOCAL, 0), (pin.LOCAL_WORLD_ALIGNED, 0), (pin.LOCAL, left)):
        tie = pin.RigidConstraintModel(kind, robot, right, sole, other, data.oMi[other].actInv(there), axes)
        ties, runs = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
        ties.append(tie)
        runs.append(tie.createData())
        frame = there if axes == pin.LOCAL else pin.SE3(np.eye(3), there.translation)
        moves = [pin.getJointJacobian(robot, data, body, pin.WORLD) if body else 0 for body in (right, other)]
        J = (frame.toActionMatrixInverse() @ (moves[0] - moves[1]))[: 3 if kind == pin.ContactType.CONTACT_3D else 6]
        held = robot.createData()
        pin.initConstraintDynamics(robot, held, ties, runs)
        a = pin.constraintDynamics(robot, held, q, zero, zero, ties, runs, pin.ProximalSettings(1e-12, 1e-13, 1e-9, 100))
        weight = pin.computeGeneralizedGravity(robot, robot.createData(), q)
        assert abs(M @ a + weight - J.T @ held.lambda_c).max() < 1e-7  # J is that of the constraint
        true = J @ np.linalg.solve(M, J.T)
        said = pin.computeDelassusMatrix(robot, robot.createData(), q, ties, runs)
        inverse = pin.computeDampedDelassusMatrixInverse(robot, robot.createData(), q, ties, runs, 0.01)
        right_inverse = np.linalg.inv(true + 0.01 * np.eye(len(J)))
        off = abs(said - true).max() / abs(true).max()
        turned = np.allclose(np.linalg.eigvalsh(said), np.linalg.eigvalsh(true))
        print(f"{len(J)} rows {axes!s:19} to {robot.names[other]:17} off by {off:.2g}, eigenvalues {'same' if turned else 'other'};"
              f" inverse {inverse[0, 0]:.1f} to {inverse[-1, -1]:.1f}, largest should be {abs(right_inverse).max():.1f}")
        assert off < 1e-12 if (axes == pin.LOCAL and not other) else off > 0.3
        assert turned == (other == 0)
        assert np.allclose(inverse, 100.0 * np.eye(len(J)), atol=1e-12) and abs(right_inverse).max() < 20.0
PY
