"""Rotor inertia and gear reduction of the motors of a URDF.

They stand in `<transmission>` elements, in `<gazebo reference="JOINT">` or in the joint. A rotor
that turns `reduction` times as fast as its joint weighs on the joint as inertia times reduction
squared (Siciliano et al., 2009, Robotics, section 7.2.1): the armature. ROS has the reduction in
the actuator or the joint, Drake has both numbers under names of its own; some have the armature
itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from gaitopt.escape import printable
from gaitopt.importers.urdf_document import Description
from gaitopt.importers.xml_document import FileProblem, NamedElement, XmlTree, as_number

_INERTIAS = ("motorinertia", "rotorinertia")
_ARMATURE = ("armature",)
_REDUCTIONS = ("mechanicalreduction", "gearratio", "gearreduction", "reductionratio")


@dataclass(frozen=True)
class Rotor:
    """What a motor's rotor adds to its joint.

    Attributes:
        joint: name of the joint.
        inertia: of the rotor about its own axis [kg·m²].
        reduction: turns of the rotor for one of the joint.
        given: whether the file has the reduction; else it is 1.
    """

    joint: str
    inertia: float
    reduction: float
    given: bool

    @property
    def armature(self) -> float:
        """Inertia seen from the joint [kg·m²]."""
        return self.inertia * self.reduction**2


def read_rotors(
    tree: XmlTree, robot: Description
) -> tuple[tuple[Rotor, ...], tuple[FileProblem, ...]]:
    """Return the rotors of a robot's motors, and those that belong to no single moving joint.

    Raises:
        RobotError: an inertia or the reduction that goes with it is no number, or there twice with
            different values.
    """
    rotors: list[Rotor] = []
    problems: list[FileProblem] = []
    for element in tree.root.iter("transmission"):
        entry = NamedElement(tree, element)
        if not _gives(element, _INERTIAS):
            continue
        parts = [(_plain(part.tag), part.get("name", "")) for part in element.iter()]
        names = list(dict.fromkeys(name for tag, name in parts if tag == "joint"))
        if reason := _unfit(names, sum(tag == "actuator" for tag, _ in parts), robot):
            text = f"its rotor inertia is not counted: {reason}"
            problems.append(entry.problem("rotor", text))
        else:
            rotors.append(_rotor(entry, names[0]))
    for element in tree.root:
        if element.tag in ("joint", "gazebo") and _gives(element, (*_INERTIAS, *_ARMATURE)):
            name = element.get("name" if element.tag == "joint" else "reference", "")
            if not _unfit([name], 1, robot):
                rotors.append(_rotor(NamedElement(tree, element), name))
    return tuple(rotors), tuple(problems)


def add_armature(model: pin.Model, rotors: Iterable[Rotor]) -> None:
    """Add the rotors of a robot to a model of it that is being made; those of one joint add up."""
    armature = np.array(model.armature)
    for rotor in rotors:
        armature[model.joints[model.getJointId(rotor.joint)].idx_v] += rotor.armature
    model.armature = armature


def _gives(element: Element, names: tuple[str, ...]) -> bool:
    return any(True for _ in _named(element, names))


def _unfit(names: list[str], actuators: int, robot: Description) -> str:
    """Return why a transmission adds no armature to one joint, or an empty string."""
    if len(names) != 1 or actuators > 1:
        return (
            f"it has {len(names)} joints and {actuators} actuators; give the armature of each "
            "joint ([[limits]] in the file for --choices)"
        )
    joint = robot.joints.get(names[0])
    if joint is None:
        return f"the robot has no joint '{printable(names[0])}'; correct the name"
    if joint.kind not in ("revolute", "continuous", "prismatic"):
        return f"joint '{printable(names[0])}' is {joint.kind}"
    return ""


def _rotor(entry: NamedElement, joint: str) -> Rotor:
    direct = _value(entry, _ARMATURE, "kg·m²") if entry.element.tag != "transmission" else None
    if direct is not None and direct >= 0.0:
        return Rotor(joint, direct, 1.0, True)
    inertia = direct if direct is not None else _value(entry, _INERTIAS, "kg·m²")
    reduction = _value(entry, _REDUCTIONS, "1")
    if inertia is None or inertia < 0.0:
        raise entry.refusal(f"its rotor inertia is {inertia} kg·m²; it must not be below 0")
    if reduction == 0.0:
        raise entry.refusal("its reduction is 0; a rotor turns with its joint; correct it")
    given = reduction is not None
    return Rotor(joint, inertia, 1.0 if reduction is None else reduction, given)


def _value(entry: NamedElement, names: tuple[str, ...], unit: str) -> float | None:
    """Return the one number that a transmission gives under some names, None if it gives none."""
    found: float | None = None
    for part, text in _named(entry.element, names):
        value = as_number(text)
        if not abs(value) < float("inf"):
            raise entry.refusal(
                f"<{part.tag}> is '{printable(text.strip())}'; it must be a finite number "
                f"[{unit}]; correct it",
                part,
            )
        if found is not None and value != found:
            raise entry.refusal(
                f"<{part.tag}> is {value:g}, but {found:g} is given as well; remove one", part
            )
        found = value
    return found


def _named(element: Element, names: tuple[str, ...]) -> Iterator[tuple[Element, str]]:
    """Yield elements of some names with the text of their value, and attributes as such."""
    for part in element.iter():
        tag = part.get("name", "") if part.tag == "param" else part.tag
        if _plain(tag) in names:
            yield part, part.get("value", part.text or "")
        for attribute, text in part.attrib.items():
            if _plain(attribute) in names:
                yield part, text


def _plain(name: str) -> str:
    """Return a name without prefix and underscores, in small letters."""
    return name.rpartition(":")[2].replace("_", "").replace("-", "").lower()
