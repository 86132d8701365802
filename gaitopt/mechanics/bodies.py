"""Where the bodies of the chain are and their inertias there, for many postures at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.mechanics.spatial import skew, world_inertias
from gaitopt.nlp import Array
from gaitopt.robot.model import Robot
from gaitopt.robot.reroot import joint_axis

_FIRST = 2  # joints 0 and 1 are the universe and the stance foot, which does not move


@dataclass(frozen=True)
class Placements:
    """Frames of the thirteen bodies in the world at N postures, the stance foot first.

    Attributes:
        rotation: shape (N, 13, 3, 3).
        origin: shape (N, 13, 3) [m].
    """

    rotation: Array
    origin: Array


class Bodies:
    """The chain from the stance foot (body 0) by the pelvis (6) to the swing foot (12)."""

    def __init__(self, model: pin.Model) -> None:
        joints = range(_FIRST, model.njoints)
        placements = [model.jointPlacements[j] for j in joints]
        K = skew(np.stack([joint_axis(model, j) for j in joints]))
        # Rodrigues' formula: the frame of a joint in the one before it is fixed
        # + sin(q) by_sine + (1 - cos(q)) by_cosine, homogeneous matrices all three.
        self._fixed = np.stack([p.homogeneous for p in placements])
        self._by_sine, self._by_cosine = np.zeros((2, *self._fixed.shape))
        self._by_sine[:, :3, :3] = self._fixed[:, :3, :3] @ K
        self._by_cosine[:, :3, :3] = self._fixed[:, :3, :3] @ K @ K

    def placed(self, q: Array) -> Placements:
        """Return the placements at postures q (N, 12), joint after joint along the chain."""
        sine, cosine = np.sin(q)[..., None, None], np.cos(q)[..., None, None]
        local = self._fixed + sine * self._by_sine + (1.0 - cosine) * self._by_cosine
        count = q.shape[1]
        world = np.empty((len(q), count + 1, 4, 4))
        world[:, 0] = np.eye(4)
        for j in range(count):
            np.matmul(world[:, j], local[:, j], out=world[:, j + 1])
        return Placements(world[:, :, :3, :3], world[:, :, :3, 3])


class BodyInertias:
    """Mass, centre and inertia of the twelve bodies beyond the stance foot."""

    def __init__(self, model: pin.Model) -> None:
        bodies = [model.inertias[j] for j in range(_FIRST, model.njoints)]
        self._bodies = Bodies(model)
        self._mass = np.array([b.mass for b in bodies])
        self._lever = np.stack([b.lever for b in bodies])
        self._inertia = np.stack([b.inertia for b in bodies])

    def in_world(self, q: Array) -> Array:
        """Return the world inertias at postures q (N, 12), shape (N, 12, 6, 6)."""
        at = self._bodies.placed(q)
        return world_inertias(
            self._mass, self._lever, self._inertia, at.rotation[:, 1:], at.origin[:, 1:]
        )


def body_inertias(robot: Robot) -> BodyInertias:
    """Return the inertias of a robot's bodies."""
    return BodyInertias(robot.model)
