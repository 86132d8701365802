"""What follows from what the paper leaves open: the same walks, with the other answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gaitopt.gait.grid import uniform_grid
from gaitopt.gait.parameters import GEOMETRY
from gaitopt.gait.problem import WalkProblem
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array
from reproduction.curve import Curve, Optimum, warm_curve
from reproduction.paper import paper_walk, printed

SINK = 0.02
"""Downward speed of the rear sole's corners, to see what their lift-off costs [m/s]."""

EULER_SAMPLES = 11  # instants, the last of which a left-hand sum leaves out


@dataclass(frozen=True)
class Consequences:
    """Changes of J are relative, at the speeds of Table 3 where a walk was found, slowest first.

    Attributes:
        yaw: change of J with the yaw of the pelvis as the 43rd parameter.
        penalty: change of J with the speed as the penalty (47) instead of the constraint (39).
        penalty_speed: by how much those walks miss the speed asked for [m/s].
        penalty_weight: rho of Eq. (47) in those walks [cost/m²].
        sinking: change of J where the rear sole may sink by `SINK` at lift-off.
        euler: change of J of the walk of Figs. 3 to 6 by ten left-hand samples.
        torque: root mean square of that walk's torques, over joints and time [N·m].
    """

    yaw: Array
    penalty: Array
    penalty_speed: Array
    penalty_weight: float
    sinking: Array
    euler: float
    torque: float


def consequences(robot: Robot, curve: Curve) -> Consequences:
    """Return what other answers would change.

    Args:
        robot: the identified biped.
        curve: its walks, at least at the speeds of Table 3.
    """
    yaw = _others(robot, curve, geometry=GEOMETRY)
    penalty = _others(robot, curve, speed_as="penalty")
    sinking = _others(robot, curve, liftoff_speed=-SINK)
    reference = curve[printed().speed]
    return Consequences(
        yaw=_changes(yaw, curve),
        penalty=_changes(penalty, curve),
        penalty_speed=np.array([_speed(walk) - v for v, walk in penalty.items()]),
        penalty_weight=next(iter(penalty.values())).problem.task.penalty_weight,
        sinking=_changes(sinking, curve),
        euler=_euler_cost(reference) / reference.cost - 1.0,
        torque=_torque(reference),
    )


def _others(robot: Robot, curve: Curve, **changes: Any) -> Curve:
    """Return the walks next to those of the curve with fields of the task changed."""
    walks = [paper_walk(v, robot, **changes) for v in printed().speeds]
    return warm_curve(walks, {w.task.speed: _carried(curve[w.task.speed], w) for w in walks})


def _carried(optimum: Optimum, to: WalkProblem) -> Array:
    """Return a walk's parameters in the layout of another; quantities newly free are zero."""
    known = dict(zip(optimum.problem.layout.names, optimum.solution.x, strict=True))
    return np.array([known.get(name, 0.0) for name in to.layout.names])


def _changes(others: Curve, curve: Curve) -> Array:
    return np.array([walk.cost / curve[v].cost - 1.0 for v, walk in others.items()])


def _speed(optimum: Optimum) -> float:
    return float(optimum.step.step_length / optimum.step.duration)


def _euler_cost(optimum: Optimum) -> float:
    problem = optimum.problem
    coarse = problem.with_grid(uniform_grid(EULER_SAMPLES, "euler"))
    return coarse.values(optimum.solution.x).cost


def _torque(optimum: Optimum) -> float:
    """From Eq. (46): J times the step length is the integral of the squared torques."""
    step, joints = optimum.step, len(optimum.problem.robot.joint_names)
    return float(np.sqrt(optimum.cost * step.step_length / (step.duration * joints)))
