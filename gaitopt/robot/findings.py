"""What was learnt, guessed or changed while a robot was read, in sentences for a person."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

How = Literal["found", "guessed", "given", "changed", "warning"]
"""Read off the model; most likely so; fixed by the user; not as in the file; worth a look."""


@dataclass(frozen=True)
class Finding:
    """One fact about a robot.

    Attributes:
        topic: what it belongs to: "legs", "pairs", "heading", "sole", "limits", "symmetry",
            "posture", "armature", "damping", "joint friction", "springs", "gravity",
            "gravity compensation", "mass" or "inertia".
        subject: the joint, link or leg it is about.
        text: the fact with its numbers and units.
        how: how sure it is.
    """

    topic: str
    subject: str
    text: str
    how: How = "found"
