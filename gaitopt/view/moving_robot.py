"""The shapes of a robot, moved through a walk."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.nlp import Array
from gaitopt.view.meshcat_quiet import MeshcatVisualizer, meshcat
from gaitopt.view.tracks import Film
from gaitopt.view.walk import Walk


def draw_robot(
    path: str,
    viewer: meshcat.Visualizer,
    film: Film,
    model: pin.Model,
    shapes: pin.GeometryModel,
    shown: Walk,
    times: Array,
) -> None:
    """Put a robot into a viewer and move it.

    Args:
        path: of its node.
        viewer: which.
        film: collects the motion.
        model: of the robot.
        shapes: what is drawn.
        shown: the walk.
        times: of its frames, increasing [s].
    """
    robot = MeshcatVisualizer(model, pin.GeometryModel(), shapes)
    robot.initViewer(viewer=viewer)
    robot.loadViewerModel(path)
    robot.display(shown.q[0])
    placements = _shape_placements(model, shapes, shown.q)
    for item, places in zip(shapes.geometryObjects, placements, strict=True):
        node = viewer[robot.getViewerNodeName(item, pin.GeometryType.VISUAL)]
        flip = _flip(item.meshScale)
        film.place(node, times, np.array([m.translation for m in places]))
        film.turn(node, times, [m.rotation @ flip for m in places])


def _shape_placements(
    model: pin.Model, shapes: pin.GeometryModel, configurations: Array
) -> list[list[pin.SE3]]:
    """Return the placement of each shape in each configuration, shapes outside."""
    data, drawn = model.createData(), shapes.createData()
    frames = []
    for q in configurations:
        pin.updateGeometryPlacements(model, data, shapes, drawn, q)
        frames.append([m.copy() for m in drawn.oMg])
    return [list(column) for column in zip(*frames, strict=True)]


def _flip(scale: Array) -> Array:
    """Return the rotation the viewer adds to a mirrored mesh when it takes the scale out.

    It splits a matrix into rotation and scale, and gives the sign of the determinant to x.
    """
    signs = np.where(np.asarray(scale) < 0.0, -1.0, 1.0)
    if signs.prod() < 0.0:
        signs = signs * (-1.0, 1.0, 1.0)
    return np.diag(signs)
