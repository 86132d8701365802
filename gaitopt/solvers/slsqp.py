"""SciPy's SLSQP: sequential least squares programming without second derivatives.

D. Kraft, "A software package for sequential quadratic programming", DFVLR-FB 88-28 (1988). Of
the methods here the nearest kin of the active-set SQP usual in engineering toolboxes, hence the
one to compare with. It returns no multipliers; they are those of `multipliers`.
"""

from __future__ import annotations

import warnings
from typing import Any, ClassVar

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.nlp import Array, Point, Solution, Start, Status
from gaitopt.settings import checked
from gaitopt.solvers.adapters import ScaledProgram
from gaitopt.solvers.solver import (
    Iterate,
    Recorder,
    SingleStage,
    is_unbounded,
    with_least_squares_multipliers,
)
from gaitopt.tolerances import FEASIBLE

LIMIT_REACHED = 9
"""SciPy's status for too many iterations."""
ENDED = 99
"""SciPy's status for a run that its callback ended."""

RESTARTS = 4
"""Times a run is begun anew where it stopped: SciPy's line search gives up when its learnt
curvature has become poor, and a restart forgets it. From the first guess of the thirteen-link biped
at 1 m/s it does so after some twenty iterations, far from feasible ..."""
RESTART_GAIN = 0.9
"""... as long as it moves, once feasible as long as the KKT residual falls to this share."""


@checked
@dataclass(frozen=True)
class SLSQP(SingleStage):
    """Quasi-Newton SQP of SciPy, on one-sided rows and scaled variables.

    Attributes:
        tolerance: on the gradient of the Lagrangian and on complementarity.
        feasibility: on the largest violation of a row or bound.
        cost_tolerance: SciPy's `ftol`, on the change of the scaled cost, which stops the run too.
        max_iterations: of SciPy's main loop.
    """

    name: ClassVar[str] = "slsqp"
    tolerance: float = 1e-5
    feasibility: float = 1e-7
    cost_tolerance: float = 1e-12
    max_iterations: int = 500

    def _solved(self, recorder: Recorder, point: Point, start: Start) -> Solution:
        del start  # it finds its own multipliers
        program = ScaledProgram(recorder.evaluator, point)
        last = _judge(program, point.x / program.scale)
        recorder.record(last)
        status = Status.INTERRUPTED
        for _ in range(1 + RESTARTS):
            if recorder.stopped:
                break
            ended, u = self._minimise(program, last.point.x / program.scale, recorder)
            before, last = last, _judge(program, u)
            recorder.keep(last)
            status = self._status(last, ended)
            if recorder.stopped and status is not Status.OPTIMAL:
                status = Status.INTERRUPTED
            if status is Status.INFEASIBLE:
                useful = not np.array_equal(last.point.x, before.point.x)
            else:
                fell = last.residual.worst < RESTART_GAIN * before.residual.worst
                useful = fell and status is Status.STALLED
            if not useful:
                break
        return recorder.solution(status, recorder.answer(status, last))

    def _minimise(
        self, program: ScaledProgram, start: Array, recorder: Recorder
    ) -> tuple[int, Array]:
        """Run SciPy's method; return its status and where it stopped."""
        from scipy import optimize

        variables, scale = program.nlp.variables, program.scale
        options: Any = {"maxiter": self.max_iterations, "ftol": self.cost_tolerance}
        last = start.copy()

        def judge_and_record(u: Array) -> None:
            last[:] = u
            iterate = _judge(program, u)
            recorder.record(iterate)
            ended = iterate.is_optimal(self.tolerance, self.feasibility)
            if ended or recorder.stopped or is_unbounded(program.nlp, iterate):
                raise StopIteration

        with warnings.catch_warnings():
            # SciPy warns when it clips a step to the bounds, and of infinite costs in its search.
            warnings.simplefilter("ignore", RuntimeWarning)
            # The published types admit neither our arrays nor our callbacks.
            minimise: Any = optimize.minimize
            try:
                result = minimise(
                    program.cost,
                    start,
                    jac=program.gradient,
                    method="SLSQP",
                    bounds=optimize.Bounds(variables.lower / scale, variables.upper / scale),
                    constraints=_constraints(program),
                    callback=judge_and_record,
                    options=options,
                )
            except StopIteration:  # SciPy before 1.17 lets it through
                return ENDED, last
        return int(result.status), np.asarray(result.x)

    def _status(self, iterate: Iterate, ended: int) -> Status:
        if iterate.is_optimal(self.tolerance, self.feasibility):
            return Status.OPTIMAL
        if ended == LIMIT_REACHED:
            return Status.ITERATION_LIMIT
        return Status.STALLED if iterate.violation <= FEASIBLE else Status.INFEASIBLE


def _constraints(program: ScaledProgram) -> list[Any]:
    """Return equalities c = 0 and one-sided rows c >= 0; limits that do not exist are dropped."""
    lower, upper = program.nlp.rows.lower, program.nlp.rows.upper
    equal = np.flatnonzero(lower == upper)
    low = np.flatnonzero((lower < upper) & np.isfinite(lower))
    high = np.flatnonzero((lower < upper) & np.isfinite(upper))

    def one_sided(u: Array) -> Array:
        rows = program.rows(u)
        return np.concatenate([rows[low] - lower[low], upper[high] - rows[high]])

    def one_sided_jacobian(u: Array) -> Array:
        jacobian = program.jacobian(u)
        return np.vstack([jacobian[low], -jacobian[high]])

    constraints: list[Any] = []
    if equal.size:
        constraints.append(
            {
                "type": "eq",
                "fun": lambda u: program.rows(u)[equal] - lower[equal],
                "jac": lambda u: program.jacobian(u)[equal],
            }
        )
    if low.size + high.size:
        constraints.append({"type": "ineq", "fun": one_sided, "jac": one_sided_jacobian})
    return constraints


def _judge(program: ScaledProgram, u: Array) -> Iterate:
    """Judge a point by the multipliers that suit it best."""
    point = program.point(u)
    return with_least_squares_multipliers(program.nlp, point)
