"""What the paper prints in section 6: Table 3 and the numbers of its text and figures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np

from gaitopt.nlp import Array
from gaitopt.robot.files.toml import parse_toml


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
    text = (resources.files("gaitopt.study.reproduce") / "printed.toml").read_text("utf-8")
    table = parse_toml(text, "printed.toml")
    rows = tuple(
        PrintedSpeed(
            row["speed"], PrintedRun(**row["analytical"]), PrintedRun(**row["differences"])
        )
        for row in table["table3"]
    )
    return Printed(table3=rows, **table["facts"])
