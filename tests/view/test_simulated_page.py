"""A simulated walk beside the designed one: page and film. Here a walk that is known exactly."""

import re
import shutil
import stat
import sys

import numpy as np
import pytest
from browser import BROWSER
from page_scene import data_of, numbers, places, scene_of, tracks_of
from sample_gait import sample_gait
from test_page import browsed

from gaitopt.errors import InputError
from gaitopt.view import video
from gaitopt.view.animation import PUSH, PUSH_SEEN, Replay, ShownPush
from gaitopt.view.page import simulated_page
from gaitopt.view.page_parts import Section
from gaitopt.view.video import RATE, pictures, write_video

GAIT = sample_gait()
TIMES = np.linspace(0.0, 1.0, 31)
SHIFT = np.array([0.1, -0.2, 0.05])


def replay(name="as designed, elsewhere", times=TIMES, pushes=()):
    """The designed walk, moved."""
    configuration = GAIT.trajectory.at(times).configuration.copy()
    configuration[:, :3] += SHIFT
    return Replay(name, "walked <all> steps", times, configuration, pushes)


FORWARD = ShownPush(0.3, (30.0, 0.0, 0.0))
PUSHED = replay("pushed", np.linspace(0.0, 0.8, 25), (FORWARD,))
TABLES = (Section("Measured", ("what", ">value"), (("speed", "1 m/s"),)),)


@pytest.fixture(scope="module")
def text():
    return simulated_page(GAIT, [replay(), PUSHED], TABLES)


def tracks(text, film):
    return tracks_of(text, data_of(text)["films"][film]["motion"])


def test_both_robots_walk_as_they_did(text):
    placed = {c["path"]: c["matrix"] for c in scene_of(text) if c["type"] == "set_transform"}
    gap = placed["/meshcat/world/along/designed"][13]
    assert gap > 0.5  # m, to the left
    for film in (0, 1):
        found = tracks(text, film)
        simulated = {k: v for k, v in found.items() if "/along/robot/" in k}
        assert len(simulated) == 13
        for path, values in simulated.items():
            designed = found[path.replace("/along/", "/along/designed/")]
            assert values[".position"] == pytest.approx(designed[".position"] + SHIFT, abs=1e-6)
            assert values[".quaternion"] == pytest.approx(designed[".quaternion"], abs=1e-6)


def test_a_push_is_drawn_while_it_is_to_be_seen_and_ends_at_the_pelvis(text):
    for film, times, pushed in ((0, TIMES, False), (1, PUSHED.time, True)):
        found = tracks(text, film)["/meshcat/world/along/push"]
        seen = found[".scale"][:, 0] == 1.0
        wanted = (times >= 0.3) & (times <= 0.3 + PUSH_SEEN) & pushed
        assert (seen == wanted).all()
    head = tracks(text, 1)["/meshcat/world/along/push/head"][".position"][seen]
    places = GAIT.trajectory.body.placements(PUSHED.configuration)[..., :3, 3]
    hips = [GAIT.trajectory.body.leg(foot)[-1] + 1 for foot in (0, 1)]
    pelvis = places[:, hips].mean(axis=1)[seen]
    tip = found[".position"][seen] + head[:, [2]] * [1.0, 0.0, 0.0]  # it points forward
    assert tip == pytest.approx(pelvis, abs=1e-5)


def test_curves_are_those_of_both_walks(text):
    base, angle = data_of(text)["films"][0]["curves"]["tabs"]
    by_name = {panel["title"]: panel["lines"] for panel in base["panels"]}
    ahead, left, rise, tilt = (
        [numbers(line["y"]) for line in by_name[name]]
        for name in ("base ahead of the design", "base to the left", "rise of the base",
                     "tilt of the base")
    )  # fmt: skip
    assert ahead[0] == pytest.approx(np.full(31, SHIFT[0]), abs=1e-6)
    assert left[0] - left[1] == pytest.approx(np.full(31, SHIFT[1]), abs=1e-6)
    assert rise[0] - rise[1] == pytest.approx(np.full(31, SHIFT[2]), abs=1e-6)
    assert tilt[0] == pytest.approx(tilt[1], abs=1e-5)
    assert len(angle["panels"]) == 12
    for panel in angle["panels"]:
        simulated, designed = (numbers(line["y"]) for line in panel["lines"])
        assert simulated == pytest.approx(designed, abs=1e-6)
        assert np.ptp(simulated) > 0.0


def test_the_page_says_what_came_of_it_and_holds_the_tables(text):
    facts = dict(re.findall(r"<dt>(.*?)</dt><dd>(.*?)</dd>", text))
    assert {"designed speed", "designed step"} <= set(facts)  # what was walked is in the tables
    assert not {"speed", "step", "cost"} & set(facts)
    assert 'id="verdict">as designed, elsewhere: walked &lt;all&gt; steps<' in text
    assert "<h2>Measured</h2>" in text
    assert "push, at the pelvis" in text
    assert re.findall(r"<button>(.*?)</button>", text) == ["as designed, elsewhere", "pushed"]
    assert all(set(film["words"]) <= places(text) for film in data_of(text)["films"])
    alone = simulated_page(GAIT, [replay()], ())
    assert "push, at the pelvis" not in alone
    assert text.count("these as designed") == alone.count("these as designed") == 1
    assert 'id="replays"' not in alone


CHOOSE = """
const placed = () => {
  seek(0.35);
  viewer.scene.updateMatrixWorld(true);
  return ROBOTS.map(path => {
    const found = [];
    viewer.scene_tree.find(path).object.traverse(part => {
      if (part.geometry) found.push(part.matrixWorld.elements[13]);  // heights
    });
    return found;
  });
};
const seen = { first: placed() };
document.querySelectorAll("#replays button")[1].click();
seen.second = placed();
seen.verdict = document.getElementById("verdict").textContent;
seen.duration = animator.duration;
document.title = JSON.stringify(seen);
"""


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium browser found")
def test_a_browser_shows_two_robots_and_the_walk_that_is_chosen(text, tmp_path):
    seen = browsed(text, CHOOSE, tmp_path, "1200,800")
    for robots in (seen["first"], seen["second"]):
        assert len(robots[0]) == len(robots[1]) > 20
        # its copy of the shapes stands where the robot does, but for the shift
        assert robots[0] == pytest.approx(np.array(robots[1]) + SHIFT[2], abs=1e-4)
    assert seen["verdict"] == "pushed: walked <all> steps"
    assert seen["duration"] == pytest.approx(0.8)


def test_too_many_steps_are_refused():
    long = np.linspace(0.0, 1000.0, 20)
    with pytest.raises(InputError, match=r"2,?500 steps on a page"):
        simulated_page(GAIT, [replay(times=long)], ())


def test_pictures_show_the_push_while_it_is_to_be_seen():
    made = [np.frombuffer(one, np.uint8).reshape(-1, 4) for one in pictures(GAIT, [PUSHED])]
    assert len(made) == 0.8 * RATE
    violet = np.array([int(PUSH[k : k + 2], 16) for k in (1, 3, 5)])
    seen = [bool((np.abs(one[:, :3].astype(int) - violet).sum(axis=1) < 30).any()) for one in made]
    times = np.arange(len(made)) / RATE
    assert seen == [0.3 <= time < 0.3 + PUSH_SEEN for time in times]
    dark = [(one[:, :3].sum(axis=1) < 240).sum() for one in made]
    assert min(dark) > 500  # a trunk
    assert not np.array_equal(made[0], made[5])


def test_a_film_says_which_leg_has_which_colour():
    film = video._Film(GAIT, PUSHED, video.trunk_top(GAIT))
    film.picture(3)
    (legend,) = film._figure.legends
    names = [text.get_text() for text in legend.get_texts()]
    assert names == ["right leg", "left leg", "trunk", "as designed"]
    colours = dict(zip(names, (line.get_color() for line in legend.get_lines()), strict=True))
    for view in film._views:
        for foot, name in ((0, "right leg"), (1, "left leg")):  # the right one stands first
            (drawn,) = [
                line
                for line in view._parts[1]
                if np.array_equal(line.get_xdata(), film._walks[1].legs[3, foot][:, view._axis])
            ]
            assert drawn.get_color() == colours[name]
        assert {line.get_color() for line in view._parts[0]} == {colours["as designed"]}


def ffmpeg(folder, body):
    """A program that stands in for ffmpeg, written in Python."""
    path = folder / "ffmpeg"
    path.write_text(f"#!{sys.executable}\nimport sys\n{body}\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


def test_ffmpeg_is_given_every_picture(tmp_path, monkeypatch):
    copy = "open(sys.argv[-1], 'wb').write(repr(sys.argv).encode() + sys.stdin.buffer.read())"
    program = ffmpeg(tmp_path, copy)
    monkeypatch.setattr(shutil, "which", lambda name: program)
    short = replay(times=np.linspace(0.0, 0.1, 4))
    path = write_video(GAIT, [short, short], tmp_path / "walk.mp4")
    words, _, rest = path.read_bytes().partition(b"]")
    assert b"'-s', '960x540'" in words
    assert b"yuv420p" in words
    assert rest == b"".join(pictures(GAIT, [short, short]))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["ffmpeg", "walk.mp4"]


def test_what_ffmpeg_cannot_do_is_told_and_leaves_nothing(tmp_path, monkeypatch):
    program = ffmpeg(tmp_path, "sys.exit('Unknown encoder')")
    monkeypatch.setattr(shutil, "which", lambda name: program)
    with pytest.raises(InputError, match=r"cannot make .walk\.webm.: Unknown encoder; try another"):
        write_video(GAIT, [replay()], tmp_path / "walk.webm")
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(InputError, match=r"install it \(apt install ffmpeg"):
        write_video(GAIT, [replay()], tmp_path / "walk.mp4")
    with pytest.raises(InputError, match=r"end its name in .mp4, .webm, .gif"):
        video.require_ffmpeg(tmp_path / "walk.txt")
    assert [p.name for p in tmp_path.iterdir()] == ["ffmpeg"]
