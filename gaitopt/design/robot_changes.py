"""What numbers of a robot move in it: lengths, masses, centres of mass, inertias, rotors, soles.

A change keeps the robot its own mirror image: both legs change alike. Laws of lengths: a link that
gets longer is stretched along the length, about the joint above it, with its mass; all that hangs
on it moves along. Axes are those of the pelvis with all joints at zero.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field, replace
from functools import cached_property

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.design.summary import brace, shared_name
from gaitopt.gait.model_gradient import OfRobot
from gaitopt.mechanics.forward_kinematics import ForwardKinematics
from gaitopt.model.joint_tree import FIRST, joint_axes
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array

LENGTH, MASS, PLACE, INERTIA, JOINT = "length", "mass", "centre of mass", "inertia", "joint"
_X, _Y, _Z = np.eye(3)
_AXES = {"forward": _X, "outward": _Y, "up": _Z}
_LENGTH_STEP, _PLACE_STEP = 0.01, 0.01  # m
_TRUNK_STEP, _LINK_STEP = 1.0, 0.1  # kg
_INERTIA_SHARE = 0.1
_ROTOR_STEP, _DAMPING_STEP, _FRICTION_STEP = 1e-3, 0.1, 0.1
_ABOUT = {"forward": "roll", "outward": "pitch", "up": "yaw"}
_OF_JOINTS = (
    ("armature", "rotor inertia", "kg·m²", _ROTOR_STEP),
    ("damping", "damping", "N·m·s/rad", _DAMPING_STEP),
    ("friction", "friction", "N·m", _FRICTION_STEP),
)


@dataclass(frozen=True)
class RobotChange(OfRobot):
    """Derivatives of a robot in one number of it.

    Attributes:
        name: of the number, "shin".
        kind: LENGTH, MASS, PLACE, INERTIA or JOINT.
        unit: of the number.
        step: a change of it that a designer thinks in.
        sole: of the edges of the sole: toe, heel, left, right, shape (4,).
        reach, straight: of the same in `Legs`.
        weight: of the mass of the whole robot.
        group: names of the joints that it is a property of, for changes of kind JOINT.
    """

    name: str
    kind: str
    unit: str
    step: float
    sole: Array = field(default_factory=lambda: np.zeros(4))
    straight: Array = field(default_factory=lambda: np.zeros(2))
    reach: float = 0.0
    group: tuple[str, ...] = ()

    @property
    def weight(self) -> float:
        """Change of the mass of the whole robot."""
        return float(self.mass.sum())

    @property
    def corners(self) -> Array:
        """Of the corners of the swing sole, which its edges move, shape (4, 3)."""
        toe, heel, left, right = self.sole
        return np.array(
            [[toe, left, 0.0], [toe, right, 0.0], [heel, left, 0.0], [heel, right, 0.0]]
        )


class Anatomy:
    """A robot with all joints at zero, by its bodies; makes changes of it.

    Bodies count as those of `OfRobot`. In the stance leg the rooted chain runs against the
    file: there the body that a joint sits on is the one which hangs on it in the file.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        tree, model = robot.tree, robot.model
        n = tree.size
        placed = ForwardKinematics(model).placed(np.zeros((1, n)))
        self._rotation, self._origin = placed.rotation[0], placed.origin[0]
        self._carriers = [parent + 1 for parent in tree.parents]
        self._place = np.stack(
            [model.jointPlacements[j].translation for j in range(FIRST, model.njoints)]
        )
        frame = model.frames[robot.pelvis_frame]
        self._pelvis = self._rotation[tree.pelvis] @ frame.placement.rotation
        self._pelvis_origin = (
            self._origin[tree.pelvis] + self._rotation[tree.pelvis] @ frame.placement.translation
        )
        bodies = [model.inertias[j] for j in range(1, model.njoints)]
        self.mass = np.array([b.mass for b in bodies])
        self._first = np.stack([b.mass * b.lever for b in bodies])
        self._own = np.stack([0.5 * np.trace(b.inertia) * np.eye(3) - b.inertia for b in bodies])
        levers = np.stack([b.lever for b in bodies])
        self._second = self._own + self.mass[:, None, None] * (
            levers[:, :, None] * levers[:, None, :]
        )
        self._partner = np.abs(robot.coupling.mirror).argmax(axis=0)
        sign = np.where(np.arange(n) < tree.stance, -1.0, 1.0)
        turned = np.einsum("jab,jb->ja", self._rotation[1:], joint_axes(model))
        self._axes = sign[:, None] * turned  # as the file has them, in the world, shape (n, 3)

    def hanging(self, joint: int) -> int:
        """Return the body that hangs on a joint in the file."""
        return self._carriers[joint] if joint < self.robot.tree.stance else joint + 1

    def pairs(self) -> list[tuple[int, ...]]:
        """Return the joints with their partners of the other side, legs from hip to ankle first."""
        tree = self.robot.tree
        legs = range(tree.stance, tree.swing_foot)
        others = range(tree.swing_foot, tree.size)
        found: list[tuple[int, ...]] = [(j, int(self._partner[j])) for j in legs]
        found += [
            tuple(dict.fromkeys((j, int(self._partner[j]))))
            for j in others
            if j <= self._partner[j]
        ]
        return found

    def joint_name(self, pair: tuple[int, ...]) -> str:
        """Return what a pair of joints is called: "hip yaw"."""
        names = [self.robot.tree.names[j] for j in pair]
        if len(names) == 1:
            return names[0]
        return shared_name(names[0], names[1]) or brace(*sorted(names))

    def bodies(self) -> list[tuple[str, tuple[int, ...]]]:
        """Return the bodies with their partners and what they are called, the trunk first."""
        tree, knee = self.robot.tree, self.robot.legs.knees[1]
        found: list[tuple[str, tuple[int, ...]]] = [("trunk", (tree.pelvis,))]
        for pair in self.pairs():
            own = tuple(self.hanging(j) for j in pair)
            names = {knee - 1: "thigh", knee: "shin", tree.swing_foot - 1: "foot"}
            found.append((names.get(pair[0], f"{self.joint_name(pair)} link"), own))
        return found

    def nothing(self, name: str, kind: str, unit: str, step: float) -> RobotChange:
        """Return a change of nothing, to be filled."""
        bodies, n = len(self.mass), self.robot.tree.size
        return RobotChange(
            name=name, kind=kind, unit=unit, step=step,
            mass=np.zeros(bodies), first=np.zeros((bodies, 3)), second=np.zeros((bodies, 3, 3)),
            joints=np.zeros((n, 3)), swing_sole=np.zeros(3), pelvis=np.zeros(3),
            hips=np.zeros((2, 3)), ankles=np.zeros((2, 3)), armature=np.zeros(n),
            damping=np.zeros(n), friction=np.zeros(n),
        )  # fmt: skip

    def _local(self, body: int, vector: Array) -> Array:
        """Return a vector of the world in the axes of a body."""
        return np.asarray(self._rotation[body].T @ vector)

    def _shift(self, change: RobotChange, body: int, vector: Array) -> None:
        """Move the mass of a body by a vector of its own axes."""
        change.first[body] += self.mass[body] * vector
        outer = np.outer(self._first[body], vector)
        change.second[body] += outer + outer.T

    def _stretch(
        self, change: RobotChange, body: int, axis: Array, point: Array, rate: float
    ) -> None:
        """Move each bit of a body along an axis by rate times its distance from a point."""
        moved = self._first[body] - self.mass[body] * point
        change.first[body] += rate * (axis @ moved) * axis
        lever = self._second[body] @ axis - (axis @ point) * self._first[body]
        outer = np.outer(axis, lever)
        change.second[body] += rate * (outer + outer.T)

    def _displace(self, change: RobotChange, joint: int, vector: Array) -> None:
        """Move a joint in the link that it hangs on in the file, by a vector of the world."""
        tree = self.robot.tree
        if joint >= tree.stance:
            change.joints[joint] += self._local(self._carriers[joint], vector)
            return
        # seen from the joint, where the rooted body begins, the link moves the other way
        body = joint + 1
        back = -self._local(body, vector)
        self._shift(change, body, back)
        for child, carrier in enumerate(self._carriers):
            if carrier == body:
                change.joints[child] += back
        if body == tree.pelvis:
            change.pelvis[:] += back

    def _joint_point(self, joint: int) -> Array:
        """Origin of a joint in the world."""
        return np.asarray(self._origin[joint + 1])

    def _ankle(self, side: int) -> Array:
        """Centre of an ankle in the world: 0 of the stance leg, 1 of the swing leg."""
        legs, swing = self.robot.legs, self.robot.tree.swing_foot
        if side == 0:
            return np.asarray(legs.ankles[0])
        local = self.robot.model.frames[self.robot.swing_frame].placement.act(legs.ankles[1])
        return np.asarray(self._origin[swing] + self._rotation[swing] @ local)

    def _level_ways(self, side: int) -> list[Array]:
        """Ways from a knee to hip and ankle of its leg, level with its axis, in the world, (3,)."""
        knee = self.robot.legs.knees[side]
        u, at = self._axes[knee], self._joint_point(knee)
        hip = self._pelvis_origin + self._pelvis @ self.robot.legs.hips[side]
        return [v - (v @ u) * u for v in (hip - at, self._ankle(side) - at)]

    def segment(self, thigh: bool) -> RobotChange:
        """Return a longer thigh, the knee farther from the hip; or a longer shin."""
        change = self.nothing("thigh" if thigh else "shin", LENGTH, "m", _LENGTH_STEP)
        robot, reach = self.robot, 0.0
        for side, knee in enumerate(robot.legs.knees):
            u, (h, a) = self._axes[knee], self._level_ways(side)
            e = -h / np.linalg.norm(h) if thigh else a / np.linalg.norm(a)
            above, joint = (self._next(knee, -1), knee) if thigh else (knee, self._next(knee, 1))
            length = float(e @ (self._joint_point(joint) - self._joint_point(above)))
            link = self.hanging(above)
            point = self._local(link, self._joint_point(above) - self._origin[link])
            self._stretch(change, link, self._local(link, e), point, 1.0 / length)
            self._displace(change, joint, e)
            dh, da = (-e, np.zeros(3)) if thigh else (np.zeros(3), e)
            change.straight[side] = _turning(h, a, dh, da, u)
            size = float(np.linalg.norm(h) + np.linalg.norm(a))
            longer = dh @ h / np.linalg.norm(h) + da @ a / np.linalg.norm(a)
            reach = float(size * longer) / robot.legs.reach
        return replace(change, reach=reach)

    def measures(self) -> dict[str, float]:
        """Return lengths of the robot [m], and masses of the bodies of one side [kg]."""
        robot, (h, a) = self.robot, self._level_ways(1)
        found = {"thigh": float(np.linalg.norm(h)), "shin": float(np.linalg.norm(a)),
                 "hip width": abs(robot.legs.spacing), "foot length": robot.sole.length,
                 "ankle height": float(robot.legs.ankles[:, 2].mean())}  # fmt: skip
        return found | {f"{name} mass": float(self.mass[own[-1]]) for name, own in self.bodies()}

    def _next(self, joint: int, down: int) -> int:
        """Return the joint of the same leg below (1) or above (-1) another one in the file."""
        return joint - down if joint < self.robot.tree.stance else joint + down

    def hip_width(self) -> RobotChange:
        """Return hips farther apart, the trunk as it is."""
        change, tree = self.nothing("hip width", LENGTH, "m", _LENGTH_STEP), self.robot.tree
        for side, joint in enumerate((tree.stance - 1, tree.stance)):
            outward = self.robot.legs.side * (0.5 if side else -0.5) * _Y
            self._displace(change, joint, self._pelvis @ outward)
            change.hips[side] = outward
        return change

    def ankle_height(self) -> RobotChange:
        """Return ankles higher above the soles, the feet as they are."""
        change = self.nothing("ankle height", LENGTH, "m", _LENGTH_STEP)
        tree, up = self.robot.tree, self._sole_axes[:, 2]
        change.joints[0] = _Z
        self._shift(change, tree.swing_foot, -up)
        change.swing_sole[:] = -up
        change.ankles[:, 2] = 1.0
        return change

    @property
    def _sole_axes(self) -> Array:
        """Axes of the swing sole in those of its body, columns."""
        return np.asarray(self.robot.model.frames[self.robot.swing_frame].placement.rotation)

    def foot(self, axis: int) -> RobotChange:
        """Return longer (axis 0) or wider (1) feet, stretched about the ankle with their soles."""
        name = ("foot length", "foot width")[axis]
        change = self.nothing(name, LENGTH, "m", _LENGTH_STEP)
        sole, tree = self.robot.sole, self.robot.tree
        ankle = self._place[0]
        edges = np.array([sole.toe, sole.heel, sole.left, sole.right])
        own = slice(2 * axis, 2 * axis + 2)
        size = float(edges[own][0] - edges[own][1])
        change.sole[own] = (edges[own] - ankle[axis]) / size
        self._stretch(change, 0, np.eye(3)[axis], ankle, 1.0 / size)
        along = self._sole_axes[:, axis]
        self._stretch(change, tree.swing_foot, along, np.zeros(3), 1.0 / size)
        return change

    def sole_forward(self) -> RobotChange:
        """Return soles farther ahead under the same feet."""
        change = self.nothing("sole forward", LENGTH, "m", _LENGTH_STEP)
        change.sole[:2] = 1.0
        return change

    @cached_property
    def changes(self) -> tuple[RobotChange, ...]:
        """All numbers of the robot: they are the same for all of its walks."""
        return (*self.lengths(), self.load(), *self.masses(), *self.joint_properties())

    def lengths(self) -> Iterator[RobotChange]:
        """Yield the lengths of the robot."""
        yield self.segment(thigh=True)
        yield self.segment(thigh=False)
        yield self.hip_width()
        yield self.ankle_height()
        yield self.foot(0)
        yield self.foot(1)
        yield self.sole_forward()

    def masses(self) -> Iterator[RobotChange]:
        """Yield the mass, the place of the centre and the inertias of each body."""
        for name, pair in self.bodies():
            step = _TRUNK_STEP if len(pair) == 1 else _LINK_STEP
            heavier = self.nothing(f"{name} mass", MASS, "kg", step)
            for body in pair:
                heavier.mass[body] = 1.0
                heavier.first[body] = self._first[body] / self.mass[body]
                heavier.second[body] = self._second[body] / self.mass[body]
            yield heavier
            for axis, vector in _AXES.items():
                moved = self.nothing(f"{name} centre {axis}", PLACE, "m", _PLACE_STEP)
                turned = self.nothing(f"{name} inertia, {_ABOUT[axis]}", INERTIA, "kg·m²", 0.0)
                for body in pair:
                    outward = np.array([1.0, self._side(body), 1.0])
                    local = self._local(body, self._pelvis @ (vector * outward))
                    self._shift(moved, body, local)
                    turned.second[body] = 0.5 * np.eye(3) - np.outer(local, local)
                    own = float(np.trace(self._own[body]) - local @ self._own[body] @ local)
                if len(pair) > 1 or axis != "outward":  # else no longer its own mirror image
                    yield moved
                yield replace(turned, step=_INERTIA_SHARE * own)

    def _side(self, body: int) -> float:
        """+1 for a body whose centre of mass is left of the middle, else -1."""
        place = self._origin[body] + self._rotation[body] @ self._first[body] / self.mass[body]
        return 1.0 if (place - self._pelvis_origin) @ self._pelvis[:, 1] > 0.0 else -1.0

    def load(self) -> RobotChange:
        """Return a further load, a point at the centre of mass of the trunk."""
        change, body = self.nothing("load on the trunk", MASS, "kg", 1.0), self.robot.tree.pelvis
        centre = self._first[body] / self.mass[body]
        change.mass[body], change.first[body] = 1.0, centre
        change.second[body] = np.outer(centre, centre)
        return change

    def joint_properties(self) -> Iterator[RobotChange]:
        """Yield rotor inertia, viscous damping and Coulomb friction of each pair of joints."""
        for pair in self.pairs():
            name, group = self.joint_name(pair), tuple(self.robot.tree.names[j] for j in pair)
            for what, words, unit, step in _OF_JOINTS:
                change = self.nothing(f"{name} {words}", JOINT, unit, step)
                getattr(change, what)[list(pair)] = 1.0
                yield replace(change, group=group)


def _turning(h: Array, a: Array, dh: Array, da: Array, axis: Array) -> float:
    """How fast the straight angle of a knee turns as hip h and ankle a move, seen from the knee.

    The squared distance of both is c0 + c1 cos q + c2 sin q, and straight the angle of (c1, c2).
    """
    c = np.array([-2.0 * h @ a, -2.0 * h @ np.cross(axis, a)])
    by_hip = np.array([dh @ a, dh @ np.cross(axis, a)])
    by_ankle = np.array([h @ da, h @ np.cross(axis, da)])
    moved = -2.0 * (by_hip + by_ankle)
    return float(c[0] * moved[1] - c[1] * moved[0]) / float(c @ c)
