"""Inertia matrices about the centre of mass: of a box, mirrored, and whether one can exist."""

from __future__ import annotations

import numpy as np

from gaitopt.errors import SpecError

Vector3 = tuple[float, float, float]
Matrix3 = tuple[Vector3, Vector3, Vector3]

ROUNDING = 1e-9
"""Relative slack for matrices typed from a drawing: symmetry and the flat-plate limit."""


def box_inertia(mass: float, size: Vector3) -> Matrix3:
    """Return the inertia [kg·m²] of a homogeneous box about its centre, axes along its edges.

    Args:
        mass: [kg].
        size: edges along x, y, z [m].
    """
    # Products, not powers: the same bits on every platform.
    xx, yy, zz = (edge * edge for edge in size)
    return (
        (mass / 12.0 * (yy + zz), 0.0, 0.0),
        (0.0, mass / 12.0 * (xx + zz), 0.0),
        (0.0, 0.0, mass / 12.0 * (xx + yy)),
    )


def mirrored_inertia(inertia: Matrix3) -> Matrix3:
    """Return the inertia of the body mirrored in the plane y = 0 (left to right)."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia
    return ((xx, -xy, xz), (-xy, yy, -yz), (xz, -yz, zz))


def checked_inertia(inertia: Matrix3, path: str) -> Matrix3:
    """Return the inertia made exactly symmetric, after checking that a body can have it.

    Args:
        inertia: about the centre of mass [kg·m²].
        path: where it stands in the specification, for messages.

    Raises:
        SpecError: not symmetric, not positive definite, or a principal moment is larger than the
            sum of the other two (impossible for positive mass; Featherstone, 2008, section 2.13).
    """
    matrix = np.array(inertia)
    size = float(np.abs(matrix).max())
    if np.abs(matrix - matrix.T).max() > ROUNDING * size:
        raise SpecError(f"{path} is not symmetric (kg·m²); give a symmetric 3 x 3 matrix")
    a, b, c = (float(moment) for moment in np.linalg.eigvalsh((matrix + matrix.T) / 2.0))
    moments = f"its principal moments are {a:.6g}, {b:.6g}, {c:.6g} kg·m²"
    if a <= 0.0:
        raise SpecError(
            f"{path} is not positive definite: {moments}; all three must be above 0; "
            "check the signs of the off-diagonal entries"
        )
    if c > (a + b) * (1.0 + ROUNDING):
        raise SpecError(
            f"{path} cannot belong to a body of positive mass: {moments}; the largest must not "
            "exceed the sum of the other two; check that it is taken about the centre of mass"
        )
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = inertia
    xy, xz, yz = (xy + yx) / 2.0, (xz + zx) / 2.0, (yz + zy) / 2.0
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
