"""Collada files whose y axis is up, and files that viewers draw invisible.

Pinocchio takes the numbers of a Collada file as they are, whichever axis the file calls up. Many
robots are made for that, and their files say y only because some program wrote it there; others
mean it. Which of the two, the masses tell: the links' shapes lie about their centres of mass.

Opacity is written in four ways, and many programs wrote that of an opaque mesh as none.
"""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

_UPRIGHT = pin.SE3(np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]), np.zeros(3))
_NEARER = 0.8  # of the distance to the masses: symmetric shapes tell nothing and are left alone
_UNSEEN = 0.02  # opacity: less is what a program meant as opaque, glass has more


def unseen(model: Element) -> bool:
    """Tell whether a viewer that goes by the book draws nothing with a lighting model.

    Args:
        model: `phong` element, say, of a Collada document.
    """
    return _opacity(model) < _UNSEEN


def _opacity(model: Element) -> float:
    """Return the opacity of a lighting model (COLLADA 1.4.1, "Determining transparency")."""
    factor = _numbers(model, "transparency", "float")
    colour = _numbers(model, "transparent", "color")
    if not factor and not colour:
        return 1.0
    mode = next((e.get("opaque", "A_ONE") for e in _parts(model, "transparent")), "A_ONE")
    scale = factor[0] if factor else 1.0
    full = (*colour, 1.0, 1.0, 1.0, 1.0)[:4] if colour else (1.0, 1.0, 1.0, 1.0)
    part = full[3] if mode.startswith("A_") else full[0]
    return 1.0 - part * scale if mode.endswith("ZERO") else part * scale


def _numbers(model: Element, name: str, kind: str) -> list[float]:
    """Return the numbers of a part of a lighting model, none if it has no such part."""
    for part in _parts(model, name):
        for value in _parts(part, kind):
            try:
                return [float(word) for word in (value.text or "").split()]
            except ValueError:
                return []
    return []


def _parts(element: Element, name: str) -> Iterator[Element]:
    return (child for child in element if child.tag.rpartition("}")[2] == name)


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
