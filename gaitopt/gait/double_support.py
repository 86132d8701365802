"""The double support at the start of a step, Eq. (26) and Fig. 2: q_start, with derivatives.

Pelvis and swing foot are placed by the geometric quantities. Each placement is a product of
elementary displacements whose amounts are linear in the quantities: a serial chain, so its twists
and second derivatives follow the same formulas as those of a leg.

Two forms. `InverseKinematicsSupport` is the paper's (section 4.2): joint angles by inverse
kinematics. `JointAngleSupport` takes the joint angles as parameters too and reports how far pelvis
and swing foot are from where the quantities put them: no trial point is out of reach, the knee may
pass through the straight leg on the way, and the legs may have any number of joints. A double
support answers three questions (posture, derivatives, Hessian) as a pure function of its
coordinates.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property

import numpy as np
import pinocchio as pin

from gaitopt.bounds import fixed
from gaitopt.contact import Hinge
from gaitopt.dataclass import dataclass
from gaitopt.errors import EvaluationError, InputError, UnreachableError
from gaitopt.gait.parameters import (
    FOOT_SPACING,
    FOOT_YAW,
    GEOMETRY,
    PELVIS_FORWARD,
    PELVIS_HEIGHT,
    PELVIS_LATERAL,
    PELVIS_ROLL,
    PELVIS_YAW,
    STEP_LENGTH,
    TRUNK_PITCH,
)
from gaitopt.mechanics import compiled
from gaitopt.mechanics.inverse_kinematics import (
    LegKinematics,
    chain_hessian,
    closure_forces,
    closure_jacobian,
    loop_gap,
    loop_gap_hessian,
    loop_gap_jacobian,
    regular,
)
from gaitopt.mechanics.spatial import cross, skew
from gaitopt.model.coupling import Tangent
from gaitopt.model.joint_tree import TWIST
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array

_X, _Y, _Z = np.eye(3)
_ZERO = np.zeros(3)
_NO_JOINTS = np.zeros((0, TWIST))


@dataclass(frozen=True)
class Displacement:
    """A translation along, or a rotation about, a fixed axis of the frame before it.

    Attributes:
        axis: unit vector, shape (3,).
        turns: True for a rotation.
        quantity: row of the geometry table that drives it; None: it stays as it is.
        factor: amount of displacement per unit of that quantity, or altogether.
        point: on the axis of a rotation, shape (3,); None: the origin.
    """

    axis: Array
    turns: bool
    quantity: int | None
    factor: float = 1.0
    point: Array | None = None


PELVIS_CHAIN = (
    Displacement(_X, False, PELVIS_FORWARD),
    Displacement(_Y, False, PELVIS_LATERAL),
    Displacement(_Z, False, PELVIS_HEIGHT),
    Displacement(_Z, True, PELVIS_YAW),
    Displacement(_Y, True, TRUNK_PITCH),
    Displacement(_X, True, PELVIS_ROLL),
)
"""Pelvis in the stance sole frame: translation, then yaw, pitch, roll."""

SWING_SOLE_CHAIN = (
    Displacement(_Z, True, FOOT_YAW, 0.5),
    Displacement(_X, False, STEP_LENGTH, -1.0),
    Displacement(_Y, False, FOOT_SPACING),
    Displacement(_Z, True, FOOT_YAW, 0.5),
)
"""Swing sole in the stance sole frame at the start of the step.

Half of the foot yaw before the offset and half after makes the direction of travel the bisector of
the two feet, so that step length and spacing keep their meaning with feet turned out.
"""


def swing_sole_chain(rise: float) -> tuple[Displacement, ...]:
    """Return `SWING_SOLE_CHAIN` for a front foot that stands higher than the rear one by a rise."""
    if rise == 0.0:
        return SWING_SOLE_CHAIN
    return (*SWING_SOLE_CHAIN[:-1], Displacement(_Z, False, None, -rise), SWING_SOLE_CHAIN[-1])


def landing_sole_chain(rise: float) -> tuple[Displacement, ...]:
    """Return the displacements of the front sole from the rear one at the end of a step.

    The mirror image of `swing_sole_chain`, seen from its other end.
    """
    up = () if rise == 0.0 else (Displacement(_Z, False, None, rise),)
    return (
        Displacement(_Z, True, FOOT_YAW, 0.5), *up, Displacement(_Y, False, FOOT_SPACING),
        Displacement(_X, False, STEP_LENGTH), Displacement(_Z, True, FOOT_YAW, 0.5),
    )  # fmt: skip


def drive(chain: tuple[Displacement, ...], count: int = len(GEOMETRY)) -> Array:
    """Return the matrix from geometric quantities, `count` of them, to displacements."""
    matrix = np.zeros((len(chain), count))
    for row, joint in enumerate(chain):
        if joint.quantity is not None:
            matrix[row, joint.quantity] = joint.factor
    return matrix


class Placing:
    """Chains of displacements as joints of one model.

    Attributes:
        drives: from `count` geometric quantities to the displacements of each chain, (k, count).
    """

    def __init__(self, *chains: tuple[Displacement, ...], count: int = len(GEOMETRY)) -> None:
        """Take displacements from the stance sole outwards."""
        self._model, self._ends = pin.Model(), list[tuple[int, slice, pin.SE3]]()
        for chain in chains:
            carrier, end, first = 0, pin.SE3.Identity(), self._model.nq
            for joint in chain:
                point = pin.SE3(np.eye(3), _ZERO if joint.point is None else joint.point)
                kind = _TURN if joint.turns else _SHIFT
                name = f"displacement {self._model.nq}"
                carrier = self._model.addJoint(carrier, kind(joint.axis), end * point, name)
                end = point.inverse()
            self._ends.append((carrier, slice(first, self._model.nq), end))
        self._data = self._model.createData()
        self.drives = [drive(chain, count) for chain in chains]
        self._drive = np.concatenate(self.drives)
        still = (joint.quantity is None for chain in chains for joint in chain)
        factors = (joint.factor for chain in chains for joint in chain)
        self._fixed = np.array([f if s else 0.0 for f, s in zip(factors, still, strict=True)])

    def at(self, geometry: Array) -> list[tuple[pin.SE3, Array]]:
        """Return of each chain the placement and the world axes of its displacements, (k, 6).

        Args:
            geometry: the geometric quantities, shape (count,) or more.
        """
        amounts = self._drive @ geometry[: self._drive.shape[1]] + self._fixed
        axes = pin.computeJointJacobians(self._model, self._data, amounts).T.copy()
        placements = self._data.oMi
        return [(placements[last] * end, axes[own]) for last, own, end in self._ends]


def place(chain: tuple[Displacement, ...], geometry: Array) -> tuple[pin.SE3, Array]:
    """Return what `Placing.at` does for one chain and quantities (10,)."""
    return Placing(chain).at(geometry)[0]


_TURN, _SHIFT = pin.JointModelRevoluteUnaligned, pin.JointModelPrismaticUnaligned
_CARRIERS = [0, 0, 1]  # pelvis or swing sole, of which each of `Posture.points` is one

FEET = len(GEOMETRY)
"""Place of further geometric quantities, the angles of feet that have turned about a line of their
sole [rad]: of the rear foot, then of the front one, as far as they do."""


@dataclass(frozen=True)
class Posture:
    """Double support at the start of the step.

    Attributes:
        q_start: joint angles [rad], shape (n,).
        legs: from ankle centre to hip centre, in stance sole axes [m], shape (2, 3).
        points: hips of both legs, then the swing ankle, in the stance sole frame [m], shape (3, 3).
        pelvis, sole: placements of pelvis and swing sole that the quantities ask for, in the
            stance sole frame.
        pelvis_axes, sole_axes: world axes of the displacement chains, shape (k, 6).
        drives: from the geometric quantities to the displacements of either chain, (k, G).
        loops: lifted form only: where pelvis and swing sole ought to be, seen from where they are.
    """

    q_start: Array
    legs: Array
    points: Array
    pelvis: pin.SE3
    sole: pin.SE3
    pelvis_axes: Array
    sole_axes: Array
    drives: tuple[Array, Array]
    loops: tuple[pin.SE3, ...] = ()

    @cached_property
    def twists(self) -> Array:
        """Twists of pelvis and swing sole per unit of each quantity, shape (2, 6, G)."""
        on_pelvis, on_sole = self.drives
        return np.array([self.pelvis_axes.T @ on_pelvis, self.sole_axes.T @ on_sole])

    @cached_property
    def moved(self) -> Array:
        """Velocities of `points` per unit of each quantity, shape (3, 3, G)."""
        twists = self.twists[_CARRIERS]
        return np.asarray(twists[:, :3] - skew(self.points) @ twists[:, 3:])

    @cached_property
    def gaps(self) -> Array:
        """How far pelvis and swing sole are from where they ought to be, shape (0 or 2, 6)."""
        return np.array([loop_gap(loop) for loop in self.loops]).reshape(-1, 6)


@dataclass(frozen=True)
class PostureDerivatives:
    """Derivatives of a Posture with respect to the boundary's coordinates, B of them.

    The coordinates are the G geometric quantities, ten and the turns of the feet that have one; in
    the lifted form the n joint angles come before them.

    Attributes:
        q_start: shape (n, B).
        legs: shape (2, 3, B).
        joint_axes: motion axes of all joints at q_start, shape (all, 6).
        gaps: shape (0 or 2, 6, B).
        loop_axes: lifted form only: axes of each loop's chain in its base.
    """

    q_start: Array
    legs: Array
    joint_axes: Array
    gaps: Array
    loop_axes: tuple[Array, ...] = ()


class DoubleSupport(compiled.MadeAnew, ABC):
    """Two feet on the ground and a pelvis, placed by the G geometric quantities."""

    def __init__(
        self,
        robot: Robot,
        hinge: Hinge | None = None,
        rise: float = 0.0,
        landing: Hinge | None = None,
    ) -> None:
        """Prepare what does not depend on the quantities.

        Args:
            hinge: about which the rear foot has turned; None: flat.
            rise: of the front foot over the rear one [m].
            landing: line of the front foot, the stance foot, on which it has landed; None: flat.
        """
        self.robot = robot
        self.pelvis_chain: tuple[Displacement, ...] = PELVIS_CHAIN
        self.sole_chain = swing_sole_chain(rise)
        self.count = FEET
        if hinge is not None:
            turn = Displacement(hinge.axis, True, self.count, point=hinge.point)
            self.sole_chain, self.count = (*self.sole_chain, turn), self.count + 1
        if landing is not None:  # both chains begin at the sole, the quantities at its footprint
            back = Displacement(landing.axis, True, self.count, -1.0, landing.point)
            self.count += 1
            self.pelvis_chain = (back, *self.pelvis_chain)
            self.sole_chain = (back, *self.sole_chain)
        self._placing = Placing(self.pelvis_chain, self.sole_chain, count=self.count)
        self.drives = self._placing.drives[0], self._placing.drives[1]
        self.kinematics = LegKinematics(robot)

    @abstractmethod
    def posture(self, geometry: Array, q_start: Array) -> Posture:
        """Return the posture for geometric quantities, shape (G,).

        Args:
            q_start: joint angles (n,); empty unless they are parameters.

        Raises:
            EvaluationError: a quantity is not finite.
            UnreachableError: a leg cannot reach, or the feet or pelvis are misplaced.
        """

    @abstractmethod
    def derivatives(self, posture: Posture) -> PostureDerivatives:
        """Return the derivatives of a posture."""

    @abstractmethod
    def hessian(
        self,
        posture: Posture,
        derivatives: PostureDerivatives,
        q_weights: Array,
        leg_weights: Array,
        gap_weights: Array,
    ) -> Array:
        """Return the Hessian of weights . (q_start, legs, gaps), shape (B, B)."""

    def place(self, geometry: Array) -> tuple[tuple[pin.SE3, Array], tuple[pin.SE3, Array]]:
        """Return placement and displacement axes (k, 6) of pelvis and of swing sole.

        Raises:
            EvaluationError: a geometric quantity is not finite.
        """
        if not np.isfinite(geometry).all():
            raise EvaluationError("a geometric quantity is not finite")
        pelvis, sole = self._placing.at(geometry)
        return pelvis, sole

    def placed(self, geometry: Array) -> tuple[Array, Array, pin.SE3, pin.SE3, Array, Array]:
        """Return legs, points, pelvis, sole, pelvis_axes and sole_axes, as of `Posture`.

        Raises:
            EvaluationError: a geometric quantity is not finite.
        """
        if compiled.in_use() and np.isfinite(geometry).all():
            frames, on_pelvis, on_sole, legs, points = self._compiled.at(geometry)
            return legs, points, pin.SE3(frames[0]), pin.SE3(frames[1]), on_pelvis, on_sole
        (pelvis, on_pelvis), (sole, on_sole) = self.place(geometry)
        return *self.kinematics.legs(pelvis, sole), pelvis, sole, on_pelvis, on_sole

    @cached_property
    def _compiled(self) -> compiled.kernels.Placing:
        legs, chains = self.robot.legs, (self.pelvis_chain, self.sole_chain)
        every = [one for chain in chains for one in chain]
        point = (_ZERO if one.point is None else one.point for one in every)
        return compiled.kernels.Placing(
            counts=[len(chain) for chain in chains],
            turns=[one.turns for one in every],
            quantities=[-1 if one.quantity is None else one.quantity for one in every],
            facts=np.array([[e.factor, *e.axis, *p] for e, p in zip(every, point, strict=True)]),
            hips=legs.hips,
            ankles=legs.ankles,
        )

    def slopes(self, posture: Posture, axes: Array = _NO_JOINTS) -> tuple[Array, Array]:
        """Return the jacobians of joints and legs in the geometric quantities, (m, G), (2, 3, G).

        Args:
            axes: of the joints of two legs of six that follow, in the world, shape (12, 6); or of
                none, shape (0, 6).

        Raises:
            UnreachableError: a leg is singular.
        """
        if compiled.in_use():
            joints, legs = compiled.kernels.support_slopes(*self._chains(posture), axes)
            return regular(joints), legs
        joints = closure_jacobian(axes, *posture.twists) if len(axes) else np.zeros((0, self.count))
        legs = posture.moved[:2].copy()
        legs[1] -= posture.moved[2]
        return joints, legs

    def curvature(
        self,
        posture: Posture,
        leg_weights: Array,
        axes: Array = _NO_JOINTS,
        slopes: Array | None = None,
        q_weights: Array = _ZERO[:0],
    ) -> Array:
        """Return the Hessian in the geometric quantities of weighed legs and joints, shape (G, G).

        Along straight lines in the quantities both sides of each closure accelerate:
        S q'' + (acceleration of the leg) = (acceleration of the displacement chain).

        Args:
            leg_weights: shape (2, 3).
            axes, slopes: of joints that follow and their jacobian, as of `slopes`.
            q_weights: of these joints, shape (m,).

        Raises:
            UnreachableError: a leg is singular.
        """
        if slopes is None:
            slopes = np.zeros((0, self.count))
        if compiled.in_use():
            given = axes, slopes, q_weights, leg_weights
            H = compiled.kernels.support_hessian(*self._chains(posture), *given)
            return regular(H) if len(axes) else H
        if not len(axes):
            return self._target_hessian(posture, np.zeros((2, TWIST)), leg_weights)
        forces = closure_forces(axes, q_weights)
        own = chain_hessian(axes, forces[1])
        stance = slice(self.robot.tree.stance)
        own[stance, stance] += chain_hessian(axes[stance], forces[0])
        H = self._target_hessian(posture, forces, leg_weights)
        return np.asarray(H - slopes.T @ own @ slopes)

    def _chains(self, posture: Posture) -> tuple[Array, Array, Array, Array, Array]:
        """Axes and drives of the displacements of pelvis and sole, and the points on them."""
        on_pelvis, on_sole = self.drives
        return posture.pelvis_axes, on_pelvis, posture.sole_axes, on_sole, posture.points

    def _target_hessian(self, posture: Posture, forces: Array, leg_weights: Array) -> Array:
        """Hessian in the quantities of weighed legs and of what forces (2, 6) pair with."""
        of_points = np.array([*leg_weights, -leg_weights[1]])
        on_points = np.concatenate([of_points, cross(posture.points, of_points)], axis=1)
        of_pelvis, of_sole = self.drives
        pelvis = chain_hessian(posture.pelvis_axes, forces[0] + on_points[0] + on_points[1])
        sole = chain_hessian(posture.sole_axes, forces[1] + on_points[2])
        # A point of a body accelerates by its spatial acceleration there + w x (l + w x p), and
        # weight . (w x v) = -w . (weight x v).
        turned = skew(of_points) @ posture.moved
        across = (posture.twists[_CARRIERS, 3:].swapaxes(1, 2) @ turned).sum(axis=0)
        H = of_pelvis.T @ pelvis @ of_pelvis + of_sole.T @ sole @ of_sole
        return np.asarray(H - (across + across.T) / 2.0)


def refuse_undetermined(robot: Robot) -> None:
    """Refuse the closed form for a robot whose joint angles pelvis and feet do not determine.

    Raises:
        InputError: the robot has other joints than two legs of six, or joints follow others.
    """
    tree = robot.tree
    if not robot.coupling.none:
        raise InputError(
            "boundary 'closed' solves for two legs of six joints that all have motors; in this "
            f"robot {tree.size - len(robot.joint_names)} follow others: take boundary 'lifted'"
        )
    if not tree.determined:
        raise InputError(
            "boundary 'closed' solves for two legs of six joints and nothing else; this robot has "
            f"{tree.size} joints, {tree.stance} in each leg: take boundary 'lifted'"
        )


class InverseKinematicsSupport(DoubleSupport):
    """The paper's form: q_start by inverse kinematics; B = G (see `refuse_undetermined`)."""

    _last: tuple[bytes, Posture] | None = None

    def posture(self, geometry: Array, q_start: Array) -> Posture:
        """Return the posture; the last one is kept: a walk is looked at on one grid after another.

        Raises:
            UnreachableError: a leg cannot reach, or the feet or pelvis are misplaced.
        """
        del q_start
        known = geometry.tobytes()
        if self._last is not None and self._last[0] == known:
            return self._last[1]
        legs, points, pelvis, sole, on_pelvis, on_sole = self.placed(geometry)
        try:
            q_start = self.kinematics.solve(pelvis, sole, legs)
        except UnreachableError as error:
            raise UnreachableError(
                f"{error} (pelvis height {fixed(geometry[PELVIS_HEIGHT], 4)} m, "
                f"pelvis {fixed(geometry[PELVIS_FORWARD], 4)} m forward of the stance toes, "
                f"step length {fixed(geometry[STEP_LENGTH], 4)} m, "
                f"foot spacing {fixed(geometry[FOOT_SPACING], 4)} m)"
            ) from error
        axes = on_pelvis, on_sole
        found = Posture(q_start, legs, points, pelvis, sole, *axes, self.drives)
        self._last = known, found
        return found

    def derivatives(self, posture: Posture) -> PostureDerivatives:
        axes = self.kinematics.axes(posture.q_start)
        return PostureDerivatives(*self.slopes(posture, axes), axes, np.zeros((0, 6, self.count)))

    def hessian(
        self,
        posture: Posture,
        derivatives: PostureDerivatives,
        q_weights: Array,
        leg_weights: Array,
        gap_weights: Array,
    ) -> Array:
        del gap_weights
        joints = derivatives.joint_axes, derivatives.q_start, q_weights
        return self.curvature(posture, leg_weights, *joints)


def _loop_drive(count: int, tangent: Tangent, displacements: Array) -> Array:
    """Matrix from (q_start, geometric quantities) to a loop's coordinates, shape (m, n + G).

    The loop runs back through the first `count` joints, then out along the displacements.
    """
    joints = len(tangent.of.free)
    matrix = np.zeros((count + len(displacements), joints + displacements.shape[1]))
    matrix[:count, :joints] = tangent.matrix[:count][::-1]
    matrix[count:, joints:] = displacements
    return matrix


class JointAngleSupport(DoubleSupport):
    """q_start is a parameter; the gaps of both loops must vanish; B = n + G."""

    @property
    def _counts(self) -> tuple[int, int]:
        """Joints from the stance foot to either target."""
        return self.robot.tree.stance, self.robot.tree.legs.stop

    @cached_property
    def _affine_drives(self) -> tuple[Array, ...]:
        robot = self.robot
        return self._drives_at(robot.coupling.at(np.zeros(len(robot.joint_names))))

    def _drives_at(self, tangent: Tangent) -> tuple[Array, ...]:
        return tuple(
            _loop_drive(count, tangent, drive)
            for count, drive in zip(self._counts, self.drives, strict=True)
        )

    def _loop_drives(self, q_start: Array) -> tuple[Array, ...]:
        coupling = self.robot.coupling
        return self._affine_drives if coupling.affine else self._drives_at(coupling.at(q_start))

    def posture(self, geometry: Array, q_start: Array) -> Posture:
        """Return the posture at the joint angles given, and its gaps.

        Raises:
            EvaluationError: pelvis or foot are turned by more than a right angle.
        """
        legs, points, pelvis, sole, on_pelvis, on_sole = self.placed(geometry)
        pelvis_is, sole_is = self.kinematics.placements(q_start)
        loops = (pelvis_is.inverse() * pelvis, sole_is.inverse() * sole)
        for name, loop in zip(("pelvis", "swing foot"), loops, strict=True):
            if np.trace(loop.rotation) < 1.0:  # its sine, which the rows read, vanishes again
                raise EvaluationError(f"the {name} is turned by more than a right angle")
        axes = on_pelvis, on_sole
        return Posture(q_start, legs, points, pelvis, sole, *axes, self.drives, loops)

    def derivatives(self, posture: Posture) -> PostureDerivatives:
        axes = self.kinematics.axes(posture.q_start)
        chains = self._loop_axes(posture, axes)
        gaps = [
            loop_gap_jacobian(loop, chain) @ drive
            for loop, chain, drive in zip(
                posture.loops, chains, self._loop_drives(posture.q_start), strict=True
            )
        ]
        n = len(posture.q_start)
        legs = np.concatenate([np.zeros((2, 3, n)), self.slopes(posture)[1]], axis=2)
        return PostureDerivatives(np.eye(n, legs.shape[2]), legs, axes, np.stack(gaps), chains)

    def hessian(
        self,
        posture: Posture,
        derivatives: PostureDerivatives,
        q_weights: Array,
        leg_weights: Array,
        gap_weights: Array,
    ) -> Array:
        del q_weights  # q_start is linear in the coordinates
        n = len(posture.q_start)
        H = np.zeros((n + self.count, n + self.count))
        H[n:, n:] = self.curvature(posture, leg_weights)
        drives = self._loop_drives(posture.q_start)
        tangent = self.robot.coupling.at(posture.q_start)
        for loop, axes, count, drive, weight in zip(
            posture.loops, derivatives.loop_axes, self._counts, drives, gap_weights, strict=True
        ):
            H += drive.T @ loop_gap_hessian(loop, axes, weight) @ drive
            if tangent.bend is not None:
                by_joint = np.zeros(self.robot.tree.size)
                by_joint[:count] = (weight @ loop_gap_jacobian(loop, axes))[count - 1 :: -1]
                H[:n, :n] += tangent.of.diagonal(tangent.bend * by_joint)
        return H

    def _loop_axes(self, posture: Posture, axes: Array) -> tuple[Array, ...]:
        """Back through the joints to the stance sole, then out along the displacements."""
        targets = ((posture.pelvis, posture.pelvis_axes), (posture.sole, posture.sole_axes))
        chains = []
        for loop, count, (target, displacements) in zip(
            posture.loops, self._counts, targets, strict=True
        ):
            world = np.concatenate([-axes[count - 1 :: -1], displacements])
            to_body = loop * target.inverse()  # world axes into the body the loop starts from
            chains.append(world @ to_body.action.T)
        return tuple(chains)
