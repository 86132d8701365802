"""The paper's method on the paper's own evaluation, until it first gets to gaitopt's optimum.

SLSQP with forward differences of cost and rows, twice from the same guess: on gaitopt's evaluation,
which counts the work in seconds, and on `paper_evaluation`, which takes as long as it takes. Both
stop at the first feasible iterate whose cost is within 0.01 % of gaitopt's optimum. Progress is
written at every iteration, so that a run that is killed still counts.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from common import TimedNLP, arguments, save, start, told, walk
from paper_evaluation import PaperProblem

from gaitopt.design.process import small_matrices
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import NLP, Array, Progress, Start, Values
from gaitopt.solvers import SLSQP, SQP, FiniteDifferenceNLP
from gaitopt.tolerances import FEASIBLE

CAP = 5400.0
"""CPU seconds after which a run is stopped."""
REPEATS = 10
"""Of our own solve, before and after."""
NEAR = 1e-4
"""Relative distance to gaitopt's optimum at which a run has arrived."""
EVERY, TIMED = 500, 10
"""Which of the points evaluated are timed on both evaluations, and how many times at most."""
SAME = 1e-9
"""Difference of the two evaluations that is allowed, relative to the larger of one and a row."""


class Sampled(TimedNLP):
    """Keeps some of the points at which it was evaluated."""

    def __init__(self, nlp: NLP, limit: float) -> None:
        super().__init__(nlp, limit=limit)
        self.points_kept: list[Array] = []

    def values(self, x: Array) -> Values:
        if self.evaluations % EVERY == 0:
            self.points_kept.append(x.copy())
        return super().values(x)


class Diary:
    """What a run got to at every iteration; ends it where it arrives."""

    def __init__(self, counted: TimedNLP, goal: float, data: dict[str, Any], quick: bool) -> None:
        self._counted, self._goal, self._quick = counted, goal, quick
        self._data = data
        self._started = time.process_time()
        self.lines: list[list[float]] = []
        self.arrived = False

    def __call__(self, progress: Progress) -> bool:
        counted = self._counted
        self.lines.append([
            time.process_time() - self._started, progress.cost, progress.violation,
            counted.evaluations, counted.cpu_seconds,
        ])  # fmt: skip
        if not self._quick:
            save("paper_own", self._data, False)
        self.arrived = progress.violation <= FEASIBLE and progress.cost <= self._goal
        return self.arrived or counted.out_of_time()


def travel(nlp: NLP, x: Array, goal: float, data: dict[str, Any], name: str, quick: bool) -> Array:
    """Run SLSQP with differences until it arrives; return points it evaluated, shape (k, P)."""
    counted = Sampled(nlp, 20.0 if quick else CAP)
    diary = Diary(counted, goal, data, quick)
    record: dict[str, Any] = {
        "columns": ["CPU s", "cost", "violation", "evaluations", "CPU s in evaluations"],
        "progress": diary.lines,
        "arrived": False,
    }
    data[name] = record
    solution = SLSQP().solve(FiniteDifferenceNLP(counted), Start(x), stop=diary)
    record |= told(solution) | {"evaluations": counted.evaluations, "arrived": diary.arrived}
    return np.array(counted.points_kept)


def ours(problem: WalkProblem, x: Array, goal: float) -> dict[str, float]:
    """Solve with gaitopt; return CPU time to the goal and to the end [s]."""
    arrived: list[float] = []
    started = time.process_time()

    def look(progress: Progress) -> None:
        if progress.violation <= FEASIBLE and progress.cost <= goal and not arrived:
            arrived.append(time.process_time() - started)

    SQP().solve(problem, Start(x), look)
    end = time.process_time() - started
    return {"arrived": arrived[0] if arrived else end, "end": end}


def compare(problem: WalkProblem, paper: PaperProblem, points: Array) -> dict[str, float]:
    """Time both evaluations in turn at the same points; they must agree."""
    seconds: dict[str, list[float]] = {"gaitopt": [], "paper": []}
    apart = 0.0
    for x in points[:: max(1, len(points) // TIMED)]:
        found = []
        for name, nlp in (("gaitopt", problem), ("paper", paper)):
            started = time.process_time()
            found.append(nlp.values(x))
            seconds[name].append(time.process_time() - started)
        one, other = found
        rows = np.abs(one.rows - other.rows) / np.maximum(1.0, np.abs(one.rows))
        apart = max(apart, float(rows.max()), abs(one.cost / other.cost - 1.0))
    if apart > SAME:
        raise SystemExit(f"the two evaluations differ by {apart:.1e}: not the same program")
    return {name: float(np.median(times)) for name, times in seconds.items()} | {"apart": apart}


def main() -> None:
    quick = arguments(__doc__).parse_args().quick
    problem = walk()
    x = start(problem)
    with small_matrices():
        goal = SQP().solve(problem, Start(x)).cost * (1.0 + NEAR)
        runs = [ours(problem, x, goal) for _ in range(1 if quick else REPEATS)]
        data: dict[str, Any] = {"cap": CAP, "goal": goal, "ours": runs}
        points = travel(problem, x, goal, data, "fast", quick)
        paper = PaperProblem(problem)
        data["evaluation"] = compare(problem, paper, points)
        travel(paper, x, goal, data, "paper", quick)
        runs += [ours(problem, x, goal) for _ in range(1 if quick else REPEATS)]
    save("paper_own", data, quick)


if __name__ == "__main__":
    main()
