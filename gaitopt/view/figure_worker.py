"""The figures of a gait, drawn beside other work: in a second process on a second core."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path

from gaitopt.design.process import serve_parent
from gaitopt.gait.result import Gait


@dataclass(frozen=True)
class FigureWorker:
    """Draws the figures of gaits.

    Attributes:
        pool: the process that draws, None for this one.
    """

    pool: ProcessPoolExecutor | None = None

    def begin(self, gait: Gait, directory: Path) -> Callable[[], list[Path]]:
        """Begin to write the figures of a gait.

        Args:
            gait: what to draw.
            directory: where to.

        Returns:
            A function that waits for the figures and returns their files, or raises what
            `write_figures` raises.
        """
        try:
            drawn = None if self.pool is None else self.pool.submit(_draw, gait, directory)
        except BrokenProcessPool:
            drawn = None

        def files() -> list[Path]:
            with contextlib.suppress(BrokenProcessPool):  # it was ended, for want of memory perhaps
                if drawn is not None:
                    return drawn.result()
            return _draw(gait, directory)

        return files


@contextlib.contextmanager
def figure_worker(wanted: bool = True) -> Iterator[FigureWorker]:
    """Get ready to draw, if that is wanted and there is a core for it; wait for it at the end.

    The process that will draw loads what it needs meanwhile, which takes as long as drawing.
    """
    if not wanted or spare_cores() < 1.0:
        yield FigureWorker()
        return
    try:
        context = multiprocessing.get_context("spawn")
        pool = ProcessPoolExecutor(1, context, initializer=serve_parent)
        pool.submit(_get_ready)
    except (OSError, RuntimeError, NotImplementedError):  # no more processes are to be had
        yield FigureWorker()
        return
    try:
        yield FigureWorker(pool)
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def spare_cores() -> float:
    """Return how many cores this process may use beside its own, less what others use of late.

    A second process loads everything again: on a core that others use it costs more than it saves.
    """
    affinity = getattr(os, "sched_getaffinity", None)  # neither of the two is everywhere
    cores = (os.cpu_count() or 1) if affinity is None else len(affinity(0))
    load = 0.0
    with contextlib.suppress(OSError, AttributeError):
        load = os.getloadavg()[0]
    return min(cores - 1.0, cores - load)


def _draw(gait: Gait, directory: Path) -> list[Path]:
    from gaitopt.view.figures import write_figures

    return write_figures(gait, directory)


def _get_ready() -> None:
    from gaitopt.view.figure_style import new_figure, rendered

    figure = new_figure(1.0, 1.0)
    figure.subplots()
    rendered(figure, "png")  # loads the fonts and the renderer too
