import math
from dataclasses import replace

import pytest

from gaitopt.errors import InputError
from gaitopt.gait.constraints import Margins
from gaitopt.gait.parameters import GEOMETRY, set_geometry
from gaitopt.gait.presets import preset_task
from gaitopt.gait.task import Task

NUMBERS = (
    "friction", "minimum_load", "cop_margin", "clearance", "lateral_gap", "knee_flexion",
    "leg_extension", "liftoff_speed", "torque_limit", "speed_limit", "trunk_roll", "trunk_pitch",
    "trunk_yaw", "torsional_friction", "step_width", "leg_gap", "arm_gap",
    "swing_tilt", "swing_height", "landing_speed", "landing_impulse",
)  # fmt: skip


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", [math.nan, math.inf, True])
def test_margins_must_be_numbers(name, value):
    with pytest.raises(InputError, match=f"{name} is {value}.*; it must be a finite number"):
        Margins(**{name: value})


@pytest.mark.parametrize("name", ["friction", "minimum_load", "lateral_gap", "knee_flexion"])
def test_limits_that_are_always_there_cannot_be_left_out(name):
    with pytest.raises(InputError, match=f"{name} is None; it must be a finite number"):
        Margins(**{name: None})
    assert Margins(leg_extension=None, torque_limit=None).leg_extension is None


@pytest.mark.parametrize("name", ["joint_range", "impulse_cop"])
@pytest.mark.parametrize("value", [5.0, 1, None, "yes"])
def test_switches_are_no_numbers(name, value):
    with pytest.raises(InputError, match=f"{name} is {value!r}; it must be True or False"):
        Margins(**{name: value})


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("friction", 0.0, "friction is 0.0; it must be between 0.001 and 100"),
        ("leg_extension", -0.5, "leg_extension is -0.5; it must be above 0"),
        ("leg_extension", 1.01, "leg_extension is 1.01; it must be at most 1"),
        ("torque_limit", 1e-320, r"torque_limit is 1e-320 N.m; it must be between 1e-50 and"),
        ("torque_limit", 0.0, r"torque_limit is 0.0 N.m; it must be above 0"),
        ("speed_limit", -3.0, "speed_limit is -3.0 rad/s; it must be above 0"),
        ("trunk_roll", 0.0, "trunk_roll is 0.0 rad; it must be above 0"),
        ("trunk_yaw", -0.1, "trunk_yaw is -0.1 rad; it must be above 0"),
        ("torsional_friction", 0.0, "torsional_friction is 0.0 m; it must be above 0"),
        ("swing_height", 0.0, "swing_height is 0.0 m; it must be above 0"),
        ("landing_speed", -0.1, "landing_speed is -0.1 m/s; it must not be negative"),
        ("landing_impulse", 0.0, "landing_impulse is 0.0 m/s; it must be above 0"),
        ("step_width", -0.2, "step_width is -0.2 m; it must be above 0"),
        ("minimum_load", -1.0, "minimum_load is -1.0 N; it must not be negative"),
        ("clearance", -0.01, "clearance is -0.01 m; it must not be negative"),
        ("cop_margin", -0.02, "cop_margin is -0.02 m; it must not be negative"),
    ],
)
def test_margins_out_of_range_are_refused(name, value, message):
    with pytest.raises(InputError, match=message):
        Margins(**{name: value})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"speed": math.nan}, "speed is nan m/s"),
        ({"duration": -0.4}, "duration is -0.4 s; it must be"),
        ({"duration": 1e-9}, "duration is 1e-09 s; it must be 0.05 s or more"),
        ({"penalty_weight": math.inf}, "penalty_weight is inf cost/m²"),
        ({"speed": True}, "speed is True m/s; it must be a finite number"),
        ({"speed": -0.5, "stairs": 0.1}, "speed is -0.5 m/s; on stairs it must be above 0"),
        ({"speed": 1e-300}, "speed is 1e-300 m/s; it must be 0, or between 1e-50 and 1e\\+50"),
        ({"speed": 1e308}, "speed is 1e\\+308 m/s; it must be 0, or between 1e-50 and 1e\\+50"),
        ({"duration": 1e300}, "duration is 1e\\+300 s; it must be between 1e-50 and 1e\\+50"),
        ({"duration": 1e9}, "duration is 1000000000.0 s; it must be at most 1000 s"),
        ({"speed": -1e-9}, "speed is -1e-09 m/s; it must be 0, for a walk in place, or at least"),
        ({"speed": 0.0, "lateral_speed": 1e-6}, "lateral_speed is 1e-06 m/s; it must be 0"),
        ({"penalty_weight": 1e-99}, "penalty_weight is 1e-99 cost/m²; it must be between"),
        ({"samples": True}, "samples is True; it must be a whole number"),
        ({"postures": 1.5}, "postures is 1.5; it must be a whole number"),
        ({"postures": 0}, "postures is 0; at least 1 intermediate posture"),
        ({"speed_as": "wish"}, "speed_as 'wish' is unknown; choose constraint or penalty"),
        ({"quadrature": "gauss"}, "quadrature 'gauss' is unknown; choose simpson or euler"),
    ],
)
def test_tasks_out_of_range_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        Task(**changes)


def test_a_walk_is_not_slowed_down_below_the_slowest():
    assert Task(speed=1e-4).at_share_of_speed(0.5).speed == 5e-5
    assert Task(speed=2e-5).at_share_of_speed(0.25).speed == 2e-5
    assert Task(speed=0.5).at_share_of_speed(0.0).speed == 0.0


@pytest.mark.parametrize("name", ["trunk_pitch", "pelvis_roll", "pelvis_yaw", "foot_yaw"])
def test_angles_beyond_half_a_turn_are_refused(name):
    with pytest.raises(InputError, match=f"{name} is 1e.18 rad; give at most half a turn, 3.1416"):
        set_geometry(GEOMETRY, {name: {"value": 1e18}})


def test_a_fixed_step_length_cannot_also_be_constrained():
    fixed = set_geometry(GEOMETRY, {"step_length": {"free": False, "value": 0.4}})
    with pytest.raises(InputError, match="step_length is fixed; free it, or take the speed as a"):
        Task(geometry=fixed)
    assert Task(geometry=fixed, speed_as="penalty").geometry == fixed


def test_the_shortest_duration_is_that_of_the_table():
    fine = set_geometry(GEOMETRY, {"duration": {"lower": 0.01}})
    assert Task(geometry=fine, duration=0.02).duration == 0.02
    with pytest.raises(InputError, match=r"duration is 0\.009 s; it must be 0\.01 s or more"):
        Task(geometry=fine, duration=0.009)


def test_feet_fixed_farther_apart_than_allowed_are_refused():
    fixed = set_geometry(GEOMETRY, {"foot_spacing": {"free": False, "value": -0.25}})
    with pytest.raises(
        InputError, match=r"fixed at -0\.25 m, but step_width allows 0.2 m; free it"
    ):
        Task(geometry=fixed, margins=Margins(step_width=0.2))
    assert Task(geometry=fixed, margins=Margins(step_width=0.25)).geometry == fixed


def test_the_step_length_is_what_the_speed_asks_for():
    assert Task(speed=0.8, duration=0.45).step_length == pytest.approx(0.36)


def test_the_standard_preset_is_the_default_task_with_torsional_friction():
    assert preset_task() == preset_task("standard") != Task()
    assert preset_task(torsional_friction=None) == Task()


def test_the_paper_preset_knows_only_its_constraints():
    standard, paper = preset_task("standard"), preset_task("paper")
    assert [q.name for q in standard.geometry if q.free][-1] == "pelvis_yaw"
    assert sum(q.free for q in paper.geometry) == 6
    assert (standard.margins.impulse_cop, paper.margins.impulse_cop) == (True, False)
    assert paper == replace(
        standard,
        geometry=paper.geometry,
        margins=replace(standard.margins, impulse_cop=False, torsional_friction=None),
    )


def test_changes_reach_task_and_margins():
    task = preset_task("paper", speed=0.7, friction=0.4, postures=3, impulse_cop=True)
    assert (task.speed, task.postures) == (0.7, 3)
    assert (task.margins.friction, task.margins.impulse_cop) == (0.4, True)
    assert task.margins.clearance == Margins().clearance


def test_an_unknown_preset_lists_those_there_are():
    with pytest.raises(
        InputError, match=r"preset 'papper' is unknown; did you mean 'paper'\? choose one of"
    ):
        preset_task("papper")


def test_a_misspelt_field_lists_those_there_are():
    with pytest.raises(
        InputError, match=r"no task field sped; did you mean 'speed'\? .*, friction"
    ):
        preset_task(sped=1.0)
