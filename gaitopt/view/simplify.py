"""Meshes as small as the eye allows: fewer triangles, with edges that stay sharp.

The triangles of a robot's file are made for machining. fast-simplification takes away those that
change the surface least (quadric error metrics: Garland and Heckbert, SIGGRAPH 1997); normals are
made again, shared only across edges that are not sharp.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.nlp import Array

Rows = NDArray[np.intp]

FEW = 400  # triangles: a mesh of fewer stays as it is
_FACTOR, _POWER = 12.0, 0.55
"""Of M triangles 12 M**0.55 stay: chosen by looking, 2,700 of the 19,000 of a link of G1."""
_SHARP = np.cos(np.radians(40.0))  # between two faces whose edge is to be seen
_FAN = 64  # triangles about a corner; where there are more, they are drawn flat
_WELD = 1e-6  # of the mesh's size: corners so near are one
_FINE = 127.0  # steps of a component of a normal
_HASTE = 5
"""How fast the library gives up on the shape where it takes too few triangles away: its limit of
the error grows by this power of the round (its own 7). A mesh of many parts, screws and vents,
cannot be made as small as is wanted; with 7 the large surfaces beside them pay for it."""
_SIZE = 100.0
"""Of the mesh while it is simplified: the library collapses edges by thresholds that know no unit,
and folds the surface of a mesh of some centimetres in metres (version 0.2.0)."""
_MANTISSA = np.uint32(0xFFFFF000)  # 11 bits, a thousandth of a coordinate in 2


@dataclass(frozen=True, eq=False)
class Surface:
    """A surface of triangles that share corners.

    Attributes:
        corners: shape (V, 3), in the units of the file.
        normals: at them, shape (V, 3); None where facets are flat.
        faces: rows of `corners`, shape (F, 3).
    """

    corners: Array
    normals: Array | None
    faces: Rows


def simplified(corners: Array) -> Surface | None:
    """Return what the eye sees of many triangles.

    Args:
        corners: of the triangles, shape (M, 3, 3), in any unit.

    Returns:
        About 12 M**0.55 triangles; None where there are so few, or so broken, that they had better
        be drawn as they are.
    """
    if len(corners) <= FEW:
        return None
    points, faces = _welded(corners)
    size = float(np.ptp(points, axis=0).max()) / _SIZE or 1.0
    wanted = max(FEW, int(_FACTOR * len(faces) ** _POWER))
    if len(faces) > wanted:
        import fast_simplification  # which looks for its own version: slow to import

        points, faces = fast_simplification.simplify(
            np.ascontiguousarray(points / size, dtype=np.float32),
            np.ascontiguousarray(faces, dtype=np.int32),
            target_reduction=1.0 - wanted / len(faces),
            agg=_HASTE,
        )
        points, faces = (
            size * np.asarray(points, dtype=np.float64),
            np.asarray(faces, dtype=np.intp),
        )
    if not len(faces) or not np.isfinite(points).all():
        return None
    return _shaded(points, faces)


def _welded(corners: Array) -> tuple[Array, Rows]:
    """Return corners (V, 3), each once, and triangles (F, 3) that keep an area."""
    flat = corners.reshape(-1, 3)
    low, size = flat.min(axis=0), float(np.ptp(flat, axis=0).max()) or 1.0
    x, y, z = np.rint((flat - low) / (_WELD * size)).astype(np.int64).T
    _, first, which = np.unique((x << 42) + (y << 21) + z, return_index=True, return_inverse=True)
    faces = which.reshape(-1, 3)
    a, b, c = faces.T
    return flat[first], faces[(a != b) & (b != c) & (a != c)]


def _shaded(points: Array, faces: Rows) -> Surface:
    """Return the surface with a normal at each corner; at a sharp edge, several corners."""
    a, b, c = points[faces.T]
    across = np.cross(b - a, c - a)  # as long as twice the area, by which normals are weighed
    size = np.linalg.norm(across, axis=1, keepdims=True)
    unit = across / np.where(size > 0.0, size, 1.0)
    vertex = faces.ravel()
    face = np.repeat(np.arange(len(faces)), 3)
    order = np.argsort(vertex, kind="stable")
    counts = np.bincount(vertex, minlength=len(points))
    begins = np.cumsum(counts) - counts
    many = counts[vertex[order]]  # corners at the point of each corner
    many = np.where(many > _FAN, 0, many)
    one = np.repeat(np.arange(len(order)), many)
    inside = np.arange(len(one)) - np.repeat(np.cumsum(many) - many, many)
    other = begins[vertex[order]][one] + inside
    mine, yours = face[order][one], face[order][other]
    smooth = np.einsum("ij,ij->i", unit[mine], unit[yours]) > _SHARP
    normals = np.zeros((len(order), 3))
    for axis in range(3):
        normals[:, axis] = np.bincount(
            one[smooth], weights=across[yours[smooth], axis], minlength=len(order)
        )
    alone = ~normals.any(axis=1)
    normals[alone] = unit[face[order][alone]]
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    steps = np.rint(_FINE * normals / np.where(length > 0.0, length, 1.0)).astype(np.int64)
    key = vertex[order].astype(np.int64)
    for axis in range(3):
        key = (key << 8) + (steps[:, axis] + 128)
    _, first, which = np.unique(key, return_index=True, return_inverse=True)
    numbers = np.empty(len(order), dtype=np.intp)
    numbers[order] = which
    short = (points[vertex[order][first]].astype(np.float32).view(np.uint32) & _MANTISSA).view(
        np.float32
    )
    return Surface(short.astype(np.float64), steps[first] / _FINE, numbers.reshape(-1, 3))
