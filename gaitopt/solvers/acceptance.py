"""Whether a trial point becomes the iterate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitopt.nlp import NLP, Values, worst_violation
from gaitopt.solvers.elastic import ElasticStep
from gaitopt.solvers.filter import Filter, improves
from gaitopt.solvers.model import LocalModel
from gaitopt.solvers.recorder import Iterate
from gaitopt.solvers.trust_region import GOOD, POOR, ROUNDING, agreement

WEIGHT = 1.2
"""Weight of the violation in the agreement ratio, over the sum of the multipliers (measured);
above one the merit is exact (Nocedal & Wright, 2006, Theorem 17.3)."""
SUFFICIENT = 1e-2
"""Share of the predicted fall of the cost that must come true (Fletcher, Leyffer & Toint)."""
SWITCH = 1e-4
"""A step predicted to lower the cost by more than SWITCH * violation^2 is taken for the cost
(Fletcher, Leyffer & Toint, 2002) ..."""
NEGLIGIBLE = 1e-8
"""... provided that its subproblem was compatible: no more slack than this was left."""
STRAY = 0.03
"""Violation, in scaled rows, beyond which a trial that keeps less than was predicted does not
widen the trust region (measured: 0.01 to 0.1 do equally well)."""


@dataclass(frozen=True)
class Trial:
    """A point tried.

    Attributes:
        step: the step that led there.
        values: cost and rows there.
        violation: largest violation there.
        ratio: actual over predicted decrease of cost + weight * violation.
        fit: the same if every row had changed as its linearisation says and the cost as the
            Lagrangian tells. The curvature of the rows that hold is in the model's Hessian, so
            that it does not speak against the model, as it does in `ratio` (with multipliers of
            several hundred a violation of 1e-3 outweighs the cost).
        for_cost: whether the step was for the sake of the cost, and the cost fell.
        failed_cost: whether it was, and the cost did not fall enough.
        rounding: rounding error of the scaled cost and of the weighed violation.
    """

    step: ElasticStep
    values: Values
    violation: float
    ratio: float
    fit: float
    for_cost: bool
    failed_cost: bool
    rounding: float

    @property
    def strays(self) -> bool:
        """Whether it is farther from the rows than was predicted, and far."""
        return self.violation > STRAY and self.ratio <= GOOD


def judge(
    nlp: NLP,
    iterate: Iterate,
    model: LocalModel,
    step: ElasticStep,
    judged: ElasticStep,
    values: Values,
) -> Trial:
    """Compare a trial with the prediction of the step `judged`.

    Args:
        nlp: the program.
        iterate: where the step began.
        model: the local model there.
        step: the step tried.
        judged: the step whose prediction counts; a correction is held to that of its original.
        values: at the trial point.
    """
    violation, _ = worst_violation(nlp, values)
    weight = WEIGHT * float(np.abs(judged.multipliers).sum())
    old_cost = nlp.cost_scale * iterate.point.cost
    fall = old_cost - nlp.cost_scale * values.cost
    rounding = ROUNDING * max(1.0, abs(old_cost), weight)
    predicted = model.predicted_decrease(judged.d)
    for_cost = judged.slack <= NEGLIGIBLE and predicted > SWITCH * iterate.violation**2
    fell = fall >= SUFFICIENT * predicted - rounding
    curved = values.rows - iterate.point.rows - model.jacobian @ judged.d
    surprise = fall - predicted - float(judged.multipliers @ curved)
    promised = predicted + weight * (iterate.violation - judged.slack)
    kept = fall + weight * (iterate.violation - violation)
    return Trial(
        step=step,
        values=values,
        violation=violation,
        ratio=agreement(kept, promised, rounding),
        fit=agreement(promised + surprise, promised, rounding),
        for_cost=for_cost and fell,
        failed_cost=for_cost and not fell,
        rounding=rounding,
    )


def accepts(trial: Trial, iterate: Iterate, cost_scale: float, entries: Filter) -> bool:
    """Return whether the filter, the iterate and the prediction let a trial pass.

    A step for the cost whose cost did not fall may still pass for its violation, if both
    together agree with the prediction: with large multipliers the predicted fall, that of the
    Lagrangian, says little of the cost alone.
    """
    cost, old_cost = cost_scale * trial.values.cost, cost_scale * iterate.point.cost
    return (
        entries.accepts(trial.violation, cost)
        and improves(trial.violation, cost, iterate.violation, old_cost, trial.rounding)
        and not (trial.failed_cost and trial.ratio < POOR)
    )
