"""Limits held at instants close together: the search ends, and the walk is certified."""

import numpy as np
from places import CASES

from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.gait.grid import Grid
from gaitopt.gait.presets import humanoid_task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Status, violations


def test_a_knee_that_touches_its_limit_between_two_instants_is_certified():
    """Its flexion is held at 0.0125, 0.0130 and 0.0135 of the step, with nearly equal gradients."""
    robot = Robot.from_urdf(CASES / "base_mini.urdf")
    found = design(robot, humanoid_task(robot, speed=0.5), DesignOptions(diagnose=False))
    assert found.certificate.certified, found.certificate.verdict
    assert found.solution.status is Status.OPTIMAL
    assert found.solution.iterations < 200
    s = np.linspace(0.0, 1.0, 5001)
    dense = found.problem.with_grid(Grid(s, np.ones(5001), 5001))
    rows = dense.values(found.solution.x).rows
    assert violations(dense.rows.lower, dense.rows.upper, rows).max() < 1e-6
