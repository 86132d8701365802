"""A page with a robot standing at its reference posture, and what is known about it.

The axes of its leg joints and its soles are drawn with it.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.escape import filled_template, html_text
from gaitopt.model.importer import ImportedRobot
from gaitopt.model.kinematic_tree import pose_model
from gaitopt.nlp import Array
from gaitopt.view.inspection import Inspection, inspection_tables
from gaitopt.view.page_parts import Page, table_text
from gaitopt.view.robot_shapes import draw_shape, unloaded
from gaitopt.view.viewer import Node, RecordingWindow, geometry, packed_viewer, page_file

_ARROW = 0.14  # length of an axis, in heights of the robot
_THICK = 0.006  # its radius, likewise
_CAMERA = (1.15, 0.25, 0.75)  # ahead, up, right; likewise
_PLATE = 0.004  # m: thickness of a sole
_SOLE = 0x2E9E5B
_SIDES = (0xD55E00, 0x0072B2)  # right, left: the colours of the figures


def draw_inspection(viewer: Node, inspection: Inspection) -> None:
    """Draw what is known of a robot: its meshes, and axes and soles if they were found."""
    viewer["/Background"].set_property("top_color", [0.97, 0.98, 1.0])
    viewer["/Background"].set_property("bottom_color", [0.86, 0.89, 0.92])
    viewer["/Axes"].set_property("visible", False)
    viewer["/Grid"].set_property("visible", False)
    if inspection.source is None or inspection.model is None:
        return
    reading = inspection.reading
    model = inspection.model if reading is None else reading.model
    q = np.array(pin.neutral(model)) if reading is None else _standing(reading)
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    draw_still(viewer["world/robot"], model, data, _shapes(inspection))
    if reading is not None:
        _draw_joints(viewer["world/axes"], reading, q, data)
        _draw_soles(viewer["world/soles"], reading, data)
    _look_at(viewer, data)


def draw_still(robot: Node, model: pin.Model, data: pin.Data, shapes: pin.GeometryModel) -> None:
    """Put a robot into a viewer, with its joints where `data` has them."""
    for item in shapes.geometryObjects:
        joint = item.parentJoint
        group = str(model.names[joint]).replace("/", "_")
        draw_shape(robot, group, item, data.oMi[joint] * item.placement)


def _shapes(inspection: Inspection) -> pin.GeometryModel:
    """Return the visual shapes that are there; a mesh that cannot be read leaves none."""
    source = inspection.source
    try:
        found = None if source is None else source.geometry(pin.GeometryType.VISUAL, load=unloaded)
    except RobotError:
        found = None
    return found or pin.GeometryModel()


def _standing(reading: ImportedRobot) -> Array:
    """Return the configuration (nq,) in which the robot stands on z = 0 and looks along x."""
    model, data = reading.model, reading.model.createData()
    pin.framesForwardKinematics(model, data, reading.q)
    soles = [data.oMf[model.getFrameId(name)].translation for name in reading.soles.names]
    upright = pin.SE3(np.array(reading.rotation), np.mean(soles, axis=0))
    q = reading.q.copy()
    q[:7] = pin.SE3ToXYZQUAT(upright.inverse())
    return np.asarray(q)


def _size(data: pin.Data) -> tuple[Array, float]:
    """Return the middle of the robot and its height, from its joints."""
    points = np.array([place.translation for place in list(data.oMi)[1:]])
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2.0, float(max(*(high - low), 0.1))


def _draw_joints(node: Node, reading: ImportedRobot, q: Array, data: pin.Data) -> None:
    model, (_, size) = reading.model, _size(data)
    axes = pose_model(model, q).axes
    for side, leg in enumerate(reading.legs):
        for joint, axis in zip(leg, axes[list(leg)], strict=True):
            arrow = node[str(model.names[joint]).replace("/", "_")]
            _draw_arrow(arrow, data.oMi[joint].translation, axis, size, _SIDES[side])


def _draw_arrow(node: Node, start: Array, axis: Array, size: float, colour: int) -> None:
    length, radius = _ARROW * size, _THICK * size
    material = geometry.MeshBasicMaterial(color=colour, depthTest=False, transparent=True)
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 1.0, 0.0]), axis).matrix()
    placed = pin.SE3(turn, start.copy())
    # MeshCat's cylinders stand along y
    node["shaft"].set_object(geometry.Cylinder(length, radius), material)
    node["shaft"].set_transform((placed * _along(length / 2.0)).homogeneous)
    head = geometry.Cylinder(4.0 * radius, radiusTop=0.0, radiusBottom=2.2 * radius)
    node["head"].set_object(head, material)
    node["head"].set_transform((placed * _along(length + 2.0 * radius)).homogeneous)


def _along(distance: float) -> pin.SE3:
    return pin.SE3(np.eye(3), np.array([0.0, distance, 0.0]))


def _draw_soles(node: Node, reading: ImportedRobot, data: pin.Data) -> None:
    sole = reading.soles.sole
    material = geometry.MeshBasicMaterial(
        color=_SOLE, opacity=0.5, transparent=True, depthTest=False, depthWrite=False
    )
    for side, name in enumerate(reading.soles.names):
        sign = 1.0 if side == reading.stance else -1.0  # the rectangle is the standing foot's
        middle = [(sole.toe + sole.heel) / 2.0, sign * (sole.left + sole.right) / 2.0, 0.0]
        plate = geometry.Box([sole.length, sole.width, _PLATE])
        node[str(side)].set_object(plate, material)
        place = data.oMf[reading.model.getFrameId(name)] * pin.SE3(np.eye(3), np.array(middle))
        node[str(side)].set_transform(place.homogeneous)


def _look_at(viewer: Node, data: pin.Data) -> None:
    """Put the middle of the robot at the origin, about which the camera turns."""
    middle, size = _size(data)
    shift = np.eye(4)
    shift[:3, 3] = -middle
    viewer["world"].set_transform(shift)
    position = [size * c for c in _CAMERA]
    viewer["/Cameras/default/rotated/<object>"].set_property("position", position)


def inspection_text(inspection: Inspection) -> Page:
    """Return a page with the robot and everything known about it; a notebook shows it."""
    recorder = RecordingWindow()
    draw_inspection(Node(recorder), inspection)
    refusal = html_text(inspection.refusal)
    parts = {
        "@TITLE@": html_text(inspection.title),
        "@REFUSAL@": f'<p class="refusal">{refusal}</p>' if refusal else "",
        "@TABLES@": "".join(map(table_text, inspection_tables(inspection))),
        "@FIT@": page_file("fit.js"),
        "@LOAD@": page_file("load.js"),
        "@COMMANDS@": recorder.text(),
        "@MESHCAT@": packed_viewer(),
    }
    return Page(filled_template(page_file("inspection.html"), parts))
