"""Options that act only together with others: which, with what, and their refusal alone."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping

from gaitopt.cli.config import SCHEMA, Settings, option_words
from gaitopt.dataclass import dataclass
from gaitopt.errors import IdleOptionError
from gaitopt.gait.costs import PeakTorque, TorqueRate, WeightedSum
from gaitopt.gait.plugin import costs_of
from gaitopt.gait.task import Task
from gaitopt.model.capsules import arm_bodies
from gaitopt.model.robot import Robot


@dataclass(frozen=True)
class Need:
    """What a setting needs to have an effect.

    Attributes:
        when: it acts, in words.
        others: settings that decide it.
        acts: whether it does, on the walk of a robot.
    """

    when: str
    others: tuple[str, ...]
    acts: Callable[[Task, Robot], bool]


def _one_of(*others: str) -> Need:
    """Return the need of a phase: one of some settings of the task, which are None without it."""
    options = " or ".join(f"--{name.replace('_', '-')}" for name in others)
    return Need(
        f"with {options}",
        others,
        lambda task, _: any(getattr(task, name) is not None for name in others),
    )


_IMPACT = Need(
    "where the foot lands by an impact: without --soft-landing, and with --double-support only "
    "by --touch-down impact",
    ("soft_landing", "double_support", "touch_down"),
    lambda task, _: (
        not task.margins.soft_landing
        and (task.double_support is None or task.touch_down == "impact")
    ),
)
_NO_INTEGRAL = (PeakTorque, TorqueRate, WeightedSum)

NEEDS: Mapping[str, Need] = {
    "toe_strip": _one_of("toe_off"),
    "toe_begin": _one_of("toe_off"),
    "heel_strip": _one_of("heel_strike"),
    "foot_flat": _one_of("heel_strike"),
    "touch_down": _one_of("double_support"),
    "phase_times": _one_of("heel_strike", "double_support"),
    "penalty_weight": Need(
        "with --speed-as penalty", ("speed_as",), lambda task, _: task.speed_as == "penalty"
    ),
    "quadrature": Need(
        "with a cost that is an integral, as --cost torque",
        ("cost",),
        lambda task, _: any(not isinstance(one, _NO_INTEGRAL) for one in costs_of(task.cost)),
    ),
    "nosing": Need("with --stairs", ("stairs",), lambda task, _: task.ground.shaped),
    "arm_gap": Need(
        "where arms move, by --move arms", ("move",), lambda _, robot: bool(arm_bodies(robot))
    ),
    "landing_impulse": _IMPACT,
    "impulse_cop": _IMPACT,
    "liftoff_speed": Need(
        "where an impact lifts the rear foot: without --soft-landing and --double-support",
        ("soft_landing", "double_support"),
        lambda task, _: not task.margins.soft_landing and task.double_support is None,
    ),
}
"""Needs of settings that act only together with others."""

_OVERRULED = {"torque": "torque_limit", "speed": "speed_limit"}
"""Of what a limit of some joints may be of, the setting that replaces it at every joint."""


def idle(names: Collection[str], task: Task, robot: Robot) -> Iterator[str]:
    """Yield those of some settings that have no effect on a walk, whatever their values."""
    return (name for name in names if name in NEEDS and not NEEDS[name].acts(task, robot))


def refuse_idle(asked: Settings, task: Task, robot: Robot, varied: Collection[str] = ()) -> None:
    """Check that what was asked has an effect on a walk.

    Args:
        asked: settings that were given.
        varied: settings that take other values too, as in a sweep.

    Raises:
        IdleOptionError: a setting has none.
    """
    for name in idle(asked, task, robot):
        if not set(NEEDS[name].others) & set(varied):
            unit = next(one[name].unit for one in SCHEMA.values() if name in one)
            words = [*option_words(name, asked[name]), unit]
            raise IdleOptionError(" ".join(words).strip(), NEEDS[name].when)


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
