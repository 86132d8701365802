import numpy as np
import pytest
from sample_gait import bare_gait, sample_gait

from gaitopt.errors import InputError
from gaitopt.view.figures import FIGURES, make_figure, write_figures


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


def test_the_torque_figure_pairs_the_same_joint_of_both_legs():
    gait = sample_gait()
    figure = make_figure(gait, "torques")
    titles = [a.get_title(loc="left") for a in figure.axes]
    assert titles == ["hip yaw", "hip roll", "hip pitch", "knee", "ankle pitch", "ankle roll"]
    assert lines(figure, 3, "stance") == pytest.approx(gait.torque[:, 2])
    assert lines(figure, 3, "swing") == pytest.approx(gait.torque[:, 9])
    assert lines(figure, 3, "limit")[0] == -150.0


def test_limits_met_are_told():
    figure = make_figure(sample_gait(), "rates")
    assert [a.get_title(loc="right").split(" / ")[1] for a in figure.axes][3:] == ["100 %"] * 3


def test_the_cop_figure_tells_the_distance_to_the_edge():
    assert "5.0 mm" in make_figure(sample_gait(), "cop").get_suptitle()


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


def test_what_cannot_be_drawn_is_refused(tmp_path):
    with pytest.raises(InputError, match="no figure 'torque'; choose from step"):
        make_figure(sample_gait(), "torque")
    with pytest.raises(InputError, match="choose png, svg, pdf"):
        write_figures(sample_gait(), tmp_path, ("gif",))
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot make the directory"):
        write_figures(sample_gait(), tmp_path / "file" / "x")
