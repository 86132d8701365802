"""What to say where nothing in the file shows the sole."""

from __future__ import annotations

from collections.abc import Sequence

from gaitopt.errors import RobotError
from gaitopt.robot.files.meshes import MeshProblem

_DIRECTORY = (
    "give the directory that holds their package (--package-dir DIR; in Python package_dirs), or "
)
_RECTANGLE = (
    "the sole rectangle ([sole] with toe, heel, left, right in the file for --choices, or --sole; "
    "in Python sole=Sole(toe, heel, left, right))"
)
_DROP = " and the height of the ankle above it (sole_drop in the same file, or in Python)"


def unseen_sole(lost: Sequence[MeshProblem], frame: str | None) -> RobotError:
    """Return the error that the feet have no shape, to be raised.

    Args:
        lost: meshes of the robot that cannot be used.
        frame: of the right sole, None where the file has no sole frames either.
    """
    shows = "no collision box or visual shape of the feet shows their soles"
    where = ", and the file has no sole frames" if frame is None else f" (frame '{frame}')"
    drop = _DROP if frame is None else ""
    if not lost:
        return RobotError(f"{shows}{where}; give {_RECTANGLE}{drop}")
    count = len({problem.file for problem in lost})
    many = "one mesh" if count == 1 else f"{count} meshes"
    first = f"'{lost[0].file}' of link '{lost[0].link}' {lost[0].reason}"
    which = f"{many} cannot be used: {first}{', and so on' if count > 1 else ''}"
    return RobotError(f"{shows}{where}; {which}; {_DIRECTORY}{_RECTANGLE}{drop}")
