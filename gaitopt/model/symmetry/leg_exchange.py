"""The leg exchange E of Eq. (26), found from the joint axes of the model, never typed."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.model.legs.kinematic_tree import joint_axes, place
from gaitopt.nlp import Array

REFLECTION = np.diag([1.0, -1.0, 1.0])  # left <-> right, in axes x forward, y left, z up


def joint_lines(model: pin.Model, pelvis: pin.SE3) -> tuple[Array, Array]:
    """Return a point on and the direction of the twelve joint axes at the neutral posture.

    Args:
        model: re-rooted model (free-flyer and twelve joints).
        pelvis: placement of the pelvis in the world at the neutral posture.

    Returns:
        Points and unit axes in the pelvis frame, each of shape (12, 3).
    """
    placed = place(model, pin.neutral(model))
    points = np.array([pelvis.actInv(p.translation) for p in placed.places[2:14]])
    return points, joint_axes(model, placed.q, range(2, 14)) @ pelvis.rotation


def leg_exchange(axes: Array, outward: Array) -> Array:
    """Return E, shape (12, 12): `E q` is the posture q with the legs exchanged by reflection.

    A joint's partner is the joint of the other leg as many joints away from the hip: where several
    axes meet or are parallel, the mirror image of its line alone would not tell. The sign is that
    between the partner's axis and the mirrored one (a rotation vector mirrors to minus its
    reflection).

    Args:
        axes: of the joints in the pelvis frame, stance leg from ankle to hip, then swing leg from
            hip to ankle, shape (12, 3).
        outward: (12,) +1 where the joint turns its URDF child by +axis in the re-rooted model, -1
            where the chain runs against the URDF.
    """
    E = np.zeros((12, 12))
    for i in range(6):
        partner = 11 - i
        mirrored = -REFLECTION @ (outward[i] * axes[i])
        same = mirrored @ (outward[partner] * axes[partner]) >= 0.0
        E[i, partner] = E[partner, i] = 1.0 if same else -1.0
    return E


def mirror_placement(placement: pin.SE3) -> pin.SE3:
    """Return the mirror image of a placement in the plane y = 0."""
    S = REFLECTION
    return pin.SE3(S @ placement.rotation @ S, S @ placement.translation)


def exchange_error(model: pin.Model, E: Array, stance_sole: str, swing_sole: str) -> float:
    """Return the largest error of mirrored kinematics and inertia over a few postures.

    The swing sole seen from the stance sole at q must mirror to the stance sole seen from the
    swing sole at E q, and the kinetic energy of the mirrored motion must be the same.
    """
    data = model.createData()
    worst = 0.0
    for angles, rates in _probe_motions():
        placement, energy = _swing_placement(model, data, angles, rates, stance_sole, swing_sole)
        exchanged, other = _swing_placement(
            model, data, E @ angles, E @ rates, stance_sole, swing_sole, about_swing=True
        )
        gap = mirror_placement(placement).homogeneous - exchanged.homogeneous
        worst = max(worst, float(np.abs(gap).max()), abs(energy - other) / energy)
    return worst


def _probe_motions() -> list[tuple[Array, Array]]:
    rng = np.random.default_rng(0)
    return [(rng.uniform(-0.4, 0.4, 12), rng.uniform(-1.0, 1.0, 12)) for _ in range(3)]


def _swing_placement(
    model: pin.Model,
    data: pin.Data,
    angles: Array,
    rates: Array,
    stance_sole: str,
    swing_sole: str,
    *,
    about_swing: bool = False,
) -> tuple[pin.SE3, float]:
    """Placement of one sole in the other and the kinetic energy with that other sole at rest."""
    q = np.concatenate([pin.neutral(model)[:7], angles])
    v = np.concatenate([np.zeros(6), rates])
    stance, swing = model.getFrameId(stance_sole), model.getFrameId(swing_sole)
    if about_swing:  # free-flyer twist that keeps the swing sole at rest
        pin.computeJointJacobians(model, data, q)
        J = pin.computeFrameJacobian(model, data, q, swing, pin.LOCAL)
        v[:6] = -np.linalg.solve(J[:, :6], J[:, 6:] @ rates)
    pin.forwardKinematics(model, data, q, v)
    pin.updateFramePlacements(model, data)
    energy = pin.computeKineticEnergy(model, data)
    first, second = (swing, stance) if about_swing else (stance, swing)
    return data.oMf[first].actInv(data.oMf[second]), float(energy)
