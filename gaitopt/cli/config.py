"""Options from a TOML file: the names of the command line, in sections."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path

from gaitopt.bounds import TABLE, read_bounded
from gaitopt.errors import InputError
from gaitopt.robot.files.toml import parse_toml

Settings = dict[str, object]

SCHEMA: dict[str, dict[str, str]] = {
    "task": {
        "preset": "text",
        "speed": "number",
        "duration": "number",
        "postures": "whole number",
        "samples": "whole number",
        "quadrature": "text",
        "speed_as": "text",
        "penalty_weight": "number",
        "boundary": "text",
    },
    "margins": {
        "friction": "number",
        "minimum_load": "number",
        "cop_margin": "number",
        "clearance": "number",
        "lateral_gap": "number",
        "knee_flexion": "number",
        "leg_extension": "number",
        "liftoff_speed": "number",
        "joint_range": "true or false",
        "impulse_cop": "true or false",
        "torque_limit": "number",
        "speed_limit": "number",
        "trunk_roll": "number",
        "trunk_pitch": "number",
        "trunk_yaw": "number",
        "torsional_friction": "number",
        "step_width": "number",
        "leg_gap": "number",
        "swing_tilt": "number",
    },
    "geometry": {"free": "list of names", "fix": "table of numbers"},
    "robot": {
        "robot": "text",
        "urdf": "file name",
        "spec": "file name",
        "choices": "file name",
        "package_dir": "list of file names",
        "forward": "text",
        "posture": "text",
        "srdf": "file name",
        "sole": "text",
        "stance_sole": "text",
        "swing_sole": "text",
        "without": "list of names",
        "armature": "table of numbers",
    },
    "solver": {
        "solver": "text",
        "qp_solver": "text",
        "tolerance": "number",
        "max_iterations": "whole number",
        "differences": "text",
        "approach": "text",
        "refine": "true or false",
        "start": "file name",
        "starts": "whole number",
        "seed": "whole number",
        "sigma": "number",
    },
}
"""Every option that a configuration file may hold, by section, and what its value is."""


def read_config(path: Path) -> Settings:
    """Read the settings of a TOML file; file names in it are relative to its directory.

    Raises:
        InputError: the file cannot be read, is not TOML, has an unknown section or name, or a
            value of the wrong kind.
    """
    settings: Settings = {}
    for section, entries in _table(path).items():
        if section not in SCHEMA:
            raise InputError(f"{path}: {_unknown('section', section, list(SCHEMA))}")
        if not isinstance(entries, Mapping):
            raise InputError(f"{path}: '{section}' must be a section, [{section}], not a value")
        for name, value in entries.items():
            if name not in SCHEMA[section]:
                where = f"entry in [{section}]"
                raise InputError(f"{path}: {_unknown(where, name, list(SCHEMA[section]))}")
            settings[name] = _value(path, f"{section}.{name}", value, SCHEMA[section][name])
    return settings


def _table(path: Path) -> dict[str, object]:
    try:
        text = read_bounded(path, TABLE)
    except (OSError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or str(error)).lower()
        raise InputError(
            f"cannot read the configuration '{path}': {reason}; give the path of a TOML file"
        ) from error
    return parse_toml(text, f"the configuration '{path}'")


def _value(path: Path, name: str, value: object, kind: str) -> object:
    """Return a value of the kind its name asks for, files as paths."""
    good = {
        "text": isinstance(value, str),
        "file name": isinstance(value, str),
        "true or false": isinstance(value, bool),
        "whole number": isinstance(value, int) and not isinstance(value, bool),
        "number": _is_number(value),
        "list of names": _is_list_of_names(value),
        "list of file names": _is_list_of_names(value),
        "table of numbers": isinstance(value, dict) and all(map(_is_number, value.values())),
    }[kind]
    if not good:
        raise InputError(f"{path}: {name} = {str(value)[:60]!r} is wrong; give a {kind}")
    if kind == "file name":
        return path.parent / str(value)
    if kind == "list of file names" and isinstance(value, list):
        return [path.parent / str(name) for name in value]
    return float(str(value)) if kind == "number" else value


def _is_list_of_names(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(v, str) for v in value)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _unknown(what: str, name: str, known: list[str]) -> str:
    close = get_close_matches(name, known, n=1)
    hint = f"did you mean '{close[0]}'? " if close else ""
    return f"unknown {what} '{name}'; {hint}there are {', '.join(known)}"
