"""How a standing foot can move and what the ground can give it: contact modes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.model.sole import Sole
from gaitopt.nlp import Array


@dataclass(frozen=True, eq=False)
class Hinge:
    """A line of the sole that rests on the ground and about which the foot turns.

    It is a joint between the ground and the foot, whose angle is 0 where the foot stands flat.

    Attributes:
        point: on the line, in the sole frame [m], shape (3,).
        axis: unit vector, about which a positive angle lifts the sole, shape (3,).
    """

    point: Array
    axis: Array

    @cached_property
    def twist(self) -> Array:
        """Twist of the foot per unit of the angle's rate, linear part first, shape (6,).

        It is the same in the sole frame and in the frame of the footprint.
        """
        return np.concatenate([np.cross(self.point, self.axis), self.axis])


class ContactMode(ABC):
    """How a foot stands; a swinging foot has none.

    To add one: a class, here or in a file of its own (docs/extending.md).

    Attributes:
        name: in records and messages, unique.
    """

    name: ClassVar[str]

    @abstractmethod
    def hinge(self, sole: Sole) -> Hinge | None:
        """Return the line about which the foot turns, None where the whole sole rests."""

    @abstractmethod
    def bearing(self, sole: Sole, margin: float) -> Array:
        """Return where the centre of pressure may be: front, rear, left, right [m], shape (4,).

        Args:
            sole: the rectangle, in whose frame the result is.
            margin: to be kept from edges beyond which the foot would tip unasked [m].
        """

    @abstractmethod
    def resting(self) -> NDArray[np.bool_]:
        """Return which corners of the sole, as `Sole.corners`, are on the ground, shape (4,)."""


@dataclass(frozen=True)
class FlatFoot(ContactMode):
    """The whole sole rests on the ground.

    The foot stands still; the centre of pressure is inside the sole, Eqs. (37)-(38).
    """

    name: ClassVar[str] = "flat"

    def hinge(self, sole: Sole) -> None:
        """Return None: the foot cannot turn."""
        del sole

    def bearing(self, sole: Sole, margin: float) -> Array:
        return np.array(
            [sole.toe - margin, sole.heel + margin, sole.left - margin, sole.right + margin]
        )

    def resting(self) -> NDArray[np.bool_]:
        return np.ones(4, dtype=np.bool_)


@dataclass(frozen=True)
class ToeLine(ContactMode):
    """The front edge of the sole rests on the ground and the foot turns about it, the heel rising.

    The centre of pressure is within a strip behind the edge: a real one is round, or a plate.

    Attributes:
        strip: its length [m].
    """

    name: ClassVar[str] = "toe line"
    strip: float

    def hinge(self, sole: Sole) -> Hinge:
        return Hinge(np.array([sole.toe, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))

    def bearing(self, sole: Sole, margin: float) -> Array:
        return np.array([sole.toe, sole.toe - self.strip, sole.left - margin, sole.right + margin])

    def resting(self) -> NDArray[np.bool_]:
        return np.array([True, True, False, False])


@dataclass(frozen=True)
class HeelLine(ContactMode):
    """The rear edge of the sole rests on the ground and the foot turns about it, the toe rising.

    The centre of pressure is within a strip ahead of the edge: a heel is round.

    Attributes:
        strip: its length [m].
    """

    name: ClassVar[str] = "heel line"
    strip: float

    def hinge(self, sole: Sole) -> Hinge:
        return Hinge(np.array([sole.heel, 0.0, 0.0]), np.array([0.0, -1.0, 0.0]))

    def bearing(self, sole: Sole, margin: float) -> Array:
        return np.array(
            [sole.heel + self.strip, sole.heel, sole.left - margin, sole.right + margin]
        )

    def resting(self) -> NDArray[np.bool_]:
        return np.array([False, False, True, True])
