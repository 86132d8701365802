"""Options that act only together with others: which, with what, and their refusal alone."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping

from gaitopt.cli.config import SCHEMA, Settings, option_words
from gaitopt.errors import IdleOptionError
from gaitopt.gait.costs import PeakTorque, TorqueRate, WeightedSum
from gaitopt.gait.plugin import costs_of
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot

Acts = Callable[[Task, Robot], bool]
"""Whether a setting has an effect on the walk of a robot."""

_TOE = ("with --toe-off", ("toe_off",), lambda task, _: task.toe_off is not None)
_HEEL = ("with --heel-strike", ("heel_strike",), lambda task, _: task.heel_strike is not None)
_IMPACT = (
    "where the foot lands by an impact: without --soft-landing, and with --double-support only "
    "by --touch-down impact",
    ("soft_landing", "double_support", "touch_down"),
    lambda task, _: (
        not task.margins.soft_landing
        and (task.double_support is None or task.touch_down == "impact")
    ),
)
_NO_INTEGRAL = (PeakTorque, TorqueRate, WeightedSum)

NEEDS: Mapping[str, tuple[str, tuple[str, ...], Acts]] = {
    "toe_strip": _TOE,
    "toe_begin": _TOE,
    "heel_strip": _HEEL,
    "foot_flat": _HEEL,
    "touch_down": (
        "with --double-support",
        ("double_support",),
        lambda task, _: task.double_support is not None,
    ),
    "phase_times": (
        "with --heel-strike or --double-support",
        ("heel_strike", "double_support"),
        lambda task, _: task.heel_strike is not None or task.double_support is not None,
    ),
    "penalty_weight": (
        "with --speed-as penalty",
        ("speed_as",),
        lambda task, _: task.speed_as == "penalty",
    ),
    "quadrature": (
        "with a cost that is an integral, as --cost torque",
        ("cost",),
        lambda task, _: any(not isinstance(one, _NO_INTEGRAL) for one in costs_of(task.cost)),
    ),
    "nosing": ("with --stairs", ("stairs",), lambda task, _: task.ground.shaped),
    "arm_gap": (
        "where arms move, by --move arms",
        ("move",),
        lambda _, robot: robot.tree.size > robot.tree.swing_foot,
    ),
    "landing_impulse": _IMPACT,
    "impulse_cop": _IMPACT,
    "liftoff_speed": (
        "where an impact lifts the rear foot: without --soft-landing and --double-support",
        ("soft_landing", "double_support"),
        lambda task, _: not task.margins.soft_landing and task.double_support is None,
    ),
}
"""Of a setting that acts only together with others: when, in words; those others; whether it acts.
"""

_OVERRULED = {"torque": "torque_limit", "speed": "speed_limit"}
"""Of what a limit of some joints may be of, the setting that replaces it at every joint."""


def idle(names: Collection[str], task: Task, robot: Robot) -> Iterator[str]:
    """Yield those of some settings that have no effect on a walk, whatever their values."""
    return (name for name in names if name in NEEDS and not NEEDS[name][2](task, robot))


def refuse_idle(asked: Settings, task: Task, robot: Robot, varied: Collection[str] = ()) -> None:
    """Check that what was asked has an effect on a walk.

    Args:
        asked: settings that were given.
        task, robot: of the walk.
        varied: settings that take other values too, as in a sweep.

    Raises:
        IdleOptionError: a setting has none.
    """
    for name in idle(asked, task, robot):
        when, others, _ = NEEDS[name]
        if not set(others) & set(varied):
            unit = next(one[name].unit for one in SCHEMA.values() if name in one)
            words = [*option_words(name, asked[name]), unit]
            raise IdleOptionError(" ".join(words).strip(), when)


def refuse_overruled(limits: Iterable[str], settings: Settings) -> None:
    """Check that no setting replaces limits of some joints by one for every joint.

    Args:
        limits: as --limit takes them.
        settings: given in the same place, or where it counts more.

    Raises:
        IdleOptionError: one does.
    """
    for text in limits:
        other = _OVERRULED.get(text.partition("=")[0].rpartition(".")[2].strip())
        if other in settings:
            words = " ".join(option_words(other, settings[other]))
            raise IdleOptionError(f"--limit {text}", f"without {words}, which is for every joint")
