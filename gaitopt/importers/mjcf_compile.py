"""MuJoCo compiles an MJCF file; what it refuses is refused in its words, with the place.

Files that the masses do not need may be missing: textures and height fields are never asked for,
and a mesh whose absence changes no mass is replaced while MuJoCo compiles.
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from os.path import realpath
from pathlib import Path, PurePosixPath
from types import ModuleType
from typing import Any, cast
from xml.etree.ElementTree import Element, tostring

import numpy as np

from gaitopt.bounds import SIZE
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, MissingExtraError, RobotError
from gaitopt.escape import printable
from gaitopt.importers.meshes import MeshPaths
from gaitopt.importers.mjcf_robot import CompiledMesh, pose, se3, vector
from gaitopt.importers.text_files import read_text
from gaitopt.importers.xml_document import (
    NamedElement,
    XmlTree,
    as_number,
    as_numbers,
    parse_xml,
    where,
)
from gaitopt.nlp import Array

EXTRA = "mujoco"
"""Name of the extra that installs MuJoCo."""

_OLDEST_MUJOCO = (3, 10)
_MOST_COPIES = 10_000  # of an element: <replicate> and <composite> nest, and multiply
_MOST_INCLUDE_LEVELS = 10  # levels of included files; more is a circle
_MOST_LEVELS = 300  # of elements in elements; robots have some thirty, MuJoCo reads 500
_MOST_RESERVED = 1e6  # of what <size> and <texture> reserve
_VECTORS = {
    "pos", "quat", "axis", "axisangle", "euler", "xyaxes", "zaxis", "fromto", "size", "scale",
    "refpos", "refquat", "anchor", "relpose",
}  # fmt: skip
"""Attributes that are places, directions, turns and sizes."""
_HOLDING_BODIES = ("body", "attach", "composite", "flexcomp")
_COPYING_TAGS = ("replicate", "composite", "flexcomp")
_STAND_IN_MESH = (
    ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
    ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)),
)
_READABLE_SUFFIXES = (".stl", ".obj", ".dae")  # by the loader of meshes, beside MuJoCo's own format
_NAMED_PLACE = re.compile(r"Element name '(?P<name>.*)', id -?\d+(?:, line (?P<line>\d+))?")
_TAGGED_PLACE = re.compile(r"Element '(?P<tag>.*)', line (?P<line>\d+)")
_PARSER_PLACE = re.compile(r"Line number=(?P<line>\d+)(?:: XMLElement name=(?P<tag>\w+))?")
_MISSING_NAME = re.compile(r"not found|unrecognized name|unknown (?:element|default|transmission)")
_ATTRIBUTE = re.compile(r"attribute(?: missing:)? '(\w+)'")
_ADVICE = {
    "must be larger than mjMINVAL": "both must be above 1e-15 kg and kg·m²: give the body an "
    "<inertial> with mass and diaginertia, or shapes that weigh something",
    "bad format in attribute": "write numbers in digits 0 to 9, as -1.5e-3, with blanks between",
    "inertia must satisfy A + B >= C": "the largest moment must not exceed the sum of the other "
    'two: correct it, or write <compiler balanceinertia="true"/>',
    "could not find decoder": "give the file a name that ends in .xml",
    "XML_ERROR_PARSING_DECLARATION": "remove <?...?> there; only <?xml ...?> at the beginning is "
    "read",
    "Error opening file": "correct the path",
}
"""What to do about what MuJoCo says, where that is not plain."""
_ERROR_PREFIX = re.compile(r"^(?:XML |Schema |Compile )?(?:Error|violation): ?", re.IGNORECASE)


@dataclass(frozen=True)
class Compilation:
    """What MuJoCo made of a file.

    Attributes:
        mujoco: the module.
        model: MuJoCo's MjModel.
        meshes: by the name that the model has for them.
        lost: files of meshes that were replaced, as the robot's file names them.
        said: what MuJoCo warns about.
        scene: names of geoms that contact pairs of the file ask for and another file has, such as
            the floor.
        touching: names of the geoms that touch those.
    """

    mujoco: ModuleType
    model: Any
    meshes: dict[str, CompiledMesh]
    lost: tuple[str, ...]
    said: tuple[str, ...]
    scene: tuple[str, ...] = ()
    touching: frozenset[str] = frozenset()

    def name(self, kind: str, index: int) -> str:
        """Return the name of an element of the model ("joint", "actuator"), or its number."""
        return str(getattr(self.model, kind)(index).name) or f"number {index}"

    def off(self, what: str) -> bool:
        """Return whether the options of the file switch something off, as "GRAVITY"."""
        bit = getattr(self.mujoco.mjtDisableBit, f"mjDSBL_{what}")
        return bool(int(self.model.opt.disableflags) & int(bit))

    def joints(self, body: int) -> tuple[int, ...]:
        """Return the joints of a body."""
        first, count = int(self.model.body_jntadr[body]), int(self.model.body_jntnum[body])
        return tuple(range(first, first + count))

    def ancestors(self, body: int) -> Iterator[int]:
        """Yield a body and all that carry it, without the world."""
        while body > 0:
            yield body
            body = int(self.model.body_parentid[body])

    def fixed_tendon(self, tendon: int) -> dict[int, float]:
        """Return the coefficient of each joint of a fixed tendon; none of one in space."""
        model = self.model
        first, count = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
        arms: dict[int, float] = {}
        for wrap in range(first, first + count):
            if int(model.wrap_type[wrap]) != self.mujoco.mjtWrap.mjWRAP_JOINT:
                return {}
            joint = int(model.wrap_objid[wrap])
            arms[joint] = arms.get(joint, 0.0) + float(model.wrap_prm[wrap])
        return arms


def load_mujoco() -> ModuleType:
    """Return the module `mujoco`.

    Raises:
        MissingExtraError: it is not installed.
        InputError: it is too old.
    """
    try:
        import mujoco
    except ImportError:
        raise MissingExtraError("reading an MJCF file", EXTRA) from None
    numbers = tuple(int(n) for n in re.findall(r"\d+", mujoco.__version__)[:2])
    if numbers < _OLDEST_MUJOCO:
        raise InputError(
            f"MuJoCo {mujoco.__version__} is installed, but reading an MJCF file needs "
            f"{'.'.join(map(str, _OLDEST_MUJOCO))} or newer; run: pip install --upgrade mujoco"
        )
    return cast(ModuleType, mujoco)


def compile_mjcf(text: str, path: Path | None, tree: XmlTree, paths: MeshPaths) -> Compilation:
    """Compile an MJCF document, whose whole `tree` (`whole_mjcf`) tells the places in messages.

    Raises:
        RobotError: MuJoCo refuses the document, or a mass depends on a mesh that is missing.
        MissingExtraError: MuJoCo is not installed.
    """
    mujoco = load_mujoco()
    check_magnitudes(tree)
    _check_copies(tree)
    with _listening(mujoco) as said:
        try:
            # MuJoCo keeps the directory as it is written, and may be asked from another one later.
            load = mujoco.MjSpec.from_string if path is None else mujoco.MjSpec.from_file
            spec, model, *found = _built(
                mujoco, load(text if path is None else realpath(path)), tree, paths
            )
        except _refused(mujoco) as e:
            _check_words(said, tree)
            raise _refusal(mujoco, str(e), tree, paths) from None
    _check_words(said, tree)
    files, lost, scene, touching = found
    meshes = _meshes(mujoco, spec, model, files)
    return Compilation(mujoco, model, meshes, lost, tuple(dict.fromkeys(said)), scene, touching)


def _refused(mujoco: ModuleType) -> tuple[type[Exception], ...]:
    """Return the exceptions by which MuJoCo refuses a file."""
    return (ValueError, RuntimeError, IndexError, KeyError, TypeError, mujoco.FatalError)


def _built(mujoco: ModuleType, spec: Any, tree: XmlTree, paths: MeshPaths) -> tuple[Any, ...]:
    """Return specification and model; files of meshes, those lost, names of the scene, touching."""
    spec.memory = -1  # of simulations, which may ask for more than there is
    _without_pictures(spec)
    scene, touching = _without_scene(spec)
    files, lost = _place_meshes(mujoco, spec, tree, paths)
    return spec, spec.compile(), files, lost, scene, touching


def element_named(tree: XmlTree, tag: str, name: str) -> Element | None:
    """Return the first element of a tag with a name, outside of the defaults."""
    return next((e for e in tree.root.iter(tag) if e.get("name") == name), None)


def refusal_of(tree: XmlTree, tag: str, name: str, text: str) -> RobotError:
    """Return the error that says something of a named element, with its place if it is known."""
    element = element_named(tree, tag, name)
    if element is None:
        return RobotError(f"{tag} '{name}': {text}")
    return NamedElement(tree, element).refusal(text)


@contextmanager
def _listening(mujoco: ModuleType) -> Iterator[list[str]]:
    """Collect MuJoCo's warnings, which otherwise go to the screen and into a file."""
    said: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: said.append(str(text)))
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            yield said
            said += [str(w.message) for w in caught]
    finally:
        mujoco.set_mju_user_warning(before)


def _without_pictures(spec: Any) -> None:
    """Take away what only pictures and terrain need, with the files behind it."""
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for thing in [*spec.textures, *spec.skins]:
        spec.delete(thing)
    for field in spec.hfields:
        field.file, field.nrow, field.ncol, field.userdata = "", 2, 2, [0.0] * 4


def _without_scene(spec: Any) -> tuple[tuple[str, ...], frozenset[str]]:
    """Take away contact pairs with geoms of another file; return their names, and those of ours."""
    own = {geom.name for geom in spec.geoms}
    scene: dict[str, None] = {}
    touching = set()
    for pair in list(spec.pairs):
        names = {pair.geomname1, pair.geomname2}
        if names & own and names - own:
            scene |= dict.fromkeys(sorted(names - own))
            touching |= names & own
            spec.delete(pair)
    return tuple(scene), frozenset(touching)


def _place_meshes(
    mujoco: ModuleType, spec: Any, tree: XmlTree, paths: MeshPaths
) -> tuple[dict[str, str], tuple[str, ...]]:
    """Give meshes their paths, or stand-ins; return files by mesh, and those that are lost."""
    # Most meshes are there to be seen or touched; MuJoCo would spend seconds on their hulls.
    # Refused is a lost file on which a mass depends.
    files: dict[str, str] = {}
    lost: dict[str, str] = {}
    idle: set[str] = set()
    foreign = any(element.tag == "model" for element in tree.root.iter())  # files of <attach>
    for mesh in spec.meshes:
        if not mesh.file:
            continue
        mesh.name = mesh.name or PurePosixPath(mesh.file).stem
        given = PurePosixPath(mesh.file)
        file = str(PurePosixPath(spec.meshdir) / (given.name if spec.strippath else given))
        files[mesh.name] = file
        found, reason = paths.find(file), paths.problem(file)
        if not reason and found is not None:
            mesh.file = realpath(found)
            if found.suffix.lower() in _READABLE_SUFFIXES:
                idle.add(mesh.name)
        elif not foreign:
            lost[mesh.name] = reason
    spec.strippath = False
    shapes = (mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_SDF)
    for body in spec.bodies:
        for geom in [geom for geom in body.geoms if geom.meshname in {*lost, *idle}]:
            name = geom.meshname
            weighs, fitted = _weighs(mujoco, spec, body, geom), geom.type not in shapes
            if name in lost and weighs:
                raise refusal_of(
                    tree,
                    "body",
                    body.name,
                    f"its mass comes from the mesh '{files[name]}', which {lost[name]}; give the "
                    "directory that holds it (--package-dir DIR; in Python package_dirs), or give "
                    "the body an <inertial>",
                )
            if name in lost and fitted:
                spec.delete(geom)  # a simple shape fitted to a mesh that is not there
            if weighs or fitted:
                idle.discard(name)
    corners, triangles = _STAND_IN_MESH
    for mesh in [mesh for mesh in spec.meshes if mesh.name in {*lost, *idle}]:
        mesh.file = ""
        mesh.uservert = [float(n) for corner in corners for n in corner]
        mesh.userface = [n for triangle in triangles for n in triangle]
    return files, tuple(dict.fromkeys(files[name] for name in lost))


def _weighs(mujoco: ModuleType, spec: Any, body: Any, geom: Any) -> bool:
    """Whether the mass or the inertia of a body depends on a geom."""
    compiler, rule = spec.compiler, mujoco.mjtInertiaFromGeom
    given = body.explicitinertial and compiler.inertiafromgeom != rule.mjINERTIAFROMGEOM_TRUE
    lowest, highest = compiler.inertiagrouprange
    if given or compiler.inertiafromgeom == rule.mjINERTIAFROMGEOM_FALSE:
        return False
    massless = geom.density == 0.0 if math.isnan(geom.mass) else geom.mass == 0.0
    return bool(lowest <= geom.group <= highest and not massless and body.name != "world")


def _meshes(
    mujoco: ModuleType, spec: Any, model: Any, files: dict[str, str]
) -> dict[str, CompiledMesh]:
    """Return what geoms show, files under the names that the robot's file has for them."""
    meshes = {}
    for mesh in spec.meshes:
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_MESH, mesh.name)
        file = files.get(mesh.name, "")
        if PurePosixPath(file).suffix.lower() in _READABLE_SUFFIXES:
            size = math.sqrt(sum(float(n) ** 2 for n in mesh.refquat)) or 1.0
            ref = pose(mesh.refpos, mesh.refquat / size)
            meshes[mesh.name] = CompiledMesh(mesh.name, file, vector(mesh.scale), ref)
        elif index >= 0:
            points, faces = _corners(model, index)
            vertices = tuple(map(float, points.ravel()))
            meshes[mesh.name] = CompiledMesh(
                mesh.name, "", vertices=vertices, triangles=tuple(map(int, faces.ravel()))
            )
    return meshes


def _corners(model: Any, mesh: int) -> tuple[Array, Array]:
    """Return corners [m] (n, 3), where the file has them, and triangles (m, 3) of a mesh."""
    # MuJoCo moves meshes onto their principal axes.
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    place = se3(pose(model.mesh_pos[mesh], model.mesh_quat[mesh]))
    corners = np.array(model.mesh_vert[first : first + count], dtype=float)
    first, count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    faces = np.array(model.mesh_face[first : first + count])
    return corners @ place.rotation.T + place.translation, faces


def mesh_by_mujoco(path: Path) -> tuple[Array, Array] | None:
    """Return corners (n, 3) and triangles (m, 3) of a mesh file, None if MuJoCo cannot read it.

    It reads more ways to write a number than the loader of all other meshes does.
    """
    try:
        mujoco = load_mujoco()
    except MissingExtraError:
        return None
    with _listening(mujoco):
        try:
            spec = mujoco.MjSpec()
            mesh = spec.add_mesh(name="mesh", file=realpath(path))
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
            spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh")
            return _corners(spec.compile(), 0)
        except (ValueError, RuntimeError, mujoco.FatalError):
            return None


def check_magnitudes(tree: XmlTree) -> None:
    """Refuse places, directions and sizes whose squares MuJoCo has no number for, or soon has none.

    Those of no body, as lights and the ground, may be of any size.

    Raises:
        RobotError: naming the element and its attribute.
    """
    ways = (
        ".//light", ".//camera", ".//geom[@type='plane']", "worldbody/geom", "worldbody/site",
        "asset/hfield",
    )  # fmt: skip
    free = {element for way in ways for element in tree.root.iterfind(way)}
    for way in ("worldbody/frame", "worldbody/replicate"):
        for group in tree.root.iterfind(way):
            if not any(element.tag in _HOLDING_BODIES for element in group.iter()):
                free.update(group.iter())
    for element in tree.root.iter():
        for name in () if element in free else _VECTORS & element.attrib.keys():
            if any(SIZE <= abs(value) < math.inf for value in as_numbers(element.attrib[name])):
                text = printable(element.attrib[name])
                raise NamedElement(tree, element).refusal(
                    f"its {name} is '{text}'; its numbers must be below {SIZE:g}; correct it"
                )


def _check_copies(tree: XmlTree) -> None:
    """Refuse a few lines that stand for more elements than fit into memory."""

    def check(element: Element, copies: float) -> None:
        if element.tag in _COPYING_TAGS:
            counts = [as_number(word) for word in element.get("count", "1").split()]
            copies *= math.prod(n for n in counts if n > 1.0)
            if copies > _MOST_COPIES:
                raise NamedElement(tree, element).refusal(
                    f"its count, with those around it, asks for {copies:g} copies; at most "
                    f"{_MOST_COPIES} are made; lower it"
                )
        if element.tag == "size":
            for name, text in element.attrib.items():
                if name != "memory" and as_number(text) > _MOST_RESERVED:
                    raise NamedElement(tree, element).refusal(
                        f"its {name} is {text}; at most {_MOST_RESERVED:g} are reserved; lower it"
                    )
        for below in element:
            check(below, copies)

    check(tree.root, 1.0)


def _check_words(said: list[str], tree: XmlTree) -> None:
    """Refuse numbers that are none: MuJoCo only warns about them, and goes on."""
    if not any("NaN" in text for text in said):
        return
    for element in tree.root.iter():
        for attribute, text in element.attrib.items():
            # NaN for the word that C takes for it.
            words = (word.lower().lstrip("+-") for word in text.split())
            if attribute != "name" and any(word.startswith("nan") for word in words):
                raise NamedElement(tree, element).refusal(
                    f"its {attribute} is '{text}'; it must be finite; correct it"
                )
    raise RobotError(f"MuJoCo warns: {said[0]} Correct it")


def _refusal(mujoco: ModuleType, message: str, tree: XmlTree, paths: MeshPaths) -> RobotError:
    """Return MuJoCo's refusal, with the place at which the element stands."""
    place = _place(message)
    words = message if place is None else message[: place.start()]
    told = None if place is None else _asked_again(mujoco, words, tree, paths)
    words = " ".join(words.split())
    while (short := _ERROR_PREFIX.sub("", words)) != words:
        words = short
    words = words.rstrip(".;") or "it cannot be parsed"
    advice = next((hint for said, hint in _ADVICE.items() if said in words), "correct it")
    if _MISSING_NAME.search(words):
        words += " (of files that are made to be included, give the one that includes them)"
    parts = {} if place is None else place.groupdict()
    element = _element(tree, parts, words) if told is None else told
    if element is not None:
        if (named := _ATTRIBUTE.search(words)) and (text := element.get(named[1])) is not None:
            words += f" (it is '{printable(text)}')"
        return NamedElement(tree, element).refusal(f"MuJoCo refuses it: {words}; {advice}")
    line = parts.get("line")
    at = f"{where(int(line))}: " if line and int(line) else ""
    return RobotError(f"{at}MuJoCo refuses the file: {words}; {advice}")


def _asked_again(mujoco: ModuleType, words: str, tree: XmlTree, paths: MeshPaths) -> Element | None:
    """Return the element that MuJoCo refuses in the same words if each has a line of its own.

    It tells elements by their lines, and many may share one, or stand in an included file.
    """
    apart = tree.copy()
    for element in apart.root.iter():
        element.text = element.tail = "\n"
    text = tostring(apart.root, encoding="unicode")
    try:
        _built(mujoco, mujoco.MjSpec.from_string(text), tree, paths)
    except RobotError:  # a mesh that it did not come to
        return None
    except _refused(mujoco) as error:
        place = _place(str(error))
        if place is None or str(error)[: place.start()] != words or not place["line"]:
            return None
        again = parse_xml(text)
        pairs = zip(tree.root.iter(), again.root.iter(), strict=True)
        return next((old for old, new in pairs if again.line(new) == int(place["line"])), None)
    return None


def _place(message: str) -> re.Match[str] | None:
    """Find where in the file it is what a message of MuJoCo's is about."""
    ways = (_NAMED_PLACE, _TAGGED_PLACE, _PARSER_PLACE)
    return next((found for way in ways if (found := way.search(message))), None)


def _element(tree: XmlTree, parts: dict[str, str | None], words: str) -> Element | None:
    """Return the element that a message is about, None if it cannot be told."""
    # MuJoCo knows no lines of elements that an included file includes or holds, and says 0.
    tag, name, line = (parts.get(key) for key in ("tag", "name", "line"))
    quoted = {name, *re.findall(r"'([^']+)'", words)} - {None, ""}
    found = [e for e in tree.root.iter() if tag in (None, e.tag)]
    if line and int(line):
        found = [e for e in found if tree.line(e) == int(line)]
    elif tag is None:
        found = [e for e in found if {e.get("name"), e.get("file")} & quoted]
    else:
        found = [e for e in found if tree.file(e)] or found
    marked = [e for e in found if {*e.attrib, *e.attrib.values()} & quoted]
    return next(iter(marked or found), None)


def whole_mjcf(tree: XmlTree, base: Path | None) -> XmlTree:
    """Return a document with the included files merged, one section of each kind.

    Included files are looked up from `base`; text alone, without one, includes nothing.

    Raises:
        RobotError: an included file cannot be read, or includes itself, or elements nest too deep.
    """
    _check_levels(tree)
    whole = tree.copy()
    root = whole.root
    _include(whole, root, base, 0)
    _check_levels(whole)
    for section in list(root):
        first = root.find(section.tag)
        if first is not None and first is not section:
            first.extend(list(section))
            first.attrib.update(section.attrib)
            root.remove(section)
    return whole


def _check_levels(tree: XmlTree) -> None:
    """Refuse elements in elements in elements, of which neither MuJoCo nor Python takes any number.

    Raises:
        RobotError: naming the first that lies too deep.
    """
    level = [tree.root]
    for _ in range(_MOST_LEVELS):
        level = [below for element in level for below in element]
    if level:
        raise NamedElement(tree, level[0]).refusal(
            f"it lies in {_MOST_LEVELS} other elements; fewer are read; nest them less"
        )


def _include(whole: XmlTree, parent: Element, base: Path | None, depth: int) -> None:
    """Put the contents of included files in the place of every `include` below an element."""
    for index, element in reversed(list(enumerate(parent))):
        if element.tag != "include":
            _include(whole, element, base, depth)
            continue
        included = _included(whole, element, base, depth)
        whole.lines.update(included.lines)
        whole.files.update(included.files)
        parent.remove(element)
        for offset, entry in enumerate(included.root):
            parent.insert(index + offset, entry)


def _included(whole: XmlTree, element: Element, base: Path | None, depth: int) -> XmlTree:
    """Return the document that an `include` names, whole itself."""
    name, at = element.get("file", ""), where(whole.line(element), whole.file(element))
    if depth == _MOST_INCLUDE_LEVELS or base is None:
        why = "it is read as text" if base is None else "too many levels, or it includes itself"
        raise RobotError(f"{at}: cannot include '{name}': {why}; give one whole file")
    if not name:
        raise RobotError(f'{at}: <include> names no file; give it one, as file="legs.xml"')
    try:
        text = read_text(base / name, "included file")
    except RobotError as error:
        raise RobotError(f"{at}: {error}") from None
    found = parse_xml(text, f"the included file '{name}'")
    found.files.update(dict.fromkeys(found.lines, name))
    _check_levels(found)
    _include(found, found.root, base, depth + 1)
    return found
