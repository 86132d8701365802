"""Co-design: numbers of a robot chosen together, for a weighted set of walks.

The outer problem is small and smooth as long as the walks stay on their branches: minimise the
weighted sum of the optimal costs over a box of lengths, masses and gear ratios. Its gradient is
exact, by the envelope theorem (`design.sensitivity`), so that each point costs one warm solution of
each walk. The method is a trust region with damped BFGS curvature (Nocedal & Wright, 2006,
algorithm 4.1 and procedure 18.2). It is deterministic: a run that is given its earlier trials goes
on where it was.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy.optimize import lsq_linear

from gaitopt.actuators.motors import MOTORS, Drive, MotorTable
from gaitopt.catalogue.biped_spec import BipedSpec
from gaitopt.catalogue.parameters import PARAMETERS, changed
from gaitopt.dataclass import dataclass
from gaitopt.design.active_set import active_rows, placed
from gaitopt.design.audit import problem_of
from gaitopt.design.options import COUNT, DesignOptions, Search
from gaitopt.design.pipeline import complete
from gaitopt.design.refinement import refine
from gaitopt.design.robot_changes import Anatomy
from gaitopt.design.sensitivity import Envelope, untold
from gaitopt.design.sizing import with_motors
from gaitopt.design.starts import many_starts
from gaitopt.errors import (
    EvaluationError,
    GaitoptError,
    InputError,
    NoGaitFoundError,
    RobotError,
    StoppedError,
    there_are,
)
from gaitopt.gait.initial_guess import resized
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task
from gaitopt.model.import_options import (
    ANKLE_HEIGHT,
    FOOT,
    HIP_WIDTH,
    MASSES,
    SHIN,
    THIGH,
    ImportOptions,
    PartChange,
)
from gaitopt.model.robot import Robot, cached_workspace
from gaitopt.nlp import Array, Solution, Start, Status, Stop, never
from gaitopt.settings import checked, checked_arguments
from gaitopt.solvers.hessian import damped_bfgs
from gaitopt.solvers.sqp import SQP

LEG, FOOT_LENGTH = "leg", "foot_length"
DESIGN = (
    SHIN, THIGH, LEG, "hip_width", "ankle_height", "foot_length", "foot_width", "mass",
    "trunk_mass", "hip_mass", "thigh_mass", "shin_mass", "ankle_mass", "foot_mass",
)  # fmt: skip
"""Parameters of the biped in which the cost of its walks has derivatives."""
OF_FILES = (
    SHIN, THIGH, LEG, HIP_WIDTH, ANKLE_HEIGHT, FOOT_LENGTH, *(f"{part}_mass" for part in MASSES),
)  # fmt: skip
"""Those of them that robots of files have, by `PartChange`."""
RATIO = "ratio"
"""Of gears; `MOTORS`, perhaps the joints of a drive, and this are the name of a variable."""

TOLERANCE = 1e-6
"""Of the cost, relative: a step that promises less ends the search. Generated robots have soles in
whole micrometres, which moves costs by as much."""
_RADIUS, _LARGEST_RADIUS, _LEAST_RADIUS = 0.15, 0.5, 1e-5  # of the ranges of the variables
_GOOD, _BAD = 0.75, 0.1  # share of the promised reduction
_ROUNDS = 5  # of walks held at further instants and searched anew
_SETTLED = 1e-5  # relative change of a walk's cost by that which counts as none
_OTHER = 1e-4  # by which a walk is cheaper that is another local optimum, relative
_FARTHEST = 10.0  # times the value of the robot, or a part of it, to which a range may reach
_LIGHTEST, _HEAVIEST = 1e-6, 1e6  # weights of walks
_SAME = 1e-12  # between values of an earlier trial and those asked for
_INNER = 1e-8  # tolerance of the walks: their errors are second order in it
_CRAWLS = 80  # iterations of a warm walk that has lost its branch


@checked
@dataclass(frozen=True)
class Variable:
    """A number of the robot that is chosen.

    Attributes:
        name: of a parameter of the biped, one of `DESIGN`; or of the gear ratio of all drives,
            "motors.ratio", or those of some joints, "motors.*knee*.ratio".
        lower, upper: of its range.
        start: where the search begins.

    Raises:
        InputError: it is no such parameter, or the range is empty, not above 0, or without the
            start.
    """

    name: str
    lower: float
    upper: float
    start: float

    def __post_init__(self) -> None:
        if self.name not in DESIGN and not self.of_gear:
            raise InputError(
                f"'{self.name}' cannot be chosen; {there_are(DESIGN, self.name)}, and ratios of "
                f"gears, {MOTORS}{RATIO} or {MOTORS}JOINTS.{RATIO}"
            )
        unit = f" {self.unit}".rstrip()
        for end in (self.lower, self.upper, self.start):
            if not (np.isfinite(end) and end > 0.0):
                raise InputError(
                    f"{self.name}: the range {self.lower:g} to {self.upper:g}, begun at "
                    f"{self.start:g}, must be of finite numbers above 0, as in "
                    "25cm:35cm"
                )
        if not self.lower < self.upper:
            raise InputError(
                f"{self.name}: the range {self.lower:g} to {self.upper:g}{unit} is empty; give the "
                "lower end first"
            )
        if not self.lower <= self.start <= self.upper:
            raise InputError(
                f"{self.name} begins at {self.start:g}{unit}, outside its range {self.lower:g} to "
                f"{self.upper:g}{unit}; begin within it"
            )

    @property
    def of_gear(self) -> bool:
        """Whether it is a ratio of gears."""
        return geared_joints(self.name) is not None

    @property
    def unit(self) -> str:
        """Of it, empty where it has none."""
        return "" if self.of_gear else PARAMETERS[self.name].unit


@checked
@dataclass(frozen=True)
class WalkCase:
    """One of the walks that the robot is designed for.

    Attributes:
        label: of it, "0.8 m/s".
        weight: of its cost.
        task: of it, which stays but for motors whose ratios are chosen.
        robot: makes the robot from lengths and masses by name, those that are chosen and that
            follow; rotors whose ratios are chosen are put into it afterwards.
    """

    label: str
    weight: float
    task: Task
    robot: Callable[[Mapping[str, float]], Robot]


@dataclass(frozen=True)
class DesignTrial:
    """A point of the search.

    Attributes:
        values: of the variables, shape (v,).
        cost: weighted sum of the costs of the walks.
        gradient: of it, shape (v,).
        costs: of each walk.
        evaluations: of walks, values or points, that it took.
        seconds: wall time.
        points: parameters and multipliers of each walk.
        round: number of the round of instants.
    """

    values: Array
    cost: float
    gradient: Array
    costs: Array
    evaluations: int
    seconds: float
    points: tuple[tuple[Array, Array], ...]
    round: int = 0


@dataclass(frozen=True)
class CoDesign:
    """What was found.

    Attributes:
        values: of all parameters that moved, by name: those chosen, and those that follow.
        before, after: the walks of the robot as it was and as it is now.
        trials: in order.
        held: why it went no further, in words.
    """

    values: Mapping[str, float]
    before: tuple[Gait, ...]
    after: tuple[Gait, ...]
    trials: tuple[DesignTrial, ...]
    held: tuple[str, ...]

    @property
    def evaluations(self) -> int:
        """Evaluations of walks of all trials."""
        return sum(trial.evaluations for trial in self.trials)


@checked
@dataclass(frozen=True)
class Study:
    """The question of a co-design.

    Attributes:
        spec: the biped as it is, or a robot of a file.
        variables: what is chosen.
        walks: what it is chosen for.
        keep_leg: whether thigh and shin together stay as long as they are; one of them is chosen.
        motors: of the robot, where ratios of them are chosen.

    Raises:
        InputError: there is nothing to choose or no walk, variables exclude each other, a range is
            far from what the robot has, or a walk is of a kind without derivatives.
    """

    spec: BipedSpec | Robot
    variables: tuple[Variable, ...]
    walks: tuple[WalkCase, ...]
    keep_leg: bool = False
    motors: MotorTable | None = None

    def __post_init__(self) -> None:
        names = [one.name for one in self.variables]
        if not names or not self.walks:
            raise InputError("a co-design needs numbers to choose, and walks")
        if len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            raise InputError(f"the range of {twice} is given twice; give one")
        if self.keep_leg and (LEG in names or len({SHIN, THIGH} & set(names)) != 1):
            raise InputError(
                "to keep the length of the leg, choose the shin or the thigh; the other follows"
            )
        if LEG in names and {SHIN, THIGH} & set(names):
            raise InputError("leg is shin and thigh in proportion; choose it or these")
        self._check_gears()
        own = () if isinstance(self.spec, BipedSpec) else OF_FILES
        if own and (
            wrong := [v.name for v in self.variables if v.name not in own and not v.of_gear]
        ):
            raise InputError(
                f"'{wrong[0]}' of a robot of a file cannot be chosen; "
                f"{there_are(OF_FILES, wrong[0])}"
            )
        for one in self.variables:
            self._check_range(one)
        for case in self.walks:
            if not _LIGHTEST <= case.weight <= _HEAVIEST:
                raise InputError(
                    f"the walk '{case.label}': the weight is {case.weight:g}; it must be from "
                    f"{_LIGHTEST:g} to {_HEAVIEST:g}"
                )
            schedule = case.task.schedule
            if case.task.steps > 1 or schedule.closing or schedule.slapping:
                raise InputError(
                    f"the walk '{case.label}' is a stride of two steps, has a double support or a "
                    "foot that comes to lie flat by an impact; what lengths and masses do to these "
                    "is not told yet; leave out lateral_speed, turn_rate, cross_slope, stride, "
                    "double_support and foot_flat"
                )

    def _check_gears(self) -> None:
        """Check that the ratio of each drive is that of one variable at most."""
        taken: dict[str, str] = {}
        for name in (one.name for one in self.variables if one.of_gear):
            for drive in drives_of(self.motors, name):
                if (other := taken.setdefault(drive.joints, name)) != name:
                    raise InputError(
                        f"the ratio of the drive of '{drive.joints}' is chosen twice, by {other} "
                        f"and by {name}; leave out one of them"
                    )

    def _check_range(self, one: Variable) -> None:
        own, unit = self.own[one.name], f" {one.unit}".rstrip()
        if one.lower < own / _FARTHEST or one.upper > _FARTHEST * own:
            example = ", if you like with a unit, as in 25cm:35cm" if unit else ""
            raise InputError(
                f"{one.name}: the range {one.lower:g} to {one.upper:g}{unit} is beyond what can "
                f"be; of this robot it is {own:.4g}{unit}: give {own / _FARTHEST:.4g} to "
                f"{_FARTHEST * own:.4g}{unit} at most{example}"
            )
        if self.keep_leg and one.name in (SHIN, THIGH):
            most = self.own[SHIN] + self.own[THIGH]
            most -= self.own[THIGH if one.name == SHIN else SHIN] / _FARTHEST
            if one.upper > most:
                raise InputError(
                    f"{one.name}: up to {one.upper:g} m leaves too little for the other half of a "
                    f"leg that keeps its length; give at most {most:.4g} m"
                )

    @cached_property
    def own(self) -> dict[str, float]:
        """Values of the parameters of the robot as it is, see `own_values`, and of its gears."""
        gears = [one.name for one in self.variables if one.of_gear]
        return own_values(self.spec) | {name: own_ratio(self.motors, name) for name in gears}

    def parameters(self, values: Array) -> dict[str, float]:
        """Return the parameters that values (v,) of the variables set."""
        found = {one.name: float(v) for one, v in zip(self.variables, values, strict=True)}
        if self.keep_leg:
            chosen = SHIN if SHIN in found else THIGH
            other = THIGH if chosen == SHIN else SHIN
            found[other] = self.own[THIGH] + self.own[SHIN] - found[chosen]
        return found

    @property
    def begun(self) -> dict[str, float]:
        """The parameters where the search begins."""
        return self.parameters(np.array([one.start for one in self.variables]))

    def drives(self, parameters: Mapping[str, float]) -> MotorTable | None:
        """Return the motors with the ratios that parameters set, None where none is chosen."""
        ratios = {k.removeprefix(MOTORS): v for k, v in parameters.items() if k.startswith(MOTORS)}
        return self.motors.changed(ratios) if self.motors is not None and ratios else None

    def each(self, parameters: Mapping[str, float]) -> list[tuple[Robot, Task]]:
        """Return robot and task of every walk with parameters as set; one maker makes one robot."""
        drives, makers = self.drives(parameters), dict.fromkeys(one.robot for one in self.walks)
        robots = {make: self._driven(make(_of_body(parameters)), drives) for make in makers}
        tasks = [
            one.task if drives is None else with_motors(one.task, drives) for one in self.walks
        ]
        return [(robots[one.robot], task) for one, task in zip(self.walks, tasks, strict=True)]

    def _driven(self, robot: Robot, drives: MotorTable | None) -> Robot:
        """Return a robot with the rotors of motors whose ratios are chosen."""
        if drives is None:
            return robot
        limits = drives.with_rotors(robot.choices.limits)
        choices = replace(robot.choices, limits=limits)
        driven = Robot.from_urdf(robot.urdf, choices=choices).as_before(robot.findings)
        self._check_joints(driven, drives)
        return driven

    def _check_joints(self, robot: Robot, drives: MotorTable) -> None:
        """Check that pairs of joints share a ratio, and that rotor inertias follow those chosen."""
        for one in self.variables:
            if one.of_gear:
                apart = drives.changed({one.name.removeprefix(MOTORS): one.lower + one.upper})
                apart.check(robot.joint_names, robot.mirror)
        chosen = [one for v in self.variables if v.of_gear for one in drives_of(drives, v.name)]
        seen = dict(zip(robot.multibody.joint_names, robot.multibody.armature, strict=True))
        for joint in robot.joint_names:
            drive, own = drives.drive(joint), float(seen[joint])
            if drive in chosen and own and not np.isclose(own, drive.armature):
                raise InputError(
                    f"the rotor inertia of '{joint}' is {own:g} kg·m², whatever the gear; leave "
                    "out what sets it (--armature, --limit or a file of choices), so that it "
                    "follows the ratio, or do not choose that"
                )

    def rates(self, at: Envelope, values: Array) -> Array:
        """Return the derivatives of a walk's optimal cost in the variables, shape (v,)."""
        spec, parameters = self.spec, self.parameters(values)
        if isinstance(spec, BipedSpec):
            spec = changed(spec, _of_body(parameters))
        known = {one.name: one for one in at.changes}
        drives = self.drives(parameters)

        def gear_rate(name: str) -> float:
            own = dict.fromkeys(one.at_joint() for one in drives_of(drives, name))
            return sum(at.gear_rates[one] for one in own) / parameters[name]

        def rate(name: str) -> float:
            if name in parameters and name.startswith(MOTORS):
                return gear_rate(name)
            parts = parts_of(spec, name) if isinstance(spec, BipedSpec) else self._of_file(name)
            if missing := [change for change, _ in parts if change not in known]:
                gap = "give a smaller --leg-gap, or " if at.gaps_press else ""
                raise InputError(
                    f"{missing[0]} cannot be chosen for this walk: {'; '.join(untold(at))}; {gap}"
                    "choose other numbers of the robot"
                )
            return sum(factor * at.per_unit(known[change]) for change, factor in parts)

        found = [rate(one.name) for one in self.variables]
        if self.keep_leg:
            for k, one in enumerate(self.variables):
                if one.name in (SHIN, THIGH):
                    found[k] -= rate(THIGH if one.name == SHIN else SHIN)
        return np.array(found)

    def _of_file(self, name: str) -> list[tuple[str, float]]:
        """Changes of a robot of a file that a parameter is made of, and their factors."""
        if name == LEG:
            return [(one, self.own[one] / self.own[LEG]) for one in (SHIN, THIGH)]
        return [(name.replace("_", " "), 1.0)]


def _of_body(parameters: Mapping[str, float]) -> dict[str, float]:
    """Return the lengths and masses among parameters."""
    return {name: value for name, value in parameters.items() if not name.startswith(MOTORS)}


def geared_joints(name: str) -> str | None:
    """Return the joints whose gear ratio a name means, empty for all, None if it means none."""
    joints, _, what = name.removeprefix(MOTORS).rpartition(".")
    return joints if name.startswith(MOTORS) and what == RATIO else None


def drives_of(motors: MotorTable | None, name: str) -> list[Drive]:
    """Return the drives whose ratio is the variable of a name.

    Raises:
        InputError: there are none.
    """
    if motors is None:
        raise InputError(
            f"{name} is a number of the robot's motors, of which nothing is known; give a table of "
            "them: --motors motors.toml"
        )
    return [motors.drives[k] for k in motors.called(geared_joints(name) or "")]


def own_ratio(motors: MotorTable | None, name: str) -> float:
    """Return the ratio of drives as they are.

    Raises:
        InputError: there are no such drives, or they have different ratios.
    """
    ratios = {one.joints: one.ratio for one in drives_of(motors, name)}
    if len(set(ratios.values())) > 1:
        said = ", ".join(f"{ratio:g} of '{joints}'" for joints, ratio in ratios.items())
        raise InputError(
            f"{name} is one ratio for all drives, and these have {said}; choose them each, by "
            f"{MOTORS}JOINTS.{RATIO}"
        )
    return next(iter(ratios.values()))


def own_values(robot: BipedSpec | Robot) -> dict[str, float]:
    """Return the values of the parameters that can be chosen of a robot as it is [m, kg]."""
    if isinstance(robot, BipedSpec):
        return {name: PARAMETERS[name].value(robot) for name in DESIGN}
    measured = cached_workspace(robot, Anatomy).measures()
    found = {name.replace(" ", "_"): value for name, value in measured.items()}
    found[LEG] = found[THIGH] + found[SHIN]
    return {name: found[name] for name in OF_FILES}


def with_proportions(
    robot: Robot, own: Mapping[str, float], values: Mapping[str, float]
) -> ImportOptions:
    """Return the choices with which the file of a robot gives one of other proportions.

    Args:
        own: values of the parameters of the robot as it is, as `Study.own`.
        values: of the same, those that differ.
    """
    found = {one.part: (one.longer, one.heavier) for one in robot.choices.proportions}
    asked, choices = dict(values), robot.choices
    if any(not name.endswith("_mass") for name in asked):  # those kept have its lengths
        choices = replace(choices, capsules=None, arm_capsules=None)
    if (leg := asked.pop(LEG, None)) is not None:
        asked |= {part: leg * own[part] / own[LEG] for part in (SHIN, THIGH)}
    for name, value in asked.items():
        part = FOOT if name == FOOT_LENGTH else name.removesuffix("_mass")
        more = value - own[name]
        longer, heavier = found.get(part, (0.0, 0.0))
        found[part] = (
            (longer, heavier + more) if name.endswith("_mass") else (longer + more, heavier)
        )
    changes = (PartChange(part, *both) for part, both in found.items() if any(both))
    return replace(choices, proportions=tuple(changes))


def parts_of(spec: BipedSpec, name: str) -> list[tuple[str, float]]:
    """Return the changes of a robot that one of `DESIGN` is made of, and their factors."""
    links = spec.links
    masses = {
        "trunk mass": links.torso.mass, "hip yaw link mass": links.hip_yaw.mass,
        "hip roll link mass": links.hip_roll.mass, "thigh mass": links.thigh.mass,
        "shin mass": links.shin.mass, "ankle pitch link mass": links.ankle.mass,
        "foot mass": links.foot.mass,
    }  # fmt: skip
    if name == LEG:
        whole = spec.geometry.d3 + spec.geometry.d4
        return [(SHIN, spec.geometry.d3 / whole), (THIGH, spec.geometry.d4 / whole)]
    if name == "mass":
        return [(one, mass / spec.total_mass) for one, mass in masses.items()]
    if name == "hip_mass":
        hips = ("hip yaw link mass", "hip roll link mass")
        whole = sum(masses[one] for one in hips)
        return [(one, masses[one] / whole) for one in hips]
    return [("ankle pitch link mass" if name == "ankle_mass" else name.replace("_", " "), 1.0)]


class WarmWalks:
    """The walks of a study on their grids, solved warm.

    Attributes:
        solved, evaluations: walks solved warm until now, and evaluations of their programs that it
            took (values or points, each x once), failed ones included.
    """

    def __init__(
        self,
        study: Study,
        first: Sequence[Gait],
        options: DesignOptions,
        stop: Stop = never,
        starts: int = COUNT,
    ) -> None:
        """Begin with walks of the robot as it is.

        Args:
            first: a walk of each of its cases, with multipliers.
            options: how walks are searched anew.
        """
        self.study, self.search, self.round = study, Search(options, stop=stop), 0
        self.starts, self.solved, self.evaluations = starts, 0, 0
        self.problems = [problem_of(gait) for gait in first]
        self.points = [(gait.parameters, _multipliers(gait)) for gait in first]
        self.values = np.array([v.start for v in study.variables])
        self._made = dict[bytes, list[tuple[Robot, Task]]]()

    def _walks(self, values: Array) -> list[tuple[Robot, Task]]:
        """Robot and task of every walk at values (k,); those of the last two designs are kept."""
        key = values.tobytes()
        if key not in self._made:
            kept = list(self._made.items())[-1:]
            self._made = dict([*kept, (key, self.study.each(self.study.parameters(values)))])
        return self._made[key]

    def trial(self, values: Array, near: DesignTrial | None) -> DesignTrial | None:
        """Solve all walks at values (k,) of the variables, from those of a trial near by."""
        started, points, costs, evaluations = time.perf_counter(), [], [], 0
        gradient = np.zeros(values.size)
        before, of = self.points, self.values
        if near is not None and near.round == self.round:
            before, of = list(near.points), near.values
        try:
            old, new = self._walks(of), self._walks(values)
            for k, (case, (x, y)) in enumerate(zip(self.study.walks, before, strict=True)):
                grid = self.problems[k].grid
                problem = WalkProblem(*new[k], grid)
                found = self._solved(problem, WalkProblem(*old[k], grid), x, y)
                evaluations += found.evaluations
                if found.status is not Status.OPTIMAL:
                    return None
                at = Envelope(problem, found.x, found.multipliers)
                gradient += case.weight * self.study.rates(at, values)
                points.append((found.x, found.multipliers))
                costs.append(found.cost)
        except (EvaluationError, InputError, RobotError) as error:
            if near is None and isinstance(error, InputError):
                raise  # where the search begins, to be told
            return None
        weights = [case.weight for case in self.study.walks]
        return DesignTrial(
            values, float(np.dot(weights, costs)), gradient, np.array(costs), evaluations,
            time.perf_counter() - started, tuple(points), self.round,
        )  # fmt: skip

    def _solved(self, problem: WalkProblem, known: WalkProblem, x: Array, y: Array) -> Solution:
        solver = SQP(tolerance=_INNER, max_iterations=_CRAWLS).near_solution()
        if y.size != problem.rows.lower.size:  # nearer legs have other pairs of bodies
            y = placed(problem, active_rows(known, y))
        start = Start(resized(x, known, problem), y)
        found = solver.solve(problem, start, None, self.search.ends)
        self.solved, self.evaluations = self.solved + 1, self.evaluations + found.evaluations
        if found.status is Status.INTERRUPTED:
            raise StoppedError(found)
        return found

    def renewed(self, best: DesignTrial) -> bool:
        """Hold the walks of a trial at further instants, and search each of them anew.

        A walk that was followed from design to design may have become one of several local optima;
        the best of some starts takes its place. Returns whether a walk's cost has changed by that.
        """
        moved, points = 0.0, []
        each = zip(self._walks(best.values), best.points, strict=True)
        for k, ((robot, task), (x, y)) in enumerate(each):
            problem = WalkProblem(robot, task, self.problems[k].grid)
            solver = SQP(tolerance=_INNER)
            found = solver.solve(problem, Start(x, y), None, self.search.ends)
            problem, found = refine(problem, found, solver, self.search)
            x, y, cost = found.x, found.multipliers, found.cost
            options, stop = self.search.options, self.search.stop
            other = many_starts(robot, task, options, count=self.starts, stop=stop).design
            if other.solution.cost < (1.0 - _OTHER) * cost:
                problem, x, y = other.problem, other.solution.x, _multipliers(other.gait)
                cost = other.solution.cost
            moved = max(moved, abs(cost / best.costs[k] - 1.0))
            self.problems[k] = problem
            points.append((x, y))
        self.points, self.values, self.round = points, best.values, self.round + 1
        return moved > _SETTLED

    def finished(self, values: Array) -> Iterator[Gait]:
        """Yield the walks at values of the variables, shape (k,), certified."""
        each = zip(self._walks(values), self.problems, self.points, strict=True)
        for walk, known, (x, y) in each:
            problem = WalkProblem(*walk, known.grid)
            solver = SQP(tolerance=_INNER)
            found = solver.solve(problem, Start(x, y), None, self.search.ends)
            yield complete(problem, found, self.search).gait


def _multipliers(gait: Gait) -> Array:
    if gait.multipliers is None:
        raise InputError("a walk to begin with is not optimal; give it more --starts")
    return gait.multipliers


@checked_arguments
def codesign(
    study: Study,
    options: DesignOptions,
    *,
    earlier: Sequence[DesignTrial] = (),
    before: Sequence[Gait] | None = None,
    starts: int = COUNT,
    on_trial: Callable[[DesignTrial], None] | None = None,
    stop: Stop = never,
) -> CoDesign:
    """Choose the variables of a study for the least weighted sum of the costs of its walks.

    Args:
        options: how walks are designed at first and at last.
        earlier: trials of a run that was interrupted, in order.
        before: walks of the robot as it is, if they are at hand; else they are designed.
        starts: first guesses of each walk that is searched anew.
        stop: ends the search; the trials until then are kept by `on_trial`.

    Raises:
        NoGaitFoundError: the robot as it is cannot do one of the walks.
        InputError: a variable is no parameter of the biped, or out of range.
        StoppedError: `stop` said so.
    """
    first = (
        tuple(before) if before is not None else tuple(first_walks(study, options, stop, starts))
    )
    walks, trials = WarmWalks(study, first, options, stop, starts), list[DesignTrial]()
    waiting = list(earlier)
    lower, upper = (
        np.array([getattr(v, side) for v in study.variables]) for side in ("lower", "upper")
    )
    width = upper - lower

    def evaluate(share: Array, near: DesignTrial | None) -> DesignTrial | None:
        values = lower + share * width
        known = waiting.pop(0) if waiting else None
        if known is not None and np.allclose(known.values, values, rtol=0.0, atol=_SAME):
            trials.append(known)
            return known
        waiting.clear()
        trial = walks.trial(values, near)
        if trial is not None:
            trials.append(trial)
            if on_trial is not None:
                on_trial(trial)
        return trial

    share = (np.array([v.start for v in study.variables]) - lower) / width
    best: DesignTrial | None = None
    halted: tuple[str, ...] = ()
    for _ in range(_ROUNDS):
        try:
            best = minimised(evaluate, share, width)
        except InputError as error:
            if best is None:
                raise
            halted = (f"the better walks found there end the search: {error}",)
            break
        share = (best.values - lower) / width
        if not walks.renewed(best):
            break
    assert best is not None
    after = tuple(walks.finished(best.values))
    held = (*_held(study, best), *halted)
    return CoDesign(study.parameters(best.values), first, after, tuple(trials), held)


def first_walks(
    study: Study, options: DesignOptions, stop: Stop = never, starts: int = COUNT
) -> Iterator[Gait]:
    """Yield the walks of the robot with the variables where they start.

    Raises:
        NoGaitFoundError: it cannot do one of them.
    """
    for case, (robot, task) in zip(study.walks, study.each(study.begun), strict=True):
        try:
            yield many_starts(robot, task, options, count=starts, stop=stop).design.gait
        except GaitoptError as error:
            begin = "; or begin where it can walk: NAME=LOWER:UPPER:START"
            begin = begin if type(error) is NoGaitFoundError else ""
            error.args = (f"the walk '{case.label}': {error}{begin}",)
            raise


def minimised(
    evaluate: Callable[[Array, DesignTrial | None], DesignTrial | None], start: Array, width: Array
) -> DesignTrial:
    """Return the best trial of a trust region with damped BFGS curvature in the unit box.

    Args:
        evaluate: at shares of the ranges (v,), from a trial near by; None where it cannot.
        start: shares where it begins, shape (v,).
        width: of the ranges [units of the variables], shape (v,).

    Raises:
        InputError: it cannot be evaluated where it begins.
    """
    best = evaluate(start, None)
    if best is None:
        raise InputError(
            "the walks cannot be solved where the search begins; begin where the robot is"
        )
    x, g = start, best.gradient * width
    B, radius, learned = np.eye(x.size) * max(np.abs(g).max(), 1e-12) / _RADIUS, _RADIUS, False
    while radius > _LEAST_RADIUS:
        d = box_step(B, g, np.maximum(-radius, -x), np.minimum(radius, 1.0 - x))
        promised = -float(g @ d + 0.5 * d @ B @ d)
        if promised <= TOLERANCE * abs(best.cost):
            break
        trial = evaluate(x + d, best)
        if trial is None:
            radius = 0.25 * float(np.abs(d).max())
            continue
        moved = trial.gradient * width
        change = moved - g
        if not learned and change @ d > 0.0:
            B, learned = np.eye(x.size) * float(change @ change) / float(change @ d), True
        B = damped_bfgs(B, d, change)
        share = (best.cost - trial.cost) / promised
        if share < _BAD:
            radius = 0.25 * float(np.abs(d).max())
        elif share > _GOOD and np.abs(d).max() > 0.99 * radius:
            radius = min(2.0 * radius, _LARGEST_RADIUS)
        if trial.cost < best.cost:
            x, g, best = x + d, moved, trial
    return best


def box_step(B: Array, g: Array, lower: Array, upper: Array) -> Array:
    """Return the minimiser (k,) of g d + d' B d / 2 in a box around 0; B is positive definite."""
    factor = np.linalg.cholesky(B)
    wide = upper > lower
    d = np.zeros(g.size)
    if wide.any():
        target = -np.linalg.solve(factor, g)
        found = lsq_linear(factor.T[:, wide], target, (lower[wide], upper[wide]), tol=1e-14)
        d[wide] = np.clip(found.x, lower[wide], upper[wide])
    return d


def _held(study: Study, best: DesignTrial) -> Iterator[str]:
    """Say which ranges stop the variables, and what a wider one would bring."""
    for one, value, slope in zip(study.variables, best.values, best.gradient, strict=True):
        width = one.upper - one.lower
        for limit, side, outward in ((one.lower, "least", -1.0), (one.upper, "largest", 1.0)):
            if abs(value - limit) < 1e-6 * width and outward * slope < 0.0:
                gain = -outward * slope * 0.01 * width / best.cost
                yield (
                    f"{one.name.replace('_', ' ')} is at the {side} value allowed, {limit:g}; a "
                    f"hundredth of its range more would bring {100.0 * gain:.2g} %"
                )
