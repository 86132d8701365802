"""What is made of a robot once and used by every walk of it.

Making one of Pinocchio's workspaces takes as long as forty evaluations of the torques in it, and
the solution of one walk takes a dozen grids. What is kept here is scratch: results are copied out
of it before anyone else works there. Every thread has its own, so ask for it where you use it.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import lru_cache
from typing import TypeVar, cast

from gaitopt.model.robot import Robot

_ROBOTS = 8  # in as many threads, of which things are kept

T = TypeVar("T")


def cached_workspace(robot: Robot, make: Callable[[Robot], T]) -> T:
    """Return what a function makes of a robot, the same object at every call."""
    made = _made(robot, threading.get_ident())
    if make not in made:
        made[make] = make(robot)
    return cast(T, made[make])


@lru_cache(maxsize=_ROBOTS)
def _made(robot: Robot, thread: int) -> dict[Callable[[Robot], object], object]:
    return {}
