"""The ground under a gait: level, a slope or stairs, in words and for pictures."""

from __future__ import annotations

import math

import numpy as np
from pinocchio.utils import rotate

from gaitopt.gait.result import Gait
from gaitopt.gait.stairs import stairs_of
from gaitopt.model.feet.sole import Sole
from gaitopt.model.multibody import Multibody
from gaitopt.nlp import Array


def upright(body: Multibody) -> Array:
    """Return the rotation from the world's axes, x along the ground, to axes whose z is vertical.

    Args:
        body: the robot on its ground, which turns gravity in the world.
    """
    ahead, _, up = body.gravity
    return np.array(rotate("y", math.atan2(ahead, -up)))


def edge_before(gait: Gait) -> float | None:
    """Return x of the edge of the tread before the stance foot [m]; None on ground without."""
    rise = gait.number("task", "stairs") or 0.0
    edges = [gait.number("sole", name) for name in ("toe", "heel", "left", "right")]
    if rise == 0.0 or None in edges:
        return None
    sole = Sole(*(float(edge or 0.0) for edge in edges))
    nosing = gait.number("task", "margins", "nosing")
    speed, duration = (gait.number("task", name) or 0.0 for name in ("speed", "duration"))
    return stairs_of(rise, speed * duration, nosing, sole).edge


def ground_words(gait: Gait) -> str:
    """Return the ground that a gait walks on in words, empty for level ground."""
    slope, rise = gait.number("task", "slope") or 0.0, gait.number("task", "stairs") or 0.0
    if rise != 0.0:
        way = "upstairs" if rise > 0.0 else "downstairs"
        return f"{way}, {1e3 * abs(rise):.4g} mm for {1e3 * gait.step_length:.4g} mm"
    if slope == 0.0:
        return ""
    way = "uphill" if slope > 0.0 else "downhill"
    rise = 100.0 * math.tan(abs(slope))
    return f"{way}, {rise:.3g} % ({math.degrees(abs(slope)):.3g}°)"
