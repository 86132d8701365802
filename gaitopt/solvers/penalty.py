"""The weight of the slack: what a run begins with, and when and how it is raised."""

from __future__ import annotations

import numpy as np

from gaitopt.nlp import NLP
from gaitopt.solvers.multipliers import least_squares_multipliers
from gaitopt.solvers.recorder import Iterate

STEERED = 0.1
"""Share of the violation that a step may leave without the penalty being raised (after Byrd,
Nocedal & Waltz, "Steering exact penalty methods for nonlinear programming", 2008) ..."""
RAISE = 10.0
"""... and factor of a penalty that proved too small (Nocedal & Wright, 2006, Algorithm 18.5)."""
EXCESS = 1.5
"""Penalty over the sum of the multipliers, if these are known ..."""
NEARLY = 0.1
"""... or can be estimated, since the violation of the start, in scaled rows, is below this."""


def initial_penalty(nlp: NLP, start: Iterate, usual: float) -> float:
    """Return the penalty to begin with: the usual one, more for a start that is nearly a solution.

    A warm start would be led away from its limits by a penalty below the sum of the multipliers
    (Nocedal & Wright, 2006, Theorem 17.3).
    """
    multipliers = start.multipliers
    if not multipliers.any() and start.violation <= NEARLY:
        multipliers = least_squares_multipliers(nlp, start.point)[0]
    return max(usual, EXCESS * float(np.abs(multipliers).sum()))
