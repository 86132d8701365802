"""Whether the masses and inertias of a URDF can belong to bodies."""

from __future__ import annotations

from xml.etree.ElementTree import Element

import numpy as np

from gaitopt.nlp import Array
from gaitopt.robot.urdf.values import Entry, UrdfProblem

_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_ROUNDING = 1e-6  # relative: what the digits of a drawing leave of a flat plate or a thin rod
_POINT = 1e-9  # m²: below this times its mass, a body is a point and its inertia rounding


def check_inertial(link: Entry, inertial: Element) -> list[UrdfProblem]:
    """Check the mass, its centre and its inertia of one link.

    Args:
        link: that is checked.
        inertial: its `inertial` element.

    Returns:
        A problem if no body can have these values.

    Raises:
        RobotError: a value is not a number, or the mass is negative.
    """
    mass_entry, tensor = inertial.find("mass"), inertial.find("inertia")
    mass = link.number(mass_entry, "value", "mass", "kg")
    if mass < 0.0:
        raise link.refusal(f"the mass is {mass:g} kg; it must be above 0; correct it", mass_entry)
    xx, xy, xz, yy, yz, zz = (link.number(tensor, m, m, "kg·m²") for m in _MOMENTS)
    for part in ("xyz", "rpy"):
        link.vector(inertial.find("origin"), part, f"the {part} of its centre of mass")
    fault = inertia_fault(mass, np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    return [link.problem("inertia", fault, inertial)] if fault else []


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
