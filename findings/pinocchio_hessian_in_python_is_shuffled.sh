#!/usr/bin/env bash
# Version:  pin 4.1.0 (Pinocchio)
# Does:     getFrameKinematicHessian and getJointKinematicHessian give Python an array of shape (6, nv, nv) whose numbers
#           are all there and stand in wrong places: memory written column by column is read row by row. No exchange
#           of indices mends it, only reshaping the flat numbers in the other order. In LOCAL axes, beyond a ball
#           joint that is not the first of the tree, numbers are wrong, too.
# Guess:    "the first order derivative of the kinematic Jacobian": entry (row, j, k) is d J[row, j] / d q_k, or with j
#           and k exchanged.
# Means:    the shape is right, the size of the numbers is right, and the curvature of every foot and hand is noise.
#           A gradient with it points anywhere. H.ravel().reshape(H.shape, order="F"), and not in LOCAL axes.
#           (Asked for in issue 2844 and new in version 4; of the order no thread was found.)
# Seen:     sample humanoid, last joint of the right leg, nv 34, either order of the two indices: off by the largest entry, 2.0
#           in LOCAL and 1.75 in WORLD axes, reshaped by 1e-9; trunk, ball hip and knee: off by 1.0 to 1.8, reshaped by 1e-9
#           in WORLD axes and by 1.0 in LOCAL
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import numpy as np
import pinocchio as pin

h = 1e-6
humanoid = pin.buildSampleModelHumanoid()
ball = pin.Model()
hip = ball.addJoint(ball.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root_joint"),
                    pin.JointModelSpherical(), pin.SE3.Identity(), "hip")
ball.addJoint(hip, pin.JointModelRY(), pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.4])), "knee")
for robot, last in ((humanoid, "rleg_wrist2_joint"), (ball, "knee")):
    rng = np.random.default_rng(1)
    q = pin.integrate(robot, pin.neutral(robot), 0.5 * rng.normal(size=robot.nv))
    foot = robot.getJointId(last)

    def jacobian(q, axes):
        data = robot.createData()
        pin.computeJointJacobians(robot, data, q)
        return pin.getJointJacobian(robot, data, foot, axes).copy()

    data = robot.createData()
    pin.computeJointJacobians(robot, data, q)
    pin.computeJointKinematicHessians(robot, data)
    for axes in (pin.LOCAL, pin.LOCAL_WORLD_ALIGNED, pin.WORLD):
        said = np.array(pin.getJointKinematicHessian(robot, data, foot, axes))
        true = np.stack([(jacobian(pin.integrate(robot, q, h * e), axes) - jacobian(pin.integrate(robot, q, -h * e), axes))
                         / (2 * h) for e in np.eye(robot.nv)], axis=2)
        mended = said.ravel().reshape(said.shape, order="F")
        off = [abs(said - true).max(), abs(said.transpose(0, 2, 1) - true).max(), abs(mended - true).max()]
        print(f"{last:17} {axes!s:19} {said.shape} largest {abs(true).max():.2f}, off by {off[0]:.2f}, exchanged {off[1]:.2f},"
              f" reshaped {off[2]:.1g}")
        assert said.shape == true.shape and min(off[:2]) > 0.5
        assert (off[2] > 0.5) if (robot is ball and axes == pin.LOCAL) else (off[2] < 1e-6)
PY
