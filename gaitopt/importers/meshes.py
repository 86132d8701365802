"""Mesh files: where they are, whether they can be read, which axis of a Collada file is up.

Pinocchio takes the numbers of a Collada file as they are, whichever axis the file calls up. Many
robots are made for that, and their files say y only because some program wrote it there; others
mean it. Which of the two, the masses tell: the links' shapes lie about their centres of mass.
"""

from __future__ import annotations

import os
import struct
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from os.path import isfile
from pathlib import Path, PurePosixPath
from urllib.parse import unquote
from xml.etree import ElementTree
from xml.parsers import expat

import coal
import numpy as np
import pinocchio as pin

from gaitopt.bounds import MESH, too_large
from gaitopt.dataclass import dataclass
from gaitopt.errors import reason_of
from gaitopt.importers.xml_document import EXPAND, is_macro
from gaitopt.nlp import Array

LoadMesh = Callable[[str, Array], coal.BVHModelBase]
"""Reads a file at a scale (3,)."""

_PACKAGE_SCHEMES = ("package", "model")
_LFS_POINTER = b"version https://git-lfs"  # in a clone without its large files
_READABLE_SUFFIXES = (
    ".stl", ".dae", ".obj", ".ply", ".off", ".3ds", ".fbx", ".gltf", ".glb", ".x", ".amf", ".3mf",
    ".dxf", ".lwo", ".ac", ".ase", ".x3d", ".blend",
)  # fmt: skip
_Y_UP_TO_Z_UP = pin.SE3(np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]), np.zeros(3))
_CLEARLY_NEARER = 0.8  # of the distance to the masses: symmetric shapes tell nothing
_STL_HEADER, _STL_FACET = 84, 50  # bytes of a binary STL file: before its facets, and of each


@dataclass(frozen=True)
class MeshProblem:
    """A mesh file that cannot be used. Motion needs no mesh; drawings and soles may.

    Attributes:
        link: that the mesh belongs to.
        kind: "visual" or "collision".
        file: the path as the robot's file gives it.
        reason: why it cannot be used.
        there: whether the file was found, and is at fault itself.
    """

    link: str
    kind: str
    file: str
    reason: str
    there: bool = False

    def __str__(self) -> str:
        """Return one sentence that says what to do."""
        advice = (
            "give the directory that holds its package (--package-dir DIR; in Python "
            "package_dirs), or correct the path"
        )
        if is_macro(self.file):
            advice = EXPAND
        elif self.there:
            advice = "the robot is read without it; replace the file, by one in STL format say"
        return f"link '{self.link}': the {self.kind} mesh '{self.file}' {self.reason}; {advice}"


@dataclass(frozen=True)
class MeshPaths:
    """Where to look for the meshes of one robot.

    Attributes:
        base: directory of the robot's file, None for a robot given as text.
        package_dirs: directories that contain packages, searched first.
    """

    base: Path | None
    package_dirs: tuple[Path, ...] = ()

    def find(self, file: str) -> Path | None:
        """Return the first existing file that a mesh path may mean, or None."""
        address = file.replace("\\", "/")
        ways = dict.fromkeys((address, unquote(address)))
        places = (path for way in ways for path in self._places(way))
        return next((path for path in places if isfile(path)), None)

    def problem(self, file: str) -> str:
        """Return why a mesh file cannot be used, or an empty string."""
        path = self.find(file)
        if path is None:
            return "is named by a macro of xacro" if is_macro(file) else "was not found"
        try:
            if large := too_large(path.stat().st_size, MESH):
                return f"is not read: {large}"
            with path.open("rb") as stream:
                head = stream.read(len(_LFS_POINTER))
        except OSError as error:
            return _no_access(error)
        if not head:
            return "is an empty file"
        if head == _LFS_POINTER:
            return "is a Git LFS pointer whose content was not fetched"
        return ""

    def _places(self, address: str) -> Iterator[Path]:
        scheme, separated, inside = address.partition("://")
        if separated and scheme.lower() in _PACKAGE_SCHEMES:
            package, _, inside = inside.partition("/")
            yield from self._in_package(package, inside.lstrip("/"))
            return
        if separated and scheme.lower() == "file":
            address = inside.removeprefix("localhost")  # which leaves the path from the root
        path = Path(address)
        if path.is_absolute():
            yield path
            yield from self._moved(path)
        else:
            yield from (directory / path for directory in self._directories())

    def _in_package(self, package: str, inside: str) -> Iterator[Path]:
        for directory in [*self._directories(), *_environment()]:
            yield directory / package / inside
            if directory.name == package:
                yield directory / inside
        if "/" in inside:  # a package whose directory was renamed: some/clone/meshes/foot.stl
            yield from (above / inside for above in self._above())

    def _moved(self, path: Path) -> Iterator[Path]:
        """An absolute path of another machine, sought above the robot's file by its last parts."""
        parts = PurePosixPath(path).parts[1:]
        for first in range(1, len(parts) - 1):
            yield from (above.joinpath(*parts[first:]) for above in self._directories())

    def _directories(self) -> list[Path]:
        return [*self.package_dirs, *self._above()]

    def _above(self) -> list[Path]:
        return [] if self.base is None else [self.base, *self.base.parents]


def unreadable(path: Path) -> str:
    """Return why a mesh file that is there cannot be a mesh that is read, or an empty string.

    STL files are checked whole, of others the format and, of Collada, whether they are XML.
    """
    try:
        facts = path.stat()
        return _unreadable(path, facts.st_mtime_ns, facts.st_size)
    except OSError as error:
        return _no_access(error)


def _no_access(error: OSError) -> str:
    return f"cannot be read ({reason_of(error)})"


@lru_cache(maxsize=4096)
def _unreadable(path: Path, _changed: int, size: int) -> str:
    suffix = path.suffix.lower()
    if suffix not in _READABLE_SUFFIXES:
        named = suffix or "without an ending"
        return f"is of a format that cannot be read ({named})"
    if suffix == ".stl" and not _is_stl(path, size):
        return "is a broken STL file"
    if suffix == ".dae":
        try:
            with path.open("rb") as stream:
                expat.ParserCreate().ParseFile(stream)
        except expat.ExpatError:
            return "is a broken Collada file"
    return ""


def _is_stl(path: Path, size: int) -> bool:
    """Whether a file has the length of a binary STL, or the words of a textual one."""
    with path.open("rb") as stream:
        head = stream.read(_STL_HEADER)
        if len(head) == _STL_HEADER:
            (facets,) = struct.unpack("<I", head[-4:])
            if facets and size >= _STL_HEADER + facets * _STL_FACET:
                return True
        if not head.lstrip().startswith(b"solid"):
            return False
        return b"vertex" in head + stream.read()


def first_part(file: str) -> str:
    """Return the package, or the first directory, that a mesh path names."""
    _, scheme, rest = file.partition("://")
    return (rest if scheme else file).lstrip("/").partition("/")[0]


def _environment() -> list[Path]:
    """Directories of packages that a ROS installation names."""
    roots = [Path(p) for p in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if p]
    prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return roots + [Path(p) / "share" for p in prefixes if p]


def up_axis(path: str) -> str:
    """Return the upward axis of a Collada file, "Y_UP" by default, "" if it is unreadable."""
    try:
        with open(path, "rb") as stream:
            for _, element in ElementTree.iterparse(stream):
                name = element.tag.rpartition("}")[2]
                if name == "up_axis":
                    return (element.text or "").strip()
                if name == "asset":  # which holds it, and comes first
                    break
    except (OSError, ElementTree.ParseError):
        return ""
    return "Y_UP"


def y_up(shapes: pin.GeometryModel) -> list[pin.GeometryObject]:
    """Return the shapes from Collada files that call their y axis up."""
    return [
        item
        for item in shapes.geometryObjects
        if item.meshPath.lower().endswith(".dae") and up_axis(item.meshPath) == "Y_UP"
    ]


def lie_on_side(shapes: pin.GeometryModel, model: pin.Model) -> bool:
    """Tell whether the shapes of `y_up` are clearly nearer to the masses when they are turned."""
    as_read, turned = 0.0, 0.0
    for item in y_up(shapes):
        inertia = model.inertias[item.parentJoint]
        if inertia.mass > 0.0:
            item.geometry.computeLocalAABB()
            middle = np.ravel(item.geometry.aabb_center)
            as_read += float(np.linalg.norm(item.placement.act(middle) - inertia.lever))
            upright = (item.placement * _Y_UP_TO_Z_UP).act(middle)
            turned += float(np.linalg.norm(upright - inertia.lever))
    return turned < _CLEARLY_NEARER * as_read


def put_upright(shapes: pin.GeometryModel) -> None:
    """Turn the shapes of `y_up` so that their z axis is up."""
    for item in y_up(shapes):
        item.placement = item.placement * _Y_UP_TO_Z_UP


@contextmanager
def silenced() -> Iterator[None]:
    """Send what is written to the streams of the process to nowhere, for the time of a call.

    C++ libraries print what names no file and helps nobody. Python's own streams are silent as
    well. Where there are no streams, nothing is done.
    """
    try:
        kept = [os.dup(number) for number in (1, 2)]
    except OSError:
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        _flush()
        for number in (1, 2):
            os.dup2(nowhere, number)
        yield
    finally:
        _flush()
        for number, copy in zip((1, 2), kept, strict=True):
            os.dup2(copy, number)
            os.close(copy)
        os.close(nowhere)


def _flush() -> None:
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError, AttributeError):
            continue  # closed, or there is none: nothing of it can be lost
