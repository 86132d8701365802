"""Walk for another cost, without touching the package: squared torques and squared rates.

The integrand of a running cost is a function of the quantities at one instant, with exact first and
second derivatives; here it is a weighted sum of squares, which the package has.
"""

from dataclasses import dataclass

import numpy as np

from gaitopt import Robot, biped13, design_gait, preset_task, urdf_text
from gaitopt.gait import quantities
from gaitopt.gait.constraint import margin
from gaitopt.gait.costs import RunningCost, TorqueCost
from gaitopt.gait.functions import SquaredNorm


@dataclass(frozen=True)
class TorqueAndRate(RunningCost):
    """J = (1 / d) integral of Gamma' Gamma + weight dq' dq dt."""

    name = "torque and rate"
    unit = "N²·m·s"
    words = "squared torque and rate per metre"
    reads = (quantities.TORQUE, quantities.RATES)

    weight: float = margin(50.0, "Weight of the rates.", "the weight", "N²·m²·s²", least=0.0)

    def integrand(self, robot):
        """Return the weighted sum of squares of torques and rates, side by side."""
        joints = len(robot.joint_names)
        return SquaredNorm(np.repeat([1.0, self.weight], joints))


robot = Robot.from_urdf(urdf_text(biped13()))
print("cost             torque²  largest torque   largest rate")
for cost in (TorqueCost(), TorqueAndRate(weight=50.0), TorqueAndRate(weight=200.0)):
    gait = design_gait(robot, preset_task("standard", robot, speed=0.8, cost=cost)).gait
    effort = float(np.trapezoid((gait.torque**2).sum(axis=1), gait.time)) / gait.step_length
    print(
        f"{cost.name:16} {effort:7.0f} {abs(gait.torque).max():10.1f} N·m "
        f"{abs(gait.dq).max():8.2f} rad/s"
    )
