"""The options of `gaitopt sweep`, which takes those of `optimise` too, and of `gaitopt library`."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from gaitopt.cli.options import option, output_directory

_SWEEP = "Sweep"
_NOT_OURS = ("page", "figures", "starts", "start", "seed", "sigma", "output", "fastest")


Speeds = Annotated[
    str | None,
    option("--speeds", "Walking speeds, FIRST:LAST:STEP or a list A,B,C.", _SWEEP, "M/S"),
]
Grid = Annotated[
    list[str] | None,
    option(
        "--grid",
        "Another quantity of task, limits, double support or specification, as "
        "duration=0.3:0.6:0.05 or geometry.d3=0.28,0.3,0.32; repeatable. trunk_pitch is the limit "
        "of the lean, hold.trunk_pitch the lean at double support.",
        _SWEEP,
        "NAME=RANGE",
    ),
]
Begin = Annotated[
    list[str] | None,
    option(
        "--begin", "Where to begin, by default in the middle; repeatable.", _SWEEP, "NAME=VALUE"
    ),
]
Workers = Annotated[
    int | None, option("--workers", "Processes on this machine (extra 'cluster').", _SWEEP, "N")
]
Scheduler = Annotated[
    str | None, option("--scheduler", "Dask scheduler to use instead.", _SWEEP, "ADDRESS")
]
Directory = Annotated[
    Path,
    output_directory("Directory of the gait library; one that exists goes on.", _SWEEP),
]
LibraryDirectory = Annotated[
    Path, typer.Argument(metavar="DIR", help="A gait library, made by gaitopt sweep.")
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


def sweep_command(optimise: Callable[..., None]) -> Callable[..., None]:
    """Return the command `sweep`, with the options of `optimise` that make sense for many gaits."""

    def sweep(ctx: typer.Context, **_: Any) -> None:
        """Design gaits over speeds and other quantities, each from its neighbour."""
        from gaitopt.cli import sweep as work

        work.run({name: v for name, v in ctx.params.items() if v not in (None, [], ())})

    own = {
        "speeds": (Speeds, None),
        "grid": (Grid, None),
        "begin": (Begin, None),
        "workers": (Workers, None),
        "scheduler": (Scheduler, None),
        "output": (Directory, inspect.Parameter.empty),
    }
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    others = inspect.signature(optimise, eval_str=True).parameters
    taken = [p for name, p in others.items() if name not in (*_NOT_OURS, "ctx")]
    mine = [
        inspect.Parameter(name, kind, default=default, annotation=annotation)
        for name, (annotation, default) in own.items()
    ]
    context = others["ctx"]
    parameters = [context, *mine, *taken]
    signature = inspect.Signature(
        [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters]
    )
    sweep.__signature__ = signature  # type: ignore[attr-defined]
    sweep.__annotations__ = {p.name: p.annotation for p in parameters}
    return sweep
