"""Spatial inertias of the moving bodies in the world, for many postures at once."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.mechanics.spatial import world_inertias
from gaitopt.nlp import Array

Views = tuple[list[Array], list[Array]]
_FIRST = 2  # joints 0 and 1 are the universe and the stance foot, which does not move


class BodyInertias:
    """Mass, centre and inertia of the twelve bodies beyond the stance foot."""

    def __init__(self, model: pin.Model) -> None:
        bodies = [model.inertias[j] for j in range(_FIRST, model.njoints)]
        self._joints = range(_FIRST, model.njoints)
        self._mass = np.array([b.mass for b in bodies])
        self._lever = np.stack([b.lever for b in bodies])
        self._inertia = np.stack([b.inertia for b in bodies])

    def placement_views(self, data: pin.Data) -> Views:
        """Return live views of rotation and origin of every body in a Data."""
        placements = [data.oMi[j] for j in self._joints]
        return [p.rotation for p in placements], [p.translation for p in placements]

    def in_world(self, placements: list[Views]) -> Array:
        """Return the world inertias for a list of placement views, shape (N, 12, 6, 6)."""
        rotation = np.stack([np.stack(p[0]) for p in placements])
        origin = np.stack([np.stack(p[1]) for p in placements])
        return world_inertias(self._mass, self._lever, self._inertia, rotation, origin)
