"""From settings to what `design_gait` takes: robot, task, method, first guess."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from gaitopt.bounds import STARTS, at_most, shown
from gaitopt.catalogue.biped_spec import BipedSpec, biped13
from gaitopt.catalogue.entries import biped_of, description, entry_by_name
from gaitopt.catalogue.spec_file import read_spec
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.cli.config import SCHEMA, Settings, read_config, with_plugin
from gaitopt.design.options import COUNT, SIGMA, DesignOptions
from gaitopt.errors import InputError
from gaitopt.gait.costs import COSTS, cost_by_name
from gaitopt.gait.gait_file import load_gait
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.parameters import set_quantities
from gaitopt.gait.plugin import load_plugin
from gaitopt.gait.presets import HUMANOID, PRESETS, preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task
from gaitopt.model.feet.sole import Sole
from gaitopt.model.import_options import (
    Choices,
    LimitOverride,
    choices_from_record,
    choices_from_toml,
    choices_record,
)
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array
from gaitopt.solvers import Solver, solver_by_name
from gaitopt.solvers.sqp import SQP
from gaitopt.solvers.two_stage import CERTIFIER, CertifiedSQP

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


Geometry = dict[str, dict[str, float | bool]]


@dataclass(frozen=True)
class Request:
    """What the user asked for.

    Attributes:
        robot, task, options: as `design` takes them.
        start: first guess, None for the usual one.
        starts: how many guesses to try; with more than one, `noise` makes the others.
        noise: standard deviation [rad] and seed.
        settings: what was given, for the record.
    """

    robot: Robot
    task: Task
    options: DesignOptions
    start: Array | None
    starts: int
    noise: tuple[float, int]
    settings: Settings


def make_request(given: Settings, config: Path | None) -> Request:
    """Return the request of a command line.

    Args:
        given: options of the command line, those not given left out; "free" and "fix" as typed.
        config: configuration file, if any; the command line wins.

    Raises:
        InputError: an option, a file or a value cannot be used.
        UnreachableError: the step asked for is longer than the legs.
    """
    plugin = Path(str(given["plugin"])) if "plugin" in given else None
    settings = _merged({} if config is None else read_config(config, plugin), given)
    settings = {"preset": usual_preset(settings), **catalogued_task(settings), **settings}
    robot = make_robot(settings)
    task = make_task(settings, robot)
    options = DesignOptions(
        solver=make_solver(settings),
        refine=bool(settings.get("refine", DesignOptions().refine)),
        differences=str(settings.get("differences", DesignOptions().differences)),
        approach=str(settings.get("approach", DesignOptions().approach)),
    )
    own = any(name in settings for name in ("start", "seed", "sigma"))
    starts = int(str(settings.get("starts", 1 if own else COUNT)))
    if starts < 1:
        raise InputError(f"{shown(starts)} starts are too few; give at least 1")
    at_most(starts, STARTS, "starts")
    start = _start(WalkProblem(robot, task), settings, disturb=starts == 1)
    return Request(robot, task, options, start, starts, _noise(settings), settings)


def make_task(settings: Settings, robot: Robot) -> Task:
    """Return the task.

    Raises:
        InputError: a value is out of range, or a geometric quantity unknown.
    """
    preset, path = str(settings["preset"]), settings.get("plugin")
    plugin = None if path is None else load_plugin(Path(str(path)))
    schema = SCHEMA if plugin is None else with_plugin(plugin)
    names = [*schema["task"], *schema["margins"]]
    changes = {n: settings[n] for n in names if n in settings and n != "preset"}
    geometry: Any = settings.get("geometry", {})
    changes["geometry"] = set_quantities(preset_task(preset, robot).geometry, geometry)
    if plugin is not None:
        changes["constraints"] = plugin.constraints
    own = () if plugin is None or plugin.cost is None else (plugin.cost,)
    name = str(settings.get("cost", own[0].name if own else COSTS[0].name))
    fields = {n: settings[n] for n in schema["cost"] if n in settings and n != "cost"}
    changes["cost"] = cost_by_name(name, own, **fields)
    return preset_task(preset, robot, **changes)


def usual_preset(settings: Settings) -> str:
    """Return the preset for a robot: that of humanoids, unless it is a thirteen-link biped."""
    return HUMANOID if biped_spec(settings) is None else PRESETS[0]


def make_solver(settings: Settings) -> Solver:
    """Return the solver with its options.

    Raises:
        InputError: there is no such solver, or it does not take an option given.
    """
    name = str(settings.get("solver", "default"))
    keys = ("tolerance", "max_iterations", "qp_solver")
    options = {key: settings[key] for key in keys if key in settings}
    if name not in ("default", CertifiedSQP.name):
        return solver_by_name(name, **options)
    # both stages aim at the same tolerance; the other options are those of the first
    both = {key: value for key, value in options.items() if key == "tolerance"}
    travel: Any = solver_by_name(SQP.name, **options)
    certify: Any = replace(CERTIFIER, **both)  # type: ignore[arg-type]
    return solver_by_name(name, travel=travel, certify=certify)


def _merged(config: Settings, given: Settings) -> Settings:
    """The settings of both; a robot given on the command line replaces one of the file."""
    if any(name in given for name in ROBOTS):
        config = {k: v for k, v in config.items() if k not in SCHEMA["robot"]}
    fixed = config.get("fix", {})
    geometry: Geometry = {**_free(config), **_fixed(fixed if isinstance(fixed, Mapping) else {})}
    held = SCHEMA["geometry"]["fix"].read_pairs(given.get("fix"))
    geometry |= _free(given) | _fixed(held)
    rest = {k: v for k, v in {**config, **given}.items() if k not in ("free", "fix")}
    return {**rest, "geometry": geometry}


def _free(settings: Settings) -> Geometry:
    names: Any = settings.get("free", [])
    return {name: {"free": True} for name in names}


def _fixed(values: Mapping[str, float]) -> Geometry:
    for name, value in values.items():
        if not math.isfinite(value):
            raise InputError(f"{name} cannot be fixed at {value}; give a finite number")
        if name == "duration":
            raise InputError("the duration is fixed by --duration, not by --fix")
    return {name: {"free": False, "value": float(value)} for name, value in values.items()}


def _start(problem: WalkProblem, settings: Settings, disturb: bool) -> Array | None:
    """Return the first guess: of a gait, disturbed, or None for the usual one."""
    disturb = disturb and ("seed" in settings or "sigma" in settings)
    if "start" not in settings and not disturb:
        return None
    if "start" in settings:
        x = parameters_of(load_gait(Path(str(settings["start"]))), problem)
    else:
        x = first_guess(problem)
    return perturbed(problem, x, *_noise(settings)) if disturb else x


def _noise(settings: Settings) -> tuple[float, int]:
    """Return standard deviation and seed of the noise on a first guess."""
    sigma, seed = (
        float(str(settings.get("sigma", SIGMA))),
        int(str(settings.get("seed", 0))),
    )
    if not (math.isfinite(sigma) and sigma >= 0.0 and seed >= 0):
        raise InputError(f"sigma {sigma} rad or seed {seed} is wrong; neither may be negative")
    return sigma, seed


def parameters_of(gait: Gait, problem: WalkProblem) -> Array:
    """Return the parameters of a gait for a walk; those it does not know are first guesses.

    Raises:
        InputError: the gait moves other joints or has another number of postures.
        UnreachableError: there is no first guess for what the gait does not know.
    """
    at_start = {f"{j}_at_start": q for j, q in zip(gait.joint_names, gait.q[0], strict=True)}
    known = at_start | dict(zip(gait.parameter_names, gait.parameters, strict=True))
    names = problem.layout.names
    joints = names[: problem.layout.rates.stop]
    if set(joints) != {n for n in known if "_at_knot_" in n or n.endswith("_rate_before_impact")}:
        raise InputError(
            "the gait given as start moves other joints or has another number of intermediate "
            "postures; take one of the same robot and --postures"
        )
    if all(name in known for name in names):
        return np.array([known[name] for name in names])
    guessed = zip(names, first_guess(problem), strict=True)
    return np.array([known.get(name, value) for name, value in guessed])
