"""Options of the commands, made from declared settings; the help says their defaults."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from copy import copy
from functools import partial
from pkgutil import resolve_name
from typing import Annotated, Any

import typer
import typer.main
from typer.core import TyperCommand, TyperGroup, TyperOption

from gaitopt.cli.process import errors_reported
from gaitopt.errors import InputError
from gaitopt.settings import FILE, FILES, FLAG, INTEGER, TABLE, TEXTS, Setting, declared

CONTEXT = {"help_option_names": ["-h", "--help"]}
NO_VALUE = ""
"""Stands in the help for the value of a flag, which takes none; Typer would write <bool>."""

_WHOSE = (
    "Defaults are those of the thirteen-link biped. For other robots speed, duration, load, step "
    "width, limits of the trunk and gaps of short legs follow from the robot or the catalogue "
    "(preset 'humanoid')."
)


def _parameter(setting: Setting, panel: str, own: bool) -> inspect.Parameter:
    """Return the parameter of a command that takes a setting.

    Args:
        panel: heading over it in the help.
        own: whether it is one of the command's own, of which flags have their defaults; others are
            None or empty where they are not given, so that a file may say something else.
    """
    said = f"{setting.help}{' Repeatable.' if setting.repeatable and not setting.argument else ''}"
    how: dict[str, Any] = {
        "help": said,
        "metavar": _metavar(setting),
        "show_default": own and setting.default is True,
        "rich_help_panel": setting.panel or panel or None,
    }
    names: list[str] = [setting.option]
    default: Any = None
    kind: Any = None
    if setting.kind == FLAG:
        default, kind = (setting.default, bool) if own else (None, bool | None)
        if default is not False or setting.negatable:
            names = [f"{setting.option}/--no-{setting.option[2:]}"]
    else:
        how["parser"] = _reader(setting)
        kind = list[str] if setting.repeatable else str
        required = own and setting.required
        default = inspect.Parameter.empty if required else None
        kind = kind if required else kind | None
    names += [setting.short] if setting.short else []
    info = typer.Argument(**how) if setting.argument else typer.Option(*names, **how)
    return inspect.Parameter(
        setting.name, inspect.Parameter.KEYWORD_ONLY, default=default,
        annotation=Annotated[kind, info],
    )  # fmt: skip


def _metavar(setting: Setting) -> str:
    plain = {
        FLAG: NO_VALUE, INTEGER: "N", FILE: "FILE", FILES: "DIR", TABLE: "NAME=VALUE",
    }  # fmt: skip
    return (setting.metavar or setting.unit or plain.get(setting.kind, "X")).upper()


def _reader(setting: Setting) -> Callable[[Any], Any]:
    def read(value: Any) -> Any:
        if setting.kind == TABLE or not isinstance(value, str):  # a default is read already
            return value
        try:
            return setting.read(value)
        except ValueError as error:
            raise typer.BadParameter(f"{value[:60]!r} is wrong; {error}") from error

    return read


Panels = Mapping[str, Iterable[Setting]]
"""Settings that a command takes, by the heading under which the help shows them."""


def command(
    app: typer.Typer,
    name: str,
    kind: type,
    panels: Callable[[Sequence[str]], Panels] | None = None,
    *,
    work: str = "",
    aliases: tuple[str, ...] = (),
) -> None:
    """Add a command to an application.

    Options are made when the command is asked for, and its work is imported when it is run, so that
    every other one starts at once; errors become a message and an exit code.

    Args:
        app: the application.
        name: of the command.
        kind: dataclass of its own options, whose docstring is its help.
        panels: returns the settings of the configuration that it takes, from the words given to it.
        work: what runs it, "MODULE:FUNCTION" of `gaitopt.cli`, by default `run` of its own module.
            It is given the values of settings by name, if there are any, and the options.
        aliases: hidden names of the command.
    """

    def complete(words: Sequence[str]) -> Any:
        if panels is None:
            return _complete(name, kind, work, None)
        with errors_reported(robots=False):
            return _complete(name, kind, work, panels(words))

    late = type("LateCommand", (_LateCommand,), {"complete": staticmethod(complete)})
    for one in (name, *aliases):
        how: Any = {"cls": late, "help": kind.__doc__, "hidden": one in aliases}
        app.command(one, **how)(lambda: None)


class _LateCommand(TyperCommand):
    """Stands for a command until it is asked for."""

    complete: Callable[[Sequence[str]], Any]

    def make_context(
        self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any
    ) -> Any:
        """Return the context of the command with its options."""
        return self.complete(args).make_context(info_name, args, parent, **extra)


def _complete(name: str, kind: type, work: str, panels: Panels | None) -> Any:
    """Return the command line of a command."""
    own = list(declared(kind))
    taken = [(one, heading) for heading, panel in (panels or {}).items() for one in panel]
    settings = {one.name: one for one, _ in taken}
    parameters = [_parameter(one, panel, own=False) for one, panel in taken]
    parameters += [_parameter(one, "", own=True) for one in own]
    parameters += [] if panels is None else [_HELP_ALL]
    known = {**settings, **{one.name: one for one in own}}

    def call(**values: Any) -> None:
        with errors_reported():
            given = {n: v for n, v in values.items() if v not in (None, [], ())}
            _keep_inputs(known.values(), given)
            before = () if panels is None else (_read(settings.values(), given),)
            run = resolve_name(f"gaitopt.cli.{work or f'{name}:run'}")
            run(*before, kind(**_read(own, given)))

    call.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    call.__annotations__ = {p.name: p.annotation for p in parameters}
    call.__doc__ = kind.__doc__
    alone = typer.Typer(
        add_completion=False, pretty_exceptions_enable=False, rich_markup_mode="rich"
    )
    alone.command(name, cls=_Command, context_settings=CONTEXT)(call)
    command: Any = typer.main.get_command(alone)
    command.settings, command.known = settings, known
    for option in command.params:
        if option.name in known:
            option.process_value = partial(_value_of, option, _reader(known[option.name]))
    return command


def _value_of(option: Any, read: Callable[[Any], Any], context: Any, value: Any) -> Any:
    """Return the value of an option from what was typed, as the option's own method would.

    That one makes a validator of Pydantic for every option, given or not: a tenth of the time of
    a whole `gaitopt optimise` (measured). Here texts are read by their settings.
    """
    if option.required and value in (None, (), []):
        return type(option).process_value(option, context, value)  # which says what is missing
    if isinstance(value, list | tuple):
        return [read(one) for one in value]
    return read(value)


def _read(settings: Iterable[Setting], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of those settings that were given."""
    read: dict[str, Any] = {}
    for one in settings:
        if one.name in given:
            value = given[one.name]
            if one.kind == TABLE:
                value = one.read_pairs(value)
            read[one.name] = tuple(value) if one.kind in (TEXTS, FILES) else value
    return read


def _keep_inputs(known: Iterable[Setting], given: Mapping[str, Any]) -> None:
    """Refuse to write a file that is read: what was asked could not be asked again."""
    files = [one for one in known if one.kind in (FILE, FILES) and one.name in given]
    read = [
        (one, path)
        for one in files
        if not one.written
        for path in (given[one.name] if one.repeatable else [given[one.name]])
    ]
    for target in (one for one in files if one.written):
        path = given[target.name]
        for source, other in read:
            with suppress(OSError, ValueError):  # told where it is read or written
                if path.samefile(other):
                    of = (
                        f"the {source.name} itself"
                        if source.argument
                        else f"that of {source.option}"
                    )
                    raise InputError(
                        f"{target.option} {path}: it is {of}, which is kept as it is; give another "
                        "name to write"
                    )


class _QuickHelp:
    """Mixed into commands: help that was not asked for loads no Pydantic, slower than NumPy."""

    def get_help_option(self, ctx: Any) -> Any:
        """Return the option, with a quicker way where it was not given."""
        option: Any = super().get_help_option(ctx)  # type: ignore[misc]
        if option is not None:
            option.metavar = NO_VALUE
            option.process_value = partial(_value_if_given, option)
        return option


def _value_if_given(option: Any, context: Any, value: Any) -> Any:
    return value and type(option).process_value(option, context, value)


class Group(_QuickHelp, TyperGroup):
    """The application before a command is asked for."""


def _say_whose(ctx: Any, option: str, error: Any) -> None:
    """Add to the message on an unknown option which other commands have it."""
    others = getattr(getattr(ctx.parent, "command", None), "commands", {})
    having = [
        name
        for name, late in others.items()
        if not late.hidden and any(option in one.opts for one in late.complete([]).params)
    ]
    if having:
        error.message += f", which is one of gaitopt {', '.join(having)}"
        error.possibilities = None  # what looks alike in this command is not what was meant


_NAMED_BY = {
    "urdf": r".*\.(urdf|xacro|xml|mjcf)", "config": r".*\.toml", "start": r".*\.npz",
    "robot": r"[a-z_][\w:-]*",
}  # fmt: skip
"""Options whose values people type without them, by what such values look like."""


class _Command(_QuickHelp, TyperCommand):
    """A command whose help says what holds where an option is not given.

    `--help` shows the usual ones of the configuration, `--help-all` every one.

    Attributes:
        known: settings that its options stand for, by name.
        settings: of the configuration among them, by name.
    """

    known: Mapping[str, Setting]
    settings: Mapping[str, Setting]

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Show the help of a copy of the command with defaults and allowed names."""
        command = copy(self)
        command.params = [self._shown(one, ctx.meta.get(_ALL, False)) for one in self.params]
        hidden = sum(one.hidden for one in command.params if isinstance(one, TyperOption))
        said = [_WHOSE] if "speed" in self.settings else []
        if hidden:
            said.append(f"There are {hidden} more options: {ctx.command_path} --help-all.")
        command.epilog = " ".join(said)
        super(_Command, command).format_help(ctx, formatter)

    def _shown(self, option: Any, every: bool) -> Any:
        """Return an option as the help shows it."""
        setting = self.known.get(option.name)
        if setting is None:
            return option
        changed, flag = copy(option), setting.kind == FLAG
        if option.name in self.settings:
            changed.hidden = not (every or setting.common)
            if setting.names:
                changed.help = f"{option.help} One of {', '.join(setting.names)}."
        elif flag:
            return option
        if setting.default not in ((None,) if flag else (None, (), {})):
            changed.default, changed.show_default = setting.default, True
        return changed

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the words, and name the option of a robot, or of a file, that was left out."""
        ctx.allow_extra_args = True
        try:
            rest: list[str] = super().parse_args(ctx, args)
        except Exception as error:
            wrong: Any = error
            if hasattr(error, "possibilities"):  # an unknown option, not one without its value
                _say_whose(ctx, wrong.option_name, error)
            raise
        if rest and not ctx.resilient_parsing:
            words, known = " ".join(rest), {one.name for one in self.params}
            looks = partial(re.fullmatch, string=rest[0], flags=re.IGNORECASE)
            option = next((o for o, form in _NAMED_BY.items() if o in known and looks(form)), None)
            meant = "" if option is None else f"; did you mean --{option} {rest[0]}?"
            ctx.fail(f"Got unexpected extra argument(s) ({words}){meant}")
        return rest


def _show_all(ctx: typer.Context, wanted: bool) -> None:
    if wanted:
        ctx.meta[_ALL] = True
        typer.echo(ctx.get_help())
        raise typer.Exit


_ALL = "gaitopt.help_all"
_HELP_ALL = inspect.Parameter(
    "help_all", inspect.Parameter.KEYWORD_ONLY, default=False,
    annotation=Annotated[
        bool,
        typer.Option(
            "--help-all", help="Show every option.", is_eager=True,
            callback=_show_all, show_default=False, metavar=NO_VALUE,
        ),
    ],
)  # fmt: skip
