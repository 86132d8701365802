"""Loops as functions of the leg's joints, by Newton's method: against cranks and rods in closed
form, differences, and MuJoCo."""

import numpy as np
import pytest
from numerics import check_jacobian
from test_linkages import ANKLE, PLACES, POSTURES, example

import gaitopt.model.linkage
from gaitopt.actuators.linkages import motor_angles
from gaitopt.model.linkage import Linkage, LoopClosure, first_fault, motor_series

RANGE = 0.4  # rad


def turned(closure):
    """A linkage of two motors in loops."""
    none = (None, None)
    return Linkage(("pitch", "roll"), ("a", "b"), (), (), none, none, none, none, closure)


def of_rods():
    """The linkage of the example as loops of lines: cranks, and rods on balls."""
    places = [PLACES[0], PLACES[0] @ PLACES[1]]
    axes = [place[:3, :3] @ axis for place, axis in zip(places, ANKLE.axis, strict=True)]
    points, parents, ends = [place[:3, 3] for place in places], [-1, 0], []
    for rod in example().rods:
        crank = len(axes)
        axes += [np.array(rod.crank_axis, dtype=float), *np.eye(3)]
        points += [rod.crank_centre, *[rod.crank_end] * 3]
        parents += [-1, crank, crank + 1, crank + 2]
        ends.append((crank + 3, rod.rod_end, 1, rod.rod_end))
    return LoopClosure(
        tuple(parents), tuple(tuple(map(float, a)) for a in axes),
        tuple(tuple(map(float, p)) for p in points), (False,) * len(axes), tuple(ends), (2, 6),
        (-RANGE, -RANGE), (RANGE, RANGE),
    )  # fmt: skip


def test_rods_on_balls_turn_their_cranks_as_in_closed_form():
    """The spin of a rod about itself is no matter."""
    inside = POSTURES[(np.abs(POSTURES) < RANGE).all(axis=1)]
    assert len(inside) > 1
    found = motor_angles(turned(of_rods()), ANKLE, inside)
    known = motor_angles(example(), ANKLE, inside)
    for part in ("angle", "jacobian", "first", "second"):
        np.testing.assert_allclose(getattr(found, part), getattr(known, part), atol=1e-9)


def test_postures_that_are_asked_for_again_are_not_found_again(monkeypatch):
    """Rows, their Jacobian and their Hessian ask for the same; Newton's method is most of it."""
    linkage, closed, made = turned(of_rods()), gaitopt.model.linkage._closed, []
    motor_angles(linkage, ANKLE, POSTURES)  # its table
    monkeypatch.setattr(
        gaitopt.model.linkage, "_closed", lambda *args: made.append(args) or closed(*args)
    )
    once, again = (motor_angles(linkage, ANKLE, POSTURES + 0.01) for _ in range(2))
    other = motor_angles(linkage, ANKLE, POSTURES + 0.02)
    assert len(made) == 2
    np.testing.assert_array_equal(once.second, again.second)
    assert np.abs(other.angle - once.angle).max() > 1e-3


@pytest.mark.parametrize("q", [(0.1, -0.2), (0.55, 0.1), (-0.6, 0.7)], ids=str)
def test_derivatives_of_the_motors_angles(q):
    """Beyond the range, too, where angles go on evenly."""
    linkage, q = turned(of_rods()), np.array(q)
    at = motor_angles(linkage, ANKLE, q[None])
    for part, derivative in (("angle", at.jacobian), ("jacobian", at.first), ("first", at.second)):
        check_jacobian(
            lambda q, part=part: getattr(motor_angles(linkage, ANKLE, q[None]), part)[0],
            derivative[0], q,
        )  # fmt: skip


def test_far_beyond_the_range_motors_still_hold_the_joints():
    at = motor_angles(turned(of_rods()), ANKLE, np.array([[3.0, -2.0], [-3.0, 3.0]]))
    assert np.abs(np.linalg.det(at.jacobian)).min() > 0.1


def test_a_slide_is_a_distance():
    """A linear motor between two points: its length by the law of cosines."""
    ends = ((2, (0.3, 0.0, 0.0), 0, (0.3, 0.0, 0.0)),)
    closure = LoopClosure(
        (-1, -1, 1), ((0.0, 1.0, 0.0), (0.0, 1.0, 0.0), (0.8, 0.0, 0.6)),
        ((0.0, 0.0, 0.0), (-0.1, 0.0, -0.3), (0.0, 0.0, 0.0)), (False, False, True), ends, (2,),
        (-0.5,), (0.5,),
    )  # fmt: skip
    q = np.linspace(-0.5, 0.5, 5)[:, None]
    (length,) = motor_series(closure, q)
    tip = 0.3 * np.stack([np.cos(q[:, 0]), 0.0 * q[:, 0], -np.sin(q[:, 0])], axis=1)
    distance = np.linalg.norm(tip - [-0.1, 0.0, -0.3], axis=1)
    np.testing.assert_allclose(length.value, distance - 0.5, atol=1e-12)


def test_dead_points_are_found_in_the_range():
    assert first_fault(of_rods()) == ()
    wide = of_rods()._replace(lower=(-1.5, -RANGE), upper=(1.5, RANGE))
    pitch, roll = first_fault(wide)
    assert 0.5 < abs(pitch) < 1.6
    assert abs(roll) < 0.5
