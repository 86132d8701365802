"""The scene with the walking robot: ground, footprints, robot, centre of pressure and force.

MeshCat animates position, orientation and scale of a node; the force arrow is a shaft that is
stretched and a head that is moved, so its length is the force. Its camera turns about the origin
of the scene only, so that to follow the robot the world is moved the other way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from gaitopt.gait.result import Gait
from gaitopt.nlp import Array
from gaitopt.view.body import walking_model
from gaitopt.view.meshcat_quiet import geometry, meshcat
from gaitopt.view.moving_robot import draw_robot
from gaitopt.view.shape_nodes import UPRIGHT
from gaitopt.view.shapes import robot_shapes
from gaitopt.view.skeleton import sole_corners, stick_figures
from gaitopt.view.tracks import Film
from gaitopt.view.walk import Walk, walk

_WORLD = "world"
CAMERA = (1.9, 0.6, 2.05)  # from what it looks at, in heights of the hips: ahead, up, right
TARGET_HEIGHT = 0.92  # of the point the camera looks at, in heights of the hips
_ARROW = 0.9  # the weight's arrow, about, in heights of the hips
_SWITCH = 1e-4  # s: marks leave the old foot this long before they are on the new one
_PRINT = 0.004  # m: thickness of the marks on the ground
_BORDER = 0.05  # m: by how much the mark of the standing foot is larger than its sole
_GROUND_SIZE = 20.0  # m, square
_GRID = 0.5  # m between the lines on the ground
_GROUND, _LINE, _FOOTPRINT = 0xEDF0F2, 0xC9D1D8, 0x9DB4C8
_STANDING, _COP, _FORCE = 0x2E9E5B, 0xB00020, 0xE07A10


@dataclass(frozen=True)
class Scene:
    """What was put into a viewer.

    Attributes:
        walk: that is shown.
        force_scale: metres of arrow for 1 N.
        note: what of the robot is missing and how to get it, or empty.
    """

    walk: Walk
    force_scale: float
    note: str


def build_scene(
    viewer: meshcat.Visualizer, gait: Gait, steps: int, package_dirs: tuple[str, ...] = ()
) -> Scene:
    """Put the walking robot into a MeshCat viewer and set it in motion.

    Args:
        viewer: an empty one.
        gait: one step.
        steps: how many to show; then the film starts again.
        package_dirs: where to look for meshes.

    Returns:
        What is shown.

    Raises:
        InputError: steps < 1.
        RobotError: the robot cannot be drawn.
    """
    model = walking_model(gait)
    film, shown = Film(), walk(gait, model, steps)
    shapes = robot_shapes(gait, model, package_dirs)
    times = _key_times(shown)
    corners = sole_corners(gait, model)
    hips = hip_height(gait, model, shown)
    force_scale = _force_scale(gait, hips)
    _prepare(viewer, hips)
    world = viewer[_WORLD]
    _draw_ground(world["ground"])
    _draw_footprints(world["footprints"], shown, corners)
    draw_robot(world["robot"], film, model, shapes.geometry, shown, times)
    _draw_standing_sole(world["standing_sole"], film, shown, corners, times)
    _draw_force(world["ground_force"], film, shown, times, force_scale)
    _follow(world, film, shown, times, TARGET_HEIGHT * hips)
    film.show(viewer)
    return Scene(shown, force_scale, shapes.note)


def hip_height(gait: Gait, model: pin.Model, shown: Walk) -> float:
    """Return the height of the hips at the beginning of a walk [m]: the size of the robot."""
    legs = stick_figures(gait, model, shown.q[:1]).legs
    return float(legs[0, :, 5, 2].mean())


def _force_scale(gait: Gait, hips: float) -> float:
    """Return metres of arrow for 1 N: 10 cm for 1, 2 or 5 times a power of ten."""
    force = float(gait.ground_wrench[:, 2].mean())
    exact = 0.1 * force / (_ARROW * hips)  # N for 10 cm
    power = 10.0 ** np.floor(np.log10(exact))
    return 0.1 / float(
        min((power * n for n in (1, 2, 5, 10)), key=lambda n: abs(np.log(n / exact)))
    )


def _key_times(shown: Walk) -> Array:
    """Return the frame times, the last of each step a moment earlier: keys must increase."""
    last = np.append(np.diff(shown.step) > 0, False)
    return np.asarray(shown.time - _SWITCH * last)


def _prepare(viewer: meshcat.Visualizer, hips: float) -> None:
    viewer["/Background"].set_property("top_color", [0.97, 0.98, 1.0])
    viewer["/Background"].set_property("bottom_color", [0.80, 0.84, 0.88])
    for name in ("/Axes", "/Grid"):  # they would not move with the world
        viewer[name].set_property("visible", False)
    viewer["/Cameras/default/rotated/<object>"].set_property("position", [hips * c for c in CAMERA])


def _draw_ground(node: meshcat.Visualizer) -> None:
    plain = _painted(node["plane"], geometry.MeshBasicMaterial, _GROUND, layer=-3)
    node["plane"].set_object(geometry.Box([_GROUND_SIZE, _GROUND_SIZE, 0.01]), plain)
    node["plane"].set_transform(_shift([0.0, 0.0, -0.5 * 0.01]))
    # Short pieces: software renderers drop a line with one end behind the camera.
    at = np.arange(-_GROUND_SIZE / 2.0, _GROUND_SIZE / 2.0, _GRID)
    x, y = (c.ravel() for c in np.meshgrid(at, at))
    zero = np.zeros_like(x)
    along_x = np.stack([[x, y, zero], [x + _GRID, y, zero]], axis=-1)
    along_y = np.stack([[x, y, zero], [x, y + _GRID, zero]], axis=-1)
    lines = np.concatenate([along_x, along_y], axis=1).reshape(3, -1)
    points = geometry.PointsGeometry(lines.astype(np.float32))
    material = _painted(node["grid"], geometry.LineBasicMaterial, _LINE, layer=-2)
    node["grid"].set_object(geometry.LineSegments(points, material))


def _painted(
    node: meshcat.Visualizer, kind: type[geometry.Material], colour: int, layer: int
) -> geometry.Material:
    """Return a material for marks on the ground: painted in layers, never hiding what stands there.

    All of them lie in one plane, which depth alone would not tell apart.
    """
    node.set_property("renderOrder", layer)
    return kind(color=colour, depthWrite=False)


def _draw_footprints(node: meshcat.Visualizer, shown: Walk, corners: Array) -> None:
    size = [*np.ptp(corners, axis=0)[:2], _PRINT]
    for number, place in enumerate(shown.stance):
        print_ = node[str(number)]
        material = _painted(print_, geometry.MeshBasicMaterial, _FOOTPRINT, layer=-1)
        print_.set_object(geometry.Box(size), material)
        print_.set_transform(place.homogeneous @ _shift(_centre(corners, number, -0.5 * _PRINT)))


def _draw_standing_sole(
    node: meshcat.Visualizer, film: Film, shown: Walk, corners: Array, times: Array
) -> None:
    size = np.ptp(corners, axis=0)[:2] + _BORDER
    material = geometry.MeshBasicMaterial(color=_STANDING)
    node.set_object(geometry.Box([*size, _PRINT]), material)
    centres = [p.act(_centre(corners, k, -0.49 * _PRINT)) for k, p in enumerate(shown.stance)]
    film.place(node, times, np.array(centres)[shown.step])
    film.turn(node, times, [shown.stance[k].rotation for k in shown.step])


def _draw_force(
    node: meshcat.Visualizer, film: Film, shown: Walk, times: Array, scale: float
) -> None:
    red, orange = _seen_through(_COP), _seen_through(_FORCE)
    node["cop"].set_object(geometry.Sphere(0.016), red)
    # inside its group the arrow points along z
    node["shaft/bar"].set_object(geometry.Cylinder(1.0, 0.009), orange)
    node["shaft/bar"].set_transform(_shift([0.0, 0.0, 0.5]) @ UPRIGHT)
    node["head/cone"].set_object(geometry.Cylinder(0.07, radiusTop=0.0, radiusBottom=0.024), orange)
    node["head/cone"].set_transform(_shift([0.0, 0.0, 0.035]) @ UPRIGHT)
    length = scale * np.linalg.norm(shown.force, axis=1)
    along, one = np.outer(length, [0.0, 0.0, 1.0]), np.ones_like(length)
    film.place(node, times, shown.cop)
    film.turn(node, times, [_towards(f) for f in shown.force])
    film.stretch(node["shaft"], times, np.column_stack([one, one, np.maximum(length, 1e-6)]))
    film.place(node["head"], times, along)


def _seen_through(colour: int) -> geometry.Material:
    """Return a material that the robot in front of it does not hide."""
    return geometry.MeshBasicMaterial(
        color=colour, opacity=0.85, transparent=True, depthTest=False, depthWrite=False
    )


def _follow(
    world: meshcat.Visualizer, film: Film, shown: Walk, times: Array, height: float
) -> None:
    """Move the world back at the mean walking speed, so that the robot stays in the picture."""
    root = shown.q[:, :2]
    share = shown.time / shown.time[-1]
    x = root[0, 0] + share * (root[-1, 0] - root[0, 0])
    y = np.full_like(x, root[:, 1].mean())
    path = np.column_stack([x, y, np.full_like(x, height)])
    world.set_transform(_shift(-path[0]))
    film.place(world, times, -path)


def _centre(corners: Array, step: int, height: float) -> Array:
    """Return the middle of the standing sole in its frame; odd steps stand on the other foot."""
    x, y, _ = corners.mean(axis=0)
    return np.array([x, y if step % 2 == 0 else -y, height])


def _towards(force: Array) -> Array:
    """Return the rotation that turns z into the direction of a force."""
    size = float(np.linalg.norm(force))
    up = np.array([0.0, 0.0, 1.0])
    return np.array(pin.Quaternion.FromTwoVectors(up, force / size if size > 0.0 else up).matrix())


def _shift(offset: ArrayLike) -> Array:
    matrix = np.eye(4)
    matrix[:3, 3] = np.asarray(offset, dtype=np.float64)
    return matrix
