"""What joints do by themselves: damping, Coulomb friction and springs (docs/physics.md).

The motor delivers the torque of the rigid bodies plus

    sum_k d_k |dq|^(k-1) dq + F tanh(dq / epsilon) + sum_k c_k (q - r)^k

with the powers that MuJoCo 4 gives to damping (odd) and to springs (plain).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitopt.nlp import Array
from gaitopt.robot.chain_physics import PassiveJoints

FRICTION_RATE = 0.1
"""epsilon: rate in which Coulomb friction turns round, so that it has derivatives [rad/s].

A joint at 0.1 rad/s has 76 % of it, at 0.3 rad/s 99.5 %; a walk's joints turn at 1 to 10 rad/s.
How little the optimum depends on it: docs/physics.md."""


@dataclass(frozen=True)
class PassiveTorque:
    """The torque at N instants and its derivatives; each joint's depends on its own motion alone.

    Attributes:
        value: shape (N, 12) [N·m].
        by_angle, by_rate: first derivatives, shape (N, 12) each.
        by_angle_twice, by_rate_twice: second derivatives, shape (N, 12) each.
    """

    value: Array
    by_angle: Array
    by_rate: Array
    by_angle_twice: Array
    by_rate_twice: Array


def passive_torque(joints: PassiveJoints, q: Array, dq: Array) -> PassiveTorque:
    """Return the torque that the motors deliver for the joints themselves.

    Args:
        joints: what they do.
        q, dq: angles and rates, shape (N, 12) each [rad, rad/s].
    """
    spring, by_angle, by_angle_twice = polynomial(joints.stiffness, q - joints.rest)
    damping, by_rate, by_rate_twice = odd_polynomial(joints.damping, dq)
    turned = np.tanh(dq / FRICTION_RATE)
    slope = joints.friction / FRICTION_RATE * (1.0 - turned**2)
    return PassiveTorque(
        value=spring + damping + joints.friction * turned,
        by_angle=by_angle,
        by_rate=by_rate + slope,
        by_angle_twice=by_angle_twice,
        by_rate_twice=by_rate_twice - 2.0 / FRICTION_RATE * turned * slope,
    )


def polynomial(coefficients: Array, x: Array) -> tuple[Array, Array, Array]:
    """Return sum_k c_k x^k and its first and second derivatives, shape (N, n) each.

    Args:
        coefficients: c_1, c_2, ..., shape (n, K).
        x: shape (N, n).
    """
    value, first, second = (np.zeros(x.shape) for _ in range(3))
    for c in coefficients.T[::-1]:  # Horner's rule for p, p' and p'' / 2 of p = c_1 + c_2 x + ...
        second = second * x + first
        first = first * x + value
        value = value * x + c
    return value * x, value + first * x, 2.0 * (first + second * x)


def odd_polynomial(coefficients: Array, x: Array) -> tuple[Array, Array, Array]:
    """Return sum_k c_k |x|^(k-1) x and its first and second derivatives, shape (N, n) each.

    The second derivative of |x| x jumps at 0, where the mean of both sides is returned.

    Args:
        coefficients: c_1, c_2, ..., shape (n, K).
        x: shape (N, n).
    """
    sign = np.sign(x)
    value, first, second = polynomial(coefficients, np.abs(x))
    return sign * value, first, sign * second
