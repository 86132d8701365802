"""The fastest walk of a robot: from gait to faster gait until none is left."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from gaitopt.dataclass import dataclass
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import Design
from gaitopt.design.starts import many_starts
from gaitopt.errors import InputError, NoGaitFoundError, StoppedError, UnreachableError
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array, Status, Stop, never
from gaitopt.settings import checked_arguments
from gaitopt.sweep.continuation import MAX_ITERATIONS

# Fractions of the speed reached.
FIRST_STEP = 0.2  # by which the second try is faster
RETRIES = (0.05, 0.1)  # tried once more in the end
RESOLUTION = 0.01  # m/s
DIGITS = 3  # of the speeds tried
AT_LIMIT = 1e-3  # scaled margin of a row that is at its limit

OnTry = Callable[[float, "Design | None"], None]


@dataclass(frozen=True)
class Fastest:
    """The fastest walk that was found.

    Attributes:
        design: the gait, designed as any other.
        refused: the least faster speed tried, at which there was none [m/s]; infinite if there is
            none yet.
        binding: the constraints at their limits in that gait, in words.
        interrupted: whether Ctrl-C ended the search, so that faster walks were left untried.
    """

    design: Design
    refused: float
    binding: tuple[str, ...]
    interrupted: bool = False

    @property
    def speed(self) -> float:
        """Of the gait [m/s]."""
        return self.design.problem.task.speed


@checked_arguments
def fastest(
    robot: Robot,
    task_at: Callable[[float], Task],
    speed: float,
    options: DesignOptions | None = None,
    *,
    resolution: float = RESOLUTION,
    on_try: OnTry | None = None,
    stop: Stop = never,
) -> Fastest:
    """Return the fastest walk of a robot, to a resolution.

    Each gait starts from the one before, or cold where that leads nowhere; when there is none, the
    stride in speed is halved. In the end some faster speeds are tried once more as if nothing were
    known, because walks of another kind may begin there. What limits a local search limits this one
    too.

    Args:
        task_at: the task at a speed; the step duration may follow from it.
        speed: to begin with [m/s].
        resolution: [m/s].
        on_try: told every speed, and the design or None.
        stop: asked at every iteration; where it says True, the search ends.

    Raises:
        InputError: the resolution is finer than speeds are told apart, or the speed to begin with
            is not above 0.
        NoGaitFoundError: there is no gait at the speed to begin with.
        UnreachableError: its step is longer than the legs.
        StoppedError: `stop` said so before there was a walk.
    """
    if not resolution >= 10.0**-DIGITS:
        raise InputError(
            f"the resolution is {resolution:g} m/s; give at least {10.0**-DIGITS:g} m/s, by which "
            "speeds are told apart"
        )
    if not speed > 0.0:
        raise InputError(
            f"the speed to begin with is {speed:g} m/s; the fastest walk is searched forward, so "
            "give one above 0"
        )
    options = options or DesignOptions()
    first = many_starts(robot, task_at(speed), options, stop=stop).design
    quick = replace(options, solver=options.solver.limited(MAX_ITERATIONS), diagnose=False)
    tell = on_try or (lambda _speed, _found: None)
    search = _Search(robot, task_at, quick, tell, stop, first, [])
    interrupted = first.solution.status is Status.INTERRUPTED
    try:
        search.on_try(speed, first)
        if not interrupted:
            search.run(resolution)
    except StoppedError:
        interrupted = True
    best = search.best
    refused = min((v for v in search.without if v > best.problem.task.speed), default=math.inf)
    return Fastest(best, refused, binding(best), interrupted)


@dataclass
class _Search:
    """The fastest walk so far, all speeds without one, the least that it does not lead to."""

    robot: Robot
    task_at: Callable[[float], Task]
    options: DesignOptions
    on_try: OnTry
    stop: Stop
    best: Design
    without: list[float]
    refused: float = math.inf

    def run(self, resolution: float) -> None:
        """Try faster speeds until neither halved steps nor retries lead on."""
        self._bisect(FIRST_STEP * self._speed, resolution)
        while self._retry():
            self._bisect(RETRIES[0] * self._speed, resolution)

    @property
    def _speed(self) -> float:
        return self.best.problem.task.speed

    def _bisect(self, step: float, resolution: float) -> None:
        """Go up by a step in speed, halved where there is no walk, down to a resolution [m/s]."""
        while step >= resolution:
            speed = round(self._speed + step, DIGITS)
            if speed < self.refused:
                found = self._from_best(self.task_at(speed))
                if found is None:
                    self.refused = speed
                    self.without.append(speed)
                else:
                    self.best = found
                self.on_try(speed, found)
            if speed >= self.refused:
                step /= 2.0

    def _retry(self) -> bool:
        """Try faster speeds once more, from all starts; return whether one walks."""
        # The speed was refused from another walk than the one that is the fastest now.
        for fraction in RETRIES:
            speed = round((1.0 + fraction) * self._speed, DIGITS)
            task = self.task_at(speed)
            found = self._from(task, self.best.solution.x)
            found = found or self._kept(partial(self._from_starts, task))
            self.on_try(speed, found)
            if found is not None:
                self.best, self.refused = found, math.inf
                return True
            self.refused = min(self.refused, speed)
            self.without.append(speed)
        return False

    def _from_best(self, task: Task) -> Design | None:
        """Design from the fastest walk, then cold."""
        return self._from(task, self.best.solution.x) or self._from(task, None)

    def _from(self, task: Task, start: Array | None) -> Design | None:
        """Design from a walk (P,) or from the first guess."""
        approach = self.options.approach if start is None else "direct"
        options = replace(self.options, approach=approach)
        return self._kept(partial(design, self.robot, task, options, start=start, stop=self.stop))

    def _from_starts(self, task: Task) -> Design:
        """Design as if nothing were known: cold, and from a slower walk."""
        return many_starts(self.robot, task, self.options, stop=self.stop).design

    def _kept(self, designed: Callable[[], Design]) -> Design | None:
        """Return what a call designs; a gait that is not certified does not count."""
        try:
            found = designed()
        except StoppedError:
            raise
        except (NoGaitFoundError, UnreachableError):
            return None
        if found.solution.status is Status.INTERRUPTED:
            raise StoppedError(found.solution)
        return found if found.certificate.certified or not self.options.refine else None


_EQUALITIES = ("walking speed", "closure")


def binding(found: Design) -> tuple[str, ...]:
    """Return the inequality constraints that are at their limits, in words, one per constraint."""
    rows = (row for row in found.certificate.constraints if row.constraint not in _EQUALITIES)
    return tuple(row.sentence for row in rows if row.margin <= AT_LIMIT)
