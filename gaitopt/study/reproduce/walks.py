"""The walks of the paper's section 6: its biped as identified, its constraints, steps of 0.4 s."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task, preset_task
from gaitopt.robot.catalogue import biped_of, entry_by_name
from gaitopt.robot.generated.spec import BipedSpec
from gaitopt.robot.generated.urdf import urdf_text
from gaitopt.robot.model import Robot
from gaitopt.study.reproduce.printed import printed

NAME = "paper"
"""Of the identified biped in the catalogue."""


def identified_biped() -> BipedSpec:
    """Return the paper's biped with what it leaves open identified from Table 3."""
    return biped_of(entry_by_name(NAME))


def identified_margins() -> dict[str, Any]:
    """Return the fields of the task that belong to it: the identified knee flexion [rad]."""
    task = dict(entry_by_name(NAME).task)
    return {name: value for name, value in task.items() if name not in ("preset", "speed")}


def biped_robot(spec: BipedSpec) -> Robot:
    """Return a biped on its right foot, as the paper's Fig. 1."""
    return Robot.from_urdf(urdf_text(spec), stance_sole="right_sole", swing_sole="left_sole")


def paper_task(speed: float, margins: Mapping[str, Any] | None = None, **changes: Any) -> Task:
    """Return the paper's task at a speed [m/s], with some fields changed.

    Raises:
        InputError: unknown field, or a value out of range.
    """
    facts = {"duration": printed().duration, "friction": printed().friction}
    chosen = identified_margins() if margins is None else dict(margins)
    return preset_task("paper", **{**facts, **chosen, "speed": speed, **changes})


def paper_walk(speed: float, robot: Robot | None = None, **changes: Any) -> WalkProblem:
    """Return the walk of the identified biped, or of another, at a speed [m/s].

    Raises:
        InputError: unknown field of the task, or a value out of range.
    """
    return WalkProblem(robot or biped_robot(identified_biped()), paper_task(speed, **changes))
