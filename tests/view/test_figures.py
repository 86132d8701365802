import io
import re
from collections import defaultdict
from dataclasses import replace
from itertools import combinations

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image
from sample_gait import bare_gait, sample_gait
from synthetic_bipeds import synthetic
from transitions import from_rest

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.design.requirements import own_motor_loops
from gaitopt.design.summary import motor_summaries
from gaitopt.errors import InputError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.model.robot import Robot
from gaitopt.view.comparison_figures import MOST, torque_speed_figure
from gaitopt.view.figure_style import LIMIT, rendered, styled
from gaitopt.view.figures import (
    FIGURES,
    TRANSITION_FIGURES,
    draw_limit,
    make_figure,
    write_figures,
)


@pytest.mark.parametrize("name", FIGURES)
@pytest.mark.parametrize("gait", [sample_gait(), bare_gait()], ids=["full", "bare"])
def test_every_axis_has_data_and_a_unit(name, gait):
    figure = make_figure(gait, name)
    panels = [a for a in figure.axes if a.lines or a.collections]
    assert panels
    labels = [t for a in figure.axes for t in (a.get_xlabel(), a.get_ylabel()) if t]
    assert labels
    assert all(t.endswith("]") for t in labels)


def lines(figure, panel, label):
    found = [n for n in figure.axes[panel].lines if str(n.get_label()).startswith(label)]
    assert found, label
    return np.asarray(found[0].get_ydata())


def test_the_force_figure_shows_force_mean_weight_and_friction():
    gait = sample_gait()
    figure = make_figure(gait, "ground_force")
    assert lines(figure, 0, "normal") == pytest.approx(gait.ground_wrench[:, 2])
    assert lines(figure, 0, "weight")[0] == pytest.approx(56.87 * 9.81)
    assert 500.0 < lines(figure, 0, "mean")[0] < 560.0
    used = np.hypot(*gait.ground_wrench[:, :2].T) / gait.ground_wrench[:, 2]
    assert lines(figure, 1, "used") == pytest.approx(used)
    assert lines(figure, 1, "allowed 0.7")[0] == 0.7


@pytest.mark.parametrize("name", ["step", "walk"])
@pytest.mark.parametrize("rise", [0.17, -0.17])
def test_stairs_are_drawn_as_treads_and_risers(name, rise):
    """Also where rounding puts the upper end of a riser before the lower one."""
    gait = sample_gait()
    step = gait.step_length
    edge = 0.1 + 1e-15
    ground = {"words": "stairs", "rise": rise, "outline": [[edge - step, 0.0], [edge + 4e-15, 0.0]]}
    figure = make_figure(replace(gait, meta={**gait.meta, "ground": ground}), name)
    (band,) = figure.axes[0].collections[0].get_paths()
    corners = band.vertices[:-1]
    top = corners[: len(corners) // 2]
    along, up = np.diff(top, axis=0).T
    assert len(top) > 6
    assert np.minimum(np.abs(along), np.abs(up)) == pytest.approx(np.zeros(len(along)), abs=1e-9)
    assert np.sign(up[np.abs(up) > 1e-9]) == pytest.approx(np.sign(rise))
    assert np.ptp(corners - np.r_[top, top[::-1]], axis=0).min() > 0.01  # thick under each


def test_joints_of_no_leg_have_a_colour_of_their_own():
    robot = synthetic("seven, waist and arms")
    problem = WalkProblem(robot, preset_task(boundary="lifted", speed=0.5, duration=0.5))
    figure = make_figure(gait_at(problem, first_guess(problem), {}), "angles")
    legend = figure.legends[0]
    colours = {t.get_text(): h.get_color() for t, h in zip(
        legend.get_texts(), legend.get_lines(), strict=True)}  # fmt: skip
    assert {"stance leg", "swing leg", "middle"} <= set(colours)
    assert len(set(colours.values())) == len(colours)


# of linear red, green, blue: as people see them who lack the long or the middle cones; Machado,
# Oliveira & Fernandes (2009), severity 1
SEEN = (
    (1, 0, 0, 0, 1, 0, 0, 0, 1),
    (0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882, -0.048116, 1.051998),
    (0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.011820, 0.042940, 0.968881),
)


@pytest.mark.parametrize("matrix", SEEN, ids=["all", "no long cones", "no middle cones"])
def test_lines_are_told_apart_by_any_eyes(matrix):
    with styled():
        cycle = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    assert len(cycle) == MOST
    assert LIMIT not in cycle
    rgb = np.array([to_rgb(colour) for colour in cycle])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    seen = np.clip(linear @ np.reshape(matrix, (3, 3)).T, 0.0, 1.0) ** (1.0 / 2.4)
    apart = [np.linalg.norm(one - other) for one, other in combinations(seen, 2)]
    assert min(apart) > 0.15  # 0.05 in Matplotlib's own cycle


def test_long_names_leave_room_for_the_limit_beside_them():
    text = urdf_text(biped13())
    for name in {*re.findall(r'<joint name="(\w+)"', text)}:
        text = text.replace(f'"{name}"', f'"{name}_of_a_robot_whose_joints_have_very_long_names"')
    problem = WalkProblem(Robot.from_urdf(text), preset_task(speed=0.8))
    figure = make_figure(gait_at(problem, first_guess(problem), {}), "torques")
    rendered(figure, "png")
    boxes = boxes_of_texts(figure)
    assert sum(text.get_text().endswith("...") for text in boxes) == 6
    for (one, a), (other, b) in combinations(boxes.items(), 2):
        shared = np.minimum(a.max, b.max) - np.maximum(a.min, b.min)
        assert shared.min() < 1.0, (one, other)


def test_the_torque_figure_pairs_the_same_joint_of_both_legs():
    gait = sample_gait()
    figure = make_figure(gait, "torques")
    titles = [a.get_title(loc="left") for a in figure.axes]
    assert titles == ["hip yaw", "hip roll", "hip pitch", "knee", "ankle pitch", "ankle roll"]
    assert lines(figure, 3, "stance") == pytest.approx(gait.torque[:, 2])
    assert lines(figure, 3, "swing") == pytest.approx(gait.torque[:, 9])


def test_the_limit_of_a_joint_without_a_partner_is_told():
    axes = Figure().subplots()
    assert draw_limit(axes, np.array([[-3.0], [2.0]]), np.array([4.0])) == [-4.0]
    assert axes.get_title(loc="right") == "limit 4: 75 %"


@pytest.mark.parametrize(
    ("right", "left", "titles"),
    [
        ("RJoint{}Pitch", "LJoint{}Pitch", [f"Joint{n}Pitch" for n in range(6, 0, -1)]),
        ("leg_right_{}_joint", "leg_left_{}_joint", [f"leg {n}" for n in range(6, 0, -1)]),
        ("j_{}", "j_0{}", [f"j_{{0{n},{n}}}" for n in range(6, 0, -1)]),
    ],
)
def test_figures_and_motors_name_a_pair_alike_and_each_apart(right, left, titles):
    names = [right.format(n) for n in range(1, 7)] + [left.format(n) for n in range(6, 0, -1)]
    gait = replace(sample_gait(), joint_names=tuple(names))
    assert [a.get_title(loc="left") for a in make_figure(gait, "angles").axes] == titles
    assert [motor["joint"] for motor in motor_summaries(gait)] == titles


def test_each_panel_of_the_torques_has_its_own_scale_and_tells_the_limit():
    gait = sample_gait()
    figure = make_figure(gait, "torques")
    for axes, stance in zip(figure.axes, [5, 4, 3, 2, 1, 0], strict=True):
        largest = np.abs(gait.torque[:, [stance, 11 - stance]]).max()
        assert largest < max(np.abs(axes.get_ylim())) < max(1.25 * largest, 1.01 * 150.0)
        assert axes.get_title(loc="right").startswith("limit 150: ")
        drawn = [n for n in axes.lines if n.get_label() == "limit"]
        assert bool(drawn) == (1.5 * largest > 150.0)
    (legend,) = figure.legends
    shown = {t.get_text() for t in legend.get_texts()} - {"stance leg", "swing leg"}
    assert shown == {label for a in figure.axes for label in a.get_legend_handles_labels()[1][2:]}


def test_limits_met_are_told():
    figure = make_figure(sample_gait(), "rates")
    assert [a.get_title(loc="right").split(" / ")[1] for a in figure.axes][3:] == ["100 %"] * 3
    assert all(abs(lines(figure, panel, "limit")[0]) == 10.0 for panel in (3, 4, 5))


def test_the_cop_figure_tells_the_distance_to_the_edge():
    assert "5.0 mm" in make_figure(sample_gait(), "cop").get_suptitle()


def test_the_cop_figure_is_as_high_as_the_sole_needs_and_its_colours_span_the_step():
    gait = sample_gait()
    figure = make_figure(gait, "cop")
    (path,) = [c for c in figure.axes[0].collections if c.get_array() is not None]
    assert path.get_clim() == (0.0, pytest.approx(gait.duration))
    rendered(figure, "png")
    box = figure.axes[0].get_tightbbox()
    assert box.height > 0.7 * figure.bbox.height
    assert box.width > 0.7 * figure.bbox.width


def boxes_of_texts(figure):
    """Where each text stands that is seen, in pixels."""
    unseen = set()
    bars = [bar for axes in figure.axes for bar in axes.child_axes]
    for axes in [*figure.axes, *bars]:
        unseen |= set() if axes.get_visible() else {*axes.findobj(Text)}
        for axis in (axes.xaxis, axes.yaxis):
            shown = [tick for tick in ticks_inside(axis) if axis.get_visible()]
            hidden = {*axis.get_major_ticks()} - {*shown}
            unseen |= {text for tick in hidden for text in tick.findobj(Text)}
            unseen |= set() if axis.get_visible() else {axis.label}
    texts = [t for t in figure.findobj(Text) if t.get_visible() and t.get_text().strip()]
    return {text: text.get_window_extent() for text in texts if text not in unseen}


def ticks_inside(axis):
    low, high = sorted(axis.get_view_interval())
    return [t for t in axis.get_major_ticks() if low - 1e-9 <= t.get_loc() <= high + 1e-9]


def scaled(size):
    gait = sample_gait()
    return replace(gait, torque=size * gait.torque, ground_wrench=size * gait.ground_wrench)


@pytest.fixture(scope="module")
def longest_words(robot):
    """A gait whose legends have most rows: a stride with three phases in each step."""
    task = preset_task(turn_rate=0.2, toe_off=0.65, heel_strike=0.1)
    return gait_at(WalkProblem(robot, task), first_guess(WalkProblem(robot, task)), {})


@pytest.mark.parametrize("kind", [1e-9, 1e-3, 1.0, 1e3, 2e6, "stride", "transition"])
def test_no_text_is_cut_off_or_lies_on_another(kind, request):
    gait = scaled(kind) if isinstance(kind, float) else None
    if gait is None:
        gait = from_rest().transition if kind == "transition" else None
    gait = gait or request.getfixturevalue("longest_words")
    for name in TRANSITION_FIGURES if kind == "transition" else FIGURES:
        figure = make_figure(gait, name)
        rendered(figure, "png")
        assert len(boxes_of_texts(figure)) > 15
        check_texts(figure)


def check_texts(figure):
    boxes = boxes_of_texts(figure)
    for text, box in boxes.items():
        corners = np.array([box.min, figure.bbox.max - box.max])
        assert corners.min() > 0.0, text
    for (one, a), (other, b) in combinations(boxes.items(), 2):
        shared = np.minimum(a.max, b.max) - np.maximum(a.min, b.min)
        assert shared.min() < 1.0, (one, other)


def test_a_factor_of_the_numbers_stands_before_their_unit():
    torques = rendered(make_figure(scaled(2e6), "torques"), "svg").decode()
    assert "torque [1e7 N·m]" in torques
    assert ">1e7<" not in torques
    loops = [replace(one, torque=2e6 * one.torque) for one in own_motor_loops(sample_gait())]
    with styled():
        figure = torque_speed_figure({"walk": loops})
    rendered(figure, "png")
    assert "torque [1e8 N·m]" in {axes.get_ylabel() for axes in figure.axes}
    check_texts(figure)


@pytest.mark.parametrize("name", FIGURES)
def test_numbers_and_labels_stand_where_matplotlib_puts_them(name):
    """Its own ticks are slow to make, five objects each, and are the oracle here."""
    figure = make_figure(sample_gait(), name)
    rendered(figure, "png")
    drawn = defaultdict(list)
    for text, box in boxes_of_texts(figure).items():
        drawn[text.get_text()].append(box)
    panels = [axes for axes in figure.axes if axes.get_visible()]
    assert not any(axis.get_visible() for axes in panels for axis in (axes.xaxis, axes.yaxis))
    for axes in panels:
        axes.xaxis.set_visible(True)
        axes.yaxis.set_visible(True)
    with styled():
        figure.canvas.draw()
    for axis in (axis for axes in panels for axis in (axes.xaxis, axes.yaxis)):
        for text in [axis.label, *(tick.label1 for tick in ticks_inside(axis))]:
            if text.get_visible() and text.get_text():
                place = text.get_window_extent().get_points()
                near = [np.abs(box.get_points() - place).max() for box in drawn[text.get_text()]]
                assert min(near) < 3.0, (text, near)


def test_an_image_is_what_the_canvas_shows():
    figure = make_figure(sample_gait(), "cop")
    with Image.open(io.BytesIO(rendered(figure, "png"))) as image:
        image.verify()
    with Image.open(io.BytesIO(rendered(figure, "png"))) as image:
        assert image.info["dpi"] == pytest.approx((150.0, 150.0), abs=0.02)
        canvas = np.asarray(figure.canvas.buffer_rgba())
        assert np.array_equal(np.asarray(image), canvas[..., :3])
    assert (canvas[..., 3] == 255).all()


def test_a_figure_is_laid_out_once_for_all_its_forms():
    figure = make_figure(sample_gait(), "torques")
    assert rendered(figure, "png") == rendered(figure, "png")


def test_all_that_the_step_shows_is_in_its_legend():
    (legend,) = make_figure(sample_gait(), "step").legends
    assert {"stance leg", "swing leg", "trunk", "path of the swing toes"} == {
        t.get_text() for t in legend.get_texts()
    }


def test_every_figure_is_written(tmp_path):
    files = write_figures(sample_gait(), tmp_path / "new" / "a")
    assert [f.name for f in files] == [f"{n}.png" for n in FIGURES]
    assert all(f.read_bytes().startswith(b"\x89PNG") for f in files)


def test_equal_gaits_give_equal_pictures(tmp_path, monkeypatch):
    monkeypatch.setattr("gaitopt.view.figures.FIGURES", {"cop": FIGURES["cop"]})
    first = write_figures(sample_gait(), tmp_path / "a", ("svg", "pdf"))
    second = write_figures(sample_gait(), tmp_path / "b", ("svg", "pdf"))
    assert b"<svg" in first[0].read_bytes()
    assert [f.read_bytes() for f in first] == [f.read_bytes() for f in second]
    (one,) = write_figures(sample_gait(), tmp_path / "c", {"svg"}, dict.fromkeys(["cop"]))
    assert one.read_bytes() == first[0].read_bytes()


def test_what_cannot_be_drawn_is_refused(tmp_path):
    with pytest.raises(
        InputError, match=r"no figure 'torque'; did you mean 'torques'. choose from step"
    ):
        make_figure(sample_gait(), "torque")
    with pytest.raises(InputError, match="choose png, svg, pdf"):
        write_figures(sample_gait(), tmp_path, ("gif",))
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot make the directory"):
        write_figures(sample_gait(), tmp_path / "file" / "x")
