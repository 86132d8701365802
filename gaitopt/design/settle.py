"""When a search whose answer need not be optimal has gone on for long enough."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitopt.nlp import Progress

FEASIBLE = 1e-6
"""Scaled violation below which there is a walk."""
WORTH, RESTLESS = 0.01, 8
"""A run ends when the objective of so many feasible iterates has not fallen by this share ..."""
FAR, HOPE, STUCK = 1e-3, 0.9, 15
"""... and one that found none when its least violation is still this large and has not fallen to
this share in so many iterations (measured: nearer to the limits runs may take their time)."""


@dataclass
class Settle:
    """Ends a run as Ctrl-C would, when it is good enough or gets nowhere; an `on_progress`.

    Attributes:
        settled: whether it has ended the run.
    """

    settled: bool = False
    _objective: float = np.inf
    _violation: float = np.inf
    _idle: int = 0

    def __call__(self, progress: Progress) -> None:
        """Look at an iteration.

        Raises:
            KeyboardInterrupt: the run may end.
        """
        walks = progress.violation <= FEASIBLE
        if walks and progress.cost < self._objective - WORTH * abs(progress.cost):
            self._objective, self._idle = progress.cost, 0
        elif not self._walked and progress.violation < HOPE * self._violation:
            self._violation, self._idle = progress.violation, 0
        elif walks or (self._violation > FAR and not self._walked):
            self._idle += 1
        if self._idle >= (RESTLESS if self._walked else STUCK):
            self.settled = True
            raise KeyboardInterrupt

    @property
    def _walked(self) -> bool:
        return bool(np.isfinite(self._objective))
