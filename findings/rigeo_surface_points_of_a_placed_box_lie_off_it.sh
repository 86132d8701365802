#!/usr/bin/env bash
# Version:  rigeo 0.2.0 (the library behind the papers on density-realizable inertial parameters)
# Does:     Box.random_points_on_surface is right for a box at the origin along the axes. Of any other box it takes points that
#           are placed and turned already, sets one coordinate of each to a half extent as if they were not, and places
#           and turns them once more: nearly none lies on the surface, and their mean is not the centre.
# Guess:    "Uniformly sample points on the surface of the box"; on_surface of the same class says yes to each, as it does
#           for points of random_points_on_edges, and their moments are those of hollow_density_params.
# Means:    contact points, loads and payload shells that are drawn on a hand, a sole or a pack lie in the air, up to its own
#           offset away, and a sampled shell has other moments than the exact one beside it. Sample the box without
#           place and turn, and place the points by hand.
# Seen:     box of half extents 0.1, 0.05 and 0.02 m, its centre 0.3 m ahead, turned: 0 of 20000 points on the surface (edges: all),
#           their mean 0.27 m from the centre, moment about y of 1 kg of them 0.211 kg·m² for 0.103 of the shell; at the origin all
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check rigeo==0.2.0 numpy==2.4.6 scipy==1.17.1
"$work/env/bin/python" -W ignore - <<'PY'
import numpy as np
import rigeo
from scipy.spatial.transform import Rotation

SIDES, POINTS = np.array([0.1, 0.05, 0.02]), 20000
centre, turn = np.array([0.3, 0.05, -0.1]), Rotation.from_euler("xyz", [0.4, -0.3, 0.8]).as_matrix()


def by_hand(points, centre, turn):
    """Which points lie on the surface."""
    inside = (points - centre) @ turn / SIDES
    return np.isclose(np.abs(inside).max(axis=1), 1.0, atol=1e-9)


def moment(points):
    """About the axis of y, of 1 kg spread evenly over the points."""
    return np.mean(points[:, 0] ** 2 + points[:, 2] ** 2)


placed, plain = rigeo.Box(SIDES, center=centre, rotation=turn), rigeo.Box(SIDES)
edges = placed.random_points_on_edges(POINTS, rng=0)
assert by_hand(edges, centre, turn).all() and np.all(placed.on_surface(edges))
at_origin = plain.random_points_on_surface(POINTS, rng=0)
assert by_hand(at_origin, np.zeros(3), np.eye(3)).all()
right = at_origin @ turn.T + centre
assert by_hand(right, centre, turn).all() and np.all(placed.on_surface(right))
exact = placed.hollow_density_params(1.0).I[1, 1]
assert np.isclose(moment(right), exact, rtol=0.02) and np.linalg.norm(right.mean(axis=0) - centre) < 0.002
points = placed.random_points_on_surface(POINTS, rng=0)
on, off = by_hand(points, centre, turn), np.linalg.norm(points.mean(axis=0) - centre)
print(f"placed box: {on.sum()} of {POINTS} points on the surface, by on_surface {np.sum(placed.on_surface(points))}; mean {off:.3f} m off")
print(f"moment about y of 1 kg: {moment(points):.4f} for {exact:.4f} kg·m² of hollow_density_params, {moment(right):.4f} placed by hand")
assert on.sum() < 0.01 * POINTS and np.sum(placed.on_surface(points)) < 0.01 * POINTS and off > 0.1
assert moment(points) > 1.3 * exact or moment(points) < 0.7 * exact
PY
