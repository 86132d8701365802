"""Limits that a walk presses on, in a form that the walk on another grid can take over."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.design.extremes import Extreme, located
from gaitopt.gait.constraint import ConstraintBlock
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array
from gaitopt.tolerances import REFINED

DIGITS = 12  # of instants, as `Grid.with_instants` rounds them
_SAME_INSTANT = 0.6e-12  # difference of instants that are the same to so many digits
ACTIVE_MULTIPLIER = 1e-9  # scaled multiplier below which a limit counts as idle
END_APPROACH = (
    10.0  # by which a row that vanishes at the end is held nearer to it, round after round
)
SAME_PEAK = 0.05  # of the step: a peak nearer than this to an active instant is that one, moved
BESIDE = 0.125  # of the distance of two instants between which a limit presses: the error of where
LEAST_SHARE = 0.02  # of the multipliers of two instants: with less, one of them presses alone


@dataclass(frozen=True)
class ViolatedRow:
    """Where a limit is exceeded most.

    Attributes:
        constraint, entry: which constraint.
        instant: s = t / T.
        excess: scaled violation there.
        held: instant at which to hold the row, so that it keeps its limit all about the peak.
        beside: instants at which to hold it too, for a round: before and after, where `held` is not
            known exactly.
    """

    constraint: str
    entry: int
    instant: float
    excess: float
    held: float
    beside: tuple[float, ...] = ()


@dataclass(frozen=True)
class ActiveRow:
    """One active row.

    Attributes:
        constraint, entry: which constraint.
        instant: s = t / T, or the row's number where the constraint is not one of instants.
        multiplier: scaled, sign as in `gaitopt.nlp`.
    """

    constraint: str
    entry: int
    instant: float
    multiplier: float


def active_rows(problem: WalkProblem, multipliers: Array) -> tuple[ActiveRow, ...]:
    """Return the active rows of a walk from the multipliers of its rows (m,)."""
    found = []
    for number in np.flatnonzero(np.abs(multipliers) > ACTIVE_MULTIPLIER):
        at = problem.address(int(number))
        instant = _instant(at.block, at.instant)
        found.append(ActiveRow(at.block.name, at.entry, instant, float(multipliers[number])))
    return tuple(found)


def placed(problem: WalkProblem, active: Iterable[ActiveRow]) -> Array:
    """Return multipliers (m,) for a walk on another grid; rows it lacks are left out."""
    multipliers = np.zeros(problem.rows.lower.size)
    blocks = {block.name: block for block in problem.blocks}
    for one in active:
        block = blocks.get(one.constraint)
        row = None if block is None else _row(block, one.instant)
        if block is not None and row is not None and one.entry < block.lower.shape[1]:
            first = problem.rows_of(one.constraint).start
            multipliers[first + row * block.lower.shape[1] + one.entry] += one.multiplier
    return multipliers


def is_among(shares: Array, instants: Array) -> NDArray[np.bool_]:
    """Return which shares of the step (K,) are one of some instants (N,), ascending, shape (K,)."""
    if not instants.size:
        return np.zeros(shares.size, dtype=bool)
    after = np.searchsorted(instants, shares - _SAME_INSTANT).clip(max=instants.size - 1)
    return np.asarray(np.abs(instants[after] - shares) < _SAME_INSTANT)


def instants_of(problem: WalkProblem, active: Iterable[ActiveRow]) -> Array:
    """Return the instants (K,) of active rows of the constraints that are over the step."""
    timed = {f.name for f in problem.blocks if f.times is not None}
    return np.unique([one.instant for one in active if one.constraint in timed])


def violated_rows(fine: WalkProblem, x: Array) -> tuple[ViolatedRow, ...]:
    """Return where rows exceed their limits most at x (P,), located anywhere in the step.

    Of every stretch in which a row exceeds a limit only the worst instant is taken.

    Raises:
        EvaluationError: the walk is not defined at x.
    """
    return exceeded(fine, located(fine, x))


def exceeded(fine: WalkProblem, extremes: Iterable[Extreme]) -> tuple[ViolatedRow, ...]:
    """Return the extremes of a walk on the proof's grid at which rows exceed their limits."""
    beyond = [(one, round(one.instant, DIGITS)) for one in extremes if one.margin < -REFINED]
    return tuple(
        ViolatedRow(one.constraint, one.entry, at, -one.margin, _held(one, fine.edges))
        for one, at in beyond
    )


def _held(peak: Extreme, ends: Array) -> float:
    """Return the instant at which a row is to be held after it has exceeded its limit.

    That is the peak, except where the row vanishes at the end of the step (a foot that lands).
    There the row would be exceeded again between peak and end, a quarter as much, and again; a row
    held at a distance d from such an end is exceeded by curvature * d² / 8 in between, so it need
    not be held nearer than where that is half of what refinement allows. It gets there by steps:
    nearer to the end its gradient vanishes too, and a solver that is sent there at once crawls.

    Args:
        ends: instants at which a step begins or ends.
    """
    end = float(ends[np.abs(ends - peak.instant).argmin()])
    distance = abs(end - peak.instant)
    reaches_end = peak.curvature * distance**2 < -4.0 * peak.margin
    if not (abs(peak.at_end) < REFINED and reaches_end and peak.curvature > 0.0):
        return round(peak.instant, DIGITS)
    nearest = min(distance, float(np.sqrt(4.0 * REFINED / peak.curvature)))
    away = max(nearest, distance / END_APPROACH)
    return round(end + away if peak.instant > end else end - away, DIGITS)


def sharpened(active: Iterable[ActiveRow], peaks: Iterable[ViolatedRow]) -> tuple[ViolatedRow, ...]:
    """Return the peaks, those between two active instants of the same row held where it presses.

    A limit that is held at two instants close together is exceeded half way between them, and to
    hold it there would halve their distance, again and again. With the multipliers m and n at the
    instants s and t, what presses is m g(s) + n g(t) of the row's gradient g, which to first order
    is (m + n) g at their mean weighted by m and n: there the row will touch its limit, but for
    the square of the distance.
    """
    known, found = tuple(active), []
    for peak in peaks:
        around = _around(peak, known) if peak.held == peak.instant else []
        if len(around) == 2:
            (s, m), (t, n) = ((one.instant, one.multiplier) for one in around)
            if LEAST_SHARE < m / (m + n) < 1.0 - LEAST_SHARE:
                here, aside = (m * s + n * t) / (m + n), BESIDE * (t - s)
                ends = (here - aside, here + aside)
                beside = tuple(round(one, DIGITS) for one in ends if s < one < t)
                peak = replace(peak, held=round(here, DIGITS), beside=beside)
        found.append(peak)
    return tuple(found)


def _around(peak: ViolatedRow, active: Iterable[ActiveRow]) -> list[ActiveRow]:
    """Return the active rows of a peak next before and after it, unless they are two limits."""
    near = [
        one
        for one in active
        if (one.constraint, one.entry) == (peak.constraint, peak.entry)
        and abs(one.instant - peak.instant) <= SAME_PEAK
    ]
    when = attrgetter("instant")
    before = max((one for one in near if one.instant < peak.instant), key=when, default=None)
    after = min((one for one in near if one.instant > peak.instant), key=when, default=None)
    found = [one for one in (before, after) if one is not None and one.multiplier != 0.0]
    return found if len({one.multiplier > 0.0 for one in found}) < 2 else []


def moved(active: Iterable[ActiveRow], peaks: Iterable[ViolatedRow]) -> tuple[ActiveRow, ...]:
    """Return the active rows with those near a new peak of the same row moved there.

    The limit that was kept at one instant is now exceeded a little before or after it; its
    multiplier is nearly the same. A peak that no active row is near gets the multiplier zero.
    """
    kept = list(active)
    for peak in peaks:
        around = _around(peak, kept)
        if len(around) == 2 and peak.held != peak.instant:  # see `sharpened`
            kept = [one for one in kept if one not in around]
            size = sum(one.multiplier for one in around)
            kept.append(ActiveRow(peak.constraint, peak.entry, peak.held, size))
            continue
        near = [
            i
            for i, one in enumerate(kept)
            if (one.constraint, one.entry) == (peak.constraint, peak.entry)
            and abs(one.instant - peak.held) <= SAME_PEAK
        ]
        size = 0.0
        if near:
            index = min(near, key=lambda i: abs(kept[i].instant - peak.held))
            size = kept.pop(index).multiplier
        kept.append(ActiveRow(peak.constraint, peak.entry, peak.held, size))
    return tuple(kept)


def _instant(constraint: ConstraintBlock, row: int) -> float:
    return float(row) if constraint.times is None else round(float(constraint.times[row]), DIGITS)


def _row(constraint: ConstraintBlock, instant: float) -> int | None:
    """Return the row of an instant as `_instant` tells it, None where there is none."""
    if constraint.times is None:
        return int(instant) if instant in range(len(constraint.lower)) else None
    near = np.flatnonzero(np.abs(constraint.times - instant) < _SAME_INSTANT)
    return int(near[-1]) if near.size else None
