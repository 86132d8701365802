"""Closed-form second derivatives of inverse dynamics and of frame velocities for a tree of joints.

All in the world frame at the base, batched over instants. Body b carries joint b; S_j are the joint
motion axes; u, v, a are virtual, real and (gravity-included) accelerations of the bodies:

    u_b = u_0 + sum_{j<=b} S_j lambda_j      v_b = sum_{j<=b} S_j dq_j
    a_b = a_0 + sum_{j<=b} (S_j ddq_j + (v_{j-1} x S_j) dq_j)

where j <= b reads "joint j moves body b" and j - 1 is the body that joint j sits on.

By d'Alembert's principle lambda . tau = sum_b u_b . (I_b a_b + v_b x* I_b v_b). Turning joint j
turns all bodies beyond it, which gives every second derivative as products of one term of joint j
and one composite term of joint k >= j, over the bodies beyond it. Joints of different branches
move no body in common: their mixed derivatives vanish (derivation: docs/derivations.md).
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from gaitopt.mechanics.spatial import (
    apply,
    cross_force,
    cross_force_matrix,
    cross_motion,
    force_cross_matrix,
    motion_cross_matrix,
    symmetric,
)
from gaitopt.model.coupling import CoupledMotion, Tangent
from gaitopt.model.joint_tree import JointTree
from gaitopt.nlp import Array


@dataclass(frozen=True)
class WeightedDynamics:
    """What the second derivatives of lambda . tau at N instants depend on.

    tau is the ground wrench and the n torques, (N, 6 + n).

    Attributes:
        axes: S_j, shape (N, n, 6).
        posture, rate, acceleration: q, dq, ddq, shape (N, n).
        base_acceleration: a_0, shape (N, 6); minus gravity for a foot at rest.
        weights: lambda, shape (N, 6 + n).
    """

    axes: Array
    posture: Array
    rate: Array
    acceleration: Array
    base_acceleration: Array
    weights: Array

    def followed_by(self, other: WeightedDynamics) -> WeightedDynamics:
        """Return the instants of both."""
        names = [field.name for field in fields(self)]
        pairs = ((getattr(self, name), getattr(other, name)) for name in names)
        return WeightedDynamics(*map(np.concatenate, pairs))


@dataclass(frozen=True)
class InverseDynamicsHessian:
    """Second derivatives of lambda . tau at N instants, shape (N, n, n) each.

    Attributes:
        qq, vv: symmetric blocks.
        qv: rows q, columns dq.
        qa: rows q, columns ddq (the other blocks with ddq vanish).
        base: d²(lambda . tau) / d q d a_0, shape (N, n, 6).
    """

    qq: Array
    qv: Array
    vv: Array
    qa: Array
    base: Array

    def reduced(self, tangent: Tangent) -> InverseDynamicsHessian:
        """Return those in the free joints, as if S were the same in every posture."""
        if tangent.of.none:
            return self
        pairs = (self.qq, self.qv, self.vv, self.qa)
        qq, qv, vv, qa = map(tangent.reduced_twice, pairs)
        base = tangent.reduced(self.base.swapaxes(1, 2)).swapaxes(1, 2)
        return InverseDynamicsHessian(qq, qv, vv, qa, base)

    def bent(
        self, motion: CoupledMotion, effort: Array, by_motion: Array, weights: Array
    ) -> InverseDynamicsHessian:
        """Return those of weights . (base wrench, S' torque) in the free joints, where S changes.

        The weights of all joints' torques, S times those of the free ones, change with the posture,
        as do dq and ddq; `self` has them fixed.

        Args:
            motion: of the joints.
            effort: of all joints, shape (N, 6 + n).
            by_motion: its derivative in q, dq, ddq, shape (N, 6 + n, 3 n).
            weights: of wrench and free joints' torques, shape (N, 6 + m).
        """
        tangent, (P, Q, R) = motion.tangent, motion.parts
        F, second = tangent.matrix, motion.orders[2]
        m = F.shape[2]
        of_v, of_a = np.swapaxes(self.qv @ P + self.qa @ Q, 1, 2) @ F, self.qa @ R
        found = self.reduced(tangent)
        across = np.swapaxes(P, 1, 2) @ self.vv
        zz = found.qq + of_v + np.swapaxes(of_v, 1, 2) + across @ P
        zv = found.qv + across @ F + np.swapaxes(F, 1, 2) @ of_a
        on_joints = weights[:, 6:]
        bent = (second * on_joints[:, tangent.of.motor])[..., None] * tangent.of.member
        mixed = np.swapaxes(bent, 1, 2) @ motion.reduced(by_motion[:, 6:])
        z, v, a = (mixed[:, :, k * m : (k + 1) * m] for k in range(3))
        all_weights = tangent.velocity(weights)
        gradient = (all_weights[:, None] @ by_motion)[:, 0]
        own = motion.curvature(gradient, on_joints, effort[:, 6:])
        return InverseDynamicsHessian(
            qq=zz + z + np.swapaxes(z, 1, 2) + own[0],
            qv=zv + v + own[1],
            vv=found.vv + own[2],
            qa=found.qa + a + own[3],
            base=found.base,
        )

    def at(self, instants: slice) -> InverseDynamicsHessian:
        """Return some of the instants."""
        return InverseDynamicsHessian(
            *(getattr(self, field.name)[instants] for field in fields(self))
        )


def inverse_dynamics_hessian(
    inertias: Array, at: WeightedDynamics, tree: JointTree
) -> InverseDynamicsHessian:
    """Return the second derivatives of lambda . tau.

    Args:
        inertias: world spatial inertias of the n moving bodies, shape (N, n, 6, 6).
        at: motion and lambda.
        tree: of the joints.
    """
    axes, rate, (base_weights, weights) = at.axes, at.rate, np.split(at.weights, [6], axis=1)
    du, dv = axes * weights[:, :, None], axes * rate[:, :, None]
    u, v = base_weights[:, None] + tree.up_to(du), tree.up_to(dv)
    across = -motion_cross_matrix(axes)  # y -> y x S_j
    u_before, v_before = u - du, v - dv
    p, U = apply(across, v_before), apply(across, u_before)
    da = axes * at.acceleration[:, :, None] + p * rate[:, :, None]
    a = at.base_acceleration[:, None] + tree.up_to(da)
    r = apply(across, a - da) + cross_motion(v_before, p)

    own = _own_terms(inertias, u, v, a)
    I, B, Z, yI, yB, force = map(tree.beyond, own)  # noqa: E741
    onto = np.swapaxes(across, 2, 3)  # f -> S_j x* f
    IS, Ip, IU, Ir = _products(I, axes, p, U, r)
    BS, Bp = _products(B, axes, p)
    ZS, Zp = _products(Z, axes, p)
    SyI, Sforce, SyB = _products(onto, yI, force, yB)
    alpha, alpha_v = Sforce + Ir + Bp, BS + 2.0 * Ip
    beta, beta_v = apply(np.swapaxes(B, 2, 3), U) + Zp + cross_force(p, yI) + SyB, ZS + SyI
    gamma = IU + SyI

    qq = _table((U, p, r), (alpha, beta, gamma))
    qv, vq = _table((U, p), (alpha_v, beta_v)), _table((gamma, beta), (2.0 * p, axes))
    vv = _table((axes,), (beta_v,))
    qa, aq = _table((U,), (IS,)), _table((gamma,), (axes,))
    return InverseDynamicsHessian(
        qq=tree.symmetric(qq),
        qv=tree.joined(qv, vq),
        vv=tree.symmetric(vv),
        qa=tree.joined(qa, aq),
        base=gamma,
    )


def _own_terms(inertias: Array, u: Array, v: Array, a: Array) -> tuple[Array, ...]:
    """Return I, 2 B and Z (N, n, 6, 6), yI, yB and the force (N, n, 6) of each body.

    2 B y = -I (v x y) + y x* (I v) + v x* (I y), and Z is minus the change of I along u.
    """
    onto_v = force_cross_matrix(v)
    momentum = apply(inertias, v)
    C = onto_v @ inertias
    B = C + np.swapaxes(C, 2, 3) + cross_force_matrix(momentum)
    turn = -force_cross_matrix(u) @ inertias
    matrices = (inertias, B, turn + np.swapaxes(turn, 2, 3))
    force = apply(inertias, a) + apply(onto_v, momentum)
    forces = (apply(inertias, u), apply(np.swapaxes(B, 2, 3), u), force)
    return (*matrices, *forces)


def velocity_hessian(axes: Array, rate: Array, base: Array, force: Array) -> Array:
    """Return the second derivative in q of force . (end velocity in the end's own frame).

    The joints are those of a serial chain to the end body, in which the force is fixed. Seen from
    that body, turning joint j moves everything before it: the first derivative in q_k is
    force . (v_{k-1} x S_k), the second -force . (S_max x (v_{min-1} x S_min)).

    Args:
        axes: S_j in order from the base, shape (m, 6).
        rate: joint rates, shape (m,).
        base: twist of the base, shape (6,).
        force: in the world at the current posture, shape (6,).
    """
    before = base + np.cumsum(axes * rate[:, None], axis=0) - axes * rate[:, None]
    p = cross_motion(before, axes)
    turned = cross_force(axes, force)  # -(S_max x y) . force = (S_max x* force) . y
    return symmetric(p @ turned.T)


def velocity_rate_hessian(axes: Array, force: Array) -> tuple[Array, Array]:
    """Return d²/dq d(rate) (m, m) and d²/dq d(base twist) (m, 6) of force . (end velocity).

    Args:
        axes, force: as for `velocity_hessian`.
    """
    # derivatives in q_k: force . (v_{k-1} x S_k) with v_{k-1} = base + sum_{i<k} S_i rate_i
    turned = cross_force(axes, force)  # force . (y x S_k) = (S_k x* force) . y
    return np.tril(turned @ axes.T, -1), turned


def _products(matrices: Array, *vectors: Array) -> Array:
    """Products of each matrix (N, n, 6, 6) with its vectors (N, n, 6), as many (N, n, 6)."""
    return np.moveaxis(matrices @ np.stack(vectors, axis=3), 3, 0)


def _table(of_q: tuple[Array, ...], of_other: tuple[Array, ...]) -> Array:
    """Sum of the products of one term of each row's joint and one of each column's, (N, n, n)."""
    left, right = np.concatenate(of_q, axis=2), np.concatenate(of_other, axis=2)
    return np.asarray(left @ np.swapaxes(right, 1, 2))
