"""The impact by which a foot that turned about a line of its sole comes to lie flat on the ground.

The foot turns about its hinge, of unit twist t in the sole frame, at a rate w, the other one
swings; then the whole sole meets the ground and stays on it. The ground acts on that foot alone and
no joint gives an impulse, so that with D the inertia matrix, whose rows and columns of the joints
are M,

    D [ -w t; dq+ - dq- ] = [ I; 0 ]

an inverse dynamics without gravity and rates, whose acceleration is the jump: M (dq+ - dq-) =
w D_joints,base t, and I, the impulse on the foot, is what its base takes. Of the two outcomes of
section 2.4.1 it is the one in which all that meets the ground stays on it, and possible where I can
be: it pushes, within its friction cone, through a point of the sole. Derivatives are those of the
inverse dynamics (docs/derivations.md, 5.6).
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.contact.mode import Hinge
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.mechanics.forward_kinematics import body_inertias
from gaitopt.mechanics.inverse_dynamics_hessian import WeightedDynamics, inverse_dynamics_hessian
from gaitopt.mechanics.spatial import solve
from gaitopt.model.joint_tree import TWIST
from gaitopt.model.robot import Robot, cached_workspace
from gaitopt.nlp import Array


@dataclass(frozen=True)
class FlatJump:
    """What the impact does to the robot.

    Attributes:
        posture: joint angles at it, shape (n,).
        rate: w [rad/s].
        jump: of the joint rates, dq+ - dq-, shape (n,).
        impulse: I, of the ground on the foot, in its sole frame [N·s, N·m·s], shape (6,).
        along: derivatives of (jump, impulse) in (posture, w), shape (n + 6, n + 1).
        inertia: D [kg, kg·m, kg·m²], shape (6 + n, 6 + n).
    """

    posture: Array
    rate: float
    jump: Array
    impulse: Array
    along: Array
    inertia: Array


class FlatImpact:
    """Evaluates the impact of one robot whose stance foot has turned about a hinge."""

    def __init__(self, robot: Robot, hinge: Hinge) -> None:
        """Prepare what does not depend on the posture.

        Args:
            robot: rooted at its stance sole.
            hinge: line about which that has turned.

        Raises:
            InputError: joints of the robot follow others.
        """
        if not robot.coupling.none:
            raise InputError(
                "foot_flat 'impact' is for robots all of whose joints have motors of their own; "
                "joints of this robot follow others: take foot_flat 'gentle' (--foot-flat gentle)"
            )
        self._twist = hinge.twist
        self._model = robot.model.copy()
        self._model.gravity = pin.Motion.Zero()
        self._data = self._model.createData()
        self._q, self._v = pin.neutral(self._model), np.zeros(self._model.nv)
        self._tree = robot.tree
        self._bodies = cached_workspace(robot, body_inertias)

    def at(self, posture: Array, rate: float) -> FlatJump:
        """Return what the impact does, with its derivatives.

        Args:
            posture: joint angles at it, shape (n,).
            rate: w, of the foot about its line before it [rad/s].
        """
        self._q[TWIST + 1 :] = posture
        D = np.array(pin.crba(self._model, self._data, self._q))
        base = -rate * self._twist
        jump = solve(D[TWIST:, TWIST:], -D[TWIST:, :TWIST] @ base)
        impulse = D[:TWIST] @ np.concatenate([base, jump])
        stopped = np.concatenate([base, jump])
        pin.computeRNEADerivatives(self._model, self._data, self._q, self._v, stopped)
        own = np.column_stack([self._data.dtau_dq[:, TWIST:], -D[:, :TWIST] @ self._twist])
        of_jump = -solve(D[TWIST:, TWIST:], own[TWIST:])
        of_impulse = own[:TWIST] + D[:TWIST, TWIST:] @ of_jump
        return FlatJump(posture, rate, jump, impulse, np.vstack([of_jump, of_impulse]), D)

    def hessian(self, at: FlatJump, jump: Array, impulse: Array) -> Array:
        """Return the Hessian of jump . (dq+ - dq-) + impulse . I in (posture, w).

        With e the adjoint of both weights it is that of e . (inverse dynamics) along the jump.

        Args:
            at: the impact.
            jump: weights of the jump of the rates, shape (n,).
            impulse: weights of the impulse, shape (6,).
        """
        D, n = at.inertia, at.jump.size
        back = solve(D[TWIST:, TWIST:], jump + D[TWIST:, :TWIST] @ impulse)
        self._q[TWIST + 1 :] = at.posture
        J = pin.computeJointJacobians(self._model, self._data, self._q)
        still = np.zeros((1, n))
        dynamics = WeightedDynamics(
            J[:, TWIST:].T.copy()[None], at.posture[None], still, at.jump[None],
            -at.rate * self._twist[None], np.concatenate([impulse, -back])[None],
        )  # fmt: skip
        inertias = self._bodies.in_world(dynamics.posture)
        bent = inverse_dynamics_hessian(inertias, dynamics, self._tree)
        mixed = bent.qa[0] @ at.along[:n]
        mixed[:, n] -= bent.base[0] @ self._twist
        H = np.zeros((n + 1, n + 1))
        H[:n, :n] = bent.qq[0]
        H[:n] += mixed
        H[:, :n] += mixed.T
        return H
