import numpy as np
import pinocchio as pin
import pytest
from numerics import check_jacobian, relative_error

from gaitopt.mechanics.inverse_kinematics import loop_gap, loop_gap_hessian, loop_gap_jacobian

JOINTS = 7


@pytest.fixture
def chain(rng):
    """Fixed placements and motion axes (own frames) of a random chain."""
    turns = [pin.exp3(rng.normal(scale=0.3, size=3)) for _ in range(JOINTS)]
    shifts = rng.normal(scale=0.2, size=(JOINTS, 3))
    axes = rng.normal(size=(JOINTS, 6))
    axes[::2, :3] = 0.0  # turns
    axes[1::2, 3:] = 0.0  # slides
    return [pin.SE3(R, p) for R, p in zip(turns, shifts, strict=True)], axes


def walked(chain, y):
    """Placement of the end, and world axes, at coordinates y."""
    place, world = pin.SE3.Identity(), []
    for fixed, axis, amount in zip(*chain, y, strict=True):
        place = place * fixed
        world.append(place.act(pin.Motion(axis)).vector)
        place = place * pin.exp6(pin.Motion(amount * axis))
    return place, np.array(world)


def test_gap_is_position_and_sine_times_axis(rng):
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    gap = loop_gap(pin.SE3(pin.exp3(0.3 * axis), np.array([1.0, 2.0, 3.0])))
    assert relative_error(gap, [1.0, 2.0, 3.0, *(np.sin(0.3) * axis)]) < 1e-14


def test_slope(chain, rng):
    y = rng.normal(scale=0.5, size=JOINTS)
    slope = loop_gap_jacobian(*walked(chain, y))
    check_jacobian(lambda v: loop_gap(walked(chain, v)[0]), slope, y, step=1e-3)


@pytest.mark.parametrize("part", ["position", "rotation", "both"])
def test_curvature(chain, rng, part):
    y, weights = rng.normal(scale=0.5, size=JOINTS), rng.normal(size=6)
    weights[:3] *= part != "rotation"
    weights[3:] *= part != "position"
    H = loop_gap_hessian(*walked(chain, y), weights)
    check_jacobian(lambda v: weights @ loop_gap_jacobian(*walked(chain, v)), H, y, step=1e-3)
    np.testing.assert_array_equal(H, H.T)
