"""Proof that a gait is what it claims, computed without the solver that found it.

A referee, the in-house Newton-Euler algorithm, judges the step that Pinocchio evaluated: another
implementation, another geometry (modified Denavit-Hartenberg), and conservation laws that neither
was built from.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import field, fields, replace
from itertools import pairwise

import numpy as np

from gaitopt.bounds import fixed
from gaitopt.contact import AFTER, Schedule, Symmetry
from gaitopt.dataclass import dataclass
from gaitopt.deprecation import Renamed
from gaitopt.design.extremes import Extreme, located
from gaitopt.gait import quantities
from gaitopt.gait.grid import Grid, proof_grid
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.step import Step
from gaitopt.mechanics.chain_build import chain_of_robot, loads_of_robot
from gaitopt.mechanics.impact import ClosedJump, FlatJump
from gaitopt.mechanics.newton_euler import (
    Chain,
    at_rest,
    base_in_sole_axes,
    foot_twist,
    impact,
    impulse_on_foot,
    inverse_dynamics,
    momentum,
    motor_effort,
    sole_axes,
    sole_placement,
    swing_jacobian,
    turned,
    wrench_on_ground,
)
from gaitopt.mechanics.single_support import standing_robot
from gaitopt.model.robot import Robot
from gaitopt.model.sole import sole_edge_speeds
from gaitopt.nlp import Array, Residual, kkt_residual
from gaitopt.settings import checked_arguments, checked_facts
from gaitopt.solvers.multipliers import least_squares_multipliers
from gaitopt.tolerances import LIMITS, MOMENTUM, OPTIMALITY, REFEREE

LEAST = 1e-3  # share of a quantity's natural size below which differences are relative to that


@checked_facts
@dataclass(frozen=True)
class RefereeVerdict:
    """Disagreements; relative ones to the largest entry of what is compared.

    Attributes:
        torque, wrench: inverse dynamics at every instant, relative.
        impulse, rate_after: impact, relative.
        sole_twist: twist of the old stance foot after the impact, and of a front foot that stands
            [m/s, rad/s].
        posture: q(0) and E q(T), Eq. (26) [rad]; with it the place of a front foot that stands [m].
        rate: dq(0) and E times the rates after impact, Eq. (27), relative; with them the rate at
            which a foot that landed on a line turns about it.
        momentum: ground force over the step plus impact impulse against the weight's impulse
            m g T and the change of the robot's momentum, largest component, relative to m g T.
        vertical: integral of the vertical ground force plus the vertical impulse [N·s].
        weight: m g T [N·s], without weight that is carried from outside; on a slope its part along
            the ground's normal, as `vertical` is.
    """

    torque: float
    wrench: float
    impulse: float
    rate_after: float
    sole_twist: float
    posture: float
    rate: float
    momentum: float
    vertical: float
    weight: float

    @property
    def worst(self) -> float:
        """Largest disagreement, the momentum balance apart (it carries a quadrature error)."""
        return max(
            self.torque, self.wrench, self.impulse, self.rate_after, self.sole_twist,
            self.posture, self.rate,
        )  # fmt: skip


def ask_referee(
    robot: Robot,
    step: Step,
    grid: Grid,
    schedule: Schedule | None = None,
    starts: tuple[Step, Step] | None = None,
) -> RefereeVerdict:
    """Compare a step with the referee's own computation.

    Args:
        grid: fine enough for the momentum balance; all its instants are quadrature nodes.
        schedule: of the step; by default that of the paper.
        starts: this step and the one after it, there exchanged, each at instants of which its
            start is the first; by default the step is followed by itself.
    """
    schedule, starts = schedule or Schedule(), starts or (step, step)
    after = starts[1]
    standing = standing_robot(robot, *schedule.contacts)
    chain = chain_of_robot(standing)
    loads = loads_of_robot(standing, chain)
    gravity: Array = np.array(robot.model.gravity.linear)
    coupled = standing.coupling.motion(step.whole_motion)
    motion = coupled.of_all
    own = chain if standing is robot else chain_of_robot(robot)
    front = None if step.double is None else wrench_on_ground(own, step.double.front)
    R0, torque = motor_effort(chain, loads, *motion, gravity=turned(gravity), end_wrench=front)
    torque = coupled.tangent.reduced(torque)
    wrench = sole_axes(R0)
    tied = robot.coupling
    landing = tied.at(step.q_end)
    last = step.rate_before
    if step.double is not None and not step.double.opens:
        last = step.double.liftoff.motion[1, 0, step.hinges :]
    q_end, before = tied.angles(step.q_end), at_rest(landing.rates(last))
    if step.turn is not None:
        before[:6] = sole_axes(step.turn.twist)
    line = None if step.landed is None else step.landed.hinge.twist
    ties = None if tied.none else tied.constraints(step.q_end)
    velocity, I13 = impact(own, q_end, before, line, ties)
    rate_after = velocity[6:][tied.free]
    impulse = impulse_on_foot(own, I13)
    struck = None if step.double is None else step.double.struck
    stated = step.impact.impulse, impulse
    if struck is not None:
        stated = _struck(own, step, struck)
    if step.flat is not None:
        flat = _flat(chain, step, step.flat)
        stated = np.concatenate([stated[0], flat[0]]), np.concatenate([stated[1], flat[1]])
    twist = base_in_sole_axes(velocity)[:6]
    E = schedule.symmetry.joint_map(robot)
    carried = 0.0 if loads.points is None else float(loads.points.mass.sum())
    weight = (chain.mass - carried) * gravity
    force, length = float(np.linalg.norm(weight)), robot.legs.reach
    rate = float(np.sqrt(np.linalg.norm(gravity) / length))
    start, landed = after.motion[1, 0], E @ rate_after
    push = impulse
    if step.landed is not None and line is not None:
        push = step.landed.on_ground @ impulse
        free = foot_twist(own, line)
        turn_rate = free @ swing_jacobian(own, q_end) @ velocity / (free @ free)
        start, landed = np.r_[start, after.foot_motion[1, 0, 0]], np.r_[landed, turn_rate]
    moved, displaced = _front_foot(chain, step)
    pull = weight * step.duration
    turned_by = [] if step.landed is None else [0.0]
    turned_by += [] if step.turn is None else [step.turn.angle]
    begin, following = (standing.coupling.motion(one.whole_motion).of_all[:2, 0] for one in starts)
    ends = begin, np.r_[turned_by, q_end], following
    balance, vertical = _momentum_balance(
        chain, step, grid, wrench, push, pull, schedule.symmetry, ends
    )
    return RefereeVerdict(
        torque=_apart(step.read(quantities.TORQUE), torque[:, step.hinges :], force * length),
        wrench=_apart(step.read(quantities.WRENCH), wrench, force),
        impulse=_apart(*stated, force * step.duration),
        rate_after=_apart(step.impact.rate_after if struck is None else last, rate_after, rate),
        sole_twist=max(float(np.abs(step.impact.sole_twist - twist).max()), moved),
        posture=max(float(np.abs(after.motion[0, 0] - E @ step.q_end).max()), displaced),
        rate=_apart(start, landed, rate),
        momentum=balance,
        vertical=vertical,
        weight=-float(pull[2]),
    )


def _struck(chain: Chain, step: Step, struck: ClosedJump) -> tuple[Array, Array]:
    """Return stated and found impulses of an impact that both feet take, shape (6 + n,) each.

    On the rear foot, then of the joints, of which there must be none.
    """
    push = wrench_on_ground(chain, step.impact.impulse)
    jump = step.impact.rate_after - step.rate_before
    R0, torque = inverse_dynamics(
        chain, struck.posture, np.zeros_like(jump), jump, gravity=np.zeros(3), end_wrench=push
    )
    stated = np.concatenate([struck.rear, np.zeros(jump.size)])
    return stated, np.concatenate([sole_axes(R0), torque])


def _flat(chain: Chain, step: Step, flat: FlatJump) -> tuple[Array, Array]:
    """Return stated and found impulses of a foot that comes to lie flat, shape (6 + n,) each.

    On the foot, then of the joints, of which there must be none; found with the hinge about which
    it turned, of the chain's first joints, as one of those that jump.
    """
    before, after = step.coefficients[-5], step.coefficients[-4]
    still = np.zeros(step.hinges)
    jump = np.concatenate([[-flat.rate], still[1:], after - before])
    posture = np.concatenate([still, flat.posture])
    R0, torque = inverse_dynamics(chain, posture, np.zeros_like(jump), jump, gravity=np.zeros(3))
    stated = np.concatenate([flat.impulse, np.zeros(flat.jump.size)])
    return stated, np.concatenate([sole_axes(R0), torque[step.hinges :]])


def _front_foot(chain: Chain, step: Step) -> tuple[float, float]:
    """How fast the front foot moves while both stand [m/s, rad/s], and how far it is away [m]."""
    if step.double is None:
        return 0.0, 0.0
    ends = step.double.touchdown, step.double.motion, step.double.liftoff
    q, dq, _ = np.concatenate([one.motion for one in ends], axis=1)
    twist = (swing_jacobian(chain, q)[..., 6:] @ dq[..., None])[..., 0]
    rotation, origin = sole_placement(chain, q)
    away = np.abs(origin - step.double.sole.translation).max()
    turned_by = np.abs(rotation - step.double.sole.rotation).max()
    return float(np.abs(twist).max()), float(max(away, turned_by))


def both(checks: Sequence[RefereeVerdict]) -> RefereeVerdict:
    """Return the disagreements about steps that follow each other: the largest of each kind."""
    summed = ("vertical", "weight")  # [N·s] over all of them
    found = {
        one.name: (sum if one.name in summed else max)(getattr(check, one.name) for check in checks)
        for one in fields(RefereeVerdict)
    }
    return RefereeVerdict(**found)


def _momentum_balance(
    chain: Chain,
    step: Step,
    grid: Grid,
    wrench: Array,
    push: Array,
    pull: Array,
    symmetry: Symmetry,
    ends: tuple[Array, Array, Array],
) -> tuple[float, float]:
    """Over a step the impulses of ground and weight are the change of momentum.

    From just after one impact to just after the next; there the symmetry of the walk
    makes it what the next step begins with, seen from the foot that has landed.

    Args:
        wrench: ground on stance foot at the instants, shape (N, 6) [N, N·m].
        push: ground on landing foot, in its footprint, shape (6,) [N·s, N·m·s].
        pull: impulse over the step of the weight that nothing else carries, shape (3,) [N·s].
        ends: angles and rates of all joints of the chain at the start, angles at the end, and
            angles and rates at the start of the next step.

    Returns:
        The largest component of what is left, over m g T, and the ground's vertical impulse [N·s].
    """
    begin, end, following = ends
    pushed = wrench[:, :3]
    if step.double is not None:
        pushed = pushed + step.double.front[:, :3] @ step.double.sole.rotation.T
    force = step.duration * grid.weights @ pushed
    if step.double is not None and step.double.struck is not None:
        force += step.double.sole.rotation @ step.impact.impulse[:3] + step.double.struck.rear[:3]
    if step.flat is not None:
        force += step.flat.impulse[:3]
    landed, _ = sole_placement(chain, end)
    if step.landed is not None:  # of the sole; from here on of its footprint
        landed = landed @ step.landed.place.rotation.T
    landing = landed @ push[:3]
    start, after = momentum(chain, *np.stack([begin, following], axis=1))[:, :3]
    change = landed @ (np.array(symmetry.reflection) * after) - start
    gap = force + landing + pull - change
    size = float(np.linalg.norm(pull))
    balance = float(np.abs(gap).max())
    return balance / size if size > 0.0 else balance, float(force[2] + landing[2])


def _apart(a: Array, b: Array, size: float) -> float:
    """Return the largest difference, relative to what is compared or to a thousandth of its size.

    The size is that of such a quantity in a walk, so that rounding next to an impulse of zero is
    not a disagreement; two quantities without any size agree where both are zero.
    """
    difference = float(np.abs(a - b).max())
    scale = max(float(np.abs(b).max()), LEAST * size)
    return difference / scale if scale > 0.0 else difference


_INSIDE = 1e-6  # of the step: nearest to its ends that a constraint which leaves them out is told


@checked_facts
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
        when = "" if self.time is None else f" at t = {fixed(self.time, 4)} s"
        return f"{self.row}{when}: {self.value:.5g} {self.unit}, allowed {self.limit:.5g}"


@checked_facts
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
            "kkt": dict(vars(self.kkt)),
            "kkt_tolerance": OPTIMALITY,
            "fine_samples": self.samples,
            "fine_cost": self.cost,
            "fine_violation": self.worst.violation,
            "fine_tolerance": LIMITS,
            "fine_resolution": self.resolution,
            "worst": dict(vars(self.worst)),
            "constraints": [dict(vars(row)) for row in self.constraints],
            "referee": dict(vars(self.referee)),
            "rear_foot_lifts": self.rear_foot_lifts,
            "rear_foot_speed": self.rear_foot_speed,
            "both_feet_stay": self.both_feet_stay,
        }


@checked_arguments
def certify(problem: WalkProblem, x: Array, fine: WalkProblem | None = None) -> Certificate:
    """Check a walk at x (P,) on the grid that was optimised, from first principles.

    Args:
        fine: the walk on the certificate's grid, if it is at hand.

    Raises:
        InputError: x is no array of numbers, or has another shape.
        EvaluationError: the walk is not defined at x.
    """
    x = problem.checked(x)
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
        constraints=worst_between(fine, x, extremes),
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
        for step, model, pair in zip(steps, fine.models, pairwise(starts), strict=True)
    ]
    return both(found)


def on_fine_grid(problem: WalkProblem) -> WalkProblem:
    """Return the walk on the proof's grid, Chebyshev points between its knots."""
    return problem.with_grid(proof_grid(problem.breaks))


def worst_between(
    fine: WalkProblem, x: Array, extremes: tuple[Extreme, ...] | None = None
) -> tuple[WorstRow, ...]:
    """Return the worst row of every constraint at x (P,) over the whole step, worst first.

    Args:
        fine: the walk on the proof's grid.
        extremes: of all rows at x, if they are at hand; computed again here.

    Raises:
        EvaluationError: the walk is not defined at x.
    """
    if extremes is None:
        extremes = located(fine, x, everywhere=True)
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
        if one.constraint not in worst:
            worst[one.constraint] = replace(one, instant=_inside(one.instant, fine.edges))
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
    margins = np.minimum(values - problem.rows.lower, problem.rows.upper - values)
    limited = [f for f in problem.blocks if np.isfinite([f.lower, f.upper]).any()]
    rows = [problem.rows_of(block.name) for block in limited]
    worst = [_row(problem, own.start + int(np.argmin(margins[own])), values, x) for own in rows]
    return tuple(sorted(worst, key=lambda row: row.margin))


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
