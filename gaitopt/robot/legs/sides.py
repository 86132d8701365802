"""Words for left and right in the names of joints and links; they never decide, only tell."""

from __future__ import annotations

import re
from collections.abc import Sequence

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


def speaks_for_other_side(right: Sequence[str], left: Sequence[str]) -> bool:
    """Tell whether the names of a right leg's joints are those of a left one, and the other way.

    What tells is where the names of two partners differ: `LR_HR` and `LL_HR` are the right and the
    left leg of a robot that begins its legs with L.

    Args:
        right, left: names of the joints from hip to ankle.
    """
    initials = [_initials(*names) for names in zip(right, left, strict=True)]
    return "lr" in initials and "rl" not in initials


def _initials(first: str, other: str) -> str:
    """First letters of what differs in two names, in lower case."""
    start = 0
    while start < min(len(first), len(other)) and first[start] == other[start]:
        start += 1
    return (first[start : start + 1] + other[start : start + 1]).lower()
