"""Why a robot is too lopsided to be averaged, and which choice would accept it all the same."""

from __future__ import annotations

import math

from gaitopt.robot.mirror.effect import percent
from gaitopt.robot.mirror.symmetrise import Difference, Symmetrised

_LISTED = 0.1  # of the largest effect: differences that matter less are counted, not listed
_MOST = 1.0  # the largest value of the choice


def asymmetry_faults(done: Symmetrised, allowed: float) -> list[str]:
    """Return what is wrong with a robot that differs too much from its mirror image, if it does.

    Args:
        done: of the robot.
        allowed: largest effect that averaging may have, `Choices.asymmetry`.
    """
    size = done.effect.size
    if size <= allowed:
        return []
    least = _LISTED * done.differences[0].effect.size
    listed = [d for d in done.differences if d.effect.size >= least]
    more = len(done.differences) - len(listed)
    differs = "; ".join(_described(difference) for difference in listed)
    rest = f"; {more} more that matter less" if more else ""
    fault = (
        f"the robot is not its own mirror image: averaging left and right would change "
        f"{done.effect.words()}; allowed is {percent(allowed)} (asymmetry = {allowed:g}). What "
        f"differs, by its effect: {differs}{rest}. {_remedy(done, size)}"
    )
    return [fault]


def _described(difference: Difference) -> str:
    return f"{difference.subject}: {difference.size} ({difference.effect.brief()})"


def _remedy(done: Symmetrised, size: float) -> str:
    place = "<origin>, <axis>" if done.differences[0].kind in ("joints", "soles") else "<inertial>"
    correct = f"Correct the file ({place} of what is named first)"
    if done.differences[0].kind == "joints":
        correct += (
            ", or if the whole robot leans in the root link's axes, say which direction of it is "
            "up (up = [X, Y, Z] in the file for --choices)"
        )
    if not size <= _MOST:
        return f"{correct}; no choice accepts so much"
    return f"{correct}, or have it averaged: asymmetry = {_above(size):g} in the file for --choices"


def _above(size: float) -> float:
    """Return the next number of two digits, so that what is written accepts what was measured."""
    digit = 10.0 ** (math.floor(math.log10(size)) - 1)
    above = math.ceil(size / digit) * digit
    above = above if above > size else above + digit
    return min(float(f"{above:.3g}"), _MOST)
