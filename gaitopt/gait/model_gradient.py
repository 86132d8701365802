"""How a weighted sum of a step's quantities changes with the robot, at fixed parameters x.

The way back of `step_hessian`, one stage further: from the weights of efforts, places, impact and
double support to the masses, lengths and rotors that they come from. All is at fixed motion, so
that one sweep serves every parameter of
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

from dataclasses import replace
from functools import cached_property

import numpy as np

from gaitopt.contact import Hinge
from gaitopt.dataclass import dataclass
from gaitopt.gait import quantities
from gaitopt.gait.double_support import Posture, PostureDerivatives
from gaitopt.gait.quantities import Quantity
from gaitopt.gait.step import Step, StepDerivatives
from gaitopt.gait.step_hessian import StepAdjoint, step_adjoint
from gaitopt.gait.step_model import StepModel
from gaitopt.mechanics.forward_kinematics import ForwardKinematics, Placements, pseudo_inertias
from gaitopt.mechanics.impact import BASE, WeightedImpact
from gaitopt.mechanics.inverse_dynamics_hessian import WeightedDynamics
from gaitopt.mechanics.inverse_kinematics import closure_forces, loop_gap_jacobian
from gaitopt.mechanics.single_support import FRICTION_RATE
from gaitopt.mechanics.spatial import apply, cross, cross_force, cross_motion, skew, world_inertias
from gaitopt.model.joint_tree import JointTree
from gaitopt.model.robot import Robot, cached_workspace
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
    """Places the bodies of a robot, with their inertias."""

    def __init__(self, robot: Robot) -> None:
        self._frames, self._tree = ForwardKinematics(robot.model), robot.tree
        self._pseudo = pseudo_inertias(robot.model)

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
    """Return the derivatives of the weighted inverse dynamics in the model."""
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
    """Derivatives of W . (I A) - turned . (I V), (N, b, 6) each, in the moments of mass."""
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

    Returns:
        For each joint with all beyond it, shape (1, n, 6); for the landing sole, shape (1, 6).
    """
    tree, axes = bodies.tree, impact.dynamics.axes
    first = BASE + len(impact.tangent.of.free)
    momentum, landing = impact.dynamics.weights[0], impact.adjoint[first : first + BASE]
    after = impact.state.sole_twist, impact.rate_after
    impulse, push = impact.on_forces @ impact.state.impulse, impact.on_forces @ landing
    W, V = (
        _from_base(motion[None, :BASE], tree.up_to(axes * motion[None, BASE:, None]))
        for motion in (momentum, np.concatenate(after))
    )
    of_body = cross_force(W, np.broadcast_to(impulse, W.shape))
    of_body -= cross_force(V, np.broadcast_to(push, V.shape))
    between = tree.path(tree.swing_foot)
    return of_body[:, bodies.carriers] * between[:, None], of_body[:, tree.swing_foot]


OF_ROBOT = (
    "mass", "first", "second", "joints", "swing_sole", "pelvis", "corners", "hips", "ankles",
    "armature", "damping", "friction",
)  # fmt: skip
"""Names of what changes of a robot move."""


@dataclass(frozen=True)
class OfRobot:
    """Numbers of a robot rooted at its stance sole: changes of them, or derivatives in them.

    Bodies are the n + 1 of the rooted model, the stance foot first, each with the axes and the
    origin of its joint's frame (the stance foot's: of its sole). Units are those of the numbers.

    Attributes:
        mass, first, second: moments of mass of each body about that origin: sum m [kg], sum m r
            [kg·m], sum m r r' [kg·m²]; shapes (n + 1,), (n + 1, 3), (n + 1, 3, 3).
        joints: displacements of each joint with all beyond it, in the axes of the body that it
            sits on [m], shape (n, 3).
        swing_sole, pelvis: displacements of these frames in the axes of their bodies [m], (3,).
        hips, ankles: the centres as `Legs` has them [m], shape (2, 3).
        armature, damping, friction: of each joint, those that follow others too [kg·m²],
            [N·m·s/rad], [N·m], shape (n,).
    """

    mass: Array
    first: Array
    second: Array
    joints: Array
    swing_sole: Array
    pelvis: Array
    hips: Array
    ankles: Array
    armature: Array
    damping: Array
    friction: Array

    @cached_property
    def flat(self) -> Array:
        """All of it, `OF_ROBOT`, one after another."""
        return np.concatenate([np.ravel(getattr(self, name)) for name in OF_ROBOT])


@dataclass(frozen=True)
class ModelGradient(OfRobot):
    """Derivatives with respect to a robot and to the step's duration.

    Attributes:
        corners: of the swing sole, in its axes, shape (4, 3).
        gravity: in the axes of the stance sole, shape (3,).
        duration: in the duration of the step.
    """

    corners: Array
    gravity: Array
    duration: float


def model_gradient(
    model: StepModel, step: Step, derivatives: StepDerivatives, first: dict[Quantity, Array]
) -> ModelGradient:
    """Return the derivatives of the sum of `first` times the quantities in the robot.

    Args:
        first: weights of every quantity, of its shape; those of `BODY_GAPS` are left out.
    """
    back = step_adjoint(model, step, derivatives, first)
    effort = derivatives.support.motion.tangent.velocity(back.effort)  # of all joints
    robot, standing, h = model.robot, model.standing, step.hinges
    swing, pelvis = robot.tree.swing_foot, robot.tree.pelvis
    supported, on_sole, on_corners = _support(standing, derivatives, effort, first, step)
    bodies = cached_workspace(robot, BodyModel)
    landing = bodies.at(robot.coupling.angles(step.q_end)[None])
    at_impact = dynamics_gradient(landing, back.impact.dynamics)
    landed, on_landing = landing_gradient(landing, back.impact)
    start = bodies.at(robot.coupling.angles(step.posture.q_start)[None])
    at_pelvis, at_sole = _double_support(
        step.posture, derivatives.posture, back.q_start, first[quantities.GAPS]
    )
    between = robot.tree.path(swing)[:, None] * at_sole
    between = between + robot.tree.path(pelvis)[:, None] * at_pelvis
    carriers = landing.carriers
    joints = supported.displaced.sum(axis=0)[h:, :3]
    joints += landing.forces_in(carriers, at_impact.displaced + landed)[0, :, :3]
    joints += start.forces_in(carriers, between[None])[0, :, :3]
    on_sole = on_sole + landing.forces_in(swing, on_landing)[0, :3]
    on_sole += start.forces_in(swing, at_sole[None])[0, :3]
    posture, legs = step.posture, first[quantities.LEGS]
    damping, friction = _passive(derivatives, effort, h)
    return ModelGradient(
        mass=supported.mass[h:] + at_impact.mass,
        first=supported.first[h:] + at_impact.first,
        second=supported.second[h:] + at_impact.second,
        joints=joints,
        swing_sole=on_sole,
        pelvis=start.forces_in(pelvis, at_pelvis[None])[0, :3],
        corners=on_corners,
        hips=legs @ posture.pelvis.rotation,
        ankles=np.stack([-legs[0], -posture.sole.rotation.T @ legs[1]]),
        armature=supported.armature[h:] + at_impact.armature,
        damping=damping,
        friction=friction,
        gravity=-supported.base[:3],
        duration=_of_duration(model, step, derivatives, back, first),
    )


def _support(
    standing: Robot,
    derivatives: StepDerivatives,
    effort: Array,
    first: dict[Quantity, Array],
    step: Step,
) -> tuple[DynamicsGradient, Array, Array]:
    """Single support: dynamics and swing foot; forces on the swing sole and on its corners.

    `displaced` is turned into the axes of the bodies that the joints sit on.
    """
    support, tree = derivatives.support, standing.tree
    bodies = cached_workspace(standing, BodyModel).at(support.motion.of_all[0])
    base = np.broadcast_to(-support.gravity, (len(effort), 6))
    q, dq, ddq = support.motion.of_all
    at = WeightedDynamics(support.axes, q, dq, ddq, base, effort)
    found = dynamics_gradient(bodies, at)
    corners = first[quantities.CORNERS].reshape(-1, 4, 3)
    moment = cross(step.support.corners, corners).sum(axis=1)
    wrench = np.concatenate([corners.sum(axis=1), moment], axis=1)
    displaced = found.displaced + tree.path(tree.swing_foot)[:, None] * wrench[:, None]
    in_bodies = bodies.forces_in(bodies.carriers, displaced)
    frame = standing.model.frames[standing.swing_frame].placement.rotation
    axes = bodies.placed.rotation[:, tree.swing_foot] @ frame
    on_sole = bodies.forces_in(tree.swing_foot, wrench)[:, :3].sum(axis=0)
    on_corners = np.einsum("kij,kci->cj", axes, corners)
    last = step.turn or step.landed  # its hinge is the nearest to the foot
    if last is not None:
        found = _about_sole(found, last.hinge, step.hinges)
    return replace(found, displaced=in_bodies), on_sole, on_corners


def _about_sole(found: DynamicsGradient, hinge: Hinge, foot: int) -> DynamicsGradient:
    """The moments of the stance foot about its sole's origin instead of a point of the hinge."""
    p, mass, first = hinge.point, found.mass.copy(), found.first.copy()
    by_second = found.second[foot] @ p
    mass[foot] += by_second @ p - first[foot] @ p
    first[foot] -= 2.0 * by_second
    return replace(found, mass=mass, first=first)


def _double_support(
    posture: Posture, at: PostureDerivatives, q_start: Array, gaps: Array
) -> tuple[Array, Array]:
    """Forces in the world, (6,) each, that displacements of pelvis and swing sole pair with.

    Args:
        q_start: weights of the posture, which follows the pelvis and the sole in the closed form.
        gaps: weights of the gaps, which open in the lifted one.
    """
    if not posture.loops:
        pelvis, sole = closure_forces(at.joint_axes, q_start)
        return -pelvis, -sole
    forces = []
    targets = (posture.pelvis, posture.sole)
    for loop, target, weight in zip(posture.loops, targets, gaps, strict=True):
        body = target * loop.inverse()
        away = -body.toActionMatrixInverse().T  # rows: what unit displacements do to the loop
        forces.append(loop_gap_jacobian(loop, away).T @ weight)
    return forces[0], forces[1]


def _passive(derivatives: StepDerivatives, effort: Array, hinges: int) -> tuple[Array, Array]:
    """Derivatives in viscous damping and Coulomb friction of the joints, shape (n,) each."""
    rates = derivatives.support.motion.of_all[1][:, hinges:]
    weights = effort[:, 6 + hinges :]
    turned = np.tanh(rates / FRICTION_RATE)
    return (weights * rates).sum(axis=0), (weights * turned).sum(axis=0)


def _of_duration(
    model: StepModel,
    step: Step,
    derivatives: StepDerivatives,
    back: StepAdjoint,
    first: dict[Quantity, Array],
) -> float:
    """Derivative in the duration T of the step."""
    T, joints = step.duration, back.by_order[:, :, step.hinges :]
    found = float(np.sum(joints * (model.basis.at(T, 1) @ step.coefficients)))
    found += float(first[quantities.TRAVEL][0, 1])
    for number, one in enumerate(derivatives.turns):
        moved = one.turn.basis.at(T, 1) @ (one.turn.coefficients @ one.shape)
        found += float(np.sum(back.by_order[:, :, number] * moved))
    return found
