"""Which robot: of the catalogue, of a file, of a specification; and what was chosen about it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import tomli_w

from gaitopt.catalogue.biped_spec import BipedSpec, biped13
from gaitopt.catalogue.entries import biped_of, description, entry_by_name
from gaitopt.catalogue.spec_file import read_spec
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.cli.config import SCHEMA, Settings
from gaitopt.errors import InputError
from gaitopt.model.feet.sole import Sole
from gaitopt.model.import_options import (
    Choices,
    LimitOverride,
    choices_from_record,
    choices_from_toml,
    choices_record,
)
from gaitopt.model.robot import Robot

ROBOTS = ("robot", "spec", "urdf")
"""Settings that name a robot; they exclude each other."""

_CHOICES_HEADER = """\
# How gaitopt reads this robot; edit what it guessed wrongly, then: --choices FILE. SI units.
# An entry that is left out is found again from the robot's file; `gaitopt inspect` tells how.
"""

_EDGES = ("toe", "heel", "left", "right")


def make_robot(settings: Settings) -> Robot:
    """Return the robot asked for, by default the thirteen-link biped.

    Raises:
        InputError: a file cannot be used, more than one robot is given, or it is not a biped.
    """
    source, choices = robot_source(settings)
    return Robot.from_urdf(source, choices=choices)


def robot_source(settings: Settings) -> tuple[str | Path, Choices]:
    """Return the URDF asked for, as text or path, and what was chosen about the robot.

    What the catalogue says is replaced by the file of choices, and that by single options.

    Raises:
        InputError: a file cannot be used, or more than one robot is given.
    """
    given = [name for name in ROBOTS if settings.get(name) is not None]
    if len(given) > 1:
        names = " and ".join(f"--{name}" for name in given)
        raise InputError(f"{names} exclude each other; give one of them")
    source, choices = _described(settings)
    if (path := settings.get("choices")) is not None:
        choices = _joined(choices, choices_from_toml(Path(str(path))))
    return source, _with_armature(choices.over(**_single(settings)), settings.get("armature"))


def _joined(choices: Choices, more: Choices) -> Choices:
    """Return choices with those of a file in their place; of limits, the later ones count."""
    own = choices_from_record({**choices_record(choices), **choices_record(more)})
    before = (entry for entry in choices.limits if entry not in more.limits)
    return replace(own, limits=(*before, *more.limits))


def _with_armature(choices: Choices, given: object) -> Choices:
    """Return choices with the rotor inertias of the command line [kg·m²], which count last."""
    if given is None:
        return choices
    if "armature" in choices.without:
        raise InputError(
            "--without armature leaves out every rotor inertia, --armature gives some; leave out "
            "one of the two (--armature '*=0' before the others leaves out those of the file only)"
        )
    named = SCHEMA["robot"]["armature"].read_pairs(given)
    entries = (LimitOverride(joints, armature=value) for joints, value in named.items())
    return replace(choices, limits=(*choices.limits, *entries))


def _described(settings: Settings) -> tuple[str | Path, Choices]:
    if (name := settings.get("robot")) is not None:
        return description(entry_by_name(str(name)))
    spec = biped_spec(settings)
    return Path(str(settings["urdf"])) if spec is None else urdf_text(spec), Choices()


def biped_spec(settings: Settings) -> BipedSpec | None:
    """Return the parameter table of a biped that gaitopt makes itself, None for another robot.

    Raises:
        InputError: the file cannot be used, or there is no robot of that name.
    """
    if (name := settings.get("robot")) is not None:
        entry = entry_by_name(str(name))
        return None if entry.file else biped_of(entry)
    if settings.get("urdf") is not None:
        return None
    path = settings.get("spec")
    return biped13() if path is None else read_spec(Path(str(path)))


def _single(settings: Settings) -> dict[str, object]:
    """Return the choices given as options of their own."""
    names = ("forward", "posture", "srdf", "stance_sole", "swing_sole")
    chosen: dict[str, object] = {name: settings.get(name) for name in names}
    if chosen["srdf"] is not None:
        chosen["srdf"] = str(Path(str(chosen["srdf"])).absolute())
    if (edges := settings.get("sole")) is not None:
        chosen["sole"] = sole_of(str(edges))
    directories: Any = settings.get("package_dir")
    if directories:
        require_directories(directories)
        chosen["package_dirs"] = tuple(str(Path(d).absolute()) for d in directories)
    parts: Any = settings.get("without")
    if parts is not None:
        chosen["without"] = tuple(part.strip() for text in parts for part in text.split(","))
    return chosen


def require_directories(directories: Iterable[str | Path]) -> None:
    """Check directories of meshes.

    Raises:
        InputError: one is not there.
    """
    for directory in directories:
        if not Path(directory).is_dir():
            raise InputError(
                f"--package-dir {directory}: there is no such directory; give the one that holds "
                "the packages which the mesh paths name"
            )


def catalogued_task(settings: Settings) -> Settings:
    """Return the walk that the catalogue proposes for a robot asked for by name.

    Raises:
        InputError: there is no robot of that name.
    """
    name = settings.get("robot")
    return {} if name is None else dict(entry_by_name(str(name)).task)


def robot_origin(settings: Settings) -> str:
    """Return where a robot of the catalogue is from; empty for others."""
    name = settings.get("robot")
    entry = None if name is None else entry_by_name(str(name))
    return f"{entry.file} of {entry.package}" if entry is not None and entry.file else ""


def choices_text(choices: Choices) -> str:
    """Return choices as TOML, with a word on how to use them."""
    return f"{_CHOICES_HEADER}{_rows_on_lines(tomli_w.dumps(choices_record(choices)))}"


_NUMBERS = re.compile(r"\[\n((?:\s+[-+.\w]+,\n)+)\s*\]")


def _rows_on_lines(toml: str) -> str:
    """Return TOML whose innermost arrays stand on a line each, as people write them."""
    return _NUMBERS.sub(lambda found: f"[{' '.join(found[1].split()).rstrip(',')}]", toml)


def sole_of(text: str) -> Sole:
    """Read a sole rectangle from "toe,heel,left,right" [m].

    Raises:
        InputError: they are not four numbers, or the rectangle is empty.
    """
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != len(_EDGES):
        raise InputError(
            f"the sole '{text}' is not four numbers; give its edges in metres, "
            "toe,heel,left,right, as in --sole 0.12,-0.05,0.03,-0.03"
        )
    return Sole(**dict(zip(_EDGES, numbers, strict=True)))
