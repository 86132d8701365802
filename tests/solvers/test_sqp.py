"""What the SQP method does when things do not go by the book."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
import textbook_programs as bank

from gaitopt.errors import EvaluationError, InputError
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, Point, Start, Status, Values
from gaitopt.solvers import SQP, sqp
from gaitopt.solvers.subproblem import build_model
from gaitopt.tolerances import FEASIBLE


@dataclass(frozen=True)
class Spoilt(bank.Textbook):
    """A textbook program, some of whose answers are spoilt."""

    nan_beyond: float = np.inf
    only_at_start: bool = False
    slope_sign: float = 1.0
    slope_shift: float = 0.0

    def values(self, x: Array) -> Values:
        if self.only_at_start and not np.array_equal(x, self.start):
            raise EvaluationError("undefined but at the start")
        values = super().values(x)
        return replace(values, cost=np.nan) if x[0] > self.nan_beyond else values

    def point(self, x: Array) -> Point:
        point = super().point(x)
        return replace(point, gradient=self.slope_sign * point.gradient + self.slope_shift)


def spoilt(program: bank.Textbook, **changes: object) -> Spoilt:
    return Spoilt(**{**vars(program), **changes})


def test_infeasible_program_ends_at_the_least_violation() -> None:
    program = bank.infeasible()
    solution = SQP().solve(program, Start(program.start))
    assert solution.status is Status.INFEASIBLE
    np.testing.assert_allclose(solution.x, program.solution, atol=5e-3)
    assert solution.violation == pytest.approx(1.0, abs=1e-3)


def test_stationary_violation_of_a_feasible_program() -> None:
    program = bank.waechter_biegler()
    solution = SQP().solve(program, Start(program.start))
    assert solution.status is Status.INFEASIBLE
    assert solution.violation == pytest.approx(np.sqrt(3.0) / 2.0, abs=1e-4)
    assert "no nearby point" in solution.status.value


def test_feasible_program_is_solved_from_a_better_start() -> None:
    program = bank.waechter_biegler()
    solution = SQP().solve(program, Start(np.array([2.0, 3.0, 1.0])))
    assert solution.status is Status.OPTIMAL
    np.testing.assert_allclose(solution.x, program.solution, atol=1e-6)


def test_a_run_that_has_come_to_a_tip_of_its_limits_is_ended(monkeypatch) -> None:
    program, solver = bank.cusp(), SQP()
    on = solver.solve(program, Start(program.start))
    monkeypatch.setattr(bank.Textbook, "is_tip", lambda self, x: bool(np.abs(x).max() < 0.05))
    ended = solver.solve(program, Start(program.start))
    assert on.status in {Status.STALLED, Status.ITERATION_LIMIT}  # which of them is rounding
    assert ended.status is Status.STALLED
    assert ended.iterations < 0.6 * on.iterations
    assert ended.cost == pytest.approx(on.cost, rel=1e-5)
    assert ended.violation <= FEASIBLE
    np.testing.assert_allclose(ended.x, program.solution, atol=0.05)


def test_an_iterate_at_the_end_of_a_short_step_is_judged_by_its_own_multipliers(
    monkeypatch,
) -> None:
    program, asked = bank.hs43(), []
    monkeypatch.setattr(sqp, "POLISH_BELOW", np.inf)
    own = sqp.with_least_squares_multipliers

    def counted(*args):
        asked.append(args)
        return own(*args)

    monkeypatch.setattr(sqp, "with_least_squares_multipliers", counted)
    usual = SQP().solve(program, Start(program.start))
    few = len(asked)
    monkeypatch.setattr(sqp, "SHORT", np.inf)
    monkeypatch.setattr(sqp, "NEARLY", -np.inf)
    at_once = SQP().solve(program, Start(program.start))
    assert len(asked) > 2 * few
    assert at_once.iterations <= usual.iterations
    np.testing.assert_allclose(at_once.x, program.solution, atol=1e-5)


def test_penalty_rises_when_multipliers_exceed_it() -> None:
    program = bank.hs15()  # the multipliers add to 2451
    solution = SQP(penalty=10.0).solve(program, Start(program.start))
    assert solution.status is Status.OPTIMAL
    np.testing.assert_allclose(solution.x, program.solution, atol=1e-6)
    np.testing.assert_allclose(solution.multipliers, program.multipliers, rtol=1e-6)


def test_penalty_that_may_not_rise_is_no_proof_of_infeasibility() -> None:
    program = bank.hs15()
    solution = SQP(penalty=10.0, max_penalty=10.0).solve(program, Start(program.start))
    # It leaves the feasible start for good, which is kept as the best iterate.
    assert solution.status is Status.STALLED
    assert max(record.violation for record in solution.history) > 0.1
    assert solution.violation <= 1e-6


def test_learning_the_curvature_takes_patience(robot) -> None:
    """Slow on the way, but there is a walk: the violation rests for more than forty iterations."""
    problem = WalkProblem(robot, preset_task(speed=0.9))
    start = perturbed(problem, first_guess(problem), sigma=0.1, seed=1)
    solution = SQP(hessian="bfgs").solve(problem, Start(start))
    assert solution.status is not Status.INFEASIBLE
    assert solution.violation <= FEASIBLE


def test_start_outside_its_bounds_is_moved_onto_them() -> None:
    program = bank.hs71()
    solution = SQP().solve(program, Start(np.array([0.0, 9.0, 5.0, 1.0])))
    assert solution.status is Status.OPTIMAL
    np.testing.assert_allclose(solution.x, program.solution, atol=1e-6)


def test_never_leaves_the_bounds() -> None:
    program, seen = bank.hs76(), []
    watched = replace(program, cost=lambda x: seen.append(x.copy()) or program.cost(x))
    SQP().solve(watched, Start(program.start))
    assert len(seen) > 3
    assert np.min(seen) >= 0.0


def test_not_a_number_is_a_rejected_step() -> None:
    program = spoilt(bank.hs43(), nan_beyond=0.9, start=np.array([-1.0, 0.5, 0.5, 0.5]))
    solution = SQP(initial_radius=2.0).solve(program, Start(program.start))
    assert solution.status is Status.OPTIMAL
    np.testing.assert_allclose(solution.x, program.solution, atol=1e-6)


def test_undefined_all_around() -> None:
    program = spoilt(bank.hs43(), only_at_start=True)
    solution = SQP().solve(program, Start(program.start))
    assert solution.status is Status.NUMERICAL
    np.testing.assert_array_equal(solution.x, program.start)
    assert np.isfinite(solution.optimality)


def test_wrong_slope_stalls() -> None:
    program = spoilt(bank.hs43(), slope_sign=-1.0, start=np.array([0.1, 0.2, 0.3, 0.4]))
    solution = SQP().solve(program, Start(program.start))
    assert solution.status is Status.STALLED
    np.testing.assert_array_equal(solution.x, program.start)


def test_who_begins_again_with_better_multipliers_computes_the_hessian_anew(monkeypatch) -> None:
    program, found = spoilt(bank.maratos(), slope_shift=1.0), []

    def seen(nlp, iterate, hessian, *words, **named):
        exact = nlp.hessian(iterate.point.x, iterate.multipliers, nlp.cost_scale)
        np.testing.assert_allclose(hessian, exact, atol=1e-12)
        found.append(tuple(iterate.multipliers))
        return build_model(nlp, iterate, hessian, *words, **named)

    monkeypatch.setattr(sqp, "build_model", seen)
    assert SQP().solve(program, Start(program.start)).status is Status.STALLED
    assert len(set(found)) > 1


def test_good_multipliers_at_the_solution_save_the_work() -> None:
    program = bank.hs100()
    cold = SQP(tolerance=1e-9).solve(program, Start(program.start))
    warm = SQP().solve(program, Start(cold.x + 1e-4, cold.multipliers))
    assert warm.status is Status.OPTIMAL
    assert warm.iterations <= 2 < cold.iterations


def test_the_last_step_takes_the_hessian_of_the_one_before(monkeypatch) -> None:
    program = bank.hs71()
    saving = SQP().solve(program, Start(program.start))
    monkeypatch.setattr(sqp, "CHORD", 0.0)
    usual = SQP().solve(program, Start(program.start))
    assert saving.iterations == usual.iterations
    assert saving.hessians == usual.hessians - 1
    np.testing.assert_allclose(saving.x, usual.x, atol=1e-7)


def test_converges_quadratically() -> None:
    program = bank.hs71()
    solution = SQP(tolerance=1e-12).solve(program, Start(program.start))
    tail = [r.optimality for r in solution.history if r.optimality < 1e-1]
    # Below 1e-8 the rounding of the quadratic programs decides, which differs between machines.
    tail = tail[: 1 + sum(error > 1e-8 for error in tail)]
    # Each error is at most a moderate multiple of the square of the one before.
    assert len(tail) >= 2
    assert all(after < 100.0 * before**2 for before, after in itertools.pairwise(tail))


def test_second_order_correction_takes_full_steps_along_a_circle() -> None:
    program = bank.maratos()
    solution = SQP(initial_radius=2.0).solve(program, Start(program.start))
    assert solution.status is Status.OPTIMAL
    assert solution.iterations <= 8
    assert solution.evaluations <= 10
    # Every step was accepted: the circle's curvature never shortened the trust region below it.
    assert min(record.radius for record in solution.history) > 0.1


@dataclass(frozen=True)
class Valley(bank.Textbook):
    """Rosenbrock's program, whose cost is a sum of squares."""

    asked: list[tuple[float, ...]] = field(default_factory=list)

    def cost_curvature(self, x: Array) -> Array:
        self.asked.append(tuple(x))
        jacobian = np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0]])
        return 2.0 * jacobian.T @ jacobian


def test_a_refused_step_is_taken_where_the_model_fits(robot, monkeypatch) -> None:
    """Limits on lift-off press three hundred times as hard as those that the step exceeds."""
    problem = WalkProblem(robot, preset_task("standard", speed=1.2))
    start = Start(first_guess(problem))
    solution = SQP().solve(problem, start)
    monkeypatch.setattr(sqp, "VENTURES", 0)
    crawling = SQP().solve(problem, start)
    assert solution.status is crawling.status is Status.OPTIMAL
    assert solution.cost == pytest.approx(crawling.cost, rel=1e-6)
    assert solution.iterations < 0.75 * crawling.iterations


def test_a_step_that_is_not_taken_is_tried_again_as_the_cost_bends() -> None:
    usual, program = bank.rosenbrock_in_disk(), Valley(**vars(bank.rosenbrock_in_disk()))
    plain, squares = (SQP(initial_radius=1.0).solve(p, Start(p.start)) for p in (usual, program))
    assert plain.status is squares.status is Status.OPTIMAL
    np.testing.assert_allclose(squares.x, program.solution, atol=1e-6)
    assert program.asked  # at iterates, once each
    assert len(program.asked) == len(set(program.asked))
    radii = [record.radius for record in plain.history], [r.radius for r in squares.history]
    after, halved = next(pair for pair in zip(*radii, strict=False) if pair[0] != pair[1])
    assert halved == pytest.approx(2.0 * after)  # half the step, not a quarter


@pytest.mark.parametrize(
    ("option", "value", "word"),
    [("tolerance", 0.0, "positive"), ("qp_solver", "gurobi", "daqp"), ("hessian", "sr1", "bfgs")],
)
def test_options_are_checked(option: str, value: object, word: str) -> None:
    with pytest.raises(InputError, match=word) as error:
        SQP(**{option: value})
    assert str(value) in str(error.value)
    assert option in str(error.value)


def test_a_neighbours_hessian_saves_the_first_of_its_own(robot) -> None:
    near, there = (WalkProblem(robot, preset_task(speed=v)) for v in (1.0, 1.01))
    known = SQP().solve(near, Start(first_guess(near)))
    assert known.hessian is not None
    alone = SQP().near_solution().solve(there, Start(known.x, known.multipliers))
    helped = SQP().near_solution().solve(there, Start(known.x, known.multipliers, known.hessian))
    assert helped.status is alone.status is Status.OPTIMAL
    assert helped.hessians == alone.hessians - 1
    assert helped.iterations == alone.iterations
    assert helped.cost == pytest.approx(alone.cost, rel=1e-9)
    assert SQP(hessian="bfgs", max_iterations=2).solve(near, Start(known.x)).hessian is None


def test_a_useless_hessian_is_put_aside(robot) -> None:
    problem = WalkProblem(robot, preset_task(speed=1.0))
    guess = first_guess(problem)
    alone = SQP().solve(problem, Start(guess))
    useless = 1e4 * np.eye(guess.size)
    led_astray = SQP().solve(problem, Start(guess, hessian=useless))
    assert led_astray.status is Status.OPTIMAL
    assert led_astray.cost == pytest.approx(alone.cost, rel=1e-9)
    assert led_astray.hessian is not None
    assert not np.array_equal(led_astray.hessian, useless)


def test_a_hessian_by_which_no_step_is_found_is_put_aside(robot, monkeypatch) -> None:
    problem = WalkProblem(robot, preset_task(speed=1.0))
    guess, asked = first_guess(problem), []
    solve = sqp.solve_subproblem

    def failing_at_first(posed, backend):
        asked.append(posed.hessian)
        return solve(posed, backend) if len(asked) > 1 else None

    monkeypatch.setattr(sqp, "solve_subproblem", failing_at_first)
    useless = 1e4 * np.eye(guess.size)
    assert SQP().solve(problem, Start(guess, hessian=useless)).status is Status.OPTIMAL
    assert not np.allclose(asked[1], asked[0])
