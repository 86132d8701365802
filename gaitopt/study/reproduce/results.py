"""Everything of the paper's section 6, computed."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from importlib import resources

import numpy as np

from gaitopt.design.certificate import Certificate, certify
from gaitopt.design.runtime import small_matrices
from gaitopt.errors import NoGaitFoundError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.result import Gait
from gaitopt.nlp import Array
from gaitopt.robot.files.toml import parse_toml
from gaitopt.robot.model import Robot
from gaitopt.study.reproduce.consequences import Consequences, consequences
from gaitopt.study.reproduce.curve import Curve, Optimum, cost_curve
from gaitopt.study.reproduce.gradients import CAP, Comparison, compare
from gaitopt.study.reproduce.joint_costs import JointCosts, joint_costs
from gaitopt.study.reproduce.printed import printed
from gaitopt.study.reproduce.sensitivity import Sensitivity, relative_errors, sensitivity
from gaitopt.study.reproduce.unknowns import walks_with
from gaitopt.study.reproduce.walks import biped_robot, identified_biped, paper_walk

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


@dataclass(frozen=True)
class Reproduction:
    """What a run computed.

    Attributes:
        curve: walks with two intermediate postures at the speeds of Table 3 and beyond.
        one_posture: with one, at the speeds of Table 3.
        certificates: of the walks of the curve, by speed [m/s].
        comparisons: kinds of gradients, one per speed of Table 3.
        sensitivity: of the identification.
        alternatives: other values that were tried.
        consequences: of other answers to what the paper leaves open.
        gait: at 1.0 m/s.
        gait_one_posture: at 1.0 m/s.
        seconds, cpu_seconds: of the run, by the wall clock and of the processor.
    """

    curve: Curve
    one_posture: Curve
    certificates: dict[float, Certificate]
    comparisons: tuple[Comparison, ...]
    sensitivity: Sensitivity
    alternatives: tuple[Alternative, ...]
    consequences: Consequences
    gait: Gait
    gait_one_posture: Gait
    seconds: float
    cpu_seconds: float

    @property
    def errors(self) -> Array:
        """J over the printed J, minus 1, at the speeds of Table 3, shape (8,)."""
        return self.sensitivity.errors

    @property
    def reference(self) -> Optimum:
        """The walk of Figs. 3 to 6 and 9."""
        return self.curve[printed().speed]

    @cached_property
    def joint_costs(self) -> dict[float, JointCosts]:
        """Of the walks of the curve, by speed [m/s]."""
        return {speed: joint_costs(walk) for speed, walk in self.curve.items()}


def reproduce(on_stage: OnStage = lambda stage: None, cap: float = CAP) -> Reproduction:
    """Compute the tables and figures of the paper's section 6; takes minutes.

    Args:
        on_stage: told what comes next.
        cap: CPU seconds after which a run with finite differences is stopped.

    Raises:
        NoGaitFoundError: at a speed of Table 3 no walk was found.
        KeyboardInterrupt: Ctrl-C was pressed.
    """
    with small_matrices():
        return _reproduce(on_stage, cap)


def _reproduce(on_stage: OnStage, cap: float) -> Reproduction:
    started, cpu = time.perf_counter(), time.process_time()
    robot = biped_robot(identified_biped())
    on_stage("costs against speed (Figs. 7 and 8)")
    curve = found_curve(robot, (*printed().speeds, *FASTER), 2)
    on_stage("one intermediate posture (Fig. 6)")
    one = found_curve(robot, printed().speeds, 1)
    on_stage("sensitivity to what the paper leaves open")
    dependence = sensitivity(curve)
    alternatives = other_fits()
    comparisons = []
    for speed in printed().speeds:
        on_stage(f"exact derivatives and finite differences at {speed:g} m/s (Table 3)")
        comparisons.append(compare(paper_walk(speed, robot), cap))
    at = printed().speed
    return Reproduction(
        curve=curve,
        one_posture=one,
        certificates={v: certify(o.problem, o.solution.x) for v, o in curve.items()},
        comparisons=tuple(comparisons),
        sensitivity=dependence,
        alternatives=alternatives,
        consequences=consequences(robot, curve),
        gait=_gait(curve[at]),
        gait_one_posture=_gait(one[at]),
        seconds=time.perf_counter() - started,
        cpu_seconds=time.process_time() - cpu,
    )


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
    text = (resources.files(__package__) / "alternatives.toml").read_text("utf-8")
    table = parse_toml(text, "alternatives.toml")
    return tuple(_alternative(fit["note"], np.array(fit["values"])) for fit in table["fit"])


def _alternative(note: str, values: Array) -> Alternative:
    curve = cost_curve(walks_with(values))
    impulse = curve[printed().speed].impulse if printed().speed in curve else np.nan
    return Alternative(note, values, relative_errors(curve), impulse)


def _gait(optimum: Optimum) -> Gait:
    return gait_at(optimum.problem, optimum.solution.x, {"status": optimum.solution.status.value})
