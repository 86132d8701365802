"""The in-house Newton-Euler algorithm judges a step that Pinocchio evaluated.

Another implementation, another geometry (modified Denavit-Hartenberg), and conservation laws that
neither was built from.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitopt.gait.grid import Grid
from gaitopt.gait.step import Reads, Step
from gaitopt.mechanics.chain import Chain, sole_placement
from gaitopt.mechanics.chain_build import chain_of_robot
from gaitopt.mechanics.chain_impact import (
    at_rest,
    base_in_sole_axes,
    impact,
    impulse_on_foot,
)
from gaitopt.mechanics.newton_euler import ground_wrench, inverse_dynamics, momentum
from gaitopt.nlp import Array
from gaitopt.robot.model import Robot


@dataclass(frozen=True)
class Verdict:
    """Disagreements; relative ones to the largest entry of what is compared.

    Attributes:
        torque, wrench: inverse dynamics at every instant, relative.
        impulse, rate_after: impact, relative.
        sole_twist: twist of the old stance foot after the impact [m/s, rad/s].
        posture: q(0) and E q(T), Eq. (26) [rad].
        rate: dq(0) and E times the rates after impact, Eq. (27), relative.
        momentum: ground force over the step plus impact impulse against the weight's impulse
            m g T and the change of the robot's momentum, largest component over m g T.
        vertical: integral of the vertical ground force plus the vertical impulse [N·s].
        weight: m g T [N·s].
    """

    torque: float
    wrench: float
    impulse: float
    rate_after: float
    sole_twist: float
    posture: float
    rate: float
    momentum: float
    vertical: float
    weight: float

    @property
    def worst(self) -> float:
        """Largest disagreement, the momentum balance apart (it carries a quadrature error)."""
        return max(
            self.torque, self.wrench, self.impulse, self.rate_after, self.sole_twist,
            self.posture, self.rate,
        )  # fmt: skip


def judge(robot: Robot, step: Step, grid: Grid) -> Verdict:
    """Compare a step with the referee's own computation.

    Args:
        robot: the robot.
        step: a step evaluated on `grid`.
        grid: fine enough for the momentum balance; all its instants are quadrature nodes.
    """
    chain = chain_of_robot(robot)
    gravity = float(np.linalg.norm(robot.model.gravity.linear))
    q, dq, ddq = step.motion
    _, torque = inverse_dynamics(chain, q, dq, ddq, gravity=gravity)
    wrench = ground_wrench(chain, q, dq, ddq, gravity=gravity)
    velocity, I13 = impact(chain, step.q_end, at_rest(chain, step.rate_before))
    impulse = impulse_on_foot(chain, I13)
    twist = base_in_sole_axes(velocity)[:6]
    E = robot.mirror
    balance, vertical, weight = _momentum_balance(chain, step, grid, wrench, impulse, gravity)
    return Verdict(
        torque=_apart(step.read(Reads.TORQUE), torque),
        wrench=_apart(step.read(Reads.WRENCH), wrench),
        impulse=_apart(step.impact.impulse, impulse),
        rate_after=_apart(step.impact.rate_after, velocity[6:]),
        sole_twist=float(np.abs(step.impact.sole_twist - twist).max()),
        posture=float(np.abs(q[0] - E @ step.q_end).max()),
        rate=_apart(dq[0], E @ velocity[6:]),
        momentum=balance,
        vertical=vertical,
        weight=weight,
    )


def _momentum_balance(
    chain: Chain, step: Step, grid: Grid, wrench: Array, impulse: Array, gravity: float
) -> tuple[float, float, float]:
    """Over a step the ground's impulse is the weight's plus the change of momentum.

    From just after one impact to just after the next; there the robot is its own mirror image,
    seen from the foot that has landed.
    """
    weight = chain.mass * gravity * step.duration
    force = step.duration * grid.weights @ wrench[:, :3]
    landed, _ = sole_placement(chain, step.q_end)
    push = landed @ impulse[:3]
    start = momentum(chain, step.motion[0, 0], step.motion[1, 0])[:3]
    change = landed @ (np.array([1.0, -1.0, 1.0]) * start) - start
    gap = force + push - np.array([0.0, 0.0, weight]) - change
    return float(np.abs(gap).max() / weight), float(force[2] + push[2]), weight


def _apart(a: Array, b: Array) -> float:
    return float(np.abs(a - b).max() / np.abs(b).max())
