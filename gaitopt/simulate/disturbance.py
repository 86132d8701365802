"""What disturbs a simulated walk without its controller being told."""

from __future__ import annotations

from collections import deque
from dataclasses import field, replace

import mujoco
import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.gait.trajectory import Trajectory
from gaitopt.nlp import Array
from gaitopt.settings import checked
from gaitopt.simulate.mujoco_model import SimulatedRobot

_UNITS = {
    "delay": " s", "duration": " s", "armature": " kg·m²", "angle": " rad", "rate": " rad/s",
    "attitude": " rad", "turning": " rad/s", "position": " m", "velocity": " m/s",
}  # fmt: skip


def _require(what: str, **values: float) -> None:
    """Refuse values that are not finite or below 0."""
    for name, value in values.items():
        if not 0.0 <= value < np.inf:
            unit = _UNITS.get(name, "")
            allowed = "must be 0 or more, and finite"
            raise InputError(f"the {name} of a {what} is {value:g}{unit}; it {allowed}")


@checked
@dataclass(frozen=True)
class Push:
    """A force on the pelvis, midway between the hips.

    Attributes:
        impulse: in the world [N·s].
        step: during which it begins, the first is 0.
        phase: share of that step's designed duration at which it begins.
        duration: of the force, which is constant [s].

    Raises:
        InputError: the impulse is not finite, or another value is below 0 or no share.
    """

    impulse: tuple[float, float, float]
    step: int = 4
    phase: float = 0.5
    duration: float = 0.05

    def __post_init__(self) -> None:
        _require("push", step=self.step, phase=self.phase, duration=self.duration)
        if not np.isfinite(self.impulse).all() or self.phase > 1.0:
            raise InputError(
                f"the impulse of a push is {self.impulse} N·s at {self.phase:g} of a step; give "
                "finite numbers, and a share of at most 1"
            )


@checked
@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of white noise, drawn anew at each tick.

    Attributes:
        angle, rate: of the joints [rad, rad/s].
        attitude, turning: of the base [rad, rad/s].
        position, velocity: of the base [m, m/s].

    Raises:
        InputError: one is below 0.
    """

    angle: float = 0.0005
    rate: float = 0.02
    attitude: float = 0.002
    turning: float = 0.02
    position: float = 0.001
    velocity: float = 0.02

    def __post_init__(self) -> None:
        _require("noise", **vars(self))


@checked
@dataclass(frozen=True)
class StartError:
    """Standard deviations of the joints at the start; the first sole stands where it should.

    Attributes:
        angle, rate: of each joint [rad, rad/s].

    Raises:
        InputError: one is below 0.
    """

    angle: float = 0.005
    rate: float = 0.05

    def __post_init__(self) -> None:
        _require("start", **vars(self))


@checked
@dataclass(frozen=True)
class Disturbance:
    """Everything that the controller is not told.

    Attributes:
        push: a push.
        mass: relative change of the masses and inertias of all bodies.
        ground: height of the ground under every second step [m].
        delay: between measuring and the torques that follow from it [s].
        armature: inertia added to every joint [kg·m²].
        contact_time: time constant of contacts, where the ground is another than the controller's
            [s]; None: that of the model.
        noise: of what is measured.
        start: of the joints.
        seed: of noise and start.

    Raises:
        InputError: a value has no meaning: no mass left, or below 0.
    """

    push: Push | None = None
    mass: float = 0.0
    ground: float = 0.0
    delay: float = 0.0
    armature: float = 0.0
    contact_time: float | None = None
    noise: SensorNoise | None = None
    start: StartError | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse what has no meaning."""
        if not (np.isfinite(self.mass) and self.mass > -1.0):
            raise InputError(f"the change of mass {self.mass:g} must be above -1 (no mass left)")
        _require("disturbance", delay=self.delay, armature=self.armature, seed=self.seed)
        if self.contact_time is not None and not 0.0 < self.contact_time < np.inf:
            raise InputError(f"the contact time {self.contact_time:g} s must be above 0")
        if not np.isfinite(self.ground):
            raise InputError(f"the height of the ground {self.ground:g} m must be finite")


NONE = Disturbance()


def disturbed_robot(robot: SimulatedRobot, disturbance: Disturbance) -> SimulatedRobot:
    """Return the robot that is simulated; its model is a copy where it differs."""
    if not (disturbance.mass or disturbance.armature or disturbance.contact_time):
        return robot
    model = robot.model.__copy__()
    model.body_mass[:] *= 1.0 + disturbance.mass
    model.body_inertia[:] *= 1.0 + disturbance.mass
    model.dof_armature[robot.dof] += disturbance.armature
    if disturbance.contact_time is not None:
        model.geom_solref[:, 0] = disturbance.contact_time
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return replace(robot, model=model)


def disturbed_start(
    robot: SimulatedRobot, trajectory: Trajectory, error: StartError, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return `qpos` and `qvel` with random errors of the joints, the first sole flat at rest."""
    start = trajectory.at(0.0)
    q, v = start.configuration[0], start.velocity[0]
    data = mujoco.MjData(robot.model)
    robot.place(data, q, v)
    data.qpos[robot.qpos] += rng.normal(0.0, error.angle, len(robot.qpos))
    data.qvel[robot.dof] += rng.normal(0.0, error.rate, len(robot.dof))
    robot.follow(data.qpos, data.qvel)
    stand(robot, data, 0, trajectory.advance(0))
    return data.qpos.copy(), data.qvel.copy()


def stand(robot: SimulatedRobot, data: mujoco.MjData, foot: int, place: pin.SE3) -> None:
    """Move the base so that a sole is at a place, at rest; joints and their rates stay."""
    mujoco.mj_kinematics(robot.model, data)
    base = pin.SE3(data.xmat[robot.base].reshape(3, 3).copy(), data.xpos[robot.base].copy())
    x = pin.SE3ToXYZQUAT(place * robot.sole(data, foot).inverse() * base)
    data.qpos[:3], data.qpos[3], data.qpos[4:7] = x[:3], x[6], x[3:6]
    mujoco.mj_fwdPosition(robot.model, data)
    J = robot.sole_jacobian(data, foot)
    data.qvel[:6] = np.linalg.solve(J[:, :6], -J[:, 6:] @ data.qvel[6:])


@dataclass(eq=False)
class Delay:
    """Torques on their way to the motors; before the first arrives, it is applied at once.

    Attributes:
        delay: [s].
    """

    delay: float
    _waiting: deque[tuple[float, Array]] = field(default_factory=deque)

    def send(self, time: float, torque: Array) -> None:
        """Send torques (n,) at a time [s]."""
        self._waiting.append((time, torque))

    def arrived(self, time: float) -> Array:
        """Return the torques (n,) [N·m] that act at a time [s]."""
        while len(self._waiting) > 1 and self._waiting[1][0] + self.delay <= time + 1e-9:
            self._waiting.popleft()
        return self._waiting[0][1]


def measured(
    robot: SimulatedRobot,
    data: mujoco.MjData,
    noise: SensorNoise | None,
    rng: np.random.Generator,
) -> tuple[Array, Array]:
    """Return `qpos` and `qvel` as sensors see them."""
    qpos, qvel = data.qpos.copy(), data.qvel.copy()
    if noise is None:
        return qpos, qvel
    qpos[robot.qpos] += rng.normal(0.0, noise.angle, len(robot.qpos))
    qvel[robot.dof] += rng.normal(0.0, noise.rate, len(robot.dof))
    robot.follow(qpos, qvel)
    qpos[:3] += rng.normal(0.0, noise.position, 3)
    qvel[:3] += rng.normal(0.0, noise.velocity, 3)
    mujoco.mju_quatIntegrate(qpos[3:7], rng.normal(0.0, noise.attitude, 3), 1.0)
    qvel[3:6] += rng.normal(0.0, noise.turning, 3)
    return qpos, qvel


def pelvis(robot: SimulatedRobot, data: mujoco.MjData) -> Array:
    """Return the point midway between the hips in the world [m], shape (3,)."""
    body = robot.body
    hips = [int(body.leg(foot)[-1]) for foot in (0, 1)]
    names = [f"body {body.joint_names[joint]}" for joint in hips]
    return np.asarray(np.mean([data.xpos[robot.model.body(name).id] for name in names], axis=0))
