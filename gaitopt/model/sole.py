"""The rectangle of a sole that may touch the ground, and what its corners tell."""

from __future__ import annotations

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.nlp import Array
from gaitopt.settings import checked

LEVEL = (0.0, 0.0, -1.0)
"""Direction of gravity in the axes of soles on level ground."""


@checked
@dataclass(frozen=True)
class Sole:
    """A rectangle in the plane z = 0 of the sole frame [m]: x forward, y left.

    Attributes:
        toe, heel: x of the front and the rear edge [m].
        left, right: y of the left and the right edge [m].

    Raises:
        RobotError: the rectangle is empty.
    """

    toe: float
    heel: float
    left: float
    right: float

    def __post_init__(self) -> None:
        if not (self.toe > self.heel and self.left > self.right):
            raise RobotError(
                f"the sole rectangle is empty: x from {self.heel} to {self.toe} m, "
                f"y from {self.right} to {self.left} m; toe must exceed heel and left exceed right"
            )

    @property
    def length(self) -> float:
        """From heel to toe [m]."""
        return self.toe - self.heel

    @property
    def width(self) -> float:
        """From right to left [m]."""
        return self.left - self.right

    @property
    def corners(self) -> Array:
        """Toe left, toe right, heel left, heel right in the sole frame [m], shape (4, 3)."""
        return np.array(
            [
                [self.toe, self.left, 0.0],
                [self.toe, self.right, 0.0],
                [self.heel, self.left, 0.0],
                [self.heel, self.right, 0.0],
            ]
        )


def tidy(length: float) -> float:
    """Return a length [m] without the rounding of the placements it came from (1e-12 m)."""
    return round(float(length), 12) + 0.0


def sole_edge_speeds(corners: Array) -> Array:
    """Return the matrix from a sole's twist to the upward speeds of its corners, shape (k, 6).

    The twist is (linear velocity of the sole origin, angular velocity) in the sole frame of a flat
    foot; a corner (x, y) of `corners` (k, 3) [m] rises at v_z + w_x y - w_y x.
    """
    zero, one = np.zeros(len(corners)), np.ones(len(corners))
    return np.stack([zero, zero, one, corners[:, 1], -corners[:, 0], zero], axis=1)


def sole_tilt(corners: Array) -> Array:
    """Return the matrix from `Sole.corners` in the world to the tilt of a sole, shape (5, 12).

    Rows: how much higher the left edge is than the right, the heel than the toe (both per metre:
    the sines of roll and pitch), how far left the toe is of the heel (the sine of yaw); and how far
    the toe is ahead of the heel and the left edge left of the right, one where the sole is level,
    negative where it points backwards or is upside down, which the sines do not tell.
    """
    x, y = corners[:, 0] - corners[:, 0].mean(), corners[:, 1] - corners[:, 1].mean()
    rows = np.zeros((5, *corners.shape))
    rows[0, :, 2] = y / (y @ y)
    rows[1, :, 2] = -x / (x @ x)
    rows[2, :, 1] = x / (x @ x)
    rows[3, :, 0] = x / (x @ x)
    rows[4, :, 1] = y / (y @ y)
    return rows.reshape(5, corners.size)


def turning_arm(length: float, width: float) -> float:
    """Return the mean distance of points of a rectangle (sides in m) from its centre [m].

    A sole that presses evenly resists being turned about its centre by friction * load * this arm
    (Goyal, Ruina & Papadopoulos, Planar sliding with dry friction, Wear 143, 1991): every bit of it
    slides across its own distance from the centre.
    """
    ahead = length**2 / width * np.arcsinh(width / length)
    aside = width**2 / length * np.arcsinh(length / width)
    return float(2.0 * np.hypot(length, width) + ahead + aside) / 12.0


def centre_of_pressure(wrench: Array) -> Array:
    """Return where wrenches (..., 6) press on the sole, Eqs. (37)-(38) [m], shape (..., 2)."""
    return np.stack([-wrench[..., 4], wrench[..., 3]], axis=-1) / wrench[..., 2:3]
