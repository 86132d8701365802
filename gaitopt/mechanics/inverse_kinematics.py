"""Inverse kinematics of the two legs and closure of their loops, with exact derivatives (3.1).

Both feet on the ground close the chain: pelvis and swing sole have given placements. For legs of
six joints the joint angles follow: "twist of the joints = twist of the target" is one linear solve,
and the acceleration of a serial chain gives the second derivatives.

A loop gap tells how far given joint angles are from that. It walks each loop as one serial chain,
from a body back to the ground through its joints, and out again along the displacements to where
the body ought to be; the chain ends where it began exactly when the posture fits.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
import pinocchio as pin

from gaitopt.bounds import fixed
from gaitopt.errors import UnreachableError
from gaitopt.mechanics import compiled
from gaitopt.mechanics.spatial import cross_force_matrix, skew, solve, symmetric
from gaitopt.model.joint_tree import TWIST
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array

_RANK = 1e-6  # of the largest singular value: directions in which a leg cannot be moved
_LAST_STEP = 1e-7  # rad: Newton is quadratic, so the error left is below rounding
_MAX_ITERATIONS = 40
_BRANCHES = 2  # more searches, each from the last one's posture, its knees bent the other way
_MAX_STEP = 0.5  # rad: keeps Newton on the branch of the seed
_SEED_KNEE = 0.6  # rad: flexion of the posture every search starts from
_SEED_REACH = 0.94  # of the leg's length, for the seed posture
_SEED_STEP = 0.5  # of the leg's length: a usual step is near it, so few iterations are left
_NO_POSTURE = (
    "the legs found no posture for this double support; lower the pelvis, shorten the step "
    "or bring the trunk closer to upright"
)


class LegKinematics:
    """Solves for the joint angles of a double-support posture.

    Legs of six joints have one solution on each branch of the knees; with more joints the search
    takes the shortest steps, with fewer it ends nearest to the targets. Other joints stay where the
    robot's posture has them. Every search starts from the same bent posture, so the result is a
    pure function of the targets.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._model = robot.model
        self._data = robot.model.createData()
        self._q = pin.neutral(robot.model)

    def legs(self, pelvis: pin.SE3, sole: pin.SE3) -> tuple[Array, Array]:
        """Return vectors from ankle to hip centres (2, 3); hips, then swing ankle, world (3, 3)."""
        legs = self.robot.legs
        points = np.empty((3, 3))
        points[:2] = legs.hips @ pelvis.rotation.T + pelvis.translation
        points[2] = sole.act(legs.ankles[1])
        vectors = points[:2] - legs.ankles[0]
        vectors[1] = points[1] - points[2]
        return vectors, points

    def solve(self, pelvis: pin.SE3, sole: pin.SE3, legs: Array | None = None) -> Array:
        """Return the joint angles that place pelvis and swing sole [rad], shape (n,).

        Args:
            pelvis, sole: placements in the stance sole frame.
            legs: vectors from ankle to hip centres [m], shape (2, 3), if they are known.

        Raises:
            UnreachableError: a leg is too short, or the search does not converge.
        """
        self._check_reach(self.legs(pelvis, sole)[0] if legs is None else legs)
        q = self._search(self._seed, pelvis, sole)
        bend = min(self._bent(q))
        if bend < 0.0:
            raise UnreachableError(
                f"the search ended with a knee bent backwards by {fixed(-bend, 3)} rad; "
                "lower the pelvis or shorten the step"
            )
        return q

    def _search(self, q: Array, pelvis: pin.SE3, sole: pin.SE3) -> Array:
        """Return the posture (n,) that a search from q ends in, its knees forward if it can."""
        q = self._newton(q, pelvis, sole)
        for _ in range(_BRANCHES):
            bend = self._bent(q)
            if min(bend) >= 0.0:
                return q
            self._bend(q, np.abs(bend))  # the leg's other branch
            # Hip and ankle lean as the backward knee had them: first let them come round.
            bent = self._newton(q, pelvis, sole, self._without_knees)
            q = self._newton(bent, pelvis, sole)
        # Too few joints may come nearer to the targets by a knee that bends backwards.
        return bent if min(self._bent(q)) < 0.0 and self._few else q

    def _bent(self, q: Array) -> Array:
        """Return how far the knees of a posture (n,) are bent from straight [rad], shape (2,)."""
        legs = self.robot.legs
        angles = self.robot.coupling.angles(q)[list(legs.knees)]
        return np.asarray(legs.flexion * (angles - legs.straight))

    def _bend(self, q: Array, bend: Array | float) -> None:
        """Bend the knees of a posture (n,) by angles from the straight legs [rad]."""
        legs = self.robot.legs
        for knee, angle in zip(legs.knees, legs.straight + legs.flexion * bend, strict=True):
            self.robot.coupling.put(q, knee, angle, self.robot.limits)

    def placements(self, q: Array) -> tuple[pin.SE3, pin.SE3]:
        """Return the placements of pelvis and swing sole at joint angles q (n,) [rad]."""
        self._q[7:] = self.robot.coupling.angles(q)
        pin.framesForwardKinematics(self._model, self._data, self._q)
        frames = self._data.oMf
        return frames[self.robot.pelvis_frame].copy(), frames[self.robot.swing_frame].copy()

    def axes(self, q: Array) -> Array:
        """Return the axes of all joints in the stance sole frame at q (n,) [rad], (all, 6)."""
        self._q[7:] = self.robot.coupling.angles(q)
        J = pin.computeJointJacobians(self._model, self._data, self._q)
        return np.asarray(J[:, 6:].T).copy()

    def _check_reach(self, legs: Array) -> None:
        bound = self.robot.legs.bound
        for name, leg in zip(("stance", "swing"), legs.tolist(), strict=True):
            distance = math.hypot(*leg)  # infinite where a square would overflow
            if distance > bound:
                raise UnreachableError(
                    f"the {name} leg is too short: hip and ankle are {fixed(distance, 4)} m "
                    f"apart, the straight leg measures {fixed(bound, 4)} m; "
                    f"lower the pelvis by at least {fixed(distance - bound, 4)} m or shorten "
                    "the step"
                )

    def _newton(self, q: Array, pelvis: pin.SE3, sole: pin.SE3, own: Array | None = None) -> Array:
        """Return the posture (n,) that Newton's method ends in, by the joints `own` or all."""
        model, data, robot = self._model, self._data, self.robot
        legs, stance, q = robot.tree.legs, robot.tree.stance, q.copy()
        free = self._free if own is None else own
        square = legs.stop == len(free) == 2 * TWIST
        if compiled.in_use() and square and robot.coupling.none:
            targets = np.array([pelvis.homogeneous, sole.homogeneous])
            q[legs], closed = compiled.bodies_of(robot).close_legs(
                q[legs], targets, _MAX_ITERATIONS, _LAST_STEP, _MAX_STEP
            )
            if closed:
                return q
            raise UnreachableError(_NO_POSTURE)
        matrix, gap = np.zeros((2 * TWIST, legs.stop)), np.empty(2 * TWIST)
        moved = slice(None) if len(free) == len(q) else free
        for _ in range(_MAX_ITERATIONS):
            self._q[7:] = robot.coupling.angles(q)
            J = pin.computeJointJacobians(model, data, self._q)
            at_pelvis = pin.updateFramePlacement(model, data, robot.pelvis_frame)
            gap[:TWIST] = pin.log6(pelvis * at_pelvis.inverse()).vector
            at_sole = pin.updateFramePlacement(model, data, robot.swing_frame)
            gap[TWIST:] = pin.log6(sole * at_sole.inverse()).vector
            columns = J[:, 6 : 6 + legs.stop]
            matrix[:TWIST, :stance], matrix[TWIST:] = columns[:, :stance], columns
            step = (
                solve(matrix, gap)
                if square
                else np.linalg.lstsq(
                    matrix @ robot.coupling.at(q).matrix[legs][:, free], gap, rcond=_RANK
                )[0]
            )
            largest = float(abs(step).max())
            if not math.isfinite(largest):
                break
            q[moved] += step * min(1.0, _MAX_STEP / max(largest, _MAX_STEP))
            if largest < _LAST_STEP:
                return q
        if (own is not None or self._few) and np.isfinite(q).all():
            return q  # the nearest posture
        raise UnreachableError(_NO_POSTURE)

    @cached_property
    def _free(self) -> Array:
        """Numbers of the free joints that turn those of the legs, shape (f,)."""
        return np.unique(self.robot.coupling.motor[self.robot.tree.legs])

    @property
    def _few(self) -> bool:
        """Whether the legs have too few joints to meet both targets."""
        return len(self._free) < 2 * TWIST

    @cached_property
    def _without_knees(self) -> Array:
        """Numbers of the free joints of the legs that turn no knee."""
        return np.setdiff1d(self._free, self.robot.coupling.motor[list(self.robot.legs.knees)])

    @cached_property
    def _seed(self) -> Array:
        """In double support, soles flat, trunk upright, knees bent: the seed of every search."""
        legs = self.robot.legs
        body, tree = self.robot.multibody, self.robot.tree
        legs_own = set(tree.names[tree.legs])
        others = [name not in legs_own for name in self.robot.joint_names]
        q = np.where(others, body.posture[body.moving], 0.0)
        self._bend(q, _SEED_KNEE)
        for step in (0.0, _SEED_STEP * legs.reach):
            q = self._search(q, *self.flat_feet(step, legs.stance_width))
        return q

    def flat_feet(self, step: float, spacing: float) -> tuple[pin.SE3, pin.SE3]:
        """Return upright pelvis, midway and with bent legs, and swing sole on the ground.

        Args:
            step: of the swing foot behind the stance foot [m].
            spacing: of the swing ankle to the left of the stance ankle [m].
        """
        legs = self.robot.legs
        height = math.sqrt((_SEED_REACH * legs.reach) ** 2 - (step / 2.0) ** 2)
        (ankle, other), middle = legs.ankles, legs.hips.mean(axis=0)
        pelvis = ankle + np.array([-step / 2.0, spacing / 2.0, height]) - middle
        sole = ankle + np.array([-step, spacing, 0.0]) - other
        return pin.SE3(np.eye(3), pelvis), pin.SE3(np.eye(3), sole)


def closure_matrix(axes: Array) -> Array:
    """Return the matrix from leg joint rates to the twists of pelvis and swing sole, (12, m).

    Args:
        axes: motion axes of the stance leg's joints, then of as many of the swing leg, (m, 6).
    """
    stance = len(axes) // 2
    matrix = np.zeros((2 * TWIST, len(axes)))
    matrix[:TWIST, :stance] = axes[:stance].T
    matrix[TWIST:] = axes.T
    return matrix


def closure_jacobian(axes: Array, pelvis_twists: Array, sole_twists: Array) -> Array:
    """Return d q / d p, shape (m, p), from the twists of the targets, shape (6, p) each."""
    return _solve(closure_matrix(axes), np.concatenate([pelvis_twists, sole_twists]))


def closure_forces(axes: Array, weights: Array) -> Array:
    """Return the forces (2, 6) on pelvis and sole that the joint weights (m,) are worth.

    They solve closure_matrix' f = weights, so weights . dq = f . (twists of the targets).
    """
    return _solve(closure_matrix(axes).T, weights).reshape(2, TWIST)


def chain_hessian(axes: Array, force: Array) -> Array:
    """Return the symmetric U with force . (acceleration of the chain's end) = rates' U rates.

    At constant rates the end of a serial chain accelerates by the sum over i < j of S_i x S_j
    (Featherstone, 2008, chapter 3).

    Args:
        axes: joint motion axes in order from the base, shape (j, 6).
        force: weights of the end's spatial acceleration.
    """
    # force . (S_i x S_j) = -(S_i x* force) . S_j
    return symmetric(axes @ cross_force_matrix(force).T @ axes.T) / -2.0


def _solve(matrix: Array, rhs: Array) -> Array:
    return regular(solve(matrix, rhs))


def regular(found: Array) -> Array:
    """Return what was solved for, of any shape, if it is finite.

    Raises:
        UnreachableError: it is not: a leg cannot be moved in all directions.
    """
    if not np.isfinite(found).all():
        raise UnreachableError(
            "a leg is singular (straight knee); lower the pelvis or shorten the step"
        )
    return found


def loop_gap(gap: pin.SE3) -> Array:
    """Return position and half the axial vector of the rotation of a loop's end, shape (6,).

    Both vanish when the loop closes; the second is sin(angle) times the axis [m, 1].
    """
    twisted = gap.rotation - gap.rotation.T
    axial = 0.5 * np.array([twisted[2, 1], twisted[0, 2], twisted[1, 0]])
    return np.concatenate([gap.translation, axial])


def loop_gap_jacobian(gap: pin.SE3, axes: Array) -> Array:
    """Return the derivative of `loop_gap` with respect to the chain's coordinates, shape (6, m).

    Args:
        gap: placement of the chain's end in its base.
        axes: motion axes in the base, in order from the base, shape (m, 6).
    """
    R, of_axes = gap.rotation, np.eye(TWIST)
    of_axes[:3, 3:] = -skew(gap.translation)
    of_axes[3:, 3:] = 0.5 * _trace_less(R)
    return np.asarray(of_axes @ axes.T)


def loop_gap_hessian(gap: pin.SE3, axes: Array, weights: Array) -> Array:
    """Return the Hessian of weights . loop_gap, shape (m, m).

    Along the chain, with i nearer to the base than j, `p_ij = w_i x p_j` and
    `R_ij = skew(w_i) skew(w_j) R`.

    Args:
        gap: placement of the chain's end in its base.
        axes: motion axes in the base, in order from the base, shape (m, 6).
        weights: of the six components.
    """
    felt, turned = -skew(weights[:3]), gap.rotation @ skew(weights[3:])
    of_axes = np.empty((3, TWIST))
    of_axes[:, :3] = felt
    of_axes[:, 3:] = 0.5 * _trace_less(turned) - felt @ skew(gap.translation)
    return symmetric(axes[:, 3:] @ of_axes @ axes.T)


def _trace_less(matrix: Array) -> Array:
    """The trace times 1, less the matrix, (3, 3)."""
    return np.asarray(float(matrix[0, 0] + matrix[1, 1] + matrix[2, 2]) * np.eye(3) - matrix)
