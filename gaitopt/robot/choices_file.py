"""Choices as a TOML file and as a table of plain values, for files of results."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from gaitopt.errors import RobotError
from gaitopt.robot.choices import UNUSED_SRDF, Choices, InertiaOverride, LimitOverride
from gaitopt.robot.feet.sole import Sole
from gaitopt.robot.files.text_file import read_text
from gaitopt.robot.files.toml import parse_toml

NO_LIMIT = "none"
"""What stands for an infinite limit in a file."""


def choices_from_toml(toml: str | Path) -> Choices:
    """Read choices from the text or the path of a TOML file; its paths are relative to it.

    Args:
        toml: a `Path`, or text; text without a line break that ends in ".toml" is a path.

    Raises:
        RobotError: the file cannot be read or is not TOML, has an unknown key, a value that cannot
            be used, or an SRDF that it does not use.
    """
    is_path = isinstance(toml, Path) or (toml.strip().endswith(".toml") and "\n" not in toml)
    where = str(toml).strip() if is_path else "the choices"
    text = read_text(Path(where), "choices") if is_path else str(toml)
    table = parse_toml(text, where, kind=RobotError)
    try:
        choices = choices_from_record(table)
        if choices.srdf is not None and isinstance(choices.posture, tuple) and not choices.rotors:
            raise RobotError(UNUSED_SRDF)
    except RobotError as error:
        raise RobotError(f"{where}: {error}") from None
    return _beside(choices, Path(where).parent) if is_path else choices


def _beside(choices: Choices, folder: Path) -> Choices:
    """Return choices whose relative paths start in a folder."""
    folder = folder.absolute()
    directories = tuple(str(folder / Path(d).expanduser()) for d in choices.package_dirs)
    srdf = choices.srdf
    if srdf is not None and not srdf.lstrip().startswith("<"):
        srdf = str(folder / Path(srdf).expanduser())
    return replace(choices, package_dirs=directories, srdf=srdf)


def choices_from_record(record: Mapping[str, Any]) -> Choices:
    """Return the choices of a table of plain values, as `choices_record` makes it.

    Raises:
        RobotError: an unknown key, or a value that cannot be used.
    """
    table = dict(_table(record, "choices"))
    _check_keys(table, Choices, "")
    if table.get("sole") is not None:
        sole = dict(_table(table["sole"], "sole"))
        _check_keys(sole, Sole, "sole.")
        missing = [f.name for f in fields(Sole) if f.name not in sole]
        if missing:
            raise RobotError(f"sole.{missing[0]} is missing; give toe, heel, left and right [m]")
        table["sole"] = Sole(**{k: _number(v, f"sole.{k}") for k, v in sole.items()})
    if table.get("limits") is not None:
        table["limits"] = tuple(_override(entry) for entry in _list(table["limits"], "limits"))
    if table.get("inertias") is not None:
        table["inertias"] = tuple(_body(entry) for entry in _list(table["inertias"], "inertias"))
    for name in ("forward", "up"):
        if isinstance(table.get(name), list):
            table[name] = tuple(table[name])
    return Choices(**{key: value for key, value in table.items() if value is not None})


def choices_record(choices: Choices) -> dict[str, Any]:
    """Return what differs from the defaults, as values that JSON and TOML can hold."""
    record: dict[str, Any] = {}
    for entry in fields(Choices):
        value = getattr(choices, entry.name)
        if value != entry.default:
            record[entry.name] = _plain(entry.name, value)
    return record


def _plain(name: str, value: Any) -> Any:
    if name == "sole":
        return {f.name: float(getattr(value, f.name)) for f in fields(Sole)}
    if name == "posture" and not isinstance(value, str):
        return dict(value)
    if name == "limits":
        return [_override_record(entry) for entry in value]
    if name == "inertias":
        return [_body_record(entry) for entry in value]
    if name in ("sole_placements", "capsules"):
        return [list(numbers) for numbers in value]
    return list(value) if isinstance(value, tuple) else value


def _override_record(entry: LimitOverride) -> dict[str, Any]:
    record: dict[str, Any] = {"joints": entry.joints}
    for name, value in entry.numbers().items():
        record[name] = NO_LIMIT if math.isinf(value) else value
    return {**record, "source": entry.source} if entry.source else record


def _override(entry: object) -> LimitOverride:
    table = dict(_table(entry, "limits"))
    _check_keys(table, LimitOverride, "limits.")
    if "joints" not in table:
        raise RobotError('limits: joints is missing; give a pattern of names, as "*knee*"')
    for name, value in table.items():
        if value == NO_LIMIT and name in ("torque", "speed", "lower", "upper"):
            table[name] = -math.inf if name == "lower" else math.inf
    return LimitOverride(**table)


def _body_record(entry: InertiaOverride) -> dict[str, Any]:
    values = {f.name: getattr(entry, f.name) for f in fields(InertiaOverride)}
    return {
        name: list(value) if isinstance(value, tuple) else value
        for name, value in values.items()
        if value is not None
    }


def _body(entry: object) -> InertiaOverride:
    table = dict(_table(entry, "inertias"))
    _check_keys(table, InertiaOverride, "inertias.")
    if "links" not in table:
        raise RobotError('inertias: links is missing; give a pattern of names, as "*foot*"')
    return InertiaOverride(**table)


def _check_keys(table: Mapping[str, Any], part: type, path: str) -> None:
    known = [entry.name for entry in fields(part)]
    for key in table:
        if key not in known:
            close = get_close_matches(str(key), known, n=1)
            hint = f"did you mean {close[0]}? " if close else ""
            raise RobotError(f"unknown entry {path}{key}; {hint}known are: {', '.join(known)}")


def _table(value: object, name: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise RobotError(f"{name} must be a table of named values, got {str(value)[:60]!r}")
    return value


def _list(value: object, name: str) -> list[Any]:
    if not isinstance(value, (list, tuple)):
        raise RobotError(f"{name} must be a list of tables ([[{name}]]), got {str(value)[:60]!r}")
    return list(value)


def _number(value: object, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise RobotError(f"{name} must be a finite number [m], got {value!r}")
    return float(value)
