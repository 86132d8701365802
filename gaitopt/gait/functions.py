"""Functions of a step's quantities at one instant, with exact first and second derivatives.

Constraints and the integrands of costs are made of them. A function maps the entries of one
quantity, or of several side by side, to rows, for all instants at once: (K, entries) to (K, rows).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property

import numpy as np

from gaitopt.bounds import shown
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, own_code
from gaitopt.model.coupling import Coupling
from gaitopt.nlp import Array
from gaitopt.settings import checked_facts


class QuantityFunction(ABC):
    """A function from the entries of quantities at an instant (e,) to rows (r,)."""

    @property
    def as_they_are(self) -> slice | None:
        """The entries that its rows are, unchanged; None where they are something else."""
        return None

    @property
    def as_matrix(self) -> Array | None:
        """The constant matrix by which it multiplies, (r, e) or (K, r, e); None: it is no such."""
        return None

    @abstractmethod
    def value(self, quantity: Array) -> Array:
        """Return the rows (K, r) of quantities (K, e)."""

    @abstractmethod
    def jacobian(self, quantity: Array) -> Array:
        """Return d rows / d quantity, shape (K, r, e), or (r, e) where it is constant."""

    def hessian(self, quantity: Array, weights: Array) -> Array | None:
        """Return the Hessian of weights . rows, weights (K, r), shape (K, e, e); None if zero.

        By default central differences of `vjp`, to about 1e-9 of their size: leave it out rather
        than approximate it, as Gauss and Newton do.
        """
        size = _RELATIVE * np.maximum(1.0, np.abs(quantity))
        columns = []
        for entry in range(quantity.shape[1]):
            move = np.zeros(quantity.shape)
            move[:, entry] = size[:, entry]
            change = self.vjp(quantity + move, weights) - self.vjp(quantity - move, weights)
            columns.append(change / (2.0 * size[:, entry, None]))
        hessian = np.stack(columns, axis=2)
        return np.asarray(0.5 * (hessian + hessian.swapaxes(1, 2)))

    def chained(self, quantity: Array, jacobian: Array) -> Array:
        """Return d rows / d x, shape (K, r, P), from d quantity / d x, shape (K, e, P)."""
        return np.asarray(self.jacobian(quantity) @ jacobian)

    def vjp(self, quantity: Array, weights: Array) -> Array:
        """Return the gradient of weights . rows in the quantity, weights (K, r), shape (K, e)."""
        return np.asarray((weights[:, None] @ self.jacobian(quantity))[:, 0])


@checked_facts
@dataclass(frozen=True)
class Linear(QuantityFunction):
    """Rows = matrix @ quantity, matrix (r, e), or (K, r, e) where each instant has its own.

    Raises:
        InputError: the matrix is of no real numbers, or of another number of axes.
    """

    matrix: Array

    def __post_init__(self) -> None:
        matrix = real_array(self.matrix, "the matrix of a Linear")
        if matrix.ndim not in (2, 3):
            raise InputError(
                f"the matrix of a Linear has shape {matrix.shape}; give (rows, entries), as "
                "np.ones((1, 12)) for the sum of 12"
            )
        object.__setattr__(self, "matrix", matrix)

    @property
    def as_matrix(self) -> Array:
        return self.matrix

    def value(self, quantity: Array) -> Array:
        check_width(self.matrix.shape[-1], quantity, "a Linear has a matrix of {} columns")
        if self.matrix.ndim == 3:
            return np.asarray((self.matrix @ quantity[:, :, None])[:, :, 0])
        return quantity @ self.matrix.T

    def jacobian(self, quantity: Array) -> Array:
        del quantity
        return self.matrix

    def hessian(self, quantity: Array, weights: Array) -> None:
        del quantity, weights


@dataclass(frozen=True)
class Followers(QuantityFunction):
    """Rows = factor * angles of some of all joints, from those of the joints that follow no other.

    Attributes:
        coupling: of all joints.
        chosen: which of them.
        factor: of each row, shape (r,).
    """

    coupling: Coupling
    chosen: slice
    factor: Array

    def value(self, quantity: Array) -> Array:
        return np.asarray(self.factor * self.coupling.angles(quantity)[:, self.chosen])

    def jacobian(self, quantity: Array) -> Array:
        matrix = self.coupling.at(quantity).matrix[..., self.chosen, :]
        return np.asarray(self.factor[:, None] * matrix)

    def hessian(self, quantity: Array, weights: Array) -> Array | None:
        """Return the Hessian, shape (K, m, m); None where ties are affine."""
        bend = self.coupling.at(quantity).bend
        if bend is None:
            return None
        of_all = np.zeros(bend.shape)
        of_all[:, self.chosen] = weights * self.factor * bend[:, self.chosen]
        return self.coupling.diagonal(of_all)


@checked_facts
@dataclass(frozen=True)
class Entries(QuantityFunction):
    """Rows = factor * chosen entries: a linear function without a product.

    Attributes:
        chosen: a slice of the entries, so that nothing is copied.
        count: number of entries of the quantity.
        factor: one for all rows, or shape (r,).

    Raises:
        InputError: the factor is no real number, and none for each entry chosen.
    """

    chosen: slice
    count: int
    factor: float | Array = 1.0

    def __post_init__(self) -> None:
        if isinstance(self.factor, float):  # as of nearly all
            return
        factor = np.asarray(self.factor)
        if factor.dtype.kind not in "fiub":
            return  # refused, as it is of another kind
        rows = len(range(*self.chosen.indices(self.count)))
        if factor.ndim and factor.shape != (rows,):
            raise InputError(
                f"the factor of Entries has shape {factor.shape}; give a number, or one for each "
                f"of the {rows} entries chosen"
            )
        object.__setattr__(self, "factor", factor if factor.ndim else float(factor))

    @cached_property
    def plain(self) -> bool:
        """Whether its rows are entries as they are."""
        return isinstance(self.factor, float) and self.factor == 1.0

    @property
    def as_they_are(self) -> slice | None:
        return self.chosen if self.plain else None

    @property
    def as_matrix(self) -> Array:
        return np.asarray(np.eye(self.count)[self.chosen] * np.reshape(self.factor, (-1, 1)))

    def value(self, quantity: Array) -> Array:
        check_width(self.count, quantity, "Entries of {}")
        chosen = quantity[:, self.chosen]
        return chosen if self.plain else np.asarray(chosen * self.factor)

    def jacobian(self, quantity: Array) -> Array:
        del quantity
        return self.as_matrix

    def chained(self, quantity: Array, jacobian: Array) -> Array:
        del quantity
        chosen = jacobian[:, self.chosen]
        if self.plain:
            return chosen
        return np.asarray(chosen * np.reshape(self.factor, (-1, 1)))

    def vjp(self, quantity: Array, weights: Array) -> Array:
        gradient = np.zeros(quantity.shape)
        gradient[:, self.chosen] = weights * self.factor
        return gradient

    def hessian(self, quantity: Array, weights: Array) -> None:
        del quantity, weights


@dataclass(frozen=True)
class ByStep(QuantityFunction):
    """Rows of the steps of a stride one after another, each by a function of its own.

    Attributes:
        functions: of the steps, with the same number of rows.
        ends: number of instants up to the end of each step.
    """

    functions: tuple[QuantityFunction, ...]
    ends: tuple[int, ...]

    @property
    def as_they_are(self) -> slice | None:
        first = self.functions[0].as_they_are
        return first if all(one.as_they_are == first for one in self.functions) else None

    @property
    def as_matrix(self) -> Array | None:
        found = [one.as_matrix for one in self.functions]
        counts = np.diff([0, *self.ends])
        each = [
            np.broadcast_to(one, (count, *one.shape[-2:]))
            for one, count in zip(found, counts, strict=True)
            if one is not None
        ]
        return np.concatenate(each) if len(each) == len(found) else None

    def value(self, quantity: Array) -> Array:
        return np.concatenate([f.value(q) for f, q in self._parts(quantity)])

    def jacobian(self, quantity: Array) -> Array:
        found = []
        for function, part in self._parts(quantity):
            one = function.jacobian(part)
            found.append(np.broadcast_to(one, (len(part), *one.shape[-2:])))
        return np.concatenate(found)

    def chained(self, quantity: Array, jacobian: Array) -> Array:
        parts = zip(self._parts(quantity), self._cut(jacobian), strict=True)
        return np.concatenate([f.chained(q, slopes) for (f, q), slopes in parts])

    def vjp(self, quantity: Array, weights: Array) -> Array:
        parts = zip(self._parts(quantity), self._cut(weights), strict=True)
        return np.concatenate([f.vjp(q, w) for (f, q), w in parts])

    def hessian(self, quantity: Array, weights: Array) -> Array | None:
        parts = zip(self._parts(quantity), self._cut(weights), strict=True)
        found = [(q, f.hessian(q, w)) for (f, q), w in parts]
        if all(H is None for _, H in found):
            return None
        none = np.zeros((1, quantity.shape[1], quantity.shape[1]))
        return np.concatenate([none.repeat(len(q), axis=0) if H is None else H for q, H in found])

    def _parts(self, quantity: Array) -> list[tuple[QuantityFunction, Array]]:
        return list(zip(self.functions, self._cut(quantity), strict=True))

    def _cut(self, rows: Array) -> list[Array]:
        return np.split(rows, self.ends[:-1])


@dataclass(frozen=True)
class StrideSpeed(QuantityFunction):
    """Rows (f V - forward, f W - left) of an average step of a stride that turns at a rate.

    The footprints follow a screw motion of V, W and the rate w in the plane. With a turn of
    phi = w T in a step, steps of d forward and to the left are then f = (2 / w) tan(phi / 2)
    seconds of it long, T where w = 0 (docs/derivations.md).

    Attributes:
        speed, lateral_speed: V, W [m/s].
        turn_rate: w [rad/s].
    """

    speed: float
    lateral_speed: float
    turn_rate: float

    def value(self, quantity: Array) -> Array:
        return np.asarray(self._seconds(quantity[:, 2])[0] * self._way - quantity[:, :2])

    def jacobian(self, quantity: Array) -> Array:
        found = np.tile(-np.eye(2, quantity.shape[1]), (len(quantity), 1, 1))
        found[:, :, 2] = self._seconds(quantity[:, 2])[1] * self._way
        return found

    def hessian(self, quantity: Array, weights: Array) -> Array:
        found = np.zeros((len(quantity), quantity.shape[1], quantity.shape[1]))
        found[:, 2, 2] = self._seconds(quantity[:, 2])[2][:, 0] * (weights @ self._way)
        return found

    @property
    def _way(self) -> Array:
        return np.array([self.speed, self.lateral_speed])

    def _seconds(self, T: Array) -> tuple[Array, Array, Array]:
        """Seconds of the screw motion that a step is long, and its derivatives, (K, 1) each."""
        w, T = self.turn_rate, T[:, None]
        if w == 0.0:
            return T, np.ones(T.shape), np.zeros(T.shape)
        t = np.tan(0.5 * w * T)
        return 2.0 / w * t, 1.0 + t**2, w * t * (1.0 + t**2)


@checked_facts
@dataclass(frozen=True)
class FrictionCone(QuantityFunction):
    """mu f_z - sqrt(f_x² + f_y² + smoothing²) of a force (or force and moment), Eqs. (33), (34).

    The smoothing keeps the cone differentiable where the force is vertical.

    Attributes:
        friction: coefficient mu.
        smoothing: [N], or [N·s] of an impulse.
    """

    friction: float
    smoothing: float

    def value(self, quantity: Array) -> Array:
        return self.friction * quantity[:, 2:3] - self._tangential(quantity)[:, None]

    def jacobian(self, quantity: Array) -> Array:
        jacobian = np.zeros((quantity.shape[0], 1, quantity.shape[1]))
        jacobian[:, 0, :2] = -quantity[:, :2] / self._tangential(quantity)[:, None]
        jacobian[:, 0, 2] = self.friction
        return jacobian

    def hessian(self, quantity: Array, weights: Array) -> Array:
        length = self._tangential(quantity)[:, None, None]
        f = quantity[:, :2]
        hessian = np.zeros((*quantity.shape, quantity.shape[1]))
        hessian[:, :2, :2] = (f[:, :, None] * f[:, None, :] / length**2 - np.eye(2)) / length
        return weights[:, :1, None] * hessian

    def _tangential(self, quantity: Array) -> Array:
        x, y = quantity[:, 0], quantity[:, 1]
        return np.asarray(np.sqrt(x**2 + y**2 + self.smoothing**2))


@checked_facts
@dataclass(frozen=True)
class Torsion(QuantityFunction):
    """c f_z -+ M of a force and moment, M about the vertical through the centre of pressure.

    M = m_z + (m_x f_x + m_y f_y) / f_z, with f_z / (f_z² + least²) for 1 / f_z, so that it stays
    smooth where the load vanishes; there M is about the origin.

    Attributes:
        coefficient: c [m].
        least: load below which M is about the origin [N], or [N·s] of an impulse.
    """

    coefficient: float
    least: float

    def value(self, quantity: Array) -> Array:
        f, m = quantity[:, :3], quantity[:, 3:]
        lever = (m[:, :2] * f[:, :2]).sum(axis=1)
        moment, limit = m[:, 2] + lever * self._inverse(f)[0], self.coefficient * f[:, 2]
        return np.stack([limit - moment, limit + moment], axis=1)

    def jacobian(self, quantity: Array) -> Array:
        f, m = quantity[:, :3], quantity[:, 3:]
        g, dg, _ = self._inverse(f)
        moment = np.zeros(quantity.shape)
        moment[:, :2], moment[:, 3:5] = m[:, :2] * g[:, None], f[:, :2] * g[:, None]
        moment[:, 2], moment[:, 5] = (m[:, :2] * f[:, :2]).sum(axis=1) * dg, 1.0
        limit = self.coefficient * np.eye(6)[2]
        return np.stack([limit - moment, limit + moment], axis=1)

    def hessian(self, quantity: Array, weights: Array) -> Array:
        f, m = quantity[:, :3], quantity[:, 3:]
        g, dg, ddg = self._inverse(f)
        upper = np.zeros((len(quantity), 6, 6))
        upper[:, 0, 3] = upper[:, 1, 4] = g
        upper[:, :2, 2], upper[:, 2, 3:5] = m[:, :2] * dg[:, None], f[:, :2] * dg[:, None]
        hessian = upper + upper.swapaxes(1, 2)
        hessian[:, 2, 2] = (m[:, :2] * f[:, :2]).sum(axis=1) * ddg
        return np.asarray((weights[:, 1] - weights[:, 0])[:, None, None] * hessian)

    def _inverse(self, force: Array) -> tuple[Array, Array, Array]:
        """f_z / (f_z² + least²) and its two derivatives, shape (K,) each."""
        f, square = force[:, 2], force[:, 2] ** 2 + self.least**2
        second = 2.0 * f * (f**2 - 3.0 * self.least**2) / square**3
        return f / square, (self.least**2 - f**2) / square**2, second


@dataclass(frozen=True)
class Length(QuantityFunction):
    """Euclidean length of a vector, Eq. (31)."""

    def value(self, quantity: Array) -> Array:
        return np.asarray(np.linalg.norm(quantity, axis=1)[:, None])

    def jacobian(self, quantity: Array) -> Array:
        return (quantity / self.value(quantity))[:, None, :]

    def hessian(self, quantity: Array, weights: Array) -> Array:
        length = self.value(quantity)[:, :, None]
        u = self.jacobian(quantity)
        return weights[:, :1, None] * (np.eye(quantity.shape[1]) - u.swapaxes(1, 2) * u) / length


@checked_facts
@dataclass(frozen=True)
class SquaredNorm(QuantityFunction):
    """Sum of w_i v_i², the integrand of Eq. (46) with weights.

    Attributes:
        weights: shape (e,).

    Raises:
        InputError: they are no real numbers, or not one for each entry.
    """

    weights: Array

    def __post_init__(self) -> None:
        weights = real_array(self.weights, "the weights of a SquaredNorm")
        if weights.ndim != 1:
            raise InputError(
                f"the weights of a SquaredNorm have shape {weights.shape}; give one for each entry "
                "of what it reads, as np.ones(12)"
            )
        object.__setattr__(self, "weights", weights)

    def value(self, quantity: Array) -> Array:
        check_width(len(self.weights), quantity, "a SquaredNorm has {} weights")
        return np.asarray(((quantity**2) @ self.weights)[:, None])

    def jacobian(self, quantity: Array) -> Array:
        return (2.0 * self.weights * quantity)[:, None]

    def vjp(self, quantity: Array, weights: Array) -> Array:
        return np.asarray(weights * (2.0 * self.weights * quantity))

    def hessian(self, quantity: Array, weights: Array) -> Array:
        del quantity
        return weights[:, :1, None] * self._bend

    @cached_property
    def _bend(self) -> Array:
        return np.diag(2.0 * self.weights)


@checked_facts
@dataclass(frozen=True)
class ComplexStep(QuantityFunction):
    """A function given by its value alone, differentiated numerically instant by instant.

    First derivatives come from complex steps, exact to rounding (Squire & Trapp, SIAM Review 40,
    1998); second ones are central differences of those, to about 1e-9 of their size. The function
    must be smooth and made of operations that NumPy extends to complex numbers: `np.sqrt(v**2)`
    and `v @ A`, not `abs`, `np.linalg.norm`, `np.maximum` or comparisons.

    Attributes:
        function: from quantities (K, e) to rows (K, r).
    """

    function: Callable[[Array], Array]

    def value(self, quantity: Array) -> Array:
        return np.asarray(self.function(quantity), dtype=np.float64)

    def jacobian(self, quantity: Array) -> Array:
        columns = []
        for entry in range(quantity.shape[1]):
            moved = quantity.astype(np.complex128)
            moved[:, entry] += 1j * _TINY
            columns.append(np.imag(self.function(moved)) / _TINY)  # type: ignore[arg-type]
        return np.stack(columns, axis=2)


def check_width(width: int, quantity: Array, has: str) -> None:
    """Refuse quantities (K, e) of another width than a function has entries for.

    Args:
        has: what it has of that width, as "a SquaredNorm has {} weights".

    Raises:
        InputError: they are.
    """
    if quantity.shape[-1] != width:
        entries = quantity.shape[-1]
        raise InputError(f"{has.format(width)}, but what it reads has {entries}; give {entries}")


def check_function(function: QuantityFunction, typical: Array, rows: int, what: str) -> None:
    """Check a function of one's own: shapes, and derivatives against differences.

    Args:
        function: to check, near typical values of its quantities.
        typical: these values, shape (e,).
        rows: how many it should have.
        what: it belongs to, as "the cost 'calm'".

    Raises:
        InputError: it cannot be evaluated, returns another shape, or a derivative is wrong.
    """
    if not typical.size:
        raise InputError(f"what {what} reads has no entries for this robot")
    if not isinstance(function, QuantityFunction):
        raise InputError(
            f"{what} has {shown(function)} for its function; return a QuantityFunction, as Entries "
            "or ComplexStep"
        )
    random, width = np.random.default_rng(0), typical.size
    at, move = typical * random.uniform(0.5, 1.5, (2, _INSTANTS, width))
    at.flags.writeable = False  # quantities are for all: nobody may write into them
    whole = f"the function of {what} cannot be evaluated at {_INSTANTS} instants of {width} entries"
    with own_code(function, whole), _told_of(what):
        with np.errstate(all="ignore"):  # it need have no value there
            value = real_array(function.value(at), f"the value of the function of {what}")
        if value.shape != (_INSTANTS, rows):
            raise InputError(
                f"the function of {what} returns shape {value.shape} for {_INSTANTS} instants of "
                f"{width} entries; return ({_INSTANTS}, {rows})"
            )
        if not np.isfinite(value).all():
            return  # it has no value there; elsewhere it may
        weights = random.uniform(0.5, 1.5, (_INSTANTS, rows))
        jacobian, hessian = function.jacobian(at), function.hessian(at, weights)
        jacobian = shaped(
            jacobian, (_INSTANTS, rows, width), f"the jacobian of the function of {what}"
        )
        hessian = shaped(
            0.0 if hessian is None else hessian,
            (_INSTANTS, width, width),
            f"the hessian of the function of {what}",
        )
        h = _CHECK * move
        change = (function.value(at + h) - function.value(at - h)) / (2.0 * _CHECK)
        ahead, back = (
            shaped(function.vjp(x, weights), at.shape, f"the vjp of the function of {what}")
            for x in (at + h, at - h)
        )
        vjp_change = (ahead - back) / (2.0 * _CHECK)
    for name, exact, found in (
        ("jacobian", (jacobian @ move[:, :, None])[:, :, 0], change),
        ("hessian", (hessian @ move[:, :, None])[:, :, 0], vjp_change),
    ):
        size = max(float(np.abs(found).max()), float(np.abs(jacobian).max()), 1e-6)
        if exact.shape != found.shape or not np.abs(exact - found).max() <= 1e-4 * size:
            raise InputError(
                f"the {name} of the function of {what} disagrees with differences of its value; "
                "correct it"
                + (
                    ", or leave it out: then it is taken from differences of the jacobian"
                    if name == "hessian"
                    else ""
                )
                + ", or give the value alone to ComplexStep (which takes smooth functions that "
                "extend to complex numbers: not abs, norm, maximum)"
            )


@contextmanager
def _told_of(what: str) -> Iterator[None]:
    """Tell of what a function is that refuses what it reads."""
    try:
        yield
    except InputError as error:
        told = str(error)
        raise InputError(told if what in told else f"{told} ({what})") from error


def real_array(values: object, what: str) -> Array:
    """Return what code of one's own gives as an array of real numbers, of the shape that it has.

    Args:
        what: it is, as "the gradient of the cost 'calm'".

    Raises:
        InputError: it is none.
    """
    try:
        array = np.asarray(values)
    except ValueError:  # rows of different lengths
        array = np.array(None)
    if array.dtype.kind not in "fiub":
        raise InputError(f"{what} is {shown(values)}; give an array of real numbers")
    return array


def shaped(values: object, shape: tuple[int, ...], what: str) -> Array:
    """Return what `real_array` does, with a shape that its own can be broadcast to.

    Raises:
        InputError: it cannot.
    """
    array = real_array(values, what)
    try:
        return np.broadcast_to(array, shape)
    except ValueError as error:
        raise InputError(f"{what} has shape {array.shape}; return {shape}") from error


_TINY = 1e-30  # complex step: no difference is taken, so it may be as small
_RELATIVE = 1e-5  # step of differences of derivatives, over the entry or one unit
_INSTANTS = 2  # at which a function is checked, as all of them are asked for at once
_CHECK = 1e-4  # step of the differences of a check, over typical values
