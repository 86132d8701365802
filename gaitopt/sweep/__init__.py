"""Gaits by the hundred: sweeps over speed and other quantities, and the libraries they fill.

Each name is imported when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gaitopt.sweep.executor import joined_scheduler, local_workers
    from gaitopt.sweep.grid import Axis, parse_axis
    from gaitopt.sweep.interpolation import interpolate
    from gaitopt.sweep.library import Library, open_library
    from gaitopt.sweep.scheduler import SweepProgress, sweep
    from gaitopt.sweep.speed_search import Fastest, fastest

_HOMES = {
    "Axis": "grid",
    "Fastest": "speed_search",
    "Library": "library",
    "SweepProgress": "scheduler",
    "fastest": "speed_search",
    "interpolate": "interpolation",
    "joined_scheduler": "executor",
    "local_workers": "executor",
    "open_library": "library",
    "parse_axis": "grid",
    "sweep": "scheduler",
}


def __getattr__(name: str) -> object:
    """Import a public name when it is first used."""
    if name not in _HOMES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    value: object = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


__all__ = [
    "Axis",
    "Fastest",
    "Library",
    "SweepProgress",
    "fastest",
    "interpolate",
    "joined_scheduler",
    "local_workers",
    "open_library",
    "parse_axis",
    "sweep",
]
