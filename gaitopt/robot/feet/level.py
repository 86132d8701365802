"""Feet that are not flat on the ground in the reference posture: which way is up for them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from scipy.spatial import ConvexHull, QhullError

from gaitopt.nlp import Array

_FLAT = 0.05  # rad: a foot tilted by less is flat, and its mesh rounded
_DOWN = 0.8  # cosine: faces that look down at least this much may be the sole
_SAME_FACE = 0.02  # rad: triangles of one face differ by rounding of the mesh
_SHARE = 0.5  # of all that looks down: a face must be that large to be the sole


def sole_normal(points: Array, down: Array) -> Array | None:
    """Return the outward normal of a foot's lower face where it is not level, shape (3,).

    The face is the largest one, of the convex hull of the foot, of those that look down. None if
    it looks straight down, or if no face is large enough to tell.

    Args:
        points: of the foot [m], shape (n, 3).
        down: unit vector, shape (3,).
    """
    try:
        hull = ConvexHull(points)
    except QhullError:
        return None  # a flat or empty foot: nothing below it to tell from
    normals = hull.equations[:, :3]
    a, b, c = (hull.points[hull.simplices[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0
    low = normals @ down > _DOWN
    if not low.any():
        return None
    normals, areas = normals[low], areas[low]
    alike = normals @ normals.T > np.cos(_SAME_FACE)
    sizes = alike @ areas
    best = int(sizes.argmax())
    if sizes[best] < _SHARE * areas.sum() or normals[best] @ down > np.cos(_FLAT):
        return None
    mean = areas[alike[best]] @ normals[alike[best]]
    return np.asarray(mean / np.linalg.norm(mean))


def levelled(place: pin.SE3, pivot: Array, turn: Array) -> pin.SE3:
    """Return a placement turned about a point.

    Args:
        place: in some frame.
        pivot: the point, in that frame [m], shape (3,).
        turn: rotation, shape (3, 3).
    """
    return pin.SE3(turn @ place.rotation, pivot + turn @ (place.translation - pivot))


def turn_onto(vector: Array, goal: Array) -> Array:
    """Return the smallest rotation that takes one unit vector onto another, shape (3, 3)."""
    axis = np.cross(vector, goal)
    sine, cosine = float(np.linalg.norm(axis)), float(vector @ goal)
    if sine == 0.0:
        return np.eye(3)
    return np.asarray(pin.exp3(axis / sine * np.arctan2(sine, cosine)))
