import numpy as np
import pytest

from gaitopt.errors import InputError
from gaitopt.view.comparison_figures import branch_cuts, library_figure
from gaitopt.view.figure_style import styled, write_figure

SPEEDS = (0.8, 0.9, 1.0, 1.1, 1.2)
KNEE = (23.8, 22.3, 20.1, 88.1, 88.4)  # between 1.0 and 1.1 m/s the knee begins to bear load
HIP = (37.5, 57.7, 82.1, 77.2, 74.3)


def library():
    return [
        {
            "speed": speed, "friction": mu, "cost": 1e3 * (row + 2.0) - 100.0 * mu,
            "peak_torque.knee": KNEE[row] + mu, "peak_torque.hip_pitch": HIP[row],
        }
        for row, speed in enumerate(SPEEDS)
        for mu in (0.6, 0.7)
    ]  # fmt: skip


def test_only_a_jump_that_stands_out_parts_two_families():
    steep = np.array([10.0, 14.0, 26.0, 29.0, 30.0])  # more than half of the range, yet a curve
    assert branch_cuts(np.column_stack([KNEE, HIP])) == [3]
    assert branch_cuts(np.column_stack([KNEE[::-1], steep])) == [2]
    assert branch_cuts(steep[:, None]) == branch_cuts(np.array([[9.0], [88.0]])) == []
    small = np.column_stack([KNEE, 100.0 * np.array(HIP)])
    assert branch_cuts(small) == []


def test_lines_are_interrupted_where_the_optima_change():
    left, right = library_figure({"": library()}, ["speed", "friction"]).axes
    assert [n.get_label() for n in left.lines] == ["friction 0.6", "friction 0.7"]
    for line in (*left.lines, *right.lines):
        assert np.flatnonzero(np.isnan(line.get_xdata())).tolist() == [3]
        assert np.delete(line.get_xdata(), 3).tolist() == list(SPEEDS)
    assert np.delete(right.lines[0].get_ydata(), 3) == pytest.approx(np.array(KNEE) + 0.7)


def test_the_panels_tell_units_and_whose_motors_they_show():
    figure = library_figure({"": library()}, ["speed", "friction"])
    left, right = figure.axes
    assert (left.get_xlabel(), left.get_ylabel()) == ("speed [m/s]", "cost [N²·m·s]")
    assert right.get_title(loc="left") == "Motors of a leg, friction 0.7"
    assert figure.get_supxlabel().startswith("a gap in the lines")
    alone = library_figure({"": library()[::2][:3]}, ["speed"])
    assert alone.axes[1].get_title(loc="left") == "Motors of a leg"
    assert alone.get_supxlabel() == ""


def test_the_legends_stand_beside_their_panels():
    with styled():
        figure = library_figure({"": library()}, ["speed", "friction"])
        figure.draw_without_rendering()
        left, right = figure.axes
        for panel in (left, right):
            words = panel.get_legend().get_window_extent()
            assert words.x0 >= panel.get_window_extent().x1 - 1.0  # pixel
            assert words.x1 <= figure.bbox.x1
        assert left.get_legend().get_window_extent().x1 < right.get_window_extent().x0


def test_what_cannot_be_drawn_is_refused(tmp_path):
    with pytest.raises(InputError, match="no gait to draw"):
        library_figure({"": [{"speed": 1.0, "cost": None}]}, ["speed"])
    with pytest.raises(InputError, match="ends in"):
        write_figure(tmp_path / "a.gif", lambda: library_figure({"": library()}, ["speed"]))
    drawn = write_figure(
        tmp_path / "a.svg", lambda: library_figure({"": library()}, ["speed", "friction"])
    )
    assert b"friction 0.7" in drawn.read_bytes()


def test_two_libraries_are_told_apart_by_dashes_and_names():
    light = [{**row, "peak_torque.knee": 20.0} for row in library()]
    left, right = library_figure({"heavy": library(), "light": light}, ["speed", "friction"]).axes
    assert [n.get_label() for n in left.lines][::2] == [
        "heavy, friction 0.6",
        "light, friction 0.6",
    ]
    assert [n.get_linestyle() for n in left.lines] == ["-", "-", "--", "--"]
    assert right.get_title(loc="left") == "Motors of a leg, friction 0.7; dashed: light"
    knees = [line for line in right.lines if line.get_color() == right.lines[0].get_color()]
    assert [line.get_linestyle() for line in knees] == ["-", "--"]
    assert [text.get_text() for text in right.get_legend().get_texts()] == ["knee", "hip pitch"]
