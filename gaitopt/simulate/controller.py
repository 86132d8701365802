"""Feedback controllers of a simulated walk: what the simulator asks of one, and joint PD."""

from __future__ import annotations

from typing import Protocol

import mujoco
import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.gait.trajectory import Trajectory, TrajectorySamples
from gaitopt.nlp import Array
from gaitopt.simulate.mujoco_model import SimulatedRobot


class Controller(Protocol):
    """What walks a simulated robot; one object walks one walk.

    The simulator measures the state exactly and calls `torque` once a tick.

    Attributes:
        interval: between two ticks [s].
    """

    interval: float

    def touch_down(self, foot: int, time: float) -> None:
        """Take note that a foot has landed and stands from now on.

        Args:
            foot: as index into `Multibody.sole_names`.
            time: of the walk [s].
        """

    def torque(self, time: float, qpos: Array, qvel: Array) -> Array:
        """Return the torques of the motors [N·m], shape (n,), joints as in `Multibody.moving`.

        Args:
            time: of the walk [s].
            qpos, qvel: state of the MuJoCo model.
        """


@dataclass(frozen=True, eq=False)
class JointReference:
    """Designed motion of the moving joints at equidistant instants of a step.

    Attributes:
        interval: between instants [s].
        q, dq, torque: while foot 0 and while foot 1 stands [rad, rad/s, N·m], shape (2, N, n).
    """

    interval: float
    q: Array
    dq: Array
    torque: Array

    def row(self, time: float) -> int:
        """Return the instant nearest to a time since touch-down [s]; the last one stays."""
        return min(max(round(time / self.interval), 0), len(self.q[0]) - 1)


def joint_reference(trajectory: Trajectory, interval: float) -> JointReference:
    """Sample the joints of two steps, one on each foot."""
    count = round(trajectory.step_duration / interval) + 1
    moving = trajectory.body.moving
    steps = [step_samples(trajectory, step, count) for step in (0, 1)]
    return JointReference(
        trajectory.step_duration / (count - 1),
        *(np.array([getattr(s, n)[:, moving] for s in steps]) for n in ("q", "dq", "torque")),
    )


def step_samples(trajectory: Trajectory, step: int, count: int) -> TrajectorySamples:
    """Return `TrajectorySamples` of a step from its touch-down to just before the next.

    Where both feet of the gait stand at the end of its step, a step of feedback begins with that.
    """
    times = np.linspace(0.0, trajectory.step_duration, count)
    begin = step * trajectory.step_duration - both_feet(trajectory)
    return trajectory.at(begin + times, before=times > 0.0)


def both_feet(trajectory: Trajectory) -> float:
    """Return how long both feet of a walk stand in each step [s], 0 where an impact ends it."""
    last = trajectory.phases[-1]
    return 0.0 if last.front is None else last.duration


_BANDWIDTH = 20.0  # w of `JointPD` [rad/s]


class JointPD:
    """Joint feedback, Kp = w² D and Kd = 2 w D with the joints' own inertias D, plus feed-forward.

    The phase begins anew at each touch-down. It does not know the sole: it walks only as long as
    the centre of pressure that it happens to ask for is inside.
    """

    def __init__(self, robot: SimulatedRobot, trajectory: Trajectory) -> None:
        """Take gains from the mass matrix at the start of the walk.

        Args:
            robot: the model.
            trajectory: the walk.
        """
        self.interval = 0.002
        self._robot, self._foot, self._landed = robot, 0, -both_feet(trajectory)
        self._reference = joint_reference(trajectory, 0.0005)
        data = mujoco.MjData(robot.model)
        data.qpos[:] = robot.position(trajectory.at(0.0).configuration[0])
        mujoco.mj_forward(robot.model, data)
        inertia = np.diag(robot.mass_matrix(data))[robot.dof]
        self._stiffness, self._damping = _BANDWIDTH**2 * inertia, 2.0 * _BANDWIDTH * inertia

    def touch_down(self, foot: int, time: float) -> None:
        """Begin the next step at a time [s]."""
        self._foot, self._landed = foot, time

    def torque(self, time: float, qpos: Array, qvel: Array) -> Array:
        """Return feed-forward and feedback [N·m], see `Controller.torque`."""
        reference, foot = self._reference, self._foot
        row = reference.row(time - self._landed)
        error = reference.q[foot, row] - qpos[self._robot.qpos]
        rate_error = reference.dq[foot, row] - qvel[self._robot.dof]
        feedback = self._stiffness * error + self._damping * rate_error
        return np.asarray(reference.torque[foot, row] + feedback)
