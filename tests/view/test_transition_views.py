"""The page and the figures of a transition."""

import json
import re
from functools import cache

import numpy as np
import pytest
from transitions import from_rest, to_rest

from gaitopt.contact import BOTH_FEET
from gaitopt.view.animation import transition_frames
from gaitopt.view.figure_style import rendered
from gaitopt.view.figures import TRANSITION_FIGURES, make_figure
from gaitopt.view.page import curves, page_text
from gaitopt.view.stick_figures import COLOURS


@cache
def text():
    return page_text(from_rest().transition)


def test_the_page_tells_what_it_leads_from_and_to():
    facts = dict(re.findall(r"<dt>(.*?)</dt><dd>(.*?)</dd>", text()))
    result = from_rest().transition
    assert (facts["from"], facts["to"]) == ("standing", "1 m/s")
    assert facts["steps"] == f"2 in {result.duration:.3f} s"
    assert "<h2>Steps</h2>" in text()
    assert '<p class="verdict" id="verdict">certified</p>' in text()
    assert not re.search(r"@[A-Z]+@", text())


def test_the_bar_of_phases_is_both_feet_then_each_in_turn():
    result = from_rest().transition
    data = json.loads(
        re.search(r"let data = (\{.*?\});\n", text(), re.S)[1].replace("\\u003c", "<")
    )
    phases = data["phases"]
    assert data["duration"] == data["step"] == pytest.approx(result.trajectory.period)
    assert [one["both"] for one in phases] == [True, False, False, False, False]
    assert [one["words"] for one in phases] == ["standing", "step 1", "step 2", "1 m/s", "1 m/s"]
    assert [one["foot"] for one in phases[1:]] == [0, 1, 0, 1]
    assert phases[0]["colour"] == COLOURS[BOTH_FEET]
    ends = [one["end"] for one in phases]
    assert [one["begin"] for one in phases] == pytest.approx([0.0, *ends[:-1]])
    assert ends[0] * data["step"] == pytest.approx(result.begins)


@pytest.mark.parametrize("found", [from_rest, to_rest])
def test_frames_are_of_all_of_it_in_order(found):
    trajectory = found().transition.trajectory
    samples = transition_frames(found().transition)
    assert samples.time[[0, -1]] == pytest.approx([0.0, trajectory.period])
    assert (np.diff(samples.time) >= 0.0).all()
    twice = np.flatnonzero(np.diff(samples.time) == 0.0)
    assert samples.time[twice] == pytest.approx(trajectory.changes[:-1])
    assert samples.q[twice] == pytest.approx(samples.q[twice + 1], abs=1e-12)


def test_curves_are_over_all_steps():
    trajectory = from_rest().transition.trajectory
    record = curves(from_rest().transition)
    assert record["period"] == record["step"] == pytest.approx(trajectory.period)
    assert record["time"][[0, -1]] == pytest.approx([0.0, trajectory.period])
    ground = next(tab for tab in record["tabs"] if tab["name"] == "ground")
    left, right = (line["y"][0] for line in ground["panels"][0]["lines"])
    assert left == pytest.approx(right)  # both feet bear alike at rest


@pytest.mark.parametrize("name", TRANSITION_FIGURES)
def test_figures_are_drawn_whole(name):
    figure = make_figure(to_rest().transition, name)
    assert "from 1 m/s to standing" in figure.get_suptitle().lower()
    assert len(rendered(figure, "svg")) > 10_000
