"""Words for left and right in the names of joints and links; they never decide, only tell."""

from __future__ import annotations

import re

SIDE_WORDS = {
    "right": re.compile(r"(?i:right)|(?<![a-zA-Z])[rR](?![a-zA-Z])|^R(?=[A-Z])"),
    "left": re.compile(r"(?i:left)|(?<![a-zA-Z])[lL](?![a-zA-Z])|^L(?=[A-Z])"),
}
"""What a name says about the side it is on."""


def partners_by_name(first: str, other: str) -> bool:
    """Tell whether two names differ in the word for the side, and in nothing else."""
    return any(
        SIDE_WORDS[a].search(first) is not None
        and SIDE_WORDS[b].search(other) is not None
        and SIDE_WORDS[a].sub("*", first) == SIDE_WORDS[b].sub("*", other)
        for a, b in (("right", "left"), ("left", "right"))
    )
