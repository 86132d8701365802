"""The command line: `gaitopt optimise | inspect | check | play | ...`."""

from __future__ import annotations

_OBJECTS = 300_000
"""New objects before cycles among them are looked for. Imports make a hundred thousand that stay:
at Python's 700, looking for cycles takes a sixteenth of their time, at 50000 still 14 ms
(measured)."""


def main() -> None:
    """Run the command line; the process ends with an exit code of `gaitopt.cli.process`."""
    import atexit
    import gc

    from gaitopt.cli.beginning import quit_on_signals

    quit_on_signals()
    gc.set_threshold(_OBJECTS)  # a walk makes few cycles, and classes of modules stay
    atexit.register(gc.freeze)  # as at the end: 7 % of a command went into that (measured)
    from gaitopt.cli.app import run

    run()


__all__ = ["main"]
