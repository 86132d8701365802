"""A walk as a function of time: base, joints, torques, ground wrenches and contacts at any instant.

Whatever shows, exports or simulates a gait reads it here; nothing is fitted again.

Frames: the world stands on the ground, x forward along the walk, z up, and its origin is that of
the sole frame that stands first. Twists and accelerations of the base are of its origin and in its
own axes, linear before angular, as in Pinocchio's free-flyer. Wrenches are in the sole frames.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from gaitopt.bounds import TIMES, at_most, fixed, is_finite, shown
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.gait.spline import bernstein, spline_basis
from gaitopt.mechanics.single_support import passive_torque
from gaitopt.model.chain_physics import PassiveJoints
from gaitopt.model.multibody import Multibody
from gaitopt.nlp import Array
from gaitopt.settings import checked_arguments, checked_facts

MIRRORED_WRENCH = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
"""Signs of a wrench seen in a mirror, in the other foot's sole frame."""

LATEST = 1e9
"""Time from the beginning at which a walk is evaluated [s]: 30 years; floats tell 0.1 µs there."""

_SNAP = 1e-9  # of a step: instants this near to its end are its end
_STRAIGHT = 1e-9  # rad: feet turned by less point along the walk
_FEET = 2
_ITERATIONS, _CLOSED = 20, 1e-12  # rad: of Newton's method, which is quadratic
_RESTING = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])  # base at the origin: x y z, quaternion


@checked_facts
@dataclass(frozen=True, eq=False)
class FootTurning:
    """How the standing foot turns about a line of its sole that rests on the ground.

    Attributes:
        hinge: twist of the sole per unit of the angle's rate, in its frame, linear first, (6,).
        knots: of the angle's spline, from 0 to the duration of the phase [s], shape (k,).
        coefficients: angle at the knots [rad], rates at the start and at the end, shape (k + 2,).
    """

    hinge: Array
    knots: Array
    coefficients: Array

    def motion(self, times: Array) -> Array:
        """Return angle, rate and acceleration at times [s] within the phase, shape (3, N)."""
        return clamped_spline(self.knots, self.coefficients[:, None], times)[:, :, 0]

    def split(self, at: float) -> tuple[FootTurning, FootTurning]:
        """Return its parts before and after one of its inner knots [s]."""
        (k1, before), (k2, after) = split_spline(self.knots, self.coefficients[:, None], at)
        return (
            FootTurning(self.hinge, k1, before[:, 0]), FootTurning(self.hinge, k2, after[:, 0]),
        )  # fmt: skip


@checked_facts
@dataclass(frozen=True, eq=False)
class TrajectoryPhase:
    """A part of a step in which one foot stands and the joints follow one spline.

    Attributes:
        standing: the foot, as index into `Multibody.sole_names`.
        knots: of the spline, from 0 to the duration of the phase [s], shape (m,).
        coefficients: joint angles at the knots [rad], rates at the start and at the end [rad/s],
            shape (m + 2, n); joints as in `Multibody.moving`.
        turning: of the standing foot; None where it stands flat.
        front: wrench of the ground on the other foot, which stands too, in its sole frame: control
            points of a cubic in Bernstein's form, shape (4, 6); None where that foot swings. Its
            leg then is where its sole stays, near its splines.
    """

    standing: int
    knots: Array
    coefficients: Array
    turning: FootTurning | None = None
    front: Array | None = None

    @property
    def duration(self) -> float:
        """Duration of the phase [s]."""
        return float(self.knots[-1])

    @property
    def still(self) -> bool:
        """Whether nothing moves in it."""
        values, rates = self.coefficients[:-2], self.coefficients[-2:]
        return not (rates.any() or (values - values[0]).any())

    def motion(self, times: Array) -> Array:
        """Return angles, rates and accelerations at times [s] within the phase, (3, N, n)."""
        return clamped_spline(self.knots, self.coefficients, times)

    def foot_motion(self, times: Array) -> Array:
        """Return placement in its footprint, twist and acceleration of the standing sole.

        Args:
            times: within the phase [s], shape (N,).

        Returns:
            As exponential coordinates, twist and its derivative in the sole frame, shape (3, N, 6).
        """
        if self.turning is None:
            return np.zeros((3, len(times), 6))
        return np.asarray(self.turning.motion(times)[:, :, None] * self.turning.hinge)

    def front_wrench(self, times: Array) -> Array:
        """Return the wrench on the other foot at times [s] within the phase, shape (N, 6)."""
        if self.front is None:
            return np.zeros((len(times), 6))
        return np.asarray(bernstein(np.clip(times / self.duration, 0.0, 1.0)) @ self.front)

    def split(
        self, at: float, rates: Array | None = None
    ) -> tuple[TrajectoryPhase, TrajectoryPhase]:
        """Return its parts before and after one of its inner knots [s]; as `split_spline`."""
        before, after = split_spline(self.knots, self.coefficients, at, rates)
        return TrajectoryPhase(self.standing, *before), TrajectoryPhase(self.standing, *after)


def clamped_spline(knots: Array, coefficients: Array, times: Array) -> Array:
    """Return values, first and second derivatives of clamped splines at times [s], (3, N, n).

    Args:
        knots: from 0 [s], shape (m,).
        coefficients: values at the knots, rates at the start and at the end, shape (m + 2, n).
        times: from 0 to the last knot [s], shape (N,).
    """
    duration = float(knots[-1])
    basis = spline_basis(knots / duration, np.clip(times / duration, 0.0, 1.0))
    return np.asarray((basis.at(duration) @ coefficients).swapaxes(0, 1))


def split_spline(
    knots: Array, coefficients: Array, at: float, rates: Array | None = None
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return knots and coefficients of a clamped spline before and after one of its inner knots.

    Args:
        knots, coefficients: as of `clamped_spline`.
        at: the knot [s].
        rates: before and after it [rad/s], (2, n), where they jump; None or no rows: of the spline.
    """
    inner = int(np.argmin(np.abs(knots - at)))
    if rates is None or not rates.size:
        rates = clamped_spline(knots, coefficients, knots[[inner, inner]])[1]
    values, first, last = coefficients[:-2], coefficients[-2:-1], coefficients[-1:]
    before = np.concatenate([values[: inner + 1], first, rates[:1]])
    after = np.concatenate([values[inner:], rates[1:], last])
    return (knots[: inner + 1], before), (knots[inner:] - knots[inner], after)


@dataclass(frozen=True, eq=False)
class TrajectorySamples:
    """A trajectory at N instants; joints are all M of the file, in its order.

    Attributes:
        time: [s], shape (N,).
        step: number of the step that an instant belongs to, from 0, shape (N,).
        phase: number of its phase within the step, shape (N,).
        base_position: origin of the base in the world [m], shape (N, 3).
        base_quaternion: its orientation, x y z w, shape (N, 4).
        base_twist: linear [m/s] and angular velocity [rad/s], shape (N, 6).
        base_acceleration: time derivative of the twist's components, shape (N, 6).
        q, dq, ddq: joint coordinates [rad or m], rates and accelerations, shape (N, M).
        torque: of the motors [N·m or N]; of joints that do not move what holds them, and 0 of those
            that follow others, whose motors move them, (N, M).
        contact: which feet stand, in the order of `Multibody.sole_names`, shape (N, 2).
        sole: placements of the sole frames in the world, shape (N, 2, 4, 4).
        standing: foot whose footprint the step counts from, index as of `contact`, shape (N,).
        wrench: of the ground on the feet, force [N] and moment about the sole frame's origin
            [N·m] in the sole frame, shape (N, 2, 6).
    """

    time: Array
    step: NDArray[np.int64]
    phase: NDArray[np.int64]
    base_position: Array
    base_quaternion: Array
    base_twist: Array
    base_acceleration: Array
    q: Array
    dq: Array
    ddq: Array
    torque: Array
    contact: NDArray[np.bool_]
    sole: Array
    wrench: Array
    standing: NDArray[np.int64]

    @property
    def configuration(self) -> Array:
        """Configurations of `Multibody.model`: base position, quaternion, joints, (N, 7 + M)."""
        return np.hstack([self.base_position, self.base_quaternion, self.q])

    @property
    def velocity(self) -> Array:
        """Velocities of `Multibody.model`: base twist, joint rates, shape (N, 6 + M)."""
        return np.hstack([self.base_twist, self.dq])

    @property
    def acceleration(self) -> Array:
        """Accelerations of `Multibody.model`, shape (N, 6 + M)."""
        return np.hstack([self.base_acceleration, self.ddq])

    @property
    def force(self) -> Array:
        """Force of the ground on each foot in the world [N], shape (N, 2, 3)."""
        force = np.einsum("nfij,nfj->nfi", self.sole[..., :3, :3], self.wrench[..., :3])
        return np.asarray(force)

    @property
    def pressure(self) -> Array:
        """Centre of pressure of each foot in its sole frame [m], (N, 2, 2); NaN in the air."""
        normal = np.where(self.contact, self.wrench[..., 2], np.nan)[..., None]
        return np.stack([-self.wrench[..., 4], self.wrench[..., 3]], axis=-1) / normal


@checked_facts
@dataclass(frozen=True, eq=False)
class Trajectory:
    """A periodic walk, defined at every time; it repeats itself for ever, the base advancing.

    Attributes:
        body: the robot.
        phases: of one step, in order.
        exchange: E, shape (n, n): joints of the next step are E times those of this one, and the
            feet change roles, Eq. (26); None where a step is followed by the same again.
        second: phases of the next step as its mirror image, as long as the first; by default those
            of the first.
    """

    body: Multibody
    phases: tuple[TrajectoryPhase, ...]
    exchange: Array | None
    second: tuple[TrajectoryPhase, ...] | None = None

    def __repr__(self) -> str:
        """Return it in one line: the whole of it is pages long."""
        return (
            f"<Trajectory of {self.body.name!r}: {len(self.phases)} phases in "
            f"{fixed(self.step_duration, 3)} s, again after {fixed(self.period, 3)} s>"
        )

    @property
    def step_duration(self) -> float:
        """Time until the next step begins [s]."""
        return float(self._ends[-1])

    @property
    def period(self) -> float:
        """Time after which the motion repeats [s]: two steps where legs are exchanged."""
        return self._steps * self.step_duration

    @property
    def changes(self) -> Array:
        """Times within a period at which a phase ends, its own end among them [s], shape (k,)."""
        return np.asarray(
            [step * self.step_duration + end for step in range(self._steps) for end in self._ends]
        )

    @property
    def breaks(self) -> Array:
        """Times within a period at which a phase begins or ends [s], shape (k + 1,)."""
        return np.append(0.0, self.changes)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints of samples, all of the file."""
        return self.body.joint_names

    @checked_arguments
    def advance(self, step: int) -> pin.SE3:
        """Return the placement in the world of the sole that stands in a step, from step 0."""
        return self._place(step, 0)

    @checked_arguments
    def times(self, rate: float, strides: float = 1.0) -> Array:
        """Return equidistant times (N,) [s] of a number of strides, the last excluded.

        Args:
            rate: samples a second [Hz].
            strides: number of periods; halves are steps.

        Raises:
            InputError: the rate or the number is not above 0, or there are too many instants.
        """
        if not (is_finite(rate) and is_finite(strides) and rate > 0.0 and strides > 0.0):
            given = f"{shown(rate)} Hz and {shown(strides)} strides"
            raise InputError(f"{given}: both must be finite numbers above 0")
        count = int(np.ceil(strides * self.period * rate - _SNAP))
        at_most(count, TIMES, "instants")
        return np.asarray(np.arange(count) / rate)

    def at(self, times: ArrayLike, before: bool | ArrayLike = False) -> TrajectorySamples:
        """Return the walk at any times.

        Rates, torques and wrenches jump where the swing foot lands: there, the values after the
        impact are returned.

        Args:
            times: [s], a number or shape (N,).
            before: whether an instant of change belongs to the phase that ends, not to the one
                that begins; one for all, or one for each time.

        Raises:
            InputError: a time is no number up to `LATEST`, there are too many of them, or
                `before` is neither one nor as many.
        """
        try:
            t = np.atleast_1d(np.asarray(times)).astype(np.float64, casting="same_kind")
        except (TypeError, ValueError):
            t = np.full(1, np.nan)
        if t.ndim != 1 or not self._reaches(t):
            raise InputError(f"times of {self._reach}, shape (N,)")
        at_most(len(t), TIMES, "instants")
        ending = np.asarray(before, dtype=bool)
        if ending.shape not in ((), t.shape):
            raise InputError(f"`before` has shape {ending.shape}; give one, or one for each time")
        return self._evaluated(t, *self._located(t, np.broadcast_to(ending, t.shape)))

    _reach = f"a trajectory must be numbers up to {LATEST:g} s"

    def _reaches(self, times: Array) -> bool:
        """Whether it is defined at all of some times (N,) [s]."""
        return bool((np.abs(times) <= LATEST).all())

    def _located(
        self, t: Array, ending: NDArray[np.bool_]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        """Step, phase, and time in it [s], of times (N,); whether an instant of change ends one."""
        share = t / self.step_duration
        step = np.where(ending, np.ceil(share - _SNAP) - 1, np.floor(share + _SNAP))
        local = np.clip(t - step * self.step_duration, 0.0, self.step_duration)
        slack = _SNAP * self.step_duration
        phase = (local[:, None] - np.where(ending, slack, -slack)[:, None] >= self._ends[:-1]).sum(
            axis=1
        )
        return step.astype(np.int64), phase, local - self._starts[phase]

    @cached_property
    def _ends(self) -> Array:
        """Ends of the phases within a step [s]."""
        return np.cumsum([phase.duration for phase in self.phases])

    @cached_property
    def _starts(self) -> Array:
        return np.concatenate([[0.0], self._ends[:-1]])

    @property
    def _steps(self) -> int:
        """Steps of a period."""
        return 1 if self.exchange is None else 2

    @cached_property
    def _stances(self) -> tuple[tuple[tuple[pin.SE3, ...], ...], pin.SE3]:
        """Placement of the footprint in each phase of each step of a period, and the stride.

        The stride moves the world so that the next period looks like this one.
        """
        stances, place = self._followed(self._steps)
        line = _heading(stances)
        stride = line * place * line.inverse()
        return tuple(tuple(line * p for p in own) for own in stances), stride

    def _followed(self, steps: int) -> tuple[list[tuple[pin.SE3, ...]], pin.SE3]:
        """Return the placements of the footprints in some steps from the first, and of the next."""
        feet = _Feet(self.body)
        place, stances = pin.SE3.Identity(), []
        standing = self._standing(0, 0)
        for step in range(steps):
            own = []
            phases = self._phases(step)
            for index, phase in enumerate(phases):
                own.append(place)
                end = self._exchanged(phase.motion(np.array([phase.duration]))[0], step)[0]
                last = index + 1 == len(phases)
                following = self._standing(step + last, 0 if last else index + 1)
                if following != standing:
                    soles = feet.soles(end)
                    turned = phase.foot_motion(np.array([phase.duration]))[0, 0]
                    place = place * pin.exp6(turned) * soles[standing].inverse() * soles[following]
                    landed = self._phases(step + 1)[0].foot_motion(np.zeros(1))
                    place = place * pin.exp6(-landed[0, 0])  # where it will be flat
                    standing = following
            stances.append(tuple(own))
        return stances, place

    def _phases(self, step: int) -> tuple[TrajectoryPhase, ...]:
        """Return the phases of a step, as of its mirror image where it is an odd one."""
        return self.phases if self.second is None or step % 2 == 0 else self.second

    def _standing(self, step: int, phase: int) -> int:
        foot = self._phases(step)[phase].standing
        return 1 - foot if self._mirrored(step) else foot

    def share(self, samples: TrajectorySamples) -> Array:
        """Return the share of its step that is over at each sample, from 0 to 1, shape (N,)."""
        return np.asarray(np.maximum(samples.time / self.step_duration - samples.step, 0.0))

    def _exchanged(self, joints: Array, step: int) -> Array:
        """Return joint values (..., n) of a step, given those of step 0."""
        if self.exchange is None or not self._mirrored(step):
            return joints
        return np.asarray(joints @ self.exchange.T)

    def _mirrored(self, step: int) -> bool:
        """Return whether a step is the mirror image of how it is given."""
        return self.exchange is not None and step % 2 == 1

    def _place(self, step: int, phase: int) -> pin.SE3:
        stances, stride = self._stances
        periods, inside = divmod(step, self._steps)
        moved = pin.exp6(pin.Motion(periods * pin.log6(stride).vector))
        return moved * stances[inside][phase]

    def _evaluated(
        self, times: Array, step: NDArray[np.int64], phase: NDArray[np.int64], local: Array
    ) -> TrajectorySamples:
        body, count, joints = self.body, len(times), len(self.body.joint_names)
        motion = np.zeros((3, count, joints))
        motion[0] = body.posture
        foot_motion, front = np.zeros((3, count, 6)), np.zeros((count, 6))
        both = np.zeros(count, dtype=bool)
        parts = list(self._parts(step, phase))
        for part, number, rows in parts:
            values = self._exchanged(part.motion(local[rows]), number)
            motion[:, rows[:, None], body.moving] = values
            foot_motion[:, rows] = part.foot_motion(local[rows])
            turned = MIRRORED_WRENCH if self._mirrored(number) else 1.0
            front[rows] = part.front_wrench(local[rows]) * turned
            both[rows] = part.front is not None
        body.follow(motion)
        places = {
            key: self._place(*key) for key in set(zip(step.tolist(), phase.tolist(), strict=True))
        }
        keys = zip(step.tolist(), phase.tolist(), strict=True)
        standing = [(self._standing(*key), places[key]) for key in keys]
        dynamics = _Dynamics(body)
        for part, number, rows in parts:
            if part.front is not None and not part.still:
                self._close(motion, part, number, rows, foot_motion)
        q, v, a = (np.zeros((count, size + joints)) for size in (7, 6, 6))
        q[:, 7:], v[:, 6:], a[:, 6:] = motion
        torque, wrench = np.empty((count, joints)), np.empty((count, 6))
        sole = np.empty((count, _FEET, 4, 4))
        for k, stance in enumerate(standing):
            instant = q[k], v[k], a[k], torque[k], sole[k]
            wrench[k] = dynamics.complete(*instant, *stance, foot_motion[:, k], front[k])
        foot = np.array([s for s, _ in standing], dtype=np.int64)
        each = np.arange(count)
        contact, on_feet = np.zeros((count, _FEET), dtype=bool), np.zeros((count, _FEET, 6))
        contact[each, foot], on_feet[each, foot] = True, wrench
        contact[each, 1 - foot], on_feet[each, 1 - foot] = both, front
        return TrajectorySamples(
            time=times,
            step=step,
            phase=phase,
            base_position=q[:, :3],
            base_quaternion=q[:, 3:7],
            base_twist=v[:, :6],
            base_acceleration=a[:, :6],
            q=motion[0],
            dq=motion[1],
            ddq=motion[2],
            torque=body.by_motors(torque + self._passive(motion), motion[0]),
            contact=contact,
            sole=sole,
            wrench=on_feet,
            standing=foot,
        )

    def _parts(
        self, step: NDArray[np.int64], phase: NDArray[np.int64]
    ) -> Iterator[tuple[TrajectoryPhase, int, NDArray[np.int64]]]:
        """Yield each phase, a step that it is of, and the rows of its instants."""
        for odd in range(self._steps):
            for index, part in enumerate(self._phases(odd)):
                yield part, odd, np.flatnonzero((phase == index) & (step % self._steps == odd))

    def _close(
        self,
        motion: Array,
        part: TrajectoryPhase,
        step: int,
        rows: NDArray[np.int64],
        foot_motion: Array,
    ) -> None:
        """Move the leg of a second foot that stands to where its sole stays, see `motion`."""
        closing, start = _Closing(self.body), self._exchanged(part.motion(np.zeros(1))[0], step)[0]
        foot = 1 - part.standing if self._mirrored(step) else part.standing
        target = pin.exp6(part.foot_motion(np.zeros(1))[0, 0]) * closing.between(start, foot)
        for k in rows:
            closing.close(motion[:, k], foot, target, foot_motion[:, k])

    def _passive(self, motion: Array) -> Array | float:
        """Return what motors need against friction, damping and springs; most files have none."""
        body = self.body
        parts = body.damping, body.friction, body.stiffness
        if not any(part.any() for part in parts):
            return 0.0
        joints = PassiveJoints(*parts, body.rest)
        return np.asarray(passive_torque(joints, motion[0], motion[1]).value)


@checked_facts
@dataclass(frozen=True, eq=False)
class StepSequence(Trajectory):
    """Steps one after another, each of one phase, that do not repeat; before and after it is still.

    Every second step is given as its mirror image, as of a periodic walk. Time begins with the
    first step. A step that begins with both feet on the ground is two of them, with one number.

    Attributes:
        numbers: of the steps; even ones are as given, odd ones mirror images.
    """

    numbers: tuple[int, ...] = (0,)

    def __repr__(self) -> str:
        """Return it in one line: the whole of it is pages long."""
        return (
            f"<StepSequence of {self.body.name!r}: {len(self.phases)} in {fixed(self.period, 3)} s>"
        )

    @property
    def period(self) -> float:
        """Time of all steps [s]."""
        return float(self._ends[-1])

    @property
    def step_duration(self) -> float:
        return self.period / len(self.phases)

    @property
    def changes(self) -> Array:
        return self._ends

    @checked_arguments
    def advance(self, step: int) -> pin.SE3:
        """Return the placement in the world of the sole that stands in a step, from step 0.

        Raises:
            InputError: there is no such step.
        """
        if not 0 <= step < len(self.phases):
            raise InputError(f"there is no step {shown(step)} of {len(self.phases)}; count from 0")
        return super().advance(step)

    @property
    def _reach(self) -> str:  # type: ignore[override]  # a constant of others
        return f"this motion must be from 0 to {self.period:.6g} s"

    def _reaches(self, times: Array) -> bool:
        slack = _SNAP * self.step_duration
        return bool(((times >= -slack) & (times <= self.period + slack)).all())

    def _located(
        self, t: Array, ending: NDArray[np.bool_]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        slack = _SNAP * self.step_duration
        inner = self._ends[:-1]
        step = (t[:, None] - np.where(ending, slack, -slack)[:, None] >= inner).sum(axis=1)
        local = np.clip(t - self._starts[step], 0.0, np.diff([0.0, *self._ends])[step])
        return step.astype(np.int64), np.zeros(len(t), dtype=np.int64), local

    def share(self, samples: TrajectorySamples) -> Array:
        durations = np.diff([0.0, *self._ends])[samples.step]
        return np.asarray((samples.time - self._starts[samples.step]) / durations)

    @property
    def _steps(self) -> int:
        return len(self.phases)

    @cached_property
    def _stances(self) -> tuple[tuple[tuple[pin.SE3, ...], ...], pin.SE3]:
        stances, place = self._followed(len(self.phases) - 1)
        line = _heading([*stances, (place,)])
        return tuple((line * one,) for (one,) in [*stances, (place,)]), pin.SE3.Identity()

    def _phases(self, step: int) -> tuple[TrajectoryPhase, ...]:
        return (self.phases[step],)

    def _mirrored(self, step: int) -> bool:
        return super()._mirrored(self.numbers[step])


def fitted_coefficients(knots: Array, times: Array, motion: Array) -> Array:
    """Return the spline coefficients of sampled motion, by least squares, shape (m + 2, n).

    Exact for samples of a clamped cubic spline; gait files of format 1 hold only these.

    Args:
        knots: from 0 to the duration [s], shape (m,).
        times: of the samples [s], shape (N,).
        motion: angles, rates and accelerations, shape (3, N, n).
    """
    duration = float(knots[-1])
    basis = spline_basis(knots / duration, times / duration).at(duration)
    size = duration ** np.arange(3.0)[:, None, None]  # all three in angles, so that none prevails
    rows = (basis.swapaxes(0, 1) * size).reshape(-1, basis.shape[2])
    values = (motion * size).reshape(-1, motion.shape[2])
    scale = np.ones(basis.shape[2])
    scale[-2:] = 1.0 / duration
    found: Array = np.linalg.lstsq(rows * scale, values, rcond=None)[0] * scale[:, None]
    return found


class _Feet:
    """Where the feet of a robot are, its base at the origin."""

    def __init__(self, body: Multibody) -> None:
        self._model, self._body = body.model, body
        self._data = self._model.createData()
        self._frames = [self._model.getFrameId(name) for name in body.sole_names]

    def soles(self, joints: Array) -> tuple[pin.SE3, ...]:
        """Return the placements of both sole frames for angles (n,) of the moving joints."""
        angles = self._body.posture.copy()
        angles[self._body.moving] = joints
        self._body.follow(angles[None])
        q = np.concatenate([pin.neutral(self._model)[:7], angles])
        pin.framesForwardKinematics(self._model, self._data, q)
        return tuple(self._data.oMf[frame].copy() for frame in self._frames)


class _Closing(_Feet):
    """Closes the legs of a robot both of whose feet stand, the base at the origin and at rest.

    Two bodies that are fixed to each other have one spatial velocity and one spatial acceleration.
    """

    def between(self, joints: Array, foot: int) -> pin.SE3:
        """Return the placement of the other sole in that of a foot, for moving joints (n,)."""
        soles = self.soles(joints)
        return soles[foot].inverse() * soles[1 - foot]

    def close(self, motion: Array, foot: int, target: pin.SE3, turn: Array) -> None:
        """Correct the leg of the other foot in place.

        Args:
            motion: angles, rates and accelerations of all joints, shape (3, M).
            foot: which stands, the other leg follows.
            target: placement of the other sole in its footprint.
            turn: of its sole from there, see `TrajectoryPhase.foot_motion`, shape (3, 6).

        Raises:
            InputError: the leg does not reach.
        """
        model, data = self._model, self._data
        own, other = self._frames[foot], self._frames[1 - foot]
        leg = np.array(self._body.leg(1 - foot))
        q, v, a = np.zeros(model.nq), np.zeros(model.nv), np.zeros(model.nv)
        q[:7] = _RESTING
        target = pin.exp6(turn[0]).inverse() * target
        for _ in range(_ITERATIONS):
            q[7:] = motion[0]
            J = pin.computeFrameJacobian(model, data, q, other, pin.WORLD)[:, 6:]
            pin.framesForwardKinematics(model, data, q)
            gap = pin.log6(data.oMf[own] * target * data.oMf[other].inverse()).vector
            move = np.linalg.solve(J[:, leg], gap)
            motion[0, leg] += move
            if np.abs(move).max() < _CLOSED:
                break
        else:
            raise InputError("the front foot of the gait does not stay where it landed")
        q[7:] = motion[0]
        J = pin.computeFrameJacobian(model, data, q, other, pin.WORLD)[:, 6:]
        for order, column in ((1, v), (2, a)):
            motion[order, leg] = 0.0
            column[6:] = motion[order]
            pin.forwardKinematics(model, data, q, v, a)
            read = pin.getFrameVelocity if order == 1 else pin.getFrameAcceleration
            apart = [read(model, data, frame, pin.WORLD).vector for frame in (own, other)]
            stays = apart[0] - self._turned(own, turn, order)
            motion[order, leg] = np.linalg.solve(J[:, leg], stays - apart[1])
            column[6:] = motion[order]

    def _turned(self, own: int, turn: Array, order: int) -> Array:
        """Twist, or its derivative, of a foot's sole against its footprint, in the world, (6,)."""
        if not turn.any():
            return np.zeros(6)
        sole = pin.updateFramePlacement(self._model, self._data, own)
        found = sole.act(pin.Motion(turn[order])).vector
        if order == 2:  # the frame in which the twist is constant moves
            moving = pin.getFrameVelocity(self._model, self._data, own, pin.WORLD)
            found = found + moving.cross(sole.act(pin.Motion(turn[1]))).vector
        return np.asarray(found)


class _Dynamics(_Feet):
    """Inverse dynamics of a robot that stands with one foot, flat or turning about a line.

    The twist of the base follows from the sole's; the wrench on the foot is the only
    one from outside, so that it must give what the free-flyer of the inverse dynamics asks for.
    """

    def __init__(self, body: Multibody) -> None:
        super().__init__(body)
        self._carried = body.carried
        self._forces = pin.StdVec_Force()
        self._forces.extend([pin.Force.Zero()] * self._model.njoints)

    def complete(
        self,
        q: Array,
        v: Array,
        a: Array,
        torque: Array,
        soles: Array,
        foot: int,
        place: pin.SE3,
        turn: Array,
        front: Array,
    ) -> Array:
        """Write what follows from the motion of the joints, and return the wrench on the foot.

        Args:
            q, v, a: of `Multibody.model`; joints are given, base pose, twist and acceleration
                written, shapes (7 + M,), (6 + M,), (6 + M,).
            torque: of all joints, written, shape (M,).
            soles: placements of the sole frames, written, shape (2, 4, 4).
            foot: which stands.
            place: of its footprint in the world.
            turn: of its sole from there, see `TrajectoryPhase.foot_motion`, shape (3, 6).
            front: wrench of the ground on the other foot in its sole frame, shape (6,).
        """
        model, data, frame = self._model, self._data, self._frames[foot]
        other = self._frames[1 - foot]
        q[:7], v[:6], a[:6] = _RESTING, 0.0, 0.0
        J = pin.computeFrameJacobian(model, data, q, frame, pin.WORLD)[:, 6:]
        J_other = pin.computeFrameJacobian(model, data, q, other, pin.WORLD)[:, 6:]
        pin.forwardKinematics(model, data, q, v, a)
        sole = pin.updateFramePlacement(model, data, frame).copy()
        twist = -pin.getFrameVelocity(model, data, frame, pin.WORLD).vector
        acceleration = -pin.getFrameAcceleration(model, data, frame, pin.WORLD).vector
        if turn.any():
            # in the sole frame: V = X V_base + v and A = X A_base - v x (X V_base) + a
            moved, rate = pin.Motion(turn[1]), pin.getFrameVelocity(model, data, frame, pin.LOCAL)
            twist += sole.act(moved).vector
            acceleration += sole.act(pin.Motion(turn[2]) + rate.cross(moved)).vector
            place = place * pin.exp6(turn[0])
        base = place * sole.inverse()
        soles[foot] = place.homogeneous
        at_other = pin.updateFramePlacement(model, data, other).copy()
        soles[1 - foot] = (base * at_other).homogeneous
        q[:7], v[:6], a[:6] = pin.SE3ToXYZQUAT(base), twist, acceleration
        if self._carried is None:
            effort = pin.rnea(model, data, q, v, a)
        else:
            self._carry(base)
            effort = pin.rnea(model, data, q, v, a, self._forces)
        if front.any():
            push = at_other.act(pin.Force(front)).vector
            effort = effort - np.concatenate([push, J_other.T @ push])
        on_base = effort[:6]
        torque[:] = effort[6:] - on_base @ J
        return np.asarray(sole.actInv(pin.Force(on_base)).vector)

    def _carry(self, base: pin.SE3) -> None:
        """Set the forces that carry weight from outside."""
        assert self._carried is not None
        for joint, mass, moment in zip(
            range(1, self._model.njoints), self._carried.mass, self._carried.moment, strict=True
        ):
            turned = base.rotation @ self._data.oMi[joint].rotation
            fall = turned.T @ self._body.gravity
            self._forces[joint] = pin.Force(-mass * fall, -np.cross(moment, fall))


def _heading(stances: list[tuple[pin.SE3, ...]]) -> pin.SE3:
    """Return the turn that makes the line midway between the directions of both feet the x axis."""
    if len(stances) < _FEET:
        return pin.SE3.Identity()
    turned = stances[1][0].rotation
    angle = float(np.arctan2(turned[1, 0], turned[0, 0])) / 2.0
    if abs(angle) < _STRAIGHT:
        return pin.SE3.Identity()
    return pin.SE3(pin.utils.rotate("z", -angle), np.zeros(3))
