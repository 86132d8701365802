"""From settings to what `design_gait` takes: robot, task, method, first guess."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import replace
from os.path import isdir
from pathlib import Path
from typing import Any, cast

import tomli_w

from gaitopt.actuators.linkages import read_linkages
from gaitopt.actuators.motors import joint_motors, read_motors
from gaitopt.bounds import STARTS, at_most, shown
from gaitopt.catalogue.biped_spec import BipedSpec, biped13
from gaitopt.catalogue.entries import biped_of, catalogue, description, entry_by_name
from gaitopt.catalogue.parameters import changed, read_spec
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.cli.config import (
    SCHEMA,
    GeometrySettings,
    RobotSettings,
    SearchSettings,
    Settings,
    read_config,
    settings_of,
    with_plugin,
)
from gaitopt.cli.idle import refuse_idle, refuse_overruled
from gaitopt.dataclass import dataclass
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import parameters_of
from gaitopt.errors import InputError
from gaitopt.gait.constraints import MotorEnvelope
from gaitopt.gait.costs import COSTS, ElectricalEnergy, cost_of_text
from gaitopt.gait.gait_file import load_gait
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.motor_space import MotorSpace, driven_joints
from gaitopt.gait.parameters import set_geometry
from gaitopt.gait.plugin import load_plugin
from gaitopt.gait.presets import HUMANOID, PRESETS, preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task
from gaitopt.model.import_options import (
    LIMIT_UNITS,
    ImportOptions,
    LimitOverride,
    Payload,
    choices_from_record,
    choices_from_toml,
    choices_record,
    read_limit,
)
from gaitopt.model.robot import Robot
from gaitopt.model.sole import Sole
from gaitopt.nlp import Array
from gaitopt.settings import NO_LIMIT
from gaitopt.solvers import Solver, solver_by_name
from gaitopt.solvers.sqp import SQP
from gaitopt.solvers.two_stage import CONFIRMING_SOLVER, ConfirmedSQP, TwoStageSQP
from gaitopt.units import read_quantity

ROBOTS = ("robot", "spec", "urdf")
"""Settings that name a robot; they exclude each other."""

_CHOICES_HEADER = """\
# How gaitopt reads this robot; edit what it guessed wrongly, then: --choices FILE. SI units.
# An entry that is left out is found again from the robot's file; `gaitopt inspect` tells how.
"""

_EDGES = ("toe", "heel", "left", "right")
_NUMBERS = re.compile(r"\[\n((?:\s+[-+.\w]+,\n)+)\s*\]")


def make_robot(settings: Settings) -> Robot:
    """Return the robot asked for, by default the thirteen-link biped.

    Raises:
        InputError: a file cannot be used, more than one robot is given, or it is not a biped.
    """
    source, choices = robot_source(settings)
    return Robot.from_urdf(source, choices=choices)


def robot_source(settings: Settings) -> tuple[str | Path, ImportOptions]:
    """Return the URDF asked for, as text or path, and what was chosen about the robot.

    What the catalogue says is replaced by the file of choices, and that by single options; of
    limits the later ones count.

    Raises:
        InputError: a file cannot be used, or more than one robot is given.
    """
    asked = settings_of(RobotSettings, settings)
    given = [name for name in ROBOTS if getattr(asked, name) is not None]
    if len(given) > 1:
        names = " and ".join(f"--{name}" for name in given)
        raise InputError(f"{names} exclude each other; give one of them")
    spec, choices = biped_spec(settings), ImportOptions()
    source: str | Path = "" if asked.urdf is None else asked.urdf
    if asked.robot is not None:
        source, choices = description(entry_by_name(asked.robot))
    if spec is not None:
        source = urdf_text(spec)
    if asked.choices is not None:
        more = choices_from_toml(asked.choices)
        before = (entry for entry in choices.limits if entry not in more.limits)
        own = choices_from_record({**choices_record(choices), **choices_record(more)})
        choices = replace(own, limits=(*before, *more.limits))
    choices = choices.over(**_single(asked))
    limits = (
        *choices.limits,
        *_rotors(asked, choices),
        *_armatures(asked, choices),
        *map(limit_of, asked.limit),
    )
    payloads = (*choices.payloads, *map(payload_of, asked.payload))
    return source, replace(choices, limits=limits, payloads=payloads)


def _single(asked: RobotSettings) -> dict[str, object]:
    """Return the choices given as options of their own; those that are not are None."""
    require_directories(asked.package_dir)
    parts, moving = (
        tuple(part.strip() for text in texts for part in text.split(","))
        for texts in (asked.without, asked.move)
    )
    return {
        "forward": asked.forward,
        "posture": asked.posture,
        "stance_sole": asked.stance_sole,
        "swing_sole": asked.swing_sole,
        "srdf": None if asked.srdf is None else str(asked.srdf.absolute()),
        "sole": None if asked.sole is None else sole_of(asked.sole),
        "package_dirs": tuple(str(d.absolute()) for d in asked.package_dir) or None,
        "gravity": asked.gravity,
        "without": parts or None,
        "moving": moving or None,
    }


def require_directories(directories: Iterable[Path]) -> None:
    """Check directories of meshes.

    Raises:
        InputError: one is not there.
    """
    for directory in directories:
        if not isdir(directory):
            raise InputError(
                f"--package-dir {directory}: there is no such directory; give the one that holds "
                "the packages which the mesh paths name"
            )


def _rotors(asked: RobotSettings, choices: ImportOptions) -> Iterator[LimitOverride]:
    """Yield the rotors of the motors, but for those that a file of choices has already."""
    known = [replace(one, source="") for one in choices.limits]
    for own in () if asked.motors is None else read_motors(asked.motors).rotors(str(asked.motors)):
        if replace(own, source="") not in known:
            yield own


def _armatures(asked: RobotSettings, choices: ImportOptions) -> Iterator[LimitOverride]:
    if asked.armature and "armature" in choices.without:
        raise InputError(
            "--without armature leaves out every rotor inertia, --armature gives some; leave out "
            "one of the two (--armature '*=0' before the others leaves out those of the file only)"
        )
    for joints, given in asked.armature.items():
        value, unit = read_limit("armature", str(given))
        yield LimitOverride(joints, armature=value, units=(unit,) if unit else ())


def limit_of(text: str) -> LimitOverride:
    """Read a limit of joints from "JOINTS.WHAT=VALUE"; a range is "LOWER:UPPER".

    Raises:
        InputError: it is none.
    """
    left, _, value = text.rpartition("=")
    joints, _, what = left.strip().rpartition(".")
    names, values = ("lower", "upper") if what == "range" else (what,), value.split(":")
    if not joints or not set(names) <= set(LIMIT_UNITS) or len(values) != len(names):
        raise InputError(
            f"--limit {text}: give JOINTS.WHAT=VALUE, where WHAT is range, with LOWER:UPPER, or "
            f"one of {', '.join(LIMIT_UNITS)}, as in --limit knee.speed=8 or --limit "
            "'*ankle*.range=-30deg:20deg'"
        )
    try:
        read = {n: read_limit(n, v.strip()) for n, v in zip(names, values, strict=True)}
    except ValueError as error:
        raise InputError(f"--limit {text}: {error}, or none") from error
    numbers: Any = {name: value for name, (value, _) in read.items()}
    return LimitOverride(joints, **numbers, units=tuple(u for _, u in read.values() if u))


def payload_of(text: str) -> Payload:
    """Read a load from "MASS@LINK", "MASS@LINK:X,Y,Z" or "MASS@LINK:X,Y,Z:AxBxC" [kg, m].

    Raises:
        InputError: it is none.
    """
    mass, _, rest = text.partition("@")
    link, *more = (part.strip() for part in rest.split(":"))
    try:
        if not link or len(more) > 2:
            raise ValueError("there is no link, or there is more than place and box")
        place = _lengths(more[0], ",") if more else None
        box = _lengths(more[1], "x") if len(more) > 1 else (0.0, 0.0, 0.0)
        return Payload(link, read_quantity(mass, "kg"), place, box)
    except ValueError as error:
        raise InputError(
            f"--payload {text}: {error}; give MASS@LINK, MASS@LINK:X,Y,Z or MASS@LINK:X,Y,Z:AxBxC, "
            "as in --payload 10kg@torso:0.1,0,0.2:0.3x0.2x0.2"
        ) from error


def _lengths(text: str, separator: str) -> tuple[float, float, float]:
    numbers = [read_quantity(word.strip(), "m") for word in text.split(separator)]
    if len(numbers) != 3:
        raise ValueError(f"'{text}' is not three lengths")
    return numbers[0], numbers[1], numbers[2]


def biped_spec(settings: Settings) -> BipedSpec | None:
    """Return the parameter table of a biped that gaitopt makes itself, None for another robot.

    Raises:
        InputError: the file cannot be used, there is no robot of that name, or --set is given for
            another robot.
    """
    asked = settings_of(RobotSettings, settings)
    entry = None if asked.robot is None else entry_by_name(asked.robot)
    if asked.urdf is not None or (entry is not None and entry.file):
        if asked.set:
            raise InputError(
                "--set changes a biped that gaitopt makes itself: the usual one, one of --spec, or "
                f"--robot {' or '.join(one.name for one in catalogue() if not one.file)}; of other "
                "robots, change the file, or masses and limits by --choices"
            )
        return None
    if entry is not None:
        return changed(biped_of(entry), asked.set)
    return changed(biped13() if asked.spec is None else read_spec(asked.spec), asked.set)


def robot_origin(settings: Settings) -> str:
    """Return where a robot of the catalogue is from; empty for others."""
    name = settings.get("robot")
    entry = None if name is None else entry_by_name(str(name))
    return f"{entry.file} of {entry.package}" if entry is not None and entry.file else ""


def choices_text(choices: ImportOptions) -> str:
    """Return choices as TOML, with a word on how to use them."""
    return f"{_CHOICES_HEADER}{_rows_on_lines(tomli_w.dumps(choices_record(choices)))}"


def _rows_on_lines(toml: str) -> str:
    """Return TOML whose innermost arrays stand on a line each, as people write them."""
    return _NUMBERS.sub(lambda found: f"[{' '.join(found[1].split()).rstrip(',')}]", toml)


def sole_of(text: str) -> Sole:
    """Read a sole rectangle from "toe,heel,left,right" [m].

    Raises:
        InputError: they are not four lengths, or the rectangle is empty.
    """
    try:
        numbers = [read_quantity(word, "m") for word in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != len(_EDGES):
        raise InputError(
            f"the sole '{text}' is not four numbers; give its edges in metres, "
            "toe,heel,left,right, as in --sole 0.12,-0.05,0.03,-0.03"
        )
    return Sole(**dict(zip(_EDGES, numbers, strict=True)))


@dataclass(frozen=True)
class Request:
    """What the user asked for.

    Attributes:
        robot, task, options: as `design` takes them.
        start: first guess of the parameters or a gait, None for the usual one.
        starts: how many guesses to try; with more than one, `noise` makes the others.
        noise: standard deviation [rad] and seed.
        settings: what was given, for the record.
    """

    robot: Robot
    task: Task
    options: DesignOptions
    start: Array | Gait | None
    starts: int
    noise: tuple[float, int]
    settings: Settings


def make_request(
    given: Settings,
    config: Path | None,
    varied: Collection[str] = (),
    on_robot: Callable[[Robot], None] | None = None,
) -> Request:
    """Return the request of a command line.

    Args:
        given: options of the command line, those not given left out.
        config: configuration file, if any; the command line wins.
        varied: settings that take other values too, as in a sweep.
        on_robot: called once the robot is read, which is not half of the work.

    Raises:
        InputError: an option, a file or a value cannot be used, or an option has no effect.
        UnreachableError: the step asked for is longer than the legs.
    """
    file = {} if config is None else read_config(config, given.get("plugin"))
    settings = _merged(file, given)
    own = {} if (name := settings.get("robot")) is None else entry_by_name(name).task
    usual = HUMANOID if biped_spec(settings) is None else PRESETS[0]
    settings = {"preset": usual, **own, **settings}  # the catalogue proposes a walk
    asked = settings_of(SearchSettings, settings)
    robot = make_robot(settings)
    if on_robot is not None:
        on_robot(robot)
    task = make_task(settings, robot)
    how = ("differences", "refine", "approach", "toe_begin", "phase_times")
    options = DesignOptions(make_solver(settings), **{n: settings[n] for n in how if n in settings})
    usually = {one.name: one.default for section in SCHEMA.values() for one in section.values()}
    unusual = {name: value for name, value in file.items() if value != usually.get(name)}
    refuse_idle({**unusual, **given}, task, robot, varied)
    for limits, known in ((file, file), (given, settings)):
        refuse_overruled(limits.get("limit", ()), known)
    one = any(name in settings for name in ("start", "seed", "sigma"))
    starts = 1 if one and "starts" not in settings else asked.starts
    if starts < 1:
        raise InputError(f"{shown(starts)} starts are too few; give at least 1")
    at_most(starts, STARTS, "starts")
    noise = (asked.sigma, 0 if asked.seed is None else asked.seed)
    if not 0.0 <= noise[0] <= math.pi:
        raise InputError(f"sigma is {noise[0]} rad; it must be from 0 to {math.pi:.4f} rad")
    if noise[1] < 0:
        raise InputError(f"seed is {shown(noise[1])}; it must not be negative")
    disturbed = starts == 1 and noise[0] > 0.0 and ("seed" in settings or "sigma" in settings)
    start = _start(WalkProblem(robot, task), asked.start, noise if disturbed else None)
    return Request(robot, task, options, start, starts, noise, settings)


def make_task(settings: Settings, robot: Robot) -> Task:
    """Return the task.

    Raises:
        InputError: a value is out of range, or a geometric quantity unknown.
    """
    preset, path = str(settings["preset"]), settings.get("plugin")
    plugin = None if path is None else load_plugin(path)
    schema = SCHEMA if plugin is None else with_plugin(plugin)
    names = [n for n in (*SCHEMA["task"], *schema["margins"]) if n in settings and n != "preset"]
    known = {**schema["task"], **schema["margins"]}
    changes: dict[str, Any] = {
        n: None if known[n].limit and settings[n] == NO_LIMIT else settings[n] for n in names
    }
    changes["constraints"] = () if plugin is None else plugin.constraints
    if plugin is not None and plugin.terrain is not None:
        names = [n for n in schema["task"] if n in settings and n not in SCHEMA["task"]]
        of_terrain, terrain = {n: settings[n] for n in names}, cast(Any, plugin.terrain)
        changes["terrain"] = replace(terrain, **of_terrain) if of_terrain else terrain
    motors_of_cost: dict[str, Any] = {}
    if (table := settings.get("motors")) is not None:
        motors = read_motors(table).at_joints
        joint_motors(motors, robot.joint_names, robot.mirror)
        changes["constraints"] = (*changes["constraints"], MotorEnvelope(motors=motors))
        if ElectricalEnergy.name in str(settings.get("cost", "")).split():
            motors_of_cost = {"motors": motors}
    if (table := settings.get("linkages")) is not None:
        linkages = read_linkages(table)
        driven_joints(robot, linkages)
        changes["constraints"] = (*changes["constraints"], MotorSpace(linkages=linkages))
    own = () if plugin is None or plugin.cost is None else (plugin.cost,)
    of_cost = {n: settings[n] for n in schema["cost"] if n in settings and n != "cost"}
    cost = cost_of_text(
        settings.get("cost", (*own, *COSTS)[0].name), own, **of_cost, **motors_of_cost
    )
    geometry = set_geometry(preset_task(preset, robot).geometry, _geometry(settings))
    return preset_task(preset, robot, geometry=geometry, cost=cost, **changes)


def _geometry(settings: Settings) -> dict[str, dict[str, float | bool]]:
    """Return the changes to the geometric quantities."""
    asked = settings_of(GeometrySettings, settings)
    if both := [name for name in asked.free if name in asked.fix]:
        raise InputError(
            f"--free {both[0]} and --fix {both[0]}={asked.fix[both[0]]:g} contradict each other; "
            "give one of the two"
        )
    for name, value in asked.fix.items():
        if not math.isfinite(value):
            raise InputError(f"{name} cannot be fixed at {value}; give a finite number")
        if name == "duration":
            raise InputError("the duration is fixed by --duration, not by --fix")
    changes: dict[str, dict[str, float | bool]] = {name: {"free": True} for name in asked.free}
    return changes | {name: {"free": False, "value": v} for name, v in asked.fix.items()}


SOLVER_OPTIONS = ("tolerance", "max_iterations", "qp_solver")


def make_solver(settings: Settings) -> Solver:
    """Return the solver with its options.

    Raises:
        InputError: there is no such solver, or it does not take an option given.
    """
    name = str(settings.get("solver", "default"))
    options = {key: settings[key] for key in SOLVER_OPTIONS if key in settings}
    if name not in ("default", ConfirmedSQP.name, TwoStageSQP.name):
        return solver_by_name(name, **options)
    # both stages aim at the same tolerance; the other options are those of the first
    both = {key: value for key, value in options.items() if key == "tolerance"}
    first: Any = solver_by_name(SQP.name, **options)
    second: Any = replace(CONFIRMING_SOLVER, **both)
    return solver_by_name(name, first=first, second=second)


def _merged(config: Settings, given: Settings) -> Settings:
    """Return the settings of both; those of the command line win, tables and limits add up."""
    # A robot given there replaces everything about the robot of the file, choices its limits, and a
    # quantity is free or fixed as the command line says.
    if any(name in given for name in ROBOTS):
        config = {k: v for k, v in config.items() if k not in SCHEMA["robot"]}
    if "choices" in given:
        config = {k: v for k, v in config.items() if k != "limit"}
    here, there = (settings_of(GeometrySettings, one) for one in (given, config))
    free = [name for name in there.free if name not in here.fix]
    fix = {name: value for name, value in there.fix.items() if name not in here.free}
    both = {**config, **given}
    for name in ("set", "armature"):
        if name in config and name in given:
            both[name] = {**config[name], **given[name]}
    if "limit" in config and "limit" in given:
        both["limit"] = [*config["limit"], *given["limit"]]
    return {**both, "free": [*free, *here.free], "fix": fix | dict(here.fix)}


def _start(
    problem: WalkProblem, file: Path | None, noise: tuple[float, int] | None
) -> Array | Gait | None:
    """Return the first guess: a gait, one disturbed, or None for the usual one."""
    gait = None if file is None else load_gait(file)
    if gait is None and noise is None:
        return None
    x = first_guess(problem) if gait is None else parameters_of(gait, problem)
    return gait if noise is None else perturbed(problem, x, *noise)
