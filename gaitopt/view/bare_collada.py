"""A Collada file with its shapes and colours only.

Pages hold Collada files as a text that the viewer reads, because that keeps their colours. The text
is written anew from the few elements and attributes that say how the shapes look: no comments, no
names, no authors or programs, no paths, no pictures.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from gaitopt.importers.meshes import unseen

_SPACE = "http://www.collada.org/2005/11/COLLADASchema"
_GREY = "0.62 0.65 0.68 1"  # in place of a picture
_NUMBERS = re.compile(r"[\d\s+\-.eE]*")
_FACES = ("lines", "linestrips", "polygons", "polylist", "triangles", "trifans", "tristrips")
_SHADING = ("blinn", "constant", "lambert", "phong")
_COLOURS = ("emission", "ambient", "diffuse", "specular")

_KEPT: dict[str, tuple[str, ...]] = {
    "asset": (), "unit": ("meter",), "up_axis": (),
    "library_effects": (), "effect": ("id",), "profile_COMMON": (), "technique": (),
    **dict.fromkeys((*_SHADING, *_COLOURS, "shininess", "transparency", "color", "float"), ()),
    "transparent": ("opaque",),
    "library_materials": (), "material": ("id",), "instance_effect": ("url",),
    "library_geometries": (), "geometry": ("id",), "mesh": (), "source": ("id",),
    "float_array": ("id", "count"), "technique_common": (),
    "accessor": ("source", "count", "stride", "offset"),
    "vertices": ("id",), "input": ("semantic", "source", "offset", "set"),
    **dict.fromkeys(_FACES, ("count", "material")), "p": (), "vcount": (),
    "library_nodes": (), "library_visual_scenes": (), "visual_scene": ("id",), "node": ("id",),
    **dict.fromkeys(("matrix", "translate", "rotate", "scale"), ()),
    "instance_geometry": ("url",), "instance_node": ("url",), "bind_material": (),
    "instance_material": ("symbol", "target"), "scene": (), "instance_visual_scene": ("url",),
}  # fmt: skip
"""Elements that say how the shapes look, with the attributes that do."""

_WORDS: Mapping[str, frozenset[str]] = {
    "semantic": frozenset(("VERTEX", "POSITION", "NORMAL", "TEXCOORD", "COLOR", "TANGENT",
                           "BINORMAL", "TEXTANGENT", "TEXBINORMAL")),
    "opaque": frozenset(("A_ONE", "RGB_ZERO", "A_ZERO", "RGB_ONE")),
}  # fmt: skip
_LABELS = ("id", "url", "source", "target", "symbol", "material")
_AXES = ("X_UP", "Y_UP", "Z_UP")


def bare_collada(path: str) -> str | None:
    """Return a Collada document with the shapes and colours of a file, and nothing else.

    What the file calls fully transparent is opaque: exporters disagree on which end of the scale
    is which, and nobody draws what cannot be seen.

    Args:
        path: of the file.

    Returns:
        None if the file is none, or has something in it that is not understood here.
    """
    try:
        root = ElementTree.parse(Path(path)).getroot()
        bare = Element("COLLADA", {"xmlns": _SPACE, "version": "1.4.1"})
        labels: dict[str, str] = {}
        for child in root:
            _copy(child, bare, labels)
    except (OSError, ElementTree.ParseError, ValueError, RecursionError):
        return None
    return ElementTree.tostring(bare, encoding="unicode")


def _copy(element: Element, parent: Element, labels: dict[str, str]) -> None:
    """Copy what counts of an element.

    Raises:
        ValueError: it holds something else than it should.
    """
    tag = _tag(element)
    if tag not in _KEPT:
        return
    names = {name: element.get(name) for name in _KEPT[tag]}
    made = SubElement(
        parent, tag, {n: _value(n, v, labels) for n, v in names.items() if v is not None}
    )
    if text := (element.text or "").strip():
        made.text = _text(tag, text)
    for child in element:
        _copy(child, made, labels)
    if tag == "diffuse" and made.find("color") is None:
        SubElement(made, "color").text = _GREY
    if tag in _SHADING and unseen(made):
        for one in [e for e in made if e.tag in ("transparent", "transparency")]:
            made.remove(one)


def _value(name: str, value: str, labels: dict[str, str]) -> str:
    if name in _LABELS:
        sign = "#" if value.startswith("#") else ""
        return sign + labels.setdefault(value.removeprefix("#"), f"n{len(labels)}")
    if name in _WORDS:
        if value not in _WORDS[name]:
            raise ValueError(f"{name} is {value}")
        return value
    return _numbers(value)


def _text(tag: str, text: str) -> str | None:
    if tag == "up_axis":
        if text not in _AXES:
            raise ValueError(f"the upward axis is {text}")
        return text
    known = ("float_array", "p", "vcount", "matrix", "translate", "rotate", "scale")
    return _numbers(text) if tag in (*known, "color", "float") else None


def _numbers(text: str) -> str:
    if _NUMBERS.fullmatch(text) is None:
        raise ValueError("there is something else than numbers")
    return text


def _tag(element: Element) -> str:
    return str(element.tag).rpartition("}")[2]
