"""The atlas of public humanoid files is what the files that a package brings say."""

import subprocess
import sys

from places import ROOT


def test_atlas_is_current():
    command = [sys.executable, str(ROOT / "scripts" / "make_atlas"), "--check"]
    found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr
