"""What one unit of a limit is worth: shadow prices of an optimal walk.

By the envelope theorem the optimal cost changes with a limit as the Lagrangian does at the optimum
(Nocedal & Wright, 2006, section 12.8): by the limit's multiplier, in scaled units. The prices hold
for small changes, as long as the same limits stay active; where several limits say the same, their
multipliers are not unique and neither are the prices.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass

import numpy as np

from gaitopt.design.active_set import ACTIVE_MULTIPLIER
from gaitopt.design.relaxation import limit_adjustments, step_width_adjustment
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array

SETTING, LIMIT = "setting", "limit"


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
        return asdict(self)


def shadow_prices(
    problem: WalkProblem, x: Array, multipliers: tuple[Array, Array]
) -> tuple[ShadowPrice, ...]:
    """Return the prices of all numbers that an optimal walk presses on, the greatest effect first.

    Args:
        problem: the walk.
        x: its optimal parameters, shape (P,).
        multipliers: there, of the scaled rows (m,) and of the bounds (P,).

    Raises:
        EvaluationError: the walk is not defined at x.
    """
    found = [
        *_of_settings(problem, problem.values(x).rows, *multipliers),
        *_of_limits(problem, multipliers[0]),
    ]
    return tuple(sorted(found, key=lambda price: (price.kind != SETTING, -abs(price.effect))))


def _of_settings(
    problem: WalkProblem, rows: Array, multipliers: Array, bound_multipliers: Array
) -> Iterator[ShadowPrice]:
    pressed = {
        block.name
        for block in problem.blocks
        if (np.abs(multipliers[problem.rows_of(block.name)]) > ACTIVE_MULTIPLIER).any()
    }
    for setting in limit_adjustments(problem):
        if pressed.isdisjoint(setting.constraints):
            continue
        rate = -setting.relaxation(problem).relief(rows, multipliers) / problem.cost_scale
        if rate != 0.0:
            yield ShadowPrice(
                SETTING,
                setting.name,
                setting.words,
                setting.before,
                setting.unit,
                rate / setting.step,
                rate,
                problem.task.cost_unit,
            )
    width = step_width_adjustment(problem)
    if width is not None and abs(bound_multipliers[width.index]) > ACTIVE_MULTIPLIER:
        rate = -abs(float(bound_multipliers[width.index])) / problem.cost_scale
        yield ShadowPrice(
            SETTING,
            width.name,
            width.words,
            width.before,
            width.unit,
            rate,
            rate * width.step,
            problem.task.cost_unit,
        )


def _of_limits(problem: WalkProblem, multipliers: Array) -> Iterator[ShadowPrice]:
    for block in problem.blocks:
        y = multipliers[problem.rows_of(block.name)].reshape(block.lower.shape)
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
