"""The points of a sweep: all combinations of the values of its axes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from gaitopt.bounds import POINTS, at_most
from gaitopt.errors import InputError
from gaitopt.study.axes import Axis

Index = tuple[int, ...]
"""Which value of each axis."""


@dataclass(frozen=True)
class GridPoints:
    """A grid and the points from which it is explored.

    Attributes:
        axes: at least one, with different names.
        seeds: where the exploration starts; by default both ends of the longest axis, in the middle
            of the others: the front is twice as wide and as many branches of optima are met as by
            starting from the middle and again at the ends, for fewer tries.

    Raises:
        InputError: no axis, one twice, or too many points.
    """

    axes: tuple[Axis, ...]
    seeds: tuple[Index, ...] = ()

    def __post_init__(self) -> None:
        names = [axis.name for axis in self.axes]
        if not names or len(set(names)) < len(names):
            raise InputError("a sweep needs at least one quantity, and each only once")
        at_most(math.prod(len(axis.values) for axis in self.axes), POINTS, "points of a sweep")
        if not self.seeds:
            object.__setattr__(self, "seeds", self._both_ends())

    @cached_property
    def order(self) -> tuple[Index, ...]:
        """All points, those near a seed first."""
        ranges = [range(len(axis.values)) for axis in self.axes]
        return tuple(sorted(itertools.product(*ranges), key=lambda p: (self._ring(p), p)))

    def values(self, point: Index) -> dict[str, float]:
        """Return the value of each quantity at a point."""
        return {a.name: a.values[i] for a, i in zip(self.axes, point, strict=True)}

    def neighbours(self, point: Index) -> Iterator[tuple[int, Index]]:
        """Yield the points one value away, each with the axis along which."""
        for k, axis in enumerate(self.axes):
            for step in (-1, 1):
                if 0 <= point[k] + step < len(axis.values):
                    yield k, (*point[:k], point[k] + step, *point[k + 1 :])

    def inner(self, point: Index) -> list[Index]:
        """Return the neighbours nearer to a seed: those that are explored before the point."""
        return [q for _, q in self.neighbours(point) if self._ring(q) < self._ring(point)]

    @property
    def probes(self) -> tuple[Index, ...]:
        """The ends of the lines through the seeds along each axis, where no seed is."""
        found = {
            (*seed[:k], end, *seed[k + 1 :])
            for seed in self.seeds
            for k, axis in enumerate(self.axes)
            for end in (0, len(axis.values) - 1)
        }
        return tuple(sorted(found - {*self.seeds}))

    def nearest(self, values: Mapping[str, float]) -> Index:
        """Return the point nearest to some values; quantities not given are in the middle.

        Raises:
            InputError: a quantity is not one of the axes.
        """
        unknown = set(values) - {axis.name for axis in self.axes}
        if unknown:
            raise InputError(
                f"the sweep is not over {', '.join(sorted(unknown))}; it is over "
                f"{', '.join(axis.name for axis in self.axes)}"
            )
        return tuple(
            min(range(len(axis.values)), key=lambda i: abs(axis.values[i] - values[axis.name]))
            if axis.name in values
            else start
            for axis, start in zip(self.axes, self._middle(), strict=True)
        )

    def name(self, point: Index) -> str:
        """Return the name of a point in files: "speed=0.85,duration=0.4"."""
        return ",".join(f"{name}={value:.10g}" for name, value in self.values(point).items())

    def _ring(self, point: Index) -> int:
        return min(sum(abs(i - j) for i, j in zip(point, seed, strict=True)) for seed in self.seeds)

    def _middle(self) -> Index:
        return tuple((len(axis.values) - 1) // 2 for axis in self.axes)

    def _both_ends(self) -> tuple[Index, ...]:
        middle, sizes = self._middle(), [len(axis.values) for axis in self.axes]
        k = sizes.index(max(sizes))
        ends = {0, sizes[k] - 1}
        return tuple(sorted((*middle[:k], end, *middle[k + 1 :]) for end in ends))
