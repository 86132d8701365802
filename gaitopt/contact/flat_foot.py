"""The whole sole rests on the ground."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitopt.contact.mode import ContactMode
from gaitopt.model.sole import Sole
from gaitopt.nlp import Array


@dataclass(frozen=True)
class FlatFoot(ContactMode):
    """The foot stands still; the centre of pressure is inside the sole, Eqs. (37)-(38)."""

    name: ClassVar[str] = "flat"

    def hinge(self, sole: Sole) -> None:
        """Return None: the foot cannot turn."""
        del sole

    def bearing(self, sole: Sole, margin: float) -> Array:
        """Return the sole, narrowed by the margin on all sides."""
        return np.array(
            [sole.toe - margin, sole.heel + margin, sole.left - margin, sole.right + margin]
        )

    def resting(self) -> NDArray[np.bool_]:
        """Return all four corners."""
        return np.ones(4, dtype=np.bool_)
