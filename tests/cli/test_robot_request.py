"""Which robot the options of the command line mean."""

import numpy as np
import pytest

from gaitopt import biped13, urdf_text
from gaitopt.cli.request import (
    biped_spec,
    limit_of,
    make_request,
    make_robot,
    robot_source,
    sole_of,
)
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


def test_limits_of_joints():
    limits = ["knee.speed=8rpm", "*hip*.torque=80Nm", "left_knee.torque=0.09kNm"]
    limits += ["right_knee.torque=90", "ankle_pitch.range=-30deg:none"]
    robot = make_robot({"limit": limits})
    names = list(robot.joint_names)
    knees = [i for i, name in enumerate(names) if "knee" in name]
    hips = [i for i, name in enumerate(names) if "hip" in name]
    assert robot.limits.speed[knees] == pytest.approx(8.0 * np.pi / 30.0)
    assert robot.limits.speed[hips] == pytest.approx(10.0)
    assert robot.limits.torque[knees] == pytest.approx(90.0)
    assert robot.limits.torque[hips] == pytest.approx(80.0)
    text = limit_of("*_knee.range = 0deg : 2.0")
    assert (text.joints, text.lower, text.upper) == ("*_knee", 0.0, 2.0)
    assert limit_of("a.b.torque=none").torque == np.inf
    assert limit_of("knee.range=none:1").lower == -np.inf
    for wrong, said in (
        ("knee=8", "give JOINTS.WHAT=VALUE"),
        (".speed=8", "give JOINTS.WHAT=VALUE"),
        ("knee.sped=8", "one of torque, speed, lower, upper, armature"),
        ("knee.range=8", "range, with LOWER:UPPER"),
        (
            "knee.speed=8Nm",
            "--limit knee.speed=8Nm: give a number in rad/s.*rpm; .* slides: m/s, .*, or none",
        ),
        ("knee.speed", "give JOINTS.WHAT=VALUE"),
    ):
        with pytest.raises(InputError, match=said):
            limit_of(wrong)
    with pytest.raises(InputError, match="no joint matches 'elbow'; the joints are"):
        make_robot({"limit": ["elbow.speed=8"]})


def test_limits_in_a_file_add_to_those_of_the_command_line(tmp_path):
    path = tmp_path / "task.toml"
    path.write_text(
        '[limits]\nknee.speed = "8rpm"\n"*hip*".torque = 80\n'
        'ankle_pitch = { range = [-0.5, "1rad"] }\n'
    )
    robot = make_request({"limit": ["knee.speed=9"]}, path).robot
    knee, hip = (robot.joint_names.index(f"right_{name}") for name in ("knee", "hip_pitch"))
    ankle = robot.joint_names.index("right_ankle_pitch")
    assert robot.limits.speed[knee] == pytest.approx(9.0)
    assert robot.limits.torque[hip] == pytest.approx(80.0)
    assert (robot.limits.lower[ankle], robot.limits.upper[ankle]) == (-0.5, 1.0)
    (tmp_path / "choices.toml").write_text('[[limits]]\njoints = "*"\ntorque = "70Nm"\n')
    other = make_request({"choices": tmp_path / "choices.toml"}, path).robot
    assert other.limits.torque[hip] == pytest.approx(70.0)
    assert other.limits.speed[knee] == pytest.approx(10.0)
    path.write_text("[limits]\nknee = 3\n")
    with pytest.raises(InputError, match=r"--limit knee=3: give JOINTS.WHAT=VALUE"):
        make_request({}, path)


def test_parameters_of_the_biped_by_words(cli, tmp_path):
    assert biped_spec({"set": {"shin": 0.42}}).geometry.d3 == 0.42
    assert biped_spec({"robot": "paper", "set": {"hip width": 0.2}}).geometry.d7 == 0.2
    robot = make_robot({"set": {"shin": 0.42, "links.torso.mass": 45.0}})
    assert robot.mass == pytest.approx(56.87 + 4.45)
    for other in ({"urdf": tmp_path / "a.urdf"}, {"robot": "g1"}):
        with pytest.raises(InputError, match="--set changes a biped that gaitopt makes itself"):
            biped_spec({**other, "set": {"shin": 0.42}})
    refused = cli("optimise", "--set", "shn=0.4")
    assert refused.exit_code == 2
    assert "unknown entry shn; did you mean 'shin'?" in refused.stderr
    path = tmp_path / "task.toml"
    path.write_text('[robot]\nset = { shin = "42cm", "hip width" = "20cm" }\n')
    settings = make_request({"set": {"shin": 0.4}}, path).settings
    spec = biped_spec(settings)
    assert (spec.geometry.d3, spec.geometry.d7) == (0.4, 0.2)
