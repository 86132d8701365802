"""A robot's description before anything is known about it: what every format can tell."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping
from dataclasses import field
from functools import cached_property, lru_cache
from os.path import exists, realpath
from pathlib import Path
from typing import ClassVar

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.importers.meshes import (
    LoadMesh,
    MeshPaths,
    MeshProblem,
    first_part,
    lie_on_side,
    put_upright,
    y_up,
)
from gaitopt.importers.physics import LoopFrames, Physics, Tie
from gaitopt.importers.pinocchio_model import mark_joint_frames
from gaitopt.importers.report import Finding
from gaitopt.importers.xml_document import FileProblem, XmlTree
from gaitopt.nlp import Array

_MESHES_IN_MEMORY = 128  # kept in memory: of one or two robots


@dataclass(frozen=True, eq=False)
class Source(ABC):
    """The description of a robot, checked; a format has a class of its own.

    Attributes:
        text: of the description, which `read_source` reads again as it is, though not its meshes;
            of an MJCF file its normal form (see `mjcf_robot`).
        path: of the file, None for text.
        package_dirs: directories that hold packages with meshes.
        problems: what is suspicious but did not stop reading.
        tree: the parsed description, which knows the lines of the files.
    """

    text: str
    path: Path | None
    package_dirs: tuple[str, ...]
    problems: tuple[FileProblem, ...]
    tree: XmlTree
    _sides: dict[pin.GeometryType, bool] = field(default_factory=dict, init=False, repr=False)

    format: ClassVar[str]
    """"urdf" or "mjcf"."""

    @property
    @abstractmethod
    def physics(self) -> Physics:
        """Passive joints, gravity and its compensation."""

    @property
    def drawn_posture(self) -> Mapping[str, float]:
        """Joint coordinates of the posture that the file draws, where they are not 0 [rad or m]."""
        return {}

    @property
    @abstractmethod
    def ties(self) -> Mapping[str, Tie]:
        """Joints that follow others, each to one that follows none."""

    @property
    def loops(self) -> tuple[LoopFrames, ...]:
        """Loops of bodies that are closed, in frames of `model()`; a URDF has none."""
        return ()

    @property
    def loop_motors(self) -> tuple[str, ...]:
        """Names of the joints in these loops that motors turn."""
        return ()

    @abstractmethod
    def mesh_problems(self) -> list[MeshProblem]:
        """Return the meshes that are missing, empty or were not fetched."""

    @abstractmethod
    def findings(self) -> tuple[Finding, ...]:
        """Return what the description says beside bodies, joints and shapes, and what is odd.

        Unlike `problems` it may need meshes: of links whose inertia is large for their size.
        """

    @abstractmethod
    def _build(self) -> pin.Model:
        """Return the model; joint 1 is a free-flyer."""

    @abstractmethod
    def _shapes(
        self, kind: pin.GeometryType, links: Collection[str] | None, load: LoadMesh
    ) -> pin.GeometryModel | None:
        """Return the geometry as the description has it."""

    @abstractmethod
    def _mesh_files(self) -> list[str]:
        """Return the files of all meshes, as the description names them."""

    def model(self) -> pin.Model:
        """Return a new model of the whole robot; joint 1 is a free-flyer.

        A limit of torque or speed that is not given is infinite (MJCF knows no speed limits), and
        so is the range of a continuous joint. The armature is that of the rotors which a URDF
        describes.

        Raises:
            RobotError: Pinocchio cannot read the description.
        """
        return self._whole.copy()

    def geometry(
        self,
        kind: pin.GeometryType,
        links: Collection[str] | None = None,
        load: LoadMesh | None = None,
    ) -> pin.GeometryModel | None:
        """Return the geometry of `model()` without the meshes at fault; None if there is none.

        Meshes of Collada files that lie on their side are turned upright (see `meshes`).

        Args:
            kind: what is drawn (VISUAL) or what touches (COLLISION).
            load: reads the mesh files of a URDF; by default they are read once, whoever asks.

        Raises:
            RobotError: a mesh file of an MJCF is there, but is not one that can be read; a URDF
                is drawn without it, and `mesh_problems` has it from then on.
        """
        shapes = self._shapes(kind, links, load or load_mesh)
        if shapes is not None and y_up(shapes) and self._lying(kind):
            put_upright(shapes)
        return shapes

    def mesh_directories(self) -> tuple[str, ...]:
        """Return where the meshes are found, for when only the text is left.

        Those given, then the directory of the file and those above it that hold a package or
        directory which a mesh path names.
        """
        files = self._mesh_files()
        if self.path is None or not files:
            return self.package_dirs
        folder = Path(realpath(self.path)).parent
        names = {first_part(file) for file in files} - {"", ".", ".."}
        above = [d for d in folder.parents if any(exists(d / name) for name in names)]
        return tuple(dict.fromkeys((*self.package_dirs, str(folder), *map(str, above))))

    @cached_property
    def _whole(self) -> pin.Model:
        """The model, read once and never modified."""
        model = self._build()
        if model.njoints < 2 or model.joints[1].shortname() != "JointModelFreeFlyer":
            raise RobotError("the robot has no links that can move; check the file")
        return mark_joint_frames(model)

    def _lying(self, kind: pin.GeometryType) -> bool:
        """Whether the Collada files of one kind lie on their side; all links have a say in it."""
        if kind not in self._sides:
            shapes = self._shapes(kind, None, load_mesh)
            self._sides[kind] = shapes is not None and lie_on_side(shapes, self._whole)
        return self._sides[kind]

    @property
    def _paths(self) -> MeshPaths:
        return mesh_paths(self.path, self.package_dirs)


def load_mesh(path: str, scale: Array) -> coal.BVHModelBase:
    """Return a mesh; one file at one scale is read once, and again when it has changed.

    Coal's own `CachedMeshLoader` reads it every time. Nobody collides with the tree of boxes that
    is made of a mesh; of those trees that show the corners it is the one made soonest.
    """
    changed = os.stat(path).st_mtime_ns if os.path.exists(path) else 0
    return _read_mesh(path, tuple(map(float, scale)), changed)


@lru_cache(maxsize=_MESHES_IN_MEMORY)
def _read_mesh(path: str, scale: tuple[float, ...], changed: int) -> coal.BVHModelBase:
    del changed
    return coal.MeshLoader(coal.NODE_TYPE.BV_OBB).load(path, np.array(scale))


def mesh_triangles(mesh: coal.BVHModelBase) -> tuple[Array, NDArray[np.intp]]:
    """Return corners (n, 3) and triangles (m, 3) of a mesh."""
    faces = [mesh.tri_indices(k) for k in range(mesh.num_tris)]
    return np.array(mesh.vertices()), np.array([[f[0], f[1], f[2]] for f in faces], dtype=np.intp)


def mesh_paths(path: Path | None, package_dirs: Collection[str]) -> MeshPaths:
    """Return where the meshes of a file are looked for, whose text alone may be known."""
    base = None if path is None else Path(realpath(path)).parent
    return MeshPaths(base, tuple(Path(p).expanduser() for p in package_dirs))
