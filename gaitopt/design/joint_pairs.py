"""How the joints of a pair, one of each leg, are named together."""

from __future__ import annotations

import re
from itertools import takewhile

_BETWEEN = r"([_\-./ ])"  # what separates the words of a name
_LEAST = 3  # letters: a shorter common end of two words belongs to both
_SIDE = re.compile("left|right", re.IGNORECASE)


def shared_name(first: str, second: str) -> str:
    """Return the words two names share, or their common ends; empty if there is none.

    right_hip_yaw_joint, left_hip_yaw_joint -> "hip yaw"; RHipYaw, LHipYaw -> "HipYaw".
    """
    words, others = (re.split(_BETWEEN, name)[::2] for name in (first, second))
    if len(words) == len(others):
        kept = [_shared_word(a, b) for a, b in zip(words, others, strict=True)]
    else:
        kept = [word for word in words if word in others]
    return " ".join(word for word in kept if word and word.lower() != "joint")


def brace(first: str, second: str) -> str:
    """Return two names as a shell would write them: {left,right}_knee."""
    parts = [re.split(_BETWEEN, name) for name in (first, second)]
    if len(parts[0]) != len(parts[1]):
        return f"{first}, {second}"
    return "".join(a if a == b else _braced(a, b) for a, b in zip(*parts, strict=True))


def _shared_word(first: str, second: str) -> str:
    """Return a word both have, or the longer of its common ends: LHipYaw, RHipYaw -> HipYaw."""
    if first == second:
        return first
    first, second = (_SIDE.sub("", word) for word in (first, second))  # both end in t
    ends = _start(first, second), _end(first, second)
    longest = max(ends, key=len)
    return longest if len(longest) >= _LEAST else ""


def _braced(first: str, second: str) -> str:
    shared = len(_end(first, second))
    cut = len(first) - shared if shared >= _LEAST else len(first)
    return f"{{{first[:cut]},{second[: len(second) - len(first) + cut]}}}{first[cut:]}"


def _start(first: str, second: str) -> str:
    same = takewhile(lambda pair: pair[0] == pair[1], zip(first, second, strict=False))
    return "".join(letter for letter, _ in same)


def _end(first: str, second: str) -> str:
    return _start(first[::-1], second[::-1])[::-1]
