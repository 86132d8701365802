#!/usr/bin/env bash
# Version:  pycapacity 2.1.9
# Does:     human.acceleration_ellipsoid(J, M, N, F_max) divides by the greatest forces of the muscles where it should multiply:
#           twice the strength, half the acceleration. Its docstring has the right set, x'' = J M⁻¹ N F with
#           ||W⁻¹ F|| <= 1 and W = diag(F_max); robot.acceleration_ellipsoid computes that one right.
# Guess:    the two modules agree where each joint has one muscle of unit arm; more force, more acceleration.
# Means:    of a leg with muscles of some hundred newtons the foot's ellipsoid comes out a million times too small, and a joint
#           with strong muscles looks like the slow one: studies of posture and of assistance read it backwards.
#           Take robot.acceleration_ellipsoid with J M⁻¹ N for J and the unit matrix for M.
# Seen:     thigh and shank of 0.4 m, six muscles of 300 to 1500 N: radii 3.4e-4 and 3.0e-5 m/s² for 196 and 33 by hand, by
#           robot.acceleration_ellipsoid and by the widest of 200000 sampled forces; all muscles twice as strong: half as
#           long. Two joints with muscles of 3 and 5 N: 1/3 and 1/5, the long axis along the first, for 5 and 3 along the second
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pycapacity==2.1.9 numpy==2.4.6
cd "$work"
"$work/env/bin/python" -W ignore - <<'PY'
import numpy as np
from pycapacity import human, robot

LENGTH, MASS = 0.4, (8.0, 3.5)
hip, knee = 0.3, -0.7  # thigh from the vertical, knee against the thigh
shank = hip + knee
J = np.array([[LENGTH * np.cos(hip) + LENGTH * np.cos(shank), LENGTH * np.cos(shank)],
              [LENGTH * np.sin(hip) + LENGTH * np.sin(shank), LENGTH * np.sin(shank)]])
half = LENGTH / 2
J1 = half * np.array([[np.cos(hip), 0.0], [np.sin(hip), 0.0]])
J2 = np.array([[LENGTH * np.cos(hip) + half * np.cos(shank), half * np.cos(shank)],
               [LENGTH * np.sin(hip) + half * np.sin(shank), half * np.sin(shank)]])
M = MASS[0] * (J1.T @ J1 + np.diag([LENGTH**2 / 12, 0])) + MASS[1] * (J2.T @ J2 + LENGTH**2 / 12 * np.ones((2, 2)))
# arms in metres: iliopsoas, gluteus, vasti, hamstrings, rectus femoris, short head of biceps
N = np.array([[0.05, -0.06, 0.0, -0.06, 0.045, 0.0], [0.0, 0.0, 0.045, -0.03, 0.045, -0.03]])
F = np.array([900.0, 1500.0, 1400.0, 1000.0, 600.0, 300.0])


def radii_and_axis(ellipsoid):
    return np.asarray(ellipsoid.radii), np.asarray(ellipsoid.rotation)[:, 0]


def angle(a, b):
    return np.degrees(np.arccos(min(abs(a @ b), 1.0)))


through = J @ np.linalg.inv(M) @ N
vectors, by_hand, _ = np.linalg.svd(through * F)  # of F = W u with ||u|| <= 1
given, _ = radii_and_axis(human.acceleration_ellipsoid(J, M, N, F))
right, right_axis = radii_and_axis(robot.acceleration_ellipsoid(through, np.eye(6), F))
twice, _ = radii_and_axis(human.acceleration_ellipsoid(J, M, N, 2 * F))
unit = np.random.default_rng(0).normal(size=(6, 200000))
reached = through @ (F[:, None] * unit / np.linalg.norm(unit, axis=0))
widest = np.linalg.norm(reached, axis=0).max()
print(f"radii {given} m/s^2, by hand {by_hand}, by robot.acceleration_ellipsoid {right}; widest of the samples {widest:.1f}")
print(f"all forces doubled: {twice / given} as long; {given[0] / given[1]:.1f} by one for {by_hand[0] / by_hand[1]:.1f}")
assert np.allclose(right, by_hand) and angle(right_axis, vectors[:, 0]) < 1e-3 and 0.95 * by_hand[0] < widest <= by_hand[0]
assert np.allclose(given, np.linalg.svd(through / F)[1]) and given[0] < 1e-5 * by_hand[0]
assert np.allclose(twice, given / 2) and given[0] / given[1] > 1.5 * by_hand[0] / by_hand[1]
two = np.eye(2), np.eye(2)
one, along = radii_and_axis(human.acceleration_ellipsoid(*two, np.eye(2), np.array([3.0, 5.0])))
same, across = radii_and_axis(robot.acceleration_ellipsoid(*two, np.array([3.0, 5.0])))
print(f"one muscle of unit arm a joint, 3 and 5 N: {one}, first axis {abs(along)}; motors of 3 and 5 N·m: {same}, {abs(across)}")
assert np.allclose(one, [1 / 3, 1 / 5]) and np.allclose(abs(along), [1, 0])
assert np.allclose(same, [5.0, 3.0]) and np.allclose(abs(across), [0, 1])
PY
