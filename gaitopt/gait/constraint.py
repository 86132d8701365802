"""What a constraint is: its declaration, the numbers a person sets in it, and the rows it gives.

A `Constraint` is declared once: name, equation, unit, words, the quantities it reads, the margins
(numbers) it depends on and how each may be relaxed. Options, TOML keys, records in gait files,
names in messages, the diagnosis and the refinement between the samples follow from that.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from bisect import bisect_right
from collections.abc import Collection, Mapping
from dataclasses import Field, field, fields, is_dataclass, replace
from functools import cached_property, lru_cache
from inspect import getattr_static
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitopt.bounds import USABLE, is_finite, is_of_use, shown
from gaitopt.contact import Schedule
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, did_you_mean, own_code
from gaitopt.gait.functions import QuantityFunction
from gaitopt.gait.grid import Grid
from gaitopt.gait.quantities import Quantity
from gaitopt.gait.terrain import Level, Terrain
from gaitopt.nlp import Array
from gaitopt.settings import check_settings, checked_arguments, setting
from gaitopt.units import SINE

if TYPE_CHECKING:
    from gaitopt.gait.constraints import Margins
    from gaitopt.model.robot import Robot
    from gaitopt.model.scales import Scales

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
        farthest: value to which the diagnosis may loosen it, None: it does not.
        change: of the value that matters to a person, signed, towards `farthest`.
    """

    words: str = ""
    unit: str = ""
    farthest: float | None = None
    change: float = 0.0


@checked_arguments
def margin(
    default: float | bool | None,
    help_text: str,
    words: str = "",
    unit: str = "",
    *,
    relax: tuple[float, float] | None = None,
    sine: bool = False,
    **shown: Any,
) -> Any:
    """Return a dataclass field that is a margin, see `Margin`.

    Args:
        default: its value unless given; None where the constraint is then off, and "none" stands
            for that where people write.
        help_text: of the option, one line.
        words, unit: as in `Margin`.
        relax: `farthest` and `change` of the `Margin`.
        sine: whether it is the sine of an angle, so that an option takes degrees too.
        shown: other attributes of the option, as in `gaitopt.settings.Setting`, and its bounds.

    Raises:
        InputError: its bounds are the wrong way round, or `change` does not lead to `farthest`.
    """
    if relax is not None:
        _check_way(default, *relax)
    declared = Margin(words, unit, *(() if relax is None else relax))
    shown = {"limit": default is None, **shown}
    return field(
        default=default,
        metadata={_KEY: declared, **setting(help_text, SINE if sine else unit, **shown)},
    )


def _check_way(default: float | None, farthest: float, change: float) -> None:
    """Refuse a change that is none, or leads from the default away from the farthest."""
    towards = 0.0 if default is None else farthest - default
    if not (is_finite(farthest) and is_of_use(change) and change and towards * change >= 0.0):
        begin = "a margin" if default is None else f"a margin of {default:g}"
        raise InputError(
            f"relax of {begin} is ({shown(farthest)}, {shown(change)}); give the farthest value, "
            "then a change towards it that matters: relax=(0.0, -0.01) of a margin of 0.05"
        )


def declared_margins(owner: object) -> Mapping[str, Margin]:
    """Return the margins among the fields of a dataclass or of an instance, by name."""
    return _margins_of(owner if isinstance(owner, type) else type(owner))


@lru_cache
def _margins_of(kind: type) -> Mapping[str, Margin]:
    found: tuple[Field[Any], ...] = fields(kind) if is_dataclass(kind) else ()
    return {one.name: one.metadata[_KEY] for one in found if _KEY in one.metadata}


_MISSING = object()
_DECLARED = ("name", "unit", "words", "equation", "reads", "change", "margins", "couplings")


def check_declaration(one: object, *names: str) -> None:
    """Check that the class of a constraint or a cost of one's own says what it is.

    Args:
        names: what it has to declare.

    Raises:
        InputError: a name is missing or no text, `reads` is no tuple of quantities, it keeps values
            without being a frozen dataclass, or a property that says it raises.
    """
    if type(one).__module__.startswith("gaitopt."):
        return
    kind = type(one).__name__
    known = {name: getattr_static(one, name, _MISSING) for name in (*names, *_DECLARED)}
    for name in known:
        if known[name] is not _MISSING:
            with own_code(one, f"{kind} cannot tell its {name}"):
                known[name] = getattr(one, name)
    if missing := [name for name in names if known[name] is _MISSING]:
        raise InputError(
            f"{kind} declares no {' and no '.join(missing)}; its class says what it is "
            "(docs/extending.md)"
        )
    for text in _DECLARED[:4]:
        value = "-" if known[text] is _MISSING else known[text]
        if not (callable(value) or isinstance(value, str)) or (value == "" and text != "unit"):
            raise InputError(f"the {text} of {kind} is {shown(value)}; give a text")
        if isinstance(value, str) and not value.isprintable():
            raise InputError(f"the {text} of {kind} is {shown(value)}; give a text of one line")
    reads = () if known["reads"] is _MISSING else known["reads"]
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


def check_relaxation(
    one: Constraint, margins: Collection[str], constraints: Collection[str]
) -> None:
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
    form = 'write them as couplings = {"friction": ("load", 1.0)}'
    whole = f"couplings of {kind}; {form}"
    if not isinstance(one.couplings, Mapping):
        raise InputError(f"{shown(one.couplings)} cannot be the {whole}")
    for name, pair in one.couplings.items():
        if not (isinstance(pair, tuple) and len(pair) == 2 and is_of_use(pair[1]) and pair[1]):
            raise InputError(f"{shown({name: pair})} cannot be among the {whole}")
        if not (name in margins or name in declared_margins(one)):
            hint = did_you_mean(name, (*margins, *declared_margins(one)))
            raise InputError(
                f"couplings of {kind} name the margin {shown(name)}, which is none; {hint}{form}"
            )
        if pair[0] not in constraints:
            hint = did_you_mean(pair[0], constraints)
            raise InputError(
                f"couplings of {kind} name the constraint {shown(pair[0])}, which is none; "
                f"{hint}{form}"
            )


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
        even: whether its rows are the same at all instants of the step, whichever these are.
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
    even: bool = False

    @property
    def size(self) -> int:
        """Number of rows, K * r."""
        return int(self.lower.size)

    def on(self, grid: Grid) -> ConstraintBlock | None:
        """Return its rows on another grid, or None where it depends on the instants."""
        if self.times is None:
            return self
        if not self.even:
            return None
        shape = (grid.count, len(self.labels))
        return replace(
            self,
            lower=np.full(shape, self.lower[:1]),
            upper=np.full(shape, self.upper[:1]),
            instants=np.arange(grid.count),
            times=grid.instants,
        )

    def take(self, values: Mapping[Quantity, Array]) -> Array:
        """Return the instants of its quantities (K, entries) side by side, or of Jacobians."""
        if len(self.reads) == 1:
            return values[self.reads[0]][self.where]
        return np.concatenate([values[one][self.where] for one in self.reads], axis=1)

    def whole(self, values: Mapping[Quantity, Array]) -> bool:
        """Return whether its rows are all entries of one quantity at all instants, as they are.

        Args:
            values: of every quantity, shape (K, entries).
        """
        chosen = self.function.as_they_are
        if chosen is None or len(self.reads) > 1:
            return False
        shape = values[self.reads[0]].shape
        return self.lower.shape == shape and chosen.indices(shape[1]) == (0, shape[1], 1)

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
        paced: whether its rows depend on speed, duration or turn of the walk.
    """

    name: str
    equation: str = "own"
    unit: str
    words: str
    reads: tuple[Quantity, ...]
    margins: tuple[str, ...] = ()
    couplings: Mapping[str, tuple[str, float]] = MappingProxyType({})
    change: float = 1.0
    paced: ClassVar[bool] = False

    def __post_init__(self) -> None:
        check_settings(self)

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
            function: from the quantities to r rows.
            labels: of the r rows.
            lower, upper: limits, broadcast to (K, r).
            scale: a change of the rows that matters, broadcast to (r,).
            instants: indices into the grid, by default all, shape (K,); chosen by their times,
                `np.flatnonzero(context.grid.instants == context.touch_down)`, as a refinement adds
                instants at the end.
        """
        everywhere = np.ndim(lower) < 2 > np.ndim(upper) and instants is None
        instants = np.asarray(np.arange(context.grid.count) if instants is None else instants)
        times, phases = context.grid.instants[instants], context.schedule.phases
        block = self._block(function, labels, lower, upper, scale, instants, times)
        if len(phases) == 1:
            return replace(block, even=True) if everywhere else block
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
