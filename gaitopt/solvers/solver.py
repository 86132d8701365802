"""What every solver is made of: its options, and the record of a run with its best iterate."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from dataclasses import field
from typing import ClassVar

import numpy as np

from gaitopt.bounds import is_line, shown
from gaitopt.dataclass import dataclass
from gaitopt.errors import EvaluationError, InputError, did_you_mean, own_code
from gaitopt.nlp import (
    NLP,
    Array,
    Point,
    Progress,
    ProgressCallback,
    Residual,
    Solution,
    Start,
    Status,
    StopCallback,
    kkt_residual,
    worst_violation,
)
from gaitopt.solvers.adapters import Evaluator
from gaitopt.solvers.multipliers import least_squares_multipliers
from gaitopt.tolerances import AGREEMENT, FEASIBILITY, FEASIBLE, OPTIMALITY


class Solver(ABC):
    """Options of one method, and the method itself.

    Attributes:
        name: under which `solver_by_name` knows the solver.
    """

    name: ClassVar[str]

    @abstractmethod
    def solve(
        self,
        nlp: NLP,
        start: Start,
        on_progress: ProgressCallback | None = None,
        stop: StopCallback | None = None,
    ) -> Solution:
        """Solve the program from `start`.

        What happens on the way is told by `Solution.status`, not by an exception.

        Args:
            start: where to begin; a point outside its bounds is moved onto them.
            on_progress: called once per iteration.
            stop: asked once per iteration; where it says True, the solver returns its best
                iterate with the status INTERRUPTED.

        Raises:
            InputError: it is a solver of one's own, and is not what a solver has to be.
        """

    @property
    def first_stage(self) -> Solver:
        """The solver that finds what `confirm` then confirms; itself where there is one stage."""
        return self

    def confirm(
        self,
        nlp: NLP,
        first: Solution,
        on_progress: ProgressCallback | None = None,
        stop: StopCallback | None = None,
    ) -> Solution:
        """Run the second stage from an answer of the first; where there is none, return that.

        Args:
            first: what `first_stage` found.
            on_progress: called for every iteration of the second stage.
            stop: asked after every iteration of it.
        """
        del nlp, on_progress, stop
        return first

    def limited(self, iterations: int) -> Solver:
        """Return the solver with at most so many iterations of its first stage, if it can be."""
        del iterations
        return self

    def near_solution(self) -> Solver:
        """Return the solver for starts that are nearly solutions."""
        return self

    def roughly(self) -> Solver:
        """Return the solver for answers that are only the way to others, if it has such options."""
        return self


def require_positive(solver: str, **options: float) -> None:
    """Check that options are positive finite numbers.

    Raises:
        InputError: one of them is not.
    """
    for option, value in options.items():
        if not (math.isfinite(value) and value > 0):
            raise InputError(
                f"solver {solver}: option {option} is {value}, but must be a positive number"
            )


def require_choice(solver: str, option: str, value: str, allowed: tuple[str, ...]) -> None:
    """Check that an option is one of the words allowed.

    Raises:
        InputError: it is not.
    """
    if value not in allowed:
        raise InputError(
            f"solver {solver}: option {option} is {value!r}; {did_you_mean(value, allowed)}choose "
            f"one of {', '.join(allowed)}"
        )


UNBOUNDED_COST = -1e10
"""Scaled cost, of order one to ten at sensible points, below which it is called unbounded."""


@dataclass(frozen=True)
class Iterate:
    """A point, its multipliers, and how far they are from optimal.

    Attributes:
        point: values and derivatives.
        multipliers: of the rows, shape (m,).
        bound_multipliers: of the bounds, shape (n,).
        residual: KKT residual of the three above.
    """

    point: Point
    multipliers: Array
    bound_multipliers: Array
    residual: Residual

    @property
    def violation(self) -> float:
        """Largest violation of a row or bound."""
        return self.residual.feasibility

    def is_optimal(self, tolerance: float, feasibility: float) -> bool:
        """Return whether the optimality conditions hold to these tolerances."""
        residual = self.residual
        return residual.optimality <= tolerance and residual.feasibility <= feasibility


def make_iterate(nlp: NLP, point: Point, multipliers: Array, bound_multipliers: Array) -> Iterate:
    """Judge a point and its multipliers (m,), (n,) by the definition of optimality."""
    residual = kkt_residual(nlp, point, multipliers, bound_multipliers)
    return Iterate(point, multipliers, bound_multipliers, residual)


def with_least_squares_multipliers(
    nlp: NLP, point: Point, tolerance: float = OPTIMALITY
) -> Iterate:
    """Judge a point by the multipliers that suit it best, whatever the solver's are.

    They are those of the limits that it is at, if these satisfy the conditions; else of those near
    it too. A limit at two instants close together has nearly the same gradient at both: allowed to
    press at both, least squares does, where the point is at it at one of them alone. A method that
    then holds both goes elsewhere.

    Args:
        tolerance: on the gradient of the Lagrangian and on complementarity.
    """
    at_limits = make_iterate(nlp, point, *least_squares_multipliers(nlp, point, FEASIBILITY))
    if at_limits.residual.optimality <= tolerance:
        return at_limits
    near = make_iterate(nlp, point, *least_squares_multipliers(nlp, point))
    return min(near, at_limits, key=lambda one: one.residual.optimality)


def is_unbounded(nlp: NLP, iterate: Iterate) -> bool:
    """Return whether a feasible iterate costs so little that the cost has no least value."""
    return iterate.violation <= FEASIBLE and nlp.cost_scale * iterate.point.cost < UNBOUNDED_COST


@dataclass
class Recorder:
    """Keeps the history and the best iterate of one run.

    Attributes:
        solver: name of the solver.
        evaluator: its counts go into every record.
        on_progress: called with every record.
        stop: asked after every record whether the run shall end.
        stopped: whether it said so; the run ends as soon as it can.
        best: the feasible iterate of least cost, of those that agree in it the nearest to
            optimality; else the one of least violation.
        history: one record per iteration.
        started: on the clock `perf_counter` [s].
    """

    solver: str
    evaluator: Evaluator
    on_progress: ProgressCallback | None = None
    stop: StopCallback | None = None
    stopped: bool = False
    best: Iterate | None = None
    history: list[Progress] = field(default_factory=list)
    started: float = field(default_factory=time.perf_counter)

    def keep(self, iterate: Iterate) -> None:
        """Remember an iterate if it is the best so far."""
        if self.best is None or _better(iterate, self.best):
            self.best = iterate

    def record(self, iterate: Iterate, radius: float = np.nan) -> None:
        """Add one iteration to the history, tell the caller, and ask whether to stop."""
        self.keep(iterate)
        progress = Progress(
            iteration=len(self.history),
            cost=iterate.point.cost,
            violation=iterate.violation,
            worst=worst_violation(self.evaluator.nlp, iterate.point)[1],
            optimality=iterate.residual.optimality,
            radius=radius,
            seconds=time.perf_counter() - self.started,
            evaluations=self.evaluator.evaluations,
            solver=self.solver,
        )
        self.history.append(progress)
        if self.on_progress is not None:
            self.on_progress(progress)
        if self.stop is not None and self.stop(progress):
            self.stopped = True

    def answer(self, status: Status, last: Iterate) -> Iterate:
        """Choose what a run returns: where it ended if that is optimal, else the best iterate."""
        return last if status is Status.OPTIMAL or self.best is None else self.best

    def solution(self, status: Status, iterate: Iterate) -> Solution:
        """Write the solution at an iterate."""
        if is_unbounded(self.evaluator.nlp, iterate):
            status = Status.UNBOUNDED
        return Solution(
            x=iterate.point.x.copy(),
            cost=iterate.point.cost,
            multipliers=iterate.multipliers.copy(),
            bound_multipliers=iterate.bound_multipliers.copy(),
            status=status,
            violation=iterate.violation,
            optimality=iterate.residual.optimality,
            iterations=max(0, len(self.history) - 1),
            evaluations=self.evaluator.evaluations,
            hessians=self.evaluator.hessians,
            seconds=time.perf_counter() - self.started,
            solver=self.solver,
            history=tuple(self.history),
        )

    def failure(self, x: Array) -> Solution:
        """Write the solution of a run whose start x (n,) has no value: all numbers nan."""
        return Solution(
            x=x,
            cost=np.nan,
            multipliers=np.zeros(self.evaluator.nlp.rows.lower.size),
            bound_multipliers=np.zeros(x.size),
            status=Status.NUMERICAL,
            violation=np.nan,
            optimality=np.nan,
            iterations=0,
            evaluations=self.evaluator.evaluations,
            hessians=self.evaluator.hessians,
            seconds=time.perf_counter() - self.started,
            solver=self.solver,
        )


class SingleStage(Solver):
    """A method that runs once, from a point at which the program has a value.

    A dataclass, whose numbers are options above zero. One of one's own need not be in `SOLVERS` to
    be given to a design (docs/solvers.md); a mistake in it ends the search as an `InputError`.

    Raises:
        InputError: an option cannot be used.
    """

    def __post_init__(self) -> None:
        numbers = {name: v for name, v in vars(self).items() if not isinstance(v, str | bool)}
        require_positive(self.name, **numbers)

    def solve(
        self,
        nlp: NLP,
        start: Start,
        on_progress: ProgressCallback | None = None,
        stop: StopCallback | None = None,
    ) -> Solution:
        """Solve the program as `Solver` says.

        Raises:
            InputError: a solver of one's own has no name, raises, or returns no solution.
        """
        if not is_line(getattr(self, "name", None)):
            raise InputError(
                f"the solver {type(self).__name__} has no name; give its class a text: name = "
                "'mine'"
            )
        evaluator = Evaluator(nlp)
        recorder = Recorder(self.name, evaluator, on_progress, stop)
        try:
            point = evaluator.point(np.clip(start.x, nlp.variables.lower, nlp.variables.upper))
        except EvaluationError:
            return recorder.failure(start.x)
        if type(self).__module__.startswith("gaitopt."):
            return self._solved(recorder, point, start)
        with own_code(self, f"the solver '{self.name}'"):
            found = self._solved(recorder, point, start)
        if not isinstance(found, Solution):
            raise InputError(
                f"the solver '{self.name}' returns {shown(found)}; return what "
                "recorder.solution(status, iterate) does"
            )
        return found

    @abstractmethod
    def _solved(self, recorder: Recorder, point: Point, start: Start) -> Solution:
        """Return what the method comes to from a point, the start moved into its bounds."""


def _better(a: Iterate, b: Iterate) -> bool:
    if a.violation <= FEASIBLE and b.violation <= FEASIBLE:
        if abs(a.point.cost - b.point.cost) > AGREEMENT * abs(b.point.cost):
            return a.point.cost < b.point.cost
        return a.residual.worst <= b.residual.worst  # a little infeasible, it would cost less
    return a.violation < b.violation
