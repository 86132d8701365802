import numpy as np
import pytest
from textbook_programs import hs43

from gaitopt.nlp import Start
from gaitopt.solvers.globalization import EXCESS, initial_penalty
from gaitopt.solvers.solver import make_iterate
from gaitopt.solvers.sqp import SQP

FROM = np.array([0.0, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def solved():
    """HS 43, whose multipliers are 1, 0 and 2 (Hock & Schittkowski, 1981)."""
    nlp = hs43()
    return nlp, SQP().solve(nlp, Start(FROM))


def begun(nlp, x, multipliers=None):
    zero = np.zeros(nlp.rows.lower.size)
    given = zero if multipliers is None else multipliers
    return make_iterate(nlp, nlp.point(x), given, np.zeros(x.size))


def test_a_solution_is_worth_its_multipliers(solved):
    nlp, solution = solved
    expected = EXCESS * np.abs(solution.multipliers).sum()
    assert expected > 1.0
    known = initial_penalty(nlp, begun(nlp, solution.x, solution.multipliers), 0.1)
    found = initial_penalty(nlp, begun(nlp, solution.x), 0.1)
    assert known == pytest.approx(expected)
    assert found == pytest.approx(expected, rel=1e-4)


def test_the_usual_penalty_is_the_least(solved):
    nlp, solution = solved
    assert initial_penalty(nlp, begun(nlp, solution.x), 1e3) == 1e3


def test_a_start_far_from_its_limits_tells_nothing(solved):
    nlp, _ = solved
    assert initial_penalty(nlp, begun(nlp, np.full(4, 9.0)), 7.0) == 7.0
