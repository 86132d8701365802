"""Limits, armatures, masses and inertias that the user sets in place of those of the file."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fnmatch import fnmatchcase

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.importers.pinocchio_model import inertia_fault
from gaitopt.importers.report import Finding
from gaitopt.importers.xml_document import FileProblem
from gaitopt.model.import_options import InertiaOverride, LimitOverride, matching

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
    names = [str(name) for name in model.names]
    for entry in overrides:
        meant = matching(entry.joints, names[2:])
        joints = [j for j, n in enumerate(names) if n in meant and model.joints[j].nq == 1]
        if not joints:
            if meant:
                raise RobotError(
                    f"limits: '{entry.joints}' matches only {', '.join(meant)}, without a range of "
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
    names = [str(name) for name in model.names]
    for entry in overrides:
        given = [side for side in ("lower", "upper") if getattr(entry, side) is not None]
        meant = matching(entry.joints, names[2:]) if given else []
        for joint in map(model.getJointId, meant):
            name, row = names[joint], model.joints[joint].idx_q
            if model.joints[joint].nq != 1:
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


_SAME = 1e-9  # relative: a joint's mass is that of its links, but for rounding
_SHOWN = 3  # links


def override_bodies(
    model: pin.Model, overrides: tuple[InertiaOverride, ...]
) -> tuple[pin.Model, list[Finding], frozenset[str]]:
    """Return a copy of the model with links replaced, what was replaced, and their names.

    Args:
        model: free-flyer and joints; its frames know the bodies of their links.
        overrides: the later one counts where two match.

    Raises:
        RobotError: a pattern matches no link, or leaves a body that cannot be.
    """
    changed, findings, names = model.copy(), [], set()
    for entry in overrides:
        links = [
            f for f in _links(changed) if fnmatchcase(str(changed.frames[f].name), entry.links)
        ]
        if not links:
            there = ", ".join(str(changed.frames[f].name) for f in _links(changed))
            raise RobotError(f"inertias: no link matches '{entry.links}'; the links are: {there}")
        before = []
        for link in links:
            before.append(_replace(changed, link, entry))
        named = [str(changed.frames[f].name) for f in links]
        names.update(named)
        findings.append(Finding("inertia", entry.links, _told(entry, named, before), "given"))
    return changed, findings, frozenset(names)


def without_mended(
    problems: Iterable[FileProblem], mended: frozenset[str]
) -> tuple[FileProblem, ...]:
    """Return the problems of a file without those of bodies that were replaced."""
    return tuple(
        p for p in problems if not (p.kind in ("inertia", "massless") and p.name in mended)
    )


def _links(model: pin.Model) -> list[int]:
    return [k for k, f in enumerate(model.frames) if f.type == pin.FrameType.BODY and f.parentJoint]


def _replace(model: pin.Model, link: int, entry: InertiaOverride) -> pin.Inertia:
    """Replace the body of a link in a model, return what it was."""
    frame = model.frames[link]
    joint = int(frame.parentJoint)
    beside = [k for k, f in enumerate(model.frames) if f.parentJoint == joint]
    _know_bodies(model, joint, beside)
    old = model.frames[link].inertia.copy()
    mass = float(old.mass) if entry.mass is None else entry.mass
    lever = np.array(old.lever) if entry.com is None else np.array(entry.com)
    if entry.inertia is None:
        turning = np.array(old.inertia) * (mass / old.mass if old.mass > 0.0 else 0.0)
    else:
        ixx, iyy, izz, ixy, ixz, iyz = entry.inertia
        turning = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    fault = inertia_fault(mass, turning)
    if fault or not mass > 0.0:
        reason = fault or "the link has no mass in the file; give its mass (kg) too"
        raise RobotError(f"inertias of '{entry.links}': link '{frame.name}': {reason}")
    new = pin.Inertia.Zero()
    new.mass, new.lever, new.inertia = mass, lever, turning
    model.frames[link].inertia = new
    total = pin.Inertia.Zero()
    for k in beside:
        other = model.frames[k]
        if other.inertia.mass > 0.0 or np.any(other.inertia.inertia):
            total += other.placement.act(other.inertia)
    model.inertias[joint] = total
    return old


def _know_bodies(model: pin.Model, joint: int, frames: list[int]) -> None:
    """See to it that the frames of a joint have the bodies of which its own consists.

    Raises:
        RobotError: it cannot be told which link has how much of it.
    """
    whole = model.inertias[joint]
    if abs(sum(model.frames[k].inertia.mass for k in frames) - whole.mass) <= _SAME * whole.mass:
        return
    links = [k for k in frames if model.frames[k].type == pin.FrameType.BODY]
    if len(links) != 1:
        names = ", ".join(f"'{model.frames[k].name}'" for k in links)
        raise RobotError(
            f"inertias: the bodies of the links {names} are one in the file; change them there"
        )
    model.frames[links[0]].inertia = model.frames[links[0]].placement.actInv(whole)


def _told(entry: InertiaOverride, links: list[str], before: list[pin.Inertia]) -> str:
    parts = []
    if entry.mass is not None:
        parts.append(f"mass {entry.mass:g} kg")
    if entry.com is not None:
        parts.append("centre of mass ({:g}, {:g}, {:g}) m".format(*entry.com))
    if entry.inertia is not None:
        parts.append("inertia ({:g}, {:g}, {:g}, {:g}, {:g}, {:g}) kg·m²".format(*entry.inertia))
    was = ", ".join(
        f"'{name}' {body.mass:g} kg" for name, body in zip(links[:_SHOWN], before, strict=False)
    )
    more = f" and {len(links) - _SHOWN} more" if len(links) > _SHOWN else ""
    return f"{', '.join(parts)} in place of those of the file: {was}{more}"
