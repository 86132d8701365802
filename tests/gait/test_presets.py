"""Named tasks in public Python, and what is said where one meets another robot."""

from dataclasses import replace

import pytest
from urdf_edits import edited_urdf, scale_mass

import gaitopt
from gaitopt.design.options import DesignOptions
from gaitopt.design.starts import design_gait, many_starts
from gaitopt.errors import InputError, NoGaitFoundError, UnreachableError
from gaitopt.gait.presets import foreign_margins, humanoid_task, preset_task
from gaitopt.model.robot import Robot
from gaitopt.model.sole import turning_arm
from gaitopt.solvers import solver_by_name

QUICK = DesignOptions(solver=solver_by_name("sqp"), refine=False, diagnose=False)


@pytest.fixture(scope="module")
def foreign() -> Robot:
    """A robot that gaitopt has not made: the biped with a heavier trunk, from another hand."""
    return Robot.from_urdf(edited_urdf(scale_mass("torso", 1.1)))


def test_the_preset_of_humanoids_is_sized_by_the_robot(robot):
    task = preset_task("humanoid", robot, speed=0.6, friction=0.5)
    assert task == humanoid_task(robot, speed=0.6, friction=0.5)
    assert gaitopt.preset_task is preset_task


def test_a_standard_walk_turns_its_foot_no_harder_than_the_sole_bears(robot, foreign):
    sole = robot.sole
    arm = turning_arm(sole.length, sole.width)
    given = preset_task("standard", robot, friction=0.5).margins
    assert given.torsional_friction == pytest.approx(0.5 * arm, abs=5e-5)
    assert preset_task() == preset_task("standard", robot)  # without a robot, that of the biped
    short = replace(foreign, sole=replace(sole, heel=0.5 * sole.heel))
    bears = preset_task("standard", short).margins.torsional_friction
    assert bears == pytest.approx(0.7 * turning_arm(0.107, 0.136), abs=5e-5)
    assert bears < preset_task().margins.torsional_friction
    assert preset_task(friction=1e-3).margins.torsional_friction > 0.0
    assert preset_task("paper").margins.torsional_friction is None


def test_the_others_do_without_a_robot(robot):
    assert preset_task("paper", robot) == preset_task("paper")
    with pytest.raises(InputError, match=r'give it, as in preset_task\("humanoid", robot'):
        preset_task("humanoid")
    with pytest.raises(InputError, match="choose one of standard, paper, humanoid"):
        preset_task("human")


def test_margins_of_the_biped_are_told_to_another_robot(foreign):
    said = foreign_margins(foreign, preset_task(speed=0.7))
    assert said is not None
    assert f"weighs {foreign.weight:.0f} N" in said
    assert 'preset_task("humanoid", robot, speed=0.7)' in said
    with (
        pytest.warns(UserWarning, match="those of the thirteen-link biped") as told,
        pytest.raises(NoGaitFoundError),
    ):
        design_gait(foreign, preset_task(torque_limit=1.0), QUICK, starts=1)
    assert told[0].filename == __file__  # the line that asked for the walk


def test_nothing_is_said_where_they_fit(robot, foreign):
    assert foreign_margins(robot, preset_task()) is None
    assert foreign_margins(foreign, preset_task("humanoid", foreign)) is None
    assert foreign_margins(foreign, preset_task(minimum_load=30.0)) is None


def test_python_finds_the_walk_of_the_command(robot):
    task = preset_task(speed=1.0)
    two, one = design_gait(robot, task, QUICK), design_gait(robot, task, QUICK, starts=1)
    assert two.gait.cost == many_starts(robot, task, QUICK).design.gait.cost
    assert two.gait.cost < 0.98 * one.gait.cost
    again = design_gait(robot, task, QUICK, start=one.gait.parameters)
    assert again.gait.cost == pytest.approx(one.gait.cost, rel=1e-9)  # one start, as it was given
    with pytest.raises(InputError, match="0 starts are too few"):
        design_gait(robot, task, QUICK, starts=0)


def test_everything_public_has_a_short_form(robot, foreign, sampled_design):
    gait, certificate = sampled_design.gait, sampled_design.certificate
    assert repr(robot) == "<Robot 'biped13': 56.87 kg, legs 0.600 m, stands on 'right_sole'>"
    assert repr(gait).startswith("<Gait of 'biped13': 1.000 m/s, 0.400 m in 0.400 s, 33")
    assert repr(gait).endswith(" N²·m·s, not certified>")
    assert repr(certificate).startswith("<Certificate: optimal at the given samples only; ")
    assert repr(sampled_design) == f"<Design: {gait!r}, sqp>"
    assert max(len(repr(x)) for x in (robot, foreign, gait, sampled_design)) <= 120


@pytest.mark.parametrize("preset", ["humanoid", "robust"])
def test_an_absurd_speed_is_refused_by_its_own_name(robot, preset):
    with pytest.raises(
        UnreachableError, match=r"\(1e\+09 m/s for 0.05 s\) is longer than the legs"
    ):
        design_gait(robot, preset_task(preset, robot, speed=1e9), starts=1)
