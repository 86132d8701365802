"""A step with a finite double support: single support, touch-down at zero speed, both feet flat.

    x -> boundary (26) -> closed chain at lift-off -> stance leg -> closed chain -> swing leg

The stance leg follows one spline over the whole step. While both feet stand the swing leg is where
its sole stays on its footprint (`mechanics/closed_chain.py`); before, it follows a spline that ends
there, at rest on the ground. The rates at lift-off begin the next step: nothing jumps, and there is
no impact. The ground's wrench on the front foot is a cubic polynomial of time in Bernstein's form;
what is left of the whole wrench is the rear foot's.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from gaitopt.contact.schedule import Schedule
from gaitopt.errors import EvaluationError
from gaitopt.gait import quantities
from gaitopt.gait.double_support import (
    Displacement,
    DoubleSupport,
    InverseKinematicsSupport,
    Posture,
    drive,
    landing_sole_chain,
    place,
)
from gaitopt.gait.foot_turn import FootTurn
from gaitopt.gait.grid import Grid
from gaitopt.gait.parameters import DURATION, FOOT_YAW, STEP_LENGTH, Layout
from gaitopt.gait.quantities import Quantity
from gaitopt.gait.spline import SplineBasis, bernstein, spline_basis
from gaitopt.gait.step import (
    DoubleSupportPart,
    PostureQuantities,
    Step,
    StepDerivatives,
    chained,
    completed,
)
from gaitopt.gait.step_hessian import StepWeights, local_gradient, local_hessian
from gaitopt.mechanics.closed_chain import (
    FREE,
    TIED,
    ClosedChain,
    ClosedMotion,
    apply_last,
    nested,
    refuse_open,
)
from gaitopt.mechanics.impact import Impact, ImpactDerivatives, ImpactState
from gaitopt.mechanics.single_support import SingleSupport, SupportState
from gaitopt.mechanics.spatial import apply, cross_force, force_cross_matrix, motion_cross_matrix
from gaitopt.model.joint_tree import TWIST
from gaitopt.model.robot import Robot, cached_workspace
from gaitopt.nlp import Array

_TIED_RATES, _TIED_ANGLES = slice(3 * TWIST, 4 * TWIST), slice(TWIST, 2 * TWIST)


@dataclass(frozen=True)
class _Chained:
    """Derivatives in x, for the second ones.

    Attributes:
        stance, swing: of the coefficients of both legs, (K, 6, P).
        closed, touchdown, liftoff: of (u, du, ddu, g) at the instants of the double support and at
            its ends, (M, 18 + G, P), (1, 18 + G, P) each.
        motion: of all joints, (N, 36, P).
        wrench: of the front foot's, (M, 6, P).
        geometry: of the quantities, (G, P).
    """

    stance: Array
    swing: Array
    closed: Array
    touchdown: Array
    liftoff: Array
    motion: Array
    wrench: Array
    geometry: Array


class DoubleStepModel:
    """Evaluates steps with a double support; every result is a pure function of x."""

    hinge = line = landing_turn = foot_turn = None
    turns_foot = False

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        grid: Grid,
        optional: Collection[Quantity] = (),
        schedule: Schedule | None = None,
    ) -> None:
        """Prepare what does not depend on x; arguments as of `StepModel`.

        Raises:
            InputError: the swing leg does not follow from the stance leg.
        """
        refuse_open(robot)
        self.robot, self.layout, self.grid = robot, layout, grid
        self.schedule = schedule or Schedule()
        self.exchange = self.schedule.symmetry.joint_map(robot)
        touch = float(self.schedule.changes[-1])
        self.touch, early = touch, np.linspace(0.0, touch, layout.postures + 2)
        late = [0.5 * (touch + 1.0), 1.0]
        self.basis = spline_basis(np.concatenate([early, late]), grid.instants)
        self.both = grid.instants > touch
        single = np.minimum(grid.instants, touch)
        self.swing_basis = spline_basis(early, single)
        self._at_touch = spline_basis(self.basis.knots, np.array([touch]))
        share = np.clip((grid.instants[self.both] - touch) / (1.0 - touch), 0.0, 1.0)
        self._shares = bernstein(share)
        # Stance leg at touch-down and midway, from its rate at lift-off and two accelerations: so
        # that their sizes do not depend on how short the double support is.
        span = (1.0 - touch) * float(layout.fixed_values[DURATION])
        back = np.array([span, 0.5 * span])
        self._late = np.column_stack([-back, np.diag(0.5 * back**2)])
        self._support = SingleSupport(robot, grid.count)
        self._optional = PostureQuantities(robot, optional)
        self._chain: tuple[Displacement, ...] = landing_sole_chain(layout.rise)
        self._drive = drive(self._chain)
        rise = layout.rise
        self._boundary = (
            InverseKinematicsSupport if rise == 0.0 else InverseKinematicsSupport(robot, None, rise)
        )

    def turns(self, z: Array, turn_rate: float) -> list[tuple[FootTurn, Array]]:
        """Return none: both feet stand flat."""
        del z, turn_rate
        return []

    def splines(self, step: Step) -> dict[str, Array]:
        """Return the splines of all joints before and after touch-down, and the front wrench.

        After it those of the swing leg are near its motion, which closes the chain, and exact at
        their knots and in the rates at their ends.
        """
        double, T, n = step.double, step.duration, self.layout.joints
        assert double is not None
        early, late = self.swing_basis.knots, self.basis.knots[-3:]
        at = spline_basis(self.basis.knots, late).at(T) @ step.coefficients  # (3, 3, 6)
        middle = self._closed(
            np.ascontiguousarray(at[1:2].swapaxes(0, 1)), double.sole, double.motion.targets
        )
        touch, end = double.touchdown.motion[:, 0], double.liftoff.motion[:, 0]
        before = np.zeros((len(early) + 2, n))
        before[:-2, FREE] = step.coefficients[: len(early)]
        before[-2:, FREE] = step.coefficients[-2], touch[1, FREE]
        before[:, TIED] = double.swing
        after = np.stack([touch[0], middle.motion[0, 0], end[0], touch[1], end[1]])
        return {
            "knots": early * T,
            "coefficients": before,
            "double_knots": late * T,
            "double_coefficients": after,
            "front_wrench": step.x[self.layout.front].reshape(4, TWIST),
        }

    @property
    def boundary(self) -> DoubleSupport:
        """The double support at the start."""
        if isinstance(self._boundary, DoubleSupport):
            return self._boundary
        return cached_workspace(self.robot, self._boundary)

    @property
    def impact(self) -> Impact:
        """The impact of the robot, which a step with a double support has not."""
        return cached_workspace(self.robot, Impact)

    @property
    def closed(self) -> ClosedChain:
        """The closed chain of the robot."""
        return cached_workspace(self.robot, ClosedChain)

    def step(self, x: Array) -> Step:
        """Return the step at x (P,).

        Raises:
            EvaluationError: a parameter is not finite, or a leg cannot reach.
        """
        parts = self._parts(x, None)
        support = self._support.state(*parts.motion)
        read = self._optional.values(self._optional.placed(parts.motion[0]))
        return self._step(parts, support, read)

    def derivatives(self, x: Array, posture: Posture | None = None) -> tuple[Step, StepDerivatives]:
        """Return the step at x (P,) and its exact derivatives; arguments as of `StepModel`."""
        parts = self._parts(x, posture)
        support, at_support = self._support.derivatives(*parts.motion)
        optional = self._optional.derivatives(
            self._optional.placed(parts.motion[0]), at_support.axes, at_support.motion.tangent
        )
        read = {what: reading.value for what, reading in optional.items()}
        step = self._step(parts, support, read)
        at_start = self.boundary.derivatives(step.posture)
        none = np.zeros((2 * TWIST + self.layout.joints, self.layout.joints))
        at_impact = ImpactDerivatives(none, none, np.eye(len(none)))
        local = StepDerivatives(at_start, at_impact, at_support, optional)
        chained_ = self._chained(step, local)
        reads = self._reads(step, local, chained_)
        return step, replace(local, motion=chained_.motion, jacobians=reads)

    def _parts(self, x: Array, posture: Posture | None) -> _Parts:
        if not np.all(np.isfinite(x)):
            raise EvaluationError("a parameter is not finite")
        layout = self.layout
        geometry = layout.geometry_of(x)
        if geometry[DURATION] <= 0.0:
            raise EvaluationError(f"a step of {geometry[DURATION]} s is not a step")
        if posture is None:
            posture = self.boundary.posture(geometry, x[layout.start])
        q_start, q_end = posture.q_start, self.exchange @ posture.q_start
        sole, targets = place(self._chain, geometry)
        T = float(geometry[DURATION])
        rate_end = x[layout.rates]
        last = np.stack([q_end[FREE], rate_end, np.zeros(TWIST)])[:, None]
        liftoff = self._closed(last, sole, targets)
        rate_start = self.exchange @ liftoff.motion[1, 0]
        knots = x[layout.knots].reshape(-1, layout.joints)
        late = q_end[FREE] + self._late @ np.vstack([rate_end, x[layout.late].reshape(2, TWIST)])
        stance = np.vstack(
            [q_start[FREE], knots[:, FREE], late, q_end[FREE], rate_start[FREE], rate_end]
        )
        at_touch = (self._at_touch.at(T) @ stance).swapaxes(0, 1)
        touchdown = self._closed(at_touch, sole, targets)
        q_touch, dq_touch = touchdown.motion[:2, 0, TIED]
        swing = np.vstack([q_start[TIED], knots[:, TIED], q_touch, rate_start[TIED], dq_touch])
        free = (self.basis.at(T) @ stance).swapaxes(0, 1)
        tied = (self.swing_basis.at(T) @ swing).swapaxes(0, 1)
        motion = np.concatenate([free, tied], axis=2)
        closed = self._closed(np.ascontiguousarray(free[:, self.both]), sole, targets)
        motion[:, self.both] = closed.motion
        wrench = self._shares @ x[layout.front].reshape(4, TWIST)
        front = np.zeros((self.grid.count, TWIST))
        front[self.both] = wrench
        part = DoubleSupportPart(closed, touchdown, liftoff, sole, wrench, swing, front)
        return _Parts(x, geometry, posture, q_end, stance, np.ascontiguousarray(motion), part)

    def _closed(self, free: Array, sole: pin.SE3, targets: Array) -> ClosedMotion:
        motion, axes = self.closed.motion(free, sole)
        return ClosedMotion(motion, axes, targets, self._drive)

    def _step(self, parts: _Parts, support: SupportState, read: dict[Quantity, Array]) -> Step:
        double, rate = parts.double, parts.double.liftoff.motion[1, 0]
        effort = support.effort.copy()
        force = double.in_world
        effort[self.both, :TWIST] -= force
        axes = double.motion.axes
        effort[self.both, TWIST:] -= apply(axes, force)
        still = ImpactState(np.concatenate([np.zeros(TWIST), rate]), np.zeros(TWIST))
        yaw = np.full(self.grid.count, parts.geometry[FOOT_YAW])
        found = completed(read, yaw, self.grid.count)
        found[quantities.PEAK] = np.tile(parts.x[self.layout.largest], (self.grid.count, 1))
        return Step(
            x=parts.x,
            geometry=parts.geometry,
            posture=parts.posture,
            q_end=parts.q_end,
            rate_before=rate,
            impact=still,
            coefficients=parts.stance,
            motion=parts.motion,
            support=SupportState(effort, support.corners),
            optional=found,
            foot_motion=np.zeros((3, self.grid.count, 0)),
            double=double,
        )

    def _chained(self, step: Step, local: StepDerivatives) -> _Chained:
        double, layout, T = step.double, self.layout, step.duration
        assert double is not None
        P, n, k = layout.size, layout.joints, layout.postures
        eye = np.eye(P)
        geometry = np.zeros((len(layout.geometry), P))
        geometry[layout.free] = eye[layout.shape]
        q_start = np.zeros((n, P))
        q_start[:, layout.boundary] = local.posture.q_start[:, layout.boundary_columns]
        q_end = self.exchange @ q_start
        rate_end = eye[layout.rates]
        liftoff = np.concatenate([q_end[FREE], rate_end, np.zeros((TWIST, P)), geometry])[None]
        rate_start = self.exchange @ (double.liftoff.jacobian[0, n : 2 * n] @ liftoff[0])
        knots = eye[layout.knots].reshape(k, n, P)
        moves = np.concatenate([rate_end[None], eye[layout.late].reshape(2, TWIST, P)])
        late = q_end[FREE] + np.einsum("km,mjp->kjp", self._late, moves)
        stance = np.concatenate(
            [q_start[None, FREE], knots[:, FREE], late, [q_end[FREE], rate_start[FREE], rate_end]]
        )
        touchdown = self._along(self._at_touch, stance, T, geometry)
        ends = double.touchdown.jacobian[0] @ touchdown[0]
        swing = np.concatenate(
            [
                q_start[None, TIED], knots[:, TIED],
                [ends[_TIED_ANGLES], rate_start[TIED], ends[_TIED_RATES]],
            ]
        )  # fmt: skip
        motion = np.concatenate(
            [_moved(self.basis, stance, T), _moved(self.swing_basis, swing, T)], axis=2
        )
        motion = motion.reshape(self.grid.count, 3 * n, P)
        closed = self._along(self.basis, stance, T, geometry)[self.both]
        motion[self.both] = double.motion.jacobian @ closed
        of_front = eye[layout.front].reshape(4, TWIST, P)
        wrench = np.einsum("mb,bjp->mjp", self._shares, of_front)
        return _Chained(stance, swing, closed, touchdown, liftoff, motion, wrench, geometry)

    def _along(self, basis: SplineBasis, stance: Array, T: float, geometry: Array) -> Array:
        """Derivatives of (u, du, ddu, g) at instants, (N, 18 + G, P)."""
        moved = _moved(basis, stance, T).reshape(len(basis.instants), 3 * TWIST, -1)
        fixed = np.broadcast_to(geometry, (len(moved), *geometry.shape))
        return np.concatenate([moved, fixed], axis=1)

    def _reads(self, step: Step, local: StepDerivatives, at: _Chained) -> dict[Quantity, Array]:
        layout, support, double = self.layout, local.support, step.double
        assert double is not None
        n, P, count = layout.joints, layout.size, self.grid.count
        own, boundary = layout.boundary_columns, layout.boundary
        angles = at.motion[:, :n]
        effort = support.effort @ at.motion
        effort[self.both] -= self._front_jacobian(step, at)
        legs = np.zeros((2, 3, P))
        legs[:, :, boundary] = local.posture.legs[:, :, own]
        travel = at.geometry[[STEP_LENGTH, DURATION]][None]
        front = np.zeros((count, TWIST, P))
        front[self.both] = at.wrench
        corners = support.corners.reshape(count, -1, n) @ angles
        yaw = layout.index("foot_yaw")
        turned = None if yaw is None else np.broadcast_to(np.eye(P)[yaw], (count, P))
        return {
            quantities.TORQUE: effort[:, TWIST:],
            quantities.WRENCH: effort[:, :TWIST],
            quantities.CORNERS: corners,
            quantities.ANGLES: angles,
            quantities.RATES: at.motion[:, n : 2 * n],
            quantities.ACCELERATIONS: at.motion[:, 2 * n :],
            quantities.IMPULSE: np.zeros((1, TWIST, P)),
            quantities.SOLE_TWIST: np.zeros((1, TWIST, P)),
            quantities.LEGS: legs,
            quantities.GAPS: np.zeros((0, TWIST, P)),
            quantities.TRAVEL: travel,
            quantities.FOOT_TURN: np.zeros((count, 0, P)),
            quantities.FRONT_WRENCH: front,
            quantities.PEAK: np.tile(np.eye(P)[layout.largest], (count, 1, 1)),
            quantities.ADVANCE: np.zeros((1, 0, P)),
            **chained(local.optional, angles, turned),
        }

    def _front_local(self, step: Step) -> tuple[Array, Array]:
        """Derivatives of the front wrench in the stance frame: in g (M, 6, G), in itself (6, 6)."""
        double = step.double
        assert double is not None
        force = double.in_world
        twists = double.motion.targets  # (k, 6)
        by_amount = np.stack(
            [cross_force(np.broadcast_to(t, force.shape), force) for t in twists], axis=2
        )
        return by_amount @ self._drive, np.asarray(double.sole.toDualActionMatrix())

    def _front_jacobian(self, step: Step, at: _Chained) -> Array:
        """Derivatives of what the front foot takes off wrench and torques, (M, 6 + n, P)."""
        double = step.double
        assert double is not None
        by_geometry, by_wrench = self._front_local(step)
        force, axes = double.in_world, double.motion.axes
        in_world = by_geometry @ at.geometry + by_wrench @ at.wrench
        n = self.layout.joints
        by_angles = nested_moments(axes, force)
        torque = axes @ in_world + by_angles @ at.motion[self.both, :n]
        return np.concatenate([in_world, torque], axis=1)

    def hessian(self, step: Step, derivatives: StepDerivatives, weights: StepWeights) -> Array:
        """Return the Hessian in x of the function that `weights` differentiates, (P, P)."""
        double, first, n = step.double, weights.first, self.layout.joints
        assert double is not None
        at, T, P = self._chained(step, derivatives), step.duration, self.layout.size
        effort = np.concatenate([first[quantities.WRENCH], first[quantities.TORQUE]], axis=1)
        gradient = local_gradient(derivatives, first, effort, 0)
        taken, H = self._front_hessian(step, at, -effort[self.both])
        gradient[self.both, :n] += taken
        dynamics = derivatives.support.hessian(effort)
        plain = StepWeights(first, {})
        local = local_hessian(derivatives, plain, dynamics, 0)
        H += np.tensordot(at.motion, local @ at.motion, ((0, 1), (0, 1)))
        for one in (quantities.WRENCH, quantities.TORQUE):
            if (one, one) in weights.second:
                J = derivatives.jacobians[one]
                H += np.tensordot(J, weights.second[one, one] @ J, ((0, 1), (0, 1)))
        by_order = gradient.reshape(-1, 3, n)
        single = by_order * ~self.both[:, None, None]
        on_stance = np.einsum("nok,noj->kj", self.basis.at(T), single[:, :, FREE])
        on_swing = np.einsum("nok,noj->kj", self.swing_basis.at(T), single[:, :, TIED])
        on_stance += self._closing(
            double.motion, gradient[self.both], at.closed, self.basis.at(T)[self.both], H
        )
        ends = np.zeros((1, 3 * n))
        ends[0, _TIED_ANGLES], ends[0, _TIED_RATES] = on_swing[-3], on_swing[-1]
        on_stance += self._closing(double.touchdown, ends, at.touchdown, self._at_touch.at(T), H)
        last = np.zeros((1, 3 * n))
        last[0, n : 2 * n] = self.exchange.T @ np.concatenate([on_stance[-2], on_swing[-2]])
        H += _bent(double.liftoff, last, at.liftoff)
        at_end = on_stance[-5:-2].sum(axis=0) + (last[0] @ double.liftoff.jacobian[0])[:TWIST]
        q_start = np.concatenate([on_stance[0], on_swing[0]])
        q_start += self.exchange[FREE].T @ at_end
        posture = self.boundary.hessian(
            step.posture, derivatives.posture, q_start,
            first[quantities.LEGS], first[quantities.GAPS],
        )  # fmt: skip
        own, boundary = self.layout.boundary_columns, self.layout.boundary
        H[np.ix_(boundary, boundary)] += posture[np.ix_(own, own)]
        assert H.shape == (P, P)
        return np.asarray(H)

    def _closing(
        self, closed: ClosedMotion, weights: Array, along: Array, basis: Array, H: Array
    ) -> Array:
        """Add what a closed chain bends to H, and return its weights of the stance coefficients."""
        H += _bent(closed, weights, along)
        back = (weights[:, None] @ closed.jacobian)[:, 0, : 3 * TWIST].reshape(-1, 3, TWIST)
        return np.asarray(np.einsum("nok,noj->kj", basis, back))

    def _front_hessian(self, step: Step, at: _Chained, weights: Array) -> tuple[Array, Array]:
        """Gradient in the angles (M, n) and Hessian in x of weights . (what the front foot takes).

        Of weights e, c = e_W + sum_j e_j S_j is a motion, and the sum is c . W(g, w).

        Args:
            step, at: of the double support.
            weights: of wrench and torques, shape (M, 6 + n).
        """
        double, n = step.double, self.layout.joints
        assert double is not None
        force, axes, targets = double.in_world, double.motion.axes, double.motion.targets
        e = weights[:, TWIST:]
        _, triple, _ = nested(axes, force, 3)
        bent = apply_last(triple, e)  # in the angles
        c = weights[:, :TWIST] + (e[..., None] * axes).sum(axis=1)
        # d c / d q_k = S_k x sum over m > k of e_m S_m
        moved = e[..., None] * axes
        beyond = moved.sum(axis=1, keepdims=True) - np.cumsum(moved, axis=1)
        of_c = apply(motion_cross_matrix(axes), beyond)  # (M, n, 6)
        by_geometry, by_wrench = self._front_local(step)
        in_world = by_geometry @ at.geometry + by_wrench @ at.wrench  # (M, 6, P)
        angles = at.motion[self.both, :n]
        mixed = angles.swapaxes(1, 2) @ (of_c @ in_world)
        H = (angles.swapaxes(1, 2) @ (bent @ angles) + mixed + mixed.swapaxes(1, 2)).sum(axis=0)
        across = force_cross_matrix(targets)  # (k, 6, 6)
        drive, count = self._drive, len(targets)
        for a in range(count):
            row = c @ across[a]  # c . (G_a x* .)
            turned = (row[:, None] @ (by_wrench @ at.wrench))[:, 0].sum(axis=0)
            both = np.outer(drive[a] @ at.geometry, turned)
            H += both + both.T
            for b in range(a, count):
                value = float(np.sum(row * (force @ across[b].T)))
                pair = value * np.outer(drive[a] @ at.geometry, drive[b] @ at.geometry)
                H += pair if a == b else pair + pair.T
        return (of_c @ force[..., None])[..., 0], np.asarray(H)


@dataclass(frozen=True)
class _Parts:
    """A step before its forces; as of `DoubleStep`."""

    x: Array
    geometry: Array
    posture: Posture
    q_end: Array
    stance: Array
    motion: Array
    double: DoubleSupportPart


def _moved(basis: SplineBasis, coefficients: Array, T: float) -> Array:
    """Derivatives of (q, dq, ddq) of a leg at the instants, (N, 3, 6, P)."""
    matrix = basis.at(T)
    width = coefficients.shape[0]
    flat = matrix.reshape(-1, width) @ coefficients.reshape(width, -1)
    return flat.reshape(*matrix.shape[:2], *coefficients.shape[1:])


def _bent(closed: ClosedMotion, weights: Array, along: Array) -> Array:
    """What closed chains bend, shape (P, P)."""
    return np.asarray(np.tensordot(along, closed.hessian(weights) @ along, ((0, 1), (0, 1))))


def nested_moments(axes: Array, force: Array) -> Array:
    """Return the derivatives of S_j . force in the angles, shape (M, j, k)."""
    return np.asarray(nested(axes, force, 2)[0].swapaxes(1, 2))
