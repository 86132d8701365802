import coal
import numpy as np
import pinocchio as pin
import pytest

from gaitopt.view.robot_shapes import capsule, draw_shape
from gaitopt.view.viewer import Node, RecordingWindow, umsgpack


def drawn(shape, colour=(0.2, 0.4, 0.6, 1.0)):
    """The object that one shape becomes, with the path of its node."""
    item = pin.GeometryObject("part", 0, pin.SE3.Identity(), shape)
    item.meshColor = np.array(colour)
    recorder = RecordingWindow()
    draw_shape(Node(recorder)["robot"], "shin", item, pin.SE3.Identity())
    commands = [umsgpack.unpackb(c) for c in recorder.commands]
    (made,) = [c for c in commands if c["type"] == "set_object"]
    assert made["path"] == commands[-1]["path"] == "/meshcat/robot/shin/part"
    return made["object"]


@pytest.mark.parametrize(
    ("shape", "kind", "sizes"),
    [
        (coal.Box(0.1, 0.2, 0.3), "Box", {"width": 0.1, "height": 0.2, "depth": 0.3}),
        (coal.Sphere(0.7), "Sphere", {"radius": 0.7}),
        (coal.Cylinder(0.2, 0.9), "Cylinder", {"radiusTop": 0.2, "height": 0.9}),
        (coal.Cone(0.2, 0.9), "Cylinder", {"radiusTop": 0.0, "radiusBottom": 0.2, "height": 0.9}),
        (coal.Capsule(0.1, 0.5), "Buffer", {}),
        (coal.Ellipsoid(0.1, 0.2, 0.3), "Sphere", {"radius": 1.0}),
    ],
)
def test_simple_shapes_keep_their_size(shape, kind, sizes):
    (made,) = drawn(shape)["geometries"]
    assert made["type"] == f"{kind}Geometry"
    assert {name: made[name] for name in sizes} == pytest.approx(sizes)


def test_shapes_keep_colour_and_opacity():
    (solid,) = drawn(coal.Sphere(0.1))["materials"]
    (clear,) = drawn(coal.Sphere(0.1), (1.0, 0.0, 0.0, 0.25))["materials"]
    assert (solid["color"], solid["opacity"], solid["transparent"]) == (0x336699, 1.0, False)
    assert (clear["color"], clear["opacity"], clear["transparent"]) == (0xFF0000, 0.25, True)


def test_a_capsule_has_its_surface_and_looks_outward():
    radius, half = 0.3, 0.5
    corners, faces = capsule(radius, half)
    axis = np.zeros_like(corners)
    axis[:, 2] = np.clip(corners[:, 2], -half, half)
    assert np.linalg.norm(corners - axis, axis=1) == pytest.approx(radius)
    a, b, c = corners[faces].transpose(1, 0, 2)
    volume = np.sum(a * np.cross(b, c)) / 6.0  # positive: seen from outside, against the clock
    exact = np.pi * radius**2 * (2.0 * half + 4.0 / 3.0 * radius)
    assert 0.98 * exact < volume < exact


def test_an_ellipsoid_is_a_stretched_sphere():
    stretch = np.reshape(drawn(coal.Ellipsoid(0.1, 0.2, 0.3))["object"]["matrix"], (4, 4))
    assert stretch == pytest.approx(np.diag([0.1, 0.2, 0.3, 1.0]))
