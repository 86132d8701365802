"""Linkages of a table and of a file: walks that keep them, checked and designed again."""

import numpy as np
import pytest
from looped_bipeds import parallel_ankles
from places import EXAMPLES

from gaitopt.actuators.linkages import read_linkages
from gaitopt.design.requirements import motor_loops, own_motor_loops
from gaitopt.design.summary import summarise
from gaitopt.gait.gait_file import load_gait
from gaitopt.gait.motor_space import driven_joints
from gaitopt.gait.result import robot_of
from gaitopt.view.comparison_figures import torque_speed_figure
from gaitopt.view.page import curves, page_text

TABLE = EXAMPLES / "linkages.toml"
QUIET = ("--no-page", "--no-figures", "-q")


@pytest.fixture(scope="module")
def walked(cli, tmp_path_factory):
    directory = tmp_path_factory.mktemp("linkages") / "walk"
    words = ("--speed", "0.8", "--starts", "1", "--solver", "sqp", "--linkages", TABLE)
    result = cli("optimise", *words, *QUIET, "-o", directory)
    assert result.exit_code == 0, result.stderr
    return directory


def test_a_walk_keeps_the_limits_and_says_so_again(cli, walked):
    gait = load_gait(walked / "gait.npz")
    power = max(
        group.values(gait.torque, gait.dq, gait.q)["power"].max()
        for group in driven_joints(robot_of(gait), read_linkages(TABLE))
    )
    assert power == pytest.approx(60.0, rel=1e-6)  # it decides
    assert cli("check", walked / "gait.npz").exit_code == 0
    again = walked.parent / "again"
    assert cli("optimise", "--config", walked / "task.toml", *QUIET, "-o", again).exit_code == 0
    np.testing.assert_allclose(load_gait(again / "gait.npz").cost, gait.cost, rtol=1e-6)


def test_inspect_says_what_a_table_turns(cli):
    result = cli("inspect", "--linkages", TABLE)
    assert result.exit_code == 0
    for side in ("left", "right"):
        assert f"motors turn {side}_ankle_pitch, {side}_ankle_roll" in result.stdout


@pytest.mark.parametrize("command", ["optimise", "inspect"])
def test_tables_that_do_not_fit_are_refused(command, cli, tmp_path):
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(TABLE.read_text("utf-8").replace("left_ankle_roll", "left_toe"), "utf-8")
    result = cli(command, "--linkages", wrong)
    assert result.exit_code == 2
    assert "a linkage turns 'left_toe', but no joint that moves by itself" in result.stderr
    missing = cli(command, "--linkages", tmp_path / "none.toml")
    assert missing.exit_code == 2
    assert "none.toml" in missing.stderr


@pytest.fixture(scope="module")
def looped(cli, tmp_path_factory):
    """A walk of the biped whose file closes loops, with motors as weak as decides."""
    directory = tmp_path_factory.mktemp("loops")
    (directory / "biped.xml").write_text(parallel_ankles(torque=4.0), "utf-8")
    words = ("--urdf", directory / "biped.xml", "--speed", "0.8", "--duration", "0.4")
    limit = ("--limit", "*_motor.speed=6", "--starts", "1", "--solver", "sqp")
    result = cli("optimise", *words, *limit, *QUIET, "-o", directory / "walk")
    assert result.exit_code == 0, result.stderr
    return directory / "walk"


def test_loops_of_a_file_need_no_table(cli, looped):
    """Both limits decide; the gait file alone says all of it again."""
    gait = load_gait(looped / "gait.npz")
    found = [g.values(gait.torque, gait.dq, gait.q) for g in driven_joints(robot_of(gait))]
    torque, speed = (max(np.abs(one[kind]).max() for one in found) for kind in ("torque", "speed"))
    assert torque == pytest.approx(4.0, rel=1e-5)
    assert speed == pytest.approx(6.0, rel=1e-5)
    checked = cli("check", looped / "gait.npz")
    assert checked.exit_code == 0
    assert "certified" in checked.stdout
    again = looped.parent / "again"
    assert cli("optimise", "--config", looped / "task.toml", *QUIET, "-o", again).exit_code == 0
    np.testing.assert_allclose(load_gait(again / "gait.npz").cost, gait.cost, rtol=1e-6)


def test_motors_of_linkages_stand_beside_the_joints(cli, looped):
    """In the summary, with what is used of their limits; on the page, with curves of their own."""
    gait = load_gait(looped / "gait.npz")
    facts = summarise(gait)
    assert [m["joint"] for m in facts["motors"]][-4:] == [
        "ankle pitch", "ankle roll", "inner motor", "outer motor",
    ]  # fmt: skip
    right = driven_joints(robot_of(gait))[0]
    of = right.values(gait.torque, gait.dq, gait.q)
    stance = facts["linkages"][0]
    assert (stance["name"], stance["leg"]) == ("right_inner_motor", "stance")
    assert stance["turns"] == ["right_ankle_pitch", "right_ankle_roll"]
    assert stance["peak_torque_Nm"] == np.abs(of["torque"][:, 0]).max()
    assert stance["peak_power_W"] == np.abs(of["power"][:, 0]).max()
    most = max(m["torque_used"] for m in facts["motors"][-2:])
    assert most == pytest.approx(1.0, rel=1e-5)
    tabs = {tab["name"]: tab["panels"] for tab in curves(gait)["tabs"]}
    inner = next(p for p in tabs["torque"] if p["title"] == "inner motor")
    assert inner["limits"] == [-4.0, 4.0]
    assert [line["side"] for line in inner["lines"]] == ["stance", "swing"]
    together = next(p for p in tabs["torque over speed"] if p["title"] == "inner motor")
    speed = next(p for p in tabs["speed"] if p["title"] == "inner motor")
    np.testing.assert_array_equal(together["lines"][1]["x"], speed["lines"][1]["y"])
    page = page_text(gait)
    assert "outer motor" in page


def test_requirements_are_those_of_the_motors_themselves(cli, looped, tmp_path):
    """In place of the joints that they turn: the same power, within their limits."""
    gait = load_gait(looped / "gait.npz")
    loops = {one.motor: one for one in own_motor_loops(gait)}
    assert list(loops) == ["hip yaw", "hip roll", "hip pitch", "knee", "inner motor", "outer motor"]
    joints = {one.motor: one for one in motor_loops(gait)}
    of_motors = loops["inner motor"].power + loops["outer motor"].power
    of_joints = joints["ankle pitch"].power + joints["ankle roll"].power
    np.testing.assert_allclose(of_motors, of_joints, atol=1e-9)
    inner = loops["inner motor"]
    assert (inner.torque_limit, inner.speed_limit) == (4.0, 6.0)
    result = cli("requirements", looped / "gait.npz", "--figure", tmp_path / "loops.svg")
    assert result.exit_code == 0, result.stderr
    assert "inner motor" in result.stdout
    assert "ankle" not in result.stdout
    panel = torque_speed_figure({"walk": list(loops.values())}).axes[4]
    levels = [line.get_ydata()[0] for line in panel.lines if len(set(line.get_ydata())) == 1]
    assert {-4.0, 4.0} < {*levels}


def test_a_table_gives_motors_too(walked):
    facts = summarise(load_gait(walked / "gait.npz"))
    assert [m["joint"] for m in facts["motors"]][-2:] == ["inner", "outer"]
    assert max(m["peak_power_W"] for m in facts["motors"][-2:]) >= 60.0 * (1.0 - 1e-6)


def test_inspect_tells_what_loops_amount_to(cli, looped):
    result = cli("inspect", "--urdf", looped.parent / "biped.xml")
    assert result.exit_code == 0
    told = " ".join(result.stdout.split())
    assert "through cranks and rods, at rates 1.2, 0.691; 1.2, -0.686" in told
    assert "cranks and rods of 0.4 kg stand still in a walk" in told


def test_a_table_for_joints_in_a_loop_is_refused_with_advice(cli, looped):
    file = ("--urdf", looped.parent / "biped.xml", "--linkages", TABLE, "--speed", "0.8")
    result = cli("optimise", *file, "-q")
    assert result.exit_code == 2
    assert "two linkages turn" in result.stderr
    assert "leave the loops of its file open by --without loops" in " ".join(result.stderr.split())
