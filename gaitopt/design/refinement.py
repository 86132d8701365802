"""Semi-infinite refinement: add violated instants to the grid and solve again, until none is left.

An exchange method (Hettich & Kortanek, 1993, Semi-infinite programming, SIAM Review 35(3), section
7) with as few instants as possible. A limit that was kept at one instant is then violated a little
beside it: its multiplier moves there too. Measured on sixteen walks of eight robots, that takes a
quarter of the iterations off the median one, and one that ran to the limit of iterations without
it is certified; one takes four times more.

A limit that is held at two instants close together is exceeded half way between them, a quarter as
much round after round; held where the multipliers of the two say that it presses, and a little
beside it, it is exceeded a fiftieth as much (`sharpened`): four rounds instead of eight for the
biped at 1 m/s. Where that does not help, as for a pressure that stays at an edge for a while, the
next round holds limits at their peaks.

With the SQP's exact Hessian the first round begins with Newton's method for instants that move
along: mostly there is no other, and the SQP takes no step. Where only that its instants move makes
the walk a minimum, it is held on either side of each of them; exchange alone, which comes to the
same, takes three to seven times longer for G1 with arms and waist.

An exchange holds a limit where it is exceeded most and solves again; the extreme then lies a little
beside that, and a round leaves about a quarter of the violation. Reduction takes the instant s(x)
of an extreme for what it is, a function of the parameters with g_s(x, s) = 0. As a function of x
alone the row g(x, s(x)) has the gradient g_x and the Hessian

    g_xx - g_xs g_xs' / g_ss,

and Newton's method for the program with these rows converges quadratically, instants included
(section 7 of the same review). It is for starts near a solution; whether it has found one is left
to others to judge.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.design.active_set import (
    DIGITS,
    SAME_PEAK,
    ActiveRow,
    ViolatedRow,
    active_rows,
    exceeded,
    instants_of,
    is_among,
    moved,
    placed,
    sharpened,
    violated_rows,
)
from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.extremes import Extreme, located
from gaitopt.design.options import Search
from gaitopt.errors import EvaluationError
from gaitopt.gait.grid import Grid
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import (
    NLP,
    Array,
    Point,
    Rows,
    Solution,
    Start,
    Status,
    Values,
)
from gaitopt.solvers.globalization import RAISE, initial_penalty
from gaitopt.solvers.hessian import MOST
from gaitopt.solvers.newton import is_strict_minimum
from gaitopt.solvers.solver import Solver, make_iterate, with_least_squares_multipliers
from gaitopt.solvers.sqp import SQP, WARM_RADIUS
from gaitopt.solvers.subproblem import (
    ElasticStep,
    LocalModel,
    build_model,
    pose_subproblem,
    solve_subproblem,
)
from gaitopt.tolerances import FEASIBLE, REFINED

STEPS = 10  # at most
SETTLED = 1e-3  # scaled length of a step after which the instants are known well enough
CONTRACTION = 0.5  # of a step by the next; less is no quadratic convergence
NEAR = 1e-2  # scaled length of a step up to which extremes need not be renewed
RENEWED = 0.2  # of a step by the next; less tells that extremes bend otherwise than they did
DELTA = 1e-4  # of the period, between the two Jacobians of which g_xs is the difference
LEAST_BEND = 1e-2  # scaled second derivative in s; flatter extremes do not move
FARTHEST = 0.03  # of the period that an instant may move in a step
NEAR_ENOUGH = 0.5  # of the distance from an end at which a row that vanishes there is best held
MERGED = 0.03  # of the period: samples nearer to an extreme of the same row say nothing more


@dataclass(frozen=True)
class RestingWalk:
    """Where Newton's method came to rest.

    Attributes:
        x: parameters, shape (P,).
        active: limits with their multipliers, at the extremes.
        steps: taken, each with one evaluation and one Hessian.
        keeps: whether it keeps the limits at every instant, as closely as refinement asks.
        hessian: of the Lagrangian before the last step in scaled variables, shape (P, P).
    """

    x: Array
    active: tuple[ActiveRow, ...]
    steps: int
    keeps: bool
    hessian: Array


@dataclass(frozen=True)
class _Held:
    """A row at the instant at which it is held.

    Attributes:
        row: constraint, entry, instant and multiplier.
        upper: whether the limit is the upper one.
        bend: second derivative of its distance to the limit with respect to s; zero where the
            instant does not move.
    """

    row: ActiveRow
    upper: bool
    bend: float = 0.0


class _Masked(NLP):
    """A walk of which some rows have no limits."""

    def __init__(self, problem: WalkProblem, idle: NDArray[np.bool_]) -> None:
        self.problem, self.has_hessian = problem, True
        self.variables, self.cost_scale = problem.variables, problem.cost_scale
        self.rows = Rows(
            np.where(idle, -np.inf, problem.rows.lower), np.where(idle, np.inf, problem.rows.upper)
        )

    def values(self, x: Array) -> Values:
        return self.problem.values(x)

    def point(self, x: Array) -> Point:
        return self.problem.point(x)

    def hessian(self, x: Array, multipliers: Array, cost_weight: float) -> Array:
        return self.problem.hessian(x, multipliers, cost_weight)

    def describe(self, row: int) -> str:
        return self.problem.describe(row)


def resting_walk(
    sparse: WalkProblem, fine: WalkProblem, x: Array, active: Iterable[ActiveRow], solver: SQP
) -> RestingWalk | None:
    """Return the walk near a point at which Newton's method rests, None if there is none.

    Where that exceeds limits near an end at which they vanish, it goes on with these held where
    they are exceeded most, until it rests there.

    Args:
        sparse: the walk at its samples.
        x: where to begin, shape (P,).
        active: limits that a walk like it presses on.
        solver: whose quadratic programs are used.
    """
    found: RestingWalk | None = None
    last = before = np.inf
    try:
        held = _at_extremes(fine, located(fine, x), active)
        for steps in range(1, STEPS + 1):
            stage = _Stage(sparse, held)
            step = stage.step(x, solver, last, first=steps == 1)
            if step is None or (steps > 2 and step.length > CONTRACTION * max(last, before)):
                break
            if steps > 1 and _leads_away(step):
                break  # from here on multipliers grow, and programs with them are hardly solvable
            slow = step.length > (NEAR if steps == 1 else max(RENEWED * last, NEAR))
            before, last = last, step.length
            x, held = stage.after(x, step)
            settled = last <= SETTLED
            if not (settled or slow):
                continue
            pressing = tuple(one.row for one in held if one.row.multiplier)
            extremes = located(fine, x)
            peaks = exceeded(fine, extremes)
            if settled:
                rests = found is not None and found.steps == steps - 1
                found = RestingWalk(x, pressing, steps, not peaks, stage.hessian)
                if found.keeps or rests:
                    break
                last = np.inf
            vanishing = (peak for peak in peaks if peak.held != peak.instant)
            held = _at_extremes(fine, extremes, moved(pressing, vanishing))
    except EvaluationError:
        pass
    return found


def on_either_side(
    fine: WalkProblem, x: Array, active: Iterable[ActiveRow]
) -> tuple[ActiveRow, ...]:
    """Return the active rows of a walk at x (P,), in place of each that moves along two beside it.

    How a row bends as its instant moves may be all that makes the walk a minimum. Held on either
    side it does not move, and exceeds its limit in between by half of what refinement allows,
    or less where it bends otherwise so near.
    """
    rows: list[ActiveRow] = []
    for one in _at_extremes(fine, located(fine, x), active):
        if one.bend > 0.0 and one.row.multiplier:
            room = np.abs(fine.breaks - one.row.instant).min()
            aside = float(min(np.sqrt(REFINED / one.bend), room))
            instants = (round(one.row.instant + way * aside, DIGITS) for way in (-1.0, 1.0))
            half = 0.5 * one.row.multiplier
            rows += [replace(one.row, instant=s, multiplier=half) for s in instants]
        else:
            rows.append(one.row)
    return tuple(rows)


def _at_extremes(
    fine: WalkProblem, extremes: Iterable[Extreme], active: Iterable[ActiveRow]
) -> tuple[_Held, ...]:
    """Return the active rows, those near an extreme of their row moved there and joined.

    Extremes near their limit are held too, although nothing presses on them yet.
    """
    extremes = [one for one in extremes if np.isfinite(one.margin)]
    left, held = list(active), []
    instants: dict[tuple[str, int, bool], list[float]] = {}
    for one in extremes:
        instants.setdefault(_row_of(one), []).append(one.instant)
    vanishing: dict[tuple[str, int, bool], float] = {}
    for one in extremes:
        end = np.abs(fine.edges - one.instant).min()
        if end < SAME_PEAK and abs(one.at_end) < REFINED:
            vanishing[_row_of(one)] = max(one.curvature, vanishing.get(_row_of(one), 0.0))
            continue  # held near the end at which it vanishes
        if end < DELTA:
            continue  # held at an end
        near = [row for row in left if _belongs(row, one, instants[_row_of(one)])]
        left = [row for row in left if row not in near]
        bent = one.curvature > LEAST_BEND and np.abs(fine.breaks - one.instant).min() > DELTA
        pressure = sum(row.multiplier for row in near)
        instant = round(one.instant, DIGITS)
        row = ActiveRow(one.constraint, one.entry, instant, pressure)
        held.append(_Held(row, one.upper, one.curvature if bent else 0.0))
    kept = [_Held(row, row.multiplier > 0.0) for row in left]
    return *held, *_off_the_ends(kept, fine.edges, vanishing)


def _off_the_ends(
    kept: Sequence[_Held], ends: Array, vanishing: Mapping[tuple[str, int, bool], float]
) -> Iterator[_Held]:
    """Yield rows, those of a constraint that vanish at an end held together, away from there.

    At different instants they would be in each other's way: each is a row at all of them, with
    nearly the same gradient. And from walk to walk they would be held ever nearer to the end, where
    their gradients vanish too; refinement allows `away`.
    """
    together: dict[tuple[str, bool, float, bool], list[tuple[_Held, float]]] = {}
    for one in kept:
        row, bend = one.row, vanishing.get((one.row.constraint, one.row.entry, one.upper), 0.0)
        end = float(ends[np.abs(ends - row.instant).argmin()])
        if 0.0 < abs(row.instant - end) < SAME_PEAK and bend > 0.0:
            key = row.constraint, one.upper, end, row.instant > end
            together.setdefault(key, []).append((one, bend))
        else:
            yield one
    for (_, _, end, after), group in together.items():
        bend = max(bend for _, bend in group)
        distance = min(abs(one.row.instant - end) for one, _ in group)
        away = min(SAME_PEAK, float(np.sqrt(4.0 * REFINED / bend)))
        if distance > NEAR_ENOUGH * away:
            away = distance
        instant = round(end + away if after else end - away, DIGITS)
        for entry in {one.row.entry: None for one, _ in group}:
            alike = [one for one, _ in group if one.row.entry == entry]
            pressure = sum(one.row.multiplier for one in alike)
            yield replace(alike[0], row=replace(alike[0].row, instant=instant, multiplier=pressure))


def _row_of(extreme: Extreme) -> tuple[str, int, bool]:
    return extreme.constraint, extreme.entry, extreme.upper


def _belongs(row: ActiveRow, extreme: Extreme, rivals: Sequence[float]) -> bool:
    """Whether an active row is an extreme, moved a little: the nearest of that row."""
    if (row.constraint, row.entry) != (extreme.constraint, extreme.entry):
        return False
    distance = abs(row.instant - extreme.instant)
    side = row.multiplier == 0.0 or (row.multiplier > 0.0) == extreme.upper
    near = side and distance <= SAME_PEAK
    return near and distance <= min(abs(row.instant - rival) for rival in rivals)


def _leads_away(step: ElasticStep) -> bool:
    return step.length >= WARM_RADIUS


class _Stage:
    """One step of Newton's method: the walk at the instants of the moment."""

    def __init__(self, sparse: WalkProblem, held: Sequence[_Held]) -> None:
        timed = {block.name for block in sparse.blocks if block.times is not None}
        instants = [one.row.instant for one in held if one.row.constraint in timed]
        self.moving = [one for one in held if one.bend > 0.0]
        grid = sparse.grid.with_instants(np.unique(np.array(instants)))
        beside = np.round([one.row.instant + DELTA for one in self.moving], DIGITS)
        beside = np.setdiff1d(beside, np.round(grid.instants, DIGITS))
        self.problem = sparse.with_grid(grid.with_instants(beside))
        self.held = held
        self._blocks = {block.name: block for block in self.problem.blocks}
        self.numbers = [self._number(one.row) for one in held]
        self.multipliers = np.zeros(self.problem.rows.lower.size)
        np.add.at(self.multipliers, self.numbers, [one.row.multiplier for one in held])
        self.nlp = _Masked(self.problem, self._idle(sparse.grid))

    def _idle(self, own: Grid) -> NDArray[np.bool_]:
        """Return the rows that are no limits here, shape (m,).

        Those at instants at which only derivatives are wanted, or only a row is held on which
        nothing presses yet: there may be hundreds, and each other row near its limit is held at an
        extreme of its own. And those next to an extreme of the same row, which have nearly its
        gradient and keep their limit if it does.

        Args:
            own: the instants of the walk.
        """
        idle: NDArray[np.bool_] = np.zeros(self.problem.rows.lower.size, dtype=bool)
        pressing = [one.row.instant for one in self.held if one.row.multiplier]
        beside = np.sort(self.problem.grid.instants[own.count :])
        beside = beside[~is_among(beside, np.unique(pressing))]
        for block in self.problem.blocks:
            if block.times is None:
                continue
            part = idle[self.problem.rows_of(block.name)].reshape(block.lower.shape)
            part[is_among(block.times, beside)] = True
            for one in self.moving:
                if one.row.constraint == block.name:
                    part[np.abs(block.times - one.row.instant) < MERGED, one.row.entry] = True
        idle[self.numbers] = False
        return idle

    def _number(self, row: ActiveRow, later: float = 0.0) -> int:
        block, start = self._blocks[row.constraint], self.problem.rows_of(row.constraint).start
        k = int(row.instant)
        if block.times is not None:
            k = int(np.abs(block.times - (row.instant + later)).argmin())
        return int(start + k * block.lower.shape[1] + row.entry)

    def step(self, x: Array, solver: SQP, last: float, first: bool = True) -> ElasticStep | None:
        """Return the step from x in scaled variables; `last` is the length of the one before.

        After the first one, a step that leads away is not asked to keep all rows.
        """
        nlp, scale = self.nlp, self.nlp.variables.scale
        point = nlp.point(x)
        iterate = make_iterate(nlp, point, self.multipliers, np.zeros(x.size))
        H = nlp.hessian(x, self.multipliers, nlp.cost_scale)
        self.hessian = 0.5 * (H + H.T) * np.outer(scale, scale)  # with the instants as they are
        self.slopes = self._slopes(point)
        scaled = self.slopes * scale
        bent = np.array([abs(one.row.multiplier) / one.bend for one in self.moving])
        hessian = self.hessian + scaled.T @ (bent[:, None] * scaled)
        penalty = initial_penalty(nlp, iterate, solver.penalty)
        reach = min(WARM_RADIUS, 2.0 * last)
        for most in (np.inf, MOST):
            model = build_model(nlp, iterate, hessian, False, penalty, tight=True, most=most)
            step = self._solved(model, penalty, reach, solver, first)
            if step is not None or model.convex.sigma <= MOST:
                return step
        return None

    def _solved(
        self, model: LocalModel, penalty: float, reach: float, solver: SQP, first: bool
    ) -> ElasticStep | None:
        while True:
            posed = pose_subproblem(model, WARM_RADIUS, penalty, reach)
            step = solve_subproblem(posed, solver.qp_solver)
            if step is None or step.slack <= solver.feasibility:
                return step
            if not first and _leads_away(step):
                return step  # which ends the search; programs with more penalty are hardly solvable
            if penalty >= solver.max_penalty:
                return step
            penalty *= RAISE  # multipliers of a row grow where it is held nearer to such an end

    def _slopes(self, point: Point) -> Array:
        """Return g_xs of the rows that move, shape (K, P)."""
        here = [k for k, one in zip(self.numbers, self.held, strict=True) if one.bend > 0.0]
        both = np.array([here, [self._number(one.row, DELTA) for one in self.moving]], dtype=int)
        rows, at = np.unique(both, return_inverse=True)
        now, later = point.slopes[rows][at.reshape(both.shape)]
        return np.asarray((later - now) / DELTA)

    def after(self, x: Array, step: ElasticStep) -> tuple[Array, tuple[_Held, ...]]:
        """Return where a step leads: parameters, and the rows where their extremes will be."""
        variables = self.nlp.variables
        moved = np.clip(x + variables.scale * step.d, variables.lower, variables.upper)
        instants = {id(one): one.row.instant for one in self.held}
        for one, slope in zip(self.moving, self.slopes, strict=True):
            shift = float(slope @ (moved - x)) / one.bend
            shift = float(np.clip(shift if one.upper else -shift, -FARTHEST, FARTHEST))
            instants[id(one)] = float(np.clip(one.row.instant + shift, 0.0, 1.0))
        multipliers, held = step.multipliers.copy(), []
        for one, number in zip(self.held, self.numbers, strict=True):
            pressure, multipliers[number] = float(multipliers[number]), 0.0
            instant = round(instants[id(one)], DIGITS)  # or the row's number, see `ActiveRow`
            row = ActiveRow(one.row.constraint, one.row.entry, instant, pressure)
            held.append(_Held(row, one.upper, one.bend))
        others = active_rows(self.problem, multipliers)
        return moved, (*held, *(_Held(row, row.multiplier > 0.0) for row in others))


MAX_ROUNDS = 20
FASTER = 0.5
"""By which the worst violation has to fall in a round for the next to hold limits where they press.
A limit that presses over a while needs instants all along it, and is held at its peaks."""
CLOSELY = 1e-8
"""KKT residual to which a walk is solved that is held on either side of its instants: where it was
the conditions hold to `OPTIMALITY`, but it is half of `REFINED` away from limits that press."""
STILL = 1e-6
"""Scaled change of parameters up to which a walk keeps the limits that it kept: rows are held where
they are at their extremes, and what these move by counts squared."""
FOLLOWED = 3  # first rounds that may begin with Newton's method; then nothing held is let go
_WORTH_SOLVING = (Status.OPTIMAL, Status.STALLED)
_WORTH_GOING_ON = (*_WORTH_SOLVING, Status.ITERATION_LIMIT)
"""A round that crawled is followed by another, at whose instants it often does not."""
Solve = Callable[[WalkProblem, Start], Solution]


def refine(
    problem: WalkProblem,
    solution: Solution,
    solver: Solver,
    search: Search,
    *,
    fine: WalkProblem | None = None,
) -> tuple[WalkProblem, Solution]:
    """Solve again, warm, with the violated instants of the fine grid, until none is left.

    A walk that is nearly solved at its samples, to less than the solver's tolerances, is returned
    as it is where Newton's method for moving instants leads nowhere from there.

    Args:
        solver: used for every round.
        search: who is told; where it is stopped, the walk of the last complete round is kept.
        fine: the walk on the certificate's grid, if it is at hand.

    Returns:
        The walk on its final grid, and the solution with the work of the rounds that led to it.
    """
    if solution.status not in _WORTH_SOLVING:
        return problem, solution
    fine = fine or on_fine_grid(problem)
    peaks = violated_rows(fine, solution.x)
    if not peaks:
        return problem, solution

    def solve_with(method: Solver, finer: WalkProblem, start: Start) -> Solution:
        return method.solve(finer, start, search.callback(finer), search.ends)

    solve, newton = partial(solve_with, solver), quadratic(solver)
    nearly = (
        newton is not None and solution.status is Status.OPTIMAL and not newton.settles(solution)
    )
    resting: tuple[WalkProblem, Solution] | None = None
    parted = problem, solution  # before the first instants that moved along
    for way in (newton, None):
        found, moving = parted, False
        if parted[0] is not problem:
            peaks = violated_rows(fine, parted[1].x)
        active = active_rows(parted[0], parted[1].multipliers)
        rounds = exchange(parted[0], parted[1].x, active, solve, fine, peaks, way, nearly)
        for finer, again, near in rounds:
            moving = moving or near
            if again.status not in _WORTH_GOING_ON or again.violation > FEASIBLE:
                if nearly and (found[0] is problem or again.status is not Status.INTERRUPTED):
                    return problem, solution
                found = found[0], _kept(found[1], again)
                break
            found = finer, with_work(again, found[1])
            parted = parted if moving else found
        else:
            if nearly and not moving:
                return problem, solution
            found = pruned(problem, *found)
        if not moving or is_strict(*found):
            break  # where no instants moved, exchange alone would do the same again
        beside = _held_beside(problem, fine, *found, solver, solve_with)
        if beside is not None:
            return beside
        if nearly:  # exchange alone begins at a walk that is solved
            again = solve(problem, Start(solution.x, solution.multipliers))
            if again.status is not Status.OPTIMAL:
                return problem, solution
            parted, peaks = (problem, with_work(again, solution)), violated_rows(fine, again.x)
            nearly = False
        resting = resting or found
    crawled = found[1].status is not Status.OPTIMAL  # among rows that are nearly alike
    if crawled and resting is not None and resting[1].status is Status.OPTIMAL:
        return found if violated_rows(fine, resting[1].x) else resting
    return found


def _held_beside(
    sparse: WalkProblem,
    fine: WalkProblem,
    problem: WalkProblem,
    solution: Solution,
    solver: Solver,
    solve_with: Callable[[Solver, WalkProblem, Start], Solution],
) -> tuple[WalkProblem, Solution] | None:
    """Return a walk that its moving instants make a minimum held on either side of each of them.

    None where that is no strict minimum either, or exceeds a limit.

    Args:
        sparse: the walk at its samples.
        problem, solution: the walk at the instants that Newton's method has found, solved.
    """
    newton = quadratic(solver)
    if newton is None or solution.status is not Status.OPTIMAL:
        return None
    rows = on_either_side(fine, solution.x, active_rows(problem, solution.multipliers))
    finer = sparse.with_grid(sparse.grid.with_instants(instants_of(sparse, rows)))
    closely = replace(newton, tolerance=min(newton.tolerance, CLOSELY))
    again = solve_with(closely, finer, Start(solution.x, placed(finer, rows)))
    if not is_strict(finer, again) or violated_rows(fine, again.x):
        return None
    return finer, with_work(again, solution)


def is_strict(problem: WalkProblem, solution: Solution) -> bool:
    """Return whether a walk is a strict minimum with its instants fixed, and so can be confirmed.

    An instant that moves along bends its row, and may be all that makes the walk a minimum.
    Exchange then finds two instants on either side of that one, which do so too.
    """
    if solution.status is not Status.OPTIMAL:
        return solution.status is Status.INTERRUPTED
    point, scale = problem.point(solution.x), problem.variables.scale
    iterate = with_least_squares_multipliers(problem, point)  # as who confirms it will
    hessian = problem.hessian(point.x, iterate.multipliers, problem.cost_scale)
    return is_strict_minimum(problem, iterate, hessian * np.outer(scale, scale))


def quadratic(solver: Solver) -> SQP | None:
    """Return a solver of whose kind rounds may begin with Newton's method, None if it is none."""
    return solver if isinstance(solver, SQP) and solver.hessian == "exact" else None


def exchange(
    sparse: WalkProblem,
    x: Array,
    active: Iterable[ActiveRow],
    solve: Solve,
    fine: WalkProblem | None,
    peaks: Iterable[ViolatedRow] = (),
    newton: SQP | None = None,
    nearly: bool = False,
) -> Iterator[tuple[WalkProblem, Solution, bool]]:
    """Yield walk, solution and whether Newton's method began it, until a walk keeps the limits.

    After `MAX_ROUNDS` the last ones may still exceed them, and so may one that ended where it began
    at the instants of the round before: all rounds after it would. A round whose solution is of no
    use must be the last that is asked for.

    Args:
        x: where to begin, shape (P,).
        active: limits that a walk like it presses on.
        solve: solves a round.
        fine: the walk on the certificate's grid; None to leave the limits at the samples.
        peaks: where x exceeds limits.
        newton: of whose kind rounds may begin with Newton's method, its instants moving along.
        nearly: whether x is only nearly a solution; nothing is yielded where the first cannot.

    Raises:
        EvaluationError: a solution's walk is not defined on the fine grid.
    """
    instants, active, peaks = instants_of(sparse, active), tuple(active), tuple(peaks)
    excess, before_it = _worst(peaks), np.zeros(0)  # peaks may not be known: the first may stay
    for number in range(MAX_ROUNDS):
        active, near = moved(active, peaks), None
        if newton is not None and fine is not None and number < FOLLOWED:
            near = resting_walk(sparse, fine, x, active, newton)
        beside = [one for peak in peaks for one in peak.beside]  # to stay if they press
        if near is None and nearly and number == 0:
            return
        if near is None:
            instants = np.union1d(instants, instants_of(sparse, active))
        else:
            x, active, beside = near.x, near.active, []
            instants, newton = instants_of(sparse, active), newton if near.keeps else None
        problem = sparse.with_grid(sparse.grid.with_instants(np.union1d(instants, beside)))
        known = None if near is None else near.hessian
        solution = solve(problem, Start(x, placed(problem, active), known))
        if near is None:
            yield problem, solution, False
        else:
            yield problem, _with_steps(solution, near.steps), True
            moved_by = np.abs(solution.x - near.x) / problem.variables.scale
            if near.keeps and moved_by.max() <= STILL:
                return  # nothing has moved since the limits were looked at
        same = np.array_equal(problem.grid.instants, before_it) and np.array_equal(x, solution.x)
        stuck, before_it = near is None and same, problem.grid.instants
        x, active = solution.x, active_rows(problem, solution.multipliers)
        peaks = () if fine is None else violated_rows(fine, x)
        if stuck or not peaks:
            return
        before, excess = excess, _worst(peaks)
        if excess < FASTER * before:
            peaks = sharpened(active, peaks)


def _worst(peaks: Iterable[ViolatedRow]) -> float:
    return max((peak.excess for peak in peaks), default=np.inf)


def _with_steps(solution: Solution, steps: int) -> Solution:
    """Return a solution that counts the steps that led to its start."""
    return replace(
        solution,
        iterations=solution.iterations + steps,
        evaluations=solution.evaluations + steps,
        hessians=solution.hessians + steps,
    )


def pruned(
    sparse: WalkProblem, problem: WalkProblem, solution: Solution
) -> tuple[WalkProblem, Solution]:
    """Return the walk on the grid without added instants at which nothing presses.

    Limits with nearly the same gradients cost a second opinion more than all the rest.
    """
    active = active_rows(problem, solution.multipliers)
    grid = sparse.grid.with_instants(instants_of(sparse, active))
    if grid.instants.size == problem.grid.instants.size:
        return problem, solution  # what is known of it stays so
    lean = sparse.with_grid(grid)
    return lean, replace(solution, multipliers=placed(lean, active))


def _kept(solution: Solution, failed: Solution) -> Solution:
    """Return the solution before a round that failed: a gait at its own samples at least."""
    status = Status.INTERRUPTED if failed.status is Status.INTERRUPTED else solution.status
    kept = with_work(solution, failed)
    return replace(kept, status=status, history=solution.history + failed.history)


def with_work(solution: Solution, before: Solution) -> Solution:
    """Return a solution that counts the work of another round as well."""
    return replace(
        solution,
        iterations=solution.iterations + before.iterations,
        evaluations=solution.evaluations + before.evaluations,
        hessians=solution.hessians + before.hessians,
        seconds=solution.seconds + before.seconds,
        history=before.history + solution.history,
    )
