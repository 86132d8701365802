"""Fig. 8: what each group of joints contributes to the cost."""

from __future__ import annotations

from dataclasses import dataclass

from gaitopt.gait.step import Reads
from gaitopt.nlp import Array
from gaitopt.study.reproduce.curve import Optimum

GROUPS = ("ankle", "knee", "hip")
_STANCE = {"ankle": slice(0, 2), "knee": slice(2, 3), "hip": slice(3, 6)}
_SWING = {"ankle": slice(10, 12), "knee": slice(9, 10), "hip": slice(6, 9)}


@dataclass(frozen=True)
class JointCosts:
    """Shares of J [N²·m·s] by group of joints; they add up to J.

    Attributes:
        stance, swing: of the leg, by name of `GROUPS`.
    """

    stance: dict[str, float]
    swing: dict[str, float]


def joint_costs(optimum: Optimum) -> JointCosts:
    """Return what each group of joints contributes to the cost of a walk, Eq. (46)."""
    step, weights = optimum.step, optimum.problem.grid.weights
    per_joint: Array = weights @ step.read(Reads.TORQUE) ** 2 * step.duration / step.step_length
    return JointCosts(
        {group: float(per_joint[_STANCE[group]].sum()) for group in GROUPS},
        {group: float(per_joint[_SWING[group]].sum()) for group in GROUPS},
    )
