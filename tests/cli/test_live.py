"""`gaitopt live`: sliders are answered with walks, refusals with what would walk."""

import asyncio
import functools
import json
import re
import signal
import subprocess
import sys
import threading
import urllib.request
from pathlib import Path
from types import SimpleNamespace

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "view"))

from browser import BROWSER, close, opened
from page_scene import commands_of, data_of, numbers, places, scene_of, unpacked
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect
from typer.testing import CliRunner

from gaitopt.cli import live
from gaitopt.cli.app import app
from gaitopt.cli.live import FOLLOWS, LiveWalk, _sliders
from gaitopt.design.pipeline import is_walk
from gaitopt.design.replanner import Plan
from gaitopt.errors import EvaluationError
from gaitopt.gait.gait_file import load_gait
from gaitopt.gait.presets import preset_task
from gaitopt.view.live_server import serve


def never():
    return False


@pytest.mark.parametrize("speed", [-0.4, 0.0, 0.8])
def test_every_slider_goes_from_less_to_more_around_its_value(robot, speed):
    task = preset_task("humanoid", robot, speed=speed)
    sliders = [*_sliders(SimpleNamespace(robot=robot, task=task))]
    assert ("speed" in {one.name for one in sliders}) == (speed != 0.0)
    assert len(sliders) > 5
    for one in sliders:
        assert one.low <= one.value <= one.high, one
        assert one.low < one.high, one


@pytest.mark.parametrize("ground", [{"stairs": 0.1}, {"turn_rate": 0.2}])
def test_no_slider_slopes_what_has_one_ground(robot, ground):
    """Stairs and turns refuse every slope but none."""
    task = preset_task("standard", robot, speed=0.8, **ground)
    names = {one.name for one in _sliders(SimpleNamespace(robot=robot, task=task))}
    assert "friction" in names
    assert "slope" not in names


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """Let no answer depend on how busy the machine is."""
    monkeypatch.setattr(live, "PATIENCE", 1e9)
    monkeypatch.setattr(live, "SEARCH", 1e9)


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    return LiveWalk({"speed": 0.8}, None, tmp_path_factory.mktemp("kept"))


@pytest.fixture
def settings(session):
    return {one.name: one.value for one in session.sliders}


def last(messages):
    *_, message = messages
    return message


def test_a_slider_is_answered_with_a_walk_and_then_its_certificate(session, settings):
    told = list(session.answers({**settings, "speed": 0.8215}, never))
    assert [one["kind"] for one in told] == ["walk", "motion", "walk", "motion"]
    assert all(set(one["words"]) <= places(session.page()) for one in told)
    first, proof = told[::2]
    assert first["words"]["verdict"] == FOLLOWS
    assert proof["words"]["verdict"] == "certified"
    for message in (first, proof):
        assert "0.8215 m/s" in message["words"]["title"]
        assert message["text"].endswith("gaitopt optimise --preset standard --speed 0.8215")
        assert len(message["curves"]["tabs"]) == 6


def test_every_slider_moves_what_it_says(session, settings):
    for slider in session.sliders:
        value = slider.value + 3.0 * slider.step * (-1.0 if slider.value >= slider.high else 1.0)
        next(session.answers({**settings, slider.name: value}, never))
        problem, task = session._planner.last.problem, session._planner.last.problem.task
        if slider.name == "load":
            assert problem.robot.mass == pytest.approx(session._request.robot.mass + value)
            continue
        found = (
            getattr(task, slider.name) if hasattr(task, slider.name) else task.margin(slider.name)
        )
        assert found == pytest.approx(value)
        assert is_walk(session._planner.last.solution)
    last(session.answers(settings, never))


def test_a_slider_that_rests_keeps_its_value_where_the_default_follows_another(tmp_path):
    """The preset humanoid takes shorter steps in time the faster it walks."""
    session = LiveWalk({"preset": "humanoid", "speed": 0.6}, None, tmp_path)
    settings = {one.name: one.value for one in session.sliders}
    first = next(session.answers({**settings, "speed": 0.75}, never))
    walk = session._planner.last.gait()
    assert walk.speed == pytest.approx(0.75, abs=1e-6)
    assert walk.duration == pytest.approx(settings["duration"], abs=1e-12)
    assert first["curves"]["period"] == pytest.approx(2.0 * settings["duration"], abs=1e-12)
    assert f"--duration {settings['duration']:g}" in first["text"]


def test_settings_without_a_walk_say_what_stops_them_and_where_it_walks(session, settings):
    last(session.answers(settings, never))
    told = list(session.answers({**settings, "torque_limit": 15.0}, never))
    assert [one["kind"] for one in told] == ["none", "none"]
    assert told[0]["text"].startswith("no walk: ")
    could = float(re.search(r"torque limit can be (\S+) N·m", told[1]["text"])[1])
    assert 15.0 < could <= 150.0
    assert last(session.answers({**settings, "torque_limit": could}, never))["kind"] == "motion"


def test_after_a_refusal_page_and_kept_walk_are_those_of_the_last_certificate(session, settings):
    *_, shown, _ = session.answers({**settings, "speed": 0.81}, never)
    assert last(session.answers({**settings, "speed": 0.81, "torque_limit": 15.0}, never))["text"]
    assert "gaitopt optimise --preset standard --speed 0.81 --start " in session.save()["text"]
    page = session.page()
    inputs = dict(re.findall(r'name="(\w+)".*? value="(.*?)"', page))
    assert float(inputs["speed"]) == 0.81
    assert float(inputs["torque_limit"]) == 150.0
    assert shown["words"]["title"] in page
    assert f'id="verdict">{shown["words"]["verdict"]}<' in page


def test_what_moves_is_what_a_new_page_would_show(session, settings):
    session.page()
    *_, moved = session.answers({**settings, "speed": 0.83}, never)
    assert moved["kind"] == "motion"
    page = session.page()
    shown, found = data_of(page)["motion"], moved["motion"]
    assert [len(own) for own in found["tracks"]] == [len(own) for own in shown["tracks"]]
    for own, known in zip(found["tracks"], shown["tracks"], strict=True):
        for values, wanted in zip(own, known, strict=True):
            assert values.ravel() == pytest.approx(numbers(wanted), abs=1e-6)
    assert found["times"] == pytest.approx(numbers(shown["times"]), abs=1e-6)
    placed = {c["path"]: c["matrix"] for c in scene_of(page) if c["type"] == "set_transform"}
    sent = commands_of(unpacked(moved["commands"]))
    assert {c["type"] for c in sent} == {"set_transform"}  # nothing is built again
    for command in sent:
        assert command["matrix"] == pytest.approx(placed[command["path"]])


def test_a_search_that_takes_too_long_says_so(session, settings, monkeypatch):
    last(session.answers(settings, never))
    monkeypatch.setattr(live, "SEARCH", 0.0)
    told = list(session.answers({**settings, "torque_limit": 15.0}, never))
    assert {one["kind"] for one in told} == {"none"}
    assert all(one["text"].startswith("no walk found within 0 s: ") for one in told)


def test_a_search_that_newer_settings_end_says_nothing(session, settings, monkeypatch):
    last(session.answers(settings, never))
    monkeypatch.setattr(live, "PATIENCE", 0.0)
    assert list(session.answers({**settings, "torque_limit": 15.0}, lambda: True)) == []


def test_newer_settings_end_what_is_of_no_use(session, settings):
    wanted = session.answers({**settings, "speed": 0.84}, lambda: True)
    first, picture = wanted  # the walk, and no certificate
    assert first["words"]["verdict"] == FOLLOWS
    assert picture["kind"] == "motion"


def test_a_walk_that_cannot_be_certified_says_so(session, settings, monkeypatch):
    def undefined(*words):
        raise EvaluationError("the legs are <stretched> at 0.1 s")

    monkeypatch.setattr(Plan, "complete", undefined)
    *_, told = session.answers({**settings, "speed": 0.85}, never)
    assert told == {
        "kind": "proof",
        "words": {
            "verdict": '<span class="doubt">optimal at the samples, no certificate: the legs are '
            "&lt;stretched&gt; at 0.1 s</span>"
        },
    }
    monkeypatch.undo()
    assert last(session.answers(settings, never))["kind"] == "motion"


class Broken:
    """A session with a fault of its own."""

    sliders = ()

    def page(self):
        return "<p>page</p>"

    def answers(self, settings, stop):
        raise ZeroDivisionError("a fault")
        yield {}

    def save(self):
        return {}


def test_a_fault_ends_the_server_and_is_told():
    """The page would else wait for ever."""
    pages, heard = [], []

    def ready(url):
        async def ask():
            socket = await websocket_connect(f"{url.replace('http', 'ws')}socket")
            await socket.write_message(json.dumps({"number": 1, "settings": {}}))
            heard.append(await socket.read_message())
            socket.close()

        pages.append(threading.Thread(target=lambda: asyncio.run(ask()), daemon=True))
        pages[0].start()

    with pytest.raises(ZeroDivisionError, match="a fault"):
        serve(Broken(), port=0, on_ready=ready, stay=True)
    pages[0].join(60.0)
    assert heard == [None]  # the line was closed


def test_a_kept_walk_is_the_certified_one(session, settings):
    *_, shown, _ = session.answers({**settings, "clearance": 0.04}, never)
    told = session.save()
    folder = re.search(r"kept in (\S+);", told["text"])[1]
    gait = load_gait(f"{folder}/gait.npz")
    assert gait.fact("certificate", "certified") is True
    assert f"{gait.cost:.6g}" in shown["words"]["facts"]
    assert "--clearance 0.04" in told["text"]
    before = json.loads((Path(folder) / "summary.json").read_text())["walk"]["cost"]
    assert before == pytest.approx(gait.cost)


def test_the_command_of_a_kept_walk_makes_it_again(session, settings, tmp_path):
    """The walk that follows a slider is not always the one that a search finds first."""
    last(session.answers({**settings, "speed": 0.86}, never))
    words = session.save()["text"].split("; again: gaitopt ")[1].split()
    (again,) = session.save()["text"].split()[2].split(";")[:1]
    assert words[-1] != f"{again}/gait.npz"  # a folder of its own each time
    assert CliRunner().invoke(app, [*words, "--output", str(tmp_path)]).exit_code == 0
    found, kept = load_gait(tmp_path / "gait.npz"), load_gait(words[-1])
    assert found.cost == pytest.approx(kept.cost, rel=1e-9)
    assert found.parameters == pytest.approx(kept.parameters, abs=1e-7)


def test_a_slider_begins_at_its_setting_and_moves_in_round_steps(tmp_path):
    """Browsers move a slider to the nearest of its steps from its least value."""
    session = LiveWalk({"speed": 0.755, "slope": 0.0996687, "starts": 1}, None, tmp_path)
    for one in session.sliders:
        if one.name == "torque_limit":
            continue
        assert one.low <= one.value <= one.high
        assert one.low / one.step == pytest.approx(round(one.low / one.step), abs=1e-9)
    form = dict(re.findall(r'name="(\w+)".*?data-value="(.*?)"', session.page()))
    assert {n: float(v) for n, v in form.items()} == {o.name: o.value for o in session.sliders}


@pytest.fixture
def served(tmp_path):
    command = [sys.executable, "-m", "gaitopt", "live", "--port", "0", "--starts", "1", "-o", "k"]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=tmp_path
    )
    try:
        line = process.stdout.readline()
        yield process, re.search(r"http://127\.0\.0\.1:\d+/", line)[0]
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


async def _nonsense(url):
    """Send what is no wish, then a wish; return the first answer to it."""
    socket = await websocket_connect(f"{url.replace('http', 'ws')}socket")
    for text in ("", "{", "[1]", "7", '{"settings": 3}', '{"settings": {"speed": "fast"}}',
                 '{"settings": {"speed": 1e400, "load": true}}', "[" * 5000):  # fmt: skip
        await socket.write_message(text)
    await socket.write_message(json.dumps({"number": 9, "settings": {"speed": 1.01}}))
    while True:
        answer = json.loads(await asyncio.wait_for(socket.read_message(), 300.0))
        if answer.get("number") == 9:
            await close(socket)
            return answer


async def _of_another_site(url):
    address = f"{url.replace('http', 'ws')}socket"
    await websocket_connect(HTTPRequest(address, headers={"Origin": "http://example.org"}))


async def _under_another_name(url):
    """As a page does whose site lets its own name mean this machine."""
    names = {"Host": "example.org", "Origin": "http://example.org"}
    await websocket_connect(HTTPRequest(f"{url.replace('http', 'ws')}socket", headers=names))


def test_nonsense_is_passed_over_other_sites_are_refused_and_a_signal_ends_it(served):
    process, url = served
    answer = asyncio.run(_nonsense(url))
    assert answer["kind"] == "walk"
    assert "1.01 m/s" in answer["words"]["title"]
    with pytest.raises(HTTPClientError, match="403"):
        asyncio.run(_of_another_site(url))
    with pytest.raises(HTTPClientError, match="404"):
        asyncio.run(_under_another_name(url))
    process.send_signal(signal.SIGINT)
    assert process.wait(300) == 0


def test_a_browser_that_asks_for_an_icon_is_told_that_there_is_none(served):
    """What is not found stands as an error in its console."""
    _, url = served
    with urllib.request.urlopen(f"{url}favicon.ico", timeout=300) as answer:
        assert (answer.status, answer.read()) == (204, b"")


MOVE = """(() => {{
  const input = document.querySelector('#sliders input[name={name}]');
  input.value = {value}; input.oninput();
}})()"""


PLACES = """(() => {
  gaitoptLive.seek(0.13);
  const found = [], { scene } = gaitoptLive.viewer;
  scene.updateMatrixWorld(true);
  scene.traverse(part => { if (part.geometry) found.push(...part.matrixWorld.elements); });
  return found;
})()"""
FRAME = "document.querySelector('iframe').contentWindow"
OTHER = """document.body.append(Object.assign(document.createElement('iframe'),
  { src: location.href, width: 400, height: 400 }))"""
SPEED = "document.querySelector('#sliders input[name=speed]').value"
READY = "!!window.gaitoptLive && document.querySelectorAll('.foot span').length"


async def _driven(url, folder):
    async with opened(url, folder) as page:
        await page.wait_for(READY)
        seen = []
        for number, value in enumerate((1.02, 1.04, 0.97), 1):
            await page.value(MOVE.format(name="speed", value=value))
            await page.wait_for(f"gaitoptLive.seen >= {number}")
            seen.append(await page.value("document.getElementById('title').textContent"))
        await page.wait_for("document.getElementById('verdict').textContent === 'certified'")
        seen.append(await page.value("document.getElementById('title').textContent"))
        await page.value("document.getElementById('save').click()")
        seen.append(
            await page.wait_for(
                "(t => t.startsWith('kept') && t)(document.getElementById('told').textContent)"
            )
        )
        await page.value(OTHER)
        await page.wait_for(f"{FRAME}.gaitoptLive && {FRAME}.gaitoptLive.number === 0")
        await page.wait_for(f"{FRAME}.document.querySelectorAll('.foot span').length")
        await page.value(f"{FRAME}.eval({json.dumps(MOVE.format(name='speed', value=0.99))})")
        await page.wait_for(f"{SPEED} === '0.99' && /0.99 m/.test(document.title)")
        await page.wait_for("document.getElementById('verdict').textContent === 'certified'")
        await page.wait_for("!document.body.classList.contains('behind')")
        moved = await page.value(PLACES)
        await page.value("(window.old = true, location.reload())")
        await page.wait_for(f"!window.old && {READY}")
        return seen, moved, await page.value(PLACES)


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium browser found")
def test_a_browser_moves_the_slider_and_closing_it_ends_everything(served, tmp_path):
    process, url = served
    seen, moved, new = asyncio.run(_driven(url, tmp_path))
    assert [title.split(" at ")[1] for title in seen[:4]] == [
        "1.02 m/s", "1.04 m/s", "0.97 m/s", "0.97 m/s",
    ]  # fmt: skip
    assert (tmp_path / "k" / "walk-1" / "gait.npz").exists()
    assert len(moved) > 1000
    assert moved == pytest.approx(new, abs=1e-5)  # of 32-bit numbers
    assert process.wait(300) == 0


VERDICT = "document.getElementById('verdict').textContent"
TOLD = "document.getElementById('told').textContent"
LIMIT = "document.querySelector('#sliders input[name=torque_limit]').dataset.value"


async def _refused_and_ended(url, folder, end):
    async with opened(url, folder) as page:
        await page.wait_for(READY)
        certified = await page.value(VERDICT)
        await page.value(MOVE.format(name="torque_limit", value=15))
        await page.wait_for(f"{VERDICT} !== {json.dumps(certified)}")
        await page.wait_for(f"{TOLD}.includes('torque limit can be')")
        seen = [certified, await page.value(VERDICT)]
        await page.value("document.getElementById('save').click()")
        await page.wait_for(f"{TOLD}.startsWith('kept')")
        await page.value(MOVE.format(name="torque_limit", value=16.5))
        await page.wait_for(f"{TOLD}.includes('torque limit can be')")
        seen.append(await page.value(VERDICT))
        end()
        await page.wait_for(f"{TOLD}.startsWith('gaitopt has ended')")
        return [*seen, await page.value(VERDICT), await page.value(LIMIT)]


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium browser found")
def test_after_a_refusal_and_at_the_end_the_verdict_is_that_of_the_walk_shown(served, tmp_path):
    process, url = served
    end = functools.partial(process.send_signal, signal.SIGINT)
    first, refused, again, ended, limit = asyncio.run(_refused_and_ended(url, tmp_path, end))
    assert first == ended == "certified"
    assert refused == again == "the walk before these settings: certified"
    assert float(limit) == 150.0  # the slider is where the walk is
    assert process.wait(300) == 0
