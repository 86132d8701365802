"""The skeleton of a URDF: names, and joints that make one tree of the links."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element

from gaitopt.errors import RobotError
from gaitopt.robot.faults import Faults
from gaitopt.robot.files.xml_lines import XmlTree
from gaitopt.robot.urdf.values import Entry, UrdfProblem, printable

JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_OTHER_FORMATS = {
    "sdf": "convert it to URDF",
    "COLLADA": "give the robot's URDF, not one of its meshes",
}


def check_tree(tree: XmlTree) -> None:
    """Check names and parents: one root, and every other link hanging on exactly one joint.

    Raises:
        RobotError: naming the line, the link or joint, and what to do.
    """
    _check_root(tree.root)
    links, joints = _named(tree, "link"), _named(tree, "joint")
    if not links:
        raise RobotError("the URDF has no <link>; it describes no robot. Give another file")
    if "name" not in tree.root.attrib:
        line = tree.line(tree.root)
        raise RobotError(f'line {line}: <robot> has no name; give it one, as <robot name="walker">')
    movers: dict[str, Entry] = {}
    parents: dict[str, str] = {}
    faults = Faults()
    for joint in joints.values():
        with faults.noted():
            _check_type(joint)
        with faults.noted():
            parent, child = (_end(joint, role, links) for role in ("parent", "child"))
            if child in movers:
                raise joint.refusal(
                    f"its child link '{child}' already hangs on joint '{movers[child].name}'; a "
                    "link hangs on one joint only; remove one of the two (a URDF cannot describe "
                    "a loop)"
                )
            movers[child], parents[child] = joint, parent
    faults.refuse()
    _check_one_root(links, movers, parents)


def _check_root(root: Element) -> None:
    if root.tag != "robot":
        hint = _OTHER_FORMATS.get(root.tag, "give a URDF")
        raise RobotError(f"the file holds <{root.tag}>, not a URDF (<robot>); {hint}")
    for element in root.iter():
        if element.tag.startswith("xacro:"):
            raise RobotError(
                f"the file still holds xacro macros (<{element.tag}>); "
                "expand them first: xacro robot.urdf.xacro > robot.urdf"
            )
    for element in root:
        text = element.get("name", "")
        if element.tag in ("link", "joint") and "${" in text:
            raise RobotError(
                f'the file still holds xacro macros (name="{text}"); '
                "expand them first: xacro robot.urdf.xacro > robot.urdf"
            )


def _named(tree: XmlTree, tag: str) -> dict[str, Entry]:
    """Return the links or the joints by their names, which must be there and differ."""
    found: dict[str, Entry] = {}
    for element in tree.root.findall(tag):
        entry = Entry(tree, element)
        if not entry.name.strip():
            raise RobotError(f"line {tree.line(element)}: a {tag} has no name; give it one")
        if entry.name in found:
            first = tree.line(found[entry.name].element)
            raise entry.refusal(f"another {tag} has this name (line {first}); rename one of them")
        found[entry.name] = entry
    return found


def name_problems(tree: XmlTree) -> list[UrdfProblem]:
    """Return a problem for each name that does not show on a screen as it is."""
    problems = []
    for element in tree.root:
        name = element.get("name", "")
        if element.tag in ("link", "joint") and printable(name) != name:
            text = "its name holds characters that cannot be seen, here as Python writes them"
            problems.append(Entry(tree, element).problem("name", f"{text}; rename it"))
    return problems


def _check_type(joint: Entry) -> None:
    kind = joint.element.get("type")
    if kind not in JOINT_TYPES:
        raise joint.refusal(
            f"its type is {kind!r}; it must be one of {', '.join(JOINT_TYPES)}; correct it"
        )


def _end(joint: Entry, role: str, links: Mapping[str, Entry]) -> str:
    """Return the name of the link at one end of a joint."""
    element = joint.element.find(role)
    name = None if element is None else element.get("link")
    if name is None:
        raise joint.refusal(f'no {role} link is given; add <{role} link="..."/>', element)
    if name not in links:
        raise joint.refusal(
            f"its {role} link '{name}' does not exist; add that link, or correct its name", element
        )
    return name


def _check_one_root(
    links: Mapping[str, Entry], movers: Mapping[str, Entry], parents: Mapping[str, str]
) -> None:
    roots = [name for name in links if name not in movers]
    if len(roots) > 1:
        raise links[roots[1]].refusal(
            f"no joint leads to it, and none to {_quoted([roots[0], *roots[2:]])}; a robot has one "
            "root link; join the others to it (by fixed joints), or remove them"
        )
    above = {name: _climbs_to_root(name, parents) for name in links}
    stuck = [name for name, free in above.items() if not free]
    if stuck:
        raise movers[stuck[0]].refusal(
            f"it is part of a loop of joints ({_quoted(stuck)}); a URDF is a tree; remove the "
            "joint that closes the loop"
        )


def _climbs_to_root(name: str, parents: Mapping[str, str]) -> bool:
    for _ in range(len(parents) + 1):
        if name not in parents:
            return True
        name = parents[name]
    return False


def _quoted(names: list[str], most: int = 4) -> str:
    """Return the first few names in quotes."""
    shown = ", ".join(f"'{name}'" for name in names[:most])
    return shown + (f" and {len(names) - most} more" if len(names) > most else "")
