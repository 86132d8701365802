"""Orders of joints: that of the gait file, MuJoCo's, Isaac's, Unitree's for the G1, or one's own.

A motion whose columns are in another order than its reader's moves the wrong joints without a word.
Orders of engines follow from the robot's file, URDF or MJCF, whose text a gait file holds.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import deque
from collections.abc import Callable, Sequence
from functools import cached_property, partial

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, RobotError
from gaitopt.importers.report import listed
from gaitopt.importers.xml_document import as_numbers, parse_xml
from gaitopt.model.multibody import BASE, Multibody
from gaitopt.nlp import Array

ORDERS = ("gait", "mujoco", "isaac", "g1")
"""Names of orders; others are lists of joints."""

_LEG = ("hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll")
_ARM = (
    "shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow",
    "wrist_roll", "wrist_pitch", "wrist_yaw",
)  # fmt: skip
G1_JOINTS = tuple(
    f"{name}_joint"
    for name in (
        *(f"{side}_{name}" for side in ("left", "right") for name in _LEG),
        *(f"waist_{name}" for name in ("yaw", "roll", "pitch")),
        *(f"{side}_{name}" for side in ("left", "right") for name in _ARM),
    )
)
"""Joints of Unitree's G1 of 29 degrees of freedom, in the order of its motors."""

_CONTAINERS = ("frame", "replicate", "worldbody")  # of MJCF, whose bodies are those of the parent
_SPACE, _ORIGIN = 3, (0.0, 0.0, 0.0)
_listed = partial(listed, most=6)  # names of joints in a message


@dataclass(frozen=True)
class FileJoint:
    """A joint of a robot's file.

    Attributes:
        name: of the joint.
        link: the body that it moves.
        anchor: of the joint in the frame of that body [m]; URDF has them at its origin.
        last: whether no other joint stands between it and the body.
    """

    name: str
    link: str
    anchor: tuple[float, ...] = _ORIGIN
    last: bool = True


@dataclass(frozen=True, eq=False)
class RobotOrder:
    """Joints and bodies of a robot in the orders of engines.

    Attributes:
        body: the robot.
        text: of its file, URDF or MJCF.
    """

    body: Multibody
    text: str

    def rows(self, order: str | Sequence[str]) -> tuple[int, ...]:
        """Return the joints of an order, as rows of the joints of the robot.

        Args:
            order: one of `ORDERS`, or names of joints, as a sequence or joined by commas. Joints
                that stand still may be left out.

        Raises:
            InputError: the order is unknown, has a joint that the robot has not or has twice, or
                lacks one that moves; or the file does not tell the order.
        """
        names = self._names(order)
        known = {name: row for row, name in enumerate(self.body.joint_names)}
        unknown = [name for name in names if name not in known]
        if unknown:
            whose = "the order 'g1' has" if order == "g1" else "the order has"
            raise InputError(
                f"{whose} {_listed(unknown)}, which '{self.body.name}' has not; its joints are "
                f"{', '.join(known)}"
            )
        if len(set(names)) < len(names):
            twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
            raise InputError(f"the order has {_listed(twice)} twice; give each joint once")
        if missing := [name for name in self.body.driven_names if name not in names]:
            raise InputError(
                f"the order lacks {_listed(missing)}, which the gait moves; only joints that stand "
                "still may be left out"
            )
        return tuple(known[name] for name in names)

    def bodies(self, rows: Sequence[int]) -> tuple[int, ...]:
        """Return the bodies that joints move, the base first, in the order of the joints."""
        return (0, *(row + 1 for row in rows if self._joint(row).last))

    def link_names(self, bodies: Sequence[int]) -> tuple[str, ...]:
        """Return the names of bodies as links; of one that the file does not name, its joint's."""
        return tuple(self._joint(body - 1).link if body else self.body.base for body in bodies)

    def anchors(self, bodies: Sequence[int]) -> Array:
        """Return where the joints of bodies sit in the frames of the file [m], (bodies, 3)."""
        return np.array([self._joint(b - 1).anchor if b else _ORIGIN for b in bodies])

    def _names(self, order: str | Sequence[str]) -> list[str]:
        if not isinstance(order, str):
            return [str(name) for name in order]
        known: dict[str, Callable[[], Sequence[str]]] = {
            "gait": lambda: self.body.joint_names,
            "mujoco": self._depth_first,
            "isaac": self._breadth_first,
            "g1": lambda: G1_JOINTS,
        }
        if order in known:
            return list(known[order]())
        if "," not in order and order not in self.body.joint_names:
            raise InputError(
                f"no order of joints is named '{order}'; choose {', '.join(ORDERS)}, or give the "
                "names of the joints, joined by commas"
            )
        return [name.strip() for name in order.split(",") if name.strip()]

    def _depth_first(self) -> list[str]:
        """Return the joints as MuJoCo numbers them: depth first, brothers as in the file."""
        names = [joint.name for joint in self._file if joint.name in self._known]
        if lost := [name for name in self.body.joint_names if name not in names]:
            raise InputError(
                f"the robot's file does not tell where {_listed(lost)} stands in the order of an "
                "engine; give the names of the joints, joined by commas"
            )
        return names

    def _breadth_first(self) -> list[str]:
        """Return the joints as Isaac numbers them: level by level.

        Its importer of URDF files sorts joints by name; that of MJCF keeps the order of the file.
        """
        names = self._depth_first()
        rank = {name: k for k, name in enumerate(names if self._is_mjcf else sorted(names))}
        children: dict[int, list[int]] = {}
        for row in sorted(range(len(names)), key=lambda row: rank[self.body.joint_names[row]]):
            children.setdefault(int(self.body.parent[row]), []).append(row)
        rows, waiting = [], deque([BASE])
        while waiting:
            own = children.get(waiting.popleft(), [])
            rows += own
            waiting.extend(own)
        return [self.body.joint_names[row] for row in rows]

    def _joint(self, row: int) -> FileJoint:
        name = self.body.joint_names[row]
        return self._by_name.get(name, FileJoint(name, name))

    @cached_property
    def _known(self) -> frozenset[str]:
        return frozenset(self.body.joint_names)

    @cached_property
    def _by_name(self) -> dict[str, FileJoint]:
        return {joint.name: joint for joint in self._file}

    @cached_property
    def _root(self) -> ET.Element | None:
        try:
            return parse_xml(self.text).root
        except RobotError:
            return None  # a file that no order is asked of needs none

    @property
    def _is_mjcf(self) -> bool:
        return self._root is not None and self._root.tag == "mujoco"

    @cached_property
    def _file(self) -> list[FileJoint]:
        """The joints of the file depth first, brothers in its order."""
        if self._root is None:
            return []
        return _mjcf_joints(self._root) if self._is_mjcf else _urdf_joints(self._root)


def _urdf_joints(root: ET.Element) -> list[FileJoint]:
    """Return the joints of a URDF depth first, those that are fixed too."""
    below: dict[str, list[FileJoint]] = {}
    moved = set()
    for element in root.findall("joint"):
        parent, child = (_attribute(element.find(tag), "link") for tag in ("parent", "child"))
        below.setdefault(parent, []).append(FileJoint(element.get("name", ""), child))
        moved.add(child)
    found: list[FileJoint] = []
    waiting = [
        joint
        for link in reversed(list(below))
        if link not in moved
        for joint in reversed(below[link])
    ]
    while waiting:
        joint = waiting.pop()
        found.append(joint)
        waiting += reversed(below.pop(joint.link, []))
    return found


def _mjcf_joints(root: ET.Element) -> list[FileJoint]:
    """Return the joints of an MJCF file, whose bodies are nested."""
    found: list[FileJoint] = []
    waiting = list(reversed(root.findall("worldbody")))
    while waiting:
        body = waiting.pop()
        own = [] if body.tag in _CONTAINERS else body.findall("joint")
        for joint in own:
            given = as_numbers(joint.get("pos", ""))
            anchor = given if len(given) == _SPACE and np.isfinite(given).all() else _ORIGIN
            link = body.get("name", joint.get("name", ""))
            found.append(FileJoint(joint.get("name", ""), link, anchor, joint is own[-1]))
        waiting += reversed([part for part in body if part.tag in ("body", *_CONTAINERS)])
    return found


def _attribute(element: ET.Element | None, name: str) -> str:
    return "" if element is None else element.get(name, "")
