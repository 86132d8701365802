import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from places import SWING_HEIGHT

from gaitopt.errors import InputError
from gaitopt.gait.parameters import FOOT_YAW, TRUNK_PITCH
from gaitopt.gait.plugin import load_plugin
from gaitopt.gait.presets import preset_task
from gaitopt.sweep.grid import Axis, parse_axis, with_values


def test_a_range_has_both_ends_and_round_values():
    axis = parse_axis("speed", "0.4:1.3:0.05")
    assert len(axis.values) == 19
    assert axis.values[:4] == (0.4, 0.45, 0.5, 0.55)
    assert axis.values[-1] == 1.3


@given(st.integers(1, 200), st.floats(0.01, 5.0), st.floats(0.001, 2.0))
@settings(derandomize=True, deadline=None, max_examples=60)
def test_a_range_has_as_many_values_as_steps_fit(count, first, step):
    first, step = round(first, 3), round(step, 3)
    axis = parse_axis("speed", f"{first!r}:{first + (count - 1) * step!r}:{step!r}")
    assert len(axis.values) == count


def test_a_list_is_taken_as_it_is():
    assert parse_axis("friction", "0.3,0.5,0.7").values == (0.3, 0.5, 0.7)


@pytest.mark.parametrize("text", ["0.4:1.3", "1:0:0.1", "0.4:1.3:0", "0.4:1.3:-1", "a", "", "nan"])
def test_what_is_no_range_is_refused(text):
    with pytest.raises(InputError, match="speed"):
        parse_axis("speed", text)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: parse_axis("speed", [1, 2]), r"parse_axis: text is \[1, 2\]; give a text"),
        (lambda: parse_axis(3, "0.4:1.3:0.05"), "parse_axis: name is 3; give a text"),
        (lambda: Axis("speed", ("fast",)), "speed"),
        (lambda: Axis("speed", 1.0), "speed"),
        (lambda: Axis(None, (1.0,)), "by its name"),
        (lambda: Axis("speed"), "Axis: missing a required argument: 'values'"),
        (lambda: Axis(nme="speed"), "did you mean 'name'"),
    ],
)
def test_values_of_another_kind_are_refused(make, said):
    with pytest.raises(InputError, match=said):
        make()


def test_each_quantity_is_listed_once():
    with pytest.raises(InputError, match="there is no quantity 'foo'") as refused:
        Axis("foo", (1.0,))
    listed = re.findall(r"[a-z_]+\.?[a-z_]+", str(refused.value).partition("there are")[2])
    assert [n for n in listed if "trunk_pitch" in n] == ["trunk_pitch", "hold.trunk_pitch"]
    assert listed.count("pelvis_roll") == 1


def test_unknown_quantities_and_disordered_values_are_refused():
    with pytest.raises(InputError, match="there is no quantity 'sped'"):
        Axis("sped", (1.0,))
    with pytest.raises(InputError, match=r"of speed begins above its end; .*: 0\.4:1\.3:0\.1"):
        parse_axis("speed", "1.3:0.4:0.1")
    with pytest.raises(InputError, match="do not increase"):
        Axis("speed", (1.0, 0.9))


def test_values_reach_task_margins_and_geometry():
    values = [("speed", 0.7), ("friction", 0.55), ("foot_yaw", 0.08), ("geometry.d3", 0.31)]
    task = with_values(preset_task(), values)
    assert (task.speed, task.margins.friction) == (0.7, 0.55)
    assert task.geometry[FOOT_YAW].value == 0.08
    assert not task.geometry[FOOT_YAW].free
    task = with_values(preset_task(), [("trunk_pitch", 0.2), ("hold.trunk_pitch", 0.05)])
    assert task.margins.trunk_pitch == 0.2
    assert (task.geometry[TRUNK_PITCH].value, task.geometry[TRUNK_PITCH].free) == (0.05, False)
    with pytest.raises(InputError, match="duration is -1"):
        with_values(preset_task(), [("duration", -1.0)])


@pytest.mark.parametrize(
    ("name", "text", "values"),
    [
        ("knee_flexion", "10deg:20deg:5deg", (0.1745329252, 0.2617993878, 0.3490658504)),
        ("speed", "1.8 km/h,3.6 km/h", (0.5, 1.0)),
        ("duration", "400ms:0.5:50ms", (0.4, 0.45, 0.5)),
        ("shin", "280mm,0.3", (0.28, 0.3)),
        ("geometry.d3", "28cm,30cm", (0.28, 0.3)),
        ("hold.trunk_pitch", "5°,10°", (0.0872664626, 0.1745329252)),
    ],
)
def test_values_may_have_their_units(name, text, values):
    assert parse_axis(name, text).values == values


def test_a_unit_of_another_dimension_is_refused():
    with pytest.raises(InputError, match="no range of speed"):
        parse_axis("speed", "10deg,20deg")


def test_margins_of_constraints_of_ones_own_are_swept_by_a_prefix():
    plugin = load_plugin(SWING_HEIGHT)
    task = preset_task(constraints=plugin.constraints)
    axis = parse_axis("own.low_swing", "0.05,0.06")
    changed = with_values(task, [(axis.name, axis.values[1]), ("friction", 0.6)])
    assert (changed.margin("low_swing"), changed.margins.friction) == (0.06, 0.6)
    with pytest.raises(InputError, match="there is no margin 'low_swing'"):
        with_values(preset_task(), [(axis.name, 0.06)])
