"""The command line: `gaitopt optimise | inspect | check | play | ...`."""

from __future__ import annotations


def main() -> None:
    """Run the command line; the process ends with an exit code of `gaitopt.cli.process`."""
    from gaitopt.cli.app import run

    run()


__all__ = ["main"]
