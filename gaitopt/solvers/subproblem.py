"""The subproblem of an SQP iteration, never infeasible thanks to one elastic variable.

    minimise over d, s   g'd + 1/2 d'H d + nu s + 1/2 w s^2
    subject to           lower - s <= c + J d <= upper + s
                         box_lower <= d <= box_upper,   s >= 0

(Nocedal & Wright, 2006, section 18.5, with the infinity norm in place of the 1-norm.) All in
variables divided by their scale, so that the trust region is a cube, and with H made convex. Of the
thousand rows only those that the step may reach are given to the quadratic program; a row left out
and then violated is added and the program solved again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.nlp import NLP, Array, Indices, Slopes
from gaitopt.solvers.hessian import FLOOR, ConvexModel, convexify, unchanged
from gaitopt.solvers.qp import QuadraticProgram, cholesky, solve_qp
from gaitopt.solvers.solver import Iterate

ROUNDS = 8
"""Times rows are added before all of them are given (one or two suffice mostly: measured)."""
MISSED = 1e-10
"""Violation from which a row left out is added."""
STIFFNESS = 1e-3
"""w / nu: without the quadratic term the programs are badly conditioned (measured)."""

HELD_ROUNDS = 6
"""Times rows that press are let go or added before a quadratic program is solved (measured: with
half as many, a replanner asks for a third more of these, with twice as many for hardly fewer)."""
INDEPENDENT = 1e-6
"""Part of a row's gradient, over its length, that must be new beside those of the rows before
(measured: 1e-9 does equally well, with 1e-4 half as many again of the steps are refused)."""
ACTIVE = 1e-7
"""Multipliers below this fraction of the largest count as zero."""
REACH = 0.01
"""Rows nearer than this share of the largest change a step can make are given to the quadratic
program at first. A fifth of those within 0.3 are; a few programs more take two thirds of the time
(measured: docs/decisions/speed.md)."""

Mask = NDArray[np.bool_]
Active = tuple[Indices, ...]


@dataclass(frozen=True)
class ScaledSlopes:
    """The Jacobian of the rows in scaled variables.

    Attributes:
        slopes: in the variables as they are.
        scale: of the variables, shape (n,).
    """

    slopes: Slopes
    scale: Array

    def __getitem__(self, rows: Indices) -> Array:
        """Return some rows by their numbers, ascending (k,), shape (k, n)."""
        return self.slopes[rows] * self.scale

    def __matmul__(self, d: Array) -> Array:
        """Return the change of all rows along a step (n,), shape (m,)."""
        return self.slopes @ (self.scale * d)


@dataclass(frozen=True)
class QuadraticModel:
    """The scaled cost to second order, with the curvature of the rows that press.

    Attributes:
        gradient: of the scaled cost, shape (n,).
        hessian: of the Lagrangian, unmodified, shape (n, n).
    """

    gradient: Array
    hessian: Array

    def predicted_decrease(self, d: Array) -> float:
        """Return how much the scaled cost should fall by d (n,)."""
        return -float(self.gradient @ d + 0.5 * d @ self.hessian @ d)


@dataclass(frozen=True)
class LocalModel(QuadraticModel):
    """First and second derivatives at an iterate, and the convex model made from them.

    Attributes:
        convex: model in (d, s), see `convexify`.
        jacobian: of the rows.
        row_sizes: 1-norm of each row of the Jacobian, or a bound of it, shape (m,).
        sizes_of: from numbers of some rows (k,) to closer bounds, shape (k,).
        below, above: limits of the rows less their values, shape (m,).
        bound_below, bound_above: the same for the variables, shape (n,).
        active: rows believed active at their upper and at their lower limit, and variables at
            their bounds.
    """

    convex: ConvexModel
    jacobian: Slopes
    row_sizes: Array
    sizes_of: Callable[[Indices], Array]
    below: Array
    above: Array
    bound_below: Array
    bound_above: Array
    active: Active


def build_model(
    nlp: NLP,
    iterate: Iterate,
    hessian: Array,
    definite: bool,
    penalty: float,
    tight: bool,
    most: float = np.inf,
) -> LocalModel:
    """Build the local model at an iterate.

    Args:
        iterate: where; its nonzero multipliers tell which rows are believed active.
        hessian: of the Lagrangian in scaled variables, shape (n, n).
        definite: whether it is known to be positive definite.
        penalty: nu, the weight of the slack.
        tight: whether the slack is believed to be zero at the next step.
        most: see `convexify`.
    """
    point, scale = iterate.point, nlp.variables.scale
    jacobian = ScaledSlopes(point.slopes, scale)
    active = _believed(iterate.multipliers, iterate.bound_multipliers)
    elastic = _with_slack(hessian, STIFFNESS * penalty)
    if definite:
        convex = unchanged(elastic)
    elif tight:
        convex = convexify(elastic, _gradients(jacobian, active, scale.size), most)
    else:
        # With slack left the rows do not fix the step's range part (measured: it stalls).
        convex = convexify(elastic, np.zeros((0, elastic.shape[0])))
    return LocalModel(
        gradient=nlp.cost_scale * point.gradient * scale,
        hessian=hessian,
        convex=convex,
        jacobian=jacobian,
        row_sizes=point.most_change(scale),
        sizes_of=partial(point.most_change, scale),
        below=nlp.rows.lower - point.rows,
        above=nlp.rows.upper - point.rows,
        bound_below=(nlp.variables.lower - point.x) / scale,
        bound_above=(nlp.variables.upper - point.x) / scale,
        active=active,
    )


def with_active(
    model: LocalModel, multipliers: Array, bound_multipliers: Array, penalty: float
) -> LocalModel:
    """Return a model made convex for the rows that other multipliers tell, or itself.

    Args:
        model: the local model; the slack of its next step is believed to be zero.
        multipliers, bound_multipliers: of rows (m,) and bounds (n,).
        penalty: nu, the weight of the slack.
    """
    told = _believed(multipliers, bound_multipliers)
    if all(map(np.array_equal, told, model.active)):
        return model
    elastic = _with_slack(model.hessian, STIFFNESS * penalty)
    convex = convexify(elastic, _gradients(model.jacobian, told, model.gradient.size))
    return replace(model, convex=convex, active=told)


def _with_slack(hessian: Array, stiffness: float) -> Array:
    n = hessian.shape[0]
    matrix = np.zeros((n + 1, n + 1))
    matrix[:n, :n] = hessian
    matrix[n, n] = stiffness
    return matrix


def _gradients(jacobian: Slopes, active: Active, n: int) -> Array:
    """Return the gradients in (d, s) of what is believed active, s = 0 last, shape (k, n + 1)."""
    up, down, bound_up, bound_down = active
    ends = np.cumsum([each.size for each in active])
    found = np.zeros((ends[-1] + 1, n + 1))
    found[: ends[0], :n] = jacobian[up]
    np.negative(jacobian[down], out=found[ends[0] : ends[1], :n])
    found[: ends[1], n] = -1.0
    found[range(ends[1], ends[2]), bound_up] = 1.0
    found[range(ends[2], ends[3]), bound_down] = -1.0
    found[-1, n] = 1.0
    return found


def _believed(*multipliers: Array) -> Active:
    """Return what multipliers of rows (m,) and of bounds (n,) say is active, by their signs."""
    return tuple(np.flatnonzero(side) for each in multipliers for side in _each_side(each))


def _each_side(multipliers: Array) -> tuple[Mask, Mask]:
    """Return which are above zero, and which below, those left out that count as zero."""
    threshold = ACTIVE * float(np.abs(multipliers).max(initial=0.0))
    return multipliers > threshold, multipliers < -threshold


@dataclass(frozen=True)
class Subproblem:
    """The subproblem in (d, s), and the rows to begin with.

    Attributes:
        gradient: linear cost of (d, s), shape (n + 1,).
        hessian: quadratic cost of (d, s), shape (n + 1, n + 1), positive definite.
        jacobian: J.
        below, above: lower - c and upper - c, shape (m,).
        box_lower, box_upper: shape (n,).
        use_below, use_above: rows whose lower, upper side is given at first, shape (m,).
        pressing: what is believed to press, of the box of (d, s) and then of rows, shape
            (n + 1 + m,): above zero at upper limits, below at lower ones; None if not known.
    """

    gradient: Array
    hessian: Array
    jacobian: Slopes
    below: Array
    above: Array
    box_lower: Array
    box_upper: Array
    use_below: Mask
    use_above: Mask
    pressing: Array | None = None


@dataclass(frozen=True)
class ElasticStep:
    """The solution of a subproblem.

    Attributes:
        d: step, shape (n,).
        slack: s, the violation the linear model still has after the step.
        change: J d, of the rows, shape (m,).
        multipliers: of the rows, shape (m,), positive at upper limits.
        box_multipliers: of the box, shape (n,), positive at upper limits.
        use_below, use_above: the rows that were needed, shape (m,).
    """

    d: Array
    slack: float
    change: Array
    multipliers: Array
    box_multipliers: Array
    use_below: Mask
    use_above: Mask

    @property
    def length(self) -> float:
        """Largest component of d."""
        return float(np.abs(self.d).max(initial=0.0))

    @property
    def pressing(self) -> Array:
        """What presses, as of `Subproblem`, shape (n + 1 + m,)."""
        slack = [0.0 if self.slack > 0.0 else -1.0]
        return np.concatenate([self.box_multipliers, slack, self.multipliers])


@dataclass(frozen=True)
class HeldStep(QuadraticModel):
    """Newton's step with the rows that press held, and the model that it is of.

    Attributes:
        step: with multipliers; if no other rows were looked at, the change of others is 0.
        residual: gradient of the Lagrangian where it begins, with its multipliers, largest entry.
    """

    step: ElasticStep
    residual: float


def hold(
    nlp: NLP, iterate: Iterate, hessian: Array, penalty: float, every: bool
) -> HeldStep | None:
    """Return the solution of the subproblem if the rows that press are nearly those of before.

    With these as equations no quadratic program is needed. What presses with the wrong sign is let
    go, and what the step breaks most is held too, a few times.

    Args:
        iterate: where; its nonzero multipliers tell which rows pressed.
        hessian: of the Lagrangian in scaled variables, shape (n, n).
        penalty: nu, the weight of the slack.
        every: whether to look at all rows; else whether the step breaks one that did not press is
            to be seen where it leads.

    Returns:
        None where it is not known after a few rounds, where rows that press are nearly dependent,
        or where the Hessian bends too little on their null space.
    """
    point, scale = iterate.point, nlp.variables.scale
    jacobian, gradient = ScaledSlopes(point.slopes, scale), nlp.cost_scale * point.gradient * scale
    below = np.append(nlp.rows.lower - point.rows, (nlp.variables.lower - point.x) / scale)
    above = np.append(nlp.rows.upper - point.rows, (nlp.variables.upper - point.x) / scale)
    m, n = point.rows.size, scale.size
    equal = below == above
    sides = np.append(_sides(iterate.multipliers), _sides(iterate.bound_multipliers))
    sides[equal & (sides == 0.0)] = 1.0
    for _ in range(HELD_ROUNDS):
        held = np.flatnonzero(sides)
        rows, bounds = held[held < m], held[held >= m] - m
        A = np.concatenate([jacobian[rows], np.eye(n)[bounds]])
        b = np.where(sides[held] > 0.0, above[held], below[held])
        solved = _with_equations(gradient, hessian, A, b)
        if solved is None:
            return None
        d, y = solved
        changes = jacobian @ d if every else np.zeros(m)
        changes[rows] = b[: rows.size]
        both = np.append(changes, d)
        broken = np.maximum(both - above, below - both)
        broken[held] = 0.0
        if not every:
            broken[:m] = 0.0
        wrong = (y * sides[held] < 0.0) & ~equal[held]
        worst = int(broken.argmax())
        if not wrong.any() and broken[worst] <= MISSED:
            break
        every = True
        sides[held[wrong]] = 0.0
        if broken[worst] > MISSED:
            sides[worst] = 1.0 if both[worst] > above[worst] else -1.0
    else:
        return None
    multipliers = np.zeros(m + n)
    multipliers[held] = y
    if float(np.abs(multipliers[:m]).sum()) > penalty:
        return None
    none = np.zeros(m, dtype=np.bool_)
    step = ElasticStep(d, 0.0, changes, multipliers[:m], multipliers[m:], none, none)
    return HeldStep(gradient, hessian, step, float(np.abs(hessian @ d / scale).max()))


def _sides(multipliers: Array) -> Array:
    """Return 1 for those above zero, -1 for those below, 0 for those that count as zero."""
    above, below = _each_side(multipliers)
    return above.astype(np.float64) - below


def _with_equations(g: Array, H: Array, A: Array, b: Array) -> tuple[Array, Array] | None:
    """Return d (n,) and y (k,) with H d + A'y = -g, A d = b; None where that is no minimum.

    By A' = [Y Z] [R; 0] (Nocedal & Wright, 2006, section 16.2).

    Args:
        g, H: shapes (n,), (n, n).
        A, b: shapes (k, n), (k,).
    """
    k, n = A.shape
    if k > n:
        return None
    length = np.maximum(np.linalg.norm(A, axis=1), 1e-300)
    Q, R = np.linalg.qr((A / length[:, None]).T, mode="complete")
    R, Y, Z = R[:k], Q[:, :k], Q[:, k:]
    if np.abs(R.diagonal()).min(initial=1.0) < INDEPENDENT:
        return None
    reduced = Z.T @ H @ Z
    if cholesky(reduced - FLOOR * np.eye(n - k)) is None:
        return None
    d = Y @ np.linalg.solve(R.T, b / length)
    d = d - Z @ np.linalg.solve(reduced, Z.T @ (g + H @ d))
    return d, -np.linalg.solve(R, Y.T @ (g + H @ d)) / length


def pose_subproblem(model: LocalModel, radius: float, penalty: float, reach: float) -> Subproblem:
    """Pose the subproblem of a trust region of this radius.

    Args:
        radius: of the trust region.
        penalty: nu.
        reach: infinity norm of the longest step to expect.
    """
    near, room = REACH * reach * model.row_sizes, np.minimum(model.above, -model.below)
    rows = np.flatnonzero(room <= near)
    near[rows] = REACH * reach * model.sizes_of(rows)
    use_above, use_below = model.above <= near, -model.below <= near
    use_above[model.active[0]] = True
    use_below[model.active[1]] = True
    return Subproblem(
        gradient=_gradient(model, model.below, model.above, radius, penalty),
        hessian=model.convex.matrix,
        jacobian=model.jacobian,
        below=model.below,
        above=model.above,
        box_lower=np.maximum(-radius, np.minimum(0.0, model.bound_below)),
        box_upper=np.minimum(radius, np.maximum(0.0, model.bound_above)),
        use_below=use_below,
        use_above=use_above,
    )


def pose_correction(
    model: LocalModel,
    posed: Subproblem,
    step: ElasticStep,
    change: Array,
    radius: float,
    penalty: float,
) -> Subproblem:
    """Pose the second-order correction: rows as they are at x + d, moved back along J d.

    Nocedal & Wright (2006), Eq. 18.57, after Fletcher (1982).

    Args:
        change: rows at the trial point less rows at the iterate, shape (m,).
        radius: of the trust region.
        penalty: nu.
    """
    curved = change - step.change
    below, above = model.below - curved, model.above - curved
    return replace(
        posed,
        gradient=_gradient(model, below, above, radius, penalty),
        below=below,
        above=above,
        use_below=step.use_below,
        use_above=step.use_above,
        pressing=step.pressing,
    )


def _gradient(
    model: LocalModel, below: Array, above: Array, radius: float, penalty: float
) -> Array:
    gradient = np.append(model.gradient, penalty)
    if model.convex.sigma == 0.0:
        return gradient
    limits = above, -below, model.bound_above, -model.bound_below
    rooms = [room[own] for room, own in zip(limits, model.active, strict=True)]
    slack = [0.0]
    return gradient + model.convex.linear_term(np.concatenate([*rooms, slack]), radius)


def solve_subproblem(problem: Subproblem, backend: str) -> ElasticStep | None:
    """Solve the elastic subproblem, or return None when no quadratic solver could."""
    for attempt in range(ROUNDS + 1):
        if attempt == ROUNDS:
            every = np.isfinite(problem.below), np.isfinite(problem.above)
            problem = replace(problem, use_below=every[0], use_above=every[1])
        step = _solve_screened(problem, backend)
        if step is None:
            return None
        missed_below = (problem.below - step.change > step.slack + MISSED) & ~problem.use_below
        missed_above = (step.change - problem.above > step.slack + MISSED) & ~problem.use_above
        if not (missed_below.any() or missed_above.any()):
            return step
        problem = replace(
            problem,
            use_below=problem.use_below | missed_below,
            use_above=problem.use_above | missed_above,
            pressing=step.pressing,
        )
    return step


def _solve_screened(problem: Subproblem, backend: str) -> ElasticStep | None:
    above = np.flatnonzero(problem.use_above)
    below = np.flatnonzero(problem.use_below)
    solution = solve_qp(_quadratic_program(problem, above, below), backend)
    if solution is None:
        return None
    n = problem.box_lower.size
    multipliers = np.zeros(problem.below.size)
    multipliers[above] += solution.rows[: above.size]
    multipliers[below] -= solution.rows[above.size :]
    d = np.clip(solution.x[:n], problem.box_lower, problem.box_upper)
    return ElasticStep(
        d=d,
        slack=max(0.0, float(solution.x[n])),
        change=problem.jacobian @ d,
        multipliers=multipliers,
        box_multipliers=solution.bounds[:n],
        use_below=problem.use_below,
        use_above=problem.use_above,
    )


def _quadratic_program(problem: Subproblem, above: Indices, below: Indices) -> QuadraticProgram:
    n, k = problem.box_lower.size, above.size
    each = np.flatnonzero(problem.use_above | problem.use_below)
    slopes, G = problem.jacobian[each], np.empty((k + below.size, n + 1))
    np.take(slopes, each.searchsorted(above), axis=0, out=G[:k, :n])
    np.negative(slopes[each.searchsorted(below)], out=G[k:, :n])
    G[:, n] = -1.0
    h = np.concatenate([problem.above[above], -problem.below[below]])
    # d = 0 needs no more slack than the worst row has, so this limit on s is never active.
    enough = 10.0 * max(1.0, -float(h.min(initial=0.0)))
    box = np.append(problem.box_lower, 0.0), np.append(problem.box_upper, enough)
    pressing = problem.pressing
    if pressing is not None:
        bounds, rows = pressing[: n + 1], pressing[n + 1 :]
        pressing = np.concatenate([bounds, rows[above] > 0.0, rows[below] < 0.0])
    return QuadraticProgram(problem.hessian, problem.gradient, G, h, *box, pressing)
