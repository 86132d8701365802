"""`gaitopt reproduce`: the paper's section 6, computed again, as a page with figures."""

from __future__ import annotations

import time
from pathlib import Path

from gaitopt.cli.screen import screen
from gaitopt.cli.writable import require_writable


def run(output: Path, quiet: bool) -> None:
    """Compute, and write page, figures and numbers.

    Raises:
        GaitoptError: the directory cannot be written, or a walk was not found.
    """
    from gaitopt.study.reproduce.results import reproduce
    from gaitopt.view.reproduction_page import write_reproduction

    require_writable(output)
    errors, started = screen(stderr=True), time.monotonic()

    def tell(stage: str) -> None:
        if not quiet:
            errors.print(f"{time.monotonic() - started:5.0f} s  {stage}")

    result = reproduce(tell)
    written = write_reproduction(result, output)
    worst = 100.0 * float(abs(result.errors).max())
    if not quiet:
        out = screen()
        out.print(f"largest error at the speeds of Table 3: {worst:.2f} %")
        for path in written:
            out.print(f"wrote {path}", soft_wrap=True)
