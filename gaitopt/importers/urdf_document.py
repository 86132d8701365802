"""What a URDF says of links and joints: checked, and each value read once, by one grammar.

Readers of URDFs take the first of two `<inertial>`, or the last, and pass over `<inertail>` in
silence: the robot that walks would be another than the file's. Here names, parents and spelling are
checked before any value is read.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator, Mapping
from functools import cached_property
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError, did_you_mean
from gaitopt.escape import printable
from gaitopt.importers.report import Faults, listed
from gaitopt.importers.xml_document import (
    EXPAND,
    FileProblem,
    NamedElement,
    XmlTree,
    as_number,
    is_macro,
    number_hint,
)
from gaitopt.nlp import Array
from gaitopt.units import motion_words

Vector = tuple[float, float, float]

JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_OTHER_FORMATS = {
    "sdf": "convert it to URDF",
    "COLLADA": "give the robot's URDF, not one of its meshes",
}
_OLD_MACROS = ("include", "property", "macro")  # of xacro before it had a name space
_SINGLE_TAGS = {
    "link": ("inertial",),
    "inertial": ("origin", "mass", "inertia"),
    "joint": (
        "origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "safety_controller",
        "calibration",
    ),
}  # fmt: skip
_REPEATED_TAGS = {"link": ("visual", "collision"), "inertial": (), "joint": ()}
_KNOWN_ATTRIBUTES = {
    "origin": ("xyz", "rpy", "quat_xyzw"),
    "axis": ("xyz",),
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "limit": ("effort", "velocity", "lower", "upper", "acceleration", "deceleration", "jerk"),
    "dynamics": ("damping", "friction"),
}
_TAGS_WITHOUT_MOTION = (
    "visual",
    "collision",
    "safety_controller",
    "calibration",
)
_SIMILAR_TAGS = 0.7  # ratio of `difflib`: one letter of five wrong, missing or exchanged
_SIMILAR_ATTRIBUTES = 0.66  # and of three, as in xzy
LIMITED_TYPES = ("revolute", "prismatic")
FREE_TYPES = ("floating", "planar")
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_UNITS = {
    "effort": "N.m", "velocity": "rad/s", "lower": "rad", "upper": "rad", "damping": "N·m·s/rad",
}  # fmt: skip
_QUATERNION_VERSION = (1, 2)  # version of URDF from which on an origin may have one
_UNIT_QUATERNION_ERROR = 1e-3  # of its length from 1: four digits of each number


@dataclass(frozen=True, eq=False)
class Inertial:
    """The body of a link.

    Attributes:
        element: of the file.
        pose: its centre of mass, and the axes of the inertia.
        mass: [kg].
        inertia: about the centre of mass, along these axes [kg·m²], shape (3, 3).
    """

    element: Element
    pose: pin.SE3
    mass: float
    inertia: Array


@dataclass(frozen=True, eq=False)
class Link:
    """A link.

    Attributes:
        entry: of the file.
        inertial: its body, None if it has none.
    """

    entry: NamedElement
    inertial: Inertial | None

    @property
    def name(self) -> str:
        """Its name."""
        return self.entry.name

    @property
    def mass(self) -> float:
        """Its mass [kg]."""
        return 0.0 if self.inertial is None else self.inertial.mass


@dataclass(frozen=True)
class Limits:
    """What a joint may do; NaN stands for what is not given, infinity for what is said to be free.

    Attributes:
        effort: largest torque or force [N·m, N].
        velocity: largest rate [rad/s, m/s].
        lower, upper: range [rad, m].
        soft: range within which its controller keeps it [rad, m], None if none is given.
    """

    effort: float = math.nan
    velocity: float = math.nan
    lower: float = math.nan
    upper: float = math.nan
    soft: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint.

    Attributes:
        entry: of the file.
        kind: one of `JOINT_TYPES`.
        parent, child: names of its links.
        pose: in the parent link.
        axis: not normed, in its own frame.
        limits: of its motion.
        damping: [N·m·s/rad, N·s/m].
        friction: [N·m, N].
    """

    entry: NamedElement
    kind: str
    parent: str
    child: str
    pose: pin.SE3
    axis: Vector
    limits: Limits
    damping: float
    friction: float

    @property
    def name(self) -> str:
        """Its name."""
        return self.entry.name

    @property
    def range(self) -> tuple[float, float]:
        """Range [rad, m]; a side not given is at 0, as the format has it.

        A continuous joint has none, whatever its limit says.
        """
        if self.kind == "continuous":
            return -math.inf, math.inf
        lower, upper = self.limits.lower, self.limits.upper
        return 0.0 if math.isnan(lower) else lower, 0.0 if math.isnan(upper) else upper


@dataclass(frozen=True, eq=False)
class Description:
    """All that a URDF says about links and joints, in the order of the file.

    Attributes:
        name: of the robot.
        links: by name.
        joints: by name.
    """

    name: str
    links: dict[str, Link]
    joints: dict[str, Joint]

    @cached_property
    def below(self) -> dict[str, list[Joint]]:
        """The joints that hang on each link, in the order of Pinocchio's loader.

        It sorts them by the bytes of their names.
        """
        found: dict[str, list[Joint]] = {name: [] for name in self.links}
        for joint in sorted(self.joints.values(), key=lambda joint: joint.name.encode()):
            found[joint.parent].append(joint)
        return found

    @cached_property
    def root(self) -> str:
        """Name of the link on which no joint hangs it."""
        children = {joint.child for joint in self.joints.values()}
        return next(name for name in self.links if name not in children)

    def rigid(self, link: str) -> Iterator[str]:
        """Yield a link and all that is fixed to it, directly or not."""
        waiting, below = [link], self.below
        while waiting:
            name = waiting.pop()
            yield name
            waiting += [joint.child for joint in below[name] if joint.kind == "fixed"]


def describe(tree: XmlTree) -> Description:
    """Read the links and joints of a URDF whose tree was checked (`check_tree`).

    A bare root link that only carries the robot on a floating joint is left out: so does a
    free-flyer.

    Raises:
        RobotError: a value is no number, with its line; no loader would take it as it is meant.
    """
    version = read_version(tree)
    faults, links, joints = Faults(), [], []
    for element in tree.root:
        with faults.noted():
            if element.tag == "link":
                links.append(_link(NamedElement(tree, element), version))
            elif element.tag == "joint":
                joints.append(_joint(NamedElement(tree, element), version))
    faults.refuse()
    name, by_name = tree.root.get("name", ""), {link.name: link for link in links}
    found = Description(name, by_name, {joint.name: joint for joint in joints})
    root = found.links[found.root]
    below = found.below[root.name]
    if root.inertial is not None or [joint.kind for joint in below] != ["floating"]:
        return found
    del by_name[root.name]
    return Description(name, by_name, {j.name: j for j in joints if j is not below[0]})


def read_origin(
    owner: NamedElement, origin: Element | None, what: str, version: tuple[int, ...]
) -> pin.SE3:
    """Read an `origin` element, where None stands for no displacement.

    Raises:
        RobotError: a value is no number, or the orientation cannot be told.
    """
    xyz = owner.vector(origin, "xyz", f"the xyz of {what}")
    rpy = owner.vector(origin, "rpy", f"the rpy of {what}")
    if origin is None or "quat_xyzw" not in origin.attrib:
        return pin.SE3(_from_rpy(rpy), np.array(xyz))
    if "rpy" in origin.attrib:
        raise owner.refusal(f"{what} has both rpy and quat_xyzw; remove one of them", origin)
    if version < _QUATERNION_VERSION:
        raise owner.refusal(
            f"{what} has quat_xyzw, which counts from version 1.2 of URDF on only; write "
            '<robot version="1.2"> or give its rpy',
            origin,
        )
    name = f"the quat_xyzw of {what}"
    quaternion = np.array(owner.numbers(origin, "quat_xyzw", name, 4))
    length = float(np.linalg.norm(quaternion))
    if not abs(length - 1.0) < _UNIT_QUATERNION_ERROR:
        raise owner.refusal(f"{name} has length {length:.4g}; it must be 1; correct it", origin)
    turn = pin.Quaternion(quaternion / length).toRotationMatrix()
    return pin.SE3(turn, np.array(xyz))


def read_version(tree: XmlTree) -> tuple[int, ...]:
    """Return the version of URDF that a document has, (1, 0) if it says none."""
    words = tree.root.get("version", "1.0").strip().split(".")
    return tuple(int(word) for word in words if word.isascii() and word.isdigit()) or (1, 0)


def _link(entry: NamedElement, version: tuple[int, ...]) -> Link:
    element = entry.element.find("inertial")
    if element is None:
        return Link(entry, None)
    mass_entry, tensor = element.find("mass"), element.find("inertia")
    mass = entry.number(mass_entry, "value", "mass", "kg")
    if mass < 0.0:
        raise entry.refusal(f"the mass is {mass:g} kg; it must be above 0; correct it", mass_entry)
    xx, xy, xz, yy, yz, zz = (entry.number(tensor, m, m, "kg·m²") for m in MOMENTS)
    pose = read_origin(entry, element.find("origin"), "its centre of mass", version)
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Link(entry, Inertial(element, pose, mass, inertia))


def _joint(entry: NamedElement, version: tuple[int, ...]) -> Joint:
    kind = entry.element.get("type", "")
    pose = read_origin(entry, entry.element.find("origin"), "its origin", version)
    axis, limits, damping, friction = (1.0, 0.0, 0.0), Limits(), 0.0, 0.0
    if kind != "fixed" and kind not in FREE_TYPES:
        axis = _axis(entry)
        limits = _limits(entry, kind)
        damping, friction = _dynamics(entry, kind)
    ends = (entry.element.find(role) for role in ("parent", "child"))
    parent, child = ("" if end is None else end.get("link", "") for end in ends)
    return Joint(entry, kind, parent, child, pose, axis, limits, damping, friction)


def _axis(joint: NamedElement) -> Vector:
    axis = joint.element.find("axis")
    values = joint.vector(axis, "xyz", "its axis", "1 0 0" if axis is None else "")
    if not any(values):
        raise joint.refusal("its axis is 0 0 0; it needs a direction, as 0 1 0; correct it", axis)
    return values


def _limits(joint: NamedElement, kind: str) -> Limits:
    limit = joint.element.find("limit")
    soft = _soft(joint, joint.element.find("safety_controller"), kind)
    if limit is None:
        return Limits(soft=soft)
    values = {}
    for name in ("effort", "velocity", "lower", "upper"):
        text = limit.get(name)
        values[name] = math.nan if text is None else as_number(text)
        one_sided = name in ("effort", "velocity")
        if text is not None and (math.isnan(values[name]) or (one_sided and values[name] < 0.0)):
            allowed = "; it must be above 0"
            if math.isnan(values[name]):
                allowed = f", which is no number{number_hint(text)}"
            given = f"the {name} limit is {text!r}{allowed}; give it [{limit_unit(kind, name)}]"
            raise joint.refusal(given, limit)
    return Limits(**values, soft=soft)


def _soft(joint: NamedElement, safety: Element | None, kind: str) -> tuple[float, float] | None:
    if safety is None or not {"soft_lower_limit", "soft_upper_limit"} & set(safety.attrib):
        return None

    def end(attribute: str) -> float:
        # 0 by the format if only the other one is given, and infinite for none
        value = as_number(safety.get(attribute, "0"))
        name = f"the {attribute} of its safety_controller"
        unit = limit_unit(kind, "lower")
        return joint.number(safety, attribute, name, unit) if math.isnan(value) else value

    return end("soft_lower_limit"), end("soft_upper_limit")


def _dynamics(joint: NamedElement, kind: str) -> tuple[float, float]:
    dynamics = joint.element.find("dynamics")

    def positive(name: str, unit: str) -> float:
        if dynamics is None or name not in dynamics.attrib:
            return 0.0
        value = joint.number(dynamics, name, name, unit)
        if value < 0.0:
            text = f"its {name} is {value:g} {unit}; it must not be below 0; correct it"
            raise joint.refusal(text, dynamics)
        return value

    damping = positive("damping", limit_unit(kind, "damping"))
    return damping, positive("friction", limit_unit(kind, "effort"))


def limit_unit(kind: str, name: str) -> str:
    """Return the unit of "effort", "velocity", "lower", "upper" or "damping" of a joint."""
    return motion_words(_UNITS[name], slides=kind == "prismatic")


def _from_rpy(rpy: Vector) -> Array:
    """Return the rotation about the fixed axes x, y, z, in this order."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def _refuse_hidden(tree: XmlTree) -> None:
    """Refuse links and joints inside of other elements, which no reader of URDFs finds."""
    for outer in tree.root:
        for inner in () if outer.tag == "gazebo" else outer.iter():
            hidden = {"link": "name", "joint": "type"}.get(inner.tag, "")
            if inner is not outer and hidden in inner.attrib:
                raise NamedElement(tree, inner).refusal(
                    f"it stands inside <{printable(outer.tag)}>, where it does not count; put it "
                    "into <robot> itself, or remove it"
                )


def check_tree(tree: XmlTree) -> None:
    """Check names and parents: one root, and every other link hanging on exactly one joint.

    Raises:
        RobotError: naming the line, the link or joint, and what to do.
    """
    _check_root(tree.root)
    _refuse_hidden(tree)
    links, joints = _named(tree, "link"), _named(tree, "joint")
    if not links:
        raise RobotError("the URDF has no <link>; it describes no robot. Give another file")
    if "name" not in tree.root.attrib:
        line = tree.line(tree.root)
        raise RobotError(f'line {line}: <robot> has no name; give it one, as <robot name="walker">')
    movers: dict[str, NamedElement] = {}
    parents: dict[str, str] = {}
    faults = Faults()
    for joint in joints.values():
        with faults.noted():
            if (kind := joint.element.get("type")) not in JOINT_TYPES:
                allowed = ", ".join(JOINT_TYPES)
                raise joint.refusal(
                    f"its type is {kind!r}; it must be one of {allowed}; correct it"
                )
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
        hint = _OTHER_FORMATS.get(root.tag, "give one of these")
        if (small := root.tag.lower()) in ("robot", "mujoco"):
            hint = f"write <{small}>"
        raise RobotError(
            f"the file holds <{root.tag}>, not a URDF (<robot>) or MJCF (<mujoco>); {hint}"
        )
    spaces = {name[6:] for name, address in root.attrib.items() if address.endswith("/xacro")}
    macros = [
        f"<{element.tag}>"
        for element in root.iter()
        if element.tag.rpartition(":")[0] in {"xacro", *spaces} - {""}
    ]
    macros += [f"<{element.tag}>" for element in root if element.tag in _OLD_MACROS]
    movers = [element for element in root if element.tag in ("link", "joint")]
    named = [(element, "name") for element in movers]
    named += [(end, key) for element in movers for end in element for key in ("link", "joint")]
    texts = ((key, element.get(key, "")) for element, key in named)
    macros += [f'{key}="{text}"' for key, text in texts if is_macro(text)]
    if macros:
        raise RobotError(f"the file still holds xacro macros ({macros[0]}); {EXPAND}")


def _named(tree: XmlTree, tag: str) -> dict[str, NamedElement]:
    """Return the links or the joints by their names, which must be there and differ."""
    found: dict[str, NamedElement] = {}
    for element in tree.root.findall(tag):
        entry = NamedElement(tree, element)
        if not entry.name.strip():
            raise RobotError(f"line {tree.line(element)}: a {tag} has no name; give it one")
        if entry.name in found:
            first = tree.line(found[entry.name].element)
            raise entry.refusal(f"another {tag} has this name (line {first}); rename one of them")
        found[entry.name] = entry
    return found


def name_problems(tree: XmlTree) -> list[FileProblem]:
    """Return a problem for each name that does not show on a screen as it is."""
    problems = []
    for element in tree.root:
        name = element.get("name", "")
        if element.tag in ("link", "joint") and printable(name) != name:
            text = "its name holds characters that cannot be seen, here as Python writes them"
            problems.append(NamedElement(tree, element).problem("name", f"{text}; rename it"))
    return problems


def _end(joint: NamedElement, role: str, links: Mapping[str, NamedElement]) -> str:
    """Return the name of the link at one end of a joint."""
    element = joint.element.find(role)
    name = None if element is None else element.get("link")
    if name is None:
        raise joint.refusal(f'no {role} link is given; add <{role} link="..."/>', element)
    if name not in links:
        raise joint.refusal(
            f"its {role} link '{name}' does not exist; {did_you_mean(name, links)}add that link, "
            "or correct its name",
            element,
        )
    return name


def _check_one_root(
    links: Mapping[str, NamedElement],
    movers: Mapping[str, NamedElement],
    parents: Mapping[str, str],
) -> None:
    roots = [name for name in links if name not in movers]
    if len(roots) > 1:
        raise links[roots[1]].refusal(
            f"no joint leads to it, and none to {listed([roots[0], *roots[2:]])}; a robot has one "
            "root link; join the others to it (by fixed joints), or remove them"
        )
    below: dict[str, list[str]] = {}
    for child, parent in parents.items():
        below.setdefault(parent, []).append(child)
    reached = list(roots)
    for name in reached:  # which grows
        reached += below.get(name, ())
    if stuck := [name for name in links if name not in set(reached)]:
        raise movers[stuck[0]].refusal(
            f"it is part of a loop of joints ({listed(stuck)}); a URDF is a tree; remove the "
            "joint that closes the loop"
        )


def check_spelling(tree: XmlTree) -> list[FileProblem]:
    """Check that every link and joint says each thing once, under its own name.

    Return what is passed over although it looks as if it was meant.

    Raises:
        RobotError: an element is there twice, or one that motion depends on is misspelt.
    """
    problems, faults = [], Faults()
    for element in tree.root:
        if element.tag in ("link", "joint"):
            entry = NamedElement(tree, element)
            for part in (element, *element.findall("inertial")):
                with faults.noted():
                    problems += _check(entry, part)
    faults.refuse()
    return problems


def _check(entry: NamedElement, element: Element) -> list[FileProblem]:
    problems = []
    once = _SINGLE_TAGS[element.tag]
    for tag in once:
        found = element.findall(tag)
        if len(found) > 1:
            lines = " and ".join(str(entry.tree.line(one)) for one in found)
            raise entry.refusal(
                f"it has {len(found)} <{tag}> (lines {lines}); one is allowed; remove the others",
                found[1],
            )
    for child in element:
        if child.tag not in (*once, *_REPEATED_TAGS[element.tag]):
            problems += _unknown(entry, element, child)
        elif child.tag in _KNOWN_ATTRIBUTES:
            check_attributes(entry, child)
    return problems


def _unknown(entry: NamedElement, element: Element, child: Element) -> list[FileProblem]:
    tag = printable(child.tag)
    if child.tag in _SINGLE_TAGS["inertial"] and element.tag == "link":
        text = f"<{tag}> is not read here; put it into <inertial>, or remove it"
        return [entry.problem("unknown", text, child)]
    near = _nearest(child.tag, (*_SINGLE_TAGS[element.tag], *_REPEATED_TAGS[element.tag]))
    text = f"<{tag}> is not known; write <{near}>, or remove it"
    if not near:
        return []
    if near not in _TAGS_WITHOUT_MOTION:
        raise entry.refusal(text, child)
    return [entry.problem("unknown", text, child)]


def check_attributes(entry: NamedElement, child: Element) -> None:
    """Refuse an element of a link or joint with an attribute that is another one misspelt.

    Raises:
        RobotError: naming the attribute that must be meant.
    """
    known = _KNOWN_ATTRIBUTES[child.tag]
    for name in child.attrib.keys() - set(known):
        left = [each for each in known if each not in child.attrib]
        near = _nearest(name, left, _SIMILAR_ATTRIBUTES)
        if near:
            raise entry.refusal(
                f"<{child.tag}> has {printable(name)}=, which is not known; write {near}=, or "
                "remove it",
                child,
            )


def _nearest(name: str, known: tuple[str, ...] | list[str], alike: float = _SIMILAR_TAGS) -> str:
    near = difflib.get_close_matches(name.lower(), known, 1, alike)
    return near[0] if near else ""
