"""Walks whose motions are exported: a biped with arms and toes, and Unitree's G1."""

import pytest
from example_robots import example_robot
from first_walks import first_walk
from humanoids import add_arms, add_toes, edits, new_root
from urdf_edits import edited_urdf

from gaitopt.gait.result import Gait
from gaitopt.model.robot import Robot


@pytest.fixture(scope="session")
def armed() -> Gait:
    """A biped with a waist below its root, arms that stand still, toes, and a turned root."""
    urdf = edited_urdf(edits(new_root("0 0 1.2", waist="revolute"), add_arms(4), add_toes()))
    return first_walk(Robot.from_urdf(urdf), speed=0.6)


@pytest.fixture(scope="session")
def g1() -> Gait:
    """Unitree's G1 of 29 joints; only for tests with the mark `needs_example_robots`."""
    path = example_robot("g1_description/urdf/g1_29dof_rev_1_0.urdf")
    return first_walk(Robot.from_urdf(path), speed=0.5)
