"""SciPy's trust-region interior point method, alone or to certify another solver's answer.

R. Byrd, M. Hribar, J. Nocedal, "An interior point algorithm for large-scale nonlinear
programming", SIAM J. Optim. 9 (1999), as scipy.optimize.minimize(method="trust-constr").
Its cost grows with the rows, so that it is given only those nearest to their limits; it starts
every inequality with a slack of at least one, so that rows are multiplied by a large number lest
a good start be thrown away. Even so the barrier leads away from a start that is a solution
(measured: 30 iterations come back to six digits of the cost, not to the tolerance). Such a start,
told by its multipliers, is therefore first tried with the rows that hold it as equalities: then
the method is the SQP of Byrd and Omojokun without a barrier. Signs of multipliers and rows left
out are judged afterwards; if they do not hold, the interior point method goes on.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import ClassVar

import numpy as np

from gaitopt.nlp import NLP, ProgressCallback, Solution, Start, Status, StopCallback
from gaitopt.solvers.recorder import begin
from gaitopt.solvers.row_choice import choose_rows
from gaitopt.solvers.scaled_program import ScaledProgram
from gaitopt.solvers.solver import Solver, require_positive
from gaitopt.tolerances import FEASIBILITY, OPTIMALITY


@dataclass(frozen=True)
class TrustConstr(Solver):
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

    def __post_init__(self) -> None:
        """Check the options.

        Raises:
            InputError: an option cannot be used.
        """
        require_positive(self.name, **asdict(self))

    def solve(
        self,
        nlp: NLP,
        start: Start,
        on_progress: ProgressCallback | None = None,
        stop: StopCallback | None = None,
    ) -> Solution:
        """Solve the program; see `Solver.solve`."""
        from gaitopt.solvers.trust_constr_run import TrustConstrRun

        recorder, point = begin(self.name, nlp, start, on_progress, stop)
        if point is None:
            return recorder.failure(start.x)
        multipliers = start.multipliers
        if multipliers is None:
            multipliers = np.zeros(point.rows.size)
        choice = choose_rows(nlp, point, multipliers, self.rows_kept)
        run = TrustConstrRun(self, ScaledProgram(recorder.evaluator, point), recorder, choice)
        status = run.solve(point.x, warm=start.multipliers is not None)
        if recorder.stopped and status is not Status.OPTIMAL:
            status = Status.INTERRUPTED
        return recorder.solution(status, recorder.answer(status, run.iterate))
