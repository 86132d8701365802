"""Limits, armatures, masses and inertias in place of those of the file, and loads on top of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from fnmatch import fnmatchcase

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError, did_you_mean
from gaitopt.importers.pinocchio_model import inertia_fault, rigid_body
from gaitopt.importers.report import Finding
from gaitopt.importers.xml_document import FileProblem
from gaitopt.model.import_options import (
    LIMIT_UNITS,
    InertiaOverride,
    LimitOverride,
    Payload,
    matching,
)
from gaitopt.model.kinematic_tree import LegJoints, joint_slides
from gaitopt.model.leg_detection import joint_count
from gaitopt.units import motion_words

_ATTRIBUTES = {
    "torque": "effortLimit",
    "speed": "velocityLimit",
    "lower": "lowerPositionLimit",
    "upper": "upperPositionLimit",
    "armature": "armature",
}

# Kept apart by Pinocchio, which compares the two.
_OPPOSITE = {"torque": "lowerEffortLimit", "speed": "lowerVelocityLimit"}
_SAME_MASS = 1e-9  # relative: a joint's mass is that of its links, but for rounding
_SHOWN = 3  # links
TORSO, PELVIS = "torso", "pelvis"
"""Names that mean a link of any robot, if none of its links bears them."""


def override(
    model: pin.Model, overrides: tuple[LimitOverride, ...]
) -> tuple[pin.Model, list[Finding]]:
    """Return a copy of the model with the limits replaced, the later where two match, and how.

    Raises:
        RobotError: a pattern matches no joint with one coordinate, or leaves it an empty range; or
            a limit has another unit than a joint.
    """
    changed, told = model.copy(), dict[tuple[str, str], tuple[list[str], set[int]]]()
    names = [str(name) for name in model.names]
    for entry in overrides:
        meant = matching(entry.joints, names[2:])
        joints = [j for j, n in enumerate(names) if n in meant and model.joints[j].nq == 1]
        if not joints and meant:
            raise RobotError(
                f"limits: '{entry.joints}' matches only {', '.join(meant)}, without a range of "
                "one angle (continuous joints have none); give a joint that has a range"
            )
        if not joints:
            raise RobotError(
                f"limits: no joint matches '{entry.joints}'; "
                f"{did_you_mean(entry.joints, names[2:])}the joints are: {', '.join(names[2:])}"
            )
        _check_units(entry, {names[j]: joint_slides(model.joints[j]) for j in joints})
        source = f"; {entry.source}" if entry.source else ""
        for slides in (False, True):
            if own := [j for j in joints if joint_slides(model.joints[j]) == slides]:
                each = (_set(changed, own, name, v) for name, v in entry.numbers().items())
                text = motion_words(", ".join(each), slides=slides)
                patterns, meant_by_them = told.setdefault((text, source), ([], set()))
                patterns.append(entry.joints)
                meant_by_them.update(own)
    _check_ranges(changed, overrides)
    return changed, [
        Finding("limits", ", ".join(subject), f"{text} ({joint_count(len(own))}){source}", "given")
        for (text, source), (subject, own) in told.items()
    ]


def _check_units(entry: LimitOverride, slides: Mapping[str, bool]) -> None:
    """Refuse a limit with units of joints that turn at one that slides, by name, or the reverse."""
    for name, one in slides.items():
        fitting = {motion_words(LIMIT_UNITS[what], slides=one): None for what in entry.numbers()}
        if wrong := [unit for unit in entry.units if unit not in fitting]:
            raise RobotError(
                f"limits of '{entry.joints}': given in {wrong[0]}, but joint '{name}' "
                f"{'slides' if one else 'turns'}; give {', '.join(fitting)}, or a pattern that "
                "does not mean this joint"
            )


def without_armature(overrides: tuple[LimitOverride, ...]) -> tuple[LimitOverride, ...]:
    """Return the overrides without their armatures; those that set nothing else are left out."""
    bare = (replace(entry, armature=None) for entry in overrides)
    return tuple(entry for entry in bare if entry.numbers())


def _check_ranges(model: pin.Model, overrides: tuple[LimitOverride, ...]) -> None:
    """Refuse an end of a range that is beyond the other end, which may be that of the file."""
    for entry in overrides:
        given = [side for side in ("lower", "upper") if getattr(entry, side) is not None]
        for name in matching(entry.joints, map(str, model.names[2:])) if given else ():
            at = model.joints[model.getJointId(name)]
            lower, upper = model.lowerPositionLimit[at.idx_q], model.upperPositionLimit[at.idx_q]
            if at.nq == 1 and not lower < upper:
                unit = motion_words("rad", slides=joint_slides(at))
                raise RobotError(
                    f"limits of '{entry.joints}': with the {' and '.join(given)} given there, the "
                    f"range of joint '{name}' is from lower = {lower:g} {unit} to upper = "
                    f"{upper:g} {unit}; lower must be below upper; correct it, or give both"
                )


def _set(model: pin.Model, joints: list[int], field: str, value: float) -> str:
    """Set a limit of some joints; return it in words."""
    row = "idx_q" if field in ("lower", "upper") else "idx_v"
    rows = [getattr(model.joints[joint], row) for joint in joints]
    for name, number in ((_ATTRIBUTES[field], value), (_OPPOSITE.get(field), -value)):
        if name is not None:
            getattr(model, name)[rows] = number
    return f"{field} {value:g} {LIMIT_UNITS[field]}"


def override_bodies(
    model: pin.Model, overrides: tuple[InertiaOverride, ...]
) -> tuple[pin.Model, list[Finding], frozenset[str]]:
    """Return a copy of the model with links replaced, what was replaced, and their names.

    The later override counts where two match; frames of the model know the bodies of their links.

    Raises:
        RobotError: a pattern matches no link, or leaves a body that cannot be.
    """
    changed, findings, names = model.copy(), [], set()
    for entry in overrides:
        links = _links(changed)
        meant = [name for name in links if fnmatchcase(name, entry.links)]
        if not meant:
            raise RobotError(
                f"inertias: no link matches '{entry.links}'; {did_you_mean(entry.links, links)}"
                f"the links are: {', '.join(links)}"
            )
        before = {name: _replace(changed, links[name], entry) for name in meant}
        names.update(meant)
        findings.append(Finding("inertia", entry.links, _body_words(entry, before), "given"))
    return changed, findings, frozenset(names)


def _links(model: pin.Model) -> dict[str, int]:
    """Return the frames of links by name."""
    return {
        str(frame.name): row
        for row, frame in enumerate(model.frames)
        if frame.type == pin.FrameType.BODY and frame.parentJoint
    }


def without_mended(
    problems: Iterable[FileProblem], mended: frozenset[str]
) -> tuple[FileProblem, ...]:
    """Return the problems of a file without those of bodies that were replaced."""
    return tuple(
        p for p in problems if not (p.kind in ("inertia", "massless") and p.name in mended)
    )


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
    model.frames[link].inertia = rigid_body(mass, lever, turning)
    total = pin.Inertia.Zero()
    for k in beside:
        other = model.frames[k]
        if other.inertia.mass > 0.0 or np.any(other.inertia.inertia):
            total += other.placement.act(other.inertia)
    model.inertias[joint] = total
    return old


def _know_bodies(model: pin.Model, joint: int, frames: list[int]) -> None:
    """See to it that the frames of a joint have its bodies; refuse it if that cannot be told."""
    whole = model.inertias[joint]
    if (
        abs(sum(model.frames[k].inertia.mass for k in frames) - whole.mass)
        <= _SAME_MASS * whole.mass
    ):
        return
    links = [k for k in frames if model.frames[k].type == pin.FrameType.BODY]
    if len(links) != 1:
        names = ", ".join(f"'{model.frames[k].name}'" for k in links)
        raise RobotError(
            f"inertias: the bodies of the links {names} are one in the file; change them there"
        )
    model.frames[links[0]].inertia = model.frames[links[0]].placement.actInv(whole)


def _body_words(entry: InertiaOverride, before: dict[str, pin.Inertia]) -> str:
    parts = []
    if entry.mass is not None:
        parts.append(f"mass {entry.mass:g} kg")
    if entry.com is not None:
        parts.append("centre of mass ({:g}, {:g}, {:g}) m".format(*entry.com))
    if entry.inertia is not None:
        parts.append("inertia ({:g}, {:g}, {:g}, {:g}, {:g}, {:g}) kg·m²".format(*entry.inertia))
    was = ", ".join(f"'{name}' {body.mass:g} kg" for name, body in list(before.items())[:_SHOWN])
    more = f" and {len(before) - _SHOWN} more" if len(before) > _SHOWN else ""
    return f"{', '.join(parts)} in place of those of the file: {was}{more}"


def add_payloads(
    model: pin.Model, payloads: Iterable[Payload], legs: LegJoints
) -> tuple[tuple[Payload, ...], list[Finding]]:
    """Fix loads to the links of a model, in place; return them with links and places of the file.

    And what is said of them.

    Raises:
        RobotError: there is no link of that name.
    """
    placed = [_placed(model, payload, legs) for payload in payloads]
    findings = []
    for payload in placed:
        frame = model.frames[_links(model)[payload.link]]
        body = pin.Inertia.FromBox(payload.mass, *payload.box)
        body.lever = np.array(payload.place)
        model.inertias[frame.parentJoint] += frame.placement.act(body)
        box = " x ".join(f"{length:g}" for length in payload.box)
        shape = f", a box of {box} m" if any(payload.box) else ""
        at = "({:g}, {:g}, {:g})".format(*np.round(body.lever, 6))
        text = f"carries {payload.mass:g} kg at {at} m of its frame{shape}"
        findings.append(Finding("payload", payload.link, text, "given"))
    return tuple(placed), findings


def loaded_joints(model: pin.Model, payloads: Iterable[Payload]) -> frozenset[int]:
    """Return the joints of the links that loads name; those of no such link are left out."""
    links = _links(model)
    return frozenset(
        int(model.frames[links[p.link]].parentJoint) for p in payloads if p.link in links
    )


def _placed(model: pin.Model, payload: Payload, legs: LegJoints) -> Payload:
    links, name = _links(model), payload.link
    if name not in links and name in (TORSO, PELVIS):
        joint = int(model.parents[legs[0][0]])
        if name == TORSO:  # the heaviest body that is not of the legs
            hips = {leg[0] for leg in legs}
            others = [j for j in range(1, model.njoints) if hips.isdisjoint(model.supports[j])]
            joint = max(others, key=lambda j: float(model.inertias[j].mass))
        name = _link_of(model, joint)
    if name not in links:
        names = list(dict.fromkeys((TORSO, PELVIS, *links)))
        raise RobotError(
            f"payload: there is no link '{name}'; {did_you_mean(name, names)}give one of "
            f"{', '.join(names)}"
        )
    if payload.place is not None:
        return replace(payload, link=name)
    frame = model.frames[links[name]]
    own = frame.inertia if frame.inertia.mass > 0.0 else None
    whole = frame.placement.actInv(model.inertias[frame.parentJoint].lever)
    x, y, z = (float(n) for n in (whole if own is None else own.lever))
    return replace(payload, link=name, place=(x, y, z))


def _link_of(model: pin.Model, joint: int) -> str:
    """Return the heaviest link of a joint's body."""
    own = [row for row in _links(model).values() if model.frames[row].parentJoint == joint]
    return str(model.frames[max(own, key=lambda row: float(model.frames[row].inertia.mass))].name)
