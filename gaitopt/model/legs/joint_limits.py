"""Limits of the joints, read from the file and compared between the legs.

Where left and right differ by no more than rounding and fits do, the tighter of both holds: it is
kept by either leg. Where they differ by more, someone has to say which is right.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from gaitopt.importers.report import Finding, How
from gaitopt.nlp import Array

_ALIKE = 0.02  # of the larger one: limits that differ by less are settled, the tighter holds
_ROUNDING = 1e-2  # rad: the same for the ends of ranges, however narrow
_TOLD = 1e-6  # rad: ends of ranges that differ by less are not worth a word
_COMMON = 0.5  # of the narrower range: where two have less in common, one of them is wrong
_MOST = {"torque": 5000.0, "speed": 50.0}  # N.m, rad/s: larger values stand for "no limit"
_WIDEST = 2.0 * np.pi  # rad: a range beyond a full turn to either side stands for "no limit"
_DEGREES = 200.0  # the widest range that a joint of a leg has to one side, if it is in degrees
_FEWEST = 10.0  # and the least
_UNITS = {"torque": "N·m", "speed": "rad/s"}


@dataclass(frozen=True)
class JointLimits:
    """Limits of the n joints, in the order of `Robot.joint_names`, shape (n,) each.

    Attributes:
        torque: largest |torque| [N.m], infinite where there is no limit.
        speed: largest |rate| [rad/s], infinite where there is no limit.
        lower, upper: joint range [rad], infinite where there is no limit.
    """

    torque: Array
    speed: Array
    lower: Array
    upper: Array


def joint_limits(
    model: pin.Model,
    joints: tuple[int, ...],
    mirror: Array,
    unequal: str = "refuse",
    stance: str = "right",
) -> tuple[JointLimits, list[Finding], list[str]]:
    """Read the limits of the leg joints.

    Args:
        model: of the robot.
        joints: stance leg from ankle to hip, then swing leg from hip to ankle, then others.
        mirror: the leg exchange E, shape (n, n).
        unequal: what to do where the legs differ, one of `choices.UNEQUAL`.
        stance: which leg stands, "right" or "left".

    Returns:
        The limits, what was found about them, and what is wrong with them: limits below zero, or
        legs that differ. Where something is wrong the limits are the tighter ones, to be shown.
    """
    names = tuple(str(model.names[j]) for j in joints)
    rows, angles = ([getattr(model.joints[j], i) for j in joints] for i in ("idx_v", "idx_q"))
    raw = JointLimits(
        torque=np.array(model.effortLimit)[rows],
        speed=np.array(model.velocityLimit)[rows],
        lower=np.array(model.lowerPositionLimit)[angles],
        upper=np.array(model.upperPositionLimit)[angles],
    )
    limits, findings, faults = _without_placeholders(raw, names)
    partner = np.abs(mirror).argmax(axis=1)
    legs = _Legs(names, partner, mirror[np.arange(len(names)), partner], unequal, stance)
    limits, told, differ, broken = _settled(limits, mirror, legs)
    shared = bool((limits.lower < limits.upper).all())
    fault = _difference_fault(differ, broken, shared)
    return limits, findings + told, faults + ([fault] if fault else [])


@dataclass(frozen=True)
class _Legs:
    """Which joint is whose partner, and what to do where their limits differ."""

    names: tuple[str, ...]
    partner: NDArray[np.intp]
    signs: Array
    unequal: str
    stance: str

    @property
    def keep(self) -> NDArray[np.bool_]:
        """Whether a joint is of the leg whose limits count."""
        first = np.arange(len(self.partner)) < self.partner
        return np.asarray(first == (self.unequal == self.stance))

    @property
    def firsts(self) -> list[int]:
        """The first joint of every pair, and joints that are their own partners."""
        return [row for row, partner in enumerate(self.partner) if row <= partner]

    def pair(self, row: int) -> str:
        return f"{self.names[row]}, {self.names[self.partner[row]]}"

    def quoted(self, row: int) -> str:
        return f"'{self.names[row]}' and '{self.names[self.partner[row]]}'"


def mirrored_limits(limits: JointLimits, mirror: Array) -> JointLimits:
    """Return the limits with the legs exchanged."""
    partner = np.abs(mirror).argmax(axis=1)
    same = mirror[np.arange(len(partner)), partner] > 0.0
    lower, upper = limits.lower[partner], limits.upper[partner]
    return JointLimits(
        torque=limits.torque[partner],
        speed=limits.speed[partner],
        lower=np.where(same, lower, -upper),
        upper=np.where(same, upper, -lower),
    )


def _without_placeholders(
    raw: JointLimits, names: tuple[str, ...]
) -> tuple[JointLimits, list[Finding], list[str]]:
    findings, faults, values = [], [], {}
    for field, most in _MOST.items():
        given = getattr(raw, field)
        for name, value in zip(names, given, strict=True):
            if value < 0.0 or np.isnan(value):
                faults.append(
                    f"the {field} limit of '{name}' is {value} {_UNITS[field]}; it must be > 0"
                )
        free = ~(given > 0.0) | (given > most)
        values[field] = np.where(free, np.inf, given)
        stands = free & (given >= 0.0)
        findings += _placeholders(names, field, given, stands, _UNITS[field])
    values["lower"] = np.where(raw.lower < -_WIDEST, -np.inf, raw.lower)
    values["upper"] = np.where(raw.upper > _WIDEST, np.inf, raw.upper)
    wide = np.isinf(values["lower"]) | np.isinf(values["upper"])
    findings += _placeholders(names, "range", raw.upper - raw.lower, wide, "rad")
    findings = _degrees(names, raw, wide) + findings
    return JointLimits(**values), findings, faults


def _degrees(names: tuple[str, ...], raw: JointLimits, wide: NDArray[np.bool_]) -> list[Finding]:
    """Warn where most ranges are wider than a turn, yet would be those of a leg in degrees."""
    most = np.maximum(np.abs(raw.lower), np.abs(raw.upper))
    rows = np.flatnonzero(wide & (most <= _DEGREES) & (most >= _FEWEST))
    # Placeholders are all alike, and alike to both sides; ranges of a leg are not.
    if len(rows) <= len(names) // 2 or len({*raw.lower[rows], *-raw.upper[rows]}) < 3:
        return []
    row = int(rows[0])
    text = (
        f"ranges as that of '{names[row]}', {raw.lower[row]:g} to {raw.upper[row]:g} rad, are "
        "more than a turn; are ranges of the file in degrees? They must be in rad"
    )
    return [Finding("limits", f"{len(rows)} joints", text, "warning")]


def _placeholders(
    names: tuple[str, ...], field: str, given: Array, free: NDArray[np.bool_], unit: str
) -> list[Finding]:
    findings = []
    for value in dict.fromkeys(given[free]):
        joints = [n for n, v, f in zip(names, given, free, strict=True) if f and v == value]
        subject = "all joints" if len(joints) == len(names) else ", ".join(joints)
        if np.isinf(value):
            text = f"the file gives no {field} limit"
        else:
            text = f"{field} limit {value:g} {unit} is a placeholder: taken as no limit"
        # A joint without a range is continuous; a motor without a limit has not been looked up.
        how: How = "found" if field == "range" and np.isinf(value) else "warning"
        findings.append(Finding("limits", subject, text, how))
    return findings


_HINT = "in the file for --choices"


def _settled(
    limits: JointLimits, mirror: Array, legs: _Legs
) -> tuple[JointLimits, list[Finding], list[str], list[str]]:
    """Make the limits of the legs mirror images.

    Returns:
        The limits, what was settled, what differs too much, and what cannot be meant.
    """
    other = mirrored_limits(limits, mirror)
    findings: list[Finding] = []
    differ: list[str] = []
    broken: list[str] = []
    for field, unit in _UNITS.items():
        mine, its = getattr(limits, field), getattr(other, field)
        tighter = np.minimum(mine, its)
        chosen = legs.unequal in ("right", "left")
        kept = np.where(legs.keep, mine, its) if chosen else tighter
        for row in (row for row in legs.firsts if mine[row] != its[row]):
            values = f"{mine[row]:.10g} and {its[row]:.10g} {unit}"
            larger = max(mine[row], its[row])
            far = np.isinf(larger) or abs(mine[row] - its[row]) > _ALIKE * larger
            if legs.unequal == "refuse" and far:
                differ.append(f"the {field} limits of {legs.quoted(row)}, {values}")
            else:
                how = legs.unequal if chosen else "tighter"
                text = f"{field} limits {values} differ: {how}"
                findings.append(Finding("limits", legs.pair(row), text, "changed"))
        limits = replace(limits, **{field: kept})
    lower, upper = limits.lower.copy(), limits.upper.copy()
    for row in legs.firsts:
        own, its = (limits.lower[row], limits.upper[row]), (other.lower[row], other.upper[row])
        if own == its:
            continue
        kept_range = _kept_range(row, own, its, legs, differ, broken)
        if max(_gap(own[0], its[0]), _gap(own[1], its[1])) > _TOLD:
            text = (
                f"ranges {_span(own)} and {_span(its)} (mirrored) differ: taken as "
                f"{_span(kept_range)}"
            )
            findings.append(Finding("limits", legs.pair(row), text, "changed"))
        lower[row], upper[row] = kept_range
        there = int(legs.partner[row])
        ends = kept_range if legs.signs[row] > 0.0 else (-kept_range[1], -kept_range[0])
        lower[there], upper[there] = ends
    return replace(limits, lower=lower, upper=upper), findings, differ, broken


_Range = tuple[float, float]


def _kept_range(
    row: int, own: _Range, its: _Range, legs: _Legs, differ: list[str], broken: list[str]
) -> _Range:
    """Return the range that holds for a joint of the standing leg; note it if none can."""
    if legs.unequal in ("right", "left"):
        return own if legs.keep[row] else its
    common = max(own[0], its[0]), min(own[1], its[1])
    shared, narrow = common[1] - common[0], min(own[1] - own[0], its[1] - its[0])
    gap = max(_gap(own[0], its[0]), _gap(own[1], its[1]))
    text = f"the ranges of {legs.quoted(row)}, {_span(own)} and {_span(its)} (mirrored)"
    if not shared > 0.0:
        why = ", and turned round they are alike" if _flipped(own, its) else ""
        broken.append(f"{text}, which have nothing in common{why}")
        return common
    if legs.unequal == "refuse" and gap > max(_ROUNDING, _ALIKE * narrow):
        if _flipped(own, its):
            broken.append(f"{text}, {_FLIPPED}")
        elif shared < _COMMON * narrow:
            broken.append(f"{text}, which have only {_span(common)} in common")
        else:
            differ.append(text)
    return common


_FLIPPED = (
    "which are alike when one of the two is turned round: an axis or a range has a wrong sign"
)


def _flipped(own: _Range, its: _Range) -> bool:
    """Tell whether the ranges would agree if one of the joints turned the other way."""
    apart = max(_gap(own[0], -its[1]), _gap(own[1], -its[0]))
    return apart <= max(_ROUNDING, _ALIKE * (own[1] - own[0]))


def _difference_fault(differ: list[str], broken: list[str], shared: bool) -> str:
    """Return what is wrong with limits that differ, all joints in one sentence.

    Args:
        differ: what differs too much.
        broken: what cannot be meant.
        shared: whether all ranges have something in common.
    """
    if broken:
        others = f"; besides, these differ: {'; '.join(differ)}" if differ else ""
        last = ' ("tighter" leaves only what both have in common)' if shared else ""
        return (
            f"the file is broken: it gives the legs limits that cannot both be meant: "
            f"{'; '.join(broken)}{others}; correct the <axis> or the range of one of the two in "
            f'the file, or say whose limits are right: unequal_limits = "right" or "left" '
            f"{_HINT}{last}"
        )
    if not differ:
        return ""
    return (
        f"the limits of the two legs differ by more than {100 * _ALIKE:g} %: {'; '.join(differ)}; "
        "make them mirror images in the file, or choose unequal_limits = "
        f'"tighter", "right" or "left" {_HINT}'
    )


def _span(ends: _Range) -> str:
    return f"{ends[0]:.6g} to {ends[1]:.6g} rad"


def _gap(mine: float, its: float) -> float:
    # Two infinite ends on the same side are equal; their difference is not a number.
    return 0.0 if mine == its else abs(mine - its)
