"""The work on one point of a sweep, as it is handed to whoever does it, near or far."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections import deque
from dataclasses import dataclass, replace

from gaitopt.design.active import pressures
from gaitopt.design.design import Design, design
from gaitopt.design.diagnosis import Diagnosis
from gaitopt.design.options import DesignOptions
from gaitopt.design.runtime import small_matrices
from gaitopt.errors import InputError, NoGaitFoundError, UnreachableError
from gaitopt.gait.result import Gait
from gaitopt.study.finish import finish
from gaitopt.study.footing import Footing
from gaitopt.study.grid_points import Index
from gaitopt.study.index import Row, index_row
from gaitopt.study.interruption import stop_if_interrupted
from gaitopt.study.setting import Setting
from gaitopt.study.travel import Near, travel

TRAVEL, FINISH, DIAGNOSE = "travel", "finish", "diagnose"


@dataclass(frozen=True, eq=False)
class Job:
    """What is to be done for a point; the answer depends on nothing else.

    Attributes:
        kind: TRAVEL to a walk from its neighbours, FINISH a walk as a gait, or DIAGNOSE why there
            is none.
        point: which.
        setting: its robot and task.
        axes: swept quantities with their values there.
        options: as of `design`.
        near: neighbours to travel from.
        patient, cold: what else to try, see `travel`.
        below: cost of a walk that would not be wanted, see `travel`.
        walk: to be finished.
    """

    kind: str
    point: Index
    setting: Setting
    axes: tuple[tuple[str, float], ...]
    options: DesignOptions
    near: tuple[Near, ...] = ()
    patient: bool = False
    cold: bool = False
    below: float = math.inf
    walk: Footing | None = None


@dataclass(frozen=True, eq=False)
class Outcome:
    """What came of a job.

    Attributes:
        job: which.
        footing: a walk, if one was found or known.
        gait, row: the finished gait and its line of the index.
        refusal: why there is no gait, one thought each, JSON-able.
        seconds: of processor.
    """

    job: Job
    footing: Footing | None
    gait: Gait | None = None
    row: Row | None = None
    refusal: dict[str, object] | None = None
    seconds: float = 0.0


class Crew(ABC):
    """Does jobs.

    Attributes:
        room: jobs it can usefully hold at a time.
    """

    room: int

    @abstractmethod
    def submit(self, job: Job) -> None:
        """Take a job."""

    @abstractmethod
    def next(self) -> Outcome:
        """Return the next outcome, whichever job it is of; wait if there is none yet."""

    @abstractmethod
    def close(self) -> None:
        """Give up what is not done and leave."""


class Alone(Crew):
    """This process, one job after another."""

    def __init__(self) -> None:
        self.room = 1
        self._jobs: deque[Job] = deque()

    def submit(self, job: Job) -> None:
        """Take a job."""
        self._jobs.append(job)

    def next(self) -> Outcome:
        """Do the oldest job."""
        return run_job(self._jobs.popleft())

    def close(self) -> None:
        """Forget the rest."""
        self._jobs.clear()


def run_job(job: Job) -> Outcome:
    """Do a job, with one BLAS thread.

    Raises:
        KeyboardInterrupt: Ctrl-C was pressed.
    """
    began = time.process_time()
    with small_matrices():
        try:
            outcome = _WORK[job.kind](job)
        except InputError as error:  # a robot or task that cannot be, at this point of the grid
            outcome = Outcome(job, None, refusal={"sentences": [str(error)]})
    return replace(outcome, seconds=time.process_time() - began)


def _travel(job: Job) -> Outcome:
    found = travel(
        job.setting,
        job.near,
        job.options,
        job.axes,
        patient=job.patient,
        cold=job.cold,
        below=job.below,
    )
    return Outcome(job, found)


def _finish(job: Job) -> Outcome:
    began = time.process_time()
    found = None if job.walk is None else finish(job.setting, job.walk, job.options)
    if job.walk is None or found is None:
        return Outcome(job, None)
    return _told(job, job.walk, found, began)


def _diagnose(job: Job) -> Outcome:
    """Design in the usual way, which explains a failure; sometimes it is none after all."""
    began = time.process_time()
    try:
        found = design(job.setting.robot.build(), job.setting.task, job.options)
    except (NoGaitFoundError, UnreachableError) as error:
        stop_if_interrupted(getattr(error, "solution", None))
        known = error.diagnosis
        record: dict[str, object] = {"sentences": [str(error)]}
        if isinstance(known, Diagnosis):
            record = {**known.record(), "sentences": [str(error), *known.sentences]}
        return Outcome(job, None, refusal=record)
    stop_if_interrupted(found.solution)
    footing = Footing(
        x=found.solution.x,
        cost=found.solution.cost,
        active=pressures(found.problem, found.solution.multipliers),
        slopes=(None,) * len(job.axes),
        journey=0,
        iterations=0,
        evaluations=0,
        seconds=0.0,
        origin="diagnosis",
    )
    return _told(job, footing, found, began)


def _told(job: Job, footing: Footing, found: Design, began: float) -> Outcome:
    seconds = footing.seconds + time.process_time() - began
    row = index_row(found, footing, dict(job.axes), seconds)
    meta = {**found.gait.meta, "sweep": {"values": dict(job.axes), "origin": footing.origin}}
    return Outcome(job, footing, gait=replace(found.gait, meta=meta), row=row)


_WORK = {TRAVEL: _travel, FINISH: _finish, DIAGNOSE: _diagnose}
