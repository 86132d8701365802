"""What a controller plays: the samples of one step, or of a whole stride with both legs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitopt.gait.result import Gait
from gaitopt.nlp import Array

_FORCE_MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])  # a moment is an axial vector
_COP_MIRROR = np.array([1.0, -1.0])


@dataclass(frozen=True, eq=False)
class Stride:
    """Samples of one step, or of a step and its mirror image; M of them.

    At the change of step the instant is there twice, before and after the impact.

    Attributes:
        time: [s], shape (M,).
        step: 0 or 1, shape (M,).
        q, dq, ddq, torque: of `Gait.joint_names`, shape (M, n); units as in `Gait`.
        ground_wrench, cop: in the sole frame of the standing foot, shapes (M, 6) and (M, 2).
        standing: sole frame of the standing foot, one for each step.
    """

    time: Array
    step: NDArray[np.intp]
    q: Array
    dq: Array
    ddq: Array
    torque: Array
    ground_wrench: Array
    cop: Array
    standing: tuple[str, ...]


def stride(gait: Gait, both_legs: bool = False) -> Stride:
    """Return the step as computed, or with its mirror image after it (Eq. 26)."""
    steps = range(2 if both_legs else 1)
    count = len(gait.time)

    def joined(values: Array, mirror: Array) -> Array:
        return np.concatenate([values if k == 0 else values @ mirror.T for k in steps])

    return Stride(
        time=np.concatenate([gait.time + k * gait.duration for k in steps]),
        step=np.repeat(np.array(steps, dtype=np.intp), count),
        q=joined(gait.q, gait.mirror),
        dq=joined(gait.dq, gait.mirror),
        ddq=joined(gait.ddq, gait.mirror),
        torque=joined(gait.torque, gait.mirror),
        ground_wrench=joined(gait.ground_wrench, np.diag(_FORCE_MIRROR)),
        cop=joined(gait.cop, np.diag(_COP_MIRROR)),
        standing=(gait.stance_sole, gait.swing_sole_frame)[: len(steps)],
    )
