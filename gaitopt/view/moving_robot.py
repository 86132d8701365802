"""The shapes of a robot, standing still or moved through a walk."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.nlp import Array
from gaitopt.view.meshcat_quiet import meshcat
from gaitopt.view.shape_nodes import draw_shape
from gaitopt.view.tracks import Film
from gaitopt.view.walk import Walk


def draw_robot(
    robot: meshcat.Visualizer,
    film: Film,
    model: pin.Model,
    shapes: pin.GeometryModel,
    shown: Walk,
    times: Array,
) -> None:
    """Put a robot into a viewer and move it.

    There is one node for each joint that moves; it carries the shapes of its link, and of those
    that are at rest on it.

    Args:
        robot: its node.
        film: collects the motion.
        model: of the robot.
        shapes: what is drawn.
        shown: the walk.
        times: of its frames, increasing [s].
    """
    data = model.createData()
    carriers = _carriers(model, shown.q)
    pin.forwardKinematics(model, data, shown.q[0])
    for item in shapes.geometryObjects:
        carrier = carriers[item.parentJoint]
        inside = data.oMi[carrier].actInv(data.oMi[item.parentJoint]) * item.placement
        draw_shape(robot, _group(model, carrier), item, inside)
    carrying = {carriers[item.parentJoint] for item in shapes.geometryObjects} - {0}
    for joint, places in _placements(model, shown.q, sorted(carrying)).items():
        node = robot[_group(model, joint)]
        node.set_transform(places[0].homogeneous)
        film.place(node, times, np.array([place.translation for place in places]))
        film.turn(node, times, [place.rotation for place in places])


def draw_still(
    robot: meshcat.Visualizer, model: pin.Model, data: pin.Data, shapes: pin.GeometryModel
) -> None:
    """Put a robot into a viewer, with its joints where `data` has them."""
    for item in shapes.geometryObjects:
        joint = item.parentJoint
        draw_shape(robot, _group(model, joint), item, data.oMi[joint] * item.placement)


def _group(model: pin.Model, joint: int) -> str:
    return str(model.names[joint]).replace("/", "_")


def _carriers(model: pin.Model, configurations: Array) -> list[int]:
    """Return for each joint the nearest one, itself or towards the root, that moves."""
    moves = np.ptp(configurations, axis=0) > 0.0
    carriers = [0]
    for joint in range(1, model.njoints):
        first, size = model.joints[joint].idx_q, model.joints[joint].nq
        turns = joint == 1 or moves[first : first + size].any()
        carriers.append(joint if turns else carriers[model.parents[joint]])
    return carriers


def _placements(
    model: pin.Model, configurations: Array, joints: list[int]
) -> dict[int, list[pin.SE3]]:
    """Return the placements of joints in the world, for each configuration."""
    data = model.createData()
    places: dict[int, list[pin.SE3]] = {joint: [] for joint in joints}
    for q in configurations:
        pin.forwardKinematics(model, data, q)
        for joint in joints:
            places[joint].append(data.oMi[joint].copy())
    return places
