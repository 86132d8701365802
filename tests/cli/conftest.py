import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from gaitopt.cli.app import app
from gaitopt.simulate.stability import Feedback, Stability


@pytest.fixture(scope="session")
def cli() -> Callable[..., Any]:
    """Run the command line in this process; the result has exit_code, stdout and stderr.

    An exception that would be a traceback fails the test.
    """
    runner = CliRunner()
    return lambda *words: runner.invoke(app, [str(word) for word in words], catch_exceptions=False)


@pytest.fixture(scope="session")
def quick(cli) -> Callable[..., Any]:
    """Run `gaitopt optimise` without what takes time."""
    less = ("--solver", "sqp", "--starts", "1", "--no-refine", "--no-figures")

    def run(*words: Any) -> Any:
        page = ("--no-page",) if {"-o", "--output"} & {*words} else ()
        return cli("optimise", *less, *page, *words)

    return run


@pytest.fixture(scope="session")
def designed(cli, tmp_path_factory) -> Path:
    """A directory as `gaitopt optimise --output` leaves it, and what it printed."""
    directory = tmp_path_factory.mktemp("designed") / "new" / "walk"
    words = (
        "--solver",
        "sqp",
        "--starts",
        "1",
        "--speed",
        "1.0",
        "--figures",
        "--output",
        directory,
    )
    result = cli("optimise", *words)
    assert result.exit_code == 0, result.stderr
    (directory / "stdout.txt").write_text(result.stdout)
    return directory


@pytest.fixture
def gait_file(designed, tmp_path) -> Path:
    """A copy of its gait, to be damaged."""
    return Path(shutil.copy(designed / "gait.npz", tmp_path / "gait.npz"))


@pytest.fixture
def known_stability(monkeypatch) -> None:
    """For what is said of a simulation beside its multipliers, which take seconds to find."""
    feedback = Feedback(multiplier=0.5, region=0.01, measured=0.5, predicted=0.5)
    known = Stability(feedback, feedback, {"middle": 0.1, "toe left": 0.1}, growth=5.0)
    monkeypatch.setattr("gaitopt.cli.simulate.stability", lambda gait: known)
