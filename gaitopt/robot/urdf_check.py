"""What the loaders below accept silently: XML errors, masses and inertias that no body can have."""

from __future__ import annotations

import math
from xml.etree import ElementTree

from gaitopt.errors import RobotError, SpecError
from gaitopt.robot.inertia import Matrix3, checked_inertia

_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def check_urdf(text: str) -> None:
    """Check that a URDF is XML, and that every link and joint in it is physical.

    Args:
        text: of the URDF.

    Raises:
        RobotError: naming the link or joint, the value, and what is allowed.
    """
    try:
        robot = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise RobotError(f"the URDF is not well-formed XML: {error}; correct that line") from None
    if robot.tag != "robot":
        raise RobotError(f"the file holds <{robot.tag}>, not a URDF; its root must be <robot>")
    for link in robot.iter("link"):
        inertial = link.find("inertial")
        if inertial is not None:
            _check_inertial(f"link '{link.get('name')}'", inertial)
    for joint in robot.iter("joint"):
        limit = joint.find("limit")
        if limit is not None and joint.get("type") in ("revolute", "prismatic"):
            _check_limit(f"joint '{joint.get('name')}'", limit)


def _check_inertial(owner: str, inertial: ElementTree.Element) -> None:
    mass_entry, tensor = inertial.find("mass"), inertial.find("inertia")
    mass = _number(owner, "mass", mass_entry, "value", "kg")
    if not mass > 0.0:
        raise RobotError(
            f"{owner}: the mass is {mass:g} kg; it must be above 0 (leave <inertial> out of a "
            "link without mass)"
        )
    xx, xy, xz, yy, yz, zz = (_number(owner, m, tensor, m, "kg·m²") for m in _MOMENTS)
    matrix: Matrix3 = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    try:
        checked_inertia(matrix, f"{owner}: the inertia")
    except SpecError as error:
        raise RobotError(str(error)) from None


def _check_limit(owner: str, limit: ElementTree.Element) -> None:
    lower, upper = (_number(owner, side, limit, side, "rad", "0") for side in ("lower", "upper"))
    if not lower < upper:
        raise RobotError(
            f"{owner}: the range is from {lower:g} to {upper:g} rad; lower must be below upper"
        )


def _number(
    owner: str,
    name: str,
    element: ElementTree.Element | None,
    attribute: str,
    unit: str,
    default: str | None = None,
) -> float:
    text = default if element is None else element.get(attribute, default)
    if text is None:
        raise RobotError(f"{owner}: no {name} is given; add it [{unit}]")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RobotError(f"{owner}: {name} is '{text}'; it must be a finite number [{unit}]")
    return value
