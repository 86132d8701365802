"""Another Pinocchio that stands before the right one is named, with its path and version."""

import os
import subprocess
import sys

import pytest
from places import ROOT

from gaitopt.errors import InputError
from gaitopt.pinocchio_check import require_pinocchio


def test_the_one_that_is_installed_will_do():
    require_pinocchio()


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("__version__ = '2.6.21'\n", "__init__.py', version 2.6.21; gaitopt needs one of 4.1 or"),
        ("__version__ = '5.0.0'\n", "version 5.0.0; gaitopt needs"),
        ("__version__ = '4.1.0'\n", "version 4.1.0 (it has no buildModelFromXML)"),
        ("raise ImportError('libpinocchio.so: cannot open')", "(it cannot be imported: libpin"),
        ("", "__init__.py', of unknown version; gaitopt"),
        (None, "pinocchio', of unknown version; gaitopt"),  # a directory with something else
    ],
)
def test_another_one_is_named(tmp_path, content, said):
    other = tmp_path / "pinocchio"
    other.mkdir()
    if content is not None:
        (other / "__init__.py").write_text(content)
    environment = {**os.environ, "PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"}
    command = [sys.executable, "-m", "gaitopt", "inspect"]
    if content is None:  # a module elsewhere on the path wins over a mere directory
        command = [sys.executable, "-c", _ALONE, str(tmp_path)]
    found = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert found.returncode == 2, found.stderr
    assert f"error: the Pinocchio that Python finds is '{other}" in found.stderr
    assert said in found.stderr
    assert "pip install 'pin>=4.1,<5'" in found.stderr
    assert "Traceback" not in found.stderr


_ALONE = """
import sys
sys.path = [sys.argv[1], *(p for p in sys.path if "cmeel" not in p)]
from gaitopt.cli import main
sys.argv = ["gaitopt", "inspect"]
main()
"""


def test_none_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    monkeypatch.setattr("gaitopt.pinocchio_check.importlib.util.find_spec", lambda _: None)
    with pytest.raises(InputError, match="Pinocchio is not installed; run: pip install"):
        require_pinocchio()
