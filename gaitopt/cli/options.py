"""Options of the commands, made from declared settings; the help says their defaults."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from copy import copy
from typing import Annotated, Any

import typer
import typer.main
from typer.core import TyperCommand

from gaitopt.cli.process import errors_reported
from gaitopt.settings import FLAG, TABLE, Setting, declared

CONTEXT = {"help_option_names": ["-h", "--help"]}

_WHOSE = (
    "Defaults are those of the thirteen-link biped. For other robots speed, duration, load, step "
    "width and limits of the trunk follow from the robot or the catalogue (preset 'humanoid')."
)


def option(setting: Setting, panel: str) -> inspect.Parameter:
    """Return the parameter of a command that takes a setting; None or empty where it is not given.

    Args:
        setting: what it sets.
        panel: heading under which the help shows it.
    """
    said = f"{setting.help}{' Repeatable.' if setting.repeatable else ''}"
    how: dict[str, Any] = {"help": said, "rich_help_panel": panel, "show_default": False}
    kind: Any = bool | None
    if setting.kind == FLAG:
        names = f"{setting.option}/--no-{setting.option[2:]}"
    else:
        names, kind = setting.option, list[str] | None if setting.repeatable else str | None
        how |= {"metavar": _metavar(setting), "parser": _reader(setting)}
    return inspect.Parameter(
        setting.name, inspect.Parameter.KEYWORD_ONLY, default=None,
        annotation=Annotated[kind, typer.Option(names, **how)],
    )  # fmt: skip


def _metavar(setting: Setting) -> str:
    plain = {"integer": "N", "file": "FILE", "files": "DIR", TABLE: "NAME=VALUE"}
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


def given(ctx: typer.Context, names: Iterable[str]) -> dict[str, object]:
    """Return the options that were given; a repeatable one that is absent is an empty list."""
    return {name: ctx.params[name] for name in names if ctx.params[name] not in (None, [], ())}


class CommandWithDefaults(TyperCommand):
    """A command whose options all default to "not given"; its help says what then holds."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Show the help of a copy of the command with defaults and allowed names."""
        command = copy(self)
        command.epilog = _WHOSE
        settings = settings_by_name()
        command.params = [_shown(one, settings.get(one.name or "")) for one in self.params]
        TyperCommand.format_help(command, ctx, formatter)


def settings_by_name() -> dict[str, Setting]:
    """Return every setting of `gaitopt optimise` and `gaitopt sweep` by its name."""
    from gaitopt.cli.config import SCHEMA
    from gaitopt.cli.sweep_options import SweepSettings

    sections = (*SCHEMA.values(), {one.name: one for one in declared(SweepSettings)})
    return {name: one for section in sections for name, one in section.items()}


def _shown(option: Any, setting: Setting | None) -> Any:
    """Return an option as the help shows it."""
    if setting is None:
        return option
    changed = copy(option)
    if setting.default not in (None, (), {}):
        changed.default, changed.show_default = setting.default, True
    if setting.names:
        changed.help = f"{option.help} One of {', '.join(setting.names)}."
    return changed


Options = Callable[[], Iterable[inspect.Parameter]]
"""Returns options of a command, beside those of its function's signature."""


def command(app: typer.Typer, options: Options = tuple, *aliases: str) -> Callable[[Any], Any]:
    """Return the decorator that makes a function a command of an application.

    Its options are made when the command is asked for, so that every other one starts at once; its
    errors become a message and an exit code.

    Args:
        app: the application.
        options: that the function takes by name, beside those of its signature.
        aliases: hidden names of the command.
    """

    def register(function: Callable[..., None]) -> Callable[..., None]:
        attributes = {"function": staticmethod(function), "more": staticmethod(options)}
        kind = type("LateCommand", (_LateCommand,), attributes)
        for name in (function.__name__, *aliases):
            how: Any = {"cls": kind, "help": function.__doc__, "hidden": name in aliases}
            app.command(name, **how)(lambda: None)
        return function

    return register


class _LateCommand(TyperCommand):
    """Stands for a command until it is asked for."""

    function: Callable[..., None]
    more: Options

    def make_context(
        self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any
    ) -> Any:
        """Return the context of the command with its options."""
        made = _complete(self.function, tuple(self.more()), str(self.name))
        return made.make_context(info_name, args, parent, **extra)


def _complete(function: Callable[..., None], more: tuple[inspect.Parameter, ...], name: str) -> Any:
    """Return the command line of a function, with more options than its signature has."""
    own = inspect.signature(function, eval_str=True).parameters.values()
    rest = [p for p in own if p.kind is not inspect.Parameter.VAR_KEYWORD]
    first = [rest.pop(0)] if rest and rest[0].annotation is typer.Context else []
    kind = inspect.Parameter.KEYWORD_ONLY
    parameters = [p.replace(kind=kind) for p in (*first, *more, *rest)]

    def call(**values: Any) -> None:
        with errors_reported():
            function(**values)

    call.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    call.__annotations__ = {p.name: p.annotation for p in parameters}
    call.__doc__ = function.__doc__
    alone = typer.Typer(
        add_completion=False, pretty_exceptions_enable=False, rich_markup_mode="rich"
    )
    kind_of_help = CommandWithDefaults if more else TyperCommand
    alone.command(name, cls=kind_of_help, context_settings=CONTEXT)(call)
    return typer.main.get_command(alone)
