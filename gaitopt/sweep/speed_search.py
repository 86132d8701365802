"""The fastest walk of a robot: from gait to faster gait until none is left."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from gaitopt.design.certificate import WorstRow
from gaitopt.design.design import Design, design
from gaitopt.design.options import DesignOptions
from gaitopt.design.starts import many_starts
from gaitopt.errors import InputError, NoGaitFoundError, StoppedError, UnreachableError
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Status, Stop, never

LEAPS = (0.05, 0.1)  # of the speed reached, tried once more in the end
FIRST_STRIDE = 0.2  # of the speed reached, by which the next try is faster
RESOLUTION = 0.01  # m/s
DIGITS = 3  # of the speeds tried
PATIENCE = 100  # iterations of a try; a neighbour's walk needs a tenth of them
AT_LIMIT = 1e-3  # scaled margin of a row that is at its limit

OnTry = Callable[[float, "Design | None"], None]


@dataclass(frozen=True)
class Fastest:
    """The fastest walk that was found.

    Attributes:
        design: the gait, designed as any other.
        refused: the next speed tried, at which there was none [m/s]; infinite if there is none yet.
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
        robot: the biped.
        task_at: the task at a speed; the step duration may follow from it.
        speed: to begin with [m/s].
        options: solver and refinement.
        resolution: [m/s].
        on_try: told every speed, and the design or None.
        stop: asked at every iteration; where it says True, the search ends.

    Raises:
        InputError: the resolution is finer than speeds are told apart.
        NoGaitFoundError: there is no gait at the speed to begin with.
        UnreachableError: its step is longer than the legs.
        StoppedError: `stop` said so before there was a walk.
    """
    if not resolution >= 10.0**-DIGITS:
        raise InputError(
            f"the resolution is {resolution} m/s; speeds are told apart from {10.0**-DIGITS} m/s on"
        )
    tell = on_try or (lambda speed, found: None)
    options = options or DesignOptions()
    search = _Search(
        robot,
        task_at,
        options,
        tell,
        stop,
        many_starts(robot, task_at(speed), options, stop=stop).design,
    )
    interrupted = search.best.solution.status is Status.INTERRUPTED
    try:
        tell(speed, search.best)
        if not interrupted:
            search.go_on(resolution)
    except StoppedError:
        interrupted = True
    return Fastest(search.best, search.refused, binding(search.best), interrupted)


@dataclass
class _Search:
    """The fastest walk so far, the least speed above it at which there was none, what to try."""

    robot: Robot
    task_at: Callable[[float], Task]
    options: DesignOptions
    tell: OnTry
    stop: Stop
    best: Design
    refused: float = math.inf

    def go_on(self, resolution: float) -> None:
        """Try faster speeds until neither small strides nor leaps lead on."""
        self._stride(FIRST_STRIDE * self._speed, resolution)
        while self._leap():
            self._stride(LEAPS[0] * self._speed, resolution)

    @property
    def _speed(self) -> float:
        return self.best.problem.task.speed

    def _stride(self, stride: float, resolution: float) -> None:
        while stride >= resolution:
            speed = round(self._speed + stride, DIGITS)
            if speed < self.refused:
                found = _try(self.robot, self.task_at(speed), self.options, self.best, self.stop)
                if found is None:
                    self.refused = speed
                else:
                    self.best = found
                self.tell(speed, found)
            if speed >= self.refused:
                stride /= 2.0

    def _leap(self) -> bool:
        """Try speeds beyond the refused one once more and from all starts; tell whether one walks.

        The speed was refused from another walk than the one that is the fastest now.
        """
        for leap in LEAPS:
            speed = round((1.0 + leap) * self._speed, DIGITS)
            task = self.task_at(speed)
            found = _try(self.robot, task, self.options, self.best, self.stop)
            found = found or _from_starts(self.robot, task, self.options, self.stop)
            self.tell(speed, found)
            if found is not None:
                self.best, self.refused = found, math.inf
                return True
            self.refused = min(self.refused, speed)
        return False


def binding(found: Design) -> tuple[str, ...]:
    """Return the inequality constraints that are at their limits, in words, one per family."""
    rows = found.certificate.families
    return tuple(row.sentence for row in rows if _at_limit(row) and row.family not in _EQUALITIES)


_EQUALITIES = ("walking speed", "closure")


def _at_limit(row: WorstRow) -> bool:
    return row.margin <= AT_LIMIT


def _from_starts(robot: Robot, task: Task, options: DesignOptions, stop: Stop) -> Design | None:
    """Design as if nothing were known; a gait that is not certified does not count."""
    quick = replace(options, solver=options.solver.limited(PATIENCE), diagnose=False)
    try:
        found = many_starts(robot, task, quick, stop=stop).design
    except StoppedError:
        raise
    except (NoGaitFoundError, UnreachableError):
        return None
    _require_not_stopped(found)
    return found if found.certificate.certified or not quick.refine else None


def _try(
    robot: Robot, task: Task, options: DesignOptions, best: Design, stop: Stop
) -> Design | None:
    """Design from a slower gait, then cold; a gait that is not certified does not count.

    Raises:
        StoppedError: `stop` said so, which is no answer about this speed.
    """
    cold = replace(options, solver=options.solver.limited(PATIENCE), diagnose=False)
    for quick, start in ((replace(cold, approach="direct"), best.solution.x), (cold, None)):
        try:
            found = design(robot, task, quick, start=start, stop=stop)
        except StoppedError:
            raise
        except (NoGaitFoundError, UnreachableError):
            continue
        _require_not_stopped(found)
        if found.certificate.certified or not quick.refine:
            return found
    return None


def _require_not_stopped(found: Design) -> None:
    if found.solution.status is Status.INTERRUPTED:
        raise StoppedError(found.solution)
