"""The sole of a foot, found from its shape: its lower face, and the rectangle in it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.importers.source import Source
from gaitopt.model.kinematic_tree import angle_between
from gaitopt.model.scales import REACH
from gaitopt.model.sole import Sole, tidy
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


MOST_TILTED = 0.6435
"""Largest tilt of a face that may be the sole [rad]."""

_LEVEL = 0.05  # rad: a foot tilted by less is flat, and its mesh rounded
_LOOKS_DOWN = float(np.cos(MOST_TILTED))
_SAME_FACE = 0.02  # rad: triangles of one face differ by rounding of the mesh
_EXACT = 1e-3  # rad: and where all its points lie in one plane
_THIN = 1e-6  # of their extent: points this near to a plane lie in it
_WIDE = 1e-3  # of their extent: and points this near to a line do not tell a plane
_SHARE = 0.5  # of all that looks down: a face must be that large to be the sole
_FLATNESS = 0.01  # of the foot's length: what lies less above the lowest point belongs to the sole
_SMALLEST = 5e-4 / REACH**2  # of the leg's length squared: less is an edge or a stud, not a sole
_LONG = 0.8  # of the foot's length: a sole shorter than that is told
_FULL = 0.9  # of the flat part: what the rectangle must hold to be the only one shown
_NEARLY = 0.9  # of the length or the width of the flat part
_LEANS = 2e-3  # rad: a tilt worth a word
_DIFFERENT = 0.01  # of its length: soles that differ by more from side to side deserve a word
_SHORTEST = 1e-6  # of the extent: of an edge, so that the logarithm of the area exists
_STRAIGHT = 1e-14  # of the extent, squared: a corner that turns by less is none
_FEW = 16  # points: the planes of each three of them are tried
_ON_FACE = 1e-10  # of the extent: points this near to a face are on it
_NEWTON_STEPS = 50
_ARRIVED = 1e-12  # of the extent: of a step
_STIFF = 1e-9  # of the curvature: least one
_DOWN = np.array([0.0, 0.0, -1.0])
_ADVICE = (
    "give the sole rectangle (--sole, or [sole] in the file for --choices) and the height of the "
    "ankle above it (sole_drop there)"
)

Edges = tuple[float, float, float, float]
"""Toe, heel, left and right edge: largest x, smallest x, largest y, smallest y [m]."""
_Box = tuple[float, float, float, float, float]  # edges and height


@dataclass(frozen=True)
class FoundSole:
    """A sole found from the shape of a foot.

    Attributes:
        placement: of the sole frame (x forward, y left, z up, origin on the sole below the ankle)
            in the frame of the last joint of the leg.
        sole: the rectangle in it.
        how: one sentence: where it came from, its size, what was left out.
        share: of the flat part under the foot that is in the rectangle.
        others: other rectangles that suit the flat part, by name, where the largest leaves out
            more than a tenth of it.
    """

    placement: pin.SE3
    sole: Sole
    how: str
    share: float = 1.0
    others: tuple[tuple[str, Sole], ...] = ()


@dataclass(frozen=True)
class Rectangle:
    """The right sole at the reference posture in the pelvis frame [m].

    Attributes:
        toe, heel, left, right: edges along x and y.
        height: of its plane [m].
        how: where it came from, in words.
        doubts: what deserves a look, in words.
        share: of the flat part under the foot that it holds.
        others: other rectangles, by name.
    """

    toe: float
    heel: float
    left: float
    right: float
    height: float
    how: str
    doubts: tuple[str, ...] = ()
    share: float = 1.0
    others: tuple[tuple[str, Rectangle], ...] = ()

    def seen_from(self, origin: Array) -> tuple[Sole, tuple[str, ...]]:
        """Return the sole seen from there [m], shape (3,), and a warning if it lost much.

        It is as wide to the left as to the right.

        Raises:
            RobotError: the sole frames lie beside the soles.
        """
        x, y = float(origin[0]), float(origin[1])
        half = min(self.left - y, y - self.right)
        lost = (self.left - self.right) - 2.0 * half
        words = (
            f"{lost * 1e3:.1f} mm of the soles' width are not used: the sole frames are not in "
            "the middle of the soles",
        )
        if half <= 0.0:
            raise RobotError(
                "the sole frames lie beside the soles; leave them out, or correct them"
            )
        sole = Sole(*(tidy(v) for v in (self.toe - x, self.heel - x, half, -half)))
        return sole, words if lost > _DIFFERENT * (self.toe - self.heel) else ()


def find_sole(shape: FootShape, upright: Array, ankle: Array, leg: float = REACH) -> FoundSole:
    """Find the largest rectangle in the flat part under a foot.

    The flat part is the convex hull of all points less than 1 % of the foot's length above the
    lowest one; toes and heels that curve up are not part of it. The rectangle has its edges along x
    and y.

    Args:
        upright: columns forward, left and up of the standing foot in the frame of its joint,
            shape (3, 3).
        ankle: its centre in that frame [m], shape (3,).
        leg: its length from hip to ankle [m].

    Raises:
        RobotError: the flat part is smaller than 5 cm² below a leg of 0.6 m, or as much of another:
            an edge, a stud or a ball.
    """
    rotation = np.array(upright, dtype=float)
    points = shape.points @ rotation
    below = points[:, 2] - shape.radii
    height = float(below.min())
    whole = float(np.ptp(points[:, 0]))
    near = _FLATNESS * (whole + 2.0 * float(shape.radii.max()))
    flat = points[below < height + near, :2]
    toe, heel, left, right = largest_rectangle(flat)
    smallest = _SMALLEST * leg**2
    if (toe - heel) * (left - right) < smallest:
        raise RobotError(
            f"no sole was found under the foot: the part within {near * 1e3:.2g} mm of its "
            f"lowest point holds a rectangle of {(toe - heel) * 1e3:.1f} x "
            f"{(left - right) * 1e3:.1f} mm only, less than {smallest * 1e4:.3g} cm² "
            f"({shape.how}); {_ADVICE}{_leaning(shape, points)}"
        )
    x, y, z = (float(v) for v in np.asarray(ankle, dtype=float) @ rotation)

    def seen(edges: Edges) -> Sole:
        return Sole(*(tidy(v) for v in np.subtract(edges, (x, x, y, y))))

    sole = seen((toe, heel, left, right))
    share = (toe - heel) * (left - right) / _area(convex_polygon(flat))
    origin = rotation @ np.array([x, y, tidy(height)])
    how = (
        f"{(toe - heel) * 1e3:.1f} x {(left - right) * 1e3:.1f} mm, {(z - height) * 1e3:.1f} mm "
        f"below the ankle, from {shape.how}"
    )
    if toe - heel < _LONG * whole:
        how += (
            f"; the foot is {whole * 1e3:.0f} mm long, rounded or raised at its ends: give a "
            "larger rectangle (sole) if they carry"
        )
    if _is_wider(left - right, toe - heel):
        how += "; wider than long: see whether the mesh lies turned, or give the rectangle (sole)"
    others = _other_rectangles(flat) if share < _FULL else {}
    candidates = tuple((name, seen(edges)) for name, edges in others.items() if _has_area(edges))
    return FoundSole(pin.SE3(rotation, origin), sole, how, share, candidates)


def common_rectangle(
    found: tuple[FoundSole | None, FoundSole | None], places: tuple[pin.SE3, pin.SE3]
) -> Rectangle | None:
    """Return the part of the right sole whose mirror image is part of the left one.

    Raises:
        RobotError: the soles have nothing in common.
    """
    seen = [(f, p, s) for s, (f, p) in enumerate(zip(found, places, strict=True)) if f is not None]
    if not seen:
        return None
    boxes = np.array([_box(sole.sole, sole, place, side) for sole, place, side in seen])
    gap = float(np.ptp(boxes, axis=0).max())
    doubts = []
    if gap > _DIFFERENT * (boxes[:, 0] - boxes[:, 1]).max():
        doubts.append(
            f"the soles of the two feet differ by {gap * 1e3:.1f} mm; the common part counts"
        )
    if _is_wider((boxes[:, 2] - boxes[:, 3]).max(), (boxes[:, 0] - boxes[:, 1]).max()):
        doubts.append(
            "the feet are wider than they are long: their shapes may be turned, or the heading "
            "wrong; give the sole rectangle (--sole), or --forward"
        )
    edges = _common(boxes)
    if not _has_area(edges):
        raise RobotError(
            "the soles of the two feet, mirrored onto each other, have nothing in common: the "
            f"right one {_reach(boxes[0])} (forward and left), the left one then "
            f"{_reach(boxes[1])}; correct the shapes of the feet, or give the sole rectangle "
            "(--sole) and sole_drop in the file for --choices"
        )
    how, share = seen[0][0].how, min(sole.share for sole, _, _ in seen)
    others = []
    for name in dict.fromkeys(name for sole, _, _ in seen for name, _ in sole.others):
        candidates = [(dict(sole.others).get(name, sole.sole), sole, p, s) for sole, p, s in seen]
        other = _common(np.array([_box(*candidate) for candidate in candidates]))
        if _has_area(other):
            others.append((name, Rectangle(*other, how)))
    return Rectangle(*edges, how, tuple(doubts), share, tuple(others))


def _reach(box: Array) -> str:
    """Say where the edges of a box lie."""
    toe, heel, left, right = (f"{1e3 * float(edge):.0f}" for edge in box[:4])
    return f"lies at x {heel} to {toe} mm and y {right} to {left} mm"


def _has_area(box: Edges | _Box) -> bool:
    return box[0] > box[1] and box[2] > box[3]


def _is_wider(width: float, length: float) -> bool:
    """Whether a rectangle is wider than long; that in a disk is as wide, but for rounding."""
    return bool(width > length * (1.0 + _SHORTEST))


def _common(boxes: Array) -> _Box:
    """Edges of the part that one or two boxes have in common, and their mean height."""
    low, high = boxes.min(axis=0), boxes.max(axis=0)
    mean = (boxes[0, 4] + boxes[-1, 4]) / 2.0
    return float(low[0]), float(high[1]), float(low[2]), float(high[3]), float(mean)


def _box(sole: Sole, found: FoundSole, place: pin.SE3, side: int) -> Array:
    """Edges and height in the pelvis frame, of the left foot mirrored to the right, shape (5,)."""
    frame = place * found.placement
    corners = np.array([frame.act(corner) for corner in sole.corners])
    if side == 1:
        corners[:, 1] *= -1.0
    (x, y, z), (low_x, low_y, low_z) = corners.max(axis=0), corners.min(axis=0)
    return np.array([x, low_x, y, low_y, (z + low_z) / 2.0])


def sole_normal(points: Array, down: Array, radii: Array | None = None) -> Array | None:
    """Return the outward normal of a foot's lower face where it is not level, shape (3,).

    None if the face looks straight down, or if there is none; see `lowest_face`.

    Args:
        points: of the foot [m], shape (n, 3).
        down: unit vector, shape (3,).
        radii: of balls about the points [m], shape (n,); 0 by default.
    """
    normal = lowest_face(points, radii, down)
    if normal is None:
        return None
    exact = _plane(points, radii) is not None or _is_face(points, radii, normal)
    return None if angle_between(normal, down) < (_EXACT if exact else _LEVEL) else normal


def _is_face(points: Array, radii: Array | None, normal: Array) -> bool:
    """Tell whether a foot ends below in a plane, as a box does, so that its tilt is no rounding."""
    if radii is not None and np.ptp(radii) > 0.0:
        return False
    heights = points @ normal
    size = float(np.ptp(points, axis=0).max())
    face = points[heights > heights.max() - _THIN * size]
    if len(face) < 3:
        return False
    spread = np.linalg.svd(face - face.mean(axis=0), compute_uv=False)
    wide = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    share = (spread[:2] / np.sqrt(len(face))) / (wide[:2] / np.sqrt(len(points)))
    return bool((share > _SHARE).all())


def lowest_face(points: Array, radii: Array | None, down: Array) -> Array | None:
    """Return the outward normal of a foot's lower face, shape (3,).

    The face is the largest one, of the convex hull of the foot, of those that look down, or the
    plane in which all points lie. None if no face is large enough to tell. Points (n, 3) [m] may be
    centres of balls of `radii` (n,) [m]; `down` is a unit vector (3,).
    """
    plane = _plane(points, radii)
    if plane is not None:
        normal = plane if plane @ down > 0.0 else -plane
        return normal if normal @ down > _LOOKS_DOWN else None
    normals, areas = hull_faces(points)
    low = normals @ down > _LOOKS_DOWN
    if not low.any():
        return None
    normals, areas = normals[low], areas[low]
    alike = normals @ normals.T > np.cos(_SAME_FACE)
    sizes = alike @ areas
    best = int(sizes.argmax())
    if sizes[best] < _SHARE * areas.sum():
        return None
    if normals[best] @ down > np.cos(_LEVEL):
        return np.asarray(normals[best])
    mean = areas[alike[best]] @ normals[alike[best]]
    return np.asarray(mean / np.linalg.norm(mean))


def hull_faces(points: Array) -> tuple[Array, Array]:
    """Return outward normals (f, 3) and areas (f,) of the faces of the convex hull of points.

    Large faces may come in parts. There are none where the points lie on a line or in a plane.
    """
    if len(points) <= _FEW:
        return _faces_of_few(points)
    from scipy.spatial import ConvexHull, QhullError  # takes longer to import than all else here

    try:
        hull = ConvexHull(points)
    except QhullError:
        return np.zeros((0, 3)), np.zeros(0)
    a, b, c = (hull.points[hull.simplices[:, k]] for k in range(3))
    return hull.equations[:, :3], np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0


def _faces_of_few(points: Array) -> tuple[Array, Array]:
    """Return the faces of the hull of a few points, as those of boxes."""
    # The plane of each three holds a face if all points are on one side of it.
    none = np.zeros((0, 3)), np.zeros(0)
    if len(points) < 4:
        return none
    sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    near = _ON_FACE * sizes[0]
    if sizes[2] <= near:
        return none
    a, b, c = points[np.array(list(combinations(range(len(points)), 3)))].swapaxes(0, 1)
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1)
    wide = length > near * sizes[0]
    normals, a = normals[wide] / length[wide, None], a[wide]
    heights = normals @ points.T - (normals * a).sum(axis=1)[:, None]
    below, above = (heights <= near).all(axis=1), (heights >= -near).all(axis=1)
    normals, heights = np.where(above[:, None], -normals, normals), heights[above | below]
    normals = normals[above | below]
    faces, first = np.unique(np.abs(heights) <= near, axis=0, return_index=True)
    areas = []
    for face, normal in zip(faces, normals[first], strict=True):
        across = np.linalg.svd(normal[None])[2][1:]  # two directions in the plane
        areas.append(abs(_area(convex_polygon(points[face] @ across.T))))
    return normals[first], np.array(areas)


def _plane(points: Array, radii: Array | None) -> Array | None:
    """Return the normal of the plane under points or equal balls, None if there is none."""
    if len(points) < 3 or (radii is not None and np.ptp(radii) > 0.0):
        return None
    _, sizes, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    flat = sizes[2] < _THIN * sizes[0] and sizes[1] > _WIDE * sizes[0]
    return np.asarray(axes[2]) if flat else None


def _other_rectangles(flat: Array) -> dict[str, Edges]:
    """Return edges of rectangles that suit a flat part that is none, by name; some without area."""
    (high_x, high_y), (low_x, low_y) = flat.max(axis=0), flat.min(axis=0)
    long, wide = high_x - low_x, high_y - low_y
    return {
        f"{_NEARLY:.0%} of its length": largest_rectangle(flat, (_NEARLY * long, 0.0)),
        f"{_NEARLY:.0%} of its width": largest_rectangle(flat, (0.0, _NEARLY * wide)),
        "all of it, with corners in the air": (
            float(high_x), float(low_x), float(high_y), float(low_y)
        ),
    }  # fmt: skip


def _leaning(shape: FootShape, points: Array) -> str:
    """Say by how much the foot's lower face leans, if it does, and what helps."""
    face = lowest_face(points, shape.radii, _DOWN)
    if face is None or angle_between(face, _DOWN) < _LEANS:
        return ""
    angle = np.degrees(angle_between(face, _DOWN))
    return (
        f"; or, as its lower face is tilted by {angle:.2f} degrees, say which "
        "direction of the root link is up (up = [X, Y, Z]) or give a posture with flat feet "
        "([posture]), both in the file for --choices"
    )


def largest_rectangle(points: Array, least: tuple[float, float] = (0.0, 0.0)) -> Edges:
    """Return the largest rectangle along the axes in the convex hull of points (n, 2).

    It has at least some extents along x and y [m], and no area if the hull has none.
    """
    points = np.unique(np.round(points, 12), axis=0)
    low, high = points.min(axis=0), points.max(axis=0)
    hull = convex_polygon(points)
    if len(hull) < 3:  # all on one line
        return float(low[0]), float(low[0]), float(low[1]), float(low[1])
    rectangle = len(hull) == 4 and ((hull == low) | (hull == high)).all()
    if rectangle and (high - low >= least).all():
        return float(high[0]), float(low[0]), float(high[1]), float(low[1])
    return _largest_inside(hull, least)


def convex_polygon(points: Array) -> Array:
    """Return the corners (m, 2) of the convex hull of points (n, 2) of a plane, counterclockwise.

    Two corners or one where all points lie on one line. Andrew, "Another efficient algorithm for
    convex hulls in two dimensions", Information Processing Letters 9 (1979).
    """
    ordered = [(float(x), float(y)) for x, y in np.unique(points, axis=0)]
    if len(ordered) < 3:
        return np.array(ordered)
    size = np.ptp(points, axis=0).max()

    def chain(along: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
        corners: list[tuple[float, float]] = []
        for x, y in along:
            while len(corners) > 1:
                (ax, ay), (bx, by) = corners[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > _STRAIGHT * size**2:
                    break
                corners.pop()
            corners.append((x, y))
        return corners[:-1]

    return np.array(chain(ordered) + chain(reversed(ordered)))


def _area(polygon: Array) -> float:
    """Return the area of a polygon, corners (m, 2) counterclockwise."""
    x, y = polygon.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def _largest_inside(hull: Array, least: tuple[float, float]) -> Edges:
    """Return the largest rectangle in a convex polygon (m, 2), of no area where there is none."""
    # The logarithm of the area is concave in the edges, and the polygon holds them by linear
    # inequalities: there is one maximum, which Newton's method finds from inside. Where it may
    # slide, it stays near the middle.
    import quadprog  # few robots ask for it

    size = np.ptp(hull, axis=0)  # areas of rectangles change by one factor where axes do
    polygon = hull / size
    along = np.roll(polygon, -1, axis=0) - polygon
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None]
    (a, b), c = normal.T, -(normal * polygon).sum(axis=1)  # a x + b y + c <= 0 inside of a side
    corner = np.stack([a.clip(0.0), a.clip(None, 0.0), b.clip(0.0), b.clip(None, 0.0)], axis=1)
    extent = np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]])
    rows = np.vstack([-corner, extent])
    within = np.concatenate([c, np.maximum(least / size, _SHORTEST)])
    middle = polygon.mean(axis=0)
    room = -0.5 * float((a * middle[0] + b * middle[1] + c).max())
    x = middle.repeat(2) + room * np.array([1.0, -1.0, 1.0, -1.0])
    for _ in range(_NEWTON_STEPS):
        extents = np.maximum(extent @ x, _SHORTEST)
        bent = extent.T / extents**2 @ extent
        bent += _STIFF * np.trace(bent) * np.eye(4)  # where only a position is free
        try:
            step = quadprog.solve_qp(bent, (1.0 / extents) @ extent, rows.T, within - rows @ x)[0]
        except ValueError:  # there is none of such extents
            x = middle.repeat(2)
            break
        shrinks = -float((extent @ step / extents).min())  # by half at most may an extent at once
        x += step * min(1.0, 0.5 / max(shrinks, 0.5))
        if np.abs(step).max() < _ARRIVED:
            break
    toe, heel, left, right = map(float, x * size.repeat(2))
    return toe, heel, left, right
