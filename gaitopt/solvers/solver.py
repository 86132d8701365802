"""What every solver looks like: a frozen dataclass of options that solves one nonlinear program."""

from __future__ import annotations

import math
from typing import Protocol

from gaitopt.errors import InputError
from gaitopt.nlp import NLP, ProgressCallback, Solution, Start


class Solver(Protocol):
    """Options of one method, and the method itself."""

    @property
    def name(self) -> str:
        """Name under which `solver_by_name` knows the solver."""

    def solve(
        self, nlp: NLP, start: Start, on_progress: ProgressCallback | None = None
    ) -> Solution:
        """Solve the program from `start`.

        Whatever happens on the way is told by `Solution.status`, never by an exception.

        Args:
            nlp: the program.
            start: where to begin; a point outside its bounds is moved onto them.
            on_progress: called once per iteration; a KeyboardInterrupt it raises stops the
                solver, which then returns its best iterate.
        """


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
