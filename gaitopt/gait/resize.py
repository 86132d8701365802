"""A walk of one robot as the start for one of other lengths."""

from __future__ import annotations

import numpy as np

from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array


def resized(x: Array, old: WalkProblem, new: WalkProblem) -> Array:
    """Return x with the pelvis at the height where no leg is straighter than before.

    Joint angles fit legs of any length; a height that is kept bends them otherwise, or is out of
    their reach.

    Args:
        x: parameters of a walk of the old robot, shape (P,).
        old, new: of the same layout.
    """
    at = new.layout.index("pelvis_height")
    if at is None:
        return x
    before, after = _legs(old, x), _legs(new, x)
    share = np.linalg.norm(before, axis=1) / old.robot.legs.reach
    reach = share * new.robot.legs.reach
    room = reach**2 - (after[:, :2] ** 2).sum(axis=1)
    if not (room > 0.0).all():
        return x
    lifted = x.copy()
    lifted[at] += float((np.sqrt(room) - after[:, 2]).min())
    return lifted


def _legs(problem: WalkProblem, x: Array) -> Array:
    """Return the vectors from ankles to hips in double support, shape (2, 3)."""
    boundary = problem.model.boundary
    (pelvis, _), (sole, _) = boundary.place(problem.layout.geometry_of(x))
    return boundary.leg_vectors(pelvis, sole)
