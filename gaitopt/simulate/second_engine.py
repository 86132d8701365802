"""A second engine signs: MuJoCo's inverse dynamics along a gait against the gait's own numbers."""

from __future__ import annotations

import mujoco
import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.gait.result import Gait
from gaitopt.gait.trajectory import MIRRORED_WRENCH, Trajectory
from gaitopt.mechanics.single_support import passive_torque
from gaitopt.mechanics.spatial import turned
from gaitopt.model.chain_physics import PassiveJoints
from gaitopt.nlp import Array
from gaitopt.simulate.mujoco_model import SimulatedRobot, simulated_robot

INSTANTS = 601
"""Of the step at which both engines are compared: 20 in each of the 30 intervals of a default."""
AGREED = 1e-9
"""Relative difference up to which both engines say the same."""
_SLIGHT = 0.01  # of the largest momentum: impulses of a foot set down softly are nearly none


@dataclass(frozen=True)
class SecondEngine:
    """Largest differences of MuJoCo from a gait, each relative to the largest of its kind.

    An impulse is compared with a hundredth of the robot's largest momentum where it is less.

    Attributes:
        engine: name and version.
        instants: number of them.
        torque, force, moment: relative, of the motors, and of the ground on the standing foot.
        rate_after, impulse: relative, joint rates after the impact, and the impulse of the ground.
    """

    engine: str
    instants: int
    torque: float
    force: float
    moment: float
    rate_after: float
    impulse: float

    @property
    def largest(self) -> float:
        """The largest of all differences."""
        return max(self.torque, self.force, self.moment, self.rate_after, self.impulse)

    @property
    def agrees(self) -> bool:
        """Whether both engines say the same."""
        return self.largest <= AGREED

    def __str__(self) -> str:
        """Return it as a sentence."""
        verdict = "agrees" if self.agrees else f"DIFFERS (more than {AGREED:g})"
        return (
            f"{self.engine} {verdict} at {self.instants} instants: torque {self.torque:.0e}, "
            f"force {self.force:.0e}, moment {self.moment:.0e}, impact {self.rate_after:.0e} and "
            f"{self.impulse:.0e}"
        )


def second_engine(gait: Gait, instants: int = INSTANTS) -> SecondEngine:
    """Compute torques, ground wrench and impact of a gait again, with `mj_inverse`.

    Motion comes from the splines of the gait, the robot from its `Multibody`; of a stride both
    steps are computed.

    Raises:
        InputError: the robot cannot be simulated.
        RobotError: the gait has no robot of its own, and its URDF is not its robot.
    """
    found = [_step(gait, number, instants) for number in range(len(gait.steps))]
    return SecondEngine(
        engine=f"MuJoCo {mujoco.__version__}",
        instants=len(found) * instants,
        **{name: max(one[name] for one in found) for name in found[0]},
    )


def _step(gait: Gait, number: int, instants: int) -> dict[str, float]:
    """Return the largest differences in a step of a gait, 0 or 1."""
    trajectory, own = gait.trajectory, gait.steps[number]
    E = gait.mirror if number == 1 else np.eye(len(gait.mirror))
    robot = simulated_robot(trajectory.body)
    robot.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    data = mujoco.MjData(robot.model)
    times = np.linspace(0.0, trajectory.step_duration, instants)
    samples = trajectory.at(times + number * trajectory.step_duration, before=times > 0.0)
    friction = _coulomb_friction(trajectory, samples.q, samples.dq)
    torque, wrench = np.empty((instants, len(robot.dof))), np.empty((instants, 6))
    for row in range(instants):
        q, v = samples.configuration[row], samples.velocity[row]
        robot.place(data, q, v)
        data.qacc[:] = robot.acceleration(q, v, samples.acceleration[row])
        mujoco.mj_inverse(robot.model, data)
        foot = int(samples.standing[row])
        J, needed = robot.sole_jacobian(data, foot), data.qfrc_inverse
        if samples.contact[row, 1 - foot]:  # how both share the load is the gait's choice
            pushed = turned(robot.sole_axes(data, 1 - foot), samples.wrench[row, 1 - foot])
            needed = needed - robot.sole_jacobian(data, 1 - foot).T @ pushed
        ground = np.linalg.solve(J[:, :6].T, needed[:6])
        torque[row] = (needed - J.T @ ground) @ robot.free(data.qpos)[:, 6:]
        wrench[row] = _in_sole(robot, data, foot, ground)
    stated = samples.torque[:, trajectory.body.moving] - friction
    on_foot = samples.wrench[np.arange(instants), samples.standing]
    begin = number * trajectory.step_duration
    sides = MIRRORED_WRENCH if number == 1 else np.ones(6)
    stated_impulse, after = own.impulse * sides, E @ own.rate_after
    if gait.striking:
        touch = begin + float(own.knots[-1])
        rate_after, impulse = _impact_inside(robot, data, trajectory, touch, True)
        stated_impulse = np.concatenate([stated_impulse, own.rear_impulse * sides])
    else:
        rate_after, impulse = engine_impact(robot, data, 1 - number, gait)
    if gait.slapping:
        flat = _impact_inside(robot, data, trajectory, begin + own.flat_from, False)
        rate_after, impulse = (
            np.concatenate(p) for p in zip((rate_after, impulse), flat, strict=True)
        )
        stated_impulse = np.concatenate([stated_impulse, own.rear_impulse * sides])
        after = np.concatenate([after, E @ own.flat_rates[1]])
    pace = float(np.linalg.norm(samples.base_twist[:, :3], axis=1).max())
    return {
        "torque": _difference(torque, stated),
        "force": _difference(wrench[:, :3], on_foot[:, :3]),
        "moment": _difference(wrench[:, 3:], on_foot[:, 3:]),
        "rate_after": _difference(rate_after, after),
        "impulse": _difference(impulse, stated_impulse, _SLIGHT * robot.mass * pace),
    }


def engine_impact(
    robot: SimulatedRobot, data: mujoco.MjData, foot: int, gait: Gait
) -> tuple[Array, Array]:
    """Return the rates (n,) after a sole stops at once, and the impulse (6,), in its footprint.

    Where the gait lands on a line of the sole, only what the line holds stops.
    """
    J, flat = robot.sole_jacobian(data, foot), np.eye(6)
    if gait.lands_on_line:
        twist = gait.landing_hinge
        across = np.linalg.qr(twist[:, None], mode="complete")[0][:, 1:]
        J = across.T @ _in_sole(robot, data, foot, J.T).T
        landed = gait.steps[foot % len(gait.steps)]  # the step that stands on that foot
        flat = pin.exp6(landed.landing_angle * twist).toDualActionMatrix() @ across
    after, impulse = _stopped(robot, data, J)
    found = flat @ impulse if gait.lands_on_line else _in_sole(robot, data, foot, impulse)
    return after, np.asarray(found)


def _impact_inside(
    robot: SimulatedRobot, data: mujoco.MjData, trajectory: Trajectory, time: float, front: bool
) -> tuple[Array, Array]:
    """Return the motors' rates after an impact inside a step, and the impulse on each foot.

    Args:
        time: of the impact [s].
        front: whether it stops both feet, or the standing one alone.

    Returns:
        The rates, and impulses in the sole frames, the front foot's first.
    """
    before = trajectory.at([time], before=True)
    q, v = before.configuration[0], before.velocity[0]
    robot.place(data, q, v)
    mujoco.mj_forward(robot.model, data)
    standing = int(before.standing[0])
    feet = (1 - standing, standing) if front else (standing,)
    J = np.concatenate([robot.sole_jacobian(data, foot) for foot in feet])
    after, impulse = _stopped(robot, data, J)
    each = zip(feet, np.split(impulse, len(feet)), strict=True)
    return after, np.concatenate([_in_sole(robot, data, foot, push) for foot, push in each])


def _stopped(robot: SimulatedRobot, data: mujoco.MjData, J: Array) -> tuple[Array, Array]:
    """Return the motors' rates (n,) after what J (k, nv) sees stops, and the impulse (k,)."""
    free = robot.free(data.qpos)
    J = J @ free
    by_impulse = np.linalg.solve(free.T @ robot.mass_matrix(data) @ free, J.T)
    before = np.concatenate([data.qvel[:6], data.qvel[robot.dof]])
    impulse = np.linalg.solve(J @ by_impulse, -J @ before)
    return (before + by_impulse @ impulse)[6:], impulse


def _in_sole(robot: SimulatedRobot, data: mujoco.MjData, foot: int, wrench: Array) -> Array:
    return turned(robot.sole_axes(data, foot).T, wrench)


def _coulomb_friction(trajectory: Trajectory, q: Array, dq: Array) -> Array:
    """Return the part of the motors' torques against dry friction, shape (N, n)."""
    # MuJoCo makes a constraint of it, which inverse dynamics without contacts does not have.
    body = trajectory.body
    none = np.zeros((len(body.joint_names), 1))
    joints = PassiveJoints(none, body.friction, none, body.rest)
    return body.by_motors(passive_torque(joints, q, dq).value, q)[:, body.moving]


def _difference(found: Array, stated: Array, least: float = 0.0) -> float:
    largest = max(float(np.abs(stated).max()), least)
    return float(np.abs(found - stated).max()) / (largest or 1.0)
