"""The old name of `gaitopt.sweep`, for programs that were written for version 0.1."""

from __future__ import annotations

import sys
import warnings

from gaitopt.sweep import executor, fastest, grid, interpolate, library, scheduler, table

_MOVED = {
    "axes": grid,
    "cluster": executor,
    "fastest": fastest,
    "grid_points": grid,
    "interpolate": interpolate,
    "jobs": executor,
    "library": library,
    "selection": table,
    "sweep": scheduler,
}

warnings.warn("gaitopt.study is now gaitopt.sweep", DeprecationWarning, stacklevel=2)
for _old, _module in _MOVED.items():
    sys.modules[f"{__name__}.{_old}"] = _module  # `from gaitopt.study.axes import Axis` finds it
