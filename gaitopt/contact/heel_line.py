"""The rear edge of the sole rests on the ground and the foot turns about it, the toe rising."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitopt.contact.mode import ContactMode, Hinge
from gaitopt.model.sole import Sole
from gaitopt.nlp import Array


@dataclass(frozen=True)
class HeelLine(ContactMode):
    """The centre of pressure is within a strip ahead of the edge: a heel is round.

    Attributes:
        strip: its length [m].
    """

    name: ClassVar[str] = "heel line"
    strip: float

    def hinge(self, sole: Sole) -> Hinge:
        """Return the rear edge."""
        return Hinge(np.array([sole.heel, 0.0, 0.0]), np.array([0.0, -1.0, 0.0]))

    def bearing(self, sole: Sole, margin: float) -> Array:
        """Return the strip, narrowed sideways by the margin."""
        return np.array(
            [sole.heel + self.strip, sole.heel, sole.left - margin, sole.right + margin]
        )

    def resting(self) -> NDArray[np.bool_]:
        """Return the corners at the heel."""
        return np.array([False, False, True, True])
