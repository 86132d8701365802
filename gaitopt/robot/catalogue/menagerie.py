"""Robots of MuJoCo Menagerie, through the package `mujoco-menagerie`, which fetches them.

Names are `menagerie:NAME`, or `menagerie:NAME/ENTRY` for another of the files of a robot.
"""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path
from types import ModuleType
from typing import Any, cast

from gaitopt.errors import InputError, MissingExtraError

PREFIX = "menagerie:"
PACKAGE = "mujoco-menagerie"
EXTRA = "menagerie"
"""Name of the extra that installs it."""

_KIND = "humanoid"


def menagerie_robot(name: str) -> tuple[str, str]:
    """Return the title of a robot, and its file from the root of the collection. Fetches nothing.

    Args:
        name: with the prefix.

    Raises:
        MissingExtraError: the package is not installed.
        InputError: it knows no such robot, or no such file of it.
    """
    package = _package(name)
    wanted, _, entry = name.removeprefix(PREFIX).partition("/")
    known = humanoids()
    if wanted not in package.names():
        close = get_close_matches(wanted, package.names(), n=1)
        hint = f"did you mean '{PREFIX}{close[0]}'? " if close else ""
        raise InputError(
            f"{PACKAGE} has no robot '{wanted}'; {hint}its humanoids are {', '.join(known)}"
        )
    robot = package.get(wanted)
    files = {point.name: point.file for point in robot.entry_points}
    if entry and entry not in files:
        raise InputError(
            f"'{wanted}' of {PACKAGE} has no file '{entry}'; it has {', '.join(files)}"
        )
    return str(robot.display_name), f"{wanted}/{files[entry or robot.default_model]}"


def menagerie_file(name: str) -> Path:
    """Return the path of a robot's MJCF file, which is fetched if it is not on this machine.

    Raises:
        MissingExtraError: the package is not installed.
        InputError: it knows no such robot, or cannot fetch it.
    """
    package = _package(name)
    _, file = menagerie_robot(name)
    robot, _, inside = file.partition("/")
    try:
        folder = package.get(robot).path(progress=None)
    except (package.MenagerieError, OSError) as error:
        told = " ".join(str(error).split()).rstrip(".")
        raise InputError(
            f"{PACKAGE} cannot fetch '{robot}': {told}; check the connection, or set "
            "MENAGERIE_ROOT to a clone of mujoco_menagerie; any file of it can also be given by "
            "--urdf FILE"
        ) from None
    return Path(folder) / inside


def humanoids() -> tuple[str, ...]:
    """Return the names of the humanoids that the installed package knows; none without it."""
    try:
        package = _package("")
    except MissingExtraError:
        return ()
    return tuple(str(robot.name) for robot in cast(Any, package).robots(_KIND))


def _package(name: str) -> ModuleType:
    try:
        import mujoco_menagerie
    except ImportError:
        raise MissingExtraError(f"the robot '{name}'", EXTRA) from None
    return cast(ModuleType, mujoco_menagerie)
