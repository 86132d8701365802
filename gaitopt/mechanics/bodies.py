"""Spatial inertias of the moving bodies in the world, for many postures at once."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.mechanics.spatial import skew, world_inertias
from gaitopt.nlp import Array
from gaitopt.robot.reroot import joint_axis

_FIRST = 2  # joints 0 and 1 are the universe and the stance foot, which does not move


class BodyInertias:
    """Mass, centre and inertia of the twelve bodies beyond the stance foot."""

    def __init__(self, model: pin.Model) -> None:
        joints = range(_FIRST, model.njoints)
        bodies = [model.inertias[j] for j in joints]
        self._mass = np.array([b.mass for b in bodies])
        self._lever = np.stack([b.lever for b in bodies])
        self._inertia = np.stack([b.inertia for b in bodies])
        self._turn = np.stack([model.jointPlacements[j].rotation for j in joints])
        self._shift = np.stack([model.jointPlacements[j].translation for j in joints])
        self._axis = skew(np.stack([joint_axis(model, j) for j in joints]))

    def in_world(self, q: Array) -> Array:
        """Return the world inertias at postures q (N, 12), shape (N, 12, 6, 6)."""
        return world_inertias(self._mass, self._lever, self._inertia, *self._placements(q))

    def _placements(self, q: Array) -> tuple[Array, Array]:
        """Rotations (N, 12, 3, 3) and origins (N, 12, 3), joint after joint along the chain."""
        K = self._axis  # Rodrigues' formula for every joint at once
        turned = (
            np.eye(3) + np.sin(q)[..., None, None] * K + (1 - np.cos(q))[..., None, None] * K @ K
        )
        local = self._turn @ turned
        rotation, origin = np.empty_like(local), np.empty((*q.shape, 3))
        rotation[:, 0], origin[:, 0] = local[:, 0], self._shift[0]
        for j in range(1, q.shape[1]):
            rotation[:, j] = rotation[:, j - 1] @ local[:, j]
            origin[:, j] = origin[:, j - 1] + rotation[:, j - 1] @ self._shift[j]
        return rotation, origin
