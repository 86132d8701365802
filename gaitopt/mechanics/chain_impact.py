"""Rigid, inelastic impact of the swing foot with its whole sole: Section 2.4, Eqs. (14) to (24).

Velocities are V = [V_0; omega_0; dq], the base in R0; wrenches and twists of the swing foot are
the paper's, at O_12 in R12; `impulse_on_foot` takes an impulse to the sole.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gaitopt.errors import InputError
from gaitopt.mechanics.chain import Chain, link_placements
from gaitopt.mechanics.mdh import hat, times
from gaitopt.mechanics.newton_euler import inertia_matrix, sole_axes
from gaitopt.nlp import Array


def swing_jacobian(chain: Chain, q: ArrayLike) -> Array:
    """Return D12' of Eq. (24): [V_n; omega_n] of link n in R_n equals this times V, Eq. (23).

    Args:
        chain: the chain.
        q: joint values, shape (..., n) [rad, m].

    Returns:
        Shape (..., 6, 6 + n).

    Raises:
        InputError: q has the wrong shape or is not finite.
    """
    A, P = link_placements(chain, q)
    to_last = np.swapaxes(A[..., -1, :, :], -1, -2)
    jacobian = np.zeros((*P.shape[:-2], 6, 6 + chain.dof))
    jacobian[..., :3, :3] = jacobian[..., 3:, 3:6] = to_last
    jacobian[..., :3, 3:6] = -to_last @ hat(P[..., -1, :])
    jacobian[..., 6:] = _joint_columns(chain, A, P)
    return jacobian


def _joint_columns(chain: Chain, A: Array, P: Array) -> Array:
    """^nJ_n: twist of link n at O_n in R_n for unit rates, shape (..., 6, n)."""
    axis = A[..., 1:, :, 2] * chain.sign[:, None]
    arm = P[..., -1:, :] - P[..., 1:, :]
    sigma = chain.joints.sigma[:, None]
    linear = sigma * axis + (1.0 - sigma) * times(hat(axis), arm)
    # Rows times A_n are columns in R_n.
    columns = np.concatenate(
        [linear @ A[..., -1, :, :], ((1.0 - sigma) * axis) @ A[..., -1, :, :]], axis=-1
    )
    return np.swapaxes(columns, -1, -2)


def impact(chain: Chain, q: ArrayLike, v_minus: ArrayLike) -> tuple[Array, Array]:
    """Return the velocity after the impact and the impulse, Eqs. (19) and (20).

    The former stance foot is free to leave the ground, I_0 = 0.

    Args:
        chain: the chain.
        q: joint values, shape (..., n) [rad, m].
        v_minus: V before the impact, shape (..., 6 + n) [m/s, rad/s].

    Returns:
        V after the impact, shape (..., 6 + n), and I13, the impulse of the swing foot ON THE
        GROUND about O_n in R_n (the paper's sign), shape (..., 6) [N·s, N·m·s].

    Raises:
        InputError: an argument has the wrong shape or is not finite, or a joint moves no mass.
    """
    before: Array = np.asarray(v_minus, dtype=np.float64)
    if before.shape[-1:] != (6 + chain.dof,) or not np.isfinite(before).all():
        raise InputError(
            f"v_minus has shape {before.shape}; give {6 + chain.dof} finite velocities: linear "
            "and angular velocity of link 0 in R0, then the joint rates"
        )
    D, D12_t = inertia_matrix(chain, q), swing_jacobian(chain, q)
    compliance = _solved(D, np.swapaxes(D12_t, -1, -2))
    I13 = _solved(D12_t @ compliance, times(D12_t, before)[..., None])[..., 0]
    return before - times(compliance, I13), I13


def _solved(matrix: Array, right: Array) -> Array:
    try:
        return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
    except np.linalg.LinAlgError as error:
        raise InputError(
            "the inertia matrix of the chain is singular: a joint moves no mass; give every link "
            "a mass and an inertia"
        ) from error


def impulse_on_foot(chain: Chain, I13: Array) -> Array:
    """Return the impulse of the ground on the landing foot in its sole frame, (..., 6).

    Args:
        chain: the chain.
        I13: as returned by `impact`, shape (..., 6) [N·s, N·m·s].
    """
    R = chain.tool_rotation
    force = I13[..., :3]
    moment = I13[..., 3:] - times(hat(np.broadcast_to(chain.tool_position, force.shape)), force)
    return -np.concatenate([force @ R, moment @ R], axis=-1)


def at_rest(chain: Chain, rate: ArrayLike) -> Array:
    """Return V for joint rates (..., n) while the stance foot stands still, Eq. (18)."""
    rate = np.asarray(rate, dtype=np.float64)
    return np.concatenate([np.zeros((*rate.shape[:-1], 6)), rate], axis=-1)


def base_in_sole_axes(velocity: Array) -> Array:
    """Turn the first six entries of V (..., 6 + n) from R0 into sole axes, or back."""
    return np.concatenate([sole_axes(velocity[..., :6]), velocity[..., 6:]], axis=-1)
