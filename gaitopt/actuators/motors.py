"""Motors and their gears as data: `motors.toml`, and what follows for the joints they drive.

A motor is its direct-current equivalent: torque kt I, voltage R I + kt w. A gear of ratio N turns
the motor N times as fast as the joint; of the torque it passes on the share that its efficiency
says, and its friction takes a constant torque at the joint.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import MISSING, asdict, field, fields, replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gaitopt.bounds import NUMBER
from gaitopt.dataclass import dataclass
from gaitopt.errors import SpecError, there_are
from gaitopt.importers.text_files import check_keys, parse_toml, read_text
from gaitopt.model.import_options import LimitOverride, matching
from gaitopt.nlp import Array
from gaitopt.settings import checked, checked_arguments
from gaitopt.units import read_quantity

MOTORS = "motors."
"""Before the names of numbers of drives, where they stand beside numbers of the robot."""
_INDUCED = (0.5, 1.05)
"""Range of kt * no-load speed over the voltage: beyond it no current flows or units are wrong."""
_MOST = {"inertia": 1.0, "mass": 200.0, "ratio": 1e4, "friction": 1e4}
"""Of numbers of motors and gears of robots that walk, in SI units: beyond it units are wrong."""
_LEAST_RATIO = 0.01
_MOST_ENTRIES = 1000  # drives of a table, ratios of a catalogue
_KEY = "unit"


def _number(unit: str, default: Any = MISSING) -> Any:
    """Return a dataclass field that is a number with a unit."""
    if default is MISSING:
        return field(metadata={_KEY: unit})
    return field(default=default, metadata={_KEY: unit})


@checked
@dataclass(frozen=True)
class Motor:
    """A motor without its gear.

    Attributes:
        name: of the motor.
        torque_constant: torque per current, kt [N·m/A].
        resistance: such that resistance * current² is the copper loss [Ω].
        inertia: of the rotor [kg·m²].
        peak_current: largest current for moments [A].
        continuous_current: largest root mean square of the current [A].
        voltage: of the supply [V].
        no_load_speed: at that voltage [rad/s].
        mass: [kg].
        source: where the figures are from.

    Raises:
        SpecError: a figure is not above zero, or they contradict each other.
    """

    name: str
    torque_constant: float = _number("N·m/A")
    resistance: float = _number("Ω")
    inertia: float = _number("kg·m²")
    peak_current: float = _number("A")
    continuous_current: float = _number("A")
    voltage: float = _number("V")
    no_load_speed: float = _number("rad/s")
    mass: float = _number("kg")
    source: str = ""

    def __post_init__(self) -> None:
        where = f"motor '{self.name}'"
        for name, unit in _units(Motor).items():
            _check_number(where, name, getattr(self, name), unit)
        if self.continuous_current > self.peak_current:
            raise SpecError(
                f"{where}: the continuous current is {self.continuous_current:g} A, above the peak "
                f"of {self.peak_current:g} A; swap them if they are mixed up"
            )
        if self.peak_current > self.stall_current:
            raise SpecError(
                f"{where}: a peak current of {self.peak_current:g} A cannot flow: {self.voltage:g} "
                f"V drive {self.stall_current:.4g} A through {self.resistance:g} Ω; give at most "
                "that, a higher voltage or a lower resistance"
            )
        induced = self.torque_constant * self.no_load_speed
        least, most = (share * self.voltage for share in _INDUCED)
        if not least <= induced <= most:
            what = "above" if induced > most else "far below"
            raise SpecError(
                f"{where}: at the no-load speed of {self.no_load_speed:.4g} rad/s it induces "
                f"{induced:.4g} V ({self.torque_constant:g} N·m/A are as many V·s), {what} its "
                f"supply of {self.voltage:g} V; give {least / self.torque_constant:.4g} to "
                f"{most / self.torque_constant:.4g} rad/s, and check the units, as in "
                f'no_load_speed = "2400rpm" or torque_constant = "91mNm/A"'
            )

    @property
    def stall_current(self) -> float:
        """Current that the supply drives through the motor at rest [A]."""
        return self.voltage / self.resistance


@checked
@dataclass(frozen=True)
class Drive:
    """A motor with its gear, and the joints that have it.

    Attributes:
        joints: pattern of joint names, `*knee*`, or a word in them.
        motor: of each of them.
        ratio: turns of the motor per turn of the joint.
        efficiency: share of the torque (and of the power) that the gear passes on.
        friction: torque at the joint that the gear takes [N·m].

    Raises:
        SpecError: a number is out of range, or the friction eats all torque.
    """

    joints: str
    motor: Motor
    ratio: float = _number("", 1.0)
    efficiency: float = _number("", 1.0)
    friction: float = _number("N·m", 0.0)

    def __post_init__(self) -> None:
        if not isinstance(self.joints, str) or not self.joints:
            raise SpecError(f"joints must be a pattern of joint names, got {self.joints!r}")
        where = f"drive of '{self.joints}'"
        _check_number(where, "ratio", self.ratio, "")
        _check_losses(where, self.efficiency, self.friction)
        most = self.torque_per_current * self.motor.continuous_current
        if self.friction >= most:
            raise SpecError(
                f"{where}: the friction is {self.friction:g} N·m, but the motor delivers no more "
                f"than {most:.4g} N·m at the joint continuously; no torque is left"
            )

    @property
    def torque_per_current(self) -> float:
        """Torque at the joint per current [N·m/A], before friction."""
        return self.ratio * self.efficiency * self.motor.torque_constant

    @property
    def armature(self) -> float:
        """Inertia of the rotor as seen from the joint, ratio² times its own [kg·m²]."""
        return self.ratio**2 * self.motor.inertia

    def at_joint(self) -> JointMotor:
        """Return what it can do at its joints."""
        torque = self.torque_per_current
        return JointMotor(
            joints=self.joints,
            peak_torque=torque * self.motor.peak_current - self.friction,
            continuous_torque=torque * self.motor.continuous_current - self.friction,
            stall_torque=torque * self.motor.stall_current - self.friction,
            no_load_speed=self.motor.no_load_speed / self.ratio,
            loss=self.motor.resistance / torque**2,
            efficiency=self.efficiency,
            friction=self.friction,
        )


class JointMotor(NamedTuple):
    """What a motor with its gear can do at a joint, as numbers that gait files keep.

    Attributes:
        joints: pattern of joint names.
        peak_torque: [N·m].
        continuous_torque: [N·m], of the root mean square over a stride.
        stall_torque: what the supply's voltage would allow at rest [N·m]; above the peak.
        no_load_speed: [rad/s].
        loss: copper loss per squared torque [W/(N·m)²].
        efficiency: of the gear.
        friction: of the gear [N·m].
    """

    joints: str
    peak_torque: float
    continuous_torque: float
    stall_torque: float
    no_load_speed: float
    loss: float
    efficiency: float
    friction: float

    def torque_at(self, speed: Array) -> Array:
        """Return the largest driving torques [N·m] at speeds [rad/s] (N,): peak or voltage line."""
        line = self.stall_torque * (1.0 - np.abs(speed) / self.no_load_speed)
        return np.asarray(np.clip(line, 0.0, self.peak_torque))


def joint_motors_of(rows: object) -> tuple[JointMotor, ...]:
    """Return motors at joints from rows of plain values, as a gait file keeps them.

    Raises:
        SpecError: a row is none, or a number of it is out of range.
    """
    names, found = JointMotor._fields, []
    if not isinstance(rows, list | tuple):
        raise SpecError(f"motors must be rows of {', '.join(names)}")
    for row in rows:
        whole = isinstance(row, list | tuple) and len(row) == len(names)
        if not whole or not isinstance(row[0], str):
            raise SpecError(f"a motor at a joint must be a row of {', '.join(names)}")
        where = f"motor at '{row[0][:40]}'"
        for name, value in zip(names[1:], row[1:], strict=True):
            _check_number(where, name, value, "", zero=name == "friction")
            if not (value == 0.0 or 1.0 / NUMBER <= value <= NUMBER):
                raise SpecError(f"{where}: the {name.replace('_', ' ')} is {value:g}, no SI value")
        found.append(JointMotor(*row))
    return tuple(found)


@checked
@dataclass(frozen=True)
class MotorTable:
    """The drives of a robot.

    Attributes:
        drives: where two patterns fit a joint, the later one counts.
    """

    drives: tuple[Drive, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "drives", tuple(self.drives))

    @property
    def at_joints(self) -> tuple[JointMotor, ...]:
        """What they can do at their joints."""
        return tuple(drive.at_joint() for drive in self.drives)

    def apart(self, joints: str, names: Sequence[str]) -> MotorTable:
        """Return the table with a drive of its own for joints of a pattern, as they have it now.

        Raises:
            SpecError: there are no such joints, or they have none or different drives.
        """
        if any(one.joints == joints for one in self.drives):
            return self
        own = list(dict.fromkeys(map(self.drive, matching(joints, names))))
        if len(own) != 1 or own[0] is None:
            known = dict.fromkeys(one.joints for one in self.drives)
            has = "have different drives or none" if own else "are no joints"
            raise SpecError(f"'{joints}' {has}; the table has drives of {', '.join(known)}")
        return MotorTable((*self.drives, replace(own[0], joints=joints)))

    def check(self, names: Sequence[str], mirror: Array) -> None:
        """Check that the drives fit the joints of a robot; see `joint_motors`."""
        joint_motors(self.at_joints, names, mirror)

    def rotors(self, source: str = "table of motors") -> tuple[LimitOverride, ...]:
        """Return the inertias of the rotors as seen from their joints, where they are from."""
        return tuple(
            LimitOverride(one.joints, armature=one.armature, source=source) for one in self.drives
        )

    def with_rotors(self, limits: Sequence[LimitOverride]) -> tuple[LimitOverride, ...]:
        """Return what is set of a robot's joints with the rotors of the drives.

        Of two that set the same, the later one counts. The rotors come after all that has a source,
        rotors of files and of an earlier table, and before a user's own, which have none.
        """
        own = next((k for k in range(len(limits), 0, -1) if limits[k - 1].source), 0)
        return (*limits[:own], *self.rotors(), *limits[own:])

    def changed(self, changes: Mapping[str, float]) -> MotorTable:
        """Return the table with other numbers.

        Args:
            changes: numbers by name: "ratio" of all drives, "knee.ratio" of the drive of the joints
                'knee', as the table calls them; of a drive, or of its motor.

        Raises:
            SpecError: there is no such drive or number, or with it the motor could not be.
        """
        drives = list(self.drives)
        for path, value in changes.items():
            joints, _, name = path.rpartition(".")
            for k in self.called(joints):
                drives[k] = _with_number(drives[k], name, value)
        return MotorTable(tuple(drives))

    def called(self, joints: str) -> list[int]:
        """Return which drives have joints, as the table calls them; all for an empty text.

        Raises:
            SpecError: there are none.
        """
        found = [k for k, one in enumerate(self.drives) if joints in ("", one.joints)]
        if not found:
            known = dict.fromkeys(one.joints for one in self.drives)
            raise SpecError(f"no drive has the joints '{joints}'; {there_are(known, joints)}")
        return found

    def record(self) -> list[dict[str, Any]]:
        """Return the drives as JSON-able data, each with its motor."""
        return [asdict(drive) for drive in self.drives]

    def drive(self, joint: str) -> Drive | None:
        """Return the drive of a joint, None where it has none."""
        found = [one for one in self.drives if matching(one.joints, [joint])]
        return found[-1] if found else None


def motor_table_of(record: Sequence[Mapping[str, Any]]) -> MotorTable:
    """Return the table of a record, as of `MotorTable.record`.

    Raises:
        TypeError, SpecError: it is none.
    """
    return MotorTable(tuple(Drive(**{**one, "motor": Motor(**one["motor"])}) for one in record))


def motor_quantities() -> dict[str, str]:
    """Return the numbers of drives and motors that a walk depends on, with their units."""
    return {
        name: unit
        for name, unit in {**_units(Drive), **_units(Motor)}.items()
        if name not in ("continuous_current", "mass")  # these are reported only
    }


def _with_number(drive: Drive, name: str, value: float) -> Drive:
    if name in _units(Drive):
        return replace(drive, **{name: value})  # type: ignore[arg-type]
    if name not in motor_quantities():
        raise SpecError(f"a drive has no number '{name}'; {there_are(motor_quantities(), name)}")
    return replace(drive, motor=replace(drive.motor, **{name: value}))  # type: ignore[arg-type]


def joint_motors(
    motors: Sequence[JointMotor], names: Sequence[str], mirror: Array
) -> list[JointMotor | None]:
    """Return the motor of each joint, the later of two that fit, or None. `mirror` (n, n) is E.

    Raises:
        SpecError: a pattern fits no joint, or the two joints of a pair have different motors.
    """
    found: list[JointMotor | None] = [None] * len(names)
    for one in motors:
        fits = matching(one.joints, names)
        if not fits:
            raise SpecError(
                f"motors are given for '{one.joints}', but no joint that moves is called so; there "
                f"are {', '.join(names)}, and patterns as '*knee*'"
            )
        for name in fits:
            found[list(names).index(name)] = one
    for k, own in enumerate(found):
        other = int(np.argmax(np.abs(mirror[:, k])))
        theirs = found[other]
        if (own and own[1:]) != (theirs and theirs[1:]):
            raise SpecError(
                f"'{names[k]}' and '{names[other]}' have different motors; give the joints of a "
                "pair the same, for each is in the stance leg in one step and in the swing leg in "
                "the next"
            )
    return found


@checked_arguments
def read_motors(path: str | Path) -> MotorTable:
    """Read `motors.toml`: [motors.NAME] tables, and a [[drives]] entry for joints with a motor.

    Raises:
        SpecError: it cannot be used; the message says what is wrong and what is allowed.
        RobotError: it cannot be read.
    """
    return motors_of(read_text(Path(path), "motor table"), str(path))


def motors_of(text: str, where: str = "motor table") -> MotorTable:
    """Return the drives of a TOML text; motors of `known_motors` need no table of their own.

    Raises:
        SpecError: the text is no TOML, a table or a value in it is wrong, or there are no drives.
    """
    table = parse_toml(text, where, kind=SpecError)
    if foreign := [key for key in ("gear", "known") if key in table]:
        raise SpecError(
            f"{where}: unknown entry '{foreign[0]}': a catalogue is for gaitopt size --catalogue; "
            "--motors takes a table that says which joints have which motor, [[drives]], as size "
            "writes it"
        )
    check_keys(where, table, ("motors", "drives"), SpecError)
    own = table.get("motors", {})
    if not isinstance(own, Mapping):
        raise SpecError(f"{where}: 'motors' must hold tables, [motors.NAME]")
    motors = {**known_motors(), **{n: _motor(where, n, one) for n, one in own.items()}}
    entries = table.get("drives", [])
    if isinstance(entries, Mapping):
        raise SpecError(f"{where}: write each drive as [[drives]], with two brackets")
    if isinstance(entries, list) and len(entries) > _MOST_ENTRIES:
        count = len(entries)
        raise SpecError(f"{where}: {count} drives are too many; give {_MOST_ENTRIES} at most")
    if not isinstance(entries, list) or not entries:
        raise SpecError(
            f"{where}: there are no drives; say which joints have which motor, as in\n"
            '[[drives]]\njoints = "*knee*"\nmotor = "ak80-6"\nratio = 6'
        )
    return MotorTable(
        tuple(_drive(where, number, one, motors) for number, one in enumerate(entries, 1))
    )


def catalogue_of(text: str, where: str = "catalogue") -> tuple[dict[str, Motor], dict[str, Any]]:
    """Return the motors of a catalogue, and the values of its [gear] table.

    Motors of `known_motors` count where the text lists their names: `known = ["ak80-6"]`.

    Raises:
        SpecError: it cannot be used; the message says what is wrong and what is allowed.
    """
    table = parse_toml(text, where, kind=SpecError)
    if "drives" in table:
        raise SpecError(
            f"{where}: unknown entry 'drives': a table with them is for --motors; which joints "
            "have which motor of a catalogue is for gaitopt size to choose"
        )
    check_keys(where, table, ("motors", "known", "gear"), SpecError)
    own, names = table.get("motors", {}), table.get("known", [])
    if not isinstance(own, Mapping) or not isinstance(names, list):
        raise SpecError(f"{where}: 'motors' must hold tables, [motors.NAME], 'known' a list")
    there = known_motors()
    if unknown := [n for n in names if not isinstance(n, str) or n not in there]:
        raise SpecError(
            f"{where}: known: there is no motor '{str(unknown[0])[:60]}'; "
            f"{there_are(there, unknown[0])}"
        )
    motors = {name: there[name] for name in names}
    motors |= {name: _motor(where, name, one) for name, one in own.items()}
    if not motors:
        raise SpecError(f"{where}: there are no motors; give [motors.NAME] tables")
    gear = table.get("gear", {})
    if not isinstance(gear, Mapping):
        raise SpecError(f"{where}: 'gear' must be a table with ratios, efficiency and friction")
    return motors, _gear(f"{where}: gear", gear)


def _gear(where: str, entry: Mapping[str, object]) -> dict[str, Any]:
    """Return ratios, efficiency and friction of a catalogue's gears, checked."""
    check_keys(where, entry, ("ratios", "efficiency", "friction"), SpecError)
    found = _numbers(where, {k: v for k, v in entry.items() if k != "ratios"}, Drive, ())
    ratios = entry.get("ratios", [])
    if not isinstance(ratios, list) or len(ratios) > _MOST_ENTRIES:
        raise SpecError(f"{where}: ratios must be a list of at most {_MOST_ENTRIES} numbers")
    for ratio in ratios:
        _check_number(where, "ratio", ratio, "")
    losses = {"efficiency": 1.0, "friction": 0.0, **found}
    _check_losses(where, **losses)
    return {"ratios": tuple(map(float, ratios)), **losses}


def _check_losses(where: str, efficiency: float, friction: float) -> None:
    _check_number(where, "efficiency", efficiency, "")
    if efficiency > 1.0:
        raise SpecError(
            f"{where}: the efficiency is {efficiency:g}; it must be a share, at most 1 (0.9 for "
            "90 %)"
        )
    _check_number(where, "friction", friction, "N·m", zero=True)


@cache
def known_motors() -> dict[str, Motor]:
    """Return the motors that come with gaitopt, by name, each with its source."""
    text = (files("gaitopt.actuators") / "known_motors.toml").read_text("utf-8")
    table = parse_toml(text, "known_motors.toml")["motors"]
    return {name: _motor("known_motors.toml", name, one) for name, one in table.items()}


def _motor(where: str, name: str, entry: object) -> Motor:
    return Motor(name=name, **_numbers(f"{where}: motor '{name}'", entry, Motor, ("source",)))


def _drive(where: str, number: int, entry: object, motors: Mapping[str, Motor]) -> Drive:
    joints = entry.get("joints") if isinstance(entry, Mapping) else None
    what = f"{where}: drive " + (f"of '{joints}'" if isinstance(joints, str) else str(number))
    values = _numbers(what, entry, Drive, ("joints", "motor"))
    if values["motor"] not in motors:
        name = values["motor"]
        raise SpecError(f"{what}: there is no motor '{name}'; {there_are(motors, name)}")
    return Drive(**{**values, "motor": motors[values["motor"]]})


def _numbers(where: str, entry: object, kind: type, texts: tuple[str, ...]) -> dict[str, Any]:
    """Return the values of a table for a dataclass, numbers in SI units."""
    units = _units(kind)
    if not isinstance(entry, Mapping):
        raise SpecError(f"{where}: give a table with {', '.join((*texts, *units))}")
    check_keys(where, entry, (*texts, *units), SpecError)
    needed = {one.name for one in fields(kind) if one.default is MISSING} - {"name"}
    if missing := [name for name in (*texts, *units) if name in needed - set(entry)]:
        what = "every figure of the motor" if kind is Motor else "it in every [[drives]] entry"
        verb = "is" if len(missing) == 1 else "are"
        raise SpecError(f"{where}: {', '.join(missing)} {verb} missing; give {what}")
    values: dict[str, Any] = {}
    for name, value in entry.items():
        if name in texts:
            if not isinstance(value, str):
                each = "; give each pattern a [[drives]] entry" if name == "joints" else ""
                raise SpecError(f"{where}: {name} must be a text, got {str(value)[:60]!r}{each}")
            values[name] = value
            continue
        try:
            values[name] = read_quantity(value, units[name])
        except ValueError as error:
            raise SpecError(f"{where}: {name} = {str(value)[:60]!r} is wrong; {error}") from None
    return values


def _units(kind: type) -> dict[str, str]:
    return {one.name: one.metadata[_KEY] for one in fields(kind) if _KEY in one.metadata}


def _check_number(where: str, name: str, value: object, unit: str, zero: bool = False) -> None:
    words = name.replace("_", " ")
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise SpecError(f"{where}: the {words} is {value!r}; it must be a finite number")
    if value < 0.0 or (value == 0.0 and not zero):
        allowed = "0 or more" if zero else "above 0"
        raise SpecError(
            f"{where}: the {words} is {f'{value:g} {unit}'.strip()}; it must be {allowed}"
        )
    if value > (most := _MOST.get(name, np.inf)) or (name == "ratio" and value < _LEAST_RATIO):
        allowed = f"from {_LEAST_RATIO:g} to {most:g}" if name == "ratio" else f"at most {most:g}"
        hint = {"mass": ', as in mass = "600g"', "inertia": ', as in inertia = "535gcm2"'}
        raise SpecError(
            f"{where}: the {words} is {f'{value:g} {unit}'.strip()}; it must be "
            f"{f'{allowed} {unit}'.strip()}{hint.get(name, '')}"
        )
