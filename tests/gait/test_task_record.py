import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitopt.errors import InputError
from gaitopt.gait.parameters import GEOMETRY, GEOMETRY_NAMES, set_geometry
from gaitopt.gait.presets import preset_task
from gaitopt.gait.task import Task, task_from_record, task_record

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
        geometry=set_geometry(GEOMETRY, GEOMETRY_CHANGES),
    ),
)


@pytest.mark.parametrize("task", TASKS)
def test_a_task_comes_back_through_json(task):
    text = json.dumps(task_record(task), allow_nan=False)
    assert task_from_record(json.loads(text)) == task


lowers = st.floats(-3.0, -1e-3) | st.just(-math.inf)
uppers = st.floats(1e-3, 3.0) | st.just(math.inf)
bounds = st.fixed_dictionaries({}, optional={"lower": lowers, "upper": uppers})


@settings(max_examples=50, derandomize=True, deadline=None)
@given(st.dictionaries(st.sampled_from(GEOMETRY_NAMES), bounds))
def test_any_bounds_come_back_through_json(changes):
    task = Task(geometry=set_geometry(GEOMETRY, changes))
    text = json.dumps(task_record(task), allow_nan=False)
    assert task_from_record(json.loads(text)) == task


def test_a_bound_taken_away_stays_away():
    free = {"pelvis_yaw": {"lower": -math.inf, "upper": math.inf}}
    record = task_record(Task(geometry=set_geometry(GEOMETRY, free)))
    assert record["geometry"]["pelvis_yaw"]["upper"] is None
    yaw = task_from_record(record).geometry[GEOMETRY_NAMES.index("pelvis_yaw")]
    assert (yaw.lower, yaw.upper) == (-math.inf, math.inf)


def test_an_old_record_that_leaves_bounds_out_has_the_usual_ones():
    record = task_record(Task())
    for entry in record["geometry"].values():
        entry.pop("lower", None), entry.pop("upper", None)
    assert task_from_record(record) == Task()


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
        ({"sped": 1.0}, r"record of the task cannot be read: .*no option sped"),
        ({"margins": {"frction": 0.5}}, r"cannot be read: .*no option frction"),
        ({"duration": -1.0}, "duration is -1.0 s"),
        ({"geometry": {"width": {}}}, "no geometric quantity 'width'"),
        ({"geometry": 5.0}, "cannot be read: its geometry is no table of tables"),
        ({"geometry": {"foot_yaw": 0.1}}, "cannot be read: its geometry is no table of tables"),
        ({"geometry": {"foot_yaw": {"value": None}}}, "record of the task cannot be read"),
    ],
)
def test_what_is_no_record_is_refused(record, message):
    with pytest.raises(InputError, match=message):
        task_from_record(record)
