"""What a reproduction found, as JSON-able data."""

from __future__ import annotations

from dataclasses import asdict
from math import isfinite

import numpy as np

from gaitopt.design.design import versions
from gaitopt.study.reproduce.gradients import Comparison
from gaitopt.study.reproduce.printed import printed
from gaitopt.study.reproduce.results import Reproduction
from gaitopt.study.reproduce.unknowns import UNKNOWNS


def record(result: Reproduction) -> dict[str, object]:
    """Return the numbers of a reproduction, beside the printed ones."""
    walks = [
        {
            "speed": speed,
            "cost": walk.cost,
            "printed": None if (row := printed().at(speed)) is None else row.analytical.cost,
            "vertical_impulse": walk.impulse,
            "mean_vertical_force": walk.mean_vertical_force,
            "kkt": result.certificates[speed].kkt.worst,
            "joint_costs": asdict(result.joint_costs[speed]),
        }
        for speed, walk in result.curve.items()
    ]
    return {
        "unknowns": {
            u.name: value
            for u, value in zip(UNKNOWNS, result.sensitivity.values.tolist(), strict=True)
        },
        "errors": result.errors.tolist(),
        "walks": walks,
        "one_posture": {f"{v:g}": walk.cost for v, walk in result.one_posture.items()},
        "consequences": {
            name: value.tolist() if isinstance(value, np.ndarray) else value
            for name, value in vars(result.consequences).items()
        },
        "gradients": [_runs(comparison) for comparison in result.comparisons],
        "seconds": result.seconds,
        "cpu_seconds": result.cpu_seconds,
        "versions": versions(),
    }


def _runs(comparison: Comparison) -> dict[str, object]:
    return {
        "speed": comparison.speed,
        **{
            run.gradient: {
                "status": run.status.name.lower(),
                "cost": run.cost,
                "iterations": run.iterations,
                "evaluations": run.evaluations,
                "cpu_seconds": run.seconds,
                "times_longer": comparison.ratio(run.gradient),
                "times_longer_to_0.1_percent": _number(comparison.near_ratio(run.gradient)),
            }
            for run in comparison.runs
        },
    }


def _number(value: float) -> float | None:
    return value if isfinite(value) else None
