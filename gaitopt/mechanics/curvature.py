"""Closed-form second derivatives of inverse dynamics and of frame velocities for a serial chain.

All in the world frame at the base, batched over instants. Body b carries joint b; S_j are the joint
motion axes; u, v, a are virtual, real and (gravity-included) accelerations of the bodies:

    u_b = u_0 + sum_{j<=b} S_j lambda_j      v_b = sum_{j<=b} S_j dq_j
    a_b = a_0 + sum_{j<=b} (S_j ddq_j + (v_{j-1} x S_j) dq_j)

By d'Alembert's principle lambda . tau = sum_b u_b . (I_b a_b + v_b x* I_b v_b). Turning joint j
turns all bodies beyond it, which gives every second derivative as products of one term of joint j
and one composite term of joint k >= j (derivation: docs/derivations.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitopt.mechanics.spatial import apply, cross_force, force_cross, motion_cross, moved, pushed
from gaitopt.nlp import Array

_OUTWARD = np.tril(np.ones((12, 12)))  # a product with it sums along the chain


@dataclass(frozen=True)
class TorqueCurvature:
    """Second derivatives of lambda . tau at N instants, shape (N, 12, 12) each.

    Attributes:
        qq, vv: symmetric blocks.
        qv: rows q, columns dq.
        qa: rows q, columns ddq (the other blocks with ddq vanish).
        base: d²(lambda . tau) / d q d a_0, shape (N, 12, 6).
    """

    qq: Array
    qv: Array
    vv: Array
    qa: Array
    base: Array


def torque_curvature(
    axes: Array,
    inertias: Array,
    rate: Array,
    acceleration: Array,
    base_acceleration: Array,
    weights: Array,
    base_weights: Array,
) -> TorqueCurvature:
    """Return the second derivatives of base_weights . wrench + weights . torque.

    Args:
        axes: S_j, shape (N, 12, 6).
        inertias: world spatial inertias of the twelve moving bodies, shape (N, 12, 6, 6).
        rate, acceleration: dq, ddq, shape (N, 12).
        base_acceleration: a_0, shape (6,) or (N, 6); minus gravity for a foot at rest.
        weights: lambda of the torques, shape (N, 12).
        base_weights: lambda of the ground wrench, shape (N, 6).
    """
    du, dv = axes * weights[:, :, None], axes * rate[:, :, None]
    u, v = base_weights[:, None] + _up_to(du), _up_to(dv)
    p = moved(v - dv, axes)
    da = axes * acceleration[:, :, None] + p * rate[:, :, None]
    base = np.broadcast_to(base_acceleration, (axes.shape[0], 6))
    a = base[:, None] + _up_to(da)
    U = moved(u - du, axes)
    r = moved(a - da, axes) + moved(v - dv, p)

    # Per body, then summed over the bodies beyond each joint.
    I = inertias  # noqa: E741
    momentum = apply(I, v)
    C = force_cross(v) @ I  # 2 B y = -I (v x y) + y x* (I v) + v x* (I y)
    twice_B = C + np.swapaxes(C, 2, 3) + cross_force(momentum)
    turn = np.swapaxes(motion_cross(u), 2, 3) @ I
    Z = _beyond(turn + np.swapaxes(turn, 2, 3))
    yI = _beyond(apply(I, u))
    yB = _beyond(apply(np.swapaxes(twice_B, 2, 3), u))
    force = _beyond(apply(I, a) + pushed(v, momentum))
    inertia, coriolis = _beyond(I), _beyond(twice_B)

    IS = apply(inertia, axes)
    SyI = pushed(axes, yI)
    alpha = pushed(axes, force) + apply(inertia, r) + apply(coriolis, p)
    alpha_v = apply(coriolis, axes) + 2.0 * apply(inertia, p)
    beta = apply(np.swapaxes(coriolis, 2, 3), U) + apply(Z, p) + pushed(p, yI) + pushed(axes, yB)
    beta_v = apply(Z, axes) + SyI
    gamma = apply(inertia, U) + SyI

    left = np.concatenate([U, p, r], axis=2)
    qq = left @ _columns(alpha, beta, gamma)
    qv_lower_q = left[:, :, :12] @ _columns(alpha_v, beta_v)
    vq = np.concatenate([2.0 * p, axes], axis=2) @ _columns(gamma, beta)
    vv = axes @ np.swapaxes(beta_v, 1, 2)
    qa = U @ np.swapaxes(IS, 1, 2)
    aq = axes @ np.swapaxes(gamma, 1, 2)
    return TorqueCurvature(
        qq=_symmetric(qq),
        qv=np.triu(qv_lower_q) + np.swapaxes(np.triu(vq, 1), 1, 2),
        vv=_symmetric(vv),
        qa=np.triu(qa) + np.swapaxes(np.triu(aq, 1), 1, 2),
        base=gamma,
    )


def velocity_curvature(axes: Array, rate: Array, base: Array, force: Array) -> Array:
    """Return the second derivative in q of force . (end velocity in the end's own frame).

    The force is fixed in the end body. Seen from that body, turning joint j moves everything
    before it: the slope in q_k is force . (v_{k-1} x S_k), the curvature
    -force . (S_max x (v_{min-1} x S_min)).

    Args:
        axes: S_j, shape (12, 6).
        rate: joint rates, shape (12,).
        base: twist of the base, shape (6,).
        force: in the world at the current posture, shape (6,).
    """
    before = base + np.cumsum(axes * rate[:, None], axis=0) - axes * rate[:, None]
    p = moved(before, axes)
    turned = pushed(axes, force)  # -(S_max x y) . force = (S_max x* force) . y
    lower = np.tril(turned @ p.T)
    return lower + np.tril(lower, -1).T


def velocity_rate_slope(axes: Array, force: Array) -> tuple[Array, Array]:
    """Return d²/dq d(rate) (12, 12) and d²/dq d(base twist) (12, 6) of force . (end velocity).

    Args:
        axes, force: as for `velocity_curvature`.
    """
    # slope in q_k: force . (v_{k-1} x S_k) with v_{k-1} = base + sum_{i<k} S_i rate_i
    turned = pushed(axes, force)  # force . (y x S_k) = (S_k x* force) . y
    return np.tril(turned @ axes.T, -1), turned


def _up_to(per_body: Array) -> Array:
    """Sum over the joints from the base to each body, shape (N, 12, ...)."""
    return _OUTWARD @ per_body


def _beyond(per_body: Array) -> Array:
    """Sum over the bodies from each joint to the end of the chain, shape (N, 12, ...)."""
    flat = per_body.reshape(*per_body.shape[:2], -1)
    return (_OUTWARD.T @ flat).reshape(per_body.shape)


def _columns(*parts: Array) -> Array:
    return np.swapaxes(np.concatenate(parts, axis=2), 1, 2)


def _symmetric(upper: Array) -> Array:
    return np.triu(upper) + np.swapaxes(np.triu(upper, 1), 1, 2)
