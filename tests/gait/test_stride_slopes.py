"""Exact derivatives of strides of two steps against differences."""

import pytest
from strides import WAYS, check_slopes, point_of
from synthetic_bipeds import synthetic


@pytest.mark.parametrize("name", WAYS)
def test_slopes_and_hessians_are_those_of_the_walk(name):
    check_slopes(*point_of(name))


def test_slopes_of_a_robot_with_other_joints():
    robot = synthetic("seven, waist and arms")
    check_slopes(*point_of("every way, duration free, lifted", robot))
