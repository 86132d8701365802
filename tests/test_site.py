"""The documentation site: built from the docs and docstrings, with every warning an error."""

import os
import re
import subprocess
import sys

import pytest
from places import ROOT

import gaitopt


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    built = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "-d", str(folder)],
        cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert built.returncode == 0, built.stderr
    return folder


def test_every_public_name_has_its_place_in_the_reference(site):
    page = (site / "reference" / "public" / "index.html").read_text("utf-8")
    found = set(re.findall(r'id="gaitopt\.[\w.]*?(\w+)"', page))
    assert set(gaitopt.__all__) - {"__version__"} <= found


def test_no_page_shows_raw_indices(site):
    """The mark-up of TeX is not made out there: `^{j-1}A_j` stood in the table of symbols."""
    pages = {
        page: page.read_text("utf-8")
        for page in site.rglob("index.html")
        if "reference" not in page.parts  # whose docstrings are read as code, too
    }
    assert "<sup>j-1</sup>A<sub>j</sub>" in pages[site / "notation" / "index.html"]
    code = re.compile(r"<(code|pre|script|style)\b.*?</\1>", re.DOTALL)
    raw = re.compile(r"\S*[_^]\{[^}]*\}\S*")
    found = {page: raw.findall(code.sub("", text)) for page, text in pages.items()}
    assert {page.parent.name: marks for page, marks in found.items() if marks} == {}


def test_every_module_is_in_the_reference(site):
    pages = "".join(p.read_text("utf-8") for p in (site / "reference").rglob("index.html"))
    modules = [
        ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for path in (ROOT / "gaitopt").rglob("*.py")
        if not path.stem.startswith("__")
    ]
    assert [name for name in modules if f'id="{name}"' not in pages] == []


def test_page_asks_nobody_else(site):
    for page in (site / "index.html", site / "reference" / "public" / "index.html"):
        fetched = re.findall(r'(?:src|href)="(https?://[^"]+)"', page.read_text("utf-8"))
        assert [url for url in fetched if not url.startswith("https://www.mkdocs.org")] == []
