"""Gaits by the hundred: explored from neighbour to neighbour, compared, finished, kept.

    explore   from the seeds on, each point from the best of its neighbours nearer to a seed
    compare   where two neighbours are on different branches, each from the other; keep the lower
    finish    limits between the samples, second opinion, certificate: a gait file
    explain   the points that are left

What is done for a point depends only on what is known of its neighbours at a stage, never on who
does it or how fast, so that any number of workers finds the same gaits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from types import NoneType

from gaitopt.design.options import DesignOptions
from gaitopt.errors import InputError
from gaitopt.gait.task import Task
from gaitopt.robot.generated.spec import BipedSpec
from gaitopt.robot.model import Robot
from gaitopt.study.axes import Axis, with_values
from gaitopt.study.grid_points import GridPoints
from gaitopt.study.jobs import Alone, Crew
from gaitopt.study.library import Library, Writer, open_library
from gaitopt.study.manifest import claim, manifest_record
from gaitopt.study.plan import make_plan
from gaitopt.study.stages import Advance, OnAdvance, Stages

__all__ = ["Advance", "OnAdvance", "sweep"]

_KINDS: dict[str, tuple[tuple[type, ...], str]] = {
    "robot": ((Robot,), "a Robot, as Robot.from_urdf(urdf_text(biped13()))"),
    "task": ((Task,), "a Task, as preset_task()"),
    "directory": ((str, Path), "a path"),
    "options": ((DesignOptions,), "DesignOptions"),
    "spec": ((BipedSpec, NoneType), "a BipedSpec, as biped13()"),
    "crew": ((Crew, NoneType), "a Crew, as local_crew(2)"),
}


def sweep(
    robot: Robot,
    task: Task,
    axes: Iterable[Axis],
    directory: str | Path,
    options: DesignOptions | None = None,
    *,
    spec: BipedSpec | None = None,
    seed: dict[str, float] | None = None,
    task_at: Callable[[dict[str, float]], Task] | None = None,
    crew: Crew | None = None,
    on_advance: OnAdvance | None = None,
) -> Library:
    """Design a gait at every point of a grid; go on where an earlier call was interrupted.

    Args:
        robot: the biped.
        task: of which the axes vary quantities.
        axes: at least one.
        directory: of the library; made if it does not exist.
        options: as of `design`.
        spec: of the robot, which axes of its entries need.
        seed: values near which to begin; by default both ends of the longest axis.
        task_at: the task for values of the axes, if more follows from them than themselves.
        crew: who does the work; by default this process.
        on_advance: told after every job.

    Returns:
        The library, every point of it finished or refused.

    Raises:
        InputError: axes, seed or a task cannot be used; the directory cannot be written, holds
            something else, or is in use.
        KeyboardInterrupt: Ctrl-C was pressed; what was done is kept.
    """
    options = options or DesignOptions()
    _require(robot=robot, task=task, directory=directory, options=options, spec=spec, crew=crew)
    points = GridPoints(_axes(axes))
    if seed:
        points = GridPoints(points.axes, (points.nearest(seed),))
    plan = make_plan(robot, spec, points, task_at or (lambda v: with_values(task, v.items())))
    folder = Path(directory)
    claim(folder, manifest_record(points, plan.robot, plan.tasks, options))
    workers = crew or Alone()
    try:
        with Writer(folder, points) as writer:
            Stages(plan, options, writer, workers, on_advance).run()
    finally:
        workers.close()
    return open_library(folder)


def _require(**given: object) -> None:
    for name, value in given.items():
        kinds, wanted = _KINDS[name]
        if not isinstance(value, kinds):
            raise InputError(f"{name} is {value!r}, which cannot be used; give {wanted}")


def _axes(given: Iterable[Axis]) -> tuple[Axis, ...]:
    axes = tuple(given) if isinstance(given, Iterable) else (given,)
    if isinstance(given, Axis) or not all(isinstance(axis, Axis) for axis in axes):
        raise InputError(
            f"axes are {given!r}; give a list of Axis, even of one: "
            "[parse_axis('speed', '0.4:1.3:0.05')]"
        )
    return axes
