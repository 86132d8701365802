"""The nonlinear program (48) of a walk: parameters in; cost, scaled rows and derivatives out."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from types import MappingProxyType
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from gaitopt.bounds import NUMBER, USABLE, is_line, is_of_use, shown
from gaitopt.contact import Schedule, check_contacts
from gaitopt.dataclass import dataclass
from gaitopt.errors import EvaluationError, InputError, own_code
from gaitopt.gait import quantities
from gaitopt.gait.constraint import Constraint, ConstraintBlock, ConstraintContext
from gaitopt.gait.constraints import CONSTRAINTS, Margins
from gaitopt.gait.costs import Cost, CostContext, cost_function
from gaitopt.gait.double_step import DoubleStepModel, double_cycle_hessian
from gaitopt.gait.functions import check_function
from gaitopt.gait.grid import STRIDE_EDGES, Grid, over_steps, parts
from gaitopt.gait.parameters import (
    FOOT_SPACING,
    GEOMETRY,
    STEP_LENGTH,
    Chart,
    GeometricParameter,
    Layout,
    set_geometry,
)
from gaitopt.gait.quantities import PEAK, Quantity, typical_entries
from gaitopt.gait.step import Period, Step, StepDerivatives
from gaitopt.gait.step_hessian import StepWeights, cycle_hessian, pairs_added
from gaitopt.gait.step_model import Ends, StepModel, cycle, cycle_derivatives
from gaitopt.gait.stride import (
    Steps,
    StepsLayout,
    Stride,
    StrideLayout,
    by_step,
    joined_blocks,
    split_weights,
    stride_jacobians,
    stride_layout,
)
from gaitopt.gait.task import Task
from gaitopt.gait.terrain import check_profile
from gaitopt.gait.walk_point import Jacobians, LinearRows, RowSlopes, WalkPoint
from gaitopt.model.robot import Robot
from gaitopt.model.scales import Scales
from gaitopt.nlp import NLP, Array, Point, ProgressCallback, Rows, Values, Variables
from gaitopt.settings import checked_arguments


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


@dataclass(frozen=True)
class _Derivatives:
    """A period of the walk with its derivatives.

    Attributes:
        x: parameters, shape (P,).
        whole: the step, or the stride.
        steps, derivatives: of which it consists.
        jacobians: of the quantities of the whole.
    """

    x: Array
    whole: Step | Steps
    steps: tuple[Step, ...]
    derivatives: tuple[StepDerivatives, ...]
    jacobians: Jacobians


VANISHED = 1e-3
"""Of the robot's momentum: a smaller impulse of the landing is none."""


class WalkProblem(NLP):
    """The walk of one robot for one task, on one grid of instants.

    What repeats is a step, exchanged, or a stride of two (`Task.steps`), its period. Instants and
    rows are of the whole period; its parameters are x, shape (P,).

    It keeps the last step and works in scratch shared with the other walks of the robot in its
    thread: not to be used by two threads.
    """

    blocks: tuple[ConstraintBlock, ...]
    edges: Array = STRIDE_EDGES
    """Shares of the period at which its steps begin and end, shape (steps + 1,)."""
    given: Ends | None = None
    """What the first step begins with and the last one ends in; None where they repeat."""
    _last_step: Step | Steps | None = None
    _last_derivatives: _Derivatives | None = None
    _last_values: Values | None = None
    _last_gradient: tuple[_Derivatives, dict[Quantity, Array]] | None = None
    _last_point: WalkPoint | None = None
    _linear: LinearRows | None = None
    _last_hessian: tuple[Array, Array, float, Array] | None = None  # after its three arguments

    @checked_arguments
    def __init__(
        self,
        robot: Robot,
        task: Task,
        grid: Grid | None = None,
        layout: Layout | StepsLayout | None = None,
        neighbour: WalkProblem | None = None,
        like: WalkProblem | None = None,
    ) -> None:
        """Pose the program.

        Args:
            grid: the task's, by default.
            layout: the task's, by default.
            neighbour: a walk whose last step is this one's too where only limits or cost differ.
            like: the same walk on another grid, if there is one, from which layout and what does
                not depend on the grid are taken.

        Raises:
            OptionError: the robot is no `Robot`, or the task no `Task`.
        """
        robot = robot.on_ground(task.ground.down)
        self.robot, self.task = robot, task
        self.robots = (robot, robot.on_ground(task.ground.in_mirror))[: task.steps]
        self.schedule = task.schedule
        self.grid = grid or task.grid
        if task.steps == 1:
            self.edges = np.array([0.0, 1.0])
        if like is not None:
            layout, self.variables = like.layout, like.variables
        self.layout: Layout | StepsLayout = layout or walk_layout(robot, task)
        known, names = {}, None
        if like is not None:
            known = {b.name: on for b in like.blocks if (on := b.on(self.grid))}
            names = {b.name for b in like.blocks}
        elif neighbour is not None and self._limits_as(neighbour):
            known = {b.name: b for b in neighbour.blocks if b.name not in _PACED}
        self.blocks = constraint_blocks(robot, task, self.grid, names, known)
        if like is not None and not task.extensions:  # one's own may depend on anything
            self.cost_scale = like.cost_scale
        penalty = task.penalty_weight if task.speed_as == "penalty" else 0.0
        self._set_up(task.speed if task.steps == 1 else task.pace, penalty)  # along the path
        if neighbour is not None and self._steps_as(neighbour):
            self._last_step = neighbour._last_step
            self._last_derivatives = neighbour._last_derivatives

    def _set_up(self, way: float, penalty: float = 0.0) -> None:
        """Make cost, models and limits, given robot, task, grid, edges, layout and blocks.

        Args:
            way: speed over which the cost is told [m/s]; 0: it is told per second.
            penalty: weight of the speed's deviation in the cost.
        """
        robot, cost = self.robot, self.task.cost
        one = len(self.edges) == 2
        rows, nodes = (self.grid, None) if one else by_step(self.grid, self.edges)
        context = CostContext(robot, rows, way, nodes)
        self.cost = cost_function(cost, context, penalty)
        if not hasattr(self, "cost_scale"):
            self.cost_scale = 1.0 / float(cost.typical(context))
        self.has_hessian = True
        self.read = {one for block in self.blocks for one in block.reads} | {*cost.reads}
        grids = (self.grid,) if one else parts(self.grid, self.edges, self.schedule.changes)
        steps = self.robots, self.layout, grids, self.read, self.schedule
        self.models: tuple[StepModel | DoubleStepModel, ...]  # of the steps, in their order
        if self.schedule.closing:
            self.models = _models(DoubleStepModel, *steps)
        else:
            self.models = _models(StepModel, *steps)
        self.model: StepModel | DoubleStepModel = self.models[0]
        if not hasattr(self, "variables"):
            lower, upper = self.layout.bounds()
            self.variables = Variables(self.layout.names, lower, upper, self.layout.scale())
        scales, lower, upper = (
            np.concatenate([table.ravel() for table in tables])
            for tables in zip(
                *((np.full(b.lower.shape, b.scale), b.lower, b.upper) for b in self.blocks),
                strict=True,
            )
        )
        self.rows, self._row_scales = Rows(lower / scales, upper / scales), scales
        self._edges = np.cumsum([0, *(block.size for block in self.blocks)])
        self._slices = [slice(*cut) for cut in pairwise(self._edges.tolist())]

    def _limits_as(self, other: WalkProblem) -> bool:
        """Whether limits are those of another walk, but for what depends on the walk's pace."""
        mine, its = self.task, other.task
        return (
            self.robot is other.robot
            and (mine.margins, mine.speed_as, mine.boundary, mine.steps)
            == (its.margins, its.speed_as, its.boundary, its.steps)
            and (mine.schedule, mine.ground) == (its.schedule, its.ground)
            and np.array_equal(self.grid.instants, other.grid.instants)
        )

    def _steps_as(self, other: WalkProblem) -> bool:
        """Whether each x is the same step as in another walk."""
        mine, its = self.layout, other.layout
        return (
            self.robot is other.robot
            and isinstance(mine, Layout)
            and isinstance(its, Layout)
            and mine.meaning == its.meaning
            and (self.schedule, self.read) == (other.schedule, other.read)
            and np.array_equal(self.grid.instants, other.grid.instants)
            and self.given is other.given is None
        )

    @cached_property
    def breaks(self) -> Array:
        """Shares (K,) of the period, from 0 to 1, between which every quantity is smooth."""
        model, knots = self.model, self.model.basis.knots
        turns = [turn for turn in (model.landing_turn, model.foot_turn) if turn is not None]
        knots = np.unique(np.concatenate([knots, *(turn.knots for turn in turns)]))
        if len(self.edges) > 2:
            return np.concatenate([[0.0], over_steps(knots, self.edges), [1.0]])
        return knots

    @property
    def changes(self) -> Array:
        """Shares (K,) of the period at which quantities may jump: phases and steps follow."""
        changes = self.schedule.changes
        if len(self.edges) == 2:
            return changes
        return over_steps(changes, self.edges)

    def with_grid(self, grid: Grid) -> WalkProblem:
        """Return the same walk looked at on another grid."""
        return WalkProblem(self.robot, self.task, grid, like=self)

    def with_task(self, task: Task) -> WalkProblem:
        """Return the walk of a task with other limits, on the same grid."""
        return WalkProblem(self.robot, task, self.grid)

    def step(self, x: Array) -> Step:
        """Return everything about the step at x, of a stride the first."""
        return self.steps(x)[0]

    def steps(self, x: Array) -> tuple[Step, ...]:
        """Return the step at x, or both steps of a stride."""
        whole = self.whole(x)
        return whole.steps if isinstance(whole, Steps) else (whole,)

    def starts(self, x: Array) -> tuple[Step, ...]:
        """Return the steps at x and the one after the last, which begins the period again."""
        steps = self.steps(x)
        return (*steps, steps[0])

    def time(self, share: float, x: Array) -> float:
        """Return the time at a share of the period [s]."""
        return share * self.whole(x).duration

    def whole(self, x: Array) -> Step | Steps:
        """Return everything about the period at x, a step or a stride (the last is kept)."""
        if self._last_derivatives is not None and np.array_equal(self._last_derivatives.x, x):
            return self._last_derivatives.whole
        if self._last_step is None or not np.array_equal(self._last_step.x, x):
            x = self.checked(x)
            self._last_step = self._joined(x, cycle(self.models, x.copy(), self.given))
        return self._last_step

    def checked(self, x: ArrayLike, what: str = "x") -> Array:
        """Return a copy of parameters, shape (P,).

        Raises:
            InputError: they are no numbers, or of another shape.
        """
        wanted = (
            f"give {self.layout.size} finite numbers, in the order of "
            "WalkProblem(robot, task).layout.names"
        )
        try:
            found = np.array(x, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InputError(f"{what} is no array of numbers; {wanted}") from error
        if found.shape != (self.layout.size,):
            raise InputError(f"{what} has shape {found.shape}; {wanted}")
        return found

    def derivatives(self, x: Array) -> tuple[Step, StepDerivatives]:
        """Return the step at x and its derivatives, of a stride the first."""
        found = self._derivatives(x)
        return found.steps[0], found.derivatives[0]

    def _joined(self, x: Array, steps: tuple[Step, ...]) -> Step | Steps:
        return steps[0] if len(steps) == 1 else Stride(x, steps, self.task.pace)

    def _together(self, derivatives: tuple[StepDerivatives, ...]) -> Jacobians:
        """Return the Jacobians of the quantities of the whole, from those of its steps."""
        if isinstance(self.layout, StrideLayout):
            return stride_jacobians(self.layout, derivatives, self.task.pace)
        return derivatives[0].jacobians

    def _derivatives(self, x: Array) -> _Derivatives:
        """Return the period at x with its derivatives (the last one is kept)."""
        if self._last_derivatives is None or not np.array_equal(self._last_derivatives.x, x):
            last, known = self._last_step, None
            if last is not None and np.array_equal(last.x, x):
                known = [one.posture for one in self.steps(x)]
            x = self.checked(x)
            steps, derivatives = cycle_derivatives(self.models, x, known, self.given)
            whole, jacobians = self._joined(x, steps), self._together(derivatives)
            self._last_derivatives = _Derivatives(x, whole, steps, derivatives, jacobians)
        return self._last_derivatives

    def values(self, x: Array) -> Values:
        step = self.whole(x)
        if self._last_values is None or self._last_values.x is not step.x:
            rows = self._row_values(step)
            for kept in (step.x, rows):  # and given to all who ask
                kept.setflags(write=False)
            self._last_values = Values(step.x, self.cost.value(step), rows)
        return self._last_values

    def point(self, x: Array) -> Point:
        found = self._derivatives(x)
        step, jacobians = found.whole, found.jacobians
        if self._last_point is not None and self._last_point.x is step.x:
            return self._last_point
        gradient = np.zeros(self.layout.size)
        for one, weight in self._cost_gradient(found).items():
            gradient += (weight[:, None] @ jacobians[one]).sum(axis=(0, 1))
        gradient.setflags(write=False)
        linear = self._linear_rows(step)
        slopes = RowSlopes(self.blocks, self._edges, linear, step.values, jacobians)
        # who asked for all rows at the last point asks for them at this one, too; and derivatives
        # of functions of one's own need not be finite where what these read is
        own = self.task.extensions or self.task.terrain is not None
        if own or (self._last_point is not None and self._last_point.slopes.asked):
            slopes.form()
        self._last_point = WalkPoint(self.values(x), gradient, slopes)
        return self._last_point

    def _cost_gradient(self, found: _Derivatives) -> dict[Quantity, Array]:
        """Return the derivatives of the cost in the quantities (the last ones are kept)."""
        if self._last_gradient is None or self._last_gradient[0] is not found:
            self._last_gradient = found, self.cost.gradient(found.whole)
        return self._last_gradient[1]

    def __getstate__(self) -> dict[str, object]:
        """Return what a copy has: it prepares its linear rows anew."""
        return vars(self) | {"_linear": None}

    def _linear_rows(self, step: Period) -> LinearRows:
        """Return what makes linear rows and their derivatives, made once."""
        if self._linear is None:
            self._linear = LinearRows(self.blocks, self._edges, step.values)
        return self._linear

    def weights(self, x: Array, multipliers: Array, cost_weight: float) -> dict[Quantity, Array]:
        """Return the derivatives of cost_weight * cost + multipliers . rows, (K, entries) each."""
        step = self.whole(x)
        weights = StepWeights.zero(step)
        for block, y in self._weighed(multipliers):
            first = block.function.vjp(block.take(step.values), y)
            weights.add(block.reads, block.where, first, None)
        for one, first in self.cost.gradient(step).items():
            weights.first[one] += cost_weight * first
        return weights.first

    def _weighed(self, multipliers: Array) -> Iterator[tuple[ConstraintBlock, Array]]:
        """Yield the blocks with multipliers, and these over the rows' scales, shape (K, r)."""
        weighed = multipliers / self._row_scales
        upto = np.flatnonzero(weighed).searchsorted(self._edges)
        for number in np.flatnonzero(np.diff(upto)):
            block = self.blocks[number]
            yield block, weighed[self._slices[number]].reshape(block.lower.shape)

    def hessian(self, x: Array, multipliers: Array, cost_weight: float) -> Array:
        if (last := self._last_hessian) is not None:
            *known, weight, H = last
            if weight == cost_weight and all(map(np.array_equal, known, (x, multipliers))):
                return H.copy()
        found = self._derivatives(x)
        step = found.whole
        weights = StepWeights.zero(step)
        for block, y in self._weighed(multipliers):
            entries = block.take(step.values)
            weights.add(
                block.reads, block.where,
                block.function.vjp(entries, y), block.function.hessian(entries, y),
            )  # fmt: skip
        if cost_weight != 0.0:
            for one, first in self._cost_gradient(found).items():
                weights.first[one] += cost_weight * first
            for pair, second in self.cost.hessian(step).items():
                weights.add_second(pair, slice(None), cost_weight * second)
        H = self.curvature(x, weights)
        if cost_weight != 0.0:
            H = H + self._between_rows(found, cost_weight)
        self._last_hessian = x.copy(), multipliers.copy(), cost_weight, H.copy()
        return H

    def is_tip(self, x: Array) -> bool:
        """Return whether the impulse of the landing all but vanishes.

        Where no impulse within the limits lifts the rear foot, as down stairs, they leave zero
        alone: docs/decisions/landing.md. Landing so may be asked for; then it is none, and
        neither where a double support begins gently, without any impulse.
        """
        margins, gentle = self.task.margins, self.schedule.closing and not self.schedule.striking
        if gentle or margins.soft_landing or margins.landing_speed is not None:
            return False
        whole = self.whole(x)
        momentum = self.robot.mass * abs(whole.step_length) / whole.duration
        pushes = np.linalg.norm([step.impulse[:3] for step in self.steps(x)], axis=1)
        return float(pushes.max()) <= VANISHED * momentum

    def cost_curvature(self, x: Array) -> Array | None:
        """Return the Hessian of the cost as if its quantities were linear in x, see `NLP`.

        Where only the legs move, searches with the Hessian itself are as short: None.
        """
        if self.robot.tree.serial:
            return None
        found = self._derivatives(x)
        second = self.cost.hessian(found.whole)
        if all(quantities.TRAVEL in pair for pair in second):
            return None  # as of a largest torque, which is linear
        weights = StepWeights.zero(found.whole)
        for pair, bent in second.items():
            weights.add_second(pair, slice(None), self.cost_scale * bent)
        H = pairs_added(np.zeros((x.size, x.size)), weights, found.jacobians)
        return H + self._between_rows(found, self.cost_scale)

    def _between_rows(self, found: _Derivatives, cost_weight: float) -> Array | float:
        """Return what a cost that mixes instants adds to its Hessian, (P, P) or 0."""
        H: Array | float = 0.0
        for one, (pairs, bent) in self.cost.neighbours(found.whole).items():
            first, second = (found.jacobians[one][pairs[:, end]] for end in (0, 1))
            weighed = (cost_weight * bent)[:, :, None] * second
            mixed = np.tensordot(first, weighed, ((0, 1), (0, 1)))
            H = H + mixed + mixed.T
        return H

    def curvature(self, x: Array, weights: StepWeights) -> Array:
        """Return the Hessian at x of the function that `weights` differentiates, shape (P, P)."""
        found = self._derivatives(x)
        single = len(found.steps) == 1
        each = [weights.first] if single else split_weights(weights.first, found.steps)
        steps = found.steps, found.derivatives, each
        if closing := [one for one in self.models if isinstance(one, DoubleStepModel)]:
            H = double_cycle_hessian(closing, *steps)
        else:
            models = [one for one in self.models if isinstance(one, StepModel)]
            H = cycle_hessian(models, *steps, self.given is None)
        return pairs_added(H, weights, found.jacobians)

    def describe(self, row: int) -> str:
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

    def check_own(self, x: Array) -> None:
        """Check that constraints and costs of one's own have finite values at x, and derivatives.

        Raises:
            InputError: one has none, and no solver could begin there, or reads what the walk does
                not have, or derivatives of the cost are wrong.
        """
        if not self.task.extensions:
            return
        own = {one.name for one in (*self.task.cost.constraints, *self.task.constraints)}
        step, advice = self.whole(x), "no solver can begin there; let it have one everywhere"
        reads = [(f"constraint '{b.name}'", b.reads) for b in self.blocks if b.name in own]
        for what, read in (*reads, (f"cost '{self.task.cost.name}'", self.task.cost.reads)):
            for one in read:
                if not step.read(one).size:
                    raise InputError(
                        f"the {what} reads {one}, which this walk does not have: {one.frame}"
                    )
        with np.errstate(all="ignore"):
            for block in self.blocks:
                values = block.function.value(block.take(step.values))
                if block.name in own and not np.isfinite(values).all():
                    instant, entry = np.argwhere(~np.isfinite(values))[0]
                    raise InputError(
                        f"the constraint '{block.name}' has no finite value at the first guess "
                        f"({block.describe(instant, entry)}); {advice}"
                    )
            if not np.isfinite(self.cost.value(step)):
                raise InputError(
                    f"the cost '{self.task.cost.name}' has no finite value at the first guess; "
                    f"{advice}"
                )
        if any(isinstance(one, Cost) for one in self.task.extensions):
            self._check_cost(x)

    def _check_cost(self, x: Array) -> None:
        """Compare derivatives of the cost with differences beside x, in one direction.

        Raises:
            InputError: one is wrong, or the cost writes into what it reads.
        """
        random, scale = np.random.default_rng(0), self.variables.scale
        at = x + _AWAY * scale * random.uniform(-1.0, 1.0, x.size)
        move = scale * random.uniform(0.5, 1.5, x.size)
        none = np.zeros(self.rows.lower.size)
        try:
            before, after = (self.point(at + way * _CHECK * move) for way in (-1.0, 1.0))
            for step in (self.whole(at), self._derivatives(at).whole):
                for entries in step.values.values():
                    entries.flags.writeable = False  # they are for all: nobody may write into them
            here, H = self.point(at), self.hessian(at, none, 1.0)
        except EvaluationError:
            return  # some walk farther on may have them
        for name, exact, found in (
            ("gradient", here.gradient * move, (after.cost - before.cost) / (2.0 * _CHECK)),
            ("hessian", H * move, (after.gradient - before.gradient) / (2.0 * _CHECK)),
        ):
            size = np.abs(exact).sum(axis=-1).max()
            apart = np.abs(exact.sum(axis=-1) - found).max()
            if not apart <= _APART * (size + np.abs(found).max()):
                of = "value; correct it"
                if name == "hessian":
                    of = (
                        "gradient; correct it, or leave it out: then it is taken from differences "
                        "(of a cost that mixes instants it cannot be: give hessian and neighbours)"
                    )
                raise InputError(
                    f"the {name} of the cost '{self.task.cost.name}' disagrees with differences of "
                    f"its {of}"
                )

    def _row_values(self, step: Period) -> Array:
        found, linear = np.empty(self._row_scales.size), self._linear_rows(step)
        linear.write(step.values, found)
        for number in linear.others:
            block, rows = self.blocks[number], self._slices[number]
            values = block.function.value(block.take(step.values))
            np.divide(values.ravel(), self._row_scales[rows], out=found[rows])
        return found


_AWAY = 1e-3  # of a walk whose cost is checked from the first guess, over the scales
_CHECK, _APART = 1e-5, 1e-4  # step of the differences over the scales; largest disagreement


MakeProgress = Callable[[WalkProblem], ProgressCallback]
"""Makes the progress callback of a walk, whose rows it can name."""


_PACED = frozenset(one.name for one in CONSTRAINTS if one.paced)


def constraint_blocks(
    robot: Robot,
    task: Task,
    grid: Grid,
    names: Container[str] | None = None,
    known: Mapping[str, ConstraintBlock] = MappingProxyType({}),
    margins: Margins | None = None,
) -> tuple[ConstraintBlock, ...]:
    """Return the rows of every constraint that a task asks for, its own ones last.

    Args:
        names: of the constraints that are wanted; None for all.
        margins: in place of the task's.
        known: rows that are at hand, by the names of their constraints, of walks of one step. Only
            those of built-in ones are used: one's own may depend on anything.

    Raises:
        InputError: the rows of a constraint of the task's own do not fit together, or a terrain of
            its own is not what it says.
    """
    if task.terrain is not None:
        with own_code(task.terrain, f"the terrain '{task.terrain.name}'"):
            check_profile(task.terrain, robot.sole, task.step_length, task.margins.nosing)
    margins = margins or task.margins
    contexts = [
        ConstraintContext(
            robot, own, margins, task.speed, task.duration, task.speed_as, task.boundary,
            task.schedule, task.ground, task.lateral_speed, task.turn_rate, task.steps,
        )
        for own in (parts(grid, STRIDE_EDGES, task.schedule.changes) if task.steps > 1 else [grid])
    ]  # fmt: skip
    found = asked_blocks(task, contexts, names, known if task.steps == 1 else {})
    return tuple(_over_period(blocks, grid, robot) for blocks in found)


def asked_blocks(
    task: Task,
    contexts: Sequence[ConstraintContext],
    names: Container[str] | None = None,
    known: Mapping[str, ConstraintBlock] = MappingProxyType({}),
) -> Iterator[list[ConstraintBlock]]:
    """Yield the rows over each of several steps of every constraint asked for, own ones last.

    Args:
        contexts: of each of them.
        names, known: as of `constraint_blocks`.

    Raises:
        InputError: the rows of a constraint of the task's own do not fit together.
    """
    for one in CONSTRAINTS:
        if one.name in known:
            yield [known[one.name]]
        elif (names is None or one.name in names) and one.asked(contexts[0]):
            yield [one.block(context) for context in contexts]
    for own in (*task.cost.constraints, *task.constraints):
        if (names is None or own.name in names) and _asked(own, contexts[0]):
            yield [_checked_block(own, context) for context in contexts]


def _over_period(blocks: list[ConstraintBlock], grid: Grid, robot: Robot) -> ConstraintBlock:
    """Return the rows of a constraint over a step, or over the steps of a stride."""
    if len(blocks) == 1 or blocks[0].reads == (quantities.ADVANCE,):
        return blocks[0]
    return joined_blocks(blocks, grid, STRIDE_EDGES, robot)


Kind = TypeVar("Kind", StepModel, DoubleStepModel)


def _models(
    kind: type[Kind],
    robots: tuple[Robot, ...],
    layout: Layout | StepsLayout,
    grids: tuple[Grid, ...],
    read: set[Quantity],
    schedule: Schedule,
) -> tuple[Kind, ...]:
    """Return the models of the steps of a period."""
    if isinstance(layout, Layout):
        return (kind(robots[0], layout, grids[0], read, schedule),)
    charts: tuple[Chart, ...] = layout.charts
    each = zip(robots, layout.steps, grids, charts, (charts[-1], *charts[:-1]), strict=True)
    return tuple(
        kind(robot, own, part, read, schedule, chart, before)
        for robot, own, part, chart, before in each
    )


def _asked(constraint: Constraint, context: ConstraintContext) -> bool:
    """Return whether a walk has a constraint of one's own.

    Raises:
        InputError: it cannot tell, as where it names a margin that is none.
    """
    what = f"the constraint '{constraint.name}' does not say whether it is asked for"
    with own_code(constraint, what):
        return bool(constraint.asked(context))


def _checked_block(constraint: Constraint, context: ConstraintContext) -> ConstraintBlock:
    """Return the rows of a constraint of one's own if they fit together.

    Raises:
        InputError: they do not.
    """
    where = f"the constraint '{constraint.name}'"
    block = _block_of(constraint, context, where)
    if not isinstance(block, ConstraintBlock):
        raise InputError(f"{where} returns no ConstraintBlock; return self.over_step(...)")
    texts = block.name, block.unit, block.words, *block.labels
    if isinstance(block.labels, str) or not all(map(is_line, texts)):
        raise InputError(
            f"the labels of {where} are {shown(block.labels)}, its unit is {shown(block.unit)}; "
            "give a tuple of texts for the rows, and texts of one line for name, unit and words"
        )
    if len({one.rows for one in block.reads}) != 1:
        raise InputError(
            f"{where} reads {shown(block.reads)}; give quantities of the same instants, one at "
            "least, as reads = (quantities.TORQUE,)"
        )
    _check_instants(block, context, where)
    _check_choice(constraint, block, context, where)
    shape = (len(block.instants), len(block.labels))
    typical = np.concatenate([typical_entries(one, context.robot) for one in block.reads])
    check_function(block.function, typical, shape[1], where)
    _check_limits(block, shape, where)
    scale = block.scale
    if not (_are_numbers(scale) and all(map(is_of_use, scale)) and (scale > 0.0).all()):
        raise InputError(f"the scale of {where} is {scale}; it must be above 0, {USABLE}")
    return block


def _check_instants(block: ConstraintBlock, context: ConstraintContext, where: str) -> None:
    instants, once = np.asarray(block.instants), bool(block.reads[0].rows)
    if once != (block.times is None):
        had, ask = ("once", "once") if once else ("at every instant", "over_step")
        raise InputError(
            f"{where} reads {block.reads[0]}, which a step has {had}; make its rows by self.{ask}"
        )
    last = (len(block.reads[0].rows) if block.times is None else context.grid.count) - 1
    if not (
        instants.ndim == 1
        and np.issubdtype(instants.dtype, np.integer)
        and ((instants >= 0) & (instants <= last)).all()
        and (np.diff(instants) > 0).all()
    ):
        raise InputError(
            f"the instants of {where} are {shown(instants.tolist())}; give indices from 0 to "
            f"{last} that increase"
        )


def _block_of(constraint: Constraint, context: ConstraintContext, where: str) -> ConstraintBlock:
    with own_code(constraint, f"{where} cannot make its rows"):
        return constraint.block(context)


_BESIDE = 1e-6  # share of a step: so near that an instant chosen as the nearest would change


def _check_choice(
    constraint: Constraint, block: ConstraintBlock, context: ConstraintContext, where: str
) -> None:
    """Check that rows at some instants are still there where a refinement has added others."""
    times, instants = block.times, np.sort(context.grid.instants)
    if times is None or len(times) == instants.size:
        return
    finer = context.grid.with_instants(np.r_[instants[:-1] + _BESIDE, instants[1:] - _BESIDE])
    again = _block_of(constraint, replace(context, grid=finer), where).times
    if again is None or (lost := np.setdiff1d(times, again)).size:
        at = times[0] if again is None else lost[0]
        raise InputError(
            f"{where} has a row at s = t/T = {at:.4g} at {instants.size} instants of the step, and "
            f"none there at {finer.count}: refinement adds instants at the end of the grid. Choose "
            "them by their times, as np.flatnonzero(context.grid.instants == context.touch_down)"
        )


def _are_numbers(values: Array) -> bool:
    return bool(np.issubdtype(values.dtype, np.number))


def _check_limits(block: ConstraintBlock, shape: tuple[int, int], where: str) -> None:
    lower, upper = block.lower, block.upper
    if not shape == lower.shape == upper.shape:
        raise InputError(f"the limits of {where} have shapes other than {shape}")
    if not (_are_numbers(lower) and _are_numbers(upper)):
        raise InputError(f"the limits of {where} are no numbers; leave out what has no limit")
    none = (lower == np.inf) | (upper == -np.inf)  # of any row
    huge = np.abs(np.where(np.isfinite([lower, upper]), [lower, upper], 0.0)).max(axis=0) > NUMBER
    wrong = ~(lower <= upper) | none | huge  # what is no number is wrong, too
    if wrong.any():
        instant, row = np.argwhere(wrong)[0]
        raise InputError(
            f"the limits of '{block.labels[row]}' of {where} are {lower[instant, row]} to "
            f"{upper[instant, row]} {block.unit}; give numbers, the lower not above the upper, "
            f"none above {NUMBER:g}, and leave out what has no limit"
        )
    if lower.size and not np.isfinite([lower, upper]).any():
        raise InputError(
            f"no row of {where} has a limit, so that it would constrain nothing; give lower= or "
            "upper=, or let its `asked` return False for walks that it means nothing to"
        )


def walk_layout(robot: Robot, task: Task) -> Layout | StrideLayout:
    """Return the layout of x for a task: its step duration, and its step length as first guess."""
    table = set_geometry(task.geometry, {"duration": {"value": task.duration}})
    if table[STEP_LENGTH].free:
        table = set_geometry(table, {"step_length": {"value": task.step_length}})
    table = _sized(table, robot.scales)
    table = _within_step_width(table, robot, task.margins.step_width)
    schedule = task.schedule
    check_contacts(schedule, robot.sole)
    landing, leaving = (
        phase.contact.hinge(robot.sole) is not None for phase in (schedule.first, schedule.last)
    )
    layout = Layout(
        robot.joint_names, task.postures, table, task.boundary == "lifted", leaving,
        task.ground.rise, landing, PEAK in task.cost.reads, schedule.closing, schedule.striking,
        schedule.slapping, robot.scales,
    )  # fmt: skip
    return layout if task.steps == 1 else stride_layout(layout, robot, task)


def _sized(table: tuple[GeometricParameter, ...], scales: Scales) -> tuple[GeometricParameter, ...]:
    """Return the table with steps in proportion to the robot, where none of one's own is given."""
    return tuple(
        replace(one, scale=size)
        if one.scale == usual.scale != (size := usual.scale * scales.of_unit(one.unit))
        else one
        for one, usual in zip(table, GEOMETRY, strict=True)
    )


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
