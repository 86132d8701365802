"""Joints that an MJCF file ties to each other or to a place, which no motor turns alone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from xml.etree.ElementTree import Element

from gaitopt.robot.files.xml_lines import XmlTree
from gaitopt.robot.mjcf.defaults import Defaults
from gaitopt.robot.urdf.values import Entry, UrdfProblem

_Names = frozenset[str]
_NONE: _Names = frozenset()
_LOOPS = ("connect", "weld")  # of bodies, which no longer hang on one joint
_KINDS = ("body", "site", "joint", "tendon")


def tied_joints(tree: XmlTree) -> list[UrdfProblem]:
    """Return a problem for every joint that an `equality` ties, if it is active.

    Two bodies that are connected tie all joints on the way from one to the other.

    Args:
        tree: of a whole document whose classes are defined.

    Raises:
        RobotError: an equality names what is not there.
    """
    defaults, known = Defaults.of(tree.root), _joints_of(tree.root)
    problems = []
    for element in [e for section in tree.root.findall("equality") for e in section]:
        if defaults.complete(element, tag="equality").get("active") == "false":
            continue
        for name in sorted(_tied(Entry(tree, element), known)):
            text = (
                f"joint '{name}': <{element.tag}> of {_ends(element)} in <equality> ties it, which "
                "is not supported in a leg: every leg joint has its own motor; remove that "
                f"<{element.tag}>"
            )
            line, file = tree.line(element), tree.file(element)
            kind = "free" if element.tag in _LOOPS else "mimic"
            problems.append(UrdfProblem(kind, name, text, line, file))
    return problems


def _ends(element: Element) -> str:
    """Return the names of what is tied."""
    return " and ".join(f"'{n}'" for a, n in element.attrib.items() if a[:-1] in _KINDS)


def _tied(entry: Entry, known: Mapping[str, Mapping[str, _Names]]) -> _Names:
    """Return the names of the joints that one equality ties."""
    ends = []
    for attribute, name in entry.element.attrib.items():
        kind = attribute[:-1]
        if kind in _KINDS and attribute[-1] in "12":
            if name not in known[kind]:
                raise entry.refusal(
                    f"its {attribute} is '{name}', but there is no such {kind}; correct the name"
                )
            ends.append(known[kind][name])
    return _between(ends) if entry.element.tag in _LOOPS else _NONE.union(*ends)


def _between(ends: Iterable[_Names]) -> _Names:
    """Return the joints on the way between bodies, given those that carry each; one hangs free."""
    carriers = list(ends)
    if len(carriers) == 1:  # the other is the world
        return carriers[0]
    return _NONE.union(*carriers) - carriers[0].intersection(*carriers) if carriers else _NONE


def _joints_of(root: Element) -> dict[str, dict[str, _Names]]:
    """Return the joints that carry each body and site, or that a joint and a tendon name."""
    known: dict[str, dict[str, _Names]] = {kind: {} for kind in _KINDS}
    for world in root.findall("worldbody"):
        _carry(world, _NONE, known)
    known["body"]["world"] = _NONE
    known["joint"] = {name: frozenset({name}) for name in _NONE.union(*known["body"].values())}
    for tendon in [t for section in root.findall("tendon") for t in section]:
        sites = [known["site"].get(site.get("site", ""), _NONE) for site in tendon.findall("site")]
        joints = frozenset(joint.get("joint", "") for joint in tendon.findall("joint"))
        known["tendon"][tendon.get("name", "")] = joints | _between(sites)
    return known


def _carry(body: Element, carriers: _Names, known: dict[str, dict[str, _Names]]) -> None:
    carriers = carriers | {j.attrib["name"] for j in body.findall("joint") if "name" in j.attrib}
    known["body"][body.get("name", "")] = carriers
    for site in body.findall("site"):
        known["site"][site.get("name", "")] = carriers
    for below in body.findall("body"):
        _carry(below, carriers, known)
