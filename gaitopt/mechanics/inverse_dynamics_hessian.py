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

from dataclasses import fields

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.mechanics import compiled
from gaitopt.mechanics.forward_kinematics import ForwardKinematics, pseudo_inertias
from gaitopt.mechanics.spatial import (
    cross_force_matrix,
    cross_motion,
    force_cross_matrix,
    joined,
    motion_cross_matrix,
    symmetric,
    world_inertias,
)
from gaitopt.model.coupling import CoupledMotion, Tangent
from gaitopt.model.joint_tree import JointTree
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array


@dataclass(frozen=True)
class WeightedDynamics:
    """What the second derivatives of lambda . tau at N instants depend on.

    tau is the ground wrench and the n torques, (N, 6 + n).

    Attributes:
        axes: S_j, shape (N, n, 6).
        posture, rate, acceleration: q, dq, ddq [rad, rad/s, rad/s²], shape (N, n).
        base_acceleration: a_0 [m/s², rad/s²], shape (N, 6); minus gravity for a foot at rest.
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
        pairs = ((getattr(self, one.name), getattr(other, one.name)) for one in fields(self))
        return WeightedDynamics(*map(np.concatenate, pairs))


@dataclass(frozen=True)
class InverseDynamicsHessian:
    """Second derivatives H of lambda . tau at N instants, shape (N, n, n) each.

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

    def through(self, motion: Array) -> Array:
        """Return the sum over the instants of M' H M, shape (P, P), M the motion's derivatives.

        Args:
            motion: those of (q, dq, ddq) in P parameters, shape (N, 3 n, P).
        """
        n, P = self.qq.shape[-1], motion.shape[-1]
        q, dq = motion[:, :n], motion[:, n : 2 * n]
        of_q = np.concatenate([self.qq, 2.0 * self.qv, 2.0 * self.qa], axis=2) @ motion
        found = q.reshape(-1, P).T @ of_q.reshape(-1, P)
        found += dq.reshape(-1, P).T @ (self.vv @ dq).reshape(-1, P)
        return np.asarray((found + found.T) / 2.0)

    def along(self, motion: Array) -> Array:
        """Return H times a change of (q, dq, ddq), shape (N, 3, n) of (N, 3, n)."""
        q, dq, ddq = motion.swapaxes(0, 1)[..., None]
        found = np.empty(motion.shape)
        found[:, 0] = (self.qq @ q + self.qv @ dq + self.qa @ ddq)[:, :, 0]
        found[:, 1] = (self.vv @ dq + self.qv.swapaxes(1, 2) @ q)[:, :, 0]
        found[:, 2] = (self.qa.swapaxes(1, 2) @ q)[:, :, 0]
        return found

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
        tables = self.qq, self.qv, self.vv, self.qa, self.base
        return InverseDynamicsHessian(*(table[instants] for table in tables))


class DynamicsHessian:
    """Second derivatives of the inverse dynamics of one robot, by kernels where they are built."""

    def __init__(self, robot: Robot) -> None:
        self._robot, self._tree = robot, robot.tree
        self._bodies = ForwardKinematics(robot.model)
        self._pseudo = pseudo_inertias(robot.model)[1:]

    def of(self, at: WeightedDynamics) -> InverseDynamicsHessian:
        """Return those of lambda . tau."""
        if compiled.in_use():
            motion, base = (at.posture, at.rate, at.acceleration), at.base_acceleration
            kernels = compiled.bodies_of(self._robot)
            found = kernels.inverse_dynamics_hessian(*motion, base, at.weights)
            return InverseDynamicsHessian(*found)
        placed = self._bodies.placed(at.posture)
        inertias = world_inertias(self._pseudo, placed.frames[1:])
        return inverse_dynamics_hessian(inertias, at, self._tree)


def inverse_dynamics_hessian(
    inertias: Array, at: WeightedDynamics, tree: JointTree
) -> InverseDynamicsHessian:
    """Return the second derivatives of lambda . tau.

    Components come first and the joints of all instants last, so that every product runs along all
    of them: two thirds of the time of stacks of small matrices (docs/decisions/speed.md).

    Args:
        inertias: world spatial inertias of the n moving bodies, shape (N, n, 6, 6).
        at: motion and lambda.
    """
    count, n = at.rate.shape
    S, own = _components_first(at.axes), _components_first(inertias)
    weights, rate = at.weights[:, 6:].ravel(), at.rate.ravel()
    onto = _matrices(_ON_FORCE, S)  # f -> S_j x* f, transposed y -> y x S_j
    steps = np.empty((2, 6, count * n))
    np.multiply(S, weights, out=steps[0])
    np.multiply(S, rate, out=steps[1])
    before = tree.sum_before(steps.reshape(2, 6, count, n))  # u and v of the body that j sits on
    before[0] += at.weights[:, :6].T[:, :, None]
    before = before.reshape(steps.shape)
    moving = np.empty((4, 6, count * n))
    S_, p, U, r = moving
    S_[:] = S
    U[:], p[:] = _apply(onto.swapaxes(0, 1), before)
    da = S * at.acceleration.ravel() + p * rate
    a_before = tree.sum_before(da.reshape(6, count, n))
    a_before += at.base_acceleration.T[:, :, None]
    a_before = a_before.reshape(da.shape)
    r[:] = _apply(onto.swapaxes(0, 1), a_before)
    r += _apply(_matrices(_ON_MOTION, before[1]), p)

    terms = _own_terms(own, before + steps, a_before + da)
    composites = tree.sum_beyond(terms.reshape(-1, count, n)).reshape(terms.shape)
    I, B, Z, forces, yB = _parts(composites)  # noqa: E741
    IS, Ip, IU, Ir = _apply(I, moving)
    BS, Bp = _apply(B, moving[:2, 3:])
    by_Z = _apply(Z, moving[:2, 3:])
    by_Z[:, 3:] += _apply(Z[:3].swapaxes(0, 1), moving[:2, :3])
    SyI, Sforce = _apply(onto, forces)
    alpha, alpha_v = Sforce + Ir + Bp, BS + 2.0 * Ip
    beta, beta_v = by_Z[1] + _apply(_matrices(_ON_FORCE, p), forces[0]), by_Z[0] + SyI
    beta[3:] += _apply(B.swapaxes(0, 1), U) + _apply(onto[3:, 3:], yB)
    gamma = IU + SyI

    SpUr = moving.reshape(24, count, n).swapaxes(0, 1)
    terms = _by_instant(count, beta, alpha, gamma, beta_v, alpha_v, IS)
    S, p, U = SpUr[:, :6], SpUr[:, 6:12], SpUr[:, 12:18]
    beta, gamma, beta_v = terms[:, :6], terms[:, 12:18], terms[:, 18:24]
    lower = _table(gamma, 2.0 * p)
    lower += _table(beta, S)
    return InverseDynamicsHessian(  # one table after the other, in the same memory
        qq=tree.symmetric(_table(SpUr[:, 6:], terms[:, :18])),
        qv=tree.joined(_table(SpUr[:, 6:18], terms[:, 18:30]), lower),
        vv=tree.symmetric(_table(S, beta_v)),
        qa=tree.joined(_table(U, terms[:, 30:]), _table(gamma, S)),
        base=gamma.swapaxes(1, 2),
    )


def _own_terms(inertia: Array, moved: Array, a: Array) -> Array:
    """Return I, 2 B, Z, yI, the force and yB of bodies moved by (u, v), see `_parts`, (87, N n).

    2 B y = -I (v x y) + y x* (I v) + v x* (I y), and Z is minus the change of I along u. With f the
    linear momentum along v, 2 B has no columns for the linear part of y and above -2 f x for the
    angular one. With f that along u, Z is 0 at the top left and has f x at the top right.
    """
    found = np.empty((87, a.shape[-1]))
    I, B, Z, forces, yB = _parts(found)  # noqa: E741
    I[:] = inertia
    u, v = moved
    forces[0], momentum = _apply(inertia, moved)
    np.add(_apply(inertia, a), _apply(_matrices(_ON_FORCE, v), momentum), out=forces[1])
    B[:], Z[:] = _matrices(_CORIOLIS, momentum), _matrices(_TURNED, forces[0])
    for changed, along in ((B, v), (Z, -u)):
        change = np.einsum("ikb,kjb->ijb", _matrices(_LEVER, along), inertia[:, 3:])
        changed[3:] += change
        changed[3:] += change.swapaxes(0, 1)
    yB[:] = _apply(B.swapaxes(0, 1), u)
    return found


def _parts(terms: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Return views of the terms of b bodies, shape (87, b).

    Returns:
        I (6, 6, b), the right halves of 2 B and Z (6, 3, b) each, yI and the force together
        (2, 6, b), and the angular part of yB (3, b), whose linear part is 0.
    """
    return (
        terms[:36].reshape(6, 6, -1),
        terms[36:54].reshape(6, 3, -1),
        terms[54:72].reshape(6, 3, -1),
        terms[72:84].reshape(2, 6, -1),
        terms[84:],
    )


def _constants(unit_matrices: Array) -> Array:
    """Return constants for `_matrices` from the matrices of the six unit vectors, (6, i, j)."""
    return np.ascontiguousarray(np.moveaxis(unit_matrices, 0, 2))


_ON_MOTION = _constants(motion_cross_matrix(np.eye(6)))
_ON_FORCE = _constants(force_cross_matrix(np.eye(6)))
_LEVER = _ON_FORCE[3:]
_RIGHT = _constants(cross_force_matrix(np.eye(6)))[:, 3:]
_CORIOLIS = np.concatenate([2.0 * _RIGHT[:3], _RIGHT[3:]])
_TURNED = np.concatenate([-_RIGHT[:3], np.zeros((3, 3, 6))])


def _matrices(constants: Array, vectors: Array) -> Array:
    """Return the matrices (i, j, b) that vectors (6, b) stand for."""
    return np.asarray((constants.reshape(-1, 6) @ vectors).reshape(*constants.shape[:2], -1))


def _apply(matrices: Array, vectors: Array) -> Array:
    """Return the products of matrices (i, j, b) with vectors (j, b), or several of them (k, j, b).

    Shape (i, b) or (k, i, b).
    """
    return np.asarray(np.einsum("ijb,...jb->...ib", matrices, vectors))


def _components_first(stack: Array) -> Array:
    """Return vectors or matrices (N, n, ...) with the joints of all instants last, (..., N n)."""
    count, n, *shape = stack.shape
    return np.ascontiguousarray(stack.reshape(count * n, -1).T).reshape(*shape, -1)


def _by_instant(count: int, *vectors: Array) -> Array:
    """Return vectors (6, N n) under each other, shape (N, 6 k, n)."""
    together = np.concatenate([one.reshape(6, count, -1) for one in vectors])
    return np.ascontiguousarray(together.swapaxes(0, 1))


def _table(of_q: Array, of_other: Array) -> Array:
    """Return the products of each row's joint's terms (N, k, n) with each column's, (N, n, n)."""
    return np.asarray(of_q.swapaxes(1, 2) @ of_other)


def moved_axes(axes: Array, rate: Array, base: Array) -> Array:
    """Return v_{k-1} x S_k of the joints of serial chains, shape (..., m, 6).

    Args:
        axes: S_j in order from the base, shape (m, 6).
        rate: joint rates [rad/s], shape (..., m).
        base: twist of the base, shape (..., 6).
    """
    velocity = base[..., None, :] + (axes * rate[..., None]).cumsum(axis=-2)
    return cross_motion(velocity, axes)  # to which joint k itself adds nothing


def velocity_hessian(axes: Array, moved: Array, force: Array) -> Array:
    """Return the second derivative in q of force . (end velocity in the end's own frame).

    The joints are those of a serial chain to the end body, in which the force is fixed. Seen from
    that body, turning joint j moves everything before it: the first derivative in q_k is
    force . (v_{k-1} x S_k), the second -force . (S_max x (v_{min-1} x S_min)).

    Args:
        axes: S_j in order from the base, shape (m, 6).
        moved: `moved_axes`, shape (..., m, 6).
        force: weights of the velocity, in the world at the current posture, shape (..., 6).

    Returns:
        Shape (..., m, m).
    """
    # -(S_max x y) . force = y . (S_max x* force)
    return symmetric(moved @ cross_force_matrix(force) @ axes.T)


def velocity_rate_hessian(axes: Array, force: Array) -> tuple[Array, Array]:
    """Return d²/dq d(rate) (m, m) and d²/dq d(base twist) (m, 6) of force . (end velocity).

    Args:
        axes, force: as for `velocity_hessian`.
    """
    # derivatives in q_k: force . (v_{k-1} x S_k) with v_{k-1} = base + sum_{i<k} S_i rate_i
    turned = axes @ cross_force_matrix(force).T  # force . (y x S_k) = (S_k x* force) . y
    return joined(np.zeros(1), turned @ axes.T), turned
