"""Names that would steer a terminal, be markup or mathematics, or forge a line."""

import os
import pty
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from places import CASES, ROOT

from gaitopt import load_gait, save_gait
from gaitopt.cli.display import screen, warn
from gaitopt.cli.process import print_advice, print_error

CSI = "\x9b"  # begins a command to a terminal, as ESC [ does; XML allows it
KNEE = f"knee[/red] {CSI}31m$\\frac{{$ :smile: <b>@TITLE@"
ROLL = "hip_roll[bold] \u202e&#10;error: forged"
ROBOT = f"mini[/] {CSI}2J&#10;error: forged <script>alert(1)</script> @DATA@ $\\frac{{"
QUICK = ("--solver", "sqp", "--starts", "1", "--samples", "15", "--no-refine")
UNSEEN = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2028\u2029]")


def attribute(text: str) -> str:
    return text.replace("<", "&lt;")


@pytest.fixture(scope="module")
def hostile(tmp_path_factory) -> Path:
    text = (CASES / "base_mini.urdf").read_text()
    for side in ("left", "right"):
        text = text.replace(f'"{side}_knee"', f'"{side}_{attribute(KNEE)}"')
        text = text.replace(f'"{side}_hip_roll"', f'"{side}_{ROLL}"')
    path = tmp_path_factory.mktemp("robot") / "odd[bold]\x1b[31m.urdf"
    path.write_text(text.replace('name="mini"', f'name="{attribute(ROBOT)}"'))
    return path


def assert_plain(*texts: str) -> None:
    for text in texts:
        assert not UNSEEN.search(text)
        assert not re.search("^error: forged", text, re.MULTILINE)


@pytest.fixture(scope="module")
def walk(hostile, quick, tmp_path_factory) -> Path:
    directory = tmp_path_factory.mktemp("walk")
    said = quick("--urdf", hostile, "--speed", "0.5", "-o", directory)
    assert said.exit_code == 0, said.stderr
    assert_plain(said.stdout, said.stderr)
    assert r"mini[/] \x9b2J\nerror: forged <script>" in said.stdout
    assert "[/red]" in said.stdout or "[ red]" in said.stdout  # the name both joints share
    assert ":smile:" in said.stdout
    return directory


def test_every_command_shows_names_as_they_are(cli, hostile, walk, tmp_path):
    gait = walk / "gait.npz"
    for words, code in (
        (("inspect", "--urdf", hostile, "--html", tmp_path / "robot.html"), 0),
        (("inspect", "--urdf", hostile.with_name("\x1b[2Jgone.urdf")), 2),
        (("check", gait), None),
        (("plot", gait, "-o", tmp_path / "figures"), 0),
        (("play", gait, "--html", tmp_path / "walk.html"), 0),
        (("export", gait, "-o", tmp_path / "walk.csv"), 0),
        (("optimise", "--urdf", hostile, "--speed", "9", *QUICK), 3),
        (("sweep", "--urdf", hostile, "--grid", "speed=0.5", "-o", "/dev/null/\x1b[2J"), 2),
    ):
        said = cli(*words)
        assert code is None or said.exit_code == code, said.stderr
        assert_plain(said.stdout, said.stderr)
    for page in (tmp_path / "robot.html", tmp_path / "walk.html"):
        assert "<script>alert" not in page.read_text()


def test_names_in_a_gait_file_steer_nothing_either(cli, gait_file):
    gait = load_gait(gait_file)
    findings = [
        {"topic": "a\x1b[1m", "subject": "b\x07", "how": how, "text": "c\nerror: forged"}
        for how in ("warning", "guessed")
    ]
    forged = {"robot": "\x1b[2J\nerror: forged", "findings": findings}
    save_gait(replace(gait, meta={**gait.meta, **forged}), gait_file)
    said = cli("check", gait_file)
    assert_plain(said.stdout, said.stderr)


def test_what_is_printed_by_itself_is_plain(capsys):
    print_error("a\x1b[31m\nerror: forged")
    print_advice(["- b\u2028c\x07"])
    warn(screen(stderr=True), "warning", "[/x] \x9b\nerror: forged")
    screen().print("[/red] :smile: \x1b[2J\nerror: forged")
    found = capsys.readouterr()
    assert_plain(found.out, found.err)
    assert r"error: a\x1b[31m\nerror: forged" in found.err
    assert r"- b\u2028c\x07" in found.err
    assert r"warning: [/x] \x9b\nerror: forged" in found.err
    assert r"[/red] :smile: \x1b[2J" in found.out


@pytest.mark.skipif(os.name != "posix", reason="a pseudo-terminal is POSIX")
def test_on_a_terminal_only_gaitopt_steers(hostile):
    shown, terminal = pty.openpty()
    words = [sys.executable, "-m", "gaitopt", "inspect", "--urdf", str(hostile)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "TERM": "xterm", "COLUMNS": "150"}
    with subprocess.Popen(words, stdout=terminal, stderr=terminal, env=environment):
        os.close(terminal)
        text = b""
        while True:
            try:
                more = os.read(shown, 65536)
            except OSError:  # the other end is closed
                break
            text += more
    os.close(shown)
    plain = re.sub(r"\x1b\[[0-9;]*m|\r", "", text.decode())  # colours are gaitopt's own
    assert r"\x9b" in plain
    assert_plain(plain)
