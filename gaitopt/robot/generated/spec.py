"""What a thirteen-link biped is made of: lengths, masses, inertias and motor limits, in SI units.

Frames: x forward, y left, z up, parallel to the world at the zero posture (straight legs). Values
are those of the left leg, seen from the pelvis down; the right leg is its mirror image in y = 0.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace

from gaitopt.errors import SpecError
from gaitopt.robot.generated.inertia import Matrix3, Vector3, box_inertia, checked_inertia
from gaitopt.robot.generated.quantity import Quantity, checked

_LENGTH = Quantity("m", 1e-4, 10.0)
_OFFSET = Quantity("m", -10.0, 10.0)
_MASS = Quantity("kg", 1e-4, 1e4)
_INERTIA = Quantity("kg·m²", -1e6, 1e6, shape=(3, 3), optional=True)
_TORQUE = Quantity("N·m", 1e-3, 1e5)
_SPEED = Quantity("rad/s", 1e-3, 1e3)
_ANGLE = Quantity("rad", -2.0 * math.pi, 2.0 * math.pi)
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.-]{0,63}")


@dataclass(frozen=True)
class Geometry:
    """Lengths of the paper's Tables 1 and 2 [m].

    Attributes:
        l1: sole frame (middle of the toe edge) to the ankle, along the foot; negative, because
            the ankle lies behind the toes. l13 = -l1.
        d1: height of the ankle above the sole. d13 = d1.
        d3: shin, ankle to knee. d11 = d3.
        d4: thigh, knee to hip. d10 = d4.
        l4: how far the plane of the leg lies outboard of the hip centre. l10 = l4.
        d7: distance between the two hip centres.
        foot_length: of the sole, forward (Lp).
        foot_width: of the sole, sideways (lp).
    """

    l1: float = field(metadata=_OFFSET.metadata)
    d1: float = field(metadata=_LENGTH.metadata)
    d3: float = field(metadata=_LENGTH.metadata)
    d4: float = field(metadata=_LENGTH.metadata)
    l4: float = field(metadata=_OFFSET.metadata)
    d7: float = field(metadata=_LENGTH.metadata)
    foot_length: float = field(metadata=_LENGTH.metadata)
    foot_width: float = field(metadata=_LENGTH.metadata)

    @property
    def hip_height(self) -> float:
        """Height of the hip centres above the sole with straight legs [m]."""
        return self.d1 + self.d3 + self.d4


@dataclass(frozen=True)
class LinkSpec:
    """One rigid link.

    Attributes:
        mass: [kg].
        size: edges of its box along x, y, z [m]; the box gives the inertia unless that is given.
        com: centre of mass, which is the centre of the box, in the frame of the joint above the
            link (torso: midpoint between the hips) [m].
        inertia: about the centre of mass, axes of the link, (3, 3) [kg·m²]; None: of the box.
    """

    mass: float = field(metadata=_MASS.metadata)
    size: Vector3 = field(metadata=Quantity("m", 1e-4, 10.0, shape=(3,)).metadata)
    com: Vector3 = field(metadata=Quantity("m", -10.0, 10.0, shape=(3,)).metadata)
    inertia: Matrix3 | None = field(default=None, metadata=_INERTIA.metadata)

    @property
    def com_inertia(self) -> Matrix3:
        """Inertia about the centre of mass, given or of the homogeneous box [kg·m²]."""
        return box_inertia(self.mass, self.size) if self.inertia is None else self.inertia


_LINK = {"part": LinkSpec}


@dataclass(frozen=True)
class Links:
    """The links: the torso and those of one leg from hip to foot.

    Attributes:
        torso: pelvis, trunk and head in one.
        hip_yaw: between the hip yaw and hip roll joints.
        hip_roll: between the hip roll and hip pitch joints.
        thigh: between the hip pitch and knee joints.
        shin: between the knee and ankle pitch joints.
        ankle: between the ankle pitch and ankle roll joints.
        foot: after the ankle roll joint.
    """

    torso: LinkSpec = field(metadata=_LINK)
    hip_yaw: LinkSpec = field(metadata=_LINK)
    hip_roll: LinkSpec = field(metadata=_LINK)
    thigh: LinkSpec = field(metadata=_LINK)
    shin: LinkSpec = field(metadata=_LINK)
    ankle: LinkSpec = field(metadata=_LINK)
    foot: LinkSpec = field(metadata=_LINK)

    def named(self) -> Iterator[tuple[str, LinkSpec]]:
        """Yield the name and the link, in the order of the attributes."""
        return ((entry.name, getattr(self, entry.name)) for entry in fields(self))

    @property
    def leg(self) -> tuple[LinkSpec, ...]:
        """The six links of one leg, from hip to foot, one below each joint of `Joints`."""
        return (self.hip_yaw, self.hip_roll, self.thigh, self.shin, self.ankle, self.foot)


@dataclass(frozen=True)
class JointLimits:
    """What one joint can do.

    Attributes:
        torque: largest absolute torque [N·m].
        speed: largest absolute rate [rad/s].
        lower, upper: range of the left joint [rad]; the right one mirrors roll and yaw.
    """

    torque: float = field(metadata=_TORQUE.metadata)
    speed: float = field(metadata=_SPEED.metadata)
    lower: float = field(metadata=_ANGLE.metadata)
    upper: float = field(metadata=_ANGLE.metadata)


_JOINT = {"part": JointLimits}


@dataclass(frozen=True)
class Joints:
    """The six joints of a leg, from hip to foot: yaw about z, roll about x, pitch about y."""

    hip_yaw: JointLimits = field(metadata=_JOINT)
    hip_roll: JointLimits = field(metadata=_JOINT)
    hip_pitch: JointLimits = field(metadata=_JOINT)
    knee: JointLimits = field(metadata=_JOINT)
    ankle_pitch: JointLimits = field(metadata=_JOINT)
    ankle_roll: JointLimits = field(metadata=_JOINT)

    def named(self) -> Iterator[tuple[str, JointLimits]]:
        """Yield the name and the limits, from hip to foot."""
        return ((entry.name, getattr(self, entry.name)) for entry in fields(self))


@dataclass(frozen=True)
class BipedSpec:
    """A thirteen-link biped, checked when made; change one with `spec_table.changed`.

    Attributes:
        name: of the robot; a letter, then letters, digits, and the signs _ . -
        geometry: lengths.
        links: masses, centres of mass and inertias.
        joints: limits of the motors.

    Raises:
        SpecError: a value is missing, of the wrong type, not finite, out of range, or contradicts
            another; the message names the field by its path, as "links.shin.mass".
    """

    name: str
    geometry: Geometry = field(metadata={"part": Geometry})
    links: Links = field(metadata={"part": Links})
    joints: Joints = field(metadata={"part": Joints})

    def __post_init__(self) -> None:
        _check_name(self.name)
        geometry = checked(self.geometry, Geometry, "geometry")
        _check_ankle(geometry)
        joints = checked(self.joints, Joints, "joints")
        for name, limits in joints.named():
            _check_range(limits, f"joints.{name}")
        object.__setattr__(self, "geometry", geometry)
        object.__setattr__(self, "links", _checked_links(self.links))
        object.__setattr__(self, "joints", joints)

    @property
    def total_mass(self) -> float:
        """Mass of the whole robot [kg]."""
        return self.links.torso.mass + 2.0 * sum(link.mass for link in self.links.leg)

    @property
    def standing_height(self) -> float:
        """Height of the torso's top above the ground with straight legs [m]."""
        torso = self.links.torso
        return self.geometry.hip_height + torso.com[2] + torso.size[2] / 2.0


def _check_name(name: object) -> None:
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise SpecError(
            f"name = {str(name)[:60]!r} is not allowed; allowed: a letter, then up to 63 letters, "
            "digits and the signs _ . -"
        )


def _check_ankle(geometry: Geometry) -> None:
    if not -geometry.foot_length <= geometry.l1 <= 0.0:
        raise SpecError(
            f"geometry.l1 = {geometry.l1:g} m puts the ankle off the sole; allowed: "
            f"{-geometry.foot_length:g} m (heel, minus geometry.foot_length) to 0 m (toe edge)"
        )


def _check_range(limits: JointLimits, path: str) -> None:
    if limits.lower >= limits.upper:
        raise SpecError(
            f"{path}.lower = {limits.lower:g} rad is not below {path}.upper = "
            f"{limits.upper:g} rad; give lower < upper"
        )


def _checked_links(links: Links) -> Links:
    links = checked(links, Links, "links")
    symmetric = {
        name: replace(link, inertia=checked_inertia(link.inertia, f"links.{name}.inertia"))
        for name, link in links.named()
        if link.inertia is not None
    }
    return replace(links, **symmetric)
