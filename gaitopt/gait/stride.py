"""A stride of two steps: its parameters, its steps side by side, and its rows.

Where a walk goes straight, the second step is the mirror image of the first and need not be
computed. Sideways and in turns it is another one. It is seen as its own mirror image all the same,
from its stance foot, so that the mechanics of one step serves both; what ends a step begins the
next (`gaitopt.gait.step_model.cycle`), and only the footprints tell how the stride goes.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.gait import quantities
from gaitopt.gait.constraint import ConstraintBlock
from gaitopt.gait.functions import ByStep
from gaitopt.gait.grid import Grid, step_of
from gaitopt.gait.parameters import (
    DURATION,
    FOOT_SPACING,
    FOOT_YAW,
    GEOMETRY_NAMES,
    PEAK_NAME,
    PELVIS_ROLL,
    PELVIS_YAW,
    Chart,
    GeometricParameter,
    Layout,
    set_geometry,
)
from gaitopt.gait.quantities import Quantity
from gaitopt.gait.step import Step, StepDerivatives
from gaitopt.gait.task import Task
from gaitopt.gait.walk_point import Jacobians, Stacked
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array

SECOND = "second_step_"
"""Before the name of a parameter of the second step, whose joints are those of its mirror image."""
SHARED = (FOOT_YAW, DURATION)
"""Rows of the geometry table that both steps share: their mean foot yaw, their duration."""
TURN_SIGNS = (-1.0, 1.0)
"""Foot yaw at the start of either step, less its mean, over the turn of the walk in a step."""


@dataclass(frozen=True)
class StepsLayout(ABC):
    """Where each parameter of several steps stands in x.

    Attributes:
        geometry: the table as it is asked for, complete.
        steps: layouts of the steps.
    """

    geometry: tuple[GeometricParameter, ...]
    steps: tuple[Layout, ...]

    @property
    def free(self) -> list[int]:
        """Rows of the geometry table that are in x."""
        return [i for i, quantity in enumerate(self.geometry) if quantity.free]

    @property
    @abstractmethod
    def largest(self) -> slice:
        """Entry of the largest torque; or none."""

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """Name of every entry of x."""

    @property
    @abstractmethod
    def own(self) -> tuple[NDArray[np.int_], ...]:
        """Entries of each step's parameters that x has for it alone, in their order in x."""

    @property
    @abstractmethod
    def others(self) -> Array:
        """Lower and upper bounds and scales of the entries of x after those, shape (k, 3)."""

    @cached_property
    def begins(self) -> list[int]:
        """Entry of x with which the own parameters of each step begin, and their end."""
        return [0, *np.cumsum([len(own) for own in self.own]).tolist()]

    @property
    def size(self) -> int:
        """Length of x."""
        return self.begins[-1] + len(self.others)

    @cached_property
    def charts(self) -> tuple[Chart, ...]:
        """Parameters of each step in x."""
        found = []
        for number, (layout, own) in enumerate(zip(self.steps, self.own, strict=True)):
            matrix, offset = np.zeros((layout.size, self.size)), np.zeros(layout.size)
            matrix[own, self.begins[number] + np.arange(len(own))] = 1.0
            self._complete(number, (matrix, offset))
            found.append(Chart(matrix, offset))
        return tuple(found)

    @abstractmethod
    def _complete(self, number: int, chart: tuple[Array, Array]) -> None:
        """Add to matrix and offset of a step's chart what is not its own."""

    @property
    def of_joints(self) -> list[int]:
        """Entries of x that are angles or rates of joints."""
        return [
            begin + k
            for begin, layout, own in zip(self.begins, self.steps, self.own, strict=False)
            for k in np.flatnonzero(np.isin(own, layout.of_joints)).tolist()
        ]

    @abstractmethod
    def index(self, name: str) -> int | None:
        """Return where a geometric quantity stands in x, of the first step, or None if fixed."""

    def bounds(self) -> tuple[Array, Array]:
        """Return lower and upper bounds of x, shape (P,) each."""
        lower, upper = zip(*(layout.bounds() for layout in self.steps), strict=True)
        return self._joined(lower, self.others[:, 0]), self._joined(upper, self.others[:, 1])

    def scale(self) -> Array:
        """Return the size of a sensible step of each entry of x, shape (P,)."""
        return self._joined([layout.scale() for layout in self.steps], self.others[:, 2])

    def _joined(self, parts: Sequence[Array], others: Array) -> Array:
        """Return an array of x from those of all steps (p,) and what comes after."""
        return np.concatenate([*(z[own] for z, own in zip(parts, self.own, strict=True)), others])

    @abstractmethod
    def pack(self, parts: Sequence[Array]) -> Array:
        """Return x from the parameters of all steps (p,)."""


@dataclass(frozen=True)
class StrideLayout(StepsLayout):
    """Where each parameter stands in x: first step, second step, then what they share.

    Attributes:
        geometry, steps: as of `StepsLayout`; steps begin with other foot yaws.
        turn_rate: of the walk [rad/s].
        yaw: mean foot yaw while that is fixed [rad].
        duration: of a step while that is fixed [s].
    """

    turn_rate: float
    yaw: float
    duration: float

    @cached_property
    def own(self) -> tuple[NDArray[np.int_], ...]:
        return tuple(
            np.array(
                [k for k, name in enumerate(layout.names) if name not in _SHARED_NAMES], dtype=int
            )
            for layout in self.steps
        )

    @property
    def largest(self) -> slice:
        return slice(self.begins[-1], self.begins[-1] + self.steps[0].peak)

    @cached_property
    def shared(self) -> list[str]:
        """Names of what both steps share and x holds once; the duration is the last."""
        names = [PEAK_NAME] if self.steps[0].peak else []
        return [*names, *(_name(row) for row in SHARED if self.geometry[row].free)]

    @cached_property
    def names(self) -> tuple[str, ...]:
        first, second = (
            [layout.names[k] for k in own] for layout, own in zip(self.steps, self.own, strict=True)
        )
        return (*first, *(SECOND + name for name in second), *self.shared)

    def index(self, name: str) -> int | None:
        return self.names.index(name) if name in self.names else None

    @cached_property
    def others(self) -> Array:
        return np.array([self._of_shared(name) for name in self.shared]).reshape(-1, 3)

    def _of_shared(self, name: str) -> tuple[float, float, float]:
        """Return bounds and scale of what both steps share."""
        if name == PEAK_NAME:
            first, at = self.steps[0], self.steps[0].largest.start
            lower, upper = first.bounds()
            return float(lower[at]), float(upper[at]), float(first.scale()[at])
        quantity = self.geometry[GEOMETRY_NAMES.index(name)]
        return quantity.lower, quantity.upper, quantity.scale

    def pack(self, parts: Sequence[Array]) -> Array:
        names = [layout.names for layout in self.steps]
        means = [
            np.mean([z[own.index(name)] for z, own in zip(parts, names, strict=True)])
            for name in self.shared
        ]
        return self._joined(parts, np.array(means))

    def _complete(self, number: int, chart: tuple[Array, Array]) -> None:
        layout, (matrix, offset) = self.steps[number], chart
        lasts, yaw = (self.index(_name(row)) for row in (DURATION, FOOT_YAW))
        sign = TURN_SIGNS[number] * self.turn_rate
        for name in set(layout.names) & {*_SHARED_NAMES}:
            at = layout.names.index(name)
            if name != _name(FOOT_YAW):
                matrix[at, self.index(name)] = 1.0
                continue
            if yaw is None:
                offset[at] = self.yaw
            else:
                matrix[at, yaw] = 1.0
            if lasts is None:
                offset[at] += sign * self.duration
            else:
                matrix[at, lasts] = sign


def _name(row: int) -> str:
    return GEOMETRY_NAMES[row]


_SHARED_NAMES = (*map(_name, SHARED), PEAK_NAME)


def stride_layout(layout: Layout, robot: Robot, task: Task) -> StrideLayout:
    """Return the layout of a stride.

    The mean foot yaw of the double supports stays what the task says; that at the start of a step
    is by the turn in a step less than the one at its end. Pelvis yaw and step width have more room
    by what that turns and widens; the pelvis' roll is against the vertical.

    Args:
        layout: of one step of the walk straight ahead.
    """
    table = layout.geometry
    turn, yaw = task.turn_rate * task.duration, table[FOOT_YAW]
    wider = 2.0 * abs(task.lateral_speed) * task.duration
    wider += robot.sole.length * abs(np.sin(turn))
    spacing, pelvis, roll = table[FOOT_SPACING], table[PELVIS_YAW], table[PELVIS_ROLL]
    across = task.ground.across_angle
    out = {"upper": spacing.upper + wider} if robot.legs.side > 0.0 else {
        "lower": spacing.lower - wider}  # fmt: skip
    steps = []
    for sign in TURN_SIGNS:
        changes: dict[str, dict[str, float | bool]] = {}
        moves = task.turn_rate != 0.0 and table[DURATION].free
        changes["foot_yaw"] = {"free": yaw.free or moves, "value": yaw.value + sign * turn}
        # On a slope across upright is against the vertical, not against the ground.
        for moved, by in ((pelvis, 0.5 * sign * turn), (roll, sign * across)):
            changes[moved.name] = {
                end: getattr(moved, end) + by for end in ("lower", "upper", "value")
            }
        if spacing.free and wider > 0.0:
            changes["foot_spacing"] = {**out}
        own = set_geometry(table, changes)
        steps.append(replace(layout, geometry=own))
    return StrideLayout(table, (steps[0], steps[1]), task.turn_rate, yaw.value, task.duration)


@dataclass(frozen=True)
class Steps(ABC):
    """Several steps, and the quantities of all of them one after another.

    Attributes:
        x: parameters, shape (P,).
        steps: every second one as its mirror image.
    """

    x: Array
    steps: tuple[Step, ...]

    @property
    @abstractmethod
    def duration(self) -> float:
        """Duration of all steps [s]."""

    @property
    @abstractmethod
    def step_length(self) -> float:
        """The way that is walked in them [m]."""

    @cached_property
    def values(self) -> dict[Quantity, Array]:
        """Every quantity, see `read`."""
        found = side_by_side([step.values for step in self.steps])
        found[quantities.TRAVEL] = np.array([[self.step_length, self.duration]])
        found[quantities.ADVANCE] = self._advance()
        return found

    @abstractmethod
    def _advance(self) -> Array:
        """Return the entries of `ADVANCE`, shape (1, 4), or (1, 0) where it has no meaning."""

    def read(self, what: Quantity) -> Array:
        """Return a quantity (K, entries), rows of each step after those of the one before."""
        return self.values[what]


@dataclass(frozen=True)
class Stride(Steps):
    """Two steps, and the quantities of both one after another.

    Attributes:
        x, steps: as of `Steps`.
        pace: speed along the path [m/s].
    """

    pace: float

    @property
    def duration(self) -> float:
        return 2.0 * self.steps[0].duration

    @property
    def step_length(self) -> float:
        return self.pace * self.duration

    def _advance(self) -> Array:
        (d, s, T), (d2, s2, _) = (step.geometry[list(_ADVANCE)] for step in self.steps)
        return np.array([[0.5 * (d + d2), 0.5 * (s2 - s), T, d]])


def side_by_side(
    each: Sequence[dict[Quantity, Array]], left_out: Collection[Quantity] = ()
) -> dict[Quantity, Array]:
    """Return quantities (K, entries) of steps one after another, or their Jacobians.

    A quantity without entries in some of them, as the wrench on a second foot that stands, is 0.
    """
    found = {}
    for what in (what for what in quantities.ALL if what not in left_out):
        parts, width = [one[what] for one in each], max(one[what].shape[1] for one in each)
        found[what] = np.concatenate(
            [
                part if part.shape[1] == width else np.zeros((len(part), width, *part.shape[2:]))
                for part in parts
            ]
        )
    return found


_ADVANCE = (GEOMETRY_NAMES.index("step_length"), FOOT_SPACING, DURATION)


def joined_jacobians(derivatives: Sequence[StepDerivatives]) -> Jacobians:
    """Return the derivatives of the quantities of steps one after another, (K, entries, P) each."""
    each = [one.jacobians for one in derivatives]
    products = {
        what: Stacked(tuple(part for one in each for part in one.products[what].each))
        for what in each[0].products
    }
    return Jacobians(side_by_side(each, products), products)


def stride_jacobians(
    layout: StrideLayout, derivatives: Sequence[StepDerivatives], pace: float
) -> Jacobians:
    """Return the derivatives of the quantities of a stride in x, (K, entries, P) each."""
    found = joined_jacobians(derivatives)
    d, s, T = ([_along(layout, k, GEOMETRY_NAMES[row]) for k in range(2)] for row in _ADVANCE)
    found[quantities.ADVANCE] = np.array([[0.5 * (d[0] + d[1]), 0.5 * (s[1] - s[0]), T[0], d[0]]])
    found[quantities.TRAVEL] = np.array([[2.0 * pace * T[0], 2.0 * T[0]]])
    return found


def _along(layout: StrideLayout, step: int, name: str) -> Array:
    at = layout.steps[step].index(name)
    return np.zeros(layout.size) if at is None else layout.charts[step].matrix[at]


def split_weights(
    weights: dict[Quantity, Array], steps: Sequence[Step]
) -> list[dict[Quantity, Array]]:
    """Return the weights of each step's quantities, of those of all steps, (K, entries) each."""
    found: list[dict[Quantity, Array]] = [{} for _ in steps]
    for what in quantities.ALL:
        ends = np.cumsum([len(step.read(what)) for step in steps])
        for own, part in zip(found, np.split(weights[what], ends)[:-1], strict=True):
            own[what] = part
    return found


def by_step(grid: Grid, edges: Array) -> tuple[Grid, NDArray[np.int_]]:
    """Return the instants of several steps in the order of their rows, and which are nodes.

    Rows of a step stand after all those of the step before, those that refinement added too.

    Args:
        edges: shares at which they begin and end, shape (steps + 1,).
    """
    order = np.argsort(step_of(grid.instants, edges), kind="stable")
    rows = Grid(grid.instants[order], grid.weights[order], grid.nodes)
    return rows, np.flatnonzero(order < grid.nodes)


def joined_blocks(
    blocks: Sequence[ConstraintBlock],
    grid: Grid,
    edges: Array,
    robot: Robot,
    period: str = "stride",
) -> ConstraintBlock:
    """Return the rows of a constraint over several steps, from those over each of them.

    Args:
        edges: shares at which they begin and end, shape (steps + 1,).
        period: what they are called together.
    """
    first, numbers = blocks[0], step_of(grid.instants, edges)
    if first.times is None:
        rows, times = [len(first.reads[0].rows)] * len(blocks), None
    else:
        rows = np.bincount(numbers, minlength=len(blocks)).tolist()
        times = np.concatenate(
            [grid.instants[numbers == k][block.instants] for k, block in enumerate(blocks)]
        )
    befores = [0, *accumulate(rows)]
    ends = tuple(accumulate(len(block.instants) for block in blocks))
    return replace(
        first,
        function=ByStep(tuple(b.function for b in blocks), ends),
        lower=np.concatenate([b.lower for b in blocks]),
        upper=np.concatenate([b.upper for b in blocks]),
        instants=np.concatenate(
            [before + b.instants for before, b in zip(befores, blocks, strict=False)]
        ),
        contacts=tuple(name for block in blocks for name in block.contacts),
        times=times,
        ends=ends,
        mirrored=tuple(map(_other_side(robot), first.labels)),
        period=period,
    )


def _other_side(robot: Robot) -> Callable[[str], str]:
    """Return what names a row of a mirror image by the joints and sides that it is of."""
    names = robot.joint_names
    partner = {name: names[int(np.abs(robot.mirror[k]).argmax())] for k, name in enumerate(names)}
    words = {**partner, "left": "right", "right": "left"}
    longest: Iterable[str] = sorted(words, key=len, reverse=True)
    pattern = re.compile(
        "|".join(rf"(?<![A-Za-z]){re.escape(word)}(?![A-Za-z])" for word in longest)
    )
    return lambda label: pattern.sub(lambda found: words[found[0]], label)
