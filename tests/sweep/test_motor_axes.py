"""Sweeps over gear ratios and the figures of motors."""

from dataclasses import replace

import numpy as np
import pytest
from places import EXAMPLES
from sweeps import QUICK, quick_task

from gaitopt.actuators.motors import motor_table_of, read_motors
from gaitopt.design.design import design
from gaitopt.design.sizing import with_motors
from gaitopt.errors import InputError, SpecError
from gaitopt.gait.constraints import MotorEnvelope
from gaitopt.gait.result import robot_of
from gaitopt.gait.task import task_from_record
from gaitopt.model.import_options import LimitOverride
from gaitopt.model.robot import Robot
from gaitopt.sweep.grid import Axis, RobotSource, parse_axis
from gaitopt.sweep.interpolation import interpolate
from gaitopt.sweep.library import open_library
from gaitopt.sweep.scheduler import sweep

TABLE = read_motors(EXAMPLES / "motors.toml")
RATIOS = (7.5, 8.0)


@pytest.fixture(scope="module")
def geared(robot, tmp_path_factory):
    directory = tmp_path_factory.mktemp("geared") / "l"
    axis = Axis("motors.ratio", RATIOS)
    return sweep(robot, quick_task(speed=0.8), [axis], directory, QUICK, motors=TABLE)


def single(robot, table):
    """A design with these motors, from its own first guess."""
    choices = replace(robot.choices, limits=table.with_rotors(robot.choices.limits))
    driven = Robot.from_urdf(robot.urdf, choices=choices)
    return design(driven, with_motors(quick_task(speed=0.8), table), QUICK)


def test_every_gait_is_of_the_robot_with_its_gears(robot, geared):
    for ratio, row in zip(RATIOS, geared.rows, strict=True):
        table = TABLE.changed({"ratio": ratio})
        alone = single(robot, table)
        assert row["cost"] <= alone.solution.cost * (1.0 + 1e-6)
        gait = geared.gait((RATIOS.index(ratio),))
        armatures = robot_of(gait).model.armature
        rotor = TABLE.drives[0].motor.inertia
        assert armatures.max() == pytest.approx(ratio**2 * rotor, rel=1e-12)
        np.testing.assert_allclose(armatures, robot_of(alone.gait).model.armature, rtol=1e-12)
        task = task_from_record(gait.fact("task"))
        (envelope,) = (c for c in task.constraints if isinstance(c, MotorEnvelope))
        told = np.array([motor[1:] for motor in envelope.motors], dtype=float)
        np.testing.assert_allclose(told, [motor[1:] for motor in table.at_joints], rtol=1e-12)


def test_rotors_of_the_user_count_more_than_those_of_the_motors_at_every_ratio(robot):
    of_file = LimitOverride("*", armature=0.5, source="the robot's maker")
    own = LimitOverride("*knee*", armature=0.123)
    limits = (of_file, *TABLE.rotors("motors.toml"), own)
    base = Robot.from_urdf(robot.urdf, choices=replace(robot.choices, limits=limits))
    source = RobotSource(base.urdf, base.choices, motors=TABLE)
    for ratio in RATIOS:
        geared = replace(source, changes=(("motors.ratio", ratio),)).build()
        rotor = ratio**2 * TABLE.drives[0].motor.inertia
        for name in geared.joint_names:
            row = geared.model.joints[geared.model.getJointId(name)].idx_v
            expected = 0.123 if "knee" in name else rotor
            assert geared.model.armature[row] == pytest.approx(expected, rel=1e-12)
    fixed = replace(base.choices, without=("armature",))
    bare = RobotSource(base.urdf, fixed, changes=(("motors.ratio", 8.0),), motors=TABLE).build()
    assert not bare.model.armature.any()


def test_the_slope_foretells_the_next_cost(geared):
    left, right = geared.rows
    slope = 0.5 * (left["slope.motors.ratio"] + right["slope.motors.ratio"])
    assert abs(slope) > 1e-3 * left["cost"]  # the ratio matters
    assert right["cost"] - left["cost"] == pytest.approx(0.5 * slope, rel=0.05)


def test_between_two_ratios_there_is_a_gait_with_its_own(geared):
    library = open_library(geared.directory)
    found = interpolate(library, {"motors.ratio": 7.75}, QUICK)
    rotor = TABLE.drives[0].motor.inertia
    assert robot_of(found.design.gait).model.armature.max() == pytest.approx(7.75**2 * rotor)
    costs = sorted(row["cost"] for row in library.rows)
    assert costs[0] < found.design.solution.cost < costs[1]


def test_other_motors_are_another_sweep(robot, geared):
    axis, other = Axis("motors.ratio", RATIOS), TABLE.changed({"resistance": 0.2})
    with pytest.raises(InputError, match=r"of its robot's motors, .*resistance|motors"):
        sweep(robot, quick_task(speed=0.8), [axis], geared.directory, QUICK, motors=other)


def test_figures_of_motors_have_their_units():
    axis = parse_axis("motors.knee.no_load_speed", "3000rpm,4000rpm")
    assert axis.values == pytest.approx((314.159265, 418.879020))
    assert axis.of_motors
    with pytest.raises(InputError, match=r"no quantity 'motors\.colour'.*motors\.NAME"):
        Axis("motors.colour", (1.0,))


def test_a_table_is_needed_and_has_to_fit(robot, tmp_path):
    axis = Axis("motors.ratio", (7.0, 8.0))
    with pytest.raises(InputError, match=r"nothing is known; give a table .* --motors motors.toml"):
        sweep(robot, quick_task(), [axis], tmp_path / "l", QUICK)
    elbow = Axis("motors.elbow.ratio", (7.0, 8.0))
    with pytest.raises(SpecError, match=r"no drive has the joints 'elbow'; there are \*"):
        sweep(robot, quick_task(), [elbow], tmp_path / "l", QUICK, motors=TABLE)
    fast = Axis("motors.torque_constant", (0.1, 10.0))
    with pytest.raises(SpecError, match="no-load speed"):
        sweep(robot, quick_task(), [fast], tmp_path / "l", QUICK, motors=TABLE)
    assert not (tmp_path / "l").exists()


def test_a_table_survives_its_record():
    assert motor_table_of(TABLE.record()) == TABLE
    knee = replace(TABLE.drives[0], joints="knee")
    both = replace(TABLE, drives=(*TABLE.drives, knee))
    assert [d.ratio for d in both.changed({"knee.ratio": 3.0}).drives] == [8.0, 3.0]
