"""The paper's double support (section 4.2): joint angles by inverse kinematics from p_G."""

from __future__ import annotations

import numpy as np

from gaitopt.errors import UnreachableError
from gaitopt.gait.boundary import Boundary, Posture, PostureSlope
from gaitopt.gait.parameters import FOOT_SPACING, PELVIS_FORWARD, PELVIS_HEIGHT, STEP_LENGTH
from gaitopt.mechanics.legs import chain_curvature, closure_forces, closure_slope
from gaitopt.nlp import Array


class ClosedBoundary(Boundary):
    """The paper's form: q_start by inverse kinematics; B = 10."""

    def posture(self, geometry: Array, q_start: Array) -> Posture:
        """Return the posture for geometric quantities, shape (10,)."""
        del q_start
        (pelvis, pelvis_axes), (sole, sole_axes) = self.place(geometry)
        try:
            q_start = self.kinematics.solve(pelvis, sole)
        except UnreachableError as error:
            raise UnreachableError(
                f"{error} (pelvis height {geometry[PELVIS_HEIGHT]:.4f} m, "
                f"pelvis {geometry[PELVIS_FORWARD]:+.4f} m forward of the stance toes, "
                f"step length {geometry[STEP_LENGTH]:.4f} m, "
                f"foot spacing {geometry[FOOT_SPACING]:.4f} m)"
            ) from error
        return Posture(
            q_start, self.leg_vectors(pelvis, sole), pelvis, sole, pelvis_axes, sole_axes
        )

    def slope(self, posture: Posture) -> PostureSlope:
        """Return the derivatives of a posture."""
        axes = self.kinematics.axes(posture.q_start)
        slope = closure_slope(axes, *posture.twists)
        return PostureSlope(slope, self.leg_slopes(posture), axes, np.zeros((0, 6, 10)))

    def curvature(
        self,
        posture: Posture,
        slope: PostureSlope,
        q_weights: Array,
        leg_weights: Array,
        gap_weights: Array,
    ) -> Array:
        """Return the Hessian of q_weights . q_start + sum(leg_weights * legs), shape (10, 10).

        Along straight lines in the geometric quantities both sides of each closure accelerate:
        S q'' + (curvature of the leg) = (curvature of the displacement chain).
        """
        del gap_weights
        forces = closure_forces(slope.joint_axes, q_weights)
        own = chain_curvature(slope.joint_axes, forces[1])
        own[:6, :6] += chain_curvature(slope.joint_axes[:6], forces[0])
        H = self.target_curvature(posture, (forces[0], forces[1]), leg_weights)
        return np.asarray(H - slope.q_start.T @ own @ slope.q_start)
