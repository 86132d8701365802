"""One step of the walk as a function of the parameters, in the order of the method.

    x -> boundary (26) -> impact (16)-(20), (27) -> spline (40)-(44) -> single support (1)-(13)

Derivatives take the same road: local ones at each instant with respect to (q, dq, ddq), then one
constant linear map to the spline's coefficients, then the coefficients' dependence on x.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from gaitopt.contact.schedule import Schedule
from gaitopt.errors import EvaluationError
from gaitopt.gait import quantities
from gaitopt.gait.double_support import (
    DoubleSupport,
    InverseKinematicsSupport,
    JointAngleSupport,
    Posture,
    PostureDerivatives,
    refuse_undetermined,
)
from gaitopt.gait.foot_turn import foot_turn
from gaitopt.gait.grid import Grid
from gaitopt.gait.parameters import DURATION, Layout
from gaitopt.gait.quantities import Quantity
from gaitopt.gait.spline import spline_basis
from gaitopt.gait.step import (
    PostureQuantities,
    Step,
    StepDerivatives,
    chained,
    completed,
    foot_turn_rows,
    with_foot,
)
from gaitopt.mechanics.cached_workspace import cached_workspace
from gaitopt.mechanics.forward_kinematics import PostureQuantityDerivatives
from gaitopt.mechanics.hinged import standing_robot
from gaitopt.mechanics.impact import Impact, ImpactDerivatives, Turning
from gaitopt.mechanics.single_support import SingleSupport, SupportDerivatives
from gaitopt.mechanics.spatial import cross_motion
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array


class StepModel:
    """Evaluates steps of one robot on one grid; every result is a pure function of x."""

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        grid: Grid,
        optional: Collection[Quantity] = (),
        schedule: Schedule | None = None,
    ) -> None:
        """Prepare what does not depend on x.

        Args:
            robot, layout, grid: of the walk.
            optional: which of the quantities that not every walk needs are to be computed.
            schedule: of the step; by default that of the paper.

        Raises:
            InputError: the layout's form of the double support does not suit the robot.
        """
        if not layout.lifted:
            refuse_undetermined(robot.tree)
        self.robot, self.layout, self.grid = robot, layout, grid
        self.schedule = schedule or Schedule()
        # Takes the joints from the end of a step to the start of the next, Eqs. (26) and (27).
        self.exchange = self.schedule.symmetry.joint_map(robot)
        self.basis = spline_basis(self.schedule.knots(layout.postures), grid.instants)
        contact = self.schedule.last.contact
        self.hinge = contact.hinge(robot.sole)
        self.foot_turn = None if self.hinge is None else foot_turn(self.schedule, grid.instants)
        self.standing = standing_robot(robot, contact)  # with the hinge of a foot that turns
        self._support = SingleSupport(self.standing, grid.count)
        self._optional = PostureQuantities(robot, optional, self.standing)
        form = JointAngleSupport if layout.lifted else InverseKinematicsSupport
        plain = self.hinge is None and layout.rise == 0.0
        self._boundary = form if plain else form(robot, self.hinge, layout.rise)

    @property
    def boundary(self) -> DoubleSupport:
        """The double support of the form that the layout has."""
        if isinstance(self._boundary, DoubleSupport):
            return self._boundary
        return cached_workspace(self.robot, self._boundary)

    @property
    def impact(self) -> Impact:
        """The impact of the robot."""
        return cached_workspace(self.robot, Impact)

    def step(self, x: Array) -> Step:
        """Return the step at x (P,).

        Raises:
            EvaluationError: a parameter is not finite, or a leg cannot reach.
        """
        geometry, posture = self._double_support(x)
        q_end, rate_before = self._end(x, posture)
        turn = self._turn_before_impact(x)
        impact = self.impact.state(q_end, rate_before, None if turn is None else turn.twist)
        rate_start = self.exchange @ impact.rate_after
        coefficients = self._coefficients(x, posture, q_end, rate_start, rate_before)
        motion, foot = self._motion(coefficients, geometry), self._foot_motion(x, geometry)
        whole = with_foot(foot, motion)
        support = self._support.state(*whole)
        read = self._optional.values(self._optional.placed(whole[0]))
        return Step(
            x, geometry, posture, q_end, rate_before, impact, coefficients, motion, support,
            completed(read, geometry, self.grid.count), foot, turn,
        )  # fmt: skip

    def derivatives(self, x: Array, posture: Posture | None = None) -> tuple[Step, StepDerivatives]:
        """Return the step at x (P,) and its exact derivatives.

        Args:
            x: parameters.
            posture: the double support at x, if a step there was computed before.

        Raises:
            EvaluationError: a parameter is not finite, or a leg cannot reach.
        """
        if posture is None:
            geometry, posture = self._double_support(x)
        else:
            geometry = self.layout.geometry_of(x)
        q_end, rate_before = self._end(x, posture)
        turn = self._turn_before_impact(x)
        impact, at_impact = self.impact.derivatives(
            q_end, rate_before, None if turn is None else turn.twist
        )
        rate_start = self.exchange @ impact.rate_after
        coefficients = self._coefficients(x, posture, q_end, rate_start, rate_before)
        motion, foot = self._motion(coefficients, geometry), self._foot_motion(x, geometry)
        whole = with_foot(foot, motion)
        support, at_support = self._support.derivatives(*whole)
        optional = self._optional.derivatives(self._optional.placed(whole[0]), at_support.axes)
        read = {what: reading.value for what, reading in optional.items()}
        step = Step(
            x, geometry, posture, q_end, rate_before, impact, coefficients, motion, support,
            completed(read, geometry, self.grid.count), foot, turn,
        )  # fmt: skip
        at_start = self.boundary.derivatives(posture)
        return step, self._chain(step, at_start, at_impact, at_support, optional)

    def _double_support(self, x: Array) -> tuple[Array, Posture]:
        if not np.all(np.isfinite(x)):
            raise EvaluationError("a parameter is not finite")
        geometry = self.layout.geometry_of(x)
        if geometry[DURATION] <= 0.0:
            raise EvaluationError(f"a step of {geometry[DURATION]} s is not a step")
        return geometry, self.boundary.posture(geometry, x[self.layout.start])

    def _end(self, x: Array, posture: Posture) -> tuple[Array, Array]:
        """Posture (26) and rates at the end of the step."""
        return self.exchange @ posture.q_start, x[self.layout.rates]

    def _coefficients(
        self, x: Array, posture: Posture, q_end: Array, rate_start: Array, rate_before: Array
    ) -> Array:
        knots = x[self.layout.knots].reshape(-1, self.layout.joints)
        return np.vstack([posture.q_start, knots, q_end, rate_start, rate_before])

    def _motion(self, coefficients: Array, geometry: Array) -> Array:
        """q, dq, ddq at the instants, shape (3, N, n), Eqs. (42)-(44)."""
        motion = self.basis.at(geometry[DURATION]) @ coefficients
        return np.ascontiguousarray(motion.swapaxes(0, 1))

    def _foot_motion(self, x: Array, geometry: Array) -> Array:
        """Angle of the stance foot, rate and acceleration at the instants, shape (3, N, h)."""
        if self.foot_turn is None:
            return np.zeros((3, self.grid.count, 0))
        coefficients = self.foot_turn.coefficients @ x[self.layout.turn]
        motion = self.foot_turn.basis.at(geometry[DURATION]) @ coefficients
        return np.ascontiguousarray(motion.T[:, :, None])

    def _turn_before_impact(self, x: Array) -> Turning | None:
        if self.hinge is None:
            return None
        turn = x[self.layout.turn]
        return Turning(self.hinge, float(turn[0]), float(turn[-1]))

    def _chain(
        self,
        step: Step,
        posture: PostureDerivatives,
        impact: ImpactDerivatives,
        support: SupportDerivatives,
        optional: dict[Quantity, PostureQuantityDerivatives],
    ) -> StepDerivatives:
        size, own, n = self.layout.size, self.layout.boundary_columns, self.layout.joints
        q_start = np.zeros((n, size))
        q_start[:, self.layout.boundary] = posture.q_start[:, own]
        rate_before = np.zeros((n, size))
        rate_before[:, self.layout.rates] = np.eye(n)
        q_end = self.exchange @ q_start
        after = impact.posture @ q_end + impact.rate @ rate_before
        if impact.sole is not None and step.turn is not None:
            after[:, self.layout.turn.stop - 1] += impact.sole @ step.turn.hinge.twist
        coefficients = self._coefficient_jacobian(q_start, q_end, after[6:-6], rate_before)
        motion = self._motion_jacobian(step, coefficients)
        legs = np.zeros((2, 3, size))
        legs[:, :, self.layout.boundary] = posture.legs[:, :, own]
        gaps = np.zeros((len(posture.gaps), 6, size))
        gaps[:, :, self.layout.boundary] = posture.gaps[:, :, own]
        travel = np.zeros((1, 2, size))
        for row, name in enumerate(("step_length", "duration")):
            column = self.layout.index(name)
            if column is not None:
                travel[0, row, column] = 1.0
        effort = support.effort @ motion
        h, m = step.hinges, step.hinges + n
        angles = motion[:, :m]
        corners = support.corners.reshape(len(motion), -1, m) @ angles
        reads = {
            quantities.TORQUE: effort[:, 6 + h :],
            quantities.WRENCH: effort[:, :6],
            quantities.CORNERS: corners,
            quantities.ANGLES: angles[:, h:],
            quantities.RATES: motion[:, m + h : 2 * m],
            quantities.ACCELERATIONS: motion[:, 2 * m + h :],
            quantities.IMPULSE: after[None, -6:],
            quantities.SOLE_TWIST: self._sole_twist_jacobian(step, after[:6])[None],
            quantities.LEGS: legs,
            quantities.GAPS: gaps,
            quantities.TRAVEL: travel,
            quantities.FOOT_TURN: foot_turn_rows(motion.reshape(len(motion), 3, m, size)[:, :, :h]),
            **chained(optional, angles, self.layout.index("foot_yaw")),
        }
        return StepDerivatives(posture, impact, support, optional, coefficients, motion, reads)

    def _sole_twist_jacobian(self, step: Step, in_sole: Array) -> Array:
        """Derivatives of the twist in the footprint, from those in the sole's frame, (6, P)."""
        if step.turn is None:
            return in_sole
        found = step.turn.place.toActionMatrix() @ in_sole
        found[:, self.layout.turn.start] += cross_motion(step.turn.hinge.twist, step.sole_twist)
        return np.asarray(found)

    def _coefficient_jacobian(
        self, q_start: Array, q_end: Array, rate_after: Array, rate_before: Array
    ) -> Array:
        postures, n = self.layout.postures, self.layout.joints
        jacobian = np.zeros((postures + 4, n, self.layout.size))
        jacobian[0] = q_start
        jacobian[1 : postures + 1, :, self.layout.knots] = np.eye(n * postures).reshape(
            postures, n, -1
        )
        jacobian[postures + 1] = q_end
        jacobian[postures + 2] = self.exchange @ rate_after
        jacobian[postures + 3] = rate_before
        return jacobian

    def _motion_jacobian(self, step: Step, coefficients: Array) -> Array:
        """Derivatives of (q, dq, ddq), with the foot's turn, at the instants, (N, 3 (h + n), P)."""
        count, width = self.grid.count, coefficients.shape[0]
        basis = self.basis.at(step.duration).reshape(3 * count, width)
        jacobian = basis @ coefficients.reshape(width, -1)
        jacobian = jacobian.reshape(count, 3 * self.layout.joints, -1)
        column = self.layout.index("duration")
        if column is not None:
            stretched = self.basis.at(step.duration, 1) @ step.coefficients
            jacobian[:, :, column] += stretched.reshape(count, -1)
        if self.foot_turn is None:
            return jacobian
        foot = np.zeros((count, 3, 1, self.layout.size))
        of_turn, duration = self.foot_turn, step.duration
        foot[:, :, 0, self.layout.turn] = of_turn.basis.at(duration) @ of_turn.coefficients
        if column is not None:
            coefficients = of_turn.coefficients @ step.x[self.layout.turn]
            foot[:, :, 0, column] = of_turn.basis.at(duration, 1) @ coefficients
        joints = jacobian.reshape(count, 3, self.layout.joints, -1)
        return np.concatenate([foot, joints], axis=2).reshape(count, -1, self.layout.size)
