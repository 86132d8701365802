"""One solver travels, another arrives and signs.

The SQP method reaches the solution in few evaluations; another method, which takes another road to
it, then starts from there. That it agrees is worth more than either word alone. The other method is
Newton's, or SciPy's interior point method where it is asked for or Newton's does not agree
(docs/decisions/confirmation.md).
"""

from __future__ import annotations

from dataclasses import field, replace
from typing import ClassVar

from gaitopt.dataclass import dataclass
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
from gaitopt.solvers.newton import Newton
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
    """SQP followed by trust-constr from its answer.

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
        first = self.first.solve(nlp, start, on_progress, stop)
        return self.confirm(nlp, first, on_progress, stop)

    def confirm(
        self,
        nlp: NLP,
        first: Solution,
        on_progress: ProgressCallback | None = None,
        stop: StopCallback | None = None,
    ) -> Solution:
        if first.status in NOT_WORTH:
            return replace(first, solver=UNCONFIRMED)
        judged = _residual(nlp, first)
        second = self.second.solve(
            nlp,
            Start(first.x, first.multipliers),
            None if on_progress is None else lambda record: on_progress(_after(first, record)),
            stop,
        )
        return self._joined(nlp, (first, judged), second, TwoStageSQP.name)

    @property
    def first_stage(self) -> SQP:
        return self.first

    def limited(self, iterations: int) -> TwoStageSQP:
        return replace(self, first=self.first.limited(iterations))

    def near_solution(self) -> TwoStageSQP:
        return replace(self, first=self.first.near_solution())

    def roughly(self) -> TwoStageSQP:
        return replace(self, first=self.first.roughly())

    def _is_optimal(self, residual: Residual) -> bool:
        """Whether an answer, judged anew, satisfies what both stages ask of theirs."""
        return residual.optimality <= min(
            self.first.tolerance, self.second.tolerance
        ) and residual.feasibility <= min(self.first.feasibility, self.second.feasibility)

    def _joined(
        self, nlp: NLP, before: tuple[Solution, Residual], second: Solution, name: str
    ) -> Solution:
        """Keep the better answer, with the work of both.

        Args:
            before: answer of the first stage, judged before the second began: a program keeps its
                last point, which is then still that answer's, and now is the second's.
            second: answer of the second stage.
            name: of the solver if the second confirms the first.
        """
        first = before[0]
        judged = [before, (second, _residual(nlp, second))]
        optimal = [self._is_optimal(residual) for _, residual in judged]
        kept = min((0, 1), key=lambda one: (not optimal[one], judged[one][1].worst))
        best = judged[kept][0]
        status = best.status
        if optimal[kept]:
            status = Status.OPTIMAL  # whatever the stage did after it
        elif Status.INTERRUPTED in (first.status, second.status):
            status = Status.INTERRUPTED
        elif status is Status.OPTIMAL:
            status = Status.STALLED
        difference = nlp.cost_scale * abs(first.cost - second.cost)
        agree = difference <= AGREEMENT * max(1.0, nlp.cost_scale * abs(first.cost))
        if not (agree and optimal[1] and optimal[kept]):
            name = UNCONFIRMED if best is first else "trust-constr (after sqp)"
        return replace(
            best,
            status=status,
            iterations=first.iterations + second.iterations,
            evaluations=first.evaluations + second.evaluations,
            hessians=first.hessians + second.hessians,
            seconds=first.seconds + second.seconds,
            solver=name,
            history=first.history + tuple(_after(first, record) for record in second.history),
        )


@checked
@dataclass(frozen=True)
class ConfirmedSQP(TwoStageSQP):
    """SQP, confirmed by Newton's method, or else by trust-constr; the default.

    `Solution.solver` is "sqp+newton" where Newton's method took a step from the answer of the
    first, optimal or not, and found the same cost and the conditions satisfied; else it is what
    `TwoStageSQP` says.
    """

    name: ClassVar[str] = "sqp+newton"

    def confirm(
        self,
        nlp: NLP,
        first: Solution,
        on_progress: ProgressCallback | None = None,
        stop: StopCallback | None = None,
    ) -> Solution:
        if first.status in NOT_WORTH:
            return super().confirm(nlp, first, on_progress, stop)
        newton = Newton(
            tolerance=min(self.first.tolerance, self.second.tolerance),
            feasibility=min(self.first.feasibility, self.second.feasibility),
        )
        told: list[Progress] = []
        judged = _residual(nlp, first)
        second = newton.solve(nlp, Start(first.x), told.append, stop)
        if second.status is Status.INTERRUPTED:
            return replace(first, solver=UNCONFIRMED)
        joined = self._joined(nlp, (first, judged), second, ConfirmedSQP.name)
        if second.status is not Status.OPTIMAL or joined.solver != ConfirmedSQP.name:
            return super().confirm(nlp, first, on_progress, stop)
        if on_progress is not None:
            for record in told:
                on_progress(_after(first, record))
        return joined


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
