"""The paper's section 6: the numbers that it prints, and its walks with steps of 0.4 s."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from gaitopt.catalogue.biped_spec import BipedSpec
from gaitopt.catalogue.entries import biped_of, entry_by_name
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task
from gaitopt.importers.text_files import parse_toml
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array


@dataclass(frozen=True)
class PrintedRun:
    """One line of Table 3.

    Attributes:
        iterations, evaluations: of fmincon.
        cost: optimum [N²·m·s].
        seconds: on a 2.0 GHz Core Duo.
    """

    iterations: int
    evaluations: int
    cost: float
    seconds: float

    @property
    def evaluations_per_iteration(self) -> float:
        """About one more than the number of parameters if every gradient is by differences."""
        return self.evaluations / self.iterations


@dataclass(frozen=True)
class PrintedSpeed:
    """Both lines of Table 3 at one speed [m/s]: the gradient of the cost by either way."""

    speed: float
    analytical: PrintedRun
    differences: PrintedRun


@dataclass(frozen=True)
class Printed:
    """Section 6 of the paper.

    Attributes:
        table3: one entry per speed, slowest first.
        mass: [kg].
        duration: of the step [s].
        speed: of Figs. 3 to 6 and 9 [m/s].
        step_length: at that speed [m].
        mean_vertical_force: of the ground on the stance foot at that speed, Fig. 5 [N].
        friction: coefficient.
        cost_one_posture, cost_two_postures: with one or two intermediate postures, Fig. 6.
        fastest: no faster walk is said to be possible, Fig. 7 [m/s].
        slow_hip, fast_hip: speeds between which the stance hip's cost changes, Fig. 8 [m/s].
        parameters: number of them according to section 4.4.
        text_iterations: of the run with differences at that speed, where Table 3 has another.
    """

    table3: tuple[PrintedSpeed, ...]
    mass: float
    duration: float
    speed: float
    step_length: float
    mean_vertical_force: float
    friction: float
    cost_one_posture: float
    cost_two_postures: float
    fastest: float
    slow_hip: float
    fast_hip: float
    parameters: int
    text_iterations: int

    @property
    def speeds(self) -> tuple[float, ...]:
        """Of Table 3 [m/s]."""
        return tuple(row.speed for row in self.table3)

    @property
    def costs(self) -> Array:
        """Analytic column of Table 3 [N²·m·s], shape (8,)."""
        return np.array([row.analytical.cost for row in self.table3])

    def at(self, speed: float) -> PrintedSpeed | None:
        """Return the lines of a speed, None if Table 3 does not have it."""
        return next((row for row in self.table3 if abs(row.speed - speed) < 1e-9), None)


@cache
def printed() -> Printed:
    """Return what the paper prints."""
    text = (resources.files("reproduction") / "printed.toml").read_text("utf-8")
    table = parse_toml(text, "printed.toml")
    rows = tuple(
        PrintedSpeed(
            row["speed"], PrintedRun(**row["analytical"]), PrintedRun(**row["differences"])
        )
        for row in table["table3"]
    )
    return Printed(table3=rows, **table["facts"])


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
