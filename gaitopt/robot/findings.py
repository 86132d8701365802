"""What was learnt, guessed or changed while a robot was read, in sentences for a person."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

How = Literal["found", "guessed", "given", "changed", "warning"]
"""Read off the model; most likely so; fixed by the user; not as in the file; worth a look."""


@dataclass(frozen=True)
class Finding:
    """One fact about a robot.

    Attributes:
        topic: what it belongs to: "legs", "pairs", "heading", "sole", "limits", "symmetry",
            "posture", "armature", "damping", "joint friction", "springs", "gravity",
            "gravity compensation", "mass", "inertia", or "file" for what is odd in a line of it.
        subject: the joint, link or leg it is about.
        text: the fact with its numbers and units.
        how: how sure it is.
    """

    topic: str
    subject: str
    text: str
    how: How = "found"

    def record(self) -> dict[str, str]:
        """Return it as JSON-able data."""
        return {"topic": self.topic, "subject": self.subject, "how": self.how, "text": self.text}


def findings_of(record: object) -> tuple[Finding, ...]:
    """Return the findings of a list of records; what is none is passed over."""
    found = []
    for entry in record if isinstance(record, list) else []:
        if isinstance(entry, Mapping) and entry.get("how") in get_args(How):
            topic, subject, text = (str(entry.get(n, "")) for n in ("topic", "subject", "text"))
            found.append(Finding(topic, subject, text, entry["how"]))
    return tuple(found)
