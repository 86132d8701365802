"""When a search whose answer need not be optimal has gone on for long enough."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gaitopt.nlp import Progress
from gaitopt.solvers.globalization import Patience
from gaitopt.tolerances import FEASIBLE

SUFFICIENT_DECREASE, FEASIBLE_STALL = 0.01, 8
"""A run ends when the objective of so many feasible iterates has not fallen by this share ..."""
INFEASIBLE_STALL = 15
"""... and one that is far from any when its violation no longer falls in so many iterations."""


@dataclass
class EarlyStopping:
    """Ends a run when it is good enough or gets nowhere; a `StopCallback`."""

    _objective: float = np.inf
    _idle: int = 0
    _patience: Patience = field(default_factory=lambda: Patience(INFEASIBLE_STALL))

    def __call__(self, progress: Progress) -> bool:
        """Look at an iteration; return whether the run may end."""
        stuck = self._patience.exhausted(progress.violation)
        if progress.violation <= FEASIBLE:
            if progress.cost < self._objective - SUFFICIENT_DECREASE * abs(progress.cost):
                self._objective, self._idle = progress.cost, 0
            else:
                self._idle += 1
        return stuck or self._idle >= FEASIBLE_STALL
