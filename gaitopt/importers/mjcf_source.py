"""An MJCF file as the source of a robot: compiled by MuJoCo, or the normal form of one that was."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cached_property
from pathlib import Path

import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.importers.meshes import LoadMesh, MeshProblem
from gaitopt.importers.mjcf_compile import compile_mjcf, whole_mjcf
from gaitopt.importers.mjcf_extract import extract
from gaitopt.importers.mjcf_model import (
    build_mjcf_geometry,
    build_mjcf_model,
    build_physics,
    loop_frames,
    missing_meshes,
)
from gaitopt.importers.mjcf_normal_form import (
    NotNormalError,
    is_normal,
    normal_text,
    read_normal,
)
from gaitopt.importers.mjcf_robot import CompiledRobot
from gaitopt.importers.physics import LoopFrames, Physics
from gaitopt.importers.report import Finding
from gaitopt.importers.source import Source, load_mesh, mesh_paths
from gaitopt.importers.ties import Tie, resolved
from gaitopt.importers.xml_document import XmlTree


@dataclass(frozen=True, eq=False)
class MjcfSource(Source):
    """An MJCF file.

    Attributes:
        compiled: what MuJoCo made of it.
        notes: what a person should know about how MuJoCo's numbers were read.
    """

    format = "mjcf"
    compiled: CompiledRobot
    notes: tuple[Finding, ...] = ()

    @cached_property
    def physics(self) -> Physics:
        return build_physics(self.compiled)

    @property
    def drawn_posture(self) -> Mapping[str, float]:
        return self.compiled.drawn_posture

    @cached_property
    def ties(self) -> Mapping[str, Tie]:
        return resolved(self.compiled.followers)[0]

    @property
    def loops(self) -> tuple[LoopFrames, ...]:
        return loop_frames(self.compiled)

    @property
    def loop_motors(self) -> tuple[str, ...]:
        return self.compiled.motors

    def mesh_problems(self) -> list[MeshProblem]:
        return missing_meshes(self.compiled, self._paths)

    def findings(self) -> tuple[Finding, ...]:
        return self.notes

    def _build(self) -> pin.Model:
        try:
            return build_mjcf_model(self.compiled)
        except (ValueError, RuntimeError, IndexError, KeyError) as error:
            # Pinocchio puts where in its own code the error arose before the message proper.
            told = str(error).split("message:")[-1].strip() or type(error).__name__
            text = f"the MJCF file cannot be read: {told.splitlines()[0]}; correct it"
            raise RobotError(text) from error

    def _shapes(
        self, kind: pin.GeometryType, links: Collection[str] | None, load: LoadMesh
    ) -> pin.GeometryModel | None:
        del load  # only those of a URDF may be unreadable
        whole = self._whole
        return build_mjcf_geometry(self.compiled, whole, kind, self._paths, load_mesh, links)

    def _mesh_files(self) -> list[str]:
        return [mesh.file for mesh in self.compiled.meshes if mesh.file]


def read_mjcf(tree: XmlTree, text: str, path: Path | None, dirs: tuple[str, ...]) -> MjcfSource:
    """Read a robot from an MJCF file.

    Args:
        tree, text: of the file.
        path: of the file, None if only its text is known.
        dirs: in which packages of meshes are looked for.

    Raises:
        RobotError: what the file describes is no robot.
        MissingExtraError: MuJoCo is not installed.
    """
    if is_normal(tree.root):
        try:
            return MjcfSource(text, path, dirs, (), tree, read_normal(tree.root))
        except NotNormalError:
            pass  # changed by hand; it is still MJCF
    whole = whole_mjcf(tree, None if path is None else path.parent)
    compiled = compile_mjcf(text, path, whole, mesh_paths(path, dirs))
    robot, problems, notes = extract(compiled, whole)
    return MjcfSource(normal_text(robot), path, dirs, problems, whole, robot, notes)
