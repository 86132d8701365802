"""How a sweep is going: a bar with the time left on a terminal, now and then a line elsewhere."""

from __future__ import annotations

import time

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from gaitopt.sweep.scheduler import Advance

PERIOD = 10.0  # s between two plain lines
FINISHING = 3  # times the work of exploring a point


class SweepDisplay:
    """Shows how far a sweep is; a context manager, and what `sweep` takes as `on_advance`."""

    def __init__(self, console: Console, quiet: bool) -> None:
        self._console, self._quiet = console, quiet
        self._bar: Progress | None = None
        self._printed = time.monotonic()
        self.jobs = 0  # done so far

    def __enter__(self) -> SweepDisplay:
        if self._console.is_terminal and not self._quiet:
            self._bar = Progress(
                TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[said]}"),
                TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(),
                console=self._console,
            )  # fmt: skip
            self._bar.add_task("exploring", total=None, said="")
            self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, advance: Advance) -> None:
        """Show it."""
        self.jobs += 1
        done = advance.gaits + advance.refused
        said = f"{done} of {advance.points} done, {advance.explored} explored"
        if advance.refused:
            said += f", {advance.refused} without a gait"
        if self._bar is not None:
            self._bar.update(
                self._bar.task_ids[0],
                description=advance.doing,
                total=(1 + FINISHING) * advance.points,
                completed=advance.explored + FINISHING * done,
                said=said,
            )
        elif not self._quiet and time.monotonic() - self._printed >= PERIOD:
            self._printed = time.monotonic()
            self._console.print(f"{advance.doing}: {said}", soft_wrap=True)
