"""A gait whose stance foot turns about its toe: what page, animation, table and export show."""

import io

import numpy as np
import pytest
from rich.console import Console

from gaitopt.cli.report import print_gait
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.motions.stride import record, stride_samples
from gaitopt.view.animation import frames
from gaitopt.view.page import facts


@pytest.fixture(scope="module")
def gait(robot):
    problem = WalkProblem(robot, preset_task(toe_off=0.65, duration=0.5))
    return gait_at(problem, first_guess(problem), {})


def test_the_page_says_when_and_how_far_the_foot_turns(gait):
    assert ("stance foot", "toe line from 0.325 s, 8.6° at the impact") in facts(gait)


def test_frames_are_apart_and_show_the_tilted_foot(gait):
    shown = frames(gait, 2)
    assert (np.diff(shown.time)[np.diff(shown.step) == 0] > 1e-3).all()
    assert len(shown.time) == 2 * (len(gait.time) - 1)  # both sides of the change are one picture
    last = len(gait.time) - 2
    heel_up = -shown.sole[last, 0, 2, 0]
    assert heel_up == pytest.approx(np.sin(0.15), abs=1e-9)


def test_the_export_has_the_turn_and_none_without(gait, robot):
    turn = record(gait, stride_samples(gait))["standing_foot_turn"]
    assert turn["contact"] == "toe line"
    assert turn["knots"][0] == pytest.approx(0.325)
    assert turn["coefficients"][-3] == pytest.approx(0.15)
    flat = WalkProblem(robot, preset_task())
    still = gait_at(flat, first_guess(flat), {})
    assert record(still, stride_samples(still))["standing_foot_turn"] is None


def test_the_table_has_a_line_for_it(gait):
    console = Console(file=io.StringIO(), width=80)
    print_gait(console, gait)
    (line,) = (one for one in console.file.getvalue().splitlines() if "turns from 0.325 s" in one)
    assert line.startswith("stance foot ")
    assert "0.15 rad" in line
