"""Collada files whose y axis is up: whether a robot wants their meshes turned, and the turn.

Pinocchio takes the numbers of a Collada file as they are, whichever axis the file calls up. Many
robots are made for that, and their files say y only because some program wrote it there; others
mean it. Which of the two, the masses tell: the links' shapes lie about their centres of mass.
"""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

_UPRIGHT = pin.SE3(np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]), np.zeros(3))
_NEARER = 0.8  # of the distance to the masses: symmetric shapes tell nothing and are left alone


def up_axis(path: str) -> str:
    """Return the upward axis of a Collada file: "Y_UP" unless it says otherwise, "" if unreadable.

    Args:
        path: of the file.
    """
    try:
        with open(path, "rb") as stream:
            for _, element in ElementTree.iterparse(stream):
                name = element.tag.rpartition("}")[2]
                if name == "up_axis":
                    return (element.text or "").strip()
                if name == "asset":  # which holds it, and comes first
                    break
    except (OSError, ElementTree.ParseError):
        return ""
    return "Y_UP"


def y_up(shapes: pin.GeometryModel) -> list[pin.GeometryObject]:
    """Return the shapes from Collada files that call their y axis up."""
    return [
        item
        for item in shapes.geometryObjects
        if item.meshPath.lower().endswith(".dae") and up_axis(item.meshPath) == "Y_UP"
    ]


def lie_on_side(shapes: pin.GeometryModel, model: pin.Model) -> bool:
    """Tell whether the shapes of `y_up` are clearly nearer to the masses when they are turned.

    Args:
        shapes: all of a robot.
        model: that they belong to.
    """
    as_read, turned = 0.0, 0.0
    for item in y_up(shapes):
        inertia = model.inertias[item.parentJoint]
        if inertia.mass > 0.0:
            item.geometry.computeLocalAABB()
            middle = np.ravel(item.geometry.aabb_center)
            as_read += float(np.linalg.norm(item.placement.act(middle) - inertia.lever))
            upright = (item.placement * _UPRIGHT).act(middle)
            turned += float(np.linalg.norm(upright - inertia.lever))
    return turned < _NEARER * as_read


def put_upright(shapes: pin.GeometryModel) -> None:
    """Turn the shapes of `y_up` so that their z axis is up."""
    for item in y_up(shapes):
        item.placement = item.placement * _UPRIGHT
