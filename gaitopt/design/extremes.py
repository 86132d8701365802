"""Where a walk comes nearest to its limits, located between the instants that are evaluated.

Between two knots of the spline every row is a smooth function of time. It is evaluated at Chebyshev
points of each piece and represented by the polynomial through them, whose error is read off its
last coefficients; where a row comes near its limit and the polynomial is not yet exact enough, the
piece is divided (Trefethen, Approximation Theory and Approximation Practice, 2013, chapters 2 to 8;
Pachon, Platte & Trefethen, Piecewise-smooth chebfuns, IMA J. Numer. Anal. 30, 2010). The extremes
of the polynomials are then found by Newton's method. Nothing here depends on the task's samples.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import islice, pairwise

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from gaitopt.contact import AFTER
from gaitopt.dataclass import dataclass
from gaitopt.errors import EvaluationError
from gaitopt.gait.grid import NODES, Grid, chebyshev_points
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array
from gaitopt.tolerances import LOCATED

DENSE = 4 * NODES  # points of a piece among which its extremes are bracketed
NEWTON = 6  # steps; the brackets are narrow
TAIL = 4  # last coefficients that tell the error of a polynomial ...
SAFETY = 10.0  # ... times this
BEYOND = 20.0  # errors by which a limit is exceeded without doubt
PARTS = 4  # into which a piece is divided
DEPTH = 10  # divisions of a piece, at most: then it is a microsecond long
MOST_PARTS = (
    256  # of all pieces, made at once: walks need some tens, parameters that are none a million
)
KEPT = 4  # walks at the nodes of parts, and limits that are looked at
CLOSE = 1e-2  # scaled distance: extremes farther from their limit are of no interest


@dataclass(frozen=True)
class Extreme:
    """A row at an instant where it comes nearest to one of its limits, or exceeds it most.

    Attributes:
        constraint, entry: which constraint.
        instant: s = t / T.
        margin: scaled distance to the limit there, negative if it is exceeded.
        error: estimate of how far the margin may be off.
        upper: whether the limit is the upper one.
        curvature: second derivative of the margin with respect to s.
        at_end: margin at the nearer end of the step, infinite where that is in another piece.
    """

    constraint: str
    entry: int
    instant: float
    margin: float
    error: float
    upper: bool
    curvature: float = 0.0
    at_end: float = np.inf


@dataclass(frozen=True)
class _Sides:
    """Limits that are looked at over the whole step, one per column of a table of margins.

    Attributes:
        names: of the constraints, (C).
        entry: index of the row in its constraint, shape (C,).
        upper: whether it is the upper limit, shape (C,).
        rows: of the program, at the instants inside the step, shape (instants, C).
        limits: shape (instants, C).
    """

    names: tuple[str, ...]
    entry: NDArray[np.int_]
    upper: NDArray[np.bool_]
    rows: NDArray[np.int_]
    limits: Array

    def margins(self, problem: WalkProblem, x: Array) -> Array:
        """Return the distances to the limits, shape (instants, C)."""
        margins = self.limits - problem.values(x).rows[self.rows]
        margins *= np.where(self.upper, 1.0, -1.0)
        if not np.isfinite(margins).all():
            raise EvaluationError("a constraint of the walk has no finite value at some instant")
        return margins


@dataclass(frozen=True)
class _Piece:
    """Margins over a part of the step without a knot inside.

    Attributes:
        start, end: in s.
        coefficients: Chebyshev series of every column, shape (NODES, C).
        dense: margins at `_dense_points`, shape (DENSE, C).
        errors: estimated ones of every column, shape (C,).
        depth: how often a knot interval was divided.
    """

    start: float
    end: float
    coefficients: Array
    dense: Array
    errors: Array
    depth: int


def located(fine: WalkProblem, x: Array, *, everywhere: bool = False) -> tuple[Extreme, ...]:
    """Return the extremes of every row that is looked at over the whole step.

    Args:
        fine: the walk on the proof's grid, see `gaitopt.gait.grid.proof_grid`.
        x: parameters, shape (P,).
        everywhere: whether to return the worst extreme of every row too, however far it is from
            its limits.

    Raises:
        EvaluationError: the walk is not defined at x, or a row has no finite value.
    """
    return _located(fine, x.tobytes(), everywhere)


@lru_cache(maxsize=2)
def _located(fine: WalkProblem, parameters: bytes, everywhere: bool) -> tuple[Extreme, ...]:
    """See `located`, x (P,) as bytes; the last ones are kept, since one asks after another."""
    sides = _sides(fine)
    at_instants = tuple(_at_instants(fine, np.frombuffer(parameters), set(sides.names)))
    if not sides.names:
        return at_instants
    pieces = _resolved(fine, parameters)
    return *_polished(
        pieces, sides, fine.edges, *_brackets(pieces, fine.changes, everywhere)
    ), *at_instants


def _pieces(fine: WalkProblem, x: Array, sides: _Sides) -> list[_Piece]:
    """The intervals between knots and changes of phase."""
    bounds = []
    for k, (start, end) in enumerate(pairwise(fine.breaks.tolist())):
        jumps = k > 0 and np.abs(fine.changes - start).min(initial=np.inf) < AFTER
        # what is there before it belongs to the other
        bounds.append((start + AFTER if jumps else start, end))
    return list(_made(bounds, sides.margins(fine, x), [0] * len(bounds)))


@lru_cache(maxsize=2)
def _resolved(fine: WalkProblem, parameters: bytes) -> list[_Piece]:
    """Divide the step until every row that comes near a limit is known well enough there.

    The last ones are kept: a walk is refined, confirmed and certified by the same extremes.

    Into four at a time: what makes a row hard to follow is at one place, where halves would be
    halved again and again, each time for as long as an evaluation takes.

    What is still unclear when there are too many of them keeps its error, of which the certificate
    tells.

    Args:
        parameters: x, shape (P,), as bytes.
    """
    x = np.frombuffer(parameters)
    pieces = _pieces(fine, x, _sides(fine))
    while unclear := [piece for piece in pieces if _unclear(piece)]:
        if PARTS * len(unclear) > MOST_PARTS:
            break
        parts = [bounds for piece in unclear for bounds in _parts(piece)]
        finer = _divided(fine, tuple(parts))
        depths = [piece.depth + 1 for piece in unclear for _ in range(PARTS)]
        made = _made(parts, _sides(finer).margins(finer, x), depths)
        divided = set(map(id, unclear))
        pieces = [
            part
            for piece in pieces
            for part in (islice(made, PARTS) if id(piece) in divided else (piece,))
        ]
    return pieces


@lru_cache(maxsize=KEPT)
def _divided(fine: WalkProblem, parts: tuple[tuple[float, float], ...]) -> WalkProblem:
    """Return the walk at the nodes of parts of the step, kept as walks alike are divided alike."""
    points = 0.5 * (chebyshev_points(NODES) + 1.0)
    instants = np.concatenate([start + points * (end - start) for start, end in parts])
    weights = np.full(instants.size, 1.0 / instants.size)
    return fine.with_grid(Grid(instants, weights, instants.size))


def _unclear(piece: _Piece) -> bool:
    """Whether a row may exceed its limit by as much as its polynomial may be wrong.

    A limit that is exceeded by far more is exceeded; by how much, a later round will tell.
    """
    unsure = np.flatnonzero(piece.errors > LOCATED)
    if not unsure.size or piece.depth >= DEPTH:
        return False
    errors, dense = piece.errors[unsure], piece.dense[:, unsure]
    least = dense.min(axis=0)
    bent = dense[:-2] - 2.0 * dense[1:-1] + dense[2:]
    dip = np.maximum(bent, 0.0).max(axis=0) / 8.0  # of a parabola between two of its points
    near = (least - dip < errors) & (-least < BEYOND * errors)
    return bool(near.any())


def _parts(piece: _Piece) -> list[tuple[float, float]]:
    return list(pairwise(np.linspace(piece.start, piece.end, PARTS + 1).tolist()))


def _made(
    bounds: Sequence[tuple[float, float]], margins: Array, depths: Sequence[int]
) -> Iterator[_Piece]:
    """Yield the pieces between bounds, from the margins at the nodes of each, (len * NODES, C)."""
    to_coefficients, to_dense = _transforms()
    coefficients = to_coefficients @ margins.reshape(len(bounds), NODES, -1)
    errors = SAFETY * np.abs(coefficients[:, -TAIL:]).sum(axis=1)
    each = zip(bounds, coefficients, to_dense @ coefficients, errors, depths, strict=True)
    for (start, end), series, dense, error, depth in each:
        yield _Piece(start, end, series, dense, error, depth)


@lru_cache(maxsize=1)
def _transforms() -> tuple[Array, Array]:
    """Matrices from values at the nodes to coefficients, and from those to dense values."""
    to_coefficients = np.linalg.inv(_terms(chebyshev_points(NODES)))
    return np.asarray(to_coefficients, dtype=np.float64), _terms(_dense_points())


@lru_cache(maxsize=1)
def _dense_points() -> Array:
    return -np.cos(np.linspace(0.0, np.pi, DENSE))


@lru_cache(maxsize=KEPT)
def _sides(problem: WalkProblem) -> _Sides:
    """Return the limits of the constraints that look at every instant inside the step."""
    instants = problem.grid.instants
    count = int(((instants > 0.0) & (instants < 1.0)).sum())
    names: list[str] = []
    tables: list[NDArray[np.int_]] = []
    for constraint in problem.blocks:
        if constraint.times is None:
            continue
        inside = (constraint.times > 0.0) & (constraint.times < 1.0)
        if int(inside.sum()) == count:
            block = problem.rows_of(constraint.name)
            numbers = np.arange(block.start, block.stop).reshape(constraint.lower.shape)
            names.append(constraint.name)
            tables.append(numbers[inside])
    rows = np.concatenate([np.zeros((count, 0), dtype=int), *tables], axis=1)
    widths = np.array([table.shape[1] for table in tables], dtype=int)
    owner = np.repeat(np.arange(len(tables)), widths)
    entry = np.arange(owner.size) - np.repeat(np.cumsum(widths) - widths, widths)
    limits = [limit[rows] for limit in (problem.rows.lower, problem.rows.upper)]
    kept = [np.flatnonzero(np.isfinite(limit).all(axis=0)) for limit in limits]
    columns = np.concatenate(kept)
    upper = np.repeat([False, True], [each.size for each in kept])
    # of each constraint the lower limits, then the upper ones
    order = np.argsort(2 * owner[columns] + upper, kind="stable")
    table = np.concatenate([limit[:, each] for limit, each in zip(limits, kept, strict=True)], 1)
    columns = columns[order]
    return _Sides(
        tuple(names[k] for k in owner[columns]),
        entry[columns],
        upper[order],
        rows[:, columns],
        table[:, order],
    )


def _at_instants(fine: WalkProblem, x: Array, over_step: set[str]) -> Iterator[Extreme]:
    """Yield the worst of each row of constraints that look at chosen instants only: at those."""
    values = fine.values(x).rows
    for constraint in fine.blocks:
        if constraint.times is None or constraint.name in over_step or constraint.size == 0:
            continue
        block, shape = fine.rows_of(constraint.name), constraint.lower.shape
        below = (values[block] - fine.rows.lower[block]).reshape(shape)
        above = (fine.rows.upper[block] - values[block]).reshape(shape)
        margins = np.minimum(below, above)
        for entry, row in enumerate(np.argmin(margins, axis=0)):
            if np.isinf(margins[row, entry]):
                continue  # it has no limit
            yield Extreme(
                constraint=constraint.name,
                entry=entry,
                instant=float(constraint.times[row]),
                margin=float(margins[row, entry]),
                error=0.0,
                upper=bool(above[row, entry] < below[row, entry]),
            )


def _brackets(
    pieces: list[_Piece], changes: Array, everywhere: bool
) -> tuple[NDArray[np.int_], ...]:
    """Return piece, dense point and column of every extreme.

    Where an extreme is at a knot, it belongs to the piece into which the margin falls. Nothing is
    taken to be continuous across a change of phase.
    """
    found = [
        _brackets_of(pieces[first:last], first, everywhere)
        for first, last in pairwise(_runs(pieces, changes))
    ]
    numbers, points, columns = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return numbers, points, columns


def _runs(pieces: list[_Piece], changes: Array) -> list[int]:
    """Return the numbers of the pieces with which phases begin, and that of all."""
    starts = np.array([piece.start for piece in pieces])
    return [0, *np.searchsorted(starts, changes).tolist(), len(pieces)]


def _brackets_of(
    pieces: list[_Piece], first: int, everywhere: bool
) -> tuple[NDArray[np.int_], ...]:
    """Return the brackets of pieces in which all rows are continuous, `first` added to theirs."""
    dense = np.concatenate([pieces[0].dense, *(piece.dense[1:] for piece in pieces[1:])])
    minima = dense < CLOSE
    minima[1:] &= dense[1:] <= dense[:-1]
    minima[:-1] &= dense[:-1] < dense[1:]
    if everywhere:
        minima[np.argmin(dense, axis=0), np.arange(dense.shape[1])] = True
    rows, columns = np.nonzero(minima)
    numbers, points = np.divmod(rows, DENSE - 1)
    for k in np.flatnonzero((points == 0) & (numbers > 0)):
        falls = numbers[k] < len(pieces) and _rate_at_start(pieces[numbers[k]], columns[k]) < 0.0
        if not falls:
            numbers[k], points[k] = numbers[k] - 1, DENSE - 1
    return numbers + first, points, columns


def _rate_at_start(piece: _Piece, column: int) -> float:
    orders = np.arange(NODES)
    return float(-((-1.0) ** orders * orders**2) @ piece.coefficients[:, column])


def _polished(
    pieces: list[_Piece],
    sides: _Sides,
    steps: Array,
    numbers: NDArray[np.int_],
    points: NDArray[np.int_],
    columns: NDArray[np.int_],
) -> Iterator[Extreme]:
    """Find the extremes by Newton's method between the neighbours of dense points.

    Args:
        steps: instants at which one begins or ends.
        numbers, points, columns: of pieces, dense points and limits, as of `_brackets`.
    """
    if not numbers.size:
        return
    coefficients = np.stack([piece.coefficients for piece in pieces])[numbers, :, columns].T
    at = _dense_points()
    low, high = at[np.maximum(points - 1, 0)], at[np.minimum(points + 1, DENSE - 1)]
    places, margins, bends = _minima(coefficients, low, high, at[points])
    bounds = np.array([(piece.start, piece.end) for piece in pieces])
    lengths = np.diff(bounds, axis=1)[:, 0]
    instants = bounds[numbers, 0] + 0.5 * (places + 1.0) * lengths[numbers]
    curvatures = bends * (2.0 / lengths[numbers]) ** 2
    at_ends = np.abs(steps[:, None, None] - bounds).min(axis=0) < 2.0 * AFTER
    ends = np.stack([piece.dense[[0, -1]] for piece in pieces])[numbers, :, columns]
    names = map(sides.names.__getitem__, columns.tolist())
    found = (
        sides.entry[columns], instants, margins,
        np.stack([piece.errors for piece in pieces])[numbers, columns], sides.upper[columns],
        curvatures, np.where(at_ends[numbers], ends, np.inf).min(axis=1),
    )  # fmt: skip
    yield from map(Extreme, names, *(one.tolist() for one in found))


def _minima(coefficients: Array, low: Array, high: Array, x: Array) -> tuple[Array, Array, Array]:
    """Return place, value and second derivative at the minima of Chebyshev series (NODES, M).

    The brackets have shape (M,), like the results.

    Newton's method on the derivative, halving the bracket where a step would leave it.
    """
    series = [matrix @ coefficients for matrix in _slopes()]
    begin = x
    for _ in range(NEWTON):
        terms = _terms(x)
        d1, d2 = ((terms.T * one).sum(axis=0) for one in series)
        low, high = np.where(d1 > 0.0, low, x), np.where(d1 > 0.0, x, high)
        step = x - d1 / np.where(d2 > 0.0, d2, 1.0)
        x = np.where((d2 > 0.0) & (low <= step) & (step <= high), step, 0.5 * (low + high))
    better = _sum(x, coefficients) <= _sum(begin, coefficients)
    x = np.where(better, x, begin)
    return x, _sum(x, coefficients), _sum(x, series[1])


@lru_cache(maxsize=1)
def _slopes() -> tuple[Array, Array]:
    """Matrices (NODES, NODES) from coefficients of a series to those of its two derivatives."""
    one = np.eye(NODES)
    first, second = (np.pad(chebyshev.chebder(one, k), ((0, k), (0, 0))) for k in (1, 2))
    return np.asarray(first), np.asarray(second)


def _sum(x: Array, coefficients: Array) -> Array:
    """Return Chebyshev series (NODES, M), each at its own place (M,)."""
    return np.asarray((_terms(x).T * coefficients).sum(axis=0))


def _terms(x: Array) -> Array:
    """Return the Chebyshev polynomials at places (M,), shape (M, NODES)."""
    return np.asarray(np.cos(np.arccos(np.clip(x, -1.0, 1.0))[:, None] * np.arange(NODES)))
