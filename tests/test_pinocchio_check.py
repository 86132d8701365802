"""Another Pinocchio that stands before the right one is named, with its path and version."""

import os
import subprocess
import sys
from importlib import import_module

import pytest
from places import ROOT
from sample_gait import sample_gait

import gaitopt
from gaitopt import save_gait
from gaitopt.errors import InputError, missing_package
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


WITHOUT = """
import sys
sys.modules[sys.argv[1]] = None
from gaitopt.cli import main
sys.argv = ["gaitopt", *sys.argv[2:]]
main()
"""


@pytest.mark.parametrize(
    ("package", "words"),
    [
        ("typer", ["robots"]),
        ("matplotlib", ["plot", "GAIT", "-o", "figures"]),
        ("PIL", ["play", "GAIT"]),
    ],
)
def test_another_package_that_is_missing_is_told(tmp_path, package, words):
    gait = save_gait(sample_gait(), tmp_path / "walk.npz")
    words = [str(gait) if word == "GAIT" else word for word in words]
    found = subprocess.run(
        [sys.executable, "-c", WITHOUT, package, *words], cwd=tmp_path, capture_output=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)}, text=True, check=False, timeout=100,
    )  # fmt: skip
    assert found.returncode == 2, found.stderr
    said = f"error: the package {package} is not installed, which gaitopt needs; run: pip install"
    assert found.stderr.startswith(said)


def test_it_is_told_to_programs_too(monkeypatch):
    def missing(name):
        raise ModuleNotFoundError(name=f"{name}.figure")

    monkeypatch.setattr(gaitopt, "import_module", lambda name: missing("matplotlib")
                        if name == "gaitopt.view.figures" else import_module(name))  # fmt: skip
    monkeypatch.delitem(vars(gaitopt), "write_figures", raising=False)
    with pytest.raises(InputError, match="the package matplotlib is not installed, which gaitopt"):
        _ = gaitopt.write_figures
    assert missing_package(ModuleNotFoundError(name="gaitopt.viw")) == ""  # a slip of our own
    assert missing_package(ImportError(name="matplotlib")) == ""  # it is there, but broken


def test_none_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    monkeypatch.setattr("gaitopt.pinocchio_check.importlib.util.find_spec", lambda _: None)
    with pytest.raises(InputError, match="Pinocchio is not installed; run: pip install"):
        require_pinocchio()
