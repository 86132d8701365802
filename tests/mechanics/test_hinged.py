"""A stance foot that turns about a line: the hinged robot against Pinocchio's free-flyer."""

import numpy as np
import pinocchio as pin
import pytest
from numerics import relative_error
from synthetic_bipeds import synthetic

from gaitopt.contact import FlatFoot, ToeLine
from gaitopt.mechanics.impact import Impact, Turning
from gaitopt.mechanics.single_support import SingleSupport, standing_robot

COUNT = 4
TOE = ToeLine(0.01)


@pytest.fixture(scope="module", params=["biped", "seven, waist and arms"])
def walker(request, robot):
    return robot if request.param == "biped" else synthetic(request.param)


def motion_of(robot, rng):
    """Angle, rate and acceleration of the hinge, then of the joints, shape (3, COUNT, 1 + n)."""
    return rng.normal(0.0, [[[0.3]], [[2.0]], [[20.0]]], (3, COUNT, robot.tree.size + 1))


def test_flat_foot_has_no_hinge(robot):
    assert standing_robot(robot, FlatFoot()) is robot


def test_hinge_comes_first_and_moves_everything(walker):
    hinged = standing_robot(walker, TOE)
    assert hinged.joint_names[1:] == walker.joint_names
    assert hinged.tree.moves[:, 0].all()
    assert hinged.mass == pytest.approx(walker.mass, rel=1e-14)


def test_effort_is_that_of_a_free_flyer_moved_alike(walker, rng):
    hinge, model = TOE.hinge(walker.sole), walker.model
    data, motion = model.createData(), motion_of(walker, rng)
    effort = SingleSupport(standing_robot(walker, TOE), COUNT).state(*motion).effort
    for k, (q, v, a) in enumerate(motion.swapaxes(0, 1)):
        place = pin.exp6(q[0] * hinge.twist)
        found = pin.rnea(
            model, data,
            np.concatenate([pin.SE3ToXYZQUAT(place), q[1:]]),
            np.concatenate([v[0] * hinge.twist, v[1:]]),
            np.concatenate([a[0] * hinge.twist, a[1:]]),
        )  # fmt: skip
        wrench = place.act(pin.Force(found[:6])).vector
        assert relative_error(effort[k, 7:], found[6:]) < 1e-10
        assert relative_error(effort[k, :6], wrench) < 1e-10
        # the torque of the hinge is the moment of the ground about the line
        assert effort[k, 6] == pytest.approx(hinge.twist @ wrench, rel=1e-9)


def test_impact_of_a_turning_foot_is_pinocchios(walker, rng):
    n, model, hinge = walker.tree.size, walker.model, TOE.hinge(walker.sole)
    posture, rate = rng.normal(0.0, 0.3, n), rng.normal(0.0, 2.0, n)
    turning = Turning(hinge, 0.2, 1.7)
    state = Impact(walker).state(posture, rate, turning.twist)
    data, q = model.createData(), pin.neutral(model)
    q[7:] = posture
    J = pin.computeFrameJacobian(model, data, q, walker.swing_frame, pin.LOCAL)
    v = np.concatenate([turning.twist, rate])
    after = pin.impulseDynamics(model, data, q, v, J, 0.0, 0.0)
    assert relative_error(state.velocity, after) < 1e-9
    still = Impact(walker).state(posture, rate)
    assert relative_error(still.velocity, after) > 1e-3


def test_foot_that_stays_on_its_line_only_turns_about_it(walker, rng):
    n, hinge = walker.tree.size, TOE.hinge(walker.sole)
    posture, rate = rng.normal(0.0, 0.3, n), rng.normal(0.0, 2.0, n)
    turning = Turning(hinge, 0.2, 1.7)
    locked = Impact(walker).locked(posture, rate, turning)
    sole = locked.velocity[:6]
    about = sole @ hinge.twist / (hinge.twist @ hinge.twist)
    assert abs(about) > 1e-3
    assert sole == pytest.approx(about * hinge.twist, abs=1e-10)
    in_sole = turning.place.actInv(pin.Force(locked.impulse_rear)).vector
    assert hinge.twist @ in_sole == pytest.approx(0.0, abs=1e-9)  # no moment about the line
    assert np.abs(in_sole).max() > 1e-2
