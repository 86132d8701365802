"""Derivatives of inverse dynamics, places and impact in the robot itself: masses, lengths, rotors.

All at fixed motion and for a weighted sum of results, so that one sweep serves every parameter of
the robot. With the virtual, real and (gravity-included) accelerations W, V, A of the bodies and
their inertias I, the weighted inverse dynamics is

    sum_b W_b . F_b        F_b = I_b A_b + V_b x* (I_b V_b)

It is linear in each body's mass, first and second moments. A displacement u of joint j and of all
beyond it changes nothing beyond it, seen from there, but what arrives at the joint: W, V and A of
the body it sits on, each by -u x. With p = I W, h = I V and sums over the bodies beyond,

    d/du = -(W x* sum F + A x* sum p + V x* Q)
    Q = sum (V_b x* p_b - W_b x* h_b - I_b (V_b x W_b)) - V x* sum p

where W, V, A are those of the body that the joint sits on (docs/derivations.md).
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.mechanics.forward_kinematics import ForwardKinematics, Placements, pseudo_inertias
from gaitopt.mechanics.impact import BASE, WeightedImpact
from gaitopt.mechanics.inverse_dynamics_hessian import WeightedDynamics
from gaitopt.mechanics.spatial import (
    apply,
    cross,
    cross_force,
    cross_motion,
    skew,
    world_inertias,
)
from gaitopt.model.joint_tree import JointTree
from gaitopt.nlp import Array

_SKEW_PARTS = skew(np.eye(3))
"""The matrices of e_k x, shape (3, 3, 3)."""


@dataclass(frozen=True)
class PlacedBodies:
    """The n + 1 bodies of a model rooted at its stance foot, that foot first, at N postures.

    Attributes:
        placed: frames of the bodies.
        inertias: spatial inertias in the world, shape (N, n + 1, 6, 6).
        tree: of the joints.
    """

    placed: Placements
    inertias: Array
    tree: JointTree

    @property
    def carriers(self) -> list[int]:
        """The body that each joint sits on."""
        return [parent + 1 for parent in self.tree.parents]

    def forces_in(self, bodies: list[int] | int, forces: Array) -> Array:
        """Return world forces (..., 6) [N, N·m], one for each of these bodies, in their frames."""
        rotation, origin = self.placed.rotation[:, bodies], self.placed.origin[:, bodies]
        back = np.swapaxes(rotation, -1, -2)
        moment = forces[..., 3:] - cross(origin, forces[..., :3])
        return np.concatenate([apply(back, forces[..., :3]), apply(back, moment)], axis=-1)

    def motions_in_bodies(self, motions: Array) -> Array:
        """Return world motions (N, n + 1, 6) of the bodies in their own frames."""
        back = np.swapaxes(self.placed.rotation, -1, -2)
        linear = motions[..., :3] - cross(self.placed.origin, motions[..., 3:])
        return np.concatenate([apply(back, linear), apply(back, motions[..., 3:])], axis=-1)


class BodyModel:
    """Places the bodies of a model, with their inertias."""

    def __init__(self, model: pin.Model, tree: JointTree) -> None:
        """Prepare what does not depend on the posture.

        Args:
            model: rooted at the stance foot.
            tree: of its joints.
        """
        self._frames, self._tree = ForwardKinematics(model), tree
        self._pseudo = pseudo_inertias(model)

    def at(self, q: Array) -> PlacedBodies:
        """Return the bodies at postures q (N, n) [rad]."""
        placed = self._frames.placed(q)
        return PlacedBodies(placed, world_inertias(self._pseudo, placed.frames), self._tree)


@dataclass(frozen=True)
class DynamicsGradient:
    """Derivatives of a weighted sum of efforts at fixed motion, summed over the instants.

    Attributes:
        displaced: in displacements of each joint with all beyond it, forces in the world at every
            instant, shape (N, n, 6).
        mass, first, second: in each body's moments of mass about the origin of its frame, in its
            axes: sum m, sum m r, sum m r r'; shapes (n + 1,), (n + 1, 3), (n + 1, 3, 3).
        armature: in the rotor inertia of each joint, shape (n,).
        base: in the acceleration of the base, shape (6,).
    """

    displaced: Array
    mass: Array
    first: Array
    second: Array
    armature: Array
    base: Array


def dynamics_gradient(bodies: PlacedBodies, at: WeightedDynamics) -> DynamicsGradient:
    """Return the derivatives of the weighted inverse dynamics in the model.

    Args:
        bodies: at the postures of `at`.
        at: motion and weights.
    """
    tree, axes, I = bodies.tree, at.axes, bodies.inertias  # noqa: E741
    base_weights, weights = np.split(at.weights, [BASE], axis=1)
    dv = axes * at.rate[:, :, None]
    v = tree.up_to(dv)
    da = axes * at.acceleration[:, :, None] + cross_motion(v - dv, dv)
    W = _from_base(base_weights, tree.up_to(axes * weights[:, :, None]))
    V = _from_base(np.zeros_like(base_weights), v)
    A = _from_base(at.base_acceleration, tree.up_to(da))
    p, h, turned = apply(I, W), apply(I, V), cross_motion(V, W)
    force = apply(I, A) + cross_force(V, h)
    own = cross_force(V, p) - cross_force(W, h) - apply(I, turned)
    beyond = tree.beyond(np.concatenate([force, p, own], axis=2)[:, 1:])
    F, P, Q = np.split(beyond, 3, axis=2)
    W_in, V_in, A_in = (motion[:, bodies.carriers] for motion in (W, V, A))
    Q = Q - cross_force(V_in, P)
    displaced = -(cross_force(W_in, F) + cross_force(A_in, P) + cross_force(V_in, Q))
    mass, first, second = _of_moments(*map(bodies.motions_in_bodies, (W, A, V, turned)))
    return DynamicsGradient(
        displaced, mass, first, second,
        armature=(weights * at.acceleration).sum(axis=0),
        base=p.sum(axis=(0, 1)),
    )  # fmt: skip


def _from_base(base: Array, beyond: Array) -> Array:
    """Motions of all bodies, the base's in front, shape (N, n + 1, 6)."""
    return np.concatenate([base[:, None], base[:, None] + beyond], axis=1)


def _of_moments(W: Array, A: Array, V: Array, turned: Array) -> tuple[Array, Array, Array]:
    """Derivatives of W . (I A) - turned . (I V) in the moments of mass, summed over instants.

    Args:
        W, A, V, turned: motions of the bodies in their frames, shape (N, b, 6).
    """
    pairs = np.einsum("kbi,kbj->bij", W, A) - np.einsum("kbi,kbj->bij", turned, V)
    of_inertia = 0.5 * (pairs + pairs.swapaxes(1, 2))
    # I = [[m 1, -[c]], [[c], tr(S) 1 - S]] with c = sum m r and S = sum m r r'
    mass = np.trace(of_inertia[:, :3, :3], axis1=1, axis2=2)
    first = -2.0 * np.einsum("kij,bij->bk", _SKEW_PARTS, of_inertia[:, :3, 3:])
    turning = of_inertia[:, 3:, 3:]
    second = np.trace(turning, axis1=1, axis2=2)[:, None, None] * np.eye(3) - turning
    return mass, first, second


def landing_gradient(bodies: PlacedBodies, impact: WeightedImpact) -> tuple[Array, Array]:
    """Return the derivatives of l . (-J' I, J V+) in displacements, forces in the world.

    Args:
        bodies: at the posture of the impact.
        impact: with its adjoint l.

    Returns:
        For each joint with all beyond it, shape (1, n, 6); for the landing sole, shape (1, 6).
    """
    tree, axes = bodies.tree, impact.dynamics.axes
    first = BASE + len(impact.tangent.of.free)
    momentum, landing = impact.dynamics.weights[0], impact.adjoint[first : first + BASE]
    after = impact.state.sole_twist, impact.rate_after
    impulse = impact.foot.act(pin.Force(impact.state.impulse)).vector
    push = impact.foot.act(pin.Force(landing)).vector
    W, V = (
        _from_base(motion[None, :BASE], tree.up_to(axes * motion[None, BASE:, None]))
        for motion in (momentum, np.concatenate(after))
    )
    of_body = cross_force(W, np.broadcast_to(impulse, W.shape))
    of_body -= cross_force(V, np.broadcast_to(push, V.shape))
    between = tree.path(tree.swing_foot)
    return of_body[:, bodies.carriers] * between[:, None], of_body[:, tree.swing_foot]
