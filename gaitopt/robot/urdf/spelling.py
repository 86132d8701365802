"""Elements of a URDF that are there twice, misspelt, or where nobody reads them.

Readers take the first of two `<inertial>`, or the last, and pass over `<inertail>` in silence: the
robot that walks would be another than the file's.
"""

from __future__ import annotations

import difflib
from xml.etree.ElementTree import Element

from gaitopt.robot.faults import Faults
from gaitopt.robot.files.xml_lines import XmlTree
from gaitopt.robot.urdf.values import Entry, UrdfProblem, printable

_ONCE = {
    "link": ("inertial",),
    "inertial": ("origin", "mass", "inertia"),
    "joint": (
        "origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "safety_controller",
        "calibration",
    ),
}  # fmt: skip
_MORE = {"link": ("visual", "collision"), "inertial": (), "joint": ()}
_ATTRIBUTES = {
    "origin": ("xyz", "rpy", "quat_xyzw"),
    "axis": ("xyz",),
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "limit": ("effort", "velocity", "lower", "upper", "acceleration", "deceleration", "jerk"),
    "dynamics": ("damping", "friction"),
}
_SEEN = ("visual", "collision", "safety_controller", "calibration")  # no motion depends on them
_ALIKE = 0.7  # ratio of `difflib`: one letter of five wrong, missing, or exchanged with the next
_ALIKE_SHORT = 0.66  # and of three, as in xzy


def check_spelling(tree: XmlTree) -> list[UrdfProblem]:
    """Check that every link and joint says each thing once, under its own name.

    Args:
        tree: of a URDF.

    Returns:
        What is passed over although it looks as if it was meant.

    Raises:
        RobotError: an element is there twice, or one that motion depends on is misspelt.
    """
    problems, faults = [], Faults()
    for element in tree.root:
        if element.tag in ("link", "joint"):
            entry = Entry(tree, element)
            for part in (element, *element.findall("inertial")):
                with faults.noted():
                    problems += _check(entry, part)
    faults.refuse()
    return problems


def _check(entry: Entry, element: Element) -> list[UrdfProblem]:
    problems = []
    once = _ONCE[element.tag]
    for tag in once:
        found = element.findall(tag)
        if len(found) > 1:
            lines = " and ".join(str(entry.tree.line(one)) for one in found)
            raise entry.refusal(
                f"it has {len(found)} <{tag}> (lines {lines}); one is allowed; remove the others",
                found[1],
            )
    for child in element:
        if child.tag not in (*once, *_MORE[element.tag]):
            problems += _unknown(entry, element, child)
        elif child.tag in _ATTRIBUTES:
            check_attributes(entry, child)
    return problems


def _unknown(entry: Entry, element: Element, child: Element) -> list[UrdfProblem]:
    tag = printable(child.tag)
    if child.tag in _ONCE["inertial"] and element.tag == "link":
        text = f"<{tag}> is not read here; put it into <inertial>, or remove it"
        return [entry.problem("unknown", text, child)]
    near = _nearest(child.tag, (*_ONCE[element.tag], *_MORE[element.tag]))
    text = f"<{tag}> is not known; write <{near}>, or remove it"
    if not near:
        return []
    if near not in _SEEN:
        raise entry.refusal(text, child)
    return [entry.problem("unknown", text, child)]


def check_attributes(entry: Entry, child: Element) -> None:
    """Refuse an element with an attribute that is another one misspelt.

    Args:
        entry: link or joint that it belongs to, for messages.
        child: the element.

    Raises:
        RobotError: naming the attribute that must be meant.
    """
    known = _ATTRIBUTES[child.tag]
    for name in child.attrib.keys() - set(known):
        left = [each for each in known if each not in child.attrib]
        near = _nearest(name, left, _ALIKE_SHORT)
        if near:
            raise entry.refusal(
                f"<{child.tag}> has {printable(name)}=, which is not known; write {near}=, or "
                "remove it",
                child,
            )


def _nearest(name: str, known: tuple[str, ...] | list[str], alike: float = _ALIKE) -> str:
    near = difflib.get_close_matches(name.lower(), known, 1, alike)
    return near[0] if near else ""
