"""Reading a robot: a URDF here, an MJCF file in `mjcf_model`."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import field
from functools import cached_property, lru_cache
from pathlib import Path

import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.importers.meshes import LoadMesh, MeshProblem
from gaitopt.importers.physics import PassiveJoint, Physics, Tie
from gaitopt.importers.report import Finding
from gaitopt.importers.source import Source, load_mesh
from gaitopt.importers.text_files import read_text
from gaitopt.importers.urdf_check import CheckedUrdf, check_urdf, urdf_findings
from gaitopt.importers.urdf_model import (
    Kind,
    add_armature,
    build_geometry,
    diagonals,
    mesh_problems,
    model_of_urdf,
)
from gaitopt.importers.xml_document import XmlTree, parse_xml


@dataclass(frozen=True, eq=False)
class UrdfSource(Source):
    """A URDF.

    Attributes:
        said: what it says.
    """

    format = "urdf"
    said: CheckedUrdf
    _broken: dict[tuple[str, str], MeshProblem] = field(
        default_factory=dict, init=False, repr=False
    )

    @cached_property
    def physics(self) -> Physics:
        joints = self.said.robot.joints.values()
        passive = (
            (j.name, PassiveJoint((j.damping,) if j.damping else (), j.friction)) for j in joints
        )
        return Physics({name: joint for name, joint in passive if not joint.idle})

    @property
    def ties(self) -> Mapping[str, Tie]:
        return self.said.ties

    def mesh_problems(self) -> list[MeshProblem]:
        found = mesh_problems(self.said.shapes, self._paths)
        known = {(problem.link, problem.file) for problem in found}
        return found + [p for place, p in self._broken.items() if place not in known]

    def findings(self) -> tuple[Finding, ...]:
        return urdf_findings(self.said.robot, self.said.rotors, self._diagonals)

    def _build(self) -> pin.Model:
        model = model_of_urdf(self.said.robot)
        add_armature(model, self.said.rotors)
        return model

    def _shapes(
        self, kind: pin.GeometryType, links: Collection[str] | None, load: LoadMesh
    ) -> pin.GeometryModel | None:
        wanted = (shape for shape in self.said.shapes if shape.kind == kind.name.lower())
        shapes, broken = build_geometry(self._whole, wanted, self._paths, load, links)
        self._broken.update({(problem.link, problem.file): problem for problem in broken})
        return shapes if shapes.ngeoms else None

    def _mesh_files(self) -> list[str]:
        return [mesh.get("filename", "") for mesh in self.tree.root.iter("mesh")]

    def _diagonals(self, kind: Kind, links: Collection[str]) -> dict[str, float]:
        """Return the diagonals of boxes about the shapes of some links [m]."""
        shapes = self._shapes(getattr(pin.GeometryType, kind.upper()), links, load_mesh)
        return {} if shapes is None else diagonals(self._whole, shapes)


def read_source(urdf: str | Path, package_dirs: Collection[str | Path] = ()) -> Source:
    """Read a robot from a URDF or MJCF file, or from its text, and check it.

    Args:
        urdf: path of the file, or its text, which begins with "<".
        package_dirs: directories in which packages of meshes are looked for, before those above
            the file and those that ROS_PACKAGE_PATH and AMENT_PREFIX_PATH name.

    Raises:
        RobotError: the file cannot be read, or what it describes is no robot; see `check_urdf`,
            `compile_mjcf` and `extract`.
        MissingExtraError: it is MJCF, and MuJoCo is not installed.
    """
    text, path = _text(urdf)
    dirs = tuple(map(str, package_dirs))
    if (checked := _checked_urdf(text)) is not None:
        tree, said = checked
        return UrdfSource(text, path, dirs, said.problems, tree, said)
    tree = parse_xml(text)
    if tree.root.tag == "mujocoinclude":
        raise RobotError(
            "the file holds <mujocoinclude>, a part of an MJCF file; give the file that includes it"
        )
    from gaitopt.importers.mjcf_model import read_mjcf  # whose modules a URDF does not need

    return read_mjcf(tree, text, path, dirs)


@lru_cache(maxsize=2)  # whoever draws a robot that was just designed for has the same text
def _checked_urdf(text: str) -> tuple[XmlTree, CheckedUrdf] | None:
    """Return a URDF parsed and checked; None for a file of MuJoCo's."""
    tree = parse_xml(text)
    return None if tree.root.tag.startswith("mujoco") else (tree, check_urdf(tree))


def _text(urdf: str | Path) -> tuple[str, Path | None]:
    if isinstance(urdf, str):
        if urdf.lstrip("\ufeff \t\r\n").startswith("<"):
            return urdf.lstrip("\ufeff \t\r\n"), None
        if not urdf.strip():
            raise RobotError("the robot is empty text; give a URDF, or the path of a file")
    path = Path(urdf).expanduser()
    return read_text(path, "URDF"), path
