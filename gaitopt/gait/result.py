"""A gait: one optimal step, everything it asks of the robot, and where it came from."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sized
from contextlib import suppress
from dataclasses import field, fields, replace
from functools import cached_property
from importlib import import_module

import numpy as np
from numpy.typing import NDArray

from gaitopt.actuators.linkages import linkages_from_rows
from gaitopt.bounds import INSTANTS, NUMBER, at_most, fixed
from gaitopt.contact import BOTH_FEET, FlatFoot
from gaitopt.dataclass import dataclass, made_anew
from gaitopt.errors import GaitFileError, GaitoptError, InputError, RobotError
from gaitopt.escape import printable
from gaitopt.gait.costs import TorqueCost, per_second
from gaitopt.gait.motor_space import DrivenJoints, MotorSpace, joints_of_linkages
from gaitopt.gait.spline import bernstein
from gaitopt.gait.trajectory import FootTurning, Trajectory, TrajectoryPhase, fitted_coefficients
from gaitopt.importers.physics import PARTS
from gaitopt.importers.report import findings_of
from gaitopt.model.import_options import ImportOptions, choices_from_record
from gaitopt.model.joint_tree import TWIST
from gaitopt.model.multibody import Multibody
from gaitopt.model.robot import Robot
from gaitopt.model.sole import LEVEL, Sole
from gaitopt.nlp import Array
from gaitopt.settings import checked_facts

_LEG_JOINTS = 6  # of each leg of gaits that do not record it


class Recorded:
    """What moves a robot and has a record: a gait, or a transition.

    Attributes:
        joint_names, mirror, urdf, stance_sole, swing_sole_frame, meta: as of a gait.
        trajectory: the motion as a function of time.
    """

    joint_names: tuple[str, ...]
    mirror: Array
    urdf: str
    stance_sole: str
    swing_sole_frame: str
    meta: Mapping[str, object]
    trajectory: Trajectory

    def _repr_html_(self) -> str | None:
        """Return what a notebook shows: the page, None where the robot cannot be drawn.

        How it looks is none of this module's business, but notebooks ask the object itself.
        """
        shown: str | None = import_module("gaitopt.view.page").gait_html(self)
        return shown

    def fact(self, *keys: str) -> object | None:
        """Return `meta[key][key]...`, None if any of the keys is absent."""
        value: object | None = self.meta
        for key in keys:
            value = value.get(key) if isinstance(value, Mapping) else None
        return value

    @property
    def certified(self) -> bool:
        """Whether its record says that it is proven."""
        return self.fact("certificate", "certified") is True

    def number(self, *keys: str) -> float | None:
        """Return a number of `meta`, None if it is absent or not a number."""
        value = self.fact(*keys)
        return float(value) if is_number(value) else None  # type: ignore[arg-type]

    def text(self, *keys: str) -> str | None:
        """Return a text of `meta`, None if it is absent or not a text."""
        value = self.fact(*keys)
        return value if isinstance(value, str) else None

    @property
    def leg_joints(self) -> int:
        """Number of joints of each leg, the first of `joint_names`; six if it is not recorded."""
        return int(self.number("leg_joints") or _LEG_JOINTS)

    def joint_limit(self, kind: str) -> Array | None:
        """Return `meta["limits"][kind]`, shape (J,), None if it is absent or no list of numbers.

        Args:
            kind: "torque" [N·m], "speed" [rad/s], "lower" or "upper" [rad].
        """
        value = self.fact("limits", kind)
        if not isinstance(value, list) or len(value) != len(self.joint_names):
            return None
        if not all(v is None or is_number(v) for v in value):
            return None
        return np.array([np.nan if v is None else v for v in value], dtype=np.float64)


def is_number(value: object) -> bool:
    """Whether a value of JSON is a number whose square has a value."""
    return (
        isinstance(value, int | float)
        and not isinstance(value, bool)
        and -NUMBER <= value <= NUMBER
    )


def recorded_choices(gait: Recorded) -> ImportOptions:
    """Return what was chosen about a gait's robot; nothing for a gait that does not record it.

    Raises:
        RobotError: the record cannot be read.
    """
    record = gait.fact("choices")
    return choices_from_record(record) if isinstance(record, Mapping) else ImportOptions()


def robot_of(gait: Recorded) -> Robot:
    """Return the robot a gait was designed for, on the ground that it walks on.

    Raises:
        GaitFileError: neither the choices about it nor its sole are recorded.
        RobotError: the URDF is not a biped, or the choices do not fit it.
    """
    choices = gait.fact("choices")
    if isinstance(choices, Mapping):
        chosen = choices_from_record(choices)
        if gait.fact("physics") is None:  # version 0.1 counted nothing but rotor inertias
            chosen = chosen.over(without=tuple(part for part in PARTS if part != "armature"))
        robot = Robot.from_urdf(gait.urdf, choices=chosen)
        robot = robot.as_before(findings_of(gait.fact("findings")))
        return robot.on_ground(ground_of(gait).down)
    edges = {name: gait.number("sole", name) for name in ("toe", "heel", "left", "right")}
    missing = [name for name, value in edges.items() if value is None]
    if missing:
        raise GaitFileError(
            f"the gait does not record the {missing[0]} edge of the sole in its 'meta'; "
            "was it designed by gaitopt?"
        )
    sole = Sole(**{name: value for name, value in edges.items() if value is not None})
    return Robot.from_urdf(
        gait.urdf, stance_sole=gait.stance_sole, swing_sole=gait.swing_sole_frame, sole=sole
    )


def recorded_linkages(gait: Recorded) -> list[DrivenJoints]:
    """Return the joints that motors turn through linkages, of the robot's file and of its task.

    Both legs stand one after the other for each linkage. None of a gait whose records are damaged.
    """
    constraints = gait.fact("task", "constraints")
    with suppress(GaitoptError):
        own = robot_of(gait).linkages if any(tag in gait.urdf for tag in _LOOPS) else ()
        for record in constraints if isinstance(constraints, list) else ():
            fields = record.get("fields") if isinstance(record, Mapping) else None
            if isinstance(fields, Mapping) and record.get("name") == MotorSpace.name:
                own = (*own, *linkages_from_rows(fields.get("linkages")))
        return joints_of_linkages(gait.joint_names, gait.mirror, gait.trajectory.body, own)
    return []


def drawn_robot(gait: Recorded) -> Robot:
    """Return the robot of a gait of format 1 or made by hand; what it does not record is found.

    Raises:
        RobotError: the URDF is not a biped, or not one with the gait's joints and sole frames.
    """
    try:
        try:
            robot = robot_of(gait)
        except GaitFileError:
            soles = gait.stance_sole, gait.swing_sole_frame
            robot = Robot.from_urdf(gait.urdf, stance_sole=soles[0], swing_sole=soles[1])
    except RobotError as error:
        raise RobotError(f"the gait's URDF cannot be read: {error}") from error
    for name in set(gait.joint_names) - set(robot.joint_names):
        raise RobotError(f"the gait's URDF has no joint '{name}', which the gait moves")
    return robot


_LONGEST = 80  # characters of words
_LOOPS = ("<connect", "<weld")  # in the text of a robot with loops of bodies
_MOST = 1000  # points of an outline


@dataclass(frozen=True)
class Ground:
    """The ground of a gait.

    Attributes:
        words: what a person calls it, empty for level ground.
        down: direction of gravity in its axes, those of the stance sole; of unit length.
        rise: of the next footprint over this one [m].
        outline: points (x, z) of the ground of one step [m], shape (m, 2); none of a plane.
    """

    words: str = ""
    down: tuple[float, float, float] = LEVEL
    rise: float = 0.0
    outline: Array = field(default_factory=lambda: np.zeros((0, 2)))

    @property
    def shaped(self) -> bool:
        """Whether it is no plane."""
        return len(self.outline) > 0

    def along(self, first: int, last: int, step: float) -> Array:
        """Return its points from one step to another before the next [m], shape (m, 2).

        Args:
            first, last: numbers of the steps; the stance foot stands in step 0.
            step: length of a step [m].
        """
        one = self.outline if self.shaped else np.zeros((1, 2))
        return np.concatenate([one + k * np.array([step, self.rise]) for k in range(first, last)])


def ground_of(gait: Recorded) -> Ground:
    """Return the ground that a gait walks on; level where it records none, or nonsense."""
    down, outline = gait.fact("ground", "down"), gait.fact("ground", "outline")
    points = _rows(outline, 2)
    axes = _rows([down], 3)
    direction = axes[0] if len(axes) else np.zeros(3)
    length = float(np.linalg.norm(direction))
    x, y, z = direction / length if length > 0.0 else LEVEL
    return Ground(
        printable((gait.text("ground", "words") or "")[:_LONGEST]),
        (float(x), float(y), float(z)),
        gait.number("ground", "rise") or 0.0,
        points,
    )


def _rows(value: object, width: int) -> Array:
    """Return lists of numbers as rows (m, width); none if they are not that."""
    rows = value if isinstance(value, list) else []
    if len(rows) > _MOST or not all(
        isinstance(row, list) and len(row) == width and all(map(is_number, row)) for row in rows
    ):
        rows = []
    return np.array(rows, dtype=np.float64).reshape(-1, width)


_REAL = "fiu"  # kinds of NumPy types; a text or a complex number would be cast in silence
_SHORTEST = 1e-50
"""Duration of a step [s]: what is divided by it still has a value."""
_CLOSEST = 1e-9  # of a step: nearer to each other no two knots are; samples are, about a change
_NOWHERE = 1e-12  # m: rounding in a step in place
_EXCHANGE_TOLERANCE = 1e-9  # on E E = 1, whose entries are 0 and +-1

# Sizes that are not numbers: N samples, J joints, m knots, m + 2 coefficients, P parameters.
SHAPES: dict[str, tuple[int | str, ...]] = {
    "time": ("N",),
    "q": ("N", "J"),
    "dq": ("N", "J"),
    "ddq": ("N", "J"),
    "torque": ("N", "J"),
    "ground_wrench": ("N", 6),
    "cop": ("N", 2),
    "swing_sole": ("N", 4, 3),
    "knots": ("m",),
    "coefficients": ("m + 2", "J"),
    "impulse": (6,),
    "rate_before": ("J",),
    "rate_after": ("J",),
    "parameters": ("P",),
    "mirror": ("J", "J"),
}
OF_TURN: dict[str, tuple[int | str, ...]] = {
    "hinge": ("6 or 0",),
    "knots": ("k",),
    "coefficients": ("k + 2",),
}
"""Arrays of a turn of the stance foot, see `OPTIONAL`."""
OPTIONAL: dict[str, tuple[int | str, ...]] = {
    **{f"{part}_{n}": shape for part in ("foot", "landing") for n, shape in OF_TURN.items()},
    "flat_rates": ("2 or 0", "J"),
    "double_knots": ("d",),
    "double_coefficients": ("d + 2", "J"),
    "front_wrench": ("4 or 0", 6),
    "rear_impulse": ("6 or 0",),
}
"""Arrays of the turns of the stance foot before it leaves and after it landed, of an impact by
which it comes to lie flat, and of a double support, empty where there are none."""
_KNOWN: dict[str, tuple[int | str, ...]] = {"multipliers": ("R",), "bound_multipliers": ("P",)}


@dataclass(frozen=True)
class ContactPhase:
    """A part of the step in which the stance foot keeps one contact.

    Attributes:
        contact: its name, "flat", "toe line".
        begin, end: times [s].
    """

    contact: str
    begin: float
    end: float


@checked_facts
@dataclass(frozen=True, eq=False)
class Gait(Recorded):
    """One step of a cyclic gait; the next step is its mirror image. All arrays are read-only.

    The joints are in the order stance leg from ankle to hip, then swing leg from hip to ankle,
    with the signs of the URDF; the computed step is the one with the stance foot of `stance_sole`.

    Attributes:
        time: sample times from 0 to the step duration [s], shape (N,).
        q, dq, ddq: joint angles [rad], rates [rad/s], accelerations [rad/s²], shape (N, J).
        torque: joint torques [N·m], shape (N, J), Eq. (1).
        ground_wrench: force [N] then moment [N·m] of the ground on the stance foot, in its sole
            frame, shape (N, 6), Eqs. (11)-(13).
        cop: centre of pressure in the stance sole frame [m], shape (N, 2).
        swing_sole: corners (toe left, toe right, heel left, heel right) of the swing sole in the
            stance sole frame [m], shape (N, 4, 3).
        knots: knots of the joint splines [s], shape (m,).
        impulse: of the ground on the landing foot, in the frame of its sole laid flat [N·s, N·m·s],
            shape (6,).
        rate_before, rate_after: joint rates around the impact, same joints [rad/s], shape (J,).
        parameters: the optimum, shape (P,); units as the parameter names say.
        parameter_names: P names.
        joint_names: J names of the URDF.
        mirror: leg exchange E, shape (J, J): the next step starts at E q(T), Eq. (26).
        urdf: text of the robot's URDF.
        stance_sole, swing_sole_frame: names of the sole frames in the URDF.
        coefficients: of the splines: angles at the knots [rad], then rates at the start and at the
            end [rad/s], shape (m + 2, J); None: those that the samples have.
        multipliers: of the scaled constraint rows at the optimum, in the order of the walk's
            program, shape (R,); None where they are not known.
        bound_multipliers: of the bounds on the parameters, shape (P,), likewise.
        multibody: the robot as it was designed for; None: it is read again from `urdf` where it
            is needed.
        foot_hinge: twist of the stance sole per unit of the rate of its turn about the line of it
            that rests at the end of the step, in its frame, linear part first, shape (6,); empty
            where it stands flat until the impact.
        foot_knots: of the spline of its angle, from where it begins to turn to the end of the step
            [s], shape (k,) or (0,); the first is one of `knots`.
        foot_coefficients: angle at these knots [rad], rates at both ends [rad/s], (k + 2,) or (0,).
        foot_contact: name of the contact in which it turns, "toe line"; empty where it does not.
        landing_hinge, landing_knots, landing_coefficients, landing_contact: the same of its turn
            from the start of the step, on the line on which it landed, "heel line", to the instant
            at which it is flat, one of `knots`; empty where it lands flat.
        flat_rates: joint rates before and after an impact by which it comes to lie flat [rad/s], at
            the last of the landing knots, where `coefficients` are of two splines; shape (2, J), or
            (0, J) where there is none.
        double_knots, double_coefficients: of the splines after touch-down, where both feet stand,
            as `knots` and `coefficients`, from the last of the knots on: the leg that has landed is
            near its splines, where its sole stays; empty where an impact ends the step.
        front_wrench: of the ground on the front foot then, in its sole frame: control points of a
            cubic of time in Bernstein's form, force [N] and moment [N·m], shape (4, 6) or (0, 6).
        rear_impulse: of the ground on the rear foot, in its sole frame, where an impact that both
            feet take begins the double support [N·s, N·m·s], shape (6,) or (0,); `impulse` and the
            rates around it are of the same instant. Where the foot comes to lie flat by an impact
            it is that of the ground on this foot, then.
        second: the step after this one, where that is no mirror image of it, in a stride of two:
            seen as its own mirror image, with E like this one, so that its next step is this one.
        meta: JSON-able record (task, limits, sole, mass, cost, solver, status, certificate,
            versions); every key is optional.

    Raises:
        InputError: an array has the wrong shape or holds NaN, times do not increase, names do not
            match, E is not an exchange, or `meta` is not JSON-able.
    """

    time: Array
    q: Array
    dq: Array
    ddq: Array
    torque: Array
    ground_wrench: Array
    cop: Array
    swing_sole: Array
    knots: Array
    impulse: Array
    rate_before: Array
    rate_after: Array
    parameters: Array
    parameter_names: tuple[str, ...]
    joint_names: tuple[str, ...]
    mirror: Array
    urdf: str
    stance_sole: str
    swing_sole_frame: str
    meta: Mapping[str, object]
    coefficients: Array = None  # type: ignore[assignment]  # from then on an array
    multipliers: Array | None = None
    bound_multipliers: Array | None = None
    multibody: Multibody | None = None
    foot_hinge: Array = field(default_factory=lambda: np.zeros(0))
    foot_knots: Array = field(default_factory=lambda: np.zeros(0))
    foot_coefficients: Array = field(default_factory=lambda: np.zeros(0))
    foot_contact: str = ""
    landing_hinge: Array = field(default_factory=lambda: np.zeros(0))
    landing_knots: Array = field(default_factory=lambda: np.zeros(0))
    landing_coefficients: Array = field(default_factory=lambda: np.zeros(0))
    landing_contact: str = ""
    flat_rates: Array = None  # type: ignore[assignment]  # from then on an array
    double_knots: Array = field(default_factory=lambda: np.zeros(0))
    double_coefficients: Array = None  # type: ignore[assignment]  # from then on an array
    front_wrench: Array = field(default_factory=lambda: np.zeros((0, 6)))
    rear_impulse: Array = field(default_factory=lambda: np.zeros(0))
    second: Gait | None = None

    def __post_init__(self) -> None:
        for name in ("parameter_names", "joint_names"):
            object.__setattr__(self, name, _names(name, getattr(self, name)))
        for name in ("urdf", "stance_sole", "swing_sole_frame"):
            if not isinstance(getattr(self, name), str) or not getattr(self, name):
                raise InputError(f"the gait's '{name}' must be a non-empty text")
        for name in ("double_coefficients", "flat_rates"):
            if getattr(self, name) is None:
                object.__setattr__(self, name, np.zeros((0, len(self.joint_names))))
        for name in (*SHAPES, *OPTIONAL, *_KNOWN):
            if getattr(self, name) is not None or name not in ("coefficients", *_KNOWN):
                object.__setattr__(self, name, _frozen(name, getattr(self, name)))
        object.__setattr__(self, "meta", _json_copy(self.meta))
        _check_times(self)
        _check_foot(self)
        _check_flat(self)
        _check_double(self)
        if self.coefficients is None:
            object.__setattr__(self, "coefficients", _frozen("coefficients", _fitted(self)))
        _check_sizes(self)
        _check_mirror(self.mirror)
        _check_second(self)

    __reduce__ = made_anew

    def __repr__(self) -> str:
        """Return it in one line: the whole of it is pages long."""
        robot, cost = self.text("robot"), self.cost
        certified = self.fact("certificate", "certified")
        proof = "" if certified is None else f", {'certified' if certified else 'not certified'}"
        return (
            f"<Gait{'' if robot is None else f' of {robot!r}'}: {fixed(self.speed, 3)} m/s, "
            f"{fixed(self.step_length, 3)} m in {fixed(self.duration, 3)} s"
            f"{'' if cost is None else f', {cost:.6g} {self.cost_unit}'}{proof}>"
        )

    @property
    def following(self) -> Gait:
        """The next step as its own mirror image: this one, or the second of a stride."""
        return self if self.second is None else self.second

    @property
    def steps(self) -> tuple[Gait, ...]:
        """This step, or both of a stride, the second as its mirror image."""
        return (self,) if self.second is None else (self, self.second)

    @property
    def duration(self) -> float:
        """Duration of the step [s]."""
        return float(self.time[-1])

    @property
    def step_length(self) -> float:
        """Distance the robot advances in one step [m]: half the travel of the swing sole.

        Below zero where it goes backward; of a stride forward, on the average.
        """
        if self.second is not None:
            return self.speed * self.duration
        start, end = self.swing_sole[[0, -1]].reshape(2, 2, 2, 3).mean(axis=2)  # toe, heel of each
        start, end = _laid_flat(start, self.foot_hinge), _laid_flat(end, self.landing_hinge)
        forward, left, _ = (end - start).mean(axis=0)  # with feet turned out it is not along x
        length = float(np.hypot(forward, left)) / 2.0
        return 0.0 if length < _NOWHERE else float(np.copysign(length, forward))

    @property
    def turning(self) -> bool:
        """Whether the stance foot turns about a line of its sole at the end of the step."""
        return bool(self.foot_knots.size)

    @property
    def turns_at(self) -> float:
        """Time at which the stance foot begins to turn [s]; the duration where it does not."""
        return float(self.foot_knots[0]) if self.turning else self.duration

    @property
    def lands_on_line(self) -> bool:
        """Whether the foot lands on a line of its sole and turns about it until it is flat."""
        return bool(self.landing_knots.size)

    @property
    def closing(self) -> bool:
        """Whether both feet stand at the end of the step."""
        return bool(self.double_knots.size)

    @property
    def striking(self) -> bool:
        """Whether that begins with an impact; otherwise the foot touches down at zero speed."""
        return self.closing and bool(self.rear_impulse.size)

    @property
    def slapping(self) -> bool:
        """Whether a foot that landed on a line of its sole comes to lie flat by an impact."""
        return bool(self.flat_rates.size)

    def front_wrench_at(self, times: Array) -> Array:
        """Return the wrench on the front foot at times [s] of the double support, (N, 6)."""
        begin = float(self.knots[-1])
        share = np.clip((times - begin) / (self.duration - begin), 0.0, 1.0)
        return np.asarray(bernstein(share) @ self.front_wrench)

    @property
    def flat_from(self) -> float:
        """Time at which the foot that landed is flat [s]; 0 where it lands flat."""
        return float(self.landing_knots[-1]) if self.lands_on_line else 0.0

    @property
    def landing_angle(self) -> float:
        """Angle of the landing foot at the impact [rad], 0 where it lands flat."""
        return float(self.landing_coefficients[0]) if self.lands_on_line else 0.0

    @property
    def phases(self) -> tuple[ContactPhase, ...]:
        """The parts of the step, in order, each with the contact of the stance foot."""
        if self.closing:
            touch = float(self.knots[-1])
            flat = ContactPhase(FlatFoot.name, 0.0, min(touch, self.turns_at))
            turning = [ContactPhase(self.foot_contact, self.turns_at, touch)] * self.turning
            return (flat, *turning, ContactPhase(BOTH_FEET, touch, self.duration))
        phases = [ContactPhase(FlatFoot.name, self.flat_from, self.turns_at)]
        if self.lands_on_line:
            phases = [ContactPhase(self.landing_contact, 0.0, self.flat_from), *phases]
        if self.turning:
            phases = [*phases, ContactPhase(self.foot_contact, self.turns_at, self.duration)]
        return tuple(phases)

    @property
    def flat(self) -> NDArray[np.bool_]:
        """Which samples are of a stance foot that stands flat, shape (N,)."""
        if not self.lands_on_line:
            return np.asarray(self.time <= self.turns_at)
        return np.asarray((self.time > self.flat_from) & (self.time <= self.turns_at))

    @property
    def foot_angle(self) -> float:
        """Angle of the stance foot at the impact [rad], 0 where it stands flat."""
        return float(self.foot_coefficients[-3]) if self.turning else 0.0

    @property
    def speed(self) -> float:
        """Walking speed [m/s]; below zero backward."""
        if self.second is not None:
            return self.number("motion", "speed") or 0.0
        return self.step_length / self.duration

    @property
    def lateral_speed(self) -> float:
        """Speed to the left [m/s]; zero unless it is a stride."""
        return 0.0 if self.second is None else self.number("motion", "lateral_speed") or 0.0

    @property
    def turn_rate(self) -> float:
        """Rate of the turn about the vertical, to the left [rad/s]; zero unless it is a stride."""
        return 0.0 if self.second is None else self.number("motion", "turn_rate") or 0.0

    @property
    def way(self) -> str:
        """Where it goes, in words: "0.4 m/s, 0.1 m/s to the left, turning right at 0.2 rad/s"."""
        found = [f"{self.speed:.4g} m/s"]
        for rate, words, unit in (
            (self.lateral_speed, "{} to the {}", "m/s"),
            (self.turn_rate, "turning {1} at {0}", "rad/s"),
        ):  # fmt: skip
            if rate != 0.0:
                found.append(
                    words.format(f"{abs(rate):.4g} {unit}", "left" if rate > 0 else "right")
                )
        return ", ".join(found)

    @property
    def in_place(self) -> bool:
        """Whether the gait was asked to get nowhere, so that its cost is told per second."""
        aside = self.number("task", "lateral_speed") or 0.0
        return self.number("task", "speed") == 0.0 and aside == 0.0

    @property
    def cost(self) -> float | None:
        """Value of the cost the gait was optimised for, None if it was not recorded."""
        return self.number("cost")

    @property
    def cost_unit(self) -> str:
        """Unit of the cost; that of the paper's where none was recorded."""
        unit = self.text("task", "cost", "unit") or TorqueCost().unit
        return per_second(unit) if self.in_place else unit

    @property
    def cost_words(self) -> str:
        """What the cost is: "squared torque per metre", or per second where it is in place."""
        words = self.text("task", "cost", "words") or TorqueCost().words
        return words.replace(" per metre", " per second") if self.in_place else words

    @cached_property
    def trajectory(self) -> Trajectory:  # type: ignore[override]
        """The walk as a function of time, from the splines that were optimised.

        Raises:
            RobotError: the gait has no `multibody`, and its URDF is not its robot.
            InputError: the joints of its `multibody` are others than its own.
        """
        body = self.multibody
        if body is None:
            body = drawn_robot(self).multibody
        if body.moving_names != self.joint_names:
            raise InputError(
                f"the gait moves {', '.join(self.joint_names)}, but its robot "
                f"{', '.join(body.moving_names)}; give the robot that it was designed for"
            )
        later = None if self.second is None else self.second._trajectory_phases()
        return Trajectory(body, self._trajectory_phases(), self.mirror, later)

    def _trajectory_phases(self) -> tuple[TrajectoryPhase, ...]:
        """Return the phases of the step, each with its splines."""
        phases = [TrajectoryPhase(0, self.knots, self.coefficients)]
        if self.lands_on_line:
            first, rest = phases[0].split(self.flat_from, self.flat_rates)
            landed = FootTurning(self.landing_hinge, self.landing_knots, self.landing_coefficients)
            phases = [replace(first, turning=landed), rest]
        after: FootTurning | None = None
        if self.turning:
            *before, rest = phases
            flat, last = rest.split(self.turns_at - self.flat_from)
            knots = self.foot_knots - self.foot_knots[0]
            turning = FootTurning(self.foot_hinge, knots, self.foot_coefficients)
            if self.closing:
                turning, after = turning.split(float(self.knots[-1]) - self.turns_at)
            phases = [*before, flat, replace(last, turning=turning)]
        if self.closing:
            knots = self.double_knots - self.double_knots[0]
            spline = 0, knots, self.double_coefficients
            late = TrajectoryPhase(*spline, turning=after, front=self.front_wrench)
            phases = [*phases, late]
        return tuple(phases)


def _laid_flat(ends: Array, hinge: Array) -> Array:
    """Return toe and heel (2, 3) of a sole as if it had turned back to flat about its line."""
    if hinge.size == 0:
        return ends
    rests, other = (0, 1) if hinge[4] > 0.0 else (1, 0)
    across = ends[other] - ends[rests]
    level = across * [1.0, 1.0, 0.0]
    level *= np.linalg.norm(across) / np.linalg.norm(level)
    flat = ends.copy()
    flat[other] = ends[rests] + level
    return flat


def array_names() -> tuple[str, ...]:
    """Return the names of the numeric arrays of a gait, in their order."""
    return tuple(f.name for f in fields(Gait) if f.name in SHAPES)


def _fitted(gait: Gait) -> Array:
    """Return the coefficients of the splines that the samples lie on."""
    motion = gait.q, gait.dq, gait.ddq
    if {part.shape for part in motion} != {(len(gait.time), gait.q.shape[1])}:
        return np.zeros((len(gait.knots) + 2, 0))  # told by the check of sizes
    return fitted_coefficients(gait.knots, gait.time, np.array(motion))


def _frozen(name: str, value: object) -> Array:
    shape = {**SHAPES, **OPTIONAL, **_KNOWN}[name]
    try:
        if isinstance(value, Sized) and shape[0] == "N":  # an array without a size is none
            at_most(len(value), INSTANTS, f"instants in the gait's '{name}'")
        array = np.array(value)
        if array.dtype.kind not in _REAL:
            raise TypeError(array.dtype)
        array = array.astype(np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"the gait's '{name}' is not an array of numbers") from error
    if array.ndim != len(shape):
        expected = " x ".join(map(str, shape))
        raise InputError(f"the gait's '{name}' has shape {array.shape}; it must be {expected}")
    if not np.isfinite(array).all():
        index = ", ".join(str(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InputError(f"the gait's '{name}' holds NaN or infinity at [{index}]")
    if np.abs(array).max(initial=0.0) > NUMBER:
        raise InputError(
            f"the gait's '{name}' holds a number beyond {NUMBER:g}, which is no SI value"
        )
    array.setflags(write=False)
    return array


def _names(name: str, value: object) -> tuple[str, ...]:
    names = tuple(value) if isinstance(value, (list, tuple, np.ndarray)) else ()
    if not all(isinstance(n, str) for n in names) or len(set(names)) != len(names):
        raise InputError(f"the gait's '{name}' must be different texts")
    return tuple(str(n) for n in names)


def _json_copy(meta: Mapping[str, object]) -> dict[str, object]:
    try:
        copy = json.loads(json.dumps(dict(meta), allow_nan=False))
    except (TypeError, ValueError) as error:
        raise InputError(
            f"the gait's 'meta' cannot be written as JSON ({error}); "
            "use plain numbers (no NaN), texts, lists and dicts"
        ) from error
    return dict(copy)


def _check_sizes(gait: Gait) -> None:
    sizes: dict[int | str, int] = {
        "N": len(gait.time),
        "J": len(gait.joint_names),
        "m": len(gait.knots),
        "m + 2": len(gait.knots) + 2,
        "P": len(gait.parameter_names),
    }
    for name, shape in SHAPES.items():
        expected = tuple(sizes.get(s, s) for s in shape)
        found = getattr(gait, name).shape
        if found != expected:
            raise InputError(f"the gait's '{name}' has shape {found}; it must be {expected}")
    bounds = gait.bound_multipliers
    if bounds is not None and len(bounds) != len(gait.parameters):
        raise InputError(
            f"the gait has {len(bounds)} multipliers of bounds on {len(gait.parameters)} parameters"
        )


def _check_flat(gait: Gait) -> None:
    """Refuse an impact by which the foot comes to lie flat that does not fit the step."""
    rates = gait.flat_rates
    if rates.size == 0:
        return
    fits = rates.shape == (2, len(gait.joint_names)) and gait.rear_impulse.size == TWIST
    if not fits or not gait.lands_on_line or gait.closing:
        raise InputError(
            "the gait's flat_rates must be two rows with a rate of every joint, of a foot that "
            "landed on a line of its sole, with six values of rear_impulse and no double support"
        )


def _check_double(gait: Gait) -> None:
    """Refuse a double support that does not fit the step."""
    knots = gait.double_knots
    sizes = gait.double_coefficients.shape, gait.front_wrench.shape
    joints = len(gait.joint_names)
    rear = 0 if gait.slapping else gait.rear_impulse.size
    if knots.size == gait.double_coefficients.size == gait.front_wrench.size == rear == 0:
        return
    if rear not in (0, 6):
        raise InputError("the gait's rear_impulse must be six values, or none")
    if knots.size < 2 or sizes != ((knots.size + 2, joints), (4, 6)):
        raise InputError(
            "the gait's double_knots must be two values at least, with double_coefficients two "
            "more for every joint, and front_wrench four rows of six"
        )
    near = 1e-9 * gait.duration
    fits = abs(knots[0] - gait.knots[-1]) <= near and abs(knots[-1] - gait.duration) <= near
    if not (_increase(knots) and fits):
        raise InputError(
            "the gait's double_knots must increase from the last of its knots to the end of the "
            "step"
        )


def _check_foot(gait: Gait) -> None:
    """Refuse turns of the stance foot that do not fit the step."""
    near, inner = 1e-9 * gait.duration, gait.knots[1:-1]
    if _turns(gait, "foot"):
        begins = inner.size and np.abs(inner - gait.foot_knots[0]).min() <= near
        if not begins or abs(gait.foot_knots[-1] - gait.duration) > near:
            raise InputError(
                "the gait's stance foot must turn from one of its knots until the end of the step"
            )
    if _turns(gait, "landing"):
        ends = inner.size and np.abs(inner - gait.landing_knots[-1]).min() <= near
        if not ends or gait.landing_knots[0] != 0.0 or gait.turns_at <= gait.flat_from + near:
            raise InputError(
                "the gait's landing foot must turn from the start of the step until one of its "
                "knots, before the foot turns again"
            )


def _turns(gait: Gait, part: str) -> bool:
    """Whether there is a turn of the stance foot; refuse one that is none."""
    hinge, knots, coefficients = (getattr(gait, f"{part}_{n}") for n in OF_TURN)
    contact, sizes = getattr(gait, f"{part}_contact"), (hinge.size, coefficients.size)
    if knots.size == 0 and sizes == (0, 0) and contact == "":
        return False
    if not (isinstance(contact, str) and contact):
        raise InputError(f"the gait's {part}_contact must name the contact in which the foot turns")
    if knots.size < 2 or sizes != (6, knots.size + 2) or not _increase(knots):
        raise InputError(
            f"the gait's {part}_knots must increase, two values at least, with {part}_coefficients "
            f"two more, and {part}_hinge must be six numbers"
        )
    return True


def _increase(knots: Array) -> bool:
    """Whether knots increase, by enough for splines between them."""
    return bool(knots.size and (np.diff(knots) > _CLOSEST * np.ptp(knots)).all())


def _check_times(gait: Gait) -> None:
    for name in ("time", "knots"):
        values = getattr(gait, name)
        apart = _increase(values) if name == "knots" else (np.diff(values) > 0.0).all()
        if len(values) < 2 or values[0] != 0.0 or not apart:
            raise InputError(f"the gait's '{name}' must increase from 0 s, two values at least")
    if gait.duration < _SHORTEST:
        raise InputError(
            f"the gait lasts {gait.duration:.3g} s; it must last {_SHORTEST:g} s or more"
        )
    end = gait.double_knots[-1] if gait.double_knots.size else gait.knots[-1]
    if not np.isclose(end, gait.duration, rtol=1e-9, atol=0.0):
        raise InputError(
            f"the gait's last knot is {gait.knots[-1]:.6g} s; "
            f"it must be the end of the step, {gait.duration:.6g} s"
        )


def _check_second(gait: Gait) -> None:
    """Refuse a second step that does not fit the first."""
    second = gait.second
    if second is None:
        return
    if (
        not isinstance(second, Gait)
        or second.second is not None
        or [one.contact for one in gait.phases] != [one.contact for one in second.phases]
    ):
        raise InputError(
            "the gait's second step must be a single step with the contacts of its first"
        )
    if second.joint_names != gait.joint_names or not np.array_equal(second.mirror, gait.mirror):
        raise InputError("the gait's second step has other joints than its first")
    if abs(second.duration - gait.duration) > _NOWHERE * gait.duration:
        raise InputError(
            f"the gait's second step lasts {second.duration:.6g} s; it must last as long as its "
            f"first, {gait.duration:.6g} s"
        )


def _check_mirror(mirror: Array) -> None:
    error = float(np.abs(mirror @ mirror - np.eye(len(mirror))).max())
    if error > _EXCHANGE_TOLERANCE:
        raise InputError(
            f"the gait's 'mirror' E is not a leg exchange: E E differs from 1 by {error:.3g}"
        )
