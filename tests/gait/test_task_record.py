import json

import pytest

from gaitopt.errors import InputError
from gaitopt.gait.parameters import GEOMETRY, set_quantities
from gaitopt.gait.task import Task, preset_task
from gaitopt.gait.task_record import task_from_record, task_record

GEOMETRY_CHANGES = {
    "foot_yaw": {"free": True, "value": 0.1},
    "step_length": {"lower": 0.2, "upper": 0.6, "scale": 0.05},
    "duration": {"free": True},
}
TASKS = (
    Task(),
    preset_task("paper", speed=0.83, postures=1),
    preset_task(
        speed_as="penalty",
        penalty_weight=3e5,
        quadrature="euler",
        samples=40,
        friction=0.55,
        torque_limit=80.0,
        joint_range=False,
        geometry=set_quantities(GEOMETRY, GEOMETRY_CHANGES),
    ),
)


@pytest.mark.parametrize("task", TASKS)
def test_a_task_comes_back_through_json(task):
    text = json.dumps(task_record(task), allow_nan=False)
    assert task_from_record(json.loads(text)) == task


def test_a_record_says_what_is_free_and_where():
    record = task_record(TASKS[2])
    assert record["geometry"]["foot_yaw"]["value"] == 0.1
    assert record["geometry"]["pelvis_height"].keys() == {"free", "value", "scale"}
    assert record["margins"]["torque_limit"] == 80.0


@pytest.mark.parametrize(
    ("record", "message"),
    [
        (None, "record of the task is missing; was the gait designed by gaitopt"),
        ("speed", "record of the task is missing"),
        ({"sped": 1.0}, r"record of the task cannot be read: .*'sped'"),
        ({"margins": {"frction": 0.5}}, r"cannot be read: .*'frction'"),
        ({"speed": -1.0}, "speed is -1.0 m/s"),
        ({"geometry": {"width": {}}}, "no geometric quantity 'width'"),
    ],
)
def test_what_is_no_record_is_refused(record, message):
    with pytest.raises(InputError, match=message):
        task_from_record(record)
