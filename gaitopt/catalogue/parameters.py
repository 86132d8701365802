"""A biped's specification as a table: parameters by words, changes by name, TOML files.

A parameter ("shin", "hip width") takes along what hangs on a length: boxes, centres of mass, and
inertias that were given.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, replace
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np

from gaitopt.atomic import write_atomically
from gaitopt.bounds import TABLE
from gaitopt.catalogue.biped_spec import BipedSpec, Links, LinkSpec, allowed_of, biped13
from gaitopt.dataclass import dataclass
from gaitopt.errors import SpecError, did_you_mean
from gaitopt.importers.text_files import parse_toml, read_text
from gaitopt.settings import checked_arguments, plain
from gaitopt.units import read_quantity

Read = Callable[[BipedSpec], float]
Change = Callable[[BipedSpec, float], BipedSpec]


_HEADER = """\
# A biped for gaitopt. SI units. Values are those of the left leg, the right one is its mirror.
# An entry left out takes its value from the biped13 preset; numbers may have units, "30cm".
# Lengths and masses have names, too, that stand before the tables: shin=0.42, "hip width"="20cm";
# lengths take boxes and centres of mass along (docs/cli.md lists them). Take the entries that a
# name sets out of the tables then, or write the table anew: gaitopt urdf --set shin=0.42 ...
# In [geometry], l1 is from the toe edge to the ankle (negative), d1 the ankle above the sole, d3
# the shin, d4 the thigh, l4 the leg's plane outboard of the hip centre, d7 between the hip centres.
# A link without `inertia` (3 x 3, about the centre of mass) has that of a homogeneous box of its
# `size`.
"""


@dataclass(frozen=True)
class Parameter:
    """A number of a biped that has a name of its own.

    Attributes:
        help: what it is, and what follows it.
        unit: "m" or "kg".
        value: reads it.
        changed: returns a biped with another value.
    """

    help: str
    unit: str
    value: Read
    changed: Change


def _stretched(link: LinkSpec, factors: tuple[float, float, float]) -> LinkSpec:
    """Return a link stretched about the joint above it along x, y, z; its mass stays."""
    k = np.array(factors)
    inertia = link.inertia
    if inertia is not None:  # through the second moments of mass, so that it stays physical
        given = np.array(inertia)
        second = np.outer(k, k) * (0.5 * np.trace(given) * np.eye(3) - given)
        inertia = _rows(np.trace(second) * np.eye(3) - second)
    return replace(link, size=_numbers(k * link.size), com=_numbers(k * link.com), inertia=inertia)


def _numbers(values: Any) -> Any:
    return tuple(map(float, values))


def _rows(matrix: Any) -> Any:
    return tuple(_numbers(row) for row in matrix)


def _with_length(names: tuple[str, ...], link: str, axis: int) -> Parameter:
    """Return the parameter of lengths in `Geometry`, the first of which it is, and of a link."""

    def value(spec: BipedSpec) -> float:
        return float(getattr(spec.geometry, names[0]))

    def change(spec: BipedSpec, new: float) -> BipedSpec:
        k = new / value(spec)
        lengths = {name: getattr(spec.geometry, name) * k for name in names} | {names[0]: new}
        factors: Any = tuple(k if i == axis else 1.0 for i in range(3))
        links = replace(spec.links, **{link: _stretched(getattr(spec.links, link), factors)})
        return replace(spec, geometry=replace(spec.geometry, **lengths), links=links)

    return Parameter(f"{link} with its box and centre of mass", "m", value, change)


def _mass(*names: str, value: Read | None = None) -> Parameter:
    """Return the parameter of the mass of links, by default of one leg where they are of a leg."""
    value = value or (lambda spec: sum(getattr(spec.links, name).mass for name in names))

    def change(spec: BipedSpec, new: float) -> BipedSpec:
        k = new / value(spec)
        links = {name: _heavier(getattr(spec.links, name), k) for name in names}
        return replace(spec, links=replace(spec.links, **links))

    return Parameter("mass; its shares and inertias go with it", "kg", value, change)


def _heavier(link: LinkSpec, k: float) -> LinkSpec:
    inertia = None if link.inertia is None else _rows(k * np.array(link.inertia))
    return replace(link, mass=k * link.mass, inertia=inertia)


def _leg(spec: BipedSpec, new: float) -> BipedSpec:
    k = new / (spec.geometry.d3 + spec.geometry.d4)
    shin, thigh = k * spec.geometry.d3, k * spec.geometry.d4
    return PARAMETERS["thigh"].changed(PARAMETERS["shin"].changed(spec, shin), thigh)


def _ankle_height(spec: BipedSpec, new: float) -> BipedSpec:
    foot = spec.links.foot
    x, y, z = foot.com
    lower = replace(foot, com=(x, y, z - (new - spec.geometry.d1)))  # the box stays on the sole
    geometry, links = replace(spec.geometry, d1=new), replace(spec.links, foot=lower)
    return replace(spec, geometry=geometry, links=links)


def _trunk_height(spec: BipedSpec, new: float) -> BipedSpec:
    factors = (1.0, 1.0, new / spec.links.torso.size[2])
    return replace(spec, links=replace(spec.links, torso=_stretched(spec.links.torso, factors)))


PARAMETERS: Mapping[str, Parameter] = {
    "leg": Parameter("shin and thigh in proportion", "m", lambda s: s.geometry.d3 + s.geometry.d4,
                     _leg),
    "shin": _with_length(("d3",), "shin", 2),
    "thigh": _with_length(("d4",), "thigh", 2),
    "hip_width": Parameter(
        "between the hip centres", "m", lambda s: s.geometry.d7,
        lambda spec, new: replace(spec, geometry=replace(spec.geometry, d7=new)),
    ),
    "ankle_height": Parameter("above the sole", "m", lambda s: s.geometry.d1, _ankle_height),
    "foot_length": _with_length(("foot_length", "l1"), "foot", 0),
    "foot_width": _with_length(("foot_width",), "foot", 1),
    "trunk_height": Parameter("of its box", "m", lambda s: s.links.torso.size[2], _trunk_height),
    "mass": _mass(*(entry.name for entry in fields(Links)), value=lambda s: s.total_mass),
    "trunk_mass": _mass("torso"),
    "hip_mass": _mass("hip_yaw", "hip_roll"),
    **{f"{link}_mass": _mass(link) for link in ("thigh", "shin", "ankle", "foot")},
}  # fmt: skip
"""Parameters by their names; blanks and dashes may stand for underscores."""


def parameter_name(text: str) -> str | None:
    """Return the name of a parameter as it is written in `PARAMETERS`, None if it is none."""
    name = "_".join(text.replace("-", " ").replace("_", " ").lower().split())
    return name if name in PARAMETERS else None


def parameter_unit(text: str) -> str:
    """Return the unit of a parameter or of an entry of the table; empty where it has none.

    Raises:
        SpecError: there is none of that name.
    """
    if (name := parameter_name(text)) is not None:
        return PARAMETERS[name].unit
    part: Any = BipedSpec
    allowed = None
    for step in text.split("."):
        entries = {entry.name: entry for entry in fields(part)} if part else {}
        if step not in entries:
            names = PARAMETERS if part is BipedSpec else ()
            raise SpecError(_unknown(text, step, [*entries, *names]))
        allowed, part = allowed_of(entries[step]), entries[step].metadata.get("part")
    return allowed.unit if allowed is not None else ""


@checked_arguments
def changed(spec: BipedSpec, changes: Mapping[str, Any]) -> BipedSpec:
    """Return a copy with some values changed: `{"shin": 0.35, "links.torso.mass": 45}`.

    Args:
        changes: new values [SI units] by the name of a parameter, which takes along what hangs on
            it, or by the path of an entry of the table, which stands for itself.

    Raises:
        SpecError: there is none of that name, or the changed biped is not physical.
    """
    table: dict[str, Any] = {}
    for path, value in plain(dict(changes)).items():
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
        table: parameters by name, set first and in order, and nested mappings with the names of
            the specification's fields.

    Raises:
        SpecError: an unknown key, a value of the wrong type, or one that is not physical; or the
            tables undo what a parameter sets.
    """
    rest: dict[str, Any] = {}
    changes: dict[str, tuple[BipedSpec, BipedSpec]] = {}  # the biped before and after each name
    for key, value in _check_table(table, "").items():
        if (name := parameter_name(str(key))) is None:
            rest[key] = value
        else:
            changes[name] = (spec, _set(spec, name, value))
            spec = changes[name][1]
    biped: BipedSpec = _merged(spec, rest, "")
    for name, (before, after) in changes.items():
        parameter = PARAMETERS[name]
        asked, found = parameter.value(spec), parameter.value(biped)
        if not math.isclose(asked, found, rel_tol=1e-9):
            undone = [p for p in _paths(rest) if _at(before, p) != _at(after, p)]
            raise SpecError(
                f"{name} is {asked:.6g} {parameter.unit}, but the tables make it {found:.6g} "
                f"{parameter.unit}; take {', '.join('.'.join(p) for p in undone)} out of them, "
                f"or leave {name} out"
            )
    return biped


def _paths(table: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    """Yield the path of every entry of a nested table."""
    for key, value in table.items():
        inner = _paths(value) if isinstance(value, Mapping) else [()]
        yield from ((key, *path) for path in inner)


def _at(part: Any, path: tuple[str, ...]) -> Any:
    """Return the entry of a biped that a path leads to."""
    return reduce(getattr, path, part)


def _set(spec: BipedSpec, name: str, value: object) -> BipedSpec:
    parameter = PARAMETERS[name]
    try:
        number = read_quantity(value, parameter.unit)
    except ValueError as error:
        raise SpecError(f"{name} = {str(value)[:60]!r} is wrong; {error}") from None
    if not 0.0 < number < np.inf:
        raise SpecError(f"{name} = {number:g} {parameter.unit} is wrong; it must be above 0")
    return parameter.changed(spec, number)


def _merged(part: Any, table: object, path: str) -> Any:
    entries = {entry.name: entry for entry in fields(part)}
    changes: dict[str, Any] = {}
    for key, value in _check_table(table, path).items():
        where = f"{path}.{key}" if path else str(key)
        if key not in entries:
            raise SpecError(_unknown(where, str(key), [*entries, *([] if path else PARAMETERS)]))
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
    hint = did_you_mean(key, allowed)
    return f"unknown entry {path[:120]}; {hint}allowed here: {', '.join(allowed)}"


@checked_arguments
def read_spec(path: str | os.PathLike[str]) -> BipedSpec:
    """Read a biped from a TOML file; what the file leaves out is taken from `biped13`.

    Raises:
        SpecError: the file is missing, unreadable or not TOML, has an unknown entry, or describes
            a biped that is not physical.
    """
    made = "'gaitopt urdf --write-spec FILE' (in Python, write_spec)"
    advice = (
        f"give the path of a TOML file, for example one made by {made}; without one it is biped13"
    )
    text = read_text(Path(path), "specification", advice, SpecError, TABLE)
    edit = f"write a correct one by {made} and edit that"
    table = parse_toml(text, str(Path(path)), edit, SpecError)
    try:
        return merged(biped13(), table)
    except SpecError as error:
        raise SpecError(f"{os.fspath(path)}: {error}") from None


@checked_arguments
def write_spec(spec: BipedSpec, path: str | os.PathLike[str]) -> None:
    """Write a biped to a TOML file that `read_spec` reads back equal; all of it or nothing.

    Raises:
        InputError: the file cannot be written.
    """
    write_atomically(path, spec_text(spec).encode())


@checked_arguments
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
