"""Where joints are, told by their lines alone.

A revolute joint is a line. Where on it a file puts the origin of the joint is the draughtsman's
choice, and nothing that is found about a robot may depend on it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from gaitopt.nlp import Array

# Sine of the angle between two lines from which on they tell where on each other they meet; they
# have no say below the first, and their full one from the second on. In between it grows smoothly,
# so that the two legs of a robot that are nearly alike have points that are nearly alike.
_ASKEW = (0.3, 0.6)
_FAINT = 1e-6  # weight of the joint before, which decides where no line does


def joint_lines_of(model: pin.Model, q: Array) -> tuple[Array, Array]:
    """Return a point and the direction of the line of each joint.

    Args:
        model: free-flyer and joints.
        q: its configuration, shape (nq,).

    Returns:
        Points in the world [m], shape (njoints, 3), as `points_on_lines` chooses them, or the
        origins of joints that do not revolve; and unit axes, 0 for those, shape (njoints, 3).
    """
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    origins = np.array([placement.translation for placement in data.oMi])
    axes = np.zeros((model.njoints, 3))
    for joint in range(2, model.njoints):
        at = model.joints[joint]
        if at.nv == 1:
            J = pin.getJointJacobian(model, data, joint, pin.LOCAL_WORLD_ALIGNED)
            axes[joint] = J[3:, at.idx_v]
    return points_on_lines(origins, axes, [int(p) for p in model.parents]), axes


def points_on_lines(points: Array, axes: Array, parents: Sequence[int]) -> Array:
    """Return the point of each line of a tree that is nearest to the line of its parent.

    As far as the two are parallel, the lines of its children decide, and where those are too, the
    point of the parent.

    Args:
        points: any point of each line [m], shape (n, 3).
        axes: unit vectors along the lines, 0 for what is a point and no line, shape (n, 3).
        parents: row of the parent of each, which comes before it; its own for none.
    """
    found = np.array(points)
    for row in map(int, np.flatnonzero(axes.any(axis=1))):
        parent = parents[row]
        children = [k for k in range(len(points)) if parents[k] == row != k]
        weight, along = _FAINT, _FAINT * float((found[parent] - points[row]) @ axes[row])
        if parent == row:
            along = 0.0
        left = 1.0
        for beside in ([parent], children):
            sides = [_meeting(points, axes, row, k) for k in beside]
            say = max((s for s, _ in sides), default=0.0)
            for share, place in sides:
                part = left * share / max(len(beside), 1)
                weight, along = weight + part, along + part * place
            left *= 1.0 - say
        found[row] = points[row] + along / weight * axes[row]
    return found


def _meeting(points: Array, axes: Array, row: int, other: int) -> tuple[float, float]:
    """Return how clearly another line tells a place on a line, and which, from its point [m]."""
    cosine = float(axes[row] @ axes[other])
    sine = float(np.linalg.norm(np.cross(axes[row], axes[other])))
    share = _share(sine)
    if share == 0.0:
        return 0.0, 0.0
    gap = points[other] - points[row]
    return share, float(gap @ axes[row] - cosine * (gap @ axes[other])) / sine**2


def _share(sine: float) -> float:
    """Weight of a line, from 0 to 1 with a continuous slope."""
    part = min(max((sine - _ASKEW[0]) / (_ASKEW[1] - _ASKEW[0]), 0.0), 1.0)
    return part * part * (3.0 - 2.0 * part)
