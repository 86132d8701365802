"""The lifted double support: joint angles are parameters, tied to p_G by equalities.

No trial point is out of reach, and the knee may pass through the straight leg on the way.
"""

from __future__ import annotations

import numpy as np

from gaitopt.errors import EvaluationError
from gaitopt.gait.boundary import PELVIS_DRIVE, SOLE_DRIVE, Boundary, Posture, PostureSlope
from gaitopt.mechanics.closure import loop_gap_curvature, loop_gap_slope
from gaitopt.nlp import Array


def _loop_drive(count: int, displacements: Array) -> Array:
    """Matrix from (q_start, geometric quantities) to a loop's coordinates, shape (m, 22)."""
    matrix = np.zeros((count + len(displacements), 22))
    matrix[np.arange(count), np.arange(count)[::-1]] = 1.0
    matrix[count:, 12:] = displacements
    return matrix


_LOOP_DRIVES = (_loop_drive(6, PELVIS_DRIVE), _loop_drive(12, SOLE_DRIVE))


class LiftedBoundary(Boundary):
    """q_start is a parameter; the gaps of both loops must vanish; B = 12 + 10."""

    def posture(self, geometry: Array, q_start: Array) -> Posture:
        """Return the posture at the joint angles given, and its gaps."""
        (pelvis, pelvis_axes), (sole, sole_axes) = self.place(geometry)
        pelvis_is, sole_is = self.kinematics.placements(q_start)
        loops = (pelvis_is.inverse() * pelvis, sole_is.inverse() * sole)
        for name, loop in zip(("pelvis", "swing foot"), loops, strict=True):
            if np.trace(loop.rotation) < 1.0:  # its sine, which the rows read, vanishes again
                raise EvaluationError(f"the {name} is turned by more than a right angle")
        legs = self.leg_vectors(pelvis, sole)
        return Posture(q_start, legs, pelvis, sole, pelvis_axes, sole_axes, loops)

    def slope(self, posture: Posture) -> PostureSlope:
        """Return the derivatives of a posture."""
        axes = self.kinematics.axes(posture.q_start)
        chains = self._loop_axes(posture, axes)
        gaps = [
            loop_gap_slope(loop, chain) @ drive
            for loop, chain, drive in zip(posture.loops, chains, _LOOP_DRIVES, strict=True)
        ]
        legs = np.concatenate([np.zeros((2, 3, 12)), self.leg_slopes(posture)], axis=2)
        return PostureSlope(np.eye(12, 22), legs, axes, np.stack(gaps), chains)

    def curvature(
        self,
        posture: Posture,
        slope: PostureSlope,
        q_weights: Array,
        leg_weights: Array,
        gap_weights: Array,
    ) -> Array:
        """Return the Hessian of sum(leg_weights * legs) + sum(gap_weights * gaps), (22, 22)."""
        del q_weights  # q_start is linear in the coordinates
        H = np.zeros((22, 22))
        H[12:, 12:] = self.target_curvature(posture, (np.zeros(6), np.zeros(6)), leg_weights)
        for loop, axes, drive, weight in zip(
            posture.loops, slope.loop_axes, _LOOP_DRIVES, gap_weights, strict=True
        ):
            H += drive.T @ loop_gap_curvature(loop, axes, weight) @ drive
        return H

    def _loop_axes(self, posture: Posture, axes: Array) -> tuple[Array, ...]:
        """Back through the joints to the stance sole, then out along the displacements."""
        targets = ((posture.pelvis, posture.pelvis_axes), (posture.sole, posture.sole_axes))
        chains = []
        for loop, count, (target, displacements) in zip(
            posture.loops, (6, 12), targets, strict=True
        ):
            world = np.concatenate([-axes[count - 1 :: -1], displacements])
            to_body = loop * target.inverse()  # world axes into the body the loop starts from
            chains.append(world @ to_body.action.T)
        return tuple(chains)
