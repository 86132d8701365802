"""A biped's URDF, written from its specification: links, joints, and shapes that grow with them.

Root link `torso`, its origin midway between the hips. Per side, from the torso down: hip yaw (z),
hip roll (x), hip pitch (y), knee (y), ankle pitch (y), ankle roll (x), all axes positive, legs
straight at zero; then a massless `*_sole` frame at the middle of the toe edge, on the sole. Mass
plays no part in what a biped looks like.
"""

from __future__ import annotations

import math
from typing import NamedTuple
from xml.etree import ElementTree as ET

from gaitopt.catalogue.biped_spec import (
    BipedSpec,
    JointSpec,
    LinkSpec,
    Vector3,
    mirrored_inertia,
)
from gaitopt.importers.physics import GENERATED
from gaitopt.settings import checked_arguments

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

COLOURS = {
    "shell": "0.93 0.94 0.95 1",
    "dark": "0.13 0.14 0.16 1",
    "metal": "0.52 0.55 0.59 1",
    "rubber": "0.06 0.06 0.07 1",
    "light": "0.25 0.85 0.95 1",
    "left": "0.10 0.42 0.78 1",
    "right": "0.91 0.42 0.09 1",
}
"""Red, green, blue, opacity of each named material."""

_QUARTER = math.pi / 2.0
_TURNS: dict[str, Vector3] = {
    "x": (0.0, _QUARTER, 0.0),
    "y": (_QUARTER, 0.0, 0.0),
    "z": (0.0, 0.0, 0.0),
}


class _Primitive(NamedTuple):
    """A primitive of a URDF in the frame of its link [m, rad], in one of `COLOURS`."""

    kind: str
    attributes: dict[str, str]
    origin: Vector3
    turn: Vector3
    colour: str


def numbers(*values: float) -> str:
    """Return the numbers separated by blanks, each in the shortest form that reads back equal."""
    return " ".join(repr(value + 0.0).removesuffix(".0") for value in values)


def _shape(
    kind: str, sizes: dict[str, str], centre: Vector3, colour: str, axis: str = "z"
) -> _Primitive:
    x, y, z = (round(value, 6) for value in centre)  # micrometres: the file stays readable
    return _Primitive(kind, sizes, (x, y, z), _TURNS[axis], colour)


def box(size: Vector3, centre: Vector3, colour: str) -> _Primitive:
    """Return a box with the given edges along x, y, z [m]."""
    return _shape("box", {"size": numbers(*(round(n, 6) for n in size))}, centre, colour)


def cylinder(axis: str, radius: float, length: float, centre: Vector3, colour: str) -> _Primitive:
    """Return a cylinder about the axis "x", "y" or "z", sizes in m."""
    sizes = {"radius": numbers(round(radius, 6)), "length": numbers(round(length, 6))}
    return _shape("cylinder", sizes, centre, colour, axis)


def sphere(radius: float, centre: Vector3, colour: str) -> _Primitive:
    """Return a sphere, sizes in m."""
    return _shape("sphere", {"radius": numbers(round(radius, 6))}, centre, colour)


def _torso(spec: BipedSpec) -> list[_Primitive]:
    """Return pelvis, chest, shoulders and head, as high and as wide as the torso's box."""
    depth, width, tall = spec.links.torso.size
    # A torso that hangs below the hips is odd but allowed; it still needs something to draw.
    height = max(spec.standing_height - spec.geometry.hip_height, 0.5 * tall)
    hip = spec.links.hip_yaw.size
    wide, low, front = spec.geometry.d7 + hip[1], 0.7 * hip[2], 0.43 * depth
    radius = 0.34 * depth
    centre = height - radius
    shapes = [
        box((0.55 * depth, wide, 0.10 * height), (0.0, 0.0, low + 0.05 * height), "shell"),
        box((0.70 * depth, 0.7 * wide, 0.06 * height), (0.0, 0.0, low + 0.05 * height), "dark"),
        cylinder("z", 0.24 * depth, 0.14 * height, (0.0, 0.0, low + 0.17 * height), "metal"),
        cylinder("z", 0.29 * depth, 0.02 * height, (0.0, 0.0, low + 0.14 * height), "dark"),
        cylinder("z", 0.29 * depth, 0.02 * height, (0.0, 0.0, low + 0.18 * height), "dark"),
        box((0.62 * depth, 0.56 * width, 0.10 * height), (0.0, 0.0, 0.35 * height), "shell"),
        box((0.72 * depth, 0.68 * width, 0.08 * height), (0.0, 0.0, 0.43 * height), "shell"),
        box((0.80 * depth, 0.76 * width, 0.24 * height), (0.0, 0.0, 0.57 * height), "shell"),
        box((0.60 * depth, 0.66 * width, 0.04 * height), (0.0, 0.0, 0.71 * height), "shell"),
        box((0.10 * depth, 0.50 * width, 0.17 * height), (front, 0.0, 0.57 * height), "dark"),
        cylinder("x", 0.11 * depth, 0.12 * depth, (front, 0.0, 0.58 * height), "metal"),
        cylinder("x", 0.08 * depth, 0.13 * depth, (front, 0.0, 0.58 * height), "light"),
        box((0.20 * depth, 0.52 * width, 0.26 * height), (-0.45 * depth, 0.0, 0.54 * height),
            "dark"),
        cylinder("y", 0.16 * depth, 0.92 * width, (0.0, 0.0, 0.62 * height), "metal"),
    ]  # fmt: skip
    for side, y in (("left", 0.46 * width), ("right", -0.46 * width)):
        shapes.append(sphere(0.25 * depth, (0.0, y, 0.62 * height), side))
        shapes.append(cylinder("y", 0.18 * depth, 0.40 * depth, (0.0, y, 0.62 * height), "dark"))
    return [
        *shapes,
        cylinder("z", 0.15 * depth, 0.12 * height, (0.0, 0.0, 0.75 * height), "dark"),
        cylinder("z", 0.24 * depth, 0.02 * height, (0.0, 0.0, 0.74 * height), "metal"),
        sphere(radius, (0.0, 0.0, centre), "shell"),
        sphere(0.84 * radius, (0.26 * radius, 0.0, centre), "dark"),
        cylinder("y", 0.40 * radius, 2.10 * radius, (-0.10 * radius, 0.0, centre), "metal"),
        *(
            sphere(0.15 * radius, (0.96 * radius, y, centre + 0.10 * radius), "light")
            for y in (0.36 * radius, -0.36 * radius)
        ),
    ]


def _hip(spec: BipedSpec) -> tuple[list[_Primitive], list[_Primitive]]:
    """Return the shapes of the two links of a hip."""
    x, y, z = spec.links.hip_yaw.size
    yaw = [
        cylinder("z", 0.42 * y, 0.35 * z, (0.0, 0.0, 0.62 * z), "dark"),
        cylinder("z", 0.34 * y, 0.12 * z, (0.0, 0.0, 0.42 * z), "metal"),
        box((0.12 * x, 0.60 * y, 0.80 * z), (-0.66 * x, 0.0, 0.05 * z), "metal"),
        box((0.72 * x, 0.60 * y, 0.10 * z), (-0.36 * x, 0.0, 0.42 * z), "metal"),
    ]
    x, y, z = spec.links.hip_roll.size
    roll = [
        cylinder("x", 0.36 * z, 1.20 * x, (0.0, 0.0, 0.0), "dark"),
        cylinder("x", 0.24 * z, 1.30 * x, (0.0, 0.0, 0.0), "metal"),
        box((0.60 * x, 0.50 * y, 0.60 * z), (0.0, 0.0, 0.0), "metal"),
    ]
    return yaw, roll


def _thigh(spec: BipedSpec, side: str, sign: float) -> list[_Primitive]:
    x, y, _ = spec.links.thigh.size
    knee, out = -spec.geometry.d4, sign * spec.geometry.l4
    length = -knee
    return [
        cylinder("y", 0.42 * x, 0.90 * y + abs(out), (0.0, 0.5 * out, 0.0), "dark"),
        cylinder("y", 0.28 * x, 1.00 * y + abs(out), (0.0, 0.5 * out, 0.0), "metal"),
        box((0.70 * x, 0.78 * y, 0.50 * length), (0.0, out, 0.42 * knee), "shell"),
        box((0.90 * x, 0.56 * y, 0.44 * length), (0.0, out, 0.40 * knee), "shell"),
        box((0.10 * x, 0.44 * y, 0.34 * length), (0.45 * x, out, 0.40 * knee), side),
        box((0.56 * x, 0.10 * y, 0.30 * length), (0.0, out + sign * 0.39 * y, 0.42 * knee), side),
        box((0.60 * x, 0.62 * y, 0.24 * length), (0.0, out, 0.74 * knee), "shell"),
        cylinder("z", 0.24 * x, 0.30 * length, (0.0, out, 0.84 * knee), "dark"),
        cylinder("y", 0.36 * x, 0.46 * y, (0.0, out, knee), "dark"),
    ]


def _shin(spec: BipedSpec, side: str) -> list[_Primitive]:
    x, y, _ = spec.links.shin.size
    length = spec.geometry.d3
    return [
        *(
            cylinder("y", 0.50 * x, 0.16 * y, (0.0, side_sign * 0.40 * y, 0.0), "shell")
            for side_sign in (1.0, -1.0)
        ),
        cylinder("y", 0.26 * x, 1.02 * y, (0.0, 0.0, 0.0), side),
        box((0.60 * x, 0.96 * y, 0.22 * length), (0.0, 0.0, -0.20 * length), "shell"),
        box((0.80 * x, 0.72 * y, 0.40 * length), (-0.06 * x, 0.0, -0.36 * length), "shell"),
        box((0.10 * x, 0.46 * y, 0.40 * length), (0.36 * x, 0.0, -0.36 * length), side),
        box((0.58 * x, 0.60 * y, 0.24 * length), (0.0, 0.0, -0.64 * length), "shell"),
        cylinder("z", 0.22 * x, 0.30 * length, (0.0, 0.0, -0.82 * length), "dark"),
    ]


def _ankle(spec: BipedSpec) -> list[_Primitive]:
    x, y, z = spec.links.ankle.size
    return [
        cylinder("y", 0.50 * z, 0.90 * y, (0.0, 0.0, 0.0), "dark"),
        cylinder("y", 0.32 * z, 1.05 * y, (0.0, 0.0, 0.0), "metal"),
        cylinder("x", 0.30 * z, 1.30 * x, (0.0, 0.0, 0.0), "metal"),
    ]


def _foot(spec: BipedSpec, side: str) -> list[_Primitive]:
    geometry, height = spec.geometry, spec.links.foot.size[2]
    long, wide = geometry.foot_length, geometry.foot_width
    sole, toe = -geometry.d1, -geometry.l1
    ankle_gap = max(geometry.d1 - height, 0.1 * geometry.d1)
    return [
        box((long, wide, 0.3 * height), (toe - 0.5 * long, 0.0, sole + 0.15 * height), "rubber"),
        box((0.90 * long, 0.90 * wide, 0.5 * height),
            (toe - 0.52 * long, 0.0, sole + 0.55 * height), "shell"),
        box((0.24 * long, 0.80 * wide, 0.3 * height),
            (toe - 0.20 * long, 0.0, sole + 0.75 * height), side),
        box((0.55 * long, 0.70 * wide, 0.4 * height),
            (toe - 0.62 * long, 0.0, sole + 0.95 * height), "shell"),
        *(
            box((0.12 * long, 0.34 * wide, ankle_gap), (x, 0.0, -0.5 * ankle_gap), "metal")
            for x in (0.26 * long, -0.26 * long)
        ),
    ]  # fmt: skip


@checked_arguments
def urdf_text(spec: BipedSpec) -> str:
    """Return the URDF of a biped: the same bytes for the same specification, everywhere.

    Raises:
        OptionError: the biped is no `BipedSpec`.
    """
    robot = ET.Element("robot", name=spec.name)
    for name, rgba in COLOURS.items():
        ET.SubElement(ET.SubElement(robot, "material", name=name), "color", rgba=rgba)
    _add_link(robot, "torso", spec.links.torso, 1.0, _torso(spec))
    for side, sign in SIDES.items():
        _add_leg(robot, spec, side, sign)
    ET.indent(robot)
    return f'<?xml version="1.0"?>\n{GENERATED}\n' + ET.tostring(robot, encoding="unicode") + "\n"


def _add_leg(robot: ET.Element, spec: BipedSpec, side: str, sign: float) -> None:
    geometry, concurrent, parent = spec.geometry, (0.0, 0.0, 0.0), "torso"
    # Of each joint in the frame of the joint above it, at the zero posture [m].
    origins: dict[str, Vector3] = {
        "hip_yaw": (0.0, sign * geometry.d7 / 2.0, 0.0),
        "hip_roll": concurrent,
        "hip_pitch": concurrent,
        "knee": (0.0, sign * geometry.l4, -geometry.d4),
        "ankle_pitch": (0.0, 0.0, -geometry.d3),
        "ankle_roll": concurrent,
    }
    shapes = (*_hip(spec), _thigh(spec, side, sign), _shin(spec, side), _ankle(spec))
    parts = zip(spec.links.leg, (*shapes, _foot(spec, side)), strict=True)
    for (joint, limits), link, (part, drawn) in zip(
        spec.joints.named(), LEG_LINKS, parts, strict=True
    ):
        child = f"{side}_{link}"
        element = _add_link(robot, child, part, sign, drawn)
        if link == "foot":
            # The lower face of the box is exactly the sole.
            long, height = geometry.foot_length, part.size[2]
            centre = (-geometry.l1 - long / 2.0, 0.0, -geometry.d1 + height / 2.0)
            sole = box((long, geometry.foot_width, height), centre, "rubber")
            _add_geometry(ET.SubElement(element, "collision"), sole)
        element = _add_joint(robot, f"{side}_{joint}", "revolute", parent, child, origins[joint])
        ET.SubElement(element, "axis", xyz=_AXES[joint])
        _add_limits(element, limits, mirrored=sign < 0.0 and _AXES[joint] != "0 1 0")
        parent = child
    ET.SubElement(robot, "link", name=f"{side}_sole")
    origin = (-geometry.l1, 0.0, -geometry.d1)
    _add_joint(robot, f"{side}_sole_joint", "fixed", parent, f"{side}_sole", origin)


def _add_joint(
    robot: ET.Element, name: str, kind: str, parent: str, child: str, origin: Vector3
) -> ET.Element:
    joint = ET.SubElement(robot, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    ET.SubElement(joint, "origin", xyz=numbers(*origin), rpy="0 0 0")
    return joint


def _add_limits(joint: ET.Element, limits: JointSpec, mirrored: bool) -> None:
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
    robot: ET.Element, name: str, part: LinkSpec, sign: float, shapes: list[_Primitive]
) -> ET.Element:
    link = ET.SubElement(robot, "link", name=name)
    inertial = ET.SubElement(link, "inertial")
    x, y, z = part.com
    ET.SubElement(inertial, "origin", xyz=numbers(x, sign * y, z), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=numbers(part.mass))
    inertia = part.com_inertia if sign > 0.0 else mirrored_inertia(part.com_inertia)
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia
    entries = {"ixx": xx, "ixy": xy, "ixz": xz, "iyy": yy, "iyz": yz, "izz": zz}
    ET.SubElement(inertial, "inertia", {key: numbers(value) for key, value in entries.items()})
    for shape in shapes:
        visual = ET.SubElement(link, "visual")
        _add_geometry(visual, shape)
        ET.SubElement(visual, "material", name=shape.colour)
    return link


def _add_geometry(element: ET.Element, shape: _Primitive) -> None:
    ET.SubElement(element, "origin", xyz=numbers(*shape.origin), rpy=numbers(*shape.turn))
    ET.SubElement(ET.SubElement(element, "geometry"), shape.kind, shape.attributes)
