"""What the pages show is run as a reader would: Python as it stands, commands at least as asked.

Pages whose Python or commands have tests of their own are not run again: README.md (test_house.py),
arms-on-stairs.md, extending.md, gait-file.md and motors.md.
"""

import re
import shlex
import shutil

import pytest
import typer
from places import DOCS, ROOT
from typer.testing import CliRunner

from gaitopt.cli.app import app

PYTHON = {
    page.name: blocks
    for page in sorted(DOCS.glob("*.md"))
    if (blocks := re.findall(r"```python\n(.*?)```", page.read_text("utf-8"), re.S))
}
ELSEWHERE = {"arms-on-stairs.md", "extending.md", "gait-file.md", "motors.md"}
SAID = {
    "design.md": r"[\d.]+ \(",
    "diagnosis.md": "torque_limit.* gives a certified walk(.*\n)+.*2 of 2 starts led to a walk",
    "index.md": r"\d+ N²·m·s, certified\n",
    "live.md": "",
    "motions.md": "",
    "simulation.md": r"Ending\.WALKED 20 ",
    "solvers.md": "sqp OPTIMAL ",
    "sweeps.md": r"0\.9 \S+ \S+\n1\.0 ",
    "transitions.md": "certified <",
    "your-robot.md": "certified",
}
"""What a page's Python prints, as far as it does not hang on the last digits."""
SHORTER = {
    "solvers.md": ('["sqp", "slsqp"]', '["sqp"]'),
    "sweeps.md": ("0.4:1.3:0.05", "0.9:1.0:0.1"),
}
"""What is run in place of what takes long."""


@pytest.fixture(scope="module")
def walks(tmp_path_factory):
    """A folder with what readers have made before by the commands of README.md."""
    folder = tmp_path_factory.mktemp("pages")
    quick = ("--starts", "1", "--no-figures", "--quiet")
    for words in (
        ("optimise", "--speed", "1", "-o", str(folder / "walk"), *quick),
        ("optimise", "--preset", "robust", "--speed", "0.8", "-o", str(folder / "robust"), *quick),
        ("sweep", "--speeds", "0.9:1:0.1", "-o", str(folder / "gaits"), "--quiet"),
    ):
        made = CliRunner().invoke(app, words)
        assert made.exit_code == 0, made.output
    shutil.copy(ROOT / "urdf" / "biped13.urdf", folder / "robot.urdf")
    return folder


def test_all_python_has_a_test():
    assert set(PYTHON) == ELSEWHERE | set(SAID)


@pytest.mark.parametrize("page", SAID)
def test_python_runs_as_it_stands(walks, page, tmp_path, monkeypatch, capsys):
    shutil.copytree(walks, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "shown"}
    told, shorter = SHORTER.get(page, ("", ""))
    assert any(told in block for block in PYTHON[page])
    for block in PYTHON[page]:
        exec(compile(block.replace(told, shorter) if told else block, page, "exec"), names)
    assert re.search(SAID[page], capsys.readouterr().out), page


def commands() -> list[tuple[str, list[str]]]:
    """The commands that stand in lines of their own, but for those with options of a plugin."""
    found = []
    for page in (ROOT / "README.md", *sorted(DOCS.glob("*.md"))):
        text = re.sub(r"\\\n\s*", " ", page.read_text("utf-8"))
        for line in re.findall(r"(?m)^(?:    )?(?:\$ )?gaitopt (.*)$", text):
            if re.match("[a-z]+ (?!.*--plugin)", line) and line.split()[0] in COMMANDS:
                found.append((page.name, shlex.split(line, comments=True)))
    return found


COMMANDS = typer.main.get_command(app).commands


def test_every_command_is_one_that_is_known():
    found = commands()
    assert len(found) > 90
    for page, (name, *words) in found:
        assert COMMANDS[name].make_context(name, words).params, page
