"""The examples: each runs, with warnings as errors, and finds what it says."""

import os
import re
import shutil
import subprocess
import sys

import pytest
from places import ROOT

EXAMPLES = ROOT / "examples"
SCRIPTS = sorted(EXAMPLES.glob("[0-9][0-9]_*.py"))

SAYS = {
    "01": r"biped13: 329\d N²·m·s, certified\n.*knee +20\.\d N·m",
    "02": r"at 0\.6 m/s, certified",
    "03": r"any rad/s +135\d.*certified\n"
    r" +5\.0 rad/s +\d+\.\d N²·m·s, fastest knee 5\.00.*certified\n"
    r" +4\.0 rad/s +\d+\.\d N²·m·s, fastest knee 4\.00.*certified",
    "04": r"torque +135\d .*\ntorque and rate +19\d\d .*\ntorque and rate +\d{4} ",
    "05": r"0\.8 m/s +135\d\.\d N²·m·s, certified\n.*cheapest per metre: 0\.7 m/s",
    "06": r"\| 1\.1 \| 7130\.79 \| 7202\.\d+ \| \+1\.\d+ % .*wrote \S+step\.png",
    "07": r"800 instants, mean speed 1\.0\d m/s\nvertical ground force \d+ to \d+ N",
    "08": r"as it is +135\d .*\nshin 2 cm longer +\d+ .*\ntrunk 5 kg heavier +\d+ ",
}


def test_there_are_eight_and_the_readme_names_each():
    assert [script.name[:2] for script in SCRIPTS] == sorted(SAYS)
    listed = re.findall(r"\]\((\d\d_\w+\.py)\)", (EXAMPLES / "README.md").read_text("utf-8"))
    assert listed == [script.name for script in SCRIPTS]


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_example_finds_what_it_says(script, tmp_path):
    copy = tmp_path / "examples" / script.name  # results land beside the script
    copy.parent.mkdir()
    shutil.copy(script, copy)
    (tmp_path / "reproduction").symlink_to(ROOT / "reproduction")
    found = subprocess.run(
        [sys.executable, "-W", "error", str(copy)], cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert found.returncode == 0, found.stderr
    assert re.search(SAYS[script.name[:2]], found.stdout, re.S), found.stdout
