"""Motion with both feet on the ground: the swing leg follows the stance leg, exactly.

Two legs of six joints between two feet that rest are one closed chain: the stance leg moves as it
is told, u(t), and the swing leg is where its sole stays on its footprint. With S_j the joint axes
in the world, S_i x S_j their Lie brackets, and X(g) the footprint as the geometric quantities g
place it, for the m joints in their order from foot to foot

    X(q) = X(g),     sum_j S_j dq_j = 0,     sum_j S_j ddq_j + sum_{i<j} (S_i x S_j) dq_i dq_j = 0

give q, dq and ddq of the swing leg. Turning joint k moves the axes beyond it, d S_j / d q_k =
S_k x S_j for k < j, so that all derivatives are nested brackets in the order of the joints
(docs/derivations.md). No closure is left to constraints, at the instants or between them. Where the
rear foot turns about a line of its sole, that hinge is the first joint of the chain, and u begins
with its angle. Joints beyond the pelvis (waist, arms, head), e of them, are in no chain: they move
as they are told, after the stance leg's in u and after the legs' in q.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, UnreachableError
from gaitopt.mechanics.inverse_kinematics import LegKinematics
from gaitopt.mechanics.spatial import (
    apply,
    cross_force,
    force_cross_matrix,
    motion_cross_matrix,
    solve,
    symmetric,
)
from gaitopt.model.joint_tree import TWIST
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array

FREE = slice(TWIST)
"""Joints of the stance leg."""
TIED = slice(TWIST, 2 * TWIST)
"""Joints of the swing leg."""
LAST = slice(-TWIST, None)
"""The same in a chain with hinges of the rear foot, h of them, in front: the last of h + 12."""
_LEGS = 2 * TWIST  # joints of both
_LAST_STEP = 1e-12  # rad: Newton is quadratic, so the error left is rounding
_MOST = 30  # iterations
_LONGEST = 0.5  # rad, of an iteration


def refuse_open(robot: Robot) -> None:
    """Refuse a robot whose swing leg does not follow from its stance leg.

    Raises:
        InputError: its legs have other than six joints each, or joints follow others.
    """
    tree = robot.tree
    if not robot.coupling.none:
        raise InputError(
            "with both feet on the ground the swing leg must follow from the stance leg; joints of "
            "this robot follow others: leave out --double-support"
        )
    if (tree.stance, tree.swing) != (TWIST, TWIST):
        raise InputError(
            "with both feet on the ground the swing leg must follow from the stance leg, as with "
            f"legs of six joints; those of this robot have {tree.stance}: leave out "
            "--double-support"
        )


class ClosedChain:
    """Evaluates the motion of the closed chain of one robot."""

    def __init__(self, robot: Robot, standing: Robot | None = None) -> None:
        """Prepare what does not depend on the motion.

        Args:
            standing: the biped with hinges under its rear foot, if that turns.

        Raises:
            InputError: the swing leg does not follow from the stance leg.
        """
        refuse_open(robot)
        standing = standing or robot
        self._kinematics = LegKinematics(robot)
        self._model, self._data = standing.model, standing.model.createData()
        self._q, self._frame = pin.neutral(standing.model), standing.swing_frame
        self._hinges = standing.tree.size - robot.tree.size

    def motion(self, free: Array, sole: pin.SE3) -> tuple[Array, Array]:
        """Return the motion of all joints, (3, N, h + 12 + e), and the chain's axes in the world.

        Args:
            free: angles, rates and accelerations of the hinges, of the stance leg and of what is in
                no chain, shape (3, N, h + 6 + e).
            sole: placement of the swing sole in the footprint of the stance foot.

        Raises:
            UnreachableError: the swing leg does not reach its footprint.
        """
        count, m = free.shape[1], self._hinges + _LEGS
        others = free[:, :, m - TWIST :]
        free = free[:, :, : m - TWIST]
        found = np.zeros((3, count, m))
        found[:, :, :-TWIST] = free
        axes, near = np.empty((count, m, TWIST)), None
        for k in range(free.shape[1]):
            near, axes[k] = self._posture(free[0, k], sole, near)
            found[0, k] = near
        A, own = axes[:, LAST].swapaxes(1, 2), axes[:, :-TWIST]
        found[1, :, LAST] = -_solved(A, (own * free[1][..., None]).sum(axis=1))
        moved = (own * free[2][..., None]).sum(axis=1) + _bias(axes, found[1])
        found[2, :, LAST] = -_solved(A, moved)
        return np.concatenate([found, others], axis=2), axes

    def _posture(self, free: Array, sole: pin.SE3, near: Array | None) -> tuple[Array, Array]:
        """Angles (h + 12,) and axes (h + 12, 6), by Newton's method from a posture that is near."""
        model, data = self._model, self._data
        if near is None:
            near = self._near(free, sole)
        q = np.concatenate([free, near[LAST]])
        for _ in range(_MOST):
            self._q[7 : 7 + q.size] = q
            J = pin.computeJointJacobians(model, data, self._q)[:, TWIST : TWIST + q.size]
            at = pin.updateFramePlacement(model, data, self._frame)
            gap = pin.log6(sole * at.inverse()).vector
            step = solve(J[:, LAST], gap)
            largest = float(np.abs(step).max())
            if not np.isfinite(largest):
                break
            if largest < _LAST_STEP:
                return q, J.T.copy()
            q[LAST] += step * min(1.0, _LONGEST / largest)
        raise UnreachableError(
            "the rear leg or the front leg does not reach its footprint while both feet stand; "
            "make the double support or the step shorter"
        )

    def _near(self, free: Array, sole: pin.SE3) -> Array:
        """Angles (12,) by inverse kinematics, from where the hinges put the stance sole."""
        kinematics, h = self._kinematics, self._hinges
        start = np.zeros(kinematics.robot.tree.size)
        start[FREE] = free[h:]
        if h:  # where the first joint of the robot itself sits
            self._q[7:] = 0.0
            self._q[7 : 7 + free.size] = free
            pin.forwardKinematics(self._model, self._data, self._q)
            at = pin.updateFramePlacement(self._model, self._data, self._frame)
            sole = kinematics.placements(start)[1] * at.inverse() * sole
        return kinematics.solve(kinematics.placements(start)[0], sole)[: 2 * TWIST]


def _solved(matrices: Array, vectors: Array) -> Array:
    """Solve a stack of systems (..., 6, 6) for vectors (..., 6)."""
    try:
        return np.asarray(np.linalg.solve(matrices, vectors[..., None])[..., 0])
    except np.linalg.LinAlgError as error:
        raise UnreachableError(
            "a leg is singular (straight knee) while both feet stand; make the step shorter"
        ) from error


def _before(axes: Array, rates: Array) -> Array:
    """Sums of S_i rate_i over i < k, shape (N, m, 6)."""
    moved = axes * rates[..., None]
    return np.asarray(np.cumsum(moved, axis=1) - moved)


def _beyond(axes: Array, rates: Array) -> Array:
    """Sums of S_m rate_m over m > k, shape (N, m, 6)."""
    moved = axes * rates[..., None]
    return np.asarray(moved.sum(axis=1, keepdims=True) - np.cumsum(moved, axis=1))


def _bias(axes: Array, rates: Array) -> Array:
    """Sum over i < j of (S_i x S_j) dq_i dq_j, shape (N, 6)."""
    brackets = apply(motion_cross_matrix(_before(axes, rates)), axes)
    return np.asarray((brackets * rates[..., None]).sum(axis=1))


@dataclass(frozen=True)
class ClosedMotion:
    """The motion of a closed chain at N instants, for its derivatives.

    They are with respect to (u, du, ddu) of the f = h + 6 + e joints that are free and the G
    quantities that place the swing sole, shape (..., 3 f + G).

    Attributes:
        motion: angles, rates and accelerations, shape (3, N, h + 12 + e).
        axes: of the chain's joints in the world, shape (N, h + 12, 6).
        targets: axes of the displacements that place the swing sole, in the world, (k, 6).
        drive: from the quantities to the displacements, shape (k, G).
    """

    motion: Array
    axes: Array
    targets: Array
    drive: Array

    @cached_property
    def _slopes(self) -> tuple[Array, Array, Array]:
        """Derivatives of velocity and acceleration in (q, dq): V_q, A_q, A_dq, (N, 6, m) each."""
        axes, (_, dq, ddq) = self.axes, self._chain
        own, before = motion_cross_matrix(axes), motion_cross_matrix(_before(axes, dq))
        by_q = apply(own, _beyond(axes, dq))
        turned = by_q * dq[..., None]
        inward = turned.sum(axis=1, keepdims=True) - np.cumsum(turned, axis=1) + turned
        of_q = apply(own, _beyond(axes, ddq) + inward) + apply(before, by_q)
        of_dq = by_q + apply(before, axes)
        return by_q.swapaxes(1, 2), of_q.swapaxes(1, 2), of_dq.swapaxes(1, 2)

    @property
    def _chain(self) -> Array:
        """The motion of the chain's joints, shape (3, N, h + 12)."""
        return self.motion[:, :, : self.axes.shape[1]]

    @cached_property
    def _places(self) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
        """Where (q, dq, ddq) and (u, du, ddu, g) of the chain are in those of all joints."""
        (_, _, m), chain = self.motion.shape, self.axes.shape[1]
        rows = [order * m + np.arange(chain) for order in range(3)]
        f = m - TWIST
        columns = [order * f + np.arange(chain - TWIST) for order in range(3)]
        placed = 3 * f + np.arange(self.drive.shape[1])
        return np.concatenate(rows), np.concatenate([*columns, placed])

    @cached_property
    def jacobian(self) -> Array:
        """Derivatives of (q, dq, ddq), shape (N, 3 m, 3 f + G) of m = h + 12 + e joints."""
        (_, count, m), chain = self.motion.shape, self.axes.shape[1]
        if m == chain:
            return self._of_chain
        rows, columns = self._places
        f = m - TWIST
        found = np.zeros((count, 3 * m, 3 * f + self.drive.shape[1]))
        found[:, rows[:, None], columns] = self._of_chain
        others = np.arange(chain, m)
        for order in range(3):
            found[:, order * m + others, order * f + others - TWIST] = 1.0
        return found

    @cached_property
    def _of_chain(self) -> Array:
        """Those of the chain alone, shape (N, 3 (h + 12), 3 (h + 6) + G)."""
        count, n = self.axes.shape[:2]
        free = n - TWIST
        S = self.axes.swapaxes(1, 2)
        A, own = S[:, :, LAST], S[:, :, :free]
        V_q, A_q, A_dq = self._slopes
        found = np.zeros((count, 3 * n, 3 * free + self.drive.shape[1]))
        for order in range(3):
            rows = slice(n * order, n * order + free)
            found[:, rows, free * order : free * (order + 1)] = np.eye(free)
        q, dq, ddq = (found[:, n * order : n * (order + 1)] for order in range(3))
        target = np.zeros((TWIST, found.shape[2]))
        target[:, 3 * free :] = self.targets.T @ self.drive
        q[:, free:] = np.linalg.solve(A, target - own @ q[:, :free])
        dq[:, free:] = np.linalg.solve(A, -own @ dq[:, :free] - V_q @ q)
        ddq[:, free:] = np.linalg.solve(A, -own @ ddq[:, :free] - A_q @ q - A_dq @ dq)
        return found

    def hessian(self, weights: Array) -> Array:
        """Return the Hessian of sum(weights * (q, dq, ddq)), (N, 3 f + G, 3 f + G).

        With the forces l_0, l_1, l_2 that the weights of the tied joints are worth in the three
        equations, it is that of -l . (their left sides) along the motion.

        Args:
            weights: shape (N, 3 m); those of the free joints change nothing.
        """
        if self.motion.shape[2] > self.axes.shape[1]:
            rows, columns = self._places
            found = np.zeros((len(weights), *[self.jacobian.shape[2]] * 2))
            found[:, columns[:, None], columns] = self._chain_hessian(weights[:, rows])
            return found
        return self._chain_hessian(weights)

    def _chain_hessian(self, weights: Array) -> Array:
        n, (_, dq, ddq) = self.axes.shape[1], self._chain
        V_q, A_q, A_dq = self._slopes
        w = weights.reshape(-1, 3, n)[:, :, LAST]
        back = self.axes[:, LAST]  # A'
        l2 = _solved(back, -w[:, 2])
        l1 = _solved(back, -w[:, 1] - _vjp(l2, A_dq))
        l0 = _solved(back, -w[:, 0] - _vjp(l1, V_q) - _vjp(l2, A_q))
        local = np.zeros((len(w), 3 * n, 3 * n))
        own = [local[:, n * i : n * i + n, n * j : n * j + n] for i in range(3) for j in range(3)]
        qq, qv, qa, vq, vv, _, aq, _, _ = own
        zeroth, first, second = (Brackets(self.axes, force) for force in (l0, l1, l2))
        qq += 0.5 * _both(zeroth.pairs)  # what S' l_0 . ddq is along a line
        qq += first.ended(dq) + second.ended(ddq) + second.ended_twice(dq)
        qv += first.pairs + second.ended(dq) + second.begun(dq)
        vq += qv.swapaxes(1, 2)
        vv += _both(second.pairs)
        qa += second.pairs
        aq += second.pairs.swapaxes(1, 2)
        along = self._of_chain
        H = along.swapaxes(1, 2) @ local @ along
        count = len(w)
        targets = np.broadcast_to(self.targets, (count, *self.targets.shape))
        placed = 0.5 * _both(Brackets(targets, l0).pairs)
        quantities = slice(3 * (n - TWIST), None)
        H[:, quantities, quantities] -= self.drive.T @ placed @ self.drive
        return np.asarray(H)


def _vjp(force: Array, slopes: Array) -> Array:
    """Force . slopes of the tied joints, shape (N, 6)."""
    return np.asarray((force[:, None] @ slopes[:, :, LAST])[:, 0])


def _both(upper: Array) -> Array:
    """The symmetric matrix of a form given by its part above the diagonal (N, m, m)."""
    return np.asarray(upper + upper.swapaxes(1, 2))


class Brackets:
    """A force on nested brackets of axes, in the order of their joints.

    The derivatives of force . S_m in q_k, (q_k, q_i), (q_k, q_l, q_i) are force . (S_k x S_m),
    force . (S_a x (S_b x S_m)) with a <= b the sorted k and i, and so on, where m is beyond all of
    them; else 0. Summed with rates of joints they are products of sums over the axes before and
    beyond a joint, by (a x b) x c = a x (b x c) - b x (a x c).

    Args of the constructor:
        axes: in the world, shape (N, m, 6).
        force: a force [N, N·m], or weights of motions, shape (N, 6).
    """

    def __init__(self, axes: Array, force: Array) -> None:
        self._axes, self._force = axes, force
        self._across = motion_cross_matrix(axes)
        self._first = (force[:, None, None] @ self._across)[:, :, 0]  # force . (S_k x .)

    @cached_property
    def pairs(self) -> Array:
        """Of two axes, shape (N, m, m)."""
        return np.triu(self._first @ self._axes.swapaxes(1, 2), 1)

    def ended(self, rates: Array) -> Array:
        """Of three, the last summed with rates (N, m) [rad/s], shape (N, m, m), symmetric."""
        inner = apply(self._across, _beyond(self._axes, rates))
        return symmetric(self._first @ inner.swapaxes(1, 2))

    def begun(self, rates: Array) -> Array:
        """Of three, one before the last summed with rates (N, m) [rad/s], shape (N, m, m)."""
        before = motion_cross_matrix(_before(self._axes, rates))
        inner = apply(before, self._axes)
        both = self._turned(inner) @ self._axes.swapaxes(1, 2)
        return np.triu(both + self._first @ inner.swapaxes(1, 2), 1)

    def ended_twice(self, rates: Array) -> Array:
        """Of four, the last and one before it summed with rates [rad/s]; as `ended`, (N, m, m)."""
        before = _before(self._axes, rates)
        inner = apply(self._across, _beyond(self._axes, rates))
        until = motion_cross_matrix(before + self._axes * rates[..., None])
        outer = apply(until, inner) + apply(self._across, _beyond(inner, rates))
        turned = self._turned(apply(motion_cross_matrix(before), self._axes))
        return symmetric(turned @ inner.swapaxes(1, 2) + self._first @ outer.swapaxes(1, 2))

    def _turned(self, inner: Array) -> Array:
        """Return force . (inner x .), shape (N, m, 6)."""
        return np.asarray((self._force[:, None, None] @ motion_cross_matrix(inner))[:, :, 0])


@dataclass(frozen=True)
class FrontFoot:
    """What a front foot that stands takes off wrench and torques at M instants.

    Attributes:
        sole: placement of its sole in that of the rear foot.
        closed: the chain.
        wrench: of the ground on it, in its sole frame [N, N·m], shape (M, 6).
    """

    sole: pin.SE3
    closed: ClosedMotion
    wrench: Array

    @cached_property
    def force(self) -> Array:
        """The wrench in the frame of the rear sole [N, N·m], shape (M, 6)."""
        return np.asarray(self.wrench @ self.sole.toDualActionMatrix().T)

    def _in_x(self, geometry: Array, by_x: Array) -> tuple[Array, Array, Array]:
        """Derivatives of `force` in g (M, 6, G) and in itself (6, 6); and in x, (M, 6, P)."""
        targets = self.closed.targets
        by_amount = np.zeros((*self.force.shape, len(targets)))
        for k, target in enumerate(targets):
            by_amount[:, :, k] = cross_force(np.broadcast_to(target, self.force.shape), self.force)
        by_geometry = by_amount @ self.closed.drive
        by_wrench = np.asarray(self.sole.toDualActionMatrix())
        return by_geometry, by_wrench, by_geometry @ geometry + by_wrench @ by_x

    def jacobian(self, angles: Array, geometry: Array, by_x: Array) -> Array:
        """Return the derivatives of what it takes off wrench and torques, (M, 6 + n, P).

        Args:
            angles, geometry, by_x: derivatives of the angles (M, n, P), of the quantities (G, P)
                and of the wrench (M, 6, P).
        """
        axes, force = self.closed.axes, self.force
        *_, in_world = self._in_x(geometry, by_x)
        moments = Brackets(axes, force).pairs.swapaxes(1, 2)
        return np.concatenate([in_world, axes @ in_world + moments @ angles], axis=1)

    def hessian(
        self, angles: Array, geometry: Array, by_x: Array, weights: Array
    ) -> tuple[Array, Array]:
        """Return gradient in the angles (M, n) and Hessian in x of weights . (what it takes off).

        Of weights e, c = e_W + sum_j e_j S_j is a motion, and the sum is c . W(g, w).

        Args:
            angles, geometry, by_x: as of `jacobian`.
            weights: of wrench and torques, shape (M, 6 + n).
        """
        axes, targets, force = self.closed.axes, self.closed.targets, self.force
        e = weights[:, TWIST:]
        bent = Brackets(axes, force).ended(e)  # in the angles
        c = weights[:, :TWIST] + (e[..., None] * axes).sum(axis=1)
        # d c / d q_k = S_k x sum over m > k of e_m S_m
        of_c = apply(motion_cross_matrix(axes), _beyond(axes, e))  # (M, n, 6)
        _, by_wrench, in_world = self._in_x(geometry, by_x)
        mixed = angles.swapaxes(1, 2) @ (of_c @ in_world)
        H = (angles.swapaxes(1, 2) @ (bent @ angles) + mixed + mixed.swapaxes(1, 2)).sum(axis=0)
        across = force_cross_matrix(targets)  # (k, 6, 6)
        drive, count = self.closed.drive, len(targets)
        for a in range(count):
            row = c @ across[a]  # c . (G_a x* .)
            turned = (row[:, None] @ (by_wrench @ by_x))[:, 0].sum(axis=0)
            both = np.outer(drive[a] @ geometry, turned)
            H += both + both.T
            for b in range(a, count):
                value = float(np.sum(row * (force @ across[b].T)))
                pair = value * np.outer(drive[a] @ geometry, drive[b] @ geometry)
                H += pair if a == b else pair + pair.T
        return (of_c @ force[..., None])[..., 0], np.asarray(H)
