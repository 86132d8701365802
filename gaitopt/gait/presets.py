"""Named tasks: for the thirteen-link biped, for the paper, and one that is sized by the robot.

Without bounds on trunk, step width and swing foot the least effort is a waddle with kicks that no
motor controller would follow; a humanoid has them by default (docs/habits.md says what each costs),
and the gaps that keep its legs whole.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from gaitopt.bounds import fixed, is_finite
from gaitopt.catalogue.biped_spec import biped13
from gaitopt.errors import InputError, did_you_mean
from gaitopt.gait.constraints import Margins
from gaitopt.gait.parameters import DURATION, GEOMETRY, set_geometry
from gaitopt.gait.task import Task
from gaitopt.gait.terrain import Terrain
from gaitopt.importers.physics import is_generated
from gaitopt.model.robot import Robot
from gaitopt.model.sole import turning_arm
from gaitopt.settings import checked_arguments, plain

PRESETS = STANDARD, PAPER, HUMANOID, ROBUST = "standard", "paper", "humanoid", "robust"

FROUDE = 0.05  # V² / (g h) of a stroll; people change to a run near 0.5 (Alexander, 1989)
SLOW = 0.25  # of the speed of a stroll: below, steps take no longer
ROLL = 0.25  # rad; the trunk's, where ankles do not roll: 0.15 stops H1 at 0.6 m/s
TRUNK = {"trunk_roll": 0.15, "trunk_pitch": 0.2, "trunk_yaw": 0.2}  # rad; people stay within
KNEE_FLEXION = 0.1  # rad
SHORT_LEG = 0.3  # m from hip to ankle: gaps and the like of shorter legs shrink with them
LEG_GAP = 0.01  # m
ARM_GAP = 0.01  # m
WIDER = 0.03  # m by which the feet may stand farther apart than the hips
SWING_HEIGHT = 0.12  # of the hips' height; without a limit feet rise to half of it
LIFTS = 2.0  # of the clearance asked for, which a foot may rise to in any case
SWING_TILT = 0.26  # sine of 15 degrees; without a limit soles end upright: docs/habits.md
LEAST_LOAD = 0.05  # of the weight
ROBUST_KNEE_FLEXION = 0.3  # rad; leaves the leg 1 % longer than it is, 0.1 rad leave 0.1 %
ROBUST_FRICTION = 0.5  # what a foot that lands 2 ms early still finds
ROBUST_COP = 0.1  # margin of the centre of pressure over the width of the sole
ROBUST_LANDING = 0.07  # speed of the landing corners over sqrt(g h): 0.2 m/s of a man
ROBUST_IMPULSE = 0.07  # vertical impulse over mass and sqrt(g h)
_SHRINKING = ("clearance", "lateral_gap", "cop_margin")
_SIZED = (*TRUNK, "minimum_load", "step_width", "leg_gap", "swing_height")


@checked_arguments
def preset_task(preset: str = STANDARD, robot: Robot | None = None, **changes: object) -> Task:
    """Return a task of a named preset, with some fields changed.

    `standard`: for the thirteen-link biped, 43 parameters and every constraint, torsional friction
    as its sole, or that of the robot given, can bear (docs/decisions/torsion.md). `paper`: the
    constraints of section 3.2 only, the six geometric parameters of section 4.2, speed as the
    constraint (39). `humanoid`: for any other robot; speed, duration, load, step width,
    friction under the foot and gaps of short legs follow from its size and weight, trunk and swing
    foot keep upright.
    `robust`: the same with margins for feedback; see `robust_task`.

    Args:
        robot: the biped, which `humanoid` and `robust` are sized by; `standard` takes its sole,
            `paper` does without.
        changes: fields of `Task`, and margins of it and of its own constraints, as `speed=0.6`
            [m/s].

    Raises:
        InputError: unknown preset or field, a value out of range, or no robot for `humanoid`
            or `robust`.
    """
    if preset not in PRESETS:
        raise InputError(
            f"preset '{preset}' is unknown; {did_you_mean(preset, PRESETS)}choose one of "
            f"{', '.join(PRESETS)}"
        )
    changes = plain(changes)
    if preset == STANDARD:
        return Task().with_changes(**{**_torsional_friction(robot, changes), **changes})
    if preset == PAPER:
        geometry = set_geometry(GEOMETRY, {"pelvis_yaw": {"free": False}})
        return Task(geometry=geometry, margins=Margins(impulse_cop=False)).with_changes(**changes)
    if robot is None:
        raise InputError(
            f"the preset '{preset}' is sized by the robot; give it, as in "
            f'preset_task("{preset}", robot, speed=0.6)'
        )
    return (humanoid_task if preset == HUMANOID else robust_task)(robot, **changes)


def humanoid_task(robot: Robot, **changes: object) -> Task:
    """Return the default task of a robot, with some fields changed.

    Speed and step duration follow from the leg length (dynamic similarity), the margins from
    weight, sole and, below 0.3 m from hip to ankle, leg; the double support is lifted.

    Args:
        changes: fields of `Task` and of `Margins`.

    Raises:
        InputError: an unknown field, or a value out of range.
    """
    changes = plain(changes)
    speed = changes.get("speed", stroll(robot))
    defaults: dict[str, object] = {"boundary": "lifted", "leg_extension": None, "speed": speed}
    aside = changes.get("lateral_speed", 0.0)
    if is_finite(speed) and is_finite(aside):
        pace = math.hypot(speed, aside)
        defaults["duration"] = natural_duration(robot, pace)
    defaults |= _torsional_friction(robot, changes)
    defaults |= {**TRUNK, "trunk_roll": TRUNK["trunk_roll"] if robot.legs.ankles_roll else ROLL}
    defaults |= {name: _shrunk(robot, getattr(Margins, name)) for name in _SHRINKING}
    defaults |= {"knee_flexion": KNEE_FLEXION, "leg_gap": _shrunk(robot, LEG_GAP)}
    if robot.tree.size > robot.tree.swing_foot:
        defaults["arm_gap"] = _shrunk(robot, ARM_GAP)
    defaults["minimum_load"] = round(LEAST_LOAD * robot.weight, 1)
    turns = {"toe_strip": changes.get("toe_off"), "heel_strip": changes.get("heel_strike")}
    for name in (name for name, turn in turns.items() if turn is not None):
        defaults[name] = _shrunk(robot, getattr(Task, name))
    if turns == dict.fromkeys(turns):
        # a foot that turns about an edge leaves or lands tilted
        defaults |= _swing(robot, {**defaults, **changes})
    gap = changes.get("lateral_gap", defaults["lateral_gap"])
    if is_finite(gap):
        defaults["step_width"] = widest(robot, gap)
    return Task().with_changes(**{**defaults, **changes})


def _shrunk(robot: Robot, length: float) -> float:
    """Return a length [m], or its share for a short leg, to a tenth of a millimetre."""
    return round(length * min(1.0, robot.legs.reach / SHORT_LEG), 4)


def _torsional_friction(robot: Robot | None, changes: Mapping[str, object]) -> dict[str, object]:
    friction = changes.get("friction", Margins.friction)
    if not is_finite(friction):
        return {}  # the task says what is wrong with it
    return {"torsional_friction": bearable_torsion(robot, friction)}


def bearable_torsion(robot: Robot | None, friction: float) -> float:
    """Return the turning moment over the load that an evenly pressed sole bears [m]; 0.1 mm least.

    Args:
        robot: whose sole it is; None for that of the thirteen-link biped.
        friction: coefficient of the ground.
    """
    if robot is None:
        feet = biped13().geometry
        length, width = feet.foot_length, feet.foot_width
    else:
        length, width = robot.sole.length, robot.sole.width
    return max(round(friction * turning_arm(length, width), 4), 1e-4)


def _swing(robot: Robot, changes: Mapping[str, object]) -> dict[str, object]:
    """Return how the foot swings: level, and no higher than it must."""
    terrain, rise = changes.get("terrain"), changes.get("stairs", 0.0)
    lift, over = changes["clearance"], 0.0
    if isinstance(terrain, Terrain):
        over = terrain.lift
    elif is_finite(rise):
        over = abs(rise)
    limits: dict[str, object] = {"swing_tilt": SWING_TILT}
    if is_finite(lift):
        height = max(SWING_HEIGHT * robot.legs.height, LIFTS * lift) + over
        limits["swing_height"] = round(height, 3)
    return limits


def robust_task(robot: Robot, **changes: object) -> Task:
    """Return a task whose walks leave feedback something to work with, some fields changed.

    Beyond `humanoid_task` the knees keep bent, the feet need less friction and keep the centre of
    pressure farther inside, and they land neither grazing nor hard; see docs/simulation.md.

    Args:
        changes: fields of `Task` and of `Margins`.

    Raises:
        InputError: an unknown field, or a value out of range.
    """
    gravity = float(np.linalg.norm(robot.model.gravity.linear))
    pace = math.sqrt(gravity * robot.legs.height)
    margins: dict[str, object] = {
        "friction": ROBUST_FRICTION,
        "knee_flexion": ROBUST_KNEE_FLEXION,
        "cop_margin": round(ROBUST_COP * robot.sole.width, 4),
        "landing_speed": round(ROBUST_LANDING * pace, 3),
        "landing_impulse": round(ROBUST_IMPULSE * pace, 3),
    }
    gentle = changes.get("double_support") is not None and changes.get("touch_down") != "impact"
    if gentle or changes.get("soft_landing"):
        del margins["landing_speed"]  # the foot lands at zero speed
    return humanoid_task(robot, **{**margins, **changes})


def natural_duration(robot: Robot, speed: float) -> float:
    """Return how long a step naturally takes at a speed [m/s], to two digits [s].

    The steps of very slow walks get short, not slow: below a quarter of the speed of an easy walk,
    in either direction and in place, they last as long as at that.
    """
    pace = max(abs(speed), SLOW * stroll(robot))
    return max(round(robot.legs.natural_step(pace) / pace, 2), GEOMETRY[DURATION].lower)


def stroll(robot: Robot) -> float:
    """Return the speed of an easy walk [m/s], to two digits: that of the Froude number 0.05."""
    gravity = float(np.linalg.norm(robot.model.gravity.linear))
    return round(math.sqrt(FROUDE * gravity * robot.legs.height), 2)


def widest(robot: Robot, gap: float = Margins.lateral_gap) -> float:
    """Return how far apart the lines of footsteps may be [m]: a little more than they must.

    Args:
        gap: that must be left between the soles [m].
    """
    soles = robot.sole.width + gap
    return round(max(abs(robot.legs.stance_width), soles) + _shrunk(robot, WIDER), 3)


def foreign_margins(robot: Robot, task: Task, remedy: str = "") -> str | None:
    """Return what to say where the margins of the thirteen-link biped meet another robot.

    Args:
        remedy: what sizes margins by the robot, by default the call in Python.
    """
    usual = Margins()
    chosen = any(getattr(task.margins, name) != getattr(usual, name) for name in _SIZED)
    if chosen or is_generated(robot.urdf):
        return None
    remedy = remedy or f'preset_task("{HUMANOID}", robot, speed={task.speed:g})'
    return (
        f"the margins of this task are those of the thirteen-link biped: a least load of "
        f"{usual.minimum_load:g} N, where {robot.name} weighs {fixed(robot.weight, 0)} N, and no "
        f"limits of trunk, step width and gap between the legs; "
        f"{remedy} sizes them by the robot"
    )
