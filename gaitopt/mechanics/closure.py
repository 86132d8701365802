"""How far a loop of joints is from closing, its slope and its curvature.

A loop is walked as one serial chain: from a body back to the ground through its joints, and out
again along the displacements to where the body ought to be. The chain ends where it began exactly
when the posture fits.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.mechanics.spatial import cross, skew
from gaitopt.mechanics.triangles import symmetric
from gaitopt.nlp import Array


def loop_gap(gap: pin.SE3) -> Array:
    """Return position and half the axial vector of the rotation of a loop's end, shape (6,).

    Both vanish when the loop closes; the second is sin(angle) times the axis [m, 1].
    """
    R = gap.rotation
    return np.concatenate([gap.translation, _axial(R)])


def loop_gap_slope(gap: pin.SE3, axes: Array) -> Array:
    """Return the derivative of `loop_gap` with respect to the chain's coordinates, shape (6, m).

    Args:
        gap: placement of the chain's end in its base.
        axes: motion axes in the base, in order from the base, shape (m, 6).
    """
    linear = axes[:, :3] + cross(axes[:, 3:], np.broadcast_to(gap.translation, (len(axes), 3)))
    R = gap.rotation
    angular = 0.5 * axes[:, 3:] @ (np.trace(R) * np.eye(3) - R).T
    return np.concatenate([linear, angular], axis=1).T


def loop_gap_curvature(gap: pin.SE3, axes: Array, weights: Array) -> Array:
    """Return the Hessian of weights . loop_gap, shape (m, m).

    Along the chain, with i nearer to the base than j, p_ij = w_i x p_j and R_ij = [w_i] [w_j] R.

    Args:
        gap: placement of the chain's end in its base.
        axes: motion axes in the base, in order from the base, shape (m, 6).
        weights: of the six components.
    """
    w = axes[:, 3:]
    moved = axes[:, :3] + cross(w, np.broadcast_to(gap.translation, w.shape))
    N = -gap.rotation @ skew(weights[3:])
    upper = cross(np.broadcast_to(weights[:3], w.shape), w) @ moved.T
    upper += 0.5 * (w @ N @ w.T - np.trace(N) * w @ w.T)
    return symmetric(upper)


def _axial(matrix: Array) -> Array:
    """Half of sum_k e_k x (column k): the vector of the skew part."""
    twisted = matrix - matrix.T
    return 0.5 * np.array([twisted[2, 1], twisted[0, 2], twisted[1, 0]])
