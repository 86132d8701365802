"""Files of results: whether they can be written, and the directory of `gaitopt optimise`."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import is_dataclass
from os.path import exists, isdir, realpath
from pathlib import Path

import tomli_w

from gaitopt.atomic import make_directory, taken_by, write_atomically
from gaitopt.cli.config import SCHEMA, Settings
from gaitopt.cli.idle import idle
from gaitopt.cli.request import Request, choices_text
from gaitopt.design.summary import summarise
from gaitopt.errors import InputError, reason_of
from gaitopt.gait.costs import Cost, WeightedSum
from gaitopt.gait.gait_file import save_gait
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task
from gaitopt.gait.terrain import Terrain
from gaitopt.settings import NO_LIMIT, declared
from gaitopt.view.drawing_worker import DrawingWorker, draw_figures, draw_page

GAIT, PAGE, FIGURES, SUMMARY = "gait.npz", "gait.html", "figures", "summary.json"
TASK, URDF, CHOICES = "task.toml", "robot.urdf", "choices.toml"


def write_results(
    gait: Gait,
    request: Request,
    directory: Path,
    *,
    page: bool,
    figures: bool,
    worker: DrawingWorker | None = None,
) -> Iterator[Path]:
    """Write the gait and everything made from it; yield each as it is written.

    Args:
        worker: draws the page and the figures, but where there are both, no page with meshes.

    Raises:
        InputError: the directory cannot be written.
    """
    make_directory(directory)
    yield save_gait(gait, directory / GAIT)
    here, worker = DrawingWorker(), worker or DrawingWorker()
    alone = figures and "<mesh" in gait.urdf  # to simplify meshes takes longer than to draw figures
    paged = worker.begin(draw_page, gait) if page and figures and not alone else None
    drawn = worker.begin(draw_figures, gait, directory / FIGURES) if figures else None
    yield write_record(summarise(gait), directory / SUMMARY)
    yield write_atomically(directory / URDF, gait.urdf.encode())
    yield write_atomically(directory / CHOICES, choices_text(request.robot.choices).encode())
    yield write_atomically(directory / TASK, task_text(request, directory).encode())
    if page:
        if paged is None:
            paged = (here if alone else worker).begin(draw_page, gait, worker.simplify_rest())
        yield write_atomically(directory / PAGE, paged().encode())
    if drawn is not None:
        drawn()
        yield directory / FIGURES


def save_elsewhere(gait: Gait) -> Path | None:
    """Keep a gait that cannot be written where it should be, in the first place that takes it."""
    name = f"gaitopt-{os.urandom(4).hex()}.npz"
    for folder in (tempfile.gettempdir(), os.curdir):
        with suppress(InputError, OSError):
            return save_gait(gait, Path(folder).absolute() / name)
    return None


def write_record(record: Mapping[str, object], path: Path) -> Path:
    """Write figures as JSON, atomically."""
    text = json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False)
    return write_atomically(path, f"{text}\n".encode())


def task_text(request: Request, directory: Path) -> str:
    """Return a configuration that asks for the same again, defaults written out.

    What has no effect on the walk is left out: it would be refused.
    """
    task = request.task
    sections: dict[str, Settings] = {
        "task": {
            "preset": request.settings["preset"],
            **_known(task, "task"),
            **_fields(task.terrain),
        },
        "margins": {n: NO_LIMIT if (v := task.margin(n)) is None else v for n in task.declared},
        "cost": {"cost": task.cost.name, **_fields(task.cost)},
        "geometry": _geometry(task),
        "robot": {"urdf": URDF, "choices": CHOICES},
        "solver": {n: v for n, v in request.settings.items() if n in SCHEMA["solver"]},
    }
    solver = sections["solver"]
    solver |= {"refine": request.options.refine, "differences": request.options.differences}
    if "start" in solver:
        solver["start"] = _relative(solver["start"], directory)
    for section in sections.values():
        for name in list(idle(section, task, request.robot)):
            del section[name]
    for table in ("motors", "linkages"):
        if table in request.settings:
            sections["robot"][table] = _relative(request.settings[table], directory)
    if "plugin" in request.settings:
        sections["plugin"] = {"plugin": _relative(request.settings["plugin"], directory)}
    return f"# gaitopt optimise --config {TASK} --output again\n\n{tomli_w.dumps(sections)}"


def _relative(path: object, directory: Path) -> str:
    return Path(os.path.relpath(Path(str(path)).absolute(), directory.absolute())).as_posix()


def _fields(cost: Cost | Terrain | None) -> Settings:
    """Return the values of settings that say something, of a cost or a terrain, if any."""
    if isinstance(cost, WeightedSum):
        return {name: value for term, _ in cost.terms for name, value in _fields(term).items()}
    names: list[str] = [one.name for one in declared(type(cost))] if is_dataclass(cost) else []
    return {name: value for name in names if (value := getattr(cost, name)) not in (None, {}, ())}


def _known(owner: Task, section: str) -> Settings:
    """Return the values of a section's names that an object has."""
    values = {name: getattr(owner, name, None) for name in SCHEMA[section]}
    return {name: value for name, value in values.items() if value is not None}


def _geometry(task: Task) -> Settings:
    fixed = [q for q in task.geometry if not q.free and q.name != "duration"]
    return {
        "free": [q.name for q in task.geometry if q.free],
        "fix": {q.name: q.value for q in fixed},
    }


def require_writable(directory: Path, option: str = "--output") -> None:
    """Check, before any work and leaving no trace, that a directory can be made and written.

    Args:
        directory: which need not exist.
        option: that names it, for the error.

    Raises:
        InputError: it cannot.
    """
    whole = directory.absolute()
    missing = [path for path in (whole, *whole.parents) if not exists(path)]
    nearest = missing[-1].parent if missing else whole
    try:
        if not isdir(nearest):
            raise NotADirectoryError
        whole.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=whole):
            pass
    except (OSError, ValueError) as error:
        reason = f"in '{nearest}': {reason_of(error)}"
        if not isdir(nearest):
            reason = f"'{nearest}' is a file"
        raise InputError(
            f"cannot write to '{directory}': {reason}; give another {option} directory"
        ) from error
    finally:
        for path in missing:
            with suppress(OSError):
                path.rmdir()


def keep_files(
    directory: Path, results: Sequence[str], read: Iterable[object], begins: str = ""
) -> None:
    """Check, before any work, that no result takes the place of a file of the user's.

    Args:
        results: their names; where the first one is, an earlier run wrote them, and they are
            replaced.
        begins: how the first one begins if an earlier run wrote it, where its name does not tell.
        read: paths of files that the command reads, which are kept whoever wrote them; what is no
            path is passed over.

    Raises:
        InputError: one would.
    """
    mark = directory / results[0]
    earlier = exists(mark)
    if earlier and begins:
        with suppress(OSError), mark.open("rb") as stream:
            earlier = stream.read(len(begins)) == begins.encode()
    for path in (directory / name for name in results):
        reason = "" if earlier else "which no earlier run wrote"
        for one in read:
            with suppress(OSError, ValueError):  # told where it is read
                if isinstance(one, Path) and path.samefile(one):
                    reason = "which is read"
        if reason and exists(path):
            raise InputError(
                f"--output {directory}: a result would replace '{path}', {reason}; give another "
                "directory, or move the file"
            )


def require_files(*files: tuple[Path | None, str]) -> None:
    """Check, before any work, that files can be written.

    Args:
        files: each with the option that names it; None where none is asked for.

    Raises:
        InputError: a directory is not there or cannot be written, the file is a directory, or two
            are the same.
    """
    taken: dict[Path, str] = {}
    for path, option in files:
        if path is None:
            continue
        if (other := taken.setdefault(Path(realpath(path)), option)) != option:
            raise InputError(
                f"{option} {path}: {other} is to write the same file; give two file names"
            )
        folder = Path(realpath(path)).parent  # a link is followed, not replaced
        reason = taken_by(path)
        if reason or not isdir(folder):
            reason = reason or f"there is no directory '{folder}'"
            raise InputError(f"{option} {path}: cannot write it: {reason}; give another file name")
        require_writable(folder, option)
