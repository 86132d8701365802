"""Requests that no motion can meet, seen without solving anything."""

from __future__ import annotations

from gaitopt.errors import UnreachableError
from gaitopt.gait.guess import first_guess
from gaitopt.gait.parameters import FOOT_YAW
from gaitopt.gait.problem import WalkProblem

Contradiction = tuple[str, str]
"""Family and sentence."""


def contradictions(problem: WalkProblem) -> tuple[Contradiction, ...]:
    """Return what is impossible whatever the motion, as pairs of family and sentence."""
    return (
        *_step(problem), *_sole(problem), *_load(problem), *_knees(problem), *_width(problem)
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
    turned = problem.layout.geometry[FOOT_YAW]
    straight = not turned.free and turned.value == 0.0
    if margins.step_width is None or margins.step_width >= needed or not straight:
        return []
    return [
        (
            "lateral",
            f"feet at most {margins.step_width:g} m apart (step_width) leave no gap of "
            f"{margins.lateral_gap:g} m between soles {sole.left - sole.right:.3g} m wide; at "
            f"least {needed:.3g} m are needed",
        )
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
