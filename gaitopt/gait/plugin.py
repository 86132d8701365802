"""Constraints, costs and terrains of one's own from a Python file.

The file is imported; it offers, at module level, `constraints`, instances of subclasses of
`Constraint` (one, a tuple or a list), `cost`, an instance of a subclass of `Cost`, and `terrain`,
one of a subclass of `Terrain`; any of them will do. Nothing else in it is looked at. A gait file
records the names, the values of their fields, and the plugin's file name and digest; it never makes
gaitopt run a plugin: who checks such a gait gives the file again.
"""

from __future__ import annotations

import copyreg
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import lru_cache, partial
from hashlib import sha256
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from gaitopt.bounds import TABLE, read_bounded, shown
from gaitopt.dataclass import dataclass
from gaitopt.errors import PLUGIN, InputError, failure, own_line, reason_of
from gaitopt.gait.constraint import Constraint, check_declaration
from gaitopt.gait.constraints import MotorEnvelope
from gaitopt.gait.costs import COSTS, Cost, WeightedSum
from gaitopt.gait.motor_space import MotorSpace
from gaitopt.gait.terrain import Level, Slope, Stairs, Terrain
from gaitopt.settings import checked_arguments

Extension = Constraint | Cost | Terrain
_Kind = TypeVar("_Kind", Constraint, Cost, Terrain)
_LONGEST = 80  # characters of a name in a message
_PLAIN = (str, int, float, bool, type(None))


@dataclass(frozen=True)
class Plugin:
    """What a plugin's file offers.

    Attributes:
        path: of the file.
        digest: SHA-256 of its contents, the first 16 hexadecimal digits.
        constraints: with the values of their fields that the file gives them.
        cost, terrain: None where it offers none.
    """

    path: Path
    digest: str
    constraints: tuple[Constraint, ...] = ()
    cost: Cost | None = None
    terrain: Terrain | None = None

    @property
    def extensions(self) -> tuple[Extension, ...]:
        """Everything that it offers; of a sum of costs, its terms too."""
        costs = () if self.cost is None else costs_of(self.cost)
        return (*self.constraints, *costs, *(() if self.terrain is None else (self.terrain,)))


def costs_of(cost: Cost) -> tuple[Cost, ...]:
    """Return a cost and, of a sum, its terms at any depth."""
    terms = cost.terms if isinstance(cost, WeightedSum) else ()
    return (cost, *(one for term, _ in terms for one in costs_of(term)))


@checked_arguments
def load_plugin(path: str | Path) -> Plugin:
    """Import a plugin; one that was imported before, and is the same, is not imported again.

    Raises:
        InputError: the file cannot be read or imported, or offers nothing.
    """
    path = Path(path)
    try:
        content = read_bounded(path, TABLE)
    except (OSError, ValueError) as error:
        raise InputError(
            f"cannot read the plugin '{path}': {reason_of(error)}; give a Python file"
        ) from error
    return _loaded(path.absolute(), sha256(content).hexdigest()[:16])


@lru_cache(maxsize=64)
def _loaded(path: Path, digest: str) -> Plugin:
    name = f"{PLUGIN}{digest}_{sha256(str(path).encode()).hexdigest()[:8]}"
    spec = spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise InputError(f"the plugin '{path}' is no Python file; give one whose name ends in .py")
    module = module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up while they are made
    try:
        spec.loader.exec_module(module)
        return _offered(module, path, digest)
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        if isinstance(error, InputError):
            if line := own_line(error):
                raise InputError(f"{error} ({line})") from error
            raise
        raise InputError(f"the plugin '{path}' cannot be imported: {failure(error)}") from error


def _offered(module: ModuleType, path: Path, digest: str) -> Plugin:
    given, cost = getattr(module, "constraints", ()), getattr(module, "cost", None)
    constraints = tuple(given) if isinstance(given, list | tuple) else (given,)
    for one in constraints:
        if not isinstance(one, Constraint):
            raise InputError(
                f"the plugin '{path}' has {one!r} in `constraints`; give instances of subclasses "
                "of Constraint"
            )
    terrain = getattr(module, "terrain", None)
    for name, one, kind in (("cost", cost, Cost), ("terrain", terrain, Terrain)):
        if one is not None and not isinstance(one, kind):
            wanted = f"give an instance of a {kind.__name__}"
            raise InputError(f"`{name}` of the plugin '{path}' is {one!r}; {wanted}")
    if not constraints and cost is None and terrain is None:
        raise InputError(
            f"the plugin '{path}' offers nothing; at module level, let `constraints` be a tuple of "
            "constraints, `cost` a cost, or `terrain` a terrain"
        )
    found = Plugin(path, digest, constraints, cost, terrain)
    for own in {type(one) for one in found.extensions}:
        if own.__module__ == module.__name__:
            copyreg.pickle(own, partial(_reduced, path))  # type: ignore[arg-type]
    return found


def _reduced(path: Path, one: Any) -> tuple[Callable[..., object], tuple[Any, ...]]:
    """Pickle an instance of a class of a plugin: another process imports the file."""
    return _restored, (path, type(one).__qualname__, dict(vars(one)))


def _restored(path: Path, name: str, values: dict[str, object]) -> object:
    found = load_plugin(path).extensions
    kind: Any = next(type(one) for one in found if type(one).__qualname__ == name)
    one = object.__new__(kind)
    for key, value in values.items():
        object.__setattr__(one, key, value)
    return one


def extension_record(one: Extension) -> dict[str, object]:
    """Return a constraint, a cost or a terrain as JSON-able data: name, fields, where it is from.

    A cost has its unit and its words besides, for those who show the gait without it.

    Raises:
        InputError: a field has a value that a file cannot hold.
    """
    record: dict[str, object] = {"name": one.name, "fields": _fields_record(one)}
    if isinstance(one, Cost):
        record |= {"unit": one.unit, "words": one.words}
    module = type(one).__module__
    if module.startswith(PLUGIN):
        path = Path(str(sys.modules[module].__file__))
        digest = module.removeprefix(PLUGIN).split("_")[0]
        record["plugin"] = {"file": path.name, "sha256": digest}
    elif not is_built_in(one):
        record["class"] = f"{module}.{type(one).__qualname__}"
    return record


def is_built_in(one: Extension) -> bool:
    """Return whether it is of gaitopt; a sum of costs is, whatever its terms are."""
    return type(one).__module__.startswith("gaitopt.")


def _fields_record(one: Extension) -> dict[str, object]:
    names: list[str] = [entry.name for entry in fields(one)] if is_dataclass(one) else []
    return {name: _plain(getattr(one, name), f"{name} of '{one.name}'") for name in names}


def _plain(value: object, what: str) -> object:
    if isinstance(value, Constraint | Cost):
        return extension_record(value)
    if isinstance(value, Mapping):
        return {str(key): _plain(entry, what) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry, what) for entry in value]
    if not isinstance(value, _PLAIN):
        raise InputError(
            f"{what} is a {type(value).__name__}, which a gait file cannot record; give numbers, "
            "texts, or tuples and tables of them"
        )
    return value


def constraint_from_record(record: object, known: Iterable[Extension]) -> Constraint:
    """Return the constraint of a record made by `extension_record`.

    Args:
        known: constraints and costs there are besides the built-in ones, as of a plugin.

    Raises:
        InputError: it is not among those known: who reads the record has to give it.
    """
    constraints = [
        MotorEnvelope(),
        MotorSpace(),
        *(one for one in known if isinstance(one, Constraint)),
    ]
    return _found(record, constraints, "constraint")


def cost_from_record(record: object, known: Iterable[Extension]) -> Cost:
    """Return the cost of a record made by `extension_record`; see `constraint_from_record`.

    Raises:
        InputError: it is not among those known, or the record of a sum is none.
    """
    own = (costs_of(one) for one in known if isinstance(one, Cost))
    costs = [*COSTS, *(one for group in own for one in group)]
    fields = record.get("fields") if isinstance(record, Mapping) else None
    terms = fields.get("terms") if isinstance(fields, Mapping) else None
    if not isinstance(terms, list):
        return _found(record, costs, "cost")
    if not all(isinstance(term, list) and len(term) == 2 for term in terms):
        raise InputError("the record of a sum of costs has no pairs of a cost and its weight")
    return WeightedSum(tuple((cost_from_record(one, costs), weight) for one, weight in terms))


def terrain_from_record(record: object, known: Iterable[Extension]) -> Terrain:
    """Return the terrain of a record made by `extension_record`; see `constraint_from_record`."""
    terrains = [Level(), Slope(0.0), Stairs(0.0), *(t for t in known if isinstance(t, Terrain))]
    return _found(record, terrains, "terrain")


def _found(record: object, known: list[_Kind], kind: str) -> _Kind:
    if not isinstance(record, Mapping) or not isinstance(record.get("name"), str):
        raise InputError(f"the record of a {kind} has no name")
    for one in known:
        if not is_built_in(one):
            check_declaration(one)
    # A cost of one's own may be called "torque", too: the record says where it is from.
    own = "plugin" in record or "class" in record
    named = (one for one in known if one.name == record["name"])
    found = next((one for one in named if not (own and is_built_in(one))), None)
    if found is None:
        raise InputError(_needed(record, kind))
    values: Any = record.get("fields", {})
    takes = _fields_record(found)
    if isinstance(values, Mapping) and (odd := [str(name) for name in values if name not in takes]):
        where = _needed(record, kind) if own else "design the gait again"
        raise InputError(
            f"the {kind} '{found.name}' takes {', '.join(takes) or 'nothing'}, and no "
            f"{_told(', '.join(odd))}, which is recorded; {where}"
        )
    try:
        return replace(found, **_tuples(values)) if values else found  # type: ignore[type-var]
    except (TypeError, ValueError) as error:
        raise InputError(
            f"the {kind} '{found.name}' does not take the values recorded, {shown(values)}: {error}"
        ) from error


def _tuples(value: Any) -> Any:
    """JSON has lists for tuples."""
    if isinstance(value, Mapping):
        return {key: _tuples(entry) for key, entry in value.items()}
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _needed(record: Mapping[str, object], kind: str) -> str:
    plugin, home = record.get("plugin"), record.get("class")
    what = f"it has the {kind} '{_told(record['name'])}', which is not gaitopt's own"
    if isinstance(plugin, Mapping):
        file, digest = _told(plugin.get("file")), _told(plugin.get("sha256"))
        return (
            f"{what}: it is of the plugin '{file}' (sha256 {digest}...); give that "
            f"file: --plugin {file} (in Python known=load_plugin('{file}').extensions)"
        )
    made = f": it is a {_told(home)}" if home else ""
    return (
        f"{what}{made}; put it into a file and give that: --plugin FILE (in Python "
        "known=load_plugin(FILE).extensions), see docs/extending.md"
    )


def _told(value: object) -> str:
    """What a file says, for a message."""
    return "".join(c if c.isprintable() else "?" for c in str(value)[:_LONGEST])
