#!/usr/bin/env bash
# Version:  biorbd 1.12.4
# Does:     a muscle that may wrap over a half cylinder at the knee has its exact length as long as it touches it. Where
#           it does not touch, musculoTendonLength is less than the straight line from origin to insertion, by 0.10 to
#           0.13 m of 0.6 m: the middle third of the straight path is replaced by a radius times an angle. The moment
#           arm (musclesLengthJacobian) is right on both sides, so it is not the derivative of the length there.
#           Nothing is said. (Its pull request 227 sets the points at the thirds, not the length.)
# Guess:    a muscle that hangs free is as long as the straight line, as without the cylinder.
# Means:    the fibre of a quadriceps or gastrocnemius is shorter by a third of its length over half of the range and
#           jumps as it touches; its force is that of another length. Compare the length with that of the muscle
#           without the cylinder, or put via points in its place.
# Seen:     radius 0.05 m, knee at 0 rad: length 0.4785 m, by hand and without the cylinder 0.6000 m; force 224 N for 801 N
#           (at -0.6 rad 11 N for 573 N); moment arm 0.1000 m, slope of the length 0.1500 m. At 0.6 rad, where it
#           wraps, 0.6382 m, by hand too
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check biorbd==1.12.4
cat > "$work/knee.bioMod" <<'MODEL'
version 4
gravity 0 0 -9.81
segment thigh
    mass 5
    inertia
        0.1 0 0
        0 0.12 0
        0 0 0.02
    com 0 0 0.2
endsegment
segment shank
    parent thigh
    rotations y
    mass 3
    inertia
        0.05 0 0
        0 0.06 0
        0 0 0.01
    com 0 0 -0.2
endsegment
musclegroup front
    originparent thigh
    insertionparent shank
endmusclegroup
muscle quadriceps
    type hilldegroote
    statetype degroote
    musclegroup front
    originposition 0.1 0 0.3
    insertionposition 0.1 0 -0.3
    optimallength 0.3
    maximalforce 800
    tendonslacklength 0.3
    pennationangle 0
    maxvelocity 10
endmuscle
MODEL
cp "$work/knee.bioMod" "$work/wrapped.bioMod"
cat >> "$work/wrapped.bioMod" <<'MODEL'
wrapping condyle
    type halfcylinder
    parent thigh
    muscle quadriceps
    musclegroup front
    rt 1.5707963267948966 0 0 xyz 0 0 0
    radius 0.05
    length 1
endwrapping
MODEL
"$work/env/bin/python" - "$work" <<'PY'
import sys

import biorbd
import numpy as np

RADIUS, ORIGIN, INSERTION = 0.05, np.array([0.1, 0.3]), np.array([0.1, -0.3])  # x and z in m; cylinder along y


def by_hand(knee):
    """Length of the shortest path in front of the cylinder, and whether it touches."""
    sine, cosine = np.sin(knee), np.cos(knee)
    end = np.array([[cosine, sine], [-sine, cosine]]) @ INSERTION
    turn = (np.arctan2(*ORIGIN[::-1]) - np.arctan2(*end[::-1])) % (2 * np.pi)
    distances = np.linalg.norm(ORIGIN), np.linalg.norm(end)
    arc = turn - sum(np.arccos(RADIUS / d) for d in distances)
    if arc <= 0:
        return float(np.linalg.norm(end - ORIGIN)), False
    return float(sum(np.sqrt(d**2 - RADIUS**2) for d in distances) + RADIUS * arc), True


def length(model, knee):
    q = biorbd.GeneralizedCoordinates(np.array([knee]))
    model.updateMuscles(q, True)
    return model.muscle(0).musculoTendonLength(model, q, True)


def force(model, knee):
    states = model.stateSet()
    states[0].setActivation(1.0)
    return model.muscleForces(states, np.array([knee]), np.zeros(1)).to_array()[0]


bare, wrapped = (biorbd.Model(f"{sys.argv[1]}/{name}.bioMod") for name in ("knee", "wrapped"))
short = {}
for knee in (-1.2, -0.6, 0.0, 0.3, 0.6, 1.2):
    true, touches = by_hand(knee)
    got, straight = length(wrapped, knee), length(bare, knee)
    wrapped.updateMuscles(np.array([knee]), True)
    arm = wrapped.musclesLengthJacobian(np.array([knee])).to_array().item()
    slope = (length(wrapped, knee + 1e-6) - length(wrapped, knee - 1e-6)) / 2e-6
    true_arm = (by_hand(knee + 1e-6)[0] - by_hand(knee - 1e-6)[0]) / 2e-6
    forces = force(wrapped, knee), force(bare, knee)
    print(f"knee {knee:+.1f} rad, {'touches' if touches else 'free'}: length {got:.4f} m, by hand {true:.4f} m, straight"
          f" {straight:.4f} m; moment arm {arm:.4f} m, slope {slope:.4f} m; force {forces[0]:.0f} N, bare {forces[1]:.0f} N")
    assert np.isclose(arm, true_arm, atol=1e-6)
    if touches:
        assert np.isclose(got, true, atol=1e-6) and np.isclose(slope, arm, atol=1e-6)
    else:
        assert np.isclose(straight, true, atol=1e-6)
        short[knee] = straight - got
    if knee == -0.6:
        assert forces[0] < 20 and forces[1] > 500
assert set(short) == {-1.2, -0.6, 0.0, 0.3} and all(0.09 < gap < 0.14 for gap in short.values())
PY
