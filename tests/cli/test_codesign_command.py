"""`gaitopt codesign`: results, going on, refusals."""

import json

import pytest
from example_robots import needs_example_robots
from places import EXAMPLES

from gaitopt.catalogue.parameters import PARAMETERS, read_spec
from gaitopt.cli.codesign import TRIALS, earlier_trials, most_more, trial_of, trial_record
from gaitopt.cli.request import make_robot
from gaitopt.design.audit import problem_of
from gaitopt.design.requirements import requirements
from gaitopt.gait.gait_file import load_gait
from gaitopt.view.codesign_page import before_and_after

QUICK = ("--solver", "sqp", "--starts", "1", "--samples", "21")
GEARS = ("--motors", EXAMPLES / "motors.toml", "--speeds", "0.8")
ASKED = ("--vary", "hip_width=10cm:14cm", "--speeds", "0.8")


@pytest.fixture(scope="module")
def finished(cli, tmp_path_factory):
    folder = tmp_path_factory.mktemp("codesign") / "out"
    result = cli("codesign", *ASKED, *QUICK, "-o", folder)
    assert result.exit_code == 0, result.stderr
    return folder, result.stdout


def test_robot_walks_and_report_are_written(finished):
    folder, said = finished
    summary = json.loads((folder / "codesign.json").read_text("utf-8"))
    found = summary["parameters"]["hip_width"]
    assert found["of_the_robot"] == found["begun_at"] == pytest.approx(0.12)
    spec = read_spec(folder / "spec.toml")
    assert PARAMETERS["hip_width"].value(spec) == pytest.approx(found["found"])
    for name in ("before", "after"):
        gait = load_gait(folder / name / "1.npz")
        assert gait.cost == pytest.approx(summary[name])
        assert gait.fact("certificate", "certified") is True
    assert summary["after"] < summary["before"]
    assert "1 of 1 walks are certified" in said
    page = (folder / "report.html").read_text("utf-8")
    assert f"{found['found']:.4g}" in page
    assert "data:image/png;base64," in page
    assert "What holds it" in page
    assert 'name="viewport"' in page
    assert page.count("<table>") == page.count('<div class="table"><table>') == 3
    assert "gaitopt requirements before/1.npz --against after/1.npz" in page
    for text in summary["held"]:
        assert text in page


def test_what_the_motors_must_deliver_is_told(finished):
    folder, said = finished
    motors = json.loads((folder / "codesign.json").read_text("utf-8"))["motors"]
    found = {
        name: {one.motor: one for one in requirements({"": load_gait(folder / name / "1.npz")})}
        for name in ("before", "after")
    }
    more = []
    for figure in ("peak_torque", "peak_speed", "rms_torque", "peak_power"):
        values = {
            name: {motor: getattr(one, figure) for motor, one in of.items()}
            for name, of in found.items()
        }
        largest = max(max(of.values()) for of in values.values())
        for motor, own in motors.items():
            assert own["units"]["peak_power"] == "W"
            assert own["largest"][figure] == pytest.approx(largest, rel=1e-9)
            before, after = (own[name][figure] for name in ("before", "after"))
            assert before == pytest.approx(values["before"][motor], rel=1e-9)
            assert after == pytest.approx(values["after"][motor], rel=1e-9)
            more.append(
                ((after - before) / largest, motor, figure.replace("_", " "), before, after)
            )
    grown, motor, figure, before, after = max(more)
    assert grown > 0.01
    assert f"what a motor must deliver more: {motor}, {figure} " in said
    page = (folder / "report.html").read_text("utf-8")
    assert f"{100.0 * (after / before - 1.0):+.0f} %" in page


def test_a_figure_of_next_to_nothing_does_not_grow_most():
    units = {"peak_torque": "N·m"}
    motors = {
        "waist": {"before": {"peak_torque": 1e-9}, "after": {"peak_torque": 0.7}},
        "knee": {"before": {"peak_torque": 80.0}, "after": {"peak_torque": 96.0}},
        "hip": {"before": {"peak_torque": 100.0}, "after": {"peak_torque": 60.0}},
    }
    motors = {name: {**one, "units": units, "largest": {"peak_torque": 100.0}}
              for name, one in motors.items()}  # fmt: skip
    assert most_more(motors) == "knee, peak torque 80 -> 96 N·m"
    del motors["knee"]
    assert most_more(motors) == ""
    waist, hip = (next(before_and_after(motors[name])) for name in ("waist", "hip"))
    assert waist == "1e-09 \u2192 0.7 N·m"
    assert hip == "100 \u2192 60 N·m\n-40 %"


def test_the_same_command_goes_on(cli, finished, tmp_path):
    folder, _ = finished
    lines = (folder / TRIALS).read_text("utf-8").splitlines()
    other = tmp_path / "cut"
    (other / "before").mkdir(parents=True)
    (other / "before" / "1.npz").write_bytes((folder / "before" / "1.npz").read_bytes())
    (other / TRIALS).write_text("\n".join([*lines[:2], lines[2][:100]]))
    result = cli("codesign", *ASKED, *QUICK, "-o", other)
    assert result.exit_code == 0, result.stderr
    assert "goes on after 1 design of" in " ".join(result.stdout.split())
    again = (other / TRIALS).read_text("utf-8").splitlines()
    assert len(again) == len(lines)
    assert json.loads(again[-1])["values"] == json.loads(lines[-1])["values"]
    trials = earlier_trials(folder / TRIALS, json.loads(lines[0]))
    assert trials is not None
    for line, trial in zip(lines[1:], trials, strict=True):
        assert trial_record(trial) == json.loads(line)
        assert trial_of(json.loads(line)).cost == trial.cost


def test_gear_ratios_are_chosen(cli, tmp_path):
    out, table = tmp_path / "out", tmp_path / "motors.toml"
    table.write_bytes((EXAMPLES / "motors.toml").read_bytes())
    driven = ("--motors", table, "--cost", "energy", "--speeds", "0.8", *QUICK)
    asked = ("codesign", "--vary", "motors.knee.ratio=6:9", *driven)
    result = cli(*asked, "-o", out)
    assert result.exit_code == 0, result.stderr
    summary = json.loads((out / "codesign.json").read_text("utf-8"))
    found = summary["parameters"]["motors.knee.ratio"]
    assert found == {"unit": "", "of_the_robot": 8.0, "begun_at": 8.0, "found": 9.0}
    assert "motors.knee.ratio: 8 -> 9\n" in result.stdout
    assert "motors.knee.ratio" in (out / "report.html").read_text("utf-8")
    again = cli("optimise", "--motors", out / "motors.toml", *driven[2:4], "--speed", "0.8", *QUICK,
                "-o", tmp_path / "walk")  # fmt: skip
    assert again.exit_code == 0, again.stderr
    walk = load_gait(tmp_path / "walk" / "gait.npz")
    # two certified walks of one task, each exceeding limits by less than 1e-6 in its own way
    assert walk.cost == pytest.approx(summary["after"], rel=1e-5)
    table.write_text(table.read_text("utf-8").replace("friction = 0.5", "friction = 0.4"))
    result = cli(*asked, "-o", out)
    assert result.exit_code == 2
    assert "trials of another study" in " ".join(result.stderr.split())


@needs_example_robots
def test_a_robot_of_a_file_gets_choices_and_may_move_other_joints_in_each_walk(cli, tmp_path):
    asked = ("--vary", "foot_mass=0.55kg:0.65kg", "--speeds", "0.6", "--walk",
             "speed=0.5 move=waist_yaw_joint")  # fmt: skip
    result = cli("codesign", "--robot", "g1", *asked, *QUICK, "-o", tmp_path)
    assert result.exit_code == 0, result.stderr
    summary = json.loads((tmp_path / "codesign.json").read_text("utf-8"))
    assert summary["after"] < summary["before"]
    assert summary["parameters"]["foot_mass"]["found"] == pytest.approx(0.55)
    assert "foot mass is at the least value allowed" in " ".join(result.stdout.split())
    settings = {"robot": "g1", "choices": str(tmp_path / "choices.toml")}
    before, after = make_robot({"robot": "g1"}), make_robot(settings)
    assert before.mass - after.mass == pytest.approx(2.0 * (0.608 - 0.55))
    assert {"knee", "waist_yaw_joint"} < summary["motors"].keys()
    gait = load_gait(tmp_path / "after" / "1.npz")
    assert problem_of(gait).robot.mass == pytest.approx(after.mass)


def test_what_cannot_be_is_refused(cli, finished, tmp_path):
    folder, _ = finished
    for words, told in (
        (("--speeds", "0.8"), "numbers to choose: --vary shin="),
        (("--vary", "hip_width=0.1:0.14"), "give the walks"),
        (("--vary", "nose=0.1:0.2", "--speeds", "0.8"), "give NAME=LOWER:UPPER"),
        (("--vary", "trunk_height=0.5:0.7", "--speeds", "0.8"), "cannot be chosen"),
        (("--vary", "hip_width=0.1:x", "--speeds", "0.8"), "give a number in m"),
        ((*ASKED, "--walk", "speed=0.8 weight=5kg"), "weight=5kg: give a number in digits"),
        (
            ("--vary", "hip_width=0.14:0.1", "--speeds", "0.8"),
            "0.14 to 0.1 m is empty; give the lower",
        ),
        ((*ASKED, "--walk", " "), "--walk is empty; give NAME=VALUE words"),
        (
            (*GEARS, "--vary", "motors.right_knee.ratio=6:9"),
            "have different motors; give the joints",
        ),
        ((*ASKED, "--walk", "speed=0.8 wings=2"), "NAME=VALUE words"),
        ((*ASKED, "--walk", "speed=0.8 weight=-1"), "weight must be above 0; give weight=1"),
        (("--vary", "shin=25cm", "--speeds", "0.8"), "--vary shin=25cm: give NAME=LOWER:UPPER or"),
        ((*ASKED, "--walk", "speed=0.8 robot=g1"), "the robot is the same for all walks"),
        (("--vary", "shin=25:35", "--speeds", "0.8"), "as in 25cm:35cm"),
        ((*ASKED, "--keep-leg"), "choose the shin or the thigh"),
        (("--vary", "motors.knee.ratio=6:9", "--speeds", "0.8"), "give a table of them: --motors"),
        (
            (*GEARS, "--vary", "motors.knee.ratio=6:9", "--armature", "*_knee=0.1"),
            "is 0.1 kg·m², wh",
        ),
        ((*GEARS, "--vary", "motors.wrist.ratio=6:9"), "'wrist' are no joints"),
        ((*GEARS, "--vary", "motors.knee.ratio=6:x"), "give a number"),
        ((*GEARS, "--vary", "motors.knee.ratio=nan:9"), "finite numbers"),
        ((*GEARS, "--vary", "motors.knee.ratio=-6:9"), "above 0"),
        ((*GEARS, "--vary", "knee.ratio=6:9"), "motors.ratio or motors.JOINTS.ratio"),
        ((*GEARS, "--vary", "motors.knee.inertia=1e-5:1e-4"), "or motors.JOINTS.ratio"),
        (("--vary", "foot_width=1:2", "--speeds", "0.6", "--robot", "g1"), "robot of a file"),
    ):
        result = cli("codesign", *words, *QUICK, "-o", tmp_path / "none")
        assert result.exit_code == 2, words
        assert told in " ".join(result.stderr.split()), words
        assert not (tmp_path / "none" / TRIALS).exists()
    other = ("--vary", "hip_width=10cm:15cm", "--speeds", "0.8")
    result = cli("codesign", *other, *QUICK, "-o", folder)
    assert result.exit_code == 2
    assert "trials of another study" in " ".join(result.stderr.split())
