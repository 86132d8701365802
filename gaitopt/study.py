"""The old name of `gaitopt.sweep`, for programs that were written for version 0.1."""

from __future__ import annotations

import sys
import warnings
from importlib import import_module

_MOVED = {
    "axes": "grid",
    "cluster": "executor",
    "fastest": "speed_search",
    "grid_points": "grid",
    "interpolate": "interpolation",
    "jobs": "executor",
    "library": "library",
    "selection": "table",
    "sweep": "scheduler",
}

warnings.warn("gaitopt.study is now gaitopt.sweep", DeprecationWarning, stacklevel=2)
for _old, _new in _MOVED.items():  # `from gaitopt.study.axes import Axis` finds it there
    sys.modules[f"{__name__}.{_old}"] = import_module(f"gaitopt.sweep.{_new}")
