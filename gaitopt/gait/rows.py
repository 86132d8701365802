"""How families of rows are put together: over the step, per joint, on the ground, once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitopt.gait.families import Entries, Family, RowMap
from gaitopt.gait.grid import Grid
from gaitopt.gait.step import Reads
from gaitopt.gait.task import Margins, Task
from gaitopt.nlp import Array
from gaitopt.robot.model import Robot

FORCE_SCALE = 500.0  # N
MOMENT_SCALE = 100.0  # N.m
IMPULSE_SCALE = 50.0  # N.s
IMPULSE_MOMENT_SCALE = 5.0  # N.m.s
LENGTH_SCALE = 0.1  # m
FORCE_SMOOTHING = 0.05  # N, rounds the tip of the friction cone
IMPULSE_SMOOTHING = 10**-4.5  # N.s

FREE = np.inf
EDGES = ("front", "rear", "left", "right")


@dataclass(frozen=True)
class Setting:
    """What a constraint is made from."""

    robot: Robot
    task: Task
    grid: Grid

    @property
    def margins(self) -> Margins:
        """The task's margins."""
        return self.task.margins


def size(limits: Array) -> Array:
    """Return the limits as scales of their rows; a row without a limit may have any scale."""
    return np.where(np.isfinite(limits), limits, 1.0)


def edge_moments(at: Setting) -> Array:
    """Rows that are >= 0 while the centre of pressure (-m_y/f_z, m_x/f_z) is inside the margins."""
    sole, margin = at.robot.sole, at.margins.cop_margin
    rows = np.zeros((4, 6))
    rows[0, [2, 4]] = sole.toe - margin, 1.0
    rows[1, [2, 4]] = -sole.heel - margin, -1.0
    rows[2, [2, 3]] = sole.left - margin, -1.0
    rows[3, [2, 3]] = -sole.right - margin, 1.0
    return rows


def family_over_step(
    at: Setting,
    name: str,
    equation: str,
    reads: Reads,
    rows: RowMap,
    labels: tuple[str, ...],
    unit: str,
    *,
    lower: Array | float = -FREE,
    upper: Array | float = FREE,
    scale: Array | float,
    instants: NDArray[np.int_] | None = None,
) -> Family:
    """A family over the instants of the step."""
    if instants is None:
        instants = np.arange(at.grid.count)
    shape = (instants.size, len(labels))
    return Family(
        name=name,
        equation=equation,
        reads=reads,
        rows=rows,
        labels=labels,
        unit=unit,
        lower=np.broadcast_to(lower, shape).copy(),
        upper=np.broadcast_to(upper, shape).copy(),
        scale=np.broadcast_to(scale, shape[1:]).copy(),
        instants=instants,
        times=at.grid.instants[instants],
    )


def joint_rows(
    at: Setting, name: str, equation: str, reads: Reads, unit: str,
    lower: Array, upper: Array, scale: Array,
) -> Family:  # fmt: skip
    """A family with one row per joint and instant."""
    labels = tuple(f"{joint} {name}" for joint in at.robot.joint_names)
    every = Entries(slice(0, len(labels)), len(labels))
    return family_over_step(
        at, name, equation, reads, every, labels, unit,
        lower=lower, upper=upper, scale=scale,
    )  # fmt: skip


def ground_rows(
    at: Setting, name: str, equation: str, rows: RowMap, labels: tuple[str, ...],
    lower: float, scale: float, unit: str = "N",
) -> Family:  # fmt: skip
    """A family on the ground wrench at every instant."""
    return family_over_step(
        at, name, equation, Reads.WRENCH, rows, labels, unit, lower=lower, scale=scale
    )


def rows_once(
    name: str, equation: str, reads: Reads, rows: RowMap, labels: tuple[str, ...], unit: str,
    lower: float, scale: float, upper: float = FREE,
) -> Family:  # fmt: skip
    """A family that is looked at once in a step."""
    shape = (1, len(labels))
    return Family(
        name=name, equation=equation, reads=reads, rows=rows, labels=labels, unit=unit,
        lower=np.full(shape, lower), upper=np.full(shape, upper),
        scale=np.full(len(labels), scale), instants=np.arange(1), times=None,
    )  # fmt: skip
