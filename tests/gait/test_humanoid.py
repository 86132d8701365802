import math
from dataclasses import replace

import pytest

from gaitopt.errors import InputError
from gaitopt.gait.presets import humanoid_task, preset_task, robust_task, stroll, widest


def test_numbers_follow_from_the_robot(robot):
    task = humanoid_task(robot)
    assert task.speed**2 / (9.81 * robot.legs.height) == pytest.approx(0.05, rel=0.03)
    assert task.duration == pytest.approx(
        robot.legs.natural_step(task.speed) / task.speed, abs=5e-3
    )
    assert task.margins.minimum_load == pytest.approx(0.05 * robot.mass * 9.81, abs=0.05)
    assert task.boundary == "lifted"
    assert task.margins.step_width > robot.sole.width


def test_a_faster_walk_has_longer_and_quicker_steps(robot):
    slow, quick = humanoid_task(robot, speed=0.5), humanoid_task(robot, speed=1.0)
    assert quick.duration < slow.duration
    assert quick.step_length > slow.step_length
    # the stride grows with the speed to the power 0.6
    assert quick.step_length / slow.step_length == pytest.approx(2.0**0.6, rel=0.05)


def test_what_is_given_wins(robot):
    task = humanoid_task(robot, speed=0.7, duration=0.33, trunk_roll=None, friction=0.35)
    assert (task.speed, task.duration, task.margins.trunk_roll) == (0.7, 0.33, None)
    full = humanoid_task(robot).margins.torsional_friction
    assert task.margins.torsional_friction == pytest.approx(full / 2.0, abs=1e-4)


def test_the_foot_swings_low_and_level(robot):
    margins = humanoid_task(robot).margins
    assert margins.swing_height == pytest.approx(0.12 * robot.legs.height, abs=1e-3)
    assert margins.swing_tilt == pytest.approx(math.sin(math.radians(15.0)), abs=2e-3)
    assert humanoid_task(robot, clearance=0.08).margins.swing_height == pytest.approx(0.16)
    free = humanoid_task(robot, swing_height=None, swing_tilt=0.5).margins
    assert (free.swing_height, free.swing_tilt) == (None, 0.5)


def test_on_stairs_the_foot_may_rise_by_that_of_a_tread_more(robot):
    stairs = {"speed": 0.5, "duration": 0.7}
    level = humanoid_task(robot, **stairs).margins.swing_height
    for rise in (0.17, -0.17):
        margins = humanoid_task(robot, stairs=rise, **stairs).margins
        assert margins.swing_height == pytest.approx(level + 0.17, abs=1e-3)


@pytest.mark.parametrize("turn", [{"toe_off": 0.7}, {"heel_strike": 0.2}])
def test_a_foot_that_turns_about_an_edge_may_leave_or_land_tilted(robot, turn):
    margins = humanoid_task(robot, **turn).margins
    assert (margins.swing_height, margins.swing_tilt) == (None, None)


def test_everything_else_is_the_standard_task(robot):
    task, standard = humanoid_task(robot), preset_task()
    assert (task.postures, task.samples, task.geometry) == (
        standard.postures, standard.samples, standard.geometry,
    )  # fmt: skip
    assert task.margins.friction == standard.margins.friction


def test_a_wider_robot_may_walk_wider(robot):
    assert widest(robot) == pytest.approx(0.136 + 0.01 + 0.03)  # its soles are wider than its hips


def test_the_lines_of_footsteps_leave_room_for_the_gap_asked_for(robot):
    margins = humanoid_task(robot, lateral_gap=0.15).margins
    assert margins.step_width == pytest.approx(0.136 + 0.15 + 0.03)
    assert humanoid_task(robot, lateral_gap=0.15, step_width=0.3).margins.step_width == 0.3


@pytest.mark.parametrize("preset", ["humanoid", "robust"])
@pytest.mark.parametrize(("leg", "share"), [(0.15, 0.5), (0.3, 1.0), (1.2, 1.0)])
def test_gaps_shrink_with_a_short_leg(robot, preset, leg, share):
    """The clearance of 30 mm is a fifth of a leg of 155 mm, which then found no optimum."""
    sized = replace(robot, legs=replace(robot.legs, reach=leg))
    margins = preset_task(preset, sized).margins
    usual = {"clearance": 0.03, "lateral_gap": 0.01, "leg_gap": 0.01, "cop_margin": 0.005}
    if preset == "robust":
        del usual["cop_margin"]  # which follows from the sole
    found = {name: getattr(margins, name) for name in usual}
    assert found == pytest.approx({name: share * length for name, length in usual.items()})
    assert margins.step_width == pytest.approx(0.136 + share * (0.01 + 0.03))
    assert margins.swing_height >= 2.0 * margins.clearance
    assert preset_task(preset, sized, clearance=0.04).margins.clearance == 0.04
    turning = preset_task(preset, sized, toe_off=0.7, heel_strike=0.1)
    assert (turning.toe_strip, turning.heel_strip) == pytest.approx((0.01 * share,) * 2)
    given = preset_task(preset, sized, toe_off=0.7, toe_strip=0.02)
    assert (given.toe_strip, given.heel_strip) == (0.02, 0.01)


@pytest.mark.parametrize("speed", [-math.inf, math.nan])
def test_wrong_speeds_are_refused(robot, speed):
    with pytest.raises(InputError, match="speed"):
        humanoid_task(robot, speed=speed)


def test_a_stroll_is_a_round_number(robot):
    assert stroll(robot) == round(stroll(robot), 2)


def test_robust_margins_follow_from_the_robot(robot):
    """The humanoid's task with room for feedback; what is given still wins."""
    task, plain = preset_task("robust", robot, speed=0.8), humanoid_task(robot, speed=0.8)
    pace = math.sqrt(9.81 * robot.legs.height)
    assert task.margins.landing_speed == pytest.approx(0.07 * pace, abs=1e-3)
    assert task.margins.landing_impulse == pytest.approx(0.07 * pace, abs=1e-3)
    assert task.margins.cop_margin == pytest.approx(0.1 * 0.136, abs=1e-4)
    assert task.margins.torsional_friction == pytest.approx(
        plain.margins.torsional_friction * 5.0 / 7.0, abs=1e-4
    )
    assert (task.duration, task.margins.step_width) == (plain.duration, plain.margins.step_width)
    assert robust_task(robot, knee_flexion=0.2, friction=0.6).margins.knee_flexion == 0.2
