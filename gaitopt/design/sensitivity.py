"""What a small change of robot or task does to the cost of an optimal walk.

By the envelope theorem the optimal cost changes with any number as the Lagrangian does at fixed
parameters and multipliers (Nocedal & Wright, 2006, section 12.8; Fiacco, 1983, theorem 3.4.1): one
evaluation on the way back (`gait.model_gradient`) serves all numbers of the robot. The derivatives
hold as long as the same limits stay active; `doubts` says where that may soon end.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from gaitopt.actuators.motors import JointMotor, joint_motors
from gaitopt.dataclass import dataclass
from gaitopt.design.active_set import ACTIVE_MULTIPLIER
from gaitopt.design.robot_changes import LENGTH, Anatomy, RobotChange
from gaitopt.design.shadow_prices import SETTING, kinks, pressed_rows, pressing, shadow_prices
from gaitopt.errors import InputError
from gaitopt.gait import quantities
from gaitopt.gait.costs import CostContext, cost_function, motors_replaced
from gaitopt.gait.double_step import DoubleStepModel
from gaitopt.gait.model_gradient import ModelGradient, model_gradient
from gaitopt.gait.parameters import DURATION
from gaitopt.gait.problem import WalkProblem, constraint_blocks
from gaitopt.gait.step import Step
from gaitopt.gait.task import Task
from gaitopt.mechanics.forward_kinematics import slope_rates
from gaitopt.model.robot import Robot, cached_workspace
from gaitopt.model.sole import Sole
from gaitopt.nlp import Array
from gaitopt.settings import checked_arguments

TASK, LIMITS, GEAR = "task", "limit", "gear"
_EDGE_STEP = 1e-5  # m, of differences of rows at a fixed step: they are linear, or nearly
_RELATIVE_STEP = 1e-5  # of other differences of the same kind
_STEPS = {"speed": 0.1, "duration": 0.01, "slope": np.pi / 180.0, "stairs": 0.01}
_SETTING_SHARE = 0.1  # of the change of a setting that a diagnosis would try
_LIMIT_SHARE = 0.01  # of a row's scale
_RATIO_STEP = 0.1
_NEAR = 0.01  # scaled distance to a limit that nothing holds
_ENDS = 0.1  # of the step: there every swing foot is near the ground
_BARELY = 1e-3  # of the largest multiplier
_HELD = 1e-8  # scaled distance to a limit that the walk is at
_DEPENDENT = 1e-6  # singular value of unit gradients of which one follows from the others
_SOLE = (
    "cop", "lift-off", "clearance", "lateral", "impulse cop", "swing tilt", "swing height",
    "landing speed",
)  # fmt: skip
"""Constraints whose rows know the edges of the sole."""


@dataclass(frozen=True)
class Sensitivity:
    """What a number of the robot or the task does to the cost of an optimal walk.

    Attributes:
        name: of the number.
        kind: what it is a number of: a length, a mass, ..., the task, a limit.
        unit: of the number, empty where it has none.
        step: a change of it that a designer thinks in, signed.
        per_unit: derivative of the optimal cost [unit of the cost per unit of the number].
        share: relative change of the cost per step, to first order.
        speed: change of speed per step at which the cost stays as it is, to first order [m/s].
    """

    name: str
    kind: str
    unit: str
    step: float
    per_unit: float
    share: float
    speed: float


@dataclass(frozen=True)
class SensitivityReport:
    """All sensitivities of a walk.

    Attributes:
        cost, unit: of the walk.
        found: the sensitivities, the largest effect first.
        doubts: where derivatives may end soon, and what is not told, in words.
    """

    cost: float
    unit: str
    found: tuple[Sensitivity, ...]
    doubts: tuple[str, ...]

    def of(self, name: str) -> Sensitivity:
        """Return the sensitivity of a name.

        Raises:
            KeyError: there is none.
        """
        for one in self.found:
            if one.name == name:
                return one
        raise KeyError(name)


class Envelope:
    """The Lagrangian of an optimal walk as a function of everything but its parameters."""

    def __init__(self, problem: WalkProblem, x: Array, multipliers: Array) -> None:
        """Evaluate the walk once at its optimum: x (P,), and multipliers of the scaled rows (m,).

        Raises:
            EvaluationError: the walk is not defined at x.
            InputError: it has a double support or a foot that comes to lie flat by an impact, or is
                a stride of two steps.
        """
        if problem.task.steps > 1:
            raise InputError(
                "sensitivities are told of walks straight ahead, not of strides of two steps; "
                "design the walk without lateral_speed, turn_rate, cross_slope and stride"
            )
        if isinstance(problem.model, DoubleStepModel) or problem.schedule.slapping:
            raise InputError(
                "what a robot's numbers are worth is not told of walks with a double support or a "
                "foot that comes to lie flat by an impact yet; leave out --double-support and "
                "--foot-flat"
            )
        self.problem, self.x, self.multipliers = problem, x, multipliers
        self.step, derivatives = problem.derivatives(x)
        first = problem.weights(x, multipliers, problem.cost_scale)
        self._of_trunk = first[quantities.TRUNK]
        self.gaps_press = any(first[gaps].any() for gaps in quantities.BODY_GAPS)
        self.gradient: ModelGradient = model_gradient(problem.model, self.step, derivatives, first)
        self._pressed = pressed_rows(problem, multipliers)

    @property
    def cost(self) -> float:
        """Of the walk."""
        return self.problem.cost.value(self.step)

    @property
    def changes(self) -> tuple[RobotChange, ...]:
        """All changes of the robot of which the derivative is known."""
        return tuple(robot_changes(self))

    def per_unit(self, change: RobotChange) -> float:
        """Return the derivative of the optimal cost in a number of the robot."""
        rate = float(self.gradient.flat @ change.flat)
        if change.sole.any():
            rate += float(self.edges @ change.sole)
        rate += self._of_measures(change)
        return rate / self.problem.cost_scale

    @cached_property
    def edges(self) -> Array:
        """What rows that know the edges of the sole add: toe, heel, left, right, shape (4,)."""
        robot, task = self.problem.robot, self.problem.task
        return np.array([
            self._difference(
                (_with_edge(robot, edge, -_EDGE_STEP), task),
                (_with_edge(robot, edge, _EDGE_STEP), task), _SOLE,
            ) / (2.0 * _EDGE_STEP)
            for edge in ("toe", "heel", "left", "right")
        ])  # fmt: skip

    def _of_measures(self, change: RobotChange) -> float:
        """What limits that follow from measures of the robot add: reach, knees, its mass."""
        margins, legs = self.problem.task.margins, self.problem.robot.legs
        moved: dict[str, float | Array] = {
            "leg length": (margins.leg_extension or 1.0) * change.reach,
            "knee": legs.flexion * change.straight,
            "landing impulse": (margins.landing_impulse or 0.0) * change.weight,
        }
        total = 0.0
        for block in self.problem.blocks:
            if block.name in moved and block.name in self._pressed:
                y = self._pressed[block.name] / block.scale
                total -= float((y * moved[block.name]).sum())
        return total

    def task_rate(self, name: str) -> float:
        """Return the derivative of the optimal cost in a number of the task: speed, slope, ..."""
        problem, task = self.problem, self.problem.task
        value, scale = float(getattr(task, name)), problem.cost_scale
        if name == "slope":
            size = float(np.linalg.norm(problem.robot.physics.gravity))
            turned = size * np.array([-np.cos(task.slope), 0.0, np.sin(task.slope)])
            trunk = self.step.read(quantities.TRUNK)
            leaned = np.vdot(self._of_trunk, slope_rates(trunk)) if trunk.size else 0.0
            return (float(self.gradient.gravity @ turned) + float(leaned)) / scale
        h = _RELATIVE_STEP * max(abs(value), _STEPS[name])
        before, after = (task.with_changes(**{name: value + side * h}) for side in (-1.0, 1.0))
        if name == "stairs":  # places the front foot as well: the whole walk, at fixed parameters
            rate = (self._whole(after) - self._whole(before)) / (2.0 * h)
        else:
            rate = self._difference((problem.robot, before), (problem.robot, after)) / (2.0 * h)
        if name == "duration":
            rate += self.gradient.duration
        return rate / scale

    @cached_property
    def gear_rates(self) -> dict[JointMotor, float]:
        """Derivatives of the optimal cost in the logarithms of gear ratios, by the task's motors.

        All of the rotor inertia that joints with a motor have is taken for that of its rotor.
        """
        robot, motors = self.problem.robot, task_motors(self.problem.task)
        rotors = np.array(robot.model.armature)[-robot.tree.size :][robot.coupling.free]
        of_joints = joint_motors(motors, robot.joint_names, robot.mirror) if motors else []
        return {
            one: self._gear_rate(one, np.where([own == one for own in of_joints], rotors, 0.0))
            for one in motors
        }

    def _gear_rate(self, motor: JointMotor, armature: Array) -> float:
        """Derivative of a gear; armature of its joints, zero for others, shape (n,) [kg·m²]."""
        task, robot = self.problem.task, self.problem.robot
        before, after = (
            _with_motor(task, motor, geared(motor, np.exp(side * _RELATIVE_STEP)))
            for side in (-1.0, 1.0)
        )
        rate = self._difference((robot, before), (robot, after)) / (2.0 * _RELATIVE_STEP)
        rate += 2.0 * float(self.gradient.armature[robot.coupling.free] @ armature)
        return rate / self.problem.cost_scale

    def _whole(self, task: Task) -> float:
        problem = WalkProblem(self.problem.robot, task, self.problem.grid)
        return self._held(problem.step(self.x), problem.robot, task, ())

    def _difference(
        self, before: tuple[Robot, Task], after: tuple[Robot, Task], only: Sequence[str] = ()
    ) -> float:
        """Change of cost and held rows as robot and task change at the step as it is."""
        return self._held(self.step, *after, only) - self._held(self.step, *before, only)

    def _held(self, step: Step, robot: Robot, task: Task, only: Sequence[str]) -> float:
        """Scaled cost, unless only some rows are asked for, and multipliers . (rows - limits)."""
        problem, total = self.problem, 0.0
        if not only:
            context = CostContext(robot, problem.grid, task.speed)
            penalty = task.penalty_weight if task.speed_as == "penalty" else 0.0
            cost = cost_function(task.cost, context, penalty)
            total += problem.cost_scale * cost.value(step)
        own = {block.name: block for block in problem.blocks}
        names = [name for name in self._pressed if not only or name in only]
        for block in constraint_blocks(robot, task, problem.grid, names):
            total += pressing(block, own[block.name], self._pressed[block.name], step)
        return total


def _with_edge(robot: Robot, edge: str, move: float) -> Robot:
    edges = {name: getattr(robot.sole, name) for name in ("toe", "heel", "left", "right")}
    return replace(robot, sole=Sole(**{**edges, edge: edges[edge] + move}))


def geared(motor: JointMotor, factor: float) -> JointMotor:
    """Return what a motor can do at its joints with another gear ratio, factor times its own.

    The friction of the gear stays.
    """
    return motor._replace(
        peak_torque=factor * (motor.peak_torque + motor.friction) - motor.friction,
        continuous_torque=factor * (motor.continuous_torque + motor.friction) - motor.friction,
        stall_torque=factor * (motor.stall_torque + motor.friction) - motor.friction,
        no_load_speed=motor.no_load_speed / factor,
        loss=motor.loss / factor**2,
    )


def _with_motor(task: Task, old: JointMotor, new: JointMotor) -> Task:
    """Return the task with another motor in the place of one, in constraints and cost."""

    def changed(motors: tuple[JointMotor, ...]) -> tuple[JointMotor, ...]:
        return tuple(new if one == old else one for one in motors)

    def driven(one: Any) -> Any:
        motors = getattr(one, "motors", ())
        return replace(one, motors=changed(motors)) if old in motors else one

    return replace(
        task,
        cost=motors_replaced(task.cost, changed),
        constraints=tuple(map(driven, task.constraints)),
    )


def task_motors(task: Task) -> tuple[JointMotor, ...]:
    """Return the motors that a task's constraints and cost know."""
    owners = (*task.constraints, task.cost)
    return tuple(dict.fromkeys(one for owner in owners for one in getattr(owner, "motors", ())))


@checked_arguments
def sensitivities(
    problem: WalkProblem, x: Array, multipliers: tuple[Array, Array]
) -> SensitivityReport:
    """Return what all numbers of robot and task do to the cost of an optimal walk.

    Args:
        x: its optimal parameters, shape (P,).
        multipliers: there, of the scaled rows (m,) and of the bounds (P,).

    Raises:
        EvaluationError: the walk is not defined at x.
    """
    at = Envelope(problem, x, multipliers[0])
    cost = at.cost
    by_speed = at.task_rate("speed") if problem.task.speed else 0.0  # in place the cost is another

    def told(name: str, kind: str, unit: str, step: float, per_unit: float) -> Sensitivity:
        effect = per_unit * step
        speed = -effect / by_speed if by_speed else np.nan
        return Sensitivity(name, kind, unit, step, per_unit, effect / cost, speed)

    found = [told("speed", TASK, "m/s", _STEPS["speed"], by_speed)] if by_speed else []
    found += [told(*one) for one in _of_task(at)]
    for motor, gear_rate in at.gear_rates.items():
        name = f"gear ratio of '{motor.joints}'"
        found.append(told(name, GEAR, "of itself", _RATIO_STEP, gear_rate))
    for change in robot_changes(at):
        found.append(told(change.name, change.kind, change.unit, change.step, at.per_unit(change)))
    for price in shadow_prices(problem, x, multipliers):
        if price.name == "speed":
            continue
        step = price.effect / price.cost_per_unit
        step *= _SETTING_SHARE if price.kind == SETTING else _LIMIT_SHARE
        name = price.words if price.kind == SETTING else f"{price.name}, {price.words} limit"
        found.append(told(name, LIMITS, price.unit, step, price.cost_per_unit))
    found.sort(key=lambda one: -abs(one.share))
    ended = "{} is worth another amount on the other side of its value: told is where limits give"
    said = (
        *untold(at), *doubts(at), *_idle_bounds(at, multipliers[1]), *_shared(at, multipliers[1]),
        *map(ended.format, kinks(problem, x, multipliers[0])),
    )  # fmt: skip
    return SensitivityReport(cost, problem.task.cost.unit, tuple(found), said)


def _of_task(at: Envelope) -> Iterator[tuple[str, str, str, float, float]]:
    task = at.problem.task
    if not task.geometry[DURATION].free:
        yield "duration", TASK, "s", _STEPS["duration"], at.task_rate("duration")
    if task.stairs != 0.0:
        yield "stairs", TASK, "m", _STEPS["stairs"], at.task_rate("stairs")
    elif task.terrain is None:
        yield "slope", TASK, "rad", _STEPS["slope"], at.task_rate("slope")


def robot_changes(at: Envelope) -> Iterator[RobotChange]:
    """Yield the changes of a walk's robot of which the derivative is known."""
    robot, turning = at.problem.robot, at.problem.model.turns_foot
    if robot.physics.carried is not None:
        return
    for change in cached_workspace(robot, Anatomy).changes:
        capsules = change.kind == LENGTH and (change.joints.any() or not change.sole.any())
        if not (at.gaps_press and capsules) and not (turning and change.sole[:2].any()):
            yield change


def untold(at: Envelope) -> Iterator[str]:
    """Say of what numbers of a robot the derivatives are not told, and why."""
    if at.problem.robot.physics.carried is not None:
        yield (
            "nothing is told of masses, lengths and joints: part of the weight of this robot is "
            "carried from outside"
        )
    elif at.gaps_press:
        yield (
            "nothing is told of most lengths: the legs' bodies press on each other, and their "
            "shapes do not follow the lengths"
        )
    if at.problem.model.turns_foot:
        yield (
            "nothing is told of the length and the place of the sole: the foot turns about its edge"
        )
    for one in at.problem.task.extensions:
        yield (
            f"'{one.name}' comes from a plugin: what of it depends on robot or task, beside the "
            "quantities it reads, is not counted"
        )


def doubts(at: Envelope) -> Iterator[str]:
    """Say which limits are about to be held or let go, where derivatives jump."""
    problem, rows = at.problem, at.problem.values(at.x).rows
    largest = float(np.abs(at.multipliers).max(initial=0.0))
    for block in problem.blocks:
        if (block.lower == block.upper).all():
            continue
        part = problem.rows_of(block.name)
        value = rows[part].reshape(block.lower.shape) * block.scale
        y = at.multipliers[part].reshape(block.lower.shape)
        away = np.minimum(value - block.lower, block.upper - value) / block.scale
        if block.reads == (quantities.CORNERS,) and block.times is not None:
            away[(block.times < _ENDS) | (block.times > 1.0 - _ENDS)] = np.inf
        for entry, label in enumerate(block.labels):
            pressed = float(np.abs(y[:, entry]).sum())
            near = float(away[:, entry].min())
            if pressed <= ACTIVE_MULTIPLIER and near < _NEAR:
                change = near * float(block.scale[entry])
                yield (
                    f"{label} is {max(change, 0.0):.3g} {block.unit} from its limit without "
                    "pressing on it: derivatives jump where it begins to"
                )
            elif ACTIVE_MULTIPLIER < pressed < _BARELY * largest:
                yield f"{label} barely presses on its limit: derivatives jump where it lets go"


def _idle_bounds(at: Envelope, multipliers: Array) -> Iterator[str]:
    """Say which parameters are at a bound that does not press on them."""
    variables = at.problem.variables
    away = np.minimum(at.x - variables.lower, variables.upper - at.x) / variables.scale
    for index in np.flatnonzero((away < _NEAR) & (np.abs(multipliers) <= ACTIVE_MULTIPLIER)):
        yield (
            f"{variables.names[index]} is at its bound without pressing on it: derivatives jump "
            "where it begins to"
        )


def _shared(at: Envelope, bound_multipliers: Array) -> Iterator[str]:
    """Say which limits hold the same, so that their multipliers, and prices, are not unique."""
    problem, variables = at.problem, at.problem.variables
    point = problem.point(at.x)
    lower, upper, value, y = (
        np.append(*pair)
        for pair in (
            (problem.rows.lower, variables.lower), (problem.rows.upper, variables.upper),
            (point.rows, at.x), (at.multipliers, bound_multipliers),
        )
    )  # fmt: skip
    away, count = np.minimum(value - lower, upper - value), point.rows.size
    gradients, names = [], []
    for index in map(int, np.flatnonzero((np.abs(y) > ACTIVE_MULTIPLIER) | (away < _HELD))):
        if index < count:
            row = problem.address(index)
            slopes = point.jacobian[index] * variables.scale
            name = row.block.label(row.instant, row.entry)
        else:
            slopes, name = np.eye(at.x.size)[index - count], variables.names[index - count]
        size = float(np.linalg.norm(slopes))
        if size > 0.0:
            side = (
                "upper" if upper[index] - value[index] <= value[index] - lower[index] else "lower"
            )
            gradients.append(slopes / size)
            names.append("" if lower[index] == upper[index] else f"{name} ({side})")
    if not gradients:
        return
    directions, sizes, _ = np.linalg.svd(np.array(gradients))
    free = directions[:, int((sizes > _DEPENDENT).sum()) :]
    linked = np.abs(free @ free.T) > _DEPENDENT
    left = {int(k) for k in np.flatnonzero(linked.diagonal())}
    while left:
        group: set[int] = set()
        reached = {left.pop()}
        while reached:
            group |= reached
            reached = {int(k) for one in reached for k in np.flatnonzero(linked[one])} - group
        left -= group
        same = sorted({names[k] for k in group} - {""})
        if len(same) > 1:
            yield (
                f"{', '.join(same)}: these limits hold the same, and only what all of them are "
                "worth together is told; the derivative of one alone jumps"
            )
