"""The nonlinear program (48) of a walk: parameters in; cost, scaled rows and derivatives out."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gaitopt.errors import GaitoptError, InputError
from gaitopt.gait.constraint import Constraint, ConstraintBlock, ConstraintContext, failure
from gaitopt.gait.constraints import CONSTRAINTS
from gaitopt.gait.costs import CostContext, cost_function
from gaitopt.gait.double_step import DoubleStepModel
from gaitopt.gait.functions import check_function
from gaitopt.gait.grid import Grid
from gaitopt.gait.parameters import (
    FOOT_SPACING,
    STEP_LENGTH,
    GeometricParameter,
    Layout,
    set_geometry,
)
from gaitopt.gait.quantities import PEAK, Quantity, typical_entries
from gaitopt.gait.step import Step, StepDerivatives
from gaitopt.gait.step_hessian import StepWeights, pairs_added, step_hessian
from gaitopt.gait.step_model import StepModel
from gaitopt.gait.task import Task
from gaitopt.gait.terrain import check_profile
from gaitopt.model.robot import Robot
from gaitopt.nlp import NLP, Array, Point, Rows, Values, Variables


@dataclass(frozen=True)
class RowAddress:
    """Where one row of the program comes from.

    Attributes:
        block: the rows of its constraint.
        instant: index into the block's instants.
        entry: which of its labels.
    """

    block: ConstraintBlock
    instant: int
    entry: int


class WalkProblem(NLP):
    """The walk of one robot for one task, on one grid of instants.

    It keeps the last step and works in scratch shared with the other walks of the robot in its
    thread: not to be used by two threads.
    """

    def __init__(self, robot: Robot, task: Task, grid: Grid | None = None) -> None:
        robot = robot.on_ground(task.ground.down)
        self.robot, self.task = robot, task
        self.schedule = task.schedule
        self.grid = grid or task.grid
        self.layout = walk_layout(robot, task)
        self.blocks = constraint_blocks(robot, task, self.grid)
        context = CostContext(robot, self.grid, task.speed)
        penalty = task.penalty_weight if task.speed_as == "penalty" else 0.0
        self.cost = cost_function(task.cost, context, penalty)
        self.cost_scale = 1.0 / task.cost.typical(context)
        self.has_hessian = True
        read = {one for block in self.blocks for one in block.reads} | {*task.cost.reads}
        evaluate = DoubleStepModel if self.schedule.closing else StepModel
        self.model: StepModel | DoubleStepModel = evaluate(
            robot, self.layout, self.grid, read, self.schedule
        )
        lower, upper = self.layout.bounds()
        self.variables = Variables(self.layout.names, lower, upper, self.layout.scale())
        self.rows = Rows(
            np.concatenate([(b.lower / b.scale).ravel() for b in self.blocks]),
            np.concatenate([(b.upper / b.scale).ravel() for b in self.blocks]),
        )
        self._row_scales = np.concatenate(
            [np.broadcast_to(b.scale, b.lower.shape).ravel() for b in self.blocks]
        )
        ends = np.cumsum([b.size for b in self.blocks])
        self._slices = [slice(e - b.size, e) for e, b in zip(ends, self.blocks, strict=True)]
        self._last_step: Step | None = None
        self._last_derivatives: tuple[Step, StepDerivatives] | None = None

    @cached_property
    def breaks(self) -> Array:
        """Shares of the step, from 0 to 1, between which every quantity is smooth."""
        model, knots = self.model, self.model.basis.knots
        turns = [turn for turn in (model.landing_turn, model.foot_turn) if turn is not None]
        return np.unique(np.concatenate([knots, *(turn.knots for turn in turns)]))

    def with_grid(self, grid: Grid) -> WalkProblem:
        """Return the same walk looked at on another grid."""
        return WalkProblem(self.robot, self.task, grid)

    def step(self, x: Array) -> Step:
        """Return everything about the step at x (the last one is kept)."""
        if self._last_derivatives is not None and np.array_equal(self._last_derivatives[0].x, x):
            return self._last_derivatives[0]
        if self._last_step is None or not np.array_equal(self._last_step.x, x):
            self._last_step = self.model.step(np.array(x))
        return self._last_step

    def derivatives(self, x: Array) -> tuple[Step, StepDerivatives]:
        """Return the step at x and its derivatives (the last one is kept)."""
        if self._last_derivatives is None or not np.array_equal(self._last_derivatives[0].x, x):
            step = self._last_step
            kept = step.posture if step is not None and np.array_equal(step.x, x) else None
            self._last_derivatives = self.model.derivatives(np.array(x), kept)
        return self._last_derivatives

    def values(self, x: Array) -> Values:
        """Return cost and scaled rows at x."""
        step = self.step(x)
        return Values(step.x, self.cost.value(step), self._row_values(step))

    def point(self, x: Array) -> Point:
        """Return cost, scaled rows and their exact derivatives at x."""
        step, derivatives = self.derivatives(x)
        gradient = np.zeros(self.layout.size)
        for one, weight in self.cost.gradient(step).items():
            gradient += (weight[:, None] @ derivatives.jacobians[one]).sum(axis=(0, 1))
        jacobian = np.empty((self.rows.lower.size, self.layout.size))
        for block, rows in zip(self.blocks, self._slices, strict=True):
            found = block.function.chained(
                block.take(step.values), block.take(derivatives.jacobians)
            )
            out = jacobian[rows].reshape(found.shape)
            np.multiply(found, block.per_unit, out=out)
        return Point(step.x, self.cost.value(step), self._row_values(step), gradient, jacobian)

    def weights(self, x: Array, multipliers: Array, cost_weight: float) -> dict[Quantity, Array]:
        """Return the derivatives of cost_weight * cost + multipliers . rows in the quantities."""
        step = self.step(x)
        weights, weighed = StepWeights.zero(step), multipliers / self._row_scales
        for block, rows in zip(self.blocks, self._slices, strict=True):
            y = weighed[rows].reshape(block.lower.shape)
            if y.any():
                first = block.function.vjp(block.take(step.values), y)
                weights.add(block.reads, block.where, first, None)
        for one, first in self.cost.gradient(step).items():
            weights.first[one] += cost_weight * first
        return weights.first

    def hessian(self, x: Array, multipliers: Array, cost_weight: float) -> Array:
        """Return the exact Hessian of cost_weight * cost + multipliers . rows."""
        step, derivatives = self.derivatives(x)
        weights = StepWeights.zero(step)
        weighed = multipliers / self._row_scales
        for block, rows in zip(self.blocks, self._slices, strict=True):
            y = weighed[rows].reshape(block.lower.shape)
            if y.any():
                entries = block.take(step.values)
                weights.add(
                    block.reads, block.where,
                    block.function.vjp(entries, y), block.function.hessian(entries, y),
                )  # fmt: skip
        if cost_weight != 0.0:
            for one, first in self.cost.gradient(step).items():
                weights.first[one] += cost_weight * first
            for pair, second in self.cost.hessian(step).items():
                weights.add_second(pair, slice(None), cost_weight * second)
        H = self.curvature(step, derivatives, weights)
        if cost_weight != 0.0:
            for one, (pairs, bent) in self.cost.neighbours(step).items():
                first, second = (derivatives.jacobians[one][pairs[:, end]] for end in (0, 1))
                weighed = (cost_weight * bent)[:, :, None] * second
                mixed = np.tensordot(first, weighed, ((0, 1), (0, 1)))
                H += mixed + mixed.T
        return H

    def curvature(self, step: Step, derivatives: StepDerivatives, weights: StepWeights) -> Array:
        """Return the Hessian in x of the function that `weights` differentiates, shape (P, P)."""
        if isinstance(self.model, DoubleStepModel):
            H = self.model.hessian(step, derivatives, weights)
            return pairs_added(H, weights, derivatives.jacobians)
        return step_hessian(self.model, step, derivatives, weights)

    def describe(self, row: int) -> str:
        """Name a row: "right_knee torque at 80.0 % of the step"."""
        at = self.address(row)
        return at.block.describe(at.instant, at.entry)

    def address(self, row: int) -> RowAddress:
        """Return where a row comes from."""
        for block, rows in zip(self.blocks, self._slices, strict=True):
            if row < rows.stop:
                instant, entry = divmod(row - rows.start, block.lower.shape[1])
                return RowAddress(block, instant, entry)
        raise IndexError(f"row {row} of {self.rows.lower.size}")

    def rows_of(self, name: str) -> slice:
        """Return the rows of the constraint of a given name."""
        index = [b.name for b in self.blocks].index(name)
        return self._slices[index]

    def _row_values(self, step: Step) -> Array:
        values = (b.function.value(b.take(step.values)).ravel() for b in self.blocks)
        return np.asarray(np.concatenate(list(values)) / self._row_scales)


def constraint_blocks(robot: Robot, task: Task, grid: Grid) -> tuple[ConstraintBlock, ...]:
    """Return the rows of every constraint that a task asks for, its own ones last.

    Raises:
        InputError: the rows of a constraint of the task's own do not fit together, or a terrain of
            its own is not what it says.
    """
    if task.terrain is not None:
        check_profile(task.terrain, robot.sole, task.step_length, task.margins.nosing)
    context = ConstraintContext(
        robot, grid, task.margins, task.speed, task.duration, task.speed_as, task.boundary,
        task.schedule, task.ground,
    )  # fmt: skip
    built_in = [one.block(context) for one in CONSTRAINTS if one.asked(context)]
    others = (*task.cost.constraints, *task.constraints)
    own = [_checked(one, context) for one in others if one.asked(context)]
    return (*built_in, *own)


def _checked(constraint: Constraint, context: ConstraintContext) -> ConstraintBlock:
    """Return the rows of a constraint of one's own if they fit together."""
    where = f"the constraint '{constraint.name}'"
    try:
        block = constraint.block(context)
    except GaitoptError:
        raise
    except Exception as error:
        raise InputError(f"{where} cannot make its rows: {failure(error, constraint)}") from error
    if not isinstance(block, ConstraintBlock):
        raise InputError(f"{where} returns no ConstraintBlock; return self.over_step(...)")
    if len({one.rows for one in block.reads}) != 1:
        raise InputError(f"{where} reads quantities with different rows: {block.reads}")
    shape = (len(block.instants), len(block.labels))
    typical = np.concatenate([typical_entries(one, context.robot) for one in block.reads])
    check_function(block.function, typical, shape[1], where)
    if not shape == block.lower.shape == block.upper.shape:
        raise InputError(f"the limits of {where} have shapes other than {shape}")
    if not (np.isfinite(block.scale).all() and (block.scale > 0.0).all()):
        raise InputError(f"the scale of {where} is {block.scale}; it must be above 0")
    return block


def walk_layout(robot: Robot, task: Task) -> Layout:
    """Return the layout of x for a task: its step duration, and its step length as first guess."""
    table = set_geometry(task.geometry, {"duration": {"value": task.duration}})
    if table[STEP_LENGTH].free:
        table = set_geometry(table, {"step_length": {"value": task.step_length}})
    table = _within_step_width(table, robot, task.margins.step_width)
    schedule = task.schedule
    landing, leaving = (
        phase.contact.hinge(robot.sole) is not None for phase in (schedule.first, schedule.last)
    )
    return Layout(
        robot.joint_names, task.postures, table, task.boundary == "lifted", leaving,
        task.ground.rise, landing, PEAK in task.cost.reads, schedule.closing,
    )  # fmt: skip


def _within_step_width(
    table: tuple[GeometricParameter, ...], robot: Robot, width: float | None
) -> tuple[GeometricParameter, ...]:
    """Return the table with the foot spacing bounded on the side of the swing foot."""
    spacing = table[FOOT_SPACING]
    if width is None or not spacing.free:
        return table
    if robot.legs.side > 0.0:
        return set_geometry(table, {"foot_spacing": {"upper": min(spacing.upper, width)}})
    return set_geometry(table, {"foot_spacing": {"lower": max(spacing.lower, -width)}})
