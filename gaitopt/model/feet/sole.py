"""The rectangle of a sole that may touch the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitopt.errors import RobotError
from gaitopt.nlp import Array


@dataclass(frozen=True)
class Sole:
    """A rectangle in the plane z = 0 of the sole frame [m]: x forward, y left."""

    toe: float
    heel: float
    left: float
    right: float

    def __post_init__(self) -> None:
        if not (self.toe > self.heel and self.left > self.right):
            raise RobotError(
                f"the sole rectangle is empty: x from {self.heel} to {self.toe} m, "
                f"y from {self.right} to {self.left} m; toe must exceed heel and left exceed right"
            )

    @property
    def corners(self) -> Array:
        """Toe left, toe right, heel left, heel right in the sole frame [m], shape (4, 3)."""
        return np.array(
            [
                [self.toe, self.left, 0.0],
                [self.toe, self.right, 0.0],
                [self.heel, self.left, 0.0],
                [self.heel, self.right, 0.0],
            ]
        )


def tidy(length: float) -> float:
    """Return a length [m] without the rounding of the placements it came from (1e-12 m)."""
    return round(float(length), 12) + 0.0
