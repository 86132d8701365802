"""Whole processes as a person starts them: import, work, certificate, files, exit."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from common import arguments, save

REPEATS = 7
"""Runs of each command; the first, which fills the caches of the system, is not counted."""
COMMANDS = {
    "help": ("--help",),
    "import": (),
    "optimise": ("optimise", "--quiet", "--no-page", "--no-figures", "--output"),
    "optimise, page": ("optimise", "--quiet", "--output"),
    "optimise, page and figures": ("optimise", "--quiet", "--figures", "--output"),
    "optimise G1": ("optimise", "--quiet", "--robot", "g1", "--output"),
}
"""What is run; a command that ends in `--output` is given a directory."""


def run(words: tuple[str, ...], compiled: str, path: str | None = None) -> dict[str, float]:
    """Run one process; return its wall and CPU time [s].

    Args:
        words: of the command.
        compiled: directory for compiled modules, which an installed package has too.
        path: of a clone to be run in place of this one.
    """
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": compiled}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    clone = Path(path or Path(__file__).parents[1]).resolve()
    others = environment.get("PYTHONPATH")
    environment["PYTHONPATH"] = os.pathsep.join([str(clone), *([others] if others else [])])
    command = [sys.executable, "-c", "import gaitopt"]
    with tempfile.TemporaryDirectory() as folder:
        if words:
            output = [str(Path(folder) / "gait")] if words[-1] == "--output" else []
            command = [sys.executable, "-m", "gaitopt", *words, *output]
        before, started = os.times(), time.perf_counter()  # not started in a clone: it goes first
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=environment, cwd=folder)
        wall, after = time.perf_counter() - started, os.times()
    user = after.children_user - before.children_user
    system = after.children_system - before.children_system
    return {"wall": wall, "cpu": user + system}


def main() -> None:
    quick = arguments(__doc__).parse_args().quick
    names = ("help", "import") if quick else tuple(COMMANDS)
    found: dict[str, list[Any]] = {name: [] for name in names}
    with tempfile.TemporaryDirectory() as compiled:
        for _ in range(1 + (1 if quick else REPEATS)):
            for name in names:
                found[name].append(run(COMMANDS[name], compiled))
    save("process", {name: runs[1:] for name, runs in found.items()}, quick)


if __name__ == "__main__":
    main()
