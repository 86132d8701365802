"""Motors that turn joints through rods or in common: `linkages.toml`, and their Jacobian.

Parallel ankles have two motors, each of which moves pitch and roll. With the rates of the motors
J(q) times those of the joints, the torques of the joints are J' times those of the motors. J is
constant, as of cables and differentials, or follows from the geometry of cranks and rods:

    |p(q) - c(theta)| = length

with p the end of the rod on the link beyond the joints, and c the end of the crank. Angle of the
crank and its derivatives up to the third, of which J and its first two are, are exact: truncated
power series in the angles of the joints. Loops of other shapes are followed by `model.linkage`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.errors import SpecError
from gaitopt.importers.text_files import check_keys, parse_toml, read_text
from gaitopt.model.linkage import (
    MOST_JOINTS,
    Linkage,
    LoopClosure,
    Rod,
    Series,
    dot,
    motor_series,
    turned_about,
)
from gaitopt.nlp import Array
from gaitopt.settings import checked_arguments
from gaitopt.units import read_quantity

_LARGEST = 1e6
"""Of lengths, limits and entries of a Jacobian."""
_UNITS = {"torque": "N·m", "speed": "rad/s", "power": "W"}
_LIMITS = (*_UNITS, "range")
_FIELDS = len(Linkage._fields) - 1  # of a table
_POINTS = ("crank_centre", "crank_axis", "crank_end", "rod_end")
DEAD = 0.98
"""Cosine from which on a crank is at its dead point, where its rod turns it no more: 11 degrees."""
_FLAT = 1e-6  # m, and sine of angles: what is shorter has no direction


@checked_arguments
def read_linkages(path: str | Path) -> tuple[Linkage, ...]:
    """Read `linkages.toml`: [[linkages]] entries with joints, and [[linkages.motors]] in each.

    Raises:
        SpecError: it cannot be used; the message says what is wrong and what is allowed.
        RobotError: it cannot be read.
    """
    return linkages_of(read_text(Path(path), "table of linkages"), str(path))


def linkages_of(text: str, where: str = "table of linkages") -> tuple[Linkage, ...]:
    """Return the linkages of a TOML text.

    Raises:
        SpecError: the text is no TOML, or a value in it is wrong.
    """
    table = parse_toml(text, where, kind=SpecError)
    check_keys(where, table, ("linkages",), SpecError)
    entries = table.get("linkages", [])
    if not isinstance(entries, list) or not entries:
        raise SpecError(
            f"{where}: there are no linkages; say which motors turn which joints, as in\n"
            '[[linkages]]\njoints = ["left_ankle_pitch", "left_ankle_roll"]\n'
            '[[linkages.motors]]\nname = "inner"\nrates = [1.0, 0.5]\ntorque = "40Nm"\n'
            '[[linkages.motors]]\nname = "outer"\nrates = [1.0, -0.5]\ntorque = "40Nm"'
        )
    return tuple(_linkage(f"{where}: linkage {k + 1}", one) for k, one in enumerate(entries))


def linkages_from_rows(rows: object) -> tuple[Linkage, ...]:
    """Return linkages from rows of plain values, as a gait file keeps them.

    Raises:
        SpecError: a row is none, or a number of it is out of range.
    """
    if not isinstance(rows, list | tuple):
        raise SpecError(f"linkages must be rows of {', '.join(Linkage._fields)}")
    return tuple(_from_row(f"linkage {k + 1}", row) for k, row in enumerate(rows))


def _from_row(where: str, row: object) -> Linkage:
    fields = ", ".join(Linkage._fields[:_FIELDS])
    if isinstance(row, list | tuple) and len(row) > _FIELDS and row[_FIELDS] is None:
        row = row[:_FIELDS]
    if not isinstance(row, list | tuple) or len(row) not in (_FIELDS - 1, _FIELDS):
        raise SpecError(f"{where} must be a row of {fields}")
    if not all(isinstance(part, list | tuple) for part in row):
        raise SpecError(f"{where} must have lists of {fields}")
    joints, motors, jacobian, rods, *limits = row
    try:
        entries = [
            {
                "name": name,
                **({"rates": list(jacobian[k])} if jacobian else {}),
                **(dict(zip(_POINTS, map(list, rods[k]), strict=True)) if rods else {}),
                **{
                    key: values[k]
                    for key, values in zip(_LIMITS, limits, strict=False)  # old rows: no range
                    if values[k] is not None
                },
            }
            for k, name in enumerate(motors)
        ]
    except (IndexError, TypeError, ValueError):
        raise SpecError(f"{where}: its lists are not of the same length") from None
    return _linkage(where, {"joints": list(joints), "motors": entries})


def _linkage(where: str, entry: object) -> Linkage:
    if not isinstance(entry, Mapping):
        raise SpecError(f"{where}: give a table with joints and motors")
    check_keys(where, entry, ("joints", "motors"), SpecError)
    joints, motors = entry.get("joints"), entry.get("motors")
    if (
        not isinstance(joints, list)
        or not all(isinstance(name, str) and name for name in joints)
        or not 1 <= len(set(joints)) == len(joints) <= MOST_JOINTS
    ):
        raise SpecError(
            f"{where}: joints must be a list of one or two names of joints of one leg, from the "
            'pelvis on, as in joints = ["left_ankle_pitch", "left_ankle_roll"]'
        )
    where = f"{where} of {' and '.join(map(repr, joints))}"
    if not isinstance(motors, list) or len(motors) != len(joints):
        raise SpecError(f"{where}: give as many [[linkages.motors]] as joints, {len(joints)}")
    for motor in motors:
        if not isinstance(motor, Mapping):
            raise SpecError(f"{where}: a motor must be a table")
        check_keys(where, motor, ("name", "rates", *_POINTS, *_LIMITS), SpecError)
    names = [motor.get("name") for motor in motors]
    if not all(isinstance(name, str) and name for name in names) or len({*names}) < len(names):
        raise SpecError(f"{where}: give every motor a name of its own")
    kinds = {("rates" in motor, any(key in motor for key in _POINTS)) for motor in motors}
    if kinds not in ({(True, False)}, {(False, True)}):
        raise SpecError(
            f"{where}: give every motor either rates, per unit rate of each joint, or "
            f"{', '.join(_POINTS)}"
        )
    limits: dict[str, Any] = {
        key: tuple(_limit(where, motor, key) for motor in motors) for key in _UNITS
    }
    limits["range"] = tuple(_range(where, motor) for motor in motors)
    if not any(value is not None for values in limits.values() for value in values):
        raise SpecError(f"{where}: give the motors limits: {', '.join(_LIMITS)}")
    jacobian: tuple[tuple[float, ...], ...] = ()
    rods: tuple[Rod, ...] = ()
    if kinds == {(True, False)}:
        jacobian = tuple(
            _vector(f"{where}: rates of '{m['name']}'", m["rates"], len(joints)) for m in motors
        )
        _check_invertible(where, np.array(jacobian))
    else:
        rods = tuple(_rod(f"{where}: motor '{motor['name']}'", motor) for motor in motors)
    return Linkage(tuple(joints), tuple(map(str, names)), jacobian, rods, **limits)


def _check_invertible(where: str, jacobian: Array) -> None:
    sizes = np.linalg.norm(jacobian, axis=1)
    if not sizes.all() or abs(np.linalg.det(jacobian / sizes[:, None])) < _FLAT:
        raise SpecError(
            f"{where}: the motors move the joints in one way only; correct the rates, so that each "
            "motor does something of its own"
        )


def _limit(where: str, motor: Mapping[str, Any], key: str) -> float | None:
    if key not in motor:
        return None
    try:
        value = read_quantity(motor[key], _UNITS[key])
    except ValueError as error:
        raise SpecError(f"{where}: {key} = {str(motor[key])[:60]!r} is wrong; {error}") from None
    if not 1.0 / _LARGEST <= value <= _LARGEST:
        raise SpecError(
            f"{where}: {key} is {value:g} {_UNITS[key]}; it must be from {1.0 / _LARGEST:g} to "
            f"{_LARGEST:g}"
        )
    return value


def _range(where: str, motor: Mapping[str, Any]) -> tuple[float, float] | None:
    if "range" not in motor:
        return None
    given = motor["range"]
    where = f"{where}: range of '{motor['name']}'"
    low, high = _vector(where, list(given) if isinstance(given, tuple) else given, 2, "rad")
    if not low < 0.0 < high:
        raise SpecError(
            f"{where} is from {low:g} to {high:g} rad; it must hold 0, at which the motor is where "
            "all joints are at 0"
        )
    return low, high


def _vector(where: str, value: object, count: int, unit: str = "") -> tuple[float, ...]:
    if not isinstance(value, list) or len(value) != count:
        raise SpecError(f"{where} must be a list of {count} numbers")
    try:
        found = tuple(read_quantity(one, unit) for one in value)
    except ValueError as error:
        raise SpecError(f"{where}: {str(value)[:60]!r} is wrong; {error}") from None
    if not all(math.isfinite(one) and abs(one) <= _LARGEST for one in found):
        raise SpecError(f"{where}: numbers must be finite, at most {_LARGEST:g} in size")
    return found


def _rod(where: str, motor: Mapping[str, Any]) -> Rod:
    if missing := [key for key in _POINTS if key not in motor]:
        verb = "is" if len(missing) == 1 else "are"
        raise SpecError(f"{where}: {', '.join(missing)} {verb} missing")
    points = [
        _vector(f"{where}: {key}", motor[key], 3, "" if key == "crank_axis" else "m")
        for key in _POINTS
    ]
    rod = Rod(*((x, y, z) for x, y, z in points))
    axis = np.array(rod.crank_axis)
    crank = np.subtract(rod.crank_end, rod.crank_centre)
    if np.linalg.norm(axis) < _FLAT:
        raise SpecError(f"{where}: crank_axis has no direction; give one, as in [0, 1, 0]")
    if np.linalg.norm(np.cross(axis / np.linalg.norm(axis), crank)) < _FLAT:
        raise SpecError(f"{where}: crank_end lies on the motor's axis; the crank has no length")
    if np.linalg.norm(np.subtract(rod.rod_end, rod.crank_end)) < _FLAT:
        raise SpecError(f"{where}: rod_end is at crank_end; the rod has no length")
    return rod


@dataclass(frozen=True)
class JointPair:
    """One or two joints in a row, as rods see them.

    Attributes:
        placement: of each joint in the frame of the body before it, shape (m, 4, 4).
        axis: in the frame of the joint, of unit length, shape (m, 3).
    """

    placement: Array
    axis: Array


@dataclass(frozen=True)
class Reach:
    """How near the rods of m motors are to their dead points, at K postures.

    Attributes:
        cosine: of the angle between crank and rod's end as seen from the motor's axis, (K, m); of
            loops of other shapes, where the joints are in their range, `DEAD` at its ends.
        first: its derivative in the angles of the joints, shape (K, m, m).
        second: and the next, shape (K, m, m, m).
    """

    cosine: Array
    first: Array
    second: Array


@dataclass(frozen=True)
class MotorAngles:
    """The motors of a linkage at K postures of its m joints.

    Attributes:
        jacobian: J, rates of motors per rate of joints, shape (K, m, m).
        first: its derivative in the angles, the last axis, shape (K, m, m, m).
        second: and the next, shape (K, m, m, m, m).
        angle: of the motors [rad], shape (K, m); 0 where all joints are at 0.
        reach: of the rods.
    """

    jacobian: Array
    first: Array
    second: Array
    angle: Array
    reach: Reach


def motor_angles(linkage: Linkage, joints: JointPair, q: Array) -> MotorAngles:
    """Return angles of motors and derivatives at postures (K, m) [rad]; joints matter to rods.

    Where a rod is beyond its dead point, or does not reach, its angle goes on evenly: a search may
    pass there, a walk may not.
    """
    count, m = q.shape
    if linkage.jacobian:
        J = np.array(linkage.jacobian)
        none = [np.zeros((count, *(m,) * order)) for order in range(5)]
        constant = np.broadcast_to(J, (count, m, m))
        return MotorAngles(constant, none[3], none[4], q @ J.T, Reach(*none[1:4]))
    each = [_crank_angle(rod, joints, q) for rod in linkage.rods]
    if (closure := linkage.closure) is not None:
        each = list(zip(motor_series(closure, q), _shares(closure, q), strict=True))
    angle, jacobian, first, second = (
        np.stack([theta.derivatives(order, m) for theta, _ in each], axis=1) for order in range(4)
    )
    cosines = (
        np.stack([cosine.derivatives(order, m) for _, cosine in each], axis=1) for order in range(3)
    )
    return MotorAngles(jacobian, first, second, angle, Reach(*cosines))


def check_linkage(linkage: Linkage, joints: JointPair) -> None:
    """Check that motors can hold the joints where these are at 0, as the points are given.

    Raises:
        SpecError: a rod is at its dead point, or the motors move the joints in one way only.
    """
    where = f"linkage of {' and '.join(map(repr, linkage.joints))}"
    found = motor_angles(linkage, joints, np.zeros((1, len(linkage.joints))))
    near = np.abs(found.reach.cosine)
    if linkage.rods and near.max() >= DEAD:
        motor = linkage.motors[int(near.argmax())]
        raise SpecError(
            f"{where}: the rod of motor '{motor}' is at its dead point where the joints are at 0: "
            "crank and rod are in line; correct the points"
        )
    _check_invertible(where, found.jacobian[0])


def _shares(closure: LoopClosure, q: Array) -> list[Series]:
    """Return where in their range the joints of the leg are, `DEAD` at its ends."""
    found = []
    for k, (low, high) in enumerate(zip(closure.lower, closure.upper, strict=True)):
        x = Series.variable(k, q[:, k]) + -(low + high) / 2.0
        found.append(x * (2.0 * DEAD / (high - low)))
    return found


def _crank_angle(rod: Rod, joints: JointPair, q: Array) -> tuple[Series, Series]:
    """Return the angle of a motor, 0 where all joints are at 0, and the cosine of `Reach`."""
    # With d from the motor's axis to the rod's end, A and B along the crank at 0 and across, the
    # closure is A cos(theta) + B sin(theta) = C, so that theta = atan2(B, A) -+ acos(C / |A, B|).
    centre, end = np.array(rod.crank_centre), np.array(rod.crank_end)
    axis = np.array(rod.crank_axis) / np.linalg.norm(rod.crank_axis)
    centre = centre + axis * (axis @ (end - centre))
    crank = end - centre
    radius, length = np.linalg.norm(crank), np.linalg.norm(np.subtract(rod.rod_end, end))
    u, w = crank / radius, np.cross(axis, crank / radius)
    at_zero = np.array(rod.rod_end) - centre
    away = np.arctan2(at_zero @ w, at_zero @ u)
    point = [x + -float(c) for x, c in zip(_rod_end(rod, joints, q), centre, strict=True)]
    A, B = (dot(point, direction * radius) for direction in (u, w))
    squared = point[0] * point[0] + point[1] * point[1] + point[2] * point[2]
    C = (squared + float(radius**2 - length**2)) * 0.5
    size = A * A + B * B
    r = size.value
    cosine = C * size.through(r**-0.5, -0.5 * r**-1.5, 0.75 * r**-2.5, -1.875 * r**-3.5)
    x = cosine.value
    near = np.clip(x, -DEAD, DEAD)
    s, inside = 1.0 - near**2, np.where(np.abs(x) < DEAD, 1.0, 0.0)
    bent = cosine.through(
        np.arccos(near) - (x - near) * s**-0.5,
        -(s**-0.5),
        -inside * near * s**-1.5,
        -inside * (1.0 + 2.0 * near**2) * s**-2.5,
    )
    # Turned to the current direction, across is 0 and its arc tangent begins t - t³ / 3.
    phi = np.arctan2(B.value, A.value)
    cos, sin = Series.constant(np.cos(phi)), Series.constant(np.sin(phi))
    along, across = A * cos + B * sin, B * cos + A * sin * -1.0
    tangent = across * along.through(
        1.0 / along.value, -(along.value**-2), 2.0 * along.value**-3, -6.0 * along.value**-4
    )
    zero, one = np.zeros(len(q)), np.ones(len(q))
    turned = tangent.through(zero, one, zero, -2.0 * one) + Series.constant(phi)
    theta = turned + bent * (-1.0 if away > 0.0 else 1.0)
    theta.terms[0] = np.remainder(theta.value + np.pi, 2.0 * np.pi) - np.pi
    return theta, cosine


def _rod_end(rod: Rod, joints: JointPair, q: Array) -> list[Series]:
    """Return the end of the rod in the frame of the body before the joints."""
    point = np.append(rod.rod_end, 1.0)
    for placement in joints.placement:
        point = np.linalg.solve(placement, point)
    found = [Series.constant(np.full(len(q), x)) for x in point[:3]]
    for k in range(q.shape[1] - 1, -1, -1):
        found = turned_about(found, joints.axis[k], Series.variable(k, q[:, k]))
        R, origin = joints.placement[k][:3, :3], joints.placement[k][:3, 3]
        found = [dot(found, row) + float(x) for row, x in zip(R, origin, strict=True)]
    return found
