import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitopt.errors import InputError
from gaitopt.sweep.grid import Axis, TaskGrid

DURATIONS = Axis("duration", (0.3, 0.35, 0.4))
SPEEDS = Axis("speed", (0.8, 0.9, 1.0, 1.1, 1.2))


def test_a_grid_has_every_combination_the_seeds_first():
    grid = TaskGrid((SPEEDS, DURATIONS))
    assert len(set(grid.order)) == 15
    assert grid.order[:2] == grid.seeds == ((0, 1), (4, 1))
    assert grid.values((3, 0)) == {"speed": 1.1, "duration": 0.3}
    assert grid.name((3, 0)) == "speed=1.1,duration=0.3"
    assert grid.probes == ((0, 0), (0, 2), (4, 0), (4, 2))


def test_from_one_seed_the_ends_lie_on_the_lines_through_it():
    assert TaskGrid((SPEEDS, DURATIONS), ((2, 1),)).probes == ((0, 1), (2, 0), (2, 2), (4, 1))


def test_a_single_value_is_its_own_seed():
    assert TaskGrid((Axis("speed", (1.0,)),)).seeds == ((0,),)


@given(st.integers(0, 99), st.integers(0, 2), st.sampled_from([5, 40, 100]))
@settings(derandomize=True, deadline=None)
def test_every_point_but_the_seed_is_reached_from_points_before_it(i, j, count):
    speeds = Axis("speed", tuple(0.5 + 0.01 * k for k in range(count)))
    grid = TaskGrid((speeds, DURATIONS), ((i % count, j),))
    known, (seed,) = set(), grid.seeds
    for level in grid.levels:
        left = [point for point in level.points if point not in known]
        while left:
            ready = [p for p in left if all(q in known for q in level.inner(p))]
            assert ready  # else points wait for each other
            assert all(level.inner(p) for p in ready if p != seed)
            for point in ready:
                for origin in level.inner(point):
                    line = level.line(point, origin)
                    assert line[0] == origin
                    assert point not in line
                    assert known.issuperset(line)
                    places = [[a - b for a, b in zip(q, point, strict=True)] for q in line]
                    assert len({place.index(next(filter(None, place))) for place in places}) == 1
            known.update(ready)
            left = [point for point in left if point not in known]
    assert known == set(grid.order)


def test_long_axes_are_explored_from_coarse_to_fine():
    speeds = Axis("speed", tuple(0.4 + 0.01 * k for k in range(91)))
    levels = TaskGrid((speeds, DURATIONS)).levels
    assert [len(level.points) for level in levels] == [24 * 3, 46 * 3, 91 * 3]
    assert levels[0].nodes == ((*range(0, 90, 4), 90), (0, 1, 2))
    assert sorted(levels[1].inner((6, 1))) == [(4, 1), (8, 1)]
    assert sorted(levels[1].line((6, 1), (4, 1))) == [(0, 1), (4, 1), (8, 1), (12, 1)]
    assert levels[0].line((8, 1), (4, 1)) == [(4, 1), (0, 1)]
    assert len(TaskGrid((SPEEDS, DURATIONS)).levels) == 1


def test_the_seed_is_the_point_nearest_to_what_is_asked():
    grid = TaskGrid((SPEEDS, DURATIONS))
    assert grid.nearest({"speed": 1.16}) == (4, 1)
    with pytest.raises(InputError, match="not over friction"):
        grid.nearest({"friction": 0.5})


def test_a_quantity_twice_is_refused():
    with pytest.raises(InputError, match="only once"):
        TaskGrid((SPEEDS, SPEEDS))
