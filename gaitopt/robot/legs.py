"""What a pair of legs is made of: hip and ankle centres, knees, reach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.nlp import Array

HIP_JOINTS = ((3, 4, 5), (6, 7, 8))  # rows of the joint vector: stance leg, swing leg


@dataclass(frozen=True)
class Legs:
    """Geometry of the two legs, stance leg first.

    Attributes:
        hips: centres of the hips in the pelvis frame [m], shape (2, 3).
        ankles: centres of the ankles in the sole frames [m], shape (2, 3).
        knees: index of each knee in the joint vector.
        straight: knee angle at which the leg is longest [rad], shape (2,).
        flexion: +1 where the knee bends with increasing angle, else -1, shape (2,).
        reach: largest distance between hip and ankle centres [m].
    """

    hips: Array
    ankles: Array
    knees: tuple[int, int]
    straight: Array
    flexion: Array
    reach: float


def common_point(points: Array, axes: Array) -> Array:
    """Return the point nearest to a set of lines in the least-squares sense, shape (3,).

    Where the lines leave a direction free (parallel axes), the point nearest to the mean of
    `points` is taken.
    """
    projectors = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    mean = points.mean(axis=0)
    rhs = np.einsum("nij,nj->i", projectors, points - mean)
    return np.asarray(mean + np.linalg.lstsq(projectors.sum(axis=0), rhs, rcond=1e-9)[0])


def find_knee(
    model: pin.Model, rows: range, hip: tuple[int, Array], ankle: tuple[int, Array]
) -> tuple[int, float, float]:
    """Find the joint that changes the hip-ankle distance most.

    About one revolute joint the squared distance is c0 + c1 cos q + c2 sin q, so three angles give
    the straight-knee angle and the reach exactly.

    Args:
        model: re-rooted model.
        rows: the leg's rows in the joint vector.
        hip, ankle: joint id and position in that joint's frame of the two centres.

    Returns:
        Row of the knee, straight angle [rad], reach [m].
    """
    best = (-1.0, 0, 0.0, 0.0)
    for row in rows:
        squared = [_squared_distance(model, row, angle, hip, ankle) for angle in (0.0, 2.1, -2.1)]
        c0, c1, c2 = np.linalg.solve(
            [[1.0, np.cos(a), np.sin(a)] for a in (0.0, 2.1, -2.1)], squared
        )
        swing = float(np.hypot(c1, c2))
        if swing > best[0]:
            best = (swing, row, float(np.arctan2(c2, c1)), float(np.sqrt(c0 + swing)))
    return best[1], best[2], best[3]


def _squared_distance(
    model: pin.Model, row: int, angle: float, hip: tuple[int, Array], ankle: tuple[int, Array]
) -> float:
    q = pin.neutral(model)
    q[7 + row] = angle
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    gap = data.oMi[hip[0]].act(hip[1]) - data.oMi[ankle[0]].act(ankle[1])
    return float(gap @ gap)
