"""The five values that the paper does not print and that move its costs most."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gaitopt.catalogue.biped_spec import BipedSpec, biped13, box_inertia
from gaitopt.catalogue.parameters import changed
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array
from reproduction.curve import Curve, cost_curve, warm_curve
from reproduction.paper import (
    biped_robot,
    identified_biped,
    identified_margins,
    paper_task,
    printed,
)


@dataclass(frozen=True)
class Unknown:
    """A value to be identified.

    Attributes:
        name: short.
        unit: of the value, empty if it has none.
        lower, upper: what a machine of this kind may have.
        meaning: what it is and why the paper leaves it open.
    """

    name: str
    unit: str
    lower: float
    upper: float
    meaning: str


UNKNOWNS = (
    Unknown(
        "knee flexion", "rad", 0.3, 1.1,
        "least bend of both knees over the step: stands for the joint range (30) and l_hip (31), "
        "of which no number is printed; it sets the cost of slow walks",
    ),
    Unknown(
        "joint speed limit", "rad/s", 3.0, 10.0,
        "of Eq. (29), the same for all joints; it sets the cost of fast walks",
    ),
    Unknown(
        "torso inertia", "of the box", 0.4, 2.5,
        "inertia about the centre of mass over that of a homogeneous box of 0.2 x 0.3 x 0.595 m",
    ),
    Unknown(
        "torso centre of mass", "m", 0.2, 0.42, "height above the hips; the torso is 0.595 m tall"
    ),
    Unknown(
        "ankle position l1", "m", -0.19, -0.107,
        "from the toe edge to the ankle, along the foot of 0.214 m: from 24 mm before the heel to "
        "the middle; the foot's centre of mass stays at its middle",
    ),
)  # fmt: skip
"""With the ranges in which they were sought."""

_TORSO_TOP = 0.595  # m above the hips: 1.30 m above the ground; drawn only
_SOLE_MIDDLE = 0.107  # m behind the toe edge
_JOINTS = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")


def identified_values() -> Array:
    """Return the values of the catalogue's biped, in the order of `UNKNOWNS`."""
    spec = identified_biped()
    torso, box = spec.links.torso, biped13().links.torso
    factor = torso.com_inertia[1][1] / box.com_inertia[1][1]
    return np.array(
        [
            identified_margins()["knee_flexion"],
            spec.joints.knee.speed,
            factor,
            torso.com[2],
            spec.geometry.l1,
        ]
    )


def biped_with(values: Sequence[float] | Array) -> BipedSpec:
    """Return the paper's biped with the unknowns that belong to the machine.

    Args:
        values: in the order of `UNKNOWNS`.

    Raises:
        SpecError: a value is not physical.
    """
    _, speed, factor, com, l1 = (float(value) for value in values)
    torso = biped13().links.torso
    inertia = np.array(box_inertia(torso.mass, torso.size)) * factor
    width, depth, _ = torso.size
    machine = {
        "geometry.l1": l1,
        "links.foot.com": (-l1 - _SOLE_MIDDLE, 0.0, biped13().links.foot.com[2]),
        "links.torso.com": (0.0, 0.0, com),
        "links.torso.size": (width, depth, 2.0 * (_TORSO_TOP - com)),
        "links.torso.inertia": tuple(map(tuple, inertia.tolist())),
    }
    limits = {f"joints.{joint}.speed": speed for joint in _JOINTS}
    return changed(biped13(), {**machine, **limits})


def walks_with(values: Sequence[float] | Array) -> list[WalkProblem]:
    """Return the walks at the eight speeds of Table 3.

    Args:
        values: in the order of `UNKNOWNS`.

    Raises:
        InputError: a value cannot be used.
    """
    robot = biped_robot(biped_with(values))
    margins = {**identified_margins(), "knee_flexion": float(values[0])}
    return [WalkProblem(robot, paper_task(v, margins)) for v in printed().speeds]


STRIDE = 0.01  # of an unknown's range, to either side


@dataclass(frozen=True)
class Sensitivity:
    """Linear dependence of the relative errors of the eight costs on the unknowns.

    Attributes:
        values: where it was taken, shape (5,).
        errors: J over the printed J, minus 1, shape (8,).
        jacobian: of the errors with respect to the unknowns over their ranges, shape (8, 5).
    """

    values: Array
    errors: Array
    jacobian: Array

    @property
    def spread(self) -> float:
        """Root mean square of the errors."""
        return float(np.sqrt((self.errors**2).mean()))

    @cached_property
    def singular(self) -> tuple[Array, Array]:
        """Singular values (5,), largest first, and their directions, one per row (5, 5)."""
        _, values, directions = np.linalg.svd(self.jacobian, full_matrices=False)
        largest = np.abs(directions).argmax(axis=1)
        signs = np.sign(directions[np.arange(len(directions)), largest])
        return values, directions * signs[:, None]

    @property
    def reach(self) -> Array:
        """How far one may go along each direction, in ranges, before the costs move by `spread`.

        Root mean square over the eight speeds; shape (5,).
        """
        return np.asarray(self.spread * np.sqrt(len(self.errors)) / self.singular[0])

    @cached_property
    def play(self) -> Array:
        """Between which values each unknown may lie while the other four make up for it, (5, 2).

        Ends of the region, within all ranges, in which the costs have linearly moved by no more
        than `spread`.
        """
        return np.array([[self._end(i, -1.0), self._end(i, 1.0)] for i in range(len(UNKNOWNS))])

    def _end(self, i: int, sign: float) -> float:
        """Largest (+1) or smallest (-1) value of an unknown in that region."""
        from scipy import optimize

        lower = np.array([u.lower for u in UNKNOWNS])
        ranges = np.array([u.upper - u.lower for u in UNKNOWNS])
        here = (self.values - lower) / ranges
        allowed = len(self.errors) * self.spread**2
        inside = {"type": "ineq", "fun": lambda d: 1.0 - ((self.jacobian @ d) ** 2).sum() / allowed}
        minimise: Any = optimize.minimize  # the published types do not admit our functions
        found = minimise(
            lambda d: -sign * d[i],
            np.zeros(len(here)),
            method="SLSQP",
            bounds=list(zip(-here, 1.0 - here, strict=True)),
            constraints=[inside],
        )
        return float(self.values[i] + ranges[i] * found.x[i])


def relative_errors(curve: Curve) -> Array:
    """Return J over the printed J, minus 1, at the speeds of Table 3; nan without a walk, (8,)."""
    costs = [curve[v].cost if v in curve else np.nan for v in printed().speeds]
    return np.array(costs) / printed().costs - 1.0


def sensitivity(curve: Curve) -> Sensitivity:
    """Return the dependence at the identified values, by central differences.

    Args:
        curve: of the identified biped, at least the speeds of Table 3.
    """
    near = {v: curve[v].solution.x for v in printed().speeds}
    values = identified_values()
    columns = []
    for i, unknown in enumerate(UNKNOWNS):
        shift = np.zeros(len(UNKNOWNS))
        shift[i] = STRIDE * (unknown.upper - unknown.lower)
        ends = [warm_curve(walks_with(values + sign * shift), near) for sign in (1.0, -1.0)]
        up, down = (relative_errors(end) for end in ends)
        columns.append((up - down) / (2.0 * STRIDE))
    return Sensitivity(values, relative_errors(curve), np.stack(columns, axis=1))


POWER = 10  # of the mean of the relative errors: near to the largest, but smooth
BEYOND = 1.0  # the misfit of values outside their ranges is more than this
FIRST_STRIDE = 0.03  # of the ranges

OnBetter = Callable[[Array, Array], None]


def misfit(errors: Array) -> float:
    """Return the power mean of the relative errors; walks that were not found count as 1."""
    size = np.where(np.isfinite(errors), np.abs(errors), 1.0)
    return float((size**POWER).mean() ** (1.0 / POWER))


def identify(
    start: Array | None = None, *, evaluations: int = 200, on_better: OnBetter | None = None
) -> Array:
    """Return values of the unknowns with a small largest error, by the method of Nelder and Mead.

    No command does this; to search on from the values that are shipped, in Python:

                identify(on_better=print)

    Each try starts from the walks of the best one so far; the costs of a better one are then
    searched along the speeds, so that they are those of the best walks known.

    Args:
        start: in the order of `UNKNOWNS`, shape (5,); by default the values that are shipped.
        evaluations: tries; a second or two each.
        on_better: told the values and the relative errors of each better try.

    Raises:
        InputError: the start is out of range.
    """
    from scipy import optimize

    lower = np.array([u.lower for u in UNKNOWNS])
    ranges = np.array([u.upper - u.lower for u in UNKNOWNS])
    first = identified_values() if start is None else np.asarray(start, dtype=np.float64)
    search = _Search(cost_curve(walks_with(first)), on_better)
    simplex = np.vstack([np.zeros(len(first)), FIRST_STRIDE * np.eye(len(first))])
    origin = (first - lower) / ranges
    minimise: Any = optimize.minimize  # the published types do not admit our arrays
    minimise(
        lambda share: search.misfit_at(lower + ranges * share, share),
        origin,
        method="Nelder-Mead",
        options={"initial_simplex": origin + simplex, "maxfev": evaluations},
    )
    return first if search.best is None else search.best


class _Search:
    """Keeps the best values and their walks."""

    def __init__(self, curve: Curve, on_better: OnBetter | None) -> None:
        self.best: Array | None = None
        self._least = np.inf
        self._curve, self._on_better = curve, on_better

    def misfit_at(self, values: Array, share: Array) -> float:
        """Return the misfit of values; share: where they are in their ranges, 0 to 1."""
        outside = float(np.maximum(0.0, np.maximum(-share, share - 1.0)).sum())
        if outside > 0.0:
            return BEYOND + outside
        near = {v: self._curve[v].solution.x for v in printed().speeds if v in self._curve}
        walks = walks_with(values)
        curve = warm_curve([w for w in walks if w.task.speed in near], near)
        first = misfit(relative_errors(curve))
        if first >= self._least:
            return first
        curve = cost_curve(walks, {v: o.solution.x for v, o in curve.items()})
        errors = relative_errors(curve)
        least = misfit(errors)
        if least < self._least:
            self.best, self._least, self._curve = values, least, curve
            if self._on_better is not None:
                self._on_better(values, errors)
        return least
