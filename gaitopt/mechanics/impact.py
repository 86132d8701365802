"""The impact that swaps the legs, Eqs. (14)-(20), its exact derivatives and its Hessian.

The landing sole stops at once, flat on the ground; the old stance foot is free to leave:

    [ D  -J' ] [ V+ ]   [ D V- ]
    [ J   0  ] [ I  ] = [  0   ]

A foot that lands on a line of its sole, of unit twist t in its frame, keeps turning about it, at a
rate w that is one more unknown, and the ground gives no moment about it:

    [ D  -J'  0 ] [ V+ ]   [ D V- ]
    [ J   0  -t ] [ I  ] = [  0   ]
    [ 0   t'  0 ] [ w  ]   [  0   ]

with V = (twist of the old stance sole, n joint rates), J the Jacobian of the landing sole in its
own frame (D12' of Eq. 24 at the sole) and I the impulse of the ground on the landing foot, upward
positive (-I13 of the paper). First derivatives: Eqs. (58)-(62); second ones: docs/derivations.md.

Another impact is that by which a foot that turned about a line of its sole comes to lie flat on the
ground (`FlatImpact`). The foot turns about its hinge, of unit twist t in the sole frame, at a rate
w, the other one swings; then the whole sole meets the ground and stays on it. The ground acts on
that foot alone and no joint gives an impulse, so that with D the inertia matrix, whose rows and
columns of the joints are M,

    D [ -w t; dq+ - dq- ] = [ I; 0 ]

an inverse dynamics without gravity and rates, whose acceleration is the jump: M (dq+ - dq-) =
w D_joints,base t, and I, the impulse on the foot, is what its base takes. Of the two outcomes of
section 2.4.1 it is the one in which all that meets the ground stays on it, and possible where I can
be: it pushes, within its friction cone, through a point of the sole. Derivatives are those of the
inverse dynamics (docs/derivations.md, 5.6).

After the second outcome of an impact, section 2.4.1, both feet stay on the ground: the swing foot
lands flat and the rear foot stays flat. No joint gives an impulse, so that with F the impulse of
the ground on the landing foot, in the world, and D the inertia matrix, whose rows and columns of
the joints are M,

    M (dq+ - dq-) = S . F,       I_rear = D_0 (dq+ - dq-) - F

and the rates after it close the chain of both legs (`ClosedImpact`). Given F nothing is left to be
solved for but the jump: F is a parameter, and the rates before follow from those after. Derivatives
are those of an inverse dynamics without gravity and rates, whose acceleration is the jump, less
what F does (docs/derivations.md).
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin
from eigenpy import PartialPivLU

from gaitopt.contact import Hinge
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.mechanics import compiled
from gaitopt.mechanics.inverse_dynamics_hessian import (
    DynamicsHessian,
    InverseDynamicsHessian,
    WeightedDynamics,
    moved_axes,
    velocity_hessian,
    velocity_rate_hessian,
)
from gaitopt.mechanics.spatial import solve
from gaitopt.model.coupling import Tangent
from gaitopt.model.joint_tree import TWIST, JointTree
from gaitopt.model.robot import Robot, cached_workspace
from gaitopt.nlp import Array

if TYPE_CHECKING:
    from gaitopt.mechanics import kernels

BASE = 6
"""Entries of V and of I that belong to a foot."""


@dataclass(frozen=True)
class ImpactState:
    """The robot just after the impact.

    Attributes:
        velocity: V+: linear and angular velocity of the old stance sole in its frame
            [m/s, rad/s], then the joint rates [rad/s], shape (6 + n,).
        impulse: of the ground on the landing foot, force then moment, in the landing sole frame
            [N.s, N.m.s], shape (6,).
        turn_rate: w, about the line on which the foot landed [rad/s]; 0 where it landed flat.
    """

    velocity: Array
    impulse: Array
    turn_rate: float = 0.0

    @property
    def sole_twist(self) -> Array:
        """Twist of the old stance sole in its own frame, shape (6,)."""
        return self.velocity[:BASE]

    @property
    def rate_after(self) -> Array:
        """Joint rates after the impact [rad/s], shape (n,)."""
        return self.velocity[BASE:]


@dataclass(frozen=True)
class ImpactDerivatives:
    """Derivatives of (V+, I) [SI], 12 + n rows; with w 13 + n where the foot lands on a line.

    Attributes:
        inputs: in the joint angles at the impact, the joint rates before it and, where the old
            stance sole moves before, its twist, side by side, shape (rows, 2 n) or (rows, 2 n + 6).
        free: n.
        kkt, inverse: the matrix K of the linear system and its inverse, shape (rows, rows).
        axes: of all joints in the world, shape (all, 6).
        frame: of the landing sole: its axes by rows, then its origin [m], shape (4, 3).
        bent: what joints add that follow others by a bend; None where there are none.
    """

    inputs: Array
    free: int
    kkt: Array
    inverse: Array
    axes: Array
    frame: Array
    bent: BentImpact | None = None

    @property
    def posture(self) -> Array:
        """With respect to the joint angles at the impact, shape (rows, n)."""
        return self.inputs[:, : self.free]

    @property
    def rate(self) -> Array:
        """With respect to the joint rates before the impact, shape (rows, n)."""
        return self.inputs[:, self.free : 2 * self.free]

    @property
    def sole(self) -> Array:
        """With respect to the old stance sole's twist before it, (rows, 6); (rows, 0) at rest."""
        return self.inputs[:, 2 * self.free :]

    def adjoint(self, weights: Array) -> Array:
        """Return l with K' l = -weights, shape (rows,).

        One step of refinement: second derivatives are as good as this equation holds.
        """
        found = -weights @ self.inverse
        return np.asarray(found - (weights + found @ self.kkt) @ self.inverse)


@dataclass(frozen=True)
class BentImpact:
    """An impact of all joints, for the part of its derivatives in which S itself changes.

    Attributes:
        D: inertia matrix, shape (6 + all, 6 + all).
        J: Jacobian of the landing sole, shape (6, 6 + all).
        residual: D (V+ - V-) - J' I, shape (6 + all,), of which S' leaves nothing.
        momentum: its derivative in the angles, shape (6 + all, all).
        landing: derivative of J V+ in the angles, shape (6, all).
        orders: f and its derivatives up to the fourth, shape (5, all).
        jump: of the free joints' rates, shape (n,).
    """

    D: Array
    J: Array
    residual: Array
    momentum: Array
    landing: Array
    orders: Array
    jump: Array


@dataclass(frozen=True)
class LockedImpact:
    """The other outcome of section 2.4.1: both feet stay on the ground.

    Attributes:
        velocity: V+ [m/s, rad/s], shape (6 + n,); the first six entries are zero, or a turn
            about the line on which the rear foot stands.
        impulse_landing, impulse_rear: ground on foot, in the frame of its footprint, shape (6,).
    """

    velocity: Array
    impulse_landing: Array
    impulse_rear: Array

    @property
    def valid(self) -> bool:
        """Whether the ground only pushes: both vertical impulses are upward."""
        return bool(self.impulse_landing[2] >= 0.0 and self.impulse_rear[2] >= 0.0)


@dataclass(frozen=True)
class Turning:
    """A stance foot that turns about a line of its sole.

    Attributes:
        hinge: the line.
        angle: from flat [rad].
        rate: [rad/s].
    """

    hinge: Hinge
    angle: float
    rate: float

    @property
    def twist(self) -> Array:
        """Of the sole, in its frame, shape (6,)."""
        return self.rate * self.hinge.twist

    @property
    def place(self) -> pin.SE3:
        """Placement of the sole in the frame of its footprint."""
        return pin.exp6(self.angle * self.hinge.twist)

    @property
    def on_ground(self) -> Array:
        """Matrix that takes forces from the sole's frame to that of its footprint, (6, 6)."""
        return np.asarray(self.place.toDualActionMatrix())


def held_rows(hinge: Hinge) -> Array:
    """Return rows of a sole's twist that a line keeps at zero, in the sole frame, (5, 6)."""
    return np.asarray(np.linalg.svd(hinge.twist[None])[2][1:])


class Impact(compiled.MadeAnew):
    """Evaluates the impact of one robot and its derivatives."""

    def __init__(self, robot: Robot, landing: Hinge | None = None) -> None:
        """Prepare what does not depend on the posture.

        Args:
            robot: rooted at its old stance sole.
            landing: line of the sole on which the foot lands; None: it lands flat.
        """
        self.robot, self.landing = robot, landing
        self._weightless = robot.model.copy()
        self._weightless.gravity = pin.Motion.Zero()
        self._data = self._weightless.createData()
        self._frame = robot.swing_frame
        foot = robot.model.frames[self._frame]
        self._last = foot.parentJoint
        self._to_last = foot.placement
        self._q = pin.neutral(robot.model)
        self._forces = pin.StdVec_Force()
        self._forces.extend([pin.Force.Zero()] * robot.model.njoints)
        self._coupling = robot.coupling
        self._nv = BASE + len(robot.joint_names)

    @cached_property
    def _compiled(self) -> kernels.Landing | None:
        line = None if self.landing is None else self.landing.twist
        affine = compiled.BUILT and self._coupling.affine
        return compiled.landing_of(self.robot, line) if affine else None

    @property
    def _kernel(self) -> kernels.Landing | None:
        """What computes; None: the plain path."""
        return self._compiled if compiled.in_use() else None

    def _configuration(self, posture: Array) -> Array:
        self._q[BASE + 1 :] = self._coupling.angles(posture)
        q: Array = self._q
        return q

    def _matrices(self, posture: Array) -> tuple[Array, Array]:
        """Inertia matrix D (6 + n, 6 + n) and landing Jacobian J (6, 6 + n) at a posture."""
        D, J = self._of_all(posture)
        tangent = self._coupling.at(posture)
        return tangent.effort(tangent.effort(D).T).T, tangent.effort(J)

    def _of_all(self, posture: Array) -> tuple[Array, Array]:
        """Those of all joints, (6 + all, 6 + all) and (6, 6 + all)."""
        q = self._configuration(posture)
        D = np.array(pin.crba(self._weightless, self._data, q))
        J = pin.computeFrameJacobian(self._weightless, self._data, q, self._frame, pin.LOCAL)
        return D, J

    def _kkt(self, D: Array, J: Array) -> Array:
        nv, stop = self._nv, self._nv + BASE
        K = np.zeros((self._size, self._size))
        K[:nv, :nv] = D
        K[:nv, nv:stop] = -J.T
        K[nv:stop, :nv] = J
        if self.landing is not None:
            K[nv:stop, stop], K[stop, nv:stop] = -self.landing.twist, self.landing.twist
        return K

    @property
    def _size(self) -> int:
        """Unknowns: V+, I and, on a line, w."""
        return int(self._nv) + BASE + (self.landing is not None)

    def _state(self, y: Array) -> ImpactState:
        turn_rate = 0.0 if self.landing is None else float(y[-1])
        return ImpactState(y[: self._nv], y[self._nv : self._nv + BASE], turn_rate)

    def state(
        self, posture: Array, rate_before: Array, sole_before: Array | None = None
    ) -> ImpactState:
        """Return the state after the impact, Eqs. (19)-(20).

        Args:
            posture: joint angles at the impact [rad], shape (n,).
            rate_before: joint rates before it [rad/s], shape (n,).
            sole_before: twist of the stance sole before it, in its frame, shape (6,); None at rest.
        """
        if (kernel := self._kernel) is not None:
            angles = self._coupling.angles(posture)
            return self._state(kernel.impact(angles, rate_before, sole_before, False)[0])
        D, J = self._matrices(posture)
        rhs = np.zeros(self._size)
        rhs[: self._nv] = _momentum(D, rate_before, sole_before)
        return self._state(solve(self._kkt(D, J), rhs))

    def derivatives(
        self, posture: Array, rate_before: Array, sole_before: Array | None = None
    ) -> tuple[ImpactState, ImpactDerivatives]:
        """Return the state and its exact derivatives, Eqs. (58)-(62); arguments as of `state`."""
        if (kernel := self._kernel) is not None:
            angles, n = self._coupling.angles(posture), len(posture)
            found = kernel.impact(angles, rate_before, sole_before, True)
            y, inputs, kkt, inverse, axes, frame = found
            return self._state(y), ImpactDerivatives(inputs, n, kkt, inverse, axes, frame)
        D, J = self._matrices(posture)
        nv, n, kkt, rhs = self._nv, len(posture), self._kkt(D, J), np.zeros(self._size)
        factors = PartialPivLU(kkt)
        inverse = factors.inverse()
        rhs[:nv] = _momentum(D, rate_before, sole_before)
        state = self._state(solve(factors, rhs))
        sides = np.zeros((nv + BASE, 2 * n + (0 if sole_before is None else BASE)))
        bent = self._bent(posture, rate_before, sole_before, state)
        momentum, landing = self._residual_jacobians(posture, rate_before, sole_before, state, bent)
        sides[:nv, :n], sides[nv:, :n] = -momentum, -landing
        sides[:nv, n : 2 * n] = D[:, BASE:]
        if sole_before is not None:
            sides[:nv, 2 * n :] = D[:, :BASE]
        foot, axes = self._data.oMi[self._last] * self._to_last, self._data.J[:, BASE:].T.copy()
        frame = np.concatenate([foot.rotation, foot.translation[None]])
        inputs = inverse[:, : nv + BASE] @ sides
        return state, ImpactDerivatives(inputs, n, kkt, inverse, axes, frame, bent)

    def _bent(
        self, posture: Array, rate_before: Array, sole_before: Array | None, state: ImpactState
    ) -> BentImpact | None:
        """What S changes with the posture; None where ties are affine."""
        if self._coupling.affine:
            return None
        D, J = self._of_all(posture)
        tangent = self._coupling.at(posture)
        jump = _jump(state, rate_before, sole_before)
        residual = D @ tangent.velocity(jump) - J.T @ state.impulse
        momentum, landing = self._by_posture(posture, jump, state)
        orders = self._coupling.orders(posture)
        return BentImpact(D, J, residual, momentum, landing, orders, jump[BASE:])

    def _residual_jacobians(
        self,
        posture: Array,
        rate_before: Array,
        sole_before: Array | None,
        state: ImpactState,
        bent: BentImpact | None,
    ) -> tuple[Array, Array]:
        """Derivatives of D (V+ - V-) - J' I and of J V+ with respect to the posture alone."""
        tangent = self._coupling.at(posture)
        if bent is None:
            jump = _jump(state, rate_before, sole_before)
            momentum, landing = self._by_posture(posture, jump, state)
            by_joints = tangent.reduced(momentum)
            return tangent.effort(by_joints.T).T, tangent.reduced(landing)
        member, motor, second = self._coupling.member, self._coupling.motor, bent.orders[2]
        by_joints = tangent.reduced(bent.momentum)
        by_joints += (bent.D[:, BASE:] * (second * bent.jump[motor])) @ member
        momentum = tangent.effort(by_joints.T).T
        momentum[BASE:] += self._coupling.diagonal(second * bent.residual[BASE:])
        landing = tangent.reduced(bent.landing)
        landing += (bent.J[:, BASE:] * (second * state.rate_after[motor])) @ member
        return momentum, landing

    def _by_posture(self, posture: Array, jump: Array, state: ImpactState) -> tuple[Array, Array]:
        """Derivatives of D (V+ - V-) - J' I and of J V+ in the angles of all joints, these fixed.

        The first is an inverse dynamics without gravity and velocity whose acceleration is the
        jump of velocity and whose external force is the impulse (Eq. 59 without forming dD).
        """
        q, tangent = self._configuration(posture), self._coupling.at(posture)
        self._forces[self._last] = self._to_last.act(pin.Force(state.impulse))
        rest, jump = np.zeros(self._weightless.nv), tangent.velocity(jump)
        pin.computeRNEADerivatives(self._weightless, self._data, q, rest, jump, self._forces)
        momentum = self._data.dtau_dq[:, BASE:].copy()
        pin.computeForwardKinematicsDerivatives(
            self._weightless, self._data, q, tangent.velocity(state.velocity), rest
        )
        landing, _ = pin.getFrameVelocityDerivatives(
            self._weightless, self._data, self._frame, pin.LOCAL
        )
        return momentum, np.asarray(landing[:, BASE:])

    def locked(
        self,
        posture: Array,
        rate_before: Array,
        turning: Turning | None = None,
        landed: Turning | None = None,
    ) -> LockedImpact:
        """Return the outcome in which both feet stay on the ground (section 2.4.1, case two).

        Args:
            posture, rate_before: as of `state`.
            turning: how the rear foot turns about its line, on which it then stays; None: flat.
            landed: the landing foot on its line; None: flat.
        """
        D, J = self._matrices(posture)
        nv, sole, held = self._nv, None, np.eye(BASE)
        stops = np.eye(BASE) if self.landing is None else held_rows(self.landing)
        if turning is not None:
            sole, held = turning.twist, held_rows(turning.hinge)
        both = np.vstack([np.pad(held, ((0, 0), (0, nv - BASE))), stops @ J])
        K = np.block([[D, -both.T], [both, np.zeros((len(both), len(both)))]])
        rhs = np.concatenate([_momentum(D, rate_before, sole), np.zeros(len(both))])
        y = solve(K, rhs)
        velocity = y[:nv].copy()
        if turning is None:
            velocity[:BASE] = 0.0
        rear = held.T @ y[nv : nv + len(held)]
        if turning is not None:
            rear = turning.place.act(pin.Force(rear)).vector
        push = stops.T @ y[nv + len(held) :]
        if landed is not None:
            push = landed.on_ground @ push
        return LockedImpact(velocity, push, rear)

    def weighted(
        self,
        posture: Array,
        rate_before: Array,
        state: ImpactState,
        derivatives: ImpactDerivatives,
        weights: Array,
        sole_before: Array | None = None,
    ) -> WeightedImpact:
        """Return weights . (V+, I), whose Hessian needs that of the inverse dynamics.

        Args:
            posture, rate_before, state, derivatives: the impact and its derivatives.
            weights: of (V+, I), or of (V+, I, w), shape (12 + n,) or (13 + n,).
            sole_before: as of `state`.
        """
        jump = _jump(state, rate_before, sole_before)
        adjoint = derivatives.adjoint(weights)
        tangent = self._coupling.at(posture)
        whole = tangent.velocity(jump)
        dynamics = WeightedDynamics(
            axes=derivatives.axes[None],
            posture=self._coupling.angles(posture)[None],
            rate=np.zeros((1, self.robot.tree.size)),
            acceleration=whole[None, BASE:],
            base_acceleration=whole[None, :BASE],
            weights=tangent.velocity(adjoint[: self._nv])[None],
        )
        tree = self.robot.tree
        return WeightedImpact(dynamics, state, derivatives, adjoint, tree, tangent, self._kernel)


@dataclass(frozen=True)
class WeightedImpact:
    """An impact and a weighted sum of its result, ready for the second derivatives.

    With F(y, z) = 0 the equations of the impact, y = (V+, I), z = (posture, V-), and
    K' l = -weights, the Hessian is that of l . F along (dz, dy/dz dz).

    Attributes:
        dynamics: D (V+ - V-) as the inverse dynamics of one instant at rest, weighted by l, of all
            joints.
        state, derivatives: the impact and its derivatives.
        adjoint: l, shape (12 + n,), or (13 + n,) on a line.
        tree: of all joints.
        tangent: of all joints to the n that follow no other.
        kernel: what computes the Hessian; None: the plain path.
    """

    dynamics: WeightedDynamics
    state: ImpactState
    derivatives: ImpactDerivatives
    adjoint: Array
    tree: JointTree
    tangent: Tangent
    kernel: kernels.Landing | None = None

    @property
    def on_forces(self) -> Array:
        """Matrix that takes forces from the landing sole's frame to the world, shape (6, 6)."""
        *axes, origin = self.derivatives.frame
        return np.asarray(pin.SE3(np.array(axes), origin).toDualActionMatrix())

    @property
    def rate_after(self) -> Array:
        """Rates of all joints after the impact [rad/s], shape (all,)."""
        return self.tangent.rates(self.state.rate_after)

    def hessian(self, inertial: InverseDynamicsHessian) -> Array:
        """Return the Hessian in (posture, rate before), shape (2 n, 2 n).

        Where the stance sole moves before the impact its twist comes third: (2 n + 6, 2 n + 6).

        Args:
            inertial: second derivatives of `dynamics`, in all joints.
        """
        of, state = self.derivatives, self.state
        if self.kernel is not None:
            return self.kernel.hessian(
                state.velocity, state.impulse, of.inputs, of.axes, of.frame, self.adjoint,
                inertial.qq[0], inertial.qa[0], inertial.base[0],
            )  # fmt: skip
        n = of.free
        qq, by_result = self._landing()
        by_jump = np.concatenate([inertial.base[0], inertial.qa[0]], axis=1)
        qq += inertial.qq[0]
        bent = of.bent
        if bent is not None:
            more, by_more, jump_more = self._where_bent(bent, inertial.qa[0], by_result)
        qq = self.tangent.reduced_twice(qq)
        by_result = self._in_free(by_result)
        by_jump = self._in_free(by_jump)
        if bent is not None:
            qq, by_result, by_jump = qq + more, by_result + by_more, by_jump + jump_more
        by_result[:, : BASE + n] += by_jump
        mixed = by_result @ of.inputs
        mixed[:, n : 2 * n] -= by_jump[:, BASE:]  # the jump V+ - V- sees minus the rate before
        if of.sole.size:
            mixed[:, 2 * n :] -= by_jump[:, :BASE]
        H = np.zeros((mixed.shape[1], mixed.shape[1]))
        H[:n, :n] = qq
        H[:n] += mixed
        H[:, :n] += mixed.T
        return H

    def _in_free(self, table: Array) -> Array:
        """Return rows of angles and columns of (base, rates, more), from those of all joints."""
        stop = BASE + self.tree.size
        by_rates = self.tangent.effort(table[:, :stop])
        return self.tangent.reduced(np.concatenate([by_rates, table[:, stop:]], axis=1).T).T

    def _where_bent(
        self, bent: BentImpact, by_acceleration: Array, by_result: Array
    ) -> tuple[Array, Array, Array]:
        """What the change of S adds, in which l . F has S in the weights, the jump and V+.

        Args:
            bent: the impact of all joints.
            by_acceleration: second derivatives of `dynamics` in angles and accelerations, (n, n).
            by_result: those of l . (-J' I, J V+) in angles and (V+, I), of all joints.

        Returns:
            Of the free joints: in the posture twice; in the posture and (V+, I); in the posture
            and the jump V+ - V-.
        """
        of, size = self.tangent.of, self.tree.size
        own, more = BASE + len(of.free), by_result.shape[1] - size - BASE
        _, _, second, third, _ = bent.orders
        weights, pushed = self.adjoint[BASE:own], self.adjoint[own : own + BASE]
        l, jump, after = (  # noqa: E741
            values[of.motor] for values in (weights, bent.jump, self.state.rate_after)
        )
        inertia, whole = bent.D[BASE:], self.dynamics.weights[0]
        on_weights, on_jump, on_after = (
            (second * values)[:, None] * of.member for values in (l, jump, after)
        )
        by_jump = bent.D @ whole  # gradients in acceleration, V+ and angles of all joints
        by_after = bent.J.T @ pushed
        by_angle = whole @ bent.momentum + pushed @ bent.landing
        S = self.tangent.matrix
        turned = S.T @ (
            by_acceleration @ on_jump
            + bent.momentum[BASE:].T @ on_weights
            + by_result[:, BASE : BASE + size] @ on_after
        )
        qq = (
            turned
            + turned.T
            + of.diagonal(
                by_angle * second
                + (bent.residual[BASE:] * l + by_jump[BASE:] * jump + by_after[BASE:] * after)
                * third
            )
        )
        both = on_weights.T @ inertia[:, BASE:] @ on_jump
        qq += both + both.T
        jumped = on_weights.T @ inertia
        jumped = self.tangent.effort(jumped)
        jumped[:, BASE:] += of.diagonal(by_jump[BASE:] * second)
        result = np.zeros((len(of.free), own + more))
        result[:, BASE:own] = of.diagonal(by_after[BASE:] * second)
        result[:, own : own + BASE] = -on_weights.T @ bent.J[:, BASE:].T
        return qq, result, jumped

    def _landing(self) -> tuple[Array, Array]:
        """Second derivatives of l . (-J' I, J V+), to which the legs alone contribute.

        Returns:
            Of all joints: in the posture twice; in the posture and (V+, I).
        """
        n, legs = self.tree.size, self.tree.legs
        axes, state = self.dynamics.axes[0, legs], self.state
        own = BASE + len(self.tangent.of.free)
        landing = self.adjoint[own : own + BASE]
        rest = len(self.adjoint) - own - BASE  # linear in w
        base, rates = self.dynamics.weights[0, :BASE], self.dynamics.weights[0, BASE:]
        both = moved_axes(
            axes, np.array([self.rate_after[legs], rates[legs]]), np.array([state.sole_twist, base])
        )
        on_forces = self.on_forces  # its transpose takes motions back
        push, impulse = on_forces @ landing, on_forces @ state.impulse
        qq, by_result = np.zeros((n, n)), np.zeros((n, n + 2 * BASE + rest))
        qq[legs, legs] = velocity_hessian(axes, both, np.array([push, -impulse])).sum(axis=0)
        by_rate, by_result[legs, :BASE] = velocity_rate_hessian(axes, push)
        by_result[legs, BASE : BASE + len(axes)] = by_rate
        by_result[legs, BASE + n : 2 * BASE + n] = -both[1] @ on_forces
        return qq, by_result


def _jump(state: ImpactState, rate_before: Array, sole_before: Array | None) -> Array:
    """Return V+ - V-, shape (6 + n,)."""
    jump = state.velocity.copy()
    jump[BASE:] -= rate_before
    if sole_before is not None:
        jump[:BASE] -= sole_before
    return jump


def _momentum(D: Array, rate_before: Array, sole_before: Array | None) -> Array:
    """Return D V-, shape (6 + n,)."""
    moved = D[:, BASE:] @ rate_before
    return np.asarray(moved if sole_before is None else moved + D[:, :BASE] @ sole_before)


@dataclass(frozen=True)
class FlatJump:
    """What the impact does to the robot.

    Attributes:
        posture: joint angles at it, shape (n,).
        rate: w [rad/s].
        jump: of the joint rates, dq+ - dq-, shape (n,).
        impulse: I, of the ground on the foot, in its sole frame [N·s, N·m·s], shape (6,).
        along: derivatives of (jump, impulse) in (posture, w), shape (n + 6, n + 1).
        inertia: D [kg, kg·m, kg·m²], shape (6 + n, 6 + n).
        axes: of the joints in the world, shape (n, 6).
    """

    posture: Array
    rate: float
    jump: Array
    impulse: Array
    along: Array
    inertia: Array
    axes: Array


class _StandingImpact:
    """What impacts need after which feet stay: the robot without gravity."""

    def __init__(self, robot: Robot) -> None:
        self._model = robot.model.copy()
        self._model.gravity = pin.Motion.Zero()
        self._data = self._model.createData()
        self._q, self._v = pin.neutral(self._model), np.zeros(self._model.nv)
        self._robot = robot

    def _bent(
        self, at: FlatJump | ClosedJump, base: Array, weights: Array
    ) -> InverseDynamicsHessian:
        """Second derivatives of weights . D [base; jump], base (6,), weights (6 + n,)."""
        still = np.zeros(at.jump.shape)
        tables = at.axes, at.posture, still, at.jump, base, weights
        dynamics = cached_workspace(self._robot, DynamicsHessian)  # of the thread that asks
        return dynamics.of(WeightedDynamics(*(table[None] for table in tables)))


class FlatImpact(_StandingImpact):
    """Evaluates the impact of one robot whose stance foot has turned about a hinge."""

    def __init__(self, robot: Robot, hinge: Hinge) -> None:
        """Prepare what does not depend on the posture.

        Args:
            robot: rooted at its stance sole.
            hinge: line about which that has turned.

        Raises:
            InputError: joints of the robot follow others.
        """
        if not robot.coupling.none:
            raise InputError(
                "foot_flat 'impact' is for robots all of whose joints have motors of their own; "
                "joints of this robot follow others: take foot_flat 'gentle' (--foot-flat gentle)"
            )
        super().__init__(robot)
        self._twist = hinge.twist

    def at(self, posture: Array, rate: float) -> FlatJump:
        """Return what the impact does, with its derivatives.

        Args:
            posture: joint angles at it, shape (n,).
            rate: w, of the foot about its line before it [rad/s].
        """
        self._q[TWIST + 1 :] = posture
        D = np.array(pin.crba(self._model, self._data, self._q))
        base = -rate * self._twist
        jump = solve(D[TWIST:, TWIST:], -D[TWIST:, :TWIST] @ base)
        impulse = D[:TWIST] @ np.concatenate([base, jump])
        stopped = np.concatenate([base, jump])
        pin.computeRNEADerivatives(self._model, self._data, self._q, self._v, stopped)
        own = np.column_stack([self._data.dtau_dq[:, TWIST:], -D[:, :TWIST] @ self._twist])
        of_jump = -solve(D[TWIST:, TWIST:], own[TWIST:])
        of_impulse = own[:TWIST] + D[:TWIST, TWIST:] @ of_jump
        along, axes = np.vstack([of_jump, of_impulse]), self._data.J[:, TWIST:].T.copy()
        return FlatJump(posture, rate, jump, impulse, along, D, axes)

    def hessian(self, at: FlatJump, jump: Array, impulse: Array) -> Array:
        """Return the Hessian of jump . (dq+ - dq-) + impulse . I in (posture, w).

        With e the adjoint of both weights it is that of e . (inverse dynamics) along the jump.

        Args:
            at: the impact.
            jump: weights of the jump of the rates, shape (n,).
            impulse: weights of the impulse, shape (6,).
        """
        D, n = at.inertia, at.jump.size
        back = solve(D[TWIST:, TWIST:], jump + D[TWIST:, :TWIST] @ impulse)
        weights = np.concatenate([impulse, -back])
        bent = self._bent(at, -at.rate * self._twist, weights)
        mixed = bent.qa[0] @ at.along[:n]
        mixed[:, n] -= bent.base[0] @ self._twist
        H = np.zeros((n + 1, n + 1))
        H[:n, :n] = bent.qq[0]
        H[:n] += mixed
        H[:, :n] += mixed.T
        return H


@dataclass(frozen=True)
class ClosedJump:
    """What an impact does to the robot, and the local derivatives of its inverse dynamics.

    Attributes:
        posture: angles at the impact, shape (n,).
        jump: of the rates, dq+ - dq-, shape (n,).
        rear: impulse of the ground on the rear foot, in its sole frame, shape (6,).
        axes: of the joints in the world, shape (n, 6).
        of_posture: derivative of D (dq+ - dq-) in the posture, shape (6 + n, n).
        inertia: columns of the joints of D [kg, kg·m, kg·m²], shape (6 + n, n).
    """

    posture: Array
    jump: Array
    rear: Array
    axes: Array
    of_posture: Array
    inertia: Array

    def along(self, posture: Array, taken: Array) -> tuple[Array, Array]:
        """Return derivatives of the jump (n, P) and of the rear impulse (6, P).

        Args:
            posture: derivatives of the angles, shape (n, P).
            taken: of the impulse on the front foot, in the world, and of its moments about the
                joints, at fixed and moving axes, shape (6 + n, P).
        """
        moved = self.of_posture @ posture
        jump = solve(self.inertia[TWIST:], taken[TWIST:] - moved[TWIST:])
        return jump, moved[:TWIST] + self.inertia[:TWIST] @ jump - taken[:TWIST]

    def adjoint(self, jump: Array, rear: Array) -> Array:
        """Return e of e . (D jump - [F; S . F]), which has the derivatives of a weighted sum.

        Args:
            jump: weights of the jump, shape (n,).
            rear: weights of the rear impulse, shape (6,).

        Returns:
            Shape (6 + n,).
        """
        back = solve(self.inertia[TWIST:].T, jump + self.inertia[:TWIST].T @ rear)
        return np.concatenate([rear, -back])


class ClosedImpact(_StandingImpact):
    """Evaluates the impact of one robot after which both feet stay."""

    def at(self, posture: Array, axes: Array, force: Array) -> ClosedJump:
        """Return what the impact does.

        Args:
            posture: angles, shape (n,).
            axes: of the joints in the world, shape (n, 6).
            force: impulse of the ground on the front foot, in the stance sole frame, shape (6,)
                [N·s, N·m·s].
        """
        self._q[TWIST + 1 :] = posture
        model, data = self._model, self._data
        D = np.array(pin.crba(model, data, self._q))
        jump = solve(D[TWIST:, TWIST:], axes @ force)
        acceleration = np.concatenate([np.zeros(TWIST), jump])
        pin.computeRNEADerivatives(model, data, self._q, self._v, acceleration)
        rear = D[:TWIST, TWIST:] @ jump - force
        return ClosedJump(
            posture, jump, rear, axes, data.dtau_dq[:, TWIST:].copy(), D[:, TWIST:].copy()
        )

    def hessian(self, at: ClosedJump, weights: Array) -> InverseDynamicsHessian:
        """Return the second derivatives of weights . D jump, weights (6 + n,)."""
        return self._bent(at, np.zeros(TWIST), weights)
