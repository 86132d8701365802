"""The parameters P of Eq. (45): one table, from which every index and every name comes."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import cached_property
from math import isfinite, pi

import numpy as np
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, did_you_mean, there_are
from gaitopt.gait import foot_turn
from gaitopt.model.scales import BIPED, Scales
from gaitopt.nlp import Array
from gaitopt.settings import checked

INFINITY = float("inf")


@checked
@dataclass(frozen=True)
class GeometricParameter:
    """One geometric parameter of the double support, or the duration of the step.

    Attributes:
        name: as in files and messages.
        unit: "m", "rad" or "s".
        scale: a sensible size of one optimisation step.
        lower, upper: bounds while it is free.
        free: whether the optimiser may change it.
        value: its value while it is fixed, and its first guess while it is free; where that is 0,
            pelvis height and place, trunk pitch and foot spacing are guessed from the robot. The
            step length begins with what the speed asks for, the duration is `Task.duration`.
    """

    name: str
    unit: str
    scale: float
    lower: float = -INFINITY
    upper: float = INFINITY
    free: bool = True
    value: float = 0.0


GEOMETRY = (
    GeometricParameter("pelvis_height", "m", 0.1),  # p1 of section 4.2
    GeometricParameter("pelvis_lateral", "m", 0.1),  # p2
    GeometricParameter("pelvis_forward", "m", 0.1),  # p3
    GeometricParameter("trunk_pitch", "rad", 0.1),  # p4
    GeometricParameter("foot_spacing", "m", 0.1),  # p5
    GeometricParameter("step_length", "m", 0.1),  # p6
    GeometricParameter("pelvis_yaw", "rad", 0.1, lower=-0.2, upper=0.2),
    GeometricParameter("pelvis_roll", "rad", 0.1, lower=-0.2, upper=0.2, free=False),
    GeometricParameter("foot_yaw", "rad", 0.1, lower=-0.3, upper=0.3, free=False),
    GeometricParameter("duration", "s", 0.1, lower=0.05, upper=5.0, free=False, value=0.4),
)
"""The nine geometric quantities of section 4.2 (six named there) and the step duration."""

GEOMETRY_NAMES = tuple(q.name for q in GEOMETRY)
PELVIS_HEIGHT, PELVIS_LATERAL, PELVIS_FORWARD, TRUNK_PITCH, FOOT_SPACING = range(5)
STEP_LENGTH, PELVIS_YAW, PELVIS_ROLL, FOOT_YAW, DURATION = range(5, 10)

KNOT_SCALE = 1.0  # rad; measured to be the main lever of the solvers, with the next
RATE_SCALE = 4.0  # rad/s
BEND_SCALE = 50.0  # rad/s²
FORCE_SCALE, MOMENT_SCALE = 200.0, 20.0  # N, N·m: of the front foot
IMPULSE_SCALE, IMPULSE_MOMENT_SCALE = 5.0, 0.5  # N·s, N·m·s: likewise
_LEG = 6  # joints of a leg that follows from where its ends are
_WRENCH = tuple(f"{kind}_{axis}" for kind in ("force", "moment") for axis in "xyz")
_PEAK_SCALE = 10.0  # N·m
PEAK_NAME = "peak_torque"


@dataclass(frozen=True)
class Layout:
    """Where each parameter stands in x: intermediate postures, rates before impact, double support.

    Attributes:
        joint_names: of the n joints.
        postures: number of intermediate postures, n - 2 of section 4.2.
        geometry: the table, complete, in the order of `GEOMETRY`.
        lifted: whether the posture at the start is in x as well, tied to the geometry by equalities
            instead of inverse kinematics.
        turning: whether the stance foot turns at the end of the step, see `foot_turn`.
        landing: whether it lands on a line of its sole and turns at the start of the step.
        slapping: whether it then comes to lie flat by an impact: the rates before that are in x.
        closing: whether both feet stand at the end of the step, see `double_step`: then all joints
            but the swing leg's have two more postures, and the front foot a wrench.
        striking: whether an impact begins that: then the stance leg has one bend more, and the
            front foot an impulse.
        rise: of the footprint ahead over that of the stance foot [m].
        peak: whether the largest torque is a parameter, for a cost that minimises it.
        scales: sizes of the robot, by which steps of its parameters are.
    """

    joint_names: tuple[str, ...]
    postures: int
    geometry: tuple[GeometricParameter, ...] = GEOMETRY
    lifted: bool = False
    turning: bool = False
    rise: float = 0.0
    landing: bool = False
    peak: bool = False
    closing: bool = False
    striking: bool = False
    slapping: bool = False
    scales: Scales = BIPED

    @cached_property
    def free(self) -> list[int]:
        """Rows of the geometry table that are in x."""
        return [i for i, quantity in enumerate(self.geometry) if quantity.free]

    @cached_property
    def fixed_values(self) -> Array:
        """The geometry table's values, shape (10,)."""
        return np.array([quantity.value for quantity in self.geometry])

    @cached_property
    def meaning(self) -> Layout:
        """The layout but for bounds and first guesses: where it is the same, x is the same step."""
        bare = (
            GeometricParameter(q.name, "", 1.0, free=True) if q.free else q for q in self.geometry
        )
        return replace(self, geometry=tuple(bare))

    @cached_property
    def joints(self) -> int:
        """Number of joints n."""
        return len(self.joint_names)

    @cached_property
    def _free_joints(self) -> tuple[str, ...]:
        """Names of the joints whose rates at the end of the step are in x.

        Of those of a closed chain all but the swing leg's, which follow.
        """
        names = self.joint_names
        return (*names[:_LEG], *names[2 * _LEG :]) if self.closing else names

    @cached_property
    def knots(self) -> slice:
        """Entries of the intermediate postures."""
        return slice(0, self.joints * self.postures)

    @cached_property
    def rates(self) -> slice:
        """Entries of the rates before impact; if it is closing at lift-off, of its free joints."""
        return slice(self.knots.stop, self.knots.stop + len(self._free_joints))

    @cached_property
    def start(self) -> slice:
        """Entries of the posture at the start: n in the lifted form, else none."""
        first = self.rates.stop
        return slice(first, first + self.joints * self.lifted)

    @cached_property
    def shape(self) -> slice:
        """Entries of the free geometric quantities."""
        return slice(self.start.stop, self.start.stop + len(self.free))

    @property
    def of_joints(self) -> list[int]:
        """Entries that are angles or rates of joints."""
        return [*range(self.start.stop), *range(self.flat.start, self.flat.stop)]

    @cached_property
    def turn(self) -> slice:
        """Entries of the stance foot's turn, the angle of the rear foot first; or none."""
        return slice(self.shape.stop, self.shape.stop + len(foot_turn.NAMES) * self.turning)

    @cached_property
    def landed(self) -> slice:
        """Entries of the foot's turn after its landing, the angle at the landing first; or none."""
        count = len(foot_turn.LANDING_NAMES) * self.landing + self.slapping
        return slice(self.turn.stop, self.turn.stop + count)

    @cached_property
    def flat(self) -> slice:
        """Entries of the joint rates before an impact by which the foot comes to lie flat."""
        return slice(self.landed.stop, self.landed.stop + self.joints * self.slapping)

    @cached_property
    def late(self) -> slice:
        """Entries that bend the stance leg while both feet stand; or none."""
        count = len(self.bends) * len(self._free_joints)
        return slice(self.flat.stop, self.flat.stop + count)

    @property
    def bends(self) -> tuple[str, ...]:
        """When the stance leg has an acceleration of its own while both feet stand."""
        if self.striking:
            return ("at_touch_down", "midway", "at_lift_off")
        return ("at_touch_down", "midway") if self.closing else ()

    @cached_property
    def front(self) -> slice:
        """Entries of the wrench on the front foot, four times six; or none."""
        return slice(self.late.stop, self.late.stop + 4 * _LEG * self.closing)

    @cached_property
    def push(self) -> slice:
        """Entries of the impulse on the front foot as both feet come to stand; or none."""
        return slice(self.front.stop, self.front.stop + _LEG * self.striking)

    @cached_property
    def largest(self) -> slice:
        """Entry of the largest torque, the last one; or none."""
        return slice(self.push.stop, self.push.stop + self.peak)

    @cached_property
    def boundary(self) -> NDArray[np.int_]:
        """Entries that shape the double support: posture at the start, geometry, both feet."""
        feet = [self.turn.start] * self.turning + [self.landed.start] * self.landing
        return np.array([*range(self.start.start, self.shape.stop), *feet], dtype=np.int_)

    @property
    def boundary_size(self) -> int:
        """Number of the boundary's own coordinates B: n angles if lifted, G quantities."""
        return self.joints * self.lifted + len(self.geometry) + self.turning + self.landing

    @cached_property
    def boundary_columns(self) -> list[int]:
        """Which of the boundary's own coordinates are in x."""
        angles, feet = self.joints * self.lifted, range(self.turning + self.landing)
        rows = [*self.free, *(len(self.geometry) + foot for foot in feet)]
        return [*range(angles), *(angles + row for row in rows)]

    @cached_property
    def size(self) -> int:
        """Length of x."""
        return int(self.largest.stop)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Name of every entry of x."""
        knots = [f"{j}_at_knot_{k + 1}" for k in range(self.postures) for j in self.joint_names]
        rates = [f"{j}_rate_before_impact" for j in self.joint_names]
        late: list[str] = []
        if self.closing:
            rates = [f"{j}_rate_at_lift_off" for j in self._free_joints]
            late = [f"{j}_bend_{when}" for when in self.bends for j in self._free_joints]
            late += [f"front_foot_{part}_{k + 1}" for k in range(4) for part in _WRENCH]
        if self.striking:
            late += [f"front_foot_impulse_{part}" for part in _WRENCH]
        start = [f"{j}_at_start" for j in self.joint_names] if self.lifted else []
        turn = foot_turn.NAMES if self.turning else ()
        turn = (*turn, *(foot_turn.LANDING_NAMES if self.landing else ()))
        if self.slapping:
            turn = (*turn, foot_turn.SLAP_NAME, *(f"{j}_rate_at_flat" for j in self.joint_names))
        turn = (*turn, *late)
        peak = (PEAK_NAME,) if self.peak else ()
        return (*knots, *rates, *start, *(self.geometry[i].name for i in self.free), *turn, *peak)

    def index(self, name: str) -> int | None:
        """Return where a geometric quantity stands in x, or None if it is fixed."""
        row = GEOMETRY_NAMES.index(name)
        return self.shape.start + self.free.index(row) if row in self.free else None

    def geometry_of(self, x: Array) -> Array:
        """Return the geometric quantities at x, shape (G,).

        The ten, free and fixed; the angle of the rear foot where the stance foot turns before it
        leaves; that of the front foot where it lands on a line.
        """
        values = self.fixed_values.copy()
        values[self.free] = x[self.shape]
        feet = [*x[self.turn][:1], *x[self.landed][:1]]
        return np.append(values, feet) if feet else values

    def pack(
        self,
        knots: Array,
        rate_before: Array,
        q_start: Array,
        geometry: Array,
        turn: Array | None = None,
    ) -> Array:
        """Return x from postures (k, n), rates (n,), start (n,), all geometry (10,), turns (p,).

        The posture at the start goes in only in the lifted form; the turns, that before the foot
        leaves and that after it landed side by side, where there are any. The largest torque, where
        it is in x, is left 0.
        """
        start = q_start if self.lifted else q_start[:0]
        turn = np.zeros(self.push.stop - self.turn.start) if turn is None else turn
        peak = np.zeros(int(self.peak))
        return np.concatenate([knots.ravel(), rate_before, start, geometry[self.free], turn, peak])

    def bounds(self) -> tuple[Array, Array]:
        """Return lower and upper bounds of x, shape (P,) each."""
        lower, upper = np.full(self.size, -INFINITY), np.full(self.size, INFINITY)
        lower[self.shape] = [self.geometry[i].lower for i in self.free]
        upper[self.shape] = [self.geometry[i].upper for i in self.free]
        if self.turning:
            lower[self.turn], upper[self.turn] = 0.0, foot_turn.LARGEST_ANGLE
            upper[self.turn.stop - 1] = foot_turn.LARGEST_RATE * self.scales.rate
        lower[self.landed], upper[self.landed] = 0.0, foot_turn.LARGEST_ANGLE
        if self.slapping:
            last = self.landed.stop - 1
            lower[last], upper[last] = -foot_turn.LARGEST_RATE * self.scales.rate, 0.0
        lower[self.largest] = 0.0
        return lower, upper

    def scale(self) -> Array:
        """Return the size of a sensible step of each entry of x, shape (P,)."""
        scale = np.full(self.size, KNOT_SCALE)
        own = self.scales
        scale[self.rates] = RATE_SCALE * own.rate
        scale[self.shape] = [self.geometry[i].scale for i in self.free]
        if self.turning:
            scale[self.turn] = foot_turn.ANGLE_SCALE
            scale[self.turn.stop - 1] = foot_turn.RATE_SCALE * own.rate
        scale[self.landed] = foot_turn.ANGLE_SCALE
        if self.slapping:
            scale[self.landed.stop - 1] = foot_turn.RATE_SCALE * own.rate
        scale[self.flat] = RATE_SCALE * own.rate
        scale[self.late] = BEND_SCALE * own.rate**2
        scale[self.front] = np.tile(wrench_scale(own), 4 * self.closing)
        impulse = np.repeat(
            [IMPULSE_SCALE * own.impulse, IMPULSE_MOMENT_SCALE * own.angular_impulse], 3
        )
        scale[self.push] = np.tile(impulse, int(self.striking))
        scale[self.largest] = _PEAK_SCALE * own.moment
        return scale


def wrench_scale(scales: Scales) -> Array:
    """Return the size of a sensible step of a foot's wrench, shape (6,)."""
    return np.repeat([FORCE_SCALE * scales.force, MOMENT_SCALE * scales.moment], 3)


@dataclass(frozen=True)
class Chart:
    """Parameters z of a step as an affine function of those of the walk, z = matrix x + offset.

    Attributes:
        matrix: shape (p, P).
        offset: shape (p,); None: z is x itself.
    """

    matrix: Array
    offset: Array | None = None

    def of(self, x: Array) -> Array:
        """Return z at x (P,)."""
        return x if self.offset is None else self.matrix @ x + self.offset


def identity_chart(size: int) -> Chart:
    """Return the chart of a walk of one step, whose parameters are those of that step."""
    return Chart(np.eye(size))


def geometric_unit(name: str) -> str:
    """Return the SI unit of a geometric quantity.

    Raises:
        InputError: there is none of that name.
    """
    if name not in GEOMETRY_NAMES:
        raise InputError(
            f"there is no geometric quantity '{name}'; {there_are(GEOMETRY_NAMES, name)}"
        )
    return GEOMETRY[GEOMETRY_NAMES.index(name)].unit


def set_geometry(
    table: tuple[GeometricParameter, ...], changes: dict[str, dict[str, float | bool]]
) -> tuple[GeometricParameter, ...]:
    """Return the table with some fields of some quantities changed.

    Raises:
        InputError: an unknown quantity, or bounds that leave no room.
    """
    known = {f.name for f in fields(GeometricParameter)} - {"name", "unit"}
    for name, change in changes.items():
        geometric_unit(name)
        if unknown := set(change) - known:
            raise InputError(
                f"{name} has no field {', '.join(sorted(unknown))}; "
                f"{did_you_mean(min(unknown), known)}it has {', '.join(sorted(known))}"
            )
    changed = tuple(
        replace(q, **changes[q.name]) if q.name in changes else q  # type: ignore[arg-type]
        for q in table
    )
    for quantity in changed:
        _check_quantity(quantity)
    return changed


def _check_quantity(q: GeometricParameter) -> None:
    if not q.lower < q.upper:
        raise InputError(
            f"{q.name}: lower bound {q.lower} {q.unit} is not below upper bound {q.upper} {q.unit}"
        )
    if not isfinite(q.value):
        raise InputError(f"{q.name} is {q.value} {q.unit}; it must be a finite number")
    if q.unit == "rad" and abs(q.value) > pi:
        raise InputError(f"{q.name} is {q.value:g} rad; give at most half a turn, {pi:.5g} rad")
    if not (isfinite(q.scale) and q.scale > 0.0):
        raise InputError(f"{q.name}: scale is {q.scale} {q.unit}; it must be above 0")
