"""Robots known by name: bipeds made here, humanoids of packages, and those of MuJoCo Menagerie.

Each of the catalogue is a TOML file in `gaitopt/catalogue/`: where its description is, what must
not be guessed about it, and a walk to begin with. Robots of the package `mujoco-menagerie`, which
fetches them, are `menagerie:NAME`, or `menagerie:NAME/ENTRY` for another of the files of a robot.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field, replace
from importlib import resources
from os.path import isdir, isfile
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, cast

from gaitopt.catalogue.biped_spec import BipedSpec, biped13
from gaitopt.catalogue.parameters import merged
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, MissingExtraError, did_you_mean, there_are
from gaitopt.importers.text_files import parse_toml
from gaitopt.model.import_options import ImportOptions, LimitOverride, choices_from_record

if TYPE_CHECKING:
    from gaitopt.model.robot import Robot


EXTRA, MENAGERIE_EXTRA = "robots", "menagerie"
"""Names of the extras that install robots."""
PACKAGE, PREFIX = "mujoco-menagerie", "menagerie:"
_TEXTS, _TABLES = ("file", "remark", "rotors_from"), ("choices", "task", "spec")
_PACKAGE = "example-robot-data"
_DESCRIPTIONS = "cmeel.prefix/share/example-robot-data/robots"  # inside site-packages


def menagerie_robot(name: str) -> tuple[str, str]:
    """Return the title of a robot, and its file from the root of the collection. Fetches nothing.

    Raises:
        MissingExtraError: the package is not installed.
        InputError: it knows no such robot, or no such file of it.
    """
    package = _package(name)
    wanted, _, entry = name.removeprefix(PREFIX).partition("/")
    known = humanoids()
    if wanted not in package.names():
        hint = did_you_mean(wanted, package.names()).replace("'", f"'{PREFIX}", 1)
        raise InputError(
            f"{PACKAGE} has no robot '{wanted}'; {hint}its humanoids are {', '.join(known)}"
        )
    robot = package.get(wanted)
    files = {point.name: point.file for point in robot.entry_points}
    if entry and entry not in files:
        raise InputError(
            f"'{wanted}' of {PACKAGE} has no file '{entry}'; {did_you_mean(entry, files)}it has "
            f"{', '.join(files)}"
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
    return tuple(str(robot.name) for robot in cast(Any, package).robots("humanoid"))


def _package(name: str) -> ModuleType:
    try:
        import mujoco_menagerie
    except ImportError:
        raise MissingExtraError(f"the robot '{name}'", MENAGERIE_EXTRA) from None
    return cast(ModuleType, mujoco_menagerie)


@dataclass(frozen=True)
class CatalogueEntry:
    """A robot of the catalogue.

    Attributes:
        name: that it is asked for by.
        title: one line for people.
        mass: [kg].
        file: of its description in the example-robot-data package; empty for the bipeds that
            gaitopt makes itself.
        choices: what must not be guessed, as `choices_from_record` takes it.
        task: fields of a `Task` to begin with: speed [m/s], duration [s], ..., and its preset
            where that is not the usual one.
        remark: what to know before using it, or empty.
        rotors: rotor inertias times gear ratios squared by pattern of joint names [kg·m²], which
            the description leaves out and others have published.
        rotors_from: where those are from.
        source: package that has the description, where that is not example-robot-data.
        spec: of a biped that gaitopt makes itself: where it differs from `biped13`, as
            `parameters.merged` takes it.
    """

    name: str
    title: str
    mass: float
    file: str
    choices: Mapping[str, Any]
    task: Mapping[str, Any]
    remark: str = ""
    rotors: Mapping[str, float] = field(default_factory=dict)
    rotors_from: str = ""
    source: str = ""
    spec: Mapping[str, Any] = field(default_factory=dict)

    @property
    def package(self) -> str:
        """Name of the Python package that has its description; empty for gaitopt itself."""
        return self.source or (_PACKAGE if self.file else "")

    @property
    def installed(self) -> bool:
        """Whether its description is on this machine."""
        return not self.file or bool(self.source) or _descriptions() is not None


def catalogue() -> tuple[CatalogueEntry, ...]:
    """Return the robots that can be asked for by name, the generated one first."""
    folder = resources.files("gaitopt.catalogue")
    names = sorted(p.name for p in folder.iterdir() if p.name.endswith(".toml"))
    files = ((n.removesuffix(".toml"), (folder / n).read_text("utf-8")) for n in names)
    entries = [read_entry(name, text) for name, text in files]
    return tuple(sorted(entries, key=lambda entry: bool(entry.file)))


def entry_by_name(name: str) -> CatalogueEntry:
    """Return the robot of a name.

    Raises:
        InputError: there is none.
        MissingExtraError: it is one of MuJoCo Menagerie, whose package is not installed.
    """
    if name.startswith(PREFIX):
        title, file = menagerie_robot(name)
        return CatalogueEntry(name, title, math.nan, file, {}, {}, source=PACKAGE)
    entries = {entry.name: entry for entry in catalogue()}
    if name not in entries:
        raise InputError(
            f"the catalogue has no robot '{name}'; {there_are(entries, name)}. "
            "Any other robot: give its file, --urdf FILE (in Python Robot.from_urdf)"
        )
    return entries[name]


def description(entry: CatalogueEntry) -> tuple[str | Path, ImportOptions]:
    """Return the URDF of a robot of the catalogue, as text or path, and its choices.

    Published rotor inertias are among its limits; `without=("armature",)` leaves them out.

    Raises:
        MissingExtraError: the package that has it is not installed.
        InputError: the package that is installed does not have its file.
    """
    choices = choices_from_record(entry.choices)
    published = (
        LimitOverride(joints, armature=value, source=entry.rotors_from)
        for joints, value in entry.rotors.items()
    )
    choices = replace(choices, limits=(*published, *choices.limits))
    if not entry.file:
        return urdf_text(biped_of(entry)), choices
    if entry.source == PACKAGE:
        return menagerie_file(entry.name), choices
    folder = _descriptions()
    if folder is None:
        raise MissingExtraError(f"the robot '{entry.name}'", EXTRA)
    path = folder / entry.file
    if not isfile(path):
        raise InputError(
            f"the installed {_PACKAGE} has no file '{entry.file}'; "
            f"run: pip install --upgrade 'gaitopt[{EXTRA}]'"
        )
    return path, choices


def biped_of(entry: CatalogueEntry) -> BipedSpec:
    """Return the specification of a biped that gaitopt makes itself."""
    return merged(biped13(), {"name": entry.name, **entry.spec})


def robot_by_name(name: str) -> Robot:
    """Return a robot of the catalogue.

    Raises:
        InputError: there is none of that name, or the package that has it is not installed.
    """
    from gaitopt.model.robot import Robot  # the list of robots needs none of what this imports

    urdf, choices = description(entry_by_name(name))
    return Robot.from_urdf(urdf, choices=choices)


def _descriptions() -> Path | None:
    """Directory of the installed descriptions, None where there are none."""
    from importlib.metadata import PackageNotFoundError, distribution

    try:
        folder = Path(str(distribution(_PACKAGE).locate_file(_DESCRIPTIONS)))
    except PackageNotFoundError:
        return None
    return folder if isdir(folder) else None


def read_entry(name: str, text: str | bytes) -> CatalogueEntry:
    """Return the robot that a TOML text of the catalogue describes.

    Raises:
        InputError: it is not TOML, or an entry is missing or of another kind; what the choices and
            the specification hold is checked when they are used.
    """
    where = f"{name}.toml of the catalogue"
    table = parse_toml(text, where)

    def number(part: Mapping[str, Any], key: str) -> float:
        value = _needed(part, key, (int, float), where)
        try:
            return float(value)
        except OverflowError:  # whole numbers have no largest one
            raise InputError(f"{where}: {key} is too large: {len(str(value))} digits") from None

    given: dict[str, Any] = {
        **{key: _of_kind(table, key, str, where) or "" for key in _TEXTS},
        **{key: _of_kind(table, key, Mapping, where) or {} for key in _TABLES},
    }
    rotors = _of_kind(table, "rotors", list, where) or []
    if not all(isinstance(rotor, Mapping) for rotor in rotors):
        raise InputError(f"{where}: rotors must be a list of tables ([[rotors]])")
    return CatalogueEntry(
        name=name,
        title=_needed(table, "title", str, where),
        mass=number(table, "mass"),
        rotors={_needed(r, "joints", str, where): number(r, "armature") for r in rotors},
        **given,
    )


def _of_kind(table: Mapping[str, Any], key: str, kind: Any, where: str) -> Any:
    """Return an entry of a table, None if it is absent."""
    value = table.get(key)
    if value is not None and (isinstance(value, bool) or not isinstance(value, kind)):
        words = {str: "a text", list: "a list", Mapping: "a table"}.get(kind, "a number")
        raise InputError(f"{where}: {key} is {str(value)[:60]!r}; it must be {words}")
    return value


def _needed(table: Mapping[str, Any], key: str, kind: Any, where: str) -> Any:
    value = _of_kind(table, key, kind, where)
    if value is None:
        raise InputError(f"{where}: {key} is missing; add it")
    return value
