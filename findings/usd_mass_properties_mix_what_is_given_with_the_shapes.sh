#!/usr/bin/env bash
# Version:  usd-core 26.11
# Does:     UsdPhysics.RigidBodyAPI.ComputeMassProperties, by which readers of USD weigh a body, fills what MassAPI leaves out
#           from the collision shapes, piece by piece. With a centre of mass and no inertia, mass times the squared distance
#           of that centre from the shapes' own is added to the moments. With moments, and neither centre nor
#           principal axes, the moments are turned into the principal axes of the shapes.
# Guess:    moving the centre of mass changes moments about it by little, and downwards where mass is drawn to an end; three
#           moments without a rotation stand along the axes of the body, as the empty rotation does in a link.
# Means:    a trunk whose centre of mass was measured turns as no body in its hull can, and a shank with a
#           tilted capsule has its moments tilted, products of inertia and all. Author mass, centre, moments and
#           principalAxes together, (1, 0, 0, 0) too.
# Seen:     box of 5 kg, 0.1 x 0.1 x 0.4 m, centre given 0.15 m above its middle: 0.1833 kg·m² about x, its own 0.0708, at most
#           0.1000 for any such body within the box; moments (0.06, 0.05, 0.01) with the box tilted by 30 degrees
#           about y: product xz 0.0217, with (1, 0, 0, 0) given 0
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check usd-core==26.11 numpy==2.4.6
"$work/env/bin/python" - <<'PY'
import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics

MASS, WIDTH, DEPTH, HEIGHT = 5.0, 0.1, 0.1, 0.4
OWN = MASS / 12 * np.array([DEPTH**2 + HEIGHT**2, WIDTH**2 + HEIGHT**2, WIDTH**2 + DEPTH**2])


def of_box(prim):
    """What a reader says of a shape: volume and moments at density 1, and where it is in the body."""
    said = UsdPhysics.RigidBodyAPI.MassInformation()
    said.volume = WIDTH * DEPTH * HEIGHT
    said.inertia = Gf.Matrix3f(*np.diag(OWN / MASS * said.volume).ravel().tolist())
    said.centerOfMass = Gf.Vec3f(0.0)
    place = Gf.Transform(UsdGeom.Xformable(prim).GetLocalTransformation())
    said.localPos = Gf.Vec3f(place.GetTranslation())
    said.localRot = Gf.Quatf(place.GetRotation().GetQuat())
    return said


def weigh(tilt=0.0, centre=None, moments=None, axes=None):
    """Mass, centre of mass and the tensor about it, in axes of the body."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    prim = UsdGeom.Xform.Define(stage, "/trunk").GetPrim()
    body, given = UsdPhysics.RigidBodyAPI.Apply(prim), UsdPhysics.MassAPI.Apply(prim)
    shape = UsdGeom.Cube.Define(stage, "/trunk/hull")
    UsdPhysics.CollisionAPI.Apply(shape.GetPrim())
    shape.AddTranslateOp().Set(Gf.Vec3d(0.0, 0.0, 0.2))
    shape.AddRotateYOp().Set(tilt)
    given.GetMassAttr().Set(MASS)
    for attribute, value in ((given.GetCenterOfMassAttr(), centre), (given.GetDiagonalInertiaAttr(), moments)):
        if value is not None:
            attribute.Set(Gf.Vec3f(*value))
    if axes is not None:
        given.GetPrincipalAxesAttr().Set(Gf.Quatf(*axes))
    mass, diagonal, at, turn = body.ComputeMassProperties(of_box)
    columns = np.array([Gf.Rotation(Gf.Quatd(turn)).TransformDir(Gf.Vec3d(*row)) for row in np.eye(3)]).T
    return mass, np.array(at), columns @ np.diag(list(diagonal)) @ columns.T


for above in (0.0, 0.05, 0.10, 0.15):
    mass, at, tensor = weigh(centre=(0.0, 0.0, 0.2 + above))
    # Of all bodies in the box with that centre the hardest to turn about x has its mass in two opposite faces.
    most = MASS * ((HEIGHT / 2 - above) * (HEIGHT / 2 + above) + (DEPTH / 2) ** 2)
    print(f"centre of mass {above} m above the middle: {tensor[0, 0]:.4f} kg·m² about x, possible {most:.4f}")
    assert np.isclose(mass, MASS) and np.allclose(at, [0.0, 0.0, 0.2 + above], atol=1e-6)
    assert np.allclose(tensor, np.diag(OWN + MASS * above**2 * np.array([1, 1, 0])), atol=1e-6)
    assert (tensor[0, 0] > 1.5 * most) == (above == 0.15)

MOMENTS = (0.06, 0.05, 0.01)
for axes in (None, (1.0, 0.0, 0.0, 0.0)):
    _, _, tensor = weigh(tilt=30.0, moments=MOMENTS, axes=axes)
    print(f"moments {MOMENTS}, hull tilted by 30 degrees, principalAxes {axes}: product xz {tensor[0, 2]:.4f}")
    if axes is None:
        assert np.isclose(abs(tensor[0, 2]), 0.05 * np.sin(np.pi / 6) * np.cos(np.pi / 6), atol=1e-6)
    else:
        assert np.allclose(tensor, np.diag(MOMENTS), atol=1e-6)
PY
