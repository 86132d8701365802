"""A step with a finite double support: single support, touch-down or impact, both feet stand.

    x -> boundary (26) -> closed chain at lift-off -> stance leg -> closed chain -> swing leg

The stance leg follows one spline over the whole step. While both feet stand the swing leg is where
its sole stays on its footprint (`mechanics/closed_chain.py`); before, it follows a spline that ends
there, at rest on the ground. The rates at lift-off begin the next step: nothing jumps, and there is
no impact. The ground's wrench on the front foot is a cubic polynomial of time in Bernstein's form;
what is left of the whole wrench is the rear foot's.

Where an impact begins the double support, the rates jump by what the impulse on the front foot, a
parameter, does to the robot (`mechanics/impact.py`). Both legs have splines of their own
before it, and the stance leg another one after it. Where the rear foot turns about its toe
before and while both stand, its hinge is a joint in front of the stance leg, whose angle is a
spline of its own (`gait/foot_turn.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from gaitopt.contact import shared_knots
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.gait import quantities
from gaitopt.gait.double_support import Placing, landing_sole_chain
from gaitopt.gait.parameters import DURATION, FOOT_YAW
from gaitopt.gait.quantities import Quantity
from gaitopt.gait.spline import (
    Basis,
    SplineInX,
    bernstein,
    on_coefficients,
    spline_basis,
    two_splines,
)
from gaitopt.gait.step import (
    DoubleSupportDerivatives,
    DoubleSupportPart,
    ShapedTurn,
    Step,
    StepDerivatives,
    gap_products,
)
from gaitopt.gait.step_hessian import local_gradient, local_hessian, weighed_effort
from gaitopt.gait.step_model import Course, Ending, Opening, StepModelBase, after_each, before_each
from gaitopt.gait.walk_point import Jacobians
from gaitopt.mechanics.closed_chain import (
    FREE,
    TIED,
    ClosedChain,
    ClosedMotion,
    FrontFoot,
    refuse_open,
)
from gaitopt.mechanics.impact import ClosedImpact, ImpactState, Turning
from gaitopt.model.joint_tree import TWIST
from gaitopt.model.robot import cached_workspace
from gaitopt.nlp import Array

_END = np.array([1.0])


@dataclass(frozen=True)
class Closing(Ending):
    """The end of a step, at which the rear foot leaves.

    Attributes:
        sole: placement of the front sole in the stance sole frame.
        targets: axes of the displacements that place it, in the world, (k, 6).
        liftoff: the closed chain then.
    """

    sole: pin.SE3
    targets: Array
    liftoff: ClosedMotion


class DoubleStepModel(StepModelBase[Closing]):
    """Evaluates steps with a double support; every result is a pure function of x."""

    def _prepare(self) -> None:
        robot, layout, grid = self.robot, self.layout, self.grid
        refuse_open(robot)
        if self.schedule.striking and not robot.tree.determined:
            raise InputError(
                "an impact that both feet take is for robots whose legs alone move; hold the other "
                "joints (leave out --move), or take touch_down 'gentle'"
            )
        self._size = self.chart.matrix.shape[1]  # of x
        touch, changes = float(self.schedule.changes[-1]), self.schedule.changes
        self.touch, early = touch, shared_knots(np.array([0.0, *changes]), layout.postures)
        self.knots = early
        late = np.array([touch, 0.5 * (touch + 1.0), 1.0])
        self.both = grid.instants > touch
        single = np.minimum(grid.instants, touch)
        self.swing_basis = spline_basis(early, single)
        self.striking = self.schedule.striking

        def stance(instants: Array, after: NDArray[np.bool_]) -> Basis:
            if self.striking:
                return two_splines(early, late, instants, after)
            return spline_basis(np.concatenate([early, late[1:]]), instants)

        self.basis = stance(grid.instants, self.both)
        self._at_touch, self._at_late = (
            stance(late[:count], np.ones(count, dtype=np.bool_)) for count in (1, 3)
        )
        self._h = int(self.hinge is not None)
        self._lasts = self.along("duration")
        m = self._h + layout.joints
        # joints that are free: the stance leg's and those in no chain; with the hinge before them
        n = layout.joints
        self.free: NDArray[np.int_] = np.r_[np.arange(n)[FREE], np.arange(n)[TIED.stop :]]
        self._driven = np.r_[np.arange(self._h), self._h + self.free]
        self._swing = slice(self._h + TIED.start, self._h + TIED.stop)
        self._count = self.free.size
        # of (q, dq, ddq) of all joints, the hinge before each
        self._angles, self._rates = slice(self._h, m), slice(m + self._h, 2 * m)
        share = np.clip((grid.instants[self.both] - touch) / (1.0 - touch), 0.0, 1.0)
        self._shares = bernstein(share)
        # Stance leg at touch-down and midway, from its rate at lift-off and accelerations: so that
        # their sizes do not depend on how short the double support is.
        span = (1.0 - touch) * float(layout.fixed_values[DURATION])
        self._late = _by_accelerations(0.5 * span) if self.striking else _by_moves(span)
        self._touching = np.array([touch])
        self._placing = Placing(landing_sole_chain(layout.rise))
        self._closed_chain = None if self.hinge is None else ClosedChain(robot, self.standing)

    def _hinge_motion(self, x: Array, T: float, instants: Array | None = None) -> Array:
        """Angle, rate and acceleration of the hinge, (3, N, h), at the grid's or other instants."""
        if self.foot_turn is None:
            count = self.grid.count if instants is None else instants.size
            return np.zeros((3, count, 0))
        turn = self.foot_turn if instants is None else replace(self.foot_turn, instants=instants)
        return np.asarray((turn.basis.at(T) @ turn.coefficients @ x[self.layout.turn]).T[..., None])

    def _hinge_in_x(self, x: Array, T: float, instants: Array | None = None) -> SplineInX | None:
        """Its spline in x; None where no foot turns."""
        if self.foot_turn is None:
            return None
        turn = self.foot_turn if instants is None else replace(self.foot_turn, instants=instants)
        own = self.layout.turn
        return ShapedTurn(turn, x[own], self.chart.matrix[own]).spline(T, self._lasts)

    def _hinge_jacobian(self, x: Array, T: float, instants: Array | None = None) -> Array:
        """Its derivatives in x, (N, 3, h, P)."""
        spline = self._hinge_in_x(x, T, instants)
        if spline is not None:
            return spline.motion()
        return np.zeros((self.grid.count if instants is None else instants.size, 3, 0, self._size))

    def _leg_in_x(self, basis: Basis, T: float, coefficients: Array, along: Array) -> SplineInX:
        """Splines of a leg in x; arguments as of `SplineInX`."""
        return SplineInX(basis, T, coefficients, along, self._lasts)

    def splines(self, step: Step) -> dict[str, Array]:
        """Return the splines of all joints before and after touch-down, the front wrench (4, 6).

        After it those of the swing leg are near its motion, which closes the chain, and exact at
        their knots and in the rates at their ends.
        """
        double, T, n = step.double_support, step.duration, self.layout.joints
        early, late = self.swing_basis.knots, self.basis.knots[-3:]
        at, h = self.late_motion(step)[1:2].swapaxes(0, 1), self._h
        turned = self._hinge_motion(step.x, T, late[1:2])
        middle = self._closed(
            np.concatenate([turned, at], axis=2), double.sole, double.motion.targets
        )
        touch, end = double.touchdown.motion[:, 0, h:], double.liftoff.motion[:, 0, h:]
        k, stance = len(early), step.coefficients
        before = np.zeros((k + 2, n))
        own = self.free
        before[:k, own] = stance[:k]
        before[k:, own] = stance[k : k + 2] if self.striking else (stance[-2], touch[1, own])
        before[:, TIED] = double.swing
        after = np.stack([touch[0], middle.motion[0, 0, h:], end[0], touch[1], end[1]])
        return {
            "knots": early * T,
            "coefficients": before,
            "double_knots": late * T,
            "double_coefficients": after,
            "front_wrench": step.x[self.layout.front].reshape(4, TWIST),
        }

    def late_motion(self, step: Step) -> Array:
        """Return (q, dq, ddq) of the stance leg at touch-down, midway and at the end, (3, 3, 6)."""
        return np.asarray(self._at_late.at(step.duration) @ step.coefficients)

    def bends(self, late: Array) -> Array:
        """Return the entries `late` of x for a motion as of `late_motion`, shape (b,)."""
        if self.striking:
            return np.asarray(late[:, 2].ravel())
        angles, rate = late[:2, 0] - late[2, 0], late[2, 1]
        by_rate, by_bends = self._late[:, :1], self._late[:, 1:]
        return np.asarray(np.linalg.solve(by_bends, angles - by_rate * rate).ravel())

    def rear_impulses(self, step: Step) -> Array:
        """Return the impulse on the rear foot per unit of that on the front one, shape (6, 6).

        Of an impact, if there were one, where both feet come to stand; each in its sole frame.
        """
        double = step.double_support
        posture, axes = double.touchdown.motion[0, 0], double.touchdown.axes[0]
        each = double.sole.toDualActionMatrix().T
        rear = [self.closed_impact.at(posture, axes, force).rear for force in each]
        return np.stack(rear, axis=1)

    @property
    def closed_impact(self) -> ClosedImpact:
        """The impact after which both feet stay."""
        return cached_workspace(self.robot, ClosedImpact)

    @property
    def closed(self) -> ClosedChain:
        """The closed chain of the robot, with the hinge of its rear foot."""
        if self._closed_chain is not None:
            return self._closed_chain
        return cached_workspace(self.robot, ClosedChain)

    def ending(self, opening: Opening, following: Opening, slopes: bool) -> Closing:
        """Return the end of the step, at which the rear foot leaves."""
        del slopes
        z, T = opening.z, float(opening.geometry[DURATION])
        q_end = self.exchange @ following.posture.q_start
        ((sole, targets),) = self._placing.at(following.geometry)
        rates = z[self.layout.rates]
        last = np.stack([q_end[self.free], rates, np.zeros(self._count)])[:, None]
        turned = self._hinge_motion(z, T, _END)
        liftoff = self._closed(np.concatenate([turned, last], axis=2), sole, targets)
        yaw_end = float(following.geometry[FOOT_YAW])
        return Closing(q_end, yaw_end, None, sole, targets, liftoff)

    def _course(self, opening: Opening, ending: Closing, before: Closing) -> Course:
        layout, x = self.layout, opening.z
        q_end, sole, targets, liftoff = ending.q_end, ending.sole, ending.targets, ending.liftoff
        T, rate_end, h = float(opening.geometry[DURATION]), x[layout.rates], self._h
        q_start = opening.posture.q_start
        rate_start = self.exchange @ before.liftoff.motion[1, 0, h:]
        knots = x[layout.knots].reshape(-1, layout.joints)
        own = self.free
        late = self._late @ np.vstack([rate_end, x[layout.late].reshape(-1, self._count)])
        late[: -2 if self.striking else None] += q_end[own]
        if self.striking:
            stance = np.vstack([np.zeros((len(knots) + 4, own.size)), late])  # before it: below
        else:
            stance = np.vstack(
                [q_start[own], knots[:, own], late, q_end[own], rate_start[own], rate_end]
            )
        at_touch = (self._at_touch.at(T) @ stance).swapaxes(0, 1)
        turned = self._hinge_motion(x, T, self._touching)
        touchdown = self._closed(np.concatenate([turned, at_touch], axis=2), sole, targets)
        q_touch, dq_touch = touchdown.motion[:2, 0, h:]
        struck = None
        if self.striking:
            force = sole.toDualActionMatrix() @ x[layout.push]
            struck = self.closed_impact.at(q_touch, touchdown.axes[0], force)
            dq_touch = dq_touch - struck.jump
        early = np.vstack([q_start, knots, q_touch, rate_start, dq_touch])
        if self.striking:
            stance[: len(early)] = early[:, self.free]
        swing = early[:, TIED]
        free = (self.basis.at(T) @ stance).swapaxes(0, 1)
        tied = (self.swing_basis.at(T) @ swing).swapaxes(0, 1)
        turned = self._hinge_motion(x, T)
        motion = np.concatenate([turned, free[..., FREE], tied, free[..., FREE.stop :]], axis=2)
        closed = self._closed(motion[:, self.both][:, :, self._driven], sole, targets)
        motion[:, self.both] = closed.motion
        wrench = self._shares @ x[layout.front].reshape(4, TWIST)
        front = np.zeros((self.grid.count, TWIST))
        front[self.both] = wrench
        part = DoubleSupportPart(closed, touchdown, liftoff, sole, wrench, swing, front, struck)
        return Course(stance, np.ascontiguousarray(motion[:, :, h:]), motion[:, :, :h], double=part)

    def _closed(self, free: Array, sole: pin.SE3, targets: Array) -> ClosedMotion:
        motion, axes = self.closed.motion(free, sole)
        return ClosedMotion(motion, axes, targets, self._placing.drives[0])

    def _at_end(
        self, opening: Opening, ending: Closing, course: Course
    ) -> tuple[Array, ImpactState, Turning | None, Turning | None]:
        double, impulse, h = course.double, np.zeros(TWIST), self._h
        assert double is not None
        twist, turn = np.zeros(TWIST), self._turn_at_end(opening.z)
        before = after = ending.liftoff.motion[1, 0, h:]
        if double.struck is not None:
            after = double.touchdown.motion[1, 0, h:]
            before, impulse = after - double.struck.jump, opening.z[self.layout.push]
        if turn is not None:  # the rear foot leaves as it turns
            twist = turn.twist
        return before, ImpactState(np.concatenate([twist, after]), impulse), turn, None

    def ending_in_x(
        self,
        step: Step,
        local: StepDerivatives,
        q_end: Array,
        following: StepModelBase[Closing] | None,
    ) -> Array:
        """Return the derivatives of (u, du, ddu, g) at lift-off, (1, 3 (h + 6) + G, P)."""
        del local
        assert following is not None
        rates = self.chart.matrix[self.layout.rates]
        last = np.stack([q_end[self.free], rates, np.zeros_like(rates)])[None]
        turned = self._hinge_jacobian(step.x, step.duration, _END)
        return self._with_hinge(last, turned, following.geometry_in_x)

    def chain(
        self,
        step: Step,
        local: StepDerivatives,
        postures: tuple[Array, Array],
        ends: tuple[Array, Array],
        before: Closing,
        following: StepModelBase[Closing] | None,
    ) -> StepDerivatives:
        assert following is not None
        (q_start, q_end), (liftoff, at_start) = postures, ends
        left = before.liftoff.jacobian[0, self._rates] @ at_start[0]
        rate_start, geometry = self.exchange @ left, following.geometry_in_x
        double, layout, T = step.double_support, self.layout, step.duration
        P, n, k = self._size, layout.joints, layout.postures
        matrix, h = self.chart.matrix, self._h
        rate_end = matrix[layout.rates]
        knots = matrix[layout.knots].reshape(k, n, P)
        own, f = self.free, self._count
        moves = np.concatenate([rate_end[None], matrix[layout.late].reshape(-1, f, P)])
        late = np.einsum("km,mjp->kjp", self._late, moves)
        late[: -2 if self.striking else None] += q_end[own]
        if self.striking:
            stance = np.concatenate([np.zeros((k + 4, f, P)), late])
        else:
            last = [q_end[own], rate_start[own], rate_end]
            stance = np.concatenate([q_start[None, own], knots[:, own], late, last])
        turned, whole = self._hinge_jacobian(step.x, T, self._touching), step.coefficients
        moved = self._leg_in_x(self._at_touch, T, whole, stance).motion()
        touchdown = self._with_hinge(moved, turned, geometry)
        at_touch = double.touchdown.jacobian[0] @ touchdown[0]
        q_touch = at_touch[self._angles]
        rate_touch, jump, rear = at_touch[self._rates], np.zeros((0, P)), np.zeros((0, P))
        if double.struck is not None:
            foot, push = self._struck_foot(step), matrix[layout.push][None]
            taken = foot.jacobian(q_touch[None], geometry, push)[0]
            jump, rear = double.struck.along(q_touch, taken)
            rate_touch = rate_touch - jump
        early = np.concatenate([q_start[None], knots, [q_touch, rate_start, rate_touch]])
        if self.striking:
            stance[: len(early)] = early[:, self.free]
        swing = early[:, TIED]
        turned = self._hinge_jacobian(step.x, T)
        free = self._leg_in_x(self.basis, T, whole, stance).motion()
        tied = self._leg_in_x(self.swing_basis, T, double.swing, swing).motion()
        legs, others = free[:, :, FREE], free[:, :, FREE.stop :]
        motion = np.concatenate([turned, legs, tied, others], axis=2)
        motion = motion.reshape(self.grid.count, 3 * (h + n), P)
        closed = self._with_hinge(free[self.both], turned[self.both], geometry)
        motion[self.both] = double.motion.jacobian @ closed
        of_front = matrix[layout.front].reshape(4, TWIST, P)
        wrench = np.einsum("mb,bjp->mjp", self._shares, of_front)
        at = DoubleSupportDerivatives(
            stance, swing, closed, touchdown, liftoff, wrench, geometry, jump, rear
        )
        reads = self._jacobians(double, local, motion, at)
        return replace(local, motion=motion, double=at, jacobians=reads)

    def _struck_foot(self, step: Step) -> FrontFoot:
        """The front foot as it takes an impulse."""
        double = step.double_support
        return FrontFoot(double.sole, double.touchdown, step.x[self.layout.push][None])

    def _with_hinge(self, stance: Array, turned: Array, geometry: Array) -> Array:
        """Derivatives of (u, du, ddu, g) at instants, (N, 3 (h + 6) + G, P).

        Args:
            stance: of the stance leg's motion, (N, 3, 6, P).
            turned: of the hinge's, (N, 3, h, P).
            geometry: of the quantities, (G, P).
        """
        count, P = len(stance), geometry.shape[1]
        free = np.concatenate([turned, stance], axis=2).reshape(count, -1, P)
        fixed = np.broadcast_to(geometry, (count, *geometry.shape))
        return np.concatenate([free, fixed], axis=1)

    def _jacobians(
        self,
        double: DoubleSupportPart,
        local: StepDerivatives,
        motion: Array,
        at: DoubleSupportDerivatives,
    ) -> Jacobians:
        """Derivatives of all quantities in x, from those of the motion (N, 3 (h + n), P)."""
        layout, P, matrix = self.layout, self._size, self.chart.matrix
        effort, chain = local.support.effort @ motion, double.motion.axes.shape[1]
        angles = motion[self.both, :chain]
        effort[self.both, : TWIST + chain] -= double.foot.jacobian(angles, at.geometry, at.wrench)
        front = np.zeros((self.grid.count, TWIST, P))
        front[self.both] = at.wrench
        impulse = matrix[layout.push] if self.striking else np.zeros((TWIST, P))
        twist = np.zeros((TWIST, P))
        if self.hinge is not None:
            twist = np.outer(self.hinge.twist, matrix[layout.turn.stop - 1])
        reads = {
            **self._reads(local, motion, effort, at.geometry[FOOT_YAW]),
            quantities.IMPULSE: impulse[None],
            quantities.SOLE_TWIST: twist[None],
            quantities.FRONT_WRENCH: front,
            quantities.REAR_IMPULSE: at.rear[None],
        }
        return Jacobians(reads, gap_products(local.optional, motion))

    def own_hessian(
        self, step: Step, derivatives: StepDerivatives, first: dict[Quantity, Array]
    ) -> tuple[Array, OnEnds]:
        """Return what a step bends but for its ends, (P, P), and what those weigh."""
        double, n = step.double_support, self.layout.joints
        at, T, P, motion = derivatives.double, step.duration, self._size, derivatives.motion
        assert at is not None
        h, m = self._h, self._h + n
        effort = weighed_effort(step, first)
        gradient = local_gradient(derivatives, first, effort, h)
        chain = double.motion.axes.shape[1]
        taken, H = double.foot.hessian(
            motion[self.both, :chain], at.geometry, at.wrench, -effort[self.both, : TWIST + chain]
        )
        gradient[self.both, :chain] += taken
        dynamics = derivatives.support.hessian(effort)
        H += local_hessian(derivatives, first, dynamics).through(motion)
        by_order = gradient.reshape(-1, 3, m)
        felt = by_order * ~self.both[:, None, None]
        free, single = felt[:, :, self._driven], felt[:, :, self._swing]
        free[self.both] = self._closing(double.motion, gradient[self.both], at.closed, H)
        on_stance = self._on_stance(step, at, self.basis, free, None, H)
        on_swing = on_coefficients(self.swing_basis, T, single)
        H += self._leg_in_x(self.swing_basis, T, double.swing, at.swing).hessian(single)
        k = self.layout.postures
        ends = np.zeros((1, 3 * m))
        on_early = on_swing
        if self.striking:
            on_early = np.concatenate([on_stance[: k + 4], on_swing], axis=1)
            ends[0, self._angles], ends[0, self._rates] = on_early[-3], on_early[-1]
            ends[0, self._angles] += self._impact_hessian(step, at, -on_early[-1], first, H)
        else:
            ends.reshape(3, m)[:2, self._swing] = on_swing[-3], on_swing[-1]
        back = self._closing(double.touchdown, ends, at.touchdown, H)
        on_stance += self._on_stance(step, at, self._at_touch, back, self._touching, H)
        if self.striking:
            start, rate = on_early[0], on_early[-2]
        else:
            start, rate = np.zeros((2, n))
            start[self.free], start[TIED] = on_stance[0], on_swing[0]
            rate[self.free], rate[TIED] = on_stance[-2], on_swing[-2]
        assert H.shape == (P, P)
        return H, OnEnds(start, rate, on_stance[-5:-2].sum(axis=0))

    def liftoff_hessian(
        self, step: Step, derivatives: StepDerivatives, rate: Array
    ) -> tuple[Array, Array]:
        """Return what the end of a step bends, (P, P), and the weights of u there, (6,).

        Args:
            rate: weights of the rates at the start of the next step, there exchanged, (n,).
        """
        double, at, h = step.double_support, derivatives.double, self._h
        assert at is not None
        last = np.zeros((1, 3 * (h + self.layout.joints)))
        last[0, self._rates] = self.exchange.T @ rate
        back = (last[0] @ double.liftoff.jacobian[0])[h : h + self._count]
        return _bent(double.liftoff, last, at.liftoff), back

    def _closing(self, closed: ClosedMotion, weights: Array, along: Array, H: Array) -> Array:
        """Add what a closed chain bends to H; return its weights of (u, du, ddu), (M, 3, h + 6)."""
        H += _bent(closed, weights, along)
        free = self._h + self._count
        return np.asarray(
            (weights[:, None] @ closed.jacobian)[:, 0, : 3 * free].reshape(-1, 3, free)
        )

    def _on_stance(
        self,
        step: Step,
        at: DoubleSupportDerivatives,
        basis: Basis,
        weights: Array,
        instants: Array | None,
        H: Array,
    ) -> Array:
        """Return weights of the stance leg's coefficients; add to H what a free duration bends.

        Args:
            basis: of the stance leg's spline at the instants.
            weights: of (u, du, ddu), shape (N, 3, h + 6).
            instants: as shares of the step; None: those of the grid.
            H: Hessian in x, shape (P, P).
        """
        T, h = step.duration, self._h
        turned = self._hinge_in_x(step.x, T, instants)
        if turned is not None:
            H += turned.hessian(weights[:, :, :h])
        own = weights[:, :, h:]
        H += self._leg_in_x(basis, T, step.coefficients, at.stance).hessian(own)
        return on_coefficients(basis, T, own)

    def _impact_hessian(
        self,
        step: Step,
        at: DoubleSupportDerivatives,
        jump: Array,
        first: dict[Quantity, Array],
        H: Array,
    ) -> Array:
        """Add what the impact bends to H, and return its weights of the angles there, (n,).

        Args:
            jump: weights of the jump of the rates, shape (n,).
            H: Hessian in x, shape (P, P).
        """
        double, n = step.double_support, self.layout.joints
        struck = double.struck
        assert struck is not None
        e = struck.adjoint(jump, first[quantities.REAR_IMPULSE][0])
        along = double.touchdown.jacobian[0, :n] @ at.touchdown[0]
        bent = self.closed_impact.hessian(struck, e)
        mixed = along.T @ bent.qa[0] @ at.jump
        H += along.T @ bent.qq[0] @ along + mixed + mixed.T
        push = self.chart.matrix[self.layout.push][None]
        taken, of_front = self._struck_foot(step).hessian(along[None], at.geometry, push, -e[None])
        H += of_front
        return np.asarray(e @ struck.of_posture + taken[0])


@dataclass(frozen=True)
class OnEnds:
    """What a weighted sum of a step's quantities weighs at its ends.

    Attributes:
        start, rate: weights of posture and rates at the start, shape (n,).
        end: of the stance leg's angles at the end, shape (6,).
    """

    start: Array
    rate: Array
    end: Array


def double_cycle_hessian(
    models: Sequence[DoubleStepModel],
    steps: Sequence[Step],
    derivatives: Sequence[StepDerivatives],
    weights: Sequence[dict[Quantity, Array]],
) -> Array:
    """Return the Hessian in x of weights . (quantities) of steps that follow each other, (P, P)."""
    each = list(zip(models, steps, derivatives, weights, strict=True))
    own = [model.own_hessian(step, at, weighed) for model, step, at, weighed in each]
    ends = [one for _, one in own]
    leaving = [
        model.liftoff_hessian(step, at, following.rate)
        for (model, step, at, _), following in zip(each, after_each(ends), strict=True)
    ]
    H = np.sum([bent for bent, _ in (*own, *leaving)], axis=0)
    on_end = [one.end + back for one, (_, back) in zip(ends, leaving, strict=True)]
    for (model, step, at, weighed), one, end in zip(each, ends, before_each(on_end), strict=True):
        q_start = one.start + model.exchange[model.free].T @ end
        start = model.start_hessian(step, at, q_start, weighed)
        H += model.at_start.T @ start @ model.at_start
    return np.asarray((H + H.T) / 2.0)


def _by_moves(span: float) -> Array:
    """Stance leg at touch-down, midway less its end, by rate and accelerations; of a span [s]."""
    back = np.array([span, 0.5 * span])
    return np.column_stack([-back, np.diag(0.5 * back**2)])


def _by_accelerations(h: float) -> Array:
    """Coefficients of the stance leg's spline after the impact, angles less that at the end.

    They are its angles at touch-down, midway and at the end, its rates at touch-down and at the
    end, by its rate at the end and its accelerations at the three knots, linear in between: (5, 4).

    Args:
        h: half of the double support [s].
    """
    square = h * h
    return np.array(
        [
            [-2.0 * h, square / 6.0, square, 5.0 * square / 6.0],
            [-h, 0.0, square / 6.0, square / 3.0],
            [0.0, 0.0, 0.0, 0.0],
            [1.0, -0.5 * h, -h, -0.5 * h],
            [1.0, 0.0, 0.0, 0.0],
        ]
    )


def _bent(closed: ClosedMotion, weights: Array, along: Array) -> Array:
    """What closed chains bend, shape (P, P)."""
    return np.asarray(np.tensordot(along, closed.hessian(weights) @ along, ((0, 1), (0, 1))))
