"""Capsules outlive the meshes they were found in."""

import pytest
from example_robots import example_robot, needs_example_robots

from gaitopt.errors import RobotError
from gaitopt.mechanics.capsule_distance import leg_pairs
from gaitopt.model.capsules import capsule_rows, leg_capsules
from gaitopt.model.import_options import ImportOptions, choices_from_record, choices_record
from gaitopt.model.robot import Robot


def test_capsules_are_the_same_from_their_record(robot):
    chosen = robot.choices.over(capsules=capsule_rows(leg_capsules(robot)), package_dirs=())
    again = Robot.from_urdf(robot.urdf, choices=choices_from_record(choices_record(chosen)))
    assert leg_capsules(again) == leg_capsules(robot)
    assert leg_pairs(again).names == leg_pairs(robot).names


@needs_example_robots
def test_a_robot_remembers_where_its_meshes_are():
    path = example_robot("talos_data/robots/talos_reduced.urdf")
    robot = Robot.from_urdf(path)
    from_text = Robot.from_urdf(robot.urdf, choices=robot.choices)
    assert {c.source for c in leg_capsules(from_text)} == {"collision"}
    rows = capsule_rows(leg_capsules(robot))
    elsewhere = robot.choices.over(capsules=rows).over(package_dirs=("/nowhere",))
    again = Robot.from_urdf(robot.urdf, choices=elsewhere)
    assert capsule_rows(leg_capsules(again)) == rows


@pytest.mark.parametrize("row", [(13, "x"), (0, "foot", 1.0), "foot"])
def test_what_is_no_capsule_is_refused(row):
    with pytest.raises(RobotError, match="capsules"):
        ImportOptions(capsules=(row,))


def test_a_capsule_of_no_number_is_refused():
    row = (0, "foot", 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, float("nan"), "collision")
    with pytest.raises(RobotError, match="capsules of 'foot'"):
        ImportOptions(capsules=(row,))
