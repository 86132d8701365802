from dataclasses import replace

import numpy as np
import pytest

from gaitopt.design.active_set import (
    END_APPROACH,
    ActiveRow,
    ViolatedRow,
    active_rows,
    instants_of,
    moved,
    placed,
    sharpened,
    violated_rows,
)
from gaitopt.design.certificate import on_fine_grid
from gaitopt.gait.grid import Grid
from gaitopt.gait.problem import WalkProblem


@pytest.fixture(scope="module")
def sampled(sampled_design):
    problem = WalkProblem(sampled_design.problem.robot, sampled_design.problem.task)
    return problem, sampled_design.solution


def test_multipliers_survive_the_way_there_and_back(sampled):
    problem, solution = sampled
    active = active_rows(problem, solution.multipliers)
    np.testing.assert_allclose(placed(problem, active), solution.multipliers, atol=1e-9)
    assert 10 < len(active) < 100


def test_on_another_grid_they_stand_at_the_same_instants(sampled):
    """The gradient of the Lagrangian, cost aside, is the same, whatever the order of the rows."""
    problem, solution = sampled
    active = active_rows(problem, solution.multipliers)
    other = problem.with_grid(problem.grid.with_instants(np.array([0.123, 0.456])))
    one = solution.multipliers @ problem.point(solution.x).jacobian
    again = placed(other, active) @ other.point(solution.x).jacobian
    np.testing.assert_allclose(again, one, rtol=1e-9, atol=1e-12)


def test_rows_that_a_grid_lacks_are_left_out(sampled):
    problem, _ = sampled
    assert not placed(problem, [ActiveRow("torque", 0, 0.12345, 1.0)]).any()
    assert not placed(problem, [ActiveRow("no such constraint", 0, 0.0, 1.0)]).any()


def test_only_constraints_of_instants_have_instants(sampled):
    problem, _ = sampled
    active = [ActiveRow("torque", 0, 0.3, 1.0), ActiveRow("leg length", 0, 1.0, 1.0)]
    assert instants_of(problem, active).tolist() == [0.3]


def margins(problem: WalkProblem, x, peak: ViolatedRow, instants):
    """Margins of a peak's row at instants, straight from its definition."""
    at = problem.with_grid(Grid(instants, np.ones(instants.size), instants.size))
    block = at.rows_of(peak.constraint)
    shape = at.address(block.start).block.lower.shape
    value, low, high = (
        part[block].reshape(shape)[:, peak.entry]
        for part in (at.values(x).rows, at.rows.lower, at.rows.upper)
    )
    return np.minimum(value - low, high - value)


def test_peaks_are_the_worst_of_their_stretch(sampled):
    problem, solution = sampled
    found = violated_rows(on_fine_grid(problem), solution.x)
    assert found
    for peak in found:
        beside = peak.instant + np.array([-1e-4, 0.0, 1e-4])
        before, there, after = margins(problem, solution.x, peak, beside)
        assert there < min(before, after)
        assert there == pytest.approx(-peak.excess, abs=1e-9)


def test_a_landing_foot_is_held_near_the_end(sampled):
    """It has no height at the end: held at the peak it would sink between peak and end again."""
    problem, solution = sampled
    peaks = violated_rows(on_fine_grid(problem), solution.x)
    (peak,) = (one for one in peaks if one.constraint == "clearance" and one.instant > 0.97)
    assert peak.instant < peak.held < 1.0
    assert 1.0 - peak.held == pytest.approx((1.0 - peak.instant) / END_APPROACH, rel=1e-6)


def test_a_multiplier_moves_to_the_peak_beside_it():
    kept = ActiveRow("torque", 3, 0.25, 1.5)
    beside, far = (
        ViolatedRow("torque", 3, 0.26, 0.1, 0.26),
        ViolatedRow("torque", 3, 0.75, 0.1, 0.75),
    )
    assert moved([kept], [beside]) == (replace(kept, instant=0.26),)
    assert moved([kept], [far]) == (kept, ActiveRow("torque", 3, 0.75, 0.0))
    assert moved([kept], [ViolatedRow("torque", 4, 0.26, 0.1, 0.26)]) == (
        kept,
        ActiveRow("torque", 4, 0.26, 0.0),
    )


def test_between_two_instants_a_limit_is_held_where_it_presses():
    before, after = ActiveRow("speed", 3, 0.20, 1.0), ActiveRow("speed", 3, 0.24, 3.0)
    peak = ViolatedRow("speed", 3, 0.22, 0.1, 0.22)
    (found,) = sharpened([before, after], [peak])
    assert found == replace(peak, held=0.23, beside=(0.225, 0.235))
    assert moved([before, after], [found]) == (ActiveRow("speed", 3, 0.23, 4.0),)


@pytest.mark.parametrize(
    "others",
    [
        [ActiveRow("speed", 3, 0.20, 1.0)],  # one alone
        [ActiveRow("speed", 3, 0.20, 1.0), ActiveRow("speed", 3, 0.24, -3.0)],  # two limits
        [ActiveRow("speed", 3, 0.20, 1.0), ActiveRow("speed", 4, 0.24, 3.0)],  # two joints
        [ActiveRow("speed", 3, 0.20, 1.0), ActiveRow("speed", 3, 0.24, 0.01)],  # one presses
        [ActiveRow("speed", 3, 0.10, 1.0), ActiveRow("speed", 3, 0.34, 3.0)],  # far away
    ],
)
def test_elsewhere_it_is_held_at_its_peak(others):
    peak = ViolatedRow("speed", 3, 0.22, 0.1, 0.22)
    assert sharpened(others, [peak]) == (peak,)


def test_an_instant_chosen_by_the_end_of_the_step_is_kept():
    active = [ActiveRow("clearance", 0, 0.97, 1.0), ActiveRow("clearance", 0, 0.99, 1.0)]
    peak = ViolatedRow("clearance", 0, 0.98, 0.1, 0.998)
    assert sharpened(active, [peak]) == (peak,)
