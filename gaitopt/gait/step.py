"""One step of the walk: everything computed at x, and its exact derivatives.

Having a `Step` means that the work is done (see `StepModel` for how). Quantities of the posture
that not every walk needs are computed only if a constraint reads them.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import field, replace
from functools import cached_property, lru_cache
from typing import Protocol

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.errors import EvaluationError
from gaitopt.gait import quantities
from gaitopt.gait.double_support import Posture, PostureDerivatives
from gaitopt.gait.foot_turn import FootTurn
from gaitopt.gait.parameters import DURATION, STEP_LENGTH
from gaitopt.gait.quantities import Quantity
from gaitopt.gait.spline import SplineInX
from gaitopt.gait.walk_point import Jacobians, Product
from gaitopt.mechanics.capsule_distance import CapsuleGaps, arm_pairs, leg_pairs
from gaitopt.mechanics.closed_chain import ClosedMotion, FrontFoot
from gaitopt.mechanics.forward_kinematics import (
    ROLL,
    YAW,
    Placements,
    PostureQuantity,
    PostureQuantityDerivatives,
    Trunk,
    placed_bodies,
)
from gaitopt.mechanics.impact import ClosedJump, FlatJump, ImpactDerivatives, ImpactState, Turning
from gaitopt.mechanics.single_support import SupportDerivatives, SupportState
from gaitopt.mechanics.spatial import apply
from gaitopt.model.coupling import Tangent
from gaitopt.model.joint_tree import TWIST
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array, Indices


class Period(Protocol):
    """What a walk repeats, as constraints and costs see it: a step, or a stride of two."""

    @property
    def duration(self) -> float:
        """Its duration [s]."""

    @property
    def step_length(self) -> float:
        """The way that is walked in it, of a stride along the path [m]."""

    @property
    def values(self) -> dict[Quantity, Array]:
        """Every quantity, see `read`."""

    def read(self, what: Quantity) -> Array:
        """Return a quantity, one row per instant (or leg), shape (K, entries)."""


@dataclass(frozen=True)
class Step:
    """Everything about one step at x.

    Attributes:
        x: parameters of the step (p,).
        geometry: geometric quantities, free and fixed (10,).
        posture: double support at the start.
        q_end: posture at the end, E q_start, (n,).
        rate_before: joint rates before the impact (n,) [rad/s].
        impact: the robot just after it.
        coefficients: of the spline (k + 4, n): knots, rate at start, rate at end; where the rates
            jump inside the step, as of `JumpingSpline`, (k + 6, n).
        motion: q, dq, ddq at the instants, shape (3, N, n).
        turn: the stance foot before the impact; None where it stands flat.
        landed: the landing foot after it; None where it lands flat.
        foot_motion: angles of the stance foot about the lines of it that rest, their rates and
            accelerations at the instants, shape (3, N, h): that on which it landed, then that on
            which it leaves, as far as it turns about them.
        support: single support at the instants.
        optional: quantities that only some constraints look at; without entries unless they do.
        double: its double support; None where an impact ends it. Then the end of the step is the
            lift-off, and `coefficients` are the stance leg's, (k + 6, 6); where an impact begins
            the double support `rate_before` and `impact` are of that, and they are those until
            then and those from then on, (k + 4 + 5, 6).
        flat: the impact by which a foot that landed on a line comes to lie flat; None where it does
            so without.
    """

    x: Array
    geometry: Array
    posture: Posture
    q_end: Array
    rate_before: Array
    impact: ImpactState
    coefficients: Array
    motion: Array
    support: SupportState
    optional: dict[Quantity, Array]
    foot_motion: Array
    turn: Turning | None = None
    landed: Turning | None = None
    double: DoubleSupportPart | None = None
    flat: FlatJump | None = None

    @property
    def hinges(self) -> int:
        """Joints between the ground and the stance foot: one for each line about which it turns."""
        return int(self.foot_motion.shape[2])

    @property
    def whole_motion(self) -> Array:
        """The stance foot's motion, then the joints', shape (3, N, h + n)."""
        return with_foot(self.foot_motion, self.motion)

    @property
    def double_support(self) -> DoubleSupportPart:
        """Its double support, of a step that has one."""
        assert self.double is not None
        return self.double

    @property
    def sole_twist(self) -> Array:
        """Twist of the old stance sole after the impact, in its footprint, (6,)."""
        twist = self.impact.sole_twist
        return twist if self.turn is None else self.turn.place.toActionMatrix() @ twist

    @property
    def impulse(self) -> Array:
        """Impulse of the ground on the landing foot, in its footprint, shape (6,)."""
        impulse = self.impact.impulse
        return impulse if self.landed is None else self.landed.on_ground @ impulse

    @property
    def impulse_standing(self) -> Array:
        """Impulse of the ground on the foot that stands, in its footprint, (6,); or none, (0,)."""
        if self.flat is not None:
            return self.flat.impulse
        if self.double is not None and self.double.struck is not None:
            return self.double.struck.rear
        return np.zeros(0)

    @property
    def duration(self) -> float:
        """T [s]."""
        return float(self.geometry[DURATION])

    @property
    def step_length(self) -> float:
        """Distance d walked in one step [m]."""
        return float(self.geometry[STEP_LENGTH])

    def read(self, what: Quantity) -> Array:
        """Return a quantity, one row per instant (or leg), shape (K, entries)."""
        return self.values[what]

    @cached_property
    def values(self) -> dict[Quantity, Array]:
        """Every quantity, see `read`."""
        effort, corners = self.support.effort, self.support.corners
        return {
            quantities.TORQUE: effort[:, 6 + self.hinges :],
            quantities.WRENCH: effort[:, :6],
            quantities.CORNERS: corners.reshape(len(corners), 3 * corners.shape[1]),
            quantities.ANGLES: self.motion[0],
            quantities.RATES: self.motion[1],
            quantities.ACCELERATIONS: self.motion[2],
            quantities.IMPULSE: self.impulse[None],
            quantities.SOLE_TWIST: self.sole_twist[None],
            quantities.LEGS: self.posture.legs,
            quantities.GAPS: self.posture.gaps,
            quantities.TRAVEL: self.geometry[None, [STEP_LENGTH, DURATION]],
            quantities.FOOT_TURN: foot_turn_rows(self.foot_motion.transpose(1, 0, 2)),
            quantities.FRONT_WRENCH: (
                np.zeros((len(effort), 0)) if self.double is None else self.double.front
            ),
            quantities.REAR_IMPULSE: self.impulse_standing[None],
            quantities.ADVANCE: np.zeros((1, 0)),
            **self.optional,
        }


@dataclass(frozen=True)
class DoubleSupportPart:
    """What of a step belongs to its double support, at M of its N instants.

    Attributes:
        motion: of the closed chain there.
        touchdown, liftoff: of the closed chain at its ends, at one instant each.
        sole: placement of the front sole in the stance sole frame.
        wrench: of the ground on the front foot there, in its sole frame [N, N·m], shape (M, 6).
        swing: coefficients of the swing leg's spline until touch-down, shape (k + 4, 6).
        front: that wrench at all instants, 0 while the foot swings, shape (N, 6).
        struck: the impact that begins it; None where the foot touches down at zero speed.
    """

    motion: ClosedMotion
    touchdown: ClosedMotion
    liftoff: ClosedMotion
    sole: pin.SE3
    wrench: Array
    swing: Array
    front: Array
    struck: ClosedJump | None = None

    @property
    def opens(self) -> bool:
        """Whether it begins the step; otherwise it ends it."""
        return False

    @cached_property
    def foot(self) -> FrontFoot:
        """The front foot."""
        return FrontFoot(self.sole, self.motion, self.wrench)

    def without_front(self, effort: Array, both: NDArray[np.bool_]) -> Array:
        """Return wrench and torques less what the front foot takes of them.

        Args:
            effort: wrench and torques with one foot on the ground, shape (N, 6 + h + n).
            both: at which instants both stand, shape (N,).
        """
        found, force, axes = effort.copy(), self.foot.force, self.motion.axes
        found[both, :TWIST] -= force
        found[both, TWIST : TWIST + axes.shape[1]] -= apply(axes, force)
        return found


@dataclass(frozen=True)
class DoubleSupportDerivatives:
    """Derivatives in x of what belongs to a double support, for the second ones.

    Attributes:
        stance, swing: of the coefficients of both legs, (K, 6, P).
        closed, touchdown, liftoff: of (u, du, ddu, g) at the instants of the double support and at
            its ends, (M, 3 (h + 6) + G, P), (1, 3 (h + 6) + G, P) each.
        wrench: derivatives of the front foot's, (M, 6, P).
        geometry: of the quantities that place the front foot, (G, P).
        jump, rear: of the impact's jump of the rates (n, P) and impulse on the rear foot (6, P),
            without entries where there is none.
    """

    stance: Array
    swing: Array
    closed: Array
    touchdown: Array
    liftoff: Array
    wrench: Array
    geometry: Array
    jump: Array
    rear: Array


@dataclass(frozen=True)
class StepDerivatives:
    """Derivatives of a step with respect to x.

    Attributes:
        posture, impact, support, optional: the local derivatives they are made of; no impact where
            a double support ends the step.
        coefficients: of the spline coefficients, shape (k + 4, n, P).
        motion: of (q, dq, ddq) at each instant, each of them with the foot's turns in front, shape
            (N, 3 (h + n), P).
        turns: of the stance foot.
        landing_angle: derivatives of the landing foot's, shape (P,); empty where it lands flat.
        double: of a step with a double support.
        jacobians: of each quantity, shape (K, entries, P).

    Those from `coefficients` on are empty until the local ones are chained.
    """

    posture: PostureDerivatives
    impact: ImpactDerivatives | None
    support: SupportDerivatives
    optional: dict[Quantity, PostureQuantityDerivatives]
    coefficients: Array = field(default_factory=lambda: np.zeros((0, 0, 0)))
    motion: Array = field(default_factory=lambda: np.zeros((0, 0, 0)))
    turns: tuple[ShapedTurn, ...] = ()
    landing_angle: Array = field(default_factory=lambda: np.zeros(0))
    double: DoubleSupportDerivatives | None = None
    jacobians: Jacobians = field(default_factory=lambda: Jacobians({}, {}))


@dataclass(frozen=True)
class ShapedTurn:
    """A turn of the stance foot and what shapes it, p numbers.

    Attributes:
        turn: linear in them.
        shape: their values, shape (p,).
        jacobian: their derivatives, shape (p, P).
    """

    turn: FootTurn
    shape: Array
    jacobian: Array

    def spline(self, duration: float, lasts: Array | None) -> SplineInX:
        """Return its spline, of one joint; arguments as of `SplineInX`."""
        linear = self.turn.coefficients
        values, jacobian = (linear @ self.shape)[:, None], (linear @ self.jacobian)[:, None]
        return SplineInX(self.turn.basis, duration, values, jacobian, lasts)


def foot_turn_rows(turned: Array) -> Array:
    """Return the stance foot's turn (N, 3), without entries where it has no hinge.

    Args:
        turned: angle, rate and acceleration of the hinges, or their derivatives, (N, 3, h, ...);
            at most one of them is not at 0.
    """
    count, _, hinges, *more = turned.shape
    return turned.sum(axis=2) if hinges else np.zeros((count, 0, *more))


def with_foot(foot: Array, joints: Array) -> Array:
    """Return tables (..., h) of the stance foot's turn and (..., n) of the joints side by side."""
    return np.concatenate([foot, joints], axis=-1) if foot.shape[-1] else joints


class ReducedDerivatives(PostureQuantityDerivatives):
    """Derivatives of a quantity of the posture in the joints that follow no other."""

    def __init__(self, of_all: PostureQuantityDerivatives, tangent: Tangent) -> None:
        """Reduce derivatives in all joints."""
        self._of_all, self._tangent = of_all, tangent
        self.value = of_all.value

    @cached_property
    def jacobian(self) -> Array:  # type: ignore[override]  # a field of others, as read-only
        """With respect to the angles of the joints that follow no other, shape (N, entries, n)."""
        return self._tangent.reduced(self._of_all.jacobian)

    def rows(self, instants: Indices, entries: Indices) -> Array:
        tangent = self._tangent
        if tangent.slope.ndim > 1:
            tangent = replace(tangent, slope=tangent.slope[instants])
        return tangent.reduced(self._of_all.rows(instants, entries))

    def along(self, step: Array) -> Array:
        return self._of_all.along(self._tangent.rates(step))

    def most(self, changes: Array) -> Array:
        tangent = replace(self._tangent, slope=np.abs(self._tangent.slope))
        return self._of_all.most(tangent.rates(changes))

    def vjp(self, weights: Array) -> Array:
        return self._tangent.reduced(self._of_all.vjp(weights))

    def hessian(self, weights: Array) -> Array:
        found, gradient = self._of_all.hessian(weights), self._of_all.vjp(weights)
        return self._tangent.reduced_twice(found, gradient)


OPTIONAL = (quantities.TRUNK, *quantities.BODY_GAPS)
_KEPT = 16  # sets of gaps: a walk has up to two, whatever its grids
_HEADING = 0.5  # of the foot yaw: the direction of travel in the stance sole's axes


@lru_cache(maxsize=_KEPT)
def _body_gaps(robot: Robot, standing: Robot, what: Quantity) -> CapsuleGaps:
    """Return the gaps of legs or arms; `standing` as of `PostureQuantities`."""
    pairs = (leg_pairs if what is quantities.LEG_GAPS else arm_pairs)(robot)
    hinges = standing.tree.size - robot.tree.size
    moved = ((replace(c, body=c.body + hinges) for c in pair) for pair in pairs.kept)
    return CapsuleGaps(standing.tree, tuple((a, b) for a, b in moved))


class PostureQuantities:
    """Quantity the optional quantities that were asked for; the others have no entries."""

    def __init__(
        self, robot: Robot, asked: Collection[Quantity] = (), standing: Robot | None = None
    ) -> None:
        """Prepare what does not depend on the posture.

        Args:
            asked: quantities that are wanted.
            standing: the biped with a hinge under its stance foot, if that turns.
        """
        standing = standing or robot
        self._read: dict[Quantity, PostureQuantity] = {}
        if quantities.TRUNK in asked:
            self._read[quantities.TRUNK] = Trunk(standing)
        for what in quantities.BODY_GAPS:
            if what in asked:
                self._read[what] = _body_gaps(robot, standing, what)
        self._standing = standing

    def placed(self, q: Array) -> Placements | None:
        """Return the bodies at postures q (N, n) [rad], if anything is read off them."""
        if not self._read:
            return None
        return placed_bodies(self._standing, self._standing.coupling.angles(q))

    def values(self, placed: Placements | None) -> dict[Quantity, Array]:
        """Return what is read off the bodies, of those asked for, shape (N, entries)."""
        if placed is None:
            return {}
        return {what: reading.value(placed) for what, reading in self._read.items()}

    def derivatives(
        self, placed: Placements | None, axes: Array, tangent: Tangent
    ) -> dict[Quantity, PostureQuantityDerivatives]:
        """Return the local derivatives of those asked for.

        Args:
            axes: of all joints, shape (N, all, 6).
            tangent: of all joints to those that follow no other.
        """
        if placed is None:
            return {}
        found = {what: reading.derivatives(placed, axes) for what, reading in self._read.items()}
        if tangent.of.none:
            return found
        return {what: ReducedDerivatives(at, tangent) for what, at in found.items()}


def completed(values: dict[Quantity, Array], foot_yaw: Array, count: int) -> dict[Quantity, Array]:
    """Return the optional quantities, shape (N, entries), entries = 0 unless asked for.

    Args:
        values: what was read off the bodies.
        foot_yaw: that the direction of travel bisects at each instant, from that at the start of
            the step to that at its end [rad], shape (N,).
        count: N.

    Raises:
        EvaluationError: the trunk is upside down at some instant.
    """
    trunk = values.get(quantities.TRUNK)
    if trunk is not None and np.abs(trunk[:, ROLL]).max(initial=0.0) > np.pi / 2:
        raise EvaluationError("the trunk is upside down")  # its pitch then reads as if it were not
    found = {what: np.zeros((count, 0)) for what in OPTIONAL} | values
    if quantities.TRUNK in values:
        found[quantities.TRUNK] = values[quantities.TRUNK].copy()
        found[quantities.TRUNK][:, YAW] -= _HEADING * foot_yaw
    return found


def chained(
    jacobian: dict[Quantity, PostureQuantityDerivatives], motion: Array, foot_yaw: Array | None
) -> dict[Quantity, Array]:
    """Return the derivatives in x of the optional quantities, those of `gap_products` left out.

    Args:
        jacobian: local derivatives.
        motion: derivatives of the joint angles, shape (N, n, P).
        foot_yaw: derivatives of `completed`'s, if it is free, shape (N, P).

    Returns:
        Shape (N, entries, P) each.
    """
    nothing = np.zeros((len(motion), 0, motion.shape[2]))
    found = {what: nothing for what in OPTIONAL if what not in jacobian}
    if quantities.TRUNK in jacobian:
        found[quantities.TRUNK] = trunk = jacobian[quantities.TRUNK].jacobian @ motion
        if foot_yaw is not None:
            trunk[:, YAW] -= _HEADING * foot_yaw
    return found


def gap_products(
    jacobian: dict[Quantity, PostureQuantityDerivatives], motion: Array
) -> dict[Quantity, Product]:
    """Return the derivatives in x of the gaps between bodies.

    Args:
        jacobian: local derivatives.
        motion: derivatives of (q, dq, ddq), shape (N, 3 n, P).
    """
    angles = motion[:, : motion.shape[1] // 3]
    gaps = (what for what in quantities.BODY_GAPS if what in jacobian)
    return {what: Product(jacobian[what], angles) for what in gaps}
