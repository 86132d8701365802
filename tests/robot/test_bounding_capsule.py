import coal
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitopt.model.capsules import bounding_capsule, farthest_centre, smallest_circle
from gaitopt.model.sole_detection import Points, points_of

fast = settings(deadline=None, derandomize=True, max_examples=100)
numbers = st.floats(-1.0, 1.0).map(lambda v: round(v, 2))
flat = st.lists(st.tuples(numbers, numbers), min_size=1, max_size=30).map(np.array)
spatial = st.lists(st.tuples(numbers, numbers, numbers), min_size=1, max_size=80).map(np.array)
NOWHERE = np.zeros(3)


def outside(found, points):
    """How far balls reach out of a capsule, at most."""
    axis = found.end - found.start
    share = (points.centres - found.start) @ axis / max(axis @ axis, 1e-12)
    nearest = found.start + np.clip(share, 0.0, 1.0)[:, None] * axis
    off = np.linalg.norm(points.centres - nearest, axis=1)
    return (off + points.radii - found.radius).max()


@given(flat)
@fast
def test_no_circle_is_smaller(points):
    """The points on it do not fit into half of it: moving the centre loses one of them."""
    centre = smallest_circle(points)
    away = points - centre
    off = np.linalg.norm(away, axis=1)
    on_it = away[off > off.max() - 1e-9]
    for direction in np.linspace(0.0, 2.0 * np.pi, 60):
        step = np.array([np.cos(direction), np.sin(direction)])
        assert (on_it @ step).min() < 1e-6


def test_circles_of_three_and_of_two_points():
    triangle = np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 1.5], [1.0, 0.3]])
    # centre on x = 1: y² + 1 = (1.5 - y)²
    np.testing.assert_allclose(smallest_circle(triangle), [1.0, 1.25 / 3.0])
    blunt = np.array([[0.0, 0.0], [2.0, 0.4], [1.0, 0.5]])
    np.testing.assert_allclose(smallest_circle(blunt), [1.0, 0.2])


@given(spatial, st.floats(0.0, 0.3), st.floats(0.0, 6.3))
@fast
def test_everything_is_inside(centres, radius, angle):
    whole = Points(centres, np.full(len(centres), radius))
    points, facing = Points.together([whole]), np.array([np.cos(angle), np.sin(angle), 0.0])
    smallest = bounding_capsule(points, NOWHERE, NOWHERE)
    flat = bounding_capsule(points, NOWHERE, facing)
    assert outside(smallest, whole) < 1e-7
    assert outside(flat, whole) < 1e-7
    assert flat.reach(facing) <= smallest.reach(facing) + 1e-12
    assert flat.reach(facing) >= (centres @ facing).max() + radius - 1e-7


@given(flat, st.floats(0.0, 6.3))
@fast
def test_no_centre_is_farther(points, angle):
    """Moving on in any direction that is farther loses one of the points."""
    facing = np.array([np.cos(angle), np.sin(angle)])
    size = np.linalg.norm(points - smallest_circle(points), axis=1).max() + 0.01
    reach = np.full(len(points), 2.0 * size)
    centre = farthest_centre(points, reach, facing)
    assert (np.linalg.norm(points - centre, axis=1) <= reach + 1e-6).all()
    for turn in np.linspace(-1.5, 1.5, 31):
        on = [np.cos(angle + np.pi + turn), np.sin(angle + np.pi + turn)]
        moved = centre + 1e-3 * np.array(on)
        assert (np.linalg.norm(points - moved, axis=1) > reach - 1e-6).any()


def test_a_side_is_nearly_as_flat_as_the_body():
    """A bar of 10 by 6 cm, whose 10 cm face the other leg: 3 cm away, not 5.8."""
    bar = points_of(coal.Box(0.1, 0.06, 0.4), around=True)
    towards = np.array([0.0, 1.0, 0.0])
    assert bounding_capsule(bar, NOWHERE, NOWHERE).reach(towards) == pytest.approx(
        np.hypot(0.05, 0.03)
    )
    radius = 3.0 * np.hypot(0.05, 0.03)
    middle = 0.03 - np.sqrt(radius**2 - 0.05**2)  # a circle through two corners
    assert bounding_capsule(bar, NOWHERE, towards).reach(towards) == pytest.approx(middle + radius)


def test_a_body_that_points_to_the_other_leg_is_not_widened():
    bar, along = points_of(coal.Box(0.1, 0.5, 0.06), around=True), np.array([0.0, 1.0, 0.0])
    np.testing.assert_allclose(bounding_capsule(bar, NOWHERE, along).radius, np.hypot(0.05, 0.03))


def test_a_ball_and_a_capsule_cover_themselves():
    ball = bounding_capsule(points_of(coal.Sphere(0.07), around=True), NOWHERE, NOWHERE)
    assert (ball.radius, np.linalg.norm(ball.end - ball.start)) == pytest.approx((0.07, 0.0))
    long = bounding_capsule(points_of(coal.Capsule(0.05, 0.4), around=True), NOWHERE, NOWHERE)
    assert long.radius == pytest.approx(0.05)
    np.testing.assert_allclose(np.abs([long.start[2], long.end[2]]), 0.2)
    assert long.volume == pytest.approx(np.pi * 0.05**2 * (0.4 + 4.0 / 3.0 * 0.05))


def test_a_bar_is_covered_along_its_length():
    bar = bounding_capsule(points_of(coal.Box(0.03, 0.5, 0.04), around=True), NOWHERE, NOWHERE)
    assert bar.radius == pytest.approx(0.025)  # half of the diagonal of 3 by 4 cm
    np.testing.assert_allclose(np.abs(bar.end - bar.start), [0.0, 0.5, 0.0], atol=1e-12)


def test_another_direction_may_be_better():
    """Points whose principal axes are none of a capsule's: the given one is tried too."""
    points = Points(
        np.array([[0.0, 0, 0], [0, 0, 1.0], [0.1, 0, 1.0], [0, 0.05, 1.0]]), np.zeros(4)
    )
    along = np.array([0.0, 0.0, 3.0])
    assert (
        bounding_capsule(points, along, NOWHERE).volume
        <= bounding_capsule(points, NOWHERE, NOWHERE).volume
    )


SHAPES = (
    coal.Box(0.1, 0.2, 0.4),
    coal.Cylinder(0.1, 0.5),
    coal.Cone(0.1, 0.5),
    coal.Ellipsoid(0.1, 0.2, 0.3),
    coal.Sphere(0.1),
    coal.Capsule(0.1, 0.5),
)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
def test_every_shape_is_inside_its_cover(shape):
    """Coal finds no point of the shape on a plane that touches the cover from outside."""
    found = bounding_capsule(points_of(shape, around=True), NOWHERE, NOWHERE)
    for direction in np.random.default_rng(1).normal(size=(50, 3)):
        n = direction / np.linalg.norm(direction)
        reach = max(found.start @ n, found.end @ n) + found.radius
        beyond = coal.Halfspace(-n, -reach - 1e-6)
        result = coal.CollisionResult()
        place = coal.Transform3s()
        assert coal.collide(shape, place, beyond, place, coal.CollisionRequest(), result) == 0


def test_meshes_are_covered_by_their_vertices():
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(1, 3)
    corners = np.array([[0.0, 0, 0], [0.3, 0, 0], [0.0, 0.1, 0.02]])
    mesh.addVertices(corners)
    mesh.addTriangle(*corners)
    mesh.endModel()
    found = bounding_capsule(points_of(mesh, around=True), NOWHERE, NOWHERE)
    assert outside(found, Points(corners, np.zeros(3))) < 1e-9
    assert found.radius < 0.06


def test_flat_crowds_are_covered_too():
    plate = np.column_stack([np.random.default_rng(0).uniform(size=(200, 2)), np.zeros(200)])
    points = Points.together([Points(plate, np.zeros(200))])
    assert outside(bounding_capsule(points, NOWHERE, NOWHERE), points) < 1e-9
