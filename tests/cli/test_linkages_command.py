"""`--linkages`: from a table to a walk that keeps it, checked and designed again from its files."""

from pathlib import Path

import numpy as np
import pytest

from gaitopt.actuators.linkages import read_linkages
from gaitopt.gait.gait_file import load_gait
from gaitopt.gait.motor_space import driven_joints
from gaitopt.gait.recorded import robot_of

TABLE = Path(__file__).parents[2] / "examples" / "linkages.toml"
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


def test_tables_that_do_not_fit_are_refused(cli, tmp_path):
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(TABLE.read_text("utf-8").replace("left_ankle_roll", "left_toe"), "utf-8")
    result = cli("optimise", "--linkages", wrong)
    assert result.exit_code == 2
    assert "a linkage turns 'left_toe', but no joint that moves by itself" in result.stderr
    missing = cli("optimise", "--linkages", tmp_path / "none.toml")
    assert missing.exit_code == 2
    assert "none.toml" in missing.stderr
