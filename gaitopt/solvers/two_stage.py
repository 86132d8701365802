"""One solver travels, another arrives and signs.

The SQP method reaches the solution in few evaluations; the interior point method, which takes
another road to it, then starts from there. That it agrees is worth more than either word alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar

from gaitopt.nlp import (
    NLP,
    Progress,
    ProgressCallback,
    Residual,
    Solution,
    Start,
    Status,
    StopCallback,
    kkt_residual,
)
from gaitopt.settings import checked
from gaitopt.solvers.solver import Solver
from gaitopt.solvers.sqp import SQP
from gaitopt.solvers.trust_constr import TrustConstr
from gaitopt.tolerances import AGREEMENT

CONFIRMING_SOLVER = TrustConstr(max_iterations=60)
"""The interior point method for starts that are nearly solutions (measured)."""
NOT_WORTH = (Status.UNBOUNDED, Status.INFEASIBLE, Status.NUMERICAL, Status.INTERRUPTED)
"""Ends of the journey after which there is nothing to sign."""
UNCONFIRMED = "sqp (not confirmed by trust-constr)"


@checked
@dataclass(frozen=True)
class TwoStageSQP(Solver):
    """SQP followed by trust-constr from its answer; the default.

    The answer is that of the stage with the smaller KKT residual. `Solution.solver` is
    "sqp+trust-constr" when the second stage confirmed the first, else "sqp (not confirmed by
    trust-constr)" or "trust-constr (after sqp)", after the stage whose answer it is.
    `Solution.history` is that of both stages.

    Attributes:
        first: the solver that goes first.
        second: the solver that starts from its answer.
    """

    name: ClassVar[str] = "sqp+trust-constr"
    first: SQP = field(default_factory=SQP)
    second: TrustConstr = CONFIRMING_SOLVER

    def solve(
        self,
        nlp: NLP,
        start: Start,
        on_progress: ProgressCallback | None = None,
        stop: StopCallback | None = None,
    ) -> Solution:
        """Solve the program; see `Solver.solve`."""
        first = self.first.solve(nlp, start, on_progress, stop)
        return self.confirm(nlp, first, on_progress, stop)

    def confirm(
        self,
        nlp: NLP,
        first: Solution,
        on_progress: ProgressCallback | None = None,
        stop: StopCallback | None = None,
    ) -> Solution:
        """Run the second stage from an answer of the first.

        Args:
            nlp: the program.
            first: what `first` found.
            on_progress: called for every iteration of the second stage.
            stop: asked after every iteration of it.
        """
        if first.status in NOT_WORTH:
            return replace(first, solver=UNCONFIRMED)
        second = self.second.solve(
            nlp,
            Start(first.x, first.multipliers),
            None if on_progress is None else lambda record: on_progress(_after(first, record)),
            stop,
        )
        return self._joined(nlp, first, second)

    @property
    def first_stage(self) -> SQP:
        """The solver that goes first."""
        return self.first

    def limited(self, iterations: int, tolerance: float = 0.0) -> TwoStageSQP:
        """Return the solver with at most so many iterations of its first stage."""
        return replace(self, first=self.first.limited(iterations, tolerance))

    def near_solution(self) -> TwoStageSQP:
        """Return the solver with a first stage for starts that are nearly solutions."""
        return replace(self, first=self.first.near_solution())

    def _is_optimal(self, nlp: NLP, solution: Solution) -> bool:
        """Whether an answer satisfies, judged anew, what both stages ask of theirs."""
        residual = _residual(nlp, solution)
        return residual.optimality <= min(
            self.first.tolerance, self.second.tolerance
        ) and residual.feasibility <= min(self.first.feasibility, self.second.feasibility)

    def _joined(self, nlp: NLP, first: Solution, second: Solution) -> Solution:
        """Keep the better answer, with the work of both."""
        best = min((first, second), key=lambda one: self._rank(nlp, one))
        status = best.status
        if self._is_optimal(nlp, best):
            status = Status.OPTIMAL  # whatever the stage did after it
        elif Status.INTERRUPTED in (first.status, second.status):
            status = Status.INTERRUPTED
        elif status is Status.OPTIMAL:
            status = Status.STALLED
        return replace(
            best,
            status=status,
            iterations=first.iterations + second.iterations,
            evaluations=first.evaluations + second.evaluations,
            hessians=first.hessians + second.hessians,
            seconds=first.seconds + second.seconds,
            solver=self._signature(nlp, first, second, best),
            history=first.history + tuple(_after(first, record) for record in second.history),
        )

    def _rank(self, nlp: NLP, solution: Solution) -> tuple[bool, float]:
        """Order answers: optimal ones first, then by their KKT residual."""
        return not self._is_optimal(nlp, solution), _residual(nlp, solution).worst

    def _signature(self, nlp: NLP, first: Solution, second: Solution, best: Solution) -> str:
        """Tell which stage's answer it is, and whether the other one agrees."""
        difference = nlp.cost_scale * abs(first.cost - second.cost)
        agree = difference <= AGREEMENT * max(1.0, nlp.cost_scale * abs(first.cost))
        if agree and all(self._is_optimal(nlp, one) for one in (second, best)):
            return TwoStageSQP.name
        return UNCONFIRMED if best is first else "trust-constr (after sqp)"


def _after(first: Solution, record: Progress) -> Progress:
    """Count a record of the second stage on from the first."""
    return replace(
        record,
        iteration=record.iteration + len(first.history),
        seconds=record.seconds + first.seconds,
        evaluations=record.evaluations + first.evaluations,
    )


def _residual(nlp: NLP, solution: Solution) -> Residual:
    """Return the KKT residual of a solution, from its definition."""
    point = nlp.point(solution.x)
    return kkt_residual(nlp, point, solution.multipliers, solution.bound_multipliers)
