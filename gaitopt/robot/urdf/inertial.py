"""Whether the masses and inertias of a URDF can belong to bodies."""

from __future__ import annotations

import numpy as np

from gaitopt.nlp import Array
from gaitopt.robot.urdf.description import Link
from gaitopt.robot.urdf.values import UrdfProblem

_ROUNDING = 1e-6  # relative: what the digits of a drawing leave of a flat plate or a thin rod
_POINT = 1e-9  # m²: below this times its mass, a body is a point and its inertia rounding
_LEAST = 1e-12  # relative: keeps a moment of zero above zero when the axes are turned


def inertial_problems(link: Link) -> list[UrdfProblem]:
    """Return a problem if no body can have the mass and the inertia of a link."""
    if link.inertial is None:
        return []
    fault = inertia_fault(link.inertial.mass, link.inertial.inertia)
    return [link.entry.problem("inertia", fault, link.inertial.element)] if fault else []


def sound_inertia(mass: float, inertia: Array) -> Array:
    """Return an inertia whose moments lie below zero by rounding only with these at zero.

    Pinocchio makes no body of the least negative moment. An inertia at fault is returned as it is.

    Args:
        mass: not negative [kg].
        inertia: symmetric, about the centre of mass [kg·m²], shape (3, 3).
    """
    moments, axes = np.linalg.eigh(inertia)
    least = _LEAST * float(moments[2])
    if moments[0] >= least or inertia_fault(mass, inertia):
        return inertia
    raised: Array = (axes * np.maximum(moments, least)) @ axes.T
    return (raised + raised.T) / 2.0


def inertia_fault(mass: float, inertia: Array) -> str:
    """Return why no body has this mass and this inertia about its centre, or an empty string.

    A point mass (no inertia) and a frame (nothing at all) are limits of bodies, and pass.

    Args:
        mass: not negative [kg].
        inertia: symmetric, about the centre of mass [kg·m²], shape (3, 3).
    """
    a, b, c = (float(moment) for moment in np.linalg.eigvalsh(inertia))
    slack = _POINT * mass + _ROUNDING * abs(c)
    moments = f"its principal moments are {a:.4g}, {b:.4g}, {c:.4g} kg·m²"
    if mass == 0.0 and max(abs(a), abs(c)) > 0.0:
        return (
            f"the mass is 0 kg, but {moments}; the mass must be above 0 "
            "(leave <inertial> out of a link without mass)"
        )
    if a < -slack:
        return (
            f"the inertia is not positive definite: {moments}; all must be above 0; check the "
            "signs, and that it is taken about the centre of mass"
        )
    if c > a + b + slack:
        return (
            f"the inertia cannot belong to a body of positive mass: {moments}; the largest must "
            "not exceed the sum of the other two; check that it is taken about the centre of mass"
        )
    return ""
