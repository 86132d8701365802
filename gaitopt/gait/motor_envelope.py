"""The envelope of the motors: peak torque and voltage line of each joint that has a motor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitopt.actuators.motors import JointMotor, joint_motors, joint_motors_of
from gaitopt.gait import quantities
from gaitopt.gait.constraint import Constraint, ConstraintBlock, ConstraintContext
from gaitopt.gait.functions import Linear


@dataclass(frozen=True)
class MotorEnvelope(Constraint):
    """|torque| <= peak, and |torque / stall torque + rate / no-load speed| <= 1.

    The second is the voltage line: where torque and rate have the same sign, the motor needs
    voltage for both; where it brakes, it needs less.

    Attributes:
        motors: what the motors can do at their joints; joints without one are free.
    """

    name, unit, words = "motor envelope", "1", "share of the envelope of the motors"
    reads = (quantities.TORQUE, quantities.RATES)
    motors: tuple[JointMotor, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "motors", joint_motors_of(self.motors))

    def asked(self, context: ConstraintContext) -> bool:
        """Return whether there are motors."""
        del context
        return bool(self.motors)

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        """Return two rows for each joint with a motor.

        Raises:
            SpecError: a pattern fits no joint, or a pair has different motors.
        """
        names = context.robot.joint_names
        found = joint_motors(self.motors, names, context.robot.mirror)
        rows, labels = [], []
        for k, one in enumerate(found):
            if one is not None:
                peak, line = np.zeros((2, 2 * len(names)))
                peak[k] = 1.0 / one.peak_torque
                line[k], line[len(names) + k] = 1.0 / one.stall_torque, 1.0 / one.no_load_speed
                rows += [peak, line]
                labels += [f"{names[k]} peak of the motor", f"{names[k]} voltage of the motor"]
        return self.over_step(context, Linear(np.array(rows)), tuple(labels), lower=-1.0, upper=1.0)
