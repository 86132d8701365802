"""The shape of a foot: everything its last joint carries, as points that may be round."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin

from gaitopt.nlp import Array
from gaitopt.robot.source import Source

_RIM = 64  # points on the rim of a cylinder or a cone; the corners of a regular polygon
_BALL = 24  # rings of points on an ellipsoid


@dataclass(frozen=True)
class FootShape:
    """A foot in the frame of the last joint of its leg.

    Attributes:
        points: corners of boxes and meshes, centres of spheres, ends of capsules [m], shape (n, 3).
        radii: of the balls about the points, 0 for corners [m], shape (n,).
        kind: of the geometry the points are from: "collision" or "visual".
        parts: what they are from, as "box of 'left_foot'".
    """

    points: Array
    radii: Array
    kind: str
    parts: tuple[str, ...]

    @property
    def how(self) -> str:
        """Where the shape came from, as "collision geometry: box of 'left_foot'"."""
        counts = {part: self.parts.count(part) for part in self.parts}
        named = [part if n == 1 else f"{n} x {part}" for part, n in counts.items()]
        return f"{self.kind} geometry: {', '.join(named)}"


def foot_points(source: Source, model: pin.Model, foot_joint: int) -> FootShape | None:
    """Return the shape of all links that the last joint of a leg carries.

    Args:
        source: the robot's description.
        model: its model, or one made from it by locking joints; links keep their names.
        foot_joint: id of the joint in `model`.

    Returns:
        The collision geometry, where there is none what is drawn, None where there is neither.

    Raises:
        RobotError: a mesh file of the foot cannot be read.
    """
    links = {
        str(frame.name): frame.placement
        for frame in model.frames
        if frame.parentJoint == foot_joint and frame.type == pin.FrameType.BODY
    }
    for kind in (pin.GeometryType.COLLISION, pin.GeometryType.VISUAL):
        geometry = source.geometry(kind, set(links))
        if geometry is None:
            continue
        shape = _joined(source.model(), geometry, links, kind.name.lower())
        if shape is not None:
            return shape
    return None


def _joined(
    whole: pin.Model, geometry: pin.GeometryModel, links: dict[str, pin.SE3], kind: str
) -> FootShape | None:
    points, radii, parts = [np.empty((0, 3))], [np.empty(0)], []
    for item in geometry.geometryObjects:
        link = whole.frames[item.parentFrame]
        if link.name not in links:
            continue
        found = _shape_points(item.geometry)
        if found is None:
            continue
        placement = links[link.name] * link.placement.inverse() * item.placement
        points.append(found[0] @ placement.rotation.T + placement.translation)
        radii.append(np.full(len(found[0]), found[1]))
        parts.append(f"{_title(item)} of '{link.name}'")
    if not parts:
        return None
    return FootShape(np.concatenate(points), np.concatenate(radii), kind, tuple(parts))


def _shape_points(shape: coal.CollisionGeometry) -> tuple[Array, float] | None:
    """Return points of a shape in its own frame and their common radius; None if it has none."""
    if isinstance(shape, coal.Box):
        return _grid(np.asarray(shape.halfSide).ravel()), 0.0
    if isinstance(shape, coal.Sphere):
        return np.zeros((1, 3)), float(shape.radius)
    if isinstance(shape, coal.Capsule):
        half = np.array([0.0, 0.0, shape.halfLength])
        return np.array([half, -half]), float(shape.radius)
    if isinstance(shape, coal.Cylinder):
        return _rims(shape.radius, (shape.halfLength, -shape.halfLength)), 0.0
    if isinstance(shape, coal.Cone):
        tip = np.array([[0.0, 0.0, shape.halfLength]])
        return np.concatenate([tip, _rims(shape.radius, (-shape.halfLength,))]), 0.0
    if isinstance(shape, coal.Ellipsoid):
        return _ball() * np.asarray(shape.radii).ravel(), 0.0
    if isinstance(shape, coal.BVHModelBase):
        return np.array(shape.vertices()), 0.0
    if isinstance(shape, coal.ConvexBase):
        return np.array([shape.point(k) for k in range(shape.num_points)]), 0.0
    return None


def _title(item: pin.GeometryObject) -> str:
    name = type(item.geometry).__name__
    return "mesh" if name.startswith(("BVH", "Convex")) else name.lower()


def _grid(half: Array) -> Array:
    signs = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
    return np.asarray(signs * half)


def _rims(radius: float, heights: Sequence[float]) -> Array:
    angles = 2.0 * np.pi * np.arange(_RIM) / _RIM
    circle = np.column_stack([radius * np.cos(angles), radius * np.sin(angles)])
    return np.concatenate([np.column_stack([circle, np.full(_RIM, z)]) for z in heights])


def _ball() -> Array:
    """Return points on the unit sphere, its poles among them."""
    polar = np.pi * np.arange(_BALL + 1) / _BALL
    around = np.pi * np.arange(2 * _BALL) / _BALL
    theta, phi = (a.ravel() for a in np.meshgrid(polar, around))
    return np.column_stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]
    )
