"""What the `<dynamics>` elements of a URDF say, as Pinocchio has read them."""

from __future__ import annotations

import pinocchio as pin

from gaitopt.robot.physics import PassiveJoint


def urdf_dynamics(model: pin.Model) -> dict[str, PassiveJoint]:
    """Return damping and Coulomb friction of the joints that have some, by name.

    Args:
        model: read from the URDF.
    """
    joints = {}
    for index in range(2, model.njoints):
        row = model.joints[index].idx_v
        joint = PassiveJoint(
            damping=(float(model.damping[row]),), friction=float(model.upperDryFrictionLimit[row])
        )
        if not joint.idle:
            joints[str(model.names[index])] = joint
    return joints
