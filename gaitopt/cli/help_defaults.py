"""Defaults in the help, read from where they are defined and only when help is asked for."""

from __future__ import annotations

from copy import copy
from dataclasses import fields
from typing import Any

from typer.core import TyperCommand

_WHOSE = (
    "Defaults are those of the thirteen-link biped. For other robots speed, duration, load, step "
    "width and limits of the trunk follow from the robot or the catalogue (preset 'humanoid')."
)


class CommandWithDefaults(TyperCommand):
    """A command whose options all default to "not given"; its help says what then holds."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Show the help of a copy of the command whose options have the method's defaults."""
        shown = defaults()
        command = copy(self)
        command.epilog = _WHOSE
        command.params = [_with_default(option, shown) for option in self.params]
        TyperCommand.format_help(command, ctx, formatter)


def defaults() -> dict[str, object]:
    """Return the default of each option of `gaitopt optimise` that has one."""
    from gaitopt.cli.config import SCHEMA
    from gaitopt.design.options import DesignOptions
    from gaitopt.design.starts import COUNT, SIGMA
    from gaitopt.gait.task import PRESETS, Task
    from gaitopt.solvers.sqp import SQP

    task, sqp, options = Task(), SQP(), DesignOptions()
    values: dict[str, object] = {f.name: getattr(task, f.name) for f in fields(task)}
    values |= {f.name: getattr(task.margins, f.name) for f in fields(task.margins)}
    values |= {f.name: getattr(options, f.name) for f in fields(options)}
    values |= {
        "preset": PRESETS[0],
        "solver": "default",
        "qp_solver": sqp.qp_solver,
        "tolerance": sqp.tolerance,
        "max_iterations": sqp.max_iterations,
        "starts": COUNT,
        "sigma": SIGMA,
    }
    known = {name for section in SCHEMA.values() for name in section}
    return {name: v for name, v in values.items() if name in known and v is not None}


def _with_default(option: Any, shown: dict[str, object]) -> Any:
    if option.name not in shown:
        return option
    changed = copy(option)
    changed.default, changed.show_default = shown[option.name], True
    return changed
