"""Boxes, cylinders and spheres of a URDF, and the colours they wear."""

from __future__ import annotations

import math
from dataclasses import dataclass
from xml.etree import ElementTree as ET

from gaitopt.robot.generated.inertia import Vector3

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


@dataclass(frozen=True)
class Shape:
    """A primitive in the frame of its link.

    Attributes:
        kind: "box", "cylinder" or "sphere".
        attributes: of that URDF element, lengths as text [m].
        origin: of its centre [m].
        turn: roll, pitch, yaw [rad].
        colour: a key of `COLOURS`.
    """

    kind: str
    attributes: dict[str, str]
    origin: Vector3
    turn: Vector3
    colour: str


def numbers(*values: float) -> str:
    """Return the numbers separated by blanks, each in the shortest form that reads back equal."""
    return " ".join(repr(value + 0.0).removesuffix(".0") for value in values)


def _rounded(values: Vector3) -> Vector3:
    # Micrometres: looks need no more, and the file stays readable.
    x, y, z = (round(value, 6) for value in values)
    return (x, y, z)


def box(size: Vector3, centre: Vector3, colour: str) -> Shape:
    """Return a box with the given edges along x, y, z [m]."""
    return Shape("box", {"size": numbers(*_rounded(size))}, _rounded(centre), _TURNS["z"], colour)


def cylinder(axis: str, radius: float, length: float, centre: Vector3, colour: str) -> Shape:
    """Return a cylinder about the axis "x", "y" or "z", sizes in m."""
    sizes = {"radius": numbers(round(radius, 6)), "length": numbers(round(length, 6))}
    return Shape("cylinder", sizes, _rounded(centre), _TURNS[axis], colour)


def sphere(radius: float, centre: Vector3, colour: str) -> Shape:
    """Return a sphere, sizes in m."""
    sizes = {"radius": numbers(round(radius, 6))}
    return Shape("sphere", sizes, _rounded(centre), _TURNS["z"], colour)


def add_materials(robot: ET.Element) -> None:
    """Append the named colours to a `robot` element."""
    for name, rgba in COLOURS.items():
        ET.SubElement(ET.SubElement(robot, "material", name=name), "color", rgba=rgba)


def add_visual(link: ET.Element, shape: Shape) -> None:
    """Append a shape to be drawn to a `link` element."""
    visual = ET.SubElement(link, "visual")
    _add_geometry(visual, shape)
    ET.SubElement(visual, "material", name=shape.colour)


def add_collision(link: ET.Element, shape: Shape) -> None:
    """Append a shape that touches the world to a `link` element."""
    _add_geometry(ET.SubElement(link, "collision"), shape)


def _add_geometry(element: ET.Element, shape: Shape) -> None:
    ET.SubElement(element, "origin", xyz=numbers(*shape.origin), rpy=numbers(*shape.turn))
    ET.SubElement(ET.SubElement(element, "geometry"), shape.kind, shape.attributes)
