"""Where the bodies of a robot are, their inertias there, the corners of its sole.

All in the world frame, which is that of the stance sole, for many postures at once. Quantities of
the posture (`PostureQuantity`) are read off the placements; they are computed only if a constraint
asks for them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.mechanics.spatial import pseudo_inertia, skew, symmetric, world_inertias
from gaitopt.model.joint_tree import FIRST
from gaitopt.model.reroot import joint_axes
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array


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
        turned = np.stack([np.ones(angles.shape), np.sin(angles), np.cos(angles)], axis=2)
        local = (turned @ self._local).reshape(*angles.shape, 4, 4)
        world = np.empty((len(local) + 1, *local.shape[1:]))
        world[0] = np.eye(4)
        for j, carrier in enumerate(self._carriers):
            np.matmul(world[carrier], local[j], out=world[j + 1])
        return Placements(world)


def bodies_of(robot: Robot) -> ForwardKinematics:
    """Return the bodies of a robot."""
    return ForwardKinematics(robot.model)


class BodyInertias:
    """Mass, centre and inertia of the n bodies beyond the stance foot."""

    def __init__(self, model: pin.Model) -> None:
        self._bodies = ForwardKinematics(model)
        self._pseudo = pseudo_inertias(model)[1:]

    def in_world(self, q: Array) -> Array:
        """Return the world inertias at postures q (N, n) [rad], shape (N, n, 6, 6)."""
        return world_inertias(self._pseudo, self._bodies.placed(q).frames[1:])


def pseudo_inertias(model: pin.Model) -> Array:
    """Return `pseudo_inertia` of the stance foot and the n bodies, shape (n + 1, 4, 4)."""
    bodies = (model.inertias[j] for j in range(FIRST - 1, model.njoints))
    return np.stack([pseudo_inertia(b.mass, b.lever, b.inertia) for b in bodies])


def body_inertias(robot: Robot) -> BodyInertias:
    """Return the inertias of a robot's bodies."""
    return BodyInertias(robot.model)


class PostureQuantityDerivatives(ABC):
    """A quantity of the posture at N postures and its local derivatives.

    Attributes:
        value: the quantity, shape (N, entries).
        jacobian: with respect to q, shape (N, entries, n).
    """

    value: Array
    jacobian: Array

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
            placed: the bodies.
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
    count, points, _ = corners.shape
    of_twist = np.empty((count, points, 3, 6))  # of the body to velocity of the point
    of_twist[..., :3], of_twist[..., 3:] = np.eye(3), -skew(corners)
    jacobian = of_twist.reshape(count, -1, 6) @ axes.swapaxes(1, 2)
    return np.asarray(jacobian.reshape(count, points, 3, -1))


def corner_hessian(axes: Array, jacobian: Array, weights: Array) -> Array:
    """Return the Hessian of sum(weights * corners) with respect to q, shape (N, j, j).

    For j <= k on the way to the foot the second derivative is w_j x (d p / d q_k): turning joint j
    turns all that joint k moves.

    Args:
        axes: joint motion axes in the world, shape (N, j, 6).
        jacobian: of the corners, shape (N, 4, 3, j); zero for joints that do not move the foot.
        weights: shape (N, 4, 3).
    """
    # sum over corners of weight . (w_j x slope_k) = w_j . (slope_k x weight)
    count, _, _, joints = jacobian.shape
    against = -skew(weights).swapaxes(1, 2).reshape(count, 3, -1)
    turned = against @ jacobian.reshape(count, -1, joints)
    return symmetric(axes[:, :, 3:] @ turned)
