"""What one unit of a limit is worth: shadow prices of an optimal walk.

By the envelope theorem the optimal cost changes with a limit as the Lagrangian does at the optimum
(Nocedal & Wright, 2006, section 12.8): by the limit's multiplier, in scaled units. The prices hold
for small changes, as long as the same limits stay active; where several limits say the same, their
multipliers are not unique and neither are the prices. Where a number acts otherwise above than
below its value, as a lift-off speed of zero does, the price is that of limits that give.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.design.active_set import ACTIVE_MULTIPLIER
from gaitopt.design.relaxation import (
    Adjustment,
    LimitAdjustment,
    limit_adjustments,
    step_width_adjustment,
)
from gaitopt.gait.constraint import ConstraintBlock, declared_margins
from gaitopt.gait.problem import WalkProblem, constraint_blocks
from gaitopt.gait.step import Step
from gaitopt.gait.stride import Steps
from gaitopt.nlp import Array

SETTING, LIMIT = "setting", "limit"
_KINK = 1e-5  # of a rate: a difference between both sides that is none of rounding
_SHARE = 1e-4  # of a change that matters: rows are linear in a limit, but not as far as any other


@dataclass(frozen=True)
class ShadowPrice:
    """What one unit more of a number changes in the optimal cost.

    Attributes:
        kind: SETTING for an option of task or robot, which may hold for many rows; LIMIT for one
            limit of one joint, corner or edge, over all instants.
        name, words: of the option, or of the row and its limit ("right_knee torque", "upper").
        value: of the number.
        unit: of the number, empty where it has none.
        cost_per_unit: derivative of the optimal cost [unit of the cost per unit of the number].
        effect: of a change that matters of an option, of one scaled unit of a limit [unit of the
            cost]; prices are ordered by it.
        cost_unit: unit of the cost.
    """

    kind: str
    name: str
    words: str
    value: float
    unit: str
    cost_per_unit: float
    effect: float
    cost_unit: str

    def record(self) -> dict[str, object]:
        """Return the price as JSON-able data."""
        return dict(vars(self))


def shadow_prices(
    problem: WalkProblem, x: Array, multipliers: tuple[Array, Array]
) -> tuple[ShadowPrice, ...]:
    """Return the prices of all numbers that an optimal walk presses on, the greatest effect first.

    Args:
        x: its optimal parameters, shape (P,).
        multipliers: there, of the scaled rows (m,) and of the bounds (P,).

    Raises:
        EvaluationError: the walk is not defined at x.
    """
    found = [
        *_of_settings(problem, problem.whole(x), *multipliers),
        *_of_limits(problem, multipliers[0]),
    ]
    return tuple(sorted(found, key=lambda price: (price.kind != SETTING, -abs(price.effect))))


def _of_settings(
    problem: WalkProblem, whole: Step | Steps, multipliers: Array, bound_multipliers: Array
) -> Iterator[ShadowPrice]:
    pressed, unit = pressed_rows(problem, multipliers), problem.task.cost_unit

    def price(one: Adjustment, per_unit: float, effect: float) -> ShadowPrice:
        facts = one.name, one.words, one.before, one.unit
        return ShadowPrice(SETTING, *facts, per_unit, effect, unit)

    for setting in limit_adjustments(problem, alone=True):
        rate = _rate(problem, whole, pressed, setting) / problem.cost_scale
        if rate != 0.0:
            yield price(setting, rate / setting.step, rate)
    width = step_width_adjustment(problem)
    if width is not None and abs(bound_multipliers[width.index]) > ACTIVE_MULTIPLIER:
        rate = -abs(float(bound_multipliers[width.index])) / problem.cost_scale
        yield price(width, rate, rate * width.step)


def kinks(problem: WalkProblem, x: Array, multipliers: Array) -> Iterator[str]:
    """Yield words of the margins that are worth more on one side of their value than on the other.

    At an optimum x (P,) with multipliers (m,) of the scaled rows.
    """
    whole, pressed = problem.whole(x), pressed_rows(problem, multipliers)
    for setting in limit_adjustments(problem, alone=True):
        if setting.name in problem.task.declared:
            sides = (1.0, -1.0)
            gives, takes = (_rate(problem, whole, pressed, setting, side) for side in sides)
            if abs(gives - takes) > _KINK * abs(gives):
                yield setting.words


def pressed_rows(problem: WalkProblem, multipliers: Array) -> dict[str, Array]:
    """Return the multipliers (K, r) of rows that press, by the names of their constraints."""
    held = np.where(np.abs(multipliers) > ACTIVE_MULTIPLIER, multipliers, 0.0)
    return {
        block.name: y.reshape(block.lower.shape)
        for block in problem.blocks
        if (y := held[problem.rows_of(block.name)]).any()
    }


def _rate(
    problem: WalkProblem,
    whole: Step | Steps,
    pressed: dict[str, Array],
    setting: LimitAdjustment,
    side: float = 1.0,
) -> float:
    """Return what a change that matters does to the Lagrangian; of side -1.0 where limits take."""
    held = [b for b in problem.blocks if b.name in pressed and b.name in setting.constraints]
    if not held:
        return 0.0
    value = setting.before + side * _SHARE * setting.step
    robot, task, margins = problem.robot, problem.task, problem.task.margins
    if setting.name in declared_margins(margins):  # nothing else of the task is looked at
        own: dict[str, Any] = {setting.name: value}
        margins = replace(margins, **own)
    else:
        robot, task = setting.changed(robot, task, value)
    names = [block.name for block in held]
    changed = constraint_blocks(robot, task, problem.grid, names, margins=margins)
    changes = (
        pressing(new, old, pressed[old.name], whole) - pressing(old, old, pressed[old.name], whole)
        for old, new in zip(held, changed, strict=True)
    )
    return side * sum(changes, 0.0) / _SHARE


def pressing(block: ConstraintBlock, own: ConstraintBlock, y: Array, whole: Step | Steps) -> float:
    """Return multipliers . (rows - limits) of a walk as it is, by other rows and limits.

    Args:
        own: those of the walk, by which the multipliers are scaled.
        y: multipliers of the walk's rows, shape (K, k).
    """
    values = block.function.value(block.take(whole.values))
    limits = np.where(y > 0.0, block.upper, block.lower)
    held = y != 0.0
    return float((y / own.scale)[held] @ (values - limits)[held])


def _of_limits(problem: WalkProblem, multipliers: Array) -> Iterator[ShadowPrice]:
    for block in problem.blocks:
        y = multipliers[problem.rows_of(block.name)].reshape(block.lower.shape)
        if not y.any():
            continue
        y = np.where(block.lower == block.upper, 0.0, y)  # equalities have no side to give
        for side, limits, pushes in (("upper", block.upper, y), ("lower", block.lower, -y)):
            push = np.maximum(pushes, 0.0)
            for entry in np.flatnonzero((push > ACTIVE_MULTIPLIER).any(axis=0)):
                effect = -float(push[:, entry].sum()) / problem.cost_scale
                scale, at = float(block.scale[entry]), int(push[:, entry].argmax())
                sign = 1.0 if side == "upper" else -1.0
                yield ShadowPrice(
                    LIMIT, block.label(at, int(entry)), side, float(limits[at, entry]), block.unit,
                    sign * effect / scale, effect, problem.task.cost_unit,
                )  # fmt: skip
