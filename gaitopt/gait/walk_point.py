"""A point of the walk's program at which gaps between bodies keep their derivatives as products.

There is a row for every pair of bodies that may meet and every instant, thousands with moving arms,
and a solver looks at few of them. All depend on the joint angles alone, so that their Jacobian is
a small one in these times the derivatives of the angles, and is formed for the rows asked for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.gait import quantities
from gaitopt.gait.quantities import Quantity
from gaitopt.mechanics import compiled
from gaitopt.mechanics.forward_kinematics import PostureQuantityDerivatives
from gaitopt.nlp import Array, Indices, Point, Values

if TYPE_CHECKING:
    from gaitopt.gait.constraint import ConstraintBlock


@dataclass(frozen=True)
class Table:
    """Derivatives in x of rows.

    Attributes:
        table: shape (k, P), or of r numbers at K instants, which are counted instant by instant,
            shape (K, r, P).
        per_unit: by which each of those numbers is multiplied, shape (r,); None: by 1.
    """

    table: Array
    per_unit: Array | None = None

    @property
    def whole(self) -> Array:
        """The derivatives, as of `table`."""
        return self.table if self.per_unit is None else self.table * self.per_unit[:, None]

    @property
    def finite(self) -> bool:
        """Whether every derivative is a finite number."""
        return bool(np.isfinite(self.table).all())

    def __len__(self) -> int:
        """Return the number of rows."""
        return int(self.table.size // self.table.shape[-1])

    def __getitem__(self, rows: Indices) -> Array:
        """Return some rows by their numbers, ascending (k,), shape (k, P)."""
        if self.per_unit is None:
            return self.table[rows]
        instants, entries = np.divmod(rows, self.per_unit.size)
        return np.asarray(self.table[instants, entries] * self.per_unit[entries, None])

    def __matmul__(self, step: Array) -> Array:
        """Return the change of all rows along a step (P,), shape (k,) or (K r,)."""
        return _scaled(self.table @ step, self.per_unit)

    def most_change(self, scale: Array) -> Array:
        """Return as of `Point.most_change`, of all rows."""
        return _scaled(np.abs(self.table) @ scale, self.per_unit)


def _scaled(changes: Array, per_unit: Array | None) -> Array:
    return (changes if per_unit is None else changes * per_unit).ravel()


@dataclass(frozen=True)
class Product:
    """Derivatives in x of what depends on the joint angles alone, r numbers at K instants.

    As rows they are counted instant by instant, K r of them.

    Attributes:
        local: in the angles.
        angles: of the angles in x, shape (K, n, P).
        per_unit: by which each number is multiplied, shape (r,); None: by 1.
    """

    local: PostureQuantityDerivatives
    angles: Array
    per_unit: Array | None = None

    @property
    def each(self) -> tuple[Product, ...]:
        """It alone, as of `Stacked`."""
        return (self,)

    @property
    def whole(self) -> Array:
        """The derivatives, shape (K, r, P)."""
        found = self.local.jacobian @ self.angles
        return np.asarray(found if self.per_unit is None else found * self.per_unit[:, None])

    @property
    def finite(self) -> bool:
        """Whether every derivative is a finite number, as far as the angles' and values are."""
        return bool(np.isfinite(self.local.value).all() and np.isfinite(self.angles).all())

    def __len__(self) -> int:
        """Return the number of rows."""
        return self.local.value.size

    def __getitem__(self, rows: Indices) -> Array:
        """Return some rows by their numbers, ascending (k,), shape (k, P)."""
        instants, local = self._local(rows)
        found = np.empty((rows.size, self.angles.shape[2]))
        for instant in np.unique(instants):
            here = slice(*np.searchsorted(instants, [instant, instant + 1]))
            np.matmul(local[here], self.angles[instant], out=found[here])
        return found

    def __matmul__(self, step: Array) -> Array:
        """Return the change of all rows along a step (P,), shape (K r,)."""
        return _scaled(self.local.along(self.angles @ step), self.per_unit)

    def most(self, changes: Array, rows: Indices | None = None) -> Array:
        """Return a bound of the changes of all rows (K r,), or a closer one of some (k,).

        Args:
            changes: the most that each angle changes by, shape (K, n).
            rows: numbers of some.
        """
        if rows is None:
            return _scaled(self.local.most(changes), self.per_unit)
        instants, local = self._local(rows)
        return np.asarray((np.abs(local) * changes[instants]).sum(axis=1))

    def _local(self, rows: Indices) -> tuple[Indices, Array]:
        """Return the instants of some rows (k,), and their derivatives in the angles, (k, n)."""
        instants, entries = np.divmod(rows, self.local.value.shape[1])
        local = self.local.rows(instants, entries)
        return instants, local if self.per_unit is None else local * self.per_unit[entries, None]


@dataclass(frozen=True)
class Stacked:
    """Products of steps, the rows of each after those of the one before."""

    each: tuple[Product, ...]

    @property
    def whole(self) -> Array:
        """The derivatives, shape (K, r, P)."""
        return np.concatenate([one.whole for one in self.each])

    @property
    def finite(self) -> bool:
        """Whether every derivative is a finite number, as of `Product`."""
        return all(one.finite for one in self.each)

    def __getitem__(self, rows: Indices) -> Array:
        """Return some rows by their numbers, ascending (k,), shape (k, P)."""
        first = np.cumsum([0, *map(len, self.each)])
        cuts = pairwise(rows.searchsorted(first).tolist())
        found = zip(self.each, cuts, first.tolist()[:-1], strict=True)
        return np.concatenate([one[rows[slice(*cut)] - start] for one, cut, start in found])

    def __matmul__(self, step: Array) -> Array:
        """Return the change of all rows along a step (P,), shape (K r,)."""
        return np.concatenate([one @ step for one in self.each])


class Jacobians(dict[Quantity, Array]):
    """Derivatives of quantities in x, shape (K, entries, P) each; products are formed when read."""

    def __init__(
        self, formed: Mapping[Quantity, Array], products: Mapping[Quantity, Product | Stacked]
    ) -> None:
        """Take tables, and of other quantities products."""
        super().__init__(formed)
        self.products = products

    def kept(self, what: Quantity) -> Array | Product | Stacked:
        """Return the derivatives of a quantity as they are kept, shape (K, entries, P)."""
        product = self.products.get(what)
        return self[what] if product is None else product

    def __missing__(self, what: Quantity) -> Array:
        self[what] = whole = self.products[what].whole
        return whole


_LARGE = 50_000  # numbers: to scale fewer takes less time than to ask one part more for its rows


class LinearRows:
    """Rows that are a constant matrix times quantities, of all constraints that have such.

    Where kernels are built (`compiled`) they are made at once; else there are none of them. Rows of
    gaps are none, whose derivatives are not formed.

    Attributes:
        others: numbers of the constraints whose rows are made one after the other.
    """

    def __init__(
        self, blocks: Sequence[ConstraintBlock], edges: Indices, values: Mapping[Quantity, Array]
    ) -> None:
        """Prepare what does not depend on x; arguments as of `RowSlopes`."""
        sources: dict[Quantity, int] = {}
        linear = compiled.linear_rows() if compiled.in_use() else None
        self.others = list[int]()
        for number, (block, first) in enumerate(zip(blocks, edges.tolist(), strict=False)):
            gaps = not {*block.reads}.isdisjoint(quantities.BODY_GAPS)
            matrix = None if linear is None or gaps else block.function.as_matrix
            widths = [values[one].shape[1] for one in block.reads]
            if linear is None or matrix is None or not _fits(matrix, block, sum(widths)):
                self.others.append(number)
                continue
            read = [sources.setdefault(one, len(sources)) for one in block.reads]
            linear.add(first, read, widths, block.instants, matrix / block.scale[:, None])
        self._made, self._reads = linear, tuple(sources)

    def write(self, of: Mapping[Quantity, Array], found: Array, first: int = 0) -> None:
        """Write them, over their scales, into a table of rows that follow each other.

        Args:
            of: quantities, shape (K, entries) each, or their derivatives, (K, entries, P) each.
            found: shape (m,), or (m, P).
            first: number of its first row.
        """
        if self._made is not None:
            self._made.of([of[one] for one in self._reads], found, first)


def _kept(block: ConstraintBlock, values: Mapping[Quantity, Array], jacobians: Jacobians) -> bool:
    """Return whether rows are kept as they are: of gaps, or too many to be scaled one by one."""
    product = block.reads[0] in jacobians.products
    if not product and block.size * jacobians[quantities.TRAVEL].shape[-1] <= _LARGE:
        return False
    return block.whole(values)


def _fits(matrix: Array, block: ConstraintBlock, width: int) -> bool:
    """Return whether a matrix has the shape that a constraint's rows ask for."""
    shape = len(block.labels), width
    return matrix.shape in (shape, (len(block.instants), *shape))


class RowSlopes:
    """The Jacobian of a walk's rows, shape (m, P), formed as far as it is asked for.

    Newton's method asks for a dozen of a thousand rows, of a few constraints.
    """

    def __init__(
        self,
        blocks: Sequence[ConstraintBlock],
        edges: Indices,
        linear: LinearRows,
        values: Mapping[Quantity, Array],
        jacobians: Jacobians,
    ) -> None:
        """Take what it is formed of.

        Args:
            blocks: the rows of each constraint.
            edges: number of the first row of each, and of all, shape (blocks + 1,).
            linear: what makes many of them at once.
            values, jacobians: of the quantities, shape (K, entries) and (K, entries, P) each.
        """
        self._of: (
            tuple[Sequence[ConstraintBlock], LinearRows, Mapping[Quantity, Array], Jacobians] | None
        ) = blocks, linear, values, jacobians
        self._edges, self._width = edges, jacobians[quantities.TRAVEL].shape[-1]
        self._found: dict[int, Table | Product | Stacked] = {}
        self._parts: list[Table | Product] = []
        self._last: tuple[Indices, Array] | None = None
        self._most: tuple[Array, Array, dict[int, Array]] | None = None  # by scale
        self.asked = False  # whether someone asked for all rows

    def __getstate__(self) -> dict[str, object]:
        """Return what a copy has, all rows formed: what forms them cannot be copied."""
        self.form()
        return vars(self)

    def form(self) -> None:
        """Form all rows at once, which is cheaper than some first."""
        if self._of is not None:
            self._parts = _all_rows(self._edges, *self._of)
            self._found = dict(enumerate(self._parts))
            self._of = None  # which holds the memory of others
            self._edges = np.cumsum([0, *map(len, self._parts)])

    @property
    def parts(self) -> list[Table | Product]:
        """All rows in parts that follow each other, those formed in one table.

        Those of gaps, and many that are quantities as they are, are left as they are.
        """
        self.form()
        self.asked = True
        return self._parts

    def __getitem__(self, rows: Indices) -> Array:
        """Return some rows by their numbers, ascending (k,), shape (k, P)."""
        if rows.size == 0:
            return np.zeros((0, self._width))
        if self._last is None or not np.array_equal(self._last[0], rows):
            each = enumerate(self._by_part(rows))
            table = np.concatenate([self._part(one)[some] for one, some in each if some.size])
            table.setflags(write=False)
            self._last = rows, table
        return self._last[1]

    def _part(self, number: int) -> Table | Product | Stacked:
        if self._of is not None and number not in self._found:
            blocks, linear, values, jacobians = self._of
            if number in linear.others or _kept(blocks[number], values, jacobians):
                self._found[number] = _rows_of(blocks[number], values, jacobians)
            else:
                start, end = self._edges[number : number + 2].tolist()
                self._found[number] = Table(rows := np.empty((end - start, self._width)))
                linear.write(jacobians, rows, start)
        return self._found[number]

    def __matmul__(self, step: Array) -> Array:
        """Return the change of all rows along a step (P,), shape (m,)."""
        parts = map(self._part, range(self._edges.size - 1))
        return np.concatenate([part @ step for part in parts])

    def most_change(self, scale: Array, rows: Indices | None = None) -> Array:
        """Return as of `Point.most_change`; as if each joint moved by as much as it can."""
        if self._most is None or self._most[0] is not scale:
            self._most = scale, *self._bounds(scale)
        _, bounds, changes = self._most
        if rows is None:
            return bounds
        found, cuts = bounds[rows], rows.searchsorted(self._edges).tolist()
        for number, most in changes.items():  # of others, the bound is what they can
            part, here = self._parts[number], slice(*cuts[number : number + 2])
            if isinstance(part, Product) and here.start < here.stop:
                found[here] = part.most(most, rows[here] - self._edges[number])
        return found

    def _bounds(self, scale: Array) -> tuple[Array, dict[int, Array]]:
        """Return bounds of all rows (m,), and of each product, by number, of its angles (K, n)."""
        changes: dict[int, Array] = {}
        shared: dict[int, Array] = {}  # of the same angles
        found = []
        for number, part in enumerate(self.parts):
            if isinstance(part, Product):
                key = id(part.angles)
                if key not in shared:
                    shared[key] = np.abs(part.angles) @ scale
                changes[number] = shared[key]
                found.append(part.most(shared[key]))
            else:
                found.append(part.most_change(scale))
        bounds = np.concatenate(found)
        bounds.setflags(write=False)
        return bounds, changes

    def _by_part(self, rows: Indices) -> list[Indices]:
        """Return some rows by their numbers within the parts that they are of."""
        cuts = pairwise(rows.searchsorted(self._edges).tolist())
        each = zip(cuts, self._edges.tolist()[:-1], strict=True)
        return [rows[slice(*cut)] - first if cut[0] < cut[1] else rows[:0] for cut, first in each]

    @property
    def finite(self) -> bool:
        """Whether every derivative is a finite number.

        Until rows are formed, what they are formed of is looked at: where that is finite, they are
        too, but for functions of one's own, whose rows are formed at once.
        """
        if self._of is None:
            return all(part.finite for part in self._found.values())
        blocks, _, _, jacobians = self._of
        reads = dict.fromkeys(one for block in blocks for one in block.reads)
        sources = map(jacobians.kept, reads)
        return all(
            Table(one).finite if isinstance(one, np.ndarray) else one.finite for one in sources
        )

    @property
    def whole(self) -> Array:
        """All rows, shape (m, P)."""
        return np.concatenate([part.whole.reshape(len(part), -1) for part in self.parts])


def _all_rows(
    edges: Indices,
    blocks: Sequence[ConstraintBlock],
    linear: LinearRows,
    values: Mapping[Quantity, Array],
    jacobians: Jacobians,
) -> list[Table | Product]:
    """Return all rows; arguments as of `RowSlopes`."""
    found: list[Table | Product] = []
    cuts, width = list(pairwise(edges.tolist())), jacobians[quantities.TRAVEL].shape[-1]
    table, first = np.empty((cuts[-1][1], width)), 0
    kept = [number for number, one in enumerate(blocks) if _kept(one, values, jacobians)]
    for number in (*kept, None):
        start, end = (len(table),) * 2 if number is None else cuts[number]
        if first < start:
            linear.write(jacobians, table[first:start], first)
            found.append(Table(table[first:start]))
        if number is not None:
            rows = _rows_of(blocks[number], values, jacobians)
            found += rows.each if isinstance(rows, Stacked) else (rows,)
        first = end
    for number in linear.others:
        if number in kept:
            continue
        block, (start, end) = blocks[number], cuts[number]
        slopes = block.function.chained(block.take(values), block.take(jacobians))
        per_unit = np.repeat(1.0 / block.scale, width).reshape(-1, width)
        np.multiply(slopes, per_unit, out=table[start:end].reshape(slopes.shape))
    return found


def _rows_of(
    block: ConstraintBlock, values: Mapping[Quantity, Array], jacobians: Jacobians
) -> Table | Product | Stacked:
    """Return the rows of one constraint, gaps and entries of quantities as they are."""
    product, per_unit = jacobians.products.get(block.reads[0]), 1.0 / block.scale
    if product is not None and block.whole(values):
        return Stacked(tuple(replace(one, per_unit=per_unit) for one in product.each))
    chosen = block.function.as_they_are
    if chosen is not None:
        return Table(block.take(jacobians)[:, chosen], per_unit)
    return Table(block.function.chained(block.take(values), block.take(jacobians)), per_unit)


class WalkPoint(Point):
    """A point whose Jacobian is formed as far as it is asked for."""

    _slopes: RowSlopes

    def __init__(self, values: Values, gradient: Array, slopes: RowSlopes) -> None:
        """Take values, and the derivatives of the cost (P,) and of the rows."""
        vars(self).update(vars(values), gradient=gradient, _slopes=slopes)

    @property
    def slopes(self) -> RowSlopes:
        return self._slopes

    @cached_property
    def jacobian(self) -> Array:
        """The whole Jacobian, shape (m, P)."""
        return self.slopes.whole

    @property
    def finite(self) -> bool:
        return bool(np.isfinite(self.gradient).all()) and self.slopes.finite

    def most_change(self, scale: Array, rows: Indices | None = None) -> Array:
        return self.slopes.most_change(scale, rows)
