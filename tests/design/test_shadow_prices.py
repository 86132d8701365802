import pytest

from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.shadow_prices import LIMIT, shadow_prices
from gaitopt.design.summary import summarise
from gaitopt.gait.presets import preset_task
from gaitopt.solvers import solver_by_name

QUICK = DesignOptions(solver=solver_by_name("sqp", tolerance=1e-9), refine=False, approach="direct")
TASK = preset_task(torque_limit=60.0, friction=0.3, samples=21)


@pytest.fixture(scope="module")
def pressed(robot):
    return design(robot, TASK, QUICK)


@pytest.fixture(scope="module")
def prices(pressed):
    return shadow_prices(pressed.problem, pressed.solution.x, pressed.certificate.multipliers)


def test_limits_of_single_joints_add_up_to_that_of_all(prices):
    (of_all,) = (one for one in prices if one.name == "torque_limit")
    single = [one for one in prices if one.kind == LIMIT and one.name.endswith(" torque")]
    assert len(single) > 1
    assert {abs(one.value) for one in single} == {60.0}
    outward = sum(one.cost_per_unit if one.words == "upper" else -one.cost_per_unit
                  for one in single)  # fmt: skip
    assert outward == pytest.approx(of_all.cost_per_unit, rel=1e-9)
    assert of_all.cost_per_unit < 0.0  # stronger motors walk more cheaply


def test_a_gait_knows_the_prices(pressed, prices):
    assert summarise(pressed.gait)["shadow_prices"] == [price.record() for price in prices]


def test_what_is_not_pressed_on_has_no_price(prices):
    assert "trunk_roll" not in {price.name for price in prices}
    assert all(price.cost_per_unit != 0.0 for price in prices)
