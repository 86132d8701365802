"""IPOPT through cyipopt, for those who have it.

A. Waechter, L. Biegler, "On the implementation of an interior-point filter line-search algorithm
for large-scale nonlinear programming", Mathematical Programming 106 (2006).
"""

from __future__ import annotations

import importlib
from typing import Any, ClassVar

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.errors import MissingExtraError
from gaitopt.nlp import Array, Indices, Point, Solution, Start, Status
from gaitopt.settings import checked
from gaitopt.solvers.adapters import ScaledProgram
from gaitopt.solvers.multipliers import one_sided
from gaitopt.solvers.solver import (
    Iterate,
    Recorder,
    SingleStage,
    make_iterate,
    with_least_squares_multipliers,
)
from gaitopt.tolerances import FEASIBILITY, FEASIBLE, OPTIMALITY

STATUS = {-1: Status.ITERATION_LIMIT, 2: Status.INFEASIBLE, 5: Status.INTERRUPTED}
"""IPOPT's return codes that say more than the point itself."""


@checked
@dataclass(frozen=True)
class Ipopt(SingleStage):
    """Interior point method of IPOPT.

    Attributes:
        tolerance: on the gradient of the Lagrangian and on complementarity.
        feasibility: on the largest violation of a row or bound.
        max_iterations: of IPOPT.

    Raises:
        MissingExtraError: when it solves, and cyipopt is not installed.
    """

    name: ClassVar[str] = "ipopt"
    tolerance: float = OPTIMALITY
    feasibility: float = FEASIBILITY
    max_iterations: int = 1000

    def _solved(self, recorder: Recorder, point: Point, start: Start) -> Solution:
        del start  # it finds its own multipliers
        nlp = recorder.evaluator.nlp
        try:
            cyipopt = importlib.import_module("cyipopt")
        except ImportError as error:
            raise MissingExtraError("solver ipopt", "ipopt") from error
        callbacks = _Callbacks(ScaledProgram(recorder.evaluator, point), recorder)
        callbacks.problem = problem = self._problem(cyipopt, callbacks)
        u, info = problem.solve(point.x / nlp.variables.scale)
        last = callbacks.judge(u, info)
        recorder.keep(last)
        status = self._status(last, int(info["status"]))
        return recorder.solution(status, recorder.answer(status, last))

    def _problem(self, cyipopt: Any, callbacks: _Callbacks) -> Any:
        nlp, scale = callbacks.program.nlp, callbacks.program.scale
        problem = cyipopt.Problem(
            n=scale.size,
            m=nlp.rows.lower.size,
            problem_obj=callbacks,
            lb=nlp.variables.lower / scale,
            ub=nlp.variables.upper / scale,
            cl=nlp.rows.lower,
            cu=nlp.rows.upper,
        )
        problem.add_option("print_level", 0)
        problem.add_option("sb", "yes")  # no banner
        # IPOPT widens bounds a little by default; then no answer would be feasible.
        problem.add_option("bound_relax_factor", 0.0)
        problem.add_option("tol", 0.1 * self.tolerance * min(1.0, float(scale.min())))
        problem.add_option("constr_viol_tol", 0.1 * self.feasibility)
        # Rows and cost are scaled already, and a fixed barrier stalls on gaits (measured).
        problem.add_option("nlp_scaling_method", "none")
        problem.add_option("mu_strategy", "adaptive")
        problem.add_option("max_iter", self.max_iterations)
        if not nlp.has_hessian:
            problem.add_option("hessian_approximation", "limited-memory")
        return problem

    def _status(self, iterate: Iterate, code: int) -> Status:
        if iterate.is_optimal(self.tolerance, self.feasibility):
            return Status.OPTIMAL
        feasible = iterate.violation <= FEASIBLE
        return STATUS.get(code, Status.STALLED if feasible else Status.NUMERICAL)


class _Callbacks:
    """The functions IPOPT calls, by the names it gives them."""

    def __init__(self, program: ScaledProgram, recorder: Recorder) -> None:
        self.program = program
        self.recorder = recorder
        self.problem: Any = None  # IPOPT's, once it is made

    def objective(self, u: Array) -> float:
        cost = self.program.cost(u)
        return cost if np.isfinite(cost) else np.nan  # IPOPT then shortens its step

    def gradient(self, u: Array) -> Array:
        return self.program.gradient(u)

    def constraints(self, u: Array) -> Array:
        return self.program.rows(u)

    def jacobian(self, u: Array) -> Array:
        return self.program.jacobian(u).ravel()

    def hessianstructure(self) -> tuple[Indices, Indices]:
        rows, columns = np.tril_indices(self.program.scale.size)
        return rows, columns

    def hessian(self, u: Array, multipliers: Array, weight: float) -> Array:
        H = self.program.hessian(u, multipliers, weight * self.program.nlp.cost_scale)
        return np.asarray(H[np.tril_indices(u.size)])

    def intermediate(self, *_: Any) -> bool:
        """Record IPOPT's iterate with its multipliers; False tells IPOPT to stop."""
        try:
            at = self.problem.get_current_iterate()
        except RuntimeError:  # IPOPT before 3.14 does not tell
            at = None
        if at is None:  # derivatives were asked for at its iterates only
            self.recorder.record(
                with_least_squares_multipliers(self.program.nlp, self.program.last)
            )
        else:
            self.recorder.record(self.judge(at["x"], at))
        return not self.recorder.stopped

    def judge(self, u: Array, info: dict[str, Any]) -> Iterate:
        """Judge a point with IPOPT's multipliers."""
        nlp = self.program.nlp
        variables, rows = nlp.variables, nlp.rows
        multipliers = np.broadcast_to(info["mult_g"], rows.lower.shape)
        bounds = (info["mult_x_U"] - info["mult_x_L"]) / self.program.scale
        return make_iterate(
            nlp,
            self.program.point(u),
            one_sided(multipliers, rows.lower, rows.upper),
            one_sided(bounds, variables.lower, variables.upper),
        )
