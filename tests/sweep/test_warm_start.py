from dataclasses import replace

import numpy as np

from gaitopt.design.active_set import ActiveRow
from gaitopt.sweep.continuation import WarmStart, is_better, promising, warm_start_of
from gaitopt.sweep.grid import Axis, TaskGrid

GRID = TaskGrid((Axis("speed", (1.0, 1.1, 1.2)),))


def walk(cost, slope, x=0.3):
    active = (ActiveRow("torque", 3, 0.25, 1.5),)
    return WarmStart(np.array([x, -x]), cost, active, (slope,), 7, 7, 9, 0.5, "cold")


def found(walk_at, point):
    return promising(GRID, walk_at, point, GRID.levels[0].neighbours(point))


def test_a_tangent_below_the_cost_is_a_promise():
    # the neighbour foretells 100 + 200 * 0.1 = 120 and may be off by 0.5 * 200 * 0.1 = 10
    assert found({(0,): walk(100.0, 200.0), (1,): walk(131.0, 400.0)}.get, (1,)) == [(0,)]
    assert found({(0,): walk(100.0, 200.0), (1,): walk(109.0, 400.0)}.get, (1,)) == []


def test_a_point_without_a_walk_is_promised_one_the_cheaper_first():
    known = {(0,): walk(100.0, 300.0), (1,): None, (2,): walk(140.0, 300.0)}
    assert found(known.get, (1,)) == [(2,), (0,)]


def test_the_way_back_along_a_branch_is_not_tried():
    known = {(0,): walk(100.0, 200.0), (1,): walk(131.0, 400.0)}
    straight = replace(known[(0,)], origin="speed=1.1", first_iterations=5)
    astray = replace(straight, first_iterations=12)
    assert found({**known, (0,): straight}.get, (1,)) == []
    assert found({**known, (0,): astray}.get, (1,)) == [(0,)]


def test_only_a_difference_that_counts_is_better():
    assert is_better(walk(99.0, 1.0), walk(100.0, 1.0))
    assert not is_better(walk(99.995, 1.0), walk(100.0, 1.0))
    assert is_better(walk(5.0, 1.0), None)
    assert not is_better(None, walk(5.0, 1.0))


def test_a_warm_start_survives_its_record():
    one = replace(walk(123.456, None), x=np.array([0.1, 1.0 / 3.0]))
    again = warm_start_of(one.record())
    assert again.x.tolist() == one.x.tolist()
    assert again.active == one.active
    assert (again.cost, again.cost_gradient, again.origin) == (123.456, (None,), "cold")
