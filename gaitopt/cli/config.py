"""What can be configured, by section, and the TOML files that do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

from gaitopt.bounds import TABLE
from gaitopt.catalogue.parameters import PARAMETERS, parameter_unit
from gaitopt.cli import command_options
from gaitopt.dataclass import dataclass
from gaitopt.design.options import COUNT, SIGMA, DesignOptions
from gaitopt.errors import InputError, there_are
from gaitopt.gait.constraints import Margins
from gaitopt.gait.costs import COSTS
from gaitopt.gait.parameters import GEOMETRY_NAMES, geometric_unit
from gaitopt.gait.plugin import Plugin, costs_of, load_plugin
from gaitopt.gait.task import Task
from gaitopt.importers.physics import PARTS
from gaitopt.importers.text_files import parse_toml, read_text
from gaitopt.settings import FILE, FILES, Setting, declared, entry
from gaitopt.solvers import SOLVERS
from gaitopt.solvers.sqp import SQP
from gaitopt.units import digits

Settings = dict[str, Any]
"""Values that were given, by name, each read by its `Setting`; what is not there takes its
default."""

Kind = TypeVar("Kind")


@dataclass(frozen=True)
class GeometrySettings:
    """Which geometric quantities of the double support are free, and which are held."""

    free: tuple[str, ...] = entry(
        (), "Let the optimiser choose a geometric quantity of the double support.", metavar="NAME",
        choices=GEOMETRY_NAMES, common=True,
    )  # fmt: skip
    fix: Mapping[str, float] = entry(
        {}, "Hold a geometric quantity of the double support at a value: pelvis_roll=0.05.",
        entry_unit=geometric_unit,
        example="pelvis_roll=0.05",
    )  # fmt: skip


def _robot_names() -> list[str]:
    from gaitopt.catalogue.entries import PREFIX, catalogue

    return [*(one.name for one in catalogue()), f"{PREFIX}NAME"]


@dataclass(frozen=True)
class RobotSettings:
    """Which robot, and what not to guess about it."""

    robot: str | None = entry(
        None,
        "Robot of the catalogue, by its name; gaitopt robots tells more.",
        metavar="NAME",
        choices=_robot_names,
        common=True,
    )
    urdf: Path | None = entry(None, "File of any humanoid, URDF or MJCF.", common=True)
    spec: Path | None = entry(None, "Parameter table of a biped, TOML.", common=True)
    choices: Path | None = entry(
        None, "What not to guess about it, TOML: inspect --write-choices.", common=True
    )
    set: Mapping[str, float] = entry(
        {}, f"Change a parameter of the biped, {', '.join(PARAMETERS)}, or an entry of its table, "
        "links.shin.mass; lengths take boxes and centres of mass along.", common=True,
        entry_unit=parameter_unit, example="shin=42cm",
    )  # fmt: skip
    limit: tuple[str, ...] = entry(
        (), "Torque, speed, range or armature of the joints whose names match: knee.speed=8rpm, "
        "'*hip*.torque=80', knee.range=0deg:120deg; none for no limit.",
        metavar="JOINTS.WHAT=VALUE", common=True,
    )  # fmt: skip
    payload: tuple[str, ...] = entry(
        (), "Load on a link, or on its torso or pelvis: 10kg@torso, or with the place of its "
        "centre and its box in the link's axes, 10kg@torso:0.1,0,0.2:0.3x0.2x0.2.",
        metavar="MASS@LINK", common=True,
    )  # fmt: skip
    gravity: float | None = entry(
        None, "Acceleration of free fall, in place of that of the robot's file.", "m/s²"
    )
    package_dir: tuple[Path, ...] = entry(
        (), "Directory with the packages that the paths of its meshes name."
    )
    forward: str | None = entry(
        None, "Axis of its root link along which the robot looks: x, -x, y, ...", metavar="AXIS"
    )
    posture: str | None = entry(
        None, "Name of the pose of the SRDF in which the robot stands.", metavar="NAME"
    )
    srdf: Path | None = entry(None, "SRDF file that holds the pose of --posture.")
    sole: str | None = entry(
        None, "Rectangle of both soles in their frames: toe,heel,left,right.", metavar="M,M,M,M"
    )
    stance_sole: str | None = entry(
        None, "Frame of the sole that stands, in the robot's file.", metavar="FRAME"
    )
    swing_sole: str | None = entry(
        None, "Frame of the sole that swings, in the robot's file.", metavar="FRAME"
    )
    without: tuple[str, ...] = entry(
        (), f"Physics of its file to leave out: {', '.join(PARTS)}; a list with commas.",
        metavar="PARTS",
    )  # fmt: skip
    move: tuple[str, ...] = entry(
        (), "Joints beside the legs' to move: arms, waist, patterns of names; a list with commas.",
        metavar="JOINTS",
    )  # fmt: skip
    motors: Path | None = entry(
        None,
        "Motors and gears of the joints, TOML: envelope, rotor inertia (docs/motors.md).",
    )
    linkages: Path | None = entry(
        None, "Motors that turn joints in common, as of parallel ankles, TOML: their limits "
        "(docs/linkages.md).",
    )  # fmt: skip
    armature: Mapping[str, float | str] = entry(
        {}, "Rotor inertia times gear ratio squared of the joints of that name, kg·m²: "
        "'*knee*=0.02'; in kg of those that slide.", metavar="PATTERN=VALUE",
        entry_unit=lambda _: "kg·m²", as_given=True, example="'*=0.01'",
    )  # fmt: skip


@dataclass(frozen=True)
class SearchSettings:
    """With which solver, and from where."""

    solver: str = entry(
        "default",
        "Solver of the nonlinear program.",
        metavar="NAME",
        choices=tuple(SOLVERS),
        common=True,
    )
    start: Path | None = entry(
        None, "Gait file whose parameters are the first guess.", metavar="GAIT"
    )
    starts: int = entry(
        COUNT, "How many first guesses to try; 1 with --start or --seed.", common=True
    )
    seed: int | None = entry(None, "Number of the random noise that disturbs the first guess.")
    sigma: float = entry(SIGMA, "Standard deviation of the noise of --seed.", "rad")


@dataclass(frozen=True)
class SweepSettings:
    """What is swept over, and who does the work."""

    speeds: str | None = entry(
        None, "Walking speeds, FIRST:LAST:STEP or a list A,B,C.", metavar="M/S", common=True
    )
    grid: tuple[str, ...] = entry(
        (), "Another quantity of task, limits, double support or specification, as "
        "duration=0.3:0.6:0.05 or geometry.d3=0.28,0.3,0.32. trunk_pitch is the limit of the "
        "lean, hold.trunk_pitch the lean at double support.", metavar="NAME=RANGE", common=True,
    )  # fmt: skip
    begin: tuple[str, ...] = entry(
        (),
        "Value at which the sweep begins, of other quantities in the middle; by default both ends "
        "of the longest range.",
        metavar="NAME=VALUE",
    )
    workers: int | None = entry(None, "How many processes on this machine work.", common=True)
    scheduler: str | None = entry(
        None, "Address of a Dask scheduler whose workers work instead.", metavar="ADDRESS"
    )


SWEEP = tuple(declared(SweepSettings))
SWEEP_SECTION = "sweep"
"""Of a configuration file; a search for one gait passes over it."""
NOT_OURS = ("starts", "start", "seed", "sigma", "toe_begin", "phase_times")
"""Settings of a search for one gait only."""


@dataclass(frozen=True)
class OwnSettings:
    """What is minimised, and what is not gaitopt's own."""

    cost: str | None = entry(
        COSTS[0].name,
        "What is minimised; a sum is 'torque + 0.5 energy'.",
        metavar="NAME",
        choices=[one.name for one in COSTS],
    )
    plugin: Path | None = entry(
        None, "Python file with constraints, a cost or a terrain of your own; it is run."
    )


@dataclass(frozen=True)
class ComparisonSettings:
    """Which solvers are compared."""

    solvers: str | None = entry(
        None, "Solvers to compare, with commas; by default sqp, slsqp and, if it is there, ipopt.",
        metavar="NAMES", choices=tuple(SOLVERS), common=True,
    )  # fmt: skip


COMPARISON = tuple(declared(ComparisonSettings))

_PRESET = Setting(
    "preset", "text", "A task for the biped, its paper's constraints only, or sized by any robot.",
    default="standard", metavar="NAME", choices=("standard", "paper", "humanoid", "robust"),
    common=True,
)  # fmt: skip


def _by_name(*settings: Setting) -> dict[str, Setting]:
    return {one.name: one for one in settings}


_OF_COSTS = [one for cost in COSTS if is_dataclass(cost) for one in declared(type(cost))]
SCHEMA: dict[str, dict[str, Setting]] = {
    "task": _by_name(_PRESET, *declared(Task)),
    "margins": _by_name(*declared(Margins)),
    "cost": _by_name(*declared(OwnSettings, "cost"), *_OF_COSTS),
    "plugin": _by_name(*declared(OwnSettings, "plugin")),
    "geometry": _by_name(*declared(GeometrySettings)),
    "robot": _by_name(*declared(RobotSettings)),
    "solver": _by_name(
        *declared(SearchSettings, "solver"),
        *declared(SQP),
        *declared(DesignOptions),
        *declared(SearchSettings, "start", "starts", "seed", "sigma"),
    ),
}
"""Every setting that a command line or a configuration file may hold, by section."""

LIMITS = "limits"
"""Section of a file that says what the option --limit does."""


def settings_of(kind: type[Kind], settings: Settings) -> Kind:
    """Return one of the dataclasses of settings with the values that were given."""
    return kind(**{one.name: settings[one.name] for one in fields(kind) if one.name in settings})  # type: ignore[arg-type]


def sections(words: Sequence[str] = ()) -> dict[str, dict[str, Setting]]:
    """Return every setting by section, those of the plugin that a command line names too.

    Args:
        words: of the command line; a plugin may also be named by its configuration file.

    Raises:
        InputError: the plugin cannot be imported, or takes a name that is gaitopt's own.
    """
    given, config = _words_after("--plugin", words), next(_words_after("--config", words), None)
    plugin = None if (word := next(given, None)) is None else Path(word)
    if next(given, None) is not None:
        raise InputError(
            "--plugin is given twice, and one file is taken; put all constraints and the cost into "
            "one"
        )
    if plugin is None and config is not None:
        with suppress(InputError):  # the command will say what is wrong with it
            plugin = _named_plugin(_table(Path(config)), Path(config))
    return SCHEMA if plugin is None else with_plugin(load_plugin(plugin))


def _named_plugin(table: Mapping[str, object], path: Path) -> Path | None:
    """Return the plugin that a configuration names, None if it names none."""
    section = table.get("plugin")
    name = section.get("plugin") if isinstance(section, Mapping) else None
    return path.parent / name if isinstance(name, str) else None


def _words_after(option: str, words: Sequence[str]) -> Iterator[str]:
    """Yield what is given to an option, each time that it is given."""
    for k, word in enumerate(words):
        if word == option and k + 1 < len(words):
            yield words[k + 1]
        if word.startswith(f"{option}="):
            yield word.partition("=")[2]


def with_plugin(plugin: Plugin) -> dict[str, dict[str, Setting]]:
    """Return every setting by section with those of a plugin.

    Raises:
        InputError: one of its names is taken, or a field is of a kind that people cannot write.
    """
    costs = [] if plugin.cost is None else [plugin.cost]
    terms = [one for cost in costs for one in costs_of(cost) if type(one) not in map(type, COSTS)]
    terrains = [] if plugin.terrain is None else [plugin.terrain]
    owners = [*plugin.constraints, *terms, *terrains]
    try:
        own = {type(one): list(declared(type(one))) for one in owners if is_dataclass(one)}
    except TypeError as error:
        raise InputError(
            f"the plugin '{plugin.path}' has a field nobody can set: {error}"
        ) from None
    commands = [kind for kind in vars(command_options).values() if isinstance(kind, type)]
    ours = filter(is_dataclass, [SweepSettings, ComparisonSettings, *commands])
    taken = {name for section in SCHEMA.values() for name in section} | {"help", "help_all"}
    taken |= {one.name for kind in ours for one in declared(kind)}
    for one in (one for settings in own.values() for one in settings):
        if one.name in taken:
            raise InputError(
                f"the plugin '{plugin.path}' has a field '{one.name}', which is the name of an "
                "option of gaitopt; rename it"
            )
    margins = [one for owner in plugin.constraints for one in own.get(type(owner), [])]
    of_cost = [one for owner in terms for one in own.get(type(owner), [])]
    of_terrain = [one for owner in terrains for one in own.get(type(owner), [])]
    named = SCHEMA["cost"]["cost"]
    choices = (*named.names, *(one.name for one in costs))
    return SCHEMA | {
        "task": SCHEMA["task"] | _by_name(*of_terrain),
        "margins": SCHEMA["margins"] | _by_name(*margins),
        "cost": SCHEMA["cost"] | _by_name(replace(named, choices=choices), *of_cost),
    }


def read_config(path: Path, plugin: Path | None = None) -> Settings:
    """Read the settings of a TOML file; file names in it are relative to its directory.

    Args:
        plugin: whose constraints, cost and terrain it may set, unless it names one itself.

    Raises:
        InputError: the file cannot be read, is not TOML, has an unknown section or name, or a
            value of the wrong kind.
    """
    settings: Settings = {}
    table = _table(path)
    plugin = plugin or _named_plugin(table, path)
    schema = SCHEMA if plugin is None else with_plugin(load_plugin(plugin))
    schema = {**schema, SWEEP_SECTION: _by_name(*SWEEP), LIMITS: {}}
    for section, entries in table.items():
        if section not in schema:
            raise InputError(f"{path}: unknown section '{section}'; {there_are(schema, section)}")
        if not isinstance(entries, Mapping):
            other = "; [[limits]] belong into the file for --choices" if section == LIMITS else ""
            raise InputError(
                f"{path}: '{section}' must be a section, [{section}], not a value{other}"
            )
        if section == LIMITS:
            settings["limit"] = list(_limit_texts(entries))
            continue
        known = schema[section]
        for name, value in entries.items():
            if name not in known:
                raise InputError(
                    f"{path}: unknown entry in [{section}] '{name}'; {there_are(known, name)}"
                )
            typed = _as_typed(name, value) if section == SWEEP_SECTION else value
            settings[name] = _value(path, f"{section}.{name}", typed, known[name])
    return settings


def _as_typed(name: str, value: object) -> object:
    """Return an entry of the section as it would be typed: tables by name, lists with commas."""
    if name == "speeds":
        return _values(value)
    if name in ("grid", "begin") and isinstance(value, Mapping):
        return [f"{key}={_values(one)}" for key, one in value.items()]
    return value


def _values(value: object) -> object:
    if isinstance(value, list) and value and all(isinstance(one, int | float) for one in value):
        return ",".join(map(str, value))
    return str(value) if isinstance(value, int | float) and not isinstance(value, bool) else value


def _limit_texts(entries: Mapping[str, object]) -> Iterator[str]:
    """Yield the entries of [limits] as the option --limit takes them."""
    for name, value in entries.items():
        if isinstance(value, Mapping):
            yield from _limit_texts({f"{name}.{key}": one for key, one in value.items()})
        else:
            ends = value if isinstance(value, list) else [value]
            yield f"{name}={':'.join(map(str, ends))}"


def _table(path: Path) -> dict[str, object]:
    text = read_text(path, "configuration", "give the path of a TOML file", InputError, TABLE)
    return parse_toml(text, f"the configuration '{path}'")


def _value(path: Path, name: str, value: object, wanted: Setting) -> object:
    """Return a value of the kind its name asks for, files as paths."""
    try:
        read = wanted.read_entry(value)
    except ValueError as error:
        raise InputError(f"{path}: {name} = {str(value)[:60]!r} is wrong; {error}") from error
    if wanted.kind == FILE:
        return path.parent / read
    return [path.parent / one for one in read] if wanted.kind == FILES else read


def option_words(name: str, value: object) -> list[str]:
    """Return a setting as the words of a command line; none where the value is None."""
    flag = name.replace("_", "-")
    if value is None:
        return []
    if isinstance(value, bool):
        return [f"--{flag}" if value else f"--no-{flag}"]
    if isinstance(value, Mapping):
        value = [f"{key}={_shown(one)}" for key, one in value.items()]
    if isinstance(value, list | tuple):
        return [word for one in value for word in option_words(name, one)]
    return [f"--{flag}", _shown(value)]


def _shown(value: object) -> str:
    return digits(value) if isinstance(value, float) else str(value)
