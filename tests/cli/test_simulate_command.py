"""`gaitopt simulate`: a gait that walks, one that falls, and what is said of either."""

import json

import pytest


@pytest.fixture(scope="module")
def robust(quick, tmp_path_factory):
    """A gait of 1.0 m/s with margins for feedback."""
    directory = tmp_path_factory.mktemp("robust")
    assert quick("--preset", "robust", "--speed", "1.0", "-o", directory).exit_code == 0
    return directory / "gait.npz"


def test_a_robust_gait_walks_twenty_steps(cli, robust, tmp_path):
    report = tmp_path / "walk.json"
    result = cli("simulate", robust, "-o", report)
    assert result.exit_code == 0, result.stdout + result.stderr
    record = json.loads(report.read_text())
    assert record["ending"] == "walked all steps"
    assert record["steps"] == record["asked_steps"] == 20
    assert record["speed_m_s"] == pytest.approx(1.0, rel=0.02)
    assert record["step_time_s"]["mean"] == pytest.approx(record["designed_step_time_s"], rel=0.02)
    assert 1.0 < record["cost_N2ms"] / record["designed_cost_N2ms"] < 1.1
    assert record["second_engine"]["agrees"]
    assert not any(point["weak"] for point in record["weak_points"])
    assert max(joint["torque_Nm"] for joint in record["joints"].values()) <= 150.0
    for words in (
        "20",
        "second engine: MuJoCo",
        "agrees at 601 instants",
        "closed loop / designed",
    ):
        assert words in result.stdout


def test_a_fall_says_why(cli, robust):
    """Joint feedback knows no sole; ice holds nobody."""
    for words in (("--controller", "joint-pd"), ("--friction", "0.05")):
        result = cli("simulate", robust, *words)
        assert result.exit_code == 1
        assert "fell:" in result.stdout
        assert "cause:" in result.stdout


def test_a_fragile_gait_names_the_options(cli, designed):
    result = cli("simulate", designed / "gait.npz", "--steps", "3", "--controller", "joint-pd")
    assert "--knee-flexion" in result.stdout
    assert "--torsional-friction" in result.stdout


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--steps", "0"), "0 steps cannot be simulated; ask for 1 to"),
        (
            ("--controller", "mpc"),
            "--controller mpc is unknown; choose one of whole-body, joint-pd",
        ),
        (("--friction", "-1"), "--friction -1: it must be above 0"),
        (("-o", "no/such/walk.json"), "there is no directory"),
    ],
)
def test_bad_words_are_refused(cli, designed, words, message):
    result = cli("simulate", designed / "gait.npz", *words)
    assert result.exit_code == 2
    assert message in result.stderr
