"""The grid of a sweep: the quantities that vary, their values, and all combinations of them.

One robot with one task: what a gait is designed for, in a form that travels between machines.
"""

from __future__ import annotations

import itertools
import json
import math
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Sized
from contextlib import suppress
from dataclasses import fields, replace
from functools import cached_property, lru_cache
from itertools import islice, pairwise

from gaitopt.actuators.motors import MOTORS, MotorTable, motor_quantities
from gaitopt.bounds import POINTS, at_most
from gaitopt.catalogue.biped_spec import BipedSpec
from gaitopt.catalogue.parameters import PARAMETERS, changed, parameter_unit
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.dataclass import dataclass
from gaitopt.design.sizing import with_motors
from gaitopt.errors import InputError, SpecError, did_you_mean
from gaitopt.gait.constraint import declared_margins
from gaitopt.gait.constraints import Margins
from gaitopt.gait.parameters import DURATION, GEOMETRY, GEOMETRY_NAMES, set_geometry
from gaitopt.gait.task import Task, task_from_record, task_record
from gaitopt.importers.report import Finding
from gaitopt.model.import_options import ImportOptions, choices_from_record, choices_record
from gaitopt.model.robot import Robot
from gaitopt.settings import checked, checked_arguments, declared
from gaitopt.units import read_quantity

DIGITS = 10  # of grid values: 0.4 + 3 * 0.05 is 0.55, not 0.55000000000000004

_TASK = (
    "speed", "lateral_speed", "turn_rate", "duration", "slope", "cross_slope", "stairs",
    "penalty_weight",
)  # fmt: skip
OF_STRIDES = ("lateral_speed", "turn_rate", "cross_slope")
"""Quantities of strides: over them all points are strides, those that go straight ahead too."""
_MARGINS = tuple(f.name for f in fields(Margins) if f.name not in ("joint_range", "impulse_cop"))
_GEOMETRY = {
    f"hold.{name}" if name in _MARGINS else name: name
    for name in GEOMETRY_NAMES
    if name != GEOMETRY_NAMES[DURATION]
}
"""Geometric quantities by the name of their axis: trunk_pitch is a limit, hold.trunk_pitch a value
of the double support."""
_UNITS = {
    **{one.name: one.unit for one in declared(Task)},
    **{name: margin.unit for name, margin in declared_margins(Margins).items()},
    **{q.name: q.unit for q in GEOMETRY if q.name not in _MARGINS},
    **{f"hold.{q.name}": q.unit for q in GEOMETRY},
}
_PARTS = ("geometry", "links", "joints")
_OWN = "own."
"""Before the name of a margin of a constraint of the task's own."""


@checked
@dataclass(frozen=True)
class Axis:
    """One quantity and the values it takes.

    Attributes:
        name: a field of `Task` or `Margins`, a geometric quantity (held at the value; as
            "hold.trunk_pitch" where a limit has the same name), a parameter of a biped, as "shin",
            the path of an entry of its specification, as "geometry.d3"; after "motors." a number of
            the drives of a table of motors, of all ("motors.ratio") or those of some joints
            ("motors.knee.ratio"); or, after "own.", a margin of a constraint of the task's own.
        values: increasing, SI units of the quantity.

    Raises:
        InputError: unknown name; values missing, not finite, or not increasing.
    """

    name: str
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise InputError(f"a sweep is over a quantity by its name, not {self.name!r}")
        names = (*_TASK, *_MARGINS, *_GEOMETRY)
        known = self.name in names or self.name.startswith(_OWN)
        if not known and not self.of_robot:
            raise InputError(
                f"there is no quantity '{self.name}' to sweep over; "
                f"{did_you_mean(self.name, (*names, *PARAMETERS))}there are {', '.join(_TASK)}; "
                f"the limits {', '.join(_MARGINS)}; the geometric quantities, held at the value, "
                f"{', '.join(_GEOMETRY)}; parameters of a biped, {', '.join(PARAMETERS)}, and the "
                "entries of its specification, as geometry.d3; motors.NAME and motors.JOINTS.NAME "
                f"of a table of motors, {', '.join(motor_quantities())}; own.NAME of constraints "
                "of your own"
            )
        values = _numbers(self.name, self.values)
        if not values or not all(map(math.isfinite, values)):
            raise InputError(f"{self.name} has no values, or not finite ones; give at least one")
        if any(b <= a for a, b in pairwise(values)):
            raise InputError(f"the values of {self.name} do not increase; give each once, in order")
        object.__setattr__(self, "values", values)

    @property
    def of_motors(self) -> bool:
        """Whether the quantity is one of a table of motors."""
        return _of_motors(self.name)

    @property
    def of_robot(self) -> bool:
        """Whether the quantity is one of the robot's specification, or of its motors."""
        return (
            self.of_motors
            or (self.name.split(".")[0] in _PARTS and "." in self.name)
            or self.name in PARAMETERS
        )


def _of_motors(name: str) -> bool:
    return name.startswith(MOTORS) and name.rpartition(".")[2] in motor_quantities()


def quantity_unit(name: str) -> str:
    """Return the SI unit of a quantity that can be swept, empty where it has none."""
    if _of_motors(name):
        return motor_quantities()[name.rpartition(".")[2]]
    if unit := _UNITS.get(name):
        return unit
    with suppress(SpecError):  # what there is to sweep over is told where the quantity is set
        return parameter_unit(name)
    return ""


def read_named(name: str, text: str) -> float:
    """Return a value of such a quantity in its SI unit.

    Raises:
        ValueError: it is none; the message says what to give.
    """
    return read_quantity(text, quantity_unit(name))


def _numbers(name: str, values: Iterable[float]) -> tuple[float, ...]:
    try:
        numbers = tuple(round(float(v), DIGITS) for v in islice(values, POINTS + 1))
        at_most(len(values) if isinstance(values, Sized) else len(numbers), POINTS, "values")
        return numbers
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"the values of {name} are {values!r}; give numbers, as (0.8, 1.0)") from (
            error
        )


@checked_arguments
def parse_axis(name: str, text: str) -> Axis:
    """Return the axis of a range "first:last:step" (both ends included) or of a list "a,b,c".

    Raises:
        InputError: the text is neither.
    """
    try:
        words = text.split(":" if ":" in text else ",")
        parts = [read_named(name, word) for word in words]
    except ValueError:
        parts = []
    if ":" not in text and parts:
        return Axis(name, tuple(parts))
    if len(parts) != 3 or not all(map(math.isfinite, parts)) or not parts[2] > 0.0:
        raise InputError(
            f"'{text}' is no range of {name}; give first:last:step with a step above 0, as "
            "0.4:1.3:0.05, or the values, as 0.4,0.6,1.0; each may have its unit, as 10deg"
        )
    first, last, step = parts
    if first > last:
        raise InputError(
            f"the range {text} of {name} begins above its end; give the lower value first: "
            f"{last:g}:{first:g}:{step:g}"
        )
    count = math.floor((last - first) / step + 1e-6) + 1
    at_most(count, POINTS, f"values of {name}", "with a larger step, or in several sweeps")
    return Axis(name, tuple(first + i * step for i in range(count)))


def with_values(task: Task, values: Iterable[tuple[str, float]]) -> Task:
    """Return the task with some quantities changed; those of the robot are passed over.

    Raises:
        InputError: a value is out of range, or the task has no such margin.
    """
    changes: dict[str, float] = {}
    margins: dict[str, float] = {}
    own: dict[str, float] = {}
    geometry: dict[str, dict[str, float | bool]] = {}
    for name, value in values:
        if name in _TASK:
            changes[name] = value
        elif name in _MARGINS:
            margins[name] = value
        elif name.startswith(_OWN):
            own[name.removeprefix(_OWN)] = value
        elif name in _GEOMETRY:
            geometry[_GEOMETRY[name]] = {"free": False, "value": value}
    return replace(
        task.with_margins(own),
        **changes,  # type: ignore[arg-type]
        margins=replace(task.margins, **margins),  # type: ignore[arg-type]
        geometry=set_geometry(task.geometry, geometry),
    )


Index = tuple[int, ...]
"""Which value of each axis."""


@checked
@dataclass(frozen=True)
class TaskGrid:
    """A grid and the points from which it is explored.

    Attributes:
        axes: at least one, with different names.
        seeds: where the exploration starts; by default both ends of the longest axis, in the middle
            of the others: the front is twice as wide and as many branches of optima are met as by
            starting from the middle and again at the ends, for fewer tries.

    Raises:
        InputError: no axis, one twice, or too many points.
    """

    axes: tuple[Axis, ...]
    seeds: tuple[Index, ...] = ()

    def __post_init__(self) -> None:
        names = [axis.name for axis in self.axes]
        if not names or len(set(names)) < len(names):
            raise InputError("a sweep needs at least one quantity, and each only once")
        at_most(math.prod(len(axis.values) for axis in self.axes), POINTS, "points of a sweep")
        if not self.seeds:
            object.__setattr__(self, "seeds", self._both_ends())

    @cached_property
    def order(self) -> tuple[Index, ...]:
        """All points, those near a seed first."""
        ranges = [range(len(axis.values)) for axis in self.axes]
        return tuple(sorted(itertools.product(*ranges), key=lambda p: (self.ring(p), p)))

    def __contains__(self, point: object) -> bool:
        """Whether there is such a point."""
        return (
            isinstance(point, tuple)
            and len(point) == len(self.axes)
            and all(
                type(index) is int and 0 <= index < len(axis.values)
                for index, axis in zip(point, self.axes, strict=True)
            )
        )

    def values(self, point: Index) -> dict[str, float]:
        """Return the value of each quantity at a point."""
        return {a.name: a.values[i] for a, i in zip(self.axes, point, strict=True)}

    @cached_property
    def levels(self) -> tuple[GridLevel, ...]:
        """The grids through which it is explored, from every so many values to all of them."""
        strides = [_coarsest(len(axis.values)) for axis in self.axes]
        found: list[GridLevel] = []
        while not found or max(strides) >= 1:
            nodes = tuple(
                tuple(sorted({*range(0, len(axis.values), max(stride, 1)), len(axis.values) - 1,
                              *(seed[k] for seed in self.seeds)}))
                for k, (axis, stride) in enumerate(zip(self.axes, strides, strict=True))
            )  # fmt: skip
            found.append(GridLevel(self, nodes, found[-1].nodes if found else None))
            if max(strides) <= 1:
                break
            strides = [stride // 2 for stride in strides]
        return tuple(found)

    @property
    def probes(self) -> tuple[Index, ...]:
        """The ends of the lines through the seeds along each axis, where no seed is."""
        found = {
            (*seed[:k], end, *seed[k + 1 :])
            for seed in self.seeds
            for k, axis in enumerate(self.axes)
            for end in (0, len(axis.values) - 1)
        }
        return tuple(sorted(found - {*self.seeds}))

    def nearest(self, values: Mapping[str, float]) -> Index:
        """Return the point nearest to some values; quantities not given are in the middle.

        Raises:
            InputError: a quantity is not one of the axes.
        """
        names = [axis.name for axis in self.axes]
        unknown = set(values) - set(names)
        if unknown:
            raise InputError(
                f"the sweep is not over {', '.join(sorted(unknown))}; "
                f"{did_you_mean(min(unknown), names)}it is over {', '.join(names)}"
            )
        return tuple(
            min(range(len(axis.values)), key=lambda i: abs(axis.values[i] - values[axis.name]))
            if axis.name in values
            else start
            for axis, start in zip(self.axes, self._middle(), strict=True)
        )

    def name(self, point: Index) -> str:
        """Return the name of a point in files: "speed=0.85,duration=0.4"."""
        return ",".join(f"{name}={value:.10g}" for name, value in self.values(point).items())

    def ring(self, point: Index) -> int:
        """Return how many values a point is away from a seed."""
        return min(sum(abs(i - j) for i, j in zip(point, seed, strict=True)) for seed in self.seeds)

    def _middle(self) -> Index:
        return tuple((len(axis.values) - 1) // 2 for axis in self.axes)

    def _both_ends(self) -> tuple[Index, ...]:
        middle, sizes = self._middle(), [len(axis.values) for axis in self.axes]
        k = sizes.index(max(sizes))
        ends = {0, sizes[k] - 1}
        return tuple(sorted((*middle[:k], end, *middle[k + 1 :]) for end in ends))


COARSE = 16  # values of an axis, at least, with which the exploration of a longer one begins


def _coarsest(count: int) -> int:
    """Return every how many-th of so many values is explored first, a power of two."""
    return 1 << max(0, int(math.log2(max(1, (count - 1) / COARSE))))


@dataclass(frozen=True)
class GridLevel:
    """A part of a grid: some values of every axis, and all their combinations.

    Attributes:
        grid: the whole.
        nodes: which values of each axis.
        coarser: those of the level before it, None for the first.
    """

    grid: TaskGrid
    nodes: tuple[tuple[int, ...], ...]
    coarser: tuple[tuple[int, ...], ...] | None

    @cached_property
    def points(self) -> tuple[Index, ...]:
        """All points, those near a seed first."""
        return tuple(sorted(itertools.product(*self.nodes), key=lambda p: (self.grid.ring(p), p)))

    def neighbours(self, point: Index) -> Iterator[tuple[int, Index]]:
        """Yield the points one node away, each with the axis along which."""
        for k, nodes in enumerate(self.nodes):
            at = bisect_left(nodes, point[k])
            for step in (-1, 1):
                if 0 <= at + step < len(nodes):
                    yield k, (*point[:k], nodes[at + step], *point[k + 1 :])

    def inner(self, point: Index) -> list[Index]:
        """Return the neighbours that are explored before a point of this level.

        On the first level these are the ones nearer to a seed, on the others those between which
        the point lies.
        """
        if self.coarser is None:
            ring = self.grid.ring
            return [q for _, q in self.neighbours(point) if ring(q) < ring(point)]
        return [q for k, q in self.neighbours(point) if point[k] not in self.coarser[k]]

    def line(self, point: Index, origin: Index) -> list[Index]:
        """Return the points explored before a point that are on its line through a neighbour.

        On the first level the neighbour and the one beyond it; on the others four around the point
        where it lies on a line of the coarser level, else the two between which it lies.
        """
        (k,) = (n for n, (a, b) in enumerate(zip(point, origin, strict=True)) if a != b)
        if self.coarser is None:
            rest = (*origin[:k], *origin[k + 1 :])
            beyond = [q for q in self.inner(origin) if (*q[:k], *q[k + 1 :]) == rest]
            away = [q for q in beyond if (q[k] - origin[k]) * (origin[k] - point[k]) > 0]
            return [origin, *away]
        others = [n for n in range(len(point)) if n != k]
        nodes = self.nodes[k]
        if all(point[n] in self.coarser[n] for n in others):
            nodes = self.coarser[k]
        at = bisect_left(nodes, point[k])
        near = [*nodes[max(0, at - 2) : at], *nodes[at : at + 2]]
        if nodes is self.nodes[k]:
            near = [nodes[i] for i in (at - 1, at + 1) if 0 <= i < len(nodes)]
        found = [(*point[:k], node, *point[k + 1 :]) for node in near]
        return [origin, *(q for q in found if q != origin)]


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
        findings: about the robot, when what it was made of was first read.
    """

    urdf: str
    choices: ImportOptions
    spec: BipedSpec | None = None
    changes: tuple[tuple[str, float], ...] = ()
    motors: MotorTable | None = None
    findings: tuple[Finding, ...] = ()

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
        return _robot(urdf, choices, self.findings)


def _chosen(spec: BipedSpec, choices: ImportOptions) -> ImportOptions:
    """Return the choices of a biped without what was found in its file: soles, places of loads."""
    unplaced = tuple(replace(one, place=None) for one in choices.payloads)
    sole = None if choices.sole_placements is None else choices.sole  # they go together
    found = _robot(urdf_text(spec), replace(choices, sole=sole, payloads=unplaced)).choices
    loads = tuple(
        free if there == own else own
        for free, there, own in zip(unplaced, found.payloads, choices.payloads, strict=True)
    )
    sole = sole if found.sole == choices.sole else choices.sole
    return replace(choices, sole=sole, payloads=loads)


def _robot(urdf: str, choices: ImportOptions, findings: tuple[Finding, ...] = ()) -> Robot:
    return _built(urdf, json.dumps(choices_record(choices)), findings)


@lru_cache(maxsize=_CACHED_ROBOTS)
def _built(urdf: str, choices: str, findings: tuple[Finding, ...]) -> Robot:
    robot = Robot.from_urdf(urdf, choices=choices_from_record(json.loads(choices)))
    return robot.as_before(findings)


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
