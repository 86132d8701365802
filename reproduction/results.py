"""Everything of the paper's section 6, computed."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cached_property
from importlib import resources
from math import isfinite

import numpy as np

from gaitopt.design.certificate import Certificate, certify
from gaitopt.design.pipeline import versions
from gaitopt.errors import NoGaitFoundError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.result import Gait
from gaitopt.importers.text_files import parse_toml
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array
from reproduction.consequences import Consequences, consequences
from reproduction.curve import Curve, JointCosts, Optimum, cost_curve, joint_costs
from reproduction.gradients import CAP, Comparison, compare
from reproduction.identification import (
    UNKNOWNS,
    Sensitivity,
    relative_errors,
    sensitivity,
    walks_with,
)
from reproduction.paper import biped_robot, identified_biped, paper_walk, printed

FASTER = (1.2, 1.3, 1.4, 1.5)
"""Speeds beyond Table 3, to see where the walks end [m/s]."""

OnStage = Callable[[str], None]


@dataclass(frozen=True)
class Alternative:
    """Other values of the unknowns.

    Attributes:
        note: what they are.
        values: in the order of `UNKNOWNS`, shape (5,).
        errors: J over the printed J, minus 1, shape (8,).
        impulse: vertical, at the impact of the walk at 1.0 m/s; nan without that walk [N·s].
    """

    note: str
    values: Array
    errors: Array
    impulse: float


class Reproduction:
    """The paper's section 6; each part is computed when it is first asked for, and kept.

    Args:
        on_stage: called with a sentence about the part that is being computed.
        cap: CPU seconds after which a run with finite differences is stopped.

    Every part raises NoGaitFoundError where no walk was found at a speed of Table 3.
    """

    def __init__(self, on_stage: OnStage = lambda _stage: None, cap: float = CAP) -> None:
        self._on_stage, self._cap = on_stage, cap
        self._comparisons: dict[float, Comparison] = {}
        self._started = time.perf_counter(), time.process_time()

    @cached_property
    def robot(self) -> Robot:
        """The identified biped."""
        return biped_robot(identified_biped())

    @cached_property
    def curve(self) -> Curve:
        """Walks with two intermediate postures at the speeds of Table 3 and beyond."""
        self._on_stage("costs against speed (Figs. 7 and 8)")
        return found_curve(self.robot, (*printed().speeds, *FASTER), 2)

    @cached_property
    def one_posture(self) -> Curve:
        """Walks with one intermediate posture at the speeds of Table 3."""
        self._on_stage("one intermediate posture (Fig. 6)")
        return found_curve(self.robot, printed().speeds, 1)

    @cached_property
    def certificates(self) -> dict[float, Certificate]:
        """Of the walks of the curve, by speed [m/s]."""
        return {speed: certify(o.problem, o.solution.x) for speed, o in self.curve.items()}

    @cached_property
    def sensitivity(self) -> Sensitivity:
        """Of the costs at the identified values."""
        curve = self.curve
        self._on_stage("sensitivity to what the paper leaves open")
        return sensitivity(curve)

    @cached_property
    def alternatives(self) -> tuple[Alternative, ...]:
        """Other values of the unknowns, with their costs."""
        self._on_stage("other values of what the paper leaves open")
        return other_fits()

    @cached_property
    def consequences(self) -> Consequences:
        """Of other answers to what the paper leaves open."""
        curve = self.curve
        self._on_stage("other answers to what the paper leaves open")
        return consequences(self.robot, curve)

    def comparison(self, speed: float) -> Comparison:
        """Return the kinds of gradients at a speed [m/s]."""
        if speed not in self._comparisons:
            self._on_stage(f"exact derivatives and finite differences at {speed:g} m/s (Table 3)")
            self._comparisons[speed] = compare(paper_walk(speed, self.robot), self._cap)
        return self._comparisons[speed]

    @cached_property
    def comparisons(self) -> tuple[Comparison, ...]:
        """Kinds of gradients, one per speed of Table 3."""
        return tuple(self.comparison(speed) for speed in printed().speeds)

    @cached_property
    def gait(self) -> Gait:
        """At 1.0 m/s."""
        return _gait(self.reference)

    @cached_property
    def gait_one_posture(self) -> Gait:
        """At 1.0 m/s, with one intermediate posture."""
        return _gait(self.one_posture[printed().speed])

    @cached_property
    def joint_costs(self) -> dict[float, JointCosts]:
        """Of the walks of the curve, by speed [m/s]."""
        return {speed: joint_costs(walk) for speed, walk in self.curve.items()}

    @property
    def errors(self) -> Array:
        """J over the printed J, minus 1, at the speeds of Table 3, shape (8,)."""
        return relative_errors(self.curve)

    @property
    def reference(self) -> Optimum:
        """The walk of Figs. 3 to 6 and 9."""
        return self.curve[printed().speed]

    @cached_property
    def seconds(self) -> tuple[float, float]:
        """From the beginning to when this is first asked for: by the clock, of the processor."""
        clock, processor = self._started
        return time.perf_counter() - clock, time.process_time() - processor


def found_curve(robot: Robot, speeds: tuple[float, ...], postures: int) -> Curve:
    """Return the walks of a robot along the speeds [m/s], all those of Table 3 among them.

    Raises:
        NoGaitFoundError: one of those was not found.
    """
    curve = cost_curve([paper_walk(v, robot, postures=postures) for v in speeds])
    missing = [f"{v:g}" for v in printed().speeds if v not in curve]
    if missing:
        raise NoGaitFoundError(
            f"no walk with {postures} intermediate postures was found at {', '.join(missing)} m/s, "
            "which the paper's Table 3 has; the biped's data were changed, or the solver"
        )
    return curve


def other_fits() -> tuple[Alternative, ...]:
    """Return the costs of the values kept as alternatives."""
    text = (resources.files("reproduction") / "alternatives.toml").read_text("utf-8")
    table = parse_toml(text, "alternatives.toml")
    return tuple(_alternative(fit["note"], np.array(fit["values"])) for fit in table["fit"])


def _alternative(note: str, values: Array) -> Alternative:
    curve = cost_curve(walks_with(values))
    impulse = curve[printed().speed].impulse if printed().speed in curve else np.nan
    return Alternative(note, values, relative_errors(curve), impulse)


def _gait(optimum: Optimum) -> Gait:
    return gait_at(optimum.problem, optimum.solution.x, {"status": optimum.solution.status.value})


def record(result: Reproduction) -> dict[str, object]:
    """Return the numbers of a reproduction, beside the printed ones."""
    walks = [
        {
            "speed": speed,
            "cost": walk.cost,
            "printed": None if (row := printed().at(speed)) is None else row.analytical.cost,
            "vertical_impulse": walk.impulse,
            "mean_vertical_force": walk.mean_vertical_force,
            "kkt": result.certificates[speed].kkt.worst,
            "joint_costs": asdict(result.joint_costs[speed]),
        }
        for speed, walk in result.curve.items()
    ]
    return {
        "unknowns": {
            u.name: value
            for u, value in zip(UNKNOWNS, result.sensitivity.values.tolist(), strict=True)
        },
        "errors": result.errors.tolist(),
        "walks": walks,
        "one_posture": {f"{v:g}": walk.cost for v, walk in result.one_posture.items()},
        "consequences": {
            name: value.tolist() if isinstance(value, np.ndarray) else value
            for name, value in vars(result.consequences).items()
        },
        "gradients": [_runs(comparison) for comparison in result.comparisons],
        "seconds": result.seconds[0],
        "cpu_seconds": result.seconds[1],
        "versions": versions(),
    }


def _runs(comparison: Comparison) -> dict[str, object]:
    return {
        "speed": comparison.speed,
        **{
            run.gradient: {
                "status": run.status.name.lower(),
                "cost": run.cost,
                "iterations": run.iterations,
                "evaluations": run.evaluations,
                "cpu_seconds": run.seconds,
                "times_longer": comparison.ratio(run.gradient),
                "times_longer_to_0.1_percent": _number(comparison.near_ratio(run.gradient)),
            }
            for run in comparison.runs
        },
    }


def _number(value: float) -> float | None:
    return value if isfinite(value) else None
