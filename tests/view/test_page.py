import asyncio
import base64
import html
import io
import json
import re
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from browser import BROWSER, opened
from matplotlib.image import imread
from page_scene import data_of, numbers, scene_of, tracks_of
from sample_gait import bare_gait, sample_gait
from synthetic_bipeds import synthetic

from gaitopt.catalogue.entries import robot_by_name
from gaitopt.errors import InputError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.view.animation import build_scene
from gaitopt.view.figures import FIGURES, write_figures
from gaitopt.view.page import _prices, curves, details, facts, headline, page_text, write_page
from gaitopt.view.scene_server import play
from gaitopt.view.viewer import Node, RecordingWindow, page_file

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
def motion(text):
    return data_of(text)["motion"]


@pytest.fixture(scope="module")
def tracks(text, motion):
    return tracks_of(text, motion)


def test_the_page_needs_no_network(text):
    markup = text.replace(re.search(r"<script>(.*?)</script>", text, re.DOTALL)[0], "")
    assert not re.search(r"<(script|link|img)[^>]*(src|href)=", markup)
    assert not re.search(r"@[A-Z]+@", text)


def test_the_page_tells_what_is_known(text):
    facts = dict(re.findall(r"<dt>(.*?)</dt><dd>(.*?)</dd>", text))
    assert '<p class="verdict" id="verdict">optimal to first order, verified</p>' in text
    assert facts == {
        "speed": "1 m/s",
        "step": "0.400 m in 0.400 s",
        "mass": "56.87 kg",
        "cost": "3346.48 N²·m·s",
        "solver": "optimal: the first-order conditions hold",
    }
    unknown = page_text(bare_gait(), steps=1)
    assert '<span class="doubt">no certificate</span>' in unknown
    assert "doubt" not in re.search(r"<main.*</main>", text, re.DOTALL)[0]
    bare = dict(re.findall(r"<dt>(.*?)</dt><dd>(.*?)</dd>", unknown))
    assert set(bare) == {"speed", "step"}


def test_each_word_of_a_page_has_its_element():
    """A later answer of a live page writes into it by this name."""
    gait = sample_gait()
    scene = build_scene(Node(RecordingWindow()), gait, 1)
    for name in {**headline(gait), **details(gait, scene)}:
        assert f'id="{name}">@{name.upper()}@<' in page_file("page.html")


def test_tables_break_lines_and_say_motors_and_proof(text):
    assert "<h2>Motors</h2>" in text
    assert "<h2>Proof</h2>" in text
    assert "\\n" not in re.search(r'<div id="tables">.*?</main>', text, re.DOTALL)[0]


def test_what_limits_cost_is_told_with_digits_that_have_sense():
    record = {"kind": "limit", "name": "heel height", "words": "lower", "value": 8.8e-9,
              "unit": "m", "cost_per_unit": 2e7, "cost_unit": "N²·m·s"}  # fmt: skip
    set_by_hand = {**record, "kind": "setting", "name": "gap", "words": "the gap", "value": 0.0353}
    rows = list(_prices([record, set_by_hand]))
    assert [row[0] for row in rows] == ["heel height, lower limit", "the gap (gap)"]
    assert [row[1] for row in rows] == ["0 m", "0.0353 m"]


def test_what_people_wrote_cannot_break_the_page():
    evil = replace(sample_gait(), meta={"status": "</dd><script>alert(1)</script>"})
    assert "<script>alert" not in page_text(evil, steps=1)


def test_times_increase_and_last_as_long_as_the_walk(motion):
    times = numbers(motion["times"])
    assert np.all(np.diff(times) > 0.0)
    assert times[-1] == pytest.approx(0.8)


def test_the_arrow_is_as_long_as_the_force_and_starts_at_the_pressure(tracks):
    gait = sample_gait()
    size = np.linalg.norm(gait.ground_wrench[:, :3], axis=1)
    arrow = "/meshcat/world/along/ground_force"
    assert tracks[f"{arrow}/shaft"][".scale"][:31, 2] == pytest.approx(size / 1e3)
    assert tracks[f"{arrow}/head"][".position"][:31, 2] == pytest.approx(size / 1e3)
    assert tracks[arrow][".position"][:31, :2] == pytest.approx(gait.cop, abs=1e-7)


def test_the_world_moves_back_at_walking_speed(motion, tracks):
    place = tracks["/meshcat/world/along"][".position"]
    took = numbers(motion["times"])[-1]
    assert (place[-1, 0] - place[0, 0]) / took == pytest.approx(-1.0, rel=1e-6)


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


@pytest.mark.parametrize("kind", [str, Path])
def test_meshes_are_found_in_directories_of_packages(kind, tmp_path):
    corners = "".join(f"vertex {place}\n" for place in ("0 0 0", "0.1 0 0", "0 0.1 0"))
    (tmp_path / "near").mkdir()
    (tmp_path / "near" / "a.stl").write_text(
        f"solid a\nfacet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\nendsolid a\n"
    )
    mesh = '<visual><geometry><mesh filename="package://near/a.stl"/></geometry></visual>'
    gait = replace(sample_gait(), urdf=sample_gait().urdf.replace("</link>", mesh + "</link>", 1))
    assert "was not found" in page_text(gait, steps=1)
    assert "was not found" not in page_text(gait, 1, (kind(tmp_path),))
    with play(gait, 1, open_browser=False, package_dirs=(kind(tmp_path),), port=0) as player:
        assert "was not found" not in player.note


async def screenshot(page, fragment, folder):
    """The page in its own time, once its scene is drawn: nothing but the picture tells that."""
    folder.mkdir()
    async with opened(f"{page.as_uri()}#{fragment}", folder) as one:
        size = {"width": 640, "height": 480, "deviceScaleFactor": 1, "mobile": False}
        await one.call("Emulation.setDeviceMetricsOverride", **size)
        ends, before = time.monotonic() + 100.0, None
        while time.monotonic() < ends:
            data = (await one.call("Page.captureScreenshot", format="png"))["data"]
            picture = imread(io.BytesIO(base64.b64decode(data)))[..., :3]
            if data == before and picture[MIDDLE].std() > 0.05:
                break
            before = data
            await asyncio.sleep(0.3)
        return picture


MIDDLE = (slice(60, 400), slice(220, 420))  # between the cards: only WebGL paints here


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium browser found")
def test_a_browser_draws_the_robot_and_it_moves(tmp_path):
    page = write_page(sample_gait(), tmp_path / "gait.html", steps=2)
    first = asyncio.run(screenshot(page, "t=0.1&paused", tmp_path / "first"))
    second = asyncio.run(screenshot(page, "t=0.3&paused", tmp_path / "second"))
    assert first[MIDDLE].std() > 0.05
    changed = np.abs(first[MIDDLE] - second[MIDDLE]).max(axis=2) > 0.1
    assert changed.mean() > 0.01
    orange = (first[MIDDLE] - [0.88, 0.48, 0.06]) ** 2
    assert (orange.sum(axis=2) < 0.02).sum() > 50  # the force arrow


# no requestAnimationFrame: a busy machine draws no frame within the virtual time
PROBE = """
function tell() {
  const box = name => document.getElementById(name).getBoundingClientRect();
  const bar = box("controls"), play = box("play"), pane = box("pane"), zoom = viewer.camera.zoom;
  const edge = share => pane.top + pane.height * (1 - zoom * share) / 2;
  document.title = JSON.stringify({
    bar: [bar.left, bar.right], play: [play.left, play.right], wide: innerWidth,
    pane: [pane.top, pane.bottom], head: edge(reach.top), feet: edge(-reach.bottom), low: bar.top,
    side: zoom * reach.side * pane.height / pane.width, report: box("report").top,
    full: document.documentElement.scrollWidth,
  });
}
tell();
addEventListener("resize", tell);  // after the page's own listener
"""
# what a person does: open a tab, point at a panel, drag in it
HAND = """
setPlaying(false);
const told = () => [...document.querySelectorAll(".told")].map(t => t.textContent);
const seen = { tabs: [...document.querySelectorAll("#tabs button")].map(b => b.textContent) };
document.querySelector("#tabs button").click();
seek(0.1);
seen.before = told();
const panel = document.querySelector(".panel"), svg = panel.querySelector("svg");
const box = svg.getBoundingClientRect();
const at = share => ({ clientX: box.left + box.width * (46 + share * 246) / 300, buttons: 1,
                       pointerId: 1, bubbles: true });
svg.setPointerCapture = () => {};
svg.dispatchEvent(new PointerEvent("pointerdown", at(0.5)));
seen.middle = animator.time;
svg.dispatchEvent(new PointerEvent("pointermove", at(0.75)));
seen.later = animator.time;
seen.after = told();
const cursor = panel.querySelector(".cursor");
const drag = share => {
  svg.dispatchEvent(new PointerEvent("pointermove", at(share)));
  return [animator.time, Number(cursor.getAttribute("x1"))];
};
seen.edges = [1.1, 1.2, -0.1, -0.2].map(drag);
seek(data.duration);
seen.end = [Number(cursor.getAttribute("x1")), ...told()];
seek(seen.later);
panel.dispatchEvent(new PointerEvent("pointerenter"));
seen.lit = lit.length;
panel.dispatchEvent(new PointerEvent("pointerleave"));
seen.unlit = lit.length;
window.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight" }));
seen.nudged = animator.time;
document.getElementById("theme").click();
seen.dark = document.documentElement.classList.contains("dark");
seen.stands = document.querySelectorAll(".foot span").length;
document.title = JSON.stringify(seen);
"""


def browsed(text, script, folder, size, *flags):
    """What a script at the end of the page's own writes into the title."""
    page = folder / "probe.html"
    page.write_text(text.replace("viewer.moved = show;", f"{{{script}}}\nviewer.moved = show;"))
    command = [BROWSER, *FLAGS, f"--user-data-dir={folder / 'profile'}", "--dump-dom"]
    command += [f"--window-size={size}", *flags, page.as_uri()]
    done = subprocess.run(command, check=True, capture_output=True, timeout=300)
    return json.loads(html.unescape(re.search(r"<title>({.*?})</title>", done.stdout.decode())[1]))


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium browser found")
def test_a_narrow_window_has_room_for_the_robot_and_the_buttons(tmp_path):
    seen = browsed(page_text(sample_gait(), steps=2), PROBE, tmp_path, "500,640")
    assert seen["wide"] <= 500
    assert seen["full"] <= seen["wide"]
    assert 0.0 <= seen["bar"][0] < seen["play"][0] < seen["play"][1] < seen["bar"][1]
    assert seen["bar"][1] <= seen["wide"]
    assert seen["pane"][0] < seen["head"] < seen["feet"] < seen["pane"][1] <= seen["low"]
    assert seen["low"] < seen["report"]
    assert 0.05 < seen["side"] < 1.0


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium browser found")
def test_curves_and_walk_move_together(text, tmp_path):
    gait = sample_gait()
    seen = browsed(text, HAND, tmp_path, "1200,800")
    assert seen["tabs"] == ["torque", "speed", "power", "angle", "torque over speed", "ground"]
    assert (seen["middle"], seen["later"]) == pytest.approx((0.4, 0.6), abs=0.003)
    assert seen["nudged"] == pytest.approx(seen["later"] + gait.duration / 30.0)
    assert len(seen["before"]) == len(seen["after"]) == 6
    index = gait.trajectory.joint_names.index("right_hip_yaw")
    (exact,) = gait.trajectory.at(np.array([0.1])).torque[:, index]
    assert _number(seen["before"][0]) == pytest.approx(exact, rel=0.005)
    right, beyond, left, before = seen["edges"]
    assert right == beyond == pytest.approx([0.8, 292.0], abs=0.2)
    assert left == before == pytest.approx([0.0, 46.0], abs=0.2)
    last = gait.trajectory.at(np.array([0.8]), before=np.array([True])).torque[0, index]
    assert seen["end"][0] == pytest.approx(292.0)  # the end of the walk, not its beginning
    assert _number(seen["end"][1]) == pytest.approx(last, rel=0.005)
    assert seen["before"] != seen["after"]
    assert seen["lit"] > 0
    assert seen["unlit"] == 0
    assert seen["dark"] is True
    assert seen["stands"] == 2


def _number(told):
    return float(told.split(" / ")[0].replace("\u2212", "-"))


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium browser found")
def test_without_webgl_curves_and_time_are_there_all_the_same(text, tmp_path):
    """As in many virtual machines; three.js makes no renderer there."""
    script = HAND.replace("const seen = {", "const seen = { pane: pane.innerText,")
    drawn = browsed(text, script, tmp_path, "1200,800")
    (tmp_path / "without").mkdir()
    bare = browsed(text, script, tmp_path / "without", "1200,800", "--disable-3d-apis")
    assert "WebGL is off" in bare.pop("pane")
    assert "WebGL" not in drawn.pop("pane")
    assert bare == drawn


def test_curves_are_those_of_the_trajectory():
    gait = sample_gait()
    found = curves(gait)
    time = np.array(found["time"])
    assert len(time) >= 301
    assert np.all(np.diff(time) >= 0.0)
    assert found["period"] == pytest.approx(2.0 * gait.duration)
    first = time <= gait.duration
    for tab, stored in (("torque", gait.torque), ("angle", gait.q), ("speed", gait.dq)):
        (panels,) = [t["panels"] for t in found["tabs"] if t["name"] == tab]
        for line in [line for panel in panels for line in panel["lines"]]:
            own = stored[:, gait.joint_names.index(line["name"])]
            near = np.interp(gait.time[1:-1], time[first][:-1], np.array(line["y"])[first][:-1])
            assert near == pytest.approx(own[1:-1], abs=0.02 * np.abs(stored).max())


def test_a_page_of_meshes_is_small():
    robot = robot_by_name("g1")
    problem = WalkProblem(robot, preset_task("humanoid", robot, speed=0.6))
    text = page_text(gait_at(problem, first_guess(problem), {}))
    shapes = [c for c in scene_of(text) if c["type"] == "set_object" and "link" in c["path"]]
    assert len(shapes) > 20
    assert 1e6 < len(text) < 5e6


@pytest.mark.parametrize("name", ["five and arms", "seven, torso first"])
def test_robots_of_other_joints_are_drawn(name, tmp_path):
    robot = synthetic(name)
    problem = WalkProblem(robot, preset_task(boundary="lifted", speed=0.5, duration=0.5))
    gait = gait_at(problem, first_guess(problem), {})
    assert gait.text("robot") in page_text(gait, steps=2)
    sizes = [imread(path).shape[:2] for path in write_figures(gait, tmp_path)]
    assert sizes[list(FIGURES).index("torques")][0] == 150 * 2.5 * (3 if "five" in name else 4)


# what a person without a mouse does: the tab key stops at buttons, which the space bar presses
KEYS = """
setPlaying(false);
const key = (name, target, more) => target.dispatchEvent(
  new KeyboardEvent("keydown", { key: name, bubbles: true, cancelable: true, ...more }));
const tab = document.querySelectorAll("#tabs button")[2];
tab.focus();
tab.click();  // as the browser does where the space bar is pressed on it
const seen = { pressed: key(" ", tab), playing: animator.playing,
               kept: document.activeElement === tab,
               pressed_tabs: [...document.querySelectorAll("#tabs button")].map(
                 b => b.getAttribute("aria-pressed")) };
const line = document.querySelector("figcaption");
seen.heights = [];
for (const t of [0, 0.13, 0.27]) {
  seek(t);
  seen.heights.push(line.getBoundingClientRect().height);
}
scrub.focus();
seen.taken = key("ArrowLeft", scrub);
seen.thumb = [Number(scrub.value), animator.time, scrub.getAttribute("aria-valuetext")];
seen.back = key("ArrowLeft", document.body, { altKey: true });
seen.same = animator.time;
const summary = document.createElement("summary");
document.body.append(summary);
seen.folds = key(" ", summary);
seen.named = [...document.querySelectorAll("figure, canvas, svg")].every(
  part => part.getAttribute("aria-label"));
tab.focus();
tab.dispatchEvent(new MouseEvent("click", { detail: 1 }));
seen.released = document.activeElement !== tab;
key(" ", document.body);
seen.plays = animator.playing;
document.title = JSON.stringify(seen);
"""


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium browser found")
def test_the_keyboard_reaches_everything(text, tmp_path):
    seen = browsed(text, KEYS, tmp_path, "1000,700")
    assert seen["pressed"] is True  # the button's own doing is not prevented
    assert seen["playing"] is False
    assert seen["kept"] is True
    assert seen["pressed_tabs"] == ["false", "false", "true", "false", "false", "false"]
    assert seen["taken"] is False
    assert seen["thumb"][0] == pytest.approx(seen["thumb"][1])
    assert seen["thumb"][1] < 0.27
    assert seen["thumb"][2] == f"step 1, t = {seen['thumb'][1]:.3f} s"
    assert seen["back"] is True  # to the page before
    assert seen["same"] == seen["thumb"][1]
    assert seen["folds"] is True
    assert seen["named"] is True
    assert len(set(seen["heights"])) == 1  # numbers that change move nothing
    assert seen["released"] is True
    assert seen["plays"] is True


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium browser found")
def test_paper_gets_all_of_the_page_and_fingers_scroll_it(text, tmp_path):
    asyncio.run(_paper_and_fingers(write_page(sample_gait(), tmp_path / "gait.html"), tmp_path))


async def _paper_and_fingers(page, folder):
    async with opened(f"{page.as_uri()}#t=0.1&paused", folder) as one:
        size = {"width": 360, "height": 640, "deviceScaleFactor": 1, "mobile": True}
        await one.call("Emulation.setDeviceMetricsOverride", **size)
        await one.call("Emulation.setTouchEmulationEnabled", enabled=True)
        await one.wait_for("document.querySelectorAll('.foot span').length > 0")
        await one.value("document.querySelector('.panel').scrollIntoView({ block: 'center' })")
        box = await one.value(
            "(b => [b.left + b.width / 2, b.top + b.height / 2])"
            "(document.querySelector('.panel svg').getBoundingClientRect())"
        )
        state = "[scrollY, Number(document.getElementById('scrub').value)]"

        async def swipe(x, y):
            touch = {"x": box[0], "y": box[1]}
            before = await one.value(state)
            await one.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[touch])
            for share in np.linspace(0.1, 1.0, 10):
                point = {"x": box[0] + share * x, "y": box[1] + share * y}
                await one.call("Input.dispatchTouchEvent", type="touchMove", touchPoints=[point])
            await one.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
            return np.subtract(await one.value(state), before)

        scrolled, moved = await swipe(80.0, 0.0)
        assert scrolled == 0.0
        assert moved > 0.1
        scrolled, moved = await swipe(0.0, -100.0)
        assert scrolled > 50.0
        assert moved == 0.0
        await one.call("Emulation.setEmulatedMedia", media="print")
        hidden, whole, *wide = await one.value(
            "[getComputedStyle(document.getElementById('play')).display,"
            " document.body.scrollHeight - document.getElementById('report').scrollHeight,"
            " document.querySelector('canvas').offsetWidth,"
            " document.getElementById('pane').offsetWidth]"
        )
        assert hidden == "none"
        assert whole > 0.0
        assert wide[0] == pytest.approx(0.7 * wide[1], abs=1.0)


def test_huge_numbers_have_four_digits_on_a_page():
    huge = replace(sample_gait(), meta={**sample_gait().meta, "mass": 3e15})
    told = dict(facts(huge))
    assert told["mass"] == "3e+15 kg"
    assert told["step"].endswith(f" in {sample_gait().duration:.3f} s")
