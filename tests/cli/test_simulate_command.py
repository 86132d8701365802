"""`gaitopt simulate`: a gait that walks, one that falls, and what is said of either."""

import json
from dataclasses import replace

import pytest

from gaitopt import load_gait
from gaitopt.simulate import battery as trials
from gaitopt.simulate.battery import CHECKS


@pytest.fixture(scope="module")
def robust(quick, tmp_path_factory):
    """A gait of 1.0 m/s with margins for feedback."""
    directory = tmp_path_factory.mktemp("robust")
    assert quick("--preset", "robust", "--speed", "1.0", "-o", directory).exit_code == 0
    return directory / "gait.npz"


def test_a_robust_gait_walks_twenty_steps(cli, robust, tmp_path, monkeypatch):
    monkeypatch.setattr(trials, "STEPS", 5)
    result = cli("simulate", robust, "-o", tmp_path / "new")
    assert result.exit_code == 0, result.stdout + result.stderr
    summary = json.loads((tmp_path / "new" / "summary.json").read_text())
    assert summary["walk"]["speed_m_per_s"] == pytest.approx(
        1.0
    )  # what `optimise` writes is there too
    record = summary["simulation"]
    assert record["ending"] == "walked all steps"
    assert record["steps"] == record["asked_steps"] == 20
    assert record["speed_m_s"] == pytest.approx(1.0, rel=0.02)
    assert record["step_time_s"]["mean"] == pytest.approx(record["designed_step_time_s"], rel=0.02)
    assert record["designed_cost_N2ms"] == load_gait(robust).cost
    assert 1.0 < record["cost_N2ms"] / record["designed_cost_N2ms"] < 1.1
    assert record["second_engine"]["agrees"]
    assert 0.3 < record["stability"]["lqr"]["multiplier"] < 0.6
    assert record["stability"]["landing_time_s_rad"].keys() > {"middle", "toe left"}
    assert not any(point["weak"] for point in record["weak_points"])
    assert max(joint["torque_Nm"] for joint in record["joints"].values()) <= 150.0
    assert [check["name"] for check in record["checks"]] == [check.name for check in CHECKS]
    assert all(check["passed"] for check in record["checks"])
    assert record["pushes"] == record["starts"] == []
    for words in (
        "mass +5 %",
        "second engine: MuJoCo",
        "agrees at 601 instants",
        "closed loop / designed",
        "largest multiplier",
    ):
        assert words in result.stdout


@pytest.mark.usefixtures("known_stability")
def test_a_fall_says_why(cli, robust):
    """Joint feedback knows no sole; ice holds nobody."""
    for words in (("--controller", "joint-pd"), ("--friction", "0.05")):
        result = cli("simulate", robust, *words)
        assert result.exit_code == 1
        assert "fell:" in result.stdout
        assert "cause:" in result.stdout


def test_optimise_says_what_will_be_fragile(cli, quick):
    """The usual optimum grazes the ground and twists its foot; the robust one does neither."""
    result = quick("--speed", "1.0")
    assert "fragile: under feedback" in result.stderr
    assert "raise --landing-speed" in result.stderr
    assert "lower --torsional-friction" in result.stderr
    assert "fragile" not in quick("--speed", "1.0", "--quiet").stderr
    assert "fragile" not in quick("--speed", "1.0", "--preset", "robust").stderr


@pytest.mark.usefixtures("known_stability")
def test_a_fragile_gait_names_the_options(cli, designed, monkeypatch):
    monkeypatch.setattr(trials, "STEPS", 1)
    result = cli("simulate", designed / "gait.npz", "--steps", "3", "--controller", "joint-pd")
    assert "--knee-flexion" in result.stdout
    assert "--torsional-friction" in result.stdout


@pytest.mark.usefixtures("known_stability")
def test_thorough_tries_everything_and_names_causes(cli, robust, tmp_path, monkeypatch):
    """Every trial cut to its shortest; a check that nobody passes points to the gait."""
    shortest = {"STEPS": 1, "PUSHED": 1, "RECOVERED": 0, "BISECTIONS": 1, "STARTS": 2}
    for name, value in {**shortest, "START_STEPS": 1}.items():
        monkeypatch.setattr(trials, name, value)
    ice = replace(CHECKS[2], name="ice", friction=0.02)
    monkeypatch.setattr(trials, "CHECKS", (CHECKS[0], ice))
    words = ("--steps", "1", "--thorough", "-o", tmp_path)
    result = cli("simulate", robust, *words)
    assert result.exit_code == 0  # the walk as such is what is judged
    record = json.loads((tmp_path / "summary.json").read_text())["simulation"]
    assert len(record["checks"]) == 2 + len(trials.THOROUGH)
    assert [push["direction"] for push in record["pushes"]] == [
        "forward", "backward", "to the swing side", "to the stance side",
    ]  # fmt: skip
    assert [start["passed"] for start in record["starts"]] == [True, True]
    assert record["checks"][0]["passed"]
    assert not record["checks"][1]["passed"]
    assert record["checks"][1]["cause"] in ("friction used", "turning moment over load")
    assert "2 of 2" in result.stdout
    assert "cause: ice: nothing that it tries is too weak; nearest is the" in result.stdout


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--steps", "0"), "0 steps cannot be simulated; ask for 1 to"),
        (
            ("--controller", "mpc"),
            "--controller mpc is unknown; choose one of whole-body, joint-pd",
        ),
        (("--friction", "-1"), "friction of the simulated ground is -1.0; it must be between"),
        (("--friction", "1e-9"), "is 1e-09; it must be between 0.001 and 100: ice has"),
        (("--friction", "nan"), "is nan; it must be between 0.001 and 100"),
        (("-o", __file__), "is a file; give another --output directory"),
    ],
)
def test_bad_words_are_refused(cli, designed, words, message):
    result = cli("simulate", designed / "gait.npz", *words)
    assert result.exit_code == 2
    assert message in result.stderr
