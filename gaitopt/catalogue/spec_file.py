"""Specifications as TOML files, to read, edit and keep."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

from gaitopt.atomic import write_atomically
from gaitopt.bounds import TABLE, read_bounded
from gaitopt.catalogue.biped_spec import BipedSpec, allowed_of, biped13
from gaitopt.catalogue.parameters import merged
from gaitopt.errors import SpecError
from gaitopt.importers.text_files import parse_toml

_HEADER = """\
# A biped for gaitopt. SI units. Values are those of the left leg, the right one is its mirror.
# An entry left out takes its value from the biped13 preset; numbers may have units, "30cm".
# Lengths and masses have names, too, that stand before the tables: shin=0.42, "hip width"="20cm";
# lengths take boxes and centres of mass along (docs/cli.md lists them).
# A link without `inertia` (3 x 3, about the centre of mass) has that of a homogeneous box of its
# `size`.
"""


def read_spec(path: str | os.PathLike[str]) -> BipedSpec:
    """Read a biped from a TOML file; what the file leaves out is taken from `biped13`.

    Args:
        path: of the file.

    Raises:
        SpecError: the file is missing, unreadable or not TOML, has an unknown entry, or describes
            a biped that is not physical.
    """
    table = _read_table(Path(path))
    try:
        return merged(biped13(), table)
    except SpecError as error:
        raise SpecError(f"{os.fspath(path)}: {error}") from None


def write_spec(spec: BipedSpec, path: str | os.PathLike[str]) -> None:
    """Write a biped to a TOML file that `read_spec` reads back equal; all of it or nothing.

    Args:
        spec: the biped.
        path: of the file; one that exists is replaced.

    Raises:
        InputError: the file cannot be written.
    """
    write_atomically(path, spec_text(spec).encode())


def spec_text(spec: BipedSpec) -> str:
    """Return a biped as TOML with the unit of every value."""
    return "\n".join([_HEADER, f'name = "{spec.name}"', *_lines(spec, "")]) + "\n"


def _lines(part: Any, path: str) -> Iterator[str]:
    for entry in fields(part):
        value, where = getattr(part, entry.name), f"{path}{entry.name}"
        allowed = allowed_of(entry)
        if allowed is not None and value is not None:
            yield f"{entry.name} = {_value_text(value)}  # {allowed.unit}"
        elif "part" in entry.metadata:
            if allowed_of(fields(value)[0]) is not None:
                yield f"\n[{where}]"
            yield from _lines(value, f"{where}.")


def _value_text(value: Any) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(_value_text(item) for item in value)}]"
    return repr(value)


def _read_table(path: Path) -> dict[str, Any]:
    try:
        text = read_bounded(path, TABLE)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise SpecError(
            f"cannot read {path}: {reason}; give the path of a TOML file, for example one that "
            "'gaitopt urdf --write-spec FILE' made (in Python, write_spec)"
        ) from None
    advice = "write a correct one by 'gaitopt urdf --write-spec FILE' (in Python, write_spec)"
    return parse_toml(text, str(path), f"{advice} and edit that", SpecError)
