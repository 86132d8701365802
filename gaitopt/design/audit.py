"""A gait file looked at with distrust: is it the walk of its own parameters, and is it optimal?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from gaitopt.bounds import is_finite, shortened, shown
from gaitopt.contact import BOTH_FEET, BUILT_IN
from gaitopt.dataclass import dataclass
from gaitopt.design.certificate import Certificate, certify
from gaitopt.design.pipeline import with_instants_of
from gaitopt.errors import EvaluationError, GaitFileError, InputError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.constraints import Margins
from gaitopt.gait.costs import TorqueCost
from gaitopt.gait.plugin import Extension, extension_record
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import OPTIONAL, Gait, Recorded, array_names, robot_of
from gaitopt.gait.task import task_from_record, task_record
from gaitopt.model.import_options import choices_record
from gaitopt.model.multibody import Multibody
from gaitopt.nlp import Array, kkt_residual
from gaitopt.settings import checked_arguments, checked_facts
from gaitopt.tolerances import OPTIMALITY, SAME

ROBOT_FACTS = ("robot", "mass", "leg_length", "physics", "sole", "limits")
_FACTS = (*ROBOT_FACTS, "cost", "step_length", "duration")


@checked_facts
@dataclass(frozen=True)
class Audit:
    """What is left of a gait file when everything in it is computed again.

    Attributes:
        differences: of each stored array from the one computed from `parameters`, largest entry,
            relative to the largest entry of either.
        facts: records of `meta` that are not what was computed again.
        certificate: computed now, from `parameters`, `urdf` and the task.
        claimed: whether the file says that it is certified.
        imposed: limits and choices that the file itself brings, in words.
    """

    differences: Mapping[str, float]
    facts: tuple[str, ...]
    certificate: Certificate
    claimed: bool
    imposed: tuple[str, ...]

    @property
    def altered(self) -> tuple[str, ...]:
        """Arrays and records that do not follow from the parameters."""
        arrays = (name for name, value in self.differences.items() if not value <= SAME)
        return (*arrays, *self.facts)

    @property
    def passed(self) -> bool:
        """Whether the file is what it says, and certified."""
        return not self.altered and self.certificate.certified


@checked_arguments
def audit(gait: Gait, known: Iterable[Extension] = ()) -> Audit:
    """Compute a gait again from its parameters, its URDF and its task, and certify it.

    Args:
        known: constraints and costs that are not gaitopt's own, as
            `load_plugin("mine.py").extensions`.

    Raises:
        GaitFileError: the gait lacks what is needed for that, or its parameters make no walk, or it
            has a constraint or a cost that is not known.
        InputError: derivatives of a cost that is known are wrong.
        RobotError: its URDF is not a biped.
    """
    problem = problem_of(gait, known)
    try:
        problem.check_own(gait.parameters)
        again = gait_at(problem, gait.parameters, {})
        certificate = certify(problem, gait.parameters)
    except EvaluationError as error:
        raise GaitFileError(f"the gait's parameters do not make a walk: {error}") from error
    differences = differences_of(gait, again, (*array_names(), *OPTIONAL))
    if gait.second is not None and again.second is not None:
        own = differences_of(gait.second, again.second, array_names())
        differences |= {f"second {name}": value for name, value in own.items()}
    if gait.multibody is not None:
        differences |= robot_differences(gait.multibody, problem.robot.multibody)
    recorded = [name for name in _FACTS if name != "physics" or gait.fact(name) is not None]
    facts = [] if gait.foot_contact == again.foot_contact else ["foot_contact"]
    if (gait.second is None) != (again.second is None):
        facts.append("second step")
    if again.second is not None and not _same(gait.fact("motion"), again.fact("motion")):
        facts.append("motion")
    facts += facts_that_differ(gait, again, recorded, certificate)
    if not _multipliers_hold(problem, gait, certificate):
        facts.append("multipliers")
    brought = (*imposed(problem), *_changed_plugins(gait, problem))
    return Audit(differences, tuple(facts), certificate, gait.certified, brought)


def differences_of(stored: object, computed: object, names: Iterable[str]) -> dict[str, float]:
    """Return the differences of arrays of two gaits or transitions, as `Audit.differences`."""
    return {name: _difference(getattr(stored, name), getattr(computed, name)) for name in names}


def facts_that_differ(
    stored: Recorded, computed: Recorded, names: Iterable[str], certificate: Certificate
) -> list[str]:
    """Return keys of two records under which they do not say the same, and what else differs.

    That is what old files leave out, the soles, and a certificate that the stored one denies.
    """
    found = [name for name in names if not _same(stored.fact(name), computed.fact(name))]
    other = ("leg_joints", "stance_sole", "swing_sole_frame")
    found += [name for name in other if getattr(stored, name) != getattr(computed, name)]
    denied = certificate.certified and not stored.certified
    return [*found, "certificate"] if denied else found


def robot_differences(stored: Multibody, computed: Multibody) -> dict[str, float]:
    """Return the differences of the arrays and names of a robot; of names, whether there are."""
    differences = {}
    for one in fields(Multibody):
        pair = getattr(stored, one.name), getattr(computed, one.name)
        numbers = all(isinstance(value, np.ndarray) for value in pair)
        found = _difference(*pair) if numbers else float(pair[0] != pair[1])
        differences[f"robot_{one.name}"] = found
    return differences


def _multipliers_hold(problem: WalkProblem, gait: Gait, certificate: Certificate) -> bool:
    """Whether the gait's multipliers show that it is optimal, if it is."""
    if gait.multipliers is None or gait.bound_multipliers is None or not certificate.optimal:
        return True
    if gait.multipliers.shape != problem.rows.lower.shape:
        return False
    point = problem.point(gait.parameters)
    shown = kkt_residual(problem, point, gait.multipliers, gait.bound_multipliers)
    # both are least-squares solutions, of which rounding may choose another
    return shown.worst <= 2.0 * OPTIMALITY


def imposed(problem: WalkProblem) -> tuple[str, ...]:
    """Return what a walk brings itself instead of taking it from the robot's description.

    That is every margin of its task that is not that of the preset `standard`, every choice about
    the robot, and each joint limit that the task replaces, with the robot's own.
    """
    margins, limits = problem.task.margins, problem.robot.limits
    usual = preset_task(robot=problem.robot).margins
    found = []
    for name, own, unit in (
        ("torque_limit", limits.torque, "N·m"),
        ("speed_limit", limits.speed, "rad/s"),
    ):
        value = getattr(margins, name)
        if value is not None:
            span = " to ".join(dict.fromkeys((f"{own.min():g}", f"{own.max():g}")))
            found.append(
                f"{name} {value:g} {unit} for every joint, where the robot has {span} {unit}"
            )
    for one in fields(Margins):
        value, default = getattr(margins, one.name), getattr(usual, one.name)
        if one.name not in ("torque_limit", "speed_limit") and value != default:
            found.append(f"{one.name} {value}, by default {default}")
    if (cost := problem.task.cost) != TorqueCost():
        found.append(f"cost '{cost.name}' [{cost.unit}]{_from(extension_record(cost))}")
    found += [
        f"constraint '{one.name}'{_from(extension_record(one))}" for one in problem.task.constraints
    ]
    if (terrain := problem.task.terrain) is not None:
        found.append(f"terrain '{terrain.name}'{_from(extension_record(terrain))}")
    choices = choices_record(problem.robot.choices)
    found += [f"choice {name}: {shortened(value)}" for name, value in choices.items()]
    return tuple(found)


def _from(record: Mapping[str, Any]) -> str:
    """Where a constraint, a cost or a terrain comes from, and the values of its fields."""
    plugin, values = record.get("plugin"), record["fields"]
    said = "" if plugin is None else f" of the plugin {plugin['file']}"
    return said + "".join(f", {name} {shortened(value)}" for name, value in values.items())


def _changed_plugins(gait: Gait, problem: WalkProblem) -> Iterator[str]:
    """Say which plugins are not the files with which the gait was designed."""
    task, now = gait.fact("task"), task_record(problem.task)
    if isinstance(task, Mapping):
        before = _plugins(task)
        for file, digest in _plugins(now).items():
            if before.get(file, digest) != digest:
                yield (
                    f"the plugin {file} has changed since the design: its sha256 was "
                    f"{before[file]}..., now it is {digest}..."
                )


def _plugins(task: Mapping[str, Any]) -> dict[str, str]:
    """Digests of a task's plugins by file name."""
    own = task.get("constraints")
    records = [task.get("cost"), task.get("terrain"), *(own if isinstance(own, list) else [])]
    plugins = [one.get("plugin") for one in records if isinstance(one, Mapping)]
    return {str(p.get("file")): str(p.get("sha256")) for p in plugins if isinstance(p, Mapping)}


def problem_of(gait: Gait, known: Iterable[Extension] = ()) -> WalkProblem:
    """Return the walk that a gait says it solves.

    Args:
        known: constraints and costs that are not gaitopt's own.

    Raises:
        GaitFileError: robot, task or parameters are not recorded as gaitopt records them, or the
            task has a constraint or a cost that is not known.
        RobotError: the URDF is not a biped.
    """
    robot = robot_of(gait)
    names = {BOTH_FEET, *(one.name for one in BUILT_IN)}
    if own := [one.contact for one in gait.phases if one.contact not in names]:
        raise GaitFileError(
            f"the foot of the gait has the contact {shown(own[0])}, which is not gaitopt's "
            "own; compute it again in Python from the task it was designed for: "
            "certify(WalkProblem(robot, task), gait.parameters), see docs/extending.md"
        )
    try:
        task = task_from_record(gait.fact("task"), known)
        problem = WalkProblem(robot, task, with_instants_of(task.grid, gait))
    except InputError as error:
        raise GaitFileError(f"the gait's task cannot be used: {error}") from error
    if gait.joint_names != robot.joint_names or gait.parameter_names != problem.layout.names:
        raise GaitFileError(
            "the gait's joint or parameter names are not those of its robot and task; "
            "it was not designed by gaitopt, or its URDF or task has been changed"
        )
    return problem


def _difference(stored: Array, computed: Array) -> float:
    if stored.shape != computed.shape:
        return float("inf")
    a, b = (np.asarray(values, dtype=np.float64) for values in (stored, computed))
    size = max(float(np.abs(a).max(initial=0.0)), float(np.abs(b).max(initial=0.0)))
    return float(np.abs(a - b).max()) / size if size > 0.0 else 0.0


def _same(stored: object, computed: object) -> bool:
    """Whether two records agree, numbers to rounding."""
    if isinstance(stored, Mapping) and isinstance(computed, Mapping):
        return stored.keys() == computed.keys() and all(
            _same(stored[key], computed[key]) for key in stored
        )
    if isinstance(stored, list) and isinstance(computed, list):
        return len(stored) == len(computed) and all(map(_same, stored, computed))
    if is_finite(stored) and is_finite(computed):
        return abs(stored - computed) <= SAME * max(abs(stored), abs(computed))
    return stored == computed
