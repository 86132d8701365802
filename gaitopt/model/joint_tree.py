"""The tree of a robot's joints, rooted at the stance foot."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.nlp import Array

TWIST = 6
"""Degrees of freedom of a rigid body."""

FIRST = 2
"""Pinocchio's index of joint 0: its joints 0 and 1 are the universe and the stance foot."""


@dataclass(frozen=True, eq=False)
class JointTree:
    """Which joint moves which body.

    Joint j carries body j + 1; body 0 is the stance foot, which does not move. The joints of the
    stance leg come first, from foot to pelvis, then those of the swing leg, from pelvis to foot,
    then all others (waist, arms, head), every branch depth first. A joint thus comes after the
    joints that move it.

    Attributes:
        names: of the n joints.
        parents: of each joint, the joint that carries the body it sits on; -1 for the stance foot.
        stance, swing: number of joints of the stance leg and of the swing leg.

    Raises:
        RobotError: the joints are not in that order.
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    stance: int
    swing: int

    def __post_init__(self) -> None:
        feet = self.stance + self.swing
        serial = self.parents[:feet] == tuple(range(-1, feet - 1))
        if not (serial and all(-1 <= p < j for j, p in enumerate(self.parents))):
            raise RobotError(
                f"the joints {list(self.names)} are not in the order stance leg, swing leg, other "
                "branches; root the model at the stance sole first"
            )

    @property
    def size(self) -> int:
        """Number of joints n."""
        return len(self.names)

    @property
    def legs(self) -> slice:
        """Joints between the two feet."""
        return slice(self.stance + self.swing)

    @property
    def pelvis(self) -> int:
        """Body between the legs."""
        return self.stance

    @property
    def swing_foot(self) -> int:
        """Body at the end of the swing leg."""
        return self.stance + self.swing

    @property
    def serial(self) -> bool:
        """Whether it is one chain from foot to foot."""
        return self.size == self.swing_foot

    @property
    def determined(self) -> bool:
        """Whether the placements of pelvis and swing foot determine all joint angles."""
        return self.serial and self.stance == self.swing == TWIST

    @cached_property
    def moves(self) -> NDArray[np.bool_]:
        """Whether joint j moves the body that joint i carries, at [i, j], shape (n, n)."""
        mask = np.eye(self.size, dtype=np.bool_)
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                mask[joint] |= mask[parent]
        mask.setflags(write=False)
        return mask

    def path(self, body: int) -> NDArray[np.bool_]:
        """Return which joints are between the stance foot and a body, shape (n,)."""
        return np.zeros(self.size, np.bool_) if body == 0 else self.moves[body - 1]

    def up_to(self, per_joint: Array) -> Array:
        """Sum over the joints that move each body, shape (..., n, k) of the joints' (..., n, k)."""
        return self._inward[0] @ per_joint

    def beyond(self, per_body: Array) -> Array:
        """Sum over the bodies that each joint moves, shape (N, n, ...) of the bodies' (N, n, ...).

        The stance foot is not among them.
        """
        flat = per_body.reshape(*per_body.shape[:2], -1)
        return (self._inward[1] @ flat).reshape(per_body.shape)

    def sum_before(self, per_joint: Array) -> Array:
        """Sum over the joints that move each one, itself apart, shape (..., n) of (..., n)."""
        return (per_joint.reshape(-1, self.size) @ self._strictly).reshape(per_joint.shape)

    def sum_beyond(self, per_body: Array) -> Array:
        """Sum over the bodies that each joint moves, shape (..., n) of the bodies' (..., n)."""
        return (per_body.reshape(-1, self.size) @ self._inward[0]).reshape(per_body.shape)

    def joined(self, upper: Array, lower: Array) -> Array:
        """Return a table of pairs of joints (..., n, n) from closed forms for either order.

        Args:
            upper: used at [i, j] where joint i is joint j or moves it.
            lower: used at [i, j] where joint j moves joint i.

        Joints of different branches move no body in common; their entries are zero.
        """
        above, below = self._related
        return np.asarray(upper * above + lower * below)

    def symmetric(self, upper: Array) -> Array:
        """Return `joined` with its transpose: a symmetric table (..., n, n)."""
        return self.joined(upper, np.swapaxes(upper, -1, -2))

    def from_legs(self, of_legs: Array) -> Array:
        """Return a table (..., n) from one of the legs' joints (..., legs), zero for the others."""
        if self.serial:
            return of_legs
        table = np.zeros((*of_legs.shape[:-1], self.size))
        table[..., self.legs] = of_legs
        return table

    @cached_property
    def _inward(self) -> tuple[Array, Array]:
        """The mask as numbers, and its transpose."""
        numbers = self.moves.astype(np.float64)
        return numbers, numbers.T

    @cached_property
    def _strictly(self) -> Array:
        return self._inward[1] - np.eye(self.size)

    @cached_property
    def _related(self) -> tuple[Array, Array]:
        return np.ascontiguousarray(self._inward[1]), np.ascontiguousarray(self._strictly.T)


def joint_tree(model: pin.Model, pelvis: int, swing_foot: int) -> JointTree:
    """Return the tree of a model that is rooted at the stance sole.

    Args:
        pelvis, swing_foot: Pinocchio's indices of the joints that carry these bodies.

    Raises:
        RobotError: see `JointTree`.
    """
    return JointTree(
        names=tuple(str(name) for name in model.names[FIRST:]),
        parents=tuple(int(parent) - FIRST for parent in model.parents[FIRST:]),
        stance=pelvis - FIRST + 1,
        swing=swing_foot - pelvis,
    )
