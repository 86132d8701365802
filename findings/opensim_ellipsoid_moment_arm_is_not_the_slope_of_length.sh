#!/usr/bin/env bash
# Version:  opensim 4.6
# Does:     a muscle that is kept on one side of a WrapEllipsoid (quadrant "x") and passes 10 to 20 mm beside its middle plane
#           has a moment arm (computeMomentArm) that is not the slope of its length over the angle of the joint. Where
#           it bends round the far side they differ by up to a fifth for a quarter of a radian. The path in the middle plane
#           is exact, and so are a WrapSphere and a WrapCylinder in the same place. (Issues 2883 and 3741 of
#           opensim-core, open, show muscles that jump on ellipsoids and at their edges.)
# Guess:    torque over tension is the slope of length, as OpenSim defines it: pulling at one newton does the work of one
#           newton over the way that the muscle shortens.
# Means:    hips, knees and shoulders of the usual models wrap on ellipsoids. A muscle there does not do the work that its
#           fibre does: a stride that closes in length does not close in energy, and an optimiser with the length as
#           constraint and the arm in the torques gains by it. Compare the arm with a difference of lengths.
# Seen:     radii 50, 80, 60 mm, from -0.50 to -0.30 rad at 1 N: fibre 14.8 mJ, torque 12.8 mJ; arm at -0.40 rad 64.8 mm,
#           slope 74.7 mm; in the middle plane, sphere and cylinder: equal to 0.1 mm
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check opensim==4.6 numpy==2.4.6
"$work/env/bin/python" - <<'PY'
import numpy as np
import opensim as osim

osim.Logger.setLevelString("off")


def muscle(surface, beside):
    """Lengths and moment arms of one muscle over a hinge, `beside` the middle plane at its two ends."""
    model = osim.Model()
    thigh, shank = (osim.Body(n, 1, osim.Vec3(0), osim.Inertia(0.1, 0.1, 0.1)) for n in ("thigh", "shank"))
    for body in (thigh, shank):
        model.addBody(body)
    model.addJoint(osim.WeldJoint("fixed", model.getGround(), thigh))
    origin = osim.Vec3(0)
    hinge = osim.PinJoint("knee", thigh, origin, origin, shank, origin, origin)
    hinge.updCoordinate().setName("angle")
    model.addJoint(hinge)
    surface.setName("surface")
    surface.set_quadrant("x")
    surface.set_translation(osim.Vec3(0.02, 0.01, 0))
    thigh.addWrapObject(surface)
    path = osim.PathActuator()
    path.setName("muscle")
    path.addNewPathPoint("above", thigh, osim.Vec3(0.06, 0.3, beside[0]))
    path.addNewPathPoint("below", shank, osim.Vec3(0.05, -0.25, beside[1]))
    path.updGeometryPath().addPathWrap(surface)
    model.addForce(path)
    model.finalizeConnections()
    state = model.initSystem()
    angle = model.getCoordinateSet().get("angle")
    way = osim.PathActuator.safeDownCast(model.getForceSet().get("muscle")).getGeometryPath()
    lengths, arms = [], []
    for value in ANGLES:
        angle.setValue(state, value)
        model.realizePosition(state)
        lengths.append(way.getLength(state))
        arms.append(way.computeMomentArm(state, angle))
    return np.array(lengths), np.array(arms)


ANGLES = np.linspace(-0.50, -0.30, 201)
ellipsoid, flat, sphere, cylinder = osim.WrapEllipsoid(), osim.WrapEllipsoid(), osim.WrapSphere(), osim.WrapCylinder()
for surface in (ellipsoid, flat):
    surface.set_dimensions(osim.Vec3(0.05, 0.08, 0.06))
for surface in (sphere, cylinder):
    surface.set_radius(0.05)
cylinder.set_length(1.0)
seen = {}
for name, surface, beside in (
    ("ellipsoid", ellipsoid, (0.01, 0.02)),
    ("ellipsoid, middle plane", flat, (0.0, 0.0)),
    ("sphere", sphere, (0.01, 0.02)),
    ("cylinder", cylinder, (0.01, 0.02)),
):
    lengths, arms = muscle(surface, beside)
    slope = -np.gradient(lengths, ANGLES)
    fibre, torque = lengths[0] - lengths[-1], np.trapezoid(arms, ANGLES)
    seen[name] = 1e3 * fibre, 1e3 * torque, 1e3 * arms[100], 1e3 * slope[100], 1e3 * np.max(abs(arms - slope)[2:-2])
    print("{}: fibre {:.2f} mJ, torque {:.2f} mJ; at -0.40 rad arm {:.1f} mm, slope {:.1f} mm; apart by up to {:.2f} mm"
          .format(name, *seen[name]))
fibre, torque, arm, slope, apart = seen.pop("ellipsoid")
assert abs(fibre - 14.8) < 0.1 and abs(torque - 12.8) < 0.2 and abs(arm - 64.8) < 0.3 and abs(slope - 74.7) < 0.3
assert all(abs(row[0] - row[1]) < 0.02 and row[4] < 0.1 for row in seen.values())
PY
