"""`gaitopt simulate --page --video`: what was simulated can be seen."""

import re
import shutil

import mujoco
import numpy as np
import pytest
from sample_gait import sample_gait

from gaitopt.cli.simulate import replays
from gaitopt.simulate import battery as trials
from gaitopt.simulate.battery import CHECKS, PUSHED, Battery, PushLimit
from gaitopt.simulate.disturbance import Disturbance, Push
from gaitopt.simulate.mujoco_model import simulated_robot
from gaitopt.simulate.walk import WalkOptions, simulate


def test_postures_of_mujoco_are_those_of_the_body():
    body = sample_gait().trajectory.body
    robot = simulated_robot(body)
    known = sample_gait().trajectory.at(np.linspace(0.0, 0.7, 9)).configuration
    rows = np.array([robot.position(one) for one in known])
    assert robot.configuration(rows) == pytest.approx(known, abs=1e-15)
    data = mujoco.MjData(robot.model)
    data.qpos[:] = rows[4]
    mujoco.mj_kinematics(robot.model, data)
    places = body.placements(robot.configuration(rows))[4]
    for joint, name in enumerate(body.joint_names):
        found = data.xpos[robot.model.body(f"body {name}").id]
        assert found == pytest.approx(places[joint + 1, :3, 3], abs=1e-9)


def test_a_push_is_shown_when_it_came():
    """Just before it begins the walk is the undisturbed one, soon after it is another."""
    gait = sample_gait()
    options = WalkOptions(steps=PUSHED + 2, frames=200.0)
    undisturbed = simulate(gait, options)
    push = Push((20.0, 0.0, 0.0), step=PUSHED)
    walk = simulate(gait, options, disturbance=Disturbance(push=push))
    limit = PushLimit("forward", 20.0, 0.3, 1.0, walk, False)
    first, shown = replays(gait, undisturbed, Battery((), (limit,), ()))
    assert shown.name == "pushed forward, 20 N·s"
    (seen,) = shown.pushes
    assert seen.impulse == pytest.approx((20.0, 0.0, 0.0))
    count = min(len(first.time), len(shown.time))
    apart = np.abs(first.configuration[:count] - shown.configuration[:count]).max(axis=1)
    begun = shown.time[:count][apart > 1e-9][0]
    assert 0.0 < begun - seen.begins < 0.01


@pytest.mark.usefixtures("known_stability")
def test_a_page_and_a_film_are_written(cli, designed, tmp_path, monkeypatch):
    monkeypatch.setattr(trials, "STEPS", 2)
    monkeypatch.setattr(trials, "CHECKS", CHECKS[:1])
    made = []
    monkeypatch.setattr(
        "gaitopt.view.video.write_video",
        lambda gait, shown, path: (made.extend(one.name for one in shown), path)[1],
    )
    monkeypatch.setattr(shutil, "which", lambda name: "/bin/true")
    page, film = tmp_path / "page.html", tmp_path / "film.mp4"
    words = ("--steps", "3", "--page", page, "--video", film)
    result = cli("simulate", designed / "gait.npz", *words)
    assert result.exit_code == 0, result.stderr
    assert result.stdout.endswith(f"wrote {page}\nwrote {film}\n")
    text = page.read_text()
    assert re.findall(r"<button>(.*?)</button>", text) == ["undisturbed", "mass +5 %"]
    assert "undisturbed: walked all steps" in text
    assert "<h2>Walked in MuJoCo, friction 0.8</h2>" in text
    assert made == ["undisturbed"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--page", "."), "'--page': '.' is wrong; give a file whose"),
        (("--page", f"{__file__}/x.html"), "is a file; give another --page directory"),
        (("--video", "walk.txt"), "a video 'walk.txt' cannot be made; end its name in .mp4"),
        (("--video", "walk.mp4"), "a video is made by ffmpeg, which is not there; install it"),
    ],
)
def test_what_cannot_be_written_is_told_before_any_work(
    cli, designed, words, message, monkeypatch, tmp_path
):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("gaitopt.cli.simulate.loaded", lambda path: pytest.fail("work"))
    result = cli("simulate", designed / "gait.npz", *words)
    assert result.exit_code == 2
    assert message in result.stderr
    assert not list(tmp_path.iterdir())
