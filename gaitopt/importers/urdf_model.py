"""The Pinocchio model of a URDF, made from its values without a loader between, with its rotors.

Pinocchio's own loader drops what it cannot parse (a mass with a blank behind it leaves a body
without mass) and looks for joints and links by name among names of its own ("universe",
"root_joint"). Here every value of the file goes into the model, or the file was refused.

Rotor inertia and gear reduction of motors stand in `<transmission>` elements, in `<gazebo
reference="JOINT">` or in the joint. A rotor that turns `reduction` times as fast as its joint
weighs on the joint as inertia times reduction squared (Siciliano et al., 2009, Robotics, section
7.2.1): the armature. ROS has the reduction in the actuator or the joint, Drake has both numbers
under names of its own; some have the armature itself.

So it is with what is drawn and touched, the geometry. Motion needs no shape: one that cannot be
read, or whose mesh cannot, costs itself alone, and is told.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator
from typing import Literal
from xml.etree.ElementTree import Element

import coal
import numpy as np
import pinocchio as pin

from gaitopt.bounds import ARMATURE
from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError, did_you_mean
from gaitopt.escape import printable
from gaitopt.importers.meshes import MeshPaths, MeshProblem, silenced, unreadable
from gaitopt.importers.pinocchio_model import joint_model, rigid_body, sound_inertia
from gaitopt.importers.report import listed
from gaitopt.importers.urdf_document import (
    FREE_TYPES,
    Description,
    Inertial,
    Joint,
    Link,
    Vector,
    check_attributes,
    read_origin,
    read_version,
)
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
    if inertial is None:
        return pin.Inertia.Zero()
    turn = inertial.pose.rotation
    inertia = turn @ sound_inertia(inertial.mass, inertial.inertia) @ turn.T
    return rigid_body(inertial.mass, inertial.pose.translation, inertia)


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
    if joint.kind in FREE_TYPES:
        moving = pin.JointModelFreeFlyer() if joint.kind == "floating" else pin.JointModelPlanar()
    else:
        moving = joint_model(np.array(joint.axis), joint.kind == "prismatic")
    new = model.addJoint(at.parentJoint, moving, place, joint.name, *_bounds(joint))
    return int(model.addJointFrame(new, parent))


def _bounds(joint: Joint) -> tuple[Array, ...]:
    """Limits in the order of `pin.Model.addJoint`: effort, rate, range, friction, damping."""
    if joint.kind in FREE_TYPES:
        return ()
    given = np.array([joint.limits.effort, joint.limits.velocity])
    effort, velocity = np.where(np.isnan(given), np.inf, given)[:, None]
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
            entry = NamedElement(tree, element)
            if reason := _unfit([name], 1, robot):
                problems.append(entry.problem("rotor", f"its armature is not counted: {reason}"))
            else:
                rotors.append(_rotor(entry, name, robot))
    return tuple(rotors), tuple(problems)


def add_armature(model: pin.Model, rotors: Iterable[Rotor]) -> None:
    """Add the rotors of a robot to a model of it that is being made; those of one joint add up."""
    for rotor in rotors:
        model.armature[model.joints[model.getJointId(rotor.joint)].idx_v] += rotor.armature


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
        hint = did_you_mean(names[0], robot.joints)
        return f"the robot has no joint '{printable(names[0])}'; {hint}correct the name"
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


Kind = Literal["visual", "collision"]
Colour = tuple[float, ...]
"""Red, green, blue and opacity, each from 0 to 1."""
KINDS: tuple[Kind, Kind] = ("visual", "collision")
GREY = (0.9, 0.9, 0.9, 1.0)
Loader = Callable[[str, Array], coal.CollisionGeometry]
"""Reads a mesh file at a scale."""
_GEOMETRY_TAGS = ("box", "sphere", "cylinder", "capsule", "mesh")
_MOST_PARTS = {"origin": 1, "geometry": 1, "material": 1}


@dataclass(frozen=True, eq=False)
class Shape:
    """A shape that can be drawn or touched.

    Attributes:
        link: that it belongs to.
        kind: what it is for.
        element: `visual` or `collision` element of the file.
        pose: in the link.
        form: "box", "sphere", "cylinder", "capsule" or "mesh".
        size: edges of a box, radius and length of the others, scale of a mesh [m, 1].
        file: of the mesh, as the robot's file gives it.
        colour: that the file gives it, None if it gives none.
    """

    link: str
    kind: Kind
    element: Element
    pose: pin.SE3
    form: str
    size: tuple[float, ...]
    file: str = ""
    colour: Colour | None = None


def read_shapes(tree: XmlTree) -> tuple[tuple[Shape, ...], list[FileProblem]]:
    """Return the shapes of a URDF, read without any mesh, in the order of the file.

    One problem tells of all that cannot be drawn or touched, one of all materials at fault.
    """
    version = read_version(tree)
    lost: list[FileProblem] = []
    odd: list[FileProblem] = []
    known = _named_colours(tree, odd)
    shapes = []
    for element in tree.root.findall("link"):
        owner = NamedElement(tree, element)
        for kind in KINDS:
            for part in element.findall(kind):
                try:
                    pose, form, size, file = _form(owner, part, version)
                except RobotError as error:
                    text = str(error).partition(": ")[2]
                    lost.append(FileProblem("shape", owner.name, text, tree.line(part)))
                    continue
                colour = _colour(owner, part, known, odd) if kind == "visual" else None
                shapes.append(Shape(owner.name, kind, part, pose, form, size, file, colour))
    return tuple(shapes), [*_merged(lost, ": it is left out"), *_merged(odd)]


def _form(
    owner: NamedElement, part: Element, version: tuple[int, ...]
) -> tuple[pin.SE3, str, tuple[float, ...], str]:
    """Return pose, form, size and mesh of a shape; raise with the reason if it has none."""
    what = f"the origin of its {part.tag}"
    for tag, most in _MOST_PARTS.items():
        if len(part.findall(tag)) > most:
            raise owner.refusal(f"its {part.tag} has {len(part.findall(tag))} <{tag}>", part)
    geometry = part.find("geometry")
    forms = [] if geometry is None else [e for e in geometry if e.tag in _GEOMETRY_TAGS]
    if len(forms) != 1 or geometry is None or len(geometry) != 1:
        named = [printable(e.tag) for e in ([] if geometry is None else geometry)]
        found = f"has <{'>, <'.join(named)}>" if named else "has nothing"
        allowed = f"one of {', '.join(_GEOMETRY_TAGS)}"
        raise owner.refusal(f"the geometry of its {part.tag} {found}; it must be {allowed}", part)
    form, origin = forms[0], part.find("origin")
    if origin is not None:
        check_attributes(owner, origin)
    pose = read_origin(owner, origin, what, version)
    return pose, form.tag, _size(owner, form, part.tag), form.get("filename", "")


def _size(owner: NamedElement, form: Element, kind: str) -> tuple[float, ...]:
    what = f"of the {form.tag} of its {kind}"
    if form.tag == "mesh":
        if not form.get("filename"):
            raise owner.refusal(f"the mesh of its {kind} names no file", form)
        scale = owner.vector(form, "scale", f"the scale {what}", "1 1 1")
        if not all(scale):
            raise owner.refusal(f"the scale {what} is {form.get('scale')!r}; none may be 0", form)
        return scale
    if form.tag == "box":
        size: Vector = owner.vector(form, "size", f"the size {what}", "")
        if min(size) < 0.0 or sorted(size)[1] <= 0.0:  # a plate is seen, a needle is not
            raise owner.refusal(f"the size {what} is {form.get('size')!r}; give edges [m]", form)
        return size
    radius = owner.number(form, "radius", f"radius {what}", "m")
    length = 0.0
    if form.tag != "sphere":
        length = owner.number(form, "length", f"length {what}", "m")
    if radius <= 0.0 or length < 0.0:
        given = f"radius {radius:g} m" + (f" and length {length:g} m" if length else "")
        raise owner.refusal(f"the {form.tag} of its {kind} has {given}; give both above 0", form)
    return radius, length


def _named_colours(tree: XmlTree, odd: list[FileProblem]) -> dict[str, Colour]:
    """Return the colours of the robot's own materials; shapes may use them, and name more."""
    found: dict[str, Colour] = {}
    for element in tree.root.findall("material"):
        owner, name = NamedElement(tree, element), element.get("name", "")
        colour = _rgba(owner, element, odd)
        if not name:
            text = "a material of the robot has no name; no shape can use it"
            odd.append(owner.problem("shape", text, element))
        elif colour is not None:
            found.setdefault(name, colour)
    return found


def _colour(
    owner: NamedElement, part: Element, known: dict[str, Colour], odd: list[FileProblem]
) -> Colour | None:
    """Return the colour of a shape: that of the first material of its name, or its own."""
    element = part.find("material")
    if element is None:
        return None
    name = element.get("name", "")
    if name in known:
        return known[name]
    colour = _rgba(owner, element, odd)
    if not name:
        text = "the material of its visual has no name; its colour is used"
        odd.append(owner.problem("shape", text, element))
    elif colour is not None:
        known[name] = colour
    return colour


def _rgba(owner: NamedElement, element: Element, odd: list[FileProblem]) -> Colour | None:
    colour = element.find("color")
    if colour is None:
        return None
    try:
        values = owner.numbers(colour, "rgba", "the rgba of a material", 4)
    except RobotError as error:
        text = str(error).partition(": ")[2].removesuffix("; correct it")
        text += "; the shape is drawn grey"
        odd.append(FileProblem("shape", owner.name, text, owner.tree.line(colour)))
        return None
    return tuple(min(max(value, 0.0), 1.0) for value in values)


def _merged(problems: list[FileProblem], consequence: str = "") -> list[FileProblem]:
    """Return one problem that speaks for all: of the first, with the places of the others."""
    if not problems:
        return []
    first, others = problems[0], problems[1:]
    text = first.text.removesuffix("; correct it") + consequence
    if others:
        places = dict.fromkeys(f"'{printable(p.name)}' (line {p.line})" for p in others)
        text += f"; the same or the like holds for {listed(places, 3, '')}"
    return [FileProblem("shape", first.name, text, first.line, first.file)]


def build_geometry(
    model: pin.Model,
    shapes: Iterable[Shape],
    paths: MeshPaths,
    load: Loader,
    links: Collection[str] | None = None,
) -> tuple[pin.GeometryModel, list[MeshProblem]]:
    """Return the geometry of a model, and the meshes that turned out to be unreadable."""
    geometry, lost = pin.GeometryModel(), []
    frames = {f.name: i for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY}
    counts: Counter[str] = Counter()
    for shape in shapes:
        if shape.link not in frames or not (links is None or shape.link in links):
            continue
        if _mesh_problem(shape, paths) is not None:
            continue
        file = str(paths.find(shape.file)) if shape.form == "mesh" else ""
        form = _collision_geometry(shape, file, load)
        if form is None:
            reason = "is not a mesh that can be read"
            lost.append(MeshProblem(shape.link, shape.kind, shape.file, reason, there=True))
            continue
        link = model.frames[frames[shape.link]]
        item = pin.GeometryObject(
            f"{shape.link}_{counts[shape.link]}",
            link.parentJoint,
            frames[shape.link],
            link.placement * shape.pose,
            form,
            file,
            np.array(shape.size if shape.form == "mesh" else (1.0, 1.0, 1.0)),
            shape.colour is not None,
            np.array(shape.colour or GREY),
        )
        geometry.addGeometryObject(item)
        counts[shape.link] += 1
    return geometry, lost


def mesh_problems(shapes: Iterable[Shape], paths: MeshPaths) -> list[MeshProblem]:
    """Return the meshes of a robot that cannot be used, in the order of the file."""
    found = (_mesh_problem(shape, paths) for shape in shapes)
    return [problem for problem in found if problem is not None]


def _mesh_problem(shape: Shape, paths: MeshPaths) -> MeshProblem | None:
    if shape.form != "mesh":
        return None
    reason, there = paths.problem(shape.file), False
    path = None if reason else paths.find(shape.file)
    if path is not None:
        reason, there = unreadable(path), True
    return MeshProblem(shape.link, shape.kind, shape.file, reason, there) if reason else None


def diagonals(model: pin.Model, geometry: pin.GeometryModel) -> dict[str, float]:
    """Return the diagonal of a box about all shapes of each link that has some [m]."""
    corners: dict[str, list[Array]] = {}
    for item in geometry.geometryObjects:
        item.geometry.computeLocalAABB()
        box = item.geometry.aabb_local
        ends = np.array([np.ravel(box.min_), np.ravel(box.max_)])
        frame = model.frames[item.parentFrame]
        place = frame.placement.actInv(item.placement)
        places = [place.act(np.array(corner)) for corner in itertools.product(*ends.T)]
        corners.setdefault(frame.name, []).extend(places)
    return {name: float(np.linalg.norm(np.ptp(each, axis=0))) for name, each in corners.items()}


def _collision_geometry(shape: Shape, file: str, load: Loader) -> coal.CollisionGeometry | None:
    """Return the form of a shape, None if its mesh cannot be read."""
    size = shape.size
    if shape.form == "box":
        return coal.Box(*size)
    if shape.form == "sphere":
        return coal.Sphere(size[0])
    if shape.form != "mesh":
        make = coal.Capsule if shape.form == "capsule" else coal.Cylinder
        return make(size[0], size[1])
    try:
        with silenced():
            mesh = load(file, np.array(size))
    except (ValueError, RuntimeError, IndexError, MemoryError):
        return None
    return mesh if np.isfinite(mesh.vertices()).all() else None
