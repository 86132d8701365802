"""Continuous joints as revolute joints without a range.

Pinocchio gives a continuous joint two coordinates, cosine and sine of its angle. In a leg its angle
itself is wanted, as that of every other joint.
"""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin

_FAR = 1e300  # rad: stands for an angle without end, which the loader does not read


def make_revolute(joint: Element) -> None:
    """Turn a continuous joint into a revolute one without end, others are left as they are.

    Args:
        joint: element of a URDF that was checked.
    """
    if joint.get("type") != "continuous":
        return
    joint.set("type", "revolute")
    limit = joint.find("limit")
    if limit is None:
        limit = SubElement(joint, "limit")
    limit.attrib.update(lower=repr(-_FAR), upper=repr(_FAR))


def without_end(model: pin.Model) -> pin.Model:
    """Return a model whose joints that were continuous have infinite ranges; it is changed."""
    for name, far in (("lowerPositionLimit", -_FAR), ("upperPositionLimit", _FAR)):
        values = np.array(getattr(model, name))
        setattr(model, name, np.where(values == far, math.copysign(math.inf, far), values))
    return model
