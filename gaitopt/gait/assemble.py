"""A gait from a point of a walk: sampled motion, loads, impact, and what they refer to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from gaitopt.contact import Schedule
from gaitopt.gait import quantities
from gaitopt.gait.constraints import imposed_limit
from gaitopt.gait.double_step import DoubleStepModel
from gaitopt.gait.foot_turn import with_knot
from gaitopt.gait.functions import StrideSpeed
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.gait.step import Step
from gaitopt.gait.step_model import StepModel
from gaitopt.gait.stride import Steps, Stride
from gaitopt.gait.task import task_record
from gaitopt.gait.terrain import Level, ground_record
from gaitopt.model.capsules import arm_capsules, capsule_rows, leg_capsules
from gaitopt.model.import_options import ImportOptions, choices_record, matching
from gaitopt.model.robot import Robot
from gaitopt.model.sole import centre_of_pressure
from gaitopt.nlp import Array

GRAVITY_KEY = "gravity_m_per_s2"  # of the record of a robot's physics
_NOWHERE = 1e-12  # m: rounding in a step that does not go that way


def gait_at(
    problem: WalkProblem,
    x: Array,
    meta: Mapping[str, object],
    multipliers: tuple[Array, Array] | None = None,
) -> Gait:
    """Return the gait at x (P,), sampled at the task's quadrature nodes.

    Args:
        meta: what to record besides robot, task and cost (solver, certificate, ...).
        multipliers: of the rows and of the bounds of the problem, if x is its optimum.

    Raises:
        EvaluationError: the walk is not defined at x.
    """
    whole, robot = problem.whole(x), problem.robot
    step = problem.step(x)
    before = whole.steps[1] if isinstance(whole, Stride) else step
    facts = {
        **robot_record(robot),
        "choices": choices_record(_choices(problem)),
        "limits": limits_record(problem),
        "task": task_record(problem.task),
        **_ground(problem),
        "instants": problem.grid.instants[problem.grid.nodes :].tolist(),
        "cost": problem.cost.value(whole),
        "step_length": step.step_length,
        "duration": step.duration,
        **_motion(problem, whole),
    }
    gait = step_gait(
        robot,
        problem.model,
        step,
        {**facts, **meta},
        parameters=whole.x,
        parameter_names=problem.layout.names,
        multipliers=None if multipliers is None else multipliers[0],
        bound_multipliers=None if multipliers is None else multipliers[1],
        **_foot(problem.schedule, problem.model, step, before),
    )
    if not isinstance(whole, Stride):
        return gait
    model, second = problem.models[1], whole.steps[1]
    own = {**step_arrays(model, second), **_foot(problem.schedule, model, second, step)}
    return replace(gait, second=replace(gait, **own))


def step_gait(
    robot: Robot,
    model: StepModel | DoubleStepModel,
    step: Step,
    meta: Mapping[str, object],
    **more: Any,
) -> Gait:
    """Return a step as a gait, without parameters unless they are among further arrays."""
    return Gait(
        **{"parameters": np.zeros(0), "parameter_names": (), **step_arrays(model, step), **more},
        joint_names=robot.joint_names,
        mirror=model.exchange,
        urdf=robot.urdf,
        stance_sole=robot.stance_sole,
        swing_sole_frame=robot.swing_sole,
        meta=meta,
        multibody=robot.multibody,
    )


def step_arrays(model: StepModel | DoubleStepModel, step: Step) -> dict[str, Any]:
    """Return the arrays of a gait that are of a single step, after a shift of the weight."""
    nodes, times = model.sampled(step)
    wrench = step.read(quantities.WRENCH)[nodes]
    return {
        "time": times,
        "q": step.motion[0, nodes],
        "dq": step.motion[1, nodes],
        "ddq": step.motion[2, nodes],
        "torque": step.read(quantities.TORQUE)[nodes],
        "ground_wrench": wrench,
        "cop": centre_of_pressure(wrench),
        "swing_sole": step.support.corners[nodes],
        **_splines(model, step),
        "impulse": step.impulse,
        "rate_before": step.rate_before,
        "rate_after": step.impact.rate_after,
    }


def _motion(problem: WalkProblem, whole: Step | Steps) -> dict[str, object]:
    """Return the screw motion of a stride, nothing of a walk straight ahead."""
    if not isinstance(whole, Stride):
        return {}
    (ahead, left, duration, _), task = whole.read(quantities.ADVANCE)[0], problem.task
    seconds = StrideSpeed(1.0, 0.0, task.turn_rate).value(np.array([[0.0, 0.0, duration]]))[0, 0]
    speed, aside = (0.0 if abs(way) < _NOWHERE else way / seconds for way in (ahead, left))
    motion = {"speed": speed, "lateral_speed": aside, "turn_rate": task.turn_rate}
    return {"motion": motion, "step_length": speed * duration}


def _ground(problem: WalkProblem) -> dict[str, object]:
    """Return the record of the ground, nothing on that of the paper."""
    task, sole = problem.task, problem.robot.sole
    if task.ground == Level():
        return {}
    return {"ground": ground_record(task.ground, sole, task.step_length, task.margins.nosing)}


def _splines(model: StepModel | DoubleStepModel, step: Step) -> dict[str, Any]:
    """Return the splines of the joints, in two parts where both feet stand at the end."""
    if isinstance(model, DoubleStepModel):
        return {**model.splines(step), "rear_impulse": step.read(quantities.REAR_IMPULSE)[0]}
    knots = model.basis.knots * model.swing_duration(step)
    found = {"knots": knots, "coefficients": step.coefficients}
    if step.flat is None:
        return found
    *values, before, after, end, first, last = step.coefficients
    found["coefficients"] = np.array([*values, end, first, last])
    return {**found, "flat_rates": np.array([before, after]), "rear_impulse": step.flat.impulse}


def _foot(
    schedule: Schedule, model: StepModel | DoubleStepModel, step: Step, before: Step
) -> dict[str, Any]:
    """Return the turns of the stance foot, nothing where it stands flat.

    The impact that ends the step before tells how fast a foot that landed on a line turns.
    """
    found = dict[str, Any]()
    asked = (
        ("foot", model.hinge, schedule.last, model.foot_turn),
        ("landing", model.line, schedule.first, model.landing_turn),
    )
    shapes = {turn.landed: shape for turn, shape in model.turns(step.x, before.impact.turn_rate)}
    for part, hinge, phase, turn in asked:
        if hinge is None or turn is None:
            continue
        shares, coefficients = turn.knots, turn.coefficients @ shapes[turn.landed]
        if schedule.closing:
            touch = float(schedule.changes[-1])
            shares, coefficients = with_knot(turn, shapes[turn.landed], step.duration, touch)
        knots = shares * step.duration
        change = -1 if turn.landed else 0  # the same number as the joints' knot
        near = np.argmin(np.abs(model.basis.knots - turn.knots[change]))
        knots[change] = model.basis.knots[near] * step.duration
        found |= {
            f"{part}_hinge": hinge.twist,
            f"{part}_knots": knots,
            f"{part}_contact": phase.contact.name,
            f"{part}_coefficients": coefficients,
        }
    return found


def robot_record(robot: Robot) -> dict[str, object]:
    """Return the facts about a robot that figures and summaries need, JSON-able."""
    sole = robot.sole
    return {
        "robot": robot.name,
        "mass": robot.mass,
        "leg_length": robot.legs.reach,
        "leg_joints": robot.tree.stance,
        "physics": physics_record(robot),
        "sole": {"toe": sole.toe, "heel": sole.heel, "left": sole.left, "right": sole.right},
    }


def physics_record(robot: Robot) -> dict[str, object]:
    """Return what counts beside the rigid bodies, and where it is from, as JSON can hold it.

    Keys of the result: gravity_m_per_s2 (down), gravity_from, carried_weight_N (from outside),
    without (parts that were left out) and joints: by name, what is not 0 of armature_kg_m2,
    damping and stiffness (coefficients of the first and higher powers; SI units), friction_Nm and
    rest_rad, and armature_from.
    """
    physics, carried = robot.physics, robot.physics.carried
    gravity = float(np.linalg.norm(physics.gravity))
    joints = {name: _joint_physics(robot, row) for row, name in enumerate(robot.tree.names)}
    return {
        GRAVITY_KEY: gravity,
        "gravity_from": "chosen"
        if robot.choices.gravity is not None
        else "file"
        if physics.gravity_stated
        else "standard",
        "carried_weight_N": 0.0 if carried is None else gravity * float(carried.mass.sum()),
        "without": list(robot.choices.without),
        "joints": {name: facts for name, facts in joints.items() if facts},
    }


def _joint_physics(robot: Robot, row: int) -> dict[str, object]:
    passive, facts = robot.physics.passive, dict[str, object]()
    armature = float(robot.model.armature[6 + row])
    if armature:
        facts["armature_kg_m2"] = armature
        facts["armature_from"] = _rotor_origin(robot, robot.tree.names[row])
    if passive is not None:
        if passive.damping[row].any():
            facts["damping"] = passive.damping[row].tolist()
        if passive.friction[row]:
            facts["friction_Nm"] = float(passive.friction[row])
        if passive.stiffness[row].any():
            facts["stiffness"] = passive.stiffness[row].tolist()
            facts["rest_rad"] = float(passive.rest[row])
    return facts


def _rotor_origin(robot: Robot, joint: str) -> str:
    """Return who gave a joint its rotor inertia."""
    given = [
        entry
        for entry in robot.choices.limits
        if entry.armature is not None and joint in matching(entry.joints, robot.tree.names)
    ]
    return (given[-1].source or "chosen") if given else "file"


def _choices(problem: WalkProblem) -> ImportOptions:
    """With these the URDF alone gives the same robot again; capsules where they were kept apart."""
    robot = problem.robot
    margins = problem.task.margins
    return robot.choices.over(
        capsules=None if margins.leg_gap is None else capsule_rows(leg_capsules(robot)),
        arm_capsules=None if margins.arm_gap is None else capsule_rows(arm_capsules(robot)),
    )


def limits_record(problem: WalkProblem) -> dict[str, list[float | None]]:
    """Return the joint limits that were imposed, None where there is none."""
    limits, margins = problem.robot.limits, problem.task.margins
    named = {
        "torque": imposed_limit(limits.torque, margins.torque_limit),
        "speed": imposed_limit(limits.speed, margins.speed_limit),
        "lower": limits.lower,
        "upper": limits.upper,
    }
    return {
        name: [float(v) if np.isfinite(v) else None for v in values]
        for name, values in named.items()
    }
