"""What a user may fix where gaitopt would otherwise find out for itself."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, fields, replace

from gaitopt.errors import RobotError
from gaitopt.robot.feet.sole import Sole

Axis = str | tuple[float, float, float]
Placement = tuple[float, ...]
CapsuleRow = tuple[int, str, float, float, float, float, float, float, float, str]
Posture = str | tuple[tuple[str, float], ...]

AXES: dict[str, tuple[float, float, float]] = {
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
    "-x": (-1.0, 0.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "-z": (0.0, 0.0, -1.0),
}
"""Names of the axes of the root link."""

UNEQUAL = ("refuse", "tighter", "right", "left")
"""What to do with limits that differ between the legs: refuse, the tighter ones, one leg's."""

SIDES = ("right", "left")

UNUSED_SRDF = (
    "an SRDF is given (srdf), but nothing of it is used; name one of its poses "
    '(--posture POSE, or posture = "POSE" in the file for --choices), ask for '
    "its rotors (rotors = true), or leave it out"
)


@dataclass(frozen=True)
class LimitOverride:
    """Limits of the joints whose name matches a pattern; None leaves what the URDF says.

    Attributes:
        joints: pattern of joint names as in a shell: `*knee*`, `left_hip_?`.
        torque: largest |torque| [N·m]; infinite for none.
        speed: largest |rate| [rad/s]; infinite for none.
        lower, upper: joint range [rad]; infinite for none.
        armature: inertia of rotor and gear seen from the joint [kg·m²].
    """

    joints: str
    torque: float | None = None
    speed: float | None = None
    lower: float | None = None
    upper: float | None = None
    armature: float | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.joints, str) or not self.joints:
            raise RobotError(f"limits: joints must be a pattern of names, got {self.joints!r}")
        for entry in fields(self)[1:]:
            value = getattr(self, entry.name)
            if value is not None:
                where = f"limits of '{self.joints}': {entry.name}"
                object.__setattr__(self, entry.name, _number(value, where))
        for name in ("torque", "speed"):
            if (value := getattr(self, name)) is not None and not value > 0.0:
                raise RobotError(f"limits of '{self.joints}': {name} is {value:g}; it must be > 0")
        if self.armature is not None and not 0.0 <= self.armature < math.inf:
            raise RobotError(
                f"limits of '{self.joints}': armature is {self.armature:g} kg·m²; it must be "
                "0 or more, and finite"
            )
        if self.lower is not None and self.upper is not None and not self.lower < self.upper:
            raise RobotError(
                f"limits of '{self.joints}': the range is from {self.lower:g} to {self.upper:g} "
                "rad; lower must be below upper"
            )


@dataclass(frozen=True)
class Choices:
    """How to read a robot; whatever is left None is found from its model.

    Attributes:
        feet: names of a link, joint or frame of the right and of the left foot.
        stance: which foot stands in the computed step, "right" or "left"; by default the one of
            `stance_sole`, else the right one.
        stance_sole, swing_sole: names of the sole frames of the standing and of the other foot
            (x forward, y left, z up, in the plane of the sole).
        forward, up: where the robot looks and where its head is: axes of the root link
            ("x", "-x", "y", ...), or three numbers along its x, y, z.
        posture: reference posture in which the robot stands with flat feet; the joints that are
            not the legs' stay in it. The name of a pose in the SRDF, or angles [rad] by joint
            (others 0). None is the neutral posture.
        srdf: path or text of the SRDF file.
        rotors: whether rotor inertias of the SRDF are used as armature.
        sole: rectangle of either sole in its sole frame.
        sole_drop: height of the ankle above the sole with flat feet [m].
        sole_placements: the sole frames of the right and of the left foot in the frame of the last
            joint of their legs, each as the rows of a 3 x 4 matrix [R p], 12 numbers [m].
        limits: what replaces limits of the URDF; where two patterns match, the later one counts.
        unequal_limits: one of `UNEQUAL`.
        asymmetry: largest relative difference between the robot and its mirror image that is
            averaged away, in mass, centre of mass (per radius of gyration) and inertia of a link.
        capsules: around the bodies of the legs, as an earlier reading found them in the shapes:
            body from 0 to 12, name, both ends [m] in the frame of its joint, radius [m], and what
            they cover.
        package_dirs: directories in which `package://` file names are looked up.
    """

    feet: tuple[str, str] | None = None
    stance: str | None = None
    stance_sole: str | None = None
    swing_sole: str | None = None
    forward: Axis | None = None
    up: Axis | None = None
    posture: Posture | None = None
    srdf: str | None = None
    rotors: bool = False
    sole: Sole | None = None
    sole_drop: float | None = None
    sole_placements: tuple[Placement, Placement] | None = None
    limits: tuple[LimitOverride, ...] = ()
    unequal_limits: str = "refuse"
    asymmetry: float = 0.08
    package_dirs: tuple[str, ...] = ()
    capsules: tuple[CapsuleRow, ...] | None = None

    def __post_init__(self) -> None:
        if isinstance(self.posture, Mapping):
            object.__setattr__(self, "posture", tuple(self.posture.items()))
        for name in ("feet", "limits", "package_dirs"):
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, _tuple(value, name))
        _check_names(self)
        for name in ("forward", "up"):
            object.__setattr__(self, name, _axis(getattr(self, name), name))
        _check_numbers(self)
        if self.capsules is not None:
            rows = tuple(_capsule(row) for row in _tuple(self.capsules, "capsules"))
            object.__setattr__(self, "capsules", rows)

    def over(self, **given: object) -> Choices:
        """Return a copy with the given fields in place of its own, those that are None left out."""
        return replace(self, **{k: v for k, v in given.items() if v is not None})  # type: ignore[arg-type]


def _check_names(choices: Choices) -> None:
    if choices.feet is not None and len(choices.feet) != 2:
        raise RobotError(
            f"feet must be two names, right foot first, got {len(choices.feet)}: "
            f"{', '.join(map(str, choices.feet))}"
        )
    _check_one_of("stance", choices.stance, (None, *SIDES))
    _check_one_of("unequal_limits", choices.unequal_limits, UNEQUAL)
    if not isinstance(choices.rotors, bool):
        raise RobotError(f"rotors must be true or false, got {choices.rotors!r}")
    for name in ("stance_sole", "swing_sole", "srdf"):
        value = getattr(choices, name)
        if value is not None and not isinstance(value, str):
            raise RobotError(f"{name} must be text, got {value!r}")


def _check_one_of(name: str, value: object, allowed: Collection[str | None]) -> None:
    if value not in allowed:
        names = ", ".join(f"'{a}'" for a in allowed if a is not None)
        raise RobotError(f"{name} is {value!r}; it must be one of {names}")


def _check_numbers(choices: Choices) -> None:
    if isinstance(choices.posture, tuple):
        angles = tuple((str(n), _finite(a, f"posture of '{n}'")) for n, a in choices.posture)
        object.__setattr__(choices, "posture", angles)
    if choices.sole_drop is not None and not 0.0 < _finite(choices.sole_drop, "sole_drop") < 1.0:
        raise RobotError(
            f"sole_drop is {choices.sole_drop:g} m; it must be above 0 and below 1: the height of "
            "the ankle above the sole"
        )
    if not 0.0 <= _finite(choices.asymmetry, "asymmetry") <= 1.0:
        raise RobotError(f"asymmetry is {choices.asymmetry:g}; it must be from 0 to 1 (relative)")
    if choices.sole_placements is not None:
        rows = tuple(
            tuple(_finite(n, "sole_placements") for n in _tuple(p, "sole_placements"))
            for p in _tuple(choices.sole_placements, "sole_placements")
        )
        if [len(p) for p in rows] != [12, 12]:
            raise RobotError("sole_placements must be 2 lists of 12 numbers, the rows of [R p]")
        object.__setattr__(choices, "sole_placements", rows)


def _capsule(row: object) -> tuple[object, ...]:
    values = _tuple(row, "capsules")
    if len(values) != 10 or values[0] not in range(13):
        raise RobotError(
            f"capsules: {list(values)} is not one; give body (0 to 12), name, two ends and a "
            "radius [m], and what it covers"
        )
    numbers = (_finite(n, f"capsules of '{values[1]}'") for n in values[2:9])
    return (values[0], str(values[1]), *numbers, str(values[9]))


def _axis(value: object, name: str) -> Axis | None:
    if value is None:
        return None
    if isinstance(value, str):
        _check_one_of(name, value.removeprefix("+"), AXES)
        return value.removeprefix("+")
    numbers = [_finite(n, name) for n in _tuple(value, name)]
    size = math.hypot(*numbers)
    if len(numbers) != 3 or not size > 0.0:
        raise RobotError(f"{name} must be an axis name or three numbers, not all 0; got {value!r}")
    x, y, z = numbers
    # A vector of length 1 comes back as it was, to the last digit.
    return (x, y, z) if abs(size - 1.0) < 1e-12 else (x / size, y / size, z / size)


def _tuple(value: object, name: str) -> tuple[object, ...]:
    if isinstance(value, (str, Mapping)) or not isinstance(value, Iterable):
        raise RobotError(f"{name} must be a list, got {value!r}")
    return tuple(value)


def _number(value: object, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or math.isnan(value):
        raise RobotError(f"{name} must be a number, got {value!r}")
    return float(value)


def _finite(value: object, name: str) -> float:
    number = _number(value, name)
    if not math.isfinite(number):
        raise RobotError(f"{name} is {number}; it must be finite")
    return number
