"""From settings to what `design` takes: robot, task, method, first guess."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from gaitopt.bounds import STARTS, at_most, shown
from gaitopt.cli.config import SCHEMA, Settings, read_config
from gaitopt.cli.robot_request import ROBOTS, biped_spec, catalogued_task, make_robot
from gaitopt.design.options import COUNT, SIGMA, DesignOptions
from gaitopt.errors import InputError
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.parameters import set_quantities
from gaitopt.gait.presets import HUMANOID, PRESETS, preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.gait.result_file import load_gait
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array
from gaitopt.solvers import Solver, solver_by_name
from gaitopt.solvers.certified import CERTIFIER, CertifiedSQP
from gaitopt.solvers.sqp import SQP

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
    settings = _merged({} if config is None else read_config(config), given)
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
    preset = str(settings["preset"])
    names = [*SCHEMA["task"], *SCHEMA["margins"]]
    changes = {n: settings[n] for n in names if n in settings and n != "preset"}
    geometry: Any = settings.get("geometry", {})
    changes["geometry"] = set_quantities(preset_task(preset, robot).geometry, geometry)
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
