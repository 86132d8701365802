"""Strides of two steps on which derivatives and rows are checked."""

import numpy as np
from numerics import central_difference, check_differences, relative_error, steps
from reference_cases import biped
from walks import HEEL_STRIKE, TOE_OFF, UPRIGHT

from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.parameters import GEOMETRY, set_geometry
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem

EVERYTHING_FREE = set_geometry(GEOMETRY, {
    "pelvis_roll": {"free": True, "value": 0.03},
    "foot_yaw": {"free": True, "value": -0.1},
    "duration": {"free": True},
})  # fmt: skip
WAYS = {
    "straight": {"stride": True},
    "every way": {"speed": 0.5, "lateral_speed": 0.1, "turn_rate": 0.4},
    "every way, everything free": {
        "speed": 0.5, "lateral_speed": -0.1, "turn_rate": 0.4, "geometry": EVERYTHING_FREE,
        **UPRIGHT,
    },
    "every way, duration free, lifted": {
        "speed": -0.3, "lateral_speed": 0.1, "turn_rate": -0.4, "boundary": "lifted",
        "geometry": set_geometry(GEOMETRY, {"duration": {"free": True}}), **UPRIGHT,
    },
    "uphill across, everything free": {
        "speed": 0.5, "lateral_speed": 0.1, "slope": 0.06, "cross_slope": -0.1,
        "geometry": set_geometry(GEOMETRY, {
            "pelvis_roll": {"free": True, "value": 0.03}, "duration": {"free": True},
        }),
        **UPRIGHT,
    },
    "turning in place": {"speed": 0.0, "turn_rate": 0.5, **UPRIGHT},
    "every way, heel strike, toe off, everything free": {
        "speed": 0.5, "lateral_speed": 0.1, "turn_rate": 0.4, "duration": 0.5,
        "geometry": EVERYTHING_FREE, **UPRIGHT, **TOE_OFF, **HEEL_STRIKE,
    },
    "every way, heel strike, foot flat by an impact": {
        "speed": 0.5, "lateral_speed": 0.1, "turn_rate": 0.4, "duration": 0.5,
        "foot_flat": "impact", **UPRIGHT, **HEEL_STRIKE,
    },
    "every way, double support, toe off, everything free": {
        "speed": 0.5, "lateral_speed": 0.1, "turn_rate": 0.4, "duration": 0.5, "toe_off": 0.6,
        "double_support": 0.1, "geometry": EVERYTHING_FREE, **UPRIGHT,
    },
    "sideways, uphill": {"speed": -0.4, "lateral_speed": 0.1, "slope": 0.1, **UPRIGHT},
    "sideways, downstairs": {
        "speed": 0.5, "lateral_speed": -0.08, "stairs": -0.1, "duration": 0.6, **UPRIGHT,
    },
}  # fmt: skip


def point_of(name, robot=None):
    problem = WalkProblem(robot or biped(), preset_task(**{"speed": 0.8, **WAYS[name]}))
    return problem, perturbed(problem, first_guess(problem), 0.05, seed=3)


STEPS = steps(4e-4, 7)


def directions(problem, count=2):
    draw = np.random.default_rng(7).normal(size=(count, problem.layout.size))
    return draw * problem.variables.scale


def check_slope(function, slope, x, d):
    """Against differences at six steps: friction cones need small ones, impacts large ones."""
    check_differences(slope, [central_difference(function, x, h * d) / h for h in STEPS])


def check_slopes(problem, x):
    """Cost and every row, their slopes, and the Hessian of cost and of each family."""
    point, (d, _) = problem.point(x), directions(problem)
    check_slope(lambda at: problem.values(at).cost, point.gradient @ d, x, d)
    for block in problem.blocks:
        rows = problem.rows_of(block.name)
        check_slope(
            lambda at, rows=rows: problem.values(at).rows[rows], point.jacobian[rows] @ d, x, d
        )
    size = problem.rows.lower.size
    slopes = [
        (_slopes(problem, x + h * d) - _slopes(problem, x - h * d)) / (2.0 * h) for h in STEPS
    ]
    families = [(np.zeros(size), 1.0)]
    for block in problem.blocks:
        rows, y = problem.rows_of(block.name), np.zeros(size)
        y[rows] = np.random.default_rng(1).normal(size=rows.stop - rows.start)
        families.append((y, 0.0))
    for y, cost in families:
        H = problem.hessian(x, y, cost)
        if H.any():  # else the rows are linear
            assert relative_error(H, H.T) < 1e-12
            check_differences(H @ d, [np.r_[cost, y] @ slope for slope in slopes])


def _slopes(problem, x):
    point = problem.point(x)
    return np.vstack([point.gradient, point.jacobian])
