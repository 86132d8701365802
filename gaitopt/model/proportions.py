"""Other thighs, shins and feet, hips farther apart, heavier parts than those of the file.

Both legs change alike. A thigh or a shin that gets longer is stretched along its length, about the
joint above it, with its mass; all that hangs on it moves along. A foot is stretched along its sole,
about the last joint, with its mass and with the edges of the sole; under an ankle that gets higher
the foot stays as it is. A part that gets heavier does so with its inertia about any point. What
stands still on a part belongs to it. Shapes stay as the file draws them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.importers.pinocchio_model import rigid_body
from gaitopt.importers.report import Finding
from gaitopt.model.import_options import (
    ANKLE_HEIGHT,
    FOOT,
    HIP_WIDTH,
    SHIN,
    THIGH,
    TRUNK,
    PartChange,
)
from gaitopt.model.kinematic_tree import LegJoints, PosedModel, points_on_lines
from gaitopt.model.leg_geometry import centre, find_knee, hip_and_ankle
from gaitopt.model.sole_frames import Soles
from gaitopt.nlp import Array

_LEAST = 0.1  # of a length or mass of the file: what must be left of it


def proportioned(
    straight: PosedModel,
    legs: LegJoints,
    moving: Sequence[int],
    rotation: Array,
    changes: Sequence[PartChange],
) -> tuple[pin.Model, list[Finding]]:
    """Return a copy of a model with parts changed, and what was changed; soles come afterwards.

    Args:
        moving: joints that move; bodies that others join are one part.
        rotation: as of `Heading`.

    Raises:
        RobotError: next to nothing would be left of a part.
    """
    model, findings = straight.model.copy(), []
    parts = _Parts(model, straight, legs, moving)
    knees = [_knee(straight, leg, rotation) for leg in legs]
    for one in changes:
        words = []
        if one.longer and one.part not in (FOOT, ANKLE_HEIGHT):
            words.append(_told(parts.lengthen(one, knees, rotation), one.longer, "m"))
        if one.heavier:
            words.append(_told(parts.weigh(one, knees), one.heavier, "kg"))
        if words:
            findings.append(_finding(one.part, ", ".join(words)))
    return model, findings


def change_feet(
    straight: PosedModel,
    legs: LegJoints,
    moving: Sequence[int],
    soles: Soles,
    ankle: float,
    changes: Sequence[PartChange],
) -> tuple[Soles, list[Finding]]:
    """Change the feet of a model, ankles at a height [m]; return soles, and what was changed.

    Raises:
        RobotError: next to nothing would be left of a foot.
    """
    parts, findings = _Parts(straight.model, straight, legs, moving), []
    for one in changes:
        if not one.longer or one.part not in (FOOT, ANKLE_HEIGHT):
            continue
        own = soles.sole.length if one.part == FOOT else ankle
        _refuse_little(one, own, one.longer, "m")
        change = parts.stretch_feet if one.part == FOOT else parts.lower_feet
        soles = change(soles, one.longer)
        findings.append(_finding(one.part, _told(own, one.longer, "m")))
    return soles, findings


def _told(own: float, more: float, unit: str) -> str:
    return f"{own:.4g} {unit} in the file, {own + more:.4g} {unit} as asked"


def _finding(part: str, text: str) -> Finding:
    return Finding("proportions", part.replace("_", " "), text, "given")


class _Knee(NamedTuple):
    """The knee of a leg: its row, how far left its hip is, the level ways to hip and ankle [m]."""

    row: int
    left: float
    hip: Array
    ankle: Array


def _knee(straight: PosedModel, leg: tuple[int, ...], rotation: Array) -> _Knee:
    rows = list(leg)
    axes = straight.axes[rows] @ rotation
    points = points_on_lines(straight.points[rows] @ rotation, axes, [0, *range(len(rows) - 1)])
    parts = hip_and_ankle(points, axes)
    hip, ankle = (centre(points, axes, part) for part in parts)
    beyond = range(len(parts[0]), len(rows))
    row = find_knee(points, axes, hip, ankle, np.zeros(len(rows)), beyond).row
    u = axes[row]
    level = [v - (v @ u) * u for v in (hip - points[row], ankle - points[row])]
    return _Knee(row, float(hip[1]), rotation @ level[0], rotation @ level[1])


class _Parts:
    """The parts of a model that is changed, as they stand with all leg angles 0."""

    def __init__(
        self, model: pin.Model, straight: PosedModel, legs: LegJoints, moving: Sequence[int]
    ) -> None:
        self.model, self.at, self.legs, self.moving = model, straight.placements, legs, moving

    def lengthen(self, one: PartChange, knees: Sequence[_Knee], rotation: Array) -> float:
        """Change a length of both legs; return what it was [m]."""
        at, legs = self.at, self.legs
        if one.part == HIP_WIDTH:
            across = [knee.left for knee in knees]
            own, sign = abs(across[1] - across[0]), float(np.sign(across[1] - across[0]))
            _refuse_little(one, own, one.longer, "m")
            for leg, side in zip(legs, (-sign, sign), strict=True):
                move = rotation @ np.array([0.0, 0.5 * side * one.longer, 0.0])
                self.move(leg[0], at[int(self.model.parents[leg[0]])].rotation.T @ move)
            return own
        lengths: list[float] = []
        for leg, knee in zip(legs, knees, strict=True):
            end = -knee.hip if one.part == THIGH else knee.ankle
            own = float(np.linalg.norm(end))
            _refuse_little(one, own, one.longer, "m")
            e, lengths = end / own, [*lengths, own]
            above = leg[knee.row - 1] if one.part == THIGH else leg[knee.row]
            below = leg[knee.row] if one.part == THIGH else leg[knee.row + 1]
            size = float(e @ (at[below].translation - at[above].translation))
            self.stretch(above, e, 1.0 + one.longer / size)
        return float(np.mean(lengths))

    def weigh(self, one: PartChange, knees: Sequence[_Knee]) -> float:
        """Change the mass of the trunk, or of a part of each leg; return what it was [kg]."""
        model, legs = self.model, self.legs
        if one.part == TRUNK:
            joints = [int(model.parents[legs[0][0]])]
        else:
            rows = {THIGH: -1, SHIN: 0}
            joints = [
                leg[-1] if one.part == FOOT else leg[knee.row + rows[one.part]]
                for leg, knee in zip(legs, knees, strict=True)
            ]
        masses = []
        for joint in joints:
            part = self.around(joint)
            own = sum(float(model.inertias[body].mass) for body in part)
            _refuse_little(one, own, one.heavier, "kg")
            masses.append(own)
            factor = 1.0 + one.heavier / own
            for body in part:
                model.inertias[body] = _heavier(model.inertias[body], factor)
            for frame in model.frames:
                if int(frame.parentJoint) in part:
                    frame.inertia = _heavier(frame.inertia, factor)
        return float(np.mean(masses))

    def stretch_feet(self, soles: Soles, longer: float) -> Soles:
        """Change the length of both feet; return their soles."""
        factor = 1.0 + longer / soles.sole.length
        for foot, place in zip(self.feet, soles.placements, strict=True):
            self.stretch(foot, self.at[foot].rotation @ place.rotation[:, 0], factor)
        self.place(soles, soles.placements)
        ankle = float(np.mean([place.inverse().translation[0] for place in soles.placements]))
        toe, heel = (ankle + factor * (x - ankle) for x in (soles.sole.toe, soles.sole.heel))
        return replace(soles, sole=replace(soles.sole, toe=toe, heel=heel))

    def lower_feet(self, soles: Soles, longer: float) -> Soles:
        """Change the height of both ankles; return the soles."""
        model, places = self.model, []
        for foot, place in zip(self.feet, soles.placements, strict=True):
            down = -longer * place.rotation[:, 2]
            body = model.inertias[foot]
            model.inertias[foot] = rigid_body(body.mass, body.lever + down, body.inertia)
            for child in range(2, model.njoints):
                if int(model.parents[child]) == foot:
                    self.move(child, down)
            for frame in model.frames:
                if int(frame.parentJoint) == foot and frame.type != pin.FrameType.JOINT:
                    _lower(frame, down)
            places.append(pin.SE3(place.rotation, place.translation + down))
        self.place(soles, places)
        return replace(soles, placements=(places[0], places[1]))

    @property
    def feet(self) -> list[int]:
        """The last joints of the legs."""
        return [leg[-1] for leg in self.legs]

    def place(self, soles: Soles, places: Sequence[pin.SE3]) -> None:
        """Place the sole frames that the file has."""
        if not soles.added:
            for name, place in zip(soles.names, places, strict=True):
                self.model.frames[self.model.getFrameId(name)].placement = place

    def around(self, joint: int) -> list[int]:
        """Return the joints whose bodies stand still on that of one, it included."""
        model, moving, found, top = self.model, self.moving, [joint], joint
        while top not in moving and top > 1:
            top = int(model.parents[top])
            found.append(top)
        for other in range(2, model.njoints):  # a joint comes after the one that carries it
            if other not in moving and other not in found and int(model.parents[other]) in found:
                found.append(other)
        return found

    def stretch(self, joint: int, axis: Array, factor: float) -> None:
        """Stretch what a joint carries until the next joints, along an axis of the root link."""
        model = self.model
        for body in self.around(joint):
            e = self.at[body].rotation.T @ axis
            K = np.eye(3) + (factor - 1.0) * np.outer(e, e)
            model.inertias[body] = _stretched(model.inertias[body], K)
            for child in range(2, model.njoints):
                if int(model.parents[child]) == body:
                    place = model.jointPlacements[child]
                    self.move(child, K @ place.translation - place.translation)
            for frame in model.frames:
                if int(frame.parentJoint) == body:
                    R = frame.placement.rotation
                    frame.inertia = _stretched(frame.inertia, R.T @ K @ R)
                    frame.placement = pin.SE3(R, K @ frame.placement.translation)

    def move(self, joint: int, vector: Array) -> None:
        """Move a joint in the axes of the body that it sits on."""
        model = self.model
        place = model.jointPlacements[joint]
        model.jointPlacements[joint] = pin.SE3(place.rotation, place.translation + vector)
        name = model.names[joint]
        for frame in model.frames:
            if frame.type == pin.FrameType.JOINT and frame.name == name:
                frame.placement = pin.SE3.Identity()


def _lower(frame: pin.Frame, move: Array) -> None:
    """Move a frame of a foot; where it is that of the joint, its body alone."""
    place, body = frame.placement, frame.inertia
    if place.translation.any():
        frame.placement = pin.SE3(place.rotation, place.translation + move)
    elif body.mass:
        lever = body.lever + place.rotation.T @ move
        frame.inertia = rigid_body(body.mass, lever, body.inertia)


def _stretched(body: pin.Inertia, K: Array) -> pin.Inertia:
    """Return a body all of whose bits at r are at K r."""
    own = np.array(body.inertia)
    second = K @ (0.5 * np.trace(own) * np.eye(3) - own) @ K
    return rigid_body(body.mass, K @ body.lever, np.trace(second) * np.eye(3) - second)


def _heavier(body: pin.Inertia, factor: float) -> pin.Inertia:
    return rigid_body(factor * body.mass, body.lever, factor * np.array(body.inertia))


def _refuse_little(one: PartChange, own: float, more: float, unit: str) -> None:
    if own + more < _LEAST * own:
        raise RobotError(
            f"proportions: {one.part} has {own:.4g} {unit} in the file, and {-more:.4g} {unit} "
            f"less leaves too little; take away at most {(1.0 - _LEAST) * own:.4g} {unit}"
        )
