"""What is asked of the walk: speed, duration, margins, cost, and how finely it is looked at.

Also as plain data, for gait files and libraries, and back.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, field, fields, replace
from functools import cached_property, lru_cache, partial
from typing import Any

from gaitopt.bounds import POSTURES, at_most, is_finite, must_be, shown
from gaitopt.contact import FlatFoot, HeelLine, Phase, PhaseEnd, Schedule, ToeLine
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, own_code, there_are
from gaitopt.gait.constraint import (
    Constraint,
    Margin,
    check_declaration,
    check_relaxation,
    declared_margins,
)
from gaitopt.gait.constraints import CONSTRAINTS, Margins
from gaitopt.gait.costs import Cost, TorqueCost, check_cost, per_second
from gaitopt.gait.grid import QUADRATURES, STRIDE_EDGES, Grid, over_steps, phase_grid, uniform_grid
from gaitopt.gait.parameters import (
    DURATION,
    FOOT_SPACING,
    FOOT_YAW,
    GEOMETRY,
    GEOMETRY_NAMES,
    INFINITY,
    STEP_LENGTH,
    GeometricParameter,
    set_geometry,
)
from gaitopt.gait.plugin import (
    Extension,
    constraint_from_record,
    cost_from_record,
    costs_of,
    extension_record,
    is_built_in,
    terrain_from_record,
)
from gaitopt.gait.terrain import Level, Slope, Stairs, Terrain
from gaitopt.model.sole import LEVEL
from gaitopt.settings import check_settings, checked, checked_arguments, entry
from gaitopt.tolerances import SAME
from gaitopt.units import SLOPE

SPEED_AS = ("constraint", "penalty")
BOUNDARIES = ("closed", "lifted")
TOUCH_DOWNS = FOOT_FLAT = ("gentle", "impact")
EARLIEST, LATEST = 0.1, 0.95
"""Shares of the step between which the foot may begin to turn about its toe."""
SOONEST, FLAT_BY = 0.05, 0.5
"""Shares of the step between which a foot that landed on its heel may meet the ground flat."""
SHORTEST, HALF = 0.001, 0.5
"""Shares of the step between which both feet may stand."""
WIDEST = 0.1
"""Strip at the toe or heel that bears while it turns [m]: a longer one is a sole of its own."""
HIGHEST = 0.5
"""Of a tread over the one before [m]: no leg of a walk lifts its foot higher."""
LONGEST = 1000.0
"""Duration of a step [s]: two thousand times that of a person's."""
SLOWEST = 1e-5
"""Speed below which a walk is one in place [m/s]: its cost per metre is all that it does there."""
FARTHEST = 0.6
"""Turn of a walk in one step [rad]: the hips of few robots turn their feet farther."""
STEEPEST = 1.0
"""Of a slope up or down [rad]: friction of rubber on stone holds a foot to about 45 degrees."""


def _elsewhere(name: str) -> str:
    """Say where a margin is given; nothing of other names."""
    if name not in declared_margins(Margins):
        return ""
    return f"{name} is a margin: preset_task({name}=...), or Task(margins=Margins({name}=...)); "


@partial(checked, elsewhere=_elsewhere)
@dataclass(frozen=True)
class Task:
    """One walking problem.

    Attributes:
        speed: walking speed V of Eq. (39) [m/s]; below zero backward, zero in place.
        lateral_speed: speed to the left [m/s].
        turn_rate: of the walk about the vertical, to the left [rad/s].
        stride: whether both steps of a stride are designed even where the second may be the mirror
            image of the first; where it may not, sideways and in turns, they always are.
        duration: of one step, T [s]; free if the geometry table says so, then the first guess.
        postures: intermediate postures of the splines, n - 2 of section 4.1.
        samples: equidistant instants of the step.
        quadrature: rule for the cost, "simpson" or "euler".
        speed_as: "constraint", Eq. (39), or "penalty", Eq. (47).
        penalty_weight: rho of Eq. (47) [cost / m²].
        boundary: of the double support: "closed" by inverse kinematics as in section 4.2, or
            "lifted": its twelve joint angles are parameters as well, tied to it by equalities.
        toe_off: share of the step at which the stance foot begins to turn about its front edge,
            the heel rising (section 7); None: it stands flat until the impact.
        toe_strip: within which the centre of pressure then is, behind that edge [m].
        heel_strike: share of the step until which the foot that landed on its rear edge rolls flat;
            None: it lands flat.
        foot_flat: how it comes to lie flat: "gentle", its rate falling to zero, or by an "impact"
            of the whole sole.
        double_support: time for which both feet stand at the end of the step [s]; None: an impact
            ends it. Where the duration is free, its share of the step is that of the first guess.
        touch_down: how that begins: "gentle", at zero speed, or with an "impact" after which both
            feet stay on the ground, the second case of section 2.4.1.
        heel_strip: within which the centre of pressure then is, ahead of that edge [m].
        slope: of the ground, uphill above zero [rad]; the speed is along it, and is level over
            stairs and terrains that are no planes.
        cross_slope: of the ground to the left, rising above zero [rad].
        stairs: height of every tread over the one before, down below zero; the treads are as long
            as the steps [m].
        margins: limits of section 3.2.
        geometry: table of the geometric quantities, free and fixed.
        cost: what the walk is optimised for.
        constraints: of one's own, on top of those of section 3.2.
        terrain: of one's own, in place of slope and stairs.

    Raises:
        InputError: a value is out of range, or two of them contradict each other.
    """

    speed: float = entry(1.0, "Walking speed; below zero backward, 0 in place.", "m/s", common=True)
    lateral_speed: float = entry(
        0.0, "Walking speed sideways, to the left above zero.", "m/s", common=True
    )
    turn_rate: float = entry(
        0.0, "Rate at which the walk turns, to the left above zero.", "rad/s", common=True
    )
    stride: bool = entry(False, "Design both steps of a stride, not one and its mirror image.")
    duration: float = entry(0.4, "Duration of a step.", "s", above=0.0, most=LONGEST, common=True)
    postures: int = entry(
        2, "Postures inside the step that the splines of the joints pass through."
    )
    samples: int = entry(31, "Instants of the step at which it is looked at first.")
    quadrature: str = entry(
        "simpson",
        "Rule by which the cost is integrated over the step.",
        choices=QUADRATURES,
        metavar="RULE",
    )
    speed_as: str = entry(
        "constraint",
        "Hold the speed by a constraint, or by a penalty beside the cost.",
        choices=SPEED_AS,
        metavar="KIND",
    )
    penalty_weight: float = entry(
        1e6,
        "Weight of the penalty of --speed-as penalty.",
        "cost/m²",
        above=0.0,
        most=1e12,  # far beyond it no solver sees the cost itself
    )
    boundary: str = entry(
        "closed",
        "Form of the double support: closed, by inverse kinematics, or lifted, its joint angles "
        "being parameters.",
        choices=BOUNDARIES,
        metavar="FORM",
    )
    toe_off: float | None = entry(
        None, "Share of the step at which the stance foot begins to turn about its toe.",
        metavar="SHARE",
    )  # fmt: skip
    toe_strip: float = entry(
        0.01, "Strip behind the toe that bears while the foot turns.", "m", above=0.0, most=WIDEST
    )
    heel_strike: float | None = entry(
        None, "Share of the step until which the foot, landed on its heel, rolls flat.",
        metavar="SHARE",
    )  # fmt: skip
    foot_flat: str = entry(
        "gentle",
        "How the foot comes to lie flat after a heel strike: its rate falling to zero, or by an "
        "impact.",
        choices=FOOT_FLAT,
        metavar="KIND",
    )
    double_support: float | None = entry(
        None, "Time for which both feet stand, after a touch-down at zero speed.", "s"
    )
    touch_down: str = entry(
        "gentle",
        "How a double support begins: at zero speed, or with an impact that both feet take.",
        choices=TOUCH_DOWNS,
        metavar="KIND",
    )
    heel_strip: float = entry(
        0.01, "Strip at the heel that bears while the foot rolls.", "m", above=0.0, most=WIDEST
    )
    slope: float = entry(
        0.0, "Slope of the ground ahead, uphill above zero: 0.1 (rad), 6deg or 10%.", SLOPE,
        common=True, metavar="RAD", least=-STEEPEST, most=STEEPEST,
    )  # fmt: skip
    cross_slope: float = entry(
        0.0, "Slope of the ground to the left, rising above zero: 0.1 (rad), 6deg or 10%.", SLOPE,
        common=True, metavar="RAD", least=-STEEPEST, most=STEEPEST,
    )  # fmt: skip
    stairs: float = entry(
        0.0, "Rise of each step of stairs, down below zero; treads are as long as the steps.", "m",
        common=True, least=-HIGHEST, most=HIGHEST,
    )  # fmt: skip
    margins: Margins = field(default_factory=Margins)
    geometry: tuple[GeometricParameter, ...] = GEOMETRY
    cost: Cost = field(default_factory=TorqueCost)
    constraints: tuple[Constraint, ...] = ()
    terrain: Terrain | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "constraints", _own(self.constraints))
        check_settings(self)
        if [quantity.name for quantity in self.geometry] != list(GEOMETRY_NAMES):
            raise InputError(
                f"geometry is {shown(self.geometry)}; give a table of all quantities, as "
                "set_geometry(GEOMETRY, {'pelvis_roll': {'free': True}})"
            )
        check_cost(self.cost)
        if math.hypot(math.sin(self.slope), math.sin(self.cross_slope)) > math.sin(STEEPEST):
            raise InputError(
                f"a slope of {self.slope:g} rad and a cross_slope of {self.cross_slope:g} rad are "
                f"too steep together; allowed are {STEEPEST:g} rad in all"
            )
        if self.terrain is not None:
            _check_terrain(self.terrain)
        if 0.0 < self.pace < SLOWEST:
            name = "lateral_speed" if self.speed == 0.0 else "speed"
            raise InputError(
                f"{name} is {getattr(self, name):g} m/s; it must be 0, for a walk in place, or at "
                f"least {SLOWEST:g} m/s in size"
            )
        self._check_stride()
        self._check_ground()
        uniform_grid(self.samples, self.quadrature)  # refuses numbers of samples it cannot use
        _check_postures(self.postures, self.samples)
        time = self.geometry[DURATION]
        if time.free and not time.lower <= self.duration <= time.upper:
            raise InputError(
                f"duration is {self.duration} s, but it is free only between {time.lower} and "
                f"{time.upper} s"
            )
        if self.duration < time.lower:
            raise InputError(f"duration is {self.duration:g} s; it must be {time.lower} s or more")
        spacing, width = self.geometry[FOOT_SPACING], self.margins.step_width
        if width is not None and not spacing.free and abs(spacing.value) > width:
            raise InputError(
                f"foot_spacing is fixed at {spacing.value} m, but step_width allows {width} m; "
                "free it or give a larger step_width"
            )
        _check_toe_off(self.toe_off)
        _check_heel_strike(self.heel_strike, self.toe_off)
        if self.foot_flat == "impact" and self.heel_strike is None:
            raise InputError(
                "foot_flat 'impact' is how a foot comes to lie flat that landed on its heel; give "
                "heel_strike, or leave it out"
            )
        self._check_double_support()
        if not self.geometry[STEP_LENGTH].free and self.speed_as == "constraint":
            raise InputError("step_length is fixed; free it, or take the speed as a penalty")

    def _check_stride(self) -> None:
        if self.steps == 1:
            return
        if self.speed_as != "constraint":
            raise InputError(
                "a stride of two steps has its speed as a constraint; leave out speed_as"
            )
        if self.touch_down == "impact":
            raise InputError(
                "an impact that both feet take is for steps that are mirror images of each other; "
                "take touch_down 'gentle' (--touch-down gentle), or leave out lateral_speed, "
                "turn_rate, cross_slope and stride"
            )
        turn = self.turn_rate * self.duration
        if not abs(turn) <= FARTHEST:
            raise InputError(
                f"turn_rate is {self.turn_rate:g} rad/s, with steps of {self.duration:g} s a turn "
                f"of {abs(turn):.3g} rad a step; give at most {FARTHEST:g} rad, by a lower rate or "
                "shorter steps"
            )

    def _check_ground(self) -> None:
        sloping = self.slope != 0.0 or self.cross_slope != 0.0
        if sum((sloping, self.stairs != 0.0, self.terrain is not None)) > 1:
            raise InputError(
                "a walk has one ground: give a slope or stairs (whose treads are level) or a "
                "terrain, not two of them"
            )
        ground, time, yaw = self.ground, self.geometry[DURATION], self.geometry[FOOT_YAW]
        where = "on a slope" if ground.name == Slope.name else f"on {ground.name}"
        if ground != Level() and (yaw.free or yaw.value != 0.0):
            raise InputError(f"{where} the feet point ahead; fix foot_yaw at 0 (--fix foot_yaw=0)")
        if ground != Level() and self.turn_rate != 0.0:
            raise InputError(
                f"{where} a walk that turns never repeats, for the ground does not turn with it; "
                "leave out turn_rate"
            )
        if ground.shaped and self.speed <= 0.0:
            raise InputError(
                f"speed is {self.speed:g} m/s; {where} it must be above 0, since the ground "
                "repeats with the steps (downstairs is a negative rise, --stairs=-0.17)"
            )
        if ground.shaped and (time.free or self.speed_as != "constraint"):
            raise InputError(
                f"{where} the ground repeats with the steps, speed times duration, but here that "
                "is free; fix the duration, and take the speed as a constraint"
            )
        for name in ("toe_off", "heel_strike"):
            if ground.shaped and getattr(self, name) is not None:
                raise InputError(
                    f"{where} the foot stands flat; give {name} or {ground.name}, not both"
                )

    def _check_double_support(self) -> None:
        span = self.double_support
        if self.touch_down == "impact" and (span is None or self.margins.soft_landing):
            why = "soft_landing asks for none; leave out one of them"
            if span is None:
                why = "here one foot stands at a time; give double_support, or leave it out"
            raise InputError(f"touch_down 'impact' is an impact that both feet take, but {why}")
        if span is None:
            return
        share = span / self.duration
        if not SHORTEST <= share <= HALF:
            raise InputError(
                f"double_support is {shown(span)} s; it must be from {SHORTEST * self.duration:g} "
                f"to {HALF * self.duration:g} s, {SHORTEST:g} to {HALF:g} of the step"
            )
        if self.heel_strike is not None:
            raise InputError(
                "the front foot stands flat in a double support; give heel_strike or "
                "double_support, not both"
            )
        if self.toe_off is not None and self.touch_down == "impact":
            raise InputError(
                "the rear foot stands flat where both take an impact; leave out toe_off or "
                "touch_down"
            )
        latest = 1.0 - share - SOONEST
        if self.toe_off is not None and self.toe_off > latest:
            raise InputError(
                f"toe_off is {self.toe_off:g}, but both feet stand from {1.0 - share:.3g} of the "
                f"step on; the rear foot turns before that, from {latest:.3g} on at the latest: "
                "give that or less, or a shorter double_support"
            )
        if self.ground.shaped:
            raise InputError(
                f"on {self.ground.name} the foot lands by an impact; give double_support or "
                f"{self.ground.name}, not both"
            )

    @property
    def ground(self) -> Terrain:
        """The terrain that it is walked on."""
        if self.terrain is not None:
            return self.terrain
        if self.stairs != 0.0:
            return Stairs(self.stairs)
        level = self.slope == 0.0 and self.cross_slope == 0.0
        return Level() if level else Slope(self.slope, self.cross_slope)

    @checked_arguments
    def on(self, terrain: Terrain) -> Task:
        """Return the same walk on another ground."""
        return replace(self, slope=0.0, cross_slope=0.0, stairs=0.0, terrain=terrain)

    @property
    def step_length(self) -> float:
        """Step length that the speed asks for, V T [m]."""
        return self.speed * self.duration

    @property
    def steps(self) -> int:
        """Number of steps that are designed: 1 where the next is its mirror image, else 2."""
        aside = self.lateral_speed != 0.0 or self.turn_rate != 0.0 or self.ground.down[1] != 0.0
        return 2 if self.stride or aside else 1

    @property
    def pace(self) -> float:
        """Speed along the path [m/s]."""
        return math.hypot(self.speed, self.lateral_speed)

    @checked_arguments
    def at_share_of_speed(self, share: float) -> Task:
        """Return the same walk at a share of its speeds and of its turn rate.

        One that would be slower than `SLOWEST` is the walk itself.
        """
        if 0.0 < share * self.pace < SLOWEST:
            return self
        return replace(
            self,
            speed=share * self.speed,
            lateral_speed=share * self.lateral_speed,
            turn_rate=share * self.turn_rate,
        )

    @property
    def in_place(self) -> bool:
        """Whether the walk gets nowhere, so that its cost is told per second."""
        return self.pace == 0.0

    @property
    def cost_unit(self) -> str:
        """Unit of the cost: of its cost per metre, or of that per second in place."""
        return per_second(self.cost.unit) if self.in_place else self.cost.unit

    @cached_property
    def schedule(self) -> Schedule:
        """Phases and symmetry of the step."""
        touch = None
        if self.double_support is not None:
            touch = 1.0 - self.double_support / self.duration
        strips = self.heel_strip, self.toe_strip
        ways = self.foot_flat == "gentle", self.touch_down == "gentle"
        return _schedule(self.heel_strike, self.toe_off, touch, *strips, *ways)

    @property
    def grid(self) -> Grid:
        """The instants at which the step, or the stride of two, is looked at first."""
        if self.steps == 2:
            changes = over_steps(self.schedule.changes, STRIDE_EDGES)
            return phase_grid(2 * self.samples - 1, self.quadrature, changes)
        return phase_grid(self.samples, self.quadrature, self.schedule.changes)

    @property
    def extensions(self) -> tuple[Constraint | Cost, ...]:
        """Its cost and constraints that are not gaitopt's, of a sum of costs the terms."""
        every: tuple[Constraint | Cost, ...] = (*costs_of(self.cost), *self.constraints)
        return tuple(one for one in every if not is_built_in(one))

    @property
    def declared(self) -> dict[str, Margin]:
        """Declarations of all margins by name: of section 3.2, then of its own constraints."""
        owners = (self.margins, *self.constraints)
        return {name: one for owner in owners for name, one in declared_margins(owner).items()}

    @checked_arguments
    def margin(self, name: str) -> float | bool | None:
        """Return the value of a margin.

        Raises:
            InputError: there is none of that name.
        """
        for owner in (self.margins, *self.constraints):
            if name in declared_margins(owner):
                value: float | bool | None = getattr(owner, name)
                return value
        raise InputError(f"there is no margin '{name}'; {there_are(self.declared, name)}")

    def with_margins(self, values: Mapping[str, float | bool | None]) -> Task:
        """Return the task with other values of some margins.

        Raises:
            InputError: there is none of that name, or a value is out of range.
        """
        must_be(values, Mapping, "margins", "a table by name, as {'friction': 0.5}")
        if not values:
            return self
        for name in values:
            self.margin(name)
        margins, *constraints = (
            _replaced(owner, values) for owner in (self.margins, *self.constraints)
        )
        return replace(self, margins=margins, constraints=tuple(constraints))

    def with_changes(self, **changes: object) -> Task:
        """Return the task with other values of some fields and margins, each by its name.

        Raises:
            InputError: there is none of that name, or a value is out of range.
        """
        names = [entry.name for entry in fields(self)]
        own: dict[str, Any] = {name: value for name, value in changes.items() if name in names}
        margins: dict[str, Any] = {n: value for n, value in changes.items() if n not in names}
        task = replace(self, **own) if own else self
        if unknown := set(margins) - set(task.declared):
            raise InputError(
                f"there is no task field {', '.join(sorted(unknown))}; "
                f"{there_are((*names, *task.declared), min(unknown))}"
            )
        return task.with_margins(margins)


@lru_cache  # tasks that differ in limits or speed have the same
def _schedule(
    landing: float | None,
    leaving: float | None,
    touch: float | None,
    heel_strip: float,
    toe_strip: float,
    softly: bool,
    gentle: bool,
) -> Schedule:
    """Return the phases of a step by when its foot lands flat, turns about its toe, is relieved."""
    if touch is not None:
        begin = PhaseEnd.TOUCH_DOWN if gentle else PhaseEnd.IMPACT
        rear = FlatFoot() if leaving is None else ToeLine(toe_strip)
        closing = Phase(rear, touch, begin), Phase(rear, 1.0, PhaseEnd.LIFT_OFF, both=True)
        if leaving is None:
            return Schedule(closing)
        return Schedule((Phase(FlatFoot(), leaving, PhaseEnd.SMOOTH), *closing))
    phases = [Phase(FlatFoot())]
    if landing is not None:
        ends = PhaseEnd.SMOOTH if softly else PhaseEnd.FOOT_FLAT
        phases = [Phase(HeelLine(heel_strip), landing, ends), *phases]
    if leaving is not None:
        flat = Phase(FlatFoot(), leaving, PhaseEnd.SMOOTH)
        phases = [*phases[:-1], flat, Phase(ToeLine(toe_strip))]
    return Schedule(tuple(phases))


def _replaced(owner: Any, values: Mapping[str, float | bool | None]) -> Any:
    own = {name: values[name] for name in declared_margins(owner) if name in values}
    return replace(owner, **own) if own else owner


def _check_terrain(terrain: object) -> None:
    """Refuse what is no terrain, and one whose gravity is none; see also `check_profile`."""
    if not isinstance(terrain, Terrain):
        raise InputError(f"terrain is {shown(terrain)}; give one, as Stairs(0.1)")
    check_declaration(terrain, "name")
    for name in ("in_mirror", "across_angle", "incline"):
        if getattr(type(terrain), name) is not getattr(Terrain, name):
            raise InputError(
                f"the terrain '{terrain.name}' has {name} of its own; leave that out: it follows "
                "from `down`"
            )
    with own_code(terrain, f"the terrain '{terrain.name}'"):
        down: Any = terrain.down
        _ = terrain.rise, terrain.shaped  # kinds are seen to with the profile
    three = isinstance(down, tuple) and len(down) == len(LEVEL) and all(map(is_finite, down))
    if not (three and abs(math.hypot(*down) - 1.0) < SAME and -down[2] >= math.cos(STEEPEST)):
        raise InputError(
            f"on the terrain '{terrain.name}' gravity points along {shown(down)}; give a tuple of "
            f"unit length, no farther than {STEEPEST:g} rad from (0, 0, -1)"
        )


def _own(constraints: object) -> tuple[Constraint, ...]:
    """Return constraints of one's own as a tuple; refuse what is none or has a name twice."""
    given = tuple(constraints) if isinstance(constraints, list | tuple) else (constraints,)
    names = [one.name for one in CONSTRAINTS]
    margins = list(declared_margins(Margins))
    for one in given:
        if not isinstance(one, Constraint):
            raise InputError(
                f"constraints holds {shown(one)}; give instances of subclasses of Constraint"
            )
        check_declaration(one, "name", "unit", "words", "reads")
        names.append(one.name)
        margins += declared_margins(one)
    for kind, known in (("constraint", names), ("margin", margins)):
        if len(set(known)) < len(known):
            twice = min(name for name in known if known.count(name) > 1)
            raise InputError(f"two {kind}s are called '{twice}'; rename one")
    for one in given:
        check_relaxation(one, declared_margins(Margins), names)
    return given


def _check_toe_off(share: float | None) -> None:
    if share is not None and not EARLIEST <= share <= LATEST:
        raise InputError(
            f"toe_off is {shown(share)}; it must be a share of the step from {EARLIEST} to {LATEST}"
        )


def _check_heel_strike(share: float | None, toe_off: float | None) -> None:
    if share is not None and not SOONEST <= share <= FLAT_BY:
        raise InputError(
            f"heel_strike is {shown(share)}; it must be a share of the step from {SOONEST} to "
            f"{FLAT_BY}"
        )
    if share is not None and toe_off is not None and toe_off < share + SOONEST:
        raise InputError(
            f"the foot rolls flat until {share} of the step (heel_strike) and turns about its toe "
            f"from {toe_off} on (toe_off); let it stand flat for {SOONEST} of the step between"
        )


def _check_postures(postures: int, samples: int) -> None:
    """Refuse more postures than are of use, or than the samples can tell apart.

    The accelerations are linear between the knots, postures + 2 of them. Samples determine those
    at the knots only if there are as many, and then equidistant ones do (Schoenberg and Whitney;
    de Boor, 2001, chapter XIII).
    """
    if postures < 1:
        raise InputError(f"postures is {shown(postures)}; at least 1 intermediate posture")
    if postures <= min(samples - 2, POSTURES):
        return
    if samples - 2 >= POSTURES:
        at_most(postures, POSTURES, "postures")
    wanted = postures + 2 + (postures + 1) % 2  # odd, as Simpson's rule wants it
    more = f", or {wanted} samples" if postures <= POSTURES else ""
    raise InputError(
        f"{shown(postures)} postures are more than {samples} samples can tell apart; give at most "
        f"{samples - 2}{more}"
    )


_PARAMETER_FIELDS = ("free", "value", "lower", "upper", "scale")
_NO_BOUND = {"lower": -INFINITY, "upper": INFINITY}


def task_record(task: Task) -> dict[str, object]:
    """Return a task as JSON-able data; an infinite bound is None, or left out by default.

    A cost other than the paper's, constraints and a terrain of its own stand there if it has any.
    """
    apart = ("margins", "geometry", "cost", "constraints", "terrain")
    record: dict[str, object] = {
        entry.name: getattr(task, entry.name) for entry in fields(task) if entry.name not in apart
    }
    record["margins"] = asdict(task.margins)
    if task.cost != TorqueCost():
        record["cost"] = extension_record(task.cost)
    if task.constraints:
        record["constraints"] = [extension_record(one) for one in task.constraints]
    if task.terrain is not None:
        record["terrain"] = extension_record(task.terrain)
    record["geometry"] = {
        q.name: _parameter_record(q, usual)
        for q, usual in zip(task.geometry, GEOMETRY, strict=True)
    }
    return record


def _parameter_record(
    parameter: GeometricParameter, usual: GeometricParameter
) -> dict[str, object]:
    record: dict[str, object] = {}
    for name in _PARAMETER_FIELDS:
        value = getattr(parameter, name)
        if value != _NO_BOUND.get(name):
            record[name] = value
        elif value != getattr(usual, name):
            record[name] = None  # JSON has no infinity
    return record


def task_from_record(record: object, known: Iterable[Extension] = ()) -> Task:
    """Return the task of a record made by `task_record`.

    Args:
        known: constraints, costs and terrains that are not gaitopt's own, as of a plugin.

    Raises:
        InputError: the record is not that of a task, or names what is not known.
    """
    if not isinstance(record, Mapping):
        raise InputError("the record of the task is missing; was the gait designed by gaitopt?")
    values = dict(record)
    margins, geometry = values.pop("margins", {}), values.pop("geometry", {})
    cost, own = values.pop("cost", None), values.pop("constraints", [])
    terrain = values.pop("terrain", None)
    known = tuple(known)
    try:
        return Task(
            **values,
            margins=Margins(**margins),
            geometry=set_geometry(GEOMETRY, _parameters(geometry)),
            cost=TorqueCost() if cost is None else cost_from_record(cost, known),
            constraints=tuple(constraint_from_record(one, known) for one in own),
            terrain=None if terrain is None else terrain_from_record(terrain, known),
        )
    except (TypeError, RecursionError) as error:
        raise InputError(f"the record of the task cannot be read: {error}") from error


def _parameters(record: object) -> dict[str, dict[str, float | bool]]:
    """Return what `set_geometry` takes; records of old leave out every infinite bound."""
    entries = record.values() if isinstance(record, Mapping) else [record]
    if not isinstance(record, Mapping) or not all(isinstance(e, Mapping) for e in entries):
        raise TypeError("its geometry is no table of tables")
    return {
        name: {k: _NO_BOUND[k] if v is None and k in _NO_BOUND else v for k, v in entry.items()}
        for name, entry in record.items()
    }
