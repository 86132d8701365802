"""Nearest points against what makes them nearest, and against coal's capsules."""

import coal
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numerics import check_differences, relative_error, steps

from gaitopt.mechanics.capsule_distance import distance_hessian, nearest
from gaitopt.mechanics.spatial import cross

fast = settings(deadline=None, derandomize=True, max_examples=200)
numbers = st.floats(-1.0, 1.0).map(lambda v: round(v, 3))
points = st.tuples(numbers, numbers, numbers)
segments = st.tuples(points, points).map(np.array)
STEP = 1e-3


def one(first, second):
    return nearest(np.array(first)[None], np.array(second)[None])


@given(segments, segments)
@fast
def test_no_other_points_are_nearer(first, second):
    """A convex problem: at an end the distance grows inwards, between the ends it is level."""
    near = one(first, second)
    slopes = near.between[0] @ near.along[0][0], -near.between[0] @ near.along[1][0]
    s, t = (float(share[0]) for share in near.share)
    assert 0.0 <= min(s, t) <= max(s, t) <= 1.0
    for share, slope in zip((s, t), slopes, strict=True):
        assert slope > -1e-9 or share == 1.0
        assert slope < 1e-9 or share == 0.0
    here = (1 - t) * second[0] + t * second[1]
    np.testing.assert_allclose(near.second[0], here, atol=1e-15)
    np.testing.assert_allclose(
        near.between[0], (1 - s) * first[0] + s * first[1] - here, atol=1e-15
    )


@given(segments, segments)
@fast
def test_the_order_does_not_matter(first, second):
    assert one(first, second).distance == pytest.approx(one(second, first).distance, abs=1e-9)


@pytest.mark.parametrize("seed", range(10))
def test_a_segment_of_the_size_of_rounding_is_a_point(seed):
    rng = np.random.default_rng(seed)
    first, second = rng.uniform(-1.0, 1.0, (2, 2, 3))
    second[1] = second[0] + 1e-16 * rng.normal(size=3)
    point = np.array([second[0], second[0]])
    assert one(first, second).distance == pytest.approx(one(first, point).distance, abs=1e-14)
    assert one(second, first).distance == pytest.approx(one(first, point).distance, abs=1e-14)


def capsule(ends, radius):
    axis = ends[1] - ends[0]
    length = np.linalg.norm(axis)
    turn = np.eye(3)
    if length > 0.0:
        turn = np.linalg.svd((axis / length)[None])[2][[1, 2, 0]].T
        turn[:, 1] *= np.linalg.det(turn)
    return coal.Capsule(radius, length), coal.Transform3s(turn, ends.mean(axis=0))


@pytest.mark.parametrize("seed", range(20))
def test_distances_are_those_of_coals_capsules(seed):
    rng = np.random.default_rng(seed)
    first, second = rng.uniform(-1.0, 1.0, (2, 2, 3))
    second += (2.5, 0.0, 0.0)
    if seed == 0:
        second[1] = second[0]  # a ball
    if seed == 1:
        second = first + np.array([0.9, 0.3, -0.2])  # parallel
    shapes = (*capsule(first, 0.11), *capsule(second, 0.07))
    expected = coal.distance(*shapes, coal.DistanceRequest(), coal.DistanceResult())
    assert one(first, second).distance[0] - 0.18 == pytest.approx(expected, abs=1e-7)


def test_crossing_segments_touch():
    first, second = [[-1.0, 0, 0], [1.0, 0, 0]], [[0.5, -1.0, 0], [0.5, 3.0, 0]]
    near = one(first, second)
    assert near.distance[0] == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(np.ravel(near.share), [0.75, 0.25])
    axes = np.random.default_rng(0).normal(size=(1, 4, 6))
    assert np.isfinite(near.force).all()
    assert np.isfinite(distance_hessian(near, axes)).all()


# Second segments near a first one along x, by where the nearest points are.
FIRST = np.array([[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]])
REGIONS = {
    "inside, inside": [[-0.1, 0.3, 0.5], [0.2, 0.2, -0.6]],
    "inside, end": [[0.1, 0.2, 0.3], [0.3, 0.7, 0.9]],
    "end, inside": [[0.8, 0.2, -0.4], [0.7, 0.3, 0.5]],
    "end, end": [[0.7, 0.3, 0.2], [1.2, 0.5, 0.9]],
    "point": [[0.2, 0.3, 0.1], [0.2, 0.3, 0.1]],
}
regions = pytest.mark.parametrize("region", REGIONS)


def turned(axes, segment, angles):
    """The segment after joints with these axes at zero have turned, the last one first."""
    for axis, angle in zip(axes[::-1], angles[::-1], strict=True):
        rate = axis * angle
        theta = np.linalg.norm(rate[3:])
        k = rate[3:] / theta if theta else rate[3:]
        K = cross(k, np.eye(3)).T
        R = np.eye(3) + np.sin(theta) * K + (1 - np.cos(theta)) * K @ K
        centre = np.cross(axis[3:], axis[:3]) / (axis[3:] @ axis[3:])
        segment = (segment - centre) @ R.T + centre
    return segment


@pytest.fixture
def joints(rng):
    """Three revolute axes, shape (3, 6)."""
    direction, point = rng.normal(size=(2, 3, 3))
    return np.concatenate([cross(point, direction), direction], axis=1)


@regions
def test_slope_in_every_region(region, joints):
    second = np.array(REGIONS[region])
    slope = joints @ one(FIRST, second).force[0]
    found = [
        np.array([
            one(FIRST, turned(joints, second, h * e)).distance[0]
            - one(FIRST, turned(joints, second, -h * e)).distance[0]
            for e in np.eye(3)
        ]) / (2.0 * h)
        for h in steps(STEP)
    ]  # fmt: skip
    check_differences(slope, found)


@regions
def test_curvature_in_every_region(region, joints):
    """Second differences of the distance, in all pairs of joints."""
    second = np.array(REGIONS[region])
    H = distance_hessian(one(FIRST, second), joints[None])[0]

    def distance(angles):
        return one(FIRST, turned(joints, second, angles)).distance[0]

    def bend(h):
        e = h * np.eye(3)
        pairs = [
            distance(a + b) - distance(a - b) - distance(b - a) + distance(-a - b)
            for a in e
            for b in e
        ]
        return np.reshape(pairs, (3, 3)) / (4.0 * h * h)

    check_differences(H, [bend(h) for h in steps(1e-3)], tolerance=1e-5)
    assert relative_error(H, H.T) < 1e-12


def test_parallel_segments_that_move_apart():
    """All their points are nearest; a translation has a slope all the same."""
    second, away = np.array([[-0.7, 0.3, 0.2], [0.9, 0.3, 0.2]]), np.array([0.3, -0.2, 0.7])
    force = one(FIRST, second).force[0]
    found = [
        (one(FIRST, second + h * away).distance - one(FIRST, second - h * away).distance)
        / (2.0 * h)
        for h in steps(STEP)
    ]
    check_differences(np.array([away @ force[:3]]), found)


def test_almost_parallel_segments_have_a_bounded_curvature(joints):
    second = FIRST + np.array([0.0, 0.3, 0.0])
    second[1, 2] += 1e-5
    assert np.abs(distance_hessian(one(FIRST, second), joints[None])).max() < 1e3
