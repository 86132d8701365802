"""`gaitopt size`: motors.toml and gaits that go together, refusals."""

import re
import shlex

import numpy as np
from places import ROOT

from gaitopt.actuators.motors import read_motors
from gaitopt.gait.gait_file import load_gait

CATALOGUE = ROOT / "examples" / "catalogue.toml"


def test_motors_and_gaits_are_written(cli, gait_file, tmp_path):
    out = tmp_path / "sized"
    result = cli("size", gait_file, "--catalogue", CATALOGUE, "-o", out)
    assert result.exit_code == 0, result.stderr
    table = read_motors(out / "motors.toml")
    gait = load_gait(out / "1.npz")
    assert {drive.joints for drive in table.drives} == set(gait.joint_names)
    assert gait.fact("certificate", "certified") is True
    knee = next(line.split() for line in result.stdout.splitlines() if line.startswith("knee"))
    drive = table.drive("left_knee")
    assert knee[1:3] == [drive.motor.name, f"{drive.ratio:.4g}"]
    used = cli("requirements", out / "1.npz", "--motors", out / "motors.toml")
    assert used.exit_code == 0, used.stderr
    assert "Before the gear" in used.stdout
    assert cli("size", gait_file, "--catalogue", CATALOGUE, "-o", out).exit_code == 0  # its own


def test_the_question_of_the_page_has_the_answer_of_the_page(cli, tmp_path, monkeypatch):
    page = (
        (ROOT / "docs" / "motors.md").read_text("utf-8").partition("## Which motors and gears")[2]
    )
    rows = re.findall(r"^\| ([a-z ]+) \| (\w+) \| (\d+) \| (.*) W \|$", page, re.M)
    assert len(rows) == 6
    (tmp_path / "examples").mkdir()
    (tmp_path / "examples" / "catalogue.toml").write_bytes(CATALOGUE.read_bytes())
    monkeypatch.chdir(tmp_path)
    commands = page.partition("```console\n")[2].partition("```")[0].splitlines()
    assert len(commands) == 3
    for line in commands:
        result = cli(*shlex.split(line.removeprefix("$ gaitopt ")))
        assert result.exit_code == 0, result.stderr
    found = {line[:20].strip(): line[20:].split() for line in result.stdout.splitlines()}
    for joints, motor, ratio, shares in rows:
        assert found[joints][:2] == [motor, ratio]
        told = [float(word) for word in shares.replace("%", "").replace("|", "").split()]
        np.testing.assert_allclose([float(word) for word in found[joints][2:]], told, atol=3.0)
    assert result.stdout.count(", certified") == 2


def test_what_cannot_be_is_refused(cli, gait_file, tmp_path):
    out = tmp_path / "none"
    bad = tmp_path / "bad.toml"
    bad.write_text("[motors.one]\nmass = 1.0\n")
    for words, told in (
        (("--catalogue", tmp_path / "no.toml"), "no.toml"),
        (("--catalogue", bad), "are missing"),
        (("--catalogue", CATALOGUE, "--reserve", "0.5"), "give 1"),
        (("--catalogue", CATALOGUE, "--reserve", "9"), "no motor of the catalogue"),
        (("--catalogue", CATALOGUE, "--aim", "price"), "price"),
    ):
        result = cli("size", gait_file, *words, "-o", out)
        assert result.exit_code == 2, words
        assert told in " ".join(result.stderr.split()), words
        assert not out.exists()
