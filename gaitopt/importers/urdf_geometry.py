"""What is drawn and touched: the shapes of a URDF, and the Pinocchio geometry made of them.

Motion needs no shape. One that cannot be read, or whose mesh cannot, costs itself alone, and is
told.
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

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.escape import printable
from gaitopt.importers.meshes import MeshPaths, MeshProblem, silenced, unreadable
from gaitopt.importers.report import listed
from gaitopt.importers.urdf_document import (
    Vector,
    check_attributes,
    read_origin,
    read_version,
)
from gaitopt.importers.xml_document import FileProblem, NamedElement, XmlTree
from gaitopt.nlp import Array

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


@dataclass(frozen=True)
class Shapes:
    """All shapes of a robot.

    Attributes:
        shapes: that can be drawn or touched, in the order of the file.
        problems: one for all that cannot, one for all materials at fault.
    """

    shapes: tuple[Shape, ...]
    problems: tuple[FileProblem, ...]

    def of(self, kind: Kind) -> Iterator[Shape]:
        """Yield the shapes of one kind."""
        return (shape for shape in self.shapes if shape.kind == kind)


def read_shapes(tree: XmlTree) -> Shapes:
    """Return the shapes of a URDF, read without any mesh."""
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
    problems = (*_merged(lost, ": it is left out"), *_merged(odd))
    return Shapes(tuple(shapes), problems)


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
    """Return the geometry of a model, and the meshes that turned out to be unreadable.

    Args:
        model: from `model_of_urdf`.
        shapes: of one kind.
        paths: where meshes are; those with a problem there are left out without a word.
        load: reads a mesh file at a scale.
        links: names of the links whose shapes are wanted; None for all.
    """
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
