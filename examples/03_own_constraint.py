"""Add a constraint without touching the package: the knees may turn no faster than a limit.

A constraint is declared once. Its rows, names in messages, the certificate, the limits between the
samples and, since the margin says how it may be loosened, the diagnosis follow from that.
"""

from dataclasses import dataclass

import numpy as np

from gaitopt import Robot, biped13, design_gait, preset_task, urdf_text
from gaitopt.gait import quantities
from gaitopt.gait.constraint import Constraint, margin
from gaitopt.gait.functions import Linear


@dataclass(frozen=True)
class KneeSpeed(Constraint):
    """|rate| of both knees <= knee_speed."""

    name = "knee speed"
    unit = "rad/s"
    words = "speed of the knees"
    reads = (quantities.RATES,)

    knee_speed: float = margin(
        4.0, "Highest speed of the knees.", "the speed limit of the knees", "rad/s",
        above=0.0, relax=(20.0, 0.1),
    )  # fmt: skip

    def block(self, context):
        """Return two rows, one for each knee."""
        names = context.robot.joint_names
        knees = [i for i, name in enumerate(names) if name.endswith("knee")]
        return self.over_step(
            context,
            Linear(np.eye(len(names))[knees]),
            tuple(f"{names[i]} speed" for i in knees),
            lower=-self.knee_speed,
            upper=self.knee_speed,
            scale=self.knee_speed,
        )


robot = Robot.from_urdf(urdf_text(biped13()))
print("knees at most   cost")
for limit in (None, 5.0, 4.0):
    own = () if limit is None else (KneeSpeed(knee_speed=limit),)
    found = design_gait(robot, preset_task("standard", robot, speed=0.8, constraints=own))
    knee = max(
        abs(found.gait.dq[:, [i for i, n in enumerate(robot.joint_names) if "knee" in n]]).max(
            axis=0
        )
    )
    asked = "any" if limit is None else f"{limit:.1f}"
    print(
        f"{asked:>5} rad/s  {found.gait.cost:8.1f} N²·m·s, fastest knee {knee:.2f} rad/s, "
        f"{found.certificate.verdict}"
    )
