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
        self._turn = np.stack([model.jointPlacements[j].rotation for j in joints])
        self._shift = np.stack([model.jointPlacements[j].translation for j in joints])
        self._axis = skew(np.stack([joint_axis(model, j) for j in joints]))

    def placed(self, q: Array) -> Placements:
        """Return the placements at postures q (N, 12), joint after joint along the chain."""
        K = self._axis  # Rodrigues' formula for every joint at once
        turned = (
            np.eye(3) + np.sin(q)[..., None, None] * K + (1 - np.cos(q))[..., None, None] * K @ K
        )
        local = self._turn @ turned
        count = q.shape[1]
        rotation, origin = np.empty((len(q), count + 1, 3, 3)), np.zeros((len(q), count + 1, 3))
        rotation[:, 0] = np.eye(3)
        for j in range(count):
            rotation[:, j + 1] = rotation[:, j] @ local[:, j]
            origin[:, j + 1] = origin[:, j] + rotation[:, j] @ self._shift[j]
        return Placements(rotation, origin)


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
