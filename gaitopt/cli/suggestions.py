"""What to do where there is no gait: suggestions as commands to run, with their walks kept."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import fields
from hashlib import sha256
from pathlib import Path

import numpy as np

from gaitopt.atomic import write_atomically
from gaitopt.cli.command_options import OptimiseOptions
from gaitopt.cli.config import SCHEMA, Settings, option_words
from gaitopt.cli.request import Request, choices_text, make_robot, make_task, robot_source
from gaitopt.cli.results import write_record
from gaitopt.dataclass import dataclass
from gaitopt.design.diagnosis import Diagnosis, Suggestion
from gaitopt.design.pipeline import begins_relaxed
from gaitopt.errors import InputError
from gaitopt.gait.gait_file import save_gait
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.settings import NO_LIMIT
from gaitopt.solvers.sqp import SQP

FOLDER = "suggestions"
"""In the directory of the results, or else in one for gaitopt's files."""
RECORD = "diagnosis.json"
GUESSES = ("start", "starts", "seed", "sigma")
SAME_LIMIT = 1e-12  # relative; limits come back through a file


@dataclass(frozen=True)
class Asked:
    """The command line that was given.

    Attributes:
        settings: as typed, those of `SCHEMA`.
        options: what else `gaitopt optimise` was told.
    """

    settings: Settings
    options: OptimiseOptions

    def command(self, changes: Mapping[str, object]) -> str:
        """Return the command line with some options changed, quoted for a shell.

        Args:
            changes: by name; those that are None are left out.
        """
        told = self.options
        words = [*_program(), "optimise"]
        for name, value in {**self.settings, **changes}.items():
            words += option_words(name, value)
        words += [*option_words("config", told.config), *option_words("output", told.output)]
        flags = (("--no-page", not told.page), ("--figures", told.figures), ("--quiet", told.quiet))
        return shlex.join([*words, *(option for option, given in flags if given)])


def suggestion_lines(diagnosis: object, request: Request, asked: Asked) -> Iterator[str]:
    """Yield the lines of a diagnosis; keep the walks of its suggestions.

    Args:
        diagnosis: of a walk without a gait; anything else has no lines.
    """
    if not isinstance(diagnosis, Diagnosis):
        return
    yield from (f"- {sentence}" for sentence in diagnosis.reasons)
    try:
        folder = _folder(request, asked.options.output)
    except OSError as error:
        yield f"- nothing can be kept: {error}"
        yield from (f"- {suggestion.sentence}" for suggestion in diagnosis.suggestions)
        return
    commands = []
    for suggestion in diagnosis.suggestions:
        yield f"- {suggestion.sentence}:"
        try:
            command = asked.command(_changes(suggestion, request, asked, folder))
            kept = save_gait(suggestion.found.gait, _gait_file(suggestion, folder))
        except (InputError, OSError) as error:
            yield f"  (no command for it: {error})"
            continue
        yield f"    {command}"
        yield f"  the walk itself is kept as {kept}"
        commands.append(command)
    if asked.options.output is not None or commands:
        write_record({**diagnosis.record(), "commands": commands}, folder / RECORD)


def _changes(
    suggestion: Suggestion, request: Request, asked: Asked, folder: Path
) -> dict[str, object]:
    """Return the options to change, by name; None for those to leave out."""
    changes: dict[str, object] = {}
    for change in suggestion.changes:
        if change.setting == "impulse_cop":
            changes[change.setting] = False
        elif change.setting in (*SCHEMA["task"], *suggestion.task.declared):
            changes[change.setting] = change.after
        else:
            changes["choices"] = _write_choices(suggestion, request, folder)
            changes["limit"] = None  # those choices hold them
    changes |= _method(suggestion, request, asked)
    settings = {k: v for k, v in {**request.settings, **changes}.items() if v is not None}
    robot = make_robot(settings) if "choices" in changes else request.robot
    # what follows from the robot and the changed value by default is held where it was
    for name, value in _differing(make_task(settings, robot), suggestion.task).items():
        changes[name] = settings[name] = value
    if make_task(settings, robot) != suggestion.task or not _same_limits(robot, suggestion.robot):
        raise InputError("no option of the command line says this; change the task in Python")
    return {**changes, "start": _gait_file(suggestion, folder)}


def _method(suggestion: Suggestion, request: Request, asked: Asked) -> dict[str, object]:
    """Return the options on how to search, so that the walk is found as it was."""
    settings, wanted = request.settings, suggestion.options
    changes: dict[str, object] = dict.fromkeys(GUESSES)
    if any(name in settings and name not in asked.settings for name in GUESSES):
        changes |= {"starts": 1, "sigma": 0.0}  # the configuration file's do not count
    if begins_relaxed(suggestion.task, request.options):
        changes["approach"] = wanted.approach
    if (wanted.solver, wanted.differences) != (request.options.solver, request.options.differences):
        usual = {
            "solver": "default", "qp_solver": SQP.qp_solver, "tolerance": SQP.tolerance,
            "max_iterations": SQP.max_iterations, "differences": "none",
        }  # fmt: skip
        from_file = {n for n in usual if n in settings and n not in asked.settings}
        changes |= {n: v if n in from_file else None for n, v in usual.items()}
    return changes


def _differing(found: Task, wanted: Task) -> dict[str, object]:
    """Return the fields of task and margins that differ, with the values wanted."""
    names = [n for n in SCHEMA["task"] if n not in ("preset",)]
    differing = {n: getattr(wanted, n) for n in names if getattr(found, n) != getattr(wanted, n)}
    for name in wanted.declared:
        if found.margin(name) != (value := wanted.margin(name)):
            differing[name] = NO_LIMIT if value is None else value
    return differing


def _same_limits(robot: Robot, wanted: Robot) -> bool:
    return all(
        np.allclose(getattr(robot.limits, f.name), getattr(wanted.limits, f.name), SAME_LIMIT, 0.0)
        for f in fields(robot.limits)
    )


def _write_choices(suggestion: Suggestion, request: Request, folder: Path) -> Path:
    """Write the choices about the robot with the limits of a suggestion."""
    _, choices = robot_source(request.settings)
    changed = suggestion.robot.choices.limits[len(request.robot.choices.limits) :]
    path = folder / f"{_file_name(suggestion)}.toml"
    text = choices_text(choices.over(limits=(*choices.limits, *changed)))
    return write_atomically(path, text.encode())


def _gait_file(suggestion: Suggestion, folder: Path) -> Path:
    """Where the walk is kept, from which the command goes on."""
    return folder / f"{_file_name(suggestion)}.npz"


def _file_name(suggestion: Suggestion) -> str:
    names = " and ".join(change.setting for change in suggestion.changes)
    return (names or "same task").replace(" ", "_")


def _folder(request: Request, output: Path | None) -> Path:
    """Return the directory for the walks of suggestions, made if need be."""
    if output is not None:
        folder = output / FOLDER
        folder.mkdir(parents=True, exist_ok=True)
        return folder
    same = repr((request.robot.urdf, request.task)).encode()
    name = Path("gaitopt") / FOLDER / sha256(same).hexdigest()[:12]
    for place in (_cache, lambda: Path(tempfile.gettempdir())):
        try:
            folder = place() / name
            folder.mkdir(parents=True, exist_ok=True)
        except (OSError, RuntimeError) as error:  # the second where a user has no home
            reason = error
        else:
            return folder
    raise OSError(str(reason))


def _cache() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


def _program() -> list[str]:
    """Return what starts gaitopt from a shell, as it was started."""
    if Path(sys.argv[0]).name == "__main__.py":
        name = Path(sys.executable).name
        found = shutil.which(name)
        same = found is not None and os.path.samefile(found, sys.executable)
        return [name if same else sys.executable, "-m", "gaitopt"]
    return ["gaitopt"]
