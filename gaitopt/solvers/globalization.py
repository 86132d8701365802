"""Globalisation of the SQP method: trust region, filter, corrections, penalty, when to give up.

A trial point becomes the iterate where it betters cost or violation of the iterate and of every
entry of a filter (R. Fletcher, S. Leyffer, "Nonlinear programming without a penalty function",
Mathematical Programming 91, 2002; the rules are those of R. Fletcher, S. Leyffer, Ph. Toint, "On
the global convergence of a filter-SQP algorithm", SIAM J. Optim. 13, 2002). The agreement of model
and function drives the trust region (J. Nocedal, S. Wright, "Numerical Optimization", 2006,
Algorithm 4.1; A. Conn, N. Gould, Ph. Toint, "Trust-Region Methods", 2000).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.nlp import NLP, Values, worst_violation
from gaitopt.solvers.multipliers import least_squares_multipliers
from gaitopt.solvers.solver import Iterate
from gaitopt.solvers.subproblem import ElasticStep, QuadraticModel

POOR, GOOD = 0.25, 0.75
"""Agreement ratios below which the radius shrinks, and above which it grows if the step was held
by it (Nocedal & Wright, Algorithm 4.1)."""
SHRINK, GROW = 0.25, 2.0
"""Factors of the step's length and of the radius then (same algorithm)."""
INTERIOR = 0.99
"""A step shorter than this share of the radius is not held by the trust region."""
ROUNDING = 1e-12
"""Relative rounding error of cost and rows (measured; used as in Conn, Gould & Toint, 17.4.2)."""
MERIT_WEIGHT = 1.2
"""Weight of the violation in the agreement ratio, over the sum of the multipliers (measured);
above one the merit is exact (Nocedal & Wright, Theorem 17.3)."""
SUFFICIENT = 1e-2
"""Share of the predicted fall of the cost that must come true (Fletcher, Leyffer & Toint)."""
SWITCH = 1e-4
"""A step predicted to lower the cost by more than SWITCH * violation² is taken for the cost
(Fletcher, Leyffer & Toint), ..."""
NEGLIGIBLE_SLACK = 1e-8
"""... provided that its subproblem was compatible: no more slack than this was left."""
LARGE_VIOLATION = 0.03
"""Violation, in scaled rows, beyond which a trial that keeps less than was predicted does not
widen the trust region (measured: 0.01 to 0.1 do equally well). A run that begins with more, and
with multipliers, widens by `fit` alone: that saves a sixth of its Hessians (measured)."""
MARGIN = 1e-5
"""gamma, beta: relative betterment asked of a filter entry (Fletcher & Leyffer, section 2.4)."""
CEILING = 10.0
"""Largest violation the filter ever lets in, in scaled rows, unless the start is worse
(Fletcher & Leyffer use 100 for rows that are not scaled)."""
FILTER_RESETS = 5
"""Times the filter may be emptied when it alone blocks progress (Waechter & Biegler, 2006)."""
CORRECTIONS = 2
"""Second-order corrections of a step that is not accepted (measured: the second saves long runs a
third of their iterations along curved rows, a third saves nothing), ..."""
CORRECT_UNTIL = 0.75
"""... until cost and violation are as good as predicted, to this share, ..."""
CORRECT_GAIN = 0.1
"""... or the violation did not fall to this share."""
STEERED = 0.1
"""Share of the violation that a step may leave without the penalty being raised (R. Byrd,
J. Nocedal, R. Waltz, "Steering exact penalty methods for nonlinear programming", 2008) ..."""
RAISE = 10.0
"""... by this factor (Nocedal & Wright, Algorithm 18.5)."""
EXCESS = 1.5
"""Penalty to begin with over the sum of the multipliers, if these are known, ..."""
NEAR_START = 0.1
"""... or can be estimated, since the violation of the start, in scaled rows, is below this."""
NEARLY_FEASIBLE = 1e-3
"""A least violation below this, in scaled rows, is near enough to go on (measured)."""
STALLED_AFTER, STALLED_AFTER_BFGS = 40, 200
"""Iterations without less violation after which a program is called infeasible, with exact
Hessian and while learning it (measured: feasible walks take up to 16, and up to 60)."""
LASTING_DECREASE = 0.9
"""Share to which the least violation has to fall to count as less."""


@dataclass(frozen=True)
class TrustRegion:
    """A box around the iterate, in units of the variables' scale.

    Attributes:
        radius: half edge of the box.
        largest: the radius never exceeds it.
    """

    radius: float
    largest: float

    def holds(self, length: float) -> bool:
        """Return whether a step of infinity norm `length` would go on but for the region."""
        return length >= INTERIOR * self.radius

    def after(self, ratio: float, length: float, may_grow: bool = True) -> TrustRegion:
        """Return the region after an accepted step of infinity norm `length`."""
        if ratio < POOR:
            return self.shrunk(length)
        if may_grow and ratio > GOOD and self.holds(length):
            return TrustRegion(min(self.largest, GROW * self.radius), self.largest)
        return self

    def shrunk(self, length: float, share: float = SHRINK) -> TrustRegion:
        """Return the region after a rejected step of infinity norm `length`."""
        return TrustRegion(share * min(self.radius, length), self.largest)


def agreement(actual: float, predicted: float, rounding: float) -> float:
    """Return the ratio of actual to predicted reduction, one when both are rounding errors."""
    return (actual + rounding) / (max(predicted, 0.0) + rounding)


@dataclass
class Filter:
    """Pairs (violation, cost), none of which a new iterate may be dominated by.

    Attributes:
        ceiling: largest violation ever accepted.
        entries: the pairs.
    """

    ceiling: float
    entries: list[tuple[float, float]] = field(default_factory=list)

    def accepts(self, violation: float, cost: float) -> bool:
        """Return whether no entry dominates the pair."""
        return violation <= self.ceiling and all(
            improves(violation, cost, *entry) for entry in self.entries
        )

    def add(self, violation: float, cost: float) -> None:
        """Enter a pair and drop those it dominates."""
        self.entries = [e for e in self.entries if e[0] < violation or e[1] < cost]
        self.entries.append((violation, cost))


def improves(
    violation: float, cost: float, old_violation: float, old_cost: float, noise: float = 0.0
) -> bool:
    """Return whether a pair is enough below an old one in violation or in cost.

    A rise of the cost below `noise`, its rounding error, is no rise.
    """
    return (
        violation < (1.0 - MARGIN) * old_violation or cost <= old_cost - MARGIN * violation + noise
    )


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
    def may_widen(self) -> bool:
        """Whether the region may grow: the rows are near, or as near as was predicted."""
        return self.violation <= LARGE_VIOLATION or self.ratio > GOOD


def judge(
    nlp: NLP,
    iterate: Iterate,
    model: QuadraticModel,
    step: ElasticStep,
    judged: ElasticStep,
    values: Values,
) -> Trial:
    """Compare a trial with the prediction of a step.

    Args:
        iterate: where the step began.
        model: of the scaled cost there.
        step: the step tried.
        judged: the step whose prediction counts; a correction is held to that of its original.
        values: at the trial point.
    """
    violation, _ = worst_violation(nlp, values)
    weight = MERIT_WEIGHT * float(np.abs(judged.multipliers).sum())
    old_cost = nlp.cost_scale * iterate.point.cost
    fall = old_cost - nlp.cost_scale * values.cost
    rounding = ROUNDING * max(1.0, abs(old_cost), weight)
    predicted = model.predicted_decrease(judged.d)
    for_cost = judged.slack <= NEGLIGIBLE_SLACK and predicted > SWITCH * iterate.violation**2
    fell = fall >= SUFFICIENT * predicted - rounding
    pressing = np.flatnonzero(judged.multipliers)  # few of thousands
    curved = (values.rows - iterate.point.rows - judged.change)[pressing]
    surprise = fall - predicted - float(judged.multipliers[pressing] @ curved)
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


def corrected(
    trial: Trial,
    feasibility: float,
    correct: Callable[[Trial], Trial | None],
    acceptable: Callable[[Trial], bool],
) -> Trial:
    """Return the best of a trial and its second-order corrections (Fletcher & Leyffer).

    A correction is itself corrected while that keeps reducing the violation.

    Args:
        trial: of a step.
        feasibility: violation below which nothing is left to correct.
        correct: returns the trial of a corrected step, None if there is none.
        acceptable: whether a trial may become the iterate.
    """
    best, last = trial, trial
    for _ in range(CORRECTIONS):
        if last.violation <= feasibility or last.ratio >= CORRECT_UNTIL:
            break
        second = correct(last)
        if second is None:
            break
        if acceptable(second) and (second.ratio > best.ratio or not acceptable(best)):
            best = second
        if second.violation > CORRECT_GAIN * last.violation:
            break
        last = second
    return best


def initial_penalty(nlp: NLP, start: Iterate, usual: float) -> float:
    """Return the penalty to begin with: the usual one, more for a start that is nearly a solution.

    A warm start would be led away from its limits by a penalty below the sum of the multipliers
    (Nocedal & Wright, Theorem 17.3).
    """
    multipliers = start.multipliers
    if not multipliers.any() and start.violation <= NEAR_START:
        multipliers = least_squares_multipliers(nlp, start.point)[0]
    return max(usual, EXCESS * float(np.abs(multipliers).sum()))


@dataclass
class Patience:
    """Notices when the least violation of a run no longer falls.

    Attributes:
        iterations: after which it is exhausted.
        least: least violation so far that counted.
        idle: iterations since.
    """

    iterations: int
    least: float = np.inf
    idle: int = 0

    def renew(self) -> None:
        """Begin anew: something else speaks for going on."""
        self.idle = 0

    def exhausted(self, violation: float) -> bool:
        """Look at an iteration; return whether to give up."""
        if violation < LASTING_DECREASE * self.least:
            self.least, self.idle = violation, 0
        else:
            self.idle += 1
        return self.least > NEARLY_FEASIBLE and self.idle >= self.iterations
