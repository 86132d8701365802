"""A gait between those of a library."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from gaitopt.dataclass import dataclass
from gaitopt.design.certificate import WorstRow, on_fine_grid, worst_between
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import Design
from gaitopt.errors import EvaluationError, InputError, did_you_mean
from gaitopt.gait.plugin import Extension
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import task_from_record
from gaitopt.importers.report import findings_of
from gaitopt.nlp import Array
from gaitopt.settings import checked_arguments
from gaitopt.sweep.continuation import WarmStart, finish
from gaitopt.sweep.database import robot_source_of
from gaitopt.sweep.grid import Index, Scenario, interpolated
from gaitopt.sweep.library import Library
from gaitopt.sweep.scheduler import robot_at
from gaitopt.tolerances import LIMITS


@dataclass(frozen=True)
class Between:
    """A gait between those of a library.

    Attributes:
        design: the gait, designed from the interpolated parameters and certified.
        plain: the row that the plain interpolation of the parameters exceeds most, on the fine
            grid; None where it makes no walk at all.
        sources: names of the points between which.
    """

    design: Design
    plain: WorstRow | None
    sources: tuple[str, ...]

    @property
    def sentence(self) -> str:
        """What interpolation alone would have done."""
        plain = "plain interpolation of the parameters"
        if len(self.sources) == 1:
            plain = "the stored gait"  # nothing to interpolate
        if self.plain is None:
            return f"{plain} makes no walk"
        if self.plain.violation <= LIMITS:
            return f"{plain} keeps every limit"
        return f"{plain} violates {self.plain.sentence}"


def stored_point(library: Library, values: Mapping[str, float]) -> Index | None:
    """Return the point of a library that lies exactly at values of its quantities, if any.

    Raises:
        InputError: a quantity is missing or unknown, or a value outside the library.
    """
    corners = _corners(library, values)
    return corners[0] if len(corners) == 1 else None


@checked_arguments
def interpolate(
    library: Library,
    values: Mapping[str, float],
    options: DesignOptions | None = None,
    known: Iterable[Extension] = (),
) -> Between:
    """Return the gait at values of the swept quantities that lie between points of a library.

    Args:
        values: of all its quantities.
        known: constraints and costs of the library that are not gaitopt's own, as
            `load_plugin("mine.py").extensions`.

    Raises:
        InputError: a quantity is missing or unknown, or a value outside the library.
        GaitFileError: a gait around the place is missing.
        NoGaitFoundError: there is none at the place.
    """
    options = options or DesignOptions()
    corners = _corners(library, values)
    scenario, x = _mixed(library, corners, values, tuple(known))
    plain = _worst(scenario, x)

    def away(point: Index) -> float:
        there = library.grid.values(point)
        return sum(abs(there[name] - v) / (abs(v) or 1.0) for name, v in values.items())

    kept = library.states[min(corners, key=away)].walk
    active = () if kept is None else kept.active
    walk = WarmStart(x, 0.0, active, (), 0, 0, 0, 0.0, "interpolation")
    found = finish(scenario, walk, options)
    if found is None:
        found = design(scenario.robot.build(), scenario.task, options, start=x)
    return Between(found, plain, tuple(map(library.grid.name, corners)))


def _corners(library: Library, values: Mapping[str, float]) -> list[Index]:
    """Return the points of the cell around a place, less those that do not matter."""
    names = [axis.name for axis in library.grid.axes]
    for name in [*(n for n in values if n not in names), *(n for n in names if n not in values)]:
        known = name in names
        what, meant = (
            ("needs a value of", "") if known else ("is not over", did_you_mean(name, names))
        )
        raise InputError(
            f"the library {what} '{name}'; {meant}give a value of each of {', '.join(names)}, and "
            "of nothing else"
        )
    corners: list[Index] = [()]
    for axis in library.grid.axes:
        value, grid = values[axis.name], axis.values
        if not grid[0] <= value <= grid[-1]:
            raise InputError(
                f"{axis.name} {value:g} is outside the library, which holds {grid[0]:g} to "
                f"{grid[-1]:g}"
            )
        low = max(i for i, known in enumerate(grid) if known <= value)
        sides = [low] if grid[low] == value else [low, low + 1]
        corners = [(*corner, i) for corner in corners for i in sides]
    return corners


def _mixed(
    library: Library,
    corners: list[Index],
    values: Mapping[str, float],
    known: tuple[Extension, ...],
) -> tuple[Scenario, Array]:
    """Interpolate linearly along one quantity after another."""
    robot = robot_source_of(library.directory, library.record)
    mixed: dict[Index, tuple[Scenario, Array]] = {}
    for corner in corners:
        gait = library.gait(corner)
        task = task_from_record(gait.fact("task"), known)
        told = replace(robot, findings=findings_of(gait.fact("findings")))
        place = Scenario(robot_at(told, library.grid, corner), task)
        mixed[corner] = place, gait.parameters
    for axis in library.grid.axes:
        rest: dict[Index, list[tuple[int, tuple[Scenario, Array]]]] = {}
        for corner, entry in mixed.items():
            rest.setdefault(corner[1:], []).append((corner[0], entry))
        mixed = {key: _along(axis.values, pair, values[axis.name]) for key, pair in rest.items()}
    return mixed[()]


def _along(
    grid: tuple[float, ...], pair: list[tuple[int, tuple[Scenario, Array]]], value: float
) -> tuple[Scenario, Array]:
    (i, (first, x)), (j, (last, y)) = pair[0], pair[-1]
    share = 0.0 if i == j else (value - grid[i]) / (grid[j] - grid[i])
    return interpolated(first, last, share), x + share * (y - x)


def _worst(scenario: Scenario, x: Array) -> WorstRow | None:
    problem = WalkProblem(scenario.robot.build(), scenario.task)
    try:
        rows = worst_between(on_fine_grid(problem), x)
    except EvaluationError:
        return None
    return max(rows, key=lambda row: row.violation)
