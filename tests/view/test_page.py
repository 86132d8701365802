import base64
import html
import json
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.image import imread
from sample_gait import bare_gait, sample_gait
from synthetic_bipeds import synthetic

from gaitopt.errors import InputError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.view.figures import FIGURES, write_figures
from gaitopt.view.page import page_text, write_page
from gaitopt.view.viewer import umsgpack

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
FLAGS = (
    "--headless", "--no-sandbox", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--window-size=640,480", "--virtual-time-budget=1500",
)  # fmt: skip


@pytest.fixture(scope="module")
def text():
    return page_text(sample_gait(), steps=2)


@pytest.fixture(scope="module")
def commands(text):
    packed = json.loads(re.search(r"const commands = (\[.*?\]);</script>", text)[1])
    return [umsgpack.unpackb(base64.b64decode(c)) for c in packed]


def tracks(commands, end):
    """The tracks of the one animated node whose path ends so: name to (times, values)."""
    (clips,) = [c["animations"] for c in commands if c["type"] == "set_animation"]
    (clip,) = [c["clip"] for c in clips if c["path"].endswith(end)]
    assert clip["fps"] == 1
    return {
        t["name"]: (
            np.array([k["time"] for k in t["keys"]]),
            np.array([k["value"] for k in t["keys"]]),
        )
        for t in clip["tracks"]
    }


def test_the_page_needs_no_network(text):
    markup = text.replace(re.search(r"<script>(.*?)</script>", text, re.DOTALL)[0], "")
    assert not re.search(r"<(script|link|img)[^>]*(src|href)=", markup)
    assert "@TITLE@" not in text
    assert "@MESHCAT@" not in text
    assert "@FIT@" not in text


def test_the_page_tells_what_is_known(text):
    facts = dict(re.findall(r"<dt>(.*?)</dt><dd>(.*?)</dd>", text))
    assert facts == {
        "speed": "1 m/s",
        "step": "0.400 m in 0.400 s",
        "mass": "56.87 kg",
        "cost": "3346.48 N²·m·s",
        "solver": "optimal: the first-order conditions hold",
        "certificate": "optimal to first order, verified",
    }
    bare = dict(re.findall(r"<dt>(.*?)</dt><dd>(.*?)</dd>", page_text(bare_gait(), steps=1)))
    assert set(bare) == {"speed", "step"}


def test_what_people_wrote_cannot_break_the_page():
    evil = replace(sample_gait(), meta={"status": "</dd><script>alert(1)</script>"})
    assert "<script>alert" not in page_text(evil, steps=1)


def test_keys_increase_and_last_as_long_as_the_walk(commands):
    (clips,) = [c["animations"] for c in commands if c["type"] == "set_animation"]
    for clip in clips:
        for track in clip["clip"]["tracks"]:
            times = [k["time"] for k in track["keys"]]
            assert np.all(np.diff(times) > 0.0)
            assert times[-1] == pytest.approx(0.8)


def test_the_arrow_is_as_long_as_the_force_and_starts_at_the_pressure(commands):
    gait = sample_gait()
    size = np.linalg.norm(gait.ground_wrench[:, :3], axis=1)
    assert tracks(commands, "ground_force/shaft")[".scale"][1][:31, 2] == pytest.approx(size / 1e3)
    assert tracks(commands, "ground_force/head")[".position"][1][:31, 2] == pytest.approx(
        size / 1e3
    )
    foot = tracks(commands, "ground_force")[".position"][1]
    assert foot[:31, :2] == pytest.approx(gait.cop, abs=1e-12)


def test_the_world_moves_back_at_walking_speed(commands):
    times, place = tracks(commands, "/world")[".position"]
    assert (place[-1, 0] - place[0, 0]) / times[-1] == pytest.approx(-1.0, rel=1e-9)


def test_bad_requests_are_refused(tmp_path):
    with pytest.raises(InputError, match="0 steps"):
        write_page(sample_gait(), tmp_path / "x.html", steps=0)
    with pytest.raises(InputError, match="cannot write"):
        write_page(sample_gait(), tmp_path / "no" / "x.html", steps=1)


def test_lost_meshes_are_told_and_the_robot_is_drawn_without_them():
    mesh = '<visual><geometry><mesh filename="package://nowhere/a.stl"/></geometry></visual>'
    lost = replace(sample_gait(), urdf=sample_gait().urdf.replace("</link>", mesh + "</link>", 1))
    text = page_text(lost, steps=1)
    assert "the mesh &#x27;package://nowhere/a.stl&#x27; was not found: it is not drawn" in text
    assert "as a skeleton" not in text  # all other shapes are there
    blank = re.sub(r"<visual>.*?</visual>", mesh, sample_gait().urdf, flags=re.S)
    bones = page_text(replace(sample_gait(), urdf=blank), steps=1)
    assert "its package (--package-dir). The robot is drawn as a skeleton" in bones


def screenshot(page, fragment, folder):
    picture = folder / "shot.png"
    command = [BROWSER, *FLAGS, f"--user-data-dir={folder / 'profile'}"]
    command += [f"--screenshot={picture}", f"{page.as_uri()}#{fragment}"]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    return imread(picture)[..., :3]


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium browser found")
def test_a_browser_draws_the_robot_and_it_moves(tmp_path):
    page = write_page(sample_gait(), tmp_path / "gait.html", steps=2)
    first = screenshot(page, "t=0.1&paused", tmp_path)
    second = screenshot(page, "t=0.3&paused", tmp_path)
    middle = (slice(60, 400), slice(220, 420))  # between the cards: only WebGL paints here
    assert first[middle].std() > 0.05
    changed = np.abs(first[middle] - second[middle]).max(axis=2) > 0.1
    assert changed.mean() > 0.01
    orange = (first[middle] - [0.88, 0.48, 0.06]) ** 2
    assert (orange.sum(axis=2) < 0.02).sum() > 50  # the force arrow


# no requestAnimationFrame: a busy machine draws no frame within the virtual time
PROBE = """<script>
function tell() {
  const box = name => document.getElementById(name).getBoundingClientRect();
  const bar = box("controls"), play = box("play"), zoom = viewer.camera.zoom;
  const edge = share => innerHeight * (1 - zoom * share) / 2;
  document.title = JSON.stringify({
    bar: [bar.left, bar.right], play: [play.left, play.right], wide: innerWidth,
    head: edge(reach.top), card: box("facts").bottom, feet: edge(-reach.bottom), low: bar.top,
    side: zoom * reach.side * innerHeight / innerWidth,
  });
}
tell();
addEventListener("resize", tell);  // after the page's own listener
</script></body>"""


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium browser found")
def test_a_narrow_window_has_room_for_the_robot_and_the_buttons(tmp_path):
    page = tmp_path / "narrow.html"
    page.write_text(page_text(sample_gait(), steps=2).replace("</body>", PROBE))
    command = [BROWSER, *FLAGS, f"--user-data-dir={tmp_path / 'profile'}", "--dump-dom"]
    command += ["--window-size=500,640", page.as_uri()]
    done = subprocess.run(command, check=True, capture_output=True, timeout=120)
    seen = json.loads(html.unescape(re.search(r"<title>({.*?})</title>", done.stdout.decode())[1]))
    assert seen["wide"] <= 500
    assert 0.0 < seen["bar"][0] < seen["play"][0] < seen["play"][1] < seen["bar"][1] < seen["wide"]
    assert seen["card"] < seen["head"] < seen["feet"] < seen["low"]
    assert 0.05 < seen["side"] < 1.0


@pytest.mark.parametrize("name", ["five and arms", "seven, torso first"])
def test_robots_of_other_joints_are_drawn(name, tmp_path):
    robot = synthetic(name)
    problem = WalkProblem(robot, preset_task(boundary="lifted", speed=0.5, duration=0.5))
    gait = gait_at(problem, first_guess(problem), {})
    assert gait.text("robot") in page_text(gait, steps=2)
    sizes = [imread(path).shape[:2] for path in write_figures(gait, tmp_path)]
    assert sizes[list(FIGURES).index("torques")][0] == 150 * 2.5 * (3 if "five" in name else 4)
