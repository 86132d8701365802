"""Random motions of the biped with bent knees, and Pinocchio's word on them."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.model.robot import Robot


def bent_posture(robot: Robot, rng: np.random.Generator) -> np.ndarray:
    """Joint angles (n,) of a biped in a walk: knees bent, trunk and swing foot near level."""
    q = rng.uniform(-0.25, 0.25, robot.tree.size)
    legs = robot.legs
    for side, knee in zip(("right", "left"), legs.knees, strict=True):
        hip, ankle = (robot.joint_names.index(f"{side}_{n}_pitch") for n in ("hip", "ankle"))
        q[knee] = rng.uniform(0.3, 1.1)
        q[hip] = rng.uniform(-0.5, 0.2) - q[knee] / 2.0
        q[ankle] += -q[hip] - q[knee]
    return q


def random_motion(
    robot: Robot, rng: np.random.Generator, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, dq, ddq of `count` unrelated instants, shape (count, n) each."""
    q = np.array([bent_posture(robot, rng) for _ in range(count)])
    return q, rng.normal(0.0, 2.0, q.shape), rng.normal(0.0, 20.0, q.shape)


def full_configuration(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Configuration (19,) with the stance sole at the world's origin."""
    full = pin.neutral(robot.model)
    full[7:] = q
    return full


@dataclass(frozen=True)
class Kinematics:
    """Pinocchio's word on one instant; arrays are copies, for its own die with the Data.

    Attributes:
        data: with placements, velocities and accelerations.
        axes: joint motion axes in the world, shape (12, 6).
        com, com_acceleration: of the centre of mass, shape (3,).
    """

    data: pin.Data
    axes: np.ndarray
    com: np.ndarray
    com_acceleration: np.ndarray

    def frame(self, index: int) -> pin.SE3:
        """Placement of a frame."""
        return self.data.oMf[index].copy()


def kinematics(
    robot: Robot,
    q: np.ndarray,
    velocity: np.ndarray | None = None,
    acceleration: np.ndarray | None = None,
) -> Kinematics:
    """Kinematics at joint angles q (12,), velocity and acceleration (18,), by default at rest."""
    model, data = robot.model, robot.model.createData()
    v = np.zeros(18) if velocity is None else velocity
    a = np.zeros(18) if acceleration is None else acceleration
    full = full_configuration(robot, q)
    axes = pin.computeJointJacobians(model, data, full)[:, 6:].T.copy()
    pin.forwardKinematics(model, data, full, v, a)
    pin.updateFramePlacements(model, data)
    pin.centerOfMass(model, data, full, v, a)
    return Kinematics(data, axes, data.com[0].copy(), data.acom[0].copy())


def moving(rate: np.ndarray) -> np.ndarray:
    """Velocity (18,) of joint rates (12,) with the stance foot at rest."""
    return np.concatenate([np.zeros(6), rate])
