"""Settings: what the field of a dataclass means to people, and how a value for it is read.

A field declares itself once: `speed: float = entry(1.0, "Walking speed.", "m/s")`.
Options of the command line, entries of TOML files, their help, units and checks follow from that.
"""

from __future__ import annotations

import inspect
import math
import re
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import MISSING, field, fields
from functools import cache, cached_property, lru_cache, wraps
from numbers import Integral, Real
from os import PathLike
from pathlib import Path
from types import NoneType, SimpleNamespace, UnionType
from typing import Any, NamedTuple, TypeVar, Union, cast, get_args, get_origin, get_type_hints

from gaitopt.bounds import NUMBER as LARGEST
from gaitopt.bounds import USABLE, is_finite, is_of_use, shown
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, OptionError, did_you_mean
from gaitopt.units import DEGREES, SINE, SLOPE, read_motion, read_quantity

KEY = "setting"
"""Key of a dataclass field's metadata under which its declaration is found."""

NO_LIMIT = "none"
"""What is written for a limit that is not imposed."""

NUMBER, INTEGER, FLAG, TEXT, FILE = "number", "integer", "flag", "text", "file"
TEXTS, FILES, TABLE = "texts", "files", "table"

_KINDS = {
    "float": NUMBER, "int": INTEGER, "bool": FLAG, "str": TEXT, "Path": FILE,
    "tuple[str, ...]": TEXTS, "tuple[Path, ...]": FILES, "Mapping[str, float]": TABLE,
    "Mapping[str, float | str]": TABLE,
}  # fmt: skip
_ALLOWED = {
    INTEGER: "whole number", FLAG: "true or false", TEXT: "text", FILE: "file name",
    TEXTS: "list of names", FILES: "list of file names", TABLE: "table of numbers",
}  # fmt: skip


def _none(_: str) -> str:
    return ""


@dataclass(frozen=True)
class Setting:
    """One thing that can be set, for people.

    Attributes:
        name: in Python and in TOML files; the option has hyphens for underscores.
        kind: of its value: "number", "integer", "flag", "text", "file"; "texts" and "files" for
            lists, "table" for numbers by name.
        help: one sentence.
        unit: SI unit of a number, a key of `units.UNITS` or any other; empty for none.
        default: None where it follows from something else.
        choices: names that are allowed, or a function that returns them; empty for any.
        metavar: stands for the value in the help; by default the unit.
        common: whether the short help shows it.
        short: another name of the option, "-o".
        argument: whether it stands by itself on the command line, without a name.
        required: whether it must be given.
        limit: whether it is a limit that may be "none".
        negatable: of a flag that is not set by default, whether --no-NAME may say so.
        panel: heading over it in the help, where that is not one of its section.
        written: of a file or directory, whether the command writes it.
        suffixes: of a file, in which its name must end; empty for any.
        entry_unit: of a table, returns the unit of an entry.
        as_given: of a table for joints that turn or slide, whether its entries stay texts: the unit
            with which one is given must suit the joint, which is not known here.
        example: of a table's entry, as NAME=VALUE.
        above, least, most: bounds of a number, see `check_settings`.
    """

    name: str
    kind: str
    help: str
    unit: str = ""
    default: object = None
    choices: tuple[str, ...] | Callable[[], Iterable[str]] = ()
    metavar: str = ""
    common: bool = False
    short: str = ""
    argument: bool = False
    required: bool = False
    limit: bool = False
    negatable: bool = False
    panel: str = ""
    written: bool = False
    suffixes: tuple[str, ...] = ()
    entry_unit: Callable[[str], str] = _none
    as_given: bool = False
    example: str = ""
    above: float | None = None
    least: float | None = None
    most: float | None = None

    @property
    def option(self) -> str:
        """Name of the option on the command line."""
        return f"--{self.name.replace('_', '-')}"

    @property
    def repeatable(self) -> bool:
        """Whether the option may be given several times."""
        return self.kind in (TEXTS, FILES, TABLE)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names that are allowed; empty for any."""
        return tuple(self.choices() if callable(self.choices) else self.choices)

    def read(self, value: object) -> Any:
        """Return one value, of a list one element, as typed on the command line or in a file.

        Raises:
            ValueError: it cannot be read; the message says what is allowed.
        """
        if self.limit and value == NO_LIMIT:
            return value
        if self.kind == NUMBER:
            try:
                return read_quantity(value, self.unit)
            except ValueError as error:
                raise ValueError(f"{error}{', or none' if self.limit else ''}") from None
        if self.kind == INTEGER:
            return _integer(value)
        if self.kind == FLAG and isinstance(value, bool):
            return value
        if self.kind in (FILE, FILES) and isinstance(value, str | Path):
            if not str(value).strip():
                what = "directory, as '.' for this one" if self.metavar == "DIR" else "file"
                raise ValueError(f"the name is empty; give a {what}")
            if self.suffixes and Path(value).suffix.lower() not in self.suffixes:
                raise ValueError(f"give a file whose name ends in {' or '.join(self.suffixes)}")
            return Path(value)
        if self.kind in (TEXT, TEXTS) and isinstance(value, str):
            return value
        raise ValueError(f"give a {_ALLOWED[self.kind]}")

    def read_entry(self, value: object) -> Any:
        """Return the whole value of an entry of a TOML file.

        Raises:
            ValueError: it cannot be read; the message says what is allowed.
        """
        if self.kind == TABLE and isinstance(value, Mapping):
            return {name: self._entry(name, one) for name, one in value.items()}
        if self.kind in (TEXTS, FILES) and isinstance(value, list | tuple):
            return [self.read(one) for one in value]
        if self.repeatable:
            raise ValueError(f"give a {_ALLOWED[self.kind]}")
        return self.read(value)

    def read_pairs(self, texts: object) -> dict[str, Any]:
        """Return a table from the NAME=VALUE texts of a command line, or from one read already.

        Raises:
            InputError: a text is none, or a name comes twice.
        """
        return named_values(texts, self.option, self._value, self.example)

    def _entry(self, name: str, value: object) -> Any:
        try:
            return self._value(name, value)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None

    def _value(self, name: str, value: object) -> Any:
        if self.as_given and isinstance(value, str):
            read_motion(value, self.entry_unit(name))
            return value
        return read_quantity(value, self.entry_unit(name))


def _integer(value: object) -> int:
    if isinstance(value, str) and value.isascii() and "_" not in value:  # see `read_number`
        with suppress(ValueError):
            return int(value)
    elif isinstance(value, int) and not isinstance(value, bool):
        return value
    raise ValueError("give a whole number")


def setting(help_text: str, unit: str = "", **more: Any) -> dict[str, Any]:
    """Return the metadata of a dataclass field that can be set.

    Args:
        help_text: one sentence for people.
        unit: SI unit of the number; empty for none.
        more: other attributes of `Setting`.

    Raises:
        InputError: its bounds are the wrong way round.
    """
    most = more.get("most")
    for name in ("above", "least"):
        if most is not None and (bound := more.get(name)) is not None and bound > most:
            raise InputError(f"{name} is {bound:g} and most is {most:g}; swap them")
    return {KEY: {"help": help_text, "unit": unit, **more}}


def entry(default: Any, help_text: str, unit: str = "", **more: Any) -> Any:
    """Return a dataclass field that can be set.

    Args:
        default: its value unless given; ... where it must be given.
        help_text, unit, more: as in `setting`.
    """
    metadata = setting(help_text, unit, **more)
    if default is ...:
        return field(metadata=metadata)
    if isinstance(default, dict):
        return field(default_factory=default.copy, metadata=metadata)
    return field(default=default, metadata=metadata)


def declared(part: type, *names: str) -> Iterator[Setting]:
    """Yield the settings that a dataclass declares, in its order.

    Args:
        part: the dataclass.
        names: of the fields wanted; by default all that declare themselves.

    Raises:
        TypeError: a declared field is of a type that people cannot write.
    """
    for one in fields(part):
        if KEY not in one.metadata or (names and one.name not in names):
            continue
        kind = _KINDS.get(written := _type_name(str(one.type)))
        if kind is None:
            raise TypeError(f"{part.__name__}.{one.name}: nobody can write a {written}")
        default = None if one.default is MISSING else one.default
        required = one.default is MISSING and one.default_factory is MISSING
        yield Setting(one.name, kind, default=default, required=required, **one.metadata[KEY])


def check_settings(one: Any) -> None:
    """Check that fields of a dataclass instance hold what they declare.

    NumPy's numbers become Python's; what lists and tables hold is not checked.

    Raises:
        OptionError: a value is no whole number, or not True or False, as its field wants.
        InputError: it is none of its choices or no finite number, or a number is out of its bounds
            or beyond those with which one computes.
    """
    for name, kind, said, names, empty, least, most in _checks_of(one.__class__):
        value = getattr(one, name)
        if type(value) is float and least <= value <= most and not 0.0 < abs(value) < 1.0 / LARGEST:
            continue  # as nearly all numbers
        if type(value) not in _PLAIN:
            object.__setattr__(one, name, value := plain(value))
        if kind == FLAG and not isinstance(value, bool):
            raise OptionError(f"{name} is {shown(value)}; it must be True or False")
        if kind == INTEGER and (not isinstance(value, int) or isinstance(value, bool)):
            raise OptionError(f"{name} is {shown(value)}; it must be a whole number")
        if names and value not in names:
            known = (" or " if len(names) == 2 else ", ").join(names)
            hint = did_you_mean(value, names)
            raise InputError(f"{name} {shown(value)} is unknown; {hint}choose {known}")
        if kind == NUMBER and not (value is None and empty):
            _check_number(name, value, said)


class _Check(NamedTuple):
    """What a field must hold: as its metadata say; `empty` where it may be None.

    It may hold every number from `least` to `most` with which one computes; of no number, none.
    """

    name: str
    kind: str
    said: Mapping[str, Any]
    choices: tuple[str, ...]
    empty: bool
    least: float
    most: float


@cache  # there are as many as the program has
def _checks_of(kind: type) -> list[_Check]:
    """Return what the fields of a dataclass that declare themselves must hold."""
    found = []
    for one in fields(kind):
        if KEY in one.metadata:
            said, kind_of_value = one.metadata[KEY], _KINDS.get(_type_name(str(one.type)), NUMBER)
            choices = said.get("choices", ())
            known = choices if isinstance(choices, tuple) else ()
            bounds = _bounds(said) if kind_of_value == NUMBER and not known else (LARGEST, -LARGEST)
            optional = "None" in str(one.type)
            found.append(_Check(one.name, kind_of_value, said, known, optional, *bounds))
    return found


def _bounds(said: Mapping[str, Any]) -> tuple[float, float]:
    """Return the least and the largest number that what is said of a field allows."""
    above, least, most = (said.get(bound) for bound in ("above", "least", "most"))
    least = -LARGEST if least is None else least
    least = least if above is None else max(least, math.nextafter(above, math.inf))
    return least, LARGEST if most is None else min(most, LARGEST)


def _check_number(name: str, value: Any, said: Mapping[str, Any]) -> None:
    unit = "rad" if said["unit"] in (SINE, SLOPE) else said["unit"]
    above, least, most = (said.get(bound) for bound in ("above", "least", "most"))
    degrees = f"; {DEGREES}" if unit == "rad" else ""
    if said["unit"] == SLOPE:
        degrees = f"; for a rise over the run write 10%, {DEGREES}"
    if not is_finite(value):
        must = f"be a finite number{degrees}"
    elif not is_of_use(value):
        must = f"be {'' if above == 0.0 else '0, or '}{USABLE} in size"
    elif above is not None and value <= above:
        must = f"be above {above:g}"
    elif least is not None and most is not None and not least <= value <= most:
        must = f"be between {least:g} and {most:g}{unit and ' '}{unit}{degrees}"
    elif least is not None and value < least:
        must = "not be negative" if least == 0.0 else f"be at least {least:g}"
    elif most is not None and value > most:
        must = f"be at most {most:g} {'' if said['unit'] == SINE else unit}".rstrip() + degrees
    else:
        return
    given = f"{shown(value)} {'' if value is None else unit}".rstrip()
    raise InputError(f"{name} is {given}; it must {must}")


@lru_cache
def _type_name(annotation: str) -> str:
    """Return an annotation, evaluated or not, as it is written, without None and modules."""
    text = annotation.removesuffix(" | None").removeprefix("<class '").removesuffix("'>")
    return re.sub(r"\b[a-z]+\.(?=[a-zA-Z])", "", text)


def named_values(
    texts: object,
    option: str,
    read: Callable[[str, str], Any],
    example: str = "speed=0.83",
) -> dict[str, Any]:
    """Read NAME=VALUE texts of an option that may be repeated.

    Args:
        texts: a list of them, or a table that is read already; anything else has no values.
        option: its name, for the error.
        read: returns the value of a name from its text, or raises a ValueError with advice.
        example: of a text, for the error.

    Raises:
        InputError: one is none, or a name comes twice.
    """
    if isinstance(texts, Mapping):
        return dict(texts)
    values: dict[str, Any] = {}
    for text in texts if isinstance(texts, list | tuple) else []:
        name, equals, number = (part.strip() for part in str(text).partition("="))
        if name in values:
            raise InputError(f"{option} gives {name} twice; give its value once")
        try:
            values[name] = read(name, number)
        except ValueError as error:
            wanted = str(error) if equals and number else "give a name and a number"
            raise InputError(f"{option} {text}: {wanted}, as in {option} {example}") from error
    return values


Kind = TypeVar("Kind", bound=type)
Function = TypeVar("Function", bound=Callable[..., Any])


def checked_facts(kind: Kind) -> Kind:
    """Let a dataclass with arrays refuse names and kinds of values, as `checked`; return it.

    Arrays do not become lists, but lists of numbers become arrays where one is wanted.
    """
    return checked(kind, arrays=True)


def checked(
    kind: Kind,
    elsewhere: Callable[[str], str] = _none,
    *,
    kinds: bool = True,
    arrays: bool = False,
) -> Kind:
    """Let a dataclass of options refuse names and kinds of values in words; return it.

    What the dataclass checks itself goes first. The error is an `OptionError`, a TypeError too.

    Args:
        kind: the dataclass.
        elsewhere: returns where an option is to be given that is none of its own, else nothing.
        kinds: whether the kinds of values are checked too, not the names alone.
        arrays: whether NumPy's numbers and arrays stay what they are.
    """
    made: Any = kind.__init__  # type: ignore[misc]

    @wraps(made)
    def init(self: Any, *args: Any, **values: Any) -> None:
        if not arrays:
            args, values = plain(args), plain(values)
        elif not {list, tuple, float, int}.isdisjoint(map(type, (*args, *values.values()))):
            args, values = _with_arrays(kind, args, values)
        try:
            made(self, *args, **values)
        except OptionError:
            raise
        except (TypeError, AttributeError, LookupError, ValueError) as error:
            _check_names(kind, made, args, values, elsewhere)
            if kinds:
                _check_kinds(kind, self)
            if arrays:
                _check_arrays(kind, self)
            raise error
        if kinds:
            _check_kinds(kind, self)
        if arrays:
            _check_arrays(kind, self)

    type.__setattr__(kind, "__init__", init)
    return kind


def _with_arrays(
    kind: type, args: tuple[Any, ...], values: dict[str, Any]
) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Return arguments of a dataclass with arrays for numbers and lists of them, where wanted."""
    import numpy

    wanted = _array_fields(kind)
    if not wanted:
        return args, values
    names = [one.name for one in fields(kind) if one.init]

    def made(name: str, value: Any) -> Any:
        if name in wanted and isinstance(value, list | tuple | Real):
            with suppress(ValueError):  # rows of different lengths: refused as they are
                return numpy.array(value)
        return value

    named = [*names[: len(args)], *[""] * (len(args) - len(names))]
    return (
        tuple(map(made, named, args)),
        {name: made(name, value) for name, value in values.items()},
    )


def _check_arrays(kind: type, one: object) -> None:
    for name in _array_fields(kind):
        value = getattr(one, name, None)
        numeric = getattr(getattr(value, "dtype", None), "kind", "O") in "fiub"
        if not (value is None or isinstance(value, Real) or numeric):
            raise OptionError(
                f"{kind.__name__}: {name} is {shown(value)}; give an array of numbers"
            )


@cache  # there are as many as the program has
def _array_fields(kind: type) -> frozenset[str]:
    """Return which fields of a dataclass are arrays, or else numbers or None."""
    others = {"array", float, NoneType}
    return frozenset(
        name for name, (hint, _) in _hints(kind).items() if "array" in _kinds_of(hint) <= others
    )


def _class_of(hint: Any) -> Any:
    """Return the class that an annotation names; to NumPy 2.5 an array is an alias of one."""
    kind = get_origin(hint) or hint
    meant = getattr(kind, "__value__", kind)
    return get_origin(meant) or meant


def _kinds_of(hint: Any) -> set[Any]:
    kind = _class_of(hint)
    if kind in (Union, UnionType):
        return {one for part in get_args(hint) for one in _kinds_of(part)}
    return {"array" if getattr(kind, "__module__", "") == "numpy" else kind}


_PLAIN = frozenset((float, int, bool, str, NoneType))


def plain(value: Any) -> Any:
    """Return a value with Python's numbers and lists for NumPy's, in tuples and tables too.

    Fractions become numbers with a point, as all that follows computes with.
    """
    if type(value) in _PLAIN:  # as nearly all are
        return value
    numpy = sys.modules.get("numpy")  # which `gaitopt --help` does without
    if numpy is not None and isinstance(value, numpy.generic | numpy.ndarray):
        value = value.tolist()
    elif type(value) in (list, tuple):
        return type(value)(plain(one) for one in value)
    elif type(value) is dict:
        return {name: plain(one) for name, one in value.items()}
    if isinstance(value, Real) and not isinstance(value, int | float):
        with suppress(OverflowError):  # beyond every float: refused as it is
            return float(value)
    return value


def _check_names(
    kind: type, made: Any, args: Any, values: Mapping[str, Any], elsewhere: Callable[[str], str]
) -> None:
    names = [one.name for one in fields(kind) if one.init]
    for name in values:
        if name not in names:
            hint = elsewhere(name) or did_you_mean(name, names)
            raise OptionError(
                f"{kind.__name__} has no option {name}; {hint}its options are {', '.join(names)}"
            )
    try:
        inspect.signature(made).bind(None, *args, **values)
    except TypeError as error:
        how = f"; give {_EXAMPLES[kind.__name__]}" if kind.__name__ in _EXAMPLES else ""
        raise OptionError(
            f"{kind.__name__}: {error}; its options are {', '.join(names)}{how}"
        ) from None


def checked_arguments(function: Function) -> Function:
    """Let a public function refuse arguments of another kind, or of no name, in words; return it.

    The error is an `OptionError`, a TypeError too.
    """
    signature, of = inspect.signature(function), function.__qualname__.removesuffix(".__init__")

    @wraps(function)
    def call(*args: Any, **values: Any) -> Any:
        try:
            given = signature.bind(*args, **values).arguments
        except TypeError as error:
            names = [name for name in signature.parameters if name not in ("self", "cls")]
            wrong = next((name for name in values if name not in names), None)
            hint = did_you_mean(wrong, names) if wrong else ""
            raise OptionError(
                f"{of}: {error}; {hint}its arguments are {', '.join(names)}"
            ) from None
        _refuse_kinds(of, _argument_kinds(function), given)
        return function(*args, **values)

    return cast("Function", call)


def _check_kinds(kind: type, one: object) -> None:
    hints = _hints(kind)
    _refuse_kinds(kind.__name__, hints, {name: getattr(one, name, None) for name in hints})


def _refuse_kinds(of: str, hints: Mapping[str, _Hint], values: Mapping[str, object]) -> None:
    for name, (hint, kinds) in hints.items():
        if name not in values or type(value := values[name]) in kinds:  # as nearly all are
            continue
        if not (_fits(value, hint) or _fits(plain(value), hint)):
            once = ", as list(...) makes it" if isinstance(value, Iterator) else ""
            raise OptionError(f"{of}: {name} is {shown(value)}; give {_said(hint)}{once}")


_Hint = tuple[Any, tuple[Any, ...]]
"""An annotation, and the classes that it names."""


def _hint(annotation: Any) -> _Hint:
    several = get_origin(annotation) in (Union, UnionType)
    parts = get_args(annotation) if several else (annotation,)
    kinds = map(_class_of, parts)
    arrays = (kind for kind in kinds if getattr(kind, "__module__", "") == "numpy")
    return annotation, (*parts, *arrays)


@cache  # there are as many as the program has
def _hints(kind: type) -> dict[str, _Hint]:
    """Return of which kinds the values of fields may be, but for those that type checkers know."""
    hints = dict[str, Any]()
    for one in fields(kind):
        home = next(base for base in kind.__mro__ if one.name in inspect.get_annotations(base))
        with suppress(NameError):
            hints |= get_type_hints(
                SimpleNamespace(__annotations__={one.name: one.type}),
                vars(sys.modules[home.__module__]),
            )
    return {name: _hint(one) for name, one in hints.items()}


@cache  # there are as many as the program has
def _argument_kinds(function: Callable[..., Any]) -> dict[str, _Hint]:
    """Return the same of arguments, but for kinds that type checkers alone know."""
    hints = dict[str, Any]()
    for name, one in inspect.signature(function).parameters.items():
        if one.annotation is not one.empty and one.kind is not one.VAR_KEYWORD:
            with suppress(NameError):
                hints |= get_type_hints(
                    SimpleNamespace(__annotations__={name: one.annotation}), function.__globals__
                )
    return {name: _hint(one) for name, one in hints.items()}


_SAID: dict[Any, tuple[str, str]] = {
    float: ("a number", "numbers"), int: ("a whole number", "whole numbers"),
    bool: ("True or False", ""), str: ("a text", "texts"), NoneType: ("None", ""),
    tuple: ("a tuple or a list", ""), Mapping: ("a table by name", ""), Path: ("a path", "paths"),
    PathLike: ("a path", "paths"), Callable: ("a function", "functions"),
    Sequence: ("a list", "lists"), Iterable: ("a list", "lists"), Collection: ("a list", "lists"),
}  # fmt: skip
"""What a value of a kind is called, and several of them in a list; empty for what says enough."""
_EXAMPLES = {
    "Robot": "a Robot, as Robot.from_urdf('robot.urdf')",
    "Task": "a Task, as preset_task('humanoid', robot)",
    "Gait": "a Gait: load_gait('walk.npz'), or .gait of a Design",
    "Transition": "a Transition: load_transition('start.npz'), or .transition of its design",
    "BipedSpec": "a BipedSpec, as biped13()",
    "WalkProblem": "a WalkProblem, as WalkProblem(robot, task)",
    "DesignOptions": "DesignOptions(...)",
    "ImportOptions": "ImportOptions(...), or choices_from_toml('choices.toml')",
    "MotorTable": "a MotorTable, as read_motors('motors.toml')",
    "Trajectory": "a Trajectory: .trajectory of a Gait",
    "ContactMode": "an instance of a ContactMode, as FlatFoot()",
    "ndarray": "an array of numbers",
    "slice": "a slice, as slice(2, 3) of one entry",
}
"""How to come by what a class of gaitopt holds."""
_LISTS = (tuple, Sequence, Iterable, Collection)


def _said(hint: Any) -> str:
    kind, parts = _class_of(hint), get_args(hint)
    if kind in (Union, UnionType):
        return " or ".join(dict.fromkeys(map(_said, parts)))
    if kind not in _SAID:
        name: str = kind.__name__
        return _EXAMPLES.get(name, name)
    several = _several(parts[0]) if kind in _LISTS and parts else ""
    return f"{_SAID[kind][0]}{several and ' of '}{several}"


def _several(hint: Any) -> str:
    if get_origin(hint) in (Union, UnionType):
        return " or ".join(map(_several, get_args(hint)))
    name: str = getattr(hint, "__name__", "")
    return _SAID.get(hint, ("", name))[1]


def _fits(value: Any, hint: Any) -> bool:
    """Return whether a value is of a kind; of one that nobody can tell anything is."""
    if type(value) is hint:  # as nearly all are
        return True
    kind, parts = _class_of(hint), get_args(hint)
    if kind in (Union, UnionType):
        return any(_fits(value, part) for part in parts)
    if not isinstance(kind, type) or kind in (object, Any):
        return True
    if kind.__module__ == "numpy":
        return isinstance(value, list | tuple | Real) or hasattr(value, "__array__")
    if getattr(kind, "_is_protocol", False) and not getattr(kind, "_is_runtime_protocol", False):
        return True
    if kind in (float, int):
        number = Real if kind is float else Integral
        return isinstance(value, number) and not isinstance(value, bool)
    if isinstance(value, str | bytes) and kind in _LISTS:
        return False
    accepted: dict[Any, Any] = {tuple: (tuple, list), Path: PathLike}
    if not isinstance(value, accepted.get(kind, kind)):
        return False
    if kind is tuple and parts and parts[-1] is not ...:
        return len(value) == len(parts) and all(map(_fits, value, parts))
    if kind in _LISTS and parts and isinstance(value, Collection):
        return all(_fits(one, parts[0]) for one in value)
    return kind is not Mapping or all(_fits(one, parts[1]) for one in value.values() if parts)
