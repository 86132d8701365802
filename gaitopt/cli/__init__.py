"""The command line: `gaitopt optimise | inspect | check | play | ...`."""

from __future__ import annotations

_OBJECTS = 50_000
"""New objects before cycles among them are looked for: at Python's 700, looking for them takes a
sixteenth of the time of imports (measured)."""


def main() -> None:
    """Run the command line; the process ends with an exit code of `gaitopt.cli.process`."""
    import gc

    gc.set_threshold(_OBJECTS)  # a walk makes few cycles, and classes of modules stay
    from gaitopt.cli.app import run

    run()


__all__ = ["main"]
