"""The impact after which both feet stay on the ground, the second outcome of section 2.4.1.

The swing foot lands flat and the rear foot stays flat. No joint gives an impulse, so that with F
the impulse of the ground on the landing foot, in the world, and D the inertia matrix, whose rows
and columns of the joints are M,

    M (dq+ - dq-) = S . F,       I_rear = D_0 (dq+ - dq-) - F

and the rates after it close the chain of both legs (`mechanics/closed_chain.py`). Given F nothing
is left to be solved for but the jump: F is a parameter, and the rates before follow from those
after. Derivatives are those of an inverse dynamics without gravity and rates, whose acceleration is
the jump, less what F does (docs/derivations.md).
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.mechanics.forward_kinematics import body_inertias
from gaitopt.mechanics.inverse_dynamics_hessian import (
    InverseDynamicsHessian,
    WeightedDynamics,
    inverse_dynamics_hessian,
)
from gaitopt.mechanics.spatial import solve
from gaitopt.model.joint_tree import TWIST
from gaitopt.model.robot import Robot, cached_workspace
from gaitopt.nlp import Array


@dataclass(frozen=True)
class ClosedJump:
    """What an impact does to the robot, and the local derivatives of its inverse dynamics.

    Attributes:
        posture: angles at the impact, shape (n,).
        jump: of the rates, dq+ - dq-, shape (n,).
        rear: impulse of the ground on the rear foot, in its sole frame, shape (6,).
        axes: of the joints in the world, shape (n, 6).
        of_posture: derivative of D (dq+ - dq-) in the posture, shape (6 + n, n).
        inertia: columns of the joints of D [kg, kg·m, kg·m²], shape (6 + n, n).
    """

    posture: Array
    jump: Array
    rear: Array
    axes: Array
    of_posture: Array
    inertia: Array

    def along(self, posture: Array, taken: Array) -> tuple[Array, Array]:
        """Return derivatives of the jump (n, P) and of the rear impulse (6, P).

        Args:
            posture: derivatives of the angles, shape (n, P).
            taken: of the impulse on the front foot, in the world, and of its moments about the
                joints, at fixed and moving axes, shape (6 + n, P).
        """
        moved = self.of_posture @ posture
        jump = solve(self.inertia[TWIST:], taken[TWIST:] - moved[TWIST:])
        return jump, moved[:TWIST] + self.inertia[:TWIST] @ jump - taken[:TWIST]

    def adjoint(self, jump: Array, rear: Array) -> Array:
        """Return e of e . (D jump - [F; S . F]), which has the derivatives of a weighted sum.

        Args:
            jump: weights of the jump, shape (n,).
            rear: weights of the rear impulse, shape (6,).

        Returns:
            Shape (6 + n,).
        """
        back = solve(self.inertia[TWIST:].T, jump + self.inertia[:TWIST].T @ rear)
        return np.concatenate([rear, -back])


class ClosedImpact:
    """Evaluates the impact of one robot."""

    def __init__(self, robot: Robot) -> None:
        self._model = robot.model.copy()
        self._model.gravity = pin.Motion.Zero()
        self._data = self._model.createData()
        self._q, self._v = pin.neutral(self._model), np.zeros(self._model.nv)
        self._tree = robot.tree
        self._bodies = cached_workspace(robot, body_inertias)

    def at(self, posture: Array, axes: Array, force: Array) -> ClosedJump:
        """Return what the impact does.

        Args:
            posture: angles, shape (n,).
            axes: of the joints in the world, shape (n, 6).
            force: impulse of the ground on the front foot, in the stance sole frame, shape (6,)
                [N·s, N·m·s].
        """
        self._q[TWIST + 1 :] = posture
        model, data = self._model, self._data
        D = np.array(pin.crba(model, data, self._q))
        jump = solve(D[TWIST:, TWIST:], axes @ force)
        acceleration = np.concatenate([np.zeros(TWIST), jump])
        pin.computeRNEADerivatives(model, data, self._q, self._v, acceleration)
        rear = D[:TWIST, TWIST:] @ jump - force
        return ClosedJump(
            posture, jump, rear, axes, data.dtau_dq[:, TWIST:].copy(), D[:, TWIST:].copy()
        )

    def hessian(self, at: ClosedJump, weights: Array) -> InverseDynamicsHessian:
        """Return the second derivatives of weights . D jump, weights (6 + n,)."""
        still = np.zeros((1, len(at.posture)))
        dynamics = WeightedDynamics(
            at.axes[None], at.posture[None], still, at.jump[None], np.zeros((1, TWIST)),
            weights[None],
        )  # fmt: skip
        inertias = self._bodies.in_world(dynamics.posture)
        return inverse_dynamics_hessian(inertias, dynamics, self._tree)
