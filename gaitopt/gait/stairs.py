"""Stairs: treads of one step's length, and the height of the swing foot above them.

Every foot stands on a tread of its own. Between its toe and the heel on the next tread the ground
rises or falls at an edge; the height over which the swing foot must pass is rounded there, before
the edge upstairs and behind it downstairs. So it is never lower than the stairs, and has two
continuous derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitopt.errors import InputError
from gaitopt.gait.functions import QuantityFunction
from gaitopt.model.feet.sole import Sole
from gaitopt.nlp import Array

LEAST_ROUNDING = 0.02
"""Length before an edge [m] from which on the sole's sides need few points."""
_EDGES = (-2.0, -1.0, 0.0, 1.0)  # in treads from the edge before the stance foot
_CORNERS = 4


@dataclass(frozen=True)
class Stairs:
    """Stairs in the axes of the stance sole.

    Attributes:
        rise: of each tread over the one before, down below zero [m].
        tread: depth of a tread [m].
        begin: x at which the height begins to change before the stance foot [m].
        rounding: length over which it changes [m].
    """

    rise: float
    tread: float
    begin: float
    rounding: float

    @property
    def edge(self) -> float:
        """X of the edge before the stance foot [m]."""
        return self.begin + (self.rounding if self.rise > 0.0 else 0.0)

    def height(self, x: Array) -> tuple[Array, Array, Array]:
        """Return the height at x and its first and second derivatives, each of the shape of x."""
        total, first, second = (
            np.full(x.shape, -2.0 * self.rise),
            np.zeros(x.shape),
            np.zeros(x.shape),
        )
        for count in _EDGES:
            t = np.clip((x - self.begin - count * self.tread) / self.rounding, 0.0, 1.0)
            total += self.rise * t**3 * (10.0 + t * (6.0 * t - 15.0))
            first += self.rise / self.rounding * 30.0 * t**2 * (1.0 - t) ** 2
            second += self.rise / self.rounding**2 * 60.0 * t * (1.0 - t) * (1.0 - 2.0 * t)
        return total, first, second


def stairs_of(rise: float, tread: float, rounding: float | None, sole: Sole) -> Stairs:
    """Return the stairs that a sole can stand on.

    Args:
        rise: of each tread over the one before [m].
        tread: its depth, one step [m].
        rounding: length over which the height changes [m]; None: all that the sole leaves.
        sole: its rectangle.

    Raises:
        InputError: the treads are too short for it.
    """
    length = sole.toe - sole.heel
    room = tread - length
    wanted = LEAST_ROUNDING if rounding is None else rounding
    if room < wanted:
        raise InputError(
            f"a tread as long as a step, {tread:.3f} m, is too short for a sole of {length:.3f} m "
            f"and {wanted:g} m to the edges (nosing): at least {length + wanted:.3f} m; take "
            "longer steps (speed times duration), or a smaller nosing"
        )
    rounding = room if rounding is None else rounding
    return Stairs(rise, tread, sole.toe + (room - rounding) / 2.0, rounding)


def sole_points(spacing: float, sole: Sole) -> Array:
    """Return the shares of the corners in points along both sides of a sole, shape (p, 4).

    Args:
        spacing: largest distance between two of them [m].
        sole: its rectangle.
    """
    count = int(np.ceil((sole.toe - sole.heel) / spacing))
    points = np.eye(_CORNERS)
    for share in np.arange(1, count) / count:
        points = np.vstack([points, [[1 - share, 0, share, 0], [0, 1 - share, 0, share]]])
    return points


@dataclass(frozen=True)
class AboveStairs(QuantityFunction):
    """Heights of points of the swing sole above the stairs, from its corners, shape (K, p).

    Attributes:
        stairs: below them.
        points: shares of the four corners in each point, shape (p, 4).
    """

    stairs: Stairs
    points: Array

    def value(self, quantity: Array) -> Array:
        """Return the heights [m], shape (K, p)."""
        x, z = self._placed(quantity)
        return np.asarray(z - self.stairs.height(x)[0])

    def jacobian(self, quantity: Array) -> Array:
        """Return the derivative, shape (K, p, 12)."""
        x, _ = self._placed(quantity)
        jacobian = np.zeros((*x.shape, _CORNERS, 3))
        jacobian[..., 0] = -self.stairs.height(x)[1][..., None] * self.points
        jacobian[..., 2] = self.points
        return jacobian.reshape(*x.shape, -1)

    def hessian(self, quantity: Array, weights: Array) -> Array:
        """Return the Hessian, shape (K, 12, 12)."""
        x, _ = self._placed(quantity)
        bent = -weights * self.stairs.height(x)[2]
        hessian = np.zeros((len(x), _CORNERS, 3, _CORNERS, 3))
        hessian[:, :, 0, :, 0] = np.einsum("kp,pi,pj->kij", bent, self.points, self.points)
        return hessian.reshape(len(x), 3 * _CORNERS, 3 * _CORNERS)

    def _placed(self, quantity: Array) -> tuple[Array, Array]:
        corners = quantity.reshape(-1, _CORNERS, 3)
        return corners[..., 0] @ self.points.T, corners[..., 2] @ self.points.T
