"""The identified biped on its walks: what was fitted, what was not, and the page about it."""

from itertools import pairwise

import numpy as np
import pytest

from gaitopt.catalogue.entries import robot_by_name
from gaitopt.design.options import DesignOptions
from gaitopt.design.process import small_matrices
from gaitopt.design.starts import many_starts
from gaitopt.gait import quantities
from gaitopt.gait.assemble import gait_at
from gaitopt.nlp import Status
from gaitopt.solvers import SQP, Solver
from reproduction.curve import cost_curve, joint_costs, warm_curve
from reproduction.figures import convergence_figure
from reproduction.gradients import GRADIENTS, Run, compare
from reproduction.identification import (
    Sensitivity,
    biped_with,
    identified_values,
    identify,
    misfit,
    relative_errors,
    walks_with,
)
from reproduction.page import part_text, write_figures, write_reproduction
from reproduction.paper import identified_biped, paper_walk, printed
from reproduction.results import Alternative, Reproduction, record


@pytest.fixture(scope="module")
def curve():
    robot = robot_by_name("paper")
    with small_matrices():
        return cost_curve([paper_walk(v, robot) for v in printed().speeds])


def test_no_walk_is_dearer_than_what_a_single_design_finds():
    """At 1.4 m/s the best walk comes from a slower one, out of whose reach the longer step is."""
    walk = paper_walk(1.4, robot_by_name("paper"))
    options = DesignOptions(solver=SQP(), refine=False, diagnose=False)
    single = many_starts(walk.robot, walk.task, options).design
    assert cost_curve([walk])[1.4].cost == pytest.approx(single.solution.cost, rel=1e-6)


@pytest.fixture(scope="module")
def comparison(curve):
    with small_matrices():
        return compare(paper_walk(1.0, curve[1.0].problem.robot), cap=0.3)


@pytest.fixture(scope="module")
def result(curve, comparison):
    walk = curve[1.0]
    gait = gait_at(walk.problem, walk.solution.x, {})
    jacobian = np.random.default_rng(1).normal(size=(8, 5))
    fit = Sensitivity(identified_values(), relative_errors(curve), jacobian)
    found = Reproduction()
    found.curve = found.one_posture = curve
    found._comparisons = {1.0: comparison}
    found.comparisons = (comparison,)
    found.sensitivity = fit
    found.alternatives = (Alternative("another", fit.values, fit.errors, 3.5),)
    found.gait = found.gait_one_posture = gait
    found.seconds = 90.0, 60.0
    with small_matrices():
        assert found.consequences.yaw.shape == (8,)
    return found


def test_every_cost_is_within_5_percent_of_table_3_and_the_least_at_0_7(curve):
    assert np.abs(relative_errors(curve)).max() < 0.05
    assert min(curve, key=lambda v: curve[v].cost) == 0.7
    assert all(walk.solution.status is Status.OPTIMAL for walk in curve.values())


def test_the_mean_force_was_not_fitted_and_agrees(curve):
    assert curve[1.0].mean_vertical_force == pytest.approx(printed().mean_vertical_force, abs=1.0)


@pytest.mark.parametrize("speed", [0.4, 1.0])
def test_momentum_over_a_step(curve, speed):
    walk = curve[speed]
    weight = 56.87 * 9.81
    assert walk.mean_vertical_force + walk.impulse / 0.4 == pytest.approx(weight, rel=1e-4)


def test_shares_of_the_joints_add_up_to_the_cost(curve):
    for walk in curve.values():
        costs = joint_costs(walk)
        stance, swing = sum(costs.stance.values()), sum(costs.swing.values())
        assert stance + swing == pytest.approx(walk.cost)
        assert stance > swing
    knees = [i for i, n in enumerate(walk.problem.robot.joint_names) if "knee" in n]
    torque = walk.step.read(quantities.TORQUE)[:, knees[0]]
    share = walk.problem.grid.weights @ torque**2 * 0.4 / walk.step.step_length
    assert costs.stance["knee"] == pytest.approx(float(share))


def test_the_catalogue_holds_the_biped_of_the_identified_values():
    biped, shipped = biped_with(identified_values()), identified_biped()
    assert biped.geometry == shipped.geometry
    assert biped.joints == shipped.joints
    assert biped.links.foot == shipped.links.foot
    assert biped.links.torso.com == shipped.links.torso.com
    np.testing.assert_allclose(
        biped.links.torso.inertia, shipped.links.torso.inertia, rtol=5e-4, atol=1e-12
    )
    assert shipped.standing_height == pytest.approx(1.30)


def test_a_tighter_joint_speed_costs_more_where_it_binds(curve):
    values = identified_values()
    values[1] -= 0.1
    walk = next(w for w in walks_with(values) if w.task.speed == 1.1)
    with small_matrices():
        tighter = warm_curve([walk], {1.1: curve[1.1].solution.x})
    assert tighter[1.1].cost > 1.005 * curve[1.1].cost


def test_differences_cost_more_and_a_capped_run_says_so(comparison):
    exact, _, differences = comparison.runs
    assert exact.converged
    assert not differences.converged
    assert differences.status is Status.INTERRUPTED
    assert comparison.ratio(GRADIENTS[2]) > 1.0
    assert differences.evaluations > 20 * differences.iterations


def test_time_to_a_cost_counts_feasible_iterates_only():
    history = np.array([[0.1, 50.0, 1.0], [0.2, 120.0, 1e-9], [0.3, 101.0, 1e-9]])
    run = Run(1.0, "exact", Status.OPTIMAL, 101.0, 2, 3, 0.3, history)
    assert run.seconds_to(105.0) == 0.3
    assert run.seconds_to(150.0) == 0.2
    assert np.isnan(run.seconds_to(99.0))


def test_other_answers_to_open_questions(result):
    other = result.consequences
    assert np.all(other.yaw < 0.0)  # one more parameter is never dearer
    assert np.all(other.penalty < 0.0)
    assert np.all(other.sinking < 0.0)
    assert np.abs(other.penalty_speed).max() < 0.1
    slow, fast = other.penalty_speed[0], other.penalty_speed[-1]
    assert slow > 0.0 > fast  # towards the cheapest speed
    walk = result.curve[1.0]
    torque, time = walk.step.read(quantities.TORQUE), walk.problem.grid.weights
    assert other.torque == pytest.approx(float(np.sqrt((time @ torque**2).mean())))


def test_a_short_identification_improves_on_worse_values(curve, monkeypatch):
    """On real walks, but without the search along the speeds, which takes seconds."""
    start = identified_values() + np.array([0.0, 0.0, -0.2, 0.0, 0.0])  # an easier torso to turn
    searched = lambda walks, known=None: warm_curve(walks, known) if known else curve  # noqa: E731
    monkeypatch.setattr("reproduction.identification.cost_curve", searched)
    told = []
    with small_matrices():
        found = identify(start, evaluations=4, on_better=lambda v, e: told.append((v, misfit(e))))
    np.testing.assert_allclose(told[0][0], start)
    np.testing.assert_array_equal(found, told[-1][0])
    assert len(told) > 1
    assert all(b < a for (_, a), (_, b) in pairwise(told))


def test_ctrl_c_is_no_answer(curve, monkeypatch):
    class Stopped(Solver):
        def solve(self, problem, start, on_progress=None, stop=None):
            raise KeyboardInterrupt

    for module in ("curve", "gradients"):
        monkeypatch.setattr(f"reproduction.{module}.SOLVER", Stopped())
    walk = curve[0.5]
    with pytest.raises(KeyboardInterrupt):
        warm_curve([walk.problem], {0.5: walk.solution.x})
    with pytest.raises(KeyboardInterrupt):
        compare(walk.problem)


def test_page_figures_and_numbers_are_written(result, tmp_path):
    page, numbers, *figures = write_reproduction(result, tmp_path / "docs")
    text = page.read_text("utf-8")
    assert "$" not in text
    assert f"| {curve_cost(result):.2f} |" in text
    assert all(f"images/reproduction/{figure.name}" in text for figure in figures)
    assert all(figure.read_bytes().startswith(b"\x89PNG") for figure in figures)
    assert numbers.suffix == ".json"
    walks = record(result)["walks"]
    assert walks[6]["printed"] == 6295.95


def test_a_part_is_computed_only_when_it_is_asked_for(curve, comparison):
    told = []
    part = Reproduction(told.append)
    part.curve = curve
    part._comparisons = {1.0: comparison}
    assert part_text(part, "fig7").count("| 0.7 |") == 1
    assert part_text(part, "fig3") == "## fig3: convergence at 1.0 m/s"
    assert write_figures(part, "nowhere", []) == []
    assert convergence_figure(part).axes
    assert told == []


def curve_cost(result):
    return result.curve[0.5].cost
