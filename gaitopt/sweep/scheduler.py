"""The sweep: which point is tried from where, in which order.

    explore   from the seeds on, each point from the best of its neighbours nearer to a seed
    probe     the ends of the grid from first guesses too
    compare   where two neighbours are on different branches, each from the other; keep the lower
    finish    limits between the samples, second opinion, certificate: a gait file
    explain   the points that are left

What is done for a point depends only on what is known of its neighbours at a stage, never on who
does it or how fast, so that any number of workers finds the same gaits.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import NoneType

from gaitopt.catalogue.biped_spec import BipedSpec
from gaitopt.catalogue.parameters import changed
from gaitopt.design.options import DesignOptions
from gaitopt.errors import InputError
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.sweep.executor import DIAGNOSE, FINISH, TRAVEL, Alone, Crew, Job, Outcome
from gaitopt.sweep.grid import Axis, GridPoints, Index, with_values
from gaitopt.sweep.library import Library, Writer, open_library
from gaitopt.sweep.manifest import claim, manifest_record
from gaitopt.sweep.scenario import RobotSource, Setting, source_of
from gaitopt.sweep.warm_start import SAME, Footing, lower, promising

TaskAt = Callable[[dict[str, float]], Task]


@dataclass(frozen=True)
class Plan:
    """The settings of all points.

    Attributes:
        points: the grid.
        robot: without the changes of a point.
        tasks: of every point.
    """

    points: GridPoints
    robot: RobotSource
    tasks: Mapping[Index, Task]

    def setting(self, point: Index) -> Setting:
        """Return robot and task of a point."""
        return Setting(robot_at(self.robot, self.points, point), self.tasks[point])

    def axes(self, point: Index) -> tuple[tuple[str, float], ...]:
        """Return the swept quantities with their values at a point."""
        return tuple(self.points.values(point).items())


def make_plan(robot: Robot, spec: BipedSpec | None, points: GridPoints, task_at: TaskAt) -> Plan:
    """Return the plan of a sweep, every task checked.

    Raises:
        InputError: a value is out of range, or the robot has no specification to vary.
    """
    source = source_of(robot, spec)
    varied = [axis for axis in points.axes if axis.of_robot]
    if varied and spec is None:
        raise InputError(
            f"{varied[0].name} is an entry of a specification, but the robot was not made from "
            "one; sweep over a generated biped, or over quantities of the task"
        )
    for axis in varied:
        for value in (axis.values[0], axis.values[-1]):
            changed(spec, {axis.name: value})  # type: ignore[arg-type]
    return Plan(points, source, {p: task_at(points.values(p)) for p in points.order})


def robot_at(robot: RobotSource, points: GridPoints, point: Index) -> RobotSource:
    """Return the robot of a point."""
    values = points.values(point)
    changes = tuple((axis.name, values[axis.name]) for axis in points.axes if axis.of_robot)
    return replace(robot, changes=changes)


NEAREST = 3  # neighbours that a point is tried from
ROUNDS = 1000  # of comparison; nothing is tried twice, so this is never reached


@dataclass(frozen=True)
class Advance:
    """How far a sweep is.

    Attributes:
        points: of the grid.
        explored: points that were tried.
        gaits: finished.
        refused: points found to have none.
        doing: what is being done.
    """

    points: int
    explored: int
    gaits: int
    refused: int
    doing: str


OnAdvance = Callable[[Advance], None]


class Stages:
    """The state of a sweep, and who writes and works."""

    def __init__(
        self,
        plan: Plan,
        options: DesignOptions,
        writer: Writer,
        crew: Crew,
        on_advance: OnAdvance | None,
    ) -> None:
        self.plan, self.options, self.writer, self.crew = plan, options, writer, crew
        self.points, self.state = plan.points, writer.state
        self.tell = on_advance or (lambda advance: None)
        self._handed_on: dict[Index, list[Index]] = {}  # by points without a walk, to those beyond
        self.named = {self.points.name(p): p for p in self.points.order}

    def run(self) -> None:
        """Go through all of them, from wherever the library stands."""
        self._explore()
        self._probe()
        for _ in range(ROUNDS):
            if not self._compare() and not self._start_anew():
                break
        self._finish()

    def _explore(self) -> None:
        """Every point once, as soon as all its inner neighbours are explored."""
        known, begun = self.state.footings, set(self.state.footings)
        inner = {p: self.points.inner(p) for p in self.points.order}

        def begin(candidates: Iterable[Index]) -> list[Job]:
            ready = [p for p in candidates if p not in begun and all(q in known for q in inner[p])]
            begun.update(ready)
            return [self._first(p) for p in ready]

        def note(outcome: Outcome) -> list[Job]:
            self._note_walk(outcome)
            return begin(q for _, q in self.points.neighbours(outcome.job.point))

        self._drive("exploring", begin(self.points.order), note)

    def _first(self, point: Index) -> Job:
        near = self._origins(point)[:NEAREST]
        return self._travel(point, near, patient=True, cold=not near)

    def _origins(self, point: Index) -> list[Index]:
        """Return inner neighbours that walk, in place of others those they were tried from."""
        found: set[Index] = set()
        for other in self.points.inner(point):
            if self.state.footings[other] is not None:
                found.add(other)
            else:
                if other not in self._handed_on:
                    self._handed_on[other] = self._origins(other)
                found.update(self._handed_on[other][:NEAREST])
        return sorted(found, key=lambda q: (self._predicted(q, point), q))

    def _predicted(self, origin: Index, point: Index) -> float:
        """Return the cost at a point by the slopes at another."""
        here, there = self.points.values(point), self.points.values(origin)
        footing = self._walk(origin)
        strides = (here[name] - there[name] for name in here)
        return footing.cost + sum(
            (slope or 0.0) * stride for slope, stride in zip(footing.slopes, strides, strict=True)
        )

    def _probe(self) -> None:
        """Far from the seeds, and after leaps, start anew as well: other branches may be better."""
        wanted = {*self.points.probes, *filter(self._leapt, self.points.order)}
        jobs = [self._anew(p) for p in sorted(wanted) if p not in self.state.probed]
        self._drive("probing", jobs, self._note_walk)

    def _compare(self) -> bool:
        """Try points from neighbours of another branch, once round; tell whether any was tried.

        A neighbour that may itself be about to change is waited for.
        """
        if not self.state.due:  # else an earlier call was interrupted in the midst of a round
            due = {p: q for p in self.points.order if (q := self._rival(p)) is not None}
            settled = {p: q for p, q in due.items() if q not in due}
            pairs = list((settled or due).items())
            if pairs:
                self.writer.note(pairs[0][0], round=pairs)
        jobs = [
            self._travel(p, [q], patient=self.state.footings[p] is None, cold=False)
            for p, q in self.state.due.items()
        ]
        self._drive("comparing", jobs, self._note_walk)
        return bool(jobs)

    def _rival(self, point: Index) -> Index | None:
        """Return the most promising neighbour that a point was not yet tried from."""
        if point in self.state.rows:
            return None
        near = promising(self.points, self.state.footings, point)
        return next((q for q in near if not self._compared(point, q)), None)

    def _compared(self, point: Index, other: Index) -> bool:
        """Whether a point was tried from another, or both are as good as single designs.

        To try these too found nothing, for up to half as many iterations again (coarse grids).
        """
        probed = self.state.probed
        alone = point in probed and other in probed and self.state.footings[point] is not None
        return alone or (point, other, self._walk(other).cost) in self.state.tried

    def _start_anew(self) -> bool:
        """Points to which no neighbour or a leap led, as a single design; tell if any was tried."""
        footings, probed = self.state.footings, self.state.probed
        left = [p for p in self.points.order if footings[p] is None or self._leapt(p)]
        jobs = [self._anew(p) for p in left if p not in probed]
        self._drive("starting anew", jobs, self._note_walk)
        return bool(jobs)

    def _anew(self, point: Index) -> Job:
        return self._travel(point, [], patient=False, cold=True)

    def _leapt(self, point: Index) -> bool:
        footing = self.state.footings[point]
        return footing is not None and footing.leapt

    def _finish(self) -> None:
        """Make gaits of the walks, and explain the points without."""
        settled = self.state.rows.keys() | self.state.refusals.keys()
        jobs = []
        for point in sorted(self.points.order):
            footing = self.state.footings[point]
            if point not in settled:
                jobs.append(self._job(FINISH if footing else DIAGNOSE, point, walk=footing))
        self._drive("finishing", jobs, self._note_gait)

    def _walk(self, point: Index) -> Footing:
        footing = self.state.footings[point]
        if footing is None:
            raise KeyError(f"no walk is known at {self.points.name(point)}")
        return footing

    def _travel(self, point: Index, near: list[Index], *, patient: bool, cold: bool) -> Job:
        known = tuple((self.plan.setting(q), self._walk(q), self.points.name(q)) for q in near)
        here = self.state.footings.get(point)
        below = math.inf if here is None else here.cost * (1.0 - SAME)
        more = {"patient": patient, "cold": cold, "below": below}
        return self._job(TRAVEL, point, near=known, **more)

    def _job(self, kind: str, point: Index, **more: object) -> Job:
        setting, axes = self.plan.setting(point), self.plan.axes(point)
        return Job(kind, point, setting, axes, self.options, **more)  # type: ignore[arg-type]

    def _note_walk(self, outcome: Outcome) -> list[Job]:
        job, found = outcome.job, outcome.footing
        known = self.state.footings.get(job.point)
        entry: dict[str, object] = {"seconds": outcome.seconds}
        tried = []
        for _, footing, name in job.near:
            tried.append([list(self.named[name]), footing.cost])
            if found is not None and found.origin == name:
                break
        if tried:
            entry["tried"] = tried
        if job.point not in self.state.footings or lower(found, known):
            entry["footing"] = None if found is None else found.record()
        if job.cold:
            entry["probed"] = True
        self.writer.note(job.point, **entry)
        return []

    def _note_gait(self, outcome: Outcome) -> list[Job]:
        job, seconds = outcome.job, outcome.seconds
        if outcome.gait is not None and outcome.row is not None:
            self.writer.save(job.point, outcome.gait, outcome.row, seconds=seconds)
        elif outcome.refusal is not None:
            self.writer.note(job.point, refusal=outcome.refusal, seconds=seconds)
        else:  # a walk at its samples that refinement did not survive
            self.writer.note(job.point, seconds=seconds)
            return [self._job(DIAGNOSE, job.point)]
        return []

    def _drive(self, doing: str, jobs: Iterable[Job], note: Callable[[Outcome], list[Job]]) -> None:
        """Have jobs done, and those that follow from their outcomes; note each as it comes."""
        waiting, flying = deque(jobs), 0
        while waiting or flying:
            while waiting and flying < self.crew.room:
                self.crew.submit(waiting.popleft())
                flying += 1
            outcome = self.crew.next()
            flying -= 1
            waiting.extend(note(outcome))
            self.tell(self._advance(doing))

    def _advance(self, doing: str) -> Advance:
        return Advance(
            points=len(self.points.order),
            explored=len(self.state.footings),
            gaits=len(self.state.rows),
            refused=len(self.state.refusals),
            doing=doing,
        )


__all__ = ["Advance", "OnAdvance", "sweep"]

_KINDS: dict[str, tuple[tuple[type, ...], str]] = {
    "robot": ((Robot,), "a Robot, as Robot.from_urdf(urdf_text(biped13()))"),
    "task": ((Task,), "a Task, as preset_task()"),
    "directory": ((str, Path), "a path"),
    "options": ((DesignOptions,), "DesignOptions"),
    "spec": ((BipedSpec, NoneType), "a BipedSpec, as biped13()"),
    "crew": ((Crew, NoneType), "a Crew, as local_crew(2)"),
}


def sweep(
    robot: Robot,
    task: Task,
    axes: Iterable[Axis],
    directory: str | Path,
    options: DesignOptions | None = None,
    *,
    spec: BipedSpec | None = None,
    seed: dict[str, float] | None = None,
    task_at: Callable[[dict[str, float]], Task] | None = None,
    crew: Crew | None = None,
    on_advance: OnAdvance | None = None,
) -> Library:
    """Design a gait at every point of a grid; go on where an earlier call was interrupted.

    Args:
        robot: the biped.
        task: of which the axes vary quantities.
        axes: at least one.
        directory: of the library; made if it does not exist.
        options: as of `design`.
        spec: of the robot, which axes of its entries need.
        seed: values near which to begin; by default both ends of the longest axis.
        task_at: the task for values of the axes, if more follows from them than themselves.
        crew: who does the work; by default this process.
        on_advance: told after every job.

    Returns:
        The library, every point of it finished or refused.

    Raises:
        InputError: axes, seed or a task cannot be used; the directory cannot be written, holds
            something else, or is in use.
        KeyboardInterrupt: Ctrl-C was pressed; what was done is kept.
    """
    options = options or DesignOptions()
    _require(robot=robot, task=task, directory=directory, options=options, spec=spec, crew=crew)
    points = GridPoints(_axes(axes))
    if seed:
        points = GridPoints(points.axes, (points.nearest(seed),))
    plan = make_plan(robot, spec, points, task_at or (lambda v: with_values(task, v.items())))
    folder = Path(directory)
    claim(folder, manifest_record(points, plan.robot, plan.tasks, options))
    workers = crew or Alone()
    try:
        with Writer(folder, points) as writer:
            Stages(plan, options, writer, workers, on_advance).run()
    finally:
        workers.close()
    return open_library(folder)


def _require(**given: object) -> None:
    for name, value in given.items():
        kinds, wanted = _KINDS[name]
        if not isinstance(value, kinds):
            raise InputError(f"{name} is {value!r}, which cannot be used; give {wanted}")


def _axes(given: Iterable[Axis]) -> tuple[Axis, ...]:
    axes = tuple(given) if isinstance(given, Iterable) else (given,)
    if isinstance(given, Axis) or not all(isinstance(axis, Axis) for axis in axes):
        raise InputError(
            f"axes are {given!r}; give a list of Axis, even of one: "
            "[parse_axis('speed', '0.4:1.3:0.05')]"
        )
    return axes
