"""An MJCF file, or the normal form of one, as a compiled robot."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gaitopt.robot.files.meshes import MeshPaths
from gaitopt.robot.files.xml_lines import XmlTree
from gaitopt.robot.findings import Finding
from gaitopt.robot.mjcf.compile import compile_mjcf
from gaitopt.robot.mjcf.compiled import CompiledRobot
from gaitopt.robot.mjcf.extract import extract
from gaitopt.robot.mjcf.include import whole_mjcf
from gaitopt.robot.mjcf.normal_form import NotNormalError, is_normal, normal_text, read_normal
from gaitopt.robot.urdf.values import UrdfProblem


@dataclass(frozen=True, eq=False)
class Mjcf:
    """What was read.

    Attributes:
        text: the robot in normal form.
        robot: in numbers.
        tree: of the document, included files merged.
        problems: what is suspicious, but did not stop reading.
        findings: what a person should know about how it was read.
    """

    text: str
    robot: CompiledRobot
    tree: XmlTree
    problems: tuple[UrdfProblem, ...] = ()
    findings: tuple[Finding, ...] = ()


def read_mjcf(text: str, path: Path | None, tree: XmlTree, paths: MeshPaths) -> Mjcf:
    """Read an MJCF document: MuJoCo says what it means, unless it is in normal form already.

    Args:
        text: of the file.
        path: of the file, None for text alone, which may include nothing.
        tree: of the text.
        paths: where meshes are.

    Raises:
        RobotError: MuJoCo refuses the document, a mass depends on a mesh that is missing, or what
            it describes is no robot.
        MissingExtraError: MuJoCo is not installed.
    """
    if is_normal(tree.root):
        try:
            return Mjcf(text, read_normal(tree.root), tree)
        except NotNormalError:
            pass  # changed by hand; it is still MJCF
    whole = whole_mjcf(tree, None if path is None else path.parent)
    found = extract(compile_mjcf(text, path, whole, paths), whole)
    return Mjcf(normal_text(found.robot), found.robot, whole, found.problems, found.findings)
