"""The leg exchange E of Eq. (26), found from the joint axes of the model, never typed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.model.joint_tree import JointTree
from gaitopt.model.legs.kinematic_tree import line_gap, pose
from gaitopt.nlp import Array

REFLECTION = np.diag([1.0, -1.0, 1.0])  # left <-> right, in axes x forward, y left, z up
_SAME_LINE = 1e-6  # m, and sine of the angle: lines that are this near are one


def joint_lines(model: pin.Model, pelvis: pin.SE3) -> tuple[Array, Array]:
    """Return a point on and the direction of all joint axes at the neutral posture.

    Args:
        model: re-rooted model (free-flyer and n joints).
        pelvis: placement of the pelvis in the world at the neutral posture.

    Returns:
        Points and unit axes in the pelvis frame, each of shape (n, 3).
    """
    posed = pose(model, pin.neutral(model))
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
        partners: of each joint, the one that does the same on the other side (`mirror_partners`);
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


def mirror_partners(tree: JointTree, points: Array, axes: Array, centres: Array) -> list[int]:
    """Return the joint that does the same on the other side, for each joint.

    Partners in the legs are as many joints away from the hip: where several axes meet or are
    parallel, the mirror image of a line alone would not tell. The partner of any other joint sits
    on the mirror image of its body and has the mirror image of its line, at the neutral posture; a
    joint in the mirror plane is its own partner. Both shoulders may turn about one line: of several
    the one counts that moves the mirror image of what the joint moves.

    Args:
        tree: of the joints.
        points, axes: joint lines in the pelvis frame, shape (n, 3) each.
        centres: of mass of all that each joint moves, in the pelvis frame, shape (n, 3).

    Raises:
        RobotError: a joint has no mirror image.
    """
    feet = tree.swing_foot
    partners = list(range(feet))[::-1]
    for j in range(feet, tree.size):
        home = body_partner(tree, partners, tree.parents[j] + 1) - 1
        image, line = REFLECTION @ centres[j], (REFLECTION @ points[j], REFLECTION @ axes[j])
        found = [
            (float(np.linalg.norm(image - centres[k])), k)
            for k in range(feet, tree.size)
            if tree.parents[k] == home and line_gap(*line, points[k], axes[k]) <= _SAME_LINE
        ]
        if not found:
            raise RobotError(
                f"joint '{tree.names[j]}' is to move, but no joint mirrors it; keep its partner "
                "moving as well, and make the robot symmetric"
            )
        partners.append(min(found)[1])
    return partners


def body_partner(tree: JointTree, partners: Sequence[int], body: int) -> int:
    """Return the body that takes the place of another when the legs are exchanged.

    Args:
        tree: of the joints.
        partners: of the joints.
        body: of which the partner is asked.
    """
    return tree.swing_foot - body if body <= tree.swing_foot else partners[body - 1] + 1


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
    for angles, rates in _probe_motions(len(E)):
        placement, energy = _swing_placement(model, data, angles, rates, stance_sole, swing_sole)
        exchanged, other = _swing_placement(
            model, data, E @ angles, E @ rates, stance_sole, swing_sole, about_swing=True
        )
        gap = mirror_placement(placement).homogeneous - exchanged.homogeneous
        worst = max(worst, float(np.abs(gap).max()), abs(energy - other) / energy)
    return worst


def _probe_motions(count: int) -> list[tuple[Array, Array]]:
    rng = np.random.default_rng(0)
    return [(rng.uniform(-0.4, 0.4, count), rng.uniform(-1.0, 1.0, count)) for _ in range(3)]


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
