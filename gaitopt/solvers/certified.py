"""One solver travels, another arrives and signs.

The SQP method reaches the solution in few evaluations; the interior point method, which takes
another road to it, then starts from there. That it agrees is worth more than either word alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar

from gaitopt.nlp import NLP, Progress, ProgressCallback, Solution, Start, Status, kkt_residual
from gaitopt.solvers.sqp import SQP
from gaitopt.solvers.trust_constr import TrustConstr

CERTIFIER = TrustConstr(max_iterations=60)
"""The interior point method for starts that are nearly solutions (measured)."""
AGREEMENT = 1e-4
"""Largest difference of the two answers' scaled costs, relative to one or to the cost if larger:
an interior point stays off each active limit by its complementarity tolerance."""
NOT_WORTH = (Status.INFEASIBLE, Status.NUMERICAL, Status.INTERRUPTED)
"""Ends of the journey after which there is nothing to sign."""
UNCONFIRMED = "sqp (not confirmed by trust-constr)"


@dataclass(frozen=True)
class CertifiedSQP:
    """SQP followed by trust-constr from its answer; the default.

    The answer is that of the stage with the smaller KKT residual. `Solution.solver` is
    "sqp+trust-constr" when the second stage confirmed the first, else "sqp (not confirmed by
    trust-constr)" or "trust-constr (after sqp)", after the stage whose answer it is.
    `Solution.history` is that of both stages.

    Attributes:
        travel: the solver that goes first.
        certify: the solver that starts from its answer.
    """

    name: ClassVar[str] = "sqp+trust-constr"
    travel: SQP = field(default_factory=SQP)
    certify: TrustConstr = CERTIFIER

    def solve(
        self, nlp: NLP, start: Start, on_progress: ProgressCallback | None = None
    ) -> Solution:
        """Solve the program; see `Solver.solve`."""
        return self.confirm(nlp, self.travel.solve(nlp, start, on_progress), on_progress)

    def confirm(
        self, nlp: NLP, first: Solution, on_progress: ProgressCallback | None = None
    ) -> Solution:
        """Run the second stage from an answer of the first.

        Args:
            nlp: the program.
            first: what `travel` found.
            on_progress: called for every iteration of the second stage.
        """
        if first.status in NOT_WORTH:
            return replace(first, solver=UNCONFIRMED)
        second = self.certify.solve(
            nlp,
            Start(first.x, first.multipliers),
            None if on_progress is None else lambda record: on_progress(_after(first, record)),
        )
        return _joined(nlp, first, second, self.travel.tolerance)


def _after(first: Solution, record: Progress) -> Progress:
    """Count a record of the second stage on from the first."""
    return replace(
        record,
        iteration=record.iteration + len(first.history),
        seconds=record.seconds + first.seconds,
        evaluations=record.evaluations + first.evaluations,
    )


def _joined(nlp: NLP, first: Solution, second: Solution, tolerance: float) -> Solution:
    """Keep the better answer, with the work of both."""
    best = first if _error(nlp, first) <= _error(nlp, second) else second
    status = best.status
    if _error(nlp, best) <= tolerance:
        status = Status.OPTIMAL  # whatever the stage did after it
    elif Status.INTERRUPTED in (first.status, second.status):
        status = Status.INTERRUPTED
    return replace(
        best,
        status=status,
        iterations=first.iterations + second.iterations,
        evaluations=first.evaluations + second.evaluations,
        hessians=first.hessians + second.hessians,
        seconds=first.seconds + second.seconds,
        solver=_signature(nlp, first, second, best),
        history=first.history + tuple(_after(first, record) for record in second.history),
    )


def _signature(nlp: NLP, first: Solution, second: Solution, best: Solution) -> str:
    """Tell which stage's answer it is, and whether the other one agrees."""
    difference = nlp.cost_scale * abs(first.cost - second.cost)
    agree = difference <= AGREEMENT * max(1.0, nlp.cost_scale * abs(first.cost))
    if agree and second.status is Status.OPTIMAL:
        return CertifiedSQP.name
    return UNCONFIRMED if best is first else "trust-constr (after sqp)"


def _error(nlp: NLP, solution: Solution) -> float:
    """Return the largest KKT residual of a solution, from its definition."""
    point = nlp.point(solution.x)
    return kkt_residual(nlp, point, solution.multipliers, solution.bound_multipliers).worst
