"""Where the mesh files of a robot are: every kind of path, found or reported."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from gaitopt.bounds import MESH, too_large

_PACKAGE_SCHEMES = ("package://", "model://")
_POINTER = b"version https://git-lfs"  # what stands in a clone whose large files were not fetched


@dataclass(frozen=True)
class MeshProblem:
    """A mesh file that cannot be used. Motion needs no mesh; drawings and soles may.

    Attributes:
        link: that the mesh belongs to.
        kind: "visual" or "collision".
        file: the path as the robot's file gives it.
        reason: why it cannot be used.
    """

    link: str
    kind: str
    file: str
    reason: str

    def __str__(self) -> str:
        """Return one sentence that says what to do."""
        return (
            f"link '{self.link}': the {self.kind} mesh '{self.file}' {self.reason}; "
            "give the directory that holds its package (--package-dir DIR; in Python "
            "package_dirs), or correct the path"
        )


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
        return next((path for path in self._candidates(file) if path.is_file()), None)

    def problem(self, file: str) -> str:
        """Return why a mesh file cannot be used, or an empty string."""
        path = self.find(file)
        if path is None:
            return "was not found"
        try:
            if large := too_large(path.stat().st_size, MESH):
                return f"is not read: {large}"
            with path.open("rb") as stream:
                head = stream.read(len(_POINTER))
        except OSError as error:
            return f"cannot be read ({(error.strerror or str(error)).lower()})"
        if not head:
            return "is an empty file"
        if head == _POINTER:
            return "is a Git LFS pointer whose content was not fetched"
        return ""

    def _candidates(self, file: str) -> Iterator[Path]:
        for scheme in _PACKAGE_SCHEMES:
            if file.startswith(scheme):
                package, _, inside = file.removeprefix(scheme).partition("/")
                yield from self._in_package(package, inside)
                return
        path = Path(file.removeprefix("file://"))
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


def first_part(file: str) -> str:
    """Return the package, or the first directory, that a mesh path names."""
    _, scheme, rest = file.partition("://")
    return (rest if scheme else file).lstrip("/").partition("/")[0]


def _environment() -> list[Path]:
    """Directories of packages that a ROS installation names."""
    roots = [Path(p) for p in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if p]
    prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return roots + [Path(p) / "share" for p in prefixes if p]
