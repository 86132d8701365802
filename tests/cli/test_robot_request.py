"""Which robot the options of the command line mean."""

import pytest

from gaitopt import biped13, urdf_text
from gaitopt.cli.request import biped_spec, make_request, make_robot, robot_source, sole_of
from gaitopt.errors import InputError


def test_the_usual_robot_is_the_thirteen_link_biped():
    assert make_robot({}).name == make_robot({"robot": "biped13"}).name == "biped13"


def test_bipeds_of_parameter_tables_have_their_specification(tmp_path):
    assert biped_spec({}) == biped_spec({"robot": "biped13"}) == biped13()
    assert biped_spec({"robot": "paper"}).geometry.l1 == -0.155
    path = tmp_path / "mine.toml"
    path.write_text('name = "mine"\n[geometry]\nd3 = 0.31\n')
    assert biped_spec({"spec": path}).geometry.d3 == 0.31
    assert biped_spec({"robot": "g1"}) is None
    assert biped_spec({"urdf": "a.urdf"}) is None


def test_single_options_win_over_the_file_of_choices(tmp_path):
    path = tmp_path / "choices.toml"
    path.write_text('forward = "x"\nasymmetry = 0.02\n')
    _, choices = robot_source({"choices": path, "forward": "-x"})
    assert (choices.forward, choices.asymmetry) == ("-x", 0.02)


def test_directories_of_meshes_are_kept_for_when_only_the_text_is_left(tmp_path):
    urdf = tmp_path / "share" / "toy_description" / "urdf" / "toy.urdf"
    urdf.parent.mkdir(parents=True)
    visual = '<visual><geometry><mesh filename="package://toy_description/a.stl"/></geometry>'
    text = urdf_text(biped13()).replace("</link>", f"{visual}</visual></link>", 1)
    urdf.write_text(text)
    robot = make_robot({"urdf": urdf, "package_dir": [tmp_path]})
    assert robot.choices.package_dirs == (
        str(tmp_path), str(urdf.parent.resolve()), str((tmp_path / "share").resolve())
    )  # fmt: skip


def test_a_stranger_gets_a_task_of_its_size(tmp_path):
    urdf = tmp_path / "robot.urdf"
    urdf.write_text(urdf_text(biped13()))
    own, other = make_request({}, None).task, make_request({"urdf": urdf, "speed": 0.7}, None).task
    assert (own.boundary, other.boundary) == ("closed", "lifted")
    assert own.margins.trunk_roll is None
    assert other.margins.trunk_roll > 0.0
    assert other.duration == pytest.approx(0.5, abs=0.15)
    asked = {"urdf": urdf, "preset": "standard", "duration": 0.45}
    assert make_request(asked, None).task.duration == 0.45


def test_another_robot_leaves_nothing_of_the_one_in_the_file(tmp_path):
    (tmp_path / "task.toml").write_text('[robot]\nurdf = "absent.urdf"\nforward = "-x"\n')
    assert make_request({"robot": "biped13"}, tmp_path / "task.toml").robot.name == "biped13"


def test_edges_of_a_sole():
    sole = sole_of("0.12, -0.05,0.03,-0.02")
    assert (sole.toe, sole.heel, sole.left, sole.right) == (0.12, -0.05, 0.03, -0.02)
    with pytest.raises(InputError, match="not four numbers"):
        sole_of("0.12,-0.05,0.03")
