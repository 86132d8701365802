"""The Pinocchio model of a URDF, made from its values without a loader between, with its rotors.

Pinocchio's own loader drops what it cannot parse (a mass with a blank behind it leaves a body
without mass) and looks for joints and links by name among names of its own ("universe",
"root_joint"). Here every value of the file goes into the model, or the file was refused.

Rotor inertia and gear reduction of motors stand in `<transmission>` elements, in
`<gazebo reference="JOINT">` or in the joint. A rotor that turns `reduction` times as fast as its
joint weighs on the joint as inertia times reduction squared (Siciliano et al., 2009, Robotics,
section 7.2.1): the armature. ROS has the reduction in the actuator or the joint, Drake has both
numbers under names of its own; some have the armature itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from gaitopt.bounds import ARMATURE
from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.escape import printable
from gaitopt.importers.pinocchio_model import joint_model, sound_inertia
from gaitopt.importers.urdf_document import Description, Inertial, Joint, Link
from gaitopt.importers.xml_document import FileProblem, NamedElement, XmlTree, as_number
from gaitopt.nlp import Array
from gaitopt.units import motion_words

WORLD, ROOT_JOINT = "universe", "root_joint"
"""Names of Pinocchio's own: the world, and the joint that carries the root link."""
_INERTIAS = ("motorinertia", "rotorinertia")
_ARMATURE = ("armature",)
_REDUCTIONS = ("mechanicalreduction", "gearratio", "gearreduction", "reductionratio")
_TAKEN_MARK = " (fixed)"  # marks a frame whose name is taken


def model_of_urdf(robot: Description) -> pin.Model:
    """Return the model of a robot; joint 1 is a free-flyer that carries the root link.

    Joints, frames and their order are those of Pinocchio's loader, save that a continuous joint is
    a revolute one without a range: its angle is wanted, not the cosine and sine of it. Limits that
    are not given are infinite; friction and damping are in the model too.

    Raises:
        RobotError: it has no link that can move.
    """
    model = pin.Model()
    model.name = robot.name
    root = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), ROOT_JOINT)
    frame = model.addJointFrame(root, 0)
    below = robot.below
    waiting: list[tuple[Joint | None, str, int]] = [(None, robot.root, frame)]
    while waiting:
        joint, name, parent = waiting.pop()
        if joint is not None:
            parent = _add_joint(model, joint, parent)
        at = _add_link(model, robot.links[name], parent)
        waiting += [(child, child.child, at) for child in reversed(below[name])]
    if model.njoints < 2:
        raise RobotError("the robot has no links that can move; check the file")
    return model


def refuse_taken(robot: Description) -> None:
    """Refuse links and moving joints that bear a name of Pinocchio's own, which finds them by name.

    Raises:
        RobotError: naming the line.
    """
    moving = [joint.entry for joint in robot.joints.values() if joint.kind != "fixed"]
    links = [link.entry for link in robot.links.values() if link.name == WORLD]
    for entry in [*links, *(each for each in moving if each.name in (WORLD, ROOT_JOINT))]:
        raise entry.refusal("this name stands for something else in every robot; rename it")


def body(inertial: Inertial | None) -> pin.Inertia:
    """Return the inertia of a link in its own frame."""
    inertia = pin.Inertia.Zero()
    if inertial is not None:
        turn = inertial.pose.rotation
        # Set one by one: a body of an arm may be impossible, which its constructor refuses.
        inertia.mass = inertial.mass
        inertia.lever = inertial.pose.translation
        inertia.inertia = turn @ sound_inertia(inertial.mass, inertial.inertia) @ turn.T
    return inertia


def _add_link(model: pin.Model, link: Link, parent: int) -> int:
    """Add a link at a frame and return its own frame."""
    inertia, at = body(link.inertial), model.frames[parent]
    place = pin.SE3.Identity() if at.type == pin.FrameType.JOINT else at.placement
    frame = pin.Frame(link.name, at.parentJoint, parent, place, pin.FrameType.BODY, inertia)
    return int(model.addFrame(frame, True))


def _add_joint(model: pin.Model, joint: Joint, parent: int) -> int:
    """Add a joint below the frame of its parent link and return its own frame."""
    at = model.frames[parent]
    place = at.placement * joint.pose
    if joint.kind == "fixed":
        kind = pin.FrameType.FIXED_JOINT
        name = joint.name + (_TAKEN_MARK if joint.name in (WORLD, ROOT_JOINT) else "")
        frame = pin.Frame(name, at.parentJoint, parent, place, kind)
        return int(model.addFrame(frame, False))
    moving = _joint_model(joint)
    new = model.addJoint(at.parentJoint, moving, place, joint.name, *_bounds(joint))
    return int(model.addJointFrame(new, parent))


def _joint_model(joint: Joint) -> pin.JointModel:
    if joint.kind == "floating":
        return pin.JointModelFreeFlyer()
    if joint.kind == "planar":
        return pin.JointModelPlanar()
    return joint_model(np.array(joint.axis), joint.kind == "prismatic")


def _bounds(joint: Joint) -> tuple[Array, ...]:
    """Limits in the order of `pin.Model.addJoint`: effort, rate, range, friction, damping."""
    if joint.kind in ("floating", "planar"):
        return ()
    effort, velocity = (np.array([value]) for value in joint.strength)
    lower, upper = (np.array([value]) for value in joint.range)
    friction, damping = np.array([joint.friction]), np.array([joint.damping])
    return (-effort, effort, -velocity, velocity, lower, upper, -friction, friction, damping)


@dataclass(frozen=True)
class Rotor:
    """What a motor's rotor adds to its joint.

    Attributes:
        joint: name of the joint.
        inertia: of the rotor about its own axis [kg·m²].
        reduction: turns of the rotor for one of the joint; radians for a metre if that slides.
        given: whether the file has the reduction; else it is 1.
        unit: of the inertia seen from the joint, kg·m², or kg if the joint slides.
    """

    joint: str
    inertia: float
    reduction: float
    given: bool
    unit: str

    @property
    def armature(self) -> float:
        """Inertia seen from the joint [kg·m²; kg]."""
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
            rotors.append(_rotor(entry, names[0], robot))
    for element in tree.root:
        if element.tag in ("joint", "gazebo") and _gives(element, (*_INERTIAS, *_ARMATURE)):
            name = element.get("name" if element.tag == "joint" else "reference", "")
            if not _unfit([name], 1, robot):
                rotors.append(_rotor(NamedElement(tree, element), name, robot))
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


def _rotor(entry: NamedElement, joint: str, robot: Description) -> Rotor:
    unit = motion_words("kg·m²", slides=robot.joints[joint].kind == "prismatic")
    rotor = _rotor_as_written(entry, joint, unit)
    if rotor.armature > ARMATURE:
        raise entry.refusal(
            f"seen from its joint its rotor has {rotor.armature:g} {unit} (inertia times the "
            f"reduction squared); at most {ARMATURE:g} {unit}; correct it"
        )
    return rotor


def _rotor_as_written(entry: NamedElement, joint: str, unit: str) -> Rotor:
    direct = _value(entry, _ARMATURE, unit) if entry.element.tag != "transmission" else None
    if direct is not None and direct >= 0.0:
        return Rotor(joint, direct, 1.0, True, unit)
    inertia = direct if direct is not None else _value(entry, _INERTIAS, "kg·m²")
    reduction = _value(entry, _REDUCTIONS, "1")
    if inertia is None or inertia < 0.0:
        raise entry.refusal(f"its rotor inertia is {inertia} kg·m²; it must not be below 0")
    if reduction == 0.0:
        raise entry.refusal("its reduction is 0; a rotor turns with its joint; correct it")
    given = reduction is not None
    return Rotor(joint, inertia, 1.0 if reduction is None else reduction, given, unit)


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
