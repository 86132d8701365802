"""The envelope of the motors as a constraint: hand-computed rows, records, and a walk it holds."""

from dataclasses import replace

import numpy as np
import pytest
from walks import walk

from gaitopt.actuators.motors import JointMotor
from gaitopt.errors import InputError, SpecError
from gaitopt.gait import quantities
from gaitopt.gait.constraints import MotorEnvelope
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import task_from_record, task_record

KNEE = JointMotor("*knee*", 40.0, 15.0, 160.0, 20.0, 0.03, 0.9, 0.5)


def problem_with(*motors):
    known = walk("guess")
    task = replace(known.problem.task, constraints=(MotorEnvelope(motors=motors),))
    return WalkProblem(known.problem.robot, task), known.x


def test_rows_are_peak_and_voltage_line_of_every_joint_with_a_motor():
    problem, x = problem_with(KNEE)
    block = problem.blocks[-1]
    assert block.labels == (
        "right_knee peak of the motor", "right_knee voltage of the motor",
        "left_knee peak of the motor", "left_knee voltage of the motor",
    )  # fmt: skip
    step = problem.step(x)
    torque, rate = step.read(quantities.TORQUE), step.read(quantities.RATES)
    left = problem.robot.joint_names.index("left_knee")
    rows = block.function.value(block.take(step.values))
    assert rows[:, 2] == pytest.approx(torque[:, left] / 40.0)
    assert rows[:, 3] == pytest.approx(torque[:, left] / 160.0 + rate[:, left] / 20.0)
    assert np.abs(rows).max() > 0.1
    assert (block.lower == -1.0).all()
    assert (block.upper == 1.0).all()


def test_joints_without_a_motor_and_walks_without_motors_are_free():
    problem, _ = problem_with()
    assert "motor envelope" not in [block.name for block in problem.blocks]


def test_a_pair_with_two_motors_is_refused():
    with pytest.raises(SpecError, match="have different motors"):
        problem_with(KNEE, KNEE._replace(joints="left_knee", peak_torque=50.0))


def test_it_is_recorded_and_read_again():
    problem, _ = problem_with(KNEE)
    assert task_from_record(task_record(problem.task)) == problem.task


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([["*", 1.0]], "must be a row of joints, peak_torque"),
        ([["*", "40", 1.0, 1.0, 1.0, 1.0, 1.0, 0.0]], "peak torque is '40'; it must be a finite"),
        ([["*", 1.0, 1.0, 1.0, 1e99, 1.0, 1.0, 0.0]], "no load speed is 1e\\+99, no SI value"),
        ([["*", 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0]], "efficiency is 0; it must be above 0"),
        (7, "motors must be rows"),
    ],
)
def test_damaged_records_are_refused_with_words(rows, said):
    problem, _ = problem_with(KNEE)
    record = task_record(problem.task)
    record["constraints"][-1]["fields"]["motors"] = rows
    with pytest.raises(InputError, match=said):
        task_from_record(record)
