"""Which limits conflict: those no motion can meet, and those that the smallest relaxation loosens.

The smallest relaxation makes the sum of all constraints' violations least (see `relaxation`); what
it loosens, and what pushes against it, is the conflict.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from gaitopt.bounds import fixed
from gaitopt.dataclass import dataclass
from gaitopt.deprecation import Renamed
from gaitopt.design.relaxation import EarlyStopping, Relaxation, RelaxedProgram
from gaitopt.errors import StoppedError, UnreachableError
from gaitopt.gait.initial_guess import first_guess, flat_feet_gap, perturbed
from gaitopt.gait.parameters import (
    DURATION,
    FOOT_SPACING,
    FOOT_YAW,
    PELVIS_ROLL,
    PELVIS_YAW,
    TRUNK_PITCH,
)
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import NLP, Array, Solution, Start, Stop, never, stopping
from gaitopt.solvers.sqp import SQP
from gaitopt.tolerances import FEASIBLE

RELAXATION_SOLVER = SQP(max_iterations=80, tolerance=1e-3, feasibility=0.9 * FEASIBLE)
"""For relaxations: they need few digits (measured: half the time of 1e-4). The tip of a smoothed
friction cone is out of reach by 6e-7; asked for more, the solver would insist on it."""
CONFLICT_SOLVER = replace(RELAXATION_SOLVER, max_iterations=60)
"""For the relaxation of all constraints."""
PATIENT_CONFLICT_SOLVER = replace(RELAXATION_SOLVER, max_iterations=300)
"""For the same, where that found none (benchmarks/infeasible.py: they take 60 to 200)."""
SECOND_START_SOLVER = SQP(max_iterations=40)
"""For a second opinion: another start."""
SECOND_START_SIGMA = 0.1
"""Standard deviation of the second start [rad], [rad/s]."""
EASIER_STEP = 0.8
"""Where the first guess cannot stand, its step is this share of the longest."""
SHARE_LOOSENED = 1e-2
"""A relaxation below this part of all is left out."""
SHARE_PUSHING = 0.05
"""Share of the push from which a constraint that holds belongs to the conflict."""
FLAT = 1e-4
"""Gap of the double support below which the feet lie flat [m, rad]."""


@dataclass(frozen=True)
class Conflict:
    """A constraint that stands in the way.

    Attributes:
        constraint, words: its name, and what a person calls it.
        amount, unit: by how much its limits give in the smallest relaxation; zero for a constraint
            that holds but pushes the others.
        row: joint and instant where it pushes most.
        share: of all push (multipliers of the smallest relaxation), from 0 to 1.
    """

    constraint: str
    words: str
    amount: float
    unit: str
    row: str
    share: float

    family = Renamed("constraint")

    @property
    def sentence(self) -> str:
        """In words."""
        where = " in every step" if self.constraint == "walking speed" else f" ({self.row})"
        if self.amount == 0.0:
            return self.words if self.constraint == "walking speed" else self.words + where
        return f"{self.words} by {self.amount:.2g} {self.unit}{where}"


@dataclass(frozen=True)
class LeastRelaxation:
    """The smallest relaxation that admits a walk.

    Attributes:
        x: parameters of that walk, shape (P,).
        amounts: by how much each constraint gives, in changes that matter, shape (constraints,).
        multipliers: of the walk's rows, shape (m,).
    """

    x: Array
    amounts: Array
    multipliers: Array

    @property
    def amount(self) -> float:
        """All of it."""
        return float(self.amounts.sum())


def first_tries(
    problem: WalkProblem, tried: Sequence[Solution], stop: Stop = never
) -> list[Solution]:
    """Return where two runs ended: those already made, others from further starts.

    Raises:
        UnreachableError: not even an easier walk can be guessed.
        StoppedError: `stop` said so.
    """
    found = sorted((s for s in tried if np.isfinite(s.violation)), key=lambda s: s.violation)[:2]
    if len(found) < 2:
        x = easier_guess(problem)
        for start in (perturbed(problem, x, SECOND_START_SIGMA, seed=0), x):
            if len(found) < 2 and not any(s.violation <= FEASIBLE for s in found):
                found.append(solve_unless_stopped(SECOND_START_SOLVER, problem, Start(start), stop))
    return [s for s in found if np.isfinite(s.violation)]


def easier_guess(problem: WalkProblem) -> Array:
    """Return the first guess, if need be that of an easier walk, shape (P,).

    Raises:
        UnreachableError: there is none either.
    """
    task, legs = problem.task, problem.robot.legs
    slowest = EASIER_STEP * 2.0 * legs.reach / task.duration
    slow = float(np.clip(task.speed, -slowest, slowest))
    slow = task.speed if task.ground.shaped else slow  # treads must hold a foot
    narrow = replace(task.margins, lateral_gap=min(task.margins.lateral_gap, 0.0))
    for easier in (task, replace(task, speed=slow), replace(task, speed=slow, margins=narrow)):
        try:
            return first_guess(WalkProblem(problem.robot, easier, problem.grid))
        except UnreachableError as error:
            reason = error
    raise reason


def find_least_relaxation(
    problem: WalkProblem, points: Sequence[Array], stop: Stop = never, solver: SQP = CONFLICT_SOLVER
) -> LeastRelaxation | None:
    """Return the smallest relaxation of all constraints found from points (P,) each.

    Raises:
        StoppedError: `stop` said so.
    """
    best: LeastRelaxation | None = None
    relaxations = _relaxations(problem)
    for x in points:
        program = RelaxedProgram(problem, relaxations, x)
        solution = solve_unless_stopped(solver, program, Start(program.needed(x)), stop)
        if not solution.violation <= FEASIBLE:
            continue
        multipliers = program.base_multipliers(solution.multipliers)
        found = LeastRelaxation(*program.split(solution.x), multipliers)
        if best is None or found.amount < best.amount:
            best = found
        if best.amount <= FEASIBLE:
            break
    return best


def conflicts(problem: WalkProblem, relaxed: LeastRelaxation) -> tuple[Conflict, ...]:
    """Return those in conflict: constraints that give, most first, then those that push most."""
    matter = np.array([f.change for f in problem.blocks])
    rows = [problem.rows_of(f.name) for f in problem.blocks]
    push = matter * np.array([np.abs(relaxed.multipliers[r]).sum() for r in rows])
    share = push / max(float(push.sum()), 1e-12)
    gives = relaxed.amounts > SHARE_LOOSENED * relaxed.amount
    given = np.where(gives, relaxed.amounts, 0.0)
    order = np.lexsort((-share, -given))
    found = []
    for i in order[(gives | (share >= SHARE_PUSHING))[order]]:
        constraint = problem.blocks[i]
        row = rows[i].start + int(np.argmax(np.abs(relaxed.multipliers[rows[i]])))
        unit = matter[i] * float(constraint.scale[problem.address(row).entry])
        amount = float(relaxed.amounts[i]) * unit if gives[i] else 0.0
        what, where = (constraint.name, constraint.words), problem.describe(row)
        found.append(Conflict(*what, amount, constraint.unit, where, float(share[i])))
    return tuple(found)


def solve_unless_stopped(
    solver: SQP, program: NLP, start: Start, stop: Stop = never, early: EarlyStopping | None = None
) -> Solution:
    """Solve, until `early` finds it good enough.

    Raises:
        StoppedError: `stop` said so.
    """
    solution = solver.solve(program, start, stop=stopping(stop, early))
    if stop():
        raise StoppedError(solution)
    return solution


def _relaxations(problem: WalkProblem) -> tuple[Relaxation, ...]:
    """One per constraint; the walking speed may only fall."""
    found = []
    for constraint in problem.blocks:
        gives = np.zeros(problem.rows.lower.size)
        gives[problem.rows_of(constraint.name)] = constraint.change
        slower = constraint.name == "walking speed"
        found.append(Relaxation(constraint.name, 0.0 * gives if slower else gives, gives))
    return tuple(found)


Contradictions = Iterator[tuple[str, str]]
"""Constraints and sentences."""


def contradictions(problem: WalkProblem) -> tuple[tuple[str, str], ...]:
    """Return what is impossible whatever the motion, as pairs of constraint and sentence."""
    tests = (
        _step, _flat_feet, _extension, _sole, _load, _knees, _width, _clearance, _trunk, _slope,
    )  # fmt: skip
    return tuple(found for test in tests for found in test(problem))


def _step(problem: WalkProblem) -> Contradictions:
    """Eq. (31): the legs span the step."""
    try:
        first_guess(problem)
    except UnreachableError as error:
        yield "leg length", str(error).split(";")[0]


def _flat_feet(problem: WalkProblem) -> Contradictions:
    """Both feet can lie flat at the step, though joints are missing."""
    if not problem.robot.legs.missing:
        return
    try:
        gap = flat_feet_gap(problem)
    except UnreachableError:
        return  # told of the leg's length
    if gap >= FLAT:
        lacks = " and ".join(f"no {name}" for name in problem.robot.legs.missing)
        yield (
            "closure",
            "the legs cannot put both feet flat at a step of "
            f"{fixed(problem.task.step_length, 3)} m: the nearest posture leaves "
            f"{gap:.2g} m or rad, as the legs have {lacks} joint",
        )


def _sole(problem: WalkProblem) -> Contradictions:
    """Eqs. (37)-(38): the margin leaves some of the sole."""
    sole, margin = problem.robot.sole, problem.task.margins.cop_margin
    for word, size in (("wide", sole.width), ("long", sole.length)):
        if 2.0 * margin >= size:
            yield (
                "cop",
                f"a margin of {margin:g} m from every edge leaves no room for the centre of "
                f"pressure in a sole {size:.3g} m {word}",
            )


def _width(problem: WalkProblem) -> Contradictions:
    """Eq. (32): feet that point ahead fit beside each other."""
    sole, margins = problem.robot.sole, problem.task.margins
    needed = sole.width + margins.lateral_gap
    turned, spacing = (problem.layout.geometry[row] for row in (FOOT_YAW, FOOT_SPACING))
    if turned.free or turned.value != 0.0:
        return
    room = [] if margins.step_width is None else [("at most", margins.step_width, "step_width")]
    room += [] if spacing.free else [("fixed at", abs(spacing.value), "foot_spacing")]
    for how, width, name in room:
        if width < needed:
            yield (
                "lateral",
                f"feet {how} {width:g} m apart ({name}) leave no gap of {margins.lateral_gap:g} m "
                f"between soles {sole.width:.3g} m wide; at least {needed:.3g} m are needed",
            )


def _extension(problem: WalkProblem) -> Contradictions:
    """Eq. (31): legs that may extend only so far span the step, the hips as far ahead as can be."""
    legs, task = problem.robot.legs, problem.task
    most, free = task.margins.leg_extension, problem.layout.geometry[DURATION].free
    if most is None or free or task.speed_as != "constraint":
        return
    hips = float(np.linalg.norm(legs.hips[0] - legs.hips[1]))
    longest = 2.0 * most * legs.reach + hips
    if abs(task.step_length) > longest:
        yield (
            "leg length",
            f"a step of {fixed(abs(task.step_length), 3)} m ({task.speed:g} m/s for "
            f"{task.duration:g} s) is longer than legs span that extend to {most:g} of "
            f"their length (leg_extension): at most {fixed(longest, 3)} m",
        )


def _clearance(problem: WalkProblem) -> Contradictions:
    """The swing foot passes below the hips."""
    legs, clearance = problem.robot.legs, problem.task.margins.clearance
    highest = legs.height + float(legs.hips[:, 2].max())
    if clearance >= highest:
        yield (
            "clearance",
            f"a clearance of {clearance:g} m lifts the whole swing foot to where the hips are, "
            f"{highest:.3g} m above the ground with straight legs; the leg is {legs.reach:.3g} m "
            "long",
        )


def _slope(problem: WalkProblem) -> Contradictions:
    """Over a step the ground's force and impulse bear the weight, which friction must hold."""
    friction, down = problem.task.margins.friction, problem.task.ground.down
    needed = float(np.hypot(down[0], down[1]) / -down[2])
    if friction < needed:
        yield (
            "friction",
            f"a slope of {100.0 * needed:.3g} % asks for a coefficient of friction of at least "
            f"{needed:.3g} on the mean of a step; it is {friction:g} (friction)",
        )


def _trunk(problem: WalkProblem) -> Contradictions:
    """The double support that is held keeps the limits of the trunk."""
    table, margins = problem.layout.geometry, problem.task.margins
    for name, row, most in (
        ("trunk_roll", PELVIS_ROLL, margins.trunk_roll),
        ("trunk_pitch", TRUNK_PITCH, margins.trunk_pitch),
        ("trunk_yaw", PELVIS_YAW, margins.trunk_yaw),
    ):
        if most is not None and not table[row].free and abs(table[row].value) > most:
            yield (
                name.replace("_", " "),
                f"{table[row].name} is fixed at {table[row].value:g} rad, but {name} allows at "
                f"most {most:g} rad",
            )


def _load(problem: WalkProblem) -> Contradictions:
    """Eq. (35): over a periodic step the vertical force averages at most the weight."""
    weight, least = problem.robot.weight, problem.task.margins.minimum_load
    if least >= weight:
        yield (
            "load",
            f"a vertical ground force of at least {least:g} N throughout the step is more than the "
            f"weight of the robot, {weight:.4g} N",
        )


def _knees(problem: WalkProblem) -> Contradictions:
    """Eq. (30): the knees can bend as asked."""
    robot, margins = problem.robot, problem.task.margins
    for index, knee in enumerate(robot.legs.knees):
        limits = robot.coupling.reach(knee, robot.limits)
        sign, straight = robot.legs.flexion[index], robot.legs.straight[index]
        most = float(max(sign * (limit - straight) for limit in limits))
        if margins.joint_range and margins.knee_flexion > most:
            yield (
                "knee",
                f"{robot.coupling.names[knee]} bends by at most {most:.3g} rad; asked for are "
                f"always at least {margins.knee_flexion:g} rad",
            )
