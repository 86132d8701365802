"""Where the gaits of a sweep change from one family of optima to another."""

from __future__ import annotations

import numpy as np

from gaitopt.nlp import Array

_HALF = 0.5  # of its range: a larger jump of a motor between neighbours may be a change of family
_STEEPER = 3.0  # times the motor's other steps: less may be a steep curve
_LARGE = 0.25  # of the largest torque: motors that vary less do not decide


def branch_cuts(torques: Array) -> list[int]:
    """Return the rows before which a family of optima ends.

    One does where the peak torque of a motor jumps by more than half of its range, and by far more
    than between any other neighbours; a few gaits far apart cannot tell, and are left together.

    Args:
        torques: peaks of the motors (columns) of neighbouring gaits (rows) [N·m]; a motor with a
            NaN is passed over.
    """
    known = torques[:, np.isfinite(torques).all(axis=0)]
    if known.shape[0] < 3 or known.shape[1] == 0:
        return []
    spread = np.ptp(known, axis=0)
    steps = np.abs(np.diff(known, axis=0))
    jumps = steps > _HALF * spread
    others = np.where(jumps, 0.0, steps).max(axis=0)
    decides = spread > _LARGE * np.abs(known).max()
    found = jumps & (steps > _STEEPER * others) & (others > 0.0) & decides
    return [int(row) + 1 for row in np.flatnonzero(found.any(axis=1))]
