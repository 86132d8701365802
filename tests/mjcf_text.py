"""The MJCF of a Pinocchio model: the same robot in another format."""

from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin

_COUPLES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def mjcf_text(model: pin.Model, *, freejoint: bool = True, foot_geom: str = "") -> str:
    """Write a model with a free-flyer as joint 1.

    Args:
        model: of the robot; its joints are revolute.
        freejoint: whether the root body has its free joint.
        foot_geom: attributes of a geometry of the bodies without children.
    """
    root = ET.Element("mujoco", model=model.name)
    ET.SubElement(root, "compiler", angle="radian", autolimits="true")
    world = ET.SubElement(root, "worldbody")
    ET.SubElement(world, "geom", type="plane", size="1 1 0.1")
    bodies = {1: _body(world, model, 1, "pelvis")}
    if freejoint:
        ET.SubElement(bodies[1], "freejoint", name="floating")
    actuators = ET.SubElement(root, "actuator")
    for j in range(2, model.njoints):
        bodies[j] = _body(bodies[model.parents[j]], model, j, f"{model.names[j]}_body")
        _joint(bodies[j], model, j)
        _motor(actuators, model, j)
        if foot_geom and not len(model.children[j]):
            bodies[j].append(ET.fromstring(f"<geom {foot_geom}/>"))
    return ET.tostring(root, encoding="unicode")


def _body(parent: ET.Element, model: pin.Model, j: int, name: str) -> ET.Element:
    placement, inertia = model.jointPlacements[j], model.inertias[j]
    x, y, z, w = pin.Quaternion(placement.rotation).coeffs()
    body = ET.SubElement(
        parent, "body", name=name, pos=_text(placement.translation), quat=_text([w, x, y, z])
    )
    moments = [inertia.inertia[c] for c in _COUPLES]
    ET.SubElement(
        body, "inertial", pos=_text(inertia.lever), mass=repr(inertia.mass),
        fullinertia=_text(moments),
    )  # fmt: skip
    return body


def _joint(body: ET.Element, model: pin.Model, j: int) -> None:
    data = model.createData()
    pin.computeJointJacobians(model, data, pin.neutral(model))
    axis = pin.getJointJacobian(model, data, j, pin.LOCAL)[3:, model.joints[j].idx_v]
    at = model.joints[j].idx_q
    ends = model.lowerPositionLimit[at], model.upperPositionLimit[at]
    ET.SubElement(body, "joint", name=model.names[j], axis=_text(axis), range=_text(ends))


def _motor(actuators: ET.Element, model: pin.Model, j: int) -> None:
    # A gear of 2: half the torque at the motor.
    half = model.effortLimit[model.joints[j].idx_v] / 2.0
    ET.SubElement(
        actuators, "motor", name=f"{model.names[j]}_motor", joint=model.names[j], gear="2",
        forcerange=_text([-half, half]),
    )  # fmt: skip


def _text(values: object) -> str:
    return " ".join(repr(float(v)) for v in np.asarray(values).ravel())
