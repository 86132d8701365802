"""The ground under a gait as its file records it, for words and pictures."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gaitopt.escape import printable
from gaitopt.gait.result import Gait, is_number
from gaitopt.model.feet.sole import LEVEL
from gaitopt.nlp import Array

_LONGEST = 80  # characters of words
_MOST = 1000  # points of an outline


@dataclass(frozen=True)
class Ground:
    """The ground of a gait.

    Attributes:
        words: what a person calls it, empty for level ground.
        down: direction of gravity in its axes, those of the stance sole; of unit length.
        rise: of the next footprint over this one [m].
        outline: points (x, z) of the ground of one step [m], shape (m, 2); none of a plane.
    """

    words: str = ""
    down: tuple[float, float, float] = LEVEL
    rise: float = 0.0
    outline: Array = field(default_factory=lambda: np.zeros((0, 2)))

    @property
    def shaped(self) -> bool:
        """Whether it is no plane."""
        return len(self.outline) > 0

    def along(self, first: int, last: int, step: float) -> Array:
        """Return its points from one step to another before the next [m], shape (m, 2).

        Args:
            first, last: numbers of the steps; the stance foot stands in step 0.
            step: length of a step [m].
        """
        one = self.outline if self.shaped else np.zeros((1, 2))
        return np.concatenate([one + k * np.array([step, self.rise]) for k in range(first, last)])


def ground_of(gait: Gait) -> Ground:
    """Return the ground that a gait walks on; level where it records none, or nonsense."""
    down, outline = gait.fact("ground", "down"), gait.fact("ground", "outline")
    points = _rows(outline, 2)
    axes = _rows([down], 3)
    direction = axes[0] if len(axes) else np.zeros(3)
    length = float(np.linalg.norm(direction))
    x, y, z = direction / length if length > 0.0 else LEVEL
    return Ground(
        printable((gait.text("ground", "words") or "")[:_LONGEST]),
        (float(x), float(y), float(z)),
        gait.number("ground", "rise") or 0.0,
        points,
    )


def _rows(value: object, width: int) -> Array:
    """Return lists of numbers as rows (m, width); none if they are not that."""
    rows = value if isinstance(value, list) else []
    if len(rows) > _MOST or not all(
        isinstance(row, list) and len(row) == width and all(map(is_number, row)) for row in rows
    ):
        rows = []
    return np.array(rows, dtype=np.float64).reshape(-1, width)
