"""Feet that are not flat on the ground in the reference posture: which way is up for them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from scipy.spatial import ConvexHull, QhullError

from gaitopt.nlp import Array

_FLAT = 0.05  # rad: a foot tilted by less is flat, and its mesh rounded
MOST_TILTED = 0.6435  # rad: faces that look down more steeply may be the sole
_DOWN = float(np.cos(MOST_TILTED))
_SAME_FACE = 0.02  # rad: triangles of one face differ by rounding of the mesh
_EXACT = 1e-3  # rad: and where all its points lie in one plane
_THIN = 1e-6  # of their extent: points this near to a plane lie in it
_WIDE = 1e-3  # of their extent: and points this near to a line do not tell a plane
_SHARE = 0.5  # of all that looks down: a face must be that large to be the sole


def sole_normal(points: Array, down: Array, radii: Array | None = None) -> Array | None:
    """Return the outward normal of a foot's lower face where it is not level, shape (3,).

    None if the face looks straight down, or if there is none; see `lowest_face`.

    Args:
        points: of the foot [m], shape (n, 3).
        down: unit vector, shape (3,).
        radii: of balls about the points [m], shape (n,); 0 by default.
    """
    normal = lowest_face(points, radii, down)
    if normal is None:
        return None
    exact = _plane(points, radii) is not None or _is_face(points, radii, normal)
    return None if tilt(normal, down) < (_EXACT if exact else _FLAT) else normal


def _is_face(points: Array, radii: Array | None, normal: Array) -> bool:
    """Tell whether a foot ends below in a plane, as a box does, so that its tilt is no rounding."""
    if radii is not None and np.ptp(radii) > 0.0:
        return False
    heights = points @ normal
    size = float(np.ptp(points, axis=0).max())
    face = points[heights > heights.max() - _THIN * size]
    if len(face) < 3:
        return False
    spread = np.linalg.svd(face - face.mean(axis=0), compute_uv=False)
    wide = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    share = (spread[:2] / np.sqrt(len(face))) / (wide[:2] / np.sqrt(len(points)))
    return bool((share > _SHARE).all())


def lowest_face(points: Array, radii: Array | None, down: Array) -> Array | None:
    """Return the outward normal of a foot's lower face, shape (3,).

    The face is the largest one, of the convex hull of the foot, of those that look down, or the
    plane in which all points lie. None if no face is large enough to tell.

    Args:
        points: of the foot [m], shape (n, 3).
        radii: of balls about the points [m], shape (n,); None for none.
        down: unit vector, shape (3,).
    """
    plane = _plane(points, radii)
    if plane is not None:
        normal = plane if plane @ down > 0.0 else -plane
        return normal if normal @ down > _DOWN else None
    try:
        hull = ConvexHull(points)
    except QhullError:
        return None  # points on a line
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
    if sizes[best] < _SHARE * areas.sum():
        return None
    if normals[best] @ down > np.cos(_FLAT):
        return np.asarray(normals[best])
    mean = areas[alike[best]] @ normals[alike[best]]
    return np.asarray(mean / np.linalg.norm(mean))


def tilt(normal: Array, down: Array) -> float:
    """Return the angle between two unit vectors [rad], exact for small ones too."""
    return float(np.arctan2(np.linalg.norm(np.cross(normal, down)), normal @ down))


def _plane(points: Array, radii: Array | None) -> Array | None:
    """Return the normal of the plane under points or equal balls, None if there is none."""
    if len(points) < 3 or (radii is not None and np.ptp(radii) > 0.0):
        return None
    _, sizes, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    flat = sizes[2] < _THIN * sizes[0] and sizes[1] > _WIDE * sizes[0]
    return np.asarray(axes[2]) if flat else None


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
