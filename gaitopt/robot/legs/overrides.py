"""Limits and armatures that the user sets joint by joint, in place of those of the file."""

from __future__ import annotations

from dataclasses import replace
from fnmatch import fnmatchcase

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.robot.choices import LimitOverride
from gaitopt.robot.findings import Finding

_ENTRIES = {
    "torque": ("effortLimit", "N·m"),
    "speed": ("velocityLimit", "rad/s"),
    "lower": ("lowerPositionLimit", "rad"),
    "upper": ("upperPositionLimit", "rad"),
    "armature": ("armature", "kg·m²"),
}

_BELOW = {"torque": "lowerEffortLimit", "speed": "lowerVelocityLimit"}


def override(
    model: pin.Model, overrides: tuple[LimitOverride, ...]
) -> tuple[pin.Model, list[Finding]]:
    """Return a copy of the model with the limits replaced, and what was replaced.

    Args:
        model: free-flyer and joints.
        overrides: the later one counts where two match.

    Raises:
        RobotError: a pattern matches no joint with one coordinate, or leaves it an empty range.
    """
    changed, findings = model.copy(), []
    names = [str(n) for n in model.names]
    for entry in overrides:
        joints = [
            j
            for j in range(2, model.njoints)
            if fnmatchcase(names[j], entry.joints) and model.joints[j].nq == 1
        ]
        if not joints:
            free = [n for n in names[2:] if fnmatchcase(n, entry.joints)]
            if free:
                raise RobotError(
                    f"limits: '{entry.joints}' matches only {', '.join(free)}, without a range of "
                    "one angle (continuous joints have none); give a joint that has a range"
                )
            raise RobotError(
                f"limits: no joint matches '{entry.joints}'; the joints are: {', '.join(names[2:])}"
            )
        parts = [_set(changed, joints, name, v) for name, v in entry.numbers().items()]
        count = "one joint" if len(joints) == 1 else f"{len(joints)} joints"
        source = f"; {entry.source}" if entry.source else ""
        text = f"{', '.join(parts)} ({count}){source}"
        findings.append(Finding("limits", entry.joints, text, "given"))
    _check_ranges(changed, overrides)
    return changed, _joined(findings)


def without_armature(overrides: tuple[LimitOverride, ...]) -> tuple[LimitOverride, ...]:
    """Return the overrides without their armatures; those that set nothing else are left out."""
    bare = (replace(entry, armature=None) for entry in overrides)
    return tuple(entry for entry in bare if entry.numbers())


def _check_ranges(model: pin.Model, overrides: tuple[LimitOverride, ...]) -> None:
    """Refuse an end of a range that is beyond the other end, which may be that of the file."""
    for entry in overrides:
        given = [side for side in ("lower", "upper") if getattr(entry, side) is not None]
        for joint in range(2, model.njoints) if given else ():
            name, row = str(model.names[joint]), model.joints[joint].idx_q
            if model.joints[joint].nq != 1 or not fnmatchcase(name, entry.joints):
                continue
            lower, upper = model.lowerPositionLimit[row], model.upperPositionLimit[row]
            if not lower < upper:
                raise RobotError(
                    f"limits of '{entry.joints}': with the {' and '.join(given)} given there, the "
                    f"range of joint '{name}' is from lower = {lower:g} rad to upper = {upper:g} "
                    "rad; lower must be below upper; correct it, or give both"
                )


def _joined(findings: list[Finding]) -> list[Finding]:
    """Say once what holds for many joints."""
    by_text: dict[str, list[str]] = {}
    for finding in findings:
        by_text.setdefault(finding.text, []).append(finding.subject)
    return [Finding("limits", ", ".join(s), text, "given") for text, s in by_text.items()]


def _set(model: pin.Model, joints: list[int], field: str, value: float) -> str:
    attribute, unit = _ENTRIES[field]
    values = np.array(getattr(model, attribute))
    for joint in joints:
        at = model.joints[joint]
        values[at.idx_q if field in ("lower", "upper") else at.idx_v] = value
    setattr(model, attribute, values)
    if (below := _BELOW.get(field)) is not None:  # kept apart by Pinocchio, which compares the two
        lower = np.array(getattr(model, below))
        lower[[model.joints[joint].idx_v for joint in joints]] = -value
        setattr(model, below, lower)
    return f"{field} {value:g} {unit}"
