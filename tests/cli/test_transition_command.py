"""`gaitopt transition`: what it says, writes and refuses."""

import os
import re
import signal

import numpy as np
import pytest
from gait_archives import changed, written
from transitions import from_rest
from transitions import walk as designed

import gaitopt.cli.transition as command
from gaitopt import load_transition, save_gait, save_transition
from gaitopt.view.figures import TRANSITION_FIGURES


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    gait = designed()
    return save_gait(gait, tmp_path_factory.mktemp("walk") / "gait.npz")


@pytest.fixture(scope="module")
def start(tmp_path_factory):
    path = tmp_path_factory.mktemp("start") / "start.npz"
    return save_transition(from_rest().transition, path)


def test_it_writes_a_file_and_says_what_it_found(cli, walk, tmp_path):
    path = tmp_path / "start.npz"
    result = cli("transition", "standing", walk, "--steps", 2, "--output", path)
    assert result.exit_code == 0, result.output
    assert "from standing to 1 m/s, 2 steps" in result.stdout
    assert "certified" in result.stdout
    assert load_transition(path).certified
    assert "kept walk, iterations" in result.stderr  # it tells how far it is


def test_ctrl_c_ends_with_the_error(cli, walk, monkeypatch, tmp_path):
    search = command.design_transition

    def interrupted(*args, **options):
        os.kill(os.getpid(), signal.SIGINT)
        return search(*args, **options)

    monkeypatch.setattr(command, "design_transition", interrupted)
    result = cli("transition", "standing", walk, "--steps", 2, "--output", tmp_path / "start.npz")
    assert result.exit_code == 130
    assert "round 1 (sqp), iteration" in result.stderr
    assert result.stderr.splitlines()[-1].startswith("error: interrupted before there was a result")


def test_its_file_is_checked(cli, start):
    result = cli("check", start)
    assert result.exit_code == 0, result.output
    text = " ".join(result.stdout.replace("1e-08", "").split())
    assert "from standing to 1 m/s in 2 steps, computed again" in text
    balance = re.search(r"ground (\S+) = weight (\S+) - loss (\S+) N·s", text)
    ground, weight, loss = (float(number) for number in balance.groups())
    assert ground == pytest.approx(weight - loss, abs=2e-3)
    assert loss > 1.0
    assert "stored arrays agree" in result.stdout


def test_an_altered_file_is_not_certified(cli, start, tmp_path):
    with np.load(start) as content:
        members = {name: content[name] for name in content.files}
    members["step_2_torque"] = changed("step_2_torque", members["step_2_torque"])
    result = cli("check", written(tmp_path / "x.npz", members, seal=False))
    assert result.exit_code == 1
    assert "step 2 torque (by" in result.output
    assert "changed after gaitopt wrote the file: step_2_torque" in " ".join(result.output.split())


def test_its_file_is_exported(cli, start, tmp_path):
    path = tmp_path / "motion.npz"
    result = cli("export", start, "--format", "mujoco", "--output", path)
    assert result.exit_code == 0, result.output
    with np.load(path) as content:
        assert content["foot_contact"][0].all()
        assert content["qpos"][-1, 0] - content["qpos"][0, 0] > 0.8  # steps and a stride


def test_its_file_is_drawn(cli, start, tmp_path):
    result = cli("play", start, "--html", tmp_path / "start.html")
    assert result.exit_code == 0, result.output
    assert (tmp_path / "start.html").stat().st_size > 100_000
    result = cli("plot", start, "--output", tmp_path / "figures", "--format", "svg")
    assert result.exit_code == 0, result.output
    assert {one.stem for one in (tmp_path / "figures").iterdir()} == set(TRANSITION_FIGURES)


@pytest.mark.parametrize(
    ("command", "words", "said"),
    [
        ("export", ("-o", "m.json"), "name a --format"),
        (
            "export",
            ("--format", "csv", "--strides", "2"),
            "only with the gait of a walk, not with a transition",
        ),
        ("export", ("-o", "m.csv", "--format", "csv", "--both-legs"), "leave --both-legs out"),
        ("export", ("--format", "bezier"), "choose another format"),
        ("play", ("--html", "x.html", "--steps", "3"), "leave --steps out"),
        ("requirements", (), "it is a transition"),
        ("sensitivity", (), "it is a transition"),
        ("simulate", (), "it is a transition"),
        ("transition", ("standing", "-o", "m.npz"), "it is a transition"),
    ],
)
def test_what_does_not_go_with_it_is_refused(
    cli, start, tmp_path, monkeypatch, command, words, said
):
    monkeypatch.chdir(tmp_path)
    result = cli(command, start, *words)
    assert result.exit_code == 2, result.output
    assert said in " ".join(result.output.split())
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("standing", "standing", "-o", "m.npz"), "give at least one"),
        (("standing", "nowhere.npz", "-o", "m.npz"), "there is no such file"),
        (("standin", "WALK", "-o", "m.npz"), "did you mean 'standing'"),
        (("standing", "WALK", "-o", "m.csv"), "end in .npz"),
        (("standing", "WALK", "-o", "nowhere/m.npz"), "there is no directory"),
        (("standing", "WALK", "-o", "WALK"), "is one of the gaits"),
        (("standing", "WALK", "-o", "m.npz", "--duration", "soon"), "give seconds"),
        (("standing", "WALK", "-o", "m.npz", "--duration", "nan"), "from 0.05 to 5.0 s"),
        (("standing", "WALK", "-o", "m.npz", "--steps", "9"), "give 1 to 8"),
        (("standing", "WALK", "-o", "m.npz", "--shift", "-1"), "or 0"),
        (("WALK", "standing", "-o", "m.npz", "--shift", "0.3"), "from standing"),
        (("standing", "WALK", "-o", "m.npz", "--stretch", "0.1"), "from 0.5 to 0.999"),
    ],
)
def test_refusals(cli, walk, tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    result = cli("transition", *(walk if word == "WALK" else word for word in words))
    assert result.exit_code == 2
    assert said in " ".join(result.output.split())
    assert not list(tmp_path.iterdir())
