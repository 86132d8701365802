"""Collision and visual shapes as balls whose convex hull they are; those of a foot together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.importers.source import Source
from gaitopt.nlp import Array

_ON = 64  # corners of the polygon in a circle
_AROUND = 24  # of the polygon around one: it is at most 1 % too wide
_RINGS = 24  # of points on an ellipsoid
_HULL = 50  # more points than these are first thinned to the corners of their hull


@dataclass(frozen=True)
class Points:
    """Balls whose convex hull is a shape.

    Attributes:
        centres: shape (P, 3) [m].
        radii: shape (P,) [m]; zero for the corners of a polyhedron.
    """

    centres: Array
    radii: Array

    def placed(self, placement: pin.SE3) -> Points:
        """Return them in the frame in which `placement` is given."""
        return Points(
            self.centres @ np.array(placement.rotation).T + placement.translation, self.radii
        )

    @classmethod
    def joined(cls, parts: Sequence[Points]) -> Points:
        """Return those of several shapes, at least one."""
        return cls(
            np.concatenate([p.centres for p in parts]), np.concatenate([p.radii for p in parts])
        )

    @classmethod
    def together(cls, parts: Sequence[Points]) -> Points:
        """Return those of several shapes, without points that are inside."""
        whole = cls.joined(parts)
        if len(whole.centres) > _HULL and not whole.radii.any():
            from scipy.spatial import ConvexHull, QhullError  # slow to import, and seldom needed

            try:
                corners = ConvexHull(whole.centres).vertices
            except QhullError:  # flat
                return whole
            return cls(whole.centres[corners], whole.radii[corners])
        return whole


class PlacedShape(NamedTuple):
    """A shape of a link, what it is, as "box" or "mesh", and its points in a frame."""

    link: str
    title: str
    points: Points


def placed_shapes(
    source: Source, kind: pin.GeometryType, links: Mapping[str, pin.SE3], *, around: bool
) -> list[PlacedShape]:
    """Return the shapes of some links; missing meshes and shapes without points have none.

    Args:
        links: by name, their placements in the frames in which the points are wanted.

    Raises:
        RobotError: a mesh file is there, but is not one that can be read.
    """
    geometry, whole = source.geometry(kind, set(links)), source.model()
    shapes = []
    for item in () if geometry is None else geometry.geometryObjects:
        link = whole.frames[item.parentFrame]
        points = points_of(item.geometry, around=around) if link.name in links else None
        if points is not None:
            placement = links[link.name] * link.placement.inverse() * item.placement
            shapes.append(PlacedShape(str(link.name), _title(item), points.placed(placement)))
    return shapes


def points_of(shape: coal.CollisionGeometry, *, around: bool) -> Points | None:
    """Return points of a shape in its frame, on what is round or `around` it, or None."""
    if isinstance(shape, coal.Box):
        return box_points(np.ravel(shape.halfSide))
    if isinstance(shape, coal.Sphere):
        return _balls(np.zeros((1, 3)), shape.radius)
    if isinstance(shape, coal.Capsule):
        half = np.array([0.0, 0.0, shape.halfLength])
        return _balls(np.array([-half, half]), shape.radius)
    if isinstance(shape, coal.Cylinder):
        return _balls(_rims(shape.radius, (-shape.halfLength, shape.halfLength), around))
    if isinstance(shape, coal.Cone):
        tip = np.array([[0.0, 0.0, shape.halfLength]])
        return _balls(np.concatenate([tip, _rims(shape.radius, (-shape.halfLength,), around)]))
    if isinstance(shape, coal.Ellipsoid):
        return _balls(_ball(around) * np.ravel(shape.radii))
    if isinstance(shape, coal.BVHModelBase):
        return _balls(np.array(shape.vertices()))
    if isinstance(shape, coal.ConvexBase):
        return _balls(np.array([shape.point(k) for k in range(shape.num_points)]))
    return None


def _title(item: pin.GeometryObject) -> str:
    name = type(item.geometry).__name__
    return "mesh" if name.startswith(("BVH", "Convex")) else name.lower()


def _balls(centres: Array, radius: float = 0.0) -> Points:
    return Points(centres, np.full(len(centres), float(radius)))


def box_points(half: Array) -> Points:
    """Return the corners of a box from half its sides [m], shape (3,)."""
    signs = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
    return _balls(signs * half)


def _rims(radius: float, heights: Sequence[float], around: bool) -> Array:
    """Return the corners of a regular polygon on or around a circle, at each height."""
    sides = _AROUND if around else _ON
    angles = 2.0 * np.pi * np.arange(sides) / sides
    r = radius / np.cos(np.pi / sides) if around else radius
    circle = np.column_stack([r * np.cos(angles), r * np.sin(angles)])
    return np.concatenate([np.column_stack([circle, np.full(sides, z)]) for z in heights])


def _ball(around: bool) -> Array:
    """Return points on the unit sphere, its poles among them, or a little outside."""
    polar = np.pi * np.arange(_RINGS + 1) / _RINGS
    azimuth = np.pi * np.arange(2 * _RINGS) / _RINGS
    theta, phi = (a.ravel() for a in np.meshgrid(polar, azimuth))
    points = np.column_stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]
    )
    # No direction is farther from a point than half the diagonal of a cell at the equator.
    return points / np.cos(np.pi / (np.sqrt(2.0) * _RINGS)) if around else points


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


def foot_points(
    source: Source, model: pin.Model, foot_joint: int, toes: Mapping[int, pin.SE3] | None = None
) -> FootShape | None:
    """Return the shape of all links that the last joint of a leg carries.

    The collision geometry, where there is none what is drawn, None where there is neither.

    Args:
        model: of the source, or one made from it by locking joints; links keep their names.
        toes: placements in that joint of others beyond it that stand still.

    Raises:
        RobotError: a mesh file of the foot cannot be read.
    """
    places = {foot_joint: pin.SE3.Identity(), **(toes or {})}
    links = {
        str(frame.name): places[frame.parentJoint] * frame.placement
        for frame in model.frames
        if frame.parentJoint in places and frame.type == pin.FrameType.BODY
    }
    for kind in (pin.GeometryType.COLLISION, pin.GeometryType.VISUAL):
        shapes = placed_shapes(source, kind, links, around=False)
        if shapes:
            points = Points.joined([shape.points for shape in shapes])
            parts = tuple(f"{shape.title} of '{shape.link}'" for shape in shapes)
            return FootShape(points.centres, points.radii, kind.name.lower(), parts)
    return None
