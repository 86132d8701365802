"""Where the bodies of a robot are, their inertias there, the corners of its sole.

All in the world frame, which is that of the stance sole, for many postures at once. Quantities of
the posture (`PostureQuantity`) are read off the placements; they are computed only if a constraint
asks for them.

One is the attitude of the trunk: roll, pitch and yaw of the pelvis frame against the vertical. On
level ground that is in the stance sole frame; on a slope the vertical is not its z axis. They are
Tait-Bryan angles in the order of the double support's geometric quantities: yaw about the vertical,
then pitch about the turned y axis, then roll about the trunk's own x axis. With the world angular
velocity w of the pelvis

    roll'  = (cos yaw w_x + sin yaw w_y) / cos pitch
    pitch' = -sin yaw w_x + cos yaw w_y
    yaw'   = w_z + tan pitch (cos yaw w_x + sin yaw w_y)

(Siciliano et al., Robotics, 2009, section 3.6, solved for the rates).
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.mechanics import compiled
from gaitopt.mechanics.spatial import pseudo_inertia, skew, symmetric, upright
from gaitopt.model.joint_tree import FIRST, joint_axes
from gaitopt.model.robot import Robot, cached_workspace
from gaitopt.model.sole import LEVEL
from gaitopt.nlp import Array, Indices


@dataclass(frozen=True)
class Placements:
    """Frames of the n + 1 bodies in the world at N postures, the stance foot first.

    Attributes:
        frames: homogeneous matrices of body after body, shape (n + 1, N, 4, 4).
    """

    frames: Array

    @property
    def rotation(self) -> Array:
        """Axes of the bodies, shape (N, n + 1, 3, 3)."""
        return self.frames[:, :, :3, :3].swapaxes(0, 1)

    @property
    def origin(self) -> Array:
        """Their origins, shape (N, n + 1, 3) [m]."""
        return self.frames[:, :, :3, 3].swapaxes(0, 1)


class ForwardKinematics:
    """The bodies of a model rooted at the stance foot: body 0, then one for each joint."""

    def __init__(self, model: pin.Model) -> None:
        joints = range(FIRST, model.njoints)
        placements = [model.jointPlacements[j] for j in joints]
        K = skew(joint_axes(model))
        # Rodrigues' formula: the frame of a joint in the one before it is
        # (1, sin(q), cos(q)) . local, homogeneous matrices all three; shape (n, 3, 16).
        fixed = np.stack([p.homogeneous for p in placements])
        by_sine, by_cosine = np.zeros((2, *fixed.shape))
        by_sine[:, :3, :3] = fixed[:, :3, :3] @ K
        by_cosine[:, :3, :3] = -fixed[:, :3, :3] @ K @ K
        self._local = np.stack([fixed - by_cosine, by_sine, by_cosine], axis=1).reshape(-1, 3, 16)
        self._carriers = [int(model.parents[j]) - 1 for j in joints]

    def placed(self, q: Array) -> Placements:
        """Return the placements at postures q (N, n) [rad], joint after joint outwards."""
        angles = q.T
        turned = np.ones((*angles.shape, 3))
        np.sin(angles, out=turned[..., 1])
        np.cos(angles, out=turned[..., 2])
        local = (turned @ self._local).reshape(*angles.shape, 4, 4)
        world = np.empty((len(local) + 1, *local.shape[1:]))
        world[0] = np.eye(4)
        for j, carrier in enumerate(self._carriers):
            np.matmul(world[carrier], local[j], out=world[j + 1])
        return Placements(world)


def placed_bodies(robot: Robot, q: Array) -> Placements:
    """Return the placements of a robot's bodies at postures q of all joints (N, n) [rad]."""
    if compiled.in_use():
        return Placements(compiled.bodies_of(robot).placed(q))
    return cached_workspace(robot, _bodies).placed(q)


def _bodies(robot: Robot) -> ForwardKinematics:
    return ForwardKinematics(robot.model)


def pseudo_inertias(model: pin.Model) -> Array:
    """Return `pseudo_inertia` of the stance foot and the n bodies, shape (n + 1, 4, 4)."""
    bodies = (model.inertias[j] for j in range(FIRST - 1, model.njoints))
    return np.stack([pseudo_inertia(b.mass, b.lever, b.inertia) for b in bodies])


class PostureQuantityDerivatives(ABC):
    """A quantity of the posture at N postures and its local derivatives.

    Attributes:
        value: the quantity, shape (N, entries).
        jacobian: with respect to q, shape (N, entries, n).
    """

    value: Array
    jacobian: Array

    def rows(self, instants: Indices, entries: Indices) -> Array:
        """Return the derivatives of some entries (k,) at instants (k,), shape (k, n)."""
        return self.jacobian[instants, entries]

    def along(self, step: Array) -> Array:
        """Return the entries' changes, to first order, along one of q (N, n), (N, entries)."""
        return np.asarray((self.jacobian @ step[:, :, None])[:, :, 0])

    def most(self, changes: Array) -> Array:
        """Return a bound of the entries' changes, to first order, shape (N, entries).

        Args:
            changes: the most that each joint moves by, shape (N, n).
        """
        return np.asarray((np.abs(self.jacobian) @ changes[:, :, None])[:, :, 0])

    def vjp(self, weights: Array) -> Array:
        """Return the gradient in q of sum(weights * value), weights (N, entries), shape (N, n)."""
        return np.asarray((weights[:, None] @ self.jacobian)[:, 0])

    @abstractmethod
    def hessian(self, weights: Array) -> Array:
        """Return the Hessian in q of sum(weights * value), weights (N, entries), (N, n, n)."""


class PostureQuantity(ABC):
    """A quantity of the posture at each instant."""

    @abstractmethod
    def value(self, placed: Placements) -> Array:
        """Return it, shape (N, entries)."""

    @abstractmethod
    def derivatives(self, placed: Placements, axes: Array) -> PostureQuantityDerivatives:
        """Return it with its derivatives.

        Args:
            axes: joint motion axes in the world, shape (N, n, 6).
        """


def corner_positions(rotation: Array, origin: Array, corners: Array) -> Array:
    """Return corners (4, 3) of a body frame in the world, shape (N, 4, 3) [m].

    Args:
        rotation, origin: placement of the body, shapes (N, 3, 3) and (N, 3).
        corners: in the body frame [m].
    """
    return corners @ rotation.swapaxes(1, 2) + origin[:, None, :]


def corner_jacobian(axes: Array, corners: Array) -> Array:
    """Return d corner / d q, shape (N, 4, 3, j).

    A joint with world axis (l, w) moves the point p by l + w x p.

    Args:
        axes: joint motion axes in the world, shape (N, j, 6).
        corners: positions in the world [m], shape (N, 4, 3).
    """
    turned = skew(-corners).reshape(len(corners), -1, 3) @ axes[:, :, 3:].swapaxes(1, 2)
    jacobian = turned.reshape(*corners.shape, -1)
    jacobian += axes[:, None, :, :3].swapaxes(2, 3)
    return np.asarray(jacobian)


def corner_hessian(axes: Array, jacobian: Array, weights: Array) -> Array:
    """Return the Hessian of sum(weights * corners) with respect to q, shape (N, j, j).

    For j <= k on the way to the foot the second derivative is w_j x (d p / d q_k): turning joint j
    turns all that joint k moves.

    Args:
        axes: joint motion axes in the world, shape (N, j, 6).
        jacobian: of the corners, shape (N, 4, 3, j); zero for joints that do not move the foot.
        weights: shape (N, 4, 3).
    """
    if compiled.in_use():
        return compiled.kernels.corner_hessian(axes, jacobian, weights)
    # sum over corners of weight . (w_j x slope_k) = w_j . (slope_k x weight)
    count, _, _, joints = jacobian.shape
    against = -skew(weights).swapaxes(1, 2).reshape(count, 3, -1)
    turned = against @ jacobian.reshape(count, -1, joints)
    return symmetric(axes[:, :, 3:] @ turned)


ROLL, PITCH, YAW = range(3)
_LEAST_COSINE = 1e-9  # of the pitch: roll and yaw are one and the same where it is 90 degrees


@dataclass(frozen=True)
class TrunkDerivatives(PostureQuantityDerivatives):
    """Derivatives of roll, pitch and yaw.

    Attributes:
        value: the angles [rad], shape (N, 3).
        jacobian: with respect to q, shape (N, 3, n).
        rate_jacobian: how the rates (roll', pitch', yaw') change with pitch and with yaw at a given
            velocity of each joint, shape (N, 2, 3, n).
    """

    value: Array
    jacobian: Array
    rate_jacobian: Array

    def hessian(self, weights: Array) -> Array:
        """Return the Hessian in q of sum(weights * angles), weights (N, 3), shape (N, n, n).

        Between the stance foot and the pelvis, turning joint k leaves the axes of the joints
        j <= k where they are, so there only pitch and yaw change the rates.
        """
        weighted = (weights[:, None, None, :] @ self.rate_jacobian)[:, :, 0]
        return symmetric(weighted.swapaxes(1, 2) @ self.jacobian[:, PITCH:])


class Trunk(PostureQuantity):
    """Roll, pitch and yaw of a robot's pelvis frame [rad]."""

    def __init__(self, robot: Robot) -> None:
        frame = robot.model.frames[robot.pelvis_frame]
        self._body = robot.tree.pelvis
        self._below = robot.tree.path(self._body)
        self._turn = np.array(frame.placement.rotation)
        self._upright = None if robot.down == LEVEL else upright(np.array(robot.down))

    def value(self, placed: Placements) -> Array:
        """Return roll, pitch, yaw [rad], shape (N, 3)."""
        R = placed.rotation[:, self._body] @ self._turn
        if self._upright is not None:
            R = self._upright @ R
        roll = np.arctan2(R[:, 2, 1], R[:, 2, 2])
        pitch = np.arcsin(np.clip(-R[:, 2, 0], -1.0, 1.0))
        yaw = np.arctan2(R[:, 1, 0], R[:, 0, 0])
        return np.stack([roll, pitch, yaw], axis=1)

    def derivatives(self, placed: Placements, axes: Array) -> TrunkDerivatives:
        value = self.value(placed)
        _, pitch, yaw = value.T
        w = np.where(self._below, axes[:, :, 3:].swapaxes(1, 2), 0.0)
        if self._upright is not None:
            w = self._upright @ w
        c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
        ahead, aside = c * w[:, 0] + s * w[:, 1], c * w[:, 1] - s * w[:, 0]  # turned with the yaw
        cosine = np.maximum(np.cos(pitch), _LEAST_COSINE)[:, None]
        sine, zero = np.sin(pitch)[:, None], np.zeros_like(aside)
        rates = np.stack([ahead / cosine, aside, w[:, 2] + sine / cosine * ahead], axis=1)
        by_pitch = np.stack([sine / cosine**2 * ahead, zero, ahead / cosine**2], axis=1)
        by_yaw = np.stack([aside / cosine, -ahead, sine / cosine * aside], axis=1)
        return TrunkDerivatives(value, rates, np.stack([by_pitch, by_yaw], axis=1))


def slope_rates(angles: Array) -> Array:
    """Return how roll, pitch and yaw change per radian of slope of the ground, shape (N, 3).

    On ground that rises ahead the trunk, fixed to it, leans back: it turns about -y.

    Args:
        angles: roll, pitch and yaw [rad], shape (N, 3).
    """
    _, pitch, yaw = angles.T
    ahead = -np.sin(yaw)
    return np.stack([ahead / np.cos(pitch), -np.cos(yaw), np.tan(pitch) * ahead], axis=1)
