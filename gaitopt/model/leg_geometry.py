"""Measures of a pair of legs: centres of hip and ankle, knees, reach, missing joints.

A leg has up to three joints at the hip, then a knee, then up to two at the ankle; a seventh joint
is at one of the two, or a second knee. Rows of a leg go from hip to ankle.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.importers.physics import STANDARD_GRAVITY
from gaitopt.importers.report import Finding
from gaitopt.model.joint_limits import JointLimits
from gaitopt.model.kinematic_tree import points_on_lines
from gaitopt.nlp import Array

NEEDED_JOINTS = ("hip pitch", "knee", "ankle pitch")
"""What a leg cannot put its foot flat at a step without."""

_HIP, _ANKLE = 3, 2  # joints at most, in a leg of six
_LEAST_KNEE = 0.1  # of what any joint of the leg changes: what a knee changes at least
_LEAST_BEND = 0.1  # of the squared distance of hip and ankle: what a knee changes it by
_ONE_SIDED = 0.15  # of the range: how far its middle must be from straight
_STRAIGHT = 0.01  # rad: a knee that stops this near to straight is straight there
_MEET = 1e-6  # m: lines that pass a point this closely meet there
_WIDE = 0.1  # of the leg's length: lines of a hip or an ankle that miss each other by less
_INDEPENDENT = 0.3  # singular value of unit axes: below it they turn about one direction less
_ABLE = 0.7  # cosine: joints that turn a foot about an axis have it nearly among theirs


@dataclass(frozen=True)
class Legs:
    """Geometry of the two legs, stance leg first.

    Attributes:
        hips: centres of the hips in the pelvis frame [m], shape (2, 3).
        ankles: centres of the ankles in the sole frames [m], shape (2, 3).
        knees: index of each knee in the joint vector.
        straight: knee angle at which the leg is longest [rad], shape (2,).
        flexion: +1 where the knee bends with increasing angle, else -1, shape (2,).
        reach: distance between hip and ankle centres with the knee straight and the other joints
            at 0 [m]; the largest possible one where the axes of a hip meet in one point.
        bound: what that distance cannot exceed at any angles within the joints' ranges [m]; equal
            to `reach` where the axes of hip and ankle meet in one point each.
        stance_width: distance between the ankles across when the robot stands upright [m], negative
            where the swing leg is the right one: that of the hips, or where ankles do not roll that
            of the ankles with all joints at 0, for such legs stay upright.
        missing: joints that the legs lack, as "ankle roll".
        gravity: acceleration of free fall [m/s²].
    """

    hips: Array
    ankles: Array
    knees: tuple[int, int]
    straight: Array
    flexion: Array
    reach: float
    bound: float
    stance_width: float
    missing: tuple[str, ...]
    gravity: float = STANDARD_GRAVITY

    @property
    def height(self) -> float:
        """Height of the pelvis frame above the soles with straight, upright legs [m]."""
        return self.reach + float(self.ankles[:, 2].mean() - self.hips[:, 2].mean())

    @property
    def spacing(self) -> float:
        """Distance between the hips [m], negative where the swing leg is the right one."""
        return float(self.hips[1, 1] - self.hips[0, 1])

    @property
    def ankles_roll(self) -> bool:
        """Whether the ankles roll; else the weight shifts by the roll of the trunk alone."""
        return "ankle roll" not in self.missing

    @property
    def side(self) -> float:
        """+1 where the swing leg is the left one, else -1."""
        return 1.0 if self.spacing > 0.0 else -1.0

    def natural_step(self, speed: float) -> float:
        """Return the step length [m] with which animals of this size walk at a speed [m/s].

        Relative stride length 2.3 (v² / g h)^0.3 with h the height of the hips above the ground,
        the fit over many species of Alexander (1989), Physiological Reviews 69(4), 1199-1227.
        """
        h = self.height
        return 0.5 * 2.3 * h * float((speed**2 / (self.gravity * h)) ** 0.3)


@dataclass(frozen=True)
class ChainLines:
    """The joint lines of a re-rooted model at its neutral posture.

    Attributes:
        model: free-flyer, stance leg from ankle to hip, swing leg from hip to ankle, other joints.
        frame: name of the pelvis frame.
        pelvis: its placement.
        points, axes: joint lines in the pelvis frame, shape (n, 3) each.
        count: joints of each leg.
    """

    model: pin.Model
    frame: str
    pelvis: pin.SE3
    points: Array
    axes: Array
    count: int


@dataclass(frozen=True)
class Knee:
    """The joint that bends a leg.

    Attributes:
        row: its place among the leg's joints.
        straight: angle at which the leg is longest [rad].
        reach: distance between hip and ankle there, the other joints as they are [m].
        side: direction in which a larger angle takes the ankle from the straight leg, shape (3,).
    """

    row: int
    straight: float
    reach: float
    side: Array

    def range_side(self, lower: float, upper: float) -> float:
        """Return +1 or -1 for the side to which a range [rad] lies, 0 if it does not tell."""
        if not (np.isfinite(lower) and np.isfinite(upper)):
            return 0.0
        middle = (lower + upper) / 2.0 - self.straight
        return float(np.sign(middle)) if abs(middle) > _ONE_SIDED * (upper - lower) else 0.0


def leg_rows(count: int) -> tuple[list[int], list[int]]:
    """Return the rows of stance and swing leg in the joint vector, from hip to ankle."""
    return list(range(count))[::-1], list(range(count, 2 * count))


def hip_and_ankle(points: Array, axes: Array) -> tuple[list[int], list[int]]:
    """Return the rows of the hip's and of the ankle's joints of a leg, given its lines (n, 3).

    Where more than one joint may be the knee it is the one that changes the distance between the
    two most. Of a leg that bends by two knees both are between.
    """
    count = len(points)
    spare = max(count - _HIP - _ANKLE - 1, 0)
    least = max(count - 1 - _ANKLE - spare, 1)
    parts = [(list(range(k)), list(range(k + 1, count)))
             for k in range(least, min(_HIP + spare, count - 2) + 1)]  # fmt: skip
    if len(parts) == 1:
        return parts[0]

    def ends(part: tuple[list[int], list[int]]) -> tuple[Array, Array]:
        hip, ankle = (common_point(points[rows], axes[rows]) for rows in part)
        return hip, ankle

    def bend(part: tuple[list[int], list[int]]) -> float:
        knee = len(part[0])
        return abs(_swing(points[knee], axes[knee], *ends(part))[1])

    def spread(part: tuple[list[int], list[int]]) -> float:
        return max(
            _distance(end, points[row], axes[row])
            for end, rows in zip(ends(part), part, strict=True)
            for row in rows
        )

    one = max(parts, key=bend)
    if not spare:
        return one
    two = list(range(_HIP)), list(range(count - _ANKLE, count))
    hip, ankle = ends(one)
    wide = spread(one) > max(_WIDE * float(np.linalg.norm(hip - ankle)), 2.0 * spread(two))
    return two if wide and abs(float(axes[_HIP] @ axes[_HIP + 1])) > _ABLE else one


def measure_legs(lines: ChainLines, soles: tuple[str, str], limits: JointLimits) -> Legs:
    """Measure the legs of a re-rooted model.

    Args:
        limits: of the joints; a knee bends towards the larger part of its range, and backwards if
            that does not tell.
    """
    data = lines.model.createData()
    pin.framesForwardKinematics(lines.model, data, pin.neutral(lines.model))
    hips, ankles, places, rows_of_knees, knees, flexion, bounds = [], [], [], [], [], [], []
    # The stance leg's chain runs from its ankle to its hip: against the file.
    for rows, outward, sole in zip(leg_rows(lines.count), (-1.0, 1.0), soles, strict=True):
        axes = lines.axes[rows]
        points = points_on_lines(lines.points[rows], axes, [0, *range(len(rows) - 1)])
        parts = hip_and_ankle(points, axes)
        hip, ankle = (centre(points, axes, part) for part in parts)
        frame = data.oMf[lines.model.getFrameId(sole)]
        missing = tuple(missing_joints(points, axes))
        if "ankle roll" in missing:  # where on its axis the ankle is, only the foot tells
            axis = axes[parts[1][0]]
            foot = lines.pelvis.actInv(frame.translation)
            ankle = ankle + ((foot - ankle) @ axis) * axis
        beyond = range(len(parts[0]), len(rows))
        knee = find_knee(points, outward * axes, hip, ankle, np.zeros(len(rows)), beyond)
        row = rows[knee.row]
        told = knee.range_side(float(limits.lower[row]), float(limits.upper[row]))
        slack = 0.0
        for part, point in zip(parts, (hip, ankle), strict=True):
            slack += _slack(lines, limits, [rows[k] for k in part], point)
        hips.append(hip)
        places.append(ankle)
        ankles.append(frame.actInv(lines.pelvis.act(ankle)))
        rows_of_knees.append(row)
        knees.append(knee)
        flexion.append(told or (1.0 if knee.side[0] < 0.0 else -1.0))
        bounds.append(knee.reach + slack)
    ends = places if "ankle roll" in missing else hips
    return Legs(
        hips=np.array(hips),
        ankles=np.array(ankles),
        knees=(rows_of_knees[0], rows_of_knees[1]),
        straight=np.array([knee.straight for knee in knees]),
        flexion=np.array(flexion),
        reach=max(knee.reach for knee in knees),
        bound=max(bounds),
        stance_width=float(ends[1][1] - ends[0][1]),
        missing=missing,
        gravity=float(np.linalg.norm(lines.model.gravity.linear)),
    )


def missing_joints(points: Array, axes: Array) -> list[str]:
    """Return which joints a leg lacks, as "hip yaw", given its lines (n, 3) in the robot's axes."""
    hip, ankle = hip_and_ankle(points, axes)
    knee, (first, last) = len(hip), (common_point(points[r], axes[r]) for r in (hip, ankle))
    bend = abs(_swing(points[knee], axes[knee], first, last)[1])
    if bend < _LEAST_BEND * float(np.linalg.norm(first - last)) ** 2:
        return ["knee"]
    turns = {"roll": 0, "pitch": 1, "yaw": 2}
    missing = []
    for name, rows, needed in (("hip", hip, turns), ("ankle", ankle, ("pitch", "roll"))):
        _, sizes, directions = np.linalg.svd(axes[rows], full_matrices=False)
        able = directions[sizes > _INDEPENDENT]
        for turn in needed:
            if np.linalg.norm(able[:, turns[turn]]) < _ABLE:
                missing.append(f"{name} {turn}")
    return missing


def knee_doubts(legs: Legs, limits: JointLimits, names: tuple[str, ...]) -> list[Finding]:
    """Return which knees never get straight, as their ranges have it."""
    findings = []
    for row, straight in zip(legs.knees, legs.straight, strict=True):
        lower, upper = float(limits.lower[row]), float(limits.upper[row])
        if lower - _STRAIGHT <= straight <= upper + _STRAIGHT:
            continue
        short = min(abs(straight - lower), abs(straight - upper))
        text = (
            f"is taken for the knee; the leg is straight at {straight:.4g} rad, {short:.3g} rad "
            f"outside its range {lower:.4g} to {upper:.4g} rad"
        )
        findings.append(Finding("legs", names[row], text, "warning"))
    return findings


def find_knee(
    points: Array,
    axes: Array,
    hip: Array,
    ankle: Array,
    angles: Array,
    beyond: Sequence[int] | None = None,
) -> Knee:
    """Find the knee: the joint line that changes the distance between hip and ankle most.

    Args:
        points, axes: of the lines, shape (n, 3) each, all in one frame; a larger angle turns the
            ankle about +axis as seen from the hip.
        hip, ankle: centres of both [m], shape (3,).
        angles: of the joints in that posture [rad], shape (n,).
        beyond: rows of the joints beyond the hip, of which the knee is one unless they hardly
            change the distance; None for all. Where the axes of a hip do not meet, one of its
            joints may well change the distance more than the knee does.
    """
    swings = [_swing(p, a, hip, ankle) for p, a in zip(points, axes, strict=True)]
    sizes = np.array([abs(c) for _, c in swings])
    row = int(sizes.argmax())
    if beyond is not None:
        nearer = max(beyond, key=lambda k: float(sizes[k]))
        row = nearer if sizes[nearer] > _LEAST_KNEE * sizes[row] else row
    c0, c = swings[row]
    turn = float(np.angle(c))
    level = ankle - points[row]
    level = level - (level @ axes[row]) * axes[row]
    side = np.cos(turn) * np.cross(axes[row], level) - np.sin(turn) * level
    return Knee(row, float(angles[row]) + turn, float(np.sqrt(c0 + abs(c))), side)


def _swing(point: Array, axis: Array, hip: Array, ankle: Array) -> tuple[float, complex]:
    """Return c0 and c1 + i c2 of the squared distance between hip and ankle about a line [m²]."""
    # It is c0 + c1 cos q + c2 sin q, the angle q counted from the posture of the lines.
    to_hip, to_ankle = hip - point, ankle - point
    along = (to_ankle @ axis) * axis
    level = to_ankle - along
    c0 = float(to_hip @ to_hip + to_ankle @ to_ankle - 2.0 * to_hip @ along)
    return c0, complex(-2.0 * to_hip @ level, -2.0 * to_hip @ np.cross(axis, level))


def common_point(points: Array, axes: Array) -> Array:
    """Return the point nearest to a set of lines in the least-squares sense, shape (3,).

    Where the lines leave a direction free (parallel axes), the point nearest to the mean of
    `points` is taken.
    """
    projectors = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    mean = points.mean(axis=0)
    rhs = np.einsum("nij,nj->i", projectors, points - mean)
    return np.asarray(mean + np.linalg.lstsq(projectors.sum(axis=0), rhs, rcond=1e-9)[0])


def centre(points: Array, axes: Array, rows: Sequence[int]) -> Array:
    """Return the centre of a hip or an ankle, shape (3,), given all lines of the leg.

    Where its axes do not meet, it is the point of the pitch axis nearest to all of them: legs swing
    about that axis most, and do not change their length by it.
    """
    points, axes = points[list(rows)], axes[list(rows)]
    middle = common_point(points, axes)
    if max(_distance(middle, p, a) for p, a in zip(points, axes, strict=True)) < _MEET:
        return middle
    pitch = int(np.abs(axes[:, 1]).argmax())
    return np.asarray(points[pitch] + ((middle - points[pitch]) @ axes[pitch]) * axes[pitch])


def _distance(point: Array, origin: Array, axis: Array) -> float:
    """Distance of a point from a line."""
    return float(np.linalg.norm(np.cross(point - origin, axis)))


def _slack(lines: ChainLines, limits: JointLimits, rows: Sequence[int], point: Array) -> float:
    """Return how far at most the joints of a hip or an ankle move a point of the leg [m]."""
    # A point at distance r from an axis moves by 2 r sin(angle / 2), and rotations do not stretch,
    # so that the sum over the axes bounds what they move it together.
    total = 0.0
    for row in rows:
        angle = min(max(abs(limits.lower[row]), abs(limits.upper[row])), np.pi)
        radius = _distance(point, lines.points[row], lines.axes[row])
        total += 2.0 * radius * float(np.sin(angle / 2.0))
    return total
