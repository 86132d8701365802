"""A gait walked in MuJoCo under a controller, and what is measured of it."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import Enum
from functools import cache

import mujoco
import numpy as np
import pinocchio as pin
from scipy.integrate import trapezoid

from gaitopt.bounds import RATE, is_finite, shown
from gaitopt.dataclass import dataclass
from gaitopt.errors import GaitoptError, InputError, failure, own_line
from gaitopt.gait.constraints import SLIPPERIEST, STICKIEST
from gaitopt.gait.result import Gait, ground_of
from gaitopt.gait.trajectory import Trajectory
from gaitopt.nlp import Array
from gaitopt.settings import checked, checked_arguments
from gaitopt.simulate.disturbance import (
    NONE,
    Delay,
    Disturbance,
    disturbed_robot,
    disturbed_start,
    measured,
    pelvis,
)
from gaitopt.simulate.mujoco_model import FRICTION, SimulatedRobot, simulated_robot
from gaitopt.simulate.reference import Controller, both_feet
from gaitopt.simulate.whole_body import WholeBodyController

STEPS = 20
MOST_STEPS = 10000
_TOUCH_DOWN = 0.05  # of the weight: normal force on the swing sole at which it has landed
_EARLIEST = 0.6  # share of a step's designed duration before which it cannot
_LOW = 0.7  # of the mean height of the centre of mass: below, the robot has fallen
_TILTED = 0.5  # cosine of the trunk's tilt: 60 degrees
_LATE = 2.0  # of a step's duration: the swing foot should have landed
_SUNK = 2e-4  # m, by which the first sole begins in the ground, where it bears about the weight
_NOWHERE = 1e-9  # m/s: rounding of walks in place
_SETTLED = 2  # first steps that are left out of means
_LAST = 5  # steps whose speed is told after a disturbance
_LIFTED = 0.002  # m, by which a sole is above the ground before that is moved
_EXCHANGED = 0.3  # of the step, before which the ground under the foot that left stays
_INSTANTS = 601  # of the step for its squared torque
_QUADRATURE = 0.05  # relative: more than Simpson's rule over a walk's samples is off


MakeController = Callable[[SimulatedRobot, Trajectory, "Array | None"], Controller]
"""Makes the controller of a walk: of the model, the walk and the limits of the torques."""


class Ending(Enum):
    """How a simulated walk ended."""

    WALKED = "walked all steps"
    FELL = "sank to the ground"
    TIPPED = "tipped over"
    NO_LANDING = "the swing foot did not land"


@checked
@dataclass(frozen=True)
class WalkOptions:
    """Of a simulated walk.

    Attributes:
        steps: how many to walk.
        friction: sliding coefficient of soles on the ground.
        frames: postures that are recorded [Hz]; 0 for none.

    Raises:
        InputError: a number is out of range.
    """

    steps: int = STEPS
    friction: float = FRICTION
    frames: float = 0.0

    def __post_init__(self) -> None:
        if not 1 <= self.steps <= MOST_STEPS:
            raise InputError(
                f"{shown(self.steps)} steps cannot be simulated; ask for 1 to {MOST_STEPS} of them"
            )
        if not (is_finite(self.friction) and SLIPPERIEST <= self.friction <= STICKIEST):
            raise InputError(
                f"the friction of the simulated ground is {shown(self.friction)}; it must be "
                f"between {SLIPPERIEST:g} and {STICKIEST:g}: ice has some 0.02"
            )
        if not (is_finite(self.frames) and 0.0 <= self.frames <= RATE):
            raise InputError(
                f"{shown(self.frames)} Hz of postures cannot be recorded; give 0 to {RATE} Hz"
            )


@dataclass(frozen=True, eq=False)
class SimulatedWalk:
    """What was measured of a simulated walk.

    Means leave out the first two steps; NaN where there were no more.

    Attributes:
        ending: how it ended.
        asked: number of steps.
        lengths: of the steps along the way that the design goes [m], shape (steps,); below zero
            where it goes backward.
        times: between touch-downs [s], shape (steps,).
        turns: of the way from one step to the next, to the left [rad], shape (steps,).
        drift: of the last standing foot from its designed place, across the way [m], to the left.
        designed_speed: along that way [m/s]; below zero backward.
        designed_turn_rate: to the left [rad/s].
        efforts: integral of the squared torques over each step [N²·m²·s], shape (steps,).
        designed_cost: squared torque per metre of the gait [N²·m·s]; in place, per second [N²·m²].
        torque: largest of each joint [N·m], shape (n,).
        rate: largest of each joint [rad/s], shape (n,).
        force: largest of the ground on one foot [N].
        simulated: time that passed in the simulation [s].
        seconds: time that the computation took [s].
        motion: time and `qpos` of the recorded postures, shape (N, 1 + 7 + n).
    """

    ending: Ending
    asked: int
    lengths: Array
    times: Array
    turns: Array
    drift: float
    designed_speed: float
    designed_turn_rate: float
    efforts: Array
    designed_cost: float
    torque: Array
    rate: Array
    force: float
    simulated: float
    seconds: float
    motion: Array

    @property
    def walked(self) -> bool:
        """Whether all steps were walked."""
        return self.ending is Ending.WALKED

    @property
    def last_speed(self) -> float:
        """Mean speed of the last five steps [m/s]."""
        return _ratio(self.lengths[-_LAST:].sum(), self.times[-_LAST:].sum())

    @property
    def steps(self) -> int:
        """Number of steps that ended with a touch-down."""
        return len(self.times)

    @property
    def settled(self) -> tuple[Array, Array]:
        """Lengths [m] and times [s] of the steps after the first two, shape (K,) each."""
        return self.lengths[_SETTLED:], self.times[_SETTLED:]

    @property
    def speed(self) -> float:
        """Mean speed along the way [m/s]."""
        lengths, times = self.settled
        return _ratio(lengths.sum(), times.sum())

    @property
    def turn_rate(self) -> float:
        """Mean rate of turning to the left [rad/s]."""
        return _ratio(self.turns[_SETTLED:].sum(), self.times[_SETTLED:].sum())

    @property
    def in_place(self) -> bool:
        """Whether the design gets nowhere, so that its cost is told per second."""
        return abs(self.designed_speed) < _NOWHERE

    @property
    def cost(self) -> float:
        """Squared torque per metre under feedback [N²·m·s]; in place, per second [N²·m²]."""
        lengths, times = self.settled
        over = times.sum() if self.in_place else abs(lengths.sum())
        return _ratio(self.efforts[_SETTLED:].sum(), over)


@checked_arguments
def simulate(
    gait: Gait,
    options: WalkOptions | None = None,
    controller: MakeController | None = None,
    disturbance: Disturbance = NONE,
) -> SimulatedWalk:
    """Walk a gait in MuJoCo, from its start.

    Args:
        options: how long, and on what ground.
        controller: makes the controller of the model, the walk and the torque limits; the
            whole-body controller by default.
        disturbance: what the controller is not told; none by default.

    Raises:
        InputError: the gait cannot be simulated, or an option is out of range.
        RobotError: the gait has no robot of its own, and its URDF is not its robot.
    """
    options = WalkOptions() if options is None else options
    if (ground := ground_of(gait)).shaped and not ground.rise:
        raise InputError(
            f"this gait walks {ground.words}; what stands on the ground cannot be simulated "
            "yet: optimise it on level ground"
        )
    trajectory, limit = gait.trajectory, gait.joint_limit("torque")
    robot = simulated_robot(trajectory.body, limit, options.friction)
    make = WholeBodyController if controller is None else controller
    with _without_log(), _told(make):
        made = make(robot, trajectory, limit)
        _check_controller(made, trajectory.step_duration)
        return _Run(robot, gait, made, options, disturbance).walk()


def _check_controller(made: object, longest: float) -> None:
    """Refuse what is no `Controller`."""
    if missing := [n for n in ("interval", "torque", "touch_down") if not hasattr(made, n)]:
        raise InputError(
            f"the controller is {shown(made)}, which has no {' and no '.join(missing)}; see "
            "gaitopt.simulate.Controller"
        )
    interval = made.interval  # type: ignore[attr-defined]
    if not (is_finite(interval) and 0.0 < interval <= longest):
        raise InputError(
            f"the interval of the controller is {shown(interval)} s; give the time between two of "
            f"its ticks, above 0 and not above the {longest:g} s of a step"
        )


@contextmanager
def _told(make: MakeController) -> Iterator[None]:
    """Tell what the code of a controller of one's own raises in our words, with its line."""
    module = str(getattr(make, "__module__", ""))
    try:
        yield
    except GaitoptError:
        raise
    except (Exception, SystemExit) as error:
        if not own_line(error, module):
            raise
        name = getattr(make, "__name__", "of your own")
        raise InputError(f"the controller {name}: {failure(error, module)}") from error


def designed_speed(gait: Gait) -> float:
    """Return the speed of a gait along the way that it goes [m/s], below zero backward."""
    if gait.lateral_speed == 0.0:
        return gait.speed
    return float(np.hypot(gait.speed, gait.lateral_speed))


def way_of(gait: Gait, step: int) -> tuple[Array, Array]:
    """Return the unit vectors (3,) along the way of a step and to its left, in the world.

    They are those midway between the feet at the begin of the step.
    """
    first, second = (gait.trajectory.advance(step + k).rotation for k in (-1, 0))
    x, y, _ = first[:, 0] + second[:, 0]
    aside = 0.0 if gait.lateral_speed == 0.0 else np.arctan2(gait.lateral_speed, gait.speed)
    angle = float(np.arctan2(y, x) + aside)
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c, s, 0.0]), np.array([-s, c, 0.0])


def designed_cost(gait: Gait) -> float:
    """Return the squared torque per metre of a gait [N²·m·s]; in place, per second [N²·m²].

    Where that is what the gait was designed for, it is the number that its file tells, from the
    quadrature over its samples; unless the motion of the file has another.
    """
    found = squared_torque(gait)
    told = gait.cost if gait.fact("task", "cost") is None else None
    return told if told is not None and math.isclose(told, found, rel_tol=_QUADRATURE) else found


def squared_torque(gait: Gait) -> float:
    """Return the same as `designed_cost`, integrated over the motion whatever the file tells."""
    trajectory, efforts = gait.trajectory, []
    times = np.linspace(0.0, trajectory.step_duration, _INSTANTS)
    for begin in np.arange(len(gait.steps)) * trajectory.step_duration:
        samples = trajectory.at(begin + times, before=times > 0.0)
        torque = samples.torque[:, trajectory.body.moving]
        efforts.append(float(trapezoid((torque**2).sum(axis=1), times)))
    pace = abs(designed_speed(gait))
    return float(np.mean(efforts)) / trajectory.step_duration / (1.0 if pace < _NOWHERE else pace)


@contextmanager
def _without_log() -> Iterator[None]:
    """Keep MuJoCo from writing MUJOCO_LOG.TXT where a robot that has fallen is shaken to pieces."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


class _Run:
    """One simulation."""

    def __init__(
        self,
        robot: SimulatedRobot,
        gait: Gait,
        controller: Controller,
        options: WalkOptions,
        disturbance: Disturbance,
    ) -> None:
        trajectory = gait.trajectory
        self._robot, self._trajectory = disturbed_robot(robot, disturbance), trajectory
        self._gait, self._advance = gait, cache(trajectory.advance)
        self._controller, self._options = controller, options
        self._disturbance = disturbance
        self._rng = np.random.default_rng(disturbance.seed)
        self._data = mujoco.MjData(self._robot.model)
        if disturbance.start is None:
            start = trajectory.at(0.0)
            q, v = start.configuration[0], start.velocity[0]
            robot.place(self._data, q, v)
        else:
            self._data.qpos[:], self._data.qvel[:] = disturbed_start(
                robot, trajectory, disturbance.start, self._rng
            )
        self._data.qpos[2] -= _SUNK
        behind = float(trajectory.advance(-1).translation[2])  # the foot has just left
        self._data.mocap_pos[robot.ground[1], 2] = behind
        mujoco.mj_forward(self._robot.model, self._data)
        self._height = float(self._data.subtree_com[robot.base][2])
        self._torque = self._rate = np.zeros(len(robot.dof))
        self._force = 0.0

    def walk(self) -> SimulatedWalk:
        """Walk until the steps are done or the robot is down."""
        robot, data, options = self._robot, self._data, self._options
        begun, duration = clock.perf_counter(), self._trajectory.step_duration
        foot, time, effort = 0, 0.0, 0.0
        landed = -both_feet(self._trajectory)
        places = [robot.sole(data, 0)]
        times: list[float] = []
        efforts: list[float] = []
        frames: list[Array] = []
        ending, timestep = Ending.WALKED, robot.model.opt.timestep
        ticks = max(1, round(self._controller.interval / timestep))
        way = Delay(self._disturbance.delay)
        while len(times) < options.steps:
            if options.frames and time * options.frames >= len(frames):
                frames.append(np.concatenate([[time], data.qpos]))
            since = time - landed
            self._push(len(times), since)
            if since > _EXCHANGED * duration:
                late = since > _EARLIEST * duration
                self._prepare_ground(1 - foot, len(times) + 1, late)
            seen = measured(robot, data, self._disturbance.noise, self._rng)
            way.send(time, self._checked(self._controller.torque(time, *seen), time))
            for tick in range(ticks):
                data.ctrl[robot.motors] = way.arrived(time + tick * timestep)
                mujoco.mj_step(robot.model, data)
            time += ticks * timestep
            torque = np.abs(data.actuator_force[robot.motors])
            effort += float(torque @ torque) * ticks * timestep
            self._torque = np.maximum(self._torque, torque)
            self._rate = np.maximum(self._rate, np.abs(data.qvel[robot.dof]))
            forces = self._forces()
            self._force = max(self._force, *forces)
            since = time - landed
            if since > _EARLIEST * duration:
                if forces[1 - foot] > _TOUCH_DOWN * robot.weight:
                    foot, landed = 1 - foot, time
                    self._controller.touch_down(foot, time)
                    places.append(robot.sole(data, foot))
                    times.append(since)
                    efforts.append(effort)
                    effort = 0.0
                elif since > _LATE * duration:
                    ending = Ending.NO_LANDING
                    break
            if (down := self._down(len(times))) is not None:
                ending = down
                break
        lengths, turns, drift = self._progress(places)
        return SimulatedWalk(
            ending=ending,
            asked=options.steps,
            lengths=lengths,
            times=np.array(times),
            turns=turns,
            drift=drift,
            designed_speed=designed_speed(self._gait),
            designed_turn_rate=self._gait.turn_rate,
            efforts=np.array(efforts),
            designed_cost=designed_cost(self._gait),
            torque=self._torque,
            rate=self._rate,
            force=self._force,
            simulated=time,
            seconds=clock.perf_counter() - begun,
            motion=np.array(frames).reshape(-1, 1 + robot.model.nq),
        )

    def _progress(self, places: list[pin.SE3]) -> tuple[Array, Array, float]:
        """Return lengths of the steps along the way, their turns (steps,), the last foot's drift.

        Args:
            places: of the standing soles, one more than steps.
        """
        advance = [self._advance(step) for step in range(len(places))]
        pairs = list(zip(advance, places, strict=True))
        off = np.array([place.translation - designed.translation for designed, place in pairs])
        off -= off[0]
        duration = self._trajectory.step_duration
        length = designed_speed(self._gait) * duration
        apart = (designed.actInv(place).rotation for designed, place in pairs)
        missed = [math.atan2(R[1, 0], R[0, 0]) for R in apart]
        turns = self._gait.turn_rate * duration + np.diff(np.unwrap(missed))
        ways = [way_of(self._gait, step)[0] for step in range(1, len(places))]
        lengths = length + np.array(
            [a @ b for a, b in zip(np.diff(off, axis=0), ways, strict=True)]
        )
        return lengths, turns, float(off[-1] @ way_of(self._gait, len(places) - 1)[1])

    def _prepare_ground(self, foot: int, step: int, late: bool) -> None:
        """Put the ground on which a foot will land where it is, once the foot is above it."""
        # A foot that is still not above it when it is late stumbles over it.
        place = self._data.mocap_pos[self._robot.ground[foot]]
        height = float(self._advance(step).translation[2]) + self._disturbance.ground * (step % 2)
        if place[2] == height:
            return
        sole = self._data.geom_xpos[self._robot.geom[foot]]
        turned = self._data.geom_xmat[self._robot.geom[foot]].reshape(3, 3)
        lowest = sole[2] - np.abs(turned[2]) @ self._robot.model.geom_size[self._robot.geom[foot]]
        if late or lowest > max(height, place[2]) + _LIFTED:
            place[2] = height

    def _checked(self, asked: object, time: float) -> Array:
        """Return a controller's torques [N·m], copied: it may write into its array again.

        Raises:
            InputError: they are not a finite number for each motor: MuJoCo would let all motors go.
        """
        many = len(self._robot.motors)
        try:
            torque = np.array(asked)
        except ValueError:  # rows of different lengths
            torque = np.zeros(0)
        if torque.shape != (many,) or torque.dtype.kind not in "iuf":
            raise InputError(
                f"the controller asks for the torques {shown(asked)}; return one number for each "
                f"of the {many} motors"
            )
        if not (fine := np.isfinite(torque)).all():
            body, (first, *others) = self._robot.body, np.flatnonzero(~fine)
            unit = "N·m" if body.revolute[body.moving[first]] else "N"
            more = f" and {len(others)} more" if others else ""
            raise InputError(
                f"the controller asks for {torque[first]} {unit} of {body.moving_names[first]}"
                f"{more} at {time:.4g} s of the walk; return finite numbers"
            )
        return torque

    def _push(self, step: int, since: float) -> None:
        """Set the force of the push that is due, at the pelvis."""
        push = self._disturbance.push
        if push is None:
            return
        begins = push.phase * self._trajectory.step_duration
        applied = self._data.xfrc_applied[self._robot.base]
        applied[:] = 0.0
        # the push lasts an interval of the controller at least
        lasts = max(push.duration, self._controller.interval)
        if step == push.step and begins <= since < begins + lasts - 1e-9:
            force = np.array(push.impulse) / lasts
            arm = pelvis(self._robot, self._data) - self._data.xipos[self._robot.base]
            applied[:3], applied[3:] = force, np.cross(arm, force)

    def _forces(self) -> tuple[float, float]:
        """Return the normal forces of the ground on both soles [N]."""
        data, total, one = self._data, [0.0, 0.0], np.zeros(6)
        for index, touching in enumerate(data.contact.geom.tolist()):
            mujoco.mj_contactForce(self._robot.model, data, index, one)
            for foot, geom in enumerate(self._robot.geom):
                total[foot] += float(one[0]) * (geom in touching)
        return total[0], total[1]

    def _down(self, step: int) -> Ending | None:
        """Return how the robot is down, None if it is up."""
        data, base = self._data, self._robot.base
        height = data.subtree_com[base][2] - self._advance(step).translation[2]
        if not np.isfinite(data.qpos).all() or height < _LOW * self._height:
            return Ending.FELL
        up = data.xmat[base].reshape(3, 3)[2] @ self._robot.body.heading[:, 2]
        return Ending.TIPPED if up < _TILTED else None


def _ratio(a: float, b: float) -> float:
    return float(a) / float(b) if b > 0.0 else float("nan")
