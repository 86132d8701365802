"""Sizes of a robot by which its lengths, forces and times are measured.

Numbers that were found to suit the thirteen-link biped, as how far rows are scaled and how high a
first guess lifts the foot, suit robots of another size in proportion: a robot twice as long, eight
times as heavy walks as its model does, and the same search finds that walk (dynamic similarity;
Alexander, 1989, Physiological Reviews 69(4), 1199-1227).
"""

from __future__ import annotations

from math import sqrt

from gaitopt.dataclass import dataclass
from gaitopt.importers.physics import STANDARD_GRAVITY

REACH = 0.6
"""Of the thirteen-link biped, from hip to ankle [m]; tolerances in metres are those of its size."""
_WEIGHT = 56.87 * STANDARD_GRAVITY  # N: its own


@dataclass(frozen=True)
class Scales:
    """How many times larger a robot's lengths, forces and times are than the biped's.

    Attributes:
        length: of the leg from hip to ankle [m/m].
        force: weight [N/N].
        time: of a pendulum as long as the leg [s/s].
    """

    length: float = 1.0
    force: float = 1.0
    time: float = 1.0

    @classmethod
    def of_robot(cls, reach: float, weight: float, gravity: float) -> Scales:
        """Return the scales of a leg's length [m], a weight [N] and an acceleration [m/s²]."""
        length = reach / REACH
        return cls(length, weight / _WEIGHT, sqrt(length * STANDARD_GRAVITY / gravity))

    def of_unit(self, unit: str) -> float:
        """Return the factor of a unit as "m/s"; 1 for units of other kinds."""
        return {
            "m": self.length, "s": self.time, "N": self.force, "m/s": self.speed,
            "rad/s": self.rate, "N·m": self.moment, "N·s": self.impulse,
            "N·m·s": self.angular_impulse, "rad/s²": self.rate**2,
        }.get(unit, 1.0)  # fmt: skip

    @property
    def speed(self) -> float:
        """Of speeds."""
        return self.length / self.time

    @property
    def rate(self) -> float:
        """Of angular velocities."""
        return 1.0 / self.time

    @property
    def moment(self) -> float:
        """Of moments and torques."""
        return self.force * self.length

    @property
    def impulse(self) -> float:
        """Of impulses."""
        return self.force * self.time

    @property
    def angular_impulse(self) -> float:
        """Of moments of impulses."""
        return self.moment * self.time


BIPED = Scales()
"""Of the thirteen-link biped itself."""
