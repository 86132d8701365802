"""The rectangle of the sole that may touch the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.nlp import Array

_FLATNESS = 1e-6  # m: how far the lower face of the foot may be from the plane of its sole frame


@dataclass(frozen=True)
class Sole:
    """A rectangle in the plane z = 0 of the sole frame [m]: x forward, y left."""

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


def sole_from_collision(model: pin.Model, geometry: pin.GeometryModel, frame: str) -> Sole:
    """Return the lower face of the collision box under the foot that carries a sole frame.

    Args:
        model: the model that `geometry` belongs to.
        geometry: collision geometry.
        frame: name of the sole frame.

    Raises:
        RobotError: the foot has no collision box with its lower face in the plane of the sole.
    """
    sole = model.frames[model.getFrameId(frame)]
    for item in geometry.geometryObjects:
        half = getattr(item.geometry, "halfSide", None)
        if item.parentJoint != sole.parentJoint or half is None:
            continue
        signs = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1)
        corners = (signs * np.asarray(half).reshape(3, 1)).T
        placement = sole.placement.inverse() * item.placement
        points = corners @ placement.rotation.T + placement.translation
        lower = points[points[:, 2] < points[:, 2].mean()]
        if np.abs(lower[:, 2]).max() < _FLATNESS:
            x, y = lower[:, 0], lower[:, 1]
            return Sole(*(_tidy(v) for v in (x.max(), x.min(), y.max(), y.min())))
    raise RobotError(
        f"no collision box of the foot has its lower face in the plane of frame '{frame}'; "
        "give the sole rectangle: Robot.from_urdf(..., sole=Sole(toe, heel, left, right))"
    )


def _tidy(value: float) -> float:
    """Round away the rounding of the placements (1e-12 m)."""
    return round(float(value), 12) + 0.0
