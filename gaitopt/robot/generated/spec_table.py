"""A specification as nested tables of plain values, and changes to it by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from difflib import get_close_matches
from typing import Any

from gaitopt.errors import SpecError
from gaitopt.robot.generated.spec import BipedSpec


def changed(spec: BipedSpec, changes: Mapping[str, Any]) -> BipedSpec:
    """Return a copy with some values changed: `{"geometry.d3": 0.35, "links.torso.mass": 45}`.

    Boxes and centres of mass are values like any other: they do not follow a length by themselves.

    Args:
        spec: the biped to start from.
        changes: new values [SI units of the field] by path.

    Raises:
        SpecError: a path does not exist, or the changed biped is not physical.
    """
    table: dict[str, Any] = {}
    for path, value in changes.items():
        *parents, key = path.split(".")
        inner = table
        for name in parents:
            inner = inner.setdefault(name, {})
            _check_table(inner, name)
        inner[key] = value
    return merged(spec, table)


def merged(spec: BipedSpec, table: Mapping[str, Any]) -> BipedSpec:
    """Return a copy of the specification with the values of a nested table in place of its own.

    Args:
        spec: gives every value that the table does not mention.
        table: nested mappings with the names of the specification's fields.

    Raises:
        SpecError: an unknown key, a value of the wrong type, or one that is not physical.
    """
    biped: BipedSpec = _merged(spec, table, "")
    return biped


def _merged(part: Any, table: object, path: str) -> Any:
    entries = {entry.name: entry for entry in fields(part)}
    changes: dict[str, Any] = {}
    for key, value in _check_table(table, path).items():
        where = f"{path}.{key}" if path else str(key)
        if key not in entries:
            raise SpecError(_unknown(where, str(key), list(entries)))
        nested = "part" in entries[key].metadata
        changes[key] = _merged(getattr(part, key), value, where) if nested else value
    return replace(part, **changes)


def _check_table(table: object, path: str) -> Mapping[str, Any]:
    if not isinstance(table, Mapping):
        raise SpecError(
            f"{path or 'a specification'} must be a table of named values, got {str(table)[:60]}"
        )
    return table


def _unknown(path: str, key: str, allowed: list[str]) -> str:
    close = get_close_matches(key, allowed, n=1)
    hint = f"did you mean {close[0]}? " if close else ""
    return f"unknown entry {path[:120]}; {hint}allowed here: {', '.join(allowed)}"
