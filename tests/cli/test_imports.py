"""What a command imports: only what its answer needs."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

_SLOW = (
    "{'scipy', 'qpsolvers', 'matplotlib', 'mujoco', 'meshcat', 'tornado', 'pydantic', "
    "'gaitopt.design.diagnosis'}"
)


def test_a_walk_of_the_biped_is_designed_without_what_it_does_not_need(tmp_path: Path) -> None:
    words = ["optimise", "--quiet", "--starts", "1", "--no-page", "--no-figures"]
    code = (
        "import sys; from gaitopt.cli import main\n"
        f"sys.argv = ['gaitopt', *{words}, '--output', {str(tmp_path / 'walk')!r}]\n"
        "try: main()\n"
        "except SystemExit as end: assert not end.code\n"
        f"print(sorted({_SLOW} & set(sys.modules)))"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"
    assert (tmp_path / "walk" / "gait.npz").exists()
