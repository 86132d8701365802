"""Whether the masses and inertias of an MJCF file can belong to bodies."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element

import numpy as np

from gaitopt.nlp import Array
from gaitopt.robot.files.xml_lines import XmlTree
from gaitopt.robot.mjcf.defaults import Defaults, with_class
from gaitopt.robot.urdf.inertial import inertia_fault
from gaitopt.robot.urdf.values import Entry

_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}


def mass_from_geoms(root: Element) -> bool:
    """Return whether the geometries, not `inertial`, say what every body weighs."""
    return any(c.get("inertiafromgeom") == "true" for c in root.findall("compiler"))


def check_scaling(tree: XmlTree) -> None:
    """Refuse settings by which the masses of a document are not those of the robot.

    Args:
        tree: of a whole document, whose numbers are numbers.

    Raises:
        RobotError: naming the line and the setting.
    """
    for compiler in [Entry(tree, element) for element in tree.root.findall("compiler")]:
        total = compiler.element.get("settotalmass", "-1")
        if float(total) > 0.0:
            raise compiler.refusal(
                f"its settotalmass is {total} kg, which is not supported; scale the masses and "
                "inertias of the bodies to that sum, and remove it"
            )
        if compiler.element.get("balanceinertia") == "true":
            raise compiler.refusal(
                "its balanceinertia is 'true', which is not supported; correct the inertias that "
                "no body can have, and remove it"
            )


def check_inertial(body: Entry, from_geoms: bool) -> None:
    """Check the mass and the inertia of one body, whose numbers are numbers.

    One without inertia is a point mass.

    Args:
        body: that is checked.
        from_geoms: see `mass_from_geoms`.

    Raises:
        RobotError: no body can have them, or they would come from a mesh.
    """
    inertial = None if from_geoms else body.element.find("inertial")
    if inertial is None:
        if any("mesh" in geom.attrib for geom in body.element.findall("geom")):
            raise body.refusal("its mass would come from a mesh; give it an <inertial>")
        return
    mass = body.number(inertial, "mass", "mass", "kg")
    if mass < 0.0:
        raise body.refusal(f"the mass is {mass:g} kg; it must be above 0; correct it", inertial)
    given = [name for name in ("diaginertia", "fullinertia") if name in inertial.attrib]
    if len(given) > 1:
        raise body.refusal(
            "both diaginertia and fullinertia are given; give either diaginertia or fullinertia "
            "[kg·m²]",
            inertial,
        )
    fault = inertia_fault(mass, _tensor(inertial, given[0])) if given else ""
    if fault:
        raise body.refusal(fault, inertial)


def check_sizes(body: Entry, geoms: Mapping[Element, Mapping[str, str]]) -> None:
    """Check that the geometries of a body are as large as their type asks.

    Args:
        body: that is checked.
        geoms: attributes of every geometry with those of its class; see `complete_geoms`.

    Raises:
        RobotError: a size is missing or zero.
    """
    for geom in body.element.findall("geom"):
        values = geoms[geom]
        kind, text = values.get("type", "sphere"), values.get("size", "")
        needed = 0 if "mesh" in values else _SIZES.get(kind, 0)
        if "fromto" in values:
            needed = min(needed, 1)
        sizes = [float(word) for word in text.split()][:needed]
        if len(sizes) < needed or 0.0 in sizes:
            raise body.refusal(
                f"the size of a geom of type {kind} is '{text}'; it must begin with {needed} "
                "above 0 [m]; correct it",
                geom,
            )


def complete_geoms(root: Element) -> dict[Element, Mapping[str, str]]:
    """Return the attributes of every geometry, its own and those of its class."""
    defaults = Defaults.of(root)
    return {g: defaults.complete(g, childclass) for g, childclass in with_class(root, "geom")}


def _tensor(inertial: Element, name: str) -> Array:
    moments = [float(word) for word in inertial.attrib[name].split()]
    xx, yy, zz, xy, xz, yz = (*moments, 0.0, 0.0, 0.0)[:6]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
