"""A walk evaluated as the paper did: instant by instant, with its own recursive algorithm.

Steps 2 to 5 of the algorithm that closes section 5, on the chain of Table 1: inverse kinematics by
Newton's method, impact by Walker's method and Eqs. (16)-(20), splines, and at every instant the
Newton-Euler recursion, Eqs. (2)-(11). Pinocchio only hands over the robot's geometry once, and
nothing is done for all instants at once. What turns these quantities into rows (limits, scales) is
gaitopt's, so that both pose the same program.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.errors import EvaluationError, UnreachableError
from gaitopt.gait import quantities
from gaitopt.gait.double_support import PELVIS_CHAIN, SWING_SOLE_CHAIN, Displacement
from gaitopt.gait.parameters import STEP_LENGTH
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.quantities import Quantity
from gaitopt.mechanics.chain_build import chain_of_robot
from gaitopt.mechanics.newton_euler import (
    SOLE_AXES,
    Chain,
    at_rest,
    base_in_sole_axes,
    hat,
    impact,
    impulse_on_foot,
    inverse_dynamics,
    link_placements,
    sole_axes,
    sole_placement,
    turned,
)
from gaitopt.model.robot import Robot
from gaitopt.nlp import NLP, Array, Point, Values

PELVIS = 6
"""Link of Table 1 that is pelvis and trunk."""
SEED_KNEE, SEED_REACH = 0.6, 0.94
"""Posture from which the inverse kinematics start: flexion [rad], and length of the legs over the
straight one."""
MAX_STEP, LAST_STEP, MAX_ITERATIONS = 0.5, 1e-7, 40
"""Of Newton's method: longest step, and the last one [rad]: it doubles the digits every time."""

Placement = tuple[Array, Array]
"""Rotation (3, 3) and origin (3,) [m] in the stance sole frame."""


class PaperProblem(NLP):
    """The same program as a `WalkProblem`; values only, at the cost of the paper's evaluation."""

    def __init__(self, problem: WalkProblem) -> None:
        self.problem = problem
        self.variables, self.rows = problem.variables, problem.rows
        self.cost_scale, self.has_hessian = problem.cost_scale, False
        self._chain = chain_of_robot(problem.robot)
        self._legs = _Legs(problem.robot, self._chain)
        model = problem.robot.model
        self._gravity = float(np.linalg.norm(model.gravity.linear))

    def values(self, x: Array) -> Values:
        """Return cost and scaled rows at x (P,)."""
        problem, layout = self.problem, self.problem.layout
        geometry = layout.geometry_of(x)
        q_start, legs = self._legs.posture(geometry)
        q_end, rate_before = problem.robot.mirror @ q_start, x[layout.rates]
        velocity, I13 = impact(self._chain, q_end, at_rest(rate_before))
        rate_start = problem.robot.mirror @ velocity[6:]
        knots = x[layout.knots].reshape(-1, 12)
        coefficients = np.vstack([q_start, knots, q_end, rate_start, rate_before])
        duration, length = float(geometry[-1]), float(geometry[STEP_LENGTH])
        reads = self._over_step(problem.model.basis.at(duration), coefficients) | {
            quantities.IMPULSE: impulse_on_foot(self._chain, I13)[None],
            quantities.SOLE_TWIST: base_in_sole_axes(velocity)[None, :6],
            quantities.LEGS: legs,
            quantities.TRAVEL: np.array([[length, duration]]),
        }
        effort = float(problem.grid.weights @ (reads[quantities.TORQUE] ** 2).sum(axis=1))
        rows = [(b.function.value(b.take(reads)) / b.scale).ravel() for b in problem.blocks]
        return Values(x, duration / length * effort, np.concatenate(rows))

    def point(self, x: Array) -> Point:
        """Not available: the paper's method takes differences, or its section 5."""
        raise EvaluationError("the paper's evaluation has no derivatives")

    def hessian(self, x: Array, multipliers: Array, cost_weight: float) -> Array:
        """Not available."""
        raise EvaluationError("the paper's evaluation has no derivatives")

    def describe(self, row: int) -> str:
        """Name a row."""
        return self.problem.describe(row)

    def _over_step(self, basis: Array, coefficients: Array) -> dict[Quantity, Array]:
        """What is looked at throughout the step; basis (N, 3, n + 2)."""
        chain, corners = self._chain, self.problem.robot.sole.corners
        found: dict[Quantity, list[Array]] = {
            what: []
            for what in (
                quantities.ANGLES,
                quantities.RATES,
                quantities.TORQUE,
                quantities.WRENCH,
                quantities.CORNERS,
            )
        }
        for instant in basis:
            q, dq, ddq = instant @ coefficients
            R0, torque = inverse_dynamics(chain, q, dq, ddq, gravity=self._gravity)
            rotation, origin = sole_placement(chain, q)
            found[quantities.ANGLES].append(q)
            found[quantities.RATES].append(dq)
            found[quantities.TORQUE].append(torque)
            found[quantities.WRENCH].append(sole_axes(R0))
            found[quantities.CORNERS].append((corners @ rotation.T + origin).ravel())
        return {what: np.array(values) for what, values in found.items()}


class _Legs:
    """Joint angles of the double support, section 3.1: pelvis and swing sole are given."""

    def __init__(self, robot: Robot, chain: Chain) -> None:
        self._chain, self._legs = chain, robot.legs
        data = robot.model.createData()
        pin.framesForwardKinematics(robot.model, data, pin.neutral(robot.model))
        pelvis = data.oMf[robot.pelvis_frame]
        A, P = self._links(np.zeros(12))
        self._rotation = A[PELVIS].T @ pelvis.rotation
        self._origin = A[PELVIS].T @ (pelvis.translation - P[PELVIS])
        self._seed = self._standing()

    def posture(self, geometry: Array) -> tuple[Array, Array]:
        """Return joint angles (12,) [rad], and both legs from ankle to hip (2, 3) [m]."""
        pelvis, sole = _placed(PELVIS_CHAIN, geometry), _placed(SWING_SOLE_CHAIN, geometry)
        hips = self._legs.hips @ pelvis[0].T + pelvis[1]
        ankles = np.stack([self._legs.ankles[0], sole[0] @ self._legs.ankles[1] + sole[1]])
        if np.linalg.norm(hips - ankles, axis=1).max() > self._legs.reach:
            raise UnreachableError("a leg is too short")
        q = self._newton(self._seed, pelvis, sole)
        bend = self._legs.flexion * (q[list(self._legs.knees)] - self._legs.straight)
        if bend.min() < 0.0:
            raise UnreachableError("a knee is bent backwards")
        return q, hips - ankles

    def _standing(self) -> Array:
        """Feet below the hips, trunk upright, knees bent."""
        legs, q = self._legs, np.zeros(12)
        q[list(legs.knees)] = legs.straight + legs.flexion * SEED_KNEE
        spacing = float(np.ptp(legs.hips[:, 1]))
        up = np.array([0.0, spacing / 2.0, SEED_REACH * legs.reach])
        pelvis = np.eye(3), legs.ankles[0] + up - legs.hips.mean(axis=0)
        sole = np.eye(3), legs.ankles[0] + np.array([0.0, spacing, 0.0]) - legs.ankles[1]
        return self._newton(q, pelvis, sole)

    def _newton(self, q: Array, pelvis: Placement, sole: Placement) -> Array:
        for _ in range(MAX_ITERATIONS):
            A, P = self._links(q)
            at_pelvis = A[PELVIS] @ self._rotation, A[PELVIS] @ self._origin + P[PELVIS]
            at_sole = sole_placement(self._chain, q)
            gap = np.concatenate([_gap(pelvis, at_pelvis), _gap(sole, at_sole)])
            axes, points = A[1:, :, 2] * self._chain.sign[:, None], P[1:]
            slope = np.zeros((12, 12))
            slope[:6, :PELVIS] = _twists(axes[:PELVIS], points[:PELVIS], at_pelvis[1])
            slope[6:] = _twists(axes, points, at_sole[1])
            try:
                step = np.linalg.solve(slope, gap)
            except np.linalg.LinAlgError as error:
                raise UnreachableError("a leg is singular") from error
            largest = float(np.abs(step).max())
            q = q + step * min(1.0, MAX_STEP / max(largest, MAX_STEP))
            if largest < LAST_STEP:
                return q
        raise UnreachableError("the legs found no posture")

    def _links(self, q: Array) -> Placement:
        """Rotations (13, 3, 3) and origins (13, 3) of the link frames in the stance sole frame."""
        A, P = link_placements(self._chain, q)
        return SOLE_AXES @ A, turned(P)


def _twists(axes: Array, points: Array, end: Array) -> Array:
    """Columns (6, n): velocity of a point and angular velocity per unit of each joint's rate."""
    return np.vstack([np.cross(axes, end - points).T, axes.T])


def _gap(target: Placement, at: Placement) -> Array:
    """Displacement that is left to go, shape (6,); its angle is a sine, zero at the target."""
    turn = target[0] @ at[0].T
    angle = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return np.concatenate([target[1] - at[1], angle / 2.0])


def _placed(chain: tuple[Displacement, ...], geometry: Array) -> Placement:
    """Follow a chain of displacements from the stance sole."""
    rotation, origin = np.eye(3), np.zeros(3)
    for joint in chain:
        amount = joint.factor * geometry[joint.quantity]
        if joint.turns:
            K = hat(joint.axis)
            turn = np.eye(3) + np.sin(amount) * K + (1.0 - np.cos(amount)) * K @ K
            rotation = rotation @ turn
        else:
            origin = origin + rotation @ (amount * joint.axis)
    return rotation, origin
