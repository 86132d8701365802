"""`--nothing-skipped`, by which scripts/test runs: a skip for a missing package is a failure."""

import subprocess
import sys
from pathlib import Path

import pytest
from places import ROOT

TESTS = """
import pytest

{head}

def test_passes():
    pass

@pytest.mark.skipif(True, reason="needs a package")
def test_skipped():
    pass

@pytest.mark.browser
@pytest.mark.skipif(True, reason="no browser")
def test_browser():
    pass

@pytest.mark.xfail(reason="known")
def test_known():
    assert False
"""


@pytest.mark.parametrize(
    ("head", "options", "expected"),
    [
        ("", (), "1 passed, 2 skipped, 1 xfailed"),
        ("", ("--nothing-skipped",), "1 passed, 1 skipped, 1 xfailed, 1 error"),
        ("pytest.importorskip('no_such_package')", (), "1 skipped"),
        ("pytest.importorskip('no_such_package')", ("--nothing-skipped",), "1 error"),
    ],
)
def test_skips_fail_if_nothing_is_to_be_skipped(tmp_path, head, options, expected):
    (tmp_path / "conftest.py").write_text((Path(__file__).parent / "conftest.py").read_text())
    (tmp_path / "test_some.py").write_text(TESTS.format(head=head))
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = browser: needs a browser\n")
    found = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *options, str(tmp_path)],
        cwd=tmp_path, env={"PYTHONPATH": f"{Path(__file__).parent}:{ROOT}"},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert expected in found.stdout
    if options:
        assert found.returncode == 1 or (head and found.returncode == 2)
