"""Table 3: the same walk, first guess and solver with exact derivatives and with differences."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import NLP, Array, Progress, Start, Status
from gaitopt.solvers import SQP, FiniteDifferenceNLP
from gaitopt.tolerances import FEASIBLE

EXACT, COST_ONLY, DIFFERENCES = "exact", "cost only", "differences"
GRADIENTS = (EXACT, COST_ONLY, DIFFERENCES)
"""Exact derivatives of everything; of the cost only, as in the paper; of nothing."""

SOLVER = SQP()
CAP = 60.0  # CPU seconds after which a run is stopped
NEAR = 1e-3  # relative; a feasible iterate this close to the optimum is almost there
REPEATS = 3  # of the runs that take a fraction of a second; the median counts


@dataclass(frozen=True)
class Run:
    """One run of the solver.

    Attributes:
        speed: [m/s].
        gradient: one of `GRADIENTS`.
        status: how it stopped.
        cost: of the best feasible iterate [N²·m·s].
        iterations: of the solver.
        evaluations: of the walk, those for differences included.
        seconds: of the CPU.
        history: CPU time [s], cost and violation of each iterate, shape (iterations, 3).
    """

    speed: float
    gradient: str
    status: Status
    cost: float
    iterations: int
    evaluations: int
    seconds: float
    history: Array

    @property
    def converged(self) -> bool:
        """Whether the first-order conditions hold to the solver's tolerance."""
        return self.status is Status.OPTIMAL

    def seconds_to(self, cost: float) -> float:
        """Return when a feasible iterate first cost no more than this [CPU s]; nan if never."""
        seconds, costs, violations = self.history.T
        there = np.flatnonzero((violations <= FEASIBLE) & (costs <= cost))
        return float(seconds[there[0]]) if there.size else float("nan")


@dataclass(frozen=True)
class Comparison:
    """The three runs at one speed, in the order of `GRADIENTS`."""

    runs: tuple[Run, Run, Run]

    @property
    def speed(self) -> float:
        """[m/s]."""
        return self.runs[0].speed

    def run(self, gradient: str) -> Run:
        """Return the run with one of `GRADIENTS`."""
        return self.runs[GRADIENTS.index(gradient)]

    def ratio(self, gradient: str) -> float:
        """Return how many times longer a run takes than the exact one, each to its end."""
        return self.run(gradient).seconds / self.run(EXACT).seconds

    def near_ratio(self, gradient: str) -> float:
        """Return the same to the first feasible iterate within `NEAR` of the best cost."""
        cost = min(run.cost for run in self.runs) * (1.0 + NEAR)
        return self.run(gradient).seconds_to(cost) / self.run(EXACT).seconds_to(cost)


def compare(problem: WalkProblem, cap: float = CAP) -> Comparison:
    """Solve a walk from the first guess with each kind of gradient.

    Args:
        problem: the walk.
        cap: CPU seconds after which a run is stopped.

    Raises:
        UnreachableError: the step is too long for a first guess.
    """
    x = first_guess(problem)
    exact = sorted((_run(problem, x, EXACT, cap) for _ in range(REPEATS)), key=_seconds)
    return Comparison(
        (
            exact[REPEATS // 2],
            _run(problem, x, COST_ONLY, cap),
            _run(problem, x, DIFFERENCES, cap),
        )
    )


def _seconds(run: Run) -> float:
    return run.seconds


def _run(problem: WalkProblem, x: Array, gradient: str, cap: float) -> Run:
    inexact = None
    if gradient != EXACT:
        inexact = FiniteDifferenceNLP(problem, cost_gradient_only=gradient == COST_ONLY)
    nlp: NLP = problem if inexact is None else inexact
    history: list[tuple[float, float, float]] = []
    started = time.process_time()

    def note(progress: Progress) -> bool:
        spent = time.process_time() - started
        history.append((spent, progress.cost, progress.violation))
        return spent > cap

    solution = SOLVER.solve(nlp, Start(x), stop=note)
    return Run(
        speed=problem.task.speed,
        gradient=gradient,
        status=solution.status,
        cost=solution.cost,
        iterations=solution.iterations,
        evaluations=solution.evaluations if inexact is None else inexact.evaluations,
        seconds=time.process_time() - started,
        history=np.array(history),
    )
