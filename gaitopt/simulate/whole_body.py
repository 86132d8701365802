"""Whole-body control of a walk: every 2 ms a quadratic program over the joint accelerations.

The standing sole is held, tasks are tracked in the least-squares sense (swing sole, trunk, centre
of mass, posture), and the wrench on the sole stays in its exact cone: S. Caron, Q.-C. Pham,
Y. Nakamura, "Stability of surface contacts for humanoid robots", ICRA 2015. The centre of mass is
steered by its divergent component of motion xi = c + c' / w, w = sqrt(g / height), and the swing
foot lands where the error of xi is caught: J. Englsberger, C. Ott, A. Albu-Schäffer, IEEE
Transactions on Robotics 31(2), 2015.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import daqp
import mujoco
import numpy as np
import pinocchio as pin

from gaitopt.gait.trajectory import Trajectory
from gaitopt.mechanics.single_support import FRICTION_RATE
from gaitopt.nlp import Array
from gaitopt.simulate.controller import step_samples
from gaitopt.simulate.mujoco_model import SimulatedRobot

_UNLIMITED = 1e30  # daqp's infinity
_INTERVAL = 0.001  # s, between instants of the reference
_FORWARD, _LEFT = 0, 1


@dataclass(frozen=True)
class WholeBodyOptions:
    """Gains, weights and limits; one set walks bipeds of 16 to 93 kg.

    Attributes:
        interval: between two ticks [s].
        swing: gains of the swing sole [1/s², 1/s], position and rotation.
        trunk: gains of the trunk's rotation.
        height: gains of the height of the centre of mass.
        posture: gains of the joints.
        decay: rate at which the error of xi is to vanish [1/s].
        weights: of swing position, swing rotation, trunk, horizontal and vertical centre of mass,
            and joints.
        hold: damping of the standing sole [1/s]: less lets it rock after landing, with 30 the
            narrow feet of Unitree's G1 fall.
        friction: half-width of the friction pyramid.
        edge: strip of the sole that is not used [m].
        least_force: normal force on the standing sole [N].
        catch: share of the predicted error of xi at landing by which the step is moved.
        reach: most that a step is moved forward and sideways [m].
        filter: of the step's move [rad/s], critically damped.
        frozen: share of the step after which it is no longer moved.
        gap: between the soles, sideways [m].
        descent: speed at which a sole that is late goes on down [m/s].
        observe: gain on what the joints of the swing leg lag behind the rates that follow from
            the accelerations asked for [1/s]: it finds rotors that the model does not know.
        forget: rate at which that lag is forgotten [1/s].
        impact: time after a landing in which that lag is not taken for one [s].
        catch_up: share of the step in which a foot that was left elsewhere gets to where it
            should be; asked for at once, it takes the friction that the robot needs.
    """

    interval: float = 0.002
    swing: tuple[float, float] = (300.0, 34.6)
    trunk: tuple[float, float] = (200.0, 28.0)
    height: tuple[float, float] = (50.0, 14.0)
    posture: tuple[float, float] = (100.0, 20.0)
    decay: float = 3.0
    weights: tuple[float, float, float, float, float, float] = (100.0, 10.0, 30.0, 10.0, 30.0, 0.3)
    hold: float = 20.0
    friction: float = 0.53
    edge: float = 0.002
    least_force: float = 20.0
    catch: float = 0.85
    reach: tuple[float, float] = (0.25, 0.2)
    filter: float = 30.0
    frozen: float = 0.9
    gap: float = 0.01
    descent: float = 0.15
    observe: float = 50.0
    forget: float = 10.0
    impact: float = 0.03
    catch_up: float = 0.6


@dataclass(eq=False)
class _Target:
    """Where the tasks are to be at an instant, in the world's axes about the standing sole."""

    q: Array
    dq: Array
    ddq: Array
    sole: Array
    sole_rotation: Array
    sole_twist: Array
    sole_acceleration: Array
    trunk_rotation: Array
    trunk_rate: Array
    trunk_acceleration: Array
    com: Array
    com_velocity: Array
    com_acceleration: Array


class Reference:
    """Tasks of the designed walk at equidistant instants, for each standing foot."""

    def __init__(self, robot: SimulatedRobot, trajectory: Trajectory) -> None:
        """Evaluate the walk every millisecond."""
        count = round(trajectory.step_duration / _INTERVAL) + 1
        self.duration = trajectory.step_duration
        self.interval = self.duration / (count - 1)
        data = mujoco.MjData(robot.model)
        self.targets: list[list[_Target]] = []
        self.room: list[Array] = []
        for foot in (0, 1):
            samples = step_samples(trajectory, foot, count)
            self.targets.append(
                [
                    _target(robot, data, foot, q, v, a, force)
                    for q, v, a, force in zip(
                        samples.configuration,
                        samples.velocity,
                        samples.acceleration,
                        samples.force[:, foot],
                        strict=True,
                    )
                ]
            )
            x, y = samples.pressure[:, foot].T
            toe, heel, left, right = robot.body.sole_rectangle[foot]
            room = np.stack([toe - x, x - heel, left - y, y - right], axis=1)
            rest = np.arange(count, 0, -1)[:, None]
            self.room.append(np.cumsum(room[::-1], axis=0)[::-1] / rest)
        height = np.mean([target.com[2] for target in self.targets[0]])
        self.rate = float(np.sqrt(-trajectory.body.gravity[2] / height))

    def row(self, time: float) -> int:
        """Return the instant nearest to a time since touch-down [s]; the last one stays."""
        return min(max(round(time / self.interval), 0), len(self.targets[0]) - 1)

    def at(self, foot: int, time: float, descent: float) -> _Target:
        """Return the tasks at a time since touch-down; a sole that is late goes on down."""
        target = self.targets[foot][self.row(time)]
        late = time - self.duration
        if late <= 0.0:
            return target
        down = np.array([0.0, 0.0, min(target.sole_twist[2], -descent)])
        return _Target(
            **{
                **vars(target),
                "dq": np.zeros_like(target.dq),
                "ddq": np.zeros_like(target.ddq),
                "sole": target.sole + late * down,
                "sole_twist": np.concatenate([down, np.zeros(3)]),
                "sole_acceleration": np.zeros(6),
                "trunk_rate": np.zeros(3),
                "trunk_acceleration": np.zeros(3),
                "com": target.com + late * target.com_velocity,
                "com_acceleration": np.zeros(3),
            }
        )


def _target(
    robot: SimulatedRobot,
    data: mujoco.MjData,
    foot: int,
    q: Array,
    v: Array,
    a: Array,
    force: Array,
) -> _Target:
    """Return the tasks of a motion of `Multibody.model` and the ground's force in the world."""
    model = robot.model
    data.qpos[:], data.qvel[:] = robot.position(q), robot.velocity(q, v)
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_fwdVelocity(model, data)
    qacc = robot.acceleration(q, v, a)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    J, drift = sole_motion(robot, data, 1 - foot)
    standing, swinging = robot.site[foot], robot.site[1 - foot]
    trunk = data.xmat[robot.base].reshape(3, 3).copy()
    return _Target(
        q=data.qpos[robot.qpos],
        dq=data.qvel[robot.dof],
        ddq=qacc[robot.dof],
        sole=data.site_xpos[swinging] - data.site_xpos[standing],
        sole_rotation=data.site_xmat[swinging].reshape(3, 3).copy(),
        sole_twist=J @ data.qvel,
        sole_acceleration=J @ qacc + drift,
        trunk_rotation=trunk,
        trunk_rate=trunk @ data.qvel[3:6],
        trunk_acceleration=trunk @ qacc[3:6],
        com=data.subtree_com[robot.base] - data.site_xpos[standing],
        com_velocity=mass[:3] @ data.qvel / robot.mass,
        com_acceleration=force / robot.mass + robot.body.gravity,
    )


def sole_motion(robot: SimulatedRobot, data: mujoco.MjData, foot: int) -> tuple[Array, Array]:
    """Return the Jacobian of a sole frame, linear rows first, and its acceleration at rest."""
    model, site = robot.model, robot.site[foot]
    J, rate = np.zeros((6, model.nv)), np.zeros((6, model.nv))
    mujoco.mj_jacSite(model, data, J[:3], J[3:], site)
    body = model.site_bodyid[site]
    mujoco.mj_jacDot(model, data, rate[:3], rate[3:], data.site_xpos[site], body)
    return J, rate @ data.qvel


def wrench_cone(friction: float, half_length: float, half_width: float) -> Array:
    """Return the rows >= 0 of the wrenches that a flat rectangle can bear, shape (17, 6).

    The wrench is about the rectangle's centre, in its axes, force first (Caron et al. 2015).

    Args:
        friction: half-width of the friction pyramid.
        half_length, half_width: of the rectangle along x and y [m].
    """
    mu, X, Y = friction, half_length, half_width
    rows = [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]
    for sign in (-1.0, 1.0):
        rows += [
            [sign, 0.0, mu, 0.0, 0.0, 0.0],
            [0.0, sign, mu, 0.0, 0.0, 0.0],
            [0.0, 0.0, Y, sign, 0.0, 0.0],
            [0.0, 0.0, X, 0.0, sign, 0.0],
        ]
        for a in (-1.0, 1.0):
            for b in (-1.0, 1.0):
                rows.append([-a * Y, -b * X, mu * (X + Y), sign * a * mu, sign * b * mu, sign])
    return np.array(rows)


def fading(time: float, duration: float) -> tuple[float, float, float]:
    """Return what goes smoothly from 1 to 0, with its first two derivatives in time.

    Args:
        time: since its begin [s].
        duration: after which it is 0 [s].
    """
    s = min(time / duration, 1.0)
    value = 1.0 - s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    rate = -30.0 * s**2 * (1.0 - s) ** 2 / duration
    return value, rate, -60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / duration**2


class WholeBodyController:
    """Walks a gait by a quadratic program over the joint accelerations, with step adjustment."""

    def __init__(
        self,
        robot: SimulatedRobot,
        trajectory: Trajectory,
        torque_limit: Array | None = None,
        options: WholeBodyOptions | None = None,
        reference: Reference | None = None,
    ) -> None:
        """Take the tasks from the designed walk.

        Args:
            robot: the model that the controller believes in.
            trajectory: the walk.
            torque_limit: of the motors [N·m], shape (n,); NaN or None: unlimited.
            options: gains, weights and limits.
            reference: of the walk, where it is made already.
        """
        self._robot, self._options = robot, options or WholeBodyOptions()
        self.interval = self._options.interval
        self._reference = Reference(robot, trajectory) if reference is None else reference
        self._data, nv = mujoco.MjData(robot.model), robot.model.nv
        self._mass, self._task = np.zeros((nv, nv)), np.zeros((12, nv))
        limit = np.full(len(robot.dof), np.nan) if torque_limit is None else torque_limit
        self._limit = np.where(np.isnan(limit), _UNLIMITED, limit)
        w = self._options.weights
        self._weights = np.repeat([w[0], w[1], w[2], w[3], w[4]], [3, 3, 3, 2, 1])
        self._cones = []
        for toe, heel, left, right in robot.body.sole_rectangle:
            edge = self._options.edge
            sizes = (toe - heel) / 2.0 - edge, (left - right) / 2.0 - edge
            self._cones.append(wrench_cone(self._options.friction, *sizes))
        moving = robot.body.moving
        self._swinging = [
            np.isin(moving, robot.body.leg(1 - foot)).astype(float) for foot in (0, 1)
        ]
        self._trajectory, self._step, self._level = trajectory, -1, 0.0
        self.unsolved = 0
        """Ticks whose program had no solution: torques were then cut at their limits alone."""
        self.touch_down(0, 0.0)

    def touch_down(self, foot: int, time: float) -> None:
        """Begin the next step where it should be."""
        self._foot, self._landed = foot, time
        self._believed: Array | None = None
        self._left: Array | None = None
        self._step += 1
        self._level = float(self._trajectory.advance(self._step).translation[2])
        self._move, self._move_rate, self._goal = np.zeros(2), np.zeros(2), np.zeros(2)

    def torque(self, time: float, qpos: Array, qvel: Array) -> Array:
        """Return the torques of the motors [N·m]; see the module."""
        robot, options, data = self._robot, self._options, self._data
        model, foot, since = robot.model, self._foot, time - self._landed
        data.qpos[:], data.qvel[:] = qpos, qvel
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_fullM(model, data, self._mass)
        target = self._reference.at(foot, since, options.descent)
        bias = data.qfrc_bias - data.qfrc_passive
        turning = robot.body.coupling(target.q) @ target.dq
        bias[robot.driven] += robot.body.friction[robot.body.driven] * np.tanh(
            turning / FRICTION_RATE
        )
        # all accelerations are N x + n with those of the joints x: the standing sole is held
        J, drift = sole_motion(robot, data, foot)
        inverse = np.linalg.inv(J[:, :6])
        count = len(robot.dof)
        N = robot.free(data.qpos)[:, 6:].copy()
        N[:6] = -inverse @ J @ N
        n = robot.drift(data.qpos, data.qvel)
        n[:6] = inverse @ (-options.hold * (J @ data.qvel) - drift - J @ n)
        MN, rest = self._mass @ N, self._mass @ n + bias
        wrench, wrench_0 = inverse.T @ MN[:6], inverse.T @ rest[:6]
        torque, torque_0 = N.T @ MN, N.T @ rest
        task, wanted = self._tasks(since, target, bias)
        A = task @ N
        weighted = A.T * self._weights
        kp, kd = options.posture
        own = target.ddq + kp * (target.q - data.qpos[robot.qpos])
        own += kd * (target.dq - data.qvel[robot.dof])
        slight = options.weights[5]
        H = weighted @ A + slight * np.eye(count)
        # the tasks ask the swing leg for what it lags behind, too; the same in the stance leg
        # winds up while the sole rocks, and falls
        dq = data.qvel[robot.dof]
        landing = self._believed is None or since < options.impact
        believed = dq if landing else self._believed
        lag = options.observe * (believed - dq) * self._swinging[foot]
        f = -weighted @ (wanted - task @ n + A @ lag) - slight * (own + lag)
        cone = self._cones[foot] @ self._about_centre(foot)
        least = -cone @ wrench_0
        least[0] += options.least_force
        C = np.vstack([cone @ wrench, torque])
        upper = np.concatenate([np.full(len(least), _UNLIMITED), self._limit - torque_0])
        lower = np.concatenate([least, -self._limit - torque_0])
        x, _, flag, _ = daqp.solve(H, f, C, upper, lower, np.zeros(len(lower), dtype=np.int32))
        if flag < 1:
            self.unsolved += 1
            x = np.linalg.solve(H, -f)
        self._believed = believed + options.interval * (x - lag - options.forget * (believed - dq))
        return np.asarray(np.clip(torque @ x + torque_0, -self._limit, self._limit))

    def _tasks(self, since: float, target: _Target, bias: Array) -> tuple[Array, Array]:
        """Return the Jacobians of the tasks (12, 6 + n) and what they are to give (12,)."""
        robot, options, data, foot = self._robot, self._options, self._data, self._foot
        standing = data.site_xpos[robot.site[foot]]
        swinging = robot.site[1 - foot]
        com = data.subtree_com[robot.base] - standing
        com_velocity = self._mass[:3] @ data.qvel / robot.mass
        w, k = self._reference.rate, options.decay
        late = target.com - com, target.com_velocity - com_velocity
        push = self._adjust(since, -(late[0] + late[1] / w)[:2])
        J, drift = sole_motion(robot, data, 1 - foot)
        twist = J @ data.qvel
        place = standing + target.sole
        place[2] = self._level + target.sole[2]
        place[:2] += self._move
        self._keep_apart(place, standing)
        rate = target.sole_twist.copy()
        rate[:2] += self._move_rate
        if self._left is None:
            self._left = (data.site_xpos[swinging] - place)[:2]
        faded, faded_rate, faded_push = fading(since, options.catch_up * self._reference.duration)
        place[:2] += faded * self._left
        rate[:2] += faded_rate * self._left
        push = push + faded_push * self._left
        turn = _rotation_to(target.sole_rotation, data.site_xmat[swinging].reshape(3, 3))
        kp, kd = options.swing
        error = np.concatenate([place - data.site_xpos[swinging], turn])
        wanted = np.empty(12)
        wanted[:6] = target.sole_acceleration + kp * error + kd * (rate - twist) - drift
        wanted[:2] += push
        trunk = data.xmat[robot.base].reshape(3, 3)
        kp, kd = options.trunk
        wanted[6:9] = (
            target.trunk_acceleration
            + kp * _rotation_to(target.trunk_rotation, trunk)
            + kd * (target.trunk_rate - trunk @ data.qvel[3:6])
        )
        kp, kd = options.height
        stiffness, damping = np.array([k * w, k * w, kp]), np.array([w + k, w + k, kd])
        height = late[0].copy()
        # above the ground as designed, not above a sole that sinks in
        height[2] += self._level - standing[2]
        wanted[9:] = target.com_acceleration + stiffness * height + damping * late[1]
        wanted[9:] -= bias[:3] / robot.mass + robot.body.gravity
        task = self._task
        task[:6], task[6:9, 3:6], task[9:] = J, trunk, self._mass[:3] / robot.mass
        return task, wanted

    def _adjust(self, since: float, error: Array) -> Array:
        """Move the step to where the error of xi is caught; return the acceleration of the move."""
        options, reference = self._options, self._reference
        w, k = reference.rate, options.decay
        rest = max(reference.duration - since, 0.0)
        if since < options.frozen * reference.duration:
            room = np.maximum(reference.room[self._foot][reference.row(since)], 0.0)
            for axis in (_FORWARD, _LEFT):
                sign, size = (1.0 if error[axis] > 0.0 else -1.0), abs(error[axis])
                free = room[2 * axis] if sign > 0.0 else room[2 * axis + 1]
                grown = free + (size - free) * np.exp(w * rest)
                predicted = sign * max(grown, size * np.exp(-k * rest))
                reach = options.reach[axis]
                self._goal[axis] = min(max(options.catch * predicted, -reach), reach)
        rate = options.filter
        push = rate**2 * (self._goal - self._move) - 2.0 * rate * self._move_rate
        self._move_rate = self._move_rate + push * options.interval
        self._move = self._move + self._move_rate * options.interval
        return np.asarray(push)

    def _keep_apart(self, place: Array, standing: Array) -> None:
        """Move the place of the swing sole so that it does not step on the other."""
        rectangle = self._robot.body.sole_rectangle[self._foot]
        least = rectangle[2] - rectangle[3] + self._options.gap
        side = np.sign(self._reference.targets[self._foot][0].sole[1])
        if side * (place[1] - standing[1]) < least:
            place[1] = standing[1] + side * least

    def _about_centre(self, foot: int) -> Array:
        """Return what takes a wrench at the sole frame, world's axes, to the sole's centre, (6, 6).

        The axes are those of the sole turned upright.
        """
        R = self._data.site_xmat[self._robot.site[foot]].reshape(3, 3)
        length = np.hypot(R[0, 0], R[1, 0])
        c, s = R[0, 0] / length, R[1, 0] / length
        turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        toe, heel, left, right = self._robot.body.sole_rectangle[foot]
        centre = np.array([(toe + heel) / 2.0, (left + right) / 2.0, 0.0])
        moved = np.zeros((6, 6))
        moved[:3, :3] = moved[3:, 3:] = turn
        moved[3:, :3] = -pin.skew(centre) @ turn
        return moved


def whole_body_walks() -> Callable[[SimulatedRobot, Trajectory, Array | None], WholeBodyController]:
    """Return a maker of whole-body controllers; those of the same walk share its reference."""
    known: list[tuple[Trajectory, Reference]] = []

    def make(
        robot: SimulatedRobot, trajectory: Trajectory, torque_limit: Array | None
    ) -> WholeBodyController:
        if not known or known[0][0] is not trajectory:
            known[:] = [(trajectory, Reference(robot, trajectory))]
        return WholeBodyController(robot, trajectory, torque_limit, reference=known[0][1])

    return make


def _rotation_to(wanted: Array, found: Array) -> Array:
    """Return the rotation vector in the world that takes one attitude to another [rad]."""
    return np.asarray(pin.log3(wanted @ found.T))
