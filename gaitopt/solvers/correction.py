"""Second-order corrections of a step, for the curvature of the rows (Fletcher & Leyffer, 2002)."""

from __future__ import annotations

from collections.abc import Callable

from gaitopt.solvers.acceptance import Trial

CORRECT_UNTIL = 0.75
"""A step that is not accepted is corrected until cost and violation are as good as predicted ..."""
CORRECT_GAIN = 0.1
"""... or the violation did not fall to this share ..."""
CORRECTIONS = 2
"""... but not more often than this (measured: the second saves long runs a third of their
iterations along the curved rows, a third saves nothing)."""


def corrected(
    trial: Trial,
    feasibility: float,
    correct: Callable[[Trial], Trial | None],
    acceptable: Callable[[Trial], bool],
) -> Trial:
    """Return the best of a trial and its second-order corrections.

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
