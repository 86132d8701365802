"""What the whole-body controller follows: tasks of the designed walk while each foot stands.

A step of feedback lasts from touch-down to touch-down. Where both feet of a gait stand at the end
of its step, they do so here at the begin of the next, on the foot that has landed. Here too is what
the simulator asks of any controller, and joint PD.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import mujoco
import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.gait.trajectory import Trajectory, TrajectoryPhase, TrajectorySamples
from gaitopt.mechanics.spatial import turned
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


BANDWIDTH = 20.0
"""w of scaled joint feedback, Kp = w² D and Kd = 2 w D [rad/s]."""


class JointPD:
    """Joint feedback, Kp = w² D and Kd = 2 w D with the joints' own inertias D, plus feed-forward.

    The phase begins anew at each touch-down. It does not know the sole: it walks only as long as
    the centre of pressure that it happens to ask for is inside.
    """

    def __init__(self, robot: SimulatedRobot, trajectory: Trajectory) -> None:
        """Take gains from the mass matrix at the start of the walk."""
        self.interval = 0.002
        self._robot, self._foot, self._landed = robot, 0, -both_feet(trajectory)
        count = round(trajectory.step_duration / 0.0005) + 1
        self._spacing = trajectory.step_duration / (count - 1)
        moving = trajectory.body.moving
        steps = [step_samples(trajectory, step, count) for step in (0, 1)]
        # of the moving joints, while foot 0 and while foot 1 stands, shape (2, N, n)
        self._q, self._dq, self._torque = (
            np.array([getattr(s, n)[:, moving] for s in steps]) for n in ("q", "dq", "torque")
        )
        data = mujoco.MjData(robot.model)
        data.qpos[:] = robot.position(trajectory.at(0.0).configuration[0])
        mujoco.mj_forward(robot.model, data)
        inertia = np.diag(robot.mass_matrix(data))[robot.dof]
        self._stiffness, self._damping = BANDWIDTH**2 * inertia, 2.0 * BANDWIDTH * inertia

    def touch_down(self, foot: int, time: float) -> None:
        """Begin the next step at a time [s]."""
        self._foot, self._landed = foot, time

    def torque(self, time: float, qpos: Array, qvel: Array) -> Array:
        """Return feed-forward and feedback [N·m], see `Controller.torque`."""
        # the instant nearest to the time; the last one stays
        row = min(max(round((time - self._landed) / self._spacing), 0), self._q.shape[1] - 1)
        at = self._foot, row
        error = self._q[at] - qpos[self._robot.qpos]
        rate_error = self._dq[at] - qvel[self._robot.dof]
        feedback = self._stiffness * error + self._damping * rate_error
        return np.asarray(self._torque[at] + feedback)


_INTERVAL = 0.001  # s, between instants of the reference
_ROUNDING = 1e-9  # s


@dataclass(frozen=True, eq=False)
class Turn:
    """How the standing foot is to turn about a line of its sole.

    Attributes:
        point, axis: of the line in the sole frame [m, -], shapes (3,).
        angle, rate, acceleration: about it [rad, rad/s, rad/s²].
    """

    point: Array
    axis: Array
    angle: float
    rate: float
    acceleration: float


@dataclass(frozen=True, eq=False)
class Target:
    """Where the tasks are to be at an instant, in the world's axes about the standing sole.

    Attributes:
        q, dq, ddq: of the moving joints [rad, rad/s, rad/s²], shapes (n,).
        sole, sole_rotation, sole_twist, sole_acceleration: of the other sole, shapes (3,), (3, 3),
            (6,), (6,), linear part first [m, s, rad].
        trunk_rotation, trunk_rate, trunk_acceleration: of the base [rad/s, rad/s²], shapes (3, 3),
            (3,), (3,).
        com, com_velocity, com_acceleration: of the centre of mass [m, m/s, m/s²], shapes (3,).
        raised: height of the standing sole's frame above where it is flat [m].
        turn: of the standing foot; None where it stands flat.
        turn_behind: of the other foot where that stands too; None where it is flat then.
        behind: wrench of the ground on the other foot, which stands too, shape (6,); None where
            that swings.
    """

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
    raised: float = 0.0
    turn: Turn | None = None
    behind: Array | None = None
    turn_behind: Turn | None = None


class Reference:
    """Tasks of the designed walk at equidistant instants, for each standing foot."""

    def __init__(self, robot: SimulatedRobot, trajectory: Trajectory) -> None:
        """Evaluate the walk every millisecond."""
        count = round(trajectory.step_duration / _INTERVAL) + 1
        self.duration, self.both = trajectory.step_duration, both_feet(trajectory)
        self.interval = self.duration / (count - 1)
        data = mujoco.MjData(robot.model)
        self.targets: list[list[Target]] = []
        self.room: list[Array] = []
        for foot in (0, 1):
            samples = step_samples(trajectory, foot, count)
            wrench = turned(samples.sole[..., :3, :3], samples.wrench)
            found, place = [], trajectory.advance(foot)
            phases = trajectory.phases
            if foot == 1 and trajectory.second is not None:
                phases = trajectory.second
            for k in range(count):
                state = (samples.configuration[k], samples.velocity[k], samples.acceleration[k])
                target = _target(robot, data, foot, *state, wrench[k, :, :3].sum(axis=0))
                behind = wrench[k, 1 - foot] if samples.contact[k, 1 - foot] else None
                time = k * self.interval - self.both
                time += self.duration if time < -_ROUNDING else 0.0
                turn, turn_behind = _turn(phases, int(samples.phase[k]), time), None
                if behind is not None:  # the phase is of the foot that stood before
                    turn, turn_behind = None, turn
                raised = float(samples.sole[k, foot, 2, 3] - place.translation[2])
                target = replace(target, raised=raised, turn=turn)
                found.append(replace(target, behind=behind, turn_behind=turn_behind))
            self.targets.append(found)
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

    def at(self, foot: int, time: float, descent: float) -> Target:
        """Return the tasks at a time since touch-down [s]; a sole that is late goes on down."""
        target = self.targets[foot][self.row(time)]
        late = time - self.duration
        if late <= 0.0:
            return target
        down = np.array([0.0, 0.0, min(target.sole_twist[2], -descent)])
        still = np.zeros(3)
        turn = target.turn
        return replace(
            target,
            dq=np.zeros_like(target.dq),
            ddq=np.zeros_like(target.ddq),
            sole=target.sole + late * down,
            sole_twist=np.concatenate([down, still]),
            sole_acceleration=np.zeros(6),
            trunk_rate=still,
            trunk_acceleration=still,
            com=target.com + late * target.com_velocity,
            com_acceleration=still,
            turn=None if turn is None else replace(turn, rate=0.0, acceleration=0.0),
        )


def _turn(phases: tuple[TrajectoryPhase, ...], phase: int, time: float) -> Turn | None:
    """Return how the standing foot turns at a time of the step [s], None where it does not."""
    part = phases[phase]
    if part.turning is None:
        return None
    begin = sum(before.duration for before in phases[:phase])
    inside = np.clip(time - begin, 0.0, part.duration)
    angle, rate, acceleration = part.turning.motion(np.array([inside]))[:, 0]
    linear, axis = part.turning.hinge[:3], part.turning.hinge[3:]
    # the twist is (point x axis, axis), the point nearest to the origin axis x linear
    point = np.cross(axis, linear)
    return Turn(point, axis, float(angle), float(rate), float(acceleration))


def _target(
    robot: SimulatedRobot,
    data: mujoco.MjData,
    foot: int,
    q: Array,
    v: Array,
    a: Array,
    force: Array,
) -> Target:
    """Return the tasks of a motion of `Multibody.model` and the ground's force in the world."""
    model = robot.model
    robot.place(data, q, v)
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_fwdVelocity(model, data)
    qacc = robot.acceleration(q, v, a)
    J, drift = sole_motion(robot, data, 1 - foot)
    standing, swinging = robot.site[foot], robot.site[1 - foot]
    trunk = data.xmat[robot.base].reshape(3, 3).copy()
    return Target(
        q=data.qpos[robot.qpos],
        dq=data.qvel[robot.dof],
        ddq=qacc[robot.dof],
        sole=data.site_xpos[swinging] - data.site_xpos[standing],
        sole_rotation=robot.sole_axes(data, 1 - foot).copy(),
        sole_twist=J @ data.qvel,
        sole_acceleration=J @ qacc + drift,
        trunk_rotation=trunk,
        trunk_rate=trunk @ data.qvel[3:6],
        trunk_acceleration=trunk @ qacc[3:6],
        com=data.subtree_com[robot.base] - data.site_xpos[standing],
        com_velocity=robot.mass_matrix(data)[:3] @ data.qvel / robot.mass,
        com_acceleration=force / robot.mass + robot.body.gravity,
    )


def sole_motion(robot: SimulatedRobot, data: mujoco.MjData, foot: int) -> tuple[Array, Array]:
    """Return the Jacobian of a sole frame (6, nv), linear rows first, and its drift (6,)."""
    model, site = robot.model, robot.site[foot]
    rate, body = np.zeros((6, model.nv)), model.site_bodyid[site]
    mujoco.mj_jacDot(model, data, rate[:3], rate[3:], data.site_xpos[site], body)
    return robot.sole_jacobian(data, foot), rate @ data.qvel
