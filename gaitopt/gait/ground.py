"""The ground under a gait: level or a slope, in words and for pictures."""

from __future__ import annotations

import math

import numpy as np
from pinocchio.utils import rotate

from gaitopt.gait.result import Gait
from gaitopt.model.multibody import Multibody
from gaitopt.nlp import Array


def upright(body: Multibody) -> Array:
    """Return the rotation from the world's axes, x along the ground, to axes whose z is vertical.

    Args:
        body: the robot on its ground, which turns gravity in the world.
    """
    ahead, _, up = body.gravity
    return np.array(rotate("y", math.atan2(ahead, -up)))


def ground_words(gait: Gait) -> str:
    """Return the ground that a gait walks on in words, empty for level ground."""
    slope = gait.number("task", "slope") or 0.0
    if slope == 0.0:
        return ""
    way = "uphill" if slope > 0.0 else "downhill"
    rise = 100.0 * math.tan(abs(slope))
    return f"{way}, {rise:.3g} % ({math.degrees(abs(slope)):.3g}°)"
