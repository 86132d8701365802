#!/usr/bin/env bash
# Version:  pin-pink 4.4.0 with pin 4.1.0 and coal 3.0.3 (daqp solves)
# Does:     the Jacobian of SelfCollisionBarrier is the slope of the distance while two shapes are apart, and minus the slope
#           once they overlap: it points from one nearest point to the other, and these change sides where the
#           distance turns negative. The barrier's condition then asks for a speed deeper into the overlap, with
#           nothing else to pull there, and the faster the deeper.
# Guess:    a barrier that is violated drives back out (its value is negative there, which is its very use); or it is
#           left out, as the code does where the points fall together.
# Means:    one step of overlap, from a start with crossed legs, coarse shapes or a measured posture, and the inverse
#           kinematics presses the legs into each other until another limit holds them. Look at the distances before
#           the call and turn the row, or take a barrier between spheres (BodySphericalBarrier).
# Seen:     two shanks on rails, spheres, capsules and boxes alike: 0.08 m apart: row (-1, 1) as by differences; 0.01 m of
#           overlap: (1, -1) for (-1, 1), asked to rest, each shank goes 0.3 m/s inwards; 0.05 m: 0.7 m/s; in 0.08 s
#           of such steps 0.01 m of overlap become 0.12 m
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin-pink==4.4.0 pin==4.1.0 coal==3.0.3 daqp==0.11.0 qpsolvers==4.13.0 numpy==2.4.6
"$work/env/bin/python" - <<'PY'
import coal
import numpy as np
import pink
import pinocchio as pin
from pink.barriers import SelfCollisionBarrier
from pink.tasks import PostureTask

STEP = 0.005
SHAPES = {"spheres": coal.Sphere(0.1), "capsules": coal.Capsule(0.1, 0.4), "boxes": coal.Box(0.2, 0.2, 0.4)}
model = pin.Model()
for name in ("left", "right"):
    rail = model.addJoint(0, pin.JointModelPX(), pin.SE3.Identity(), name)
    model.appendBodyToJoint(rail, pin.Inertia(1.0, np.zeros(3), 0.01 * np.eye(3)), pin.SE3.Identity())
model.lowerPositionLimit[:], model.upperPositionLimit[:], model.velocityLimit[:] = -10.0, 10.0, 5.0


def at(shape, apart):
    """The two shapes, 0.2 m wide, with so much room between them, or where they are told to be."""
    shapes = pin.GeometryModel()
    for rail in (1, 2):
        shapes.addGeometryObject(pin.GeometryObject(f"shape {rail}", rail, pin.SE3.Identity(), shape))
    shapes.addCollisionPair(pin.CollisionPair(0, 1))
    q = np.array([0.0, 0.2 + apart]) if np.ndim(apart) == 0 else apart
    return pink.Configuration(
        model, model.createData(), q, collision_model=shapes, collision_data=pin.GeometryData(shapes)
    )


def asked_to_rest(here, barrier):
    rest = PostureTask(cost=1e-3)
    rest.set_target(here.q)
    return pink.solve_ik(here, [rest], STEP, solver="daqp", barriers=[barrier])


for name, shape in SHAPES.items():
    barrier = SelfCollisionBarrier(1, gain=20.0, d_min=0.02)
    for apart, sign in ((0.08, 1.0), (-0.01, -1.0), (-0.05, -1.0)):
        here = at(shape, apart)
        value, row = barrier.compute_barrier(here)[0], barrier.compute_jacobian(here)[0]
        assert np.isclose(value, apart - 0.02)
        values = [[barrier.compute_barrier(at(shape, here.q + s * h))[0] for s in (1, -1)] for h in 1e-6 * np.eye(2)]
        slope = -np.diff(values)[:, 0] / 2e-6
        speed = asked_to_rest(here, barrier)
        print(f"{name} {apart:+.2f} m apart: row {row}, slope {np.round(slope, 6)}, speeds {np.round(speed, 4) + 0.0}")
        assert np.allclose(slope, [-1.0, 1.0], atol=1e-6) and np.allclose(row, sign * np.array([-1.0, 1.0]), atol=1e-6)
        inwards = 0.0 if apart > 0 else 10.0 * (0.02 - apart)
        assert np.allclose(speed, [inwards, -inwards], atol=1e-4)
    here = at(shape, -0.01)
    for _ in range(16):
        here = at(shape, here.q + STEP * asked_to_rest(here, barrier))
    overlap = 0.2 - (here.q[1] - here.q[0])
    print(f"   {16 * STEP} s later they overlap by {overlap:.3f} m")
    assert overlap > 0.1
PY
