"""The audit of a gait that was just designed; damaged files are tested with the command line."""

from dataclasses import fields

import pytest

from gaitopt import audit
from gaitopt.design.audit import problem_of
from gaitopt.gait.result import OPTIONAL, array_names
from gaitopt.model.multibody import Multibody


def test_fresh_gait_passes(refined_design):
    found = audit(refined_design.gait)
    assert found.passed
    robot = {f"robot_{one.name}" for one in fields(Multibody)}
    assert set(found.differences) == {*array_names(), *OPTIONAL, *robot}
    assert max(found.differences.values()) < 1e-12


def test_recovers_the_walk(refined_design):
    problem = problem_of(refined_design.gait)
    assert set(problem.grid.instants) == set(refined_design.problem.grid.instants)
    assert problem.grid.count > problem.task.samples  # refinement added some
    x = refined_design.gait.parameters
    assert problem.values(x).cost == pytest.approx(refined_design.gait.cost, rel=1e-12)


def test_certificate_is_that_of_the_design(refined_design):
    found, stored = audit(refined_design.gait).certificate, refined_design.certificate
    assert found.cost == pytest.approx(stored.cost, rel=1e-12)
    assert found.verdict == stored.verdict == "certified"
