"""Walks and points on which derivatives are checked: every option of a task is in one of them."""

import functools
from dataclasses import dataclass

import numpy as np
from reference_cases import biped, reference_case, reference_task
from synthetic_bipeds import synthetic
from tied_bipeds import TIED, tied

from gaitopt.gait.grid import uniform_grid
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.parameters import GEOMETRY, set_geometry
from gaitopt.gait.problem import WalkProblem
from gaitopt.mechanics.inverse_kinematics import LegKinematics
from gaitopt.model.robot import Robot

ALWAYS = (
    "torque",
    "speed",
    "load",
    "friction",
    "cop",
    "impulse",
    "impulse friction",
    "lift-off",
    "clearance",
    "lateral",
    "knee",
    "leg length",
    "range",
    "impulse cop",
    "walking speed",
    "closure",
)
SWITCHED = (  # constraints that are off unless asked for, as by `UPRIGHT`
    "trunk roll",
    "trunk pitch",
    "trunk yaw",
    "torsion",
    "impulse torsion",
    "leg gap",
    "swing tilt",
    "swing height",
    "landing speed",
    "landing impulse",
)
OF_ARMS = ("arm gap",)  # of arms that move
OF_TURN = ("foot angle", "foot lift")  # of a stance foot that turns
SOFT = ("soft landing",)  # of a landing at zero speed, which has none of `AT_IMPACT`
AT_IMPACT = (
    "impulse",
    "impulse friction",
    "lift-off",
    "impulse cop",
    "impulse torsion",
    "landing impulse",
)
OF_FRONT = ("front load", "front friction", "front cop", "front torsion")  # while both feet stand
OF_REAR_IMPULSE = (  # of an impact that both feet take, or by which a foot comes to lie flat
    "rear impulse",
    "rear impulse friction",
    "rear impulse cop",
    "rear impulse torsion",
)
NAMES = (
    *ALWAYS,
    *SWITCHED,
    *OF_ARMS,
    *OF_TURN,
    *SOFT,
    *OF_FRONT,
    *OF_REAR_IMPULSE,
)  # as `CONSTRAINTS`
UPRIGHT = {
    "trunk_roll": 0.1,
    "trunk_pitch": 0.12,
    "trunk_yaw": 0.09,
    "torsional_friction": 0.04,
    "step_width": 0.2,
    "leg_gap": 0.012,
    "arm_gap": 0.011,
    "swing_tilt": 0.15,
    "swing_height": 0.05,
    "landing_speed": 0.2,
    "landing_impulse": 0.15,
}
TOE_OFF = {"toe_off": 0.65, "toe_strip": 0.008}
HEEL_STRIKE = {"heel_strike": 0.15, "heel_strip": 0.012}
_ALL = {"joint_range": True, "impulse_cop": True}
_PLACES_FREE = {
    "pelvis_roll": {"free": True, "value": 0.03},
    "foot_yaw": {"free": True, "value": -0.1},
}
_EVERYTHING_FREE = {**_PLACES_FREE, "duration": {"free": True}}


@dataclass(frozen=True)
class Walk:
    """A problem and a point of it."""

    problem: WalkProblem
    x: np.ndarray


def _reference(name: str) -> Walk:
    case = reference_case(name)
    return Walk(case.problem(biped(), **_ALL), case.x)


def _guess(seed: int, sigma: float = 0.1, robot: Robot | None = None, **changes: object) -> Walk:
    problem = WalkProblem(robot or biped(), reference_task(**{**_ALL, **changes}))
    x = perturbed(problem, first_guess(problem), sigma, seed)
    noise = np.random.default_rng(seed).normal(0.0, 0.02, x.size)
    x[problem.layout.shape] += (
        noise[problem.layout.shape] * problem.layout.scale()[problem.layout.shape]
    )
    return Walk(problem, x)


def _synthetic(name: str, sigma: float = 0.05, **changes: object) -> Walk:
    """Everything there is, of a robot with other joints than two times six."""
    geometry = set_geometry(GEOMETRY, _EVERYTHING_FREE)
    robot = tied(name) if name in TIED else synthetic(name)
    return _guess(
        6, sigma=sigma, robot=robot, geometry=geometry, boundary="lifted", speed=0.6,
        duration=0.5, **UPRIGHT, **changes,
    )  # fmt: skip


def _everything_free(seed: int = 4, sigma: float = 0.1, **changes: object) -> Walk:
    geometry = set_geometry(GEOMETRY, _EVERYTHING_FREE)
    return _guess(seed, sigma=sigma, geometry=geometry, **changes)


def _added_instants() -> Walk:
    walk = _guess(5)
    grid = uniform_grid(31).with_instants(np.array([0.11, 0.777]))
    return Walk(walk.problem.with_grid(grid), walk.x)


def _double_support(**changes: object) -> Walk:
    """Both feet stand at the end of the step, the front one pushed in all directions."""
    places = _EVERYTHING_FREE if changes.pop("everything", False) else _PLACES_FREE
    geometry = set_geometry(GEOMETRY, places)
    found = _guess(
        1, sigma=0.03, duration=0.5, double_support=0.1, geometry=geometry, **UPRIGHT, **changes
    )
    return _pushed(found)


def _closed(found: Walk) -> Walk:
    """The same with the posture at the start where it ought to be: there both ends agree."""
    problem, x = found.problem, found.x.copy()
    (pelvis, _), (sole, _) = problem.model.boundary.place(problem.model.opening(x).geometry)
    x[problem.layout.start] = LegKinematics(problem.robot).solve(pelvis, sole)
    return Walk(problem, x)


def _pushed(found: Walk) -> Walk:
    """The same with a front foot that is pushed in all directions: friction cones have a tip."""
    front, push, x = found.problem.layout.front, found.problem.layout.push, found.x.copy()
    moved = slice(front.start, push.stop)
    noise = np.random.default_rng(2).normal(0.0, 0.3, moved.stop - moved.start)
    x[moved] += noise * found.problem.layout.scale()[moved]
    return Walk(found.problem, x)


_MAKERS = {
    "optimum 43": lambda: _reference("p43_v1.0_optimum"),
    "optimum 42": lambda: _reference("p42_v0.8_optimum"),
    "infeasible 43": lambda: _reference("p43_v1.0_infeasible"),
    "infeasible 42": lambda: _reference("p42_v1.0_infeasible"),
    "guess": lambda: _guess(1),
    "one posture": lambda: _guess(2, postures=1, speed=0.7),
    "three postures, speed as penalty": lambda: _guess(3, postures=3, speed_as="penalty"),
    "everything free": _everything_free,
    "everything free, penalty, Euler": lambda: _everything_free(
        speed_as="penalty", quadrature="euler", samples=20
    ),
    "added instants": _added_instants,
    "lifted, everything free": lambda: _everything_free(boundary="lifted"),
    "upright": lambda: _guess(1, sigma=0.05, **UPRIGHT),
    "upright, uphill": lambda: _guess(1, sigma=0.05, slope=0.12, **UPRIGHT),
    "upright, upstairs": lambda: _guess(
        1, sigma=0.05, stairs=0.12, speed=0.6, duration=0.6, **UPRIGHT
    ),
    "upright, downstairs": lambda: _guess(
        2, sigma=0.05, stairs=-0.1, speed=0.6, duration=0.6, **UPRIGHT
    ),
    "upright, everything free": lambda: _everything_free(**UPRIGHT),
    "upright, lifted, seven joints, waist, arms": lambda: _synthetic("seven, waist and arms"),
    "upright, lifted, five joints": lambda: _synthetic("five"),
    "upright, backward, everything free": lambda: _everything_free(speed=-0.5, **UPRIGHT),
    "upright, in place, everything free": lambda: _everything_free(speed=0.0, **UPRIGHT),
    "upright, lifted, joints that follow others": lambda: _synthetic("elbows and shanks"),
    "upright, lifted, heel strike, toe off, joints that follow by bends": lambda: _synthetic(
        "bent elbows and shanks", sigma=0.021, **TOE_OFF, **HEEL_STRIKE
    ),
    "upright, lifted, heel strike, toe off, NAO's hips": lambda: _synthetic(
        "NAO's hips", sigma=0.02, **TOE_OFF, **HEEL_STRIKE
    ),
    "upright, toe off, everything free": lambda: _everything_free(**UPRIGHT, **TOE_OFF),
    "upright, lifted, toe off, seven joints, waist, arms": lambda: _synthetic(
        "seven, waist and arms", **TOE_OFF
    ),
    "upright, heel strike, toe off, everything free": lambda: _everything_free(
        seed=1, sigma=0.02, duration=0.5, **UPRIGHT, **TOE_OFF, **HEEL_STRIKE
    ),
    "upright, heel strike, foot flat by an impact, toe off, everything free": lambda: (
        _everything_free(
            seed=1,
            sigma=0.015,
            duration=0.5,
            foot_flat="impact",
            **UPRIGHT,
            **TOE_OFF,
            **HEEL_STRIKE,
        )
    ),
    "upright, lifted, heel strike, foot flat by an impact, seven joints, waist, arms": lambda: (
        _synthetic("seven, waist and arms", foot_flat="impact", **HEEL_STRIKE)
    ),
    "upright, double support": lambda: _double_support(),
    "upright, double support, toe off": lambda: _double_support(toe_off=0.6),
    "upright, double support, toe off, everything free": lambda: _double_support(
        toe_off=0.6, everything=True
    ),
    "upright, lifted, double support, toe off, six joints, waist, arms": lambda: _pushed(
        _closed(_synthetic("six, waist and arms", sigma=0.02, double_support=0.1, toe_off=0.6))
    ),
    "upright, double support after an impact on both, everything free": lambda: _double_support(
        touch_down="impact", everything=True
    ),
    "upright, double support after an impact on both": lambda: _double_support(touch_down="impact"),
    "upright, lifted, heel strike, five joints, soft": lambda: _synthetic(
        "five", soft_landing=True, **HEEL_STRIKE
    ),
}
WALKS = tuple(_MAKERS)
PAIRS = tuple(
    (walk, constraint)
    for walk in WALKS
    for constraint in NAMES
    if not (constraint == "walking speed" and "penalty" in walk)
    and not (constraint == "closure" and "lifted" not in walk)
    and not (constraint in SWITCHED and "upright" not in walk)
    and not (constraint in OF_ARMS and "arms" not in walk and "that follow" not in walk)
    and not (constraint in OF_TURN and "toe off" not in walk and "heel strike" not in walk)
    and not (constraint in SOFT and "soft" not in walk)
    and not (
        constraint in AT_IMPACT and ("soft" in walk or "double" in walk) and "both" not in walk
    )
    and not (constraint == "lift-off" and "double" in walk)
    and not (constraint in OF_FRONT and "double" not in walk)
    and not (constraint in OF_REAR_IMPULSE and "both" not in walk and "foot flat" not in walk)
    and not (constraint == "foot lift" and "foot flat" in walk and "toe off" not in walk)
)


@functools.cache
def walk(name: str) -> Walk:
    """One of `WALKS`."""
    return _MAKERS[name]()


def rows_and_limits(problem, x, name):
    """Value, lower and upper limit of a constraint's rows in its unit, shape (K, r)."""
    constraint = next(block for block in problem.blocks if block.name == name)
    value = problem.values(x).rows[problem.rows_of(name)].reshape(constraint.lower.shape)
    return value * constraint.scale, constraint.lower, constraint.upper
