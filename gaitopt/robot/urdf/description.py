"""The values of a URDF as the file has them, each read once, by one grammar of numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from xml.etree.ElementTree import Element

import numpy as np

from gaitopt.nlp import Array
from gaitopt.robot.faults import Faults
from gaitopt.robot.files.xml_lines import XmlTree
from gaitopt.robot.urdf.values import Entry, as_number

Vector = tuple[float, float, float]

LIMITED = ("revolute", "prismatic")
FREE = ("floating", "planar")
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_UNITS = {"prismatic": ("N", "m/s", "m", "N·s/m")}
_ANGULAR = ("N.m", "rad/s", "rad", "N·m·s/rad")
_QUATERNIONS = (1, 2)  # version of URDF from which on an origin may have one
_UNIT = 1e-3  # by which the length of a quaternion may differ from 1: four digits of each number


@dataclass(frozen=True, eq=False)
class Pose:
    """Where something stands in the frame of its link, or a joint in that of its parent link.

    Attributes:
        xyz: [m].
        rotation: shape (3, 3).
    """

    xyz: Vector
    rotation: Array


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
    pose: Pose
    mass: float
    inertia: Array


@dataclass(frozen=True, eq=False)
class Link:
    """A link.

    Attributes:
        entry: of the file.
        inertial: its body, None if it has none.
    """

    entry: Entry
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

    entry: Entry
    kind: str
    parent: str
    child: str
    pose: Pose
    axis: Vector
    limits: Limits
    damping: float
    friction: float

    @property
    def name(self) -> str:
        """Its name."""
        return self.entry.name


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
    """Read the links and joints of a URDF.

    A bare root link that only carries the robot on a floating joint is left out: so does a
    free-flyer.

    Args:
        tree: of a URDF whose names and ends of joints were checked (`check_tree`).

    Raises:
        RobotError: a value is no number, with its line; no loader would take it as it is meant.
    """
    version = read_version(tree)
    faults, links, joints = Faults(), [], []
    for element in tree.root:
        with faults.noted():
            if element.tag == "link":
                links.append(_link(Entry(tree, element), version))
            elif element.tag == "joint":
                joints.append(_joint(Entry(tree, element), version))
    faults.refuse()
    found = Description(
        tree.root.get("name", ""),
        {link.name: link for link in links},
        {joint.name: joint for joint in joints},
    )
    return _without_world(found)


def read_pose(owner: Entry, origin: Element | None, what: str, version: tuple[int, ...]) -> Pose:
    """Read an `origin` element.

    Args:
        owner: link or joint, for messages.
        origin: None stands for no displacement.
        what: it is the origin of, for messages.
        version: of the URDF; quaternions count from 1.2 on.

    Raises:
        RobotError: a value is no number, or the orientation cannot be told.
    """
    xyz = owner.vector(origin, "xyz", f"the xyz of {what}")
    rpy = owner.vector(origin, "rpy", f"the rpy of {what}")
    if origin is None or "quat_xyzw" not in origin.attrib:
        return Pose(xyz, _from_rpy(rpy))
    if "rpy" in origin.attrib:
        raise owner.refusal(f"{what} has both rpy and quat_xyzw; remove one of them", origin)
    if version < _QUATERNIONS:
        raise owner.refusal(
            f"{what} has quat_xyzw, which counts from version 1.2 of URDF on only; write "
            '<robot version="1.2"> or give its rpy',
            origin,
        )
    name = f"the quat_xyzw of {what}"
    quaternion = np.array(owner.numbers(origin, "quat_xyzw", name, 4))
    length = float(np.linalg.norm(quaternion))
    if not abs(length - 1.0) < _UNIT:
        raise owner.refusal(f"{name} has length {length:.4g}; it must be 1; correct it", origin)
    return Pose(xyz, _from_quaternion(quaternion / length))


def read_version(tree: XmlTree) -> tuple[int, ...]:
    """Return the version of URDF that a document has, (1, 0) if it says none."""
    words = tree.root.get("version", "1.0").strip().split(".")
    return tuple(int(word) for word in words if word.isascii() and word.isdigit()) or (1, 0)


def _link(entry: Entry, version: tuple[int, ...]) -> Link:
    element = entry.element.find("inertial")
    if element is None:
        return Link(entry, None)
    mass_entry, tensor = element.find("mass"), element.find("inertia")
    mass = entry.number(mass_entry, "value", "mass", "kg")
    if mass < 0.0:
        raise entry.refusal(f"the mass is {mass:g} kg; it must be above 0; correct it", mass_entry)
    xx, xy, xz, yy, yz, zz = (entry.number(tensor, m, m, "kg·m²") for m in MOMENTS)
    pose = read_pose(entry, element.find("origin"), "its centre of mass", version)
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Link(entry, Inertial(element, pose, mass, inertia))


def _joint(entry: Entry, version: tuple[int, ...]) -> Joint:
    kind = entry.element.get("type", "")
    pose = read_pose(entry, entry.element.find("origin"), "its origin", version)
    axis, limits, damping, friction = (1.0, 0.0, 0.0), Limits(), 0.0, 0.0
    if kind != "fixed" and kind not in FREE:
        axis = _axis(entry)
        limits = _limits(entry, kind)
        damping, friction = _dynamics(entry, kind)
    ends = (entry.element.find(role) for role in ("parent", "child"))
    parent, child = ("" if end is None else end.get("link", "") for end in ends)
    return Joint(entry, kind, parent, child, pose, axis, limits, damping, friction)


def _axis(joint: Entry) -> Vector:
    axis = joint.element.find("axis")
    values = joint.vector(axis, "xyz", "its axis", "1 0 0" if axis is None else "")
    if not any(values):
        raise joint.refusal("its axis is 0 0 0; it needs a direction, as 0 1 0; correct it", axis)
    return values


def _limits(joint: Entry, kind: str) -> Limits:
    limit = joint.element.find("limit")
    soft = _soft(joint, joint.element.find("safety_controller"), kind)
    if limit is None:
        return Limits(soft=soft)
    values = {}
    for name in ("effort", "velocity", "lower", "upper"):
        text = limit.get(name)
        values[name] = math.nan if text is None else as_number(text)
        if text is not None and math.isnan(values[name]):
            raise joint.refusal(_no_limit(joint, name, text, limit_unit(kind, name)), limit)
        if name in ("effort", "velocity") and values[name] < 0.0:
            unit = limit_unit(kind, name)
            text = f"the {name} limit is {text!r}; it must be above 0; give it [{unit}]"
            raise joint.refusal(text, limit)
    return Limits(**values, soft=soft)


def _no_limit(joint: Entry, name: str, text: str, unit: str) -> str:
    if name in ("effort", "velocity"):
        return f"the {name} limit is {text!r}; it must be above 0; give it [{unit}]"
    return f"the {name} limit is {text!r}, which is no number; give it [{unit}]"


def _soft(joint: Entry, safety: Element | None, kind: str) -> tuple[float, float] | None:
    if safety is None or not {"soft_lower_limit", "soft_upper_limit"} & set(safety.attrib):
        return None
    unit = limit_unit(kind, "lower")
    ends = []
    for side in ("lower", "upper"):
        attribute = f"soft_{side}_limit"
        given = attribute in safety.attrib  # 0 by the format if only the other one is
        name = f"the {attribute} of its safety_controller"
        ends.append(joint.number(safety, attribute, name, unit) if given else 0.0)
    return ends[0], ends[1]


def _dynamics(joint: Entry, kind: str) -> tuple[float, float]:
    dynamics = joint.element.find("dynamics")
    if dynamics is None:
        return 0.0, 0.0
    values = []
    for name, unit in (
        ("damping", limit_unit(kind, "damping")),
        ("friction", limit_unit(kind, "effort")),
    ):
        value = joint.number(dynamics, name, name, unit) if name in dynamics.attrib else 0.0
        if value < 0.0:
            text = f"its {name} is {value:g} {unit}; it must not be below 0; correct it"
            raise joint.refusal(text, dynamics)
        values.append(value)
    return values[0], values[1]


def limit_unit(kind: str, name: str) -> str:
    """Return the unit of a limit: of "effort", "velocity", "lower", "upper" or "damping".

    Args:
        kind: of the joint.
        name: of the quantity.
    """
    places = {"effort": 0, "velocity": 1, "lower": 2, "upper": 2, "damping": 3}
    return _UNITS.get(kind, _ANGULAR)[places[name]]


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


def _from_quaternion(quaternion: Array) -> Array:
    """Return the rotation of a unit quaternion x, y, z, w (Euler-Rodrigues)."""
    vector, scalar = quaternion[:3], float(quaternion[3])
    x, y, z = vector
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation: Array = np.eye(3) + 2.0 * (scalar * cross + cross @ cross)
    return rotation


def _without_world(found: Description) -> Description:
    root = found.links[found.root]
    below = found.below[root.name]
    if root.inertial is not None or [joint.kind for joint in below] != ["floating"]:
        return found
    links = {name: link for name, link in found.links.items() if link is not root}
    joints = {name: joint for name, joint in found.joints.items() if joint is not below[0]}
    return Description(found.name, links, joints)
