"""SciPy's trust-region interior point method, alone or to confirm another solver's answer.

R. Byrd, M. Hribar, J. Nocedal, "An interior point algorithm for large-scale nonlinear
programming", SIAM J. Optim. 9 (1999), as scipy.optimize.minimize(method="trust-constr").
Its cost grows with the rows, so that it is given a working set of those nearest to their limits;
it starts every inequality with a slack of at least one, so that rows are multiplied by a large
number lest a good start be thrown away. Even so the barrier leads away from a start that is a
solution (measured: 30 iterations come back to six digits of the cost, not to the tolerance). Such a
start, told by its multipliers, is therefore first tried with the rows that hold it as equalities:
then the method is the SQP of Byrd and Omojokun without a barrier. Signs of multipliers and rows
left out are judged afterwards; if they do not hold, the interior point method goes on.
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.nlp import NLP, Array, Indices, Point, Solution, Start, Status, violations
from gaitopt.settings import checked
from gaitopt.solvers.adapters import ScaledProgram
from gaitopt.solvers.multipliers import least_squares_multipliers, one_sided
from gaitopt.solvers.solver import (
    Iterate,
    Recorder,
    SingleStage,
    is_unbounded,
    make_iterate,
    with_least_squares_multipliers,
)
from gaitopt.tolerances import FEASIBILITY, FEASIBLE, OPTIMALITY

if TYPE_CHECKING:
    from scipy.optimize import NonlinearConstraint


ROUNDS = 6
"""Times the method is started again, with rows it had not been given and then violated."""
APPROACH_ROUNDS = 12
APPROACH_ITERATIONS = 60
APPROACH_SCALE = (1.0, 3.0, 10.0)
APPROACH_BARRIER = 0.1
APPROACH_FALL = 10.0**-0.5
"""Rounds of a cold start: how many, how long, scale of the rows, barrier and its fall from the
third round on (measured on gaits, with all rows at scale 100 to 1000 none converged)."""
APPROACHED = 1e-4
"""Violation below which the end of such a round may be near a solution."""
HELD = 1e-4
"""Distance to its limit within which a row may hold a solution that is only near."""
CONFIRM = 20
"""Iterations to confirm a start that is a solution (measured: 2 to 5)."""
SHARPEN = 1e-2
"""Factor of the barrier parameter when a round ended before complementarity was small."""
NO_GRADIENT_TEST = 1e-300
"""SciPy's own test knows nothing of complementarity and would stop far from an active vertex;
ours, in the callback, takes its place."""
SHORTEST = 1e-12
"""Trust radius at which the method gives up, in units of the variables' scale."""


@checked
@dataclass(frozen=True)
class TrustConstr(SingleStage):
    """Interior point method of SciPy with exact Hessian: slow from afar, sure at the end.

    Attributes:
        tolerance: on the gradient of the Lagrangian and on complementarity.
        feasibility: on the largest violation of a row or bound.
        max_iterations: of all rounds together, those that only confirm included.
        rows_kept: rows given to the method, nearest to their limits first (measured: with all
            2000 an iteration takes 1 s, with 300 it takes 20 ms).
        row_scale: factor on rows and bounds, see the module's text (measured: 100 to 1000).
        initial_radius: of the trust region, in units of the variables' scale.
    """

    name: ClassVar[str] = "trust-constr"
    tolerance: float = OPTIMALITY
    feasibility: float = FEASIBILITY
    max_iterations: int = 1000
    rows_kept: int = 300
    row_scale: float = 300.0
    initial_radius: float = 1.0

    def _solved(self, recorder: Recorder, point: Point, start: Start) -> Solution:
        nlp = recorder.evaluator.nlp
        known = np.zeros(point.rows.size) if start.multipliers is None else start.multipliers
        working_set = nearest_rows(nlp, point, known, self.rows_kept)
        run = _Run(self, ScaledProgram(recorder.evaluator, point), recorder, working_set)
        status = run.solve(point.x, warm=start.multipliers is not None)
        if recorder.stopped and status is not Status.OPTIMAL:
            status = Status.INTERRUPTED
        return recorder.solution(status, recorder.answer(status, run.iterate))


class _Run:
    """The state of a run; `iterate` is always the last one judged."""

    def __init__(
        self,
        options: TrustConstr,
        program: ScaledProgram,
        recorder: Recorder,
        working_set: WorkingSet,
    ) -> None:
        """Begin at the point the program begins with."""
        self.options = options
        self.program = program
        self.recorder = recorder
        self.working_set = working_set
        self.barrier = APPROACH_BARRIER
        self.row_scale = options.row_scale
        nlp, point = program.nlp, program.first
        self.iterate = make_iterate(nlp, point, np.zeros(point.rows.size), np.zeros(point.x.size))

    def solve(self, x: Array, warm: bool) -> Status:
        """Run rounds until the answer is optimal over all rows, or nothing more helps."""
        u = x / self.program.scale
        if warm:
            point, tolerance = self.iterate.point, self.options.tolerance
            start = with_least_squares_multipliers(self.program.nlp, point, tolerance)
            held = start.multipliers, start.bound_multipliers
            if self._confirmed(u, held) or self._confirmed(u, self._near_limits()):
                return Status.OPTIMAL
        u = self._approach(u)
        return self._arrive(u)

    @property
    def _left(self) -> int:
        """Iterations that the run may still take: none when it was asked to stop."""
        if self.recorder.stopped:
            return 0
        return self.options.max_iterations - len(self.recorder.history)

    def _arrive(self, u: Array) -> Status:
        """Run rounds on growing sets of rows until the answer is optimal over all of them."""
        for _ in range(ROUNDS):
            if self._is_optimal(self.iterate):
                return Status.OPTIMAL
            if self._left <= 0:
                return Status.ITERATION_LIMIT
            u = self._minimise(u, self._left)
            self._polish()
            if self._is_optimal(self.iterate):
                return Status.OPTIMAL
            if is_unbounded(self.program.nlp, self.iterate):
                return Status.UNBOUNDED
            if not self._better_posed():
                break
        if self._left <= 0:
            return Status.ITERATION_LIMIT
        return Status.STALLED if self.iterate.violation <= FEASIBLE else Status.INFEASIBLE

    def _approach(self, u: Array) -> Array:
        """Come near a solution from afar: short rounds, rows chosen anew where each one ended.

        Every round starts with slacks of one, which is little next to rows barely scaled and
        keeps the method away from limits it may have to cross; then the scale grows and the
        barrier falls. A round that ends near a solution is confirmed as a warm start would be.
        """
        nlp = self.program.nlp
        none = np.zeros(nlp.rows.lower.size)
        for number in range(APPROACH_ROUNDS):
            if self._left <= 0:
                break
            nearest = nearest_rows(nlp, self.iterate.point, none, self.options.rows_kept).rows
            self.working_set = given_rows(nlp, np.union1d(self.working_set.rows, nearest))
            self.row_scale = APPROACH_SCALE[min(number, len(APPROACH_SCALE) - 1)]
            if number >= 2:
                self.barrier *= APPROACH_FALL
            u = self._minimise(u, APPROACH_ITERATIONS)
            self._polish()
            if self._is_optimal(self.iterate) or (
                self.iterate.violation <= APPROACHED and self._confirmed(u, self._near_limits())
            ):
                break
        self.row_scale = self.options.row_scale
        return u

    def _near_limits(self) -> tuple[Array, Array]:
        """Return multipliers of rows (m,) and bounds (n,) that may hold a solution near by."""
        return least_squares_multipliers(self.program.nlp, self.iterate.point, HELD)

    def _confirmed(self, u: Array, multipliers: tuple[Array, Array]) -> bool:
        """Try the rows that hold the start as equalities, the others left out.

        Then no slack and no barrier moves the iterate away from a start that is a solution. What
        was assumed is judged afterwards, over all rows: signs of multipliers, rows left out. If
        it does not hold, the iterate is again the one of the beginning.
        """
        if self._left <= 0:
            return False
        nlp, inequalities, kept = self.program.nlp, self.working_set, self.iterate
        self.working_set = working_set_of(nlp, *multipliers)
        self._minimise(u, CONFIRM)
        self.working_set = inequalities
        if self._is_optimal(self.iterate):
            return True
        self.iterate = kept
        return False

    def _better_posed(self) -> bool:
        """Add the rows missed, or sharpen the barrier; False when neither is of use."""
        nlp, point = self.program.nlp, self.iterate.point
        missed = missed_rows(nlp, point, self.working_set, self.options.feasibility)
        if missed.size:
            self.working_set = given_rows(nlp, np.union1d(self.working_set.rows, missed))
            return True
        self.barrier *= SHARPEN
        return self.iterate.residual.complementarity > self.options.tolerance

    def _minimise(self, u: Array, iterations: int) -> Array:
        """Run SciPy's method once from u, within what is left, and return where it stopped."""
        from scipy import optimize

        program, nlp = self.program, self.program.nlp
        options: Any = {
            "maxiter": min(iterations, self._left),
            "gtol": NO_GRADIENT_TEST,
            "xtol": SHORTEST,
            "barrier_tol": 0.1 * self.options.tolerance,
            "initial_tr_radius": self.options.initial_radius,
            "initial_barrier_parameter": self.barrier,
            "initial_barrier_tolerance": self.barrier,
        }
        if self.working_set.equalities:
            # They may depend on each other: over them SciPy's LU has BLAS write to the terminal.
            options["factorization_method"] = "SVDFactorization"
        constraints = self._constraints()
        hessian: Any = optimize.BFGS(exception_strategy="damp_update")
        if nlp.has_hessian:
            hessian = self._cost_hessian if not constraints else _with_the_rows
        with warnings.catch_warnings():
            # SciPy warns of singular Jacobians and of gradients that do not change.
            warnings.simplefilter("ignore", UserWarning)
            # The published types admit neither our arrays nor our callbacks.
            minimise: Any = optimize.minimize
            result = minimise(
                program.cost,
                u,
                jac=program.gradient,
                hess=hessian,
                method="trust-constr",
                constraints=constraints,
                callback=self._callback,
                options=options,
            )
        return np.asarray(result.x)

    def _constraints(self) -> list[NonlinearConstraint]:
        """Return the chosen rows and the bounds, in this order, multiplied by the row scale."""
        from scipy.optimize import BFGS, NonlinearConstraint
        from scipy.sparse import csr_array

        program, nlp = self.program, self.program.nlp
        rows, bounds = self.working_set.rows, self.working_set.bounds
        if rows.size + bounds.size == 0:
            return []
        factor, m = self.row_scale, nlp.rows.lower.size
        unit = np.eye(program.scale.size)[bounds]
        bound_limits = self.working_set.bound_limits / program.scale[bounds]
        lower, upper = factor * np.hstack([self.working_set.row_limits, bound_limits])

        def weighed(u: Array, v: Array) -> Array:
            multipliers = np.zeros(m)
            multipliers[rows] = factor * v[: rows.size]
            return program.hessian(u, multipliers, program.nlp.cost_scale)

        def slopes(u: Array) -> Any:
            J = factor * np.vstack([program.jacobian(u)[rows], unit])
            return J if self.working_set.equalities else csr_array(J)  # slacks make it sparse

        # The published type of `hess` lacks its second argument.
        hessian: Any = weighed if nlp.has_hessian else BFGS(exception_strategy="damp_update")
        return [
            NonlinearConstraint(
                lambda u: factor * np.append(program.rows(u)[rows], u[bounds]),
                lower,
                upper,
                jac=slopes,
                hess=hessian,
            )
        ]

    def _cost_hessian(self, u: Array) -> Array:
        nlp = self.program.nlp
        return self.program.hessian(u, np.zeros(nlp.rows.lower.size), nlp.cost_scale)

    def _callback(self, u: Array, state: Any) -> bool:
        """Judge SciPy's iterate over all rows; stop when it is optimal."""
        nlp, k = self.program.nlp, self.working_set.rows.size
        multipliers = np.zeros(nlp.rows.lower.size)
        bound_multipliers = np.zeros(u.size)
        if state.v:
            v = self.row_scale * np.asarray(state.v[0])
            multipliers[self.working_set.rows] = v[:k]
            bound_multipliers[self.working_set.bounds] = v[k:]
        self.iterate = make_iterate(
            nlp,
            self.program.point(u),
            one_sided(multipliers, nlp.rows.lower, nlp.rows.upper),
            one_sided(
                bound_multipliers / self.program.scale, nlp.variables.lower, nlp.variables.upper
            ),
        )
        self.recorder.record(self.iterate, float(state.tr_radius))
        # The start's own optimality is no news: at least one step must confirm it.
        done = state.nit > 1 and self._is_optimal(self.iterate)
        return done or self.recorder.stopped or is_unbounded(nlp, self.iterate)

    def _polish(self) -> None:
        """Take least-squares multipliers if they satisfy the conditions better."""
        iterate = with_least_squares_multipliers(
            self.program.nlp, self.iterate.point, self.options.tolerance
        )
        if iterate.residual.worst < self.iterate.residual.worst:
            self.iterate = iterate
            self.recorder.keep(iterate)

    def _is_optimal(self, iterate: Iterate) -> bool:
        return iterate.is_optimal(self.options.tolerance, self.options.feasibility)


def _with_the_rows(u: Array) -> Array:
    """Return no curvature: that of the cost comes with that of the rows, in one evaluation."""
    return np.zeros((u.size, u.size))


@dataclass(frozen=True)
class WorkingSet:
    """Rows and bounds given to a method.

    Attributes:
        rows: indices of rows, ascending.
        bounds: indices of variables with a finite bound, ascending.
        row_limits, bound_limits: lower and upper limits of them, shape (2, k).
    """

    rows: Indices
    bounds: Indices
    row_limits: Array
    bound_limits: Array

    @property
    def equalities(self) -> bool:
        """Whether there are rows or bounds, and all are held at one value."""
        lower, upper = np.hstack([self.row_limits, self.bound_limits])
        return lower.size > 0 and np.array_equal(lower, upper)


def nearest_rows(nlp: NLP, point: Point, multipliers: Array, count: int) -> WorkingSet:
    """Choose the rows nearest to a limit, and all that are equalities or carry a multiplier.

    Args:
        point: where the distances are measured: margin over the 1-norm of the row's gradient,
            which is how far the variables must move, in units of their scale.
        multipliers: of the rows, shape (m,), zero where unknown.
        count: how many rows to choose at least, if there are as many.
    """
    lower, upper = nlp.rows.lower, nlp.rows.upper
    margin = np.minimum(upper - point.rows, point.rows - lower)
    reach = np.abs(point.jacobian * nlp.variables.scale).sum(axis=1)
    distance = margin / np.maximum(reach, 1e-12)
    distance[(lower == upper) | (multipliers != 0.0)] = -np.inf
    needed = int(np.isneginf(distance).sum())
    nearest = np.argsort(distance, kind="stable")[: max(count, needed)]
    rows = np.sort(nearest[np.isfinite(margin[nearest])])
    return given_rows(nlp, rows)


def given_rows(nlp: NLP, rows: Indices) -> WorkingSet:
    """Choose these rows, with their own limits, and all bounds."""
    finite = np.isfinite(nlp.variables.lower) | np.isfinite(nlp.variables.upper)
    bounds = np.flatnonzero(finite)
    return WorkingSet(
        rows,
        bounds,
        np.stack([nlp.rows.lower[rows], nlp.rows.upper[rows]]),
        np.stack([nlp.variables.lower[bounds], nlp.variables.upper[bounds]]),
    )


def working_set_of(nlp: NLP, multipliers: Array, bound_multipliers: Array) -> WorkingSet:
    """Choose rows and bounds with a multiplier (m,), (n,), as equalities at the limit it tells."""
    rows = np.flatnonzero((multipliers != 0.0) | (nlp.rows.lower == nlp.rows.upper))
    bounds = np.flatnonzero(bound_multipliers)
    at_row = np.where(multipliers > 0.0, nlp.rows.upper, nlp.rows.lower)[rows]
    variables = nlp.variables
    at_bound = np.where(bound_multipliers > 0.0, variables.upper, variables.lower)[bounds]
    return WorkingSet(rows, bounds, np.stack([at_row, at_row]), np.stack([at_bound, at_bound]))


def missed_rows(nlp: NLP, point: Point, working_set: WorkingSet, tolerance: float) -> Indices:
    """Return the indices of violated rows that are not in the working set."""
    excess = violations(nlp.rows.lower, nlp.rows.upper, point.rows)
    return np.setdiff1d(np.flatnonzero(excess > tolerance), working_set.rows)
