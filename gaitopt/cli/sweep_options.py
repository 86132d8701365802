"""The options of `gaitopt sweep` beside those of `optimise`, and their section of a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gaitopt.settings import declared, entry


@dataclass(frozen=True)
class SweepSettings:
    """What is swept over, and who does the work."""

    speeds: str | None = entry(
        None, "Walking speeds, FIRST:LAST:STEP or a list A,B,C.", metavar="M/S", common=True
    )
    grid: tuple[str, ...] = entry(
        (), "Another quantity of task, limits, double support or specification, as "
        "duration=0.3:0.6:0.05 or geometry.d3=0.28,0.3,0.32. trunk_pitch is the limit of the "
        "lean, hold.trunk_pitch the lean at double support.", metavar="NAME=RANGE", common=True,
    )  # fmt: skip
    begin: tuple[str, ...] = entry(
        (), "Where to begin, by default in the middle.", metavar="NAME=VALUE"
    )
    workers: int | None = entry(None, "Processes on this machine (extra 'cluster').", common=True)
    scheduler: str | None = entry(None, "Dask scheduler to use instead.", metavar="ADDRESS")


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
