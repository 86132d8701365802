"""The nonlinear program (48) of a walk: parameters in; cost, scaled rows and derivatives out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitopt.gait.constraints import families
from gaitopt.gait.costs import TorqueCost
from gaitopt.gait.families import Family
from gaitopt.gait.grid import Grid, uniform_grid
from gaitopt.gait.parameters import (
    FOOT_SPACING,
    STEP_LENGTH,
    Layout,
    Quantity,
    set_quantities,
)
from gaitopt.gait.step import Reads, Step, StepSlope
from gaitopt.gait.step_hessian import StepWeights, step_hessian
from gaitopt.gait.step_model import StepModel
from gaitopt.gait.task import Task
from gaitopt.nlp import NLP, Array, Point, Rows, Values, Variables
from gaitopt.robot.model import Robot

_TYPICAL_EFFORT = 200.0  # cost of a good walk in units of (m g L)² T / d / 200; measured


@dataclass(frozen=True)
class RowAddress:
    """Where one row of the program comes from.

    Attributes:
        family: the family.
        instant: index into the family's instants.
        entry: which of its labels.
    """

    family: Family
    instant: int
    entry: int


class WalkProblem(NLP):
    """The walk of one robot for one task, on one grid of instants.

    It keeps the last step and works in scratch shared with the other walks of the robot in its
    thread: not to be used by two threads.
    """

    def __init__(self, robot: Robot, task: Task, grid: Grid | None = None) -> None:
        self.robot, self.task = robot, task
        self.grid = grid or uniform_grid(task.samples, task.quadrature)
        self.layout = walk_layout(robot, task)
        self.families = families(robot, task, self.grid)
        self.model = StepModel(robot, self.layout, self.grid, {f.reads for f in self.families})
        penalty = task.penalty_weight if task.speed_as == "penalty" else 0.0
        self.cost = TorqueCost(self.grid.weights, task.speed, penalty)
        self.has_hessian = True
        self.cost_scale = cost_scale(robot, task)
        lower, upper = self.layout.bounds()
        self.variables = Variables(self.layout.names, lower, upper, self.layout.scale())
        self.rows = Rows(
            np.concatenate([(f.lower / f.scale).ravel() for f in self.families]),
            np.concatenate([(f.upper / f.scale).ravel() for f in self.families]),
        )
        self._row_scales = np.concatenate(
            [np.broadcast_to(f.scale, f.lower.shape).ravel() for f in self.families]
        )
        ends = np.cumsum([f.size for f in self.families])
        self._slices = [slice(e - f.size, e) for e, f in zip(ends, self.families, strict=True)]
        self._last_step: Step | None = None
        self._last_slope: tuple[Step, StepSlope] | None = None

    def with_grid(self, grid: Grid) -> WalkProblem:
        """Return the same walk looked at on another grid."""
        return WalkProblem(self.robot, self.task, grid)

    def step(self, x: Array) -> Step:
        """Return everything about the step at x (the last one is kept)."""
        if self._last_slope is not None and np.array_equal(self._last_slope[0].x, x):
            return self._last_slope[0]
        if self._last_step is None or not np.array_equal(self._last_step.x, x):
            self._last_step = self.model.step(np.array(x))
        return self._last_step

    def slope(self, x: Array) -> tuple[Step, StepSlope]:
        """Return the step at x and its derivatives (the last one is kept)."""
        if self._last_slope is None or not np.array_equal(self._last_slope[0].x, x):
            step = self._last_step
            kept = step.posture if step is not None and np.array_equal(step.x, x) else None
            self._last_slope = self.model.slope(np.array(x), kept)
        return self._last_slope

    def values(self, x: Array) -> Values:
        """Return cost and scaled rows at x."""
        step = self.step(x)
        return Values(step.x, self.cost.value(step), self._row_values(step))

    def point(self, x: Array) -> Point:
        """Return cost, scaled rows and their exact derivatives at x."""
        step, slope = self.slope(x)
        gradient = np.zeros(self.layout.size)
        for what, weight in self.cost.slope(step).items():
            gradient += (weight[:, None] @ slope.reads[what]).sum(axis=(0, 1))
        jacobian = np.empty((self.rows.lower.size, self.layout.size))
        for family, rows in zip(self.families, self._slices, strict=True):
            quantity = family.take(step.read(family.reads))
            block = family.rows.jacobian(quantity, family.take(slope.reads[family.reads]))
            out = jacobian[rows].reshape(block.shape)
            np.multiply(block, family.per_unit, out=out)
        return Point(step.x, self.cost.value(step), self._row_values(step), gradient, jacobian)

    def hessian(self, x: Array, multipliers: Array, cost_weight: float) -> Array:
        """Return the exact Hessian of cost_weight * cost + multipliers . rows."""
        step, slope = self.slope(x)
        weights = StepWeights.zero(step)
        for what, weight in self.cost.slope(step).items():
            weights.first[what] += cost_weight * weight
        weighed = multipliers / self._row_scales
        for family, rows in zip(self.families, self._slices, strict=True):
            y = weighed[rows].reshape(family.lower.shape)
            if not y.any():
                continue
            quantity = family.take(step.read(family.reads))
            weights.first[family.reads][family.where] += family.rows.pull(quantity, y)
            bend = family.rows.curvature(quantity, y)
            if bend is not None:
                weights.bend(family.reads, family.where, bend)
        self._add_cost_curvature(step, weights, cost_weight)
        H = step_hessian(self.model, step, slope, weights)
        return H + cost_weight * self._coupling(step, slope)

    def describe(self, row: int) -> str:
        """Name a row: "right_knee torque at 80.0 % of the step"."""
        at = self.address(row)
        label = at.family.labels[at.entry]
        if at.family.reads is Reads.LEGS:
            return f"{('stance', 'swing')[at.instant]} leg {label}"
        if at.family.reads is Reads.GAPS:
            return f"{('pelvis', 'swing sole')[at.instant]} {label}"
        if at.family.times is None:
            return label
        return f"{label} at {100.0 * at.family.times[at.instant]:.1f} % of the step"

    def address(self, row: int) -> RowAddress:
        """Return where a row comes from."""
        for family, rows in zip(self.families, self._slices, strict=True):
            if row < rows.stop:
                instant, entry = divmod(row - rows.start, family.lower.shape[1])
                return RowAddress(family, instant, entry)
        raise IndexError(f"row {row} of {self.rows.lower.size}")

    def family_rows(self, name: str) -> slice:
        """Return the rows of the family of a given name."""
        index = [f.name for f in self.families].index(name)
        return self._slices[index]

    def _row_values(self, step: Step) -> Array:
        values = (f.rows.value(f.take(step.read(f.reads))).ravel() for f in self.families)
        return np.asarray(np.concatenate(list(values)) / self._row_scales)

    def _add_cost_curvature(self, step: Step, weights: StepWeights, cost_weight: float) -> None:
        diagonal = cost_weight * self.cost.torque_curvature(step)
        weights.bend(
            Reads.TORQUE, slice(None), diagonal[:, None, None] * np.eye(self.layout.joints)
        )
        weights.bend(Reads.TRAVEL, slice(None), cost_weight * self.cost.travel_curvature(step))

    def _coupling(self, step: Step, slope: StepSlope) -> Array:
        """The cost's mixed second derivatives in torque and travel."""
        effort, travel = self.cost.mixed_curvature(step)
        d_effort = (effort[:, None] @ slope.reads[Reads.TORQUE]).sum(axis=(0, 1))
        d_travel = travel @ slope.reads[Reads.TRAVEL][0]
        mixed = np.outer(d_effort, d_travel)
        return mixed + mixed.T


def walk_layout(robot: Robot, task: Task) -> Layout:
    """Return the layout of x for a task: its step duration, and its step length as first guess."""
    table = set_quantities(task.geometry, {"duration": {"value": task.duration}})
    if table[STEP_LENGTH].free:
        table = set_quantities(table, {"step_length": {"value": task.step_length}})
    table = _within_step_width(table, robot, task.margins.step_width)
    return Layout(robot.joint_names, task.postures, table, task.boundary == "lifted")


def _within_step_width(
    table: tuple[Quantity, ...], robot: Robot, width: float | None
) -> tuple[Quantity, ...]:
    """Return the table with the foot spacing bounded on the side of the swing foot."""
    spacing = table[FOOT_SPACING]
    if width is None or not spacing.free:
        return table
    if robot.legs.side > 0.0:
        return set_quantities(table, {"foot_spacing": {"upper": min(spacing.upper, width)}})
    return set_quantities(table, {"foot_spacing": {"lower": max(spacing.lower, -width)}})


def cost_scale(robot: Robot, task: Task) -> float:
    """Return the factor that makes the cost of a walk of order one.

    A stance leg that holds a small part of m g L for the time T / d per metre costs about
    (m g L)² T / d / 200.
    """
    weight = robot.mass * float(np.linalg.norm(robot.model.gravity.linear))
    typical = (weight * robot.legs.reach) ** 2 * task.duration / task.step_length
    return _TYPICAL_EFFORT / typical
