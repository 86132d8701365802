"""Constraints beyond the paper, off unless asked for: how upright, how wide apart, how grippy.

They make a walk look human and keep a real robot whole. Section 3.2 has nothing of them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gaitopt.gait.families import Entries, Family, Linear, Torsion
from gaitopt.gait.rows import (
    FREE,
    LENGTH_SCALE,
    Setting,
    family_over_step,
    ground_rows,
    rows_once,
)
from gaitopt.gait.step import Reads
from gaitopt.gait.task import Margins
from gaitopt.mechanics.forward_kinematics import sole_tilt
from gaitopt.mechanics.leg_distance import leg_pairs
from gaitopt.mechanics.trunk import PITCH, ROLL, YAW

TORSION_SCALE = 20.0  # N.m
IMPULSE_TORSION_SCALE = 1.0  # N.m.s
LEAST_FORCE = 1.0  # N, where the centre of pressure is given up
LEAST_IMPULSE = 1e-3  # N.s, the same


def trunk_roll(at: Setting) -> Family:
    """Beyond section 3.2: |roll| of the trunk <= limit over the whole step."""
    return _trunk(at, "roll", ROLL, at.margins.trunk_roll)


def trunk_pitch(at: Setting) -> Family:
    """Beyond section 3.2: |pitch| of the trunk <= limit over the whole step."""
    return _trunk(at, "pitch", PITCH, at.margins.trunk_pitch)


def trunk_yaw(at: Setting) -> Family:
    """Beyond section 3.2: |yaw| of the trunk from the direction of travel <= limit."""
    return _trunk(at, "yaw", YAW, at.margins.trunk_yaw)


def torsion(at: Setting) -> Family:
    """Beyond (33): |moment about the vertical through the centre of pressure| <= c f_z."""
    rows = Torsion(at.margins.torsional_friction or 0.0, LEAST_FORCE)
    labels = ("torsional friction margin to the left", "torsional friction margin to the right")
    return ground_rows(at, "torsion", "3.2", rows, labels, 0.0, TORSION_SCALE, unit="N·m")


def impulse_torsion(at: Setting) -> Family:
    """Beyond (34): the same of the impulse on the landing foot."""
    rows = Torsion(at.margins.torsional_friction or 0.0, LEAST_IMPULSE)
    labels = tuple(f"impulse torsional friction margin to the {s}" for s in ("left", "right"))
    return rows_once(
        "impulse torsion", "3.2", Reads.IMPULSE, rows, labels, "N·m·s", 0.0, IMPULSE_TORSION_SCALE
    )


def leg_gap(at: Setting) -> Family:
    """Beyond (32): the capsules of the two legs keep apart over the whole step."""
    pairs = leg_pairs(at.robot)
    names = pairs.names
    rows = Entries(slice(0, len(names)), len(names))
    labels = tuple(f"gap between {name}" for name in names)
    return family_over_step(
        at, "leg gap", "3.2", Reads.LEG_GAPS, rows, labels, "m",
        lower=pairs.least(at.margins.leg_gap or 0.0), scale=LENGTH_SCALE,
    )  # fmt: skip


def swing_tilt(at: Setting) -> Family:
    """Beyond 3.2.3: the swing sole stays level and points ahead, within an angle (its sine).

    A foot upside down or turned about has the same sines; it does not point ahead and left.
    """
    limit = at.margins.swing_tilt or 0.0
    labels = (
        "swing foot roll", "swing foot pitch", "swing foot yaw",
        "swing foot pointing ahead", "swing foot upright",
    )  # fmt: skip
    bounds = np.array([limit, limit, limit, FREE, FREE])
    least = np.array([-limit, -limit, -limit, 0.0, 0.0])
    return family_over_step(
        at, "swing tilt", "3.2", Reads.CORNERS, Linear(sole_tilt(at.robot.sole.corners)), labels,
        "rad", lower=least, upper=bounds, scale=1.0,
    )  # fmt: skip


_SWITCHED: dict[str, tuple[Callable[[Setting], Family], ...]] = {
    "trunk_roll": (trunk_roll,),
    "trunk_pitch": (trunk_pitch,),
    "trunk_yaw": (trunk_yaw,),
    "torsional_friction": (torsion, impulse_torsion),
    "leg_gap": (leg_gap,),
    "swing_tilt": (swing_tilt,),
}
"""Field of `Margins` that switches constraints on by having a value."""


def switched_on(margins: Margins) -> tuple[Callable[[Setting], Family], ...]:
    """Return the makers of the constraints that the margins ask for."""
    asked = (makers for name, makers in _SWITCHED.items() if getattr(margins, name) is not None)
    return tuple(maker for makers in asked for maker in makers)


def _trunk(at: Setting, name: str, entry: int, limit: float | None) -> Family:
    bound = 0.0 if limit is None else limit
    return family_over_step(
        at, f"trunk {name}", "3.2", Reads.TRUNK, Entries(slice(entry, entry + 1), 3),
        (f"trunk {name}",), "rad", lower=-bound, upper=bound, scale=1.0,
    )  # fmt: skip
