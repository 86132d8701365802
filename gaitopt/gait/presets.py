"""The named tasks, those that need no robot and the one that is sized by it."""

from __future__ import annotations

from gaitopt.errors import InputError
from gaitopt.gait import task as bipeds
from gaitopt.gait.constraints import Margins
from gaitopt.gait.humanoid import TRUNK, humanoid_task
from gaitopt.gait.task import Task
from gaitopt.importers.physics import is_generated
from gaitopt.model.robot import Robot

HUMANOID = "humanoid"
PRESETS = (*bipeds.PRESETS, HUMANOID)
_SIZED = (*TRUNK, "minimum_load", "torsional_friction", "step_width", "leg_gap")


def preset_task(preset: str = "standard", robot: Robot | None = None, **changes: object) -> Task:
    """Return a task of a named preset, with some fields changed.

    `standard`: for the thirteen-link biped, 43 parameters and every constraint. `paper`: the
    constraints of section 3.2 only, the six geometric parameters of section 4.2, speed as the
    constraint (39). `humanoid`: for any other robot; speed, duration, load, step width and
    friction under the foot follow from its size and weight, the trunk keeps upright.

    Args:
        preset: its name.
        robot: the biped, which `humanoid` is sized by; the others do without.
        changes: fields of `Task` and of `Margins`, as `speed=0.6` [m/s].

    Raises:
        InputError: unknown preset or field, a value out of range, or no robot for `humanoid`.
    """
    if preset not in PRESETS:
        raise InputError(f"preset '{preset}' is unknown; choose one of {', '.join(PRESETS)}")
    if preset != HUMANOID:
        return bipeds.preset_task(preset, **changes)
    if not isinstance(robot, Robot):
        raise InputError(
            f"the preset '{HUMANOID}' is sized by the robot; give it, as in "
            f'preset_task("{HUMANOID}", robot, speed=0.6)'
        )
    return humanoid_task(robot, **changes)


def foreign_margins(robot: Robot, task: Task) -> str | None:
    """Return what to say where the margins of the thirteen-link biped meet another robot.

    Args:
        robot: the biped.
        task: its walk.
    """
    usual = Margins()
    chosen = any(getattr(task.margins, name) != getattr(usual, name) for name in _SIZED)
    if chosen or is_generated(robot.urdf):
        return None
    return (
        f"the margins of this task are those of the thirteen-link biped: a least load of "
        f"{usual.minimum_load:g} N, where {robot.name} weighs {robot.weight:.0f} N, and no limits "
        f"of trunk, step width and gap between the legs; "
        f'preset_task("{HUMANOID}", robot, speed={task.speed:g}) sizes them by the robot'
    )
