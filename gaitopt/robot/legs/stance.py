"""The robot at its reference posture in its own axes, both feet flat."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.nlp import Array
from gaitopt.robot.choices import SIDES
from gaitopt.robot.feet.level import (
    MOST_TILTED,
    levelled,
    lowest_face,
    sole_normal,
    tilt,
    turn_onto,
)
from gaitopt.robot.feet.shape import FootShape
from gaitopt.robot.findings import Finding

_ALIGNED = 1e-3  # rad: a named frame may be turned by rounding in the file
_ALIKE = 0.02  # rad: feet turned by the same in spite of rounded meshes
_DOWN = np.array([0.0, 0.0, -1.0])


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

    def upright(self, side: int) -> Array:
        """Columns forward, left, up in the frame of a foot's joint, shape (3, 3)."""
        return np.asarray(self.places[side].rotation.T)

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


def level_feet(
    stance: Stance,
    shapes: list[FootShape | None],
    names: tuple[str | None, str | None],
    rotation: Array,
) -> tuple[Stance, list[Finding]]:
    """Turn the feet about their ankles until their soles are level, where they are not.

    Args:
        stance: the robot as its reference posture has it.
        shapes: of the right and of the left foot.
        names: of the sole frames that the user named; their axes count, whatever the shape.
        rotation: columns forward, left, up of the robot in its root link, shape (3, 3).

    Returns:
        The robot with flat feet, and what had to be turned.
    """
    places, findings = list(stance.places), []
    turns = [_turn(stance, side, shapes[side], names[side]) for side in (0, 1)]
    up = _tilted_up(turns, rotation)
    for side, turn in enumerate(turns):
        angle = float(np.linalg.norm(pin.log3(turn)))
        if angle > 0.0:
            places[side] = levelled(places[side], stance.ankles[side], turn)
            text = (
                f"is tilted by {np.degrees(angle):.2f} degrees in the reference posture; its sole "
                "was taken level"
            )
            if up is not None:
                numbers = ", ".join(f"{n:g}" for n in np.round(up, 6) + 0.0)
                text += f"; if it is the root link that is tilted: up = [{numbers}]"
            findings.append(Finding("sole", f"{SIDES[side]} foot", text, "guessed"))
    return replace(stance, places=(places[0], places[1])), findings


def refuse_tilted(stance: Stance, straight: Stance, shapes: list[FootShape | None]) -> None:
    """Refuse a reference posture that tilts a foot so far that its sole cannot be told any more.

    Args:
        stance: the robot as its reference posture has it.
        straight: the robot with all leg angles 0.
        shapes: of the right and of the left foot.

    Raises:
        RobotError: a foot is tilted.
    """
    for side, shape in enumerate(shapes):
        if shape is None:
            continue
        R = straight.places[side].rotation
        face = lowest_face(shape.points @ R.T, shape.radii, _DOWN)
        angle = 0.0 if face is None else tilt(stance.places[side].rotation @ R.T @ face, _DOWN)
        if angle > MOST_TILTED:
            raise RobotError(
                f"the sole of the {SIDES[side]} foot is tilted by {np.degrees(angle):.1f} degrees "
                f"in the reference posture; at most {np.degrees(MOST_TILTED):.0f} can be levelled; "
                "give angles of hip, knee and ankle that keep both feet flat ([posture] in the "
                "file for --choices, or a pose of the SRDF), or none for the legs"
            )


def _tilted_up(turns: list[Array], rotation: Array) -> Array | None:
    """Direction in the root link that would be up if that were tilted, and not both feet alike."""
    logs = [pin.log3(turn) for turn in turns]
    if not all(log.any() for log in logs) or np.linalg.norm(logs[0] - logs[1]) > _ALIKE:
        return None
    return np.asarray(rotation @ turns[0].T @ -_DOWN)


def _turn(stance: Stance, side: int, shape: FootShape | None, name: str | None) -> Array:
    """Rotation in the pelvis frame that makes a foot flat."""
    place, model = stance.places[side], stance.model
    if name is not None and model.existFrame(name):
        R = (place * model.frames[model.getFrameId(name)].placement).rotation
        return np.asarray(R.T) if np.linalg.norm(pin.log3(R)) > _ALIGNED else np.eye(3)
    if name is None and shape is not None:
        normal = sole_normal(shape.points @ place.rotation.T, _DOWN, shape.radii)
        if normal is not None:
            return turn_onto(normal, _DOWN)
    return np.eye(3)
