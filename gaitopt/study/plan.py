"""What each point of a sweep is: its robot and its task."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from gaitopt.errors import InputError
from gaitopt.gait.task import Task
from gaitopt.robot.generated.spec import BipedSpec
from gaitopt.robot.generated.spec_table import changed
from gaitopt.robot.model import Robot
from gaitopt.study.grid_points import GridPoints, Index
from gaitopt.study.setting import RobotSource, Setting, source_of

TaskAt = Callable[[dict[str, float]], Task]


@dataclass(frozen=True)
class Plan:
    """The settings of all points.

    Attributes:
        points: the grid.
        robot: without the changes of a point.
        tasks: of every point.
    """

    points: GridPoints
    robot: RobotSource
    tasks: Mapping[Index, Task]

    def setting(self, point: Index) -> Setting:
        """Return robot and task of a point."""
        return Setting(robot_at(self.robot, self.points, point), self.tasks[point])

    def axes(self, point: Index) -> tuple[tuple[str, float], ...]:
        """Return the swept quantities with their values at a point."""
        return tuple(self.points.values(point).items())


def make_plan(robot: Robot, spec: BipedSpec | None, points: GridPoints, task_at: TaskAt) -> Plan:
    """Return the plan of a sweep, every task checked.

    Raises:
        InputError: a value is out of range, or the robot has no specification to vary.
    """
    source = source_of(robot, spec)
    varied = [axis for axis in points.axes if axis.of_robot]
    if varied and spec is None:
        raise InputError(
            f"{varied[0].name} is an entry of a specification, but the robot was not made from "
            "one; sweep over a generated biped, or over quantities of the task"
        )
    for axis in varied:
        for value in (axis.values[0], axis.values[-1]):
            changed(spec, {axis.name: value})  # type: ignore[arg-type]
    return Plan(points, source, {p: task_at(points.values(p)) for p in points.order})


def robot_at(robot: RobotSource, points: GridPoints, point: Index) -> RobotSource:
    """Return the robot of a point."""
    values = points.values(point)
    changes = tuple((axis.name, values[axis.name]) for axis in points.axes if axis.of_robot)
    return replace(robot, changes=changes)
