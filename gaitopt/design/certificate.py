"""Proof that a gait is what it claims, computed without the solver that found it."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from gaitopt.design.referee import Verdict, judge
from gaitopt.gait.grid import Grid, uniform_grid
from gaitopt.gait.problem import WalkProblem
from gaitopt.mechanics.feet import sole_edge_speeds
from gaitopt.nlp import Array, Residual, kkt_residual, violations
from gaitopt.solvers.multipliers import least_squares_multipliers

FINER = 10  # the certificate's grid over the task's
KKT_TOLERANCE = 1e-6  # scaled stationarity, feasibility and complementarity
FINE_TOLERANCE = 1e-6  # scaled violation between the samples
REFEREE_TOLERANCE = 1e-8  # relative; two formulations agree to rounding times conditioning
MOMENTUM_TOLERANCE = 1e-5  # of m g T; the fine grid's quadrature error


@dataclass(frozen=True)
class WorstRow:
    """The row of a family that comes nearest to its limit, or exceeds it most.

    Attributes:
        family, equation: which constraint.
        row: joint, corner or edge it speaks of.
        time: instant [s], None where the constraint is not one of an instant.
        value, limit, unit: measured and allowed.
        violation: scaled, zero if the limit is kept.
        margin: scaled distance to the limit; negative if it is exceeded.
    """

    family: str
    equation: str
    row: str
    time: float | None
    value: float
    limit: float
    unit: str
    violation: float
    margin: float

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
        samples: instants of the fine grid.
        cost: on the fine grid [N²·m·s].
        families: worst row of every family on the fine grid, worst first.
        referee: disagreement with the Newton-Euler referee on the fine grid.
        rear_foot_speed: least upward speed of a corner of the rear sole after the impact [m/s].
        both_feet_stay: second outcome: the ground would only push on both feet.
    """

    kkt: Residual
    samples: int
    cost: float
    families: tuple[WorstRow, ...]
    referee: Verdict
    rear_foot_speed: float
    both_feet_stay: bool

    @property
    def worst(self) -> WorstRow:
        """Worst row of all."""
        return self.families[0]

    @property
    def optimal(self) -> bool:
        """Whether the KKT conditions hold at the optimised samples."""
        return self.kkt.worst <= KKT_TOLERANCE

    @property
    def rear_foot_lifts(self) -> bool:
        """First outcome of section 2.4.1: no corner of the rear sole moves down."""
        return self.rear_foot_speed >= -FINE_TOLERANCE

    @property
    def refereed(self) -> bool:
        """Whether the referee agrees, momentum balance included."""
        return (
            self.referee.worst <= REFEREE_TOLERANCE and self.referee.momentum <= MOMENTUM_TOLERANCE
        )

    @property
    def certified(self) -> bool:
        """Whether everything that the task asks for holds, between the samples too."""
        return self.optimal and self.refereed and self.worst.violation <= FINE_TOLERANCE

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
        if self.referee.worst > REFEREE_TOLERANCE:
            return f"not certified: the referee disagrees by {self.referee.worst:.2e}"
        if not self.refereed:
            return f"not certified: momentum is off by {self.referee.momentum:.2e} of m g T"
        if not self.optimal:
            return f"not certified: KKT residual {self.kkt.worst:.2e}, allowed {KKT_TOLERANCE:.0e}"
        return f"optimal at the given samples only; between them {self.worst.sentence}"

    def record(self) -> dict[str, object]:
        """Return the certificate as JSON-able data."""
        return {
            "certified": self.certified,
            "verdict": self.verdict,
            "optimal": self.optimal,
            "kkt": asdict(self.kkt),
            "kkt_tolerance": KKT_TOLERANCE,
            "fine_samples": self.samples,
            "fine_cost": self.cost,
            "fine_violation": self.worst.violation,
            "fine_tolerance": FINE_TOLERANCE,
            "worst": asdict(self.worst),
            "families": [asdict(row) for row in self.families],
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
    step = fine.step(x)
    locked = problem.model.impact.locked(step.q_end, step.rate_before)
    rear_corners = sole_edge_speeds(problem.robot.sole.corners) @ step.impact.sole_twist
    return Certificate(
        kkt=kkt_residual(problem, point, *multipliers),
        samples=fine.grid.count,
        cost=fine.cost.value(step),
        families=worst_rows(fine, x),
        referee=judge(problem.robot, step, fine.grid),
        rear_foot_speed=float(rear_corners.min()),
        both_feet_stay=locked.valid,
    )


def fine_grid(problem: WalkProblem) -> Grid:
    """Return the certificate's grid: at least ten times finer than the task's, Simpson's rule.

    The knots fall between panels of two intervals, since the jerk jumps there.
    """
    panels = 2 * (problem.task.postures + 1)
    return uniform_grid(panels * -(-FINER * (problem.task.samples - 1) // panels) + 1)


def on_fine_grid(problem: WalkProblem) -> WalkProblem:
    """Return the walk on the certificate's grid, the same whatever grid it was optimised on."""
    return problem.with_grid(fine_grid(problem))


def worst_rows(problem: WalkProblem, x: Array) -> tuple[WorstRow, ...]:
    """Return the worst row of every family that has limits, the one that fares worst first."""
    values = problem.values(x).rows
    limited = [f for f in problem.families if np.isfinite([f.lower, f.upper]).any()]
    rows = [_worst_of(problem, family.name, values, x) for family in limited]
    return tuple(sorted(rows, key=lambda row: row.margin))


def _worst_of(problem: WalkProblem, name: str, values: Array, x: Array) -> WorstRow:
    rows = problem.family_rows(name)
    value, lower, upper = values[rows], problem.rows.lower[rows], problem.rows.upper[rows]
    margin = np.minimum(value - lower, upper - value)
    index = int(np.argmin(margin))
    at = problem.address(rows.start + index)
    scale = float(at.family.scale[at.entry])
    low = value[index] - lower[index] < upper[index] - value[index]
    time = None
    if at.family.times is not None:
        time = float(at.family.times[at.instant]) * problem.step(x).duration
    return WorstRow(
        family=name,
        equation=at.family.equation,
        row=at.family.labels[at.entry],
        time=time,
        value=float(value[index]) * scale,
        limit=float(lower[index] if low else upper[index]) * scale,
        unit=at.family.unit,
        violation=float(violations(lower, upper, value).max()),
        margin=float(margin[index]),
    )
