"""Proof that a gait is what it claims, computed without the solver that found it."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import asdict, field, replace
from itertools import pairwise

import numpy as np

from gaitopt.contact.schedule import AFTER
from gaitopt.dataclass import dataclass
from gaitopt.deprecation import Renamed
from gaitopt.design.extremes import Extreme, located
from gaitopt.design.referee import RefereeVerdict, ask_referee, both
from gaitopt.gait.grid import Grid, proof_grid
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.step import Step
from gaitopt.model.sole import sole_edge_speeds
from gaitopt.nlp import Array, Residual, kkt_residual
from gaitopt.solvers.multipliers import least_squares_multipliers
from gaitopt.tolerances import LIMITS, MOMENTUM, OPTIMALITY, REFEREE

_INSIDE = 1e-6  # of the step: nearest to its ends that a constraint which leaves them out is told


@dataclass(frozen=True)
class WorstRow:
    """The row of a constraint that comes nearest to its limit, or exceeds it most.

    Attributes:
        constraint, equation: which constraint.
        row: joint, corner or edge it speaks of.
        time: instant [s], None where the constraint is not one of an instant.
        value, limit, unit: measured and allowed.
        violation: scaled, zero if the limit is kept.
        margin: scaled distance to the limit; negative if it is exceeded.
    """

    constraint: str
    equation: str
    row: str
    time: float | None
    value: float
    limit: float
    unit: str
    violation: float
    margin: float

    family = Renamed("constraint")

    @property
    def sentence(self) -> str:
        """The row in words."""
        when = "" if self.time is None else f" at t = {self.time:.4f} s"
        return f"{self.row}{when}: {self.value:.5g} {self.unit}, allowed {self.limit:.5g}"


@dataclass(frozen=True)
class Certificate:
    """What was checked and what came out.

    Attributes:
        kkt: residuals at the samples that were optimised, from least-squares multipliers.
        samples: instants at which the whole step was evaluated; extremes are located between them.
        cost: with the quadrature of the proof's grid, in the unit of the task's cost.
        constraints: worst row of every constraint over the whole step, worst first.
        resolution: estimated error of the located extremes near their limits, scaled.
        referee: disagreement with the Newton-Euler referee on the proof's grid.
        rear_foot_speed: least upward speed of a corner of the rear sole after the impact [m/s].
        multipliers: of rows and bounds at the samples, by least squares.
        both_feet_stay: second outcome: the ground would only push on both feet.
    """

    kkt: Residual
    samples: int
    cost: float
    constraints: tuple[WorstRow, ...]
    resolution: float
    referee: RefereeVerdict
    rear_foot_speed: float
    both_feet_stay: bool
    multipliers: tuple[Array, Array] = field(compare=False, repr=False)

    families = Renamed("constraints")

    def __repr__(self) -> str:
        """Return it in one line: the whole of it is pages long."""
        return (
            f"<Certificate: {self.verdict}; KKT {self.kkt.worst:.1e}, limits "
            f"{self.worst.violation:.1e}, referee {self.referee.worst:.1e}>"
        )

    @property
    def worst(self) -> WorstRow:
        """Worst row of all."""
        return self.constraints[0]

    @property
    def optimal(self) -> bool:
        """Whether the KKT conditions hold at the optimised samples."""
        return self.kkt.worst <= OPTIMALITY

    @property
    def rear_foot_lifts(self) -> bool:
        """First outcome of section 2.4.1: no corner of the rear sole moves down."""
        return self.rear_foot_speed >= -LIMITS

    @property
    def refereed(self) -> bool:
        """Whether the referee agrees, momentum balance included."""
        return self.referee.worst <= REFEREE and self.referee.momentum <= MOMENTUM

    @property
    def certified(self) -> bool:
        """Whether everything that the task asks for holds, between the samples too."""
        return self.optimal and self.refereed and self.limits_hold

    @property
    def limits_hold(self) -> bool:
        """Whether no limit is exceeded at any instant, the located extremes' error included."""
        return self.worst.violation + self.resolution <= LIMITS

    @property
    def verdict(self) -> str:
        """One sentence."""
        if self.certified and self.rear_foot_lifts:
            return "certified"
        if self.certified:
            return (
                f"certified, but the rear foot sinks at {-self.rear_foot_speed:.3g} m/s after the "
                "impact, as the task allows; liftoff_speed 0 forbids it"
            )
        if self.referee.worst > REFEREE:
            return f"not certified: the referee disagrees by {self.referee.worst:.2e}"
        if not self.refereed:
            return f"not certified: momentum is off by {self.referee.momentum:.2e} of m g T"
        if not self.optimal:
            return f"not certified: KKT residual {self.kkt.worst:.2e}, allowed {OPTIMALITY:.0e}"
        if self.worst.violation <= LIMITS:
            return (
                f"not certified: limits hold to {self.worst.violation:.1e}, but between the "
                f"samples that is known to {self.resolution:.1e} only, together more than "
                f"{LIMITS:.0e}"
            )
        return f"optimal at the given samples only; between them {self.worst.sentence}"

    def record(self) -> dict[str, object]:
        """Return the certificate as JSON-able data."""
        return {
            "certified": self.certified,
            "verdict": self.verdict,
            "optimal": self.optimal,
            "kkt": asdict(self.kkt),
            "kkt_tolerance": OPTIMALITY,
            "fine_samples": self.samples,
            "fine_cost": self.cost,
            "fine_violation": self.worst.violation,
            "fine_tolerance": LIMITS,
            "fine_resolution": self.resolution,
            "worst": asdict(self.worst),
            "constraints": [asdict(row) for row in self.constraints],
            "referee": asdict(self.referee),
            "rear_foot_lifts": self.rear_foot_lifts,
            "rear_foot_speed": self.rear_foot_speed,
            "both_feet_stay": self.both_feet_stay,
        }


def certify(problem: WalkProblem, x: Array, fine: WalkProblem | None = None) -> Certificate:
    """Check a point of a walk from first principles.

    Args:
        problem: the walk on the grid that was optimised.
        x: parameters, shape (P,).
        fine: the walk on the certificate's grid, if it is at hand.

    Raises:
        EvaluationError: the walk is not defined at x.
    """
    point = problem.point(x)
    multipliers = least_squares_multipliers(problem, point)
    fine = fine or on_fine_grid(problem)
    steps, impact = fine.steps(x), problem.model.impact
    locked = [impact.locked(step.q_end, step.rate_before, step.turn, step.landed) for step in steps]
    resting = problem.robot.sole.corners[problem.schedule.last.contact.resting()]
    rear_corners = [sole_edge_speeds(resting) @ step.sole_twist for step in steps]
    extremes = located(fine, x, everywhere=True)
    return Certificate(
        kkt=kkt_residual(problem, point, *multipliers),
        samples=fine.grid.count,
        cost=fine.cost.value(fine.whole(x)),
        constraints=_worst_of_all(fine, x, extremes),
        resolution=max((e.error for e in extremes if e.margin < e.error), default=0.0),
        referee=_refereed(fine, x, steps),
        rear_foot_speed=float(np.min(rear_corners)),
        both_feet_stay=problem.schedule.closing or any(one.valid for one in locked),
        multipliers=multipliers,
    )


def _refereed(fine: WalkProblem, x: Array, steps: tuple[Step, ...]) -> RefereeVerdict:
    """Return the referee's word on a step, or on both steps of a stride."""
    if len(steps) == 1 and fine.given is None:
        return ask_referee(fine.robot, steps[0], fine.grid, fine.schedule)
    begin = fine.edges[:-1] + np.where(fine.edges[:-1] > 0.0, AFTER, 0.0)
    starts = fine.with_grid(Grid(begin, np.zeros(begin.size), begin.size)).starts(x)
    found = [
        ask_referee(model.robot, step, model.grid, fine.schedule, pair)
        for step, model, pair in zip(steps, fine.each, pairwise(starts), strict=True)
    ]
    return both(found)


def fine_grid(problem: WalkProblem) -> Grid:
    """Return the proof's grid: Chebyshev points between the knots, whatever the task's samples."""
    return proof_grid(problem.breaks)


def on_fine_grid(problem: WalkProblem) -> WalkProblem:
    """Return the walk on the proof's grid, the same whatever grid it was optimised on."""
    return problem.with_grid(fine_grid(problem))


def worst_between(fine: WalkProblem, x: Array) -> tuple[WorstRow, ...]:
    """Return the worst row of every constraint over the whole step, the one that fares worst first.

    Args:
        fine: the walk on the proof's grid.
        x: parameters, shape (P,).

    Raises:
        EvaluationError: the walk is not defined at x.
    """
    return _worst_of_all(fine, x, located(fine, x, everywhere=True))


def _worst_of_all(
    fine: WalkProblem, x: Array, extremes: tuple[Extreme, ...]
) -> tuple[WorstRow, ...]:
    """The located extremes over the step, computed again there; the rows of other constraints."""
    worst = _worst_extremes(fine, extremes)
    instants = np.unique([one.instant for one in worst.values()])
    at = fine.with_grid(Grid(instants, np.ones(instants.size), instants.size))
    values = at.values(x).rows
    rows = [_worst_extreme(at, one, values, x) for one in worst.values()]
    rows += [row for row in worst_rows(fine, x) if row.constraint not in worst]
    return tuple(sorted(rows, key=lambda row: row.margin))


def _worst_extremes(fine: WalkProblem, extremes: tuple[Extreme, ...]) -> dict[str, Extreme]:
    """The worst extreme of each constraint; at an end only where the constraint looks there."""
    at_ends = {f.name: f.times is not None and 0.0 in f.times for f in fine.blocks}
    worst: dict[str, Extreme] = {}
    extremes = tuple(one for one in extremes if np.isfinite(one.margin))  # a robot may lack limits
    for one in sorted(extremes, key=lambda one: one.margin):
        if at_ends[one.constraint] or _inside(one.instant, fine.edges) == one.instant:
            worst.setdefault(one.constraint, one)
    for one in extremes:
        worst.setdefault(one.constraint, replace(one, instant=_inside(one.instant, fine.edges)))
    return worst


def _inside(instant: float, ends: Array) -> float:
    """Return the instant, or where it is at the end of a step a little inside that."""
    number = min(max(bisect_left(ends, instant), 1), len(ends) - 1)
    return min(max(instant, float(ends[number - 1]) + _INSIDE), float(ends[number]) - _INSIDE)


def _worst_extreme(at: WalkProblem, extreme: Extreme, values: Array, x: Array) -> WorstRow:
    rows = at.rows_of(extreme.constraint)
    constraint = at.address(rows.start).block
    assert constraint.times is not None
    instant = int(np.argmin(np.abs(constraint.times - extreme.instant)))
    return _row(at, rows.start + instant * constraint.lower.shape[1] + extreme.entry, values, x)


def worst_rows(problem: WalkProblem, x: Array) -> tuple[WorstRow, ...]:
    """Return the worst row at x (P,) of every constraint with limits, the worst of all first."""
    values = problem.values(x).rows
    limited = [f for f in problem.blocks if np.isfinite([f.lower, f.upper]).any()]
    rows = [_worst_of(problem, constraint.name, values, x) for constraint in limited]
    return tuple(sorted(rows, key=lambda row: row.margin))


def _worst_of(problem: WalkProblem, name: str, values: Array, x: Array) -> WorstRow:
    rows = problem.rows_of(name)
    value, lower, upper = values[rows], problem.rows.lower[rows], problem.rows.upper[rows]
    index = int(np.argmin(np.minimum(value - lower, upper - value)))
    return _row(problem, rows.start + index, values, x)


def _row(problem: WalkProblem, index: int, values: Array, x: Array) -> WorstRow:
    """Return a row of the program in words and figures."""
    value, lower, upper = values[index], problem.rows.lower[index], problem.rows.upper[index]
    at = problem.address(index)
    scale = float(at.block.scale[at.entry])
    margin, low = min(value - lower, upper - value), value - lower < upper - value
    time = None
    if at.block.times is not None:
        time = problem.time(float(at.block.times[at.instant]), x)
    return WorstRow(
        constraint=at.block.name,
        equation=at.block.equation,
        row=at.block.label(at.instant, at.entry),
        time=time,
        value=float(value) * scale,
        limit=float(lower if low else upper) * scale,
        unit=at.block.unit,
        violation=max(0.0, -float(margin)),
        margin=float(margin),
    )
