"""SciPy's SLSQP as wrapped; what it finds is tested with the other solvers."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import textbook_programs as bank
from scipy import optimize

from gaitopt.nlp import Array, Start, Status
from gaitopt.solvers import SLSQP


def test_a_run_ended_by_the_callback_is_one_with_every_scipy(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    program, minimise, ended = bank.hs43(), optimize.minimize, []
    expected = SLSQP().solve(program, Start(program.start))

    def letting_through(*args: Any, callback: Any, **options: Any) -> Any:
        """Let StopIteration out, as SciPy before 1.17 does."""

        def watched(u: Array) -> None:
            try:
                callback(u)
            except StopIteration:
                ended.append(u)
                raise

        result = minimise(*args, callback=watched, **options)
        if ended:
            raise StopIteration
        return result

    monkeypatch.setattr(optimize, "minimize", letting_through)
    solution = SLSQP().solve(program, Start(program.start))
    assert len(ended) == 1
    assert solution.status is Status.OPTIMAL
    np.testing.assert_array_equal(solution.x, expected.x)
    np.testing.assert_allclose(solution.x, program.solution, atol=1e-4)


@pytest.mark.parametrize("stuck", [False, True])
def test_a_line_search_that_gives_up_far_from_feasible_is_begun_anew(
    monkeypatch: pytest.MonkeyPatch, stuck: bool
) -> None:
    """It ended there as infeasible: SciPy's learnt curvature was poor, not the program."""
    program, minimise, begun = bank.hs43(), optimize.minimize, []
    beyond = np.full_like(program.start, 5.0)  # violates all three rows

    def giving_up(fun: Any, start: Array, **more: Any) -> Any:
        begun.append(start.copy())
        if stuck or len(begun) == 1:
            return SimpleNamespace(x=start if len(begun) > 1 else beyond, status=8)
        return minimise(fun, start, **more)

    monkeypatch.setattr(optimize, "minimize", giving_up)
    solution = SLSQP().solve(program, Start(program.start))
    np.testing.assert_array_equal(begun[1], beyond)
    assert len(begun) == 2
    assert solution.status is (Status.INFEASIBLE if stuck else Status.OPTIMAL)
    if not stuck:
        np.testing.assert_allclose(solution.x, program.solution, atol=1e-4)
