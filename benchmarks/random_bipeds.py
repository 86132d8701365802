"""Fifty random bipeds at random speeds: each design is certified, or diagnosed, or neither."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from common import arguments, reference_task, robot_of, save

from gaitopt import biped13
from gaitopt.catalogue.biped_spec import BipedSpec
from gaitopt.catalogue.parameters import changed
from gaitopt.design.design import design
from gaitopt.design.diagnosis import diagnose
from gaitopt.design.process import small_matrices
from gaitopt.errors import GaitoptError, NoGaitFoundError
from gaitopt.gait.problem import WalkProblem

LENGTHS, MASSES = 0.2, 0.3
"""Largest relative change, either way."""
SPEEDS = (0.5, 1.2)
"""Range of walking speeds [m/s]."""


def random_case(seed: int) -> tuple[BipedSpec, float, dict[str, float]]:
    """Return a biped, a speed [m/s] and the factors on lengths and masses.

    Boxes and centres of mass follow the length of their link.
    """
    rng = np.random.default_rng(seed)
    lengths = ("d1", "d3", "d4", "d7", "foot_length", "foot_width", "torso")
    k = {name: float(rng.uniform(1.0 - LENGTHS, 1.0 + LENGTHS)) for name in lengths}
    base = biped13()
    links = dict(base.links.named())
    m = {name: float(rng.uniform(1.0 - MASSES, 1.0 + MASSES)) for name in links}
    speed = float(rng.uniform(*SPEEDS))
    changes: dict[str, Any] = {
        f"geometry.{name}": getattr(base.geometry, name) * k[name]
        for name in ("d1", "d3", "d4", "d7", "foot_length", "foot_width")
    }
    changes["geometry.l1"] = base.geometry.l1 * k["foot_length"]
    stretch = {
        "torso": (1.0, 1.0, k["torso"]),
        "thigh": (1.0, 1.0, k["d4"]),
        "shin": (1.0, 1.0, k["d3"]),
        "foot": (k["foot_length"], k["foot_width"], k["d1"]),
    }
    for name, link in links.items():
        changes[f"links.{name}.mass"] = link.mass * m[name]
        for what in ("size", "com"):
            scaled = np.multiply(getattr(link, what), stretch.get(name, (1.0, 1.0, 1.0)))
            changes[f"links.{name}.{what}"] = tuple(float(v) for v in scaled)
    factors = {**k, **{f"mass {name}": value for name, value in m.items()}}
    return changed(base, changes), speed, {n: round(v, 3) for n, v in factors.items()}


def run(seed: int) -> dict[str, Any]:
    """Design one gait and tell how it went."""
    spec, speed, factors = random_case(seed)
    robot, task = robot_of(spec), reference_task(speed=speed)
    record: dict[str, Any] = {"seed": seed, "speed": speed, "factors": factors}
    started = time.perf_counter()
    try:
        result = design(robot, task)
    except NoGaitFoundError as error:
        record |= {"outcome": "no gait", "reason": str(error)}
    except GaitoptError as error:
        record |= {"outcome": "error", "reason": f"{type(error).__name__}: {error}"}
    else:
        certificate, solution = result.certificate, result.solution
        record |= {
            "outcome": "certified" if certificate.certified else "not certified",
            "reason": certificate.verdict,
            "cost": solution.cost,
            "solver": solution.solver,
            "status": solution.status.name,
            "kkt": certificate.kkt.worst,
            "fine violation": certificate.worst.violation,
            "iterations": solution.iterations,
            "evaluations": solution.evaluations,
        }
    record["seconds"] = time.perf_counter() - started
    if record["outcome"] == "no gait":
        record |= _diagnosed(robot, task)
    return record


def _diagnosed(robot: Any, task: Any) -> dict[str, Any]:
    """Diagnose a walk that has no gait."""
    try:
        with small_matrices():
            found = diagnose(WalkProblem(robot, task))
    except GaitoptError as error:
        return {"diagnosis": f"none: {error}", "diagnosed": False}
    return {
        "diagnosis": "; ".join(found.sentences),
        "diagnosed": found.gait is None and bool(found.impossible or found.conflict),
        "diagnosis seconds": found.seconds,
    }


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--seeds", type=int, default=50)
    parser.add_argument("--first", type=int, default=0)
    options = parser.parse_args()
    count = 2 if options.quick else options.seeds
    records = []
    for seed in range(options.first, options.first + count):
        records.append(run(seed))
        last = records[-1]
        print(
            f"{seed:3d} {last['speed']:.2f} m/s {last['seconds']:6.2f} s {last['outcome']}: "
            f"{last['reason']} {last.get('diagnosis', '')}",
            flush=True,
        )
    save("random_bipeds", records, options.quick)


if __name__ == "__main__":
    main()
