"""Which way is up for the legs, where the root link's own axes do not stand as they do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gaitopt.nlp import Array
from gaitopt.robot.choices import Choices
from gaitopt.robot.feet.level import lowest_face
from gaitopt.robot.feet.shape import foot_points
from gaitopt.robot.files.source import Source
from gaitopt.robot.legs.alike import axes_apart, mirror_normal
from gaitopt.robot.legs.find import Pair, find_legs
from gaitopt.robot.legs.heading import axis_vector
from gaitopt.robot.legs.named import named_feet
from gaitopt.robot.legs.placed import Placed, joint_axes
from gaitopt.robot.legs.refused import no_up
from gaitopt.robot.legs.tree import Tree, unit

_UPRIGHT = 1e-3  # rad: a smaller tilt is rounding
_AGREE = 0.02  # rad: the soles of both feet, whose meshes may be rounded
_Z = np.array([0.0, 0.0, 1.0])


def standing_legs(source: Source, placed: Placed, choices: Choices) -> Pair:
    """Return the two legs and their upward direction.

    Up is an axis of the root link if the legs mirror each other in an upright plane along it. If
    that plane leans, up is square to both soles where they agree, else it lies in the plane.

    Args:
        source: of the robot.
        placed: the robot in its reference posture.
        choices: of the user; a given `up` counts as it is.

    Raises:
        RobotError: there are no two legs.
    """
    tree = Tree(placed.model, *placed.lines, source.problems, placed.q)
    up = None if choices.up is None else axis_vector(choices.up)
    pair = find_legs(tree, named_feet(placed.model, choices), up)
    if up is not None:
        return pair
    normal = mirror_normal(tree, (list(pair.legs[0]), list(pair.legs[1])))
    leaning = normal is not None and _leans(placed, pair, normal)
    if normal is None or not (leaning or pair.lying):
        return pair
    within = unit(pair.up - (pair.up @ normal) * normal)
    soles = _above_soles(source, placed, pair, within)
    if soles is None and pair.lying:
        raise no_up(tree, (pair.legs[0][-1], pair.legs[1][-1]))
    above = within if soles is None else soles
    up = unit(above - (above @ normal) * normal)
    angle = np.degrees(np.arccos(np.clip(up @ (_Z if pair.lying else pair.up), -1.0, 1.0)))
    reason = "" if soles is None else "the soles and "
    text = (
        f"the root link is tilted by {angle:.2f} degrees against the legs; up was taken from "
        f"{reason}the plane between the legs; if that is wrong, name it: up = [X, Y, Z]"
    )
    return replace(pair, up=up, tilt=text)


def _leans(placed: Placed, pair: Pair, normal: Array) -> bool:
    """Tell whether the plane between the legs leans, rather than one leg is longer than the other.

    Then the axes of the joints lean with it.
    """
    if abs(float(normal @ pair.up)) <= _UPRIGHT:
        return False
    upright = unit(normal - (normal @ pair.up) * pair.up)
    first, other = (joint_axes(placed.model, placed.q, leg) for leg in pair.legs)
    return axes_apart(first, other, normal) < axes_apart(first, other, upright)


def _above_soles(source: Source, placed: Placed, pair: Pair, up: Array) -> Array | None:
    """Direction square to the lower faces of both feet, None if they have none or differ."""
    normals = []
    for leg in pair.legs:
        shape = foot_points(source, placed.model, leg[-1])
        R = placed.places[leg[-1]].rotation
        face = None if shape is None else lowest_face(shape.points @ R.T, shape.radii, -up)
        if face is None:
            return None
        normals.append(-face)
    apart = float(np.linalg.norm(normals[0] - normals[1]))
    return unit(normals[0] + normals[1]) if apart < _AGREE else None
