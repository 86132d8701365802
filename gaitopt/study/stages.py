"""The stages of a sweep, and the state they share."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from gaitopt.design.options import DesignOptions
from gaitopt.study.branches import SAME, lower, promising
from gaitopt.study.footing import Footing
from gaitopt.study.grid_points import Index
from gaitopt.study.jobs import DIAGNOSE, FINISH, TRAVEL, Crew, Job, Outcome
from gaitopt.study.library import Writer
from gaitopt.study.plan import Plan

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
