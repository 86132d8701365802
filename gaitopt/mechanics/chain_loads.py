"""What acts on a chain beside its rigid bodies, for the referee: from the definitions, on its own.

The production code has the same in `passive` and `carried`, by other formulas.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from gaitopt.mechanics.chain import Chain, LinkTable, joint_values
from gaitopt.mechanics.newton_euler import GRAVITY, inverse_dynamics
from gaitopt.nlp import Array

FRICTION_RATE = 0.1
"""Rate in which Coulomb friction turns round [rad/s]; the referee has its own, as for gravity."""


@dataclass(frozen=True)
class Loads:
    """Passive joints, in the sign of the robot's joints, and weight carried from outside.

    Attributes:
        damping: coefficients of |rate|^(k-1) rate, k = 1, 2, ..., shape (n, K).
        stiffness: coefficients of (angle - rest)^k, shape (n, K).
        friction: Coulomb friction, shape (n,) [N·m].
        rest: of the springs, shape (n,) [rad].
        points: the points that are carried, as links of a chain of their own; None for none.
    """

    damping: Array
    stiffness: Array
    friction: Array
    rest: Array
    points: LinkTable | None


def motor_effort(
    chain: Chain,
    loads: Loads,
    q: ArrayLike,
    dq: ArrayLike,
    ddq: ArrayLike,
    *,
    gravity: ArrayLike = GRAVITY,
) -> tuple[Array, Array]:
    """Return what ground and motors give: `inverse_dynamics`, and the loads.

    Args:
        chain: the chain.
        loads: what acts on it beside.
        q, dq, ddq: as for `inverse_dynamics`.
        gravity: g, along -x0, or a vector in R0, shape (3,) [m/s²].

    Returns:
        R0, shape (..., 6), in R0, and the torques of the motors, shape (..., n).

    Raises:
        InputError: an argument has the wrong shape or is not finite.
    """
    R0, torque = inverse_dynamics(chain, q, dq, ddq, gravity=gravity)
    angle, rate = joint_values(chain, "q", q), joint_values(chain, "dq", dq)
    torque = torque + np.sign(rate) * _powers(loads.damping, np.abs(rate))
    torque = torque + _powers(loads.stiffness, angle - loads.rest)
    torque = torque + loads.friction * _turned(rate / FRICTION_RATE)
    if loads.points is not None:
        hung = replace(chain, links=loads.points, armature=np.zeros(chain.dof))
        still = np.zeros(chain.dof)
        unneeded, unneeded_torque = inverse_dynamics(hung, q, still, still, gravity=gravity)
        R0, torque = R0 - unneeded, torque - unneeded_torque
    return R0, torque


def _powers(coefficients: Array, x: Array) -> Array:
    """Sum of c_k x^k."""
    powers = x[..., None] ** np.arange(1, coefficients.shape[1] + 1)
    return np.asarray((coefficients * powers).sum(axis=-1))


def _turned(x: Array) -> Array:
    """The smooth sign (1 - exp(-2 x)) / (1 + exp(-2 x)), from the side that does not overflow."""
    fading = np.exp(-2.0 * np.abs(x))
    return np.asarray(np.sign(x) * (1.0 - fading) / (1.0 + fading))
