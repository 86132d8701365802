"""Requests that no motion can meet, seen without solving anything."""

from __future__ import annotations

import numpy as np

from gaitopt.errors import UnreachableError
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.parameters import (
    DURATION,
    FOOT_SPACING,
    FOOT_YAW,
    PELVIS_ROLL,
    PELVIS_YAW,
    TRUNK_PITCH,
)
from gaitopt.gait.problem import WalkProblem

Contradiction = tuple[str, str]
"""Family and sentence."""


def contradictions(problem: WalkProblem) -> tuple[Contradiction, ...]:
    """Return what is impossible whatever the motion, as pairs of family and sentence."""
    return (
        *_step(problem), *_extension(problem), *_sole(problem), *_load(problem), *_knees(problem),
        *_width(problem), *_clearance(problem), *_trunk(problem),
    )  # fmt: skip


def _step(problem: WalkProblem) -> list[Contradiction]:
    """Eq. (31): the legs span the step."""
    try:
        first_guess(problem)
    except UnreachableError as error:
        return [("leg length", str(error).split(";")[0])]
    return []


def _sole(problem: WalkProblem) -> list[Contradiction]:
    """Eqs. (37)-(38): the margin leaves some of the sole."""
    sole, margin = problem.robot.sole, problem.task.margins.cop_margin
    sizes = (("wide", sole.left - sole.right), ("long", sole.toe - sole.heel))
    return [
        (
            "cop",
            f"a margin of {margin:g} m from every edge leaves no room for the centre of pressure "
            f"in a sole {size:.3g} m {word}",
        )
        for word, size in sizes
        if 2.0 * margin >= size
    ]


def _width(problem: WalkProblem) -> list[Contradiction]:
    """Eq. (32): feet that point ahead fit beside each other."""
    sole, margins = problem.robot.sole, problem.task.margins
    needed = sole.left - sole.right + margins.lateral_gap
    turned, spacing = (problem.layout.geometry[row] for row in (FOOT_YAW, FOOT_SPACING))
    if turned.free or turned.value != 0.0:
        return []
    room = [] if margins.step_width is None else [("at most", margins.step_width, "step_width")]
    room += [] if spacing.free else [("fixed at", abs(spacing.value), "foot_spacing")]
    return [
        (
            "lateral",
            f"feet {how} {width:g} m apart ({name}) leave no gap of {margins.lateral_gap:g} m "
            f"between soles {sole.left - sole.right:.3g} m wide; at least {needed:.3g} m are "
            "needed",
        )
        for how, width, name in room
        if width < needed
    ]


def _extension(problem: WalkProblem) -> list[Contradiction]:
    """Eq. (31): legs that may extend only so far span the step, the hips as far ahead as can be."""
    legs, task = problem.robot.legs, problem.task
    most, free = task.margins.leg_extension, problem.layout.geometry[DURATION].free
    if most is None or free or task.speed_as != "constraint":
        return []
    hips = float(np.linalg.norm(legs.hips[0] - legs.hips[1]))
    longest = 2.0 * most * legs.reach + hips
    if task.step_length <= longest:
        return []
    return [
        (
            "leg length",
            f"a step of {task.step_length:.3f} m ({task.speed:g} m/s for {task.duration:g} s) is "
            f"longer than legs span that extend to {most:g} of their length (leg_extension): at "
            f"most {longest:.3f} m",
        )
    ]


def _clearance(problem: WalkProblem) -> list[Contradiction]:
    """The swing foot passes below the hips."""
    legs, clearance = problem.robot.legs, problem.task.margins.clearance
    highest = legs.height + float(legs.hips[:, 2].max())
    if clearance < highest:
        return []
    return [
        (
            "clearance",
            f"a clearance of {clearance:g} m lifts the whole swing foot to where the hips are, "
            f"{highest:.3g} m above the ground with straight legs; the leg is {legs.reach:.3g} m "
            "long",
        )
    ]


def _trunk(problem: WalkProblem) -> list[Contradiction]:
    """The double support that is held keeps the limits of the trunk."""
    table, margins = problem.layout.geometry, problem.task.margins
    pairs = (
        ("trunk_roll", PELVIS_ROLL, margins.trunk_roll),
        ("trunk_pitch", TRUNK_PITCH, margins.trunk_pitch),
        ("trunk_yaw", PELVIS_YAW, margins.trunk_yaw),
    )
    return [
        (
            name.replace("_", " "),
            f"{table[row].name} is fixed at {table[row].value:g} rad, but {name} allows at most "
            f"{most:g} rad",
        )
        for name, row, most in pairs
        if most is not None and not table[row].free and abs(table[row].value) > most
    ]


def _load(problem: WalkProblem) -> list[Contradiction]:
    """Eq. (35): over a periodic step the vertical force averages at most the weight."""
    weight, least = problem.robot.weight, problem.task.margins.minimum_load
    if least < weight:
        return []
    return [
        (
            "load",
            f"a vertical ground force of at least {least:g} N throughout the step is more than the "
            f"weight of the robot, {weight:.4g} N",
        )
    ]


def _knees(problem: WalkProblem) -> list[Contradiction]:
    """Eq. (30): the knees can bend as asked."""
    robot, margins = problem.robot, problem.task.margins
    found: list[Contradiction] = []
    for index, knee in enumerate(robot.legs.knees):
        limits = (robot.limits.lower[knee], robot.limits.upper[knee])
        sign, straight = robot.legs.flexion[index], robot.legs.straight[index]
        most = float(max(sign * (limit - straight) for limit in limits))
        if margins.joint_range and margins.knee_flexion > most:
            found.append(
                (
                    "knee",
                    f"{robot.joint_names[knee]} bends by at most {most:.3g} rad; asked for are "
                    f"always at least {margins.knee_flexion:g} rad",
                )
            )
    return found
