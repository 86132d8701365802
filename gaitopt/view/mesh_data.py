"""What a page shows of a mesh file: triangles, normals and colours, and nothing else of it.

STL, OBJ and Collada files are read here, the last with the colour of each of their materials;
textures, comments, names and paths stay where they are.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.importers.meshes import opacity, unseen, up_axis
from gaitopt.nlp import Array

_HEAD, _RECORD = 84, 50  # bytes of a binary STL: before the triangles, and of each
_CORNERS = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
_VERTEX = re.compile(rb"^\s*vertex\s+(\S+)\s+(\S+)\s+(\S+)", re.MULTILINE | re.IGNORECASE)
GREY = np.array([0.62, 0.65, 0.68, 1.0])
"""In place of a texture, and of black where all is black: on that no shape can be seen."""
_FACES = ("triangles", "polylist", "polygons")
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
    """Return the triangles of an STL, OBJ or Collada file.

    Args:
        path: of the file.

    Returns:
        None if it is another file, or one that cannot be read here.
    """
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
    """Read a Collada file as coal does: every node where it is, whichever axis is called up.

    Coal itself confuses the corners of geometries with several materials.
    """
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
    return colours if colours[:, :3].any() else np.tile(GREY, (len(colours), 1))


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
        """Return diffuse colour and opacity of a material (4,), None if it has none.

        What the file calls fully transparent is opaque: exporters disagree on which end of the
        scale is which, and nobody draws what cannot be seen.
        """
        found = self.ids.get(material.removeprefix("#"))
        effects = () if found is None else _inside(found, "instance_effect")
        for effect in effects:
            for model in self.linked(effect).iter():
                for diffuse in _children(model, "diffuse"):
                    values = [_numbers(e, np.float64)[:3] for e in _children(diffuse, "color")]
                    plain = values[0] if values else GREY[:3]
                    return np.append(plain, 1.0 if unseen(model) else opacity(model))
        return None


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
            own[:3, :3] = _rotation(numbers[:3], np.radians(numbers[3]))
        place = place @ own
    return place


def _rotation(axis: Array, angle: float) -> Array:
    """Return Rodrigues' rotation about an axis."""
    x, y, z = axis / np.linalg.norm(axis)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K)


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
