"""Relaxed walks: how little must limits give, or one number of task or robot change, for a walk?

    minimise over x, t   t_1 + t_2 + ... + weights . x + epsilon/2 |(x - x_0) / scale|²
    subject to           lower <= c(x) + t_1 (A_1 + B_1 c(x)) + t_2 (A_2 + B_2 c(x)) + ... <= upper
                         0 <= t <= t_max

with c the scaled rows of the walk; its cost plays no part. Where a row has two limits and is
relaxed, it stands there twice, once for each limit. The sum of t (a 1-norm) keeps most of them at
exactly zero (Nocedal & Wright, 2006, section 17.2): what is left is a small set of limits that
conflict. B couples rows: a coefficient of friction multiplies the vertical force, which is a row
of its own. The weights ask for little of one variable instead. With neither t nor weights, the
program asks for the nearest walk.

An `Adjustment` is one number of the task or of the robot with the program that changes it least.
"""

from __future__ import annotations

import glob
from abc import ABC, abstractmethod
from dataclasses import field, replace

import numpy as np
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.gait.constraint import ConstraintBlock, declared_margins
from gaitopt.gait.constraints import CONSTRAINTS
from gaitopt.gait.parameters import FOOT_SPACING, set_geometry
from gaitopt.gait.presets import (
    bearable_torsion,
    humanoid_task,
    natural_duration,
    preset_task,
    widest,
)
from gaitopt.gait.problem import WalkProblem, constraint_blocks
from gaitopt.gait.task import Task
from gaitopt.model.import_options import LimitOverride
from gaitopt.model.robot import Robot
from gaitopt.nlp import NLP, Array, Point, Progress, Rows, Values, Variables
from gaitopt.solvers.globalization import Patience
from gaitopt.tolerances import FEASIBLE

REGULARITY = 1e-3
"""epsilon: the distance only chooses among walks that are equally near to the limits."""
STEP = 0.3
"""Scale of t for the solver; one unit of t is a change that matters."""
STRONGEST = 10.0  # times: no motor is asked to be stronger or faster than this
WIDEST = 1.0  # rad: no joint range is widened by more
SLOWEST = 0.05  # m/s, of the thirteen-link biped
UNUSUAL = 0.05  # of a change that matters: a value this far from the usual one was asked for
LONGEST, SHORTEST = 2.0, 0.5  # step duration over the one asked for
Indices = NDArray[np.int_]
Coupling = tuple[Indices, Indices, float]
_ROBOT_SETTINGS = ("robot torque limits", "robot speed limits", "robot joint ranges")


@dataclass(frozen=True)
class Relaxation:
    """One number t >= 0 that widens limits.

    Attributes:
        name: of what gives.
        lower, upper: by how much the lower limits fall and the upper ones rise per unit of t,
            scaled like the rows, shape (m,); at an equality by how much its value falls or rises.
        couplings: (rows, partners, factor): factor * partner is added to the row per unit of t.
        largest: bound on t.
    """

    name: str
    lower: Array
    upper: Array
    couplings: tuple[Coupling, ...] = ()
    largest: float = np.inf

    def relief(self, rows: Array, multipliers: Array) -> float:
        """Return how fast the objective of a relaxed program falls per unit of t.

        Args:
            rows: scaled rows at its solution, shape (m,).
            multipliers: of these rows there, shape (m,).
        """
        moved = np.where(multipliers < 0.0, self.lower, -self.upper)
        for target, partner, factor in self.couplings:
            moved[target] += factor * rows[partner]
        return -float(multipliers @ moved)

    @property
    def rows(self) -> NDArray[np.bool_]:
        """Which rows it relaxes, shape (m,)."""
        touched = np.asarray((self.lower != 0.0) | (self.upper != 0.0))
        for rows, _, _ in self.couplings:
            touched[rows] = True
        return touched


class RelaxedProgram(NLP):
    """A program whose limits give; its variables are (x, t)."""

    def __init__(
        self,
        base: NLP,
        relaxations: tuple[Relaxation, ...],
        centre: Array,
        weights: Array | None = None,
    ) -> None:
        """Relax a program.

        Args:
            centre: x_0, shape (n,).
            weights: linear objective on x, shape (n,), by default none.
        """
        self.base, self.relaxations, self.centre = base, relaxations, centre
        self.has_hessian, self.cost_scale = base.has_hessian, 1.0
        k, variables = len(relaxations), base.variables
        self.size = variables.lower.size
        self._weights = np.zeros(self.size) if weights is None else weights
        self._stiffness = REGULARITY / variables.scale**2
        self.variables = Variables(
            (*variables.names, *(r.name for r in relaxations)),
            np.append(variables.lower, np.zeros(k)),
            np.append(variables.upper, [r.largest for r in relaxations]),
            np.append(variables.scale, np.full(k, STEP)),
        )
        lower, upper = base.rows.lower, base.rows.upper
        relaxed = np.zeros(lower.size, dtype=bool)
        for r in relaxations:
            relaxed |= r.rows
        twice = np.flatnonzero(relaxed & np.isfinite(lower) & np.isfinite(upper) & (lower < upper))
        once = np.delete(np.arange(lower.size), twice)
        self.source = np.concatenate([once, twice, twice])
        """Row of the base behind every row, shape (M,)."""
        infinite = np.full(twice.size, np.inf)
        self.rows = Rows(
            np.concatenate([lower[once], lower[twice], -infinite]),
            np.concatenate([upper[once], infinite, upper[twice]]),
        )
        has_lower, has_upper = np.isfinite(self.rows.lower), np.isfinite(self.rows.upper)
        self._offsets = [
            np.where(has_lower, r.lower[self.source], 0.0)
            - np.where(has_upper, r.upper[self.source], 0.0)
            for r in relaxations
        ]

    def split(self, z: Array) -> tuple[Array, Array]:
        """Return x (P,) and t (k,) of the variables (P + k,)."""
        return z[: self.size], z[self.size :]

    def needed(self, x: Array) -> Array:
        """Return (x, t) with t just large enough for each relaxation's own rows at x.

        Couplings and rows that several relaxations share are ignored: the solver's matter.
        """
        rows = self.base.values(x).rows
        below, above = self.base.rows.lower - rows, rows - self.base.rows.upper
        t = [max(_ratio(below, r.lower), _ratio(above, r.upper), 0.0) for r in self.relaxations]
        return np.append(x, np.minimum(t, [r.largest for r in self.relaxations]))

    def values(self, z: Array) -> Values:
        x, t = self.split(z)
        at = self.base.values(x)
        return Values(z, self._objective(x, t), self._rows(at.rows, t))

    def point(self, z: Array) -> Point:
        x, t = self.split(z)
        at = self.base.point(x)
        jacobian = np.empty((self.source.size, z.size))
        jacobian[:, : x.size] = (at.jacobian + self._coupled(at.jacobian, t))[self.source]
        for i in range(t.size):
            jacobian[:, x.size + i] = self.column(i, at.rows)
        of_x = self._weights + self._stiffness * (x - self.centre)
        gradient = np.append(of_x, np.ones(t.size))
        return Point(z, self._objective(x, t), self._rows(at.rows, t), gradient, jacobian)

    def hessian(self, z: Array, multipliers: Array, cost_weight: float) -> Array:
        x, t = self.split(z)
        y = self.base_multipliers(multipliers)
        coupled_y = [self._coupled_multipliers(i, y) for i in range(t.size)]
        at_base = y + sum((t[i] * coupled_y[i] for i in range(t.size)), np.zeros(y.size))
        H = np.zeros((z.size, z.size))
        H[: x.size, : x.size] = self.base.hessian(x, at_base, 0.0)
        H[: x.size, : x.size] += cost_weight * np.diag(self._stiffness)
        for i in range(t.size):
            if coupled_y[i].any():
                H[: x.size, x.size + i] = coupled_y[i] @ self.base.point(x).jacobian
                H[x.size + i, : x.size] = H[: x.size, x.size + i]
        return H

    def describe(self, row: int) -> str:
        return self.base.describe(int(self.source[row]))

    def base_multipliers(self, multipliers: Array) -> Array:
        """Return the multipliers of the base's rows, those of both limits together, shape (m,)."""
        together = np.zeros(self.base.rows.lower.size)
        np.add.at(together, self.source, multipliers)
        return together

    def own_multipliers(self, multipliers: Array) -> Array:
        """Return multipliers of these rows that are those (m,) of the base's rows together."""
        both = multipliers[self.source]
        low = np.where(np.isfinite(self.rows.lower), np.minimum(both, 0.0), 0.0)
        return low + np.where(np.isfinite(self.rows.upper), np.maximum(both, 0.0), 0.0)

    def column(self, index: int, rows: Array) -> Array:
        """Return the derivative of the rows with respect to one t, shape (M,)."""
        moved = np.zeros(rows.size)
        for target, partner, factor in self.relaxations[index].couplings:
            moved[target] += factor * rows[partner]
        return np.asarray(self._offsets[index] + moved[self.source])

    def _objective(self, x: Array, t: Array) -> float:
        away = x - self.centre
        return float(t.sum() + self._weights @ x + 0.5 * away @ (self._stiffness * away))

    def _rows(self, rows: Array, t: Array) -> Array:
        moved: Array = rows[self.source]
        for i in range(t.size):
            moved = moved + t[i] * self.column(i, rows)
        return moved

    def _coupled(self, jacobian: Array, t: Array) -> Array:
        """Sum of t_i B_i J."""
        moved = np.zeros_like(jacobian)
        for relaxation, amount in zip(self.relaxations, t, strict=True):
            for target, partner, factor in relaxation.couplings:
                moved[target] += amount * factor * jacobian[partner]
        return moved

    def _coupled_multipliers(self, index: int, y: Array) -> Array:
        """B_i' y."""
        back = np.zeros(y.size)
        for target, partner, factor in self.relaxations[index].couplings:
            np.add.at(back, partner, factor * y[target])
        return back


def _ratio(missing: Array, rate: Array) -> float:
    """Largest missing / rate where a limit is missed and gives."""
    gives = (rate > 0.0) & (missing > 0.0)
    return float((missing[gives] / rate[gives]).max(initial=0.0))


@dataclass(frozen=True)
class Adjustment(ABC):
    """Something that can be turned, and the program that tells how far.

    Attributes:
        name: as in `Task` and `Margins`, or of a property of the robot.
        words: for a person.
        unit: of its value; empty where it has none.
        before: its value in the task.
        bound: the farthest value that makes sense.
        step: a change of it that matters, signed: one unit of t.
        constraints: constraints that it relaxes.
    """

    name: str
    words: str
    unit: str
    before: float
    bound: float
    step: float
    constraints: tuple[str, ...]

    @abstractmethod
    def changed(self, robot: Robot, task: Task, value: float) -> tuple[Robot, Task]:
        """Return robot and task with another value.

        Raises:
            InputError: the value is out of range.
        """

    @abstractmethod
    def program(self, problem: WalkProblem, start: Array) -> RelaxedProgram:
        """Return the program whose solution turns the setting the least.

        Args:
            start: variables as `start` returns them; the solution is sought near their x.
        """

    @abstractmethod
    def start(self, x: Array, amount: float) -> Array:
        """Return variables of the program: x (P,) of the walk, then the setting turned."""

    @abstractmethod
    def value(self, z: Array) -> float:
        """Return the setting's value at variables of the program, shape (P + 1,)."""

    def walk(self, z: Array) -> Array:
        """Return x (P,) of the walk at variables of the program, by default all but the last."""
        return z[:-1]


@dataclass(frozen=True)
class LimitAdjustment(Adjustment):
    """A number that enters the limits of rows linearly.

    Attributes:
        twists: whether the limit of torsional friction follows, as it does in the presets.
    """

    twists: bool = False

    def changed(self, robot: Robot, task: Task, value: float) -> tuple[Robot, Task]:
        if self.name in _ROBOT_SETTINGS:
            return _with_limits(robot, self.name, value), task
        if self.name == "speed":
            return robot, replace(task, speed=value)
        margins = {self.name: value}
        if self.twists:
            margins["torsional_friction"] = bearable_torsion(robot, value)
        return robot, task.with_margins(margins)

    def program(self, problem: WalkProblem, start: Array) -> RelaxedProgram:
        x = start[:-1]
        return RelaxedProgram(problem, (self.relaxation(problem, x),), x)

    def relaxation(self, problem: WalkProblem, x: Array) -> Relaxation:
        """Return how the rows' limits give per unit of t.

        A limit that gives only from some value on, as that of a pair of bodies that stand nearer
        than asked, gives evenly all the way to the bound instead. `shadow_prices` tells what little
        changes do.

        Args:
            x: its parameters, shape (P,), of which only a free duration matters.
        """
        size = problem.rows.lower.size
        lower, upper = np.zeros(size), np.zeros(size)
        couplings: tuple[Coupling, ...] = ()
        if self.name == "speed":
            given = upper if self.step < 0.0 else lower
            ahead = problem.rows_of("walking speed").start  # a stride's second row is to the left
            free = problem.layout.index("duration")
            given[ahead] = abs(self.step) * (problem.task.duration if free is None else x[free])
        else:
            robot, task = self.changed(problem.robot, problem.task, self.bound)
            share = self.step / (self.bound - self.before)
            changed = constraint_blocks(robot, task, problem.grid)
            for old, new in zip(problem.blocks, changed, strict=True):
                rows = problem.rows_of(old.name)
                lower[rows] = share * _moved(new.lower, old.lower, old.scale)
                upper[rows] = share * _moved(old.upper, new.upper, old.scale)
            couplings = self._couplings(problem, task, share, changed)
        largest = (self.bound - self.before) / self.step
        return Relaxation(self.name, lower, upper, couplings, largest)

    def start(self, x: Array, amount: float) -> Array:
        return np.append(x, min(amount, (self.bound - self.before) / self.step))

    def value(self, z: Array) -> float:
        return self.before + self.step * float(z[-1])

    def _couplings(
        self, problem: WalkProblem, task: Task, share: float, changed: tuple[ConstraintBlock, ...]
    ) -> tuple[Coupling, ...]:
        """Return which rows move with a force; a share of the way to the bound per unit of t."""
        present = {f.name: f for f in problem.blocks}
        others = {f.name: f for f in changed}
        found = []
        for constraint in (*CONSTRAINTS, *problem.task.constraints):
            name = constraint.name
            if name not in present:
                continue
            for margin, (force, sign) in constraint.couplings.items():
                rise = share * (_number(task, margin) - _number(problem.task, margin))
                rows = np.arange(problem.rows.lower.size)[problem.rows_of(name)]
                if rise == 0.0 or force not in present or rows.size % present[force].size:
                    continue  # nothing moves, or rows of one's own have no force each
                per_force = rows.size // present[force].size
                first = problem.rows_of(force).start
                partners = first + np.arange(rows.size) // per_force
                factor = float(present[force].scale[0] / present[name].scale[0])
                moves = _differ(present[name], others[name], problem.robot)
                found.append((rows[moves], partners[moves], sign * rise * factor))
        return tuple(found)


@dataclass(frozen=True)
class DurationAdjustment(Adjustment):
    """The duration of the step, made a variable of the walk."""

    def changed(self, robot: Robot, task: Task, value: float) -> tuple[Robot, Task]:
        return robot, replace(task, duration=value)

    def program(self, problem: WalkProblem, start: Array) -> RelaxedProgram:
        low, high = sorted((self.before, self.bound))
        free: dict[str, float | bool] = {"lower": low, "upper": high, "free": True}
        table = set_geometry(problem.task.geometry, {"duration": free})
        task = replace(problem.task, geometry=table)
        walk = WalkProblem(problem.robot, task, problem.grid)
        weights = np.zeros(walk.layout.size)
        weights[-1] = 1.0 / (self.bound - self.before)  # the last of the geometric quantities
        return RelaxedProgram(walk, (), start, weights)

    def start(self, x: Array, amount: float) -> Array:
        return np.append(x, self.before + min(amount, 1.0) * (self.bound - self.before))

    def value(self, z: Array) -> float:
        return float(z[-1])


@dataclass(frozen=True)
class StepWidthAdjustment(Adjustment):
    """The largest step width: a bound of the foot spacing, which is a variable of the walk.

    Attributes:
        index: of the foot spacing in x.
        side: sign of the foot spacing.
    """

    index: int
    side: float

    def changed(self, robot: Robot, task: Task, value: float) -> tuple[Robot, Task]:
        return robot, replace(task, margins=replace(task.margins, step_width=value))

    def program(self, problem: WalkProblem, start: Array) -> RelaxedProgram:
        least = {"lower": self.before} if self.side > 0.0 else {"upper": -self.before}
        table = set_geometry(problem.task.geometry, {"foot_spacing": {**least}})
        _, task = self.changed(problem.robot, replace(problem.task, geometry=table), self.bound)
        walk = WalkProblem(problem.robot, task, problem.grid)
        weights = np.zeros(walk.layout.size)
        weights[self.index] = self.side / (self.bound - self.before)
        return RelaxedProgram(walk, (), start, weights)

    def start(self, x: Array, amount: float) -> Array:
        z = x.copy()
        width = self.before + min(amount, 1.0) * (self.bound - self.before)
        z[self.index] = self.side * width
        return z

    def value(self, z: Array) -> float:
        return self.side * float(z[self.index])

    def walk(self, z: Array) -> Array:
        return z


def limit_adjustments(problem: WalkProblem, alone: bool = False) -> tuple[LimitAdjustment, ...]:
    """Return everything that can be turned in the limits of a walk.

    Args:
        alone: whether the limit of torsional friction stays while friction changes, even where it
            is, as in the presets, what the sole bears by it.
    """
    margins, task = problem.task.margins, problem.task
    present = {block.name for block in problem.blocks}
    settings = [*_motor_limits(problem)]
    for name, declared in task.declared.items():
        before, farthest = task.margin(name), declared.farthest
        words, loosened, twists = declared.words, constraints_of(task, name), False
        if name == "friction" and not alone:
            twists = margins.torsional_friction == bearable_torsion(problem.robot, margins.friction)
        if twists:
            words += ", and of torsional friction with it"
            loosened += constraints_of(task, "torsional_friction")
        if before is not None and farthest is not None and not present.isdisjoint(loosened):
            size = problem.robot.scales.of_unit(declared.unit)
            settings.append(
                LimitAdjustment(
                    name, words, declared.unit, before, size * farthest, size * declared.change,
                    loosened, twists,
                )
            )  # fmt: skip
    if margins.joint_range:
        words = "the joint ranges of the robot, widened at both ends"
        settings.append(
            LimitAdjustment("robot joint ranges", words, "rad", 0.0, WIDEST, 0.3, ("range",))
        )
    if task.speed_as == "constraint" and not task.ground.shaped:  # else steps are V T long
        words, relaxed, way = "the walking speed", ("walking speed",), float(np.sign(task.speed))
        pace = problem.robot.scales.speed
        slowest = way * pace * SLOWEST
        settings.append(
            LimitAdjustment("speed", words, "m/s", task.speed, slowest, -0.2 * pace * way, relaxed)
        )
    return tuple(k for k in settings if k.step and (k.bound - k.before) / k.step > 1e-9)


def constraints_of(task: Task, margin: str) -> tuple[str, ...]:
    """Return the names of the constraints that a margin loosens."""
    built_in = tuple(one.name for one in CONSTRAINTS if margin in one.margins)
    own = (one.name for one in task.constraints if margin in declared_margins(one))
    return (*built_in, *own)


def duration_adjustment(problem: WalkProblem, shorter: bool) -> DurationAdjustment:
    """Return the setting of the step duration, to be made shorter or longer."""
    before = problem.task.duration
    bound = before * (SHORTEST if shorter else LONGEST)
    return DurationAdjustment(
        "duration", "the duration of a step", "s", before, bound, before, ("walking speed",)
    )


def step_width_adjustment(problem: WalkProblem) -> StepWidthAdjustment | None:
    """Return the setting of the step width, to be made wider; None where nothing bounds it so."""
    before, legs = problem.task.margins.step_width, problem.robot.legs
    index = problem.layout.index("foot_spacing")
    if before is None or index is None or problem.task.steps > 1:  # of which there are two widths
        return None
    side = 1.0 if legs.side > 0.0 else -1.0
    given = problem.task.geometry[FOOT_SPACING]
    farthest = given.upper if side > 0.0 else -given.lower
    nearest = given.lower if side > 0.0 else -given.upper
    bound = min(before + legs.reach, farthest)
    if bound - before <= 1e-9 or nearest > before:
        return None
    words, loosened = "the largest step width", ("lateral", "leg gap")
    return StepWidthAdjustment(
        "step_width", words, "m", before, bound, 0.1, loosened, index=index, side=side
    )


def usual_value(problem: WalkProblem, setting: Adjustment) -> float | None:
    """Return the value of a setting in a usual task, if that asks for less; else None.

    Where the limit is usually not imposed, that is the setting's bound, or the robot's own motors.
    """
    robot, task = problem.robot, problem.task
    usual = humanoid_task(robot) if task.boundary == "lifted" else preset_task(robot=robot)
    if setting.name in _ROBOT_SETTINGS:
        return None
    if setting.name == "duration":
        natural = task.boundary == "lifted"
        value = natural_duration(robot, task.pace) if natural else usual.duration
    elif setting.name == "speed":
        value = float(np.clip(setting.before, -usual.speed, usual.speed))
    else:
        given = getattr(usual.margins, setting.name, None)
        if setting.name == "step_width" and given is not None:
            given = widest(robot, task.margins.lateral_gap)
        own = getattr(robot.limits, setting.name.removesuffix("_limit"), None)
        if given is None and own is not None and np.isfinite(own).any():
            given = float(np.max(own[np.isfinite(own)]))
        value = setting.bound if given is None else float(given)
    sign = 1.0 if setting.bound > setting.before else -1.0
    away = sign * (value - setting.before)
    return (
        value
        if away > UNUSUAL * abs(setting.step) and sign * (setting.bound - value) >= 0.0
        else None
    )


def _with_limits(robot: Robot, setting: str, value: float) -> Robot:
    """Return a robot with other limits, which its choices tell as well."""
    own = robot.limits
    if setting == "robot joint ranges":
        limits = replace(own, lower=own.lower - value, upper=own.upper + value)
    elif setting == "robot torque limits":
        limits = replace(own, torque=value * own.torque)
    else:
        limits = replace(own, speed=value * own.speed)
    changed = {
        name: getattr(limits, name)
        for name in ("torque", "speed", "lower", "upper")
        if getattr(limits, name) is not getattr(own, name)
    }
    overrides = tuple(
        LimitOverride(glob.escape(joint), **{n: float(v[i]) for n, v in changed.items()})  # type: ignore[arg-type]
        for i, joint in enumerate(robot.joint_names)
    )
    choices = robot.choices.over(limits=(*robot.choices.limits, *overrides))
    return replace(robot, limits=limits, choices=choices)


def _motor_limits(problem: WalkProblem) -> list[LimitAdjustment]:
    """Torque and speed of the motors: one number where all joints have the same limit."""
    settings = []
    for quantity, unit in (("torque", "N·m"), ("speed", "rad/s")):
        name, words = f"{quantity}_limit", f"the {quantity} limit of every joint"
        given = getattr(problem.task.margins, name)
        own = getattr(problem.robot.limits, quantity)
        if given is None and not np.isfinite(own).any():
            continue  # nothing to turn: the robot states no limit
        if given is None and len(set(own)) > 1:
            name, words = f"robot {quantity} limits", f"the {quantity} limits of the robot"
            unit, before = "times its own", 1.0
        else:
            before = float(own[0] if given is None else given)
        bound = STRONGEST * before
        if given is not None:  # the robot's own motors are no stronger than they are
            bound = max(bound, float(own[np.isfinite(own)].max(initial=0.0)))
        settings.append(LimitAdjustment(name, words, unit, before, bound, before, (quantity,)))
    return settings


def _number(task: Task, margin: str) -> float:
    return float(task.margin(margin) or 0.0)


def _moved(start: Array, end: Array, scale: Array) -> Array:
    """Scaled end - start of limits, zero where there are none."""
    there = np.isfinite(start)
    return (np.subtract(end, start, out=np.zeros(start.shape), where=there) / scale).ravel()


def _differ(old: ConstraintBlock, new: ConstraintBlock, robot: Robot) -> NDArray[np.bool_]:
    """Return which rows of blocks have other values where no quantity vanishes, shape (K r,)."""
    width = sum(len(one.labels(robot)) for one in old.reads)
    ones = np.ones((old.lower.shape[0], width))
    return np.asarray(old.function.value(ones) != new.function.value(ones)).ravel()


SUFFICIENT_DECREASE, FEASIBLE_STALL = 0.01, 8
"""A run ends when the objective of so many feasible iterates has not fallen by this share ..."""
INFEASIBLE_STALL = 15
"""... and one that is far from any when its violation no longer falls in so many iterations."""


@dataclass
class EarlyStopping:
    """Ends a run when it is good enough or gets nowhere; a `StopCallback`."""

    _objective: float = np.inf
    _idle: int = 0
    _patience: Patience = field(default_factory=lambda: Patience(INFEASIBLE_STALL))

    def __call__(self, progress: Progress) -> bool:
        """Look at an iteration; return whether the run may end."""
        stuck = self._patience.exhausted(progress.violation)
        if progress.violation <= FEASIBLE:
            if progress.cost < self._objective - SUFFICIENT_DECREASE * abs(progress.cost):
                self._objective, self._idle = progress.cost, 0
            else:
                self._idle += 1
        return stuck or self._idle >= FEASIBLE_STALL
