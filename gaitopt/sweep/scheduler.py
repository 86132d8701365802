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
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Protocol

from gaitopt.actuators.motors import MotorTable
from gaitopt.catalogue.biped_spec import BipedSpec
from gaitopt.catalogue.parameters import changed
from gaitopt.dataclass import dataclass
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import SAME_COST
from gaitopt.errors import GaitoptError, InputError
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.settings import checked_arguments
from gaitopt.sweep.continuation import Line, Neighbour, Station, WarmStart, is_better, promising
from gaitopt.sweep.database import manifest_record
from gaitopt.sweep.executor import (
    CONTINUE,
    DIAGNOSE,
    FINISH,
    Job,
    JobOutcome,
    LocalWorkers,
    run_job,
    run_job_alone,
)
from gaitopt.sweep.grid import OF_STRIDES, Axis, Index, RobotSource, Scenario, TaskGrid, with_values
from gaitopt.sweep.library import Library, Writer, open_library

NEAREST = 3  # neighbours that a point is tried from
ROUNDS = 1000  # of comparison; nothing is tried twice, so this is never reached
IN_FLIGHT = 1000  # jobs handed to an executor at a time, some 30 kB each
AHEAD = 200  # gaits finished before all walks are known, some 50 kB each

TaskAt = Callable[[dict[str, float]], Task]


class JobExecutor(Protocol):
    """What a sweep needs of an executor: those of `concurrent.futures` and their like have it."""

    def submit(self, fn: Callable[[Job], JobOutcome], job: Job, /) -> Future[JobOutcome]:
        """Have a job done; the future has its outcome."""


@dataclass(frozen=True)
class SweepProgress:
    """How far a sweep is.

    Attributes:
        points: of the grid.
        explored: points that were tried.
        gaits: finished.
        refused: points found to have none.
        stage: "exploring", "probing", "comparing", "starting anew" or "finishing".
    """

    points: int
    explored: int
    gaits: int
    refused: int
    stage: str


OnProgress = Callable[[SweepProgress], None]


@checked_arguments
def sweep(
    robot: Robot,
    task: Task,
    axes: Iterable[Axis],
    directory: str | Path,
    options: DesignOptions | None = None,
    *,
    spec: BipedSpec | None = None,
    motors: MotorTable | None = None,
    seed: dict[str, float] | None = None,
    task_at: TaskAt | None = None,
    executor: JobExecutor | None = None,
    on_progress: OnProgress | None = None,
) -> Library:
    """Design a gait at every point of a grid; go on where an earlier call was interrupted.

    Args:
        task: of which the axes vary quantities.
        directory: of the library; made if it does not exist.
        spec: of the robot, which axes of its entries need.
        motors: of the robot, which axes of their numbers need.
        seed: values near which to begin; by default both ends of the longest axis.
        task_at: the task for values of the axes, if more follows from them than themselves.
        executor: does the work, and is left open; by default this process does it.
        on_progress: told after every job.

    Raises:
        InputError: axes, seed or a task cannot be used; the directory cannot be written, holds
            something else, or is in use.
        GaitoptError: the executor broke down; what was done is kept.
        KeyboardInterrupt: Ctrl-C was pressed; what was done is kept.
    """
    options = options or DesignOptions()
    grid = TaskGrid(tuple(axes))
    if seed:
        grid = TaskGrid(grid.axes, (grid.nearest(seed),))
    task_at = task_at or (lambda v: with_values(task, v.items()))
    scenarios = Scenarios(robot, spec, grid, task_at, motors)
    record = manifest_record(grid, scenarios.robot, scenarios.tasks, options)
    folder = Path(directory)
    with Writer(folder, grid, record) as writer:
        Scheduler(scenarios, options, writer, executor, on_progress).run()
    return open_library(folder)


class Scenarios:
    """Robot and task of every point, all tasks checked.

    Attributes:
        robot: without the changes of a point.
        tasks: by point.

    Raises:
        InputError: a value is out of range, or the robot has no specification to vary.
    """

    def __init__(
        self,
        robot: Robot,
        spec: BipedSpec | None,
        grid: TaskGrid,
        task_at: TaskAt,
        motors: MotorTable | None = None,
    ) -> None:
        driven = [axis for axis in grid.axes if axis.of_motors]
        if driven and motors is None:
            raise InputError(
                f"{driven[0].name} is a number of the robot's motors, of which nothing is known; "
                "give a table of them: --motors motors.toml, in Python motors=read_motors(...)"
            )
        varied = [axis for axis in grid.axes if axis.of_robot and not axis.of_motors]
        if varied and spec is None:
            raise InputError(
                f"{varied[0].name} is an entry of a specification, but the robot was not made from "
                "one; sweep over a generated biped, or over quantities of the task"
            )
        for axis in varied:
            for value in (axis.values[0], axis.values[-1]):
                changed(spec, {axis.name: value})  # type: ignore[arg-type]
        self._grid = grid
        self.robot = RobotSource(
            robot.urdf, robot.choices, spec, motors=motors if driven else None,
            findings=robot.findings,
        )  # fmt: skip
        tasks = {p: task_at(grid.values(p)) for p in grid.order}
        if driven:
            places = {p: robot_at(self.robot, grid, p) for p in tasks}
            tasks = {p: Scenario(places[p], task).driven().task for p, task in tasks.items()}
            drives = places[grid.order[0]].drives
            if drives is not None:
                drives.check(robot.joint_names, robot.mirror)
        if any(axis.name in OF_STRIDES for axis in grid.axes):
            tasks = {p: replace(task, stride=True) for p, task in tasks.items()}
        self.tasks: Mapping[Index, Task] = tasks

    def at(self, point: Index) -> Scenario:
        """Return robot and task of a point."""
        return Scenario(robot_at(self.robot, self._grid, point), self.tasks[point])


def robot_at(robot: RobotSource, grid: TaskGrid, point: Index) -> RobotSource:
    """Return the robot of a point."""
    values = grid.values(point)
    changes = tuple((axis.name, values[axis.name]) for axis in grid.axes if axis.of_robot)
    return replace(robot, changes=changes)


class Scheduler:
    """Goes through the stages, from wherever the library stands."""

    def __init__(
        self,
        scenarios: Scenarios,
        options: DesignOptions,
        writer: Writer,
        executor: JobExecutor | None,
        on_progress: OnProgress | None,
    ) -> None:
        self._scenarios, self._options, self._writer = scenarios, options, writer
        self._executor, self._on_progress = executor, on_progress
        self._run, self._workers = run_job_alone, 0  # how many of them would wait is not known
        if isinstance(executor, LocalWorkers):
            self._run, self._workers = run_job, executor.count
        self._ahead: dict[Index, tuple[WarmStart, Future[JobOutcome]]] = {}  # gaits of these walks
        self._grid, self._states = writer.grid, writer.states
        self._level = self._grid.levels[0]
        self._handed_on: dict[Index, list[Index]] = {}  # by points without a walk, to those beyond
        self._named = {self._grid.name(point): point for point in self._grid.order}
        self._counted = tuple(  # sets: to count thousands of points after each job takes long
            {point for point in self._states if self._reached(point)[k]} for k in range(3)
        )

    def run(self) -> None:
        """Bring every point to a gait, or to the reason why there is none."""
        levels = self._grid.levels
        reached = [any(self._states[p].explored for p in level.points) for level in levels]
        new = [set(b.points) - set(a.points) for a, b in pairwise(levels)]
        for number, points in enumerate(new, 1):
            reached[number] = any(self._states[p].explored for p in points)
        first = max((n for n, begun in enumerate(reached) if begun), default=0)
        for level in levels[first:]:  # what was done of coarser ones is settled
            self._level = level
            self._explore()
            self._probe()
            for _ in range(ROUNDS):
                if not self._compare() and not self._start_anew():
                    break
        self._finish()

    def _explore(self) -> None:
        """Every point of a level once, as soon as all its inner neighbours are explored."""
        begun = {point for point, state in self._states.items() if state.explored}
        level = self._level
        inner = {point: level.inner(point) for point in level.points if point not in begun}

        def begin(candidates: Iterable[Index]) -> list[Job]:
            ready = [
                point
                for point in candidates
                if point not in begun and all(self._states[q].explored for q in inner[point])
            ]
            begun.update(ready)
            return [self._first(point) for point in ready]

        def note(outcome: JobOutcome) -> list[Job]:
            self._note_walk(outcome)
            return begin(q for _, q in level.neighbours(outcome.job.point))

        self._drive("exploring", begin(level.points), note)

    def _first(self, point: Index) -> Job:
        near = self._origins(point)[:NEAREST]
        line = self._line(point, near[0]) if near else ()
        return self._continue(point, near, substeps=True, cold_start=not near, line=line)

    def _line(self, point: Index, origin: Index) -> Line:
        """Return walks on the line through a point and the one it starts from.

        None where that is no neighbour, or the robot differs.
        """
        level = self._level
        axes = [k for k, q in level.neighbours(point) if q == origin]
        axis = self._grid.axes[axes[0]] if axes else None
        if axis is None or (axis.of_robot and not axis.of_motors):
            return ()
        values = self._grid.axes[axes[0]].values
        return tuple(
            Station(values[q[axes[0]]] - values[point[axes[0]]], walk, self._grid.name(q))
            for q in level.line(point, origin)
            if (walk := self._walk_at(q)) is not None
        )

    def _origins(self, point: Index) -> list[Index]:
        """Return inner neighbours that walk, in place of others those they were tried from."""
        found: set[Index] = set()
        for other in self._level.inner(point):
            if self._walk_at(other) is not None:
                found.add(other)
            else:
                if other not in self._handed_on:
                    self._handed_on[other] = self._origins(other)
                found.update(self._handed_on[other][:NEAREST])
        return sorted(found, key=lambda q: (self._predicted(q, point), q))

    def _predicted(self, origin: Index, point: Index) -> float:
        """Return the cost at a point by the tangent at another."""
        here, there = self._grid.values(point), self._grid.values(origin)
        walk = self._walk(origin)
        strides = (here[name] - there[name] for name in here)
        return walk.cost + sum(
            (slope or 0.0) * stride
            for slope, stride in zip(walk.cost_gradient, strides, strict=True)
        )

    def _probe(self) -> None:
        """Far from the seeds, and off a branch, start anew as well: others may be better."""
        points = self._level.points
        wanted = {*set(self._grid.probes).intersection(points), *filter(self._left_branch, points)}
        jobs = [self._anew(p) for p in sorted(wanted) if not self._states[p].cold_started]
        self._drive("probing", jobs, self._note_walk)

    def _compare(self) -> bool:
        """Try points from neighbours of another branch, once round; return whether any was."""
        if not self._due():  # else an earlier call was interrupted in the midst of a round
            points = self._level.points
            rivals = {p: q for p in points if (q := self._rival(p)) is not None}
            # a neighbour that may itself be about to change is waited for
            settled = {p: q for p, q in rivals.items() if q not in rivals}
            pairs = settled or rivals
            self._writer.note({p: replace(self._states[p], due=q) for p, q in pairs.items()})
        jobs = [
            self._continue(p, [q], substeps=self._walk_at(p) is None, cold_start=False)
            for p, q in self._due().items()
        ]
        self._drive("comparing", jobs, self._note_walk)
        return bool(jobs)

    def _due(self) -> dict[Index, Index]:
        return {p: state.due for p, state in self._states.items() if state.due is not None}

    def _rival(self, point: Index) -> Index | None:
        """Return the most promising neighbour that a point was not yet tried from."""
        if self._writer.has_gait(point):
            return None
        near = promising(self._grid, self._walk_at, point, self._level.neighbours(point))
        return next((q for q in near if not self._compared(point, q)), None)

    def _compared(self, point: Index, other: Index) -> bool:
        """Whether a point was tried from another, or both are as good as single designs."""
        # To try these too found nothing, for up to half as many iterations again (coarse grids).
        here, there = self._states[point], self._states[other]
        alone = here.cold_started and there.cold_started and here.walk is not None
        return alone or (other, self._walk(other).cost) in here.tried

    def _start_anew(self) -> bool:
        """Try points to which no neighbour led, as a single design; return whether any was."""
        points = self._level.points
        left = [p for p in points if self._walk_at(p) is None or self._left_branch(p)]
        jobs = [self._anew(p) for p in left if not self._states[p].cold_started]
        self._drive("starting anew", jobs, self._note_walk)
        return bool(jobs)

    def _anew(self, point: Index) -> Job:
        return self._continue(point, [], substeps=False, cold_start=True)

    def _left_branch(self, point: Index) -> bool:
        walk = self._walk_at(point)
        return walk is not None and walk.left_branch

    def _finish(self) -> None:
        """Make gaits of the walks, and explain the points without."""
        jobs = []
        self._workers = 0  # these are all jobs that are left: none can be done ahead
        for point in sorted(self._grid.order):
            if self._open(point):
                walk = self._walk_at(point)
                jobs.append(self._job(FINISH if walk else DIAGNOSE, point, walk=walk))
        self._drive("finishing", jobs, self._note_gait)

    def _open(self, point: Index) -> bool:
        """Whether a point has neither a gait nor the reason why there is none."""
        return not self._writer.has_gait(point) and self._states[point].refusal is None

    def _walk_at(self, point: Index) -> WarmStart | None:
        return self._states[point].walk

    def _walk(self, point: Index) -> WarmStart:
        walk = self._walk_at(point)
        if walk is None:
            raise KeyError(f"no walk is known at {self._grid.name(point)}")
        return walk

    def _continue(
        self,
        point: Index,
        near: list[Index],
        *,
        substeps: bool,
        cold_start: bool,
        line: Line = (),
    ) -> Job:
        neighbours = tuple(
            Neighbour(self._scenarios.at(q), self._walk(q), self._grid.name(q)) for q in near
        )
        here = self._walk_at(point)
        limit = math.inf if here is None else here.cost * (1.0 - SAME_COST)
        how = {"substeps": substeps, "cold_start": cold_start, "cost_limit": limit}
        return self._job(CONTINUE, point, neighbours=neighbours, line=line, **how)

    def _job(self, kind: str, point: Index, **more: object) -> Job:
        axes = tuple(self._grid.values(point).items())
        scenario = self._scenarios.at(point)
        return Job(kind, point, scenario, axes, self._options, **more)  # type: ignore[arg-type]

    def _note_walk(self, outcome: JobOutcome) -> list[Job]:
        job, found = outcome.job, outcome.walk
        known = self._states[job.point]
        tried = set(known.tried)
        for neighbour in job.neighbours:
            tried.add((self._named[neighbour.name], neighbour.walk.cost))
            if found is not None and found.origin == neighbour.name:
                break
        if found is not None:
            foretold = {one.name: one.walk.cost for one in job.line}
            tried.update((self._named[name], foretold[name]) for name in found.beside)
        state = replace(
            known,
            explored=True,
            walk=found if is_better(found, known.walk) else known.walk,
            cold_started=known.cold_started or job.cold_start,
            due=None if job.neighbours else known.due,
            tried=frozenset(tried),
            seconds=known.seconds + outcome.seconds,
        )
        self._writer.note({job.point: state})
        return []

    def _note_gait(self, outcome: JobOutcome) -> list[Job]:
        point, known = outcome.job.point, self._states[outcome.job.point]
        state = replace(known, seconds=known.seconds + outcome.seconds)
        if outcome.file is not None and outcome.row is not None:
            self._writer.save(point, outcome.file, outcome.row, state)
        elif outcome.refusal is not None:
            self._writer.note({point: replace(state, refusal=outcome.refusal)})
        else:  # a walk at its samples that refinement did not survive
            self._writer.note({point: state})
            return [self._job(DIAGNOSE, point)]
        return []

    def _drive(
        self, stage: str, jobs: Iterable[Job], note: Callable[[JobOutcome], list[Job]]
    ) -> None:
        """Have jobs done, and those that follow from their outcomes; note each as it comes."""
        waiting = deque(jobs)
        running: set[Future[JobOutcome]] = set()
        try:
            while waiting or running:
                for outcome in self._next(waiting, running):
                    waiting.extend(note(outcome))
                    if self._on_progress is not None:
                        self._on_progress(self._progress(stage, outcome.job.point))
        except BaseException:
            for future in (*running, *(one for _, one in self._ahead.values())):
                future.cancel()
            raise

    def _next(self, waiting: deque[Job], running: set[Future[JobOutcome]]) -> Iterable[JobOutcome]:
        """Yield the next outcomes; wait until there is one, or until a worker has nothing to do."""
        if self._executor is None:
            yield run_job(waiting.popleft())
            return
        try:
            while waiting and len(running) < IN_FLIGHT:
                running.add(self._submitted(self._executor, waiting.popleft()))
            ahead = self._finishing_ahead(self._executor, self._workers - len(running))
            for future in running & wait(running | ahead, return_when=FIRST_COMPLETED).done:
                running.discard(future)
                yield future.result()
        except (BrokenExecutor, CancelledError) as error:
            reason = str(error).strip().rstrip(".") or "the workers were stopped"
            raise GaitoptError(
                f"{reason}; what was finished is kept, and the same command goes on"
            ) from error

    def _submitted(self, executor: JobExecutor, job: Job) -> Future[JobOutcome]:
        """Have a job done, unless it is."""
        if job.kind == FINISH and job.point in self._ahead:
            walk, future = self._ahead.pop(job.point)
            if walk is job.walk:
                return future
        return executor.submit(self._run, job)

    def _finishing_ahead(self, executor: JobExecutor, idle: int) -> set[Future[JobOutcome]]:
        """Have walks made gaits by workers that would wait; return what is not done yet."""
        # Most walks stay as they are; the gait of one that is improved later is not used.
        pending = {future for _, future in self._ahead.values() if not future.done()}
        for point in self._level.points:
            if len(pending) >= idle or len(self._ahead) >= AHEAD:
                break
            walk = self._walk_at(point)
            known = self._ahead.get(point, (None,))[0]
            if walk is not None and walk is not known and self._open(point):
                future = executor.submit(self._run, self._job(FINISH, point, walk=walk))
                self._ahead[point] = walk, future
                pending.add(future)
        return pending

    def _progress(self, stage: str, point: Index) -> SweepProgress:
        """Return how far the sweep is after a job at a point."""
        reached = self._reached(point)
        for known, new in zip(self._counted, reached, strict=True):
            if new:
                known.add(point)
        explored, gaits, refused = map(len, self._counted)
        return SweepProgress(len(self._states), explored, gaits, refused, stage)

    def _reached(self, point: Index) -> tuple[bool, bool, bool]:
        """Return whether a point is explored, has a gait, is refused; it stays so."""
        state = self._states[point]
        return state.explored, self._writer.has_gait(point), state.refusal is not None
