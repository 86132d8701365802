"""A transition: steps from one given state to another, of rest or of a walk.

Each step is one of the walk's, see `gaitopt.gait.step_model.cycle`; what ends it begins the next.
Only the ends differ: the first step begins in the state of a walk after an impact, or at rest on
both feet, and the last one ends in the posture and with the rates from which the impact leads into
another walk, or at rest on both feet. Both are given, so that the parameters are what lies between:
the intermediate postures of all steps, the double supports where they meet, and the rates before
all impacts but the last. The mass matrix takes rates before an impact to those after it one to one,
so that nothing else would end in the same walk.

How a robot stands: at rest, feet side by side, its weight over the middle of the soles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field, replace
from functools import cached_property

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from gaitopt.bounds import is_finite, shown
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.gait import quantities
from gaitopt.gait.constraint import Constraint, ConstraintBlock, ConstraintContext
from gaitopt.gait.constraints import (
    FRONT,
    LEAST_FORCE,
    UNLIMITED_HEIGHT,
    Clearance,
    LandingSpeed,
    on_foot,
)
from gaitopt.gait.double_support import PELVIS_CHAIN, SWING_SOLE_CHAIN, place
from gaitopt.gait.functions import Linear
from gaitopt.gait.grid import Grid, parts, phase_grid
from gaitopt.gait.parameters import (
    DURATION,
    FOOT_SPACING,
    FOOT_YAW,
    GEOMETRY_NAMES,
    PELVIS_FORWARD,
    PELVIS_HEIGHT,
    PELVIS_LATERAL,
    PELVIS_ROLL,
    PELVIS_YAW,
    STEP_LENGTH,
    TRUNK_PITCH,
    Layout,
    set_geometry,
)
from gaitopt.gait.problem import WalkProblem, asked_blocks, walk_layout
from gaitopt.gait.quantities import Quantity
from gaitopt.gait.shift_step import SIZE as SHIFT_SIZE
from gaitopt.gait.shift_step import Shift, ShiftStepModel, shift_names, shift_scale, while_shifting
from gaitopt.gait.step import Step, StepDerivatives
from gaitopt.gait.step_model import Ends, Landing, Opening, StepModel
from gaitopt.gait.stride import Steps, StepsLayout, joined_blocks, joined_jacobians
from gaitopt.gait.task import Task
from gaitopt.gait.walk_point import Jacobians
from gaitopt.mechanics.impact import ImpactState
from gaitopt.mechanics.inverse_kinematics import LegKinematics
from gaitopt.model.joint_tree import TWIST
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array

PERIOD = "transition"
LAST_LOAD = 2.0 * LEAST_FORCE
"""With which the foot that swings presses on the ground as it leaves after a shift [N]."""
_SOON = 1e-9  # share of a swing, of instants before it
_FEET = (FOOT_SPACING, STEP_LENGTH, FOOT_YAW)


@dataclass(frozen=True, eq=False)
class Junction:
    """A state at which steps meet, seen from the foot that stands next.

    Attributes:
        geometry: geometric quantities of its double support, the duration among them (10,).
        q: joint angles [rad], shape (n,).
        rate: joint rates with which the next step begins [rad/s], shape (n,).
        rate_before: with which the step before it ends, joints as in that step [rad/s], (n,).
        rests: whether the robot is at rest on both feet, before and after.
    """

    geometry: Array
    q: Array
    rate: Array
    rate_before: Array
    rests: bool = False


def junction_of(problem: WalkProblem, x: Array) -> Junction:
    """Return the state with which a step of a cyclic walk at x (P,) begins."""
    step = problem.step(x)
    rate = problem.model.exchange @ step.impact.rate_after
    return Junction(step.geometry, step.posture.q_start, rate, step.rate_before)


@dataclass(frozen=True, eq=False)
class TransitionTask:
    """What is asked of a transition.

    Attributes:
        task: of its steps; speed and duration apart.
        begin, finish: the states between which it leads.
        durations: of its steps [s], one or more; where they are free, their first guess and what
            the steps weigh in the cost.
        free: whether the durations are parameters, within `ROOM` of those given.
        shift: time before the first step for which the weight moves over its stance foot while both
            feet stand [s]; 0: none. Only from rest; it lasts longer or shorter as the step does.
        front: wrench of the ground on the foot that swings first, in its sole frame, while the
            robot stands (6,) [N, N·m]; empty without a shift.
    """

    task: Task
    begin: Junction
    finish: Junction
    durations: tuple[float, ...]
    free: bool = False
    shift: float = 0.0
    front: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def lasts(self) -> tuple[float, ...]:
        """Duration of each step, the shift part of the first [s]."""
        first, *others = self.durations
        return (self.shift + first, *others)

    @property
    def shifted(self) -> float:
        """Share of the first step in which both feet stand."""
        return self.shift / self.lasts[0]

    @property
    def duration(self) -> float:
        """Of all steps [s]."""
        return float(sum(self.lasts))

    @property
    def changes(self) -> Array:
        """Shares of the transition at which the contacts change, shape (k,)."""
        lifts = [self.shifted * self.edges[1]] if self.shift else []
        return np.array([*lifts, *self.edges[1:-1]])

    @cached_property
    def edges(self) -> Array:
        """Shares of the transition at which steps begin and end, shape (steps + 1,)."""
        ends = np.cumsum(self.lasts) / self.duration
        ends[-1] = 1.0
        return np.concatenate([[0.0], ends])

    @cached_property
    def grid(self) -> Grid:
        """The instants at which it is looked at first."""
        count = len(self.durations) * (self.task.samples - 1) + 1
        return phase_grid(count, self.task.quadrature, self.changes)


@dataclass(frozen=True)
class TransitionLayout(StepsLayout):
    """Where each parameter of a transition stands in x: step after step.

    Attributes:
        geometry, steps: as of `StepsLayout`.
        begin, finish: the given states.
        shifts: whether the first step begins with a shift of the weight: then the posture in which
            the foot leaves is free, but for where the feet are.
    """

    begin: Junction
    finish: Junction
    shifts: bool = False

    @cached_property
    def own(self) -> tuple[NDArray[np.int_], ...]:
        found = []
        for number, layout in enumerate(self.steps):
            free = np.ones(layout.size, dtype=bool)
            if number == 0:
                free[layout.boundary] = False
                free[layout.start] = self.shifts
                free[[k for name in self._of_first if (k := layout.index(name)) is not None]] = True
            if number == len(self.steps) - 1:
                free[layout.rates] = False
            found.append(np.flatnonzero(free))
        return tuple(found)

    @property
    def _of_first(self) -> tuple[str, ...]:
        """Free geometric quantities of the first step: after a shift all but those of the feet."""
        if not self.shifts:
            return ("duration",)
        return tuple(name for k, name in enumerate(GEOMETRY_NAMES) if k not in _FEET)

    @property
    def shift(self) -> slice:
        """Entries of the shift; or none."""
        return slice(self.begins[-1], self.size)

    @cached_property
    def others(self) -> Array:
        if not self.shifts:
            return np.zeros((0, 3))
        free = np.full(SHIFT_SIZE, np.inf)
        return np.stack([-free, free, shift_scale(self.steps[0].scales)], axis=1)

    @property
    def largest(self) -> slice:
        return slice(self.size, self.size)

    @cached_property
    def names(self) -> tuple[str, ...]:
        names = [
            f"step_{number + 1}_{layout.names[k]}"
            for number, (layout, own) in enumerate(zip(self.steps, self.own, strict=True))
            for k in own
        ]
        return (*names, *(shift_names(self.steps[0].joint_names) if self.shifts else ()))

    @property
    def of_joints(self) -> list[int]:
        return [*super().of_joints, *range(self.shift.start, self.shift.stop)[:TWIST]]

    def index(self, name: str) -> int | None:
        found = [k for k, one in enumerate(self.names) if one.endswith(f"_{name}")]
        return found[0] if found else None

    def pack(self, parts: Sequence[Array], shift: Array | None = None) -> Array:
        return self._joined(parts, np.zeros(0) if shift is None else shift)

    def _complete(self, number: int, chart: tuple[Array, Array]) -> None:
        layout, own, (_, offset) = self.steps[number], self.own[number], chart
        if number == 0:
            offset[layout.start] = self.begin.q[: layout.joints * layout.lifted]
            offset[layout.shape] = self.begin.geometry[layout.free]
            offset[own] = 0.0
        if number == len(self.steps) - 1:
            offset[layout.rates] = self.finish.rate_before


@dataclass(frozen=True)
class TransitionSteps(Steps):
    """Steps of a transition, and the quantities of all of them one after another.

    Attributes:
        x, steps: as of `Steps`.
        last_length: of the last step, which its end gives [m].
    """

    last_length: float

    @property
    def duration(self) -> float:
        return sum(step.duration for step in self.steps)

    @property
    def step_length(self) -> float:
        return sum(self.lengths)

    @property
    def lengths(self) -> tuple[float, ...]:
        """Of each step [m]: how far its foot lands ahead, with which the next one begins."""
        return (*(step.step_length for step in self.steps[1:]), self.last_length)

    def _advance(self) -> Array:
        return np.zeros((1, 0))


class TransitionProblem(WalkProblem):
    """The nonlinear program of a transition: the mean over its steps of the cost per second.

    Each step counts by the duration that is given. Constraints, certificate and refinement are
    those of a walk; instants are shares of all steps, x has all their parameters, shape (P,).
    """

    models: tuple[StepModel, ...]

    def __init__(self, robot: Robot, transition: TransitionTask, grid: Grid | None = None) -> None:
        task = transition.task
        robot = robot.on_ground(task.ground.down)
        self.robot, self.task, self.transition = robot, task, transition
        self.robots = (robot,) * len(transition.durations)
        self.schedule, self.grid = task.schedule, grid or transition.grid
        self.edges = transition.edges
        self.layout = transition_layout(robot, transition)
        self.blocks = _blocks(robot, transition, self.grid)
        self._set_up(0.0)
        if transition.shift:
            self.models = (self._shifting(self.models[0]), *self.models[1:])
            self.model = self.models[0]
        self.given = self._given()

    def _shifting(self, model: StepModel) -> StepModel:
        """Return the model of the first step, which begins with a shift of the weight."""
        asked = self.transition
        load = LAST_LOAD * self.robot.scales.force  # as good as nothing
        last = asked.front * (load / asked.front[2])  # where it presses
        layout = self.layout
        assert isinstance(layout, TransitionLayout)
        shift = Shift(asked.shifted, layout.shift, asked.begin.q, np.stack([asked.front, last]))
        return ShiftStepModel(
            self.robot, model.layout, model.grid, self.read, self.schedule, model.chart, shift
        )

    @cached_property
    def breaks(self) -> Array:
        each = zip(self.edges, np.diff(self.edges), self.models, strict=False)
        found = [begin + length * one.knots for begin, length, one in each]
        return np.unique(np.concatenate([knots[:-1] for knots in found] + [[1.0]]))

    @property
    def changes(self) -> Array:
        return self.transition.changes

    def with_grid(self, grid: Grid) -> TransitionProblem:
        return TransitionProblem(self.robot, self.transition, grid)

    def with_task(self, task: Task) -> TransitionProblem:
        return TransitionProblem(self.robot, replace(self.transition, task=task), self.grid)

    def starts(self, x: Array) -> tuple[Step, ...]:
        steps, finish = self.steps(x), self.transition.finish
        still = np.zeros(finish.q.size)
        motion = np.stack([finish.q, finish.rate, still])[:, None]  # accelerations are not given
        return (*steps, replace(steps[-1], motion=motion, foot_motion=np.zeros((3, 1, 0))))

    def time(self, share: float, x: Array) -> float:
        """Return the time at a share of the transition [s]; steps share it as they are given."""
        ends = np.cumsum([0.0, *(step.duration for step in self.steps(x))])
        return float(np.interp(share, self.edges, ends))

    def begin_gap(self, x: Array) -> tuple[float, float]:
        """Return how far the first step is from beginning as given [rad], [rad/s]."""
        (q, rate), begin = self.steps(x)[0].motion[:2, 0], self.transition.begin
        return float(np.abs(q - begin.q).max()), float(np.abs(rate - begin.rate).max())

    def _given(self) -> Ends:
        """Return the ends in terms of the steps: the impact before, the double support after."""
        begin, finish = self.transition.begin, self.transition.finish
        model = self.models[-1]
        before = np.concatenate([np.zeros(6), model.exchange @ begin.rate])
        angles = finish.q if model.layout.lifted else finish.q[:0]
        posture = model.boundary.posture(finish.geometry, angles)
        after = Opening(np.zeros(0), finish.geometry, posture)
        impact = ImpactState(before, np.zeros(6))
        return Ends(Landing(begin.q, 0.0, None, begin.rate_before, None, impact, None), after)

    def _joined(self, x: Array, steps: tuple[Step, ...]) -> TransitionSteps:
        return TransitionSteps(x, steps, float(self.transition.finish.geometry[STEP_LENGTH]))

    def is_tip(self, x: Array) -> bool:
        del x  # its last step may end at rest
        return False

    def _together(self, derivatives: tuple[StepDerivatives, ...]) -> Jacobians:
        found = joined_jacobians(derivatives)
        found[quantities.TRAVEL] = np.zeros((1, 2, self.layout.size))
        for number, model in enumerate(self.models):
            length, lasts = model.along("step_length"), model.along("duration")
            if length is not None and number > 0:
                found[quantities.TRAVEL][0, 0] += length
            if lasts is not None:
                found[quantities.TRAVEL][0, 1] += lasts
        found[quantities.ADVANCE] = np.zeros((1, 0, self.layout.size))
        return found


def transition_layout(robot: Robot, transition: TransitionTask) -> TransitionLayout:
    """Return the layout of a transition: steps of the walk's geometry with durations of their own.

    The lengths of the steps are free; what is given at the ends need not be within bounds.
    """
    layout = walk_layout(robot, transition.task)
    assert isinstance(layout, Layout)
    steps = []
    for number, duration in enumerate(transition.lasts):
        room = {"lower": ROOM[0] * duration, "upper": ROOM[1] * duration}
        changes: dict[str, dict[str, float | bool]] = {
            "duration": {"free": transition.free, "value": duration, **room},
            "step_length": {"free": True},
        }
        if number == 0:
            fixed = {GEOMETRY_NAMES[k] for k, q in enumerate(layout.geometry) if not q.free}
            for name in fixed - {"duration", "step_length"}:
                value = float(transition.begin.geometry[GEOMETRY_NAMES.index(name)])
                changes[name] = {"value": value}
        steps.append(replace(layout, geometry=set_geometry(layout.geometry, changes)))
    return TransitionLayout(
        steps[-1].geometry, tuple(steps), transition.begin, transition.finish,
        transition.shift > 0.0,
    )  # fmt: skip


_OF_START = (quantities.LEGS, quantities.GAPS)
_OF_STATE = (
    quantities.ANGLES, quantities.RATES, quantities.CORNERS, quantities.TRUNK,
    *quantities.BODY_GAPS,
)  # fmt: skip
_OF_IMPACT = (quantities.IMPULSE, quantities.SOLE_TWIST)


def _blocks(robot: Robot, transition: TransitionTask, grid: Grid) -> tuple[ConstraintBlock, ...]:
    """Return the rows of every constraint of the walk but its speed, over all steps."""
    task, edges = transition.task, transition.edges
    each = parts(grid, edges)
    first, (own, swings) = each[0].instants, _aloft(transition, each)
    contexts = [
        TransitionContext(
            robot, part, task.margins, task.speed, duration, "penalty", task.boundary,
            task.schedule, task.ground, swings=aloft,
        )
        for part, duration, aloft in zip(own, transition.durations, swings, strict=True)
    ]  # fmt: skip
    found = []
    for front in on_foot(FRONT) if transition.shift else ():
        if Constraint.asked(front, contexts[0]):
            blocks = [front.block(context) for context in contexts]
            found.append(joined_blocks(blocks, grid, edges, robot, PERIOD))
    for blocks in asked_blocks(task, contexts):
        name = blocks[0].name
        if transition.shift:
            blocks[0] = _while_both(blocks[0], swings[0], first == 0.0)
        else:
            blocks[0] = _inside(_without(blocks[0], _OF_START), 0.0)
        blocks[-1] = _inside(_without(blocks[-1], _OF_IMPACT), 1.0)
        if name == LandingSpeed.name and transition.finish.rests:
            lower = np.full(blocks[-1].lower.shape, UNLIMITED_HEIGHT)
            blocks[-1] = replace(blocks[-1], lower=lower)  # it lands at zero speed
        if name in _HEIGHTS:
            ends = transition.begin.rests, transition.finish.rests
            blocks[0] = _weighed(blocks[0], ends[0], False)
            blocks[-1] = _weighed(blocks[-1], False, ends[1])
        found.append(joined_blocks(blocks, grid, edges, robot, PERIOD))
    return tuple(found)


@dataclass(frozen=True)
class TransitionContext(ConstraintContext):
    """One step of a transition; its instants are shares of the time for which one foot swings.

    Attributes:
        swings: at which of them one does, shape (N,).
    """

    swings: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))

    @property
    def swinging(self) -> NDArray[np.bool_]:
        return self.swings


def _aloft(
    transition: TransitionTask, grids: Sequence[Grid]
) -> tuple[list[Grid], list[NDArray[np.bool_]]]:
    """Return the instants of each step as shares of its swing, and at which one foot swings."""
    swings = [np.ones(grid.count, dtype=np.bool_) for grid in grids]
    own, s = list(grids), transition.shifted
    if transition.shift:
        swings[0] = ~while_shifting(grids[0], s)
        instants = grids[0].instants
        shares = np.clip((instants - s) / (1.0 - s), 0.0, 1.0)
        shares[~swings[0] & (instants > 0.0)] = _SOON  # so that every instant inside has its rows
        own[0] = replace(grids[0], instants=shares)
    return own, swings


def _while_both(
    block: ConstraintBlock, swings: NDArray[np.bool_], at_start: NDArray[np.bool_]
) -> ConstraintBlock:
    """Return the rows of a step that begins with a shift: then no foot has a height.

    Of the state alone those at the start, which is given, are left out.
    """
    if block.times is None:
        return block
    if block.name in _HEIGHTS:
        low = np.where(swings[block.instants][:, None], block.lower, UNLIMITED_HEIGHT)
        return replace(block, lower=low)
    return _state_only_at(block, ~at_start[block.instants])


_HEIGHTS = (Clearance.name, LandingSpeed.name)
_NEAR, _NEAREST = 0.1, 1e-3  # shares of a step


def _weighed(block: ConstraintBlock, begins: bool, ends: bool) -> ConstraintBlock:
    """Return heights and limits times about one over the squared distance from an end at rest.

    A foot that leaves the ground from rest, or comes to rest on it, has a height of the order of
    the squared time, and so has its limit: their difference vanishes with its slope, and no row
    near the end would hold those nearer to it. Weighed they are as any other rows.
    """
    if not (begins or ends) or block.times is None:
        return block
    weights = np.ones(len(block.instants))
    s = block.times
    for asked, away in ((begins, s), (ends, 1.0 - s)):
        if asked:
            weights *= 1.0 + _NEAR**2 / (away**2 + _NEAREST**2)
    matrix = block.function.jacobian(np.zeros((1, len(block.reads[0].entries))))
    weighed = Linear(weights[:, None, None] * matrix)
    return replace(block, function=weighed, lower=weights[:, None] * block.lower)


def _without(block: ConstraintBlock, given: tuple[Quantity, ...]) -> ConstraintBlock:
    """Return a block without limits if it is of quantities that are given: the walk proves those.

    Their rows do not depend on x, and a solver can do nothing about the last digit of them.
    """
    if not set(block.reads) <= set(given):
        return block
    lower, upper = np.full(block.lower.shape, -np.inf), np.full(block.upper.shape, np.inf)
    return replace(block, lower=lower, upper=upper)


ROOM = (0.5, 1.5)
"""How much shorter and longer than given a step may last whose duration is free."""
FROM_REST = 0.64
"""Duration of a step next to rest over that of the walk: a robot at rest falls away from the foot
on which it begins to stand, and the less the sooner the other lands (docs/transitions.md)."""


def _inside(block: ConstraintBlock, end: float) -> ConstraintBlock:
    """Return a block of the state alone without its rows at an end of a step, where that is given.

    Their multipliers could be anything where a walk presses on such a limit.
    """
    return block if block.times is None else _state_only_at(block, block.times != end)


def _state_only_at(block: ConstraintBlock, kept: NDArray[np.bool_]) -> ConstraintBlock:
    """Return some of the instants (N,) of a block of the state alone; all of any other."""
    if block.times is None or not set(block.reads) <= set(_OF_STATE):
        return block
    return replace(
        block, instants=block.instants[kept], times=block.times[kept], lower=block.lower[kept],
        upper=block.upper[kept],
    )  # fmt: skip


def step_durations(begin: Junction, finish: Junction, steps: int) -> tuple[float, ...]:
    """Return durations that lead evenly from one walk to the other, shortest at rest."""
    first, last = float(begin.geometry[DURATION]), float(finish.geometry[DURATION])
    if begin.rests or finish.rests:
        walked = last if begin.rests else first
        shares = np.linspace(1.0, FROM_REST, steps)
        return tuple((walked * (shares[::-1] if begin.rests else shares)).tolist())
    shares = np.arange(1, steps + 1) / (steps + 1)
    return tuple(((1.0 - shares) * first + shares * last).tolist())


STRETCH = 0.96
"""Distance of hip and ankle over the leg's length, unless a person says otherwise."""
_LEAST, _MOST = 0.5, 0.999
_ITERATIONS, _CENTRED = 50, 1e-13  # m


def standing(robot: Robot, walk: Array, stretch: float = STRETCH) -> Junction:
    """Return the state of a robot that stands as far apart with its feet as it walks.

    Upright, both legs alike, the feet turned out as in the walk, the centre of mass over the middle
    of the soles.

    Args:
        walk: geometric quantities of a double support of its walk, shape (10,).
        stretch: distance of hip and ankle over the leg's length.

    Raises:
        InputError: the stretch is out of range, or the legs have fewer than six motors.
        UnreachableError: the legs cannot stand so.
    """
    if not (is_finite(stretch) and _LEAST <= stretch <= _MOST):
        raise InputError(
            f"a stretch of {shown(stretch)} is none; give one from {_LEAST} to {_MOST}"
        )
    if robot.tree.stance < TWIST or not robot.coupling.none:
        raise InputError(
            "a posture to stand in is found for legs of six joints or more, in a robot of which no "
            "moving joint follows another; give two gaits, or such a robot"
        )
    geometry, sole = walk.copy(), robot.sole
    yaw = float(geometry[FOOT_YAW]) / 2.0  # of the pelvis, midway between the feet
    geometry[[STEP_LENGTH, TRUNK_PITCH, PELVIS_ROLL]] = 0.0
    geometry[PELVIS_YAW] = yaw
    aside = np.array([0.0, 0.5 * geometry[FOOT_SPACING], 0.0])
    middle = pin.SE3(pin.utils.rotate("z", yaw), np.zeros(3)) * pin.SE3(np.eye(3), aside)
    hips, mean = robot.legs.hips, robot.legs.hips.mean(axis=0)
    ankle = middle.actInv(robot.legs.ankles[0])
    centre = middle.actInv(
        np.array([0.5 * (sole.toe + sole.heel), 0.5 * (sole.left + sole.right), 0.0])
    )
    wide = ankle[1] - (hips[0] - mean)[1]
    kinematics, ahead = LegKinematics(robot), 0.0  # of the hips over the ankles
    for _ in range(_ITERATIONS):
        room = (stretch * robot.legs.reach) ** 2 - wide**2 - ahead**2
        hip = np.array([ankle[0] + ahead, 0.0, ankle[2] + np.sqrt(max(room, 0.0))])
        pelvis = middle.act(hip - mean)
        geometry[[PELVIS_FORWARD, PELVIS_LATERAL, PELVIS_HEIGHT]] = pelvis
        q = kinematics.solve(place(PELVIS_CHAIN, geometry)[0], place(SWING_SOLE_CHAIN, geometry)[0])
        off = float(centre[0] - middle.actInv(centre_of_mass(robot, q))[0])
        if abs(off) < _CENTRED:
            break
        ahead += off
    still = np.zeros(q.size)
    return Junction(geometry, q, still, still, rests=True)


def centre_of_mass(robot: Robot, q: Array) -> Array:
    """Return the centre of mass in the stance sole frame at joint angles q (n,) [m], shape (3,)."""
    whole = np.concatenate([pin.neutral(robot.model)[:7], robot.coupling.angles(q)])
    return np.array(pin.centerOfMass(robot.model, robot.model.createData(), whole))


def wrench_standing(robot: Robot) -> Array:
    """Return the wrench of the ground on the swing foot of a robot that stands, in its sole frame.

    Both feet press alike, straight down, in the middle of their soles, shape (6,).
    """
    sole, load = robot.sole, 0.5 * robot.weight
    x, y = 0.5 * (sole.toe + sole.heel), -0.5 * (sole.left + sole.right)  # of a mirror image
    return np.array([0.0, 0.0, load, load * y, -load * x, 0.0])
