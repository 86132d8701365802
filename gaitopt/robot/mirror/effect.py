"""What a difference between two robots amounts to in a walk.

Two robots with the same joints are compared over their range of motion by what the dynamics of a
walk is made of: the mass matrix of the twelve joints with one foot on the ground, and where the
other foot is. A difference of a link's inertia, of a joint's line or of a rotor thus has one
measure, and a light link or a joint near the ground counts as little as it matters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.nlp import Array

_POSTURES = 48
_WORTH = 1e-6  # what is below matters to nobody
_WIDEST = 1.0  # rad: what a leg's joint turns to either side in a walk, and stairs, and squats


@dataclass(frozen=True)
class Effect:
    """How far two robots differ, the largest over all postures, either foot standing.

    Attributes:
        mass_matrix: difference of the mass matrix, each entry in units of sqrt(D_i D_j), where D_i
            is what joint i or its partner in the other leg moves, whichever is more (for most
            joints when its leg stands) [-].
        feet: how far the other foot is from where it was, per length of the leg, or by how much it
            is turned [rad], whichever is more.
    """

    mass_matrix: float
    feet: float

    @property
    def size(self) -> float:
        """The larger of the two."""
        return max(self.mass_matrix, self.feet)

    def words(self) -> str:
        """Return both as percentages."""
        return (
            f"the mass matrix by {percent(self.mass_matrix)} and the placement of the feet by "
            f"{percent(self.feet)} of the leg's length"
        )

    def brief(self) -> str:
        """Return what is worth a word, as percentages."""
        parts = (("mass matrix", self.mass_matrix), ("feet", self.feet))
        return ", ".join(f"{name} {percent(share)}" for name, share in parts if share >= _WORTH)


@dataclass(frozen=True)
class WalkProbe:
    """Postures in which robots of one set of joints are compared.

    Attributes:
        postures: configurations, free-flyer at the origin, shape (n, nq).
        soles: names of the right and of the left sole frame.
        partner: row of the partner of each of the twelve joints, shape (12,).
        length: of the leg [m].
    """

    postures: Array
    soles: tuple[str, str]
    partner: Array
    length: float

    def compare(self, first: Motions, other: Motions) -> Effect:
        """Return how far two robots differ.

        Args:
            first, other: of `measure`; the first one gives the scale.
        """
        moved = np.diagonal(first.mass, axis1=-2, axis2=-1).max(axis=1)  # (n, 12): either foot
        moved = np.maximum(moved, moved[:, self.partner])
        scale = np.sqrt(moved[:, :, None] * moved[:, None, :])[:, None]
        change = np.abs(first.mass - other.mass) / scale
        apart = np.linalg.norm(first.place - other.place, axis=-1) / self.length
        # |R - Q| = 2 sqrt(2) |sin(angle / 2)|
        chord = np.linalg.norm(first.turn - other.turn, axis=(-2, -1)) / np.sqrt(8.0)
        angle = 2.0 * np.arcsin(np.clip(chord, 0.0, 1.0))
        return Effect(float(change.max()), float(max(apart.max(), angle.max())))

    def measure(self, model: pin.Model) -> Motions:
        """Return mass matrices and placements of a robot in all postures.

        Args:
            model: free-flyer and twelve joints, rooted at the pelvis, with both sole frames.
        """
        data = model.createData()
        frames = [model.getFrameId(name) for name in self.soles]
        count = len(self.postures)
        M, J = np.zeros((count, 18, 18)), np.zeros((count, 2, 6, 18))
        place, turn = np.zeros((count, 2, 3)), np.zeros((count, 2, 3, 3))
        for k, q in enumerate(self.postures):
            M[k] = pin.crba(model, data, q)
            pin.computeJointJacobians(model, data, q)
            pin.updateFramePlacements(model, data)
            for side, frame in enumerate(frames):
                J[k, side] = pin.getFrameJacobian(model, data, frame, pin.LOCAL)
                seen = data.oMf[frame].actInv(data.oMf[frames[1 - side]])
                place[k, side], turn[k, side] = seen.translation, seen.rotation
        # The free-flyer's twist that keeps the standing foot still is linear in the joint rates.
        held = np.zeros((count, 2, 18, 12))
        held[..., :6, :] = -np.linalg.solve(J[..., :6], J[..., 6:])
        held[..., 6:, :] = np.eye(12)
        return Motions(held.swapaxes(-1, -2) @ M[:, None] @ held, place, turn)


@dataclass(frozen=True)
class Motions:
    """A robot in n postures, the right foot standing, then the left.

    Attributes:
        mass: mass matrix of the twelve joints with that foot at rest, shape (n, 2, 12, 12).
        place, turn: of the other sole in the standing one, shapes (n, 2, 3) and (n, 2, 3, 3).
    """

    mass: Array
    place: Array
    turn: Array


def walk_probe(model: pin.Model, legs: tuple[tuple[int, ...], ...], soles: tuple[str, str],
               length: float) -> WalkProbe:  # fmt: skip
    """Return the postures in which variants of a robot are compared: straight, and at random.

    Args:
        model: free-flyer and twelve joints, rooted at the pelvis.
        legs: joints of the right and of the left leg from hip to ankle.
        soles: names of the right and of the left sole frame.
        length: of the leg [m].
    """
    low, high = (
        np.clip(np.array(b)[7:], -_WIDEST, _WIDEST)
        for b in (model.lowerPositionLimit, model.upperPositionLimit)
    )
    ranged = low < high  # a range beyond that, or none, is as good as the whole
    low, high = np.where(ranged, low, -_WIDEST), np.where(ranged, high, _WIDEST)
    postures = np.tile(pin.neutral(model), (_POSTURES, 1))
    postures[1:, 7:] = np.random.default_rng(0).uniform(low, high, (_POSTURES - 1, 12))
    partner = np.zeros(12, dtype=int)
    for right, left in zip(*legs, strict=True):
        rows = (model.joints[j].idx_v - 6 for j in (right, left))
        i, j = rows
        partner[i], partner[j] = j, i
    return WalkProbe(postures, soles, partner, length)


def percent(share: float) -> str:
    """Return a share in words."""
    return f"{100.0 * share:.2g} %" if share >= _WORTH else f"less than {100.0 * _WORTH:g} %"
