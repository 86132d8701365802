"""Strides of two steps on which derivatives and rows are checked."""

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
    "sideways, uphill": {"speed": -0.4, "lateral_speed": 0.1, "slope": 0.1, **UPRIGHT},
    "sideways, downstairs": {
        "speed": 0.5, "lateral_speed": -0.08, "stairs": -0.1, "duration": 0.6, **UPRIGHT,
    },
}  # fmt: skip


def point_of(name, robot=None):
    problem = WalkProblem(robot or biped(), preset_task(**{"speed": 0.8, **WAYS[name]}))
    return problem, perturbed(problem, first_guess(problem), 0.05, seed=3)
