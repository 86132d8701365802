"""What a user may fix about a robot where gaitopt would otherwise find out for itself.

In Python, as a TOML file, and as a table of plain values that gait files keep.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sized
from dataclasses import fields, is_dataclass, replace
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path, PurePath
from typing import Any

from gaitopt.bounds import ARMATURE
from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError, did_you_mean
from gaitopt.importers.physics import PARTS
from gaitopt.importers.text_files import parse_toml, read_text
from gaitopt.model.sole import Sole
from gaitopt.settings import NO_LIMIT, checked, checked_arguments
from gaitopt.units import motion_words, read_motion, read_quantity

Axis = str | tuple[float, float, float]
Placement = tuple[float, ...]
CapsuleRow = tuple[int, str, float, float, float, float, float, float, float, str]
ReferencePosture = str | tuple[tuple[str, float], ...]

AXES: dict[str, tuple[float, float, float]] = {
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
    "-x": (-1.0, 0.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "-z": (0.0, 0.0, -1.0),
}
"""Names of the axes of the root link."""

_AXIS = f"{{}} must be an axis name ({', '.join(AXES)}) or three numbers, not all 0; got {{!r}}"

UNEQUAL = ("refuse", "tighter", "right", "left")
"""What to do with limits that differ between the legs: refuse, the tighter ones, one leg's."""

SIDES = ("right", "left")

LIMIT_UNITS = {
    "torque": "N·m", "speed": "rad/s", "lower": "rad", "upper": "rad", "armature": "kg·m²",
}  # fmt: skip
"""What a `LimitOverride` can replace, and its unit where the joint turns."""

LEAST_GRAVITY, MOST_GRAVITY = 0.01, 1000.0
"""Of free fall [m/s²]: what walks must be pressed on the ground; the Sun's has 274."""
GRAVITY_WORDS = (
    f"a walk needs at least {LEAST_GRAVITY:g} m/s² to press the feet on the ground, and more than "
    f"{MOST_GRAVITY:g} m/s² is nowhere"
)

UNUSED_SRDF = (
    "an SRDF is given (srdf), but nothing of it is used; name one of its poses "
    '(--posture POSE, or posture = "POSE" in the file for --choices), ask for '
    "its rotors (rotors = true), or leave it out"
)


@checked
@dataclass(frozen=True)
class LimitOverride:
    """Limits of the joints whose name matches a pattern; None leaves what the URDF says.

    Attributes:
        joints: pattern of joint names as in a shell, `*knee*`, `left_hip_?`, or a word in them.
        torque: largest |torque| [N·m; N]; infinite for none.
        speed: largest |rate| [rad/s; m/s]; infinite for none.
        lower, upper: joint range [rad; m]; infinite for none.
        armature: inertia of rotor and gear seen from the joint [kg·m²; kg].
        source: where the numbers are from, for people.
        units: SI units that numbers were given with, which must be those of the joints.

    Raises:
        RobotError: the limits are no numbers, or out of range.
    """

    joints: str
    torque: float | None = None
    speed: float | None = None
    lower: float | None = None
    upper: float | None = None
    armature: float | None = None
    source: str = ""
    units: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "units", tuple(map(str, _tuple(self.units, "limits: units"))))
        if not isinstance(self.joints, str) or not self.joints:
            raise RobotError(f"limits: joints must be a pattern of names, got {self.joints!r}")
        if not isinstance(self.source, str):
            raise RobotError(f"limits of '{self.joints}': source must be text, got {self.source!r}")
        for name, value in self.numbers().items():
            where = f"limits of '{self.joints}': {name}"
            object.__setattr__(self, name, _number(value, where))
        linear = {motion_words(unit, slides=True) for unit in LIMIT_UNITS.values()}
        words = partial(motion_words, slides=not linear.isdisjoint(self.units))
        for name, never in (("lower", math.inf), ("upper", -math.inf)):
            if (value := getattr(self, name)) == never:
                raise RobotError(
                    f"limits of '{self.joints}': {name} is {value:g} {words('rad')}, which no "
                    f'joint can keep; give a finite {words("angle [rad]")}, or "none" '
                    f"({-never:g} in Python) for no limit"
                )
        for name in ("torque", "speed"):
            if (value := getattr(self, name)) is not None and not value > 0.0:
                raise RobotError(f"limits of '{self.joints}': {name} is {value:g}; it must be > 0")
        if self.armature is not None and not 0.0 <= self.armature <= ARMATURE:
            unit = words(LIMIT_UNITS["armature"])
            raise RobotError(
                f"limits of '{self.joints}': armature is {self.armature:g} {unit}; it must be "
                f"from 0 to {ARMATURE:g} {unit}"
            )
        if self.lower is not None and self.upper is not None and not self.lower < self.upper:
            raise RobotError(
                f"limits of '{self.joints}': the range is from {self.lower:g} to {self.upper:g} "
                f"{words('rad')}; lower must be below upper"
            )

    def numbers(self) -> dict[str, float]:
        """Return what is replaced, by name."""
        values = {name: getattr(self, name) for name in LIMIT_UNITS}
        return {name: value for name, value in values.items() if value is not None}


def read_limit(name: str, text: str) -> tuple[float, str]:
    """Return a number of a `LimitOverride` and the SI unit it has, "" for none.

    Raises:
        ValueError: it is none; the message says what to give.
    """
    if text == NO_LIMIT and name != "armature":
        return -math.inf if name == "lower" else math.inf, ""
    return read_motion(text, LIMIT_UNITS[name])


def matching(pattern: str, names: Iterable[str]) -> list[str]:
    """Return the joints that a pattern of `LimitOverride` means.

    A pattern without *, ? and [ that is no name means every joint whose name has it in it.
    """
    known = list(names)
    found = [name for name in known if fnmatchcase(name, pattern)]
    if found or any(sign in pattern for sign in "*?["):
        return found
    return [name for name in known if pattern in name]


@checked
@dataclass(frozen=True)
class InertiaOverride:
    """The body of the links whose name matches a pattern; None leaves what the file says.

    Attributes:
        links: pattern of link names as in a shell: `*foot*`, `left_shin`.
        mass: [kg]; without `inertia`, that of the file grows with it.
        com: centre of mass in the frame of the link [m].
        inertia: ixx, iyy, izz, ixy, ixz, iyz about the centre of mass, along the axes of the
            link's frame [kg·m²].

    Raises:
        RobotError: the inertias are no numbers, or out of range.
    """

    links: str
    mass: float | None = None
    com: tuple[float, float, float] | None = None
    inertia: tuple[float, float, float, float, float, float] | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.links, str) or not self.links:
            raise RobotError(f"inertias: links must be a pattern of names, got {self.links!r}")
        where = f"inertias of '{self.links}'"
        if self.mass is not None:
            object.__setattr__(self, "mass", _finite(self.mass, f"{where}: mass"))
            if not self.mass > 0.0:
                raise RobotError(f"{where}: mass is {self.mass:g} kg; it must be > 0")
        for name, count, what in (
            ("com", 3, "x, y, z [m]"),
            ("inertia", 6, "ixx, iyy, izz, ixy, ixz, iyz [kg·m²]"),
        ):
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, _vector(value, name, where, count, what))
        if self.mass is None and self.com is None and self.inertia is None:
            raise RobotError(f"{where}: nothing is replaced; give mass, com or inertia")


THIGH, SHIN, HIP_WIDTH, FOOT, TRUNK = "thigh", "shin", "hip_width", "foot", "trunk"
ANKLE_HEIGHT = "ankle_height"
LENGTHS, MASSES = (THIGH, SHIN, HIP_WIDTH, FOOT, ANKLE_HEIGHT), (THIGH, SHIN, FOOT, TRUNK)
"""Parts whose length, and whose mass, `PartChange` changes."""
_LARGEST_CHANGE = 1e3  # m, kg


@checked
@dataclass(frozen=True)
class PartChange:
    """A part of both legs, or the trunk, in other proportions than the file has it.

    Attributes:
        part: "thigh", "shin", "hip_width", "foot", "ankle_height" or "trunk".
        longer: by which a thigh, a shin, a foot with its sole, the distance between the hips or the
            height of the ankles above the soles grows [m]; see `proportions` for what becomes
            of the masses.
        heavier: by which the part of each leg, or the trunk, grows with its inertia [kg].

    Raises:
        RobotError: there is no such part, it has no such number, or nothing is changed.
    """

    part: str
    longer: float = 0.0
    heavier: float = 0.0

    def __post_init__(self) -> None:
        _one_of("proportions: part", self.part, tuple(dict.fromkeys((*LENGTHS, *MASSES))))
        where = f"proportions of '{self.part}'"
        for name, parts, unit in (("longer", LENGTHS, "m"), ("heavier", MASSES, "kg")):
            value = _finite(getattr(self, name), f"{where}: {name}")
            object.__setattr__(self, name, value)
            if abs(value) > _LARGEST_CHANGE:
                raise RobotError(
                    f"{where}: {name} is {value:g} {unit}; give at most {_LARGEST_CHANGE:g} {unit}"
                )
            if value and self.part not in parts:
                raise RobotError(f"{where}: {name} is for {', '.join(parts)}; leave it out")
        if not self.longer and not self.heavier:
            raise RobotError(f"{where}: nothing is changed; give longer [m] or heavier [kg]")


@checked
@dataclass(frozen=True)
class Payload:
    """A load fixed to a link.

    Attributes:
        link: name of the link; "torso" and "pelvis" also mean those of the robot.
        mass: [kg].
        place: of its centre of mass in the frame of the link [m], where it stays if the link gets
            other proportions; by default the link's own, with these.
        box: lengths along the axes of the link's frame of the box that it fills evenly [m]; a point
            by default.

    Raises:
        RobotError: a value is no number, or out of range.
    """

    link: str
    mass: float
    place: tuple[float, float, float] | None = None
    box: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not isinstance(self.link, str) or not self.link:
            raise RobotError(f"payloads: link must be the name of a link, got {self.link!r}")
        where = f"payload on '{self.link}'"
        object.__setattr__(self, "mass", _finite(self.mass, f"{where}: mass"))
        if not self.mass > 0.0:
            raise RobotError(f"{where}: mass is {self.mass:g} kg; it must be > 0")
        for name in ("place", "box"):
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, _vector(value, name, where, 3, "3 [m]"))
        if min(self.box) < 0.0:
            raise RobotError(f"{where}: box is {self.box} m; no length may be negative")


@checked
@dataclass(frozen=True)
class ImportOptions:
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
        sole: rectangle of either sole in its sole frame; of feet that get longer, that of the file.
        sole_drop: height of the ankle above the sole with flat feet [m].
        sole_placements: the sole frames of the right and of the left foot in the frame of the last
            joint of their legs, each as the rows of a 3 x 4 matrix [R p], 12 numbers [m].
        limits: what replaces limits of the URDF; where two patterns match, the later one counts.
        inertias: what replaces masses and inertias of the file; where two patterns match, the
            later one counts.
        proportions: lengths and masses of its parts in place of those of the file; each part once.
        payloads: what it carries; see `Payload`. Entries of this and of the three before may be
            tables, as in a file.
        gravity: acceleration of free fall in place of that of the file [m/s²].
        unequal_limits: one of `UNEQUAL`.
        asymmetry: by how much averaging left and right may change the robot at most, over the range
            of motion: its mass matrix (relative), and the placement of its feet (per length of the
            leg, or rad); see `symmetry.averaging`.
        capsules: around the bodies of the legs, as an earlier reading found them in the shapes:
            body from 0 (stance foot) on, name, both ends [m] in the frame of its joint, radius
            [m], and what they cover.
        arm_capsules: likewise around moving arms and what they may run into, several of a body.
        without: what of the description's physics is left out, some of `physics.PARTS`; without
            "gravity" it is 9.81 m/s² straight down, whatever the description says.
        moving: joints beside the legs' that are not locked: "arms", "waist", or patterns of joint
            names as in a shell; a joint's partner on the other side moves with it.
        package_dirs: directories in which `package://` file names are looked up.

    Raises:
        RobotError: a value cannot be used.
    """

    feet: tuple[str, str] | None = None
    stance: str | None = None
    stance_sole: str | None = None
    swing_sole: str | None = None
    forward: Axis | None = None
    up: Axis | None = None
    posture: ReferencePosture | None = None
    srdf: str | None = None
    rotors: bool = False
    sole: Sole | None = None
    sole_drop: float | None = None
    sole_placements: tuple[Placement, Placement] | None = None
    limits: tuple[LimitOverride, ...] = ()
    inertias: tuple[InertiaOverride, ...] = ()
    proportions: tuple[PartChange, ...] = ()
    payloads: tuple[Payload, ...] = ()
    gravity: float | None = None
    unequal_limits: str = "refuse"
    asymmetry: float = 0.02
    without: tuple[str, ...] = ()
    package_dirs: tuple[str, ...] = ()
    capsules: tuple[CapsuleRow, ...] | None = None
    arm_capsules: tuple[CapsuleRow, ...] | None = None
    moving: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.posture is not None:
            object.__setattr__(self, "posture", _posture(self.posture))
        for name, kind in _TABLES.items():
            entries = getattr(self, name)
            if not isinstance(entries, list | tuple):
                given = str(entries)[:60]
                raise RobotError(f"{name} must be a list of tables ([[{name}]]), got {given!r}")
            made = (e if isinstance(e, kind) else kind(**_checked_table(e, kind, name))
                    for e in entries)  # fmt: skip
            object.__setattr__(self, name, tuple(made))
        for name in ("feet", "package_dirs", "moving"):
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, _tuple(value, name))
        _check_names(self)
        for name in ("forward", "up"):
            object.__setattr__(self, name, _axis(getattr(self, name), name))
        _check_numbers(self)
        for part in (without := _tuple(self.without, "without")):
            _one_of("without", part, PARTS)
        object.__setattr__(self, "without", tuple(part for part in PARTS if part in without))
        for name in ("capsules", "arm_capsules"):
            if (value := getattr(self, name)) is not None:
                rows = tuple(_capsule(row) for row in _tuple(value, name))
                object.__setattr__(self, name, rows)

    def over(self, **given: object) -> ImportOptions:
        """Return a copy with the given fields in place of its own, those that are None left out."""
        return replace(self, **{k: v for k, v in given.items() if v is not None})  # type: ignore[arg-type]


def _check_names(choices: ImportOptions) -> None:
    if choices.feet is not None and len(choices.feet) != 2:
        raise RobotError(
            f"feet must be two names, right foot first, got {len(choices.feet)}: "
            f"{', '.join(map(str, choices.feet))}"
        )
    for name in ("feet", "package_dirs", "moving"):
        for entry in getattr(choices, name) or ():
            if not isinstance(entry, (str, PurePath)):
                raise RobotError(f"{name} must be a list of texts, got {entry!r} in it; quote it")
    object.__setattr__(choices, "package_dirs", tuple(map(str, choices.package_dirs)))
    _one_of("stance", choices.stance, (None, *SIDES))
    _one_of("unequal_limits", choices.unequal_limits, UNEQUAL)
    if not isinstance(choices.rotors, bool):
        raise RobotError(f"rotors must be true or false, got {choices.rotors!r}")
    for name in ("stance_sole", "swing_sole", "srdf"):
        value = getattr(choices, name)
        if value is not None and not isinstance(value, str):
            raise RobotError(f"{name} must be text, got {value!r}")


def _check_numbers(choices: ImportOptions) -> None:
    parts = [one.part for one in choices.proportions]
    if twice := sorted({part for part in parts if parts.count(part) > 1}):
        raise RobotError(f"proportions: '{twice[0]}' is given twice; give each part once")
    if choices.sole_drop is not None and not 0.0 < _finite(choices.sole_drop, "sole_drop") < 1.0:
        raise RobotError(
            f"sole_drop is {choices.sole_drop:g} m; it must be above 0 and below 1: the height of "
            "the ankle above the sole"
        )
    if choices.gravity is not None and not (
        LEAST_GRAVITY <= _finite(choices.gravity, "gravity") <= MOST_GRAVITY
    ):
        raise RobotError(
            f"gravity is {choices.gravity:g} m/s²; {GRAVITY_WORDS}; the Earth has 9.81, the Moon "
            "1.62"
        )
    if choices.gravity is not None and "gravity" in choices.without:
        raise RobotError(
            "a gravity is given (gravity), and that of the file is to be left out for the standard "
            "one (without); leave out one of the two"
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
    if len(values) != 10 or not (type(values[0]) is int and values[0] >= 0):
        raise RobotError(
            f"capsules: {list(values)} is not one; give body (0 or more), name, two ends and a "
            "radius [m], and what it covers"
        )
    numbers = (_finite(n, f"capsules of '{values[1]}'") for n in values[2:9])
    return (values[0], str(values[1]), *numbers, str(values[9]))


def _posture(value: object) -> ReferencePosture:
    if isinstance(value, str):
        return value
    given = value.items() if isinstance(value, Mapping) else value
    entries = list(given) if isinstance(given, Iterable) else []
    pairs = [p for p in entries if isinstance(p, (tuple, list)) and len(p) == 2]
    if not isinstance(given, Sized) or len(pairs) != len(given):
        raise RobotError(
            "posture must be the name of a pose in the SRDF, or a table of angles [rad] by joint "
            f"([posture] with JOINT = ANGLE), got {value!r}"
        )
    return tuple((str(name), _finite(a, f"posture of '{name}'")) for name, a in pairs)


def _axis(value: object, name: str) -> Axis | None:
    if value is None:
        return None
    if isinstance(value, str):
        _one_of(name, value.removeprefix("+"), AXES)
        return value.removeprefix("+")
    listed = tuple(value) if isinstance(value, Iterable) else ()
    if len(listed) != 3 or not all(isinstance(n, (int, float)) for n in listed):
        raise RobotError(_AXIS.format(name, value))
    x, y, z = (_finite(n, name) for n in listed)
    size = math.hypot(x, y, z)
    if not 0.0 < size < math.inf:
        raise RobotError(_AXIS.format(name, value))
    # A vector of length 1 comes back as it was, to the last digit.
    return (x, y, z) if abs(size - 1.0) < 1e-12 else (x / size, y / size, z / size)


@checked_arguments
def choices_from_toml(toml: str | Path) -> ImportOptions:
    """Read choices from the text or the path of a TOML file; its paths are relative to it.

    Args:
        toml: a `Path`, or text; text without a line break that ends in ".toml" is a path.

    Raises:
        RobotError: the file cannot be read or is not TOML, has an unknown key, a value that cannot
            be used, or an SRDF that it does not use.
    """
    is_path = isinstance(toml, Path) or (toml.strip().endswith(".toml") and "\n" not in toml)
    where = str(toml).strip() if is_path else "the choices"
    text = read_text(Path(where), "choices") if is_path else str(toml)
    table = parse_toml(text, where, kind=RobotError)
    try:
        choices = choices_from_record(table)
        if choices.srdf is not None and isinstance(choices.posture, tuple) and not choices.rotors:
            raise RobotError(UNUSED_SRDF)
    except RobotError as error:
        raise RobotError(f"{where}: {error}") from None
    if not is_path:
        return choices
    folder, srdf = Path(where).parent.absolute(), choices.srdf
    if srdf is not None and not srdf.lstrip().startswith("<"):
        srdf = str(folder / Path(srdf).expanduser())
    directories = tuple(str(folder / Path(d).expanduser()) for d in choices.package_dirs)
    return replace(choices, package_dirs=directories, srdf=srdf)


def choices_from_record(record: Mapping[str, Any]) -> ImportOptions:
    """Return the choices of a table of plain values, as `choices_record` makes it.

    Raises:
        RobotError: an unknown key, or a value that cannot be used.
    """
    table = _checked_table(record, ImportOptions, "choices", "")
    if table.get("sole") is not None:
        sole = _checked_table(table["sole"], Sole, "sole")
        for name in (f.name for f in fields(Sole)):
            if name not in sole:
                raise RobotError(f"sole.{name} is missing; give toe, heel, left and right [m]")
        table["sole"] = Sole(**{name: _finite(edge, f"sole.{name}") for name, edge in sole.items()})
    for name in ("forward", "up"):
        if isinstance(table.get(name), list):
            table[name] = tuple(table[name])
    return ImportOptions(**{key: value for key, value in table.items() if value is not None})


def _checked_table(value: object, part: type, name: str, path: str | None = None) -> dict[str, Any]:
    """Return the fields of a part of the choices, numbers with units read, all keys known."""
    if not isinstance(value, Mapping):
        raise RobotError(f"{name} must be a table of named values, got {str(value)[:60]!r}")
    known = [entry.name for entry in fields(part)]
    for key in value:
        if key not in known:
            hint, where = did_you_mean(key, known), f"{name}." if path is None else path
            raise RobotError(f"unknown entry {where}{key}; {hint}known are: {', '.join(known)}")
    table = dict(value)
    for needed, advice in (
        ("joints", 'a pattern of names, as "*knee*"'),
        ("links", 'a pattern of names, as "*foot*"'),
        ("link", 'the name of a link, or "torso"'),
        ("part", f"one of {', '.join(dict.fromkeys((*LENGTHS, *MASSES)))}"),
    ):
        if part in _TABLES.values() and needed in known and needed not in table:
            raise RobotError(f"{name}: {needed} is missing; give {advice}")
    if part is Payload and "mass" not in table:
        raise RobotError(f"{name}: mass is missing; give it [kg]")
    units = []
    for key, text in table.items():
        if part is LimitOverride and key in LIMIT_UNITS and isinstance(text, str):
            table[key], unit = _read(partial(read_limit, key), text, f"{name}: {key}")
            units += [unit] * bool(unit)
        elif (unit := _UNITS[part].get(key)) is not None:
            table[key] = _in_si(text, unit, f"{name}: {key}")
    if units:
        table["units"] = units
    if part is ImportOptions and isinstance(posture := table.get("posture"), Mapping):
        table["posture"] = {j: _in_si(q, "rad", f"posture: {j}") for j, q in posture.items()}
    return table


def _in_si(value: object, unit: str, what: str) -> object:
    """Return a text of a number, with a unit or without, as that number; others as they are."""
    return _read(lambda t: read_quantity(t, unit), value, what) if isinstance(value, str) else value


def _read(read: Callable[[str], Any], text: str, what: str) -> Any:
    try:
        return read(text)
    except ValueError as error:
        raise RobotError(f"{what} = {text[:60]!r} is wrong; {error}") from None


_TABLES: dict[str, type] = {
    "limits": LimitOverride, "inertias": InertiaOverride, "proportions": PartChange,
    "payloads": Payload,
}  # fmt: skip
"""Choices that are lists of tables."""

_UNITS: dict[type, dict[str, str]] = {
    LimitOverride: {},
    InertiaOverride: {"mass": "kg"},
    PartChange: {"longer": "m", "heavier": "kg"},
    Payload: {"mass": "kg"},
    Sole: dict.fromkeys(("toe", "heel", "left", "right"), "m"),
    ImportOptions: {"sole_drop": "m"},
}
"""Units of numbers that a file may give with theirs."""


def choices_record(choices: ImportOptions) -> dict[str, Any]:
    """Return what differs from the defaults, as values that JSON and TOML can hold."""
    record: dict[str, Any] = _plain(choices)
    if isinstance(choices.posture, tuple):
        record["posture"] = dict(choices.posture)
    return record


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        given = {f.name: getattr(value, f.name) for f in fields(value)}
        defaults = {f.name: f.default for f in fields(value)}
        return {name: _plain(v) for name, v in given.items() if v != defaults[name]}
    if isinstance(value, tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, float):
        return NO_LIMIT if math.isinf(value) else float(value)
    return value


# Checks of single values


def _one_of(name: str, value: object, allowed: Collection[str | None]) -> None:
    if value not in allowed:
        names = [str(one) for one in allowed if one is not None]
        raise RobotError(
            f"{name} is {value!r}; {did_you_mean(value, names)}it must be one of "
            f"{', '.join(map(repr, names))}"
        )


def _tuple(value: object, name: str) -> tuple[Any, ...]:
    if isinstance(value, str | Mapping) or not isinstance(value, Iterable):
        raise RobotError(f"{name} must be a list, got {value!r}")
    return tuple(value)


def _number(value: object, name: str) -> float:
    """Return a number, which may be infinite."""
    if isinstance(value, bool) or not isinstance(value, int | float) or value != value:
        raise RobotError(f"{name} must be a number, got {value!r}")
    try:
        return float(value)
    except OverflowError:  # whole numbers have no largest one
        raise RobotError(f"{name} is too large: {len(str(value))} digits") from None


def _vector(value: object, name: str, where: str, count: int, what: str) -> tuple[float, ...]:
    numbers = tuple(_finite(n, f"{where}: {name}") for n in _tuple(value, name))
    if len(numbers) != count:
        raise RobotError(f"{where}: {name} has {len(numbers)} numbers; give {what}")
    return numbers


def _finite(value: object, name: str) -> float:
    found = _number(value, name)
    if not math.isfinite(found):
        raise RobotError(f"{name} is {found}; it must be finite")
    return found
