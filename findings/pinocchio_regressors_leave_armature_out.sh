#!/usr/bin/env bash
# Version:  pin 4.1.0 (Pinocchio)
# Does:     with a rotor inertia in `model.armature`, `rnea`, `crba`, `aba`, `computeMinverse`,
#           `impulseDynamics` and `computeKineticEnergy` count it, `computeJointTorqueRegressor` and
#           `computeKineticEnergyRegressor` do not: regressor times parameters is the torque (energy) of
#           the robot without rotors, short of armature x acceleration (half of armature x rate squared).
# Guess:    the regressor of a model times the parameters of that model is `rnea` of that model, as the
#           documentation of computeJointTorqueRegressor says.
# Means:    who identifies masses of a geared robot with it charges the links with the rotors' torque, and
#           who takes sensitivities from it loses the rotors; add diag(ddq) columns for the armature.
# Seen:     rnea - Y phi = armature * ddq to 1e-13 N·m, 0.18 N·m here; kinetic energy short by
#           the rotors' share exactly
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
"$work/env/bin/python" - <<'PY'
import numpy as np
import pinocchio as pin

model = pin.buildSampleModelManipulator()
model.armature = np.linspace(0.05, 0.3, model.nv)
data = model.createData()
rng = np.random.default_rng(0)
q = pin.integrate(model, pin.neutral(model), rng.uniform(-1.0, 1.0, model.nv))
v, a = rng.uniform(-1.0, 1.0, (2, model.nv))
phi = np.concatenate([one.toDynamicParameters() for one in list(model.inertias)[1:]])

upper = np.triu(pin.crba(model, data, q))
M = upper + np.triu(upper, 1).T
torque = pin.rnea(model, data, q, v, a)
energy = pin.computeKineticEnergy(model, data, q, v)
assert np.abs(torque - M @ a - pin.nonLinearEffects(model, data, q, v)).max() < 1e-12
assert abs(energy - 0.5 * v @ M @ v) < 1e-12
assert np.abs(pin.aba(model, data, q, v, torque) - a).max() < 1e-10

short = torque - pin.computeJointTorqueRegressor(model, data, q, v, a) @ phi
missing = energy - pin.computeKineticEnergyRegressor(model, data, q, v) @ phi
print(f"rnea - Y phi:  {np.round(short, 4)} N·m")
print(f"armature * a:  {np.round(model.armature * a, 4)} N·m")
print(f"energy short by {missing:.6f} J, of the rotors {0.5 * v @ (model.armature * v):.6f} J")
assert np.abs(short).max() > 0.05
assert np.abs(short - model.armature * a).max() < 1e-12
assert abs(missing - 0.5 * v @ (model.armature * v)) < 1e-12
PY
