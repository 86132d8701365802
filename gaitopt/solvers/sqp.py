"""Sequential quadratic programming with a filter and a trust region, in scaled variables.

Each iteration solves a convex quadratic program for a step d within a cube (`subproblem`), tries
it, corrects it for the curvature of the rows if it disappoints, and accepts it when it betters cost
or violation against a filter (`globalization`). Where the rows that press are nearly known, no
program is solved: Newton's step with these as equations is its solution.

Sources: Nocedal & Wright, "Numerical Optimization" (2006), chapter 18; Fletcher & Leyffer,
Mathematical Programming 91 (2002); Conn, Gould & Toint, "Trust-Region Methods" (2000).
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import ClassVar

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.errors import EvaluationError
from gaitopt.nlp import NLP, Array, Point, Solution, Start, Status, violations
from gaitopt.settings import checked, entry
from gaitopt.solvers.globalization import (
    CEILING,
    FILTER_RESETS,
    GOOD,
    LARGE_VIOLATION,
    LASTING_DECREASE,
    NEARLY_FEASIBLE,
    RAISE,
    SHRINK,
    STALLED_AFTER,
    STALLED_AFTER_BFGS,
    STEERED,
    Filter,
    Patience,
    Trial,
    TrustRegion,
    accepts,
    corrected,
    initial_penalty,
    judge,
)
from gaitopt.solvers.hessian import MOST, LagrangianHessian
from gaitopt.solvers.multipliers import bound_multipliers, bounds_pressing, one_sided
from gaitopt.solvers.qp import BACKENDS
from gaitopt.solvers.solver import (
    Iterate,
    Recorder,
    SingleStage,
    is_unbounded,
    make_iterate,
    require_choice,
    with_least_squares_multipliers,
)
from gaitopt.solvers.subproblem import (
    ElasticStep,
    HeldStep,
    LocalModel,
    QuadraticModel,
    Subproblem,
    build_model,
    hold,
    pose_correction,
    pose_subproblem,
    solve_subproblem,
    with_active,
)
from gaitopt.tolerances import FEASIBILITY, FEASIBLE, OPTIMALITY

NO_DECREASE = 1e-4
"""Relative decrease of the violation below which the model is called stationary (measured)."""
WARM_RADIUS = 0.5
"""First trust region near a solution; 0.1 costs sweeps a quarter more iterations (measured)."""
ROUGH, ROUGHLY_FEASIBLE = 0.1, 1e-4
"""Tolerances for answers that are only the way to others. With 1 and 0.001 slower walks take a
fifth fewer iterations, but lead one of ten random bipeds to an optimum that costs 4 % more
(measured)."""
UNBOUNDED_AFTER = 100
"""Longest steps in a row, all feasible, after which a cost is called unbounded: 200 units of the
variables' scale with the default radius, in radians thirty turns."""
EARLY, EARLY_FEASIBLE = 0.03, 1e-3
"""Length of the next step and violation with which a run ends that need not arrive (measured)."""
VENTURES, VENTURED = 5, 0.1
"""Times that a run from a guess may take a step that is refused although the model fits, and the
most violation that may lead to, in scaled rows (measured: docs/decisions/speed.md)."""
CHORD = 0.3
"""Share of the tolerance below which the residual is to fall where no new Hessian is computed
(measured: it ends within a fifth and five times of what is predicted)."""
POLISH_BELOW = 1e-1
"""KKT residual below which a step may be judged by that residual (measured) ..."""
POLISH_GAIN = 0.5
"""... which must fall to this share."""
FAR, HALF = 0.1, 0.5
"""KKT residual above which a step that is not taken is tried again with what the cost alone bends,
and the share of its length to which the region then shrinks (measured)."""
RECHECK_AFTER = 4
"""Feasible iterates in a row with no better KKT residual, after which the iterate is judged by its
least-squares multipliers. Those of a step are poor where rows have nearly the same gradients (a
limit held at two instants close together): the run then goes to and fro about an optimum that it
does not recognise."""
STILL_FOR, STILL = 10, 1e-5
"""Feasible iterates in a row whose cost changes by no more than this share, while multipliers grow,
after which a run has come to a tip of its limits, if it is at one (`NLP.is_tip`)."""
SHORT = 1e-5
"""Length of the last step up to which that is done at once, too: a run hardly goes anywhere by it,
so that a residual that is left is mostly that of poor multipliers."""
NEARLY = 1e-4
"""KKT residual of feasible iterates below which that is done at once: the multipliers of a step
belong to where it began, and may hide for an iteration that it has arrived."""


@checked
@dataclass(frozen=True)
class SQP(SingleStage):
    """Filter trust-region SQP: few evaluations, from far away too.

    Attributes:
        tolerance: on the gradient of the Lagrangian and on complementarity.
        feasibility: on the largest violation of a row or bound.
        max_iterations: subproblems tried, rejected ones included.
        hessian: "exact", or "bfgs" to learn curvature from gradients; a program without second
            derivatives always gets the latter.
        qp_solver: quadratic solver asked first, one of `qp.BACKENDS`.
        initial_radius, max_radius: of the trust region, in units of the variables' scale
            (measured: 0.07 to 0.15 and 2 to 5 do equally well).
        min_radius: a smaller trust region ends the run.
        penalty: weight of the slack at the beginning. In the end it must exceed the sum of the
            multipliers, and is raised by itself when it proves too small (measured: begun with
            that sum or less, more starts lead to an optimum than with several times as much) ...
        max_penalty: ... but not beyond this; only then is a program called infeasible.
        early: whether a run ends as soon as it is near, where another method arrives sooner; called
            optimal, with the KKT residual that it has.
    """

    name: ClassVar[str] = "sqp"
    tolerance: float = entry(OPTIMALITY, "Largest residual of the optimality conditions.")
    feasibility: float = FEASIBILITY
    max_iterations: int = entry(300, "Most iterations of one run of the solver.")
    hessian: str = "exact"
    qp_solver: str = entry(
        "daqp",
        "Solver of the quadratic subproblems of the SQP.",
        choices=tuple(BACKENDS),
        metavar="NAME",
    )
    initial_radius: float = 0.1
    max_radius: float = 2.0
    min_radius: float = 1e-10
    penalty: float = 200.0
    max_penalty: float = 1e6
    early: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        require_choice(self.name, "hessian", self.hessian, ("exact", "bfgs"))
        require_choice(self.name, "qp_solver", self.qp_solver, BACKENDS)

    def _solved(self, recorder: Recorder, point: Point, start: Start) -> Solution:
        nlp = recorder.evaluator.nlp
        known = np.zeros(nlp.rows.lower.size) if start.multipliers is None else start.multipliers
        multipliers = one_sided(known, nlp.rows.lower, nlp.rows.upper)
        first = make_iterate(nlp, point, multipliers, bounds_pressing(nlp, point, multipliers))
        if known.any() and first.violation <= self.feasibility:
            own = with_least_squares_multipliers(nlp, point, self.tolerance)  # of bounds too
            if own.is_optimal(self.tolerance, self.feasibility):
                first = own
        run = _Run(self, nlp, recorder, first, start.hessian)
        status = run.iterate_until_verdict()
        best = recorder.answer(status, run.iterate)
        if status is Status.INFEASIBLE and best.violation <= FEASIBLE:
            status = Status.STALLED  # it went astray from a feasible iterate
        return replace(recorder.solution(status, best), hessian=run.hessian.last)

    def settles(self, answer: Solution) -> bool:
        """Return whether an answer satisfies the conditions as closely as is asked."""
        return answer.optimality <= self.tolerance and answer.violation <= self.feasibility

    def limited(self, iterations: int) -> SQP:
        return replace(self, max_iterations=min(self.max_iterations, iterations))

    def near_solution(self) -> SQP:
        return replace(self, initial_radius=WARM_RADIUS)

    def roughly(self) -> SQP:
        return replace(
            self,
            tolerance=max(self.tolerance, ROUGH),
            feasibility=max(self.feasibility, ROUGHLY_FEASIBLE),
        )


class _Run:
    """The state of a run: the iterate, its model, and what has been learnt on the way."""

    def __init__(
        self,
        options: SQP,
        nlp: NLP,
        recorder: Recorder,
        iterate: Iterate,
        hessian: Array | None = None,
    ) -> None:
        self.options = options
        self.nlp = nlp
        self.recorder = recorder
        self.undefined = False  # whether the program had no value at the last point asked for
        self.iterate = iterate
        self.region = TrustRegion(options.initial_radius, options.max_radius)
        self.exact = exact = options.hessian == "exact" and nlp.has_hessian
        # whether the next step is likely to be: the last one was, or the start is nearly a solution
        self.hopeful = exact and bool(iterate.multipliers.any())
        # whether it begins at a solution of other limits: those that moved say nothing of the model
        self.elsewhere = bool(iterate.multipliers.any()) and iterate.violation > LARGE_VIOLATION
        self.patience = Patience(STALLED_AFTER if exact else STALLED_AFTER_BFGS)
        self.filter = Filter(max(CEILING, 1.25 * iterate.violation))
        self.resets_left = FILTER_RESETS
        self.ventures_left = 0 if iterate.multipliers.any() else VENTURES
        self.hessian = LagrangianHessian(recorder.evaluator, exact, hessian)
        self.penalty = initial_penalty(nlp, iterate, options.penalty)
        self.slack = 0.0
        self.last_length = options.initial_radius
        self.renewed = False
        self.strides = 0
        self.idle, self.least_residual = 0, np.inf
        self.crawls = False
        self.resting, self.rests_at = 0, np.inf  # feasible iterates of about the same cost
        self.usual_penalty = self.penalty
        self.model: LocalModel | None = None
        self.bent: Array | None = None  # the Hessian at the iterate
        self.own = False  # whether that is its own, neither a neighbour's nor the last iterate's
        self.residual_before = np.inf  # of the iterate before
        self.known = self.hopeful  # whether it begins at a solution that is known
        self.settled = self.hopeful  # whether the rows that press are nearly known
        self.others = True  # whether others may have to be added
        self.tangent = self.hopeful and hessian is not None  # whether the first step goes along it
        self.by_cost = False  # whether the model bends as the cost alone does

    def iterate_until_verdict(self) -> Status:
        """Go on from iterate to iterate until one is optimal, or the reason why not is known."""
        for _ in range(self.options.max_iterations):
            self.recorder.record(self.iterate, self.region.radius)
            if self._is_optimal(self.iterate):
                return Status.OPTIMAL
            if self.recorder.stopped:
                return Status.INTERRUPTED
            if self._is_optimal_by_itself():
                return Status.OPTIMAL
            if self._falls_without_end():
                return Status.UNBOUNDED
            if self._rests_at_a_tip():
                return Status.STALLED
            status = self._iteration()
            if status is not None:
                return status
        self.recorder.record(self.iterate, self.region.radius)
        return Status.OPTIMAL if self._is_optimal(self.iterate) else Status.ITERATION_LIMIT

    def _is_optimal_by_itself(self) -> bool:
        """Whether an iterate that gets no nearer, or is near, is optimal by other multipliers."""
        residual, feasible = self.iterate.residual.worst, self.options.feasibility
        if self.iterate.violation > feasible or residual < LASTING_DECREASE * self.least_residual:
            self.idle = 0
        else:
            self.idle += 1
        if self.iterate.violation <= feasible and self.idle == 0:
            self.least_residual = min(residual, self.least_residual)
        self.crawls = self.idle >= RECHECK_AFTER
        arrived = self.idle >= RECHECK_AFTER or self.last_length <= SHORT
        due = residual <= (POLISH_BELOW if arrived else NEARLY)
        if not due or self.iterate.violation > feasible:
            return False
        own = with_least_squares_multipliers(self.nlp, self.iterate.point, self.options.tolerance)
        if not self._is_optimal(own):
            return False
        self.iterate = own
        self.recorder.keep(own)
        return True

    def _rests_at_a_tip(self) -> bool:
        """Whether it goes no further as limits meet in a point, where multipliers grow without end.

        The region would collapse only after a hundred iterations and more.
        """
        cost = self.iterate.point.cost
        still = abs(cost - self.rests_at) <= STILL * abs(cost)
        if not (still and self.iterate.violation <= FEASIBLE):
            self.resting, self.rests_at = 0, cost
        self.resting += 1
        grown = self.penalty > self.usual_penalty
        return self.resting > STILL_FOR and grown and self.nlp.is_tip(self.iterate.point.x)

    def _falls_without_end(self) -> bool:
        """Whether the cost is beyond all bounds, or falls with every of many longest steps."""
        longest = self.region.radius >= self.options.max_radius
        going = longest and self.last_length >= 0.99 * self.options.max_radius
        self.strides = self.strides + 1 if going and self.iterate.violation <= FEASIBLE else 0
        return self.strides >= UNBOUNDED_AFTER or is_unbounded(self.nlp, self.iterate)

    def _iteration(self) -> Status | None:
        held = self._held_step()
        if held is not None:
            self.patience.renew()
            near = held.residual <= self.options.tolerance or self.options.early
            status = self._verdict(held.step) if near else None
            if status is not None or self._follow(held):
                return status
        model = self._model()
        posed, step = self._solve_subproblem(model)
        if step is None and model.convex.sigma > MOST:
            self.model = model = self._built(MOST)
            posed, step = self._solve_subproblem(model)
        if step is not None and self.iterate.violation <= NEARLY_FEASIBLE and not self.crawls:
            model, posed, step = self._guessed_again(model, posed, step)
        if step is None:
            self._shrink(self.region.radius)
        else:
            status = self._verdict(step)
            if status is not None:
                return status
            self._advance(model, posed, step)
        return self._collapsed() if self.region.radius < self.options.min_radius else None

    def _held_step(self) -> HeldStep | None:
        """Return Newton's step with the rows that pressed held, where these are nearly known."""
        if not self.settled or self.crawls or self.model is not None:
            return None
        self.settled = False
        bent = self.hessian.matrix if self._last_hessian_will_do() else self._bent()
        held = hold(self.nlp, self.iterate, bent, self.penalty, self.others)
        return None if held is None or self.region.holds(held.step.length) else held

    def _last_hessian_will_do(self) -> bool:
        """Whether Newton's step by the Hessian of the iterate before will lead to the optimum.

        By its own it would be off by c d² where the last step d0 was, r = c d0². The Hessian having
        changed by 2 c d0, it is off by 2 c d0 d; with d / d0 = r / r0 that is 2 r² / r0.
        """
        residual = self.iterate.residual.optimality
        do = self.own and 2.0 * residual**2 <= CHORD * self.options.tolerance * self.residual_before
        self.own = False
        return do

    def _follow(self, held: HeldStep) -> bool:
        """Take a step that no quadratic program has found, if it is as good as was predicted."""
        tangent, self.tangent = self.tangent, False
        trial = self._try(held, held.step, held.step)
        if trial is None:
            return False
        # along the tangent of the solutions the violation that is added is of second order
        accepted = (tangent and self._fits(trial)) or self._accepts(trial)
        return (accepted and self._move(trial)) or self._polish(trial, held.step)

    def _fits(self, trial: Trial) -> bool:
        """Whether a trial is near the limits, and cost and rows there are as the model tells."""
        return trial.violation <= VENTURED and GOOD < trial.fit < 2.0 - GOOD

    def _bent(self) -> Array:
        """Return the Hessian at the iterate in scaled variables, shape (n, n)."""
        if self.bent is None:
            self.bent = self.hessian.at(self.iterate)
            self.own = self.exact and not self.hessian.borrowed
        return self.bent

    def _guessed_again(
        self, model: LocalModel, posed: Subproblem, step: ElasticStep
    ) -> tuple[LocalModel, Subproblem, ElasticStep]:
        """Return model, subproblem and step with the rows made active that the step is held by.

        Where the model was made convex for other rows, it keeps the step from letting these go. A
        second program is cheap beside an evaluation. Far from the limits it may lead to another
        optimum (measured: docs/decisions/speed.md).
        """
        if model.convex.sigma == 0.0:
            return model, posed, step
        again = with_active(model, step.multipliers, self._held(step), self.penalty)
        if again is model:
            return model, posed, step
        posed_again, second = self._solve_subproblem(again)
        if second is None:
            return model, posed, step
        self.model = again
        return again, posed_again, second

    def _model(self) -> LocalModel:
        if self.model is None:
            self.model = self._built(MOST if self.crawls else np.inf)
        return self.model

    def _built(self, most: float = np.inf) -> LocalModel:
        return build_model(
            self.nlp,
            self.iterate,
            self._bent(),
            self.hessian.definite,
            self.penalty,
            tight=self.slack <= self.options.feasibility,
            most=most,
        )

    def _solve_subproblem(self, model: LocalModel) -> tuple[Subproblem, ElasticStep | None]:
        """Solve the subproblem; raise the penalty while only it keeps the violation up."""
        radius = self.region.radius
        reach = min(radius, 2.0 * self.last_length)
        while True:
            posed = pose_subproblem(model, radius, self.penalty, reach)
            step = solve_subproblem(posed, self.options.qp_solver)
            if step is None or not self._penalty_too_small(step):
                return posed, step
            self.penalty = min(RAISE * self.penalty, self.options.max_penalty)

    def _penalty_too_small(self, step: ElasticStep) -> bool:
        return (
            step.slack > max(self.options.feasibility, STEERED * self.iterate.violation)
            and not self.region.holds(step.length)
            and self.penalty < self.options.max_penalty
        )

    def _verdict(self, step: ElasticStep) -> Status | None:
        """Judge the iterate with the new multipliers, before any step is taken."""
        iterate = self._iterate_at(self.iterate.point, step)
        if self._is_optimal(iterate) or (self.options.early and self._is_near(iterate, step)):
            self.iterate = iterate
            return Status.OPTIMAL
        if step.slack <= STEERED * iterate.violation:
            self.patience.renew()  # nothing is in the way of the next step
        elif self.patience.exhausted(iterate.violation):
            return Status.INFEASIBLE
        if (
            step.slack > FEASIBLE
            and self.penalty >= self.options.max_penalty
            and not self.region.holds(step.length)
            and iterate.violation - step.slack <= NO_DECREASE * iterate.violation
        ):
            return Status.INFEASIBLE
        return None

    def _advance(self, model: LocalModel, posed: Subproblem, step: ElasticStep) -> None:
        """Try the step, then its correction; move to the better one or shrink the region."""
        first = trial = self._try(model, step, step)
        self.hopeful = self.exact and trial is not None and self._accepts(trial)
        if trial is not None and not self._accepts(trial):
            trial = corrected(
                trial,
                self.options.feasibility,
                partial(self._correct, model, posed, step),
                self._accepts,
            )
        moved = trial is not None and (
            (self._accepts(trial) and self._move(trial)) or self._polish(trial, step)
        )
        if not (moved or self._venture(first)):
            self._unblock(trial)
            self._shrink(step.length)

    def _try(self, model: QuadraticModel, step: ElasticStep, judged: ElasticStep) -> Trial | None:
        """Evaluate a step, held to the prediction of `judged`; None if undefined there."""
        variables = self.nlp.variables
        x = self.iterate.point.x + variables.scale * step.d
        evaluator = self.recorder.evaluator
        # a step that is likely to be taken is evaluated with its derivatives at once
        evaluate = evaluator.point if self.hopeful and judged is step else evaluator.values
        try:
            values = evaluate(np.clip(x, variables.lower, variables.upper))
        except EvaluationError:
            self.undefined = True
            return None
        self.undefined = False
        return judge(self.nlp, self.iterate, model, step, judged, values)

    def _differentiated(self, trial: Trial) -> Iterate | None:
        """Return a trial with its derivatives, None if it has none."""
        if isinstance(trial.values, Point):
            return self._iterate_at(trial.values, trial.step)
        try:
            point = self.recorder.evaluator.point(trial.values.x)
        except EvaluationError:
            self.undefined = True
            return None
        return self._iterate_at(point, trial.step)

    def _iterate_at(self, point: Point, step: ElasticStep) -> Iterate:
        """Return a point with the multipliers of a step from the present iterate."""
        return make_iterate(self.nlp, point, step.multipliers, self._held(step))

    def _held(self, step: ElasticStep) -> Array:
        """Return what of a step's multipliers of the box belongs to bounds, shape (n,)."""
        return bound_multipliers(
            self.nlp.variables, self.iterate.point.x, step.box_multipliers, self.region.radius
        )

    def _correct(
        self, model: LocalModel, posed: Subproblem, step: ElasticStep, last: Trial
    ) -> Trial | None:
        """Try the step again with the rows as they were found at its end."""
        change = last.values.rows - self.iterate.point.rows
        correction = solve_subproblem(
            pose_correction(model, posed, last.step, change, self.region.radius, self.penalty),
            self.options.qp_solver,
        )
        if correction is None:
            return None
        return self._try(model, correction, step)

    def _polish(self, trial: Trial, step: ElasticStep) -> bool:
        """Move although cost and violation look no better, if the KKT residual falls.

        Near a solution with large multipliers a violation at the rounding level outweighs the
        decrease predicted, and no merit of values can see it; the residual can. It falls with
        every such move, so they cannot cycle.
        """
        near = (
            max(self.iterate.violation, trial.violation, step.slack) <= FEASIBLE
            and self.iterate.residual.worst <= POLISH_BELOW
            and not self.region.holds(step.length)
        )
        polished = self._differentiated(trial) if near else None
        if polished is None or polished.residual.worst > POLISH_GAIN * self.iterate.residual.worst:
            return False
        self._take(polished, trial)
        return True

    def _venture(self, trial: Trial | None) -> bool:
        """Move although cost and violation look no better, where the model fits, a few times.

        The largest violation weighs all rows alike. A step towards a row that presses hard is
        refused for what it adds to one that hardly does, and ever shorter steps crawl along that
        (R. Chamberlain et al., "The watchdog technique for forcing convergence in algorithms for
        constrained optimization", Mathematical Programming Study 16, 1982).
        """
        if trial is None or self.ventures_left == 0 or self.iterate.violation <= NEARLY_FEASIBLE:
            return False
        if not self._fits(trial):
            return False
        if self.by_cost or self._of_cost() is not None:
            return False  # there is another model to try
        self.ventures_left -= 1
        return self._move(trial)

    def _accepts(self, trial: Trial) -> bool:
        return accepts(trial, self.iterate, self.nlp.cost_scale, self.filter)

    def _move(self, trial: Trial) -> bool:
        """Make an accepted trial the iterate; False if it has no derivatives."""
        iterate = self._differentiated(trial)
        if iterate is None:
            return False
        if not trial.for_cost:
            self.filter.add(self.iterate.violation, self.nlp.cost_scale * self.iterate.point.cost)
        self._take(iterate, trial)
        may_widen = self.elsewhere or trial.may_widen
        self.region = self.region.after(trial.fit, self.last_length, may_widen)
        return True

    def _take(self, iterate: Iterate, trial: Trial) -> None:
        """Take an iterate, and learn from the step to it."""
        self.residual_before = self.iterate.residual.optimality
        same = bool(((iterate.multipliers != 0.0) == (self.iterate.multipliers != 0.0)).all())
        self.hessian.update(self.iterate, iterate)
        self.iterate, self.model, self.bent, self.by_cost = iterate, None, None, False
        self.last_length, self.slack = trial.step.length, trial.step.slack
        free = trial.step.slack <= FEASIBILITY and not self.region.holds(trial.step.length)
        self.settled = self.exact and free and self._fits(trial) and (self.known or same)
        self.others = self.settled and self._breaks_others(trial)

    def _breaks_others(self, trial: Trial) -> bool:
        """Whether a row that was not held is violated."""
        rows = self.nlp.rows
        missed = violations(rows.lower, rows.upper, trial.values.rows)
        missed[(trial.step.multipliers != 0.0) | (rows.lower == rows.upper)] = 0.0
        return float(missed.max(initial=0.0)) > self.options.feasibility

    def _unblock(self, trial: Trial | None) -> None:
        """Empty the filter when it alone blocks a step that betters the iterate."""
        if trial is None or not self.filter.entries or self.resets_left == 0:
            return
        lenient = Filter(self.filter.ceiling)
        small = self.region.radius < 1e-2 * self.options.initial_radius
        if small and accepts(trial, self.iterate, self.nlp.cost_scale, lenient):
            self.filter = lenient
            self.resets_left -= 1

    def _shrink(self, length: float) -> None:
        """Shrink the region after a step that is not taken; the model may change, too."""
        bent = self._of_cost()
        share = SHRINK if bent is None else HALF
        self.region = self.region.shrunk(max(length, self.options.min_radius), share)
        self.last_length = self.region.radius
        if bent is not None:
            self.by_cost = True
            self.model = build_model(self.nlp, self.iterate, bent, True, self.penalty, tight=False)
        elif self.hessian.borrowed:
            self.model = self.bent = None  # it may be the reason: the next is by the program's own

    def _of_cost(self) -> Array | None:
        """Return what the cost alone bends, shape (n, n), where that is worth another attempt.

        Far from an optimum the Hessian has much curvature below zero, and is a poor model once it
        is made convex.
        """
        if self.by_cost or self.iterate.residual.worst <= FAR:
            return None
        return self.hessian.of_cost(self.iterate)

    def _is_optimal(self, iterate: Iterate) -> bool:
        return iterate.is_optimal(self.options.tolerance, self.options.feasibility)

    def _is_near(self, iterate: Iterate, step: ElasticStep) -> bool:
        """Whether a step says that an iterate is nearly optimal."""
        free = not self.region.holds(step.length) and step.slack <= self.options.feasibility
        return free and step.length <= EARLY and iterate.violation <= EARLY_FEASIBLE

    def _collapsed(self) -> Status | None:
        """Say why the region collapsed; the multipliers of short steps are poor, so ask again.

        Better ones are worth another run from there: rows of nearly the same gradient may have
        misled the first (once; measured, a few steps then suffice).
        """
        if self.undefined:
            return Status.NUMERICAL
        if self.iterate.violation > FEASIBLE:
            return Status.INFEASIBLE
        iterate = with_least_squares_multipliers(self.nlp, self.iterate.point)
        if self.recorder.best is not None and not self._is_optimal(iterate):
            best = with_least_squares_multipliers(self.nlp, self.recorder.best.point)
            iterate = min(iterate, best, key=lambda one: one.residual.worst)
        if iterate.residual.worst < self.iterate.residual.worst:
            self.iterate = iterate
            self.recorder.keep(iterate)
            if not self._is_optimal(iterate) and not self.renewed:
                self._renew()
                return None
        return Status.OPTIMAL if self._is_optimal(self.iterate) else Status.STALLED

    def _renew(self) -> None:
        self.renewed, self.model, self.bent = True, None, None
        self.region = TrustRegion(self.options.initial_radius, self.options.max_radius)
        self.last_length = self.options.initial_radius
        self.filter = Filter(CEILING)
