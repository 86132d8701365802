"""What every solver looks like: a frozen dataclass of options that solves one nonlinear program."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar

from gaitopt.errors import InputError
from gaitopt.nlp import NLP, ProgressCallback, Solution, Start, StopCallback


class Solver(ABC):
    """Options of one method, and the method itself.

    Attributes:
        name: under which `solver_by_name` knows the solver.
    """

    name: ClassVar[str]

    @abstractmethod
    def solve(
        self,
        nlp: NLP,
        start: Start,
        on_progress: ProgressCallback | None = None,
        stop: StopCallback | None = None,
    ) -> Solution:
        """Solve the program from `start`.

        Whatever happens on the way is told by `Solution.status`, never by an exception.

        Args:
            nlp: the program.
            start: where to begin; a point outside its bounds is moved onto them.
            on_progress: called once per iteration.
            stop: asked once per iteration; where it says True, the solver returns its best
                iterate with the status INTERRUPTED.
        """

    @property
    def first_stage(self) -> Solver:
        """The solver that finds what `confirm` then confirms; itself where there is one stage."""
        return self

    def confirm(
        self,
        nlp: NLP,
        first: Solution,
        on_progress: ProgressCallback | None = None,
        stop: StopCallback | None = None,
    ) -> Solution:
        """Run the second stage from an answer of the first; where there is none, return that.

        Args:
            nlp: the program.
            first: what `first_stage` found.
            on_progress: called for every iteration of the second stage.
            stop: asked after every iteration of it.
        """
        del nlp, on_progress, stop
        return first

    def limited(self, iterations: int) -> Solver:
        """Return the solver with at most so many iterations of its first stage, if it counts."""
        del iterations
        return self


def require_positive(solver: str, **options: float) -> None:
    """Check that options are positive finite numbers.

    Raises:
        InputError: one of them is not.
    """
    for option, value in options.items():
        if not (math.isfinite(value) and value > 0):
            raise InputError(
                f"solver {solver}: option {option} is {value}, but must be a positive number"
            )


def require_choice(solver: str, option: str, value: str, allowed: tuple[str, ...]) -> None:
    """Check that an option is one of the words allowed.

    Raises:
        InputError: it is not.
    """
    if value not in allowed:
        raise InputError(
            f"solver {solver}: option {option} is {value!r}; choose one of {', '.join(allowed)}"
        )
