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

import daqp
import mujoco
import numpy as np
import pinocchio as pin

from gaitopt.design.walkability import PYRAMID, STRIP
from gaitopt.gait.trajectory import Trajectory
from gaitopt.mechanics.single_support import FRICTION_RATE
from gaitopt.nlp import Array
from gaitopt.simulate.mujoco_model import SimulatedRobot
from gaitopt.simulate.reference import Reference, Target, Turn, sole_motion

_UNLIMITED = 1e30  # daqp's infinity
_LINE = 0.001  # m, half of what a line about which a foot turns is wide
_FLAT = 0.003  # rad, below which a foot that rolls is flat
_ARM = 0.1  # m: a moment counts as a force at this arm
_FORWARD, _LEFT = 0, 1
# One set of gains, weights and limits walks bipeds of 16 to 93 kg. Gains are of place and rate.
_INTERVAL = 0.002  # s, between two ticks
_SWING = 300.0, 34.6  # 1/s², 1/s: gains of the swing sole, position and rotation
_TRUNK = 200.0, 28.0  # of the trunk's rotation
_HEIGHT = 50.0, 14.0  # of the height of the centre of mass
_POSTURE = 100.0, 20.0  # of the joints
_TURN = 600.0, 49.0  # of the angle of a standing foot that turns about its toe or heel
_TASKS = np.repeat([100.0, 10.0, 10.0, 20.0, 30.0], [3, 3, 3, 2, 1])
"""Weights of swing position, swing rotation, trunk, horizontal and vertical centre of mass."""
_JOINTS_WEIGHT, _TURN_WEIGHT = 0.3, 10.0  # of the joints, and of the angle of a foot that turns
_STAND_WEIGHT = 1000.0  # of the standstill of the foot behind while both stand
_DECAY = 3.0  # 1/s: rate at which the error of xi is to vanish
_HOLD = 20.0  # 1/s, damping of the standing sole: less lets it rock after landing, with 30 the
# narrow feet of Unitree's G1 fall
_LEAST_FORCE = 20.0  # N, normal force on the standing sole
_CATCH = 0.85  # share of the predicted error of xi at landing by which the step is moved
_REACH = 0.25, 0.2  # m, most that a step is moved forward and sideways
_FILTER = 30.0  # rad/s, of the step's move, critically damped
_FROZEN = 0.9  # share of the step after which it is no longer moved
_GAP = 0.01  # m, between the soles, sideways
_PASSING = 0.1  # m ahead of the other foot, beyond its length and the gap, from which a foot may
# come onto the other's line
_DESCENT = 0.15  # m/s, speed at which a sole that is late goes on down
_OBSERVE = 50.0  # 1/s, gain on what the joints of the swing leg lag behind the rates that follow
# from the accelerations asked for: it finds rotors that the model does not know
_FORGET = 10.0  # 1/s, rate at which that lag is forgotten
_IMPACT = 0.03  # s after a landing in which that lag is not taken for one
_CATCH_UP = 0.6  # share of the step in which a foot that was left elsewhere gets to where it should
# be; asked for at once, it takes the friction that the robot needs


def wrench_cone(friction: float, half_length: float, half_width: float) -> Array:
    """Return the rows >= 0 of the wrenches that a flat rectangle can bear, shape (17, 6).

    The wrench is about the rectangle's centre, in its axes, force first (Caron et al. 2015).

    Args:
        friction: coefficient, half-width of the friction pyramid.
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
        reference: Reference | None = None,
    ) -> None:
        """Take the tasks from the designed walk.

        Args:
            robot: the model that the controller believes in.
            torque_limit: of the motors [N·m], shape (n,); NaN or None: unlimited.
            reference: of the walk, where it is made already.
        """
        self._robot = robot
        self.interval = _INTERVAL
        self._reference = Reference(robot, trajectory) if reference is None else reference
        self._data, nv = mujoco.MjData(robot.model), robot.model.nv
        self._mass, self._task = np.zeros((nv, nv)), np.zeros((12, nv))
        limit = np.full(len(robot.dof), np.nan) if torque_limit is None else torque_limit
        self._limit = np.where(np.isnan(limit), _UNLIMITED, limit)
        self._cones, self._lines = [], []
        for toe, heel, left, right in robot.body.sole_rectangle:
            sizes = (toe - heel) / 2.0 - STRIP, (left - right) / 2.0 - STRIP
            self._cones.append(wrench_cone(PYRAMID, *sizes))
            self._lines.append(wrench_cone(PYRAMID, _LINE, sizes[1]))
        moving = robot.body.moving
        self._swinging = [
            np.isin(moving, robot.body.leg(1 - foot)).astype(float) for foot in (0, 1)
        ]
        self._trajectory, self._step, self._level = trajectory, -1, 0.0
        self.unsolved, self._turn_rate = 0, 0.0
        """Ticks whose program had no solution: torques were then cut at their limits alone."""
        self.touch_down(0, -self._reference.both)

    def touch_down(self, foot: int, time: float) -> None:
        """Begin the next step at a time [s], where it should be."""
        self._foot, self._landed = foot, time
        self._believed: Array | None = None
        self._left: Array | None = None
        self._step += 1
        place = self._trajectory.advance(self._step)
        self._level = float(place.translation[2])
        ahead = place.rotation @ self._trajectory.advance(self._step % 2).rotation.T
        self._heading = float(np.arctan2(ahead[1, 0], ahead[0, 0]))
        self._rolls = self._reference.targets[foot][0].turn is not None
        self._move, self._move_rate, self._goal = np.zeros(2), np.zeros(2), np.zeros(2)

    def torque(self, time: float, qpos: Array, qvel: Array) -> Array:
        """Return the torques of the motors [N·m], see `Controller.torque` and the module."""
        robot, data = self._robot, self._data
        foot, since, count = self._foot, time - self._landed, len(self._robot.dof)
        self._see(qpos, qvel)
        target = self._reference.at(foot, since, _DESCENT)
        bias = data.qfrc_bias - data.qfrc_passive
        turning = robot.body.coupling(target.q) @ target.dq
        bias[robot.driven] += robot.body.friction[robot.body.driven] * np.tanh(
            turning / FRICTION_RATE
        )
        # all accelerations are N x + n with those of the joints x, and of the standing foot where
        # it turns about a line: what of it rests on the ground is held
        turn = self._turn(target, since)
        N, n, inverse = self._held(turn)
        MN, rest = self._mass @ N, self._mass @ n + bias
        wrench, wrench_0 = inverse.T @ MN[:6], inverse.T @ rest[:6]
        torque, torque_0 = N[:, :count].T @ MN, N[:, :count].T @ rest
        task, wanted, weights = self._tasks(since, target, bias)
        A = task @ N
        weighted = A.T * weights
        dq = data.qvel[robot.dof]
        kp, kd = _POSTURE
        own = target.ddq + kp * (target.q - data.qpos[robot.qpos]) + kd * (target.dq - dq)
        slight = np.full(N.shape[1], _JOINTS_WEIGHT)
        # the tasks ask the swing leg for what it lags behind, too; the same in the stance leg
        # winds up while the sole rocks, and falls
        landing = self._believed is None or since < _IMPACT
        believed = dq if landing else self._believed
        lag = _OBSERVE * (believed - dq) * self._swinging[foot]
        if turn is not None:
            slight[count] = _TURN_WEIGHT
            own, lag = np.append(own, self._rolling(turn)), np.append(lag, 0.0)
        H = weighted @ A
        H.flat[:: len(H) + 1] += slight
        f = -weighted @ (wanted - task @ n + A @ lag) - slight * (own + lag)
        cone = self._cone(foot, turn)
        C, least = cone @ wrench, -cone @ wrench_0
        least[0] += _LEAST_FORCE
        if target.behind is not None:
            rear = target.behind, target.turn_behind
            H, f, C, least, torque = self._shared(*rear, N, inverse, H, f, C, least, torque)
        upper = np.concatenate([np.full(len(least), _UNLIMITED), self._limit - torque_0])
        lower = np.concatenate([least, -self._limit - torque_0])
        C = np.vstack([C, torque])
        x, _, flag, _ = daqp.solve(H, f, C, upper, lower, np.zeros(len(lower), dtype=np.int32))
        if flag < 1:
            self.unsolved += 1
            x = np.linalg.solve(H, -f)
        joints = x[:count] - lag[:count] - _FORGET * (believed - dq)
        self._believed = believed + _INTERVAL * joints
        return np.asarray(np.clip(torque @ x + torque_0, -self._limit, self._limit))

    def _see(self, qpos: Array, qvel: Array) -> None:
        """Take a state, the world turned so that the step goes where the first ones go."""
        data = self._data
        data.qpos[:], data.qvel[:] = qpos, qvel
        if self._heading:
            back = pin.utils.rotate("z", -self._heading)
            half = -0.5 * self._heading
            data.qpos[:3], data.qvel[:3] = back @ qpos[:3], back @ qvel[:3]
            turn = np.array([np.cos(half), 0.0, 0.0, np.sin(half)])
            mujoco.mju_mulQuat(data.qpos[3:7], turn, qpos[3:7])
        mujoco.mj_fwdPosition(self._robot.model, data)
        mujoco.mj_fwdVelocity(self._robot.model, data)
        mujoco.mj_fullM(self._robot.model, data, self._mass)

    def _turn(self, target: Target, since: float) -> Turn | None:
        """Return how the standing foot is to turn; None where it stands flat."""
        # A foot that landed on a line is flat when it is, or when the design has it flat.
        turn = target.turn
        if self._rolls and (turn is None or self._angle(turn) < _FLAT):
            self._rolls = False
        return turn if self._rolls or since > 0.5 * self._reference.duration else None

    def _angle(self, turn: Turn) -> float:
        """Return the angle of the standing foot about a line of it [rad]."""
        R = self._robot.sole_axes(self._data, self._foot)
        return float(turn.axis[1] * np.arctan2(-R[2, 0], R[2, 2]))

    def _rolling(self, turn: Turn) -> float:
        """Return the acceleration that the standing foot is to have about its line [rad/s²]."""
        kp, kd = _TURN
        error = turn.angle - self._angle(turn)
        return turn.acceleration + kp * error + kd * (turn.rate - self._turn_rate)

    def _held(self, turn: Turn | None) -> tuple[Array, Array, Array]:
        """Return N and n, and the inverse of the base's columns of the standing sole's Jacobian."""
        robot, data = self._robot, self._data
        J, drift = sole_motion(robot, data, self._foot)
        inverse = np.linalg.inv(J[:, :6])
        N = robot.free(data.qpos)[:, 6:].copy()
        N[:6] = -inverse @ J @ N
        twist, turned = J @ data.qvel, np.zeros(6)
        n = robot.drift(data.qpos, data.qvel)
        if turn is not None:
            R = robot.sole_axes(data, self._foot)
            axis, arm = R @ turn.axis, -R @ turn.point
            along = np.concatenate([np.cross(axis, arm), axis])
            rate = self._turn_rate = float(axis @ twist[3:])
            twist -= rate * along
            turned[:3] = rate**2 * np.cross(axis, along[:3])
            column = np.zeros((robot.model.nv, 1))
            column[:6, 0] = inverse @ along
            N = np.hstack([N, column])
        n[:6] = inverse @ (turned - _HOLD * twist - drift - J @ n)
        return N, n, np.asarray(inverse)

    def _cone(self, foot: int, turn: Turn | None) -> Array:
        """Return the rows >= 0 of the wrench at a sole frame in the world's axes."""
        if turn is not None:
            return np.asarray(self._lines[foot] @ self._about(foot, turn.point))
        toe, heel, left, right = self._robot.body.sole_rectangle[foot]
        centre = np.array([(toe + heel) / 2.0, (left + right) / 2.0, 0.0])
        return np.asarray(self._cones[foot] @ self._about(foot, centre))

    def _shared(
        self,
        behind: Array,
        turn: Turn | None,
        N: Array,
        inverse: Array,
        H: Array,
        f: Array,
        C: Array,
        least: Array,
        torque: Array,
    ) -> tuple[Array, Array, Array, Array, Array]:
        """Return a program with the wrench on the other foot beside, which stands too."""
        # That of the standing sole is less by what the other bears, as designed (`behind`).
        robot, other = self._robot, 1 - self._foot
        J, _ = sole_motion(robot, self._data, other)
        cone, count = self._cone(other, turn), len(f)
        scale = robot.weight * np.array([1.0, 1.0, 1.0, _ARM, _ARM, _ARM])
        moved = -inverse.T @ J[:, :6].T * scale
        big = np.zeros((count + 6, count + 6))
        big[:count, :count] = H
        big[count:, count:] = np.eye(6)
        f = np.append(f, -behind / scale)
        on_this = self._cone(self._foot, None) @ moved
        C = np.block([[C, on_this], [np.zeros((len(cone), count)), cone * scale]])
        more = np.zeros(len(cone))
        more[0] = _LEAST_FORCE
        pushed = -N[:, : len(torque)].T @ J.T * scale
        return big, f, C, np.append(least, more), np.hstack([torque, pushed])

    def _tasks(self, since: float, target: Target, bias: Array) -> tuple[Array, Array, Array]:
        """Return the Jacobians of the tasks (12, 6 + n), what they are to give, and weights (12,).

        The first six are of the other sole.
        """
        robot, data, foot = self._robot, self._data, self._foot
        standing = data.site_xpos[robot.site[foot]]
        com = data.subtree_com[robot.base] - standing
        com_velocity = self._mass[:3] @ data.qvel / robot.mass
        w, k = self._reference.rate, _DECAY
        late = target.com - com, target.com_velocity - com_velocity
        push = self._adjust(since, -(late[0] + late[1] / w)[:2])
        J, drift = sole_motion(robot, data, 1 - foot)
        twist = J @ data.qvel
        wanted, weights = np.empty(12), _TASKS
        if target.behind is None:
            wanted[:6] = self._swing(since, target, push, standing, twist) - drift
        else:
            wanted[:6] = target.sole_acceleration + _HOLD * (target.sole_twist - twist)
            wanted[:6] -= drift
            weights = weights.copy()
            weights[:6] = _STAND_WEIGHT
        trunk = data.xmat[robot.base].reshape(3, 3)
        kp, kd = _TRUNK
        wanted[6:9] = (
            target.trunk_acceleration
            + kp * _rotation_to(target.trunk_rotation, trunk)
            + kd * (target.trunk_rate - trunk @ data.qvel[3:6])
        )
        kp, kd = _HEIGHT
        stiffness, damping = np.array([k * w, k * w, kp]), np.array([w + k, w + k, kd])
        height = late[0].copy()
        # above the ground as designed, not above a sole that sinks in
        height[2] += self._level + target.raised - standing[2]
        wanted[9:] = target.com_acceleration + stiffness * height + damping * late[1]
        wanted[9:] -= bias[:3] / robot.mass + robot.body.gravity
        task = self._task
        task[:6], task[6:9, 3:6], task[9:] = J, trunk, self._mass[:3] / robot.mass
        return task, wanted, weights

    def _swing(
        self, since: float, target: Target, push: Array, standing: Array, twist: Array
    ) -> Array:
        """Return the acceleration that the swing sole is to have (6,).

        Args:
            since: touch-down [s].
            push: acceleration of the move of the step (2,).
            standing: place of the standing sole (3,).
            twist: of the swing sole (6,).
        """
        robot, data = self._robot, self._data
        swinging = robot.site[1 - self._foot]
        place = standing + target.sole
        place[2] = self._level + target.raised + target.sole[2]
        place[:2] += self._move
        self._keep_apart(place, standing)
        rate = target.sole_twist.copy()
        rate[:2] += self._move_rate
        if self._left is None:
            self._left = (data.site_xpos[swinging] - place)[:2]
        lifted = since - self._reference.both
        faded, faded_rate, faded_push = fading(lifted, _CATCH_UP * self._reference.duration)
        place[:2] += faded * self._left
        rate[:2] += faded_rate * self._left
        push = push + faded_push * self._left
        turn = _rotation_to(target.sole_rotation, robot.sole_axes(data, 1 - self._foot))
        kp, kd = _SWING
        error = np.concatenate([place - data.site_xpos[swinging], turn])
        wanted = target.sole_acceleration + kp * error + kd * (rate - twist)
        wanted[:2] += push
        return np.asarray(wanted)

    def _adjust(self, since: float, error: Array) -> Array:
        """Move the step to where the error of xi is caught; return the acceleration of the move."""
        reference = self._reference
        w, k = reference.rate, _DECAY
        rest = max(reference.duration - since, 0.0)
        if since < _FROZEN * reference.duration:
            room = np.maximum(reference.room[self._foot][reference.row(since)], 0.0)
            for axis in (_FORWARD, _LEFT):
                sign, size = (1.0 if error[axis] > 0.0 else -1.0), abs(error[axis])
                free = room[2 * axis] if sign > 0.0 else room[2 * axis + 1]
                grown = free + (size - free) * np.exp(w * rest)
                predicted = sign * max(grown, size * np.exp(-k * rest))
                reach = _REACH[axis]
                self._goal[axis] = min(max(_CATCH * predicted, -reach), reach)
        rate = _FILTER
        push = rate**2 * (self._goal - self._move) - 2.0 * rate * self._move_rate
        self._move_rate = self._move_rate + push * _INTERVAL
        self._move = self._move + self._move_rate * _INTERVAL
        return np.asarray(push)

    def _keep_apart(self, place: Array, standing: Array) -> None:
        """Move the place of the swing sole so that it does not step on the other."""
        # A foot ahead or behind by more than its length may land on the line of the other.
        toe, heel, left, right = self._robot.body.sole_rectangle[self._foot]
        beyond = abs(place[0] - standing[0]) - (toe - heel) - _GAP
        free = min(max(beyond / _PASSING, 0.0), 1.0)
        least = (1.0 - free) * (left - right + _GAP)
        side = np.sign(self._reference.targets[self._foot][0].sole[1])
        if side * (place[1] - standing[1]) < least:
            place[1] = standing[1] + side * least

    def _about(self, foot: int, point: Array) -> Array:
        """Return what takes a wrench at the sole frame, world's axes, to a point of it, (6, 6).

        The axes are those of the sole turned upright.
        """
        R = self._robot.sole_axes(self._data, foot)
        length = np.hypot(R[0, 0], R[1, 0])
        c, s = R[0, 0] / length, R[1, 0] / length
        turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        moved = np.zeros((6, 6))
        moved[:3, :3] = moved[3:, 3:] = turn
        moved[3:, :3] = -turn @ pin.skew(R @ point)
        return moved


def whole_body_walks() -> Callable[[SimulatedRobot, Trajectory, Array | None], WholeBodyController]:
    """Return a maker of controllers from robot, walk and limit of the torques (n,) [N·m].

    Those of the same walk share its reference.
    """
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
