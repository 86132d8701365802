"""What is asked of the walk: speed, duration, margins, and how finely it is looked at."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields

from gaitopt.bounds import POSTURES, at_most, shown
from gaitopt.errors import InputError
from gaitopt.gait.grid import QUADRATURES, uniform_grid
from gaitopt.gait.parameters import (
    DURATION,
    FOOT_SPACING,
    GEOMETRY,
    STEP_LENGTH,
    Quantity,
    set_quantities,
)
from gaitopt.settings import setting

SPEED_AS = ("constraint", "penalty")
BOUNDARIES = ("closed", "lifted")


def _is_finite(value: object) -> bool:
    if isinstance(value, bool):  # to Python a kind of int
        return False
    try:
        return isinstance(value, float | int) and math.isfinite(value)
    except OverflowError:  # a whole number beyond every float
        return False


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
        torque_limit, speed_limit: replace the robot's limits when given [N.m], [rad/s].
        trunk_roll, trunk_pitch, trunk_yaw: largest angle of the trunk from upright and from the
            direction of travel over the whole step [rad].
        torsional_friction: largest moment about the vertical through the centre of pressure over
            the vertical force, of the stance foot and of the impact [m]; friction * turning_arm of
            the sole is what a foot that presses evenly can bear.
        step_width: largest distance between the two lines of footsteps, |foot_spacing| [m].
        swing_tilt: largest roll, pitch and yaw of the swing sole over the whole step, as sines.
        leg_gap: least distance between the capsules around the bodies of the two legs [m]; less
            where the robot has less when it stands.
    """

    friction: float = 0.7
    minimum_load: float = 25.0
    cop_margin: float = 0.005
    clearance: float = 0.03
    lateral_gap: float = 0.01
    knee_flexion: float = 0.1
    leg_extension: float | None = 0.9995
    liftoff_speed: float = 0.0
    joint_range: bool = True
    impulse_cop: bool = True
    torque_limit: float | None = None
    speed_limit: float | None = None
    trunk_roll: float | None = None
    trunk_pitch: float | None = None
    trunk_yaw: float | None = None
    torsional_friction: float | None = None
    step_width: float | None = None
    leg_gap: float | None = None
    swing_tilt: float | None = None

    def __post_init__(self) -> None:
        for entry in fields(self):
            value, kind = getattr(self, entry.name), str(entry.type)
            if kind == "bool":
                if not isinstance(value, bool):
                    raise InputError(f"{entry.name} is {shown(value)}; it must be True or False")
            elif not _is_finite(value) and not (value is None and "None" in kind):
                raise InputError(f"{entry.name} is {shown(value)}; it must be a finite number")
        for name, unit in (
            ("friction", ""),
            ("leg_extension", ""),
            ("torque_limit", " N.m"),
            ("speed_limit", " rad/s"),
            ("trunk_roll", " rad"),
            ("trunk_pitch", " rad"),
            ("trunk_yaw", " rad"),
            ("torsional_friction", " m"),
            ("step_width", " m"),
            ("swing_tilt", " rad"),
        ):
            value = getattr(self, name)
            if value is not None and not value > 0.0:
                raise InputError(f"{name} is {value}{unit}; it must be above 0")
        for name, unit in (("minimum_load", "N"), ("clearance", "m"), ("cop_margin", "m")):
            if getattr(self, name) < 0.0:
                raise InputError(f"{name} is {getattr(self, name)} {unit}; it must not be negative")
        if self.leg_extension is not None and self.leg_extension > 1.0:
            raise InputError(f"leg_extension is {self.leg_extension}; a leg reaches at most 1")


@dataclass(frozen=True)
class Task:
    """One walking problem.

    Attributes:
        speed: walking speed V of Eq. (39) [m/s].
        duration: of one step, T [s]; free if the geometry table says so, then the first guess.
        postures: intermediate postures of the splines, n - 2 of section 4.1.
        samples: equidistant instants of the step.
        quadrature: rule for the cost, "simpson" or "euler".
        speed_as: "constraint", Eq. (39), or "penalty", Eq. (47).
        penalty_weight: rho of Eq. (47) [cost / m²].
        boundary: of the double support: "closed" by inverse kinematics as in section 4.2, or
            "lifted": its twelve joint angles are parameters as well, tied to it by equalities.
        margins: limits of section 3.2.
        geometry: table of the geometric quantities, free and fixed.
    """

    speed: float = field(default=1.0, metadata=setting("Walking speed.", "m/s", common=True))
    duration: float = field(default=0.4, metadata=setting("Duration of a step.", "s", common=True))
    postures: int = field(default=2, metadata=setting("Intermediate postures of the splines."))
    samples: int = field(default=31, metadata=setting("Instants of the step."))
    quadrature: str = field(
        default="simpson",
        metadata=setting("Rule for the cost.", choices=QUADRATURES, metavar="RULE"),
    )
    speed_as: str = field(
        default="constraint",
        metadata=setting("Speed as a constraint or a penalty.", choices=SPEED_AS, metavar="KIND"),
    )
    penalty_weight: float = field(
        default=1e6, metadata=setting("Weight of that penalty.", "cost/m²")
    )
    boundary: str = field(
        default="closed",
        metadata=setting(
            "Double support by inverse kinematics, closed, or with its joint angles as "
            "parameters, lifted.",
            choices=BOUNDARIES,
            metavar="FORM",
        ),
    )
    margins: Margins = field(default_factory=Margins)
    geometry: tuple[Quantity, ...] = GEOMETRY

    def __post_init__(self) -> None:
        for name, unit in (("speed", "m/s"), ("duration", "s"), ("penalty_weight", "cost/m²")):
            value = getattr(self, name)
            if not (_is_finite(value) and value > 0.0):
                raise InputError(
                    f"{name} is {shown(value)} {unit}; it must be a finite number above 0"
                )
        for name in ("postures", "samples"):
            value = getattr(self, name)
            if not isinstance(value, int) or isinstance(value, bool):
                raise InputError(f"{name} is {shown(value)}; it must be a whole number")
        if self.speed_as not in SPEED_AS:
            raise InputError(
                f"speed_as '{self.speed_as}' is unknown; choose {' or '.join(SPEED_AS)}"
            )
        if self.boundary not in BOUNDARIES:
            raise InputError(
                f"boundary '{self.boundary}' is unknown; choose {' or '.join(BOUNDARIES)}"
            )
        if self.quadrature not in QUADRATURES:
            raise InputError(
                f"quadrature '{self.quadrature}' is unknown; choose {' or '.join(QUADRATURES)}"
            )
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
        if not self.geometry[STEP_LENGTH].free and self.speed_as == "constraint":
            raise InputError("step_length is fixed; free it, or take the speed as a penalty")

    @property
    def step_length(self) -> float:
        """Step length that the speed asks for, V T [m]."""
        return self.speed * self.duration


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


PRESETS = ("standard", "paper")


def preset_task(preset: str = "standard", **changes: object) -> Task:
    """Return a task of a named preset, with some fields changed.

    `standard`: 43 parameters and every constraint. `paper`: the constraints of section 3.2 only,
    the six geometric parameters of section 4.2, speed as the constraint (39).

    Raises:
        InputError: unknown preset or field, or a value out of range.
    """
    if preset not in PRESETS:
        raise InputError(f"preset '{preset}' is unknown; choose {' or '.join(PRESETS)}")
    values: dict[str, object] = {}
    margin_names = {f.name for f in fields(Margins)}
    margins = {k: changes.pop(k) for k in list(changes) if k in margin_names}
    if preset == "paper":
        margins = {"impulse_cop": False, **margins}
        values["geometry"] = set_quantities(GEOMETRY, {"pelvis_yaw": {"free": False}})
    unknown = set(changes) - {f.name for f in fields(Task)}
    if unknown:
        raise InputError(
            f"there is no task field {', '.join(sorted(unknown))}; there are "
            f"{', '.join(f.name for f in fields(Task))}, {', '.join(sorted(margin_names))}"
        )
    if margins:
        values["margins"] = Margins(**margins)  # type: ignore[arg-type]
    return Task(**{**values, **changes})  # type: ignore[arg-type]
