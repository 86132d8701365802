"""One robot with one task: what a gait is designed for, in a form that travels between machines."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

from gaitopt.actuators.motors import MOTORS, MotorTable
from gaitopt.catalogue.biped_spec import BipedSpec
from gaitopt.catalogue.parameters import changed
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.dataclass import dataclass
from gaitopt.design.sizing import with_motors
from gaitopt.errors import InputError
from gaitopt.gait.task import Task, task_from_record, task_record
from gaitopt.model.import_options import ImportOptions, choices_from_record, choices_record
from gaitopt.model.robot import Robot

_CACHED_ROBOTS = 8  # that a process keeps built


@dataclass(frozen=True, eq=False)
class RobotSource:
    """How to build a robot.

    Attributes:
        urdf: text, used as it is unless there is a specification.
        choices: about that URDF.
        spec: of a generated biped, None for any other robot.
        changes: entries of the specification that differ, by path, and numbers of the motors, by
            the names of their axes.
        motors: of the robot, where numbers of them are swept.
    """

    urdf: str
    choices: ImportOptions
    spec: BipedSpec | None = None
    changes: tuple[tuple[str, float], ...] = ()
    motors: MotorTable | None = None

    @property
    def drives(self) -> MotorTable | None:
        """The motors with the numbers that differ, None where no number of theirs is swept.

        Raises:
            SpecError: with a number the motor could not be.
        """
        changes = {k.removeprefix(MOTORS): v for k, v in self.changes if k.startswith(MOTORS)}
        return None if self.motors is None or not changes else self.motors.changed(changes)

    def build(self) -> Robot:
        """Return the robot; the last few are cached.

        Raises:
            RobotError: it is not a biped.
            SpecError: the changed specification is not physical.
        """
        urdf, choices = self.urdf, self.choices
        entries = {k: v for k, v in self.changes if not k.startswith(MOTORS)}
        if self.spec is not None and entries:
            urdf, choices = urdf_text(changed(self.spec, entries)), _chosen(self.spec, choices)
        if (drives := self.drives) is not None:
            choices = replace(choices, limits=drives.with_rotors(choices.limits))
        return _robot(urdf, choices)


def _chosen(spec: BipedSpec, choices: ImportOptions) -> ImportOptions:
    """Return the choices of a biped without what was found in its file.

    Soles, and the places of loads that are given none, are where the changed biped has them.
    """
    unplaced = tuple(replace(one, place=None) for one in choices.payloads)
    sole = None if choices.sole_placements is None else choices.sole  # they go together
    found = _robot(urdf_text(spec), replace(choices, sole=sole, payloads=unplaced)).choices
    loads = tuple(
        free if there == own else own
        for free, there, own in zip(unplaced, found.payloads, choices.payloads, strict=True)
    )
    sole = sole if found.sole == choices.sole else choices.sole
    return replace(choices, sole=sole, payloads=loads)


def _robot(urdf: str, choices: ImportOptions) -> Robot:
    return _built(urdf, json.dumps(choices_record(choices)))


@lru_cache(maxsize=_CACHED_ROBOTS)
def _built(urdf: str, choices: str) -> Robot:
    return Robot.from_urdf(urdf, choices=choices_from_record(json.loads(choices)))


@dataclass(frozen=True, eq=False)
class Scenario:
    """A robot and a task."""

    robot: RobotSource
    task: Task

    def driven(self) -> Scenario:
        """Return it with the task within the envelopes of the robot's motors of the moment."""
        drives = self.robot.drives
        return self if drives is None else replace(self, task=with_motors(self.task, drives))


def interpolated(a: Scenario, b: Scenario, share: float) -> Scenario:
    """Return the scenario a part of the way from one to another: every number in proportion.

    Args:
        a, b: of the same kind of robot and task.
        share: 0 for a, 1 for b.

    Raises:
        InputError: they differ in something that is not a number.
    """
    if share in (0.0, 1.0):
        return b if share == 1.0 else a
    mixed = _mixed(task_record(a.task), task_record(b.task), share, "task")
    task = task_from_record(mixed, (*a.task.constraints, a.task.cost))
    if a.robot.spec is None and a.robot.urdf != b.robot.urdf:
        raise InputError("the gaits are of different robots; nothing lies between them")
    mixed = _mixed(dict(a.robot.changes), dict(b.robot.changes), share, "specification")
    changes = tuple((k, float(str(v))) for k, v in mixed.items())
    return Scenario(replace(a.robot, changes=changes), task).driven()


def _mixed(
    a: Mapping[str, object], b: Mapping[str, object], share: float, where: str
) -> dict[str, object]:
    if a.keys() != b.keys():
        raise InputError(f"the gaits differ in which entries their {where} has")
    return {key: _mix(a[key], b[key], share, f"{where} {key}") for key in a}


def _mix(a: object, b: object, share: float, where: str) -> object:
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return _mixed(a, b, share, where)
    if isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        return [_mix(one, other, share, where) for one, other in zip(a, b, strict=True)]
    if a == b:
        return a
    if isinstance(a, float) and isinstance(b, float) and math.isfinite(a + b):
        return a + share * (b - a)
    raise InputError(f"the gaits differ in {where}: {a!r} and {b!r}; nothing lies between them")
