"""The first guess of a walk, as a gait."""

from gaitopt.gait.assemble import gait_at
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.model.robot import Robot


def first_walk(robot: Robot, **task: object) -> Gait:
    """The first guess of a walk: a whole motion, with all forces that it takes."""
    problem = WalkProblem(robot, preset_task("humanoid", robot, **task))
    return gait_at(problem, first_guess(problem), {})
