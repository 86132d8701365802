"""Moving arms as capsules, and what they may run into: pelvis, waist, thighs, loads.

Several capsules may cover a body, for one around a torso would reach far into arms that hang beside
it: its shapes are cut where that makes the capsules smaller, and put together where it does not.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import combinations

import numpy as np
import pinocchio as pin

from gaitopt.importers.reader import read_source
from gaitopt.model.feet.foot_shape import Points, box_points
from gaitopt.model.import_options import CapsuleRow
from gaitopt.model.joint_tree import FIRST
from gaitopt.model.leg_capsules import (
    SHORT,
    BoundingCapsule,
    Capsule,
    CapsuleKey,
    bar_radius,
    bounding_capsule,
    capsules_of_rows,
    link_of,
    rows_of_capsules,
    shapes_by_body,
)
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array

_OF_TRUNK, _OF_LIMB = 6, 2  # capsules of a body at most
_THICKER = 1.2  # times the radius of both halves: one capsule is too thick to take their place
_THIN = 0.14  # of the leg's length: the radius of a capsule that is good enough
_ANYWHERE = np.zeros(3)


def arm_bodies(robot: Robot) -> dict[int, int]:
    """Return the bodies of moving arms, and of each the one at which its arm begins.

    Arms are what moves beside the legs and has a mirror image that is another body.
    """
    tree = robot.tree
    paired = {
        name: int(np.abs(row).argmax()) != k
        for k, (name, row) in enumerate(zip(robot.joint_names, robot.mirror, strict=True))
    }
    found: dict[int, int] = {}
    for joint in range(tree.swing_foot, tree.size):
        on = tree.parents[joint] + 1  # the body on which it sits
        if on in found:
            found[joint + 1] = found[on]
        elif paired.get(tree.names[joint], False):
            found[joint + 1] = joint + 1
    return found


def arm_capsules(robot: Robot) -> tuple[Capsule, ...]:
    """Return the capsules of moving arms and of what they may run into, in the order of the bodies.

    None where no arm moves. The result is kept.

    Raises:
        RobotError: a mesh file of such a body is there but cannot be read.
    """
    if robot.choices.arm_capsules is not None:
        return capsules_of_rows(robot.choices.arm_capsules)
    return _capsules(CapsuleKey.of(robot)) if arm_bodies(robot) else ()


def arm_capsule_rows(robot: Robot) -> tuple[CapsuleRow, ...]:
    """Return the capsules as `ImportOptions` keeps them: no mesh is needed to find them again."""
    return rows_of_capsules(arm_capsules(robot))


@lru_cache(maxsize=16)
def _capsules(key: CapsuleKey) -> tuple[Capsule, ...]:
    robot, tree = key.robot, key.robot.tree
    source, images = read_source(robot.urdf, robot.choices.package_dirs), _Images(robot)
    stance_knee, swing_knee = robot.legs.knees
    bodies = [
        *range(stance_knee + 1, swing_knee + 1),  # thighs, pelvis
        *range(tree.swing_foot + 1, tree.size + 1),
    ]
    thin = _THIN * robot.legs.reach
    found: dict[int, list[Capsule]] = {}
    for kind in (pin.GeometryType.COLLISION, pin.GeometryType.VISUAL):
        missing = [body for body in bodies if body not in found]
        shapes = shapes_by_body(robot, source, kind, missing)
        for body, parts in shapes.items():
            if (other := images.of(body)) < body and other in found:
                continue
            both = parts + [images.points(p, body) for p in shapes.get(other, []) if other != body]
            most = _OF_TRUNK if other == body else _OF_LIMB
            around = _covered(both, thin, most)
            found[body] = _named(body, link_of(robot, body), around, kind.name.lower())
            if other != body:
                around = [images.capsule(capsule, other) for capsule in around]
                found[other] = _named(other, link_of(robot, other), around, kind.name.lower())
    for body in bodies:
        if body not in found:
            found[body] = _named(body, link_of(robot, body), list(_bars(robot, body)), "joints")
    for payload in robot.choices.payloads:
        frame = robot.model.frames[robot.model.getFrameId(payload.link)]
        body = int(frame.parentJoint) - 1
        if body in found and payload.place is not None and any(payload.box):
            place = frame.placement * pin.SE3(np.eye(3), np.array(payload.place))
            box = box_points(np.array(payload.box) / 2.0).placed(place)
            found[body] += _named(body, "the load", _covered([box], thin, _OF_TRUNK), "load")
    return tuple(capsule for body in sorted(found) for capsule in found[body])


class _Images:
    """Bodies and what belongs to them as a mirror between the legs shows them."""

    def __init__(self, robot: Robot) -> None:
        self._tree, self._mirror = robot.tree, np.abs(robot.coupling.mirror).argmax(axis=1)
        data = robot.model.createData()
        pin.framesForwardKinematics(robot.model, data, pin.neutral(robot.model))
        middle = data.oMf[robot.pelvis_frame]
        self._places = [middle.actInv(place) for place in data.oMi[1:]]

    def of(self, body: int) -> int:
        """Return the body on the other side, or the body itself if it is in the middle."""
        if body <= self._tree.swing_foot:
            return self._tree.swing_foot - body
        return int(self._mirror[body - 1]) + 1

    def points(self, points: Points, body: int) -> Points:
        """Return balls of the other side's body as the image of `body` has them."""
        return Points(self._seen(points.centres, body), points.radii)

    def capsule(self, capsule: BoundingCapsule, body: int) -> BoundingCapsule:
        """Return a capsule of the other side's body as the image of `body` has it."""
        start, end = self._seen(np.stack([capsule.start, capsule.end]), body)
        return BoundingCapsule(start, end, capsule.radius)

    def _seen(self, points: Array, body: int) -> Array:
        there, here = self._places[self.of(body)], self._places[body]
        image = (points @ there.rotation.T + there.translation) * [1.0, -1.0, 1.0]
        return np.asarray((image - here.translation) @ here.rotation)


def _named(body: int, name: str, shapes: list[BoundingCapsule], origin: str) -> list[Capsule]:
    """Return capsules with names; those of one body are numbered if there are several."""
    several = len(shapes) > 1
    return [
        shape.of(body, f"{name} ({k + 1})" if several else name, origin)
        for k, shape in enumerate(shapes)
    ]


def _bars(robot: Robot, body: int) -> Iterator[BoundingCapsule]:
    """Yield bars from a body's joint to those that it carries."""
    tree, model = robot.tree, robot.model
    for joint, parent in enumerate(tree.parents):
        end = model.jointPlacements[FIRST + joint].translation
        if parent + 1 == body and np.linalg.norm(end) > SHORT * robot.scales.length:
            yield BoundingCapsule(np.zeros(3), end.copy(), bar_radius(robot))


Piece = tuple[Points, BoundingCapsule]


def _covered(parts: list[Points], thin: float, most: int) -> list[BoundingCapsule]:
    """Return few small capsules that cover shapes, which are cut if theirs are not thin."""
    pieces = [piece for part in parts for piece in _cut(_around(part), thin)]
    joined: dict[frozenset[int], Piece] = {}  # by the numbers of both
    numbers = list(range(len(pieces)))
    while len(numbers) > 1:
        best = (True, np.inf, 0, 0)
        for i, j in combinations(numbers, 2):
            one, other, pair = pieces[i], pieces[j], frozenset((i, j))
            if pair not in joined:
                joined[pair] = _around(Points.joined([one[0], other[0]]))
            both = joined[pair][1]
            thicker = both.radius > max(thin, _THICKER * _thickest((one, other)))
            best = min(best, (thicker, both.volume - one[1].volume - other[1].volume, i, j))
        thicker, grown, i, j = best
        if (thicker or grown > 0.0) and len(numbers) <= most:
            break
        pieces.append(joined[frozenset((i, j))])
        numbers = [*(k for k in numbers if k not in (i, j)), len(pieces) - 1]
    return [pieces[k][1] for k in numbers]


def _around(points: Points) -> Piece:
    """Return the corners of a shape, and a capsule around them."""
    corners = Points.together([points])
    return corners, bounding_capsule(corners, _ANYWHERE, _ANYWHERE)


def _cut(piece: Piece, thin: float, depth: int = 2) -> list[Piece]:
    """Return a shape in pieces, halved across one of its two longest directions while that pays."""
    points, around = piece
    if depth == 0 or around.radius < thin or len(points.centres) < 4:
        return [piece]
    spread = points.centres - points.centres.mean(axis=0)
    directions = np.linalg.eigh(spread.T @ spread)[1].T[1:]
    halves = [tuple(map(_around, both)) for d in directions if (both := _halves(points, d))]
    if not halves:
        return [piece]
    best = min(halves, key=_thickest)
    if _thickest(best) > around.radius / _THICKER:
        return [piece]
    return [smaller for half in best for smaller in _cut(half, thin, depth - 1)]


def _thickest(pieces: Iterable[Piece]) -> float:
    return max(capsule.radius for _, capsule in pieces)


def _halves(points: Points, direction: Array) -> tuple[Points, Points] | None:
    """Return both halves of the hull of some balls, of equal width; None if it is flat."""
    from scipy.spatial import ConvexHull, QhullError  # slow to import, and seldom needed

    height = points.centres @ direction
    height = height - (height.min() + height.max()) / 2.0
    try:
        corners = ConvexHull(points.centres).simplices
    except QhullError:
        return None
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    edges = edges[height[edges[:, 0]] * height[edges[:, 1]] < 0.0]
    low, high = edges.T
    share = height[low] / (height[low] - height[high])
    on_cut = Points(
        (1.0 - share)[:, None] * points.centres[low] + share[:, None] * points.centres[high],
        (1.0 - share) * points.radii[low] + share * points.radii[high],
    )
    sides = [Points(points.centres[side], points.radii[side]) for side in (height <= 0, height > 0)]
    below, above = (Points.joined([side, on_cut]) for side in sides)
    return below, above
