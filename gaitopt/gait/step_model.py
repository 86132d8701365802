"""One step of the walk as a function of the parameters, in the order of the method.

    x -> boundary (26) -> impact (16)-(20), (27) -> spline (40)-(44) -> single support (1)-(13)

Derivatives take the same road: local ones at each instant with respect to (q, dq, ddq), then one
constant linear map to the spline's coefficients, then the coefficients' dependence on x.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Sequence
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from gaitopt.contact import Schedule
from gaitopt.dataclass import dataclass
from gaitopt.errors import EvaluationError
from gaitopt.gait import quantities
from gaitopt.gait.double_support import (
    FEET,
    DoubleSupport,
    InverseKinematicsSupport,
    JointAngleSupport,
    Posture,
    PostureDerivatives,
    refuse_undetermined,
)
from gaitopt.gait.foot_turn import FootTurn, foot_turn, landing_turn
from gaitopt.gait.grid import Grid
from gaitopt.gait.parameters import DURATION, FOOT_YAW, STEP_LENGTH, Chart, Layout, identity_chart
from gaitopt.gait.quantities import Quantity
from gaitopt.gait.spline import Basis, SplineInX, jumping_spline, on_coefficients, spline_basis
from gaitopt.gait.step import (
    DoubleSupportPart,
    PostureQuantities,
    ShapedTurn,
    Step,
    StepDerivatives,
    chained,
    completed,
    foot_turn_rows,
    gap_products,
    with_foot,
)
from gaitopt.gait.walk_point import Jacobians
from gaitopt.mechanics.impact import (
    FlatImpact,
    FlatJump,
    Impact,
    ImpactDerivatives,
    ImpactState,
    Turning,
)
from gaitopt.mechanics.inverse_dynamics_hessian import InverseDynamicsHessian
from gaitopt.mechanics.single_support import SingleSupport, SupportState, standing_robot
from gaitopt.mechanics.spatial import cross_force, cross_motion
from gaitopt.model.robot import Robot, cached_workspace
from gaitopt.nlp import Array

T = TypeVar("T")
E = TypeVar("E", bound="Ending")


@dataclass(frozen=True)
class Opening:
    """The double support at the start of a step.

    Attributes:
        z: parameters of the step, shape (p,).
        geometry: geometric quantities, free and fixed (G,).
        posture: of the robot.
    """

    z: Array
    geometry: Array
    posture: Posture


@dataclass(frozen=True)
class Ending:
    """The end of a step.

    Attributes:
        q_end: posture, shape (n,).
        yaw_end: foot yaw at the start of the next step [rad].
        slopes: derivatives of the impact; None where there is none, or they are not wanted.
    """

    q_end: Array
    yaw_end: float
    slopes: ImpactDerivatives | None


@dataclass(frozen=True)
class Landing(Ending):
    """The end of a step by an impact.

    Attributes:
        rate_before, turn, impact, landed: as of `Step`.
    """

    rate_before: Array
    turn: Turning | None
    impact: ImpactState
    landed: Turning | None


@dataclass(frozen=True)
class Course:
    """The motion of a step.

    Attributes:
        coefficients, motion: as of `Step`.
        foot, flat, double: its `foot_motion`, `flat` and `double`.
    """

    coefficients: Array
    motion: Array
    foot: Array
    flat: FlatJump | None = None
    double: DoubleSupportPart | None = None

    @cached_property
    def whole(self) -> Array:
        """The stance foot's motion, then the joints', shape (3, N, h + n)."""
        return with_foot(self.foot, self.motion)


class StepModelBase(ABC, Generic[E]):
    """What steps with and without a double support have in common: all but their course.

    A step begins with an `Opening`, and with what ended the step before it, there exchanged; its
    own end is of the kind E, a `Landing` or the lift-off that ends a double support.
    """

    both: NDArray[np.bool_]
    """At which instants both feet stand, shape (N,), of steps with a double support."""

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        grid: Grid,
        optional: Collection[Quantity] = (),
        schedule: Schedule | None = None,
        chart: Chart | None = None,
        before: Chart | None = None,
    ) -> None:
        """Prepare what does not depend on x.

        Args:
            optional: which of the quantities that not every walk needs are to be computed.
            schedule: of the step; by default that of the paper.
            chart: of the layout's parameters in those of a walk of more than one step.
            before: that of the step before, whose stance foot is the rear one at the start.

        Raises:
            InputError: the layout's form of the double support, or the schedule, does not suit the
                robot.
        """
        if not layout.lifted:
            refuse_undetermined(robot)
        self.robot, self.layout, self.grid = robot, layout, grid
        self.schedule = schedule or Schedule()
        self.chart = chart or identity_chart(layout.size)
        self._before = before or self.chart
        self.at_start = self._start_in_x()
        # Takes the joints from the end of a step to the start of the next, Eqs. (26) and (27).
        self.exchange = self.schedule.symmetry.joint_map(robot)
        one, last = self.schedule.first.contact, self.schedule.last.contact
        self.line, self.hinge = one.hinge(robot.sole), last.hinge(robot.sole)
        self.landing_turn = (
            None if self.line is None else landing_turn(self.schedule, grid.instants)
        )
        self.foot_turn = None if self.hinge is None else foot_turn(self.schedule, grid.instants)
        # with the hinges of a foot that turns
        self.standing = standing_robot(robot, *self.schedule.contacts)
        self._support = SingleSupport(self.standing, grid.count)
        self._optional = PostureQuantities(robot, optional, self.standing)
        form = JointAngleSupport if layout.lifted else InverseKinematicsSupport
        plain = not self.turns_foot and layout.rise == 0.0
        self._boundary = form if plain else form(robot, self.hinge, layout.rise, self.line)
        self._impact = Impact if self.line is None else Impact(robot, self.line)
        self._prepare()

    @abstractmethod
    def _prepare(self) -> None:
        """Prepare what depends on the course of the step, and not on x."""

    @abstractmethod
    def ending(self, opening: Opening, following: Opening, slopes: bool) -> E:
        """Return the end of the step, from its start and that of the next step, there exchanged.

        Args:
            slopes: whether the derivatives of an impact are wanted.
        """

    @abstractmethod
    def _course(self, opening: Opening, ending: E, before: E) -> Course:
        """Return the motion; `before` is the end of the step before, there exchanged."""

    @abstractmethod
    def _at_end(
        self, opening: Opening, ending: E, course: Course
    ) -> tuple[Array, ImpactState, Turning | None, Turning | None]:
        """Rates before the impact, this, and how the rear and the front foot turn then."""

    @abstractmethod
    def ending_in_x(
        self, step: Step, local: StepDerivatives, q_end: Array, following: StepModelBase[E] | None
    ) -> Array:
        """Return the derivatives in x of what the step leaves to the next one.

        Args:
            step, local: with its local derivatives.
            q_end: of the posture, shape (n, P).
            following: the next step; None: its start is given.
        """

    @abstractmethod
    def chain(
        self,
        step: Step,
        local: StepDerivatives,
        postures: tuple[Array, Array],
        ends: tuple[Array, Array],
        before: E,
        following: StepModelBase[E] | None,
    ) -> StepDerivatives:
        """Return the derivatives of a step in x, from the local ones.

        Args:
            step, local, following: as of `ending_in_x`.
            postures: of those at its ends, shape (n, P) each.
            ends: of its end and of that of the step before, as of `ending_in_x`.
            before: end of the step before.
        """

    def course(self, opening: Opening, ending: E, before: E) -> Step:
        """Return the whole step, from its start, its end, and the end of the step before."""
        course = self._course(opening, ending, before)
        support = self._support.state(*course.whole)
        read = self._optional.values(self._optional.placed(course.whole[0]))
        return self._step(opening, ending, course, support, read)

    def course_derivatives(
        self, opening: Opening, ending: E, before: E, posture: PostureDerivatives
    ) -> tuple[Step, StepDerivatives]:
        """Return the step as `course` does, and its local derivatives; `posture` of its start."""
        course = self._course(opening, ending, before)
        support, at_support = self._support.derivatives(*course.whole)
        optional = self._optional.derivatives(
            self._optional.placed(course.whole[0]), at_support.axes, at_support.motion.tangent
        )
        read = {what: reading.value for what, reading in optional.items()}
        local = StepDerivatives(posture, ending.slopes, at_support, optional)
        return self._step(opening, ending, course, support, read), local

    def _step(
        self,
        opening: Opening,
        ending: E,
        course: Course,
        support: SupportState,
        read: dict[Quantity, Array],
    ) -> Step:
        if course.double is not None:
            own = course.double.without_front(support.effort, self.both)
            support = SupportState(own, support.corners)
        rate_before, impact, turn, landed = self._at_end(opening, ending, course)
        return Step(
            opening.z, opening.geometry, opening.posture, ending.q_end, rate_before, impact,
            course.coefficients, course.motion, support,
            self._completed(read, opening, ending.yaw_end), course.foot, turn, landed,
            flat=course.flat, double=course.double,
        )  # fmt: skip

    def _start_in_x(self) -> Array:
        """Derivatives in x of all coordinates of the double support at the start, (B, P)."""
        layout, found = self.layout, self.chart.matrix[self.layout.boundary]
        if layout.turning:
            row = int(np.flatnonzero(layout.boundary == layout.turn.start)[0])
            found[row] = self._before.matrix[layout.turn.start]
        whole = np.zeros((layout.boundary_size, found.shape[1]))  # what is fixed included
        whole[layout.boundary_columns] = found
        return whole

    @property
    def turns_foot(self) -> bool:
        """Whether the stance foot turns about a line of its sole."""
        return self.hinge is not None or self.line is not None

    @property
    def boundary(self) -> DoubleSupport:
        """The double support of the form that the layout has."""
        if isinstance(self._boundary, DoubleSupport):
            return self._boundary
        return cached_workspace(self.robot, self._boundary)

    @property
    def impact(self) -> Impact:
        """The impact of the robot."""
        if isinstance(self._impact, Impact):
            return self._impact
        return cached_workspace(self.robot, self._impact)

    def opening(self, x: Array, posture: Posture | None = None) -> Opening:
        """Return the double support at the start of the step.

        Args:
            x: parameters of the walk, shape (P,).
            posture: of it, if it was computed before.

        Raises:
            EvaluationError: a parameter is not finite, or a leg cannot reach.
        """
        if not np.isfinite(x).all():
            raise EvaluationError("a parameter is not finite")
        layout, z = self.layout, self.chart.of(x)
        geometry = layout.geometry_of(z)
        if layout.turning:  # the rear foot is as the step before leaves it
            geometry[FEET] = self._before.of(x)[layout.turn.start]
        if geometry[DURATION] <= 0.0:
            raise EvaluationError(f"a step of {geometry[DURATION]} s is not a step")
        if posture is None:
            posture = self.boundary.posture(geometry, z[layout.start])
        return Opening(z, geometry, posture)

    def opening_derivatives(self, opening: Opening) -> tuple[PostureDerivatives, Array]:
        """Return those of the double support, and of q_start in x, shape (n, P)."""
        found = self.boundary.derivatives(opening.posture)
        return found, found.q_start @ self.at_start

    def start_hessian(
        self, step: Step, derivatives: StepDerivatives, q_start: Array, first: dict[Quantity, Array]
    ) -> Array:
        """Return what the double support at the start bends, in its coordinates, shape (B, B).

        Args:
            q_start: weights of the posture, shape (n,).
            first: of the quantities.
        """
        return self.boundary.hessian(
            step.posture, derivatives.posture, q_start,
            first[quantities.LEGS], first[quantities.GAPS],
        )  # fmt: skip

    def turns(self, z: Array, turn_rate: float) -> list[tuple[FootTurn, Array]]:
        """Return the turns of the stance foot and what shapes each of them.

        Args:
            z: parameters of the step, shape (p,).
            turn_rate: that the impact before it leaves [rad/s].
        """
        turns = []
        if self.landing_turn is not None:
            turns.append((self.landing_turn, np.append(z[self.layout.landed], turn_rate)))
        if self.foot_turn is not None:
            turns.append((self.foot_turn, z[self.layout.turn]))
        return turns

    def sampled(self, step: Step) -> tuple[NDArray[np.int_], Array]:
        """Return the quadrature nodes that a gait holds, and their times [s], shape (k,) each."""
        nodes = np.arange(self.grid.nodes)
        return nodes, self.grid.instants[nodes] * step.duration

    def along(self, name: str) -> Array | None:
        """Return the derivatives of a geometric quantity in x, shape (P,); None where fixed."""
        column = self.layout.index(name)
        return None if column is None else self.chart.matrix[column]

    def _yaw_jacobian(self, yaw_end: Array | None) -> Array | None:
        """Derivatives of the foot yaw that the heading follows, at the instants, (N, P)."""
        start = self.along("foot_yaw")
        if start is None or yaw_end is None:
            return None
        return np.asarray(start + self.grid.instants[:, None] * (yaw_end - start))

    @cached_property
    def geometry_in_x(self) -> Array:
        """Derivatives of the geometric quantities in x, shape (G, P)."""
        found = np.zeros((len(self.layout.geometry), self.chart.matrix.shape[1]))
        found[self.layout.free] = self.chart.matrix[self.layout.shape]
        return found

    def _reads(
        self, local: StepDerivatives, motion: Array, effort: Array, yaw_end: Array | None
    ) -> dict[Quantity, Array]:
        """Derivatives of the quantities in x, all but those of impacts, a second foot, and gaps.

        Args:
            local: local derivatives.
            motion: derivatives of (q, dq, ddq), shape (N, 3 (h + n), P).
            effort: of wrench and torques, shape (N, 6 + h + n, P).
            yaw_end: of the foot yaw at the start of the next step, shape (P,); None where fixed.
        """
        posture, count = local.posture, len(motion)
        m = motion.shape[1] // 3
        h = m - self.layout.joints
        angles = motion[:, :m]
        yaw = self._yaw_jacobian(yaw_end) if quantities.TRUNK in local.optional else None
        hinges = motion.reshape(count, 3, m, -1)[:, :, :h]
        return {
            quantities.TORQUE: effort[:, 6 + h :],
            quantities.WRENCH: effort[:, :6],
            quantities.CORNERS: local.support.corners.reshape(count, -1, m) @ angles,
            quantities.ANGLES: angles[:, h:],
            quantities.RATES: motion[:, m + h : 2 * m],
            quantities.ACCELERATIONS: motion[:, 2 * m + h :],
            quantities.LEGS: posture.legs @ self.at_start,
            quantities.GAPS: posture.gaps @ self.at_start,
            quantities.TRAVEL: self.geometry_in_x[[STEP_LENGTH, DURATION]][None],
            quantities.FOOT_TURN: foot_turn_rows(hinges),
            quantities.PEAK: self._peak_in_x,
            quantities.ADVANCE: np.zeros((1, 0, motion.shape[2])),
            **chained(local.optional, angles, yaw),
        }

    @cached_property
    def _peak_in_x(self) -> Array:
        """Derivatives of the largest torque in x, the same at all instants, (N, 1 or 0, P)."""
        return np.tile(self.chart.matrix[self.layout.largest], (self.grid.count, 1, 1))

    def _turn_at_end(self, z: Array) -> Turning | None:
        """How the stance foot turns as the step ends; None where it stands flat."""
        if self.hinge is None:
            return None
        angle, *_, rate = z[self.layout.turn]
        return Turning(self.hinge, float(angle), float(rate))

    def _completed(
        self, read: dict[Quantity, Array], opening: Opening, yaw_end: float
    ) -> dict[Quantity, Array]:
        """The optional quantities, from what was read off the bodies."""
        start, count = opening.geometry[FOOT_YAW], self.grid.count
        found = completed(read, start + self.grid.instants * (yaw_end - start), count)
        peak = opening.z[self.layout.largest]
        found[quantities.PEAK] = np.full((count, peak.size), peak)
        return found


class StepModel(StepModelBase[Landing]):
    """Evaluates steps of one robot on one grid; every result is a pure function of x."""

    def _prepare(self) -> None:
        self.knots: Array = self.schedule.knots(self.layout.postures)
        """Shares of the step between which its motion is smooth, shape (m,)."""
        self.basis: Basis = spline_basis(self.knots, self.grid.instants)
        self._flat_impact: FlatImpact | None = None
        if self.schedule.slapping and self.line is not None:
            flat = float(self.schedule.changes[0])
            self.basis = jumping_spline(self.knots, self.grid.instants, flat)
            self._flat_impact = FlatImpact(self.robot, self.line)
            first = (int(np.argmin(np.abs(self.knots - flat))) - 1) * self.layout.joints
            # the posture there, and the rate of the foot, of which the jump is a function
            posture = range(first, first + self.layout.joints)
            self._at_flat = np.array([*posture, self.layout.landed.stop - 1])

    @property
    def flat_impact(self) -> FlatImpact:
        """The impact by which the foot comes to lie flat, of a schedule that has one."""
        assert self._flat_impact is not None
        return self._flat_impact

    @property
    def at_flat(self) -> Array:
        """Derivatives in x of the posture and of the foot's rate at that impact, (n + 1, P)."""
        found: Array = self.chart.matrix[self._at_flat]
        return found

    def swing_duration(self, step: Step) -> float:
        """Return for how long one foot swings [s]."""
        return step.duration

    def ending(self, opening: Opening, following: Opening, slopes: bool) -> Landing:
        """Return the end of the step and the impact, Eqs. (26) and (16) to (20)."""
        q_end, turn = self.exchange @ following.posture.q_start, self._turn_at_end(opening.z)
        at = q_end, opening.z[self.layout.rates], None if turn is None else turn.twist
        impact, derivatives = (
            self.impact.derivatives(*at) if slopes else (self.impact.state(*at), None)
        )
        landed = None
        if self.line is not None:
            angle = float(following.z[self.layout.landed][0])
            landed = Turning(self.line, angle, impact.turn_rate)
        yaw_end = float(following.geometry[FOOT_YAW])
        return Landing(q_end, yaw_end, derivatives, at[1], turn, impact, landed)

    def _at_end(
        self, opening: Opening, ending: Landing, course: Course
    ) -> tuple[Array, ImpactState, Turning | None, Turning | None]:
        del opening, course
        return ending.rate_before, ending.impact, ending.turn, ending.landed

    def _course(self, opening: Opening, ending: Landing, before: Landing) -> Course:
        z, geometry, flat = opening.z, opening.geometry, None
        rates = []
        if self._flat_impact is not None:
            *posture, rate = z[self._at_flat]
            flat = self._flat_impact.at(np.array(posture), float(rate))
            rates = [z[self.layout.flat], z[self.layout.flat] + flat.jump]
        rate_start = self.exchange @ before.impact.rate_after
        last = [*rates, ending.q_end, rate_start, ending.rate_before]
        knots = z[self.layout.knots].reshape(-1, self.layout.joints)
        coefficients = np.concatenate([opening.posture.q_start[None], knots, last])
        motion = self._motion(coefficients, geometry)
        foot = self._foot_motion(z, before.impact.turn_rate, geometry)
        return Course(coefficients, motion, foot, flat)

    def _motion(self, coefficients: Array, geometry: Array) -> Array:
        """q, dq, ddq at the instants, shape (3, N, n), Eqs. (42)-(44)."""
        motion = self.basis.at(geometry[DURATION]) @ coefficients
        return np.ascontiguousarray(motion.swapaxes(0, 1))

    def _foot_motion(self, z: Array, turn_rate: float, geometry: Array) -> Array:
        """Angles of the stance foot, rates and accelerations at the instants, shape (3, N, h)."""
        turns = self.turns(z, turn_rate)
        foot = np.zeros((3, self.grid.count, len(turns)))
        for column, (turn, shape) in enumerate(turns):
            foot[:, :, column] = (turn.basis.at(geometry[DURATION]) @ turn.coefficients @ shape).T
        return foot

    def ending_in_x(
        self, step: Step, local: StepDerivatives, q_end: Array, following: object
    ) -> Array:
        """Return the derivatives of the impact, shape (12 + n, P), or (13 + n, P) on a line."""
        del following
        impact, matrix = local.impact, self.chart.matrix
        assert impact is not None
        after = impact.posture @ q_end + impact.rate @ matrix[self.layout.rates]
        if step.turn is not None:
            rate = matrix[self.layout.turn.stop - 1]
            after += np.outer(impact.sole @ step.turn.hinge.twist, rate)
        return np.asarray(after)

    def chain(
        self,
        step: Step,
        local: StepDerivatives,
        postures: tuple[Array, Array],
        ends: tuple[Array, Array],
        before: Landing,
        following: StepModelBase[Landing] | None,
    ) -> StepDerivatives:
        (q_start, q_end), (after, at_start), turn_rate = postures, ends, before.impact.turn_rate
        landing_angle, yaw_end = None, None if following is None else following.along("foot_yaw")
        if following is None:  # its start is given, and constant
            yaw_end = np.zeros(q_end.shape[1])
        elif self.line is not None:
            landing_angle = following.chart.matrix[following.layout.landed.start]
        matrix, n = self.chart.matrix, self.layout.joints
        knots = matrix[self.layout.knots].reshape(self.layout.postures, n, -1)
        rate_start = self.exchange @ at_start[6 : 6 + n]
        rates, of_flat = [], np.zeros((0, matrix.shape[1]))
        if step.flat is not None:
            jump, of_flat = np.split(step.flat.along @ self.at_flat, [n])
            rates = [matrix[self.layout.flat], matrix[self.layout.flat] + jump]
        coefficients = np.concatenate(
            [q_start[None], knots, [*rates, q_end, rate_start, matrix[self.layout.rates]]]
        )
        turns = self._shaped(step, turn_rate, at_start)
        motion = self._motion_jacobian(step, coefficients, turns)
        effort = self._effort_jacobian(step, local.support.effort, motion)
        impulse = self._impulse_jacobian(step, after[6 + n : 12 + n], landing_angle)
        reads = {
            **self._reads(local, motion, effort, yaw_end),
            quantities.IMPULSE: impulse[None],
            quantities.SOLE_TWIST: self._sole_twist_jacobian(step, after[:6])[None],
            quantities.FRONT_WRENCH: self._front_jacobian(matrix.shape[1]),
            quantities.REAR_IMPULSE: of_flat[None],
        }
        angle = np.zeros(0) if landing_angle is None else landing_angle
        return StepDerivatives(
            local.posture, local.impact, local.support, local.optional,
            coefficients, motion, turns, angle,
            jacobians=Jacobians(reads, gap_products(local.optional, motion)),
        )  # fmt: skip

    def _shaped(self, step: Step, turn_rate: float, before: Array) -> tuple[ShapedTurn, ...]:
        """The turns of the stance foot, with the derivatives of what shapes them."""
        found, matrix = [], self.chart.matrix
        for turn, shape in self.turns(step.x, turn_rate):
            jacobian = matrix[self.layout.landed if turn.landed else self.layout.turn]
            if turn.landed:
                jacobian = np.concatenate([jacobian, before[-1:]])
            found.append(ShapedTurn(turn, shape, jacobian))
        return tuple(found)

    def _impulse_jacobian(self, step: Step, in_sole: Array, angle: Array | None) -> Array:
        """Derivatives of the impulse in the footprint, from those in the sole's frame, (6, P)."""
        if step.landed is None or angle is None:
            return in_sole
        by_angle = cross_force(step.landed.hinge.twist, step.impulse)
        return np.asarray(step.landed.on_ground @ in_sole + np.outer(by_angle, angle))

    def _sole_twist_jacobian(self, step: Step, in_sole: Array) -> Array:
        """Derivatives of the twist in the footprint, from those in the sole's frame, (6, P)."""
        if step.turn is None:
            return in_sole
        found = step.turn.place.toActionMatrix() @ in_sole
        by_angle = cross_motion(step.turn.hinge.twist, step.sole_twist)
        found += np.outer(by_angle, self.chart.matrix[self.layout.turn.start])
        return np.asarray(found)

    def _motion_jacobian(
        self, step: Step, coefficients: Array, turns: tuple[ShapedTurn, ...]
    ) -> Array:
        """Derivatives of (q, dq, ddq), the foot's turns in front of each, (N, 3 (h + n), P)."""
        T, lasts = step.duration, self.along("duration")
        joints = SplineInX(self.basis, T, step.coefficients, coefficients, lasts).motion()
        foot = [one.spline(T, lasts).motion() for one in turns]
        whole = np.concatenate([*foot, joints], axis=2) if foot else joints
        return whole.reshape(len(whole), -1, whole.shape[3])

    def _effort_jacobian(self, step: Step, effort: Array, motion: Array) -> Array:
        """Derivatives of wrench and torques in x, from those in the motion, (N, 6 + h + n, P)."""
        del step
        return np.asarray(effort @ motion)

    def _front_jacobian(self, size: int) -> Array:
        """Derivatives of the wrench on a second foot that stands in x, (N, 6, P); or none."""
        return np.zeros((self.grid.count, 0, size))

    def add_front_gradient(
        self, step: Step, derivatives: StepDerivatives, effort: Array, by_order: Array
    ) -> None:
        """Add what a second foot that stands takes off weighed efforts; here none does.

        Args:
            effort: weights of wrench and torques, shape (N, 6 + h + n).
            by_order: gradient in (q, dq, ddq), the foot's turn before each, (N, 3, h + n).
        """

    def on_coefficients(self, step: Step, by_order: Array) -> Array:
        """Return what a gradient in (q, dq, ddq) weighs on the joints' coefficients, (k + 4, n).

        Args:
            by_order: as of `add_front_gradient`.
        """
        return on_coefficients(self.basis, step.duration, by_order[:, :, step.hinges :])

    def motion_hessian(
        self,
        step: Step,
        derivatives: StepDerivatives,
        local: InverseDynamicsHessian,
        by_order: Array,
        effort: Array,
    ) -> Array:
        """Return what the motion bends of the function that weights differentiate, shape (P, P).

        Args:
            local: Hessian in (q, dq, ddq) at the instants.
            by_order, effort: gradient there and weights, as of `add_front_gradient`.
        """
        del effort  # no second foot takes a part of it
        T, h, lasts = step.duration, step.hinges, self.along("duration")
        H = self._in_pairs(step, derivatives, local)
        if lasts is not None:
            spline = SplineInX(self.basis, T, step.coefficients, derivatives.coefficients, lasts)
            H += spline.hessian(by_order[:, :, h:])
            for number, one in enumerate(derivatives.turns):
                H += one.spline(T, lasts).hessian(by_order[:, :, number : number + 1])
        return H

    def _in_pairs(
        self, step: Step, derivatives: StepDerivatives, local: InverseDynamicsHessian
    ) -> Array:
        """Sum over the instants of (d motion / d x)' local (d motion / d x), shape (P, P).

        The motion of every joint is the same linear map of its own K spline coefficients. Summed
        over the instants first, the local Hessians become one table of pairs of coefficients and
        pairs of joints: less than half of the time of a Hessian with 21 joints. Only its symmetric
        part counts, so that mixed blocks are there once, twice as large.
        """
        if step.hinges:  # the foot's turn has another map
            return local.through(derivatives.motion)
        basis, pairs = self._pairs(step.duration)
        width, n = basis.shape[2], self.layout.joints
        bent = np.concatenate([local.qq, local.qv, local.vv, local.qa]).reshape(len(pairs), -1)
        table = (pairs.T @ bent).reshape(width, width, n, n)
        table = table.swapaxes(1, 2).reshape(width * n, width * n)
        coefficients = _last(derivatives.coefficients).reshape(width * n, -1)
        H = self._through(table, coefficients)
        lasts = self.along("duration")
        if lasts is not None:  # the map itself depends on it
            stretched = self.basis.at(step.duration, 1) @ step.coefficients
            felt = local.along(stretched)
            weights = basis.reshape(-1, width).T @ felt.reshape(-1, n)
            both = np.outer(lasts, weights.ravel() @ coefficients)
            H += both + both.T + float(np.sum(stretched * felt)) * np.outer(lasts, lasts)
        return np.asarray(H)

    def _pairs(self, duration: float) -> tuple[Array, Array]:
        """Return the map from the coefficients, (N, 3, K), and its products in pairs, (4 N, K K).

        The products are those of the rows that qq, qv, vv and qa belong to, one after the other,
        the mixed ones twice as large. They are kept for one duration, which most walks share.
        """
        if duration not in self._kept_pairs:
            basis = _last(self.basis.at(duration).swapaxes(0, 2)).swapaxes(0, 2)
            q, dq, ddq = basis.swapaxes(0, 1)
            each = (q, q), (2.0 * q, dq), (dq, dq), (2.0 * q, ddq)
            pairs = np.concatenate([left[:, :, None] * right[:, None] for left, right in each])
            self._kept_pairs.clear()
            self._kept_pairs[duration] = basis, pairs.reshape(len(pairs), -1)
        return self._kept_pairs[duration]

    @cached_property
    def _kept_pairs(self) -> dict[float, tuple[Array, Array]]:
        return {}

    @cached_property
    def beyond_knots(self) -> slice:
        """Entries of x on which the ends of the step depend.

        Of a step by itself all but the postures at inner knots, which come first in x; else all.
        """
        alone = self.chart.offset is None and self._flat_impact is None
        return slice(self.layout.knots.stop if alone else 0, None)

    def _through(self, table: Array, coefficients: Array) -> Array:
        """Return C' T C, or what has its symmetric part, shape (P, P).

        Where nothing else depends on the postures at the inner knots, C takes them from x as they
        are, so that two thirds of the products are left out.

        Args:
            table: T, of pairs of coefficients, those postures first, shape (K n, K n).
            coefficients: C, their derivatives in x, shape (K n, P).
        """
        own, m = self.beyond_knots, self.beyond_knots.start
        C = coefficients[m:, own]
        H = np.zeros((coefficients.shape[1],) * 2)
        H[:m, :m] = table[:m, :m]
        H[:m, own] = (table[:m, m:] + table[m:, :m].T) @ C
        H[own, own] = C.T @ (table[m:, m:] @ C)
        return H


def _last(of_coefficients: Array) -> Array:
    """Return a table (K, ...) of the coefficients with that at the start as the last one."""
    return np.concatenate([of_coefficients[1:], of_coefficients[:1]])


@dataclass(frozen=True)
class Ends:
    """What steps that do not repeat begin with and end in, both given.

    Attributes:
        before: end of the step before the first one, there exchanged.
        after: start of the step after the last one, there exchanged.
    """

    before: Landing
    after: Opening


def cycle(
    models: Sequence[StepModelBase[Any]], x: Array, ends: Ends | None = None
) -> tuple[Step, ...]:
    """Return the steps of a walk that follow each other, the first again after the last.

    Each is seen from its own stance foot, as its mirror image where that is the other foot.

    Args:
        x: parameters of the walk, shape (P,).
        ends: of steps that do not repeat.

    Raises:
        EvaluationError: a parameter is not finite, or a leg cannot reach.
    """
    return tuple(
        model.course(opening, ending, before)
        for model, opening, ending, before in _begun(models, x, ends, None, False)
    )


def _begun(
    models: Sequence[StepModelBase[Any]],
    x: Array,
    ends: Ends | None,
    known: Sequence[Posture] | None,
    slopes: bool,
) -> list[tuple[StepModelBase[Any], Opening, Any, Any]]:
    """Return each step's model, start, end, and the end of the step before it."""
    postures = [None] * len(models) if known is None else known
    openings = [model.opening(x, at) for model, at in zip(models, postures, strict=True)]
    following = after_each(openings, None if ends is None else ends.after)
    each = zip(models, openings, following, strict=True)
    endings = [model.ending(opening, after, slopes) for model, opening, after in each]
    befores = before_each(endings, None if ends is None else ends.before)
    return list(zip(models, openings, endings, befores, strict=True))


def cycle_derivatives(
    models: Sequence[StepModelBase[Any]],
    x: Array,
    known: Sequence[Posture] | None = None,
    ends: Ends | None = None,
) -> tuple[tuple[Step, ...], tuple[StepDerivatives, ...]]:
    """Return the steps as `cycle` does, and their exact derivatives in x.

    Args:
        models, x, ends: as of `cycle`.
        known: the double supports at x, if they were computed before.

    Raises:
        EvaluationError: a parameter is not finite, or a leg cannot reach.
    """
    begun = _begun(models, x, ends, known, True)
    starts = [model.opening_derivatives(opening) for model, opening, *_ in begun]
    courses = [
        model.course_derivatives(opening, ending, before, posture)
        for (model, opening, ending, before), (posture, _) in zip(begun, starts, strict=True)
    ]
    q_starts = [q for _, q in starts]
    nothing = None if ends is None else np.zeros(q_starts[0].shape)  # what is given is constant
    q_ends = [m.exchange @ q for m, q in zip(models, after_each(q_starts, nothing), strict=True)]
    following = [*models[1:], models[0] if ends is None else None]
    left = [
        model.ending_in_x(step, local, q_end, after)
        for model, (step, local), q_end, after in zip(
            models, courses, q_ends, following, strict=True
        )
    ]
    leaving = before_each(left, None if ends is None else np.zeros(left[0].shape))
    derivatives = [
        model.chain(
            *courses[k], (q_starts[k], q_ends[k]), (left[k], leaving[k]), before, following[k]
        )
        for k, (model, _, _, before) in enumerate(begun)
    ]
    return tuple(step for step, _ in courses), tuple(derivatives)


def after_each(each: Sequence[T], last: T | None = None) -> list[T]:
    """Return what belongs to the step after each; after the last the first, or what is given."""
    return [*each[1:], each[0] if last is None else last]


def before_each(each: Sequence[T], first: T | None = None) -> list[T]:
    """Return what belongs to the step before each; before the first the last, or what is given."""
    return [each[-1] if first is None else first, *each[:-1]]
