"""Robots of MuJoCo Menagerie: asked for by name, fetched by its package, or refused in words."""

import shutil
import sys
from dataclasses import dataclass
from types import ModuleType

import pytest
from places import CASES
from typer.testing import CliRunner

from gaitopt.catalogue.entries import entry_by_name, robot_by_name
from gaitopt.cli.app import app
from gaitopt.errors import InputError, MissingExtraError

CASE = CASES / "base_mini.xml"


@dataclass
class Point:
    name: str
    file: str


class FakeRobot:
    """What the package has of a robot; `folder` is None where it cannot be fetched."""

    display_name, default_model = "Mini", "mini"
    entry_points = (Point("scene", "scene.xml"), Point("mini", "mini.xml"))

    def __init__(self, name, folder):
        self.name, self.folder = name, folder

    def path(self, cache=None, progress=None):
        if self.folder is None:
            raise sys.modules["mujoco_menagerie"].MenagerieError("https://host/x: no route.")
        return self.folder


@pytest.fixture
def package(monkeypatch, tmp_path):
    folder = tmp_path / "mini"
    folder.mkdir()
    shutil.copy(CASE, folder / "mini.xml")
    robots = {"mini": FakeRobot("mini", folder), "far": FakeRobot("far", None)}
    fake = ModuleType("mujoco_menagerie")
    fake.MenagerieError = type("MenagerieError", (Exception,), {})
    fake.names = lambda: list(robots)
    fake.robots = lambda category=None: list(robots.values())
    fake.get = robots.__getitem__
    monkeypatch.setitem(sys.modules, "mujoco_menagerie", fake)


@pytest.mark.usefixtures("package")
def test_a_robot_is_fetched_and_read():
    entry = entry_by_name("menagerie:mini")
    assert (entry.title, entry.file, entry.package) == ("Mini", "mini/mini.xml", "mujoco-menagerie")
    assert robot_by_name("menagerie:mini").mass == pytest.approx(42.6)
    shown = CliRunner().invoke(app, ["inspect", "--robot", "menagerie:mini"])
    assert shown.exit_code == 0
    assert "mini/mini.xml of mujoco-menagerie" in " ".join(shown.stdout.split())
    assert "--robot menagerie:NAME, as mini, far" in CliRunner().invoke(app, ["robots"]).stdout


@pytest.mark.usefixtures("package")
@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("menagerie:minni", "no robot 'minni'; did you mean 'menagerie:mini'. its humanoids are"),
        (
            "menagerie:mini/left",
            "'mini' of mujoco-menagerie has no file 'left'; it has scene, mini",
        ),
        ("menagerie:far", "cannot fetch 'far': https://host/x: no route; check the connection, or"),
    ],
)
def test_what_cannot_be_had_is_refused(name, message):
    with pytest.raises(InputError, match=message):
        robot_by_name(name)


def test_the_package_is_named_where_it_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco_menagerie", None)
    with pytest.raises(MissingExtraError, match=r"'menagerie:mini'.*gaitopt\[menagerie\]"):
        entry_by_name("menagerie:mini")
    assert "menagerie:" not in CliRunner().invoke(app, ["robots"]).stdout


def test_mujoco_is_named_where_it_is_missing(monkeypatch):
    from gaitopt.importers.reader import read_source

    text = read_source(CASE).text
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingExtraError, match=r"an MJCF file needs .*gaitopt\[mujoco\]"):
        read_source(CASE)
    assert read_source(text).model().nv == 18  # the normal form needs no MuJoCo
    result = CliRunner().invoke(app, ["inspect", "--urdf", str(CASE)])
    assert result.exit_code == 2
    assert "pip install 'gaitopt[mujoco]'" in " ".join(result.stderr.split())
