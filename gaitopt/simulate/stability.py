"""Orbital stability of a gait under two simple feedbacks, and how far it can be trusted.

While the sole stays flat the joints determine the robot: the state is x = (q, dq) of the n joints
less their design, and every joint has a motor. With feedback K the step maps it by

    S = E2 G (I + f s') Phi,    Phi = product of expm((A - B K) h) over the step,

with A = [0 I; -D^-1 dID/dq, -D^-1 dID/d(dq)], B = [0; D^-1] of the inverse dynamics ID and the
mass matrix D on a fixed sole; dt = s'x, by which the landing is late; f = (dq, ddq) just before it;
G, the differential of the impact; E2, which exchanges the legs. The clock begins anew at the
landing, and the sole that lands is taken as flat from then on. Eigenvalues of S are the
multipliers: J. W. Grizzle, G. Abba, F. Plestan, IEEE Transactions on Automatic Control 46(1), 2001;
the jump by the landing time (saltation): M. A. Aizerman, F. R. Gantmacher, 1958.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import mujoco
import numpy as np
from scipy.linalg import expm

from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.gait.quantities import CORNER_NAMES
from gaitopt.gait.result import Gait
from gaitopt.nlp import Array
from gaitopt.simulate.disturbance import stand
from gaitopt.simulate.mujoco_model import simulated_robot
from gaitopt.simulate.reference import BANDWIDTH, sole_motion
from gaitopt.simulate.second_engine import engine_impact

INTERVALS = 100
"""Of a step, in each of which the linear system is constant."""
_DIFFERENCE = 1e-5  # rad and rad/s, of central differences
_RATE_SCALE = 5.0  # 1/s: 1 rad counts as much as 5 rad/s in the size of a disturbance
_ANGLE, _RATE, _EFFORT = 0.05, 0.5, 0.1  # rad, rad/s, share of the torque: equal costs of the LQR
_PERIODS = 12  # of the Riccati equation; more change nothing
_GRAZING = 1e-9  # m/s: slower corners land at any time
_SMALL = 0.01  # of the linear region: size of the disturbances that are simulated
_EXPLICIT = 1.0  # times the fastest rate: the method of Runge and Kutta follows it to 1 %
_STEPS = 3  # over which a contraction is measured


@dataclass(frozen=True)
class Feedback:
    """Stability under a feedback.

    Attributes:
        multiplier: largest modulus of the multipliers: what is left of a disturbance in a step.
        region: size of the start error, in its worst direction, up to which the centre of
            pressure stays in the sole over the step [rad; 5 rad/s count as 1 rad].
        measured: contraction per step of the nonlinear walk, over three steps from a disturbance a
            hundredth of the region long, along the slowest multiplier.
        predicted: that of S from the same start.
    """

    multiplier: float
    region: float
    measured: float
    predicted: float


@dataclass(frozen=True)
class Stability:
    """What says how a gait reacts to small disturbances.

    Attributes:
        joint_pd: under joint PD with feed-forward.
        lqr: under the time-varying LQR that knows that the landing moves.
        landing: largest change of the landing time per change of a joint [s/rad], of the middle of
            the sole, and by the name of the corner; infinite where one grazes.
        growth: of an error of the divergent component of motion in a step, once the centre of
            pressure is at the edge of the sole: exp(w T).
    """

    joint_pd: Feedback
    lqr: Feedback
    landing: dict[str, float]
    growth: float


def stability(gait: Gait) -> Stability:
    """Return the stability of a gait, its dry friction left out.

    Raises:
        InputError: the gait cannot be simulated, or its two legs walk differently.
        RobotError: the gait has no robot of its own, and its URDF is not its robot.
    """
    walk = _Walk(gait)
    pd = np.repeat(walk.joint_pd()[None], INTERVALS, axis=0)
    late = walk.landing_row(walk.middle)
    names = dict(zip(CORNER_NAMES, walk.corners, strict=True))
    landing = {"middle": float(np.linalg.norm(late))}
    landing |= {name: float(np.linalg.norm(walk.landing_row(p))) for name, p in names.items()}
    height = float(np.mean(walk.heights))
    rate = np.sqrt(float(np.linalg.norm(walk.robot.body.gravity)) / height)
    return Stability(
        joint_pd=walk.under(pd),
        lqr=walk.under(walk.lqr()),
        landing=landing,
        growth=float(np.exp(rate * walk.duration)),
    )


class _Walk:
    """A step of a gait, the sole fixed: reference, linear systems, and the nonlinear walk."""

    def __init__(self, gait: Gait) -> None:
        trajectory = gait.trajectory
        alike, flat = len(gait.steps) == 1, not (gait.turning or gait.lands_on_line)
        if trajectory.exchange is None or not alike or not flat or gait.closing:
            raise InputError("multipliers are those of walks on flat feet whose legs take turns")
        self._gait = gait
        self.robot = robot = simulated_robot(trajectory.body)
        off = mujoco.mjtDisableBit.mjDSBL_CONSTRAINT | mujoco.mjtDisableBit.mjDSBL_CONTACT
        robot.model.opt.disableflags |= int(off)
        self.data, self.n = mujoco.MjData(robot.model), len(robot.dof)
        self.place, self.exchange = trajectory.advance(0), trajectory.exchange
        self._rise = float(trajectory.advance(1).translation[2])
        self.duration, self.h = gait.duration, gait.duration / INTERVALS
        # at the ends and the middles of the intervals
        times = np.linspace(0.0, self.duration, 2 * INTERVALS + 1)
        samples = trajectory.at(times, before=times > 0.0)
        moving = trajectory.body.moving
        self.q, self.dq, self.ddq = (v[:, moving] for v in (samples.q, samples.dq, samples.ddq))
        self.torque, self.heights = np.empty_like(self.q), np.empty(len(times))
        for k in range(len(times)):
            D, bias, _ = self.dynamics(self.q[k], self.dq[k])
            self.torque[k] = D @ self.ddq[k] + bias
            self.heights[k] = self.data.subtree_com[robot.base][2]
        body = trajectory.body
        self.corners = body.sole_corners[1]
        self.middle = self.corners.mean(axis=0)
        limit = gait.joint_limit("torque")
        most = float(np.abs(self.torque).max())
        self.limit = np.full(self.n, most) if limit is None else np.where(
            np.isfinite(limit), limit, most
        )  # fmt: skip
        self.A, self.B = self._linear()
        self.jump = self._jump()

    def dynamics(self, q: Array, dq: Array) -> tuple[Array, Array, Array]:
        """Return D (n, n) and the torques without acceleration (n,) on the fixed sole.

        The third is what takes joint accelerations and 1 to the wrench on the sole frame in the
        world's axes, shape (6, n + 1).
        """
        robot, data, model = self.robot, self.data, self.robot.model
        self._stand(q, dq)
        mujoco.mj_fwdVelocity(model, data)
        M = robot.mass_matrix(data)
        J, drift = sole_motion(robot, data, 0)
        inverse = np.linalg.inv(J[:, :6])
        N = robot.free(data.qpos)[:, 6:].copy()
        n0 = robot.drift(data.qpos, data.qvel)
        N[:6], n0[:6] = -inverse @ J @ N, -inverse @ (drift + J @ n0)
        MN, rest = M @ N, M @ n0 + data.qfrc_bias - data.qfrc_passive
        wrench = np.column_stack([inverse.T @ MN[:6], inverse.T @ rest[:6]])
        return N.T @ MN, N.T @ rest, wrench

    def joint_pd(self) -> Array:
        """Return the gains (n, 2 n) of scaled joint feedback."""
        D = self.dynamics(self.q[0], self.dq[0])[0]
        inertia = np.diag(np.diag(D))
        return np.hstack([BANDWIDTH**2 * inertia, 2.0 * BANDWIDTH * inertia])

    def _linear(self) -> tuple[Array, Array]:
        """Return A (N, 2 n, 2 n) and B (N, 2 n, n) in the middles of the intervals."""
        n = self.n
        A, B = np.zeros((INTERVALS, 2 * n, 2 * n)), np.zeros((INTERVALS, 2 * n, n))
        A[:, :n, n:] = np.eye(n)
        for k in range(INTERVALS):
            row = 2 * k + 1
            q, dq, ddq = self.q[row], self.dq[row], self.ddq[row]
            inverse = np.linalg.inv(self.dynamics(q, dq)[0])
            A[k, n:] = -inverse @ self._differences(partial(self._torque, ddq), q, dq)
            B[k, n:] = inverse
        return A, B

    def _torque(self, ddq: Array, q: Array, dq: Array) -> Array:
        D, bias, _ = self.dynamics(q, dq)
        return np.asarray(D @ ddq + bias)

    def _differences(self, function: Callable[[Array, Array], Array], q: Array, dq: Array) -> Array:
        """Return central differences of a function of (q, dq) in both, columns (2 n)."""
        columns = []
        for index in range(2 * self.n):
            step = np.zeros(2 * self.n)
            step[index] = _DIFFERENCE
            e, de = step[: self.n], step[self.n :]
            columns.append(
                (function(q + e, dq + de) - function(q - e, dq - de)) / (2 * _DIFFERENCE)
            )
        return np.array(columns).T

    def _stand(self, q: Array, dq: Array | float) -> None:
        """Put the robot on its standing sole, joints at angles and rates (n,)."""
        robot, data = self.robot, self.data
        data.qpos[robot.qpos], data.qvel[robot.dof] = q, dq
        robot.follow(data.qpos, data.qvel)
        stand(robot, data, 0, self.place)

    def after_impact(self, q: Array, dq: Array) -> Array:
        """Return the joint rates after the landing of the other sole (n,)."""
        robot, data = self.robot, self.data
        self._stand(q, dq)
        return engine_impact(robot, data, 1, self._gait)[0]

    def height(self, q: Array, point: Array) -> float:
        """Return the height of a point of the landing sole, in its frame, over the ground [m]."""
        robot, data = self.robot, self.data
        self._stand(q, 0.0)
        up = robot.sole_axes(data, 1)[2]
        return float(data.site_xpos[robot.site[1]][2] + up @ point) - self._rise

    def landing_row(self, point: Array) -> Array:
        """Return s (2 n,): landing time dt = s'x if that point of the sole decides [s/rad]."""
        q, dq = self.q[-1], self.dq[-1]
        by_q = self._differences(lambda q, _: np.array([self.height(q, point)]), q, dq)[0]
        rate = float(by_q[: self.n] @ dq)
        if abs(rate) < _GRAZING:
            return np.full(2 * self.n, np.inf)
        return np.asarray(-by_q / rate)

    def _jump(self) -> Array:
        """Return E2 G (I + f s'), shape (2 n, 2 n)."""
        n, q, dq = self.n, self.q[-1], self.dq[-1]
        G = np.zeros((2 * n, 2 * n))
        G[:n, :n] = np.eye(n)
        G[n:] = self._differences(self.after_impact, q, dq)
        f = np.concatenate([dq, self.ddq[-1]])
        exchange = np.kron(np.eye(2), self.exchange)
        late = np.eye(2 * n) + np.outer(f, self.landing_row(self.middle))
        return np.asarray(exchange @ G @ late)

    def lqr(self) -> Array:
        """Return the gains (N, n, 2 n) of the periodic LQR, its jump that of the landing."""
        n, h = self.n, self.h
        Q = np.diag(np.repeat([_ANGLE**-2, _RATE**-2], n)) * h
        R = np.diag((_EFFORT * self.limit) ** -2) * h
        discrete = []
        for A, B in zip(self.A, self.B, strict=True):
            both = np.zeros((3 * n, 3 * n))
            both[: 2 * n, : 2 * n], both[: 2 * n, 2 * n :] = A * h, B * h
            both = expm(both)
            discrete.append((both[: 2 * n, : 2 * n], both[: 2 * n, 2 * n :]))
        P, gains = np.eye(2 * n), np.empty((INTERVALS, n, 2 * n))
        for _ in range(_PERIODS):
            P = self.jump.T @ P @ self.jump
            for k in range(INTERVALS - 1, -1, -1):
                Ad, Bd = discrete[k]
                gains[k] = np.linalg.solve(R + Bd.T @ P @ Bd, Bd.T @ P @ Ad)
                P = Q + Ad.T @ P @ (Ad - Bd @ gains[k])
                P = 0.5 * (P + P.T)
        return gains

    def under(self, gains: Array) -> Feedback:
        """Return the stability under gains (N, n, 2 n)."""
        Phi, region = np.eye(2 * self.n), np.inf
        weigh = np.repeat([1.0, _RATE_SCALE], self.n)
        for k in range(INTERVALS):
            closed = self.A[k] - self.B[k] @ gains[k]
            half = expm(closed * self.h / 2.0)
            region = min(region, self._region(2 * k + 1, closed, half @ Phi * weigh))
            Phi = half @ half @ Phi
        S = self.jump @ Phi
        values, vectors = np.linalg.eig(S)
        slowest = int(np.argmax(np.abs(values)))
        start = np.real(vectors[:, slowest])
        start *= _SMALL * region / np.linalg.norm(start / weigh)
        end, walked, alone = start, start, np.zeros_like(start)
        for _ in range(_STEPS):
            end = S @ end
            walked, alone = self.walked(walked, gains), self.walked(alone, gains)
        walked = walked - alone  # the design is sampled: alone it is off by 1e-6, too
        size = np.linalg.norm(start / weigh)
        return Feedback(
            multiplier=float(np.abs(values[slowest])),
            region=region,
            measured=float((np.linalg.norm(walked / weigh) / size) ** (1.0 / _STEPS)),
            predicted=float((np.linalg.norm(end / weigh) / size) ** (1.0 / _STEPS)),
        )

    def _region(self, row: int, closed: Array, along: Array) -> float:
        """Return the size of the start error that takes the pressure to an edge at an instant.

        Args:
            row: of the instant.
            closed: A - B K there.
            along: what takes the scaled start error to the error there, shape (2 n, 2 n).
        """
        q, dq, ddq = self.q[row], self.dq[row], self.ddq[row]
        toe, heel, left, right = self.robot.body.sole_rectangle[0]
        # the distances to the four edges times the normal force: toe f_z + m_y, and so on
        edges = np.zeros((4, 6))
        edges[:, 2] = toe, -heel, left, -right
        edges[[0, 1, 2, 3], [4, 4, 3, 3]] = 1.0, -1.0, -1.0, 1.0
        turn = np.kron(np.eye(2), self.place.rotation.T)

        def room(q: Array, dq: Array) -> Array:
            return np.asarray(edges @ turn @ (self.dynamics(q, dq)[2] @ np.append(ddq, 1.0)))

        here = room(q, dq)
        by_acceleration = edges @ turn @ self.dynamics(q, dq)[2][:, :-1]
        change = (self._differences(room, q, dq) + by_acceleration @ closed[self.n :]) @ along
        return float(np.min(np.maximum(here, 0.0) / np.linalg.norm(change, axis=1)))

    def walked(self, x: Array, gains: Array) -> Array:
        """Return x at the next landing of the nonlinear walk, x given at this one, (2 n,)."""
        state = x + np.concatenate([self.q[0], self.dq[0]])
        for k in range(INTERVALS - 1):
            state = self._advance(state, k, self.h, gains[k])
        last, h = state, self.h

        def height(duration: float) -> float:
            end = self._advance(last, INTERVALS - 1, duration, gains[-1])
            return self.height(end[: self.n], self.middle)

        before, now = 0.999 * h, h
        low, high = height(before), height(now)
        for _ in range(6):  # secants; the height is nearly linear in time
            if high == low:
                break
            before, now = now, now - high * (now - before) / (high - low)
            low, high = high, height(now)
        state = self._advance(last, INTERVALS - 1, now, gains[-1])
        q, dq = state[: self.n], self.after_impact(state[: self.n], state[self.n :])
        return np.concatenate([self.exchange @ q - self.q[0], self.exchange @ dq - self.dq[0]])

    def _advance(self, state: Array, interval: int, duration: float, gain: Array) -> Array:
        """Return the state after a part of an interval, by the method of Runge and Kutta."""

        def rate(time: float, state: Array) -> Array:
            q, dq = state[: self.n], state[self.n :]
            wanted, torque = self._reference(interval, time)
            D, bias, _ = self.dynamics(q, dq)
            push = torque - gain @ (state - wanted) - bias
            return np.concatenate([dq, np.linalg.solve(D, push)])

        closed = self.A[interval] - self.B[interval] @ gain
        fastest = float(np.abs(np.linalg.eigvals(closed)).max())
        count = max(1, math.ceil(fastest * duration / _EXPLICIT))
        d = duration / count
        for time in d * np.arange(count):
            a = rate(time, state)
            b = rate(time + d / 2.0, state + d / 2.0 * a)
            c = rate(time + d / 2.0, state + d / 2.0 * b)
            e = rate(time + d, state + d * c)
            state = state + d / 6.0 * (a + 2.0 * b + 2.0 * c + e)
        return state

    def _reference(self, interval: int, time: float) -> tuple[Array, Array]:
        """Return state (2 n,) and torque (n,) of the design at a time in an interval."""
        s = 2.0 * time / self.h - 1.0
        weights = np.array([s * (s - 1.0) / 2.0, 1.0 - s * s, s * (s + 1.0) / 2.0])
        rows = slice(2 * interval, 2 * interval + 3)
        state = np.concatenate([weights @ self.q[rows], weights @ self.dq[rows]])
        return state, np.asarray(weights @ self.torque[rows])
