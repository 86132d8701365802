"""Sequential quadratic programming with a filter and a trust region, in scaled variables.

Each iteration solves a convex quadratic program for a step d within a cube (`elastic`,
`convexify`), tries it, corrects it for the curvature of the rows if it disappoints
(`model.pose_correction`), and accepts it when it betters cost or violation against a filter
(`filter`). The agreement of model and function drives the size of the cube (`trust_region`).

Sources: Nocedal & Wright, "Numerical Optimization" (2006), chapter 18; Fletcher & Leyffer,
Mathematical Programming 91 (2002); Conn, Gould & Toint, "Trust-Region Methods" (2000).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from gaitopt.nlp import NLP, ProgressCallback, Solution, Start, Status, StopCallback
from gaitopt.settings import setting
from gaitopt.solvers.multipliers import one_sided
from gaitopt.solvers.qp import BACKENDS
from gaitopt.solvers.recorder import begin, make_iterate
from gaitopt.solvers.solver import Solver, require_choice, require_positive
from gaitopt.solvers.sqp_run import SQPRun
from gaitopt.tolerances import FEASIBILITY, FEASIBLE, OPTIMALITY


@dataclass(frozen=True)
class SQP(Solver):
    """Filter trust-region SQP: the fast traveller.

    Attributes:
        tolerance: on the gradient of the Lagrangian and on complementarity.
        feasibility: on the largest violation of a row or bound.
        max_iterations: subproblems tried, rejected ones included.
        hessian: "exact", or "bfgs" to learn curvature from gradients; a program without second
            derivatives always gets the latter.
        qp_solver: quadratic solver asked first, one of `qp.BACKENDS`.
        initial_radius, max_radius: of the trust region, in units of the variables' scale
            (measured: 0.07 to 0.15 and 2 to 5 do equally well).
        min_radius: a smaller trust region ends the run.
        penalty: weight of the slack at the beginning. In the end it must exceed the sum of the
            multipliers, and is raised by itself when it proves too small (measured: begun with
            that sum or less, more starts lead to an optimum than with several times as much) ...
        max_penalty: ... but not beyond this; only then is a program called infeasible.
    """

    name: ClassVar[str] = "sqp"
    tolerance: float = field(default=OPTIMALITY, metadata=setting("Of the optimality conditions."))
    feasibility: float = FEASIBILITY
    max_iterations: int = field(default=300, metadata=setting("Of one run of the solver."))
    hessian: str = "exact"
    qp_solver: str = field(
        default="daqp",
        metadata=setting("Quadratic solver of the SQP.", choices=tuple(BACKENDS), metavar="NAME"),
    )
    initial_radius: float = 0.1
    max_radius: float = 2.0
    min_radius: float = 1e-10
    penalty: float = 200.0
    max_penalty: float = 1e6

    def __post_init__(self) -> None:
        """Check the options.

        Raises:
            InputError: an option cannot be used.
        """
        require_choice(self.name, "hessian", self.hessian, ("exact", "bfgs"))
        require_choice(self.name, "qp_solver", self.qp_solver, BACKENDS)
        require_positive(
            self.name,
            tolerance=self.tolerance,
            feasibility=self.feasibility,
            max_iterations=self.max_iterations,
            initial_radius=self.initial_radius,
            max_radius=self.max_radius,
            min_radius=self.min_radius,
            penalty=self.penalty,
            max_penalty=self.max_penalty,
        )

    def solve(
        self,
        nlp: NLP,
        start: Start,
        on_progress: ProgressCallback | None = None,
        stop: StopCallback | None = None,
    ) -> Solution:
        """Solve the program; see `Solver.solve`."""
        recorder, point = begin(self.name, nlp, start, on_progress, stop)
        if point is None:
            return recorder.failure(start.x)
        multipliers = np.zeros(nlp.rows.lower.size)
        if start.multipliers is not None:
            multipliers = one_sided(start.multipliers, nlp.rows.lower, nlp.rows.upper)
        first = make_iterate(nlp, point, multipliers, np.zeros(point.x.size))
        run = SQPRun(self, nlp, recorder, first)
        status = run.iterate_until_verdict()
        best = recorder.answer(status, run.iterate)
        if status is Status.INFEASIBLE and best.violation <= FEASIBLE:
            status = Status.STALLED  # it went astray from a feasible iterate
        return recorder.solution(status, best)

    def limited(self, iterations: int) -> SQP:
        """Return the solver with at most so many iterations."""
        return replace(self, max_iterations=min(self.max_iterations, iterations))
