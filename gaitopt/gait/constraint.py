"""What a constraint is: its declaration, the numbers a person sets in it, and the rows it gives.

`Margins` are the numbers of the built-in ones, which `gaitopt.gait.constraints` holds.

A `Constraint` is declared once: name, equation, unit, words, the quantities it reads, the margins
(numbers) it depends on and how each may be relaxed. Options, TOML keys, records in gait files,
names in messages, the diagnosis and the refinement between the samples follow from that.
"""

from __future__ import annotations

import math
import sys
from abc import ABC, abstractmethod
from bisect import bisect_right
from collections.abc import Container, Mapping
from dataclasses import Field, field, fields, is_dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from traceback import extract_tb
from typing import TYPE_CHECKING, Any, ClassVar, TypeGuard

import numpy as np
from numpy.typing import NDArray

from gaitopt.bounds import NUMBER, shown
from gaitopt.contact import Schedule
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.gait.functions import QuantityFunction
from gaitopt.gait.grid import Grid
from gaitopt.gait.quantities import Quantity
from gaitopt.gait.terrain import Level, Terrain
from gaitopt.nlp import Array
from gaitopt.settings import checked, setting
from gaitopt.units import DEGREES, SINE

if TYPE_CHECKING:
    from gaitopt.model.robot import Robot
    from gaitopt.model.scales import Scales

USABLE = f"between {1.0 / NUMBER:g} and {NUMBER:g}"

FREE = np.inf
"""A limit that is none."""

_KEY = "margin"  # of a field's metadata


@dataclass(frozen=True)
class Margin:
    """A number of a constraint that a person may set: a field of `Margins` or of a constraint.

    The field's name is the keyword in Python, the key in TOML and, with dashes, the option; its
    help is that of its `gaitopt.settings.Setting`.

    Attributes:
        words: what a person calls it: "the coefficient of friction".
        unit: empty where there is none.
        above, least, most: bounds on its value.
        farthest: value to which the diagnosis may loosen it, None: it does not.
        change: of the value that matters to a person, signed, towards `farthest`.
    """

    words: str = ""
    unit: str = ""
    above: float | None = None
    least: float | None = None
    most: float | None = None
    farthest: float | None = None
    change: float = 0.0


def margin(
    default: float | bool | None,
    help_text: str,
    words: str = "",
    unit: str = "",
    *,
    above: float | None = None,
    least: float | None = None,
    most: float | None = None,
    relax: tuple[float, float] | None = None,
    sine: bool = False,
    **shown: Any,
) -> Any:
    """Return a dataclass field that is a margin, see `Margin`.

    Args:
        default: its value unless given; None where the constraint is then off, and "none" stands
            for that where people write.
        help_text: of the option, one line.
        words, unit, above, least, most: as in `Margin`.
        relax: `farthest` and `change` of the `Margin`.
        sine: whether it is the sine of an angle, so that an option takes degrees too.
        shown: other attributes of the option, as in `gaitopt.settings.Setting`.
    """
    declared = Margin(words, unit, above, least, most, *(relax or ()))
    shown = {"limit": default is None, **shown}
    return field(
        default=default,
        metadata={_KEY: declared, **setting(help_text, SINE if sine else unit, **shown)},
    )


def declared_margins(owner: object) -> Mapping[str, Margin]:
    """Return the margins among the fields of a dataclass or of an instance, by name."""
    return _margins_of(owner if isinstance(owner, type) else type(owner))


@lru_cache
def _margins_of(kind: type) -> Mapping[str, Margin]:
    found: tuple[Field[Any], ...] = fields(kind) if is_dataclass(kind) else ()
    return {one.name: one.metadata[_KEY] for one in found if _KEY in one.metadata}


def check_margins(owner: object) -> None:
    """Check the values of the margins of a dataclass instance.

    Raises:
        InputError: one is not a finite number (True or False for a switch), or out of bounds.
    """
    for one in fields(owner):  # type: ignore[arg-type]
        if _KEY in one.metadata:
            _check(one.name, getattr(owner, one.name), str(one.type), one.metadata[_KEY])


def _check(name: str, value: object, kind: str, declared: Margin) -> None:
    if "bool" in kind:
        if not isinstance(value, bool):
            raise InputError(f"{name} is {shown(value)}; it must be True or False")
        return
    if value is None and "None" in kind:
        return
    if not is_finite(value):
        raise InputError(f"{name} is {shown(value)}; it must be a finite number")
    unit = declared.unit and f" {declared.unit}"
    if not is_of_use(value):
        raise InputError(f"{name} is {value}{unit}; it must be 0, or {USABLE} in size")
    if declared.above is not None and not value > declared.above:
        raise InputError(f"{name} is {value}{unit}; it must be above {declared.above:g}")
    if declared.least is not None and value < declared.least:
        limit = "not be negative" if declared.least == 0.0 else f"be at least {declared.least:g}"
        raise InputError(f"{name} is {value}{unit}; it must {limit}")
    if declared.most is not None and value > declared.most:
        also = f"; {DEGREES}" if declared.unit == "rad" else ""
        raise InputError(f"{name} is {value}{unit}; it must be at most {declared.most:g}{also}")


_LYING = 1.5708  # rad: what asks the trunk to lean or turn farther is meant in degrees
TILTED = 1.0
"""No trunk is let lean or turn farther to find a walk, no foot tilt [rad]."""


@checked
@dataclass(frozen=True)
class Margins:
    """The limits of section 3.2 that are not facts of the robot.

    Attributes:
        friction: coefficient mu of Eqs. (33)-(34).
        minimum_load: least vertical ground force, Eq. (35) [N].
        cop_margin: distance of the centre of pressure from the sole's edge, Eqs. (37)-(38) [m].
        clearance: height of the swing foot's corners at mid-step; the profile is
            clearance * sin²(pi t / T) [m].
        lateral_gap: between the swing sole and the edge of the stance sole, Eq. (32) [m].
        knee_flexion: least bend of both knees from straight [rad].
        leg_extension: largest hip-ankle distance in double support over the straight leg, Eq. (31);
            None: no limit, as suits the lifted form, whose joint angles cannot be out of reach.
        liftoff_speed: least upward speed of the old stance sole's corners after impact [m/s];
            a small negative value relaxes section 2.4.1, and lowers the profile of the clearance
            by what such a foot sinks, at most 0.0125 |liftoff_speed| T.
        joint_range: whether the joint ranges of Eq. (30) are imposed.
        impulse_cop: whether the impulsive centre of pressure must lie in the landing sole.
        torque_limit, speed_limit: replace the robot's limits when given [N·m], [rad/s].
        trunk_roll, trunk_pitch, trunk_yaw: largest angle of the trunk from upright and from the
            direction of travel over the whole step [rad].
        torsional_friction: largest moment about the vertical through the centre of pressure over
            the vertical force, of the stance foot and of the impact [m]; friction * turning_arm of
            the sole is what a foot that presses evenly can bear.
        step_width: largest distance between the two lines of footsteps, |foot_spacing| [m]; by as
            much more as a wide step sideways needs, or feet turned against each other in a turn.
        swing_tilt: largest roll, pitch and yaw of the swing sole over the whole step, as sines;
            its yaw in a turn by as much more as the feet are turned against each other.
        leg_gap: least distance between the capsules around the bodies of the two legs [m]; less
            where the robot has less when it stands.
        arm_gap: the same between moving arms and pelvis, waist, thighs, loads and the other arm.
        swing_height: largest height of the swing foot's corners over the whole step [m].
        landing_speed: least speed at which every corner of the swing foot comes down [m/s]: they
            stay above landing_speed * (T - t) * (t / T)^12.
        landing_impulse: largest vertical impulse of the impact over the robot's mass [m/s].
        soft_landing: whether the swing foot lands at zero speed: there is no impact then, and what
            limits an impact and what the rear foot does after it has no meaning.
        nosing: on stairs, length over which the height that the swing foot must pass is rounded at
            every edge, on the side of the lower tread [m]; None: all that lies between the toe of a
            foot that stands and the heel on the next tread.

    Raises:
        InputError: a value is no finite number, or out of range.
    """

    friction: float = margin(
        0.7, "Coefficient of friction of the ground.",
        "the coefficient of friction", above=0.0, metavar="mu", common=True,
        relax=(2.0, 0.1),  # rubber on rough concrete
    )  # fmt: skip
    minimum_load: float = margin(
        25.0, "Least vertical force of the ground on the stance foot.",
        "the least vertical ground force", "N", least=0.0,
        relax=(0.0, -100.0),
    )  # fmt: skip
    cop_margin: float = margin(
        0.005, "Least distance of the centre of pressure from the edges of the sole.",
        "the margin of the centre of pressure", "m", least=0.0, relax=(0.0, -0.01),
    )  # fmt: skip
    clearance: float = margin(
        0.03, "Least height of the swing foot above the ground at mid-step.",
        "the clearance of the swing foot", "m",
        least=0.0, relax=(0.0, -0.1), common=True,
    )  # fmt: skip
    lateral_gap: float = margin(
        0.01,
        "Least gap between swing and stance sole, sideways.",
        "the gap between the feet",
        "m",
        relax=(0.0, -0.1),
    )
    knee_flexion: float = margin(
        0.1,
        "Least bend of the knees from straight.",
        "the least bend of the knees",
        "rad",
        relax=(0.0, -0.3),
    )
    leg_extension: float | None = margin(
        0.9995,
        "Longest distance from hip to ankle in double support, over that of the straight leg.",
        "the largest extension of the legs",
        above=0.0, most=1.0, relax=(1.0, 0.01), metavar="ratio", limit=True,
    )  # fmt: skip
    liftoff_speed: float = margin(
        0.0, "Least speed upward of the rear foot as it leaves; below zero it may sink first.",
        "the least lift-off speed of the rear foot", "m/s",
        relax=(-0.05, -0.1),  # a rear foot that sinks faster has not lifted off
    )  # fmt: skip
    joint_range: bool = margin(True, "Keep every joint within its range.")
    impulse_cop: bool = margin(
        True, "Keep the impulse of the impact inside the landing sole, which then does not tip."
    )
    torque_limit: float | None = margin(
        None, "Largest torque of every joint, in place of the robot's limits.",
        "the torque limit of every joint", "N·m",
        above=0.0, common=True,
    )  # fmt: skip
    speed_limit: float | None = margin(
        None, "Largest speed of every joint, in place of the robot's limits.",
        "the speed limit of every joint",
        "rad/s", above=0.0, common=True,
    )  # fmt: skip
    trunk_roll: float | None = margin(
        None, "Largest sideways lean of the trunk.", "the largest sideways lean of the trunk",
        "rad", above=0.0, most=_LYING, relax=(TILTED, 0.3),
    )  # fmt: skip
    trunk_pitch: float | None = margin(
        None, "Largest lean of the trunk forward or back.",
        "the largest lean of the trunk forward or back",
        "rad", above=0.0, most=_LYING, relax=(TILTED, 0.3), common=True,
    )  # fmt: skip
    trunk_yaw: float | None = margin(
        None, "Largest turn of the trunk from the direction of travel.",
        "the largest turn of the trunk", "rad", above=0.0, most=_LYING,
        relax=(TILTED, 0.3),
    )  # fmt: skip
    torsional_friction: float | None = margin(
        None, "Largest moment about the vertical that a foot bears, over its load.",
        "the coefficient of torsional friction",
        "m", above=0.0, relax=(0.5, 0.01),  # of a foot far larger than any biped's
    )  # fmt: skip
    step_width: float | None = margin(
        None, "Largest distance of the feet sideways.", "the largest step width", "m", above=0.0
    )
    swing_tilt: float | None = margin(
        None, "Largest roll, pitch and yaw of the swing foot, as sines.",
        "the largest tilt of the swing foot", "rad",
        above=0.0, most=1.0, relax=(TILTED, 0.3), sine=True,
    )  # fmt: skip
    leg_gap: float | None = margin(
        None, "Least distance between the legs' bodies.", "the gap between the bodies of the legs",
        "m", relax=(0.0, -0.1),
    )  # fmt: skip
    arm_gap: float | None = margin(
        None, "Least distance of moving arms from trunk, thighs and each other.",
        "the gap between the arms and other bodies", "m", relax=(0.0, -0.1),
    )  # fmt: skip
    swing_height: float | None = margin(
        None, "Largest height of the swing foot.", "the largest height of the swing foot", "m",
        above=0.0, relax=(0.5, 0.1),  # nobody lifts a foot higher to walk on level ground
    )  # fmt: skip
    landing_speed: float | None = margin(
        None, "Least speed downward at which every corner of the landing foot comes down.",
        "the least speed at which the corners of the foot land", "m/s", least=0.0,
        relax=(0.0, -0.3),
    )  # fmt: skip
    landing_impulse: float | None = margin(
        None, "Largest vertical impulse of the impact over the robot's mass.",
        "the largest vertical impulse at the impact over the mass", "m/s", above=0.0,
        relax=(2.0, 0.3),  # of a foot slammed down
    )  # fmt: skip
    soft_landing: bool = margin(False, "The foot lands at zero speed, without an impact.")
    nosing: float | None = margin(
        None, "On stairs, length before the edges over which the swing foot keeps away.",
        "the distance of the swing foot from the edges of the stairs", "m", above=0.0,
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_margins(self)


def check_declaration(one: object, *names: str) -> None:
    """Check that the class of a constraint or a cost says what it is.

    Args:
        one: an instance.
        names: what it has to declare.

    Raises:
        InputError: a name is missing or no text, `reads` is no tuple of quantities, or it keeps
            values without being a frozen dataclass.
    """
    kind = type(one).__name__
    if missing := [name for name in names if not hasattr(one, name)]:
        raise InputError(
            f"{kind} declares no {' and no '.join(missing)}; its class says what it is "
            "(docs/extending.md)"
        )
    for text in ("name", "unit", "words", "equation"):
        value = getattr(one, text, "-")
        if not (callable(value) or isinstance(value, str)) or (value == "" and text != "unit"):
            raise InputError(f"the {text} of {kind} is {shown(value)}; give a text")
        if isinstance(value, str) and not value.isprintable():
            raise InputError(f"the {text} of {kind} is {shown(value)}; give a text of one line")
    reads = getattr(one, "reads", ())
    if not (isinstance(reads, tuple) and all(isinstance(entry, Quantity) for entry in reads)):
        raise InputError(
            f"{kind} reads {shown(reads)}; give a tuple of quantities: reads = (quantities.TORQUE,)"
        )
    fields_left = any(isinstance(value, Field) for value in vars(type(one)).values())
    mutable = type(one).__hash__ is None  # of a dataclass that is not frozen
    if fields_left or mutable or (vars(one) and not is_dataclass(one)):
        raise InputError(
            f"{kind} keeps values but is no frozen dataclass; write @dataclass(frozen=True) above "
            "its class, so that gait files can record them"
        )


def check_relaxation(one: Constraint, margins: Container[str], constraints: Container[str]) -> None:
    """Check what a constraint says of its margins and of how much of its rows matters.

    Args:
        one: of one's own.
        margins, constraints: names that there are, but for those of its own fields.

    Raises:
        InputError: `change` is no number above 0, `margins` no tuple of texts, or `couplings` names
            what is none, or gives no number.
    """
    kind = type(one).__name__
    if not (is_of_use(one.change) and one.change > 0.0):
        raise InputError(f"change of {kind} is {shown(one.change)}; it must be above 0, {USABLE}")
    if not (isinstance(one.margins, tuple) and all(isinstance(n, str) for n in one.margins)):
        raise InputError(
            f"margins of {kind} is {shown(one.margins)}; give a tuple of names: ('friction',)"
        )
    whole = f'couplings of {kind}; write them as couplings = {{"friction": ("load", 1.0)}}'
    if not isinstance(one.couplings, Mapping):
        raise InputError(f"{shown(one.couplings)} cannot be the {whole}")
    for name, pair in one.couplings.items():
        if not (isinstance(pair, tuple) and len(pair) == 2 and is_of_use(pair[1]) and pair[1]):
            raise InputError(f"{shown({name: pair})} cannot be among the {whole}")
        if not (name in margins or name in declared_margins(one)):
            raise InputError(f"there is no margin {shown(name)}, which is among the {whole}")
        if pair[0] not in constraints:
            raise InputError(f"there is no constraint {shown(pair[0])}, which is among the {whole}")


def failure(error: Exception, one: object) -> str:
    """Return an exception in words, with the line of the file of a constraint or a cost, if any.

    Args:
        error: that a method of it raised.
        one: the constraint or the cost.
    """
    file = getattr(sys.modules.get(type(one).__module__), "__file__", None)
    lines = [at.lineno for at in extract_tb(error.__traceback__) if at.filename == file]
    where = f" (line {lines[-1]} of {Path(str(file)).name})" if lines else ""
    return f"{type(error).__name__}: {error}{where}"


def is_of_use(value: object) -> bool:
    """Return whether a value is a finite number, 0 or of a size with which computing has sense."""
    if not is_finite(value):
        return False
    number = abs(value)
    return number == 0.0 or 1.0 / NUMBER <= number <= NUMBER


def is_finite(value: object) -> TypeGuard[float]:
    """Return whether a value is a finite number."""
    if isinstance(value, bool):  # to Python a kind of int
        return False
    try:
        return isinstance(value, float | int) and math.isfinite(value)
    except OverflowError:  # a whole number beyond every float
        return False


@dataclass(frozen=True)
class ConstraintContext:
    """The walk that a constraint is made for.

    Attributes:
        robot: the biped.
        grid: the instants of the step.
        margins: limits of section 3.2.
        speed: walking speed V [m/s].
        duration: of a step, T [s].
        speed_as: "constraint" or "penalty".
        boundary: "closed" or "lifted".
        schedule: phases and symmetry of the step.
        terrain: under the walk.
        lateral_speed: to the left [m/s].
        turn_rate: to the left [rad/s].
        steps: of what is designed, 2 for a stride.
    """

    robot: Robot
    grid: Grid
    margins: Margins
    speed: float
    duration: float
    speed_as: str = "constraint"
    boundary: str = "closed"
    schedule: Schedule = field(default_factory=Schedule)
    terrain: Terrain = field(default_factory=Level)
    lateral_speed: float = 0.0
    turn_rate: float = 0.0
    steps: int = 1

    @property
    def scales(self) -> Scales:
        """Sizes of the robot, by which rows are scaled."""
        return self.robot.scales

    @property
    def swinging(self) -> NDArray[np.bool_]:
        """At which instants one foot swings, shape (N,)."""
        both = np.array([phase.both for phase in self.schedule.phases])
        return np.asarray(~both[self.phases])

    @property
    def touch_down(self) -> float:
        """Share of the step at which the swing foot lands."""
        return float(self.schedule.changes[-1]) if self.schedule.closing else 1.0

    @property
    def phases(self) -> NDArray[np.int_]:
        """Number of the phase at each instant, shape (N,)."""
        return self.schedule.phase_at(self.grid.instants)


@dataclass(frozen=True)
class ConstraintBlock:
    """The rows of one constraint.

    Attributes:
        name, equation, unit, words, change: of the constraint.
        reads: the quantities, side by side.
        function: from these quantities to r rows at each instant.
        labels: what each of the r rows speaks of: ("right_knee torque", ...).
        lower, upper: limits, shape (K, r); infinite where there is none.
        scale: a change of the value that matters, shape (r,).
        instants: rows of the quantities it looks at, shape (K,).
        times: shares s = t / T of the step of each of the K, or None where time means nothing.
        contacts: of the stance foot at each of the K, by name; empty where it never changes.
        ends: numbers of rows up to the end of each step, every second of which is seen as its
            mirror image; empty where all are of one step.
        mirrored: labels there, of joints and sides as they are.
        period: what all its steps are called.
    """

    name: str
    equation: str
    unit: str
    words: str
    change: float
    reads: tuple[Quantity, ...]
    function: QuantityFunction
    labels: tuple[str, ...]
    lower: Array
    upper: Array
    scale: Array
    instants: NDArray[np.int_]
    times: Array | None
    contacts: tuple[str, ...] = ()
    ends: tuple[int, ...] = ()
    mirrored: tuple[str, ...] = ()
    period: str = "step"

    @property
    def size(self) -> int:
        """Number of rows, K * r."""
        return int(self.lower.size)

    def take(self, values: Mapping[Quantity, Array]) -> Array:
        """Return the instants of its quantities (K, entries) side by side, or of Jacobians."""
        if len(self.reads) == 1:
            return values[self.reads[0]][self.where]
        return np.concatenate([values[one][self.where] for one in self.reads], axis=1)

    @cached_property
    def per_unit(self) -> Array:
        """One over the scale of each row, shape (r, 1)."""
        return 1.0 / self.scale[:, None]

    @cached_property
    def where(self) -> NDArray[np.int_] | slice:
        """The instants, as a slice if they are consecutive: then nothing is copied."""
        if self.instants.size == 0 or np.any(np.diff(self.instants) != 1):
            return self.instants
        return slice(int(self.instants[0]), int(self.instants[-1]) + 1)

    def label(self, instant: int, entry: int) -> str:
        """Return what a row speaks of: "right_knee torque"."""
        return (self.mirrored if self._step(instant) % 2 else self.labels)[entry]

    def describe(self, instant: int, entry: int) -> str:
        """Name a row: "right_knee torque at 80.0 % of the step (toe line)"."""
        label = self.label(instant, entry)
        if self.times is not None:
            contact = f" ({self.contacts[instant]})" if self.contacts else ""
            return f"{label} at {100.0 * self.times[instant]:.1f} % of the {self.period}{contact}"
        names = self.reads[0].rows
        number = self._step(instant)
        later = f"{_ORDINALS[min(number, len(_ORDINALS) - 1)]} step:" if number else ""
        return f"{later} {names[self.instants[instant] % len(names)]} {label}".strip()

    def _step(self, instant: int) -> int:
        """Return the number of the step that a row is of."""
        return bisect_right(self.ends, instant)


_ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth")


class Constraint(ABC):
    """A constraint of a walk; a subclass declares it and makes its rows.

    A constraint of one's own is a frozen dataclass whose fields, made by `margin`, are its numbers:
    see docs/extending.md.

    Attributes:
        name: in certificates and messages, unique: "swing height".
        equation: of the paper, or "own".
        unit: of its rows.
        words: what a person calls it: "height of the swing foot".
        reads: the quantities its rows depend on, all with the same rows.
        margins: names of the numbers that loosen it; its own fields need not be named.
        couplings: margin that multiplies a row of another constraint -> its name and the sign, as
            friction multiplies the load.
        change: scaled change of its limits that matters to a person.
    """

    name: ClassVar[str]
    equation: ClassVar[str] = "own"
    unit: ClassVar[str]
    words: ClassVar[str]
    reads: ClassVar[tuple[Quantity, ...]]
    margins: ClassVar[tuple[str, ...]] = ()
    couplings: ClassVar[Mapping[str, tuple[str, float]]] = {}
    change: ClassVar[float] = 1.0

    def __post_init__(self) -> None:
        check_margins(self)

    def asked(self, context: ConstraintContext) -> bool:
        """Return whether a walk has it: by default, unless one of its margins is None or False."""
        values = [getattr(context.margins, name) for name in self.margins]
        values += [getattr(self, name) for name in declared_margins(self)]
        return all(value is not None and value is not False for value in values)

    @abstractmethod
    def block(self, context: ConstraintContext) -> ConstraintBlock:
        """Return its rows for a walk."""

    def over_step(
        self,
        context: ConstraintContext,
        function: QuantityFunction,
        labels: tuple[str, ...],
        *,
        lower: Array | float = -FREE,
        upper: Array | float = FREE,
        scale: Array | float = 1.0,
        instants: NDArray[np.int_] | None = None,
    ) -> ConstraintBlock:
        """Return rows at every instant of the step, or at some.

        Args:
            context: the walk.
            function: from the quantities to r rows.
            labels: of the r rows.
            lower, upper: limits, broadcast to (K, r).
            scale: a change of the rows that matters, broadcast to (r,).
            instants: indices into the grid, by default all, shape (K,).
        """
        if instants is None:
            instants = np.arange(context.grid.count)
        times, phases = context.grid.instants[instants], context.schedule.phases
        block = self._block(function, labels, lower, upper, scale, instants, times)
        if len(phases) == 1:
            return block
        contacts = tuple(phases[phase].name for phase in context.phases[instants])
        return replace(block, contacts=contacts)

    def once(
        self,
        function: QuantityFunction,
        labels: tuple[str, ...],
        *,
        lower: Array | float = -FREE,
        upper: Array | float = FREE,
        scale: Array | float = 1.0,
    ) -> ConstraintBlock:
        """Return rows of quantities that the step has once (or once per leg); as `over_step`."""
        rows = np.arange(len(self.reads[0].rows))
        return self._block(function, labels, lower, upper, scale, rows, None)

    def _block(
        self,
        function: QuantityFunction,
        labels: tuple[str, ...],
        lower: Array | float,
        upper: Array | float,
        scale: Array | float,
        instants: NDArray[np.int_],
        times: Array | None,
    ) -> ConstraintBlock:
        shape = (instants.size, len(labels))
        return ConstraintBlock(
            name=self.name,
            equation=self.equation,
            unit=self.unit,
            words=self.words,
            change=self.change,
            reads=self.reads,
            function=function,
            labels=labels,
            lower=np.full(shape, lower),
            upper=np.full(shape, upper),
            scale=np.full(shape[1:], scale),
            instants=instants,
            times=times,
        )
