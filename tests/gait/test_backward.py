"""Walks backward and in place: half-steps like those forward, with a cost that has a meaning."""

import numpy as np
import pytest
from walks import walk

from gaitopt.design.starts import design_gait
from gaitopt.design.summary import summarise
from gaitopt.errors import EvaluationError, InputError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.costs import MechanicalWork, TorqueCost, per_second
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.presets import humanoid_task, natural_duration, preset_task, stroll
from gaitopt.simulate.second_engine import second_engine
from gaitopt.simulate.walk import squared_torque
from gaitopt.sweep.speed_search import fastest
from gaitopt.view.figures import make_figure


@pytest.fixture(scope="module")
def backward(robot):
    return design_gait(robot, preset_task(speed=-0.4), starts=1)


@pytest.fixture(scope="module")
def in_place(robot):
    return design_gait(robot, preset_task(speed=0.0), starts=1)


def test_backward_costs_the_integral_over_the_length_of_the_step(backward):
    """By the trapezoidal rule at 2001 instants of the trajectory, in its own words."""
    gait = backward.gait
    assert gait.speed == pytest.approx(-0.4)
    assert gait.step_length == pytest.approx(-0.16)
    assert squared_torque(gait) == pytest.approx(gait.cost, rel=1e-3)
    assert (gait.cost_unit, gait.cost_words) == ("N²·m·s", "squared torque per metre")


def test_in_place_costs_the_mean_over_time(in_place):
    gait = in_place.gait
    times = np.linspace(0.0, gait.duration, 2001)
    torque = gait.trajectory.at(times, before=times > 0.0).torque
    mean = float(np.trapezoid((torque**2).sum(axis=1), times)) / gait.duration
    assert gait.cost == pytest.approx(mean, rel=1e-3)
    assert (gait.cost_unit, gait.cost_words) == ("N²·m²", "squared torque per second")
    assert (gait.speed, gait.step_length) == (0.0, 0.0)
    assert squared_torque(gait) == pytest.approx(gait.cost, rel=1e-3)


def test_unit_per_second_is_the_unit_times_a_speed():
    assert per_second(TorqueCost().unit) == "N²·m²"
    assert per_second(MechanicalWork().unit) == "W"
    assert per_second("kg/m²") == "kg/m²·m/s"


@pytest.mark.parametrize("name", ["backward", "in_place"])
def test_walks_are_certified_by_both_referees(name, request):
    found = request.getfixturevalue(name)
    assert found.certificate.certified, found.certificate.verdict
    assert second_engine(found.gait, 61).agrees


@pytest.mark.parametrize(("name", "way"), [("backward", -1.0), ("in_place", 0.0)])
def test_the_base_goes_where_it_should(name, way, request):
    gait = request.getfixturevalue(name).gait
    at = gait.trajectory.at(np.array([0.0, 2.0 * gait.duration]))
    moved = at.base_position[1] - at.base_position[0]
    assert moved == pytest.approx([0.32 * way, 0.0, 0.0], abs=1e-9)


def test_summary_has_no_cost_of_transport_in_place(backward, in_place):
    assert summarise(backward.gait)["walk"]["mechanical_cost_of_transport"] > 0.0
    facts = summarise(in_place.gait)["walk"]
    assert facts["mechanical_cost_of_transport"] is None
    assert facts["cost_N2ms"] is None


@pytest.mark.parametrize("name", ["backward", "in_place"])
def test_figure_of_the_step_has_its_ground(name, request):
    """Between all that is drawn, at its height, whichever way the steps go."""
    figure = make_figure(request.getfixturevalue(name).gait, "step")
    (ground,) = figure.axes[0].collections[:1]
    top = ground.get_paths()[0].vertices[:, 1].max()
    assert top == pytest.approx(0.0, abs=1e-12)


def test_gait_file_gives_it_again(in_place, tmp_path):
    again = load_gait(save_gait(in_place.gait, tmp_path / "in_place.npz"))
    assert again.cost == in_place.gait.cost
    assert again.cost_unit == "N²·m²"


def test_a_step_the_wrong_way_has_no_cost():
    backward = walk("upright, backward, everything free")
    x = backward.x.copy()
    x[backward.problem.layout.index("step_length")] = 0.1
    assert backward.problem.step(x).step_length == 0.1
    for ask in (backward.problem.values, backward.problem.point):
        with pytest.raises(EvaluationError, match="does not go where it should"):
            ask(x)


def test_gait_of_a_point_tells_the_way():
    found = walk("upright, backward, everything free")
    assert gait_at(found.problem, found.x, {}).speed < 0.0


def test_very_slow_steps_get_short_not_slow(robot):
    rest = humanoid_task(robot, speed=0.0).duration
    assert rest == natural_duration(robot, 0.2 * stroll(robot)) == natural_duration(robot, -0.02)
    assert humanoid_task(robot, speed=-0.6).duration == humanoid_task(robot, speed=0.6).duration
    assert humanoid_task(robot, speed=0.6).duration < rest < 1.5


def test_the_fastest_walk_is_searched_forward(robot):
    with pytest.raises(InputError, match="searched forward"):
        fastest(robot, lambda speed: preset_task(speed=speed), -0.4)
