"""The robot as a few points and lines: hips, knees, ankles, soles and trunk in the world.

Also how the contacts of a foot look in figures and on pages, and what its phases are called.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from gaitopt.contact import BOTH_FEET, FlatFoot, HeelLine, ToeLine
from gaitopt.dataclass import dataclass
from gaitopt.gait.result import Gait, Recorded, recorded_choices
from gaitopt.gait.transition import Transition
from gaitopt.importers.reader import read_source
from gaitopt.importers.source import Source
from gaitopt.model.multibody import Multibody
from gaitopt.model.reference_posture import reference_configuration
from gaitopt.nlp import Array

_TRUNK_TO_LEG = 0.9  # trunk length over leg length, where the model does not show the trunk
_STUB = 0.3  # of the leg's length: less above the hips is a pelvis, not a trunk


@dataclass(frozen=True, eq=False)
class StickFigures:
    """Stick figures of N configurations, points in the world [m].

    Attributes:
        legs: joint origins from ankle to hip, shape (N, 2, k, 3), in the order of the body's soles.
        soles: corners toe left, toe right, heel left, heel right, shape (N, 2, 4, 3).
        trunk: midpoint of the hips and top of the trunk, shape (N, 2, 3).
    """

    legs: Array
    soles: Array
    trunk: Array

    def at(self, rows: NDArray[np.intp]) -> StickFigures:
        """Return some of them."""
        return StickFigures(self.legs[rows], self.soles[rows], self.trunk[rows])

    def turned(self, rotation: Array) -> StickFigures:
        """Return them in other axes, given the rotation (3, 3) to these."""
        return StickFigures(*(part @ rotation.T for part in (self.legs, self.soles, self.trunk)))


def stick_figures(body: Multibody, configurations: Array, top: Array) -> StickFigures:
    """Return the stick figures of a robot.

    Args:
        configurations: of its model, shape (N, 7 + M).
        top: of the trunk in the base's frame [m], see `trunk_top`.
    """
    places = body.placements(configurations)
    rows = np.array([body.leg(foot) for foot in (0, 1)]) + 1
    legs = places[..., :3, 3][:, rows]
    soles = places[:, body.sole_joint + 1] @ body.sole_placement
    corners = body.sole_corners @ soles[..., :3, :3].swapaxes(2, 3) + soles[..., None, :3, 3]
    above = places[:, 0, :3, :3] @ top + places[:, 0, :3, 3]
    return StickFigures(legs, corners, np.stack([legs[:, :, -1].mean(axis=1), above], axis=1))


@lru_cache(maxsize=2)  # the robot is read for it, and more than one figure asks
def trunk_top(gait: Recorded) -> Array:
    """Return the top of the trunk, above the middle of the hips, in the base's frame, (3,) [m].

    It is the highest joint, or the top of what the robot's file draws with simple shapes; in
    proportion to the legs if neither is clearly above the hips.

    Raises:
        RobotError: the robot cannot be read.
    """
    body = gait.trajectory.body
    up = body.heading[:, 2]
    at_rest = np.concatenate([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], body.posture])
    origins = body.placements(at_rest[None])[0, 1:, :3, 3]
    ankles, hips = (origins[[body.leg(foot)[end] for foot in (0, 1)]] for end in (0, -1))
    middle = hips.mean(axis=0)
    leg = float(np.linalg.norm(hips[0] - ankles[0]))
    above = max(float((origins @ up).max()), _drawn_top(gait, up)) - float(up @ middle)
    top = np.asarray(middle + up * (above if above > _STUB * leg else _TRUNK_TO_LEG * leg))
    top.setflags(write=False)
    return top


def at_reference(gait: Recorded, source: Source) -> tuple[pin.Model, pin.Data]:
    """Return the model of a gait's file and its kinematics, in the posture of what stands still.

    Raises:
        RobotError: the gait records a posture of joints that the robot does not have.
    """
    model = source.model()
    posture = recorded_choices(gait).posture or ()
    data = model.createData()
    # a gait records angles, never the name of a pose
    q = reference_configuration(model, dict(posture))  # type: ignore[arg-type]
    pin.framesForwardKinematics(model, data, q)
    return model, data


def _drawn_top(gait: Recorded, up: Array) -> float:
    """Return the highest point of the shapes that are no meshes [m], -inf if none."""
    # Read from its text alone, without directories, a robot has no meshes: loading them takes long.
    source = read_source(gait.urdf)
    shapes = source.geometry(pin.GeometryType.VISUAL)
    if shapes is None:
        return -np.inf
    model, data = at_reference(gait, source)
    placements = shapes.createData()
    pin.updateGeometryPlacements(model, data, shapes, placements)
    tops = [
        _top(shape.geometry, place, up)
        for shape, place in zip(shapes.geometryObjects, placements.oMg, strict=True)
    ]
    return max(tops)


def _top(shape: Any, place: pin.SE3, up: Array) -> float:
    """Return the highest point of the box around a shape."""
    shape.computeLocalAABB()
    box = shape.aabb_local
    half = np.array([box.width(), box.height(), box.depth()]) / 2.0
    centre = place.act(shape.aabb_center)
    return float(up @ centre + np.abs(place.rotation.T @ up) @ half)


COLOURS = {FlatFoot.name: "#009E73", ToeLine.name: "#CC79A7", HeelLine.name: "#56B4E9"} | {
    BOTH_FEET: "#F0E442"
}
"""By the name of the contact; of Okabe & Ito, as those of figures."""
OTHER = "#8A8A8A"
"""Of a contact that is none of these."""


def contact_colour(contact: str) -> str:
    """Return the colour of a contact, "#rrggbb"."""
    return COLOURS.get(contact, OTHER)


def contact_words(contact: str) -> str:
    """Return how a foot stands in words: "flat", "on the toe line"."""
    if contact == BOTH_FEET:
        return "beside the other"
    return contact if contact == FlatFoot.name else f"on the {contact}"


def flat_contact(stands: NDArray[np.bool_]) -> str:
    """Return the contact where these feet stand flat, shape (2,)."""
    return BOTH_FEET if stands.all() else FlatFoot.name


def contacts(gait: Gait | Transition) -> list[str]:
    """Return the contacts of a step, each once, in their order, or those of a transition."""
    if isinstance(gait, Transition):
        return [BOTH_FEET, FlatFoot.name][not gait.rests :]
    return list(dict.fromkeys(phase.contact for phase in gait.phases))
