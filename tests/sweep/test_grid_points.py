import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitopt.errors import InputError
from gaitopt.sweep.grid import Axis, Grid

DURATIONS = Axis("duration", (0.3, 0.35, 0.4))
SPEEDS = Axis("speed", (0.8, 0.9, 1.0, 1.1, 1.2))


def test_a_grid_has_every_combination_the_seeds_first():
    grid = Grid((SPEEDS, DURATIONS))
    assert len(set(grid.order)) == 15
    assert grid.order[:2] == grid.seeds == ((0, 1), (4, 1))
    assert grid.values((3, 0)) == {"speed": 1.1, "duration": 0.3}
    assert grid.name((3, 0)) == "speed=1.1,duration=0.3"
    assert grid.probes == ((0, 0), (0, 2), (4, 0), (4, 2))


def test_from_one_seed_the_ends_lie_on_the_lines_through_it():
    assert Grid((SPEEDS, DURATIONS), ((2, 1),)).probes == ((0, 1), (2, 0), (2, 2), (4, 1))


def test_a_single_value_is_its_own_seed():
    assert Grid((Axis("speed", (1.0,)),)).seeds == ((0,),)


@given(st.integers(0, 4), st.integers(0, 2))
@settings(derandomize=True, deadline=None)
def test_every_point_but_the_seed_is_reached_from_one_before_it(i, j):
    grid = Grid((SPEEDS, DURATIONS), ((i, j),))
    rank = {point: n for n, point in enumerate(grid.order)}
    for point in grid.order[1:]:
        inner = grid.inner(point)
        assert inner
        assert all(rank[q] < rank[point] for q in inner)


def test_the_seed_is_the_point_nearest_to_what_is_asked():
    grid = Grid((SPEEDS, DURATIONS))
    assert grid.nearest({"speed": 1.16}) == (4, 1)
    with pytest.raises(InputError, match="not over friction"):
        grid.nearest({"friction": 0.5})


def test_a_quantity_twice_is_refused():
    with pytest.raises(InputError, match="only once"):
        Grid((SPEEDS, SPEEDS))
