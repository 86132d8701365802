"""What a robot is drawn with: the visual shapes of its file, or a skeleton if it has none.

Pinocchio's own visualiser is not used: its import alone takes as long as a page, and it puts whole
mesh files, authors and paths included, into a page. Of a mesh file (STL, OBJ, Collada) a page shows
triangles, normals and the colour of each material; textures, comments, names and paths stay where
they are. There are as few triangles as the eye allows: those of the file are made for machining,
and fast-simplification takes away those that change the surface least (quadric error metrics:
Garland and Heckbert, SIGGRAPH 1997); normals are made again, shared only across edges that are not
sharp.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.gait.result import Recorded, recorded_choices
from gaitopt.importers.meshes import MeshProblem, up_axis
from gaitopt.importers.reader import read_source
from gaitopt.importers.source import Source, load_mesh, mesh_triangles
from gaitopt.model.multibody import Multibody
from gaitopt.nlp import Array
from gaitopt.view.stick_figures import at_reference, stick_figures, trunk_top
from gaitopt.view.viewer import Node, geometry

Rows = NDArray[np.intp]

FEW = 400  # triangles: a mesh of fewer stays as it is
_FACTOR, _POWER = 12.0, 0.55
"""Of M triangles 12 M**0.55 stay: chosen by looking, 2,700 of the 19,000 of a link of G1."""
_SHARP = np.cos(np.radians(40.0))  # between two faces whose edge is to be seen
_FAN = 64  # triangles about a corner; where there are more, they are drawn flat
_WELD = 1e-6  # of the mesh's size: corners so near are one
_FINE = 127.0  # steps of a component of a normal
_HASTE = 5
"""How fast the library gives up on the shape where it takes too few triangles away: its limit of
the error grows by this power of the round (its own 7). A mesh of many parts, screws and vents,
cannot be made as small as is wanted; with 7 the large surfaces beside them pay for it."""
_SIZE = 100.0
"""Of the mesh while it is simplified: the library collapses edges by thresholds that know no unit,
and folds the surface of a mesh of some centimetres in metres (version 0.2.0)."""
_MANTISSA = np.uint32(0xFFFFF000)  # 11 bits, a thousandth of a coordinate in 2


@dataclass(frozen=True, eq=False)
class Surface:
    """A surface of triangles that share corners.

    Attributes:
        corners: shape (V, 3), in the units of the file.
        normals: at them, shape (V, 3); None where facets are flat.
        faces: rows of `corners`, shape (F, 3).
    """

    corners: Array
    normals: Array | None
    faces: Rows


def simplified(corners: Array) -> Surface | None:
    """Return what the eye sees of many triangles.

    Args:
        corners: of the triangles, shape (M, 3, 3), in any unit.

    Returns:
        About 12 M**0.55 triangles; None where there are so few, or so broken, that they had better
        be drawn as they are.
    """
    if len(corners) <= FEW:
        return None
    points, faces = _welded(corners)
    size = float(np.ptp(points, axis=0).max()) / _SIZE or 1.0
    wanted = max(FEW, int(_FACTOR * len(faces) ** _POWER))
    if len(faces) > wanted:
        import fast_simplification  # which looks for its own version: slow to import

        points, faces = fast_simplification.simplify(
            np.ascontiguousarray(points / size, dtype=np.float32),
            np.ascontiguousarray(faces, dtype=np.int32),
            target_reduction=1.0 - wanted / len(faces),
            agg=_HASTE,
        )
        points, faces = (
            size * np.asarray(points, dtype=np.float64),
            np.asarray(faces, dtype=np.intp),
        )
    if not len(faces) or not np.isfinite(points).all():
        return None
    return _shaded(points, faces)


def _welded(corners: Array) -> tuple[Array, Rows]:
    """Return corners (V, 3), each once, and triangles (F, 3) that keep an area."""
    flat = corners.reshape(-1, 3)
    low, size = flat.min(axis=0), float(np.ptp(flat, axis=0).max()) or 1.0
    x, y, z = np.rint((flat - low) / (_WELD * size)).astype(np.int64).T
    _, first, which = np.unique((x << 42) + (y << 21) + z, return_index=True, return_inverse=True)
    faces = which.reshape(-1, 3)
    a, b, c = faces.T
    return flat[first], faces[(a != b) & (b != c) & (a != c)]


def _shaded(points: Array, faces: Rows) -> Surface:
    """Return the surface with a normal at each corner; at a sharp edge, several corners."""
    a, b, c = points[faces.T]
    across = np.cross(b - a, c - a)  # as long as twice the area, by which normals are weighed
    size = np.linalg.norm(across, axis=1, keepdims=True)
    unit = across / np.where(size > 0.0, size, 1.0)
    vertex = faces.ravel()
    face = np.repeat(np.arange(len(faces)), 3)
    order = np.argsort(vertex, kind="stable")
    counts = np.bincount(vertex, minlength=len(points))
    begins = np.cumsum(counts) - counts
    many = counts[vertex[order]]  # corners at the point of each corner
    many = np.where(many > _FAN, 0, many)
    one = np.repeat(np.arange(len(order)), many)
    inside = np.arange(len(one)) - np.repeat(np.cumsum(many) - many, many)
    other = begins[vertex[order]][one] + inside
    mine, yours = face[order][one], face[order][other]
    smooth = np.einsum("ij,ij->i", unit[mine], unit[yours]) > _SHARP
    normals = np.zeros((len(order), 3))
    for axis in range(3):
        normals[:, axis] = np.bincount(
            one[smooth], weights=across[yours[smooth], axis], minlength=len(order)
        )
    alone = ~normals.any(axis=1)
    normals[alone] = unit[face[order][alone]]
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    steps = np.rint(_FINE * normals / np.where(length > 0.0, length, 1.0)).astype(np.int64)
    key = vertex[order].astype(np.int64)
    for axis in range(3):
        key = (key << 8) + (steps[:, axis] + 128)
    _, first, which = np.unique(key, return_index=True, return_inverse=True)
    numbers = np.empty(len(order), dtype=np.intp)
    numbers[order] = which
    short = (points[vertex[order][first]].astype(np.float32).view(np.uint32) & _MANTISSA).view(
        np.float32
    )
    return Surface(short.astype(np.float64), steps[first] / _FINE, numbers.reshape(-1, 3))


_HEAD, _RECORD = 84, 50  # bytes of a binary STL: before the triangles, and of each
_CORNERS = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
_VERTEX = re.compile(rb"^\s*vertex\s+(\S+)\s+(\S+)\s+(\S+)", re.MULTILINE | re.IGNORECASE)
GREY = np.array([0.62, 0.65, 0.68, 1.0])
"""In place of a texture, and of black where all is black: on that no shape can be seen."""
_FACES = ("triangles", "polylist", "polygons")
_MEANT_AS_OPAQUE = 0.02  # opacity: less is what a program meant as opaque, glass has more
_OTHER_FACES = ("trifans", "tristrips")  # nobody writes them; left to others


@dataclass(frozen=True, eq=False)
class MeshData:
    """M triangles in the units of their file.

    Attributes:
        corners: shape (M, 3, 3).
        normals: at the corners, None where the file gives none: facets are then flat.
        colours: red, green, blue and opacity of each triangle from 0 to 1, shape (M, 4); None where
            the file gives none.
    """

    corners: Array
    normals: Array | None = None
    colours: Array | None = None


def read_mesh(path: str) -> MeshData | None:
    """Return the triangles of an STL, OBJ or Collada file, None where they cannot be read here."""
    read = {".stl": _stl, ".obj": _obj, ".dae": _collada}.get(Path(path).suffix.lower())
    if read is None:
        return None
    try:
        found = read(Path(path))
    except (OSError, ValueError, IndexError, KeyError, ElementTree.ParseError, RecursionError):
        return None
    return found if found.corners.size and bool(np.isfinite(found.corners).all()) else None


def _stl(path: Path) -> MeshData:
    """Read an STL file, binary or text: one with "solid" in its head may be either."""
    data = path.read_bytes()
    count = int.from_bytes(data[_HEAD - 4 : _HEAD], "little")
    if len(data) >= _HEAD and len(data) >= _HEAD + _RECORD * count and count:
        records = np.frombuffer(data, _CORNERS, count, _HEAD)
        return MeshData(np.array(records["corners"], dtype=np.float64))
    numbers = [[float(n) for n in corner] for corner in _VERTEX.findall(data)]
    return MeshData(np.array(numbers, dtype=np.float64).reshape(-1, 3, 3))


def _obj(path: Path) -> MeshData:
    """Read an OBJ file; faces of more corners are cut into fans."""
    points: list[list[float]] = []
    faces: list[tuple[int, int, int]] = []
    for line in path.read_bytes().splitlines():
        words = line.split()
        if words[:1] == [b"v"]:
            points.append([float(w) for w in words[1:4]])
        elif words[:1] == [b"f"]:
            ids = [int(w.partition(b"/")[0]) for w in words[1:]]
            ids = [i - 1 if i > 0 else len(points) + i for i in ids]  # negative: from the end
            faces += [(ids[0], a, b) for a, b in pairwise(ids[1:])]
    return MeshData(np.array(points, dtype=np.float64)[np.array(faces, dtype=np.intp)])


def _collada(path: Path) -> MeshData:
    """Read a Collada file as coal does: every node where it is, whichever axis is called up."""
    # Coal itself confuses the corners of geometries with several materials.
    root = ElementTree.parse(path).getroot()
    document = _Document({e.get("id", ""): e for e in root.iter() if e.get("id")})
    scenes = [document.linked(e) for e in _inside(root, "instance_visual_scene")]
    parts = [
        part
        for scene in scenes or list(_inside(root, "visual_scene"))
        for node in _children(scene, "node")
        for part in document.node(node, np.eye(4))
    ]
    corners = np.concatenate([part.corners for part in parts])
    unit = next((float(e.get("meter", "1")) for e in _inside(root, "unit")), 1.0)
    if up_axis(str(path)) == "Z_UP":  # others are taken as they are, see `importers.meshes`
        corners = unit * corners
    normals = [part.normals for part in parts if part.normals is not None]
    all_normals = np.concatenate(normals) if len(normals) == len(parts) else None
    return MeshData(corners, all_normals, _colours(parts))


def _colours(parts: list[MeshData]) -> Array | None:
    """Return the colours of parts together, None if none of them has any."""
    if all(part.colours is None for part in parts):
        return None
    rows = [
        np.tile(GREY, (len(part.corners), 1)) if part.colours is None else part.colours
        for part in parts
    ]
    colours = np.concatenate(rows)
    if not colours[:, :3].any():
        colours[:, :3] = GREY[:3]
    return colours


@dataclass(frozen=True)
class _Document:
    """A Collada document, its elements by their ids."""

    ids: dict[str, Element]

    def linked(self, element: Element, key: str = "url") -> Element:
        """Return the element that another one names."""
        return self.ids[element.get(key, "").removeprefix("#")]

    def node(self, node: Element, place: Array) -> Iterator[MeshData]:
        """Yield what is drawn of a node and of those in it."""
        place = place @ _placement(node)
        for child in node:
            tag = _tag(child)
            if tag == "node":
                yield from self.node(child, place)
            elif tag == "instance_node":
                yield from self.node(self.linked(child), place)
            elif tag == "instance_geometry":
                bound = {
                    e.get("symbol", ""): e.get("target", "")
                    for e in _inside(child, "instance_material")
                }
                yield from self.geometry(self.linked(child), place, bound)

    def geometry(
        self, geometry: Element, place: Array, bound: dict[str, str]
    ) -> Iterator[MeshData]:
        """Yield the triangles of a geometry, those of each of its materials together."""
        for mesh in _children(geometry, "mesh"):
            for faces in mesh:
                if _tag(faces) in _OTHER_FACES:
                    raise ValueError("fans and strips are not read here")
                if _tag(faces) in _FACES:
                    yield self.faces(faces, place, bound)

    def faces(self, faces: Element, place: Array, bound: dict[str, str]) -> MeshData:
        """Return the triangles of one material."""
        inputs: dict[str, tuple[int, Element]] = {}
        for one in _children(faces, "input"):
            offset = int(one.get("offset", "0"))
            inputs.setdefault(one.get("semantic", ""), (offset, self.linked(one, "source")))
        stride = 1 + max(int(e.get("offset", "0")) for e in _children(faces, "input"))
        offset, vertices = inputs["VERTEX"]
        for one in _children(vertices, "input"):
            inputs.setdefault(one.get("semantic", ""), (offset, self.linked(one, "source")))
        polygons = [_numbers(p, np.int64).reshape(-1, stride) for p in _children(faces, "p")]
        counts = [len(p) for p in polygons]
        rows = np.concatenate(polygons) if polygons else np.zeros((0, stride), dtype=np.int64)
        if _tag(faces) == "triangles":
            counts = [3] * (len(rows) // 3)
        elif _tag(faces) == "polylist":
            counts = [int(n) for e in _children(faces, "vcount") for n in _numbers(e, np.int64)]
        rows = rows[_fans(np.array(counts, dtype=np.int64))]
        column, source = inputs["POSITION"]
        corners = self.values(source)[rows[..., column]] @ place[:3, :3].T + place[:3, 3]
        normals = None
        if "NORMAL" in inputs:
            column, source = inputs["NORMAL"]
            normals = self.values(source)[rows[..., column]] @ np.linalg.inv(place[:3, :3])
            length = np.linalg.norm(normals, axis=-1, keepdims=True)
            normals = normals / np.where(length > 0.0, length, 1.0)
        symbol = faces.get("material", "")
        colour = self.colour(bound.get(symbol, symbol))
        colours = None if colour is None else np.tile(colour, (len(corners), 1))
        return MeshData(corners, normals, colours)

    def values(self, source: Element) -> Array:
        """Return the rows (K, 3) of a source."""
        accessor = next(_inside(source, "accessor"))
        numbers = _numbers(self.linked(accessor, "source"), np.float64)
        stride, first = int(accessor.get("stride", "1")), int(accessor.get("offset", "0"))
        count = int(accessor.get("count", "0"))
        return numbers[first : first + count * stride].reshape(count, stride)[:, :3]

    def colour(self, material: str) -> Array | None:
        """Return diffuse colour and opacity of a material (4,), None if it has none."""
        # What the file calls fully transparent is opaque: exporters disagree on which end of the
        # scale is which, and nobody draws what cannot be seen.
        found = self.ids.get(material.removeprefix("#"))
        effects = () if found is None else _inside(found, "instance_effect")
        for effect in effects:
            for model in self.linked(effect).iter():
                for diffuse in _children(model, "diffuse"):
                    values = [_numbers(e, np.float64)[:3] for e in _children(diffuse, "color")]
                    plain = values[0] if values else GREY[:3]
                    return np.append(plain, 1.0 if unseen(model) else opacity(model))
        return None


def unseen(model: Element) -> bool:
    """Tell whether a viewer that goes by the book draws nothing with a lighting model."""
    return opacity(model) < _MEANT_AS_OPAQUE


def opacity(model: Element) -> float:
    """Return the opacity of a lighting model of a Collada document (`phong`, say), from 0 to 1.

    It is written in four ways (COLLADA 1.4.1, "Determining transparency"), and many programs wrote
    that of an opaque mesh as none.
    """

    def numbers(name: str, kind: str) -> list[float]:
        values = [value for part in _children(model, name) for value in _children(part, kind)]
        with suppress(ValueError):
            return [float(n) for n in _numbers(values[0], np.float64)] if values else []
        return []

    factor, colour = numbers("transparency", "float"), numbers("transparent", "color")
    if not factor and not colour:
        return 1.0
    mode = next((e.get("opaque", "A_ONE") for e in _children(model, "transparent")), "A_ONE")
    red, _, _, alpha = (*colour, 1.0, 1.0, 1.0, 1.0)[:4] if colour else (1.0, 1.0, 1.0, 1.0)
    part = (alpha if mode.startswith("A_") else red) * (factor[0] if factor else 1.0)
    return 1.0 - part if mode.endswith("ZERO") else part


def _placement(node: Element) -> Array:
    """Return the placement of a node in the one around it: its parts in their order."""
    place = np.eye(4)
    for part in node:
        tag, own = _tag(part), np.eye(4)
        if tag not in ("matrix", "translate", "rotate", "scale"):
            continue
        numbers = _numbers(part, np.float64)
        if tag == "matrix":
            own = numbers.reshape(4, 4)
        elif tag == "translate":
            own[:3, 3] = numbers[:3]
        elif tag == "scale":
            own[:3, :3] = np.diag(numbers[:3])
        else:
            axis = numbers[:3] / np.linalg.norm(numbers[:3])
            own[:3, :3] = pin.AngleAxis(np.radians(numbers[3]), axis).matrix()
        place = place @ own
    return place


def _fans(counts: Array) -> Array:
    """Return the corners (M, 3) of triangles that fill polygons of so many corners each."""
    begins = np.concatenate([[0], np.cumsum(counts)[:-1]])
    inside = np.maximum(counts - 2, 0)
    first = np.repeat(begins, inside)
    number = np.arange(inside.sum()) - np.repeat(np.cumsum(inside) - inside, inside)
    return np.asarray(np.stack([first, first + number + 1, first + number + 2], axis=1))


def _numbers(element: Element, kind: type[np.generic]) -> np.ndarray[tuple[int], np.dtype]:
    return np.array((element.text or "").split(), dtype=kind)


def _inside(element: Element, tag: str) -> Iterator[Element]:
    return (one for one in element.iter() if _tag(one) == tag)


def _children(element: Element, tag: str) -> Iterator[Element]:
    return (one for one in element if _tag(one) == tag)


def _tag(element: Element) -> str:
    return str(element.tag).rpartition("}")[2]


# MeshCat's cylinders stand along y, the others' along z
UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])
_AROUND, _ALONG = 30, 10  # facets of a capsule: around its axis, and from rim to pole
_BONE = 0.025  # m: radius of the skeleton's limbs
_FOOT = 0.02  # m: thickness of its feet
_ENOUGH = 0.5  # of the moving bodies of the legs must be drawn
_POINT = 0.06  # m: edge of the box that shows a load without one
_LOAD = np.array([0.55, 0.36, 0.16, 1.0])
_STANCE, _SWING, _TRUNK = 0xD55E00, 0x0072B2, 0x333333  # the colours of the figures


@dataclass(frozen=True, eq=False)
class RobotShapes:
    """What a walking robot is drawn with.

    Attributes:
        shapes: body of `Multibody` that carries a shape, 0 for the base; the shape; its placement
            in the body's frame.
        note: what is missing and how to get it, or empty.
    """

    shapes: tuple[tuple[int, pin.GeometryObject, pin.SE3], ...]
    note: str = ""

    @property
    def carriers(self) -> tuple[int, ...]:
        """The bodies that carry something."""
        return tuple(sorted({body for body, _, _ in self.shapes}))


def robot_shapes(gait: Recorded, package_dirs: tuple[str, ...] = ()) -> RobotShapes:
    """Return the visual shapes of a gait's robot, a skeleton if those of a leg are missing.

    Args:
        package_dirs: where to look for meshes, before the directories that the gait records.

    Raises:
        RobotError: the robot's file cannot be read.
    """
    source = _source(gait, package_dirs)
    lost = [p for p in source.mesh_problems() if p.kind == "visual"]
    note = _note(lost[0], len(lost)) if lost else ""
    try:
        found = source.geometry(pin.GeometryType.VISUAL, load=unloaded)
    except RobotError as error:
        found, note = None, str(error)
    body = gait.trajectory.body
    if found is not None:
        _add_payloads(gait, source, found)
        shapes = tuple(_carried(gait, body, source, found))
        legs = {row + 1 for foot in (0, 1) for row in body.leg(foot)}
        if not lost or len(legs & {carrier for carrier, _, _ in shapes}) >= _ENOUGH * len(legs):
            return RobotShapes(shapes, note)
    skeleton = tuple(_skeleton(gait, body))
    return RobotShapes(skeleton, note and f"{note}. The robot is drawn as a skeleton")


def unloaded(path: str, scale: Array) -> coal.BVHModelBase:
    """Return an empty mesh for a file that is read here when drawn, else the mesh, by scale (3,).

    Coal builds a tree of boxes about every mesh, for which a page has no use and which takes fifty
    times as long as reading the file.
    """
    if Path(path).suffix.lower() in (".stl", ".obj") and file_parts(path) is not None:
        return coal.BVHModelOBB()
    return load_mesh(path, scale)


def draw_shape(robot: Node, group: str, item: pin.GeometryObject, placement: pin.SE3) -> None:
    """Draw one shape of a robot, as the node `group`/NAME below the robot's."""
    node = robot[f"{group}/{item.name}"]
    matrix = placement.homogeneous @ np.diag([*item.meshScale, 1.0])
    solid = item.geometry
    if _suffix(item) or isinstance(solid, coal.BVHModelBase):
        parts = file_parts(item.meshPath)
        loaded = None if parts is not None else _loaded(solid, item.meshScale)
        parts = parts or (() if loaded is None else mesh_parts(loaded))
        for number, (colour, surface) in enumerate(parts):
            part = node if len(parts) == 1 else node[str(number)]
            material = _material(item) if colour is None else _painted(colour)
            part.set_object(_Triangles(surface), material)
    else:
        node.set_object(_simple(solid), _material(item))
        if isinstance(solid, coal.Cylinder | coal.Cone):
            matrix = matrix @ UPRIGHT
    node.set_transform(matrix)


def capsule(radius: float, half: float) -> tuple[Array, Array]:
    """Return corners (V, 3) [m] and triangles (F, 3) of a capsule along z, seen from outside.

    Args:
        radius: of the capsule [m].
        half: from its middle to the centre of either end [m].
    """
    rise = np.linspace(0.0, np.pi / 2.0, _ALONG + 1)
    rise = np.concatenate([-rise[::-1], rise])  # from pole to pole, each rim once
    centre = np.repeat([-half, half], _ALONG + 1)
    turn = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)
    x, y = (np.outer(radius * np.cos(rise), f(turn)) for f in (np.cos, np.sin))
    z = np.outer(centre + radius * np.sin(rise), np.ones(_AROUND))
    corners = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    ring, place = (i.ravel() for i in np.indices((len(rise) - 1, _AROUND)))
    here, beside = ring * _AROUND + place, ring * _AROUND + (place + 1) % _AROUND
    above, across = here + _AROUND, beside + _AROUND
    faces = np.concatenate(
        [np.stack([here, beside, across], axis=1), np.stack([here, across, above], axis=1)]
    )
    return corners, faces


def _source(gait: Recorded, package_dirs: tuple[str, ...]) -> Source:
    directories = (*package_dirs, *recorded_choices(gait).package_dirs)
    try:
        return read_source(gait.urdf, tuple(dict.fromkeys(directories)))
    except RobotError as error:
        raise RobotError(f"the gait's URDF cannot be read: {error}") from error


def _note(lost: MeshProblem, count: int) -> str:
    others = f" and {count - 1} more are not drawn" if count > 1 else " is not drawn"
    return (
        f"the mesh '{lost.file}' {lost.reason}: it{others}; give the directory that holds its "
        "package (--package-dir)"
    )


def _add_payloads(gait: Recorded, source: Source, shapes: pin.GeometryModel) -> None:
    """Add the loads that the robot carries, as boxes in their links."""
    model = source.model()
    for number, load in enumerate(recorded_choices(gait).payloads):
        frame = model.frames[model.getFrameId(load.link)]
        lengths = [length or _POINT for length in load.box]
        place = frame.placement * pin.SE3(np.eye(3), np.array(load.place or np.zeros(3)))
        shape = pin.GeometryObject(
            f"payload_{number}", frame.parentJoint, place, coal.Box(*lengths)
        )
        shape.meshColor = _LOAD
        shapes.addGeometryObject(shape)


def _carried(
    gait: Recorded, body: Multibody, source: Source, shapes: pin.GeometryModel
) -> Iterator[tuple[int, pin.GeometryObject, pin.SE3]]:
    """Yield each shape with the nearest body towards the base that moves, and its place there."""
    model, data = at_reference(gait, source)
    rows = {body.joint_names[row]: int(row) + 1 for row in body.driven}
    for item in shapes.geometryObjects:
        joint = item.parentJoint
        while joint > 1 and str(model.names[joint]) not in rows:
            joint = model.parents[joint]
        inside = data.oMi[joint].actInv(data.oMi[item.parentJoint]) * item.placement
        yield rows.get(str(model.names[joint]), 0), item, inside


def _skeleton(gait: Recorded, body: Multibody) -> Iterator[tuple[int, pin.GeometryObject, pin.SE3]]:
    """Yield capsules from joint to joint, plates for the feet and a bar for the trunk."""
    at_rest = np.concatenate([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], body.posture])[None]
    places = body.placements(at_rest)[0]
    sticks = stick_figures(body, at_rest, trunk_top(gait))
    bars: list[tuple[int, Array, Array, int]] = []
    for foot, colour in ((0, _STANCE), (1, _SWING)):
        points, rows = sticks.legs[0, foot], [row + 1 for row in body.leg(foot)]
        bars += [(row, *ends, colour) for row, ends in zip(rows[1:], pairwise(points), strict=True)]
        bars.append((rows[0], points[0], sticks.soles[0, foot].mean(axis=0), colour))
        yield _foot(body, foot, colour)
    bars.append((0, *sticks.trunk[0], _TRUNK))
    bars.append((0, *sticks.legs[0, :, -1], _TRUNK))
    for number, (row, start, end, colour) in enumerate(bars):
        span = end - start
        length = float(np.linalg.norm(span))
        if length >= 1e-6:
            turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), span / length).matrix()
            place = pin.SE3(places[row]).actInv(pin.SE3(turn, (start + end) / 2.0))
            yield row, _bone(f"bone_{number}", coal.Capsule(_BONE, length), colour), place


def _foot(body: Multibody, foot: int, colour: int) -> tuple[int, pin.GeometryObject, pin.SE3]:
    toe, heel, left, right = body.sole_rectangle[foot]
    centre = np.array([(toe + heel) / 2.0, (left + right) / 2.0, _FOOT / 2.0])
    place = pin.SE3(body.sole_placement[foot]) * pin.SE3(np.eye(3), centre)
    plate = coal.Box(toe - heel, left - right, _FOOT)
    return int(body.sole_joint[foot]) + 1, _bone(f"foot_{foot}", plate, colour), place


def _bone(name: str, shape: coal.CollisionGeometry, colour: int) -> pin.GeometryObject:
    item = pin.GeometryObject(name, 0, pin.SE3.Identity(), shape)
    item.meshColor = np.array([*((colour >> shift & 0xFF) / 255.0 for shift in (16, 8, 0)), 1.0])
    return item


def _simple(solid: coal.CollisionGeometry) -> geometry.Geometry:
    """Return a simple shape as MeshCat's."""
    if isinstance(solid, coal.Box):
        return geometry.Box(list(2.0 * solid.halfSide))
    if isinstance(solid, coal.Sphere):
        return geometry.Sphere(solid.radius)
    if isinstance(solid, coal.Cylinder):
        return geometry.Cylinder(2.0 * solid.halfLength, solid.radius)
    if isinstance(solid, coal.Cone):
        height = 2.0 * solid.halfLength
        return geometry.Cylinder(height, radiusTop=0.0, radiusBottom=solid.radius)
    if isinstance(solid, coal.Ellipsoid):
        return geometry.Ellipsoid(np.ravel(solid.radii))
    return geometry.TriangularMeshGeometry(*capsule(solid.radius, solid.halfLength))


def _suffix(item: pin.GeometryObject) -> str:
    """Return the suffix of the file; the "file" of a simple shape is BOX or the like."""
    return Path(item.meshPath).suffix.lower()


def _loaded(solid: object, scale: Array) -> MeshData | None:
    """Return the triangles of a mesh as it was read, before it was scaled."""
    if not isinstance(solid, coal.BVHModelBase) or not np.all(scale) or not solid.num_tris:
        return None
    corners, faces = mesh_triangles(solid)
    return MeshData((corners / scale)[faces])


Part = tuple[Array | None, Surface]
"""What is drawn of a mesh in one colour (4,), in that of the robot's file where it is None."""


def mesh_parts(mesh: MeshData) -> tuple[Part, ...]:
    """Return a mesh by its colours, simplified where triangles are many."""
    if mesh.colours is None:
        return ((None, _surface(mesh.corners, mesh.normals)),)
    colours, which = np.unique(mesh.colours, axis=0, return_inverse=True)
    each = [which.reshape(-1) == number for number in range(len(colours))]
    return tuple(
        (colour, _surface(mesh.corners[rows], None if mesh.normals is None else mesh.normals[rows]))
        for colour, rows in zip(colours, each, strict=True)
    )


def file_parts(path: str) -> tuple[Part, ...] | None:
    """Return the parts of a mesh file that is read here, else None; those of the last are kept."""
    with suppress(OSError, ValueError):  # a simple shape has no file
        facts = Path(path).stat()
        return _file_parts(path, facts.st_mtime_ns, facts.st_size)
    return None


def take_parts(parts: Mapping[str, tuple[Part, ...] | None]) -> None:
    """Keep parts of mesh files, by path, that another process made, as `file_parts` has them."""
    _made.update(parts)
    for path in parts:
        file_parts(path)
    _made.clear()


_made: dict[str, tuple[Part, ...] | None] = {}  # to be kept


@lru_cache(maxsize=256)
def _file_parts(path: str, _changed: int, _size: int) -> tuple[Part, ...] | None:
    if path in _made:
        return _made[path]
    mesh = read_mesh(path)
    return None if mesh is None else mesh_parts(mesh)


def triangles(corners: Array) -> geometry.Geometry:
    """Return triangles (M, 3, 3) as MeshCat's, simplified where they are many."""
    return _Triangles(_surface(corners, None))


def _surface(corners: Array, normals: Array | None) -> Surface:
    few = simplified(corners)
    if few is not None:
        return few
    flat = corners.reshape(-1, 3)
    return Surface(flat, normals, np.arange(len(flat)).reshape(-1, 3))


class _Triangles(geometry.TriangularMeshGeometry):  # type: ignore[misc]
    """Triangles with normals at their corners; where there are none, facets are flat."""

    def __init__(self, surface: Surface) -> None:
        super().__init__(surface.corners, surface.faces)
        self.normals = surface.normals

    def lower(self, object_data: object) -> dict[str, object]:
        """Return the geometry as the viewer reads it."""
        made: dict[str, object] = super().lower(object_data)
        if self.normals is not None:
            flat = np.asarray(self.normals, dtype=np.float32).reshape(-1, 3)
            made["data"]["attributes"]["normal"] = geometry.pack_numpy_array(flat.T)  # type: ignore[index]
        return made


def _material(item: pin.GeometryObject) -> geometry.Material:
    lustre = item.meshMaterial
    shines: dict[str, float] = {}
    if item.overrideMaterial and isinstance(lustre, pin.GeometryPhongMaterial):
        shines["emissive"] = _number(lustre.meshEmissionColor)
        shines["specular"] = _number(lustre.meshSpecularColor)
        shines["shininess"] = 100.0 * lustre.meshShininess
    black = _suffix(item) == ".dae" and not item.meshColor[:3].any()  # on it no shape can be seen
    return _painted(GREY if black else item.meshColor, **shines)


def _painted(colour: Array, **more: float) -> geometry.Material:
    """Return the material of a colour with opacity."""
    opacity = float(colour[3])
    return geometry.MeshPhongMaterial(
        color=_number(colour), opacity=opacity, transparent=opacity < 1.0, **more
    )


def _number(colour: Array) -> int:
    """Return red, green and blue, each from 0 to 1, as one number."""
    red, green, blue = (int(255.0 * c) for c in np.clip(colour[:3], 0.0, 1.0))
    return (red << 16) + (green << 8) + blue
