"""Limits of the joints, read from the file and compared between left and right.

Where left and right differ by no more than rounding and fits do, the tighter of both holds: it is
kept by either side. Where they differ by more, someone has to say which is right.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gaitopt.bounds import NUMBER, USABLE
from gaitopt.dataclass import dataclass
from gaitopt.importers.report import Finding, How
from gaitopt.model.import_options import LIMIT_UNITS
from gaitopt.nlp import Array

if TYPE_CHECKING:
    import pinocchio as pin

_ALIKE = 0.02  # of the larger one: limits that differ by less are settled, the tighter holds
_ROUNDING = 1e-2  # rad: the same for the ends of ranges, however narrow
_TOLD = 1e-6  # rad: ends of ranges that differ by less are not worth a word
_COMMON = 0.5  # of the narrower range: where two have less in common, one of them is wrong
_MOST = {"torque": 5000.0, "speed": 50.0}  # N.m, rad/s: larger values stand for "no limit"
_HEAVY = 60.0  # kg: robots heavier than this have stronger motors
_WIDEST = 2.0 * np.pi  # rad: a range beyond a full turn to either side stands for "no limit"
_NARROW = 0.12  # rad: a whole turn of radians taken for degrees is narrower
_DEGREES = (10.0, 200.0)  # how far a joint of a leg turns to one side, if its range is in degrees
_HINT = "in the file for --choices"
_FLIPPED = (
    "which are alike when one of the two is turned round: an axis or a range has a wrong sign"
)

_Range = tuple[float, float]


@dataclass(frozen=True)
class JointLimits:
    """Limits of the moving joints, in the order of `Robot.joint_names`, shape (n,) each.

    Attributes:
        torque: largest |torque| [N.m], infinite where there is no limit.
        speed: largest |rate| [rad/s], infinite where there is no limit.
        lower, upper: joint range [rad], infinite where there is no limit.
    """

    torque: Array
    speed: Array
    lower: Array
    upper: Array

    def ordered(self, rows: Sequence[int]) -> JointLimits:
        """Return the limits of some of the joints in another order."""
        values = (getattr(self, field)[rows] for field in ("torque", "speed", "lower", "upper"))
        return JointLimits(*values)

    def range(self, row: int) -> _Range:
        """Return the range of a joint [rad]."""
        return float(self.lower[row]), float(self.upper[row])


def joint_limits(
    model: pin.Model,
    joints: Sequence[int],
    mirror: Array,
    unequal: str,
    right: NDArray[np.bool_],
    complete: Callable[[JointLimits], JointLimits],
    elsewhere: Collection[str],
) -> tuple[JointLimits, list[Finding], list[str]]:
    """Read the limits of the joints that move.

    Args:
        joints: the moving ones, those of the stance leg first, shape (n,).
        right: which joints are on the right side, shape (n,); asked for "right" and "left".
        complete: gives torque and speed to joints without any, which others of their ties have.
        elsewhere: joints whose motors sit elsewhere, so that theirs is the torque that is limited.

    Returns:
        The limits, what was found about them, and what is wrong with them: limits below zero, or
        sides that differ. Where something is wrong the limits are the tighter ones, to be shown.
    """
    names = tuple(str(model.names[j]) for j in joints)
    rows, angles = ([getattr(model.joints[j], i) for j in joints] for i in ("idx_v", "idx_q"))
    raw = JointLimits(
        torque=np.array(model.effortLimit)[rows],
        speed=np.array(model.velocityLimit)[rows],
        lower=np.array(model.lowerPositionLimit)[angles],
        upper=np.array(model.upperPositionLimit)[angles],
    )
    raw = complete(raw)
    limits, findings, faults = _without_placeholders(
        raw, names, elsewhere, sum(float(body.mass) for body in model.inertias)
    )
    keep = right == (unequal == "right") if unequal in ("right", "left") else None
    sides = _Sides(names, mirror, unequal, keep)
    limits = sides.mirrored(limits)
    return limits, findings + sides.findings, faults + sides.faults(limits)


def _without_placeholders(
    raw: JointLimits, names: tuple[str, ...], elsewhere: Collection[str], mass: float
) -> tuple[JointLimits, list[Finding], list[str]]:
    findings, faults, values = [], [], {}
    for field, most in _MOST.items():
        given, unit = getattr(raw, field), LIMIT_UNITS[field]
        if field == "torque":
            most *= max(mass / _HEAVY, 1.0)
        faults += [
            f"the {field} limit of '{name}' is {value} {unit}; it must be > 0"
            for name, value in zip(names, given, strict=True)
            if value < 0.0 or np.isnan(value)
        ]
        faults += [
            f"the {field} limit of '{name}' is {value:g} {unit}; it must be {USABLE}, or absent"
            for name, value in zip(names, given, strict=True)
            if 0.0 < value < 1.0 / NUMBER
        ]
        free = ~(given > 0.0) | (given > most)
        values[field] = np.where(free, np.inf, given)
        told = free & (given >= 0.0)
        if field == "torque":
            told &= ~np.isin(names, list(elsewhere))
        findings += _placeholders(names, field, given, told, unit)
    values["lower"] = np.where(raw.lower < -_WIDEST, -np.inf, raw.lower)
    values["upper"] = np.where(raw.upper > _WIDEST, np.inf, raw.upper)
    wide = np.isinf(values["lower"]) | np.isinf(values["upper"])
    findings += _placeholders(names, "range", _widths(raw), wide, "rad")
    units = _in_degrees(names, raw, wide) or _in_radians(names, raw)
    return JointLimits(**values), units + findings, faults


def _in_degrees(names: tuple[str, ...], raw: JointLimits, wide: NDArray[np.bool_]) -> list[Finding]:
    """Warn where most ranges are wider than a turn, yet would be those of a leg in degrees."""
    most = np.maximum(np.abs(raw.lower), np.abs(raw.upper))
    rows = np.flatnonzero(wide & (most >= _DEGREES[0]) & (most <= _DEGREES[1]))
    # Placeholders are all alike, and alike to both sides; ranges of a leg are not.
    if len(rows) <= len(names) // 2 or len({*raw.lower[rows], *-raw.upper[rows]}) < 3:
        return []
    row = int(rows[0])
    text = (
        f"ranges as that of '{names[row]}', {raw.lower[row]:g} to {raw.upper[row]:g} rad, are "
        "more than a turn; are ranges of the file in degrees? They must be in rad"
    )
    return [Finding("limits", f"{len(rows)} joints", text, "warning")]


def _in_radians(names: tuple[str, ...], raw: JointLimits) -> list[Finding]:
    """Warn where even the widest range is that of a leg in radians, but read in degrees."""
    widths = _widths(raw)
    row = int(np.argmax(widths))
    if not 0.0 < widths[row] < _NARROW:
        return []
    text = (
        f"the widest of the ranges, that of '{names[row]}', is {widths[row]:.3g} rad or "
        f"{np.degrees(widths[row]):.3g} degrees; no leg walks with that. Are they in radians where "
        'the file counts in degrees? MJCF does without <compiler angle="radian"/>'
    )
    return [Finding("limits", f"{len(names)} joints", text, "warning")]


def _widths(raw: JointLimits) -> Array:
    """Return the widths of the ranges: infinite between the largest numbers, or NaN of no range."""
    with np.errstate(over="ignore", invalid="ignore"):
        return raw.upper - raw.lower


def _placeholders(
    names: tuple[str, ...], field: str, given: Array, free: NDArray[np.bool_], unit: str
) -> list[Finding]:
    findings = []
    for value in dict.fromkeys(given[free]):
        joints = [n for n, v, f in zip(names, given, free, strict=True) if f and v == value]
        subject = "all joints" if len(joints) == len(names) else ", ".join(joints)
        text = f"{field} limit {value:g} {unit} is a placeholder: taken as no limit"
        if np.isinf(value):
            text = f"the file gives no {field} limit"
        # A joint without a range is continuous; a motor without a limit has not been looked up.
        how: How = "found" if field == "range" and np.isinf(value) else "warning"
        findings.append(Finding("limits", subject, text, how))
    return findings


class _Sides:
    """Limits of joints and their partners; those of the joints to `keep` count, or the tighter."""

    def __init__(
        self, names: tuple[str, ...], mirror: Array, unequal: str, keep: NDArray[np.bool_] | None
    ) -> None:
        self.names, self.unequal, self.keep = names, unequal, keep
        self.partner = np.abs(mirror).argmax(axis=1)
        self.same = mirror[np.arange(len(names)), self.partner] > 0.0
        self.findings: list[Finding] = []  # what was settled
        self.differ: list[str] = []  # what differs too much
        self.broken: list[str] = []  # what cannot be meant

    def mirrored(self, limits: JointLimits) -> JointLimits:
        """Return the limits with left and right mirror images of each other."""
        pairs = [row for row, partner in enumerate(self.partner) if row <= partner]
        for field in _MOST:
            mine = getattr(limits, field)
            its = mine[self.partner]
            kept = np.minimum(mine, its) if self.keep is None else np.where(self.keep, mine, its)
            for row in pairs:
                if mine[row] == its[row]:
                    continue
                values = f"{_limit(mine[row])} and {_limit(its[row])} {LIMIT_UNITS[field]}"
                larger = max(mine[row], its[row])
                far = np.isinf(larger) or abs(mine[row] - its[row]) > _ALIKE * larger
                if self.unequal == "refuse" and far:
                    self.differ.append(f"the {field} limits of {self._quoted(row)}, {values}")
                else:
                    how = "tighter" if self.keep is None else self.unequal
                    self._settle(row, f"{field} limits {values} differ: {how}")
            limits = replace(limits, **{field: kept})
        lower, upper = limits.lower.copy(), limits.upper.copy()
        for row in pairs:
            there = int(self.partner[row])
            own, its = limits.range(row), _turned(limits.range(there), self.same[row])
            if own == its:
                continue
            kept = self._kept_range(row, own, its)
            if _apart(own, its) > _TOLD:
                spans = f"{_span(own)} and {_span(its)} (mirrored)"
                self._settle(row, f"ranges {spans} differ: taken as {_span(kept)}")
            lower[row], upper[row] = kept
            lower[there], upper[there] = _turned(kept, self.same[row])
        return replace(limits, lower=lower, upper=upper)

    def _quoted(self, row: int) -> str:
        return f"'{self.names[row]}' and '{self.names[self.partner[row]]}'"

    def _settle(self, row: int, text: str) -> None:
        pair = dict.fromkeys((self.names[row], self.names[self.partner[row]]))
        self.findings.append(Finding("limits", ", ".join(pair), text, "changed"))

    def _kept_range(self, row: int, own: _Range, its: _Range) -> _Range:
        """Return the range that holds for the first joint of a pair; note it if none can."""
        alone = self.partner[row] == row
        if self.keep is not None and not alone:
            return own if self.keep[row] else its
        common = max(own[0], its[0]), min(own[1], its[1])
        shared, narrow = common[1] - common[0], min(own[1] - own[0], its[1] - its[0])
        text = f"the ranges of {self._quoted(row)}, {_span(own)} and {_span(its)} (mirrored)"
        # The range seen if one of the joints turned the other way.
        flipped = _apart(own, (-its[1], -its[0])) <= max(_ROUNDING, _ALIKE * (own[1] - own[0]))
        if not shared > 0.0:
            why = ", and turned round they are alike" if flipped else ""
            self.broken.append(f"{text}, which have nothing in common{why}")
        elif alone or self.unequal != "refuse":
            return common
        elif _apart(own, its) > max(_ROUNDING, _ALIKE * narrow):
            if flipped:
                self.broken.append(f"{text}, {_FLIPPED}")
            elif shared < _COMMON * narrow:
                self.broken.append(f"{text}, which have only {_span(common)} in common")
            else:
                self.differ.append(text)
        return common

    def faults(self, limits: JointLimits) -> list[str]:
        """Return what is wrong with limits that differ, all joints in one sentence, if anything."""
        legs = "legs" if (self.partner == np.arange(len(self.names))[::-1]).all() else "sides"
        if self.broken:
            others = f"; besides, these differ: {'; '.join(self.differ)}" if self.differ else ""
            shared = (limits.lower < limits.upper).all()
            last = ' ("tighter" leaves only what both have in common)' if shared else ""
            return [
                f"the file is broken: it gives the {legs} limits that cannot both be meant: "
                f"{'; '.join(self.broken)}{others}; correct the <axis> or the range of one of the "
                f'two in the file, or say whose limits are right: unequal_limits = "right" or '
                f'"left" {_HINT}{last}'
            ]
        if not self.differ:
            return []
        return [
            f"the limits of the two {legs} differ by more than {100 * _ALIKE:g} %: "
            f"{'; '.join(self.differ)}; give both legs the same, or choose unequal_limits = "
            f'"tighter", "right" or "left" {_HINT}'
        ]


def _turned(ends: _Range, same: bool) -> _Range:
    return ends if same else (-ends[1], -ends[0])


def _limit(value: float) -> str:
    return "none" if np.isinf(value) else f"{value:.10g}"


def _span(ends: _Range) -> str:
    if np.isinf(ends).all():
        return "none"
    return f"{ends[0]:.6g} to {ends[1]:.6g} rad"


def _apart(first: _Range, other: _Range) -> float:
    """Largest difference of two ranges' ends; infinite ends on the same side are equal."""
    gaps = (0.0 if a == b else abs(a - b) for a, b in zip(first, other, strict=True))
    return max(gaps)
