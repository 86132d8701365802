"""Starting points: a first guess that walks badly but is a walk, and a walk for other lengths."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.errors import UnreachableError
from gaitopt.gait.double_support import PELVIS_CHAIN, SWING_SOLE_CHAIN, place
from gaitopt.gait.parameters import (
    DURATION,
    FOOT_SPACING,
    PELVIS_FORWARD,
    PELVIS_HEIGHT,
    PELVIS_LATERAL,
    STEP_LENGTH,
    TRUNK_PITCH,
)
from gaitopt.gait.problem import WalkProblem
from gaitopt.mechanics.inverse_kinematics import LegKinematics
from gaitopt.nlp import Array

_CROUCH = 0.875  # hip height above the ankle over the leg's length; measured to start well
_LONGEST = 0.97  # of the leg's length, in double support
_TRUNK_PITCH = 0.05  # rad
_CLEAR_OF_GAP = 0.014  # m: the guess keeps this much off the lateral constraint
_EXTRA_LIFT = 0.02  # m above the clearance profile
_RATE_FRACTION = 0.5  # of the last secant: the foot slows down before it lands


def first_guess(problem: WalkProblem) -> Array:
    """Return a starting point x for a walk, shape (P,).

    Raises:
        UnreachableError: the step is too long for the legs.
    """
    geometry = _geometry(problem)
    kinematics = LegKinematics(problem.robot)
    pelvis, _ = place(PELVIS_CHAIN, geometry)
    rear, _ = place(SWING_SOLE_CHAIN, geometry)
    q_start = kinematics.solve(pelvis, rear)
    q_end = problem.robot.mirror @ q_start
    pelvis_end, front = kinematics.placements(q_end)
    count = problem.layout.postures
    lift = problem.task.margins.clearance + _EXTRA_LIFT
    knots = []
    for s in np.arange(1, count + 1) / (count + 1):
        sole = pin.SE3.Interpolate(rear, front, float(s))
        sole.translation = sole.translation + np.array([0.0, 0.0, lift * np.sin(np.pi * s)])
        knots.append(kinematics.solve(pin.SE3.Interpolate(pelvis, pelvis_end, float(s)), sole))
    last = geometry[DURATION] / (count + 1)
    rate_before = _RATE_FRACTION * (q_end - knots[-1]) / last
    return problem.layout.pack(np.array(knots), rate_before, q_start, geometry)


def perturbed(problem: WalkProblem, x: Array, sigma: float, seed: int) -> Array:
    """Return x with normal noise of standard deviation sigma on every joint parameter.

    Args:
        problem: the walk x belongs to.
        x: parameters, shape (P,).
        sigma: standard deviation [rad], and [rad/s] for the rates before impact.
        seed: of the random generator.
    """
    noisy = np.array(x)
    joints = slice(0, problem.layout.start.stop)
    noisy[joints] += np.random.default_rng(seed).normal(0.0, sigma, joints.stop)
    return noisy


def _geometry(problem: WalkProblem) -> Array:
    """Geometric quantities of the guess: fixed ones keep their value."""
    robot, task = problem.robot, problem.task
    legs = robot.legs
    guess = problem.layout.fixed_values.copy()
    step = guess[STEP_LENGTH]
    narrowest = robot.sole.left - robot.sole.right + task.margins.lateral_gap
    spacing = legs.side * max(abs(legs.stance_width), narrowest + _CLEAR_OF_GAP)
    if abs(step) / 2.0 >= _LONGEST * legs.reach:
        raise UnreachableError(
            f"a step of {step:.3f} m ({task.speed:g} m/s for {task.duration:g} s) is longer than "
            f"the legs can span: at most {2.0 * _LONGEST * legs.reach:.3f} m; "
            "ask for a lower speed or a shorter step duration"
        )
    height = min(_CROUCH * legs.reach, np.sqrt((_LONGEST * legs.reach) ** 2 - (step / 2.0) ** 2))
    ankle, middle = legs.ankles.mean(axis=0), legs.hips.mean(axis=0)
    values = {
        PELVIS_HEIGHT: ankle[2] + height - middle[2],
        PELVIS_LATERAL: spacing / 2.0,
        PELVIS_FORWARD: ankle[0] - step / 2.0 - middle[0],
        TRUNK_PITCH: _TRUNK_PITCH,
        FOOT_SPACING: spacing,
    }
    for row, value in values.items():
        if problem.layout.geometry[row].free:
            quantity = problem.layout.geometry[row]
            guess[row] = np.clip(value, quantity.lower, quantity.upper)
    return guess


def resized(x: Array, old: WalkProblem, new: WalkProblem) -> Array:
    """Return x with the pelvis at the height where no leg is straighter than before.

    Joint angles fit legs of any length; a height that is kept bends them otherwise, or is out of
    their reach.

    Args:
        x: parameters of a walk of the old robot, shape (P,).
        old, new: of the same layout.
    """
    at = new.layout.index("pelvis_height")
    if at is None:
        return x
    before, after = _legs(old, x), _legs(new, x)
    share = np.linalg.norm(before, axis=1) / old.robot.legs.reach
    reach = share * new.robot.legs.reach
    room = reach**2 - (after[:, :2] ** 2).sum(axis=1)
    if not (room > 0.0).all():
        return x
    lifted = x.copy()
    lifted[at] += float((np.sqrt(room) - after[:, 2]).min())
    return lifted


def _legs(problem: WalkProblem, x: Array) -> Array:
    """Return the vectors from ankles to hips in double support, shape (2, 3)."""
    boundary = problem.model.boundary
    (pelvis, _), (sole, _) = boundary.place(problem.layout.geometry_of(x))
    return boundary.leg_vectors(pelvis, sole)
