"""What Pinocchio would leave out of an MJCF file, change or misread, all in silence.

What leaves no robot, or makes every result wrong, is refused at once. What matters only in a leg is
returned as data, as `check_urdf` does.
"""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element

from gaitopt.errors import RobotError
from gaitopt.robot.files.xml_lines import XmlTree
from gaitopt.robot.mjcf.defaults import Defaults, check_classes, with_class
from gaitopt.robot.mjcf.equality import tied_joints
from gaitopt.robot.mjcf.inertial import (
    check_inertial,
    check_scaling,
    check_sizes,
    complete_geoms,
    mass_from_geoms,
)
from gaitopt.robot.mjcf.limits import limits_itself, range_in_force
from gaitopt.robot.mjcf.names import check_names
from gaitopt.robot.mjcf.numbers import check_numbers
from gaitopt.robot.urdf.check import MOST_JOINTS
from gaitopt.robot.urdf.values import Entry, UrdfProblem

_UNREAD = ("attach", "composite", "flexcomp", "frame", "replicate")


def check_mjcf(tree: XmlTree) -> tuple[UrdfProblem, ...]:
    """Check a whole MJCF document before any loader sees it.

    Args:
        tree: of the document, included files merged.

    Returns:
        What is suspicious but does not stop reading, in the order of the file.

    Raises:
        RobotError: naming the line, in which of the included files, the element, the value, and
            what is allowed.
    """
    robot = _robot(tree)
    _check_count(robot)
    check_classes(tree)
    check_names(tree, robot)
    check_numbers(tree, robot)
    check_scaling(tree)
    from_geoms, geoms = mass_from_geoms(tree.root), complete_geoms(tree.root)
    for body in robot.iter("body"):
        check_inertial(Entry(tree, body), from_geoms)
        check_sizes(Entry(tree, body), geoms)
    problems = [*_range_problems(tree), *_massless(tree, robot, geoms), *tied_joints(tree)]
    return tuple(sorted(problems, key=lambda problem: problem.line))


def moves(body: Element) -> bool:
    """Return whether a body, or one on it, has a joint."""
    return any(e.tag in ("joint", "freejoint") for b in body.iter("body") for e in b)


def _robot(tree: XmlTree) -> Element:
    """Return the one body that moves in the world."""
    worlds = tree.root.findall("worldbody")
    for element in [e for world in worlds for e in world.iter()]:
        if element.tag in _UNREAD:
            raise Entry(tree, element).refusal(
                "this is not supported; open the file in MuJoCo and save it, which writes it out "
                "in plain bodies"
            )
    moving = [body for world in worlds for body in world.findall("body") if moves(body)]
    if not moving:
        raise RobotError("the MJCF file has no body that moves; it describes no robot")
    if len(moving) > 1:
        names = ", ".join(f"'{body.get('name')}'" for body in moving)
        raise Entry(tree, moving[1]).refusal(
            f"several bodies move in the world: {names}; leave only the robot in it"
        )
    return moving[0]


def _check_count(robot: Element) -> None:
    count = sum(joint.get("type") != "free" for joint in robot.iter("joint"))
    if count > MOST_JOINTS:
        raise RobotError(
            f"the MJCF file has {count} joints that move; at most {MOST_JOINTS} can be read; make "
            "those that a walk does not need fixed (remove their <joint>)"
        )


def _range_problems(tree: XmlTree) -> list[UrdfProblem]:
    """Return the joints whose range, their own or that of their class, counts but is empty."""
    defaults, automatic = Defaults.of(tree.root), limits_itself(tree.root)
    radian = any(c.get("angle") == "radian" for c in tree.root.findall("compiler"))
    problems = []
    for joint, childclass in with_class(tree.root, "joint"):
        values = defaults.complete(joint, childclass)
        unit = "m" if values.get("type") == "slide" else "rad" if radian else "degrees"
        ends = [float(word) for word in range_in_force(values, "range", automatic).split()]
        if ends and not ends[0] < ends[1]:
            whose = "" if "range" in joint.attrib else " of its class"
            text = (
                f"the range{whose} is from {ends[0]:g} to {ends[1]:g} {unit}; lower must be below "
                "upper"
            )
            problems.append(Entry(tree, joint).problem("range", text))
    return problems


def _massless(
    tree: XmlTree, robot: Element, geoms: Mapping[Element, Mapping[str, str]]
) -> list[UrdfProblem]:
    """Return the bodies that a joint moves although they, and all fixed to them, weigh nothing."""
    text = "a joint moves it, but it has no mass; give it an <inertial>"
    return [
        Entry(tree, body).problem("massless", text)
        for body in robot.iter("body")
        if body.find("joint") is not None and not _heavy(body, geoms)
    ]


def _heavy(body: Element, geoms: Mapping[Element, Mapping[str, str]]) -> bool:
    inertial = body.find("inertial")
    masses: list[Mapping[str, str]] = [geoms[geom] for geom in body.findall("geom")]
    if inertial is not None:
        masses = [inertial.attrib]
    if any(float(m.get("mass", m.get("density", "1"))) > 0.0 for m in masses):
        return True
    return any(
        below.find("joint") is None and _heavy(below, geoms) for below in body.findall("body")
    )
