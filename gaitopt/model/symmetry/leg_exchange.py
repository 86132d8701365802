"""The leg exchange E of Eq. (26), found from the joint axes of the model, never typed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from gaitopt.model.legs.kinematic_tree import pose_model
from gaitopt.nlp import Array

REFLECTION = np.diag([1.0, -1.0, 1.0])  # left <-> right, in axes x forward, y left, z up


def joint_lines(model: pin.Model, pelvis: pin.SE3) -> tuple[Array, Array]:
    """Return a point on and the direction of all joint axes at the neutral posture.

    Args:
        model: re-rooted model (free-flyer and n joints).
        pelvis: placement of the pelvis in the world at the neutral posture.

    Returns:
        Points and unit axes in the pelvis frame, each of shape (n, 3).
    """
    posed = pose_model(model, pin.neutral(model))
    points = np.array([pelvis.actInv(p.translation) for p in posed.placements[2:]])
    return points, posed.axes[2:] @ pelvis.rotation


def leg_exchange(axes: Array, outward: Array, partners: Sequence[int] | None = None) -> Array:
    """Return E, shape (n, n): `E q` is the posture q reflected left to right, legs exchanged.

    The sign is that between the partner's axis and the mirrored one (a rotation vector mirrors to
    minus its reflection): a waist that yaws has -1, one that pitches +1.

    Args:
        axes: of the joints in the pelvis frame, stance leg from ankle to hip, then swing leg from
            hip to ankle, then others, shape (n, 3).
        outward: (n,) +1 where the joint turns its URDF child by +axis in the re-rooted model, -1
            where the chain runs against the URDF.
        partners: of each joint, the one that does the same on the other side;
            None for two legs alone: the joint of the other leg as many joints away from the hip.
    """
    n = len(axes)
    partners = range(n)[::-1] if partners is None else partners
    E = np.zeros((n, n))
    for i, partner in enumerate(partners):
        mirrored = -REFLECTION @ (outward[i] * axes[i])
        same = mirrored @ (outward[partner] * axes[partner]) >= 0.0
        E[i, partner] = 1.0 if same else -1.0
    return E


def mirror_placement(placement: pin.SE3) -> pin.SE3:
    """Return the mirror image of a placement in the plane y = 0."""
    S = REFLECTION
    return pin.SE3(S @ placement.rotation @ S, S @ placement.translation)


def exchange_error(model: pin.Model, E: Array, stance_sole: str, swing_sole: str) -> float:
    """Return the largest error of mirrored kinematics and inertia over a few postures.

    The swing sole seen from the stance sole at q must mirror to the stance sole seen from the
    swing sole at E q, E (n, n), and the kinetic energy of the mirrored motion must be the same.
    """
    data, numbers = model.createData(), np.arange(1.0, 2 * len(E) + 1).reshape(2, len(E))
    soles = model.getFrameId(stance_sole), model.getFrameId(swing_sole)
    worst = 0.0
    for posture in range(1, 4):  # as good as random ones, whose generator takes long to load
        angles, rates = np.array([[0.4], [1.0]]) * np.sin(posture * numbers)
        placement, energy = _seen_standing(model, data, angles, rates, soles)
        exchanged, other = _seen_standing(model, data, E @ angles, E @ rates, soles[::-1])
        gap = mirror_placement(placement).homogeneous - exchanged.homogeneous
        worst = max(worst, float(np.abs(gap).max()), abs(energy - other) / energy)
    return worst


def _seen_standing(
    model: pin.Model, data: pin.Data, angles: Array, rates: Array, soles: tuple[int, int]
) -> tuple[pin.SE3, float]:
    """Placement of the second sole in the first, and kinetic energy with the first one at rest."""
    q = np.concatenate([pin.neutral(model)[:7], angles])
    v = np.concatenate([np.zeros(6), rates])
    pin.computeJointJacobians(model, data, q)
    J = pin.computeFrameJacobian(model, data, q, soles[0], pin.LOCAL)
    v[:6] = -np.linalg.solve(J[:, :6], J[:, 6:] @ rates)
    pin.updateFramePlacements(model, data)
    # computeKineticEnergy leaves out the rotors of hinges about any axis but +x, +y and +z.
    energy = float(v @ pin.crba(model, data, q) @ v) / 2.0
    return data.oMf[soles[0]].actInv(data.oMf[soles[1]]), energy
