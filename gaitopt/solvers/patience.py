"""When a run that finds no feasible point has gone on for long enough."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

FAR = 1e-3
"""A least violation below this, in scaled rows, is near enough to go on (measured: near the limits
runs may take their time)."""
GIVE_UP, GIVE_UP_LEARNING = 40, 200
"""Iterations without less violation after which a program is called infeasible, with exact
curvature and while learning it (measured: feasible walks take up to 16, and up to 60)."""
HOPE = 0.9
"""Share to which the least violation has to fall."""


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
        """Begin anew: something else than hope speaks for going on."""
        self.idle = 0

    def exhausted(self, violation: float) -> bool:
        """Look at an iteration; return whether to give up."""
        if violation < HOPE * self.least:
            self.least, self.idle = violation, 0
        else:
            self.idle += 1
        return self.least > FAR and self.idle >= self.iterations
