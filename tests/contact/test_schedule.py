"""Schedules of phases, and the instants at which a step of several phases is looked at."""

import numpy as np
import pytest

from gaitopt.contact import (
    AFTER,
    FlatFoot,
    HeelLine,
    Hinge,
    LegExchange,
    Phase,
    PhaseEnd,
    Schedule,
    ToeLine,
)
from gaitopt.errors import InputError
from gaitopt.gait.grid import phase_grid, uniform_grid
from gaitopt.gait.task import Task

SMOOTH, IMPACT = PhaseEnd.SMOOTH, PhaseEnd.IMPACT
TWO = Schedule((Phase(FlatFoot(), 0.7, SMOOTH), Phase(FlatFoot())))


def test_paper_walk_is_one_phase_on_the_flat_foot(robot):
    schedule = Task().schedule
    assert [p.contact for p in schedule.phases] == [FlatFoot()]
    assert schedule.last.ends_by is IMPACT
    assert schedule.changes.size == 0
    E = schedule.symmetry.joint_map(robot)
    assert np.array_equal(E @ E, np.eye(len(E)))
    assert not np.array_equal(E, np.eye(len(E)))


def test_exchange_reflects_vectors_as_it_does_legs():
    assert LegExchange.reflection == (1.0, -1.0, 1.0)


def test_instant_of_a_change_belongs_to_the_phase_before_it():
    assert TWO.phase_at(np.array([0.0, 0.7, 0.7 + AFTER, 1.0])).tolist() == [0, 0, 1, 1]


@pytest.mark.parametrize(
    "phases",
    [
        (),
        (Phase(FlatFoot(), 0.9),),
        (Phase(FlatFoot(), 1.0, SMOOTH), Phase(FlatFoot())),
        (Phase(FlatFoot(), 0.0, SMOOTH), Phase(FlatFoot())),
        (Phase(FlatFoot(), 1.0, SMOOTH),),
        (Phase(FlatFoot(), 0.5, IMPACT), Phase(FlatFoot())),
        (Phase(ToeLine(0.01)),),
        (Phase(ToeLine(0.01), 0.5, SMOOTH), Phase(ToeLine(0.01))),
        (Phase(FlatFoot(), 0.3, SMOOTH), Phase(ToeLine(0.01), 0.5, SMOOTH), Phase(FlatFoot())),
    ],
)
def test_phases_that_make_no_step_are_refused(phases):
    with pytest.raises(InputError, match="phase"):
        Schedule(phases)


def test_a_foot_may_turn_after_its_landing_and_before_it_leaves():
    heel, toe = HeelLine(0.01), ToeLine(0.01)
    both = Schedule((Phase(heel, 0.2, SMOOTH), Phase(FlatFoot(), 0.7, SMOOTH), Phase(toe)))
    assert both.contacts == (both.first.contact, both.last.contact) == (heel, toe)
    assert Schedule((Phase(heel, 0.2, SMOOTH), Phase(FlatFoot()))).first.contact is heel
    assert Schedule().contacts == ()


@pytest.mark.parametrize("axis", [[0.1, 0.99, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
def test_a_line_that_is_not_its_own_mirror_image_is_refused(axis):
    """The other foot would turn about another one, of which no equation knows."""
    with pytest.raises(InputError, match="give a line across it"):
        Hinge(np.array([0.1, 0.0, 0.0]), np.array(axis))


def test_grid_of_one_phase_is_the_uniform_one():
    grid, whole = phase_grid(31, "simpson", np.zeros(0)), uniform_grid(31)
    assert np.array_equal(grid.instants, whole.instants)
    assert np.array_equal(grid.weights, whole.weights)


@pytest.mark.parametrize("quadrature", ["simpson", "euler"])
def test_grid_of_phases_integrates_a_jump_on_both_sides(quadrature):
    grid = phase_grid(31, quadrature, TWO.changes)
    phase = TWO.phase_at(grid.instants)
    assert (np.diff(grid.instants) > 0.0).all()
    assert {0.0, 0.7, 0.7 + AFTER, 1.0} <= set(grid.instants.tolist())
    jump = np.array([2.0, 5.0])[phase]
    assert grid.weights @ jump == pytest.approx(0.7 * 2.0 + 0.3 * 5.0, rel=1e-11)
    if quadrature == "simpson":  # exact for cubics in each phase
        s = grid.instants
        assert grid.weights @ (jump * s**3) == pytest.approx(
            (2.0 * 0.7**4 + 5.0 * (1.0 - 0.7**4)) / 4.0, rel=1e-11
        )
