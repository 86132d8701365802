"""Single support, Eqs. (1)-(13): torques, ground wrench, swing foot, and their derivatives.

The effort is [R0; Gamma] of Eq. (1) for the rigid bodies, plus what the joints take themselves
(damping, Coulomb friction, springs; docs/physics.md), less the weight that is carried from outside.
Motion and torques are those of the n joints that follow no other (see `Coupling`).

Where kernels are built (`compiled`) they compute all instants, else Pinocchio one after the other.
One `pin.Data` then serves all instants, and all walks of a robot in a thread; its results are live
views that are copied out after each: faster than a Data per instant, whose 0.4 MB each leave the
processor's caches (measured: a third at 31 instants, two fifths at 301).
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property, lru_cache

import numpy as np
import pinocchio as pin

from gaitopt.contact import ContactMode
from gaitopt.dataclass import dataclass
from gaitopt.mechanics import compiled
from gaitopt.mechanics.forward_kinematics import (
    ForwardKinematics,
    corner_hessian,
    corner_jacobian,
    corner_positions,
)
from gaitopt.mechanics.inverse_dynamics_hessian import (
    DynamicsHessian,
    InverseDynamicsHessian,
    WeightedDynamics,
    inverse_dynamics_hessian,
)
from gaitopt.mechanics.spatial import apply, cross_force, cross_motion, skew
from gaitopt.model.chain_physics import CarriedWeight, ChainPhysics, PassiveJoints
from gaitopt.model.coupling import CoupledMotion
from gaitopt.model.joint_tree import FIRST, joint_axes
from gaitopt.model.robot import Robot, cached_workspace
from gaitopt.nlp import Array

FRICTION_RATE = 0.1
"""epsilon: rate in which Coulomb friction turns round, so that it has derivatives [rad/s].

A joint at 0.1 rad/s has 76 % of it, at 0.3 rad/s 99.5 %; a walk's joints turn at 1 to 10 rad/s.
How little the optimum depends on it: docs/physics.md."""


@dataclass(frozen=True)
class SupportState:
    """Single support at N instants, world frame = stance sole frame.

    Attributes:
        effort: ground wrench on the stance foot (force, moment about the sole origin; 6) then
            torques (n) [N, N.m], shape (N, 6 + n): [R0; Gamma] of Eq. (1).
        corners: corners of the swing sole [m], shape (N, 4, 3).
    """

    effort: Array
    corners: Array


@dataclass(frozen=True)
class SupportDerivatives:
    """Derivatives of a SupportState, and the kinematics they came with.

    Attributes:
        effort: with respect to (q, dq, ddq) side by side, shape (N, 6 + n, 3 n).
        corners: with respect to q, shape (N, 4, 3, n).
        corners_by_all: likewise, of all joints, those that follow others too, (N, 4, 3, all).
        axes: motion axes of all joints in the world, shape (N, all, 6).
        motion: of all joints.
        of_all: the effort of all joints and its derivative in their q, dq, ddq, shapes
            (N, 6 + all) and (N, 6 + all, 3 all).
        dynamics: of the robot, for the second derivatives.
        gravity: spatial acceleration of gravity [m/s²], shape (6,).
        passive: what the joints do by themselves; None if they do nothing.
        carried: weight that is carried from outside; None if there is none.
    """

    effort: Array
    corners: Array
    corners_by_all: Array
    axes: Array
    motion: CoupledMotion
    of_all: tuple[Array, Array]
    dynamics: DynamicsHessian
    gravity: Array
    passive: PassiveTorque | None = None
    carried: GravityCompensation | None = None

    def hessian(self, weights: Array) -> InverseDynamicsHessian:
        """Return the second derivatives of sum(weights * effort), weights (N, 6 + n)."""
        return self.hessians(weights)[0]

    def hessians(
        self, weights: Array, then: WeightedDynamics | None = None
    ) -> tuple[InverseDynamicsHessian, InverseDynamicsHessian]:
        """Return `hessian`, and that of further dynamics.

        Args:
            weights: of the effort.
            then: further instants to follow the N; cheaper than on their own.

        Returns:
            Those of the N instants; those of the further ones, of all joints.
        """
        of_free, weights = weights, self.motion.tangent.velocity(weights)
        base = np.full((len(weights), 6), -self.gravity)
        q, dq, ddq = self.motion.of_all
        at = WeightedDynamics(self.axes, q, dq, ddq, base, weights)
        if then is not None:
            at = at.followed_by(then)
        found = self.dynamics.of(at)
        own = slice(len(weights))
        if self.carried is not None:
            found.qq[own] -= self.carried.hessian(q, weights)
        if self.passive is not None:
            each = np.arange(self.axes.shape[1])
            found.qq[own, each, each] += weights[:, 6:] * self.passive.by_angle_twice
            found.vv[own, each, each] += weights[:, 6:] * self.passive.by_rate_twice
        mine, others = found.at(own), found.at(slice(len(weights), None))
        if self.motion.bends:
            return mine.bent(self.motion, *self.of_all, of_free), others
        return mine.reduced(self.motion.tangent), others

    def corner_hessian(self, weights: Array) -> Array:
        """Return the second derivatives in q of sum(weights * corners), weights (N, 4, 3)."""
        by_all = corner_hessian(self.axes, self.corners_by_all, weights)
        gradient = None
        if self.motion.bends:
            gradient = np.einsum("kci,kcin->kn", weights, self.corners_by_all)
        return self.motion.tangent.reduced_twice(by_all, gradient)


class _Workspace:
    """What is the same for all walks of a robot, and views of Pinocchio's results for it."""

    def __init__(self, robot: Robot) -> None:
        self.data = data = robot.model.createData()
        self.neutral = pin.neutral(robot.model)
        self.effort, self.axes = data.tau, data.J[:, 6:].T
        self.slopes = [getattr(data, name)[:, 6:] for name in ("dtau_dq", "dtau_dv", "M")]
        last = data.oMi[robot.model.frames[robot.swing_frame].parentJoint]
        self.rotation, self.origin = last.rotation, last.translation


class SingleSupport:
    """Evaluates Eq. (1) at a fixed number of instants."""

    def __init__(self, robot: Robot, count: int) -> None:
        self.robot = robot
        self.count = count
        self._joints = robot.physics.passive

    @property
    def _carried(self) -> GravityCompensation | None:
        """Weight that is carried from outside."""
        return (
            None
            if self.robot.physics.carried is None
            else cached_workspace(self.robot, GravityCompensation)
        )

    def state(self, q: Array, dq: Array, ddq: Array) -> SupportState:
        """Return wrench, torques and swing foot at q, dq, ddq (N, n) [rad, rad/s, rad/s²]."""
        motion = self.robot.coupling.motion(np.array([q, dq, ddq]))
        q, dq, _ = motion.of_all
        effort, foot, _, axes = self._inverse_dynamics(motion.of_all, derivatives=False)
        if (carried := self._carried) is not None:
            effort -= carried.effort(q)
        if self._joints is not None:
            effort[:, 6:] += passive_torque(self._joints, q, dq).value
        effort = motion.tangent.effort(effort)
        return SupportState(effort, self._corners(foot, axes)[0])

    def _inverse_dynamics(
        self, of_all: Array, derivatives: bool
    ) -> tuple[Array, Array, Array, Array]:
        """Return `by_pinocchio`, by the kernels where they are built."""
        if compiled.in_use():
            q, dq, ddq = of_all
            return compiled.bodies_of(self.robot).inverse_dynamics(q, dq, ddq, derivatives)
        return by_pinocchio(self.robot, of_all, derivatives)

    def _corners(self, foot: Array, axes: Array) -> tuple[Array, Array]:
        """Return `corners_plainly`, by the kernels where they are built."""
        if compiled.in_use():
            return compiled.bodies_of(self.robot).foot_points(foot, axes, self._in_last)
        return corners_plainly(self.robot, foot, axes, self._in_last)

    @cached_property
    def _in_last(self) -> Array:
        """Corners of the swing sole in the frame of its body [m], shape (4, 3)."""
        frame, sole = self.robot.model.frames[self.robot.swing_frame].placement, self.robot.sole
        return np.asarray(sole.corners @ frame.rotation.T + frame.translation)

    def derivatives(
        self, q: Array, dq: Array, ddq: Array
    ) -> tuple[SupportState, SupportDerivatives]:
        """Return the state and its exact derivatives at q, dq, ddq (N, n) [rad, rad/s, rad/s²]."""
        motion = self.robot.coupling.motion(np.array([q, dq, ddq]))
        q, dq, _ = motion.of_all
        model, n = self.robot.model, self.robot.tree.size
        found = self._inverse_dynamics(motion.of_all, derivatives=True)
        effort, foot, jacobian, axes = found
        of_q, of_dq = (jacobian[:, :, k * n : (k + 1) * n] for k in range(2))
        if (carried := self._carried) is not None:
            unneeded, unneeded_slope = carried.derivatives(q)
            effort -= unneeded
            of_q -= unneeded_slope
        passive = None if self._joints is None else passive_torque(self._joints, q, dq)
        if passive is not None:
            effort[:, 6:] += passive.value
            each = np.arange(n)
            of_q[:, 6 + each, each] += passive.by_angle
            of_dq[:, 6 + each, each] += passive.by_rate
        corners, corners_by_all = self._corners(foot, axes)
        of_all, tangent = (effort, jacobian), motion.tangent
        if not tangent.of.none:
            effort = tangent.effort(effort)
            jacobian = tangent.effort(motion.reduced(jacobian).swapaxes(1, 2)).swapaxes(1, 2)
            if motion.bends:
                m = len(tangent.of.free)
                turned = motion.orders[2] * of_all[0][:, 6:]
                jacobian[:, 6:, :m] += tangent.of.diagonal(turned)
        derivatives = SupportDerivatives(
            effort=jacobian,
            corners=tangent.reduced(corners_by_all),
            corners_by_all=corners_by_all,
            axes=axes,
            motion=motion,
            of_all=of_all,
            dynamics=cached_workspace(self.robot, DynamicsHessian),
            gravity=model.gravity.vector,
            passive=passive,
            carried=carried,
        )
        return SupportState(effort, corners), derivatives


def by_pinocchio(
    robot: Robot, motion: Array, derivatives: bool
) -> tuple[Array, Array, Array, Array]:
    """Return the inverse dynamics of rigid bodies whose stance foot rests.

    Args:
        robot: rooted at its stance sole.
        motion: q, dq, ddq of all n joints [rad, rad/s, rad/s²], shape (3, N, n).
        derivatives: whether the last two are wanted; else they have no instants.

    Returns:
        Wrench and torques [N, N·m] (N, 6 + n); axes by rows and origin of the body of the swing
        foot (N, 4, 3); the effort's derivatives in (q, dq, ddq) (N, 6 + n, 3 n); axes of the joints
        in the world (N, n, 6).
    """
    model, at = robot.model, cached_workspace(robot, _Workspace)
    data, (by_position, by_rate, by_acceleration) = at.data, at.slopes
    count, n = motion.shape[1:]
    effort, foot = np.empty((count, 6 + n)), np.empty((count, 4, 3))
    rows = count if derivatives else 0
    jacobian, axes = np.empty((rows, 6 + n, 3 * n)), np.empty((rows, n, 6))
    q, v, a = np.tile(at.neutral, (count, 1)), np.zeros((count, 6 + n)), np.zeros((count, 6 + n))
    q[:, 7:], v[:, 6:], a[:, 6:] = motion
    of_q, of_dq, of_ddq = (jacobian[:, :, k * n : (k + 1) * n] for k in range(3))
    for k, instant in enumerate(zip(q, v, a, strict=True)):
        if derivatives:
            pin.computeRNEADerivatives(model, data, *instant)
            of_q[k], of_dq[k], of_ddq[k] = by_position, by_rate, by_acceleration
            axes[k] = at.axes
        else:
            pin.rnea(model, data, *instant)
            pin.updateGlobalPlacements(model, data)
        effort[k], foot[k, :3], foot[k, 3] = at.effort, at.rotation, at.origin
    return effort, foot, jacobian, axes


def corners_plainly(robot: Robot, foot: Array, axes: Array, in_last: Array) -> tuple[Array, Array]:
    """Return corners of the swing sole and their derivatives in the angles of all n joints.

    Args:
        robot: rooted at its stance sole.
        foot, axes: as of `by_pinocchio`; without instants of the axes there are no derivatives.
        in_last: the corners in the frame of their body [m], shape (4, 3).

    Returns:
        Shapes (N, 4, 3) and (N, 4, 3, n).
    """
    corners, tree = corner_positions(foot[:, :3], foot[:, 3], in_last), robot.tree
    if not len(axes):
        return corners, np.empty((0, *in_last.shape, tree.size))
    return corners, tree.from_legs(corner_jacobian(axes[:, tree.legs], corners))


@dataclass(frozen=True)
class PassiveTorque:
    """The torque that the joints take themselves, at N instants, and its derivatives.

    Each joint's depends on its own motion alone.

    Attributes:
        value: shape (N, n) [N·m].
        by_angle, by_rate: first derivatives of it, shape (N, n) each.
        by_angle_twice, by_rate_twice: second derivatives, shape (N, n) each.
    """

    value: Array
    by_angle: Array
    by_rate: Array
    by_angle_twice: Array
    by_rate_twice: Array


def passive_torque(joints: PassiveJoints, q: Array, dq: Array) -> PassiveTorque:
    """Return the torque that the motors deliver for the joints themselves.

    It is sum_k d_k |dq|^(k-1) dq + F tanh(dq / epsilon) + sum_k c_k (q - r)^k

    with the powers that MuJoCo 4 gives to damping (odd) and to springs (plain).

    Args:
        q, dq: angles and rates, shape (N, n) each [rad, rad/s].
    """
    spring, by_angle, by_angle_twice = polynomial(joints.stiffness, q - joints.rest)
    damping, by_rate, by_rate_twice = odd_polynomial(joints.damping, dq)
    turned = np.tanh(dq / FRICTION_RATE)
    by_friction = joints.friction / FRICTION_RATE * (1.0 - turned**2)
    return PassiveTorque(
        value=spring + damping + joints.friction * turned,
        by_angle=by_angle,
        by_rate=by_rate + by_friction,
        by_angle_twice=by_angle_twice,
        by_rate_twice=by_rate_twice - 2.0 / FRICTION_RATE * turned * by_friction,
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


class GravityCompensation:
    """The weight of one robot that is carried from outside (MuJoCo's `gravcomp`).

    A point mass m at p is held by a force -m g from outside, which the ground and the motors need
    not give. With a_0 = -g the wrench that holds all points beyond joint j is

        W_j = sum_{b >= j} P_b a_0        of P_b, the spatial inertia of body b's points,

    and the effort is that of the whole robot less [W_0; S_j . W_j]: two inverse dynamics, the
    second of the points alone at rest. Turning joint k moves what lies beyond it, so that for the
    joint j that k moves or is, and the other way round,

        dW_j / dq_k = G_j         G_k = S_k x* W_k - P_k^c (S_k x a_0)

    and the derivative of S_j . W_j is S_min . G_max, symmetric as the Hessian of a potential is.
    """

    def __init__(self, robot: Robot) -> None:
        """Prepare what does not depend on the posture.

        Args:
            robot: with `physics.carried`.
        """
        weight = robot.physics.carried
        if weight is None:
            raise ValueError("the robot has no weight that is carried from outside")
        model = robot.model
        self._bodies = ForwardKinematics(model)
        self._tree = robot.tree
        self._axes = joint_axes(model)
        self._mass, self._moment = weight.mass, weight.moment
        self._start = np.concatenate([-model.gravity.linear, np.zeros(3)])

    def effort(self, q: Array) -> Array:
        """Return the part of wrench and torques that is not needed, shape (N, 6 + n).

        Args:
            q: postures, shape (N, n) [rad].
        """
        axes, inertias = self._placed(q)
        return _effort(axes, self._wrenches(inertias))

    def derivatives(self, q: Array) -> tuple[Array, Array]:
        """Return the effort (N, 6 + n) and its derivative in the posture (N, 6 + n, n)."""
        axes, inertias = self._placed(q)
        wrenches = self._wrenches(inertias)
        composite = self._tree.beyond(inertias[:, 1:])
        fallen = cross_motion(axes, np.broadcast_to(self._start, axes.shape))
        G = cross_force(axes, wrenches[:, 1:]) - apply(composite, fallen)
        by_joint = G.swapaxes(1, 2)
        of_torque = self._tree.symmetric(axes @ by_joint)  # S_j . G_k for k >= j
        jacobian = np.concatenate([by_joint, of_torque], axis=1)
        return _effort(axes, wrenches), jacobian

    def hessian(self, q: Array, weights: Array) -> Array:
        """Return the second derivative of sum(weights * effort) in the posture, (N, n, n).

        Args:
            q: postures, shape (N, n) [rad].
            weights: of the effort, shape (N, 6 + n).
        """
        axes, inertias = self._placed(q)
        rest = np.zeros(q.shape)
        base = np.broadcast_to(self._start, (len(q), 6))
        at = WeightedDynamics(axes, q, rest, rest, base, weights)
        return inverse_dynamics_hessian(inertias[:, 1:], at, self._tree).qq

    def _placed(self, q: Array) -> tuple[Array, Array]:
        """Joint axes S_j (N, n, 6) and the points' spatial inertias P_b (N, n + 1, 6, 6).

        Their rotational blocks are left 0: nothing here turns.
        """
        at = self._bodies.placed(q)
        direction = apply(at.rotation[:, 1:], self._axes)
        axes = np.concatenate([np.cross(at.origin[:, 1:], direction), direction], axis=2)
        moment = apply(at.rotation, self._moment) + self._mass[:, None] * at.origin
        inertias = np.zeros((*moment.shape[:2], 6, 6))
        inertias[..., :3, :3] = self._mass[:, None, None] * np.eye(3)
        inertias[..., 3:, :3] = skew(moment)
        inertias[..., :3, 3:] = -inertias[..., 3:, :3]
        return axes, inertias

    def _wrenches(self, inertias: Array) -> Array:
        """W_0 and W_j, shape (N, n + 1, 6)."""
        own = inertias @ self._start
        return np.concatenate([own.sum(axis=1)[:, None], self._tree.beyond(own[:, 1:])], axis=1)


def _effort(axes: Array, wrenches: Array) -> Array:
    torque = np.einsum("nji,nji->nj", axes, wrenches[:, 1:])
    return np.concatenate([wrenches[:, 0], torque], axis=1)


HINGE = "stance foot on the ground"
"""Name of the joint, with that of its contact."""

FOOTPRINT = "footprint"
"""Name of the frame where the stance sole stood flat."""


_KEPT = 8  # hinged robots, one for each robot and contact


def standing_robot(robot: Robot, *contacts: ContactMode) -> Robot:
    """Return a robot whose joints are the hinges of contacts, then its own; itself without any.

    A hinge is one more joint, between the ground and the stance foot, about a line of its sole. The
    model is then rooted at the footprint, a body without mass where the sole stood flat, and the
    torque of the hinge is the moment of the ground about the line.
    Of several hinges, one after the other from the ground, one at most is not at 0: a foot turns
    about one line at a time, and the others do nothing.
    What is measured of the legs (limits, mirror, geometry) is still that of the robot's own joints.

    Args:
        robot: rooted at its stance sole.
        contacts: of its stance foot; those without a hinge add none.
    """
    for contact in reversed(contacts):  # each comes between the ground and those before
        if contact.hinge(robot.sole) is not None:
            robot = _hinged(robot, contact)
    return robot


@lru_cache(maxsize=_KEPT)
def _hinged(robot: Robot, contact: ContactMode) -> Robot:
    """Return a robot with one more hinge under its first body."""
    hinge, model = contact.hinge(robot.sole), robot.model
    assert hinge is not None
    name = f"{HINGE}, {contact.name}"
    line = pin.SE3(np.eye(3), hinge.point)
    rooted = pin.Model()
    rooted.name, rooted.gravity = model.name, model.gravity
    base = rooted.addJoint(0, pin.JointModelFreeFlyer(), model.jointPlacements[1], model.names[1])
    foot = rooted.addJoint(base, pin.JointModelRevoluteUnaligned(hinge.axis), line, name)
    new = {0: 0, 1: foot}
    for joint, axis in enumerate(joint_axes(model), FIRST):
        place = model.jointPlacements[joint]
        if model.parents[joint] == 1:
            place = line.inverse() * place
        new[joint] = rooted.addJoint(
            new[int(model.parents[joint])],
            pin.JointModelRevoluteUnaligned(axis),
            place,
            model.names[joint],
        )
    for joint in range(1, model.njoints):
        moved = line.inverse() if joint == 1 else pin.SE3.Identity()
        rooted.appendBodyToJoint(new[joint], model.inertias[joint], moved)
    armature = np.array(rooted.armature)
    armature[-robot.tree.size :] = np.array(model.armature)[-robot.tree.size :]
    rooted.armature = armature
    for frame in model.frames:
        if frame.type == pin.FrameType.OP_FRAME and frame.name != FOOTPRINT:
            joint = int(frame.parentJoint)
            place = line.inverse() * frame.placement if joint == 1 else frame.placement
            rooted.addFrame(pin.Frame(frame.name, new[joint], place, frame.type), False)
    footprint = pin.Frame(FOOTPRINT, base, pin.SE3.Identity(), pin.FrameType.OP_FRAME)
    rooted.addFrame(footprint, False)
    return replace(
        robot,
        model=rooted,
        joint_names=(name, *robot.joint_names),
        coupling=robot.coupling.led(name),
        stance_sole=FOOTPRINT,
        physics=_physics(robot.physics, line),
    )


def _physics(physics: ChainPhysics, line: pin.SE3) -> ChainPhysics:
    """The hinge does nothing by itself; the footprint has no weight to carry."""
    passive, carried = physics.passive, physics.carried
    if passive is not None:
        passive = PassiveJoints(
            *(_led(values) for values in (passive.damping, passive.friction)),
            *(_led(values) for values in (passive.stiffness, passive.rest)),
        )
    if carried is not None:
        moment = carried.moment.copy()
        of_foot = moment[0] - carried.mass[0] * line.translation  # about a point of the line
        moment[0] = line.rotation.T @ of_foot
        carried = CarriedWeight(_led(carried.mass), _led(moment))
    return replace(physics, passive=passive, carried=carried)


def _led(values: Array) -> Array:
    """A table by joint or body with zeros in front for the hinge or the footprint."""
    return np.concatenate([np.zeros((1, *values.shape[1:])), values])
