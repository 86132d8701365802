"""A walk sampled at a fixed rate in a world whose z points up, its joints in a reader's order.

Frames: the world's z is against gravity, x along the walk, its origin that of the sole frame that
stands first; on level ground it is the world of `Trajectory`. Frames of bodies are those of the
robot's file.

Orders of joints: that of the gait file, MuJoCo's, Isaac's, Unitree's for the G1, or one's own.

A motion whose columns are in another order than its reader's moves the wrong joints without a word.
Orders of engines follow from the robot's file, URDF or MJCF, whose text a gait file holds.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import deque
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import cached_property, partial

import numpy as np
from scipy.spatial.transform import Rotation

from gaitopt.bounds import INSTANTS_OF_MOTION, RATE, STRIDES, at_most
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, RobotError, did_you_mean
from gaitopt.gait.result import Gait
from gaitopt.gait.trajectory import TrajectorySamples
from gaitopt.gait.transition import Transition
from gaitopt.importers.report import listed
from gaitopt.importers.xml_document import as_numbers, parse_xml
from gaitopt.mechanics.spatial import turned, upright
from gaitopt.model.multibody import BASE, Multibody
from gaitopt.nlp import Array
from gaitopt.settings import checked_arguments

ORDERS = ("gait", "mujoco", "isaac", "g1", "mjcf")
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

    def rows(self, order: str | Collection[str]) -> tuple[int, ...]:
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
                f"{whose} {_listed(unknown)}, which '{self.body.name}' has not; "
                f"{did_you_mean(unknown[0], known)}its joints are {', '.join(known)}"
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

    def _names(self, order: str | Collection[str]) -> list[str]:
        if not isinstance(order, str):
            return [str(name) for name in order]
        known: dict[str, Callable[[], Sequence[str]]] = {
            "gait": lambda: self.body.joint_names,
            "mujoco": self._depth_first,
            "isaac": self._breadth_first,
            "g1": lambda: G1_JOINTS,
            "mjcf": lambda: [self.body.joint_names[row] for row in np.sort(self.body.driven)],
        }
        if order in known:
            return list(known[order]())
        if "," not in order and order not in self.body.joint_names:
            raise InputError(
                f"no order of joints is named '{order}'; {did_you_mean(order, ORDERS)}choose "
                f"{', '.join(ORDERS)}, or give the names of the joints, joined by commas"
            )
        return [name.strip() for name in order.split(",") if name.strip()]

    def _depth_first(self) -> list[str]:
        """Return the joints as MuJoCo numbers them: depth first, brothers as in the file."""
        names = [joint.name for joint in self._file if joint.name in self.body.joint_names]
        if lost := [name for name in self.body.joint_names if name not in names]:
            raise InputError(
                f"the robot's file does not tell where {_listed(lost)} stands in the order of an "
                "engine; give the names of the joints, joined by commas"
            )
        return names

    def _breadth_first(self) -> list[str]:
        """Return the joints as Isaac numbers them: level by level."""
        # Its importer of URDF files sorts joints by name; that of MJCF keeps the order of the file.
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


SCALAR_FIRST = [3, 0, 1, 2]
"""Columns of a quaternion x y z w that make it w x y z."""


@dataclass(frozen=True, eq=False)
class BodyMotion:
    """Motion of B bodies in the world.

    Attributes:
        position: of the origins of their frames [m], shape (T, B, 3).
        quaternion: orientation x y z w, without jumps of sign, shape (T, B, 4).
        linear: velocity of those origins [m/s], shape (T, B, 3).
        angular: velocity [rad/s], shape (T, B, 3).
    """

    position: Array
    quaternion: Array
    linear: Array
    angular: Array


@dataclass(frozen=True, eq=False)
class Motion:
    """Samples of a walk at a fixed rate.

    Attributes:
        gait: that walks, or the transition.
        rate: samples a second [Hz].
        samples: T of them in the world of this module; joints as in `joint_names`.
        rows: the n joints of the motion among those of the robot.
        bodies: the B bodies of the motion among those of the robot, the base first.
        joint_names: n names.
        body_names: B names of links.
        anchors: places of the bodies' joints in the frames of the file [m], shape (B, 3).
        whole: angles and rates of all joints of the robot, shape (2, T, M).
    """

    gait: Gait | Transition
    rate: float
    samples: TrajectorySamples
    rows: tuple[int, ...]
    bodies: tuple[int, ...]
    joint_names: tuple[str, ...]
    body_names: tuple[str, ...]
    anchors: Array
    whole: Array

    @property
    def body(self) -> Multibody:
        """The robot."""
        return self.gait.trajectory.body

    @property
    def foot_names(self) -> tuple[str, str]:
        """Names of the sole frames, in the order of contacts and wrenches."""
        return self.body.sole_names

    @cached_property
    def base_rotation(self) -> Array:
        """Rotation of the base in the world, shape (T, 3, 3)."""
        return np.asarray(Rotation.from_quat(self.samples.base_quaternion).as_matrix())

    @cached_property
    def base_velocity(self) -> Array:
        """Linear [m/s] and angular velocity [rad/s] of the base in the world, shape (T, 6)."""
        return turned(self.base_rotation, self.samples.base_twist)

    @cached_property
    def base_acceleration(self) -> Array:
        """Time derivative of `base_velocity`, shape (T, 6)."""
        twist, change = self.samples.base_twist, self.samples.base_acceleration.copy()
        change[:, :3] += np.cross(twist[:, 3:], twist[:, :3])
        return turned(self.base_rotation, change)

    @cached_property
    def foot_wrench(self) -> Array:
        """Force [N] and moment about the sole frames' origins [N·m] in the world, (T, 2, 6)."""
        return turned(self.samples.sole[..., :3, :3], self.samples.wrench)

    @cached_property
    def body_motion(self) -> BodyMotion:
        """Motion of the bodies, as named by `body_names`."""
        return _moving_bodies(self)

    @cached_property
    def step_phase(self) -> Array:
        """Time since the step began over its duration, from 0 to 1, shape (T,)."""
        return self.gait.trajectory.share(self.samples)


@checked_arguments
def motion(
    gait: Gait | Transition,
    rate: float,
    strides: float = 1.0,
    joints: str | Collection[str] = "gait",
) -> Motion:
    """Return a gait, or a transition with what it leads from and to, sampled at a fixed rate.

    Where the swing foot lands, the sample is that after the impact. The end is left out, so that
    a motion of whole strides goes on with its own first sample.

    Args:
        rate: samples a second [Hz].
        strides: number of strides of two steps; halves are steps. A transition is one.
        joints: order of the joints; see `RobotOrder.rows`.

    Raises:
        InputError: the rate, the number of strides, the instants that they make or the order of
            joints cannot be had.
        RobotError: the gait holds no robot, and its URDF is not one.
    """
    for value, most, what in ((rate, RATE, "Hz"), (strides, STRIDES, "strides")):
        if not 0.0 < value <= most:  # NaN is none of these
            raise InputError(f"a motion has {value:g} {what}; give a number above 0, to {most:g}")
    trajectory = gait.trajectory
    duration = strides * trajectory.period
    count = int(np.ceil(min(duration * rate, 1e12)))
    if count < 2:
        raise InputError(
            f"a motion of {duration:.3g} s at {rate:g} Hz has one instant; give "
            f"{2.0 / duration:.3g} Hz or more, or more strides"
        )
    at_most(count, INSTANTS_OF_MOTION, "instants of a motion", "export fewer strides at once")
    body = trajectory.body
    order = RobotOrder(body, gait.urdf)
    rows = order.rows(joints)
    bodies = order.bodies(rows)
    samples = _upright(trajectory.at(trajectory.times(rate, strides)), body.gravity)
    whole = np.stack([samples.q, samples.dq])
    picked = {name: getattr(samples, name)[:, rows] for name in ("q", "dq", "ddq", "torque")}
    return Motion(
        gait=gait,
        rate=rate,
        samples=replace(samples, **picked),
        rows=rows,
        bodies=bodies,
        joint_names=tuple(body.joint_names[row] for row in rows),
        body_names=order.link_names(bodies),
        anchors=order.anchors(bodies),
        whole=whole,
    )


def _upright(samples: TrajectorySamples, gravity: Array) -> TrajectorySamples:
    """Return samples in the world whose z is against gravity, quaternions without jumps of sign."""
    R = upright(gravity)
    turn = np.eye(4)
    turn[:3, :3] = R
    quaternion = (Rotation.from_matrix(R) * Rotation.from_quat(samples.base_quaternion)).as_quat()
    return replace(
        samples,
        base_position=samples.base_position @ R.T,
        base_quaternion=_continuous(quaternion),
        sole=turn @ samples.sole,
    )


def _continuous(quaternion: Array) -> Array:
    """Return quaternions x y z w (T, ..., 4) that change sign nowhere; the first has w >= 0."""
    inner = np.einsum("t...i,t...i->t...", quaternion[1:], quaternion[:-1])
    first = np.where(quaternion[:1, ..., 3] < 0.0, -1.0, 1.0)
    signs = np.cumprod(np.concatenate([first, np.where(inner < 0.0, -1.0, 1.0)]), axis=0)
    return np.asarray(quaternion * signs[..., None])


def _moving_bodies(motion: Motion) -> BodyMotion:
    """Return the motion of the bodies, outward from the base, all instants at once."""
    body, samples = motion.body, motion.samples
    q, dq = motion.whole
    turns, rotations = [Rotation.from_quat(samples.base_quaternion)], [motion.base_rotation]
    places = [samples.base_position]
    linear, angular = [motion.base_velocity[:, :3]], [motion.base_velocity[:, 3:]]
    for row, parent in enumerate(body.parent):
        own = 0 if parent == BASE else int(parent) + 1
        turn, along = Rotation.from_matrix(body.placement[row, :3, :3]), body.axis[row]
        if body.revolute[row]:
            turn = turn * Rotation.from_rotvec(q[:, row, None] * along)
        turns.append(turns[own] * turn)
        rotations.append(turns[-1].as_matrix())
        arm, axis = rotations[own] @ body.placement[row, :3, 3], rotations[-1] @ along
        spin, slide = axis * dq[:, row, None], 0.0 * axis
        if not body.revolute[row]:
            arm, spin, slide = arm + axis * q[:, row, None], slide, spin
        places.append(places[own] + arm)
        linear.append(linear[own] + np.cross(angular[own], arm) + slide)
        angular.append(angular[own] + spin)
    shape = (len(q), len(motion.bodies))
    position, velocity, rate = np.empty((*shape, 3)), np.empty((*shape, 3)), np.empty((*shape, 3))
    quaternion = np.empty((*shape, 4))
    for column, (index, anchor) in enumerate(zip(motion.bodies, motion.anchors, strict=True)):
        shift = rotations[index] @ -anchor  # from the joint to the body's own frame
        position[:, column] = places[index] + shift
        velocity[:, column] = linear[index] + np.cross(angular[index], shift)
        rate[:, column] = angular[index]
        quaternion[:, column] = turns[index].as_quat()
    return BodyMotion(position, _continuous(quaternion), velocity, rate)
