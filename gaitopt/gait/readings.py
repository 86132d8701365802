"""The optional quantities of a step: computed only if a constraint looks at them."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from gaitopt.errors import EvaluationError
from gaitopt.gait.parameters import FOOT_YAW
from gaitopt.gait.step import Reads
from gaitopt.mechanics.bodies import Bodies, Placements
from gaitopt.mechanics.leg_gaps import LegGaps, leg_pairs
from gaitopt.mechanics.readings import Reading, ReadingSlope
from gaitopt.mechanics.trunk import ROLL, YAW, Trunk
from gaitopt.nlp import Array
from gaitopt.robot.model import Robot

OPTIONAL = (Reads.TRUNK, Reads.LEG_GAPS)
_HEADING = 0.5  # of the foot yaw: the direction of travel in the stance sole's axes


class Readings:
    """Reads the optional quantities that were asked for; the others have no entries."""

    def __init__(self, robot: Robot, asked: Collection[Reads] = ()) -> None:
        self._read: dict[Reads, Reading] = {}
        if Reads.TRUNK in asked:
            self._read[Reads.TRUNK] = Trunk(robot)
        if Reads.LEG_GAPS in asked:
            self._read[Reads.LEG_GAPS] = LegGaps(leg_pairs(robot).kept)
        self._bodies = Bodies(robot.model) if self._read else None

    def placed(self, q: Array) -> Placements | None:
        """Return the bodies at postures q (N, 12), if anything is read off them."""
        return None if self._bodies is None else self._bodies.placed(q)

    def values(self, placed: Placements | None) -> dict[Reads, Array]:
        """Return what is read off the bodies, of those asked for, shape (N, entries)."""
        if placed is None:
            return {}
        return {what: reading.value(placed) for what, reading in self._read.items()}

    def slopes(self, placed: Placements | None, axes: Array) -> dict[Reads, ReadingSlope]:
        """Return the local derivatives of those asked for, from joint axes (N, 12, 6)."""
        if placed is None:
            return {}
        return {what: reading.slope(placed, axes) for what, reading in self._read.items()}


def completed(values: dict[Reads, Array], geometry: Array, count: int) -> dict[Reads, Array]:
    """Return the optional quantities, shape (N, entries), entries = 0 unless asked for.

    Args:
        values: what was read off the bodies.
        geometry: geometric quantities (10,).
        count: N.

    Raises:
        EvaluationError: the trunk is upside down at some instant.
    """
    if Reads.TRUNK in values and np.abs(values[Reads.TRUNK][:, ROLL]).max(initial=0.0) > np.pi / 2:
        raise EvaluationError("the trunk is upside down")  # its pitch then reads as if it were not
    found = {what: np.zeros((count, 0)) for what in OPTIONAL} | values
    if Reads.TRUNK in values:
        found[Reads.TRUNK] = values[Reads.TRUNK].copy()
        found[Reads.TRUNK][:, YAW] -= _HEADING * geometry[FOOT_YAW]
    return found


def chained(
    slopes: dict[Reads, ReadingSlope], motion: Array, foot_yaw: int | None
) -> dict[Reads, Array]:
    """Return the derivatives of the optional quantities in x, shape (N, entries, P).

    Args:
        slopes: local derivatives.
        motion: derivatives of the joint angles, shape (N, 12, P).
        foot_yaw: its place in x, if it is free.
    """
    found = {what: np.zeros((len(motion), 0, motion.shape[2])) for what in OPTIONAL}
    found |= {what: slope.jacobian @ motion for what, slope in slopes.items()}
    if foot_yaw is not None and Reads.TRUNK in slopes:
        found[Reads.TRUNK][:, YAW, foot_yaw] -= _HEADING
    return found
