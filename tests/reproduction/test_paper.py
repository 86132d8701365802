"""What is typed in from the paper."""

import numpy as np
import pytest

from reproduction.paper import printed


def test_table_3_has_eight_speeds_and_its_least_cost_at_0_7():
    np.testing.assert_allclose(printed().speeds, np.arange(4, 12) / 10.0)
    assert printed().speeds[int(np.argmin(printed().costs))] == 0.7


def test_evaluations_per_iteration_are_the_parameters_and_one_both_times():
    runs = [run for row in printed().table3 for run in (row.analytical, row.differences)]
    assert all(43.0 < run.evaluations_per_iteration < 45.0 for run in runs)


def test_text_and_table_agree_at_1_0():
    row = printed().at(1.0)
    assert row is not None
    assert row.analytical.cost == printed().cost_two_postures
    assert printed().step_length == pytest.approx(printed().speed * printed().duration)


def test_a_speed_that_the_table_does_not_have():
    assert printed().at(1.2) is None
