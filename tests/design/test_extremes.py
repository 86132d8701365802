"""Located extremes against the walk evaluated at thousands of instants, which share nothing."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from walks import UPRIGHT, walk

from gaitopt.design import extremes
from gaitopt.design.certificate import certify, on_fine_grid
from gaitopt.design.extremes import located
from gaitopt.errors import EvaluationError
from gaitopt.gait.grid import NODES, Grid, chebyshev_points, proof_grid
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem

INSTANTS = 5001


def dense_margins(problem: WalkProblem, x, count: int = INSTANTS):
    """The least margin of every row over the step at equidistant instants, by constraint."""
    s = np.linspace(0.0, 1.0, count)
    dense = problem.with_grid(Grid(s, np.ones(count), count))
    values = dense.values(x).rows
    margins = np.minimum(values - dense.rows.lower, dense.rows.upper - values)
    return {
        f.name: margins[dense.rows_of(f.name)].reshape(f.lower.shape).min(axis=0)
        for f in dense.blocks
        if f.times is not None
    }


def random_walk(robot, seed: int, **changes: object):
    problem = WalkProblem(robot, preset_task(**changes))
    return problem, perturbed(problem, first_guess(problem), 0.15, seed)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("postures", [1, 2, 4])
def test_no_row_comes_nearer_to_its_limit_than_was_located(robot, seed, postures):
    """Wild walks that exceed most limits: kinks of leg gaps and tips of friction cones included."""
    problem, x = random_walk(robot, seed, postures=postures, speed=0.9, **UPRIGHT)
    found = located(on_fine_grid(problem), x, everywhere=True)
    for constraint, least in dense_margins(problem, x).items():
        for row, margin in enumerate(least):
            worst = min(e.margin for e in found if (e.constraint, e.entry) == (constraint, row))
            enough = 1e-6 + 0.1 * abs(margin)  # exact near the limit, roughly beyond it
            assert worst <= margin + enough or margin > 1e-2


@pytest.mark.parametrize("seed", range(3))
def test_a_located_extreme_is_there(robot, seed):
    """The walk evaluated at the instant itself has the margin that was told."""
    problem, x = random_walk(robot, seed, speed=1.0, **UPRIGHT)
    found = [e for e in located(on_fine_grid(problem), x) if 1e-6 < e.instant < 1.0 - 1e-6]
    s = np.unique([e.instant for e in found])
    at = problem.with_grid(Grid(s, np.ones(s.size), s.size))
    values = at.values(x).rows
    for one in found:
        block = at.rows_of(one.constraint)
        shape = at.address(block.start).block.lower.shape
        bound = (at.rows.upper if one.upper else at.rows.lower)[block].reshape(shape)
        value = values[block].reshape(shape)
        margin = np.where(one.upper, bound - value, value - bound)
        exact = margin[np.searchsorted(s, one.instant), one.entry]
        assert one.margin == pytest.approx(exact, abs=max(1e-9, one.error))


@pytest.mark.parametrize("count", [5001, 20001])
def test_a_refined_gait_keeps_its_limits_at_every_instant(refined_design, count):
    least = dense_margins(refined_design.problem, refined_design.solution.x, count)
    assert min(margins.min() for margins in least.values()) >= -1e-6


def test_minima_of_polynomials(rng):
    """Against the roots of the derivative."""
    coefficients = rng.normal(size=(NODES, 30)) / (1.0 + np.arange(NODES)[:, None]) ** 2
    dense = np.linspace(-1.0, 1.0, 2001)
    begin = dense[np.argmin(chebyshev.chebval(dense, coefficients), axis=1)]
    low, high = np.maximum(begin - 1e-3, -1.0), np.minimum(begin + 1e-3, 1.0)
    places, values, bends = extremes._minima(coefficients, low, high, begin)
    for k, column in enumerate(coefficients.T):
        roots = chebyshev.chebroots(chebyshev.chebder(column))
        inside = [r.real for r in roots if abs(r.imag) < 1e-9 and abs(r.real) <= 1.0]
        least = min(chebyshev.chebval(np.array([*inside, -1.0, 1.0]), column))
        assert values[k] == pytest.approx(least, abs=1e-12)
        assert bends[k] == pytest.approx(
            chebyshev.chebval(places[k], chebyshev.chebder(column, 2)), rel=1e-9, abs=1e-9
        )


def test_a_jump_of_the_slope_is_closed_in_upon(robot):
    """Where the polynomial is not exact enough near a limit, the piece is divided until it is."""
    problem, x = random_walk(robot, 3, **UPRIGHT)
    gap = dense_margins(problem, x)["leg gap"].min()
    limit = problem.task.margins.leg_gap + 0.1 * gap  # exactly at the nearest approach
    task = replace(problem.task, margins=replace(problem.task.margins, leg_gap=limit))
    touching = WalkProblem(robot, task)
    found = [e for e in located(on_fine_grid(touching), x) if e.constraint == "leg gap"]
    worst = min(found, key=lambda e: e.margin)
    assert worst.margin == pytest.approx(0.0, abs=1e-4)
    assert worst.margin <= dense_margins(touching, x)["leg gap"].min() + 1e-7
    assert worst.error <= 1e-7


@pytest.mark.parametrize("place", [-0.97, -0.3, 0.0, 0.41, 0.999])
def test_a_limit_that_is_touched_between_dense_points_is_looked_at_closely(place):
    """The margin vanishes midway between two of them, where both are farther than the error."""
    dense = extremes._dense_points()
    k = int(np.searchsorted(dense, place))
    x = chebyshev_points(NODES)
    rough = np.zeros(NODES)
    rough[-1] = 3e-7  # makes the error 3e-6
    touch = 5.0 * (x - 0.5 * (dense[k - 1] + dense[k])) ** 2
    margins = (touch + chebyshev.chebval(x, rough) + 3e-7)[:, None]
    piece = next(extremes._made([(0.0, 0.3)], margins, [0]))
    assert piece.errors[0] == pytest.approx(3e-6)
    assert piece.dense.min() > 10.0 * piece.errors[0] or abs(place) > 0.9
    assert extremes._unclear(piece)
    smooth = next(extremes._made([(0.0, 0.3)], (touch + 1e-3)[:, None], [0]))
    assert not extremes._unclear(smooth)


def test_a_row_that_is_no_number_is_an_error(monkeypatch):
    problem, x = walk("guess").problem, walk("guess").x
    fine = on_fine_grid(problem)
    values = fine.values(x)
    broken = replace(values, rows=np.full(values.rows.size, np.nan))
    monkeypatch.setattr(fine, "values", lambda _: broken)
    with pytest.raises(EvaluationError, match="no finite value"):
        located(fine, x)


@pytest.mark.parametrize("pieces", [1, 3, 7])
def test_the_quadrature_of_the_proof_is_exact_for_polynomials(pieces):
    grid = proof_grid(np.linspace(0.0, 1.0, pieces + 1))
    for power in range(NODES):
        assert grid.weights @ grid.instants**power == pytest.approx(1.0 / (power + 1), abs=1e-14)
    assert grid.weights[0] == grid.weights[-1] == 0.0
    assert (grid.weights[1:-1] > 0.0).all()


def test_rows_without_limits_have_no_extremes(robot):
    """No torque limits at all, and limits on some joints only."""
    free = np.full(12, np.inf)
    some = free.copy()
    some[3] = 150.0
    for torque, expected in ((free, set()), (some, {3})):
        weak = replace(robot, limits=replace(robot.limits, torque=torque))
        problem = WalkProblem(weak, preset_task())
        x = first_guess(problem)
        found = located(on_fine_grid(problem), x, everywhere=True)
        assert {e.entry for e in found if e.constraint == "torque"} == expected
        assert np.isfinite([e.margin for e in found]).all()
        rows = certify(problem, x).constraints
        assert np.isfinite([(row.limit, row.margin) for row in rows]).all()


def test_parameters_that_are_no_walk_are_not_resolved_without_end(robot, monkeypatch):
    problem = WalkProblem(robot, preset_task(samples=15))
    x = first_guess(problem)
    x[problem.layout.names.index("left_hip_pitch_rate_before_impact")] *= 1e6
    sizes, with_grid = [], WalkProblem.with_grid

    def counted(self, grid):
        sizes.append(grid.count)
        return with_grid(self, grid)

    monkeypatch.setattr(WalkProblem, "with_grid", counted)
    assert not certify(problem, x).certified
    assert NODES * 2 < max(sizes) <= NODES * extremes.MOST_PARTS


def test_a_minimum_between_two_dense_points_is_not_overlooked():
    """A polynomial with a narrow dip between the points at which it is looked at first."""
    points = extremes._dense_points()
    k = points.size // 2
    place = 0.5 * (points[k] + points[k + 1])
    x = chebyshev_points(NODES)
    margins = (2e-2 * (x - place) ** 2 - 4e-7)[:, None]
    margins[:, 0] += 3e-7 * np.cos((NODES - 1) * np.arccos(x))  # what the polynomial may be off
    piece = next(extremes._made([(0.0, 1.0)], margins, [0]))
    assert piece.dense.min() > piece.errors[0] > 1e-6
    assert extremes._unclear(piece)
    far = next(extremes._made([(0.0, 1.0)], margins + 1e-3, [0]))
    assert not extremes._unclear(far)
