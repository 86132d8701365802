"""Shapes that MeshCat's viewer draws: it stops at some Collada files, and the page with it."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from gaitopt.importers.meshes import up_axis

_GREY = np.array([0.62, 0.65, 0.68, 1.0])
_FACES = ("lines", "polygons", "polylist", "triangles", "trifans", "tristrips")


def drawable(shapes: pin.GeometryModel) -> pin.GeometryModel:
    """Return shapes with Collada files put so that the viewer draws them.

    A file whose z axis is up keeps the colours it gives. Of the others, which the viewer would turn
    by itself, and of files that it cannot merge, the triangles are drawn, in the colour that the
    robot's file gives; black, for want of a colour, becomes grey: on black no shape can be seen.
    """
    for item in shapes.geometryObjects:
        if not item.meshPath.lower().endswith(".dae"):
            continue
        root = _parsed(Path(item.meshPath))
        if root is not None and mergeable(root) and up_axis(item.meshPath) == "Z_UP":
            item.overrideMaterial = False
            continue
        item.meshPath = ""  # the triangles are there already, scaled
        item.meshScale = np.ones(3)
        if not item.meshColor[:3].any():
            item.meshColor = _GREY
    return shapes


def mergeable(root: Element) -> bool:
    """Whether the viewer can make one mesh of a Collada document.

    It merges all meshes, which must have the same attributes (normals, colours, textures).
    """
    attributes = set()
    for element in root.iter():
        if element.tag.rpartition("}")[2] in _FACES:
            inputs = (e for e in element if e.tag.endswith("input"))
            attributes.add(frozenset(e.get("semantic", "") for e in inputs))
    return len(attributes) == 1


def _parsed(path: Path) -> Element | None:
    try:
        return ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError):
        return None
