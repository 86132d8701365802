"""The margins that can be turned: what each is to a person, how far, and what it relaxes."""

from __future__ import annotations

ROUGHEST = 2.0  # coefficient of friction of rubber on rough concrete
SINKING = -0.05  # m/s: a rear foot that sinks faster has not lifted off
TILTED = 1.0  # rad: no trunk is asked to lean or turn farther
GRIPPIEST = 0.5  # m: torsional friction of a foot far larger than any biped's

MARGINS: tuple[tuple[str, str, str, float, float, tuple[str, ...]], ...] = (
    (
        "friction",
        "the coefficient of friction",
        "",
        ROUGHEST,
        0.1,
        ("friction", "impulse friction"),
    ),
    ("minimum_load", "the least vertical ground force", "N", 0.0, -100.0, ("load",)),
    ("cop_margin", "the margin of the centre of pressure", "m", 0.0, -0.01, ("cop", "impulse cop")),
    ("clearance", "the clearance of the swing foot", "m", 0.0, -0.1, ("clearance",)),
    ("lateral_gap", "the gap between the feet", "m", 0.0, -0.1, ("lateral",)),
    ("knee_flexion", "the least bend of the knees", "rad", 0.0, -0.3, ("knee",)),
    ("leg_extension", "the largest extension of the legs", "", 1.0, 0.01, ("leg length",)),
    (
        "liftoff_speed",
        "the least lift-off speed of the rear foot",
        "m/s",
        SINKING,
        -0.1,
        ("lift-off",),
    ),
    ("trunk_roll", "the largest sideways lean of the trunk", "rad", TILTED, 0.3, ("trunk roll",)),
    (
        "trunk_pitch",
        "the largest lean of the trunk forward or back",
        "rad",
        TILTED,
        0.3,
        ("trunk pitch",),
    ),
    ("trunk_yaw", "the largest turn of the trunk", "rad", TILTED, 0.3, ("trunk yaw",)),
    (
        "torsional_friction",
        "the coefficient of torsional friction",
        "m",
        GRIPPIEST,
        0.01,
        ("torsion", "impulse torsion"),
    ),
    ("swing_tilt", "the largest tilt of the swing foot", "rad", TILTED, 0.3, ("swing tilt",)),
    ("leg_gap", "the gap between the bodies of the legs", "m", 0.0, -0.1, ("leg gap",)),
)
"""Field of `Margins`, words, unit, farthest value, signed change that matters, families."""

COUPLED = {
    "friction": (("friction", "load", 1.0), ("impulse friction", "impulse", 1.0)),
    "cop_margin": (("cop", "load", -1.0), ("impulse cop", "impulse", -1.0)),
    "torsional_friction": (("torsion", "load", 1.0), ("impulse torsion", "impulse", 1.0)),
}
"""Margins that multiply the vertical force or impulse: family, row of that force, sign."""
