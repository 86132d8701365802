"""A gait whose stance foot turns about its toe: what page, animation, table and export show."""

import io
import re

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import same_color
from page_scene import data_of, numbers, tracks_of
from rich.console import Console

from gaitopt.cli.report import print_gait
from gaitopt.design.summary import summarise
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.motions.export import stride_record, stride_samples
from gaitopt.view.animation import frames
from gaitopt.view.figures import make_figure
from gaitopt.view.page import facts, page_text
from gaitopt.view.stick_figures import COLOURS, contact_colour


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
    turn = stride_record(gait, stride_samples(gait))["standing_foot_turn"]
    assert turn["contact"] == "toe line"
    assert turn["knots"][0] == pytest.approx(0.325)
    assert turn["coefficients"][-3] == pytest.approx(0.15)
    flat = WalkProblem(robot, preset_task())
    still = gait_at(flat, first_guess(flat), {})
    assert stride_record(still, stride_samples(still))["standing_foot_turn"] is None


def test_the_table_has_a_line_for_it(gait):
    console = Console(file=io.StringIO(), width=80)
    print_gait(console, gait)
    (line,) = (one for one in console.file.getvalue().splitlines() if "turns from 0.325 s" in one)
    assert line.startswith("stance foot ")
    assert "0.15 rad" in line


def test_the_step_has_two_phases_and_the_paper_walk_one(gait, robot):
    flat, toe = gait.phases
    assert [flat.contact, toe.contact] == ["flat", "toe line"]
    assert [flat.begin, flat.end, toe.end] == pytest.approx([0.0, 0.325, 0.5])
    assert toe.begin == flat.end == gait.turns_at
    problem = WalkProblem(robot, preset_task())
    (only,) = gait_at(problem, first_guess(problem), {}).phases
    assert (only.contact, only.begin, only.end) == ("flat", 0.0, pytest.approx(0.4))


def test_summary_and_table_tell_each_phase_apart(gait):
    flat, toe = summarise(gait)["contact"]["phases"]
    force = gait.ground_wrench[:, 2]
    assert toe["begin_s"] == pytest.approx(0.325)
    assert toe["share_of_step"] == pytest.approx(0.35)
    # the change is in both of them, from its own side
    late = gait.time >= 0.325 - 1e-9
    assert toe["largest_vertical_force_N"] == pytest.approx(force[late].max())
    assert flat["least_vertical_force_N"] == pytest.approx(force[gait.flat].min())
    whole = summarise(gait)["contact"]
    assert whole["least_vertical_force_N"] == min(
        flat["least_vertical_force_N"], toe["least_vertical_force_N"]
    )
    console = Console(file=io.StringIO(), width=80)
    print_gait(console, gait)
    assert re.search(r"^  flat from 0.000 s .* N$", console.file.getvalue(), re.MULTILINE)
    assert "  toe line from" in console.file.getvalue()


@pytest.fixture(scope="module")
def page(gait):
    return page_text(gait, 2)


def test_the_page_has_a_bar_of_phases_in_the_colours_it_explains(page):
    data = data_of(page)
    phases = data["phases"]
    assert [one["colour"] for one in phases] == [COLOURS["flat"], COLOURS["toe line"]]
    assert [one["end"] for one in phases] == pytest.approx([0.65, 1.0])
    for one in phases:
        mark = f'style="background:{one["colour"]}"></span> foot {one["words"]}'
        assert mark in page
    assert data["feet"] == ["right sole", "left sole"]


def test_the_mark_of_the_standing_foot_changes_with_its_contact(page):
    motion = data_of(page)["motion"]
    tracks = tracks_of(page, motion)
    flat, toe = (
        tracks[path][".scale"][:, 0] > 0.5
        for index in (0, 1)
        for path in tracks
        if path.endswith(f"standing_sole/{index}")
    )
    share = numbers(motion["times"]) / 0.5
    share -= np.minimum(np.floor(share), 1.0)  # of two steps; the film ends with the second
    assert (flat != toe).all()
    assert flat[share < 0.64].all()
    assert toe[share > 0.66].all()


def test_figures_colour_the_standing_foot_and_mark_the_phases(gait):
    torques = make_figure(gait, "torques")
    for axes in torques.axes:
        (flat, toe) = axes.patches
        assert [flat.get_x(), toe.get_x(), toe.get_width()] == pytest.approx([0.0, 0.325, 0.175])
    for name in ("step", "walk"):
        drawn = {line.get_color() for line in make_figure(gait, name).axes[0].lines}
        assert {COLOURS[one] for one in ("flat", "toe line")} <= drawn
    step = make_figure(gait, "step").axes[0]
    sticks = [one for one in step.collections if isinstance(one, LineCollection)]
    drawn = [
        pair for one in sticks for pair in zip(one.get_colors(), one.get_segments(), strict=True)
    ]
    toe = contact_colour("toe line")
    standing = next(points for colour, points in drawn if same_color(colour[:3], toe))
    assert standing[1, 1] == pytest.approx(0.0, abs=1e-12)  # the toe stays


def test_rows_say_in_which_phase_they_are(robot):
    problem = WalkProblem(robot, preset_task(toe_off=0.65, duration=0.5))
    told = [problem.describe(row) for row in range(problem.rows.lower.size)]
    assert any(one.endswith("torque at 65.0 % of the step (flat)") for one in told)
    assert any(one.endswith("torque at 65.0 % of the step (toe line)") for one in told)
    assert any(one.endswith("torque at 100.0 % of the step (toe line)") for one in told)
    flat = WalkProblem(robot, preset_task())
    assert not any("(flat)" in flat.describe(row) for row in range(flat.rows.lower.size))
