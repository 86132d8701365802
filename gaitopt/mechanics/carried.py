"""Weight that is carried from outside (MuJoCo's `gravcomp`): point masses that hang on nothing.

A point mass m at p is held by a force -m g from outside, which the ground and the motors need not
give. With a_0 = -g the wrench that holds all points beyond joint j is

    W_j = sum_{b >= j} P_b a_0        of P_b, the spatial inertia of body b's points,

and the effort is that of the whole robot less [W_0; S_j . W_j]: two inverse dynamics, the second
of the points alone at rest. Turning joint k moves what lies beyond it, so that

    dW_j / dq_k = G_max(j, k)         G_k = S_k x* W_k - P_k^c (S_k x a_0)

and the derivative of S_j . W_j is S_min . G_max, symmetric as the curvature of a potential is.
"""

from __future__ import annotations

import numpy as np

from gaitopt.mechanics.bodies import Bodies
from gaitopt.mechanics.curvature import WeightedDynamics, torque_curvature
from gaitopt.mechanics.spatial import apply, moved, pushed, skew
from gaitopt.nlp import Array
from gaitopt.robot.model import Robot
from gaitopt.robot.reroot import joint_axis


class Carried:
    """The weight of one robot that is carried from outside."""

    def __init__(self, robot: Robot) -> None:
        """Prepare what does not depend on the posture.

        Args:
            robot: with `physics.carried`.
        """
        weight = robot.physics.carried
        if weight is None:
            raise ValueError("the robot has no weight that is carried from outside")
        model = robot.model
        self._bodies = Bodies(model)
        self._axes = np.stack([joint_axis(model, j) for j in range(2, model.njoints)])
        self._mass, self._moment = weight.mass, weight.moment
        self._start = np.concatenate([-model.gravity.linear, np.zeros(3)])

    def effort(self, q: Array) -> Array:
        """Return the part of wrench and torques that is not needed, shape (N, 18).

        Args:
            q: postures, shape (N, 12) [rad].
        """
        axes, inertias = self._placed(q)
        return _effort(axes, self._wrenches(inertias))

    def slope(self, q: Array) -> tuple[Array, Array]:
        """Return the effort (N, 18) and its derivative in the posture (N, 18, 12)."""
        axes, inertias = self._placed(q)
        wrenches = self._wrenches(inertias)
        composite = _beyond(inertias)[:, 1:]
        fallen = moved(axes, np.broadcast_to(self._start, axes.shape))
        G = pushed(axes, wrenches[:, 1:]) - apply(composite, fallen)
        slope = np.empty((len(q), 18, 12))
        slope[:, :6] = G.swapaxes(1, 2)
        upper = np.triu(axes @ G.swapaxes(1, 2))  # S_j . G_k for k >= j
        slope[:, 6:] = upper + np.triu(upper, 1).swapaxes(1, 2)
        return _effort(axes, wrenches), slope

    def curvature(self, q: Array, weights: Array) -> Array:
        """Return the second derivative of sum(weights * effort) in the posture, (N, 12, 12).

        Args:
            q: postures, shape (N, 12) [rad].
            weights: of the effort, shape (N, 18).
        """
        axes, inertias = self._placed(q)
        rest = np.zeros(q.shape)
        base = np.broadcast_to(self._start, (len(q), 6))
        at = WeightedDynamics(axes, q, rest, rest, base, weights)
        return torque_curvature(inertias[:, 1:], at).qq

    def _placed(self, q: Array) -> tuple[Array, Array]:
        """Joint axes S_j (N, 12, 6) and the points' spatial inertias P_b (N, 13, 6, 6).

        Their rotational blocks are left 0: nothing here turns.
        """
        at = self._bodies.placed(q)
        direction = apply(at.rotation[:, 1:], self._axes)
        axes = np.concatenate([np.cross(at.origin[:, 1:], direction), direction], axis=2)
        moment = apply(at.rotation, self._moment) + self._mass[:, None] * at.origin
        inertias = np.zeros((len(q), 13, 6, 6))
        inertias[..., :3, :3] = self._mass[:, None, None] * np.eye(3)
        inertias[..., 3:, :3] = skew(moment)
        inertias[..., :3, 3:] = -inertias[..., 3:, :3]
        return axes, inertias

    def _wrenches(self, inertias: Array) -> Array:
        """W_0 and W_j, shape (N, 13, 6)."""
        return _beyond(inertias @ self._start)


def _effort(axes: Array, wrenches: Array) -> Array:
    torque = np.einsum("nji,nji->nj", axes, wrenches[:, 1:])
    return np.concatenate([wrenches[:, 0], torque], axis=1)


def _beyond(per_body: Array) -> Array:
    """Sum over the bodies from each one to the end of the chain."""
    return np.flip(np.cumsum(np.flip(per_body, axis=1), axis=1), axis=1)
