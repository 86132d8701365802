"""`@dataclass(frozen=True)`, applied in a fifth of the time that the library takes.

The library writes and compiles up to six functions for every class, of which a command loads 300:
longer than NumPy and Pinocchio take to import (docs/decisions/dataclasses.md). Here only `__init__`
is compiled, as soon as it is asked for; everything else that a frozen dataclass has is the same few
lines for all of them.
`fields`, `replace`, `asdict`, pattern matching, and classes of the library's own decorator that
inherit from these work as usual.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable, Iterable
from operator import attrgetter
from reprlib import recursive_repr
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:

    def dataclass(cls=None, /, *, frozen=False, eq=True):
        """Make a class a dataclass, as the decorator of the library does.

        Args:
            cls: the class, where the decorator stands without parentheses.
            frozen: whether assignments raise `FrozenInstanceError`; if not, the library does all.
            eq: whether instances are compared, and hashed, by their fields.
        """
        make = _frozen if frozen else dataclasses.dataclass
        return make(cls, eq=eq) if cls is not None else lambda cls: make(cls, eq=eq)


def made_anew(one: Any) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """Return how to copy and pickle an instance, as its `__reduce__`: made anew of its fields.

    Else copies would have neither read-only arrays nor what else `__post_init__` sees to.
    """
    kept = {f.name: getattr(one, f.name) for f in dataclasses.fields(one) if f.init}
    return _make, (type(one), kept)


def _make(cls: type, kept: dict[str, Any]) -> Any:
    return cls(**kept)


def _frozen(cls: type, eq: bool) -> type:
    inherits = any(map(dataclasses.is_dataclass, cls.__mro__[1:]))
    dataclasses.dataclass(init=False, repr=False, eq=False, frozen=inherits)(cls)
    fields = dataclasses.fields(cls)
    methods: dict[str, Any] = {"__init__": _Uncompiled(cls), "__repr__": _repr}
    if not inherits:  # frozen classes inherit from frozen ones alone: the library sees to it
        vars(cls)["__dataclass_params__"].frozen = True
        methods["__setattr__"], methods["__delattr__"] = _refusals(cls)
    if eq:
        methods["__eq__"] = _equality(_values(f.name for f in fields if f.compare))
        if vars(cls).get("__hash__") is None:  # None where a class has an `__eq__` of its own
            hashed = (f.name for f in fields if (f.compare if f.hash is None else f.hash))
            methods["__hash__"] = _hashing(_values(hashed))
    for name, method in methods.items():
        if vars(cls).get(name) is None:
            setattr(cls, name, method)
    return cls


class _Made:
    """Stands in a signature for a default that is made anew for every instance."""

    def __repr__(self) -> str:
        return "<factory>"


_MADE = _Made()


class _Uncompiled:
    """Stands for `__init__` until that is first asked for: of most classes it never is."""

    def __init__(self, cls: type) -> None:
        self._class = cls

    def __get__(self, one: object, _: type | None = None) -> Any:
        """Compile it in its own place, and return it."""
        made = self._class.__init__ = _initialiser(self._class)  # type: ignore[misc]
        return made.__get__(one, self._class)


def _initialiser(cls: type) -> Callable[..., None]:
    """Return `__init__`: one argument, and one assignment, per field."""
    known: dict[str, Any] = {"_assign": object.__setattr__, "_MADE": _MADE}
    arguments, by_name, lines = ["self"], list[str](), list[str]()
    fields = dataclasses.fields(cls)
    for one in fields:
        name, value, default = one.name, one.name, ""
        if one.default_factory is not dataclasses.MISSING:
            known[f"_make_{name}"], default = one.default_factory, "=_MADE"
            value = f"_make_{name}()" + (f" if {name} is _MADE else {name}" if one.init else "")
        elif one.default is not dataclasses.MISSING:
            known[f"_default_{name}"], default = one.default, f"=_default_{name}"
        if one.init:
            (by_name if one.kw_only else arguments).append(name + default)
        elif one.default_factory is dataclasses.MISSING:
            continue  # a default stays an attribute of the class, or `__post_init__` assigns
        lines.append(f"_assign(self, {name!r}, {value})")
    if hasattr(cls, "__post_init__"):
        lines.append("self.__post_init__()")
    signature = ", ".join([*arguments, "*", *by_name] if by_name else arguments)
    body = "\n  ".join(lines or ["pass"])
    text = f"def make({', '.join(known)}):\n def __init__({signature}):\n  {body}\n return __init__"
    made: dict[str, Any] = {}
    # only names of fields, which are identifiers, go into the text
    exec(text, getattr(sys.modules.get(cls.__module__), "__dict__", {}), made)
    initialiser: Callable[..., None] = made["make"](**known)
    initialiser.__qualname__ = f"{cls.__qualname__}.__init__"
    initialiser.__annotations__ = {f.name: f.type for f in fields if f.init} | {"return": None}
    return initialiser


def _values(names: Iterable[str]) -> Callable[[Any], tuple[Any, ...]]:
    """Return what reads the named attributes of an instance."""
    read = tuple(names)
    return attrgetter(*read) if len(read) > 1 else lambda one: tuple(getattr(one, n) for n in read)


def _equality(values: Callable[[Any], tuple[Any, ...]]) -> Callable[[Any, object], bool]:
    def equal(self: Any, other: object) -> bool:
        return values(self) == values(other) if type(other) is type(self) else NotImplemented

    return equal


def _hashing(values: Callable[[Any], tuple[Any, ...]]) -> Callable[[Any], int]:
    return lambda self: hash(values(self))


@recursive_repr()
def _repr(self: Any) -> str:
    shown = (f"{f.name}={getattr(self, f.name)!r}" for f in dataclasses.fields(self) if f.repr)
    return f"{type(self).__qualname__}({', '.join(shown)})"


def _refusals(cls: type) -> tuple[Callable[..., None], Callable[..., None]]:
    """Return `__setattr__` and `__delattr__`; plain subclasses may have attributes of their own."""
    fields = frozenset(one.name for one in dataclasses.fields(cls))

    def assign(self: Any, name: str, value: object) -> None:
        if type(self) is cls or name in fields:
            raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")
        object.__setattr__(self, name, value)

    def delete(self: Any, name: str) -> None:
        if type(self) is cls or name in fields:
            raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")
        object.__delattr__(self, name)

    return assign, delete
