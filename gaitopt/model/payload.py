"""Loads that are fixed to links: their masses, on top of those of the file."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError, did_you_mean
from gaitopt.importers.report import Finding
from gaitopt.model.import_options import Payload
from gaitopt.model.legs.kinematic_tree import LegJoints

TORSO, PELVIS = "torso", "pelvis"
"""Names that mean a link of any robot, if none of its links bears them."""


def add_payloads(
    model: pin.Model, payloads: Iterable[Payload], legs: LegJoints
) -> tuple[tuple[Payload, ...], list[Finding]]:
    """Fix loads to the links of a model, in place.

    Returns:
        The loads with names of links of the file and with their places; what is said of them.

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


def _links(model: pin.Model) -> dict[str, int]:
    """Return the frames of links by name."""
    return {
        str(frame.name): row
        for row, frame in enumerate(model.frames)
        if frame.type == pin.FrameType.BODY and frame.parentJoint
    }


def _placed(model: pin.Model, payload: Payload, legs: LegJoints) -> Payload:
    links, name = _links(model), payload.link
    if name not in links and name in (TORSO, PELVIS):
        name = _link_of(model, _pelvis(model, legs) if name == PELVIS else _torso(model, legs))
    if name not in links:
        raise RobotError(
            f"payload: there is no link '{name}'; {did_you_mean(name, links)}give {TORSO}, "
            f"{PELVIS} or one of "
            f"{', '.join(links)}"
        )
    if payload.place is not None:
        return replace(payload, link=name)
    frame = model.frames[links[name]]
    own = frame.inertia if frame.inertia.mass > 0.0 else None
    joint = frame.placement.actInv(model.inertias[frame.parentJoint].lever)
    x, y, z = (float(n) for n in (joint if own is None else own.lever))
    return replace(payload, link=name, place=(x, y, z))


def _pelvis(model: pin.Model, legs: LegJoints) -> int:
    """Return the joint of the body that carries both legs."""
    above = [_ancestors(model, leg[0])[1:] for leg in legs]
    return next(joint for joint in above[0] if joint in above[1])


def _torso(model: pin.Model, legs: LegJoints) -> int:
    """Return the joint of the heaviest body that is not of the legs."""
    hips = {leg[0] for leg in legs}
    others = [j for j in range(1, model.njoints) if not hips & {*_ancestors(model, j)}]
    return max(others, key=lambda joint: float(model.inertias[joint].mass))


def _ancestors(model: pin.Model, joint: int) -> list[int]:
    """Return a joint and those towards the root."""
    found = []
    while joint:
        found.append(joint)
        joint = int(model.parents[joint])
    return found


def _link_of(model: pin.Model, joint: int) -> str:
    """Return the heaviest link of a joint's body."""
    own = [row for row in _links(model).values() if model.frames[row].parentJoint == joint]
    return str(model.frames[max(own, key=lambda row: float(model.frames[row].inertia.mass))].name)
