import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitopt.errors import InputError
from gaitopt.gait.parameters import (
    DURATION,
    GEOMETRY,
    GEOMETRY_NAMES,
    STEP_LENGTH,
    Layout,
    set_geometry,
)
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import walk_layout

JOINTS = tuple(f"joint_{i}" for i in range(12))
FREE_ALL = {name: {"free": True} for name in GEOMETRY_NAMES}


def layout(postures=2, **changes):
    return Layout(JOINTS, postures, set_geometry(GEOMETRY, changes))


@pytest.mark.parametrize(
    ("postures", "changes", "size"),
    [
        (2, {}, 43),
        (2, {"pelvis_yaw": {"free": False}}, 42),
        (1, {}, 31),
        (3, {}, 55),
        (2, FREE_ALL, 46),
        (5, {"duration": {"free": True}}, 80),
    ],
)
def test_size(postures, changes, size):
    table = layout(postures, **changes)
    assert table.size == len(table.names) == table.scale().size == size
    assert table.bounds()[0].size == size


def test_presets_have_43_and_42_parameters(robot):
    assert walk_layout(robot, preset_task("standard")).size == 43
    assert walk_layout(robot, preset_task("paper")).size == 42


@given(st.integers(1, 6), st.sets(st.sampled_from(GEOMETRY_NAMES)))
@settings(deadline=None, derandomize=True, max_examples=40)
def test_names_are_unique_and_parts_tile_the_vector(postures, free):
    table = layout(postures, **{n: {"free": n in free} for n in GEOMETRY_NAMES})
    assert len(set(table.names)) == table.size
    everything = np.arange(table.size)
    parts = [everything[p] for p in (table.knots, table.rates, table.shape)]
    np.testing.assert_array_equal(np.concatenate(parts), everything)
    for name in GEOMETRY_NAMES:
        index = table.index(name)
        assert (index is None) == (name not in free)
        if index is not None:
            assert table.names[index] == name


@given(st.integers(1, 4), st.sets(st.sampled_from(GEOMETRY_NAMES)), st.integers(0, 1000))
@settings(deadline=None, derandomize=True, max_examples=40)
def test_what_is_packed_is_found_again(postures, free, seed):
    table = layout(postures, **{n: {"free": n in free, "value": 2.5} for n in GEOMETRY_NAMES})
    rng = np.random.default_rng(seed)
    knots, rates, geometry = rng.normal(size=(postures, 12)), rng.normal(size=12), rng.normal(10)
    geometry = np.broadcast_to(geometry, 10) + np.arange(10)
    x = table.pack(knots, rates, np.zeros(12), geometry)
    np.testing.assert_array_equal(x[table.knots].reshape(-1, 12), knots)
    np.testing.assert_array_equal(x[table.rates], rates)
    expected = [g if n in free else 2.5 for n, g in zip(GEOMETRY_NAMES, geometry, strict=True)]
    np.testing.assert_array_equal(table.geometry_of(x), expected)


def test_order_is_postures_rates_geometry():
    names = layout(2).names
    assert names[0] == "joint_0_at_knot_1"
    assert names[23] == "joint_11_at_knot_2"
    assert names[24] == "joint_0_rate_before_impact"
    assert names[36:] == (
        "pelvis_height", "pelvis_lateral", "pelvis_forward", "trunk_pitch", "foot_spacing",
        "step_length", "pelvis_yaw",
    )  # fmt: skip


def test_only_quantities_have_bounds():
    table = layout(1, foot_yaw={"free": True})
    lower, upper = table.bounds()
    yaw, toes = table.index("pelvis_yaw"), table.index("foot_yaw")
    assert (lower[yaw], upper[yaw]) == (-0.2, 0.2)
    assert (lower[toes], upper[toes]) == (-0.3, 0.3)
    assert np.flatnonzero(np.isfinite(lower)).tolist() == [yaw, toes]


def test_scale_follows_the_kind_of_parameter():
    table = layout(2, pelvis_yaw={"scale": 0.37})
    scale = table.scale()
    assert len(set(scale[table.knots])) == len(set(scale[table.rates])) == 1
    assert scale[table.index("pelvis_yaw")] == 0.37
    assert (scale > 0.0).all()


def test_rows_of_the_table_are_where_their_names_say():
    assert GEOMETRY_NAMES[STEP_LENGTH] == "step_length"
    assert GEOMETRY_NAMES[DURATION] == "duration"


def test_an_unknown_quantity_lists_those_there_are():
    with pytest.raises(InputError, match=r"no geometric quantity 'step_width'; .*foot_spacing"):
        set_geometry(GEOMETRY, {"step_width": {"free": True}})


def test_bounds_without_room_are_refused():
    with pytest.raises(InputError, match=r"pelvis_yaw: lower bound 0.3 rad is not below upper"):
        set_geometry(GEOMETRY, {"pelvis_yaw": {"lower": 0.3}})


def test_the_table_that_was_given_is_kept():
    changed = set_geometry(GEOMETRY, {"duration": {"value": 0.6}})
    assert changed[DURATION].value == 0.6 != GEOMETRY[DURATION].value
    assert changed[:DURATION] == GEOMETRY[:DURATION]
