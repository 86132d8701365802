import numpy as np
import pinocchio as pin
import pytest
from numerics import check_jacobian, relative_error

from gaitopt.gait.double_support import PELVIS_CHAIN, SWING_SOLE_CHAIN, drive, place
from gaitopt.gait.parameters import GEOMETRY_NAMES

VALUES = {
    "pelvis_height": 0.63,
    "pelvis_lateral": 0.08,
    "pelvis_forward": -0.31,
    "trunk_pitch": 0.05,
    "foot_spacing": 0.16,
    "step_length": 0.4,
    "pelvis_yaw": 0.12,
    "pelvis_roll": -0.07,
    "foot_yaw": 0.2,
    "duration": 0.45,
}
G = np.array([VALUES[name] for name in GEOMETRY_NAMES])
CHAINS = pytest.mark.parametrize("chain", [PELVIS_CHAIN, SWING_SOLE_CHAIN], ids=["pelvis", "sole"])


def test_pelvis_is_yawed_then_pitched_then_rolled():
    expected = pin.SE3(pin.rpy.rpyToMatrix(-0.07, 0.05, 0.12), np.array([-0.31, 0.08, 0.63]))
    placement, _ = place(PELVIS_CHAIN, G)
    assert relative_error(placement.homogeneous, expected.homogeneous) < 1e-14


def test_sole_is_behind_and_beside_the_stance_sole():
    flat = G.copy()
    flat[GEOMETRY_NAMES.index("foot_yaw")] = 0.0
    placement, _ = place(SWING_SOLE_CHAIN, flat)
    np.testing.assert_allclose(placement.translation, [-0.4, 0.16, 0.0], atol=1e-15)
    np.testing.assert_array_equal(placement.rotation, np.eye(3))


def test_feet_turned_out_keep_step_length_and_spacing_along_their_bisector():
    placement, _ = place(SWING_SOLE_CHAIN, G)
    assert pin.rpy.matrixToRpy(placement.rotation)[2] == pytest.approx(0.2)
    along = pin.rpy.rpyToMatrix(0.0, 0.0, 0.1).T @ placement.translation
    np.testing.assert_allclose(along, [-0.4, 0.16, 0.0], atol=1e-15)
    # Seen from the other foot the offset is the opposite: its mirror image takes the next step.
    back = pin.rpy.rpyToMatrix(0.0, 0.0, -0.1).T @ placement.inverse().translation
    np.testing.assert_allclose(back, [0.4, -0.16, 0.0], atol=1e-15)


@CHAINS
def test_axes_are_the_twists_of_the_displacements(chain):
    placement, axes = place(chain, G)

    def twist(g):
        moved, _ = place(chain, g)
        return pin.log6(moved * placement.inverse()).vector

    twists = axes.T @ drive(chain)
    assert np.abs(twists).max(axis=0).astype(bool).sum() >= 3  # quantities that move it
    check_jacobian(twist, twists, G, step=1e-4)
