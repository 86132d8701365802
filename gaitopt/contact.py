"""Contacts of a standing foot, and the schedule of a step: its phases with theirs, its symmetry.

A contact mode says how the foot can move and what the ground can give it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import field
from enum import Enum
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitopt.bounds import is_line, shown
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, own_code
from gaitopt.model.sole import Sole
from gaitopt.nlp import Array
from gaitopt.settings import checked_facts

if TYPE_CHECKING:
    from gaitopt.model.robot import Robot


@checked_facts
@dataclass(frozen=True, eq=False)
class Hinge:
    """A line of the sole that rests on the ground and about which the foot turns.

    It is a joint between the ground and the foot, whose angle is 0 where the foot stands flat.

    Attributes:
        point: on the line, in the sole frame [m], shape (3,).
        axis: unit vector, about which a positive angle lifts the sole, shape (3,): to the left or
            to the right, so that the line is its own mirror image, as the feet are each other's.

    Raises:
        InputError: the point is none, or the axis is another.
    """

    point: Array
    axis: Array

    def __post_init__(self) -> None:
        for name, value in vars(self).copy().items():
            object.__setattr__(self, name, _numbers(value, 3, f"the {name} of a hinge"))
        if not np.array_equal(np.abs(self.axis), [0.0, 1.0, 0.0]):
            raise InputError(
                f"a foot would turn about {np.asarray(self.axis).tolist()}; give a line across it, "
                "[0, 1, 0] or [0, -1, 0]: the other foot turns about the mirror image of the line, "
                "which must be the line itself"
            )

    @cached_property
    def twist(self) -> Array:
        """Twist of the foot per unit of the angle's rate, linear part first, shape (6,).

        It is the same in the sole frame and in the frame of the footprint.
        """
        return np.concatenate([np.cross(self.point, self.axis), self.axis])


class ContactMode(ABC):
    """How a foot stands; a swinging foot has none.

    To add one: a frozen dataclass, here or in a file of its own (docs/extending.md). What it says
    is looked at before a walk is sought.

    Attributes:
        name: in records and messages, unique.
    """

    name: ClassVar[str]

    @abstractmethod
    def hinge(self, sole: Sole) -> Hinge | None:
        """Return the line about which the foot turns, None where the whole sole rests."""

    @abstractmethod
    def bearing(self, sole: Sole, margin: float) -> Array:
        """Return where the centre of pressure may be: front, rear, left, right [m], shape (4,).

        Args:
            sole: the rectangle, in whose frame the result is.
            margin: to be kept from edges beyond which the foot would tip unasked [m].
        """

    @abstractmethod
    def resting(self) -> NDArray[np.bool_]:
        """Return which corners of the sole, as `Sole.corners`, are on the ground, shape (4,)."""


@dataclass(frozen=True)
class FlatFoot(ContactMode):
    """The whole sole rests on the ground.

    The foot stands still; the centre of pressure is inside the sole, Eqs. (37)-(38).
    """

    name: ClassVar[str] = "flat"

    def hinge(self, sole: Sole) -> None:
        """Return None: the foot cannot turn."""
        del sole

    def bearing(self, sole: Sole, margin: float) -> Array:
        return np.array(
            [sole.toe - margin, sole.heel + margin, sole.left - margin, sole.right + margin]
        )

    def resting(self) -> NDArray[np.bool_]:
        return np.ones(4, dtype=np.bool_)


@checked_facts
@dataclass(frozen=True)
class ToeLine(ContactMode):
    """The front edge of the sole rests on the ground and the foot turns about it, the heel rising.

    The centre of pressure is within a strip behind the edge: a real one is round, or a plate.

    Attributes:
        strip: its length [m].
    """

    name: ClassVar[str] = "toe line"
    strip: float

    def hinge(self, sole: Sole) -> Hinge:
        return Hinge(np.array([sole.toe, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))

    def bearing(self, sole: Sole, margin: float) -> Array:
        return np.array([sole.toe, sole.toe - self.strip, sole.left - margin, sole.right + margin])

    def resting(self) -> NDArray[np.bool_]:
        return np.array([True, True, False, False])


@checked_facts
@dataclass(frozen=True)
class HeelLine(ContactMode):
    """The rear edge of the sole rests on the ground and the foot turns about it, the toe rising.

    The centre of pressure is within a strip ahead of the edge: a heel is round.

    Attributes:
        strip: its length [m].
    """

    name: ClassVar[str] = "heel line"
    strip: float

    def hinge(self, sole: Sole) -> Hinge:
        return Hinge(np.array([sole.heel, 0.0, 0.0]), np.array([0.0, -1.0, 0.0]))

    def bearing(self, sole: Sole, margin: float) -> Array:
        return np.array(
            [sole.heel + self.strip, sole.heel, sole.left - margin, sole.right + margin]
        )

    def resting(self) -> NDArray[np.bool_]:
        return np.array([False, False, True, True])


BOTH_FEET = "both feet"
"""Name of a phase in which both feet stand flat."""
BUILT_IN = (FlatFoot, ToeLine, HeelLine)
_EDGE = 1e-9
"""By how much a line or a strip may lie beyond its sole [m]: rounding of their sums."""


def _numbers(value: object, size: int, what: str) -> Array:
    """Return what code of one's own gives as an array of finite numbers, shape (size,).

    Raises:
        InputError: it is none.
    """
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        array = np.array(None)
    if array.dtype.kind not in "fiu" or array.shape != (size,) or not np.isfinite(array).all():
        raise InputError(f"{what} is {shown(value)}; give an array of {size} numbers")
    return array.astype(float)


def _resting(contact: ContactMode) -> NDArray[np.bool_]:
    """Return which corners of the sole rest in a contact, whose class is looked at.

    Raises:
        InputError: it is no contact mode, has no name of its own, or does not say it of four.
    """
    if not isinstance(contact, ContactMode):
        raise InputError(
            f"the contact of a phase is {shown(contact)}; give an instance of a ContactMode, as "
            "FlatFoot()"
        )
    name, kind = getattr(contact, "name", None), type(contact)
    taken = [BOTH_FEET, *(one.name for one in BUILT_IN if one is not kind)]
    if not is_line(name) or not name or name in taken:
        raise InputError(
            f"the name of the contact mode {kind.__name__} is {shown(name)}; give a text of one "
            f"line that is none of {', '.join(taken)}"
        )
    with own_code(contact, f"the contact '{name}' does not say which corners rest"):
        corners = contact.resting()
    if getattr(corners, "dtype", None) != np.bool_ or corners.shape != (4,) or not corners.any():
        raise InputError(
            f"resting() of the contact '{name}' returns {shown(corners)}; return an array of four "
            "booleans, not all False, as np.array([True, True, False, False]) for the front edge"
        )
    return corners


def check_contacts(schedule: Schedule, sole: Sole) -> None:
    """Check what the contacts of a schedule say of a sole.

    Raises:
        InputError: a hinge is none, is not where the foot rests or would turn it into the ground,
            or the centre of pressure may be where no sole is.
    """
    edges = FlatFoot().bearing(sole, 0.0)
    for phase in schedule.phases:
        contact = phase.contact
        what, resting = f"the contact '{contact.name}'", _resting(contact)
        with own_code(contact, f"{what} has no hinge"):
            hinge = contact.hinge(sole)
        if isinstance(hinge, Hinge):
            _check_hinge(hinge, resting, sole, what)
        elif hinge is not None:
            raise InputError(f"hinge() of {what} returns {shown(hinge)}; return a Hinge, or None")
        if (hinge is None) != resting.all():
            raise InputError(
                f"{what} has {'no' if hinge is None else 'a'} hinge, and {resting.sum()} of 4 "
                "corners rest; a foot that turns rests on fewer, one that does not on all of them"
            )
        with own_code(contact, f"{what} does not say where it bears"):
            found = contact.bearing(sole, 0.0)
        front, rear, left, right = bearing = _numbers(found, 4, f"what bearing() of {what} returns")
        over = np.array([1.0, -1.0, 1.0, -1.0]) * (bearing - edges)
        if not (front > rear and left > right and over.max() <= _EDGE):
            raise InputError(
                f"{what} bears from {rear:g} to {front:g} m ahead and from {right:g} to {left:g} m "
                f"to the left; the sole is from {sole.heel:g} to {sole.toe:g} m and from "
                f"{sole.right:g} to {sole.left:g} m: stay within it, as by a shorter strip "
                "(toe_strip, heel_strip)"
            )


def _check_hinge(hinge: Hinge, resting: NDArray[np.bool_], sole: Sole, what: str) -> None:
    x, _, z = hinge.point
    if not sole.heel - _EDGE <= x <= sole.toe + _EDGE or z != 0.0:
        raise InputError(
            f"{what} turns the foot about a line at x = {x:g} m, z = {z:g} m; give one of the "
            f"sole, from {sole.heel:g} to {sole.toe:g} m, at z = 0"
        )
    if not (np.cross(hinge.axis, sole.corners[~resting] - hinge.point)[:, 2] > 0.0).all():
        raise InputError(
            f"{what} has the axis {hinge.axis.tolist()}, about which a positive angle presses a "
            "corner that does not rest into the ground; give the opposite one, or another line"
        )


AFTER = 1e-12
"""Share of the step by which the instant just after a change of phase follows the one before it."""


class PhaseEnd(Enum):
    """How a phase ends."""

    SMOOTH = "smooth"
    """The contact changes; no velocity jumps."""

    FOOT_FLAT = "foot flat"
    """The stance foot, which turns about a line of its sole, meets the ground with the whole of it,
    by an impact."""

    TOUCH_DOWN = "touch-down"
    """The swing foot lands flat at zero speed; both feet stand from then on."""

    LIFT_OFF = "lift-off"
    """The stance foot leaves at rest; the foot that has landed stands in the next step."""

    IMPACT = "impact"
    """The swing foot lands on the contact of the first phase; the stance foot leaves, or stays if
    both stand from then on."""


@checked_facts
@dataclass(frozen=True)
class Phase:
    """A part of a step in which the stance foot keeps one contact; the other foot swings.

    Attributes:
        contact: of the stance foot.
        end: share of the step at which it ends, s = t / T.
        ends_by: how it ends.
        both: whether the other foot stands too, flat.
    """

    contact: ContactMode
    end: float = 1.0
    ends_by: PhaseEnd = PhaseEnd.IMPACT
    both: bool = False

    @property
    def name(self) -> str:
        """What it is called in messages: as its contact, or "both feet"."""
        return BOTH_FEET if self.both else self.contact.name


class Symmetry(ABC):
    """How the next step follows from this one.

    Attributes:
        name: in records.
        reflection: signs of a vector (forward, left, up) of this step in the next, shape (3,).
    """

    name: ClassVar[str]
    reflection: ClassVar[tuple[float, float, float]]

    @abstractmethod
    def joint_map(self, robot: Robot) -> Array:
        """Return E with joints of the next step = E joints of this one, constant, shape (n, n)."""


@dataclass(frozen=True)
class LegExchange(Symmetry):
    """The next step is the mirror image of this one: the legs change roles, Eqs. (26)-(27)."""

    name = "leg exchange"
    reflection = (1.0, -1.0, 1.0)

    def joint_map(self, robot: Robot) -> Array:
        """Return the leg exchange of the robot."""
        return robot.mirror


@checked_facts
@dataclass(frozen=True)
class Schedule:
    """What happens in a step, and what comes after it.

    Attributes:
        phases: in order; the last one ends with the step, by an impact, or by lift-off after a
            phase in which both feet stand, which a touch-down at zero speed or an impact begins.
        symmetry: how the next step follows.

    Raises:
        InputError: the phases do not make a step.
    """

    phases: tuple[Phase, ...] = (Phase(FlatFoot()),)
    symmetry: Symmetry = field(default_factory=LegExchange)

    def __post_init__(self) -> None:
        ends = np.array([0.0, *(phase.end for phase in self.phases)])
        if not self.phases or ends[-1] != 1.0 or not (np.diff(ends) > 2.0 * AFTER).all():
            raise InputError(
                f"the phases of a step end at {ends[1:].tolist()} of it; their ends must increase "
                "above 0 and the last must be 1"
            )
        rest = [_resting(phase.contact) for phase in self.phases]
        kinds = [phase.ends_by for phase in self.phases]
        leaving = PhaseEnd.LIFT_OFF
        smooth = [PhaseEnd.SMOOTH] * len(kinds)
        if self.slapping and not rest[0].all():
            kinds[0] = PhaseEnd.SMOOTH
        closing = [[*smooth[2:], one, leaving] for one in (PhaseEnd.TOUCH_DOWN, PhaseEnd.IMPACT)]
        if kinds not in ([*smooth[1:], PhaseEnd.IMPACT], *closing):
            raise InputError(
                "the last phase of a step, and no other, ends with an impact; or the last but one "
                "with a touch-down or an impact and the last with a lift-off; the first ends with "
                "the foot flat only where it turns about a line"
            )
        if [phase.both for phase in self.phases] != [one is leaving for one in kinds]:
            raise InputError("both feet stand from the touch-down to the lift-off, and else never")
        flat = [bool(resting.all()) for resting in rest]
        inner = flat[1:-1]
        if self.closing and self.phases[-2].contact == self.last.contact:
            inner = inner[:-1]  # it keeps turning as the other foot comes to stand
        if not all(inner) or not any(flat):
            raise InputError(
                "the stance foot turns about a line of its sole in a phase that is neither the "
                "first nor the last, or in all of them; let it stand flat between"
            )

    @property
    def first(self) -> Phase:
        """The phase that the impact begins; on its contact the swing foot lands."""
        return self.phases[0]

    @property
    def contacts(self) -> tuple[ContactMode, ...]:
        """The contacts on which the stance foot may turn: of the landing, before the next one."""
        return (self.first.contact, self.last.contact) if len(self.phases) > 1 else ()

    @property
    def closing(self) -> bool:
        """Whether both feet stand at the end of the step."""
        return self.last.both

    @property
    def striking(self) -> bool:
        """Whether the phase in which both feet stand begins with an impact."""
        return self.closing and self.phases[-2].ends_by is PhaseEnd.IMPACT

    @property
    def slapping(self) -> bool:
        """Whether the foot that landed on a line comes to lie flat by an impact."""
        return self.first.ends_by is PhaseEnd.FOOT_FLAT

    @property
    def turns_from(self) -> float:
        """Share of the step from which on the stance foot has its last contact."""
        begin = 0.0
        for one, other in pairwise(self.phases):
            if one.contact != other.contact:
                begin = one.end
        return begin

    @property
    def last(self) -> Phase:
        """The phase that the impact ends."""
        return self.phases[-1]

    @cached_property
    def changes(self) -> Array:
        """Shares of the step at which one phase follows another, shape (phases - 1,)."""
        return np.array([phase.end for phase in self.phases[:-1]])

    def knots(self, inner: int) -> Array:
        """Return where splines over the step have knots: its ends, `inner` more, every change.

        The inner ones share the phases by their lengths; with fewer than the changes they are at
        those alone.

        Args:
            inner: number of knots between the ends, the changes among them.

        Returns:
            Shares of the step, increasing from 0 to 1, shape (inner + 2,) or more.
        """
        return _shared_knots((0.0, *self.changes.tolist(), 1.0), inner)

    def phase_at(self, instants: Array) -> NDArray[np.int_]:
        """Return the number of the phase at each instant s; the instant of a change is before it.

        Args:
            instants: shares of the step, shape (N,).
        """
        return np.searchsorted(self.changes, instants, side="left")


@lru_cache(maxsize=64)
def _shared_knots(ends: tuple[float, ...], inner: int) -> Array:
    knots = shared_knots(np.array(ends), inner)
    knots.flags.writeable = False
    return knots


def shared_knots(ends: Array, inner: int) -> Array:
    """Return ends of phases and knots between them, which share the phases by their lengths.

    Args:
        ends: increasing, the first and the last of the spline too, shape (k,).
        inner: number of knots between the first and the last, the other ends among them.
    """
    lengths = np.diff(ends)
    pieces = np.ones(lengths.size, dtype=int)
    while pieces.sum() < inner + 1:
        pieces[np.argmax(lengths / pieces)] += 1
    parts = [np.linspace(ends[k], ends[k + 1], n + 1)[1:] for k, n in enumerate(pieces)]
    return np.concatenate([ends[:1], *parts])
