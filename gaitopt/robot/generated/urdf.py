"""A biped's URDF, written from its specification.

Root link `torso`, its origin midway between the hips. Per side, from the torso down: hip yaw (z),
hip roll (x), hip pitch (y), knee (y), ankle pitch (y), ankle roll (x), all axes positive, legs
straight at zero; then a massless `*_sole` frame at the middle of the toe edge, on the sole.
"""

from __future__ import annotations

from xml.etree import ElementTree as ET

from gaitopt.robot.generated import GENERATED
from gaitopt.robot.generated.inertia import Matrix3, Vector3, mirrored_inertia
from gaitopt.robot.generated.shapes import (
    Shape,
    add_collision,
    add_materials,
    add_visual,
    box,
    numbers,
)
from gaitopt.robot.generated.spec import BipedSpec, Geometry, JointLimits, LinkSpec
from gaitopt.robot.generated.visuals import leg_shapes, torso_shapes

SIDES = {"left": 1.0, "right": -1.0}
"""The sides and the sign of y on which each lies."""

LEG_LINKS = ("hip_yaw_link", "hip_roll_link", "thigh", "shin", "ankle", "foot")
"""Links of a leg from hip to foot, without the side; one below each joint of `Joints`."""

_AXES = {
    "hip_yaw": "0 0 1",
    "hip_roll": "1 0 0",
    "hip_pitch": "0 1 0",
    "knee": "0 1 0",
    "ankle_pitch": "0 1 0",
    "ankle_roll": "1 0 0",
}


def urdf_text(spec: BipedSpec) -> str:
    """Return the URDF of a biped: the same bytes for the same specification, everywhere."""
    robot = ET.Element("robot", name=spec.name)
    add_materials(robot)
    _add_link(robot, "torso", spec.links.torso, 1.0, torso_shapes(spec))
    for side, sign in SIDES.items():
        _add_leg(robot, spec, side, sign)
    ET.indent(robot)
    return f'<?xml version="1.0"?>\n{GENERATED}\n' + ET.tostring(robot, encoding="unicode") + "\n"


def _add_leg(robot: ET.Element, spec: BipedSpec, side: str, sign: float) -> None:
    origins, shapes = _joint_origins(spec.geometry, sign), leg_shapes(spec, side, sign)
    parent = "torso"
    for (joint, limits), link, part in zip(
        spec.joints.named(), LEG_LINKS, spec.links.leg, strict=True
    ):
        child = f"{side}_{link}"
        element = _add_link(robot, child, part, sign, shapes[link])
        if link == "foot":
            add_collision(element, _sole_box(spec))
        element = _add_joint(robot, f"{side}_{joint}", "revolute", parent, child, origins[joint])
        ET.SubElement(element, "axis", xyz=_AXES[joint])
        _add_limits(element, limits, mirrored=sign < 0.0 and _AXES[joint] != "0 1 0")
        parent = child
    ET.SubElement(robot, "link", name=f"{side}_sole")
    sole = (-spec.geometry.l1, 0.0, -spec.geometry.d1)
    _add_joint(robot, f"{side}_sole_joint", "fixed", parent, f"{side}_sole", sole)


def _sole_box(spec: BipedSpec) -> Shape:
    """The box whose lower face is exactly the sole, in the frame of the ankle roll joint."""
    geometry, height = spec.geometry, spec.links.foot.size[2]
    size = (geometry.foot_length, geometry.foot_width, height)
    centre = (-geometry.l1 - geometry.foot_length / 2.0, 0.0, -geometry.d1 + height / 2.0)
    return box(size, centre, "rubber")


def _joint_origins(geometry: Geometry, sign: float) -> dict[str, Vector3]:
    """Position of each joint in the frame of the joint above it, at the zero posture [m]."""
    concurrent = (0.0, 0.0, 0.0)
    return {
        "hip_yaw": (0.0, sign * geometry.d7 / 2.0, 0.0),
        "hip_roll": concurrent,
        "hip_pitch": concurrent,
        "knee": (0.0, sign * geometry.l4, -geometry.d4),
        "ankle_pitch": (0.0, 0.0, -geometry.d3),
        "ankle_roll": concurrent,
    }


def _add_joint(
    robot: ET.Element, name: str, kind: str, parent: str, child: str, origin: Vector3
) -> ET.Element:
    joint = ET.SubElement(robot, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    ET.SubElement(joint, "origin", xyz=numbers(*origin), rpy="0 0 0")
    return joint


def _add_limits(joint: ET.Element, limits: JointLimits, mirrored: bool) -> None:
    lower, upper = limits.lower, limits.upper
    if mirrored:
        lower, upper = -upper, -lower
    ET.SubElement(
        joint,
        "limit",
        effort=numbers(limits.torque),
        velocity=numbers(limits.speed),
        lower=numbers(lower),
        upper=numbers(upper),
    )


def _add_link(
    robot: ET.Element, name: str, part: LinkSpec, sign: float, shapes: list[Shape]
) -> ET.Element:
    link = ET.SubElement(robot, "link", name=name)
    inertial = ET.SubElement(link, "inertial")
    x, y, z = part.com
    ET.SubElement(inertial, "origin", xyz=numbers(x, sign * y, z), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=numbers(part.mass))
    inertia = part.com_inertia
    _add_inertia(inertial, inertia if sign > 0.0 else mirrored_inertia(inertia))
    for shape in shapes:
        add_visual(link, shape)
    return link


def _add_inertia(inertial: ET.Element, inertia: Matrix3) -> None:
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia
    entries = {"ixx": xx, "ixy": xy, "ixz": xz, "iyy": yy, "iyz": yz, "izz": zz}
    ET.SubElement(inertial, "inertia", {key: numbers(value) for key, value in entries.items()})
