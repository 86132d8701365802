"""The options of `gaitopt sweep`, which takes those of `optimise` too, and of `gaitopt library`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import typer

from gaitopt.cli.paths import named_directory
from gaitopt.settings import declared, setting

_SWEEP = "Sweep"


@dataclass(frozen=True)
class SweepSettings:
    """What is swept over, and who does the work."""

    speeds: str | None = field(
        default=None,
        metadata=setting(
            "Walking speeds, FIRST:LAST:STEP or a list A,B,C.", metavar="M/S", common=True
        ),
    )
    grid: tuple[str, ...] = field(
        default=(),
        metadata=setting(
            "Another quantity of task, limits, double support or specification, as "
            "duration=0.3:0.6:0.05 or geometry.d3=0.28,0.3,0.32. trunk_pitch is the limit of the "
            "lean, hold.trunk_pitch the lean at double support.", metavar="NAME=RANGE",
            common=True,
        ),
    )  # fmt: skip
    begin: tuple[str, ...] = field(
        default=(),
        metadata=setting("Where to begin, by default in the middle.", metavar="NAME=VALUE"),
    )
    workers: int | None = field(
        default=None,
        metadata=setting("Processes on this machine (extra 'cluster').", common=True),
    )
    scheduler: str | None = field(
        default=None, metadata=setting("Dask scheduler to use instead.", metavar="ADDRESS")
    )


Config = Annotated[
    Path | None,
    typer.Option(
        "--config", help="TOML file with any of these options; the command line wins.",
        rich_help_panel="Method", metavar="FILE",
    ),
]  # fmt: skip
Directory = Annotated[
    Path,
    typer.Option(
        "--output", "-o", help="Directory of the gait library; one that exists goes on.",
        rich_help_panel=_SWEEP, metavar="DIR", parser=named_directory,
    ),
]  # fmt: skip
LibraryDirectories = Annotated[
    list[Path],
    typer.Argument(metavar="DIR", help="A gait library, made by gaitopt sweep, or two to compare."),
]
Where = Annotated[
    list[str] | None,
    typer.Option("--where", help='Only gaits with, as "speed>0.8"; repeatable.', metavar="TEST"),
]
Columns = Annotated[
    str | None,
    typer.Option(
        "--columns",
        help="What to show of the index beside what was swept, as cost,friction_used; 'list' tells "
        "what there is.",
        metavar="NAMES",
    ),
]
Plot = Annotated[
    Path | None,
    typer.Option("--plot", help="Draw cost and peak torques: .png, .svg or .pdf.", metavar="FILE"),
]
At = Annotated[
    list[str] | None,
    typer.Option(
        "--at", help="Design the gait between the stored ones, as speed=0.83.", metavar="NAME=VALUE"
    ),
]
GaitOutput = Annotated[
    Path | None, typer.Option("--output", "-o", help="Where to write that gait.", metavar="FILE")
]

SWEEP = tuple(declared(SweepSettings))
SECTION = "sweep"
"""Of a configuration file; a search for one gait passes over it."""
NOT_OURS = ("starts", "start", "seed", "sigma")
"""Settings of a search for one gait only."""


def as_typed(name: str, value: object) -> object:
    """Return an entry of the section as it would be typed: tables by name, lists with commas.

    speeds = [0.4, 0.6] is --speeds 0.4,0.6; grid = {duration = "0.3:0.5:0.1"} is --grid
    duration=0.3:0.5:0.1; begin = {speed = 0.7} is --begin speed=0.7.
    """
    if name == "speeds":
        return _values(value)
    if name in ("grid", "begin") and isinstance(value, Mapping):
        return [f"{key}={_values(one)}" for key, one in value.items()]
    return value


def _values(value: object) -> object:
    if isinstance(value, list) and value and all(isinstance(one, int | float) for one in value):
        return ",".join(map(str, value))
    return str(value) if isinstance(value, int | float) and not isinstance(value, bool) else value
