#!/usr/bin/env bash
# Version:  dartpy 6.20.0
# Does:     getPositionDifferences (of a Skeleton or a joint) gives the rates that lead from one position to another; for a
#           FreeJoint it takes the joint's own poses in its parent and in its body as unit poses, whatever they are,
#           while integratePositions, velocities and Jacobians count them. Where the joint is turned the rates come out about
#           other axes, where it is away from the body's origin the linear ones are off. Ball joints, and free joints at
#           the origin, are right. (Its pull request 2298 taught the others; this function is not in it.)
# Guess:    the difference of two positions, over the time between them, is the rate that led from the one to the other: it
#           was made for the velocities of recorded motions (its pull request 389).
# Means:    a trunk whose axes were turned to stand upright, or whose free joint is in its centre of mass, has other velocities
#           from its recording than those of its motion: inverse dynamics asks for another wrench, and a servo on
#           this difference turns it about the wrong axis. Difference the world transform instead.
# Seen:     rates (0.5, 2, -0.4) rad/s and (1, 0.2, -0.1) m/s, integrated by 1e-5 s and differenced: the same with the joint at
#           the origin; 0.2 m off: (0.98, 0.22, -0.04) m/s; turned by a quarter about x: (0.5, -0.4, -2) rad/s and
#           (1, -0.1, -0.2) m/s; ball joint the same with either
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check dartpy==6.20.0 numpy==2.4.6 2>/dev/null
cd "$work"
"$work/env/bin/python" - <<'PY'
import dartpy as dart
import numpy as np

FIRST = np.array([0.1, -0.2, 0.3, 0.4, 0.1, 0.9])
RATES = np.array([0.5, 2.0, -0.4, 1.0, 0.2, -0.1])  # turning [rad/s], then moving [m/s]
STEP = 1e-5


def recovered(kind, turned, above):
    """The rates by the difference of two positions that the rates themselves lead to."""
    properties = getattr(dart.dynamics, f"{kind}JointProperties")()
    seat, lift = dart.math.Isometry3(), dart.math.Isometry3()
    seat.set_rotation(dart.math.expMapRot(np.array([turned, 0.0, 0.0])))
    lift.set_translation(np.array([0.0, 0.0, above]))
    properties.mT_ParentBodyToJoint, properties.mT_ChildBodyToJoint = seat, lift
    robot = dart.dynamics.Skeleton()
    create = getattr(robot, f"create{kind}JointAndBodyNodePair")
    joint, body = create(None, properties, dart.dynamics.BodyNodeProperties(dart.dynamics.BodyNodeAspectProperties("trunk")))
    first, rates = FIRST[: robot.getNumDofs()], RATES[: robot.getNumDofs()]
    robot.setPositions(first)
    robot.setVelocities(rates)
    told, before = body.getLinearVelocity(), body.getWorldTransform().translation().copy()
    robot.integratePositions(STEP)
    # DART's own velocity of the body is that of its motion, so rates, Jacobian and integration agree.
    assert np.allclose((body.getWorldTransform().translation() - before) / STEP, told, atol=1e-4)
    second = robot.getPositions().copy()
    assert np.array_equal(robot.getPositionDifferences(second, first), joint.getPositionDifferences(second, first))
    return robot.getPositionDifferences(second, first) / STEP, rates


for kind, turned, above in (("Free", 0.0, 0.0), ("Free", 0.0, 0.2), ("Free", np.pi / 2, 0.0), ("Ball", 0.0, 0.2), ("Ball", np.pi / 2, 0.0)):
    found, rates = recovered(kind, turned, above)
    off = abs(found - rates).max()
    print(f"{kind}Joint turned by {turned:.2f} rad, {above} m off: rates {found.round(3)} for {rates}")
    assert off < 1e-3 if kind == "Ball" or not (turned or above) else off > 0.05
PY
