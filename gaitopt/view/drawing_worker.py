"""Page and figures of a gait, drawn beside other work: in a second process on a second core."""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from gaitopt.dataclass import dataclass
from gaitopt.design.process import serve_parent, shut_down, without_ctrl_c, worker_context
from gaitopt.gait.result import Gait

if TYPE_CHECKING:
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing.process import BaseProcess

Drawn = TypeVar("Drawn")


@dataclass(frozen=True)
class DrawingWorker:
    """Draws what it is asked for.

    Attributes:
        pool: the process that draws, None for this one.
    """

    pool: ProcessPoolExecutor | None = None

    def begin(self, draw: Callable[..., Drawn], *facts: object) -> Callable[[], Drawn]:
        """Begin to draw.

        Args:
            draw: a function of a module, as `draw_figures` and `draw_page`.

        Returns:
            A function that waits for what `draw` returns, or raises what it raises.
        """
        here = partial(draw, *facts)
        if self.pool is None:
            return here
        from concurrent.futures.process import BrokenProcessPool

        try:
            drawn = self.pool.submit(draw, *facts)
        except BrokenProcessPool:
            return here

        def result() -> Drawn:
            with contextlib.suppress(BrokenProcessPool):  # it was ended, for want of memory perhaps
                return drawn.result()
            return here()

        return result


@contextlib.contextmanager
def drawing_worker(get_ready: Callable[[], None] | None) -> Iterator[DrawingWorker]:
    """Get ready to draw if there is a core for it; wait for what was begun at the end.

    Where processes can be copied, the one that will draw is a copy of this one.

    Args:
        get_ready: called by the process that will draw: it loads what that needs, meanwhile. None
            where nothing will be drawn that would be worth it.
    """
    if get_ready is None or spare_cores() < 1.0:
        yield DrawingWorker()
        return
    from concurrent.futures import ProcessPoolExecutor  # slow to import, and seldom needed

    try:
        pool = ProcessPoolExecutor(1, worker_context(), initializer=serve_parent)
        with without_ctrl_c():
            ready = pool.submit(get_ready)
    except (OSError, RuntimeError, NotImplementedError):  # no more processes are to be had
        yield DrawingWorker()
        return
    try:
        yield DrawingWorker(pool)
    finally:
        shut_down(pool, at_once=not ready.done())  # if nothing was drawn yet, and nothing will be


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


def draw_figures(gait: Gait, directory: Path) -> list[Path]:
    """Write the figures of a gait, see `write_figures`; a worker has a copy of it draw half."""
    from gaitopt.view.figures import FIGURES, write_figures

    names = tuple(FIGURES)
    first, second = (partial(write_figures, gait, directory, names=names[k::2]) for k in (0, 1))
    copy = _copy_that_does(second)
    try:
        first()
    finally:
        if copy is not None:
            copy.join()
    if copy is None or copy.exitcode:
        second()
    return [directory / f"{name}.png" for name in names]


def _copy_that_does(work: Callable[[], object]) -> BaseProcess | None:
    """Return a copy of this process that works and ends, its exit code not 0 if it fails.

    Returns:
        None where this is no worker, as a command must not be copied amid its work: it has
        threads. The second thread of a worker waits for the command's end, and holds no lock.
    """
    import multiprocessing

    if multiprocessing.parent_process() is None or not sys.platform.startswith("linux"):
        return None
    copy = multiprocessing.get_context("fork").Process(target=_work, args=(work,))
    with warnings.catch_warnings(), contextlib.suppress(OSError):
        warnings.simplefilter("ignore", DeprecationWarning)  # of threads, by Python 3.12
        copy.start()
        return copy
    return None


def _work(work: Callable[[], object]) -> None:
    serve_parent()
    try:
        work()
    except Exception:  # told by the worker, which fails likewise when it does this itself
        sys.exit(1)


def draw_page(gait: Gait) -> str:
    """Return the text of the page of a gait; see `write_page`."""
    from gaitopt.view.page import page_text

    return str(page_text(gait))


def ready_for_figures() -> None:
    """Load what figures need, which takes as long as drawing them."""
    from gaitopt.view.figure_style import new_figure, rendered

    figure = new_figure(1.0, 1.0)
    figure.subplots().set_title("$f_z$")
    rendered(figure, "png")  # loads the fonts, the grammar of formulas and the renderer too


def ready_for_page(urdf: str, package_dirs: tuple[str, ...]) -> None:
    """Load what a page needs, and simplify the meshes of a robot: that takes longer than a gait."""
    import pinocchio as pin

    from gaitopt.errors import GaitoptError
    from gaitopt.importers.reader import read_source
    from gaitopt.view.robot_shapes import file_parts, unloaded

    with contextlib.suppress(GaitoptError):  # which the page will say
        shapes = read_source(urdf, package_dirs).geometry(pin.GeometryType.VISUAL, load=unloaded)
        for item in () if shapes is None else shapes.geometryObjects:
            file_parts(item.meshPath)
