"""Page and figures of a gait, drawn beside other work: in a second process on a second core."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from gaitopt.design.process import (
    copy_that_does,
    processors,
    serve_parent,
    shut_down,
    without_ctrl_c,
    worker_context,
)
from gaitopt.gait.result import Gait

if TYPE_CHECKING:
    from concurrent.futures import Future, ProcessPoolExecutor

Drawn = TypeVar("Drawn")


class DrawingWorker:
    """Draws what it is asked for: in this process, or in one that was started for it.

    Attributes:
        pool: the process that draws, None for this one.
    """

    def __init__(self) -> None:
        self.pool: ProcessPoolExecutor | None = None
        self._ready: list[Future[Any]] = []
        self._meshes: dict[str, Future[Any]] = {}

    def get_ready(self, *, figures: bool = False, meshes: Sequence[str] = ()) -> None:
        """Start a process that gets ready to draw, if there is a core for it.

        Where processes can be copied, it is a copy of this one.

        Args:
            figures: whether it shall load what figures need.
            meshes: files that it shall simplify, as a page needs them.
        """
        if not (figures or meshes) or spare_cores() < 1.0:
            return
        from concurrent.futures import ProcessPoolExecutor  # slow to import, and seldom needed

        try:
            pool = ProcessPoolExecutor(1, worker_context(), initializer=serve_parent)
            with without_ctrl_c():
                loads = (ready_for_figures, ready_for_page) if figures else (ready_for_page,)
                self._ready = [pool.submit(load) for load in loads]
        except (OSError, RuntimeError, NotImplementedError):  # no more processes are to be had
            return
        self.pool = pool
        with contextlib.suppress(RuntimeError):  # it has died: this process draws
            for path in meshes:
                self._meshes[path] = pool.submit(simplify, path)

    def simplify_rest(self) -> dict[str, Any]:
        """Simplify the meshes that the process has not begun with; return them by file."""
        from gaitopt.view.robot_shapes import file_parts

        rest = [path for path, job in reversed(self._meshes.items()) if job.cancel()]
        return {path: file_parts(path) for path in rest}

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

    def close(self) -> None:
        """Wait for what was begun; end the process at once if it is not even ready."""
        if self.pool is not None:
            jobs = (*self._ready, *self._meshes.values())
            shut_down(self.pool, at_once=not all(job.done() for job in jobs))


def spare_cores() -> float:
    """Return how many cores this process may use beside its own, less what others use.

    A second process loads everything again: on a core that others use it costs more than it saves.
    The load of the last minute counts commands that have ended, as those before this one in a row;
    what runs at this moment does not.
    """
    cores, load = processors(), 0.0
    with contextlib.suppress(OSError, AttributeError):  # it is not everywhere
        load = os.getloadavg()[0]
    return min(cores - 1.0, cores - min(load, _running()))


_LOAD = Path("/proc/loadavg")  # of Linux; its fourth number is what runs, of all that there is
_LOOKS = 3  # at what runs: what the system does beside takes less time


def _running() -> float:
    """Return how many threads run at this moment, this one included; infinite if none can tell."""
    with contextlib.suppress(OSError, ValueError, IndexError):
        texts = [_LOAD.read_text(encoding="ascii") for _ in range(_LOOKS)]
        return float(min(int(text.split()[3].partition("/")[0]) for text in texts))
    return float("inf")


def draw_figures(gait: Gait, directory: Path) -> list[Path]:
    """Write the figures of a gait, see `write_figures`; a worker has a copy of it draw half."""
    from gaitopt.view.figures import FIGURES, write_figures

    names = tuple(FIGURES)
    first, second = (partial(write_figures, gait, directory, names=names[k::2]) for k in (0, 1))
    copy = copy_that_does(second) if _is_worker() else None
    try:
        first()
    finally:
        if copy is not None:
            copy.join()
    if copy is None or copy.exitcode:
        second()
    return [directory / f"{name}.png" for name in names]


def _is_worker() -> bool:
    """Return whether this process may be copied amid its work, which a command must not be.

    A command has threads. The second thread of a worker waits for the command's end, and holds no
    lock.
    """
    import multiprocessing

    return multiprocessing.parent_process() is not None and sys.platform.startswith("linux")


def draw_page(gait: Gait, parts: Mapping[str, Any] | None = None) -> str:
    """Return the text of the page of a gait, see `write_page`, with meshes already simplified."""
    from gaitopt.view.page import page_text
    from gaitopt.view.robot_shapes import take_parts

    take_parts(parts or {})
    return str(page_text(gait))


def ready_for_figures() -> None:
    """Load what figures need, which takes as long as drawing them."""
    from gaitopt.view.figure_style import legends_beside, panelled, rendered, styled
    from gaitopt.view.figures import FORCES

    with styled():
        figure, (axes,) = panelled((4.0, 2.0), "")
        for words in FORCES:
            axes.plot([], label=words)
        legends_beside(figure)
    rendered(figure, "png")  # loads the fonts, the grammar of formulas and the renderer too


def ready_for_page() -> None:
    """Load what a page needs."""
    import gaitopt.view.page  # noqa: F401
    from gaitopt.view.viewer import packed_viewer

    packed_viewer()  # which is kept


def simplify(path: str) -> None:
    """Simplify a mesh file, which is kept: those of a robot take longer than a gait."""
    from gaitopt.view.robot_shapes import file_parts

    file_parts(path)


def mesh_files(urdf: str, package_dirs: tuple[str, ...]) -> list[str]:
    """Return the mesh files that a robot is drawn with, the largest first.

    Args:
        urdf: text of its file.
        package_dirs: where its meshes are.
    """
    if "<mesh" not in urdf:
        return []
    import coal
    import pinocchio as pin

    from gaitopt.errors import GaitoptError
    from gaitopt.importers.reader import read_source

    sizes: dict[str, int] = {}

    def note(path: str, _scale: object) -> coal.BVHModelBase:
        with contextlib.suppress(OSError):
            sizes[path] = os.stat(path).st_size
        return coal.BVHModelOBB()

    with contextlib.suppress(GaitoptError):  # which the page will say
        read_source(urdf, package_dirs).geometry(pin.GeometryType.VISUAL, load=note)
    return sorted(sizes, key=lambda path: -sizes[path])
