"""The constraints of section 3.2 and the few a real walk needs besides, with their margins.

To add one: a field of `Margins` if it has a number of its own, a class, a place in `CONSTRAINTS`.
Option, TOML key, record, messages, diagnosis and refinement follow. Constraints of one's own need
not stand here: see docs/extending.md.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gaitopt.actuators.motors import JointMotor, joint_motors, joint_motors_of
from gaitopt.contact import AFTER, ContactMode, FlatFoot
from gaitopt.dataclass import dataclass
from gaitopt.gait import quantities
from gaitopt.gait.constraint import FREE, Constraint, ConstraintBlock, ConstraintContext, margin
from gaitopt.gait.functions import (
    Entries,
    Followers,
    FrictionCone,
    Length,
    Linear,
    QuantityFunction,
    StrideSpeed,
    Torsion,
)
from gaitopt.gait.motor_space import LoopMotors
from gaitopt.gait.quantities import CORNER_NAMES, Quantity
from gaitopt.gait.terrain import AboveProfile
from gaitopt.model.sole import sole_edge_speeds, sole_tilt
from gaitopt.nlp import Array
from gaitopt.settings import check_settings, checked

if TYPE_CHECKING:
    from gaitopt.mechanics.capsule_distance import CapsulePairs

_SIZES = {
    "N": 500.0, "N·m": 100.0, "N·s": 50.0, "N·m·s": 5.0, "m": 0.1, "rad": 0.1, "m/s": 1.0,
    "rad/s²": 10.0,
}  # fmt: skip
"""Changes of rows that matter, by their unit, of the thirteen-link biped; those of other robots are
in proportion, as all sizes here, see `Scales`."""
SLIPPERIEST, STICKIEST = 1e-3, 100.0
"""Bounds of the coefficient of friction of a ground: skates on ice have some 0.005, slicks of
dragsters some 4."""
_TORSION = 0.2  # of these, where a moment is one of torsional friction
FORCE_SMOOTHING = 0.05  # N, rounds the tip of the friction cone
IMPULSE_SMOOTHING = 10**-4.5  # N.s
LEAST_FORCE = 1.0  # N, where the centre of pressure is given up
LEAST_IMPULSE = 1e-3  # N.s, the same

EDGES = ("front", "rear", "left", "right")
_SINKING = 29  # a foot that may sink does so for about a thirtieth of the step
_LANDING_SIZE = 0.01  # of these, where heights vanish at the end: as fine as what they are there
_STEEPER = 1.001  # refinement leaves their slope at the end short by less than a thousandth
_LANDING = 12  # power that leaves the profile of the landing to the last fifth of the step
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
        "the coefficient of friction", least=SLIPPERIEST, most=STICKIEST, metavar="mu",
        common=True,
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
        check_settings(self)


def _size(context: ConstraintContext, unit: str) -> float:
    """Return the change of rows of a unit that matters, by which they are scaled."""
    return _SIZES[unit] * context.scales.of_unit(unit)


def _corner_entries(axis: int, factor: float = 1.0) -> Entries:
    """Return one coordinate of the four corners of the swing sole: 0 forward, 1 left, 2 up."""
    count = len(quantities.CORNERS.entries)
    return Entries(slice(axis, count, 3), count, factor)


UNLIMITED_HEIGHT = -1.0  # m: no limit of a foot that has landed, whose rows are there all the same


def _while_aloft(context: ConstraintContext) -> tuple[NDArray[np.int_], Array, NDArray[np.bool_]]:
    """Return the instants inside the step, the share of the swing that is over, where it lasts."""
    instants = context.grid.instants
    inside = np.flatnonzero((instants > 0.0) & (instants < 1.0))
    s = instants[inside] / context.touch_down
    return inside, np.minimum(s, 1.0), s < 1.0


def _above_ground(context: ConstraintContext) -> tuple[QuantityFunction, tuple[str, ...]]:
    """Return heights of the swing sole above the ground, and the names of its points.

    They are its corners; where the ground is no plane, more along both sides.
    """
    sole, step = context.robot.sole, context.speed * context.duration
    profile = context.terrain.profile(sole, step, context.margins.nosing)
    if profile is None:
        return _corner_entries(2), CORNER_NAMES
    above = AboveProfile.of_sole(profile, sole)
    between = tuple(
        f"{side} edge, {k + 1} of {len(above.points) // 2 - 2} from the toe,"
        for k in range(len(above.points) // 2 - 2)
        for side in ("left", "right")
    )
    return above, (*CORNER_NAMES, *between)


_BETWEEN_CORNERS = 1e-3
"""How much nearer to the ground than the corners the points between them may come [m]: above level
ground their rows would else be held where those of the corners are, and say the same."""


class JointTorque(Constraint):
    """Eq. (28): |Gamma_i| <= Gamma_i,max."""

    name, equation, unit, words = "torque", "(28)", "N·m", "joint torque"
    reads = (quantities.TORQUE,)

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        limit = imposed_limit(context.robot.limits.torque, context.margins.torque_limit)
        return _joints(self, context, -limit, limit, _finite(limit))


class JointSpeed(Constraint):
    """Eq. (29): |dq_i| <= dq_i,max."""

    name, equation, unit, words = "speed", "(29)", "rad/s", "joint speed"
    reads = (quantities.RATES,)

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        limit = imposed_limit(context.robot.limits.speed, context.margins.speed_limit)
        return _joints(self, context, -limit, limit, _finite(limit))


class Foot(NamedTuple):
    """A foot that the ground presses on, all the time or at an impact, as its constraints read it.

    Attributes:
        reads: the wrench of the ground on it, or its impulse.
        load: name of the constraint of its load.
        others: what the names of the others begin with.
        words: of its constraints, by kind.
        asked: whether a walk has it.
    """

    reads: Quantity
    load: str
    others: str
    words: Mapping[str, str]
    asked: Callable[[ConstraintContext], bool]

    @property
    def struck(self) -> bool:
        """Whether it takes an impulse."""
        return self.reads in (quantities.IMPULSE, quantities.REAR_IMPULSE)

    def label(self, context: ConstraintContext) -> str:
        """Return what labels of its rows begin with."""
        if self.reads is quantities.REAR_IMPULSE:
            return f"{'foot as it lies flat' if context.schedule.slapping else 'rear foot'}, "
        return "front foot, " if self.reads is quantities.FRONT_WRENCH else ""


def _impact(context: ConstraintContext) -> bool:
    """Return whether a walk has an impact; one at zero speed says nothing."""
    schedule = context.schedule
    gentle = schedule.closing and not schedule.striking
    return not (context.margins.soft_landing or gentle)


STANCE = Foot(
    quantities.WRENCH, "load", "",
    {
        "load": "load on the stance foot", "friction": "friction on the ground",
        "cop": "centre of pressure", "torsion": "torsional friction under the foot",
    },
    lambda _: True,
)  # fmt: skip
FRONT = Foot(
    quantities.FRONT_WRENCH, "front load", "front ",
    {
        "load": "load on the front foot", "friction": "friction under the front foot",
        "cop": "centre of pressure of the front foot",
        "torsion": "torsional friction under the front foot",
    },
    lambda context: context.schedule.closing,
)  # fmt: skip
LANDING = Foot(
    quantities.IMPULSE, "impulse", "impulse ",
    {
        "load": "vertical impulse at the impact", "friction": "friction at the impact",
        "cop": "centre of pressure at the impact", "torsion": "torsional friction at the impact",
    },
    _impact,
)  # fmt: skip
STRUCK = Foot(
    quantities.REAR_IMPULSE, "rear impulse", "rear impulse ",
    {
        "load": "vertical impulse on the rear foot",
        "friction": "friction under the rear foot at the impact",
        "cop": "centre of pressure under the rear foot at the impact",
        "torsion": "torsional friction under the rear foot at the impact",
    },
    lambda context: context.schedule.striking or context.schedule.slapping,
)  # fmt: skip
"""A foot that stands at an impact, section 2.4.1: the rear one where both stay, or the stance foot
as it comes to lie flat."""


class _OnFoot(Constraint):
    """What must hold of the ground's wrench on a foot, or of its impulse at an impact."""

    kind: ClassVar[str]
    equations: ClassVar[tuple[str, str]]  # of a wrench, of an impulse
    units: ClassVar[tuple[str, str]]
    coupled: ClassVar[Mapping[str, float]] = {}  # margin -> sign with which it multiplies the load

    def __init__(self, foot: Foot = STANCE) -> None:
        self.foot, self.reads = foot, (foot.reads,)
        self.name = foot.load if self.kind == "load" else f"{foot.others}{self.kind}"
        self.words = foot.words[self.kind]
        self.equation, self.unit = self.equations[foot.struck], self.units[foot.struck]
        self.couplings = {margin: (foot.load, sign) for margin, sign in self.coupled.items()}

    def asked(self, context: ConstraintContext) -> bool:
        return self.foot.asked(context) and super().asked(context)

    def rows(
        self,
        context: ConstraintContext,
        function: QuantityFunction,
        labels: Iterable[str],
        lower: Array | float = 0.0,
        scale: float | None = None,
    ) -> ConstraintBlock:
        """Return rows with a lower limit, wherever the foot bears something.

        Rows of a front foot ask nothing before it stands, where all are 0. They are there all the
        same, so that extremes are located between the instants.
        """
        scale = _size(context, self.unit) if scale is None else scale
        before = self.foot.label(context)
        named = tuple(f"{before}{label}" for label in labels)
        if self.foot.struck:
            return self.once(function, named, lower=lower, scale=scale)
        if self.foot is FRONT:
            lower = np.where(context.swinging[:, None], -scale, lower)
        return self.over_step(context, function, named, lower=lower, scale=scale)


class Load(_OnFoot):
    """Eqs. (35)-(36): a foot keeps pressing on the ground, and the ground pushes it up."""

    kind, equations, units = "load", ("(35)", "(36)"), ("N", "N·s")

    def __init__(self, foot: Foot = STANCE) -> None:
        super().__init__(foot)
        self.margins = ("minimum_load",) if foot is STANCE else ()

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        if self.foot.struck:
            return self.rows(context, Entries(slice(2, 3), 6), ["vertical impact impulse"])
        lower: Array | float = LEAST_FORCE * context.scales.force
        if self.foot is STANCE:
            least, swinging = context.margins.minimum_load, context.swinging
            lower = least if swinging.all() else np.where(swinging, least, lower)[:, None]
        return self.rows(context, Entries(slice(2, 3), 6), ["vertical ground force"], lower)


class Friction(_OnFoot):
    """Eqs. (33)-(34): the force, or the impulse, stays inside the friction cone."""

    kind, equations, units = "friction", ("(33)", "(34)"), ("N", "N·s")
    margins, coupled = ("friction",), MappingProxyType({"friction": 1.0})

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        smoothing = IMPULSE_SMOOTHING if self.foot.struck else FORCE_SMOOTHING
        rounded = smoothing * context.scales.of_unit(self.unit)
        cone = FrictionCone(context.margins.friction, rounded)
        return self.rows(context, cone, [f"{'impulse ' * self.foot.struck}friction cone margin"])


class CentreOfPressure(_OnFoot):
    """Eqs. (37)-(38) as moments about the edges: they stay linear when the load vanishes.

    At an impact a foot does not tip.
    """

    kind, equations, units = "cop", ("(37)-(38)", "3.2.3"), ("N·m", "N·m·s")
    coupled = MappingProxyType({"cop_margin": -1.0})

    def __init__(self, foot: Foot = STANCE) -> None:
        super().__init__(foot)
        self.margins = ("cop_margin", "impulse_cop") if foot.struck else ("cop_margin",)

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        impulsive = "impulsive " if self.foot.struck else ""
        labels = [f"{impulsive}centre of pressure, moment about the {edge} edge" for edge in EDGES]
        schedule, lower = context.schedule, np.zeros(4)
        contacts: list[ContactMode] = [FlatFoot()]
        if self.foot is STANCE:
            contacts = [phase.contact for phase in schedule.phases]
        elif self.foot is LANDING:
            contacts = [schedule.first.contact]
            if not contacts[0].resting().all():  # on a line it is ahead and behind, whatever x
                lower[:2] = -FREE
        elif self.foot is STRUCK and not schedule.slapping:
            contacts = [schedule.last.contact]
        rows = np.stack([_edge_moments(context, contact) for contact in contacts])
        moments = Linear(rows[0] if len(rows) == 1 else rows[context.phases])
        return self.rows(context, moments, labels, lower)


class TorsionalFriction(_OnFoot):
    """Beyond (33): |moment about the vertical through the centre of pressure| <= c f_z."""

    kind, equations, units = "torsion", ("3.2", "3.2"), ("N·m", "N·m·s")
    margins, coupled = ("torsional_friction",), MappingProxyType({"torsional_friction": 1.0})

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        least, unit = (LEAST_IMPULSE, "N·s") if self.foot.struck else (LEAST_FORCE, "N")
        coefficient = context.margins.torsional_friction or 0.0
        torsion = Torsion(coefficient, least * context.scales.of_unit(unit))
        what = f"{'impulse ' * self.foot.struck}torsional friction margin"
        labels = [f"{what} to the {side}" for side in ("left", "right")]
        return self.rows(context, torsion, labels, scale=_TORSION * _size(context, self.unit))


def on_foot(foot: Foot) -> tuple[Constraint, ...]:
    """Return what a foot that the ground presses on must keep."""
    return Load(foot), Friction(foot), CentreOfPressure(foot), TorsionalFriction(foot)


class FootAngle(Constraint):
    """Beyond section 3.2: while the stance foot turns about a line, the rest of it stays above."""

    name, equation, unit, words = "foot angle", "3.2", "rad", "angle of the stance foot"
    reads = (quantities.FOOT_TURN,)

    def asked(self, context: ConstraintContext) -> bool:
        return any(_turning(context))

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        changes, instants = context.schedule.changes, context.grid.instants
        landed, leaving = _turning(context)
        # where it begins to turn, or ends to, it is 0 whatever x, and at the landing a parameter
        inside = landed & (instants > 0.0) & (instants < changes[0])
        inside |= leaving & (instants > context.schedule.turns_from + 2.0 * AFTER)
        lower = np.where(inside, 0.0, -TILTED)
        labels = ("angle of the stance foot",)
        return self.over_step(context, Entries(slice(0, 1), 3), labels, lower=lower[:, None])


class FootLift(FootAngle):
    """The stance foot does not turn into the ground where it begins to turn, or ends to.

    Angle and rate vanish there, so that its angular acceleration tells; not where it comes to lie
    flat with a rate.
    """

    name, unit, words, change = "foot lift", "rad/s²", "start of the stance foot's turn", 10.0

    def asked(self, context: ConstraintContext) -> bool:
        return any(_resting(context))

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        changes, (landed, leaving) = context.schedule.changes, _resting(context)
        begins = np.array([context.schedule.turns_from])[: int(leaving)]
        at = np.concatenate([changes[:landed], begins + AFTER])
        instants = np.flatnonzero(np.isin(context.grid.instants, at))
        labels = ("angular acceleration of the stance foot",)
        rows = Entries(slice(2, 3), 3)
        return self.over_step(
            context, rows, labels, lower=0.0, scale=_size(context, self.unit), instants=instants
        )


class SoftLanding(Constraint):
    """Section 2.4.1: a foot that lands at zero speed; there is no impact, the impulse is zero."""

    name, equation, unit, words = "soft landing", "2.4.1", "N·s, N·m·s", "landing at zero speed"
    reads, margins = (quantities.IMPULSE,), ("soft_landing",)

    def asked(self, context: ConstraintContext) -> bool:
        return not context.schedule.closing and super().asked(context)

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        flat = context.schedule.first.contact.resting().all()
        held = list(range(6)) if flat else [0, 1, 2, 3, 5]  # about a line there is none anyway
        labels = tuple(f"impulse, {quantities.IMPULSE.entries[k]}" for k in held)
        scale = np.where(np.array(held) < 3, _size(context, "N·s"), _size(context, "N·m·s"))
        return self.once(Linear(np.eye(6)[held]), labels, lower=0.0, upper=0.0, scale=scale)


class LiftOff(Constraint):
    """Section 2.4.1, first case: the resting corners of the old stance foot leave the ground."""

    name, equation, unit, words = "lift-off", "2.4.1", "m/s", "lift-off of the rear foot"
    reads, margins, change = (quantities.SOLE_TWIST,), ("liftoff_speed",), 0.1

    def asked(self, context: ConstraintContext) -> bool:
        closing = context.schedule.closing
        return not closing and _impact(context) and super().asked(context)

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        resting = context.schedule.last.contact.resting()
        speeds = Linear(sole_edge_speeds(context.robot.sole.corners[resting]))
        labels = tuple(
            f"rear foot {CORNER_NAMES[c]} lift-off speed" for c in np.flatnonzero(resting)
        )
        return self.once(
            speeds, labels, lower=context.margins.liftoff_speed, scale=_size(context, self.unit)
        )


class _LeastHeight(Constraint):
    """While the swing foot is aloft, its corners keep a least height that depends on the time."""

    reads, paced = (quantities.CORNERS,), True
    label: ClassVar = "height"
    share: ClassVar = 1.0  # of what matters of heights

    @abstractmethod
    def _least(self, context: ConstraintContext, s: Array) -> Array:
        """Return the heights (N,) [m] at shares s (N,) of the time aloft."""

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        inside, s, aloft = _while_aloft(context)
        function, points = _above_ground(context)
        labels = tuple(f"swing foot {point} {self.label}" for point in points)
        length = context.scales.length
        least = np.where(aloft, self._least(context, s), UNLIMITED_HEIGHT * length)
        lower = np.repeat(least[:, None], len(points), axis=1)
        lower[:, len(CORNER_NAMES) :] -= _BETWEEN_CORNERS * length
        return self.over_step(
            context,
            function,
            labels,
            lower=lower,
            scale=self.share * _size(context, "m"),
            instants=inside,
        )


class Clearance(_LeastHeight):
    """Section 3.2.3: the swing foot's corners stay above a smooth profile.

    A foot that may leave the ground with a negative speed sinks at first, whatever it does then;
    the profile is lowered by as much as that.
    """

    name, equation, unit, words = "clearance", "3.2.3", "m", "clearance of the swing foot"
    margins = ("clearance", "liftoff_speed")

    def _least(self, context: ConstraintContext, s: Array) -> Array:
        margins = context.margins
        profile = margins.clearance * np.sin(np.pi * s) ** 2
        if margins.liftoff_speed < 0.0:
            profile += margins.liftoff_speed * context.duration * s * (1.0 - s) ** _SINKING
        return np.asarray(profile)


class Lateral(Constraint):
    """Eq. (32) over the whole step: the swing foot stays beside the stance foot."""

    name, equation, unit, words = "lateral", "(32)", "m", "gap between the feet"
    reads, margins = (quantities.CORNERS,), ("lateral_gap",)

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        side, sole = context.robot.legs.side, context.robot.sole
        edge = sole.left if side > 0 else -sole.right
        labels = tuple(f"swing foot {c} sideways" for c in CORNER_NAMES)
        return self.over_step(
            context, _corner_entries(1, side), labels,
            lower=edge + context.margins.lateral_gap, scale=_size(context, "m"),
        )  # fmt: skip


class KneeFlexion(Constraint):
    """Both knees stay bent by a margin from the straight leg."""

    name, equation, unit, words = "knee", "3.2.1", "rad", "bend of the knees"
    reads, margins, change = (quantities.ANGLES,), ("knee_flexion",), 0.3

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        legs, coupling = context.robot.legs, context.robot.coupling
        first, second = legs.knees
        pair = slice(first, second + 1, second - first)
        bends: QuantityFunction = Entries(pair, len(coupling.names), legs.flexion)
        if not coupling.none:
            bends = Followers(coupling, pair, legs.flexion)
        straight = legs.straight
        return self.over_step(
            context, bends,
            tuple(f"{coupling.names[k]} flexion" for k in legs.knees),
            lower=legs.flexion * straight + context.margins.knee_flexion,
        )  # fmt: skip


class LegLength(Constraint):
    """Eq. (31): d(hip, foot) <= l_hip in double support."""

    name, equation, unit, words = "leg length", "(31)", "m", "length of the legs"
    reads, margins = (quantities.LEGS,), ("leg_extension",)

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        longest = (context.margins.leg_extension or 1.0) * context.robot.legs.reach
        return self.once(
            Length(), ("hip-ankle distance",), upper=longest, scale=_size(context, "m")
        )


class JointRange(Constraint):
    """Eq. (30): q_min <= q <= q_max."""

    name, equation, unit, words = "range", "(30)", "rad", "joint range"
    reads, margins = (quantities.ANGLES,), ("joint_range",)

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        limits = context.robot.limits
        return _joints(self, context, limits.lower, limits.upper, np.ones(limits.lower.size))


class WalkingSpeed(Constraint):
    """Eq. (39): V T - d = 0; of a stride of two steps the same forward and to the left."""

    name, equation, unit, words = "walking speed", "(39)", "m", "walking speed"
    reads, change, paced = (quantities.TRAVEL,), 0.1, True

    def asked(self, context: ConstraintContext) -> bool:
        return context.speed_as == "constraint"

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        length = context.scales.length
        ahead = "way that the speed asks for - way"
        if context.steps == 1:
            rows = Linear(np.array([[-1.0, context.speed]]))
            return self.once(rows, (ahead,), lower=0.0, upper=0.0, scale=length)
        way = StrideSpeed(context.speed, context.lateral_speed, context.turn_rate)
        labels = (ahead, "way to the left that the speed asks for - way")
        block = self.once(way, labels, lower=0.0, upper=0.0, scale=length)
        return replace(block, reads=(quantities.ADVANCE,))


class Tread(Constraint):
    """In a stride over ground that repeats with the steps, either step is as long as the other."""

    name, equation, unit, words = "tread", "(39)", "m", "length of the first step"
    reads, change, paced = (quantities.ADVANCE,), 0.1, True

    def asked(self, context: ConstraintContext) -> bool:
        return context.steps > 1 and context.terrain.shaped

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        rows = Linear(np.array([[0.0, 0.0, context.speed, -1.0]]))
        labels = ("way that the speed asks for - length of the first step",)
        return self.once(rows, labels, lower=0.0, upper=0.0, scale=context.scales.length)


class Closure(Constraint):
    """Lifted form of Eq. (26): pelvis and swing sole are where the quantities put them."""

    name, equation, unit, words = "closure", "(26)", "m, rad", "closure of the double support"
    reads = (quantities.GAPS,)

    def asked(self, context: ConstraintContext) -> bool:
        return context.boundary == "lifted"

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        labels = tuple(f"closure {how} {axis}" for how in ("along", "about") for axis in "xyz")
        rows = Entries(slice(0, 6), 6)
        scale = np.repeat([_size(context, "m"), _size(context, "rad")], 3)
        return self.once(rows, labels, lower=0.0, upper=0.0, scale=scale)


class TrunkAngle(Constraint):
    """Beyond section 3.2: |an angle of the trunk| <= limit over the whole step."""

    equation, unit, reads, change = "3.2", "rad", (quantities.TRUNK,), 0.3

    def __init__(self, angle: str, words: str) -> None:
        self.name, self.words, self.margins = f"trunk {angle}", words, (f"trunk_{angle}",)
        self._entry = quantities.TRUNK.entries.index(angle)

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        limit = getattr(context.margins, self.margins[0])
        angle = Entries(slice(self._entry, self._entry + 1), 3)
        return self.over_step(context, angle, (self.name,), lower=-limit, upper=limit)


class BodyGap(Constraint):
    """Beyond (32): capsules keep apart over the whole step.

    Those of the two legs; or moving arms from pelvis, waist, thighs, loads and each other.
    """

    equation, unit = "3.2", "m"

    def __init__(self, of: str, reads: Quantity, words: str) -> None:
        self.name, self.words, self.reads = f"{of} gap", words, (reads,)
        self.margins = (f"{of}_gap",)

    def asked(self, context: ConstraintContext) -> bool:
        return super().asked(context) and bool(self._pairs(context).kept)

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        pairs, gap = self._pairs(context), getattr(context.margins, self.margins[0])
        count = len(pairs.names)
        labels = tuple(f"gap between {name}" for name in pairs.names)
        return self.over_step(
            context, Entries(slice(0, count), count), labels, lower=pairs.least(gap),
            scale=_size(context, "m"),
        )  # fmt: skip

    def _pairs(self, context: ConstraintContext) -> CapsulePairs:
        from gaitopt.mechanics.capsule_distance import arm_pairs, leg_pairs

        legs = self.reads[0] is quantities.LEG_GAPS
        return (leg_pairs if legs else arm_pairs)(context.robot)


class SwingTilt(Constraint):
    """Beyond 3.2.3: the swing sole stays level and points ahead, within an angle (its sine).

    A foot upside down or turned about has the same sines; it does not point ahead and left.
    """

    name, equation, unit, words = "swing tilt", "3.2", "rad", "tilt of the swing foot"
    reads, margins, paced = (quantities.CORNERS,), ("swing_tilt",), True

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        limit = context.margins.swing_tilt or 0.0
        turned = abs(context.turn_rate) * context.duration  # of the feet in double support
        yaw = float(np.sin(np.arcsin(min(limit, 1.0)) + turned)) if turned else limit
        labels = (
            "swing foot roll", "swing foot pitch", "swing foot yaw",
            "swing foot pointing ahead", "swing foot upright",
        )  # fmt: skip
        return self.over_step(
            context, Linear(sole_tilt(context.robot.sole.corners)), labels,
            lower=np.array([-limit, -limit, -yaw, 0.0, 0.0]),
            upper=np.array([limit, limit, yaw, FREE, FREE]),
        )  # fmt: skip


class SwingHeight(Constraint):
    """Beyond 3.2.3: the swing foot's corners stay below a height."""

    name, equation, unit, words = "swing height", "3.2", "m", "height of the swing foot"
    reads, margins, paced = (quantities.CORNERS,), ("swing_height",), True

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        function, points = _above_ground(context)
        labels = tuple(f"swing foot {point} height above ground" for point in points)
        limit = context.margins.swing_height or 0.0
        return self.over_step(context, function, labels, upper=limit, scale=_size(context, "m"))


class LandingSpeed(_LeastHeight):
    """Beyond 3.2.3: all corners of the swing foot come down at some speed, none grazes the ground.

    A corner that grazes lands at any time. The rows are of heights, which vanish at the end, so
    that they are scaled finely: then the speed at the landing itself is what is asked for, too.
    With the duration free, the profile is that of the duration given.
    """

    name, equation, unit, words = "landing speed", "3.2", "m", "landing of the swing foot"
    margins = ("landing_speed",)
    label, share = "height before landing", _LANDING_SIZE

    def _least(self, context: ConstraintContext, s: Array) -> Array:
        speed = _STEEPER * (context.margins.landing_speed or 0.0)
        return np.asarray(speed * context.duration * (1.0 - s) * s**_LANDING)


class LandingImpulse(Constraint):
    """Beyond (36): the ground does not push the landing foot harder than a limit."""

    name, equation, unit, words = "landing impulse", "3.2", "N·s", "hardness of the landing"
    reads, margins = (quantities.IMPULSE,), ("landing_impulse",)

    def asked(self, context: ConstraintContext) -> bool:
        return _impact(context) and super().asked(context)

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        most = (context.margins.landing_impulse or 0.0) * context.robot.mass
        labels = ("vertical impact impulse over its limit",)
        return self.once(Entries(slice(2, 3), 6), labels, upper=most, scale=_size(context, "N·s"))


CONSTRAINTS: tuple[Constraint, ...] = (
    JointTorque(), JointSpeed(), Load(), Friction(), CentreOfPressure(),
    Load(LANDING), Friction(LANDING), LiftOff(), Clearance(), Lateral(), KneeFlexion(), LegLength(),
    JointRange(), CentreOfPressure(LANDING), WalkingSpeed(), Tread(), Closure(),
    TrunkAngle("roll", "sideways lean of the trunk"),
    TrunkAngle("pitch", "lean of the trunk forward or back"),
    TrunkAngle("yaw", "turn of the trunk"), TorsionalFriction(), TorsionalFriction(LANDING),
    BodyGap("leg", quantities.LEG_GAPS, "gap between the legs"), SwingTilt(), SwingHeight(),
    LandingSpeed(), LandingImpulse(),
    BodyGap("arm", quantities.ARM_GAPS, "gap between arms and other bodies"),
    FootAngle(), FootLift(), SoftLanding(), *on_foot(FRONT), *on_foot(STRUCK), LoopMotors(),
)  # fmt: skip
"""All built-in constraints, in the order of their rows."""


def imposed_limit(own: Array, given: float | None) -> Array:
    """Return the limits of the joints (n,): the robot's own, or one for all in their place."""
    return own if given is None else np.full(own.size, given)


def _joints(
    constraint: Constraint, context: ConstraintContext, lower: Array, upper: Array, scale: Array
) -> ConstraintBlock:
    """Rows with one entry per joint and instant."""
    joints = context.robot.joint_names
    labels = tuple(f"{joint} {constraint.name}" for joint in joints)
    rows = Entries(slice(0, len(joints)), len(joints))
    return constraint.over_step(context, rows, labels, lower=lower, upper=upper, scale=scale)


def _finite(limits: Array) -> Array:
    """Limits as scales of their rows; a row without a limit may have any scale."""
    return np.where(np.isfinite(limits), limits, 1.0)


def _resting(context: ConstraintContext) -> tuple[bool, bool]:
    """Whether the stance foot's turn ends at rest after its landing, and begins so."""
    landed, leaving = _turning(context)
    return landed and not context.schedule.slapping, leaving


def _turning(context: ConstraintContext) -> tuple[bool, bool]:
    """Return whether the stance foot turns about a line after its landing, and before it leaves."""
    schedule, sole = context.schedule, context.robot.sole
    landed, leaving = (
        phase.contact.hinge(sole) is not None for phase in (schedule.first, schedule.last)
    )
    return landed, leaving


def _edge_moments(context: ConstraintContext, contact: ContactMode) -> Array:
    """Rows that are >= 0 while the centre of pressure (-m_y/f_z, m_x/f_z) is where it may be."""
    front, rear, left, right = contact.bearing(context.robot.sole, context.margins.cop_margin)
    rows = np.zeros((4, 6))
    rows[0, [2, 4]] = front, 1.0
    rows[1, [2, 4]] = -rear, -1.0
    rows[2, [2, 3]] = left, -1.0
    rows[3, [2, 3]] = -right, 1.0
    return rows


@checked
@dataclass(frozen=True)
class MotorEnvelope(Constraint):
    """|torque| <= peak, and |torque / stall torque + rate / no-load speed| <= 1.

    The second is the voltage line: where torque and rate have the same sign, the motor needs
    voltage for both; where it brakes, it needs less.

    Attributes:
        motors: what the motors can do at their joints; joints without one are free.
    """

    name, unit, words = "motor envelope", "1", "share of the envelope of the motors"
    reads = (quantities.TORQUE, quantities.RATES)
    motors: tuple[JointMotor, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "motors", joint_motors_of(self.motors))

    def asked(self, context: ConstraintContext) -> bool:
        del context
        return bool(self.motors)

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        """Return two rows for each joint with a motor.

        Raises:
            SpecError: a pattern fits no joint, or a pair has different motors.
        """
        names = context.robot.joint_names
        found = joint_motors(self.motors, names, context.robot.mirror)
        rows, labels = [], []
        for k, one in enumerate(found):
            if one is not None:
                peak, line = np.zeros((2, 2 * len(names)))
                peak[k] = 1.0 / one.peak_torque
                line[k], line[len(names) + k] = 1.0 / one.stall_torque, 1.0 / one.no_load_speed
                rows += [peak, line]
                labels += [f"{names[k]} peak of the motor", f"{names[k]} voltage of the motor"]
        return self.over_step(context, Linear(np.array(rows)), tuple(labels), lower=-1.0, upper=1.0)
