"""docs/reproduction.md is what the command writes today."""

import json
import re
from importlib import resources

import pytest
from places import DOCS

from gaitopt.importers.text_files import parse_toml
from reproduction.figures import REPRODUCTION_FIGURES
from reproduction.identification import UNKNOWNS, identified_values
from reproduction.page import IMAGES
from reproduction.paper import printed
from reproduction.tables import printed_table


@pytest.fixture(scope="module")
def page():
    return (DOCS / "reproduction.md").read_text("utf-8")


def test_its_words_are_those_of_the_template(page):
    words = (resources.files("reproduction") / "page.toml").read_text("utf-8")
    pieces = re.split(r"\$\w+", parse_toml(words, "the words")["page"])
    assert len(pieces) > 20
    at = 0
    for piece in pieces:
        at = page.index(piece, at) + len(piece)
    assert printed_table() in page


def test_its_command_gives_its_costs(page):
    """They are those at the samples; refined, the walk costs more."""
    assert "gaitopt optimise --robot paper --speed 0.7 --no-refine" in page


def test_its_figures_are_there(page):
    files = {path.stem for path in (DOCS / IMAGES).glob("*.png")}
    assert files == set(REPRODUCTION_FIGURES)
    assert all(f"{IMAGES}/{name}.png" in page for name in files)


def test_its_numbers_are_of_the_shipped_biped():
    record = json.loads((DOCS / "reproduction.json").read_text("utf-8"))
    values = dict(zip((u.name for u in UNKNOWNS), identified_values(), strict=True))
    assert record["unknowns"] == pytest.approx(values)
    assert [w["speed"] for w in record["walks"]][:8] == list(printed().speeds)
    assert max(map(abs, record["errors"])) < 0.05
