import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from gaitopt.cli.app import app


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
