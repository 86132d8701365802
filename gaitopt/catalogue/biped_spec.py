"""What a thirteen-link biped is made of: lengths, masses, inertias and motor limits, in SI units.

Frames: x forward, y left, z up, parallel to the world at the zero posture (straight legs). Values
are those of the left leg, seen from the pelvis down; the right leg is its mirror image in y = 0.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import Field, field, fields, is_dataclass, replace
from functools import partial
from numbers import Real
from typing import Any, TypeVar

import numpy as np

from gaitopt.bounds import shown
from gaitopt.dataclass import dataclass
from gaitopt.errors import SpecError
from gaitopt.settings import checked
from gaitopt.units import in_si

Vector3 = tuple[float, float, float]
Matrix3 = tuple[Vector3, Vector3, Vector3]
Part = TypeVar("Part")

ROUNDING = 1e-9
"""Relative slack for matrices typed from a drawing: symmetry and the flat-plate limit."""


@dataclass(frozen=True)
class Allowed:
    """What a field may hold.

    Attributes:
        unit: SI unit of the number.
        low, high: smallest and largest number accepted, inclusive.
        shape: () for a number, (3,) for a vector along x, y, z, (3, 3) for a matrix.
        optional: whether None is accepted.
    """

    unit: str
    low: float
    high: float
    shape: tuple[int, ...] = ()
    optional: bool = False

    def __str__(self) -> str:
        """Return the range in words."""
        return f"{self.low:g} to {self.high:g} {self.unit}"

    @property
    def metadata(self) -> dict[str, Allowed]:
        """What to hand to `dataclasses.field`."""
        return {"allowed": self}


def allowed_of(entry: Field[Any]) -> Allowed | None:
    """Return what a dataclass field may hold, None if it is a part or a name."""
    found: Allowed | None = entry.metadata.get("allowed")
    return found


_LENGTH = Allowed("m", 1e-4, 10.0).metadata
_OFFSET = Allowed("m", -10.0, 10.0).metadata
_EDGES = Allowed("m", 1e-4, 10.0, shape=(3,)).metadata
_PLACE = Allowed("m", -10.0, 10.0, shape=(3,)).metadata
_MASS = Allowed("kg", 1e-4, 1e4).metadata
_INERTIA = Allowed("kg·m²", -1e6, 1e6, shape=(3, 3), optional=True).metadata
_TORQUE = Allowed("N·m", 1e-3, 1e5).metadata
_SPEED = Allowed("rad/s", 1e-3, 1e3).metadata
_ANGLE = Allowed("rad", -2.0 * math.pi, 2.0 * math.pi).metadata
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.-]{0,63}")


def box_inertia(mass: float, size: Vector3) -> Matrix3:
    """Return the inertia [kg·m²] of an even box of a mass [kg] and edges [m], axes along these."""
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


_named = partial(checked, kinds=False)  # values are checked with their ranges, all at once


@_named
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
        foot_length: of the sole, forward (Lp) [m].
        foot_width: of the sole, sideways (lp) [m].
    """

    l1: float = field(metadata=_OFFSET)
    d1: float = field(metadata=_LENGTH)
    d3: float = field(metadata=_LENGTH)
    d4: float = field(metadata=_LENGTH)
    l4: float = field(metadata=_OFFSET)
    d7: float = field(metadata=_LENGTH)
    foot_length: float = field(metadata=_LENGTH)
    foot_width: float = field(metadata=_LENGTH)

    @property
    def hip_height(self) -> float:
        """Height of the hip centres above the sole with straight legs [m]."""
        return self.d1 + self.d3 + self.d4


@_named
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

    mass: float = field(metadata=_MASS)
    size: Vector3 = field(metadata=_EDGES)
    com: Vector3 = field(metadata=_PLACE)
    inertia: Matrix3 | None = field(default=None, metadata=_INERTIA)

    @property
    def com_inertia(self) -> Matrix3:
        """Inertia about the centre of mass, given or of the homogeneous box [kg·m²]."""
        return box_inertia(self.mass, self.size) if self.inertia is None else self.inertia


_LINK = {"part": LinkSpec}


@_named
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


@_named
@dataclass(frozen=True)
class JointSpec:
    """One joint of a leg: what its motor can do, and how far it turns.

    Attributes:
        torque: largest absolute torque [N·m].
        speed: largest absolute rate [rad/s].
        lower, upper: range of the left joint [rad]; the right one mirrors roll and yaw.
    """

    torque: float = field(metadata=_TORQUE)
    speed: float = field(metadata=_SPEED)
    lower: float = field(metadata=_ANGLE)
    upper: float = field(metadata=_ANGLE)


_JOINT = {"part": JointSpec}


@_named
@dataclass(frozen=True)
class Joints:
    """The six joints of a leg, from hip to foot: yaw about z, roll about x, pitch about y.

    Attributes:
        hip_yaw, hip_roll, hip_pitch, knee, ankle_pitch, ankle_roll: their limits.
    """

    hip_yaw: JointSpec = field(metadata=_JOINT)
    hip_roll: JointSpec = field(metadata=_JOINT)
    hip_pitch: JointSpec = field(metadata=_JOINT)
    knee: JointSpec = field(metadata=_JOINT)
    ankle_pitch: JointSpec = field(metadata=_JOINT)
    ankle_roll: JointSpec = field(metadata=_JOINT)

    def named(self) -> Iterator[tuple[str, JointSpec]]:
        """Yield the name and the limits, from hip to foot."""
        return ((entry.name, getattr(self, entry.name)) for entry in fields(self))


@_named
@dataclass(frozen=True)
class BipedSpec:
    """A thirteen-link biped, checked when made; change one with `parameters.changed`.

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
        if not isinstance(self.name, str) or not _NAME.fullmatch(self.name):
            raise SpecError(
                f"name = {str(self.name)[:60]!r} is not allowed; allowed: a letter, then up to 63 "
                "letters, digits and the signs _ . -"
            )
        geometry = _checked(self.geometry, Geometry, "geometry")
        if not -geometry.foot_length <= geometry.l1 <= 0.0:
            raise SpecError(
                f"geometry.l1 = {geometry.l1:g} m puts the ankle off the sole; allowed: "
                f"{-geometry.foot_length:g} m (heel, minus geometry.foot_length) to 0 m (toe edge)"
            )
        joints = _checked(self.joints, Joints, "joints")
        for name, limits in joints.named():
            if limits.lower >= limits.upper:
                raise SpecError(
                    f"joints.{name}.lower = {limits.lower:g} rad is not below joints.{name}.upper "
                    f"= {limits.upper:g} rad; give lower < upper"
                )
        links = _checked(self.links, Links, "links")
        inertias = {
            name: replace(link, inertia=checked_inertia(link.inertia, f"links.{name}.inertia"))
            for name, link in links.named()
            if link.inertia is not None
        }
        object.__setattr__(self, "geometry", geometry)
        object.__setattr__(self, "links", replace(links, **inertias))
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


def _checked(part: Part, expected: type[Part], path: str) -> Part:
    """Return a dataclass with every number below it checked and made a float."""
    if not isinstance(part, expected) or not is_dataclass(part):
        raise SpecError(
            f"{path} must be a {expected.__name__}, got {shown(part)}; build one from its fields"
        )
    changes: dict[str, Any] = {}
    for entry in fields(part):
        value, where = getattr(part, entry.name), f"{path}.{entry.name}"
        if (allowed := allowed_of(entry)) is None:
            changes[entry.name] = _checked(value, entry.metadata["part"], where)
        elif value is None and allowed.optional:
            changes[entry.name] = None
        else:
            changes[entry.name] = _checked_array(value, allowed, allowed.shape, where)
    return expected(**changes)


def _checked_array(value: object, allowed: Allowed, shape: tuple[int, ...], path: str) -> Any:
    """Return tuples of floats of a shape."""
    if not shape:
        return _checked_number(value, allowed, path)
    listed = isinstance(value, Sequence) and not isinstance(value, str | bytes)
    rows: Any = value if listed or (isinstance(value, np.ndarray) and value.ndim) else ()
    if len(rows) != shape[0]:
        raise SpecError(
            f"{path} must be a list of {' x '.join(map(str, shape))} numbers in {allowed.unit}, "
            f"got {shown(value)}; give them in the order x, y, z"
        )
    return tuple(
        _checked_array(row, allowed, shape[1:], f"{path}[{i}]") for i, row in enumerate(rows)
    )


def _checked_number(value: object, allowed: Allowed, path: str) -> float:
    value = in_si(value, allowed.unit)
    if isinstance(value, bool) or not isinstance(value, Real):
        raise SpecError(
            f"{path} must be a number in {allowed.unit}, got {shown(value)}; allowed: {allowed}"
        )
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number) or not allowed.low <= number <= allowed.high:
        raise SpecError(
            f"{path} = {number:g} {allowed.unit} is not allowed; allowed: {allowed}; "
            "check the value and its unit"
        )
    return number + 0.0  # -0.0 becomes 0.0: one number, one spelling


def checked_inertia(inertia: Matrix3, path: str) -> Matrix3:
    """Return an inertia [kg·m²] made exactly symmetric, after checking that a body can have it.

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


def biped13() -> BipedSpec:
    """Return the thirteen-link biped of the paper's Tables 1 and 2: 56.87 kg, 1.30 m tall.

    Lengths, masses and sole size are the paper's. It leaves open the inertias (here homogeneous
    boxes), l1 and l4, how the 2.04 kg of a hip divide over its two links (here equally), and the
    limits of the motors (here 150 N·m and 10 rad/s, and ranges wider than a walk needs).
    """
    return BipedSpec(
        name="biped13",
        geometry=Geometry(
            l1=-0.137, d1=0.105, d3=0.3, d4=0.3, l4=0.0, d7=0.12, foot_length=0.214,
            foot_width=0.136,
        ),
        links=_links(),
        joints=_joints(),
    )  # fmt: skip


def _links() -> Links:
    hip = LinkSpec(mass=1.02, size=(0.08, 0.08, 0.08), com=(0.0, 0.0, 0.0))
    return Links(
        torso=LinkSpec(mass=40.55, size=(0.2, 0.3, 0.595), com=(0.0, 0.0, 0.2975)),
        hip_yaw=hip,
        hip_roll=hip,
        thigh=LinkSpec(mass=2.08, size=(0.1, 0.1, 0.3), com=(0.0, 0.0, -0.15)),
        shin=LinkSpec(mass=1.75, size=(0.08, 0.08, 0.3), com=(0.0, 0.0, -0.15)),
        ankle=LinkSpec(mass=0.65, size=(0.06, 0.06, 0.06), com=(0.0, 0.0, 0.0)),
        foot=LinkSpec(mass=1.64, size=(0.214, 0.136, 0.04), com=(0.03, 0.0, -0.085)),
    )


def _joints() -> Joints:
    def limits(lower: float, upper: float) -> JointSpec:
        return JointSpec(torque=150.0, speed=10.0, lower=lower, upper=upper)

    return Joints(
        hip_yaw=limits(-1.0, 1.0),
        hip_roll=limits(-0.8, 0.8),
        hip_pitch=limits(-2.2, 1.2),
        knee=limits(0.0, 2.6),
        ankle_pitch=limits(-2.2, 1.2),
        ankle_roll=limits(-1.5, 1.5),
    )
