"""The pictures of docs/your-robot.md: there, small, and of the version they claim."""

import json
import re

import pytest
from places import DOCS

import gaitopt
from gaitopt.cli.request import make_request
from gaitopt.design.starts import many_starts


def test_links_of_the_page_about_robots_exist():
    targets = re.findall(r"\]\(([^)#]+)\)", (DOCS / "your-robot.md").read_text())
    assert "images/g1_walk.png" in targets
    assert [t for t in targets if not (DOCS / t).exists()] == []


def test_pictures_are_of_the_walk_in_the_text():
    record = json.loads((DOCS / "images" / "g1.json").read_text())
    assert record["gaitopt"] == gaitopt.__version__
    speed = re.search(r"optimise --robot g1 --speed (\S+)", (DOCS / "your-robot.md").read_text())
    assert record["speed_m_per_s"] == pytest.approx(float(speed[1]))
    request = make_request({"robot": "g1", "speed": float(speed[1])}, None)
    found = many_starts(request.robot, request.task, request.options).design.gait
    assert record["cost_N2ms"] == pytest.approx(found.cost, rel=1e-5)
    for picture in ("g1_walk.png", "g1_inspect.png"):
        assert 20_000 < (DOCS / "images" / picture).stat().st_size < 300_000
