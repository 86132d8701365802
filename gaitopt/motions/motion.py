"""A walk sampled at a fixed rate in a world whose z points up, its joints in a reader's order.

Frames: the world's z is against gravity, x along the walk, its origin that of the sole frame that
stands first; on level ground it is the world of `Trajectory`. Frames of bodies are those of the
robot's file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from gaitopt.bounds import INSTANTS_OF_MOTION, RATE, STRIDES, at_most
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.gait.result import Gait
from gaitopt.gait.trajectory import TrajectorySamples
from gaitopt.gait.transition import Transition
from gaitopt.mechanics.spatial import upright
from gaitopt.model.multibody import BASE, Multibody
from gaitopt.motions.orders import RobotOrder
from gaitopt.nlp import Array

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
        return _turned(self.base_rotation, self.samples.base_twist)

    @cached_property
    def base_acceleration(self) -> Array:
        """Time derivative of `base_velocity`, shape (T, 6)."""
        twist, change = self.samples.base_twist, self.samples.base_acceleration.copy()
        change[:, :3] += np.cross(twist[:, 3:], twist[:, :3])
        return _turned(self.base_rotation, change)

    @cached_property
    def foot_wrench(self) -> Array:
        """Force [N] and moment about the sole frames' origins [N·m] in the world, (T, 2, 6)."""
        turn, own = self.samples.sole[..., :3, :3], self.samples.wrench
        parts = [np.einsum("tfij,tfj->tfi", turn, own[..., k : k + 3]) for k in (0, 3)]
        return np.concatenate(parts, axis=-1)

    @cached_property
    def body_motion(self) -> BodyMotion:
        """Motion of the bodies, as named by `body_names`."""
        return _moving_bodies(self)

    @cached_property
    def step_phase(self) -> Array:
        """Time since the step began over its duration, from 0 to 1, shape (T,)."""
        return self.gait.trajectory.share(self.samples)


def motion(
    gait: Gait | Transition,
    rate: float,
    strides: float = 1.0,
    joints: str | Sequence[str] = "gait",
) -> Motion:
    """Return a gait, or a transition with what it leads from and to, sampled at a fixed rate.

    Where the swing foot lands, the sample is that after the impact. The end is left out, so that
    a motion of whole strides goes on with its own first sample.

    Args:
        gait: to sample.
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
    count = int(np.ceil(min(strides * trajectory.period * rate, 1e12)))
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


def _turned(rotation: Array, vectors: Array) -> Array:
    """Return pairs of vectors (T, 6) turned by rotations (T, 3, 3)."""
    pairs = np.einsum("tij,tkj->tki", rotation, vectors.reshape(-1, 2, 3))
    return np.asarray(pairs.reshape(-1, 6))


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
