"""What a command imports: only what its answer needs."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

_SLOW = (
    "{'scipy', 'qpsolvers', 'matplotlib', 'mujoco', 'meshcat', 'tornado', 'pydantic', "
    "'IPython', 'zmq', 'PIL', "
    "'multiprocessing', 'numpy.random', 'fast_simplification', 'gaitopt.design.diagnosis'}"
)


def printed(code: str) -> str:
    """What a new process prints."""
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return found.stdout.strip()


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys, gaitopt, gaitopt.cli.app; from typer.testing import CliRunner; "
        "r = CliRunner().invoke(gaitopt.cli.app.app, ['--help']); assert r.exit_code == 0; "
        "assert 'Design the gait' in r.stdout; "
        f"print([m for m in {_SLOW} | {{'pinocchio', 'numpy'}} if m in sys.modules])"
    )
    assert printed(code) == "[]"


@pytest.mark.parametrize("page", [True, False])
def test_a_walk_of_the_biped_is_designed_without_what_it_does_not_need(
    tmp_path: Path, page: bool
) -> None:
    words = [
        "optimise",
        "--quiet",
        "--starts",
        "1",
        "--no-figures",
        *([] if page else ["--no-page"]),
    ]
    code = (
        "import sys; from gaitopt.cli import main\n"
        f"sys.argv = ['gaitopt', *{words}, '--output', {str(tmp_path / 'walk')!r}]\n"
        "try: main()\n"
        "except SystemExit as end: assert not end.code\n"
        f"print(sorted({_SLOW} & set(sys.modules)))"
    )
    assert printed(code) == "[]"
    assert (tmp_path / "walk" / "gait.npz").exists()
    assert (tmp_path / "walk" / "gait.html").exists() == page


def test_a_page_leaves_meshcat_to_others_as_it_is() -> None:
    """Pinocchio's own viewer, say."""
    code = (
        "import sys, warnings; import gaitopt.view.page\n"
        "warnings.simplefilter('ignore')\n"
        "import meshcat\n"
        "print(meshcat.geometry.Box([1, 1, 1]).lengths, meshcat.Visualizer.__name__)"
    )
    assert printed(code) == "[1, 1, 1] Visualizer"


def test_a_table_is_written_as_parquet_without_pandas(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow", reason="the extra 'tables' is not installed")
    code = (
        "import sys; from pathlib import Path; from gaitopt.sweep.table import write_table\n"
        f"write_table([{{'speed': 1.0, 'status': 'certified'}}], Path({str(tmp_path)!r}))\n"
        "print('pandas' in sys.modules)"
    )
    assert printed(code) == "False"
    assert (tmp_path / "index.parquet").exists()
