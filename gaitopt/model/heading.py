"""Which way a robot looks, and which of its legs is the right one: from geometry, not names."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.model.import_options import AXES, Axis
from gaitopt.model.kinematic_tree import PosedModel
from gaitopt.model.leg_detection import axes_apart
from gaitopt.model.leg_geometry import common_point, find_knee, hip_and_ankle
from gaitopt.model.scales import REACH
from gaitopt.nlp import Array

_SNAP = 1e-3  # rad: a hip line this close to an axis of the root link is that axis
_ASKEW = 0.5  # rad: and one this close if the axes of the legs mirror better in that one
_LONGER = 1.25  # a foot is clearly longer ahead of the ankle if by this factor
_NARROW = 1e-4 / REACH  # of the distance from hip to ankle


@dataclass(frozen=True)
class LegLines:
    """One leg at the reference posture, all in the root link.

    Attributes:
        points, axes: of the joint lines from hip to ankle, shape (n, 3) each.
        angles: of the joints [rad], shape (n,).
        lower, upper: of their ranges [rad], shape (n,).
        foot: points of the foot [m], shape (n, 3), None if unknown.
    """

    points: Array
    axes: Array
    angles: Array
    lower: Array
    upper: Array
    foot: Array | None = None

    @cached_property
    def parts(self) -> tuple[list[int], list[int]]:
        """Rows of the joints of hip and ankle."""
        return hip_and_ankle(self.points, self.axes)

    @property
    def hip(self) -> Array:
        """Point nearest to the lines of the hip [m], shape (3,)."""
        return common_point(self.points[self.parts[0]], self.axes[self.parts[0]])

    @property
    def ankle(self) -> Array:
        """Point nearest to the lines of the ankle [m], shape (3,)."""
        return common_point(self.points[self.parts[1]], self.axes[self.parts[1]])


def leg_lines(posed: PosedModel, leg: Sequence[int], foot: Array | None = None) -> LegLines:
    """Return the joint lines of a leg in the root link, and points of its foot (n, 3), if known."""
    model, rows = posed.model, [posed.model.joints[joint].idx_q for joint in leg]
    ankle = posed.placements[leg[-1]]
    return LegLines(
        points=posed.points[list(leg)],
        axes=posed.axes[list(leg)],
        angles=posed.q[rows],
        lower=np.array(model.lowerPositionLimit)[rows],
        upper=np.array(model.upperPositionLimit)[rows],
        foot=None if foot is None else foot @ ankle.rotation.T + ankle.translation,
    )


@dataclass(frozen=True)
class Heading:
    """Axes of the robot in its root link.

    Attributes:
        rotation: columns forward, left, up, shape (3, 3).
        right: index of the right leg, 0 or 1.
        reasons: what spoke for this heading, in words.
        doubt: what spoke against it, in words, or empty.
        given: whether the user fixed it.
    """

    rotation: Array
    right: int
    reasons: str
    doubt: str = ""
    given: bool = False


def find_heading(legs: tuple[LegLines, LegLines], up: Array, forward: Axis | None) -> Heading:
    """Return forward, left and up in the root link, and which leg is the right one.

    Left is along the line through the hips, square to up, shape (3,). Forward is where the feet are
    longer or, if that does not tell, against the side on which the knees take the shanks when they
    bend. Where the two contradict each other, the one counts that has the root's x axis forward, as
    is usual.

    Raises:
        RobotError: front and back cannot be told apart, or the given axis is not level.
    """
    side = _hip_line(legs, up)
    if forward is not None:
        ahead, reasons, doubt = _given(forward, side, up), "as given", ""
    else:
        ahead = np.cross(side, up)
        sign, reasons, doubt = _front(legs, ahead)
        ahead = sign * ahead + 0.0
    left = np.cross(up, ahead) + 0.0
    rotation = np.column_stack([ahead, left, up])
    across = [float(leg.hip @ left) for leg in legs]
    return Heading(rotation, int(across[1] < across[0]), reasons, doubt, forward is not None)


def axis_name(vector: Array) -> Axis:
    """Return the name of a root axis (3,), or the three numbers of another direction."""
    for name, axis in AXES.items():
        if np.array_equal(vector, axis):
            return name
    x, y, z = (float(v) for v in vector)
    return (x, y, z)


def axis_vector(axis: Axis) -> Array:
    """Return the unit vector (3,) of an axis name or of three numbers."""
    return np.array(AXES[axis] if isinstance(axis, str) else axis)


def _hip_line(legs: tuple[LegLines, LegLines], up: Array) -> Array:
    narrow = _NARROW * float(np.linalg.norm(legs[0].hip - legs[0].ankle))
    for line in (legs[1].hip - legs[0].hip, legs[1].ankle - legs[0].ankle):
        level = line - (line @ up) * up
        if (size := float(np.linalg.norm(level))) > narrow:
            unit = level / size
            near = [np.array(a) for a in AXES.values() if unit @ np.array(a) > np.cos(_ASKEW)]
            return near[0] if near and _squarer(legs, near[0], unit) else np.asarray(unit)
    raise RobotError(
        "neither the hips nor the ankles of the two legs are beside each other: at the reference "
        f"posture both pairs lie less than {1e3 * narrow:.2g} mm apart to the side; correct the "
        "places of the hips, or give a posture that spreads the legs (posture, in the file for "
        "--choices)"
    )


def _squarer(legs: tuple[LegLines, LegLines], axis: Array, line: Array) -> bool:
    """Tell whether the legs look to the side along an axis of the root rather than along a line."""
    # A hip that is a little ahead of the other one turns the line through both, not the robot.
    if line @ axis > np.cos(_SNAP):
        return True
    first, other = (leg.axes for leg in legs)
    return axes_apart(first, other, axis) < axes_apart(first, other, line)


def _given(forward: Axis, side: Array, up: Array) -> Array:
    ahead = axis_vector(forward)
    if abs(float(ahead @ up)) > _SNAP or abs(float(ahead @ side)) > _SNAP:
        raise RobotError(
            f"forward = {forward} is not level and across the hips: its angle to the upward axis "
            f"is {np.degrees(np.arccos(np.clip(ahead @ up, -1, 1))):.1f} degrees and to the line "
            f"through the hips {np.degrees(np.arccos(np.clip(ahead @ side, -1, 1))):.1f} degrees; "
            "both must be 90"
        )
    return ahead


def _front(legs: tuple[LegLines, LegLines], ahead: Array) -> tuple[float, str, str]:
    """Return the sign of forward along `ahead`, why, and what contradicts it."""
    feet, foot_words = _longer_side(legs, ahead)
    bends = [_bend(leg, ahead) for leg in legs]
    knees = -float(np.sign(bends[0])) if bends[0] * bends[1] > 0.0 else 0.0
    knee_words = "the knees bend that way"
    if feet == 0.0 and knees == 0.0:
        if abs(float(ahead[0])) != 1.0:
            raise RobotError(_UNTOLD)
        return float(ahead[0]), "by convention", f"{_UNTOLD}; x was taken, as most robots have it"
    if feet * knees < 0.0:
        usual = float(ahead[0]) if abs(float(ahead[0])) == 1.0 else feet
        if usual == feet:
            return feet, foot_words, "the knees' ranges speak for the opposite direction"
        return knees, knee_words, f"though {foot_words} if it looked the other way"
    words = [w for vote, w in ((feet, foot_words), (knees, knee_words)) if vote != 0.0]
    return feet or knees, " and ".join(words), ""


def _bend(leg: LegLines, ahead: Array) -> float:
    """How far forward the knee takes the ankle as its range has it [m], 0 if that does not tell."""
    beyond = range(len(leg.parts[0]), len(leg.points))
    knee = find_knee(leg.points, leg.axes, leg.hip, leg.ankle, leg.angles, beyond)
    side = knee.range_side(float(leg.lower[knee.row]), float(leg.upper[knee.row]))
    return side * float(knee.side @ ahead)


_UNTOLD = (
    "front and back cannot be told apart: the feet are about as long behind the ankle as ahead of "
    "it (or have no shape), and the ranges of the knees do not tell; say where the robot looks "
    '(forward = "x" or another axis of the root link)'
)


def _longer_side(legs: tuple[LegLines, LegLines], ahead: Array) -> tuple[float, str]:
    spans = [(leg.foot - leg.ankle) @ ahead for leg in legs if leg.foot is not None]
    if not spans:
        return 0.0, ""
    front = max(float(np.median([s.max() for s in spans])), 1e-6)
    back = max(float(np.median([-s.min() for s in spans])), 1e-6)
    words = (
        f"the feet reach {max(front, back) * 1e3:.0f} mm ahead of the ankle and "
        f"{min(front, back) * 1e3:.0f} mm behind it"
    )
    if max(front, back) < _LONGER * min(front, back):
        return 0.0, words
    return (1.0 if front > back else -1.0), words
