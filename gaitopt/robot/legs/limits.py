"""Limits of the joints, read from the URDF and compared between the legs."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from gaitopt.errors import RobotError
from gaitopt.nlp import Array
from gaitopt.robot.findings import Finding

_RANGE_TOLERANCE = 1e-6  # rad
_ROUNDING = 1e-2  # rad: ranges that differ by less were meant to be mirror images
_MOST = {"torque": 5000.0, "speed": 50.0}  # N.m, rad/s: larger values stand for "no limit"
_WIDEST = 2.0 * np.pi  # rad: a range beyond a full turn to either side stands for "no limit"
_DEGREES = 200.0  # the widest range that a joint of a leg has to one side, if it is in degrees
_FEWEST = 10.0  # and the least
_UNITS = {"torque": "N·m", "speed": "rad/s"}


@dataclass(frozen=True)
class JointLimits:
    """Limits of the twelve joints, in the order of `Robot.joint_names`, shape (12,) each.

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
) -> tuple[JointLimits, list[Finding]]:
    """Read the limits of the leg joints.

    Args:
        model: of the robot.
        joints: the twelve, stance leg from ankle to hip, then swing leg from hip to ankle.
        mirror: the leg exchange E, shape (12, 12).
        unequal: what to do where the legs differ, one of `choices.UNEQUAL`.
        stance: which leg stands, "right" or "left".

    Returns:
        The limits, and what was found about them.

    Raises:
        RobotError: a limit is below zero, or the two legs differ.
    """
    names = tuple(str(model.names[j]) for j in joints)
    rows, angles = ([getattr(model.joints[j], i) for j in joints] for i in ("idx_v", "idx_q"))
    raw = JointLimits(
        torque=np.array(model.effortLimit)[rows],
        speed=np.array(model.velocityLimit)[rows],
        lower=np.array(model.lowerPositionLimit)[angles],
        upper=np.array(model.upperPositionLimit)[angles],
    )
    limits, findings = _without_placeholders(raw, names)
    other = mirrored_limits(limits, mirror)
    keep = (np.arange(12) < 6) == (unequal == stance)
    for field in ("torque", "speed"):
        mine, its = getattr(limits, field), getattr(other, field)
        differ = np.flatnonzero(mine != its)
        if unequal == "refuse" and differ.size:
            _refuse_values(names, mirror, field, mine, int(differ[0]))
        settled = np.minimum(mine, its) if unequal == "tighter" else np.where(keep, mine, its)
        limits = replace(limits, **{field: np.where(mine != its, settled, mine)})
        findings += _settled(names, mirror, field, (mine, its), unequal)
    return _settle_ranges(limits, other, names, mirror, unequal, keep, findings)


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
) -> tuple[JointLimits, list[Finding]]:
    findings, values = [], {}
    for field, most in _MOST.items():
        given = getattr(raw, field)
        for name, value in zip(names, given, strict=True):
            if value < 0.0 or np.isnan(value):
                raise RobotError(
                    f"the {field} limit of '{name}' is {value} {_UNITS[field]}; it must be > 0"
                )
        free = (given == 0.0) | (given > most)
        values[field] = np.where(free, np.inf, given)
        findings += _placeholders(names, field, given, free, _UNITS[field])
    values["lower"] = np.where(raw.lower < -_WIDEST, -np.inf, raw.lower)
    values["upper"] = np.where(raw.upper > _WIDEST, np.inf, raw.upper)
    wide = np.isinf(values["lower"]) | np.isinf(values["upper"])
    findings += _placeholders(names, "range", raw.upper - raw.lower, wide, "rad")
    findings = _degrees(names, raw, wide) + findings
    return JointLimits(**values), findings


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
        text = f"{field} limit {value:g} {unit} is a placeholder: taken as no limit"
        subject = "all joints" if len(joints) == len(names) else ", ".join(joints)
        findings.append(Finding("limits", subject, text, "warning"))
    return findings


def _refuse_values(
    names: tuple[str, ...], mirror: Array, field: str, values: Array, row: int
) -> None:
    partner = int(np.abs(mirror[row]).argmax())
    raise RobotError(
        f"the {field} limits of '{names[row]}' and its partner in the other leg, "
        f"'{names[partner]}', differ: {values[row]} and {values[partner]} {_UNITS[field]}; "
        f"make them equal in the URDF, or choose {_HINT}"
    )


_HINT = 'unequal_limits = "tighter", "right" or "left" in the file for --choices'


def _settled(
    names: tuple[str, ...],
    mirror: Array,
    field: str,
    values: tuple[Array, Array],
    unequal: str,
) -> list[Finding]:
    mine, its = values
    findings = []
    for row in np.flatnonzero(mine[:6] != its[:6]):
        pair = f"{names[row]}, {names[int(np.abs(mirror[row]).argmax())]}"
        text = f"{field} limits {mine[row]:g} and {its[row]:g} {_UNITS[field]} differ: {unequal}"
        findings.append(Finding("limits", pair, text, "changed"))
    return findings


def _settle_ranges(
    limits: JointLimits,
    other: JointLimits,
    names: tuple[str, ...],
    mirror: Array,
    unequal: str,
    keep: Array,
    findings: list[Finding],
) -> tuple[JointLimits, list[Finding]]:
    """Make the ranges of the legs mirror images, or refuse."""
    gap = np.maximum(_gap(limits.lower, other.lower), _gap(limits.upper, other.upper))
    lower, upper = limits.lower.copy(), limits.upper.copy()
    for row in np.flatnonzero(gap > _RANGE_TOLERANCE):
        own, its = (lower[row], upper[row]), (other.lower[row], other.upper[row])
        partner = names[int(np.abs(mirror[row]).argmax())]
        if unequal == "refuse" and gap[row] > _ROUNDING:
            raise RobotError(
                f"the range of '{names[row]}', {own[0]:g} to {own[1]:g} rad, is not the mirror "
                f"image of its partner's, '{partner}', which mirrors to {its[0]:g} to "
                f"{its[1]:g} rad; make the ranges of the two legs mirror images in the URDF, or "
                f"choose {_HINT}"
            )
        if unequal in ("refuse", "tighter"):
            kept = max(own[0], its[0]), min(own[1], its[1])
        else:
            kept = own if keep[row] else its
        if not kept[0] < kept[1]:
            raise RobotError(
                f"the ranges of '{names[row]}' and its partner '{partner}', {own[0]:g} to "
                f"{own[1]:g} rad and {its[0]:g} to {its[1]:g} rad (mirrored), have nothing in "
                'common; choose unequal_limits = "right" or "left" in the file for --choices'
            )
        lower[row], upper[row] = kept
        if row < 6:
            text = (
                f"ranges {own[0]:g} to {own[1]:g} and {its[0]:g} to {its[1]:g} rad (mirrored) "
                f"differ: taken as {kept[0]:g} to {kept[1]:g} rad"
            )
            findings.append(Finding("limits", f"{names[row]}, {partner}", text, "changed"))
    return replace(limits, lower=lower, upper=upper), findings


def _gap(mine: Array, its: Array) -> Array:
    # Two infinite ends on the same side are equal; their difference is not a number.
    same = mine == its
    gap: Array = np.abs(np.where(same, 0.0, mine) - np.where(same, 0.0, its))
    return gap
