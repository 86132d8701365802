"""Sizing: motors from a catalogue and gear ratios that serve a set of gaits.

A motor's rotor is accelerated by its own joint alone, so that joints are sized one by one: for each
motor of the catalogue the ratios at which it serves all gaits, and of all these the best. The gaits
are then designed again with the rotors and within the envelopes of these motors, which changes
what they ask; motors are chosen again for them, until the choice stays.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from operator import attrgetter
from pathlib import Path

import numpy as np

from gaitopt.actuators.motors import Drive, Motor, MotorTable, catalogue_of
from gaitopt.dataclass import dataclass
from gaitopt.design.options import DesignOptions
from gaitopt.design.requirements import MotorLoop, motor_loops, motor_use
from gaitopt.design.starts import many_starts
from gaitopt.errors import InputError, NoGaitFoundError, StoppedError
from gaitopt.gait.constraints import MotorEnvelope
from gaitopt.gait.costs import motors_replaced
from gaitopt.gait.result import Gait, robot_of
from gaitopt.gait.task import Task, task_from_record
from gaitopt.importers.text_files import read_text
from gaitopt.model.overrides import without_armature
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array, Status, Stop, never
from gaitopt.settings import checked_arguments

_ORDER = {
    "mass": attrgetter("drive.motor.mass", "loss"), "loss": attrgetter("loss", "drive.motor.mass"),
}  # fmt: skip
AIMS = tuple(_ORDER)
RESERVE = 1.1
"""Of torque, heat and voltage, over what the gaits ask: gaits that are designed again ask else."""
_SCANNED = 400  # ratios between the least and the largest, evenly in their logarithm
_FREE = (1.0, 200.0)  # where the catalogue names no ratios
_ROUNDS = 4  # of sizing and designing again
_SAME = 0.02  # relative, of two ratios of a gear


@dataclass(frozen=True)
class Catalogue:
    """What there is to choose from.

    Attributes:
        motors: by name.
        ratios: of gears, empty for any from 1 to 200.
        efficiency, friction: of every gear, as of `Drive`.
    """

    motors: Mapping[str, Motor]
    ratios: tuple[float, ...] = ()
    efficiency: float = 1.0
    friction: float = 0.0

    def candidates(self) -> Array:
        """Return the ratios to be tried, increasing, shape (K,)."""
        if self.ratios:
            return np.array(sorted(self.ratios))
        return np.asarray(np.geomspace(*_FREE, _SCANNED))


@dataclass(frozen=True)
class Choice:
    """The motor of a pair of joints.

    Attributes:
        motor: name that the joints of both sides share.
        joints: names of the joints.
        drive: motor and gear, for the first of the joints.
        peak_share, rms_share, voltage_share: largest over the gaits, of its limits.
        loss: mean copper loss over the gaits [W].
    """

    motor: str
    joints: tuple[str, ...]
    drive: Drive
    peak_share: float
    rms_share: float
    voltage_share: float
    loss: float


@dataclass(frozen=True)
class Sizing:
    """What was chosen.

    Attributes:
        choices: of every pair of joints.
        gaits: designed again with these motors, by label.
        rounds: of choosing and designing.
        settled: whether the last gaits would choose the same motors again.
    """

    choices: tuple[Choice, ...]
    gaits: Mapping[str, Gait]
    rounds: int
    settled: bool

    @property
    def table(self) -> MotorTable:
        """The drives of all joints."""
        return table_of(self.choices)

    @property
    def mass(self) -> float:
        """Of all motors [kg]."""
        return sum(len(one.joints) * one.drive.motor.mass for one in self.choices)


@checked_arguments
def read_catalogue(path: str | Path) -> Catalogue:
    """Read [motors.NAME] tables and a [gear] table with ratios, efficiency and friction.

    Raises:
        SpecError: it cannot be used.
        RobotError: it cannot be read.
    """
    motors, gear = catalogue_of(read_text(Path(path), "catalogue of motors"), str(path))
    return Catalogue(motors, **gear)


def table_of(choices: Sequence[Choice]) -> MotorTable:
    """Return the drives of choices as a table, one for each joint."""
    return MotorTable(
        tuple(replace(one.drive, joints=joint) for one in choices for joint in one.joints)
    )


@checked_arguments
def chosen(
    gaits: Mapping[str, Gait], catalogue: Catalogue, aim: str = AIMS[0], reserve: float = RESERVE
) -> tuple[Choice, ...]:
    """Return the motor and the ratio of every pair of joints that serve all gaits.

    Args:
        gaits: by label, of one robot.
        aim: least "mass" of the motor, then loss; or least "loss", then mass.
        reserve: over what the gaits ask.

    Raises:
        InputError: no motor of the catalogue serves some joint, or the gaits are of other joints.
    """
    if aim not in AIMS:
        raise InputError(f"the aim is '{aim}'; give {' or '.join(AIMS)}")
    loops = {label: _rigid(gait) for label, gait in gaits.items()}
    first = next(iter(gaits.values()))
    found = []
    for k, loop in enumerate(next(iter(loops.values()))):
        of = {label: each[k] for label, each in loops.items()}
        if any(one.motor != loop.motor for one in of.values()):
            raise InputError("the gaits move different joints; give gaits of one robot")
        partner = int(np.argmax(np.abs(first.mirror[:, first.joint_names.index(loop.joint)])))
        joints = tuple(dict.fromkeys((loop.joint, first.joint_names[partner])))
        options = [
            choice
            for motor in catalogue.motors.values()
            if (choice := _best_ratio(of, joints, motor, catalogue, reserve)) is not None
        ]
        if not options:
            raise InputError(_nothing(of, catalogue, reserve))
        found.append(min(options, key=_ORDER[aim]))
    return tuple(found)


def _rigid(gait: Gait) -> list[MotorLoop]:
    """The loops of a gait without what accelerates the rotors of its own robot."""
    body = gait.trajectory.body
    names = gait.trajectory.joint_names
    return [
        replace(
            loop,
            torque=loop.torque - float(body.armature[names.index(loop.joint)]) * loop.acceleration,
        )
        for loop in motor_loops(gait)
    ]


def _best_ratio(
    loops: Mapping[str, MotorLoop],
    joints: tuple[str, ...],
    motor: Motor,
    catalogue: Catalogue,
    reserve: float,
) -> Choice | None:
    """Return the ratio of least loss at which a motor serves all gaits, None if at none."""
    drives = [
        Drive(joints[0], motor, float(ratio), catalogue.efficiency, catalogue.friction)
        for ratio in catalogue.candidates()
        if catalogue.friction
        < ratio * catalogue.efficiency * motor.torque_constant * motor.continuous_current
    ]
    each = [_use(loops, joints, drive) for drive in drives]
    fit = [
        one for one in each
        if reserve * max(one.peak_share, one.rms_share, one.voltage_share) <= 1.0
    ]  # fmt: skip
    return min(fit, key=lambda one: one.loss, default=None)


def _use(loops: Mapping[str, MotorLoop], joints: tuple[str, ...], drive: Drive) -> Choice:
    """Return what gaits ask of a drive, its rotor accelerated."""
    uses = [
        motor_use(
            replace(loop, torque=loop.torque + drive.armature * loop.acceleration), label, drive
        )
        for label, loop in loops.items()
    ]
    return Choice(
        uses[0].motor, joints, drive, max(one.peak_share for one in uses),
        max(one.rms_share for one in uses), max(one.voltage_share for one in uses),
        float(np.mean([one.copper_loss for one in uses])),
    )  # fmt: skip


def _nothing(loops: Mapping[str, MotorLoop], catalogue: Catalogue, reserve: float) -> str:
    """Say why no motor serves a joint, by the one that comes nearest."""
    nearest, joints = None, (next(iter(loops.values())).joint,)
    for motor in catalogue.motors.values():
        loosest = [_best_ratio(loops, joints, motor, catalogue, reserve / more)
                   for more in (1.25, 1.6, 2.0, 4.0, 16.0)]  # fmt: skip
        for one in filter(None, loosest):
            if nearest is None or _needs(one) < _needs(nearest):
                nearest = one
    joint = next(iter(loops.values())).motor
    if nearest is None:
        return f"no motor of the catalogue comes near what the {joint} needs; add a larger one"
    drive = nearest.drive
    return (
        f"no motor of the catalogue serves the {joint} with a reserve of {reserve:g}; nearest "
        f"comes '{drive.motor.name}' with ratio {drive.ratio:.3g}: "
        f"{nearest.peak_share:.0%} of its peak current, {nearest.rms_share:.0%} of the continuous "
        f"one, {nearest.voltage_share:.0%} of its voltage; add a larger motor or other ratios, or "
        "ask less of the gaits"
    )


def _needs(choice: Choice) -> float:
    return max(choice.peak_share, choice.rms_share, choice.voltage_share)


@checked_arguments
def size(
    gaits: Mapping[str, Gait],
    catalogue: Catalogue,
    options: DesignOptions,
    *,
    aim: str = AIMS[0],
    reserve: float = RESERVE,
    on_round: Callable[[tuple[Choice, ...]], None] | None = None,
    stop: Stop = never,
) -> Sizing:
    """Choose motors and ratios, and design the gaits again with them.

    Args:
        gaits: by label, of one robot, designed with or without motors.

    Raises:
        InputError: no motor serves a joint, or no gait is possible with those chosen.
        StoppedError: `stop` said so.
    """
    choices, rounds = chosen(gaits, catalogue, aim, reserve), 0
    while True:
        rounds += 1
        if on_round is not None:
            on_round(choices)
        again = {
            label: designed_with(gait, table_of(choices), options, label, stop)
            for label, gait in gaits.items()
        }
        used = served(again, choices)
        following = chosen(again, catalogue, aim, reserve)
        pairs = [(a.drive, b.drive) for a, b in zip(choices, following, strict=True)]
        same = all(a.motor == b.motor and abs(np.log(a.ratio / b.ratio)) < _SAME for a, b in pairs)
        if same or rounds == _ROUNDS:
            return Sizing(used, again, rounds, same)
        choices = following


def served(gaits: Mapping[str, Gait], choices: Sequence[Choice]) -> tuple[Choice, ...]:
    """Return choices with the shares of their limits that gaits take."""
    loops = {label: _rigid(gait) for label, gait in gaits.items()}
    return tuple(
        _use({label: each[k] for label, each in loops.items()}, one.joints, one.drive)
        for k, one in enumerate(choices)
    )


def designed_with(
    gait: Gait, table: MotorTable, options: DesignOptions, label: str, stop: Stop = never
) -> Gait:
    """Return the gait designed again with motors: their rotors, within their envelopes.

    Raises:
        InputError: there is none.
        StoppedError: `stop` said so.
    """
    task = task_from_record(gait.fact("task"))
    robot = robot_of(gait)
    limits = (*without_armature(robot.choices.limits), *table.rotors())
    choices = robot.choices.over(limits=limits)
    robot = Robot.from_urdf(robot.urdf, choices=choices).as_before(robot.findings)
    try:
        found = many_starts(
            robot, with_motors(task, table), options, count=2, start=gait.parameters, stop=stop
        ).design
    except StoppedError:  # which says nothing about the motors
        raise
    except NoGaitFoundError as error:
        raise InputError(
            f"with the motors chosen there is no gait '{label}': {error}; give a larger --reserve"
        ) from error
    if found.solution.status is Status.INTERRUPTED:
        raise StoppedError(found.solution)
    return found.gait


def with_motors(task: Task, table: MotorTable) -> Task:
    """Return the task within the envelopes of motors, in place of any it has."""
    motors = table.at_joints
    others = tuple(one for one in task.constraints if not isinstance(one, MotorEnvelope))
    cost = motors_replaced(task.cost, lambda _: motors)
    return replace(task, cost=cost, constraints=(*others, MotorEnvelope(motors=motors)))
