"""The knee against rotations of the ankle about every joint line."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitopt.model.leg_geometry import Knee, find_knee

quick = settings(deadline=None, derandomize=True, max_examples=30)


def distance(point, axis, hip, ankle, angle):
    turned = point + pin.exp3(angle * axis) @ (ankle - point)
    return np.linalg.norm(turned - hip), turned


@quick
@given(st.integers(0, 10_000))
def test_no_joint_changes_the_length_more(seed):
    rng = np.random.default_rng(seed)
    points, axes = rng.normal(size=(6, 3)), rng.normal(size=(6, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    hip, ankle, angles = rng.normal(size=3), rng.normal(size=3), rng.uniform(-2.0, 2.0, 6)
    knee = find_knee(points, axes, hip, ankle, angles)
    line = points[knee.row], axes[knee.row], hip, ankle
    turn = knee.straight - angles[knee.row]
    longest, there = distance(*line, turn)
    assert longest == pytest.approx(knee.reach, rel=1e-12)
    np.testing.assert_allclose(
        (distance(*line, turn + 1e-6)[1] - there) / 1e-6, knee.side, atol=1e-5
    )
    grid = np.linspace(-np.pi, np.pi, 73)
    spans = [
        np.ptp([distance(p, a, hip, ankle, angle)[0] ** 2 for angle in grid])
        for p, a in zip(points, axes, strict=True)
    ]
    assert max(distance(*line, angle)[0] for angle in grid) <= longest + 1e-12
    assert spans[knee.row] >= 0.99 * max(spans)


@pytest.mark.parametrize(
    ("lower", "upper", "side"),
    [(0.2, 2.5, 1.0), (-2.5, 0.4, -1.0), (-1.0, 1.5, 0.0), (-np.inf, 2.0, 0.0)],
)
def test_a_one_sided_range_tells_how_the_knee_bends(lower, upper, side):
    assert Knee(3, 0.1, 0.8, np.array([-1.0, 0.0, 0.0])).range_side(lower, upper) == side
