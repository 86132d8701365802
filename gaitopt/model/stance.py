"""The robot at its reference posture in its own axes: which way is up, and both feet flat."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.importers.report import Finding
from gaitopt.importers.source import Source
from gaitopt.model.heading import axis_vector, leg_lines
from gaitopt.model.import_options import SIDES, ImportOptions
from gaitopt.model.kinematic_tree import (
    LegJoints,
    PosedModel,
    angle_between,
    pose_model,
    turn_onto,
    unit,
)
from gaitopt.model.leg_detection import (
    LegPair,
    axes_apart,
    find_legs,
    mirror_normal,
    named_feet,
    no_up,
)
from gaitopt.model.leg_geometry import centre
from gaitopt.model.sole_detection import (
    MOST_TILTED,
    FootShape,
    foot_points,
    lowest_face,
    sole_normal,
)
from gaitopt.nlp import Array

_NEARLY_FLAT = 0.05  # rad: feet turned by less between two postures are flat in both
_ALIGNED = 1e-3  # rad: a named frame may be turned by rounding in the file
_ALIKE = 0.02  # rad: feet turned by the same, and their soles, in spite of rounded meshes
_UPRIGHT = 1e-3  # rad: a smaller tilt is rounding
_Z = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Stance:
    """A robot at its reference posture, seen in its own axes.

    Attributes:
        model: free-flyer and all joints.
        feet: last joints of the right and of the left leg.
        places: placements of those joints in the pelvis frame.
        ankles: centres of the ankles in the pelvis frame [m], shape (2, 3).
    """

    model: pin.Model
    feet: tuple[int, int]
    places: tuple[pin.SE3, pin.SE3]
    ankles: Array

    @property
    def leg(self) -> float:
        """Height of the hips above the ankles [m]."""
        return float(-self.ankles[:, 2].mean())

    def height(self, soles: tuple[pin.SE3, pin.SE3]) -> float:
        """Return that of the ankles above soles placed in the frames of the last joints [m]."""
        under = [
            (place * own).translation[2] for place, own in zip(self.places, soles, strict=True)
        ]
        return float(np.mean(self.ankles[:, 2] - under))

    def centred(self) -> Stance:
        """Return it with either foot where its ankle is the mirror image of the other one's.

        Where one leg is set a little apart its foot is so as a whole: the soles are compared below
        their own ankles.
        """
        mirror = np.array([1.0, -1.0, 1.0])
        mean = (self.ankles[0] + self.ankles[1] * mirror) / 2.0
        ankles = np.array([mean, mean * mirror])
        first, other = (
            pin.SE3(place.rotation, place.translation + shift)
            for place, shift in zip(self.places, ankles - self.ankles, strict=True)
        )
        return replace(self, places=(first, other), ankles=ankles)


def legs_at_zero(posed: PosedModel, legs: LegJoints) -> PosedModel:
    """Return the same posture with all leg angles 0."""
    q = posed.q.copy()
    q[[posed.model.joints[j].idx_q for leg in legs for j in leg]] = 0.0
    return pose_model(posed.model, q, posed.problems)


def flat_stance(
    posed: PosedModel,
    straight: PosedModel,
    legs: LegJoints,
    rotation: Array,
    shapes: list[FootShape | None],
) -> Stance:
    """Return the robot with flat feet in its own axes, their origin between the hips.

    Poses in files are rounded and not quite symmetric; with all leg angles 0 the feet are exact.
    So that posture counts where the feet are as flat in it. Axes are those of `Heading`.

    Raises:
        RobotError: the reference posture tilts a foot so far that its sole cannot be told any more.
    """
    upright = _stance_of(straight, legs, rotation)
    feet = [(straight.placements[leg[-1]], posed.placements[leg[-1]]) for leg in legs]
    turns = [pin.log3(a.rotation.T @ b.rotation) for a, b in feet]
    if max(map(np.linalg.norm, turns)) <= _NEARLY_FLAT:
        return upright
    stance = _stance_of(posed, legs, rotation)
    for side, shape in enumerate(shapes):
        if shape is None:
            continue
        R = upright.places[side].rotation
        face = lowest_face(shape.points @ R.T, shape.radii, -_Z)
        angle = (
            0.0 if face is None else angle_between(stance.places[side].rotation @ R.T @ face, -_Z)
        )
        if angle > MOST_TILTED:
            raise RobotError(
                f"the sole of the {SIDES[side]} foot is tilted by {np.degrees(angle):.1f} degrees "
                f"in the reference posture; at most {np.degrees(MOST_TILTED):.0f} can be levelled; "
                "give angles of hip, knee and ankle that keep both feet flat ([posture] in the "
                "file for --choices, or a pose of the SRDF), or none for the legs"
            )
    return stance


def _stance_of(posed: PosedModel, legs: LegJoints, rotation: Array) -> Stance:
    lines = [leg_lines(posed, leg) for leg in legs]
    pelvis = pin.SE3(rotation, (lines[0].hip + lines[1].hip) / 2.0)
    # The ankles' centres are those of `Legs`: on the pitch axes, where the axes do not meet.
    ankles = [centre(line.points @ rotation, line.axes @ rotation, line.parts[1]) for line in lines]
    first, other = (pelvis.actInv(posed.placements[leg[-1]]) for leg in legs)
    return Stance(
        model=posed.model,
        feet=(legs[0][-1], legs[1][-1]),
        places=(first, other),
        ankles=np.array([pelvis.actInv(rotation @ point) for point in ankles]),
    )


def level_feet(
    stance: Stance,
    shapes: list[FootShape | None],
    names: tuple[str | None, str | None],
    rotation: Array,
) -> tuple[Stance, list[Finding]]:
    """Return the robot with level soles, the feet turned about their ankles, and what was turned.

    Axes of the sole frames that the user named (`names`) count, whatever the shape.
    """
    places, findings = list(stance.places), []
    turns = [_turn(stance, side, shapes[side], names[side]) for side in (0, 1)]
    up = _tilted_up(turns, rotation)
    for side, turn in enumerate(turns):
        angle = float(np.linalg.norm(pin.log3(turn)))
        if angle > 0.0:
            place, ankle = places[side], stance.ankles[side]
            arm = turn @ (place.translation - ankle)
            places[side] = pin.SE3(turn @ place.rotation, ankle + arm)
            text = (
                f"is tilted by {np.degrees(angle):.2f} degrees in the reference posture; its sole "
                "was taken level"
            )
            if up is not None:
                numbers = ", ".join(f"{n:g}" for n in np.round(up, 6) + 0.0)
                text += f"; if it is the root link that is tilted: up = [{numbers}]"
            findings.append(Finding("sole", f"{SIDES[side]} foot", text, "guessed"))
    return replace(stance, places=(places[0], places[1])), findings


def _tilted_up(turns: list[Array], rotation: Array) -> Array | None:
    """Direction in the root link that would be up if that were tilted, and not both feet alike."""
    logs = [pin.log3(turn) for turn in turns]
    if not all(log.any() for log in logs) or np.linalg.norm(logs[0] - logs[1]) > _ALIKE:
        return None
    return np.asarray(rotation @ turns[0].T @ _Z)


def _turn(stance: Stance, side: int, shape: FootShape | None, name: str | None) -> Array:
    """Rotation in the pelvis frame that makes a foot flat."""
    place, model = stance.places[side], stance.model
    if name is not None and model.existFrame(name):
        R = (place * model.frames[model.getFrameId(name)].placement).rotation
        return np.asarray(R.T) if np.linalg.norm(pin.log3(R)) > _ALIGNED else np.eye(3)
    if name is None and shape is not None:
        normal = sole_normal(shape.points @ place.rotation.T, -_Z, shape.radii)
        if normal is not None:
            return turn_onto(normal, -_Z)
    return np.eye(3)


def standing_legs(source: Source, posed: PosedModel, choices: ImportOptions) -> LegPair:
    """Return the two legs and their upward direction, which the user may give.

    Up is an axis of the root link if the legs mirror each other in an upright plane along it. If
    that plane leans, up is square to both soles where they agree, else it lies in the plane.

    Raises:
        RobotError: there are no two legs.
    """
    up = None if choices.up is None else axis_vector(choices.up)
    pair = find_legs(posed, named_feet(posed.model, choices), up)
    if up is not None:
        return pair
    normal = mirror_normal(posed, pair.legs)
    if normal is None or not (pair.lying or _leans(posed, pair, normal)):
        return pair
    within = unit(pair.up - (pair.up @ normal) * normal)
    soles = _above_soles(source, posed, pair.legs, within)
    if soles is None and pair.lying:
        raise no_up(posed, pair.legs)
    above = within if soles is None else soles
    up = unit(above - (above @ normal) * normal)
    angle = np.degrees(np.arccos(np.clip(up @ (_Z if pair.lying else pair.up), -1.0, 1.0)))
    reason = "" if soles is None else "the soles and "
    text = (
        f"the root link is tilted by {angle:.2f} degrees against the legs; up was taken from "
        f"{reason}the plane between the legs; if that is wrong, name it: up = [X, Y, Z]"
    )
    return replace(pair, up=up, tilt=text)


def _leans(posed: PosedModel, pair: LegPair, normal: Array) -> bool:
    """Tell whether the plane between the legs leans, and the axes with it: no leg is longer."""
    if abs(float(normal @ pair.up)) <= _UPRIGHT:
        return False
    upright = unit(normal - (normal @ pair.up) * pair.up)
    first, other = (posed.axes[list(leg)] for leg in pair.legs)
    return axes_apart(first, other, normal) < axes_apart(first, other, upright)


def _above_soles(source: Source, posed: PosedModel, legs: LegJoints, up: Array) -> Array | None:
    """Direction square to the lower faces of both feet, None if they have none or differ."""
    normals = []
    for leg in legs:
        shape = foot_points(source, posed.model, leg[-1])
        R = posed.placements[leg[-1]].rotation
        face = None if shape is None else lowest_face(shape.points @ R.T, shape.radii, -up)
        if face is None:
            return None
        normals.append(-face)
    apart = float(np.linalg.norm(normals[0] - normals[1]))
    return unit(normals[0] + normals[1]) if apart < _ALIKE else None
