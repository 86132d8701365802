"""Schedules of phases, and the instants at which a step of several phases is looked at."""

import numpy as np
import pytest

from gaitopt.contact import (
    AFTER,
    ContactMode,
    FlatFoot,
    HeelLine,
    Hinge,
    LegExchange,
    Phase,
    PhaseEnd,
    Schedule,
    ToeLine,
    check_contacts,
)
from gaitopt.errors import InputError
from gaitopt.gait.grid import phase_grid, uniform_grid
from gaitopt.gait.task import Task
from gaitopt.model.sole import Sole

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


SOLE = Sole(0.12, -0.06, 0.04, -0.04)
ACROSS, TOES = np.array([0.0, 1.0, 0.0]), np.array([True, True, False, False])


class Ball(ContactMode):
    """The foot turns about a line 4 cm behind its tip."""

    name = "ball line"

    def hinge(self, sole):
        return Hinge(np.array([sole.toe - 0.04, 0.0, 0.0]), ACROSS)

    def bearing(self, sole, margin):
        return [sole.toe, sole.toe - 0.04, sole.left - margin, sole.right + margin]

    def resting(self):
        return TOES


def checked(mode, sole=SOLE):
    check_contacts(Schedule((Phase(FlatFoot(), 0.7, SMOOTH), Phase(mode))), sole)


@pytest.mark.parametrize("mode", [FlatFoot(), ToeLine(0.01), HeelLine(0.01), Ball()])
def test_contacts_that_fit_the_sole_are_taken(mode):
    checked(mode)


@pytest.mark.parametrize(
    ("method", "answer", "told"),
    [
        ("name", "flat", "the name of the contact mode Wrong is 'flat'; give a text of one line"),
        ("name", "a\nb", r"the name of the contact mode Wrong is 'a\\nb'"),
        ("resting", lambda _: TOES.nothing, r"which corners rest: Attrib.*\(line \d+ of test_sche"),
        ("resting", lambda _: [True, True, False, False], "return an array of four booleans"),
        ("resting", lambda _: ~TOES & TOES, "return an array of four booleans, not all False"),
        ("resting", lambda _: TOES | ~TOES, "has a hinge, and 4 of 4 corners rest"),
        (
            "hinge",
            lambda _, sole: sole / 2,
            r"has no hinge: TypeError.*\(line \d+ of test_schedule",
        ),
        (
            "hinge",
            lambda _, sole: sole.toe,
            r"hinge\(\) of the contact 'ball line' returns 0.12; ret",
        ),
        ("hinge", lambda *_: None, "has no hinge, and 2 of 4 corners rest"),
        ("hinge", lambda *_: Hinge(np.array([np.nan, 0, 0]), ACROSS), "give an array of 3 numbers"),
        ("hinge", lambda *_: Hinge(np.array([0, 0, 0.1]), ACROSS), "x = 0 m, z = 0.1 m; give one"),
        (
            "hinge",
            lambda *_: Hinge(np.array([0.13, 0, 0]), ACROSS),
            "give one of the sole, from -0",
        ),
        ("hinge", lambda *_: Hinge(np.zeros(3), -ACROSS), "presses a corner that does not rest"),
        (
            "bearing",
            lambda *_: {}["edge"],
            r"where it bears: KeyError.*\(line \d+ of test_schedule",
        ),
        ("bearing", lambda *_: [0.1, 0.0], "give an array of 4 numbers"),
        ("bearing", lambda *_: [0.0, 0.1, 0.04, -0.04], "bears from 0.1 to 0 m ahead"),
        ("bearing", lambda *_: [0.12, 0.1, 0.04, -0.05], "stay within it, as by a shorter strip"),
    ],
)
def test_a_contact_with_a_mistake_is_refused_with_its_line(method, answer, told):
    wrong = type("Wrong", (Ball,), {"__module__": __name__, method: answer})()
    with pytest.raises(InputError, match=told):
        checked(wrong)


@pytest.mark.parametrize("mode", [ToeLine(0.19), HeelLine(0.19)])
def test_a_strip_longer_than_the_sole_is_refused(mode):
    """The centre of pressure was allowed where there is no sole."""
    with pytest.raises(InputError, match="stay within it, as by a shorter strip"):
        checked(mode)


def test_what_is_no_contact_mode_is_refused():
    with pytest.raises(InputError, match=r"is <class .*; give an instance of a ContactMode"):
        Schedule((Phase(FlatFoot),))


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
