"""Grids whose neighbours are far apart, or have legs of other lengths."""

import pytest
from sweeps import QUICK, quick_task

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.design.starts import many_starts
from gaitopt.sweep.continuation import ON_BRANCH
from gaitopt.sweep.grid import Axis
from gaitopt.sweep.scheduler import sweep


def test_a_walk_is_followed_along_the_length_of_the_shins(robot, tmp_path):
    """Taken over as it is, the walk at 0.29 m ends on a branch a seventh dearer."""
    axis = Axis("geometry.d4", (0.28, 0.29, 0.3))
    library = sweep(robot, quick_task(speed=0.9), [axis], tmp_path / "l", QUICK, spec=biped13())
    short, middle, long = (row["cost"] for row in library.rows)
    assert middle == pytest.approx(0.5 * (short + long), rel=0.01)
    assert library.states[(1,)].walk.first_iterations <= ON_BRANCH


def test_a_point_whose_walk_left_its_branch_is_as_good_as_a_single_design(robot, tmp_path):
    axis = Axis("speed", (0.5, 1.0, 1.5))
    library = sweep(robot, quick_task(), [axis], tmp_path / "l", QUICK)
    assert all(state.cold_started for state in library.states.values())
    single = many_starts(robot, quick_task(speed=1.0), QUICK).design
    assert library.rows[1]["cost"] <= single.solution.cost * (1.0 + 1e-6)
