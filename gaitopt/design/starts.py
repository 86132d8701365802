"""Several starts: there are several strict local optima, so search from several first guesses.

The first start is the guess itself, the second a slower walk, the others are the guess disturbed.
Where none leads to an optimum there is one more; of walks slower than a stroll it is a faster walk:
their steps are so short that few impulses lift the rear foot, and from guesses at such steps the
impulse dwindles, with which all limits on it meet in a point (docs/decisions/slow-walks.md).
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import field, replace
from typing import TYPE_CHECKING

import numpy as np

from gaitopt.bounds import STARTS, WORKERS, at_most, is_finite, shown
from gaitopt.dataclass import dataclass
from gaitopt.design.design import checked_start, design, walk_after_diagnosis
from gaitopt.design.options import COUNT, SIGMA, DesignOptions, Search
from gaitopt.design.phase_times import SLOWER, best_times, searched_times
from gaitopt.design.pipeline import (
    Design,
    attempt,
    complete,
    finished,
    impulse_vanishes,
    is_walk,
    same_optimum,
    without_impact,
)
from gaitopt.design.process import (
    copy_that_does,
    serve_parent,
    shut_down,
    starting_processes,
    tune_process,
)
from gaitopt.design.refinement import with_work
from gaitopt.design.summary import peak_torques
from gaitopt.errors import (
    GaitoptError,
    InputError,
    StoppedError,
    UnreachableError,
    plugins_told,
)
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.grid import Grid
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.presets import foreign_margins, preset_task, stroll
from gaitopt.gait.problem import MakeProgress, WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array, Progress, ProgressCallback, Solution, Status, Stop, never
from gaitopt.settings import checked_arguments

if TYPE_CHECKING:
    from multiprocessing.synchronize import Event

SECOND = 1  # number of the start that comes from there
FASTER = 1.25  # of the speed: the walk from which slow ones are begun at last
MOTORS_TOLD = 3  # of another optimum
ASKED_EVERY = 0.1  # s: how often `stop` is asked while other processes work
LATE = 10.0  # s without a word from a process, which is then not waited for any longer
GRACE = 1.0  # s: for other processes to come to the end of an iteration when they are stopped
_stopped: Event | None = None  # of a worker process, given to it by its pool


@checked_arguments
def design_gait(
    robot: Robot,
    task: Task | None = None,
    options: DesignOptions | None = None,
    *,
    start: Array | Gait | None = None,
    starts: int | None = None,
    on_progress: MakeProgress | None = None,
    stop: Stop = never,
) -> Design:
    """Design the optimal gait of a robot for a task, as `gaitopt optimise` does.

    Of a task with `toe_off` the best beginning of the turn is searched, and the flat walk is kept
    where that is cheaper, unless the options say otherwise; other times of phases are searched if
    the options say so.

    Args:
        task: speed, duration, margins; by default the preset `standard`.
        start: first guess of the parameters, shape (P,), or a gait, which is gone on from at its
            instants if it is an optimum of this very walk; by default `first_guess`.
        starts: number of first guesses to try, of which the best walk is kept; by default 2, or 1
            from a start that is given. One takes half the time; `many_starts` tells all it found.
        on_progress: makes the progress callback of a walk (it can name the walk's rows).
        stop: asked at every iteration; where it says True, the best walk until then is returned,
            with the status INTERRUPTED.

    Warns:
        UserWarning: the robot is not the thirteen-link biped, but the margins of the task are its.

    Raises:
        InputError: the robot is no `Robot`, starts below 1, or the start has another shape than
            the parameters, or is not finite.
        NoGaitFoundError: no feasible gait was found; the message says what stands in the way, and
            `diagnosis` why and what would help.
        UnreachableError: the step asked for is longer than the legs; with a `diagnosis` too.
        StoppedError: `stop` said so before there was a walk.
    """
    task = task or preset_task(robot=robot)
    foreign = foreign_margins(robot, task)
    if foreign is not None:
        warnings.warn(foreign, stacklevel=3)  # whoever called it, past the check of arguments

    def designed(task: Task, start: Array | Gait | None, options: DesignOptions | None) -> Design:
        count = starts if starts is not None else COUNT if start is None else 1
        if count == 1:
            return design(robot, task, options, start=start, on_progress=on_progress, stop=stop)
        return many_starts(
            robot, task, options, count=count, start=start, on_progress=on_progress, stop=stop
        ).design

    if searched_times(task, options):
        usual = options or DesignOptions()
        return best_times(robot, task, usual, designed, start, stop).design
    return designed(task, start, options)


@checked_arguments
def many_starts(
    robot: Robot,
    task: Task | None = None,
    options: DesignOptions | None = None,
    *,
    count: int = COUNT,
    seed: int = 0,
    sigma: float = SIGMA,
    workers: int = 1,
    start: Array | Gait | None = None,
    second: SecondStart | None = None,
    on_outcome: Callable[[Outcome], None] | None = None,
    on_progress: MakeProgress | None = None,
    stop: Stop = never,
) -> StartsReport:
    """Search from several first guesses, keep the best walk, refine and certify that one.

    The result depends on the seed, not on the number of workers.

    Args:
        task: by default the preset `standard`.
        options: as of `design`; the starts always have exact derivatives.
        count: number of starts; the first is the guess itself, the second a slower walk. Where
            the best of several is no optimum, one more is made; of slow walks, from a faster one.
        seed: of the perturbations.
        sigma: their standard deviation [rad], and [rad/s] for the rates before impact.
        workers: processes; with more than one, a script must start its work under
            `if __name__ == "__main__":`, because each process imports it.
        start: first guess of the parameters, shape (P,), or a gait, of which only these count; by
            default `first_guess`.
        second: the second start of the same, if it is being made already; by one worker only.
        on_outcome: called with every outcome, in order.
        on_progress: makes the progress callback of a walk; starts in other processes tell none.
        stop: asked at every iteration; where it says True, the best walk until then is returned,
            with the status INTERRUPTED.

    Raises:
        InputError: count or workers below 1, sigma or seed negative, or the start has another
            shape than the parameters or is not finite.
        NoGaitFoundError: none of the starts led to a walk; with a `diagnosis`.
        UnreachableError: the step asked for is longer than the legs.
        StoppedError: `stop` said so before there was a walk.
        GaitoptError: a worker process died, or cannot be started.
    """
    _check(count, seed, sigma, workers)
    task, options = task or preset_task(robot=robot), options or DesignOptions()
    try:
        problem = WalkProblem(robot, task)
        x = checked_start(problem, start)
    except UnreachableError:
        found = design(robot, task, options, on_progress=on_progress, stop=stop)
        return StartsReport(found, (), (), count)
    search = Search(options, on_progress, stop)
    exactly = search.changed(differences="none")
    job = StartJob(robot, task, x, sigma, seed)
    made = outcomes_of(job, count, min(workers, count), exactly, second)
    outcomes = _gathered(made, on_outcome)

    def another(make: MakeOutcome) -> list[Outcome]:
        made = make(len(outcomes), exactly)
        more = [] if made is None else _gathered(iter([made]), on_outcome)
        outcomes.extend(more)
        return more

    if count > 1 and not (stop() or any(one.walks for one in outcomes)):
        another(job.from_faster)
    best = min(outcomes, key=_rank, default=None)
    walks = best is not None and best.walks
    ended = outcomes[-1:]
    if stop() or any(one.solution.status is Status.INTERRUPTED for one in ended):
        if best is None or not walks:
            raise StoppedError(None if best is None else best.solution)
        found = finished(problem, replace(best.solution, status=Status.INTERRUPTED), False)
    elif best is not None and walks:
        found = _completed(problem, best.solution, search)
        for make in (job.from_faster, job.run) if len(outcomes) == count > 1 else ():
            if not (found.certificate.optimal or stop()):
                for one in filter(lambda one: one.walks, another(make)):
                    other = _completed(problem, one.solution, search)
                    found = other if other.certificate.optimal else found
    else:
        tried = [outcome.solution for outcome in outcomes]
        solution = walk_after_diagnosis(problem, tried, search.quiet)
        found = _completed(problem, solution, search)
    optima = _with_motors(_distinct(outcomes, problem), problem)
    report = StartsReport(found, optima, tuple(outcomes), count)
    gait = replace(found.gait, meta={**found.gait.meta, "optima": report.record()["optima"]})
    return replace(report, design=replace(found, gait=gait))


@dataclass(frozen=True)
class Outcome:
    """Where one start led.

    Attributes:
        number: 0 is the first guess itself, 1 a slower walk, the others are perturbed.
        solution: what the solver made of it.
    """

    number: int
    solution: Solution

    @property
    def walks(self) -> bool:
        """Whether it is a feasible walk."""
        return is_walk(self.solution)


@dataclass(frozen=True)
class Optimum:
    """One of the distinct optima.

    Attributes:
        cost: in the unit of the task's cost.
        x: parameters, shape (P,).
        starts: numbers of the starts that led to it.
        peak_torques: of its motors [N·m], by name; empty where there is but one optimum.
    """

    cost: float
    x: Array
    starts: tuple[int, ...]
    peak_torques: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class StartsReport:
    """What many starts found.

    Attributes:
        design: the best gait, refined and certified; as its start left it if Ctrl-C ended all.
        optima: distinct ones at the given samples, the best first.
        outcomes: of every start made, in order.
        asked: number of starts asked for.
    """

    design: Design
    optima: tuple[Optimum, ...]
    outcomes: tuple[Outcome, ...]
    asked: int

    @property
    def sentences(self) -> tuple[str, ...]:
        """The report for people."""
        walks = sum(outcome.walks for outcome in self.outcomes)
        first = f"{walks} of {len(self.outcomes)} starts led to a walk"
        if len(self.outcomes) < self.asked:
            first += f"; {self.asked} were asked for"
        rest = (
            f"optimum {i} of cost {optimum.cost:.6g}: reached from {_starts(optimum.starts)}"
            f"{_motors_apart(optimum, self.optima[0])}"
            for i, optimum in enumerate(self.optima, start=1)
        )
        return (first, *rest)

    def record(self) -> dict[str, object]:
        """Return the report as JSON-able data."""
        return {
            "asked": self.asked,
            "starts": len(self.outcomes),
            "walks": sum(outcome.walks for outcome in self.outcomes),
            "optima": [
                {
                    "cost": o.cost,
                    "starts": list(o.starts),
                    "peak_torques_Nm": dict(o.peak_torques),
                    "parameters": o.x.tolist(),
                }
                for o in self.optima
            ],
        }


def _motors_apart(optimum: Optimum, best: Optimum) -> str:
    """Say for which motors the peak torques of an optimum and of the best differ most."""
    peaks = optimum.peak_torques
    apart = sorted(peaks, key=lambda name: -abs(peaks[name] - best.peak_torques[name]))
    told = [
        f"{name} {peaks[name]:.3g} N·m instead of {best.peak_torques[name]:.3g}"
        for name in apart[:MOTORS_TOLD]
    ]
    return f"; peak torques: {', '.join(told)}" if told and optimum is not best else ""


def _starts(numbers: tuple[int, ...]) -> str:
    return "1 start" if len(numbers) == 1 else f"{len(numbers)} starts"


def _check(count: int, seed: int, sigma: float, workers: int) -> None:
    for name, value in (("starts", count), ("workers", workers), ("seed", seed)):
        if value < 1 and name != "seed":
            raise InputError(f"{shown(value)} {name} are too few; give at least 1")
    at_most(count, STARTS, "starts")
    at_most(workers, WORKERS, "workers")
    if seed < 0:
        raise InputError(f"seed {seed} is negative; give 0 or more")
    if not (is_finite(sigma) and sigma >= 0.0):
        raise InputError(f"sigma is {shown(sigma)} rad; it must be a finite number, not negative")


def _completed(problem: WalkProblem, solution: Solution, search: Search) -> Design:
    """Return the design of a start's walk; one that is not yet optimal is solved once more."""
    exact = search.options.differences == "none"
    if impulse_vanishes(problem, solution) and exact:
        return _without_impact(problem, solution, search)
    if solution.status is Status.OPTIMAL and exact:
        return complete(problem, solution, search)
    return design(
        problem.robot, problem.task, replace(search.options, approach="direct"),
        start=solution.x, on_progress=search.on_progress, stop=search.stop,
    )  # fmt: skip


def _without_impact(problem: WalkProblem, solution: Solution, search: Search) -> Design:
    """Return a walk that lands at zero speed: from one that all but does, or from its own starts.

    Where neither is proven, the former.
    """
    near = complete(problem, solution, search)
    if near.proven or search.stop():
        return near
    try:
        found = many_starts(
            problem.robot, without_impact(problem).task, replace(search.options, diagnose=False),
            on_progress=search.on_progress, stop=search.stop,
        ).design  # fmt: skip
    except GaitoptError:  # there is none, or it was stopped
        return near
    return found if found.proven else near


def _gathered(
    found: Iterator[Outcome], on_outcome: Callable[[Outcome], None] | None
) -> list[Outcome]:
    """Return the outcomes up to one that was stopped."""
    outcomes = []
    for outcome in found:
        outcomes.append(outcome)
        if outcome.solution.status is Status.INTERRUPTED:
            break
        if on_outcome is not None:
            on_outcome(outcome)
    return outcomes


def _rank(outcome: Outcome) -> tuple[bool, float]:
    """Walks before others, then by cost or violation; a nan comes last."""
    value = outcome.solution.cost if outcome.walks else outcome.solution.violation
    return not outcome.walks, value if np.isfinite(value) else np.inf


def _distinct(outcomes: list[Outcome], problem: WalkProblem) -> tuple[Optimum, ...]:
    """Gather outcomes that are optimal and the same to the precision of solvers."""
    optima: list[Optimum] = []
    for outcome in sorted(outcomes, key=_rank):
        solution = outcome.solution
        if not outcome.walks or solution.status is not Status.OPTIMAL:
            continue
        for i, known in enumerate(optima):
            if same_optimum(problem, (solution.cost, solution.x), (known.cost, known.x)):
                optima[i] = replace(known, starts=(*known.starts, outcome.number))
                break
        else:
            optima.append(Optimum(solution.cost, solution.x, (outcome.number,)))
    return tuple(optima)


def _with_motors(optima: tuple[Optimum, ...], problem: WalkProblem) -> tuple[Optimum, ...]:
    """Return optima with the peak torques of their motors, if there are several to compare."""
    if len(optima) < 2:
        return optima
    gaits = [gait_at(problem, optimum.x, {}) for optimum in optima]
    return tuple(
        replace(optimum, peak_torques=peak_torques(gait))
        for optimum, gait in zip(optima, gaits, strict=True)
    )


MakeOutcome = Callable[[int, Search], Outcome | None]


@dataclass(frozen=True)
class StartJob:
    """What a worker needs to make any of the starts.

    Attributes:
        robot, task: of the walk.
        x: the first guess, shape (P,).
        sigma, seed: of the noise on it.
    """

    robot: Robot
    task: Task
    x: Array
    sigma: float
    seed: int

    def run(self, number: int, search: Search) -> Outcome:
        """Solve from one start."""
        if number == SECOND:
            easier = self.task.ground.easier()
            known = self._on_easier_ground(search) if easier else self._at_share(SLOWER, search)
            if known is not None:
                return self._from(known, number, search)
        problem = WalkProblem(self.robot, self.task)
        start = self.x
        if number > 0:
            state = np.random.SeedSequence([self.seed, number]).generate_state(1)
            start = perturbed(problem, self.x, self.sigma, int(state[0]))
        return Outcome(number, attempt(problem, search, start))

    def from_faster(self, number: int, search: Search) -> Outcome | None:
        """Solve from a faster walk; None if there is none, or the walk is no slow one."""
        if self.task.pace >= stroll(self.robot):
            return None
        known = self._at_share(FASTER, search)
        return None if known is None else self._from(known, number, search)

    def _from(self, known: Solution, number: int, search: Search) -> Outcome:
        """Solve from a walk at another speed, whose multipliers are taken along, or ground."""
        if known.status is Status.INTERRUPTED:
            return Outcome(number, replace(known, cost=np.nan, violation=np.inf))  # another walk
        problem, near = WalkProblem(self.robot, self.task), search.changed(approach="direct")
        same = not self.task.ground.easier() and known.multipliers.size == problem.rows.lower.size
        found = attempt(problem, near, known.x, known.multipliers if same else None)
        return Outcome(number, with_work(found, known))

    def _at_share(self, share: float, search: Search) -> Solution | None:
        """Return a walk at a share of the speed, about the best one there, or None."""
        if self.task.in_place and self.task.turn_rate == 0.0:
            return None
        problem = WalkProblem(self.robot, self.task.at_share_of_speed(share))
        rough = search.changed(solver=search.options.solver.roughly())
        try:
            solution = attempt(problem, rough, first_guess(problem))
        except UnreachableError:
            return None
        useful = solution.status in (Status.OPTIMAL, Status.INTERRUPTED)
        return solution if useful or is_walk(solution) else None

    def _on_easier_ground(self, search: Search) -> Solution | None:
        """Return the walk on the last of the easier grounds, each from the one before, or None."""
        found: Solution | None = None
        for terrain in self.task.ground.easier():
            problem = WalkProblem(self.robot, self.task.on(terrain))
            how = search if found is None else search.changed(approach="direct")
            try:
                start = first_guess(problem) if found is None else found.x
                solution = attempt(problem, how, start)
            except UnreachableError:
                return None
            if solution.status is Status.INTERRUPTED:
                return solution
            if not is_walk(solution):
                return None
            found = solution if found is None else with_work(solution, found)
        return found


class SecondStart:
    """The second start in a copy of this process, made while the first is made here.

    It comes to the same, rounds told included. The process must be fit to be copied; a command is
    before it shows anything. Until it is closed the copy goes on.

    Args of the constructor: as of `many_starts`.
    """

    def __init__(
        self,
        robot: Robot,
        task: Task,
        options: DesignOptions,
        *,
        seed: int = 0,
        sigma: float = SIGMA,
        start: Array | Gait | None = None,
    ) -> None:
        import multiprocessing

        self._robot = robot
        self._rounds: list[_Round] = []
        self._pipe, there = multiprocessing.Pipe()

        def work() -> None:
            from select import select

            self._pipe.close()
            words: list[object] = []

            def tell(word: object) -> None:
                words.append(word)
                if isinstance(word, Outcome) or select([], [there], [], 0.0)[1]:
                    there.send(words)  # which waits where nobody reads and the pipe is full
                    words.clear()

            def begin_round(problem: WalkProblem) -> ProgressCallback:
                tell((problem.task, problem.grid))
                return tell

            search = Search(replace(options, differences="none"), begin_round, there.poll)
            with warnings.catch_warnings(record=True) as warned:
                x = checked_start(WalkProblem(robot, task), start)
                outcome = StartJob(robot, task, x, sigma, seed).run(SECOND, search)
            if not warned:  # else it is made again, where its user sees what it warns of
                tell(outcome)

        self._copy = copy_that_does(work)
        there.close()

    def outcome(self, search: Search) -> Outcome | None:
        """Return where it led to, and tell its rounds; None where the copy died, or is too late.

        Args:
            search: who is told, and what ends it.
        """
        asked, deadline = False, time.monotonic() + LATE
        with suppress(EOFError, OSError):
            while time.monotonic() < deadline:
                if search.stop() and not asked:
                    asked, deadline = True, time.monotonic() + GRACE
                    self._pipe.send(None)
                if not self._pipe.poll(ASKED_EVERY):
                    continue
                for word in self._pipe.recv():
                    if isinstance(word, Outcome):
                        return word
                    self._tell(word, search)
                deadline = deadline if asked else time.monotonic() + LATE
        self.close()
        return None

    def _tell(self, word: Progress | tuple[Task, Grid], search: Search) -> None:
        if isinstance(word, Progress):
            self._rounds[-1].tell(word)
        else:
            self._rounds.append(_Round(search.callback(WalkProblem(self._robot, *word))))

    def rest(self, search: Search) -> Search:
        """Return a search that makes the start again, and tells what is not told yet."""
        told = iter(self._rounds)

        def begin_round(problem: WalkProblem) -> ProgressCallback:
            known = next(told, None)
            if known is None:
                return _Round(search.callback(problem)).tell
            return _Round(known.show, known.told).tell

        return replace(search, on_progress=begin_round)

    def close(self) -> None:
        """End the copy, whatever it does."""
        self._pipe.close()
        if self._copy is not None:
            self._copy.kill()
            self._copy.join()


class _Round:
    """A round whose first records were told before."""

    def __init__(self, show: ProgressCallback | None, before: int = 0) -> None:
        self.show, self.told, self._before = show, 0, before

    def tell(self, progress: Progress) -> None:
        self.told += 1
        if self.show is not None and self.told > self._before:
            self.show(progress)


def outcomes_of(
    job: StartJob, count: int, workers: int, search: Search, second: SecondStart | None = None
) -> Iterator[Outcome]:
    """Make the starts and yield their outcomes in order, until the search is stopped.

    Args:
        search: how each is made. Several processes tell nobody; they are asked to stop ten times a
            second, and yield the best iterates of the starts that they were at.
        second: the second start, if it is being made; by one worker only.

    Raises:
        GaitoptError: a worker process died, or cannot be started.
    """
    stop = search.stop
    if workers == 1:
        for number in range(count):
            if number > 0 and stop():
                return
            how = search
            if second is not None and number == SECOND:
                made = second.outcome(search)
                if made is not None:
                    yield made
                if made is not None or stop():
                    continue
                how = second.rest(search)
            yield job.run(number, how)
        return
    import multiprocessing  # slow to import, as those below, and most commands do without
    from concurrent.futures import ProcessPoolExecutor, wait
    from concurrent.futures.process import BrokenProcessPool

    context = multiprocessing.get_context("spawn")
    complete = False
    with starting_processes():
        stopped = context.Event()
        pool = ProcessPoolExecutor(workers, context, initializer=_begin_worker, initargs=(stopped,))
    try:
        with starting_processes():
            futures = [
                pool.submit(_run_in_worker, job, search.options, number) for number in range(count)
            ]
        for future in futures:
            while not (future.done() or stop()):
                wait([future], timeout=ASKED_EVERY)
            if stop():
                stopped.set()
                ended, _ = wait([f for f in futures if not f.cancel()], timeout=GRACE)
                yield from (f.result() for f in futures[futures.index(future) :] if f in ended)
                break
            yield future.result()
        complete = not stop()
    except BrokenProcessPool as error:
        raise GaitoptError(
            "a worker process died; run with 1 worker, or see to it that the script starts its "
            'work under `if __name__ == "__main__":`'
        ) from error
    finally:
        shut_down(pool, at_once=not complete)  # starts that nobody wants are not waited for


def _begin_worker(stopped: Event) -> None:
    """Begin a worker process whose starts end when the event is set."""
    global _stopped
    serve_parent()
    tune_process()
    _stopped = stopped


@plugins_told()
def _run_in_worker(job: StartJob, options: DesignOptions, number: int) -> Outcome:
    assert _stopped is not None
    return job.run(number, Search(options, stop=_stopped.is_set))
