"""What confirms a walk may not let go of limits between its samples."""

from dataclasses import replace

import pytest

from gaitopt.design.options import Search
from gaitopt.design.pipeline import attempt, complete
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.problem import WalkProblem
from gaitopt.solvers.two_stage import UNCONFIRMED, ConfirmedSQP


@pytest.fixture
def loose(refined_design):
    """A walk at its samples, and its solution, which exceeds limits between them."""
    problem = WalkProblem(refined_design.problem.robot, refined_design.problem.task)
    return problem, attempt(problem, Search(), first_guess(problem))


@pytest.mark.parametrize("careless", [1, 2])
def test_a_limit_let_go_is_held_again(loose, monkeypatch, careless):
    problem, solution = loose
    usual, calls = ConfirmedSQP.confirm, []

    def confirm(self, nlp, first, *rest):
        calls.append(first)
        if len(calls) <= careless:
            return replace(first, x=solution.x)
        return usual(self, nlp, first, *rest)

    monkeypatch.setattr(ConfirmedSQP, "confirm", confirm)
    found = complete(problem, solution, Search())
    assert len(calls) == 2
    assert found.certificate.certified
    assert (found.solution.solver == UNCONFIRMED) == (careless == 2)
