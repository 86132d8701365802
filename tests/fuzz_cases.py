"""One mutation by its number: the input, what is done with it, and what came of it.

Nothing here knows of processes; `benchmarks/fuzz.py` runs thousands in processes that may die, and
the test suite a few in its own. A case is made from the seed and its number alone.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import resource
import shutil
import sqlite3
import subprocess
import sys
import traceback
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
from input_mutations import (
    mutate_bytes,
    mutate_json_lines,
    mutate_mjcf,
    mutate_npz,
    mutate_toml,
    mutate_words,
    tomllib,
)
from mjcf_generator import write_random_mjcf
from places import CASES, ROOT
from urdf_mutations import mutate_urdf, pick

from gaitopt.atomic import is_leftover
from gaitopt.bounds import STARTS
from gaitopt.errors import GaitoptError

SHARES = {
    "URDF": 30, "MJCF": 24, "task": 8, "choices": 8, "specification": 6, "catalogue": 2,
    "gait file": 10, "library": 6, "arguments": 6,
}  # fmt: skip
"""Kinds of input, and how many of a hundred mutations are of each."""
_ENDS = {".html": b"</html>\n", ".svg": b"</svg>\n", ".csv": b"\n", ".jsonl": b"\n"}
EXIT_CODES = (0, 1, 2, 3, 130)
TOLERANCE = 1e-9  # relative, of what MuJoCo and the model say
_KINDS = tuple(kind for kind, share in SHARES.items() for _ in range(share))
_URDFS = ("base_mini", "urdf_damping_friction", "unnamed_material", "urdf_transmission_rotor")
_MJCFS = (
    "base_mini", "b_planar_root_joints", "mj_root6", "mjcf_damping_stiffness", "mjcf_frame",
    "mjcf_general_fixed_gain", "mjcf_gravcomp", "mjcf_gravity", "mjcf_inertiagrouprange",
    "mjcf_joint_ref", "mjcf_saved_by_mujoco_motor_general", "default_joint_ref",
)  # fmt: skip
_QUICK = "--samples 9 --no-refine --no-page --no-figures --starts 1 --max-iterations 4 --solver sqp"
_NOISE = re.compile(
    r"Traceback|^\w*(?:Error|Warning|Exception)\b|\.py:\d+|\.(?:cpp|hpp|cc|h):\d+|terminate called|"
    r"\[(?:ERROR|WARN)|^WARNING|urdfdom|object at 0x|Segmentation",
    re.MULTILINE,
)
"""What a library or Python itself would say."""


@dataclass
class Outcome:
    """What came of a mutation.

    Attributes:
        kind: of its input.
        result: "refused", "read", or what else is no fault.
        findings: what must not be, in words; empty where all is well.
        message: of a refusal.
        notes: what is told without being a fault, as what MuJoCo reads otherwise.
        seconds: of processor, of this process and its children.
    """

    kind: str
    result: str = "read"
    findings: list[str] = field(default_factory=list)
    message: str = ""
    notes: list[str] = field(default_factory=list)
    seconds: float = 0.0


def prepare(folder: Path) -> None:
    """Make the inputs that are mutated: a walk, a library, a task, choices, a specification."""
    from gaitopt import Robot, biped13, design_gait, preset_task, save_gait, urdf_text, write_spec
    from gaitopt.cli.request import choices_text
    from gaitopt.design.options import DesignOptions
    from gaitopt.solvers import solver_by_name
    from gaitopt.sweep.grid import Axis
    from gaitopt.sweep.scheduler import sweep

    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.urdf").write_text(urdf_text(biped13()), encoding="utf-8")
    write_spec(biped13(), folder / "spec.toml")
    robot = Robot.from_urdf(urdf_text(biped13()))
    (folder / "choices.toml").write_text(
        choices_text(robot.choices)
        + '\n[[limits]]\njoints = "*knee*"\ntorque = 90.0\nspeed = "none"\n'
        + '[[inertias]]\nlinks = "*foot*"\nmass = 0.9\n',
        encoding="utf-8",
    )
    (folder / "task.toml").write_text(_TASK, encoding="utf-8")
    options = DesignOptions(solver=solver_by_name("sqp"), refine=False, diagnose=False)
    task = preset_task(speed=1.0, samples=15)
    save_gait(design_gait(robot, task, options).gait, folder / "gait.npz")
    sweep(robot, task, [Axis("speed", (1.0, 1.05))], folder / "lib", options)


_TASK = """
[task]
preset = "standard"
speed = 0.8
duration = 0.45
postures = 2
samples = 15
quadrature = "simpson"
penalty_weight = 1e6
[margins]
torque_limit = 120.0
friction = 0.6
cop_margin = 0.005
clearance = 0.01
joint_range = true
trunk_pitch = 0.3
[geometry]
free = ["duration", "pelvis_roll"]
fix = { pelvis_yaw = 0.0 }
[robot]
urdf = "robot.urdf"
choices = "choices.toml"
without = ["friction"]
armature = { "*knee*" = 0.02 }
[solver]
solver = "sqp"
tolerance = 1e-6
max_iterations = 4
starts = 1
refine = false
"""


def kind_of(number: int) -> str:
    """Return the kind of input of a mutation; any hundred in a row have their shares."""
    return _KINDS[(number * 37) % 100]


def run_case(number: int, seed: int, inputs: Path, folder: Path) -> Outcome:
    """Make a mutation in an empty folder, put it through gaitopt, and judge what comes of it.

    Args:
        number: of the mutation.
        seed: of all mutations.
        inputs: what `prepare` made.
        folder: an empty one.
    """
    rng, kind = np.random.default_rng([seed, number]), kind_of(number)
    outcome, before = Outcome(kind), _cpu()
    command = number // 100 % 100 == number % 100
    given = _GIVEN[kind](rng, inputs, folder)
    known = {p: p.stat().st_size for p in folder.rglob("*")}
    where = os.getcwd()
    try:
        os.chdir(folder)
        with warnings.catch_warnings(), _expected(outcome):
            warnings.simplefilter("error")
            if command:
                _through_command(kind, given, outcome)
            else:
                _TRIED[kind](given, rng, outcome, number)
    finally:
        os.chdir(where)
    outcome.seconds = _cpu() - before
    outcome.findings += _half_written(folder, known)
    return outcome


def _cpu() -> float:
    usages = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


@contextlib.contextmanager
def _expected(outcome: Outcome):
    """Take the package's own errors as refusals, and every other as a finding."""
    try:
        yield
    except GaitoptError as error:
        outcome.result, outcome.message = "refused", str(error)
        if not str(error).strip() or _NOISE.search(str(error)):
            outcome.findings.append(f"message: {str(error)[:300]!r}")
    except BaseException as error:
        frames = traceback.extract_tb(error.__traceback__)
        own = [f for f in frames if f"{os.sep}gaitopt{os.sep}" in f.filename] or frames
        place = f"{Path(own[-1].filename).name}:{own[-1].name}"
        outcome.result = "exception"
        outcome.findings.append(f"exception: {type(error).__name__} in {place}: {str(error)[:300]}")


def _half_written(folder: Path, known: dict[Path, int]) -> list[str]:
    found = []
    for path in sorted(set(folder.rglob("*")) - set(known)):
        if path.is_file() and (fault := _fault_of(path)):
            found.append(f"file: {path.relative_to(folder)}: {fault}")
    return found


def _fault_of(path: Path) -> str:
    """Return why a file that was written is not whole; empty where it is."""
    if is_leftover(path):
        return "left over"
    if path.name == "MUJOCO_LOG.TXT":
        return "written by MuJoCo"
    data = path.read_bytes()
    try:
        if path.suffix == ".npz":
            with np.load(io.BytesIO(data)) as content:
                _ = [content[name] for name in content.files]
        elif path.suffix == ".json":
            json.loads(data)
        elif path.suffix == ".toml":
            tomllib.loads(data.decode())
        elif path.suffix == ".urdf":
            ET.fromstring(data.decode())
        elif data and not data.endswith(_ENDS.get(path.suffix, b"")):
            return "cut off"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""


# What is given: a mutated file, or words.


def _write(path: Path, data: bytes | str, rng: np.random.Generator) -> Path:
    data = data.encode("utf-8", "surrogatepass") if isinstance(data, str) else data
    path.write_bytes(mutate_bytes(data, rng) if rng.random() < 0.03 else data)
    return path


def _times(rng) -> int:
    return int(rng.choice([1, 1, 1, 2, 3]))


def _urdf(rng, inputs: Path, folder: Path) -> Path:
    name = pick((*_URDFS, "biped13", "biped13"), rng)
    path = inputs / "robot.urdf" if name == "biped13" else CASES / f"{name}.urdf"
    text = mutate_urdf(path.read_text(encoding="utf-8"), rng, _times(rng))
    return _write(folder / "robot.urdf", text, rng)


def _mjcf(rng, inputs: Path, folder: Path) -> Path:
    del inputs
    if rng.random() < 0.35:
        path = write_random_mjcf(folder, int(rng.integers(100_000)))
    else:
        path = CASES / f"{pick(_MJCFS, rng)}.xml"
    text = mutate_mjcf(path.read_text(encoding="utf-8"), rng, _times(rng))
    return _write(folder / "robot.xml", text, rng)


_NAMES = {
    "task.toml": (
        "speed", "samples", "boundary", "speed_as", "leg_gap", "arm_gap", "step_width",
        "forward", "posture", "srdf", "stance_sole", "package_dir", "spec", "robot", "approach",
        "differences", "qp_solver", "seed", "sigma", "start", "penalty_weight", "impulse_cop",
        "quadrature", "minimum_load", "sole", "swing_tilt",
        "leg_extension", "liftoff_speed", "torsional_friction",
    ),
    "choices.toml": (
        "feet", "stance", "forward", "up", "posture", "srdf", "sole", "sole_drop", "unequal_limits",
        "sole_placements", "limits", "inertias", "without", "package_dirs", "rotors", "capsules",
        "asymmetry", "joints", "torque", "speed", "lower", "upper", "armature", "links", "mass",
        "arm_capsules",
    ),
    "spec.toml": ("name", "inertia", "size", "mass", "com", "lower", "upper", "torque", "geometry"),
    "entry.toml": ("title", "mass", "file", "choices", "task", "rotors", "spec", "remark"),
}  # fmt: skip


def _toml(name: str) -> Callable[..., Path]:
    def given(rng, inputs: Path, folder: Path) -> Path:
        for file in ("robot.urdf", "choices.toml"):
            shutil.copy(inputs / file, folder / file)
        if name == "entry.toml":
            from importlib import resources

            entries = resources.files("gaitopt.catalogue")
            entry = pick(sorted(p.name for p in entries.iterdir() if p.name.endswith("toml")), rng)
            text = (entries / entry).read_text(encoding="utf-8")
        else:
            text = (inputs / name).read_text(encoding="utf-8")
        path = folder / name
        path.write_bytes(mutate_toml(text, rng, _times(rng), _NAMES[name]))
        return path

    return given


def _gait_file(rng, inputs: Path, folder: Path) -> Path:
    path = folder / "gait.npz"
    path.write_bytes(mutate_npz((inputs / "gait.npz").read_bytes(), rng))
    return path


def _library(rng, inputs: Path, folder: Path) -> Path:
    library = folder / "lib"
    shutil.copytree(inputs / "lib", library)
    names = ["library.sqlite", "library.sqlite", "library.sqlite", "index.csv", "gaits"]
    name = pick(names, rng)
    path = pick(sorted((library / name).iterdir()), rng) if name == "gaits" else library / name
    if rng.random() < 0.08:
        path.unlink()
    elif name == "gaits":
        path.write_bytes(mutate_npz(path.read_bytes(), rng))
    elif name == "index.csv" or rng.random() < 0.15:
        path.write_bytes(mutate_bytes(path.read_bytes(), rng))
    else:
        _mutate_records(path, rng)
    return library


def _mutate_records(path: Path, rng) -> None:
    """Change records of a database; their digests are right mostly."""
    from gaitopt.sweep.database import record_digest

    with contextlib.closing(sqlite3.connect(path)) as connection, connection:
        known = connection.execute("SELECT name, record FROM points").fetchall()
        known += [("", *row) for row in connection.execute("SELECT record FROM manifest")]
        for _ in range(_times(rng)):
            name, text = pick(known, rng)
            with contextlib.suppress(ValueError, IndexError, RecursionError):
                line = mutate_json_lines(text.encode() + b"\n", rng, ("walk", "row", "tried"))
                text = line.decode(errors="replace").rstrip("\n")
            check = record_digest(name, text) if rng.random() < 0.8 else ""
            where = f"points SET record = ?, digest = ? WHERE name = {name!r}"
            if not name:
                where = "manifest SET record = ?, digest = ?"
            connection.execute(f"UPDATE {where}", (text, check))


_COMMANDS = (
    "inspect --urdf robot.urdf",
    "inspect --urdf robot.urdf --choices choices.toml --html out.html --write-choices out.toml",
    "inspect --spec spec.toml --forward +x --sole 0.1,-0.1,0.05,-0.05",
    "inspect --robot biped13 --without friction --armature *knee*=0.01",
    "urdf --spec spec.toml --output out.urdf",
    "urdf --write-spec out.toml",
    "robots",
    "check gait.npz",
    "export gait.npz --output out.csv --both-legs",
    "export gait.npz --output out.json",
    "export gait.npz --format motion --rate 20 --joints mujoco --output out.npz",
    "export gait.npz --format bezier --output out.yaml",
    "export lib --format csv --strides 1.5 --joints isaac --output out",
    "play gait.npz --html out.html --steps 2 --package-dir .",
    "library lib",
    "library lib --where speed>1.0 --columns cost,friction_used",
    "library lib --at speed=1.02 --output out.npz",
    f"optimise --speed 1.0 {_QUICK} --output out",
    f"optimise --config task.toml --duration 0.4 {_QUICK} --output out",
    f"optimise --urdf robot.urdf --fix pelvis_yaw=0.0 --free duration {_QUICK} --output out",
    "sweep --speeds 1.0:1.05:0.05 --grid duration=0.4,0.42 --workers 1 --no-refine --samples 9 "
    "--solver sqp --output taken",
)
_OPTIONS = (
    "--speed", "--duration", "--preset", "--speed-as", "--penalty-weight", "--boundary", "--free",
    "--fix", "--postures", "--samples", "--quadrature", "--torque-limit", "--speed-limit",
    "--friction", "--clearance", "--knee-flexion", "--joint-range", "--trunk-pitch", "--step-width",
    "--leg-gap", "--swing-tilt", "--robot", "--urdf", "--spec", "--choices", "--package-dir",
    "--forward", "--posture", "--srdf", "--sole", "--stance-sole", "--without", "--armature",
    "--solver", "--qp-solver", "--tolerance", "--differences", "--approach", "--start", "--seed",
    "--sigma", "--config", "--output", "--quiet", "--html", "--write-choices", "--where", "--at",
    "--columns", "--plot", "--grid", "--begin", "--steps", "--both-legs", "--formats", "--help",
    "--version", "-o", "-h", "--write-spec", "--no-refine", "--nonsense", "-x",
)  # fmt: skip


def _words(rng, inputs: Path, folder: Path) -> list[str]:
    for path in inputs.iterdir():
        (shutil.copytree if path.is_dir() else shutil.copy)(path, folder / path.name)
    (folder / "taken").write_text("a file where a directory is wanted\n", encoding="utf-8")
    words = mutate_words(str(pick(_COMMANDS, rng)).split(), rng, _OPTIONS)
    for place, word in enumerate(words[1:], 1):
        if words[place - 1] == "--starts" and word.isascii() and word.isdigit():
            # As many solves are what is asked for, up to the bound, each of which takes its time.
            words[place] = "20" if 20 < int(word) <= STARTS else word
    if words and words[0] == "play" and "--html" not in words[:-1]:
        words += ["--html", "out.html"]  # else it serves until it is ended
    return words


_GIVEN: dict[str, Callable[..., Any]] = {
    "URDF": _urdf, "MJCF": _mjcf, "task": _toml("task.toml"), "choices": _toml("choices.toml"),
    "specification": _toml("spec.toml"), "catalogue": _toml("entry.toml"),
    "gait file": _gait_file, "library": _library, "arguments": _words,
}  # fmt: skip


# What is done with it.


def _try_urdf(path: Path, rng, outcome: Outcome, number: int) -> None:
    from urdf_oracle import differences_from_mujoco, differences_from_text, mujoco_of_urdf

    source = _read(path)
    outcome.result = "read, as a second reader"
    outcome.findings += [f"difference: {d}" for d in differences_from_text(source, rng)]
    try:
        m = _silently(lambda: mujoco_of_urdf(source.text))
    except Exception as error:
        outcome.notes.append(f"MuJoCo refuses: {str(error).splitlines()[0][:80]}")
    else:
        other = _silently(lambda: differences_from_mujoco(source, m, rng))
        outcome.result = "read, as MuJoCo" if not other else outcome.result
        outcome.notes += [f"MuJoCo reads otherwise: {d}" for d in other]
    _try_robot(path, None, number, outcome)


def _try_mjcf(path: Path, rng, outcome: Outcome, number: int) -> None:
    from mjcf_oracle import compare_models, silently_compiled

    source = _read(path)
    try:
        m = silently_compiled(path)
    except Exception as error:
        # Meshes that the masses do not need may be missing; then there is nothing to compare.
        outcome.notes.append(f"MuJoCo refuses: {str(error).splitlines()[0][:80]}")
    else:
        drawn = int(rng.integers(2**31))
        worst = _silently(lambda: compare_models(source, m, drawn, 1)).worst
        wrong = {q: v for q, v in worst.items() if not v <= TOLERANCE and "single" not in q}
        outcome.findings += [f"difference: {q} by {v:.1e}" for q, v in wrong.items()]
        outcome.result = "read, as MuJoCo"
    _try_robot(path, None, number, outcome)


def _silently(compiled: Callable[[], Any]) -> Any:
    import mujoco

    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: None)
    try:
        return compiled()
    finally:
        mujoco.set_mju_user_warning(before)


def _read(path: Path):
    from gaitopt.importers.reader import read_source

    source = read_source(path)
    source.model()
    for kind in (pin.GeometryType.VISUAL, pin.GeometryType.COLLISION):
        source.geometry(kind)
    source.mesh_problems()
    source.findings()
    _ = source.physics
    return source


def _try_robot(path: Path | str, choices, number: int, outcome: Outcome) -> None:
    """Make the robot; of some, a page or a short design."""
    from gaitopt import Robot
    from gaitopt.model.import_options import ImportOptions
    from gaitopt.view.inspection import inspect_robot

    if number % 7 == 0:
        inspect_robot(path, choices or ImportOptions())
    try:
        robot = Robot.from_urdf(path, choices=choices)
    except GaitoptError as error:
        outcome.message = str(error)
        if _NOISE.search(str(error)):
            outcome.findings.append(f"message: {str(error)[:300]!r}")
        return
    outcome.result += ", a biped"
    if number % 11 == 0:
        _saved_and_read(robot, outcome)
    if number % 53 == 0:
        _short_design(robot)
        outcome.result += ", a short design"


def _saved_and_read(robot, outcome: Outcome) -> None:
    """What is designed for a robot must be read again."""
    from first_walks import first_walk

    from gaitopt import load_gait, save_gait

    try:
        gait = first_walk(robot)
    except GaitoptError as error:
        outcome.message = str(error)
        return
    path = save_gait(gait, Path("walk.npz"))
    try:
        load_gait(path)
    except GaitoptError as error:
        outcome.findings.append(f"a walk that is not read: {error}")
    path.unlink()


def _short_design(robot) -> None:
    from gaitopt import design_gait
    from gaitopt.design.options import DesignOptions
    from gaitopt.gait.presets import humanoid_task
    from gaitopt.solvers import solver_by_name

    solver = replace(solver_by_name("sqp"), max_iterations=5)
    options = DesignOptions(solver=solver, refine=False, diagnose=False)
    design_gait(robot, humanoid_task(robot, speed=0.4, samples=9), options)


def _try_task(path: Path, rng, outcome: Outcome, number: int) -> None:
    from gaitopt.cli.request import make_request

    del rng
    request = make_request({}, path)
    if number % 31 == 0:
        from gaitopt import design_gait

        solver = request.options.solver
        if hasattr(solver, "max_iterations"):
            solver = replace(solver, max_iterations=4)
        design_gait(request.robot, request.task, replace(request.options, solver=solver))
        outcome.result = "read, a short design"


def _try_choices(path: Path, rng, outcome: Outcome, number: int) -> None:
    from gaitopt.model.import_options import choices_from_record, choices_from_toml, choices_record

    del rng
    choices = choices_from_toml(path)
    record = choices_record(choices)
    again = choices_from_record(json.loads(json.dumps(record, allow_nan=False)))
    if choices_record(again) != record:
        outcome.findings.append("difference: choices change on the way through their record")
    _try_robot(path.parent / "robot.urdf", choices, number, outcome)


def _try_spec(path: Path, rng, outcome: Outcome, number: int) -> None:
    from gaitopt import read_spec, urdf_text
    from gaitopt.catalogue.parameters import spec_text

    del rng
    spec = read_spec(path)
    copy = path.parent / "again.toml"
    copy.write_text(spec_text(spec), encoding="utf-8")
    if read_spec(copy) != spec:
        outcome.findings.append("difference: the specification changes on the way through a file")
    copy.unlink()
    _try_robot(urdf_text(spec), None, number, outcome)


def _try_entry(path: Path, rng, outcome: Outcome, number: int) -> None:
    from gaitopt.catalogue.entries import description, read_entry
    from gaitopt.errors import MissingExtraError

    del rng, number, outcome
    entry = read_entry("mutated", path.read_bytes())
    with contextlib.suppress(MissingExtraError):
        description(entry)


def _try_gait(path: Path, rng, outcome: Outcome, number: int) -> None:
    from gaitopt import audit, export, load_gait, summarise
    from gaitopt.cli.display import screen
    from gaitopt.cli.report import print_findings_of, print_gait

    del rng
    gait = load_gait(path)
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        print_findings_of(gait)
        print_gait(screen(), gait)
    json.dumps(summarise(gait), allow_nan=False)
    for suffix in (".csv", ".json"):
        with contextlib.suppress(GaitoptError):
            export(gait, path.with_suffix(suffix), both_legs=bool(number % 2))
    if number % 3 == 0:
        from gaitopt import write_page

        with contextlib.suppress(GaitoptError):
            write_page(gait, path.with_suffix(".html"))
    found = audit(gait)
    outcome.result = "read, certified" if found.passed else "read, not as it says"


def _try_library(directory: Path, rng, outcome: Outcome, number: int) -> None:
    from gaitopt.cli.command_options import LibraryOptions
    from gaitopt.cli.library import run
    from gaitopt.sweep.library import Writer, open_library

    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        run(LibraryOptions(directory=(directory,)))
    library = open_library(directory)
    for point in library.grid.order:
        with contextlib.suppress(GaitoptError):
            library.gait(point)
    if number % 5 == 0:
        from gaitopt.sweep.interpolation import interpolate

        with contextlib.suppress(GaitoptError):
            interpolate(library, {"speed": float(rng.uniform(0.99, 1.06))})
    with Writer(directory, library.grid, library.record) as writer:
        writer.write_table()
    outcome.result = "read, with faults" if library.faults else "read"


def _try_words(words: list[str], rng, outcome: Outcome, number: int) -> None:
    """Run a command in this process; its streams are caught."""
    from gaitopt.cli.app import app

    del rng, number
    out, err = io.StringIO(), io.StringIO()
    code: object = 0
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            app(args=words, prog_name="gaitopt")
        except SystemExit as end:
            code = end.code or 0
    _judge_command(words, code, err.getvalue(), outcome)


_TRIED: dict[str, Callable[..., None]] = {
    "URDF": _try_urdf, "MJCF": _try_mjcf, "task": _try_task, "choices": _try_choices,
    "specification": _try_spec, "catalogue": _try_entry, "gait file": _try_gait,
    "library": _try_library, "arguments": _try_words,
}  # fmt: skip


def _through_command(kind: str, given, outcome: Outcome) -> None:
    """Run the command for an input as a process of its own."""
    name = "" if isinstance(given, list) else str(given)
    words: list[str] = {
        "URDF": ["inspect", "--urdf", name, "--html", "out.html"],
        "MJCF": ["inspect", "--urdf", name, "--write-choices", "out.toml"],
        "task": ["optimise", "--config", name, "--output", "out", *_QUICK.split()],
        "choices": ["inspect", "--urdf", "robot.urdf", "--choices", name],
        "specification": ["urdf", "--spec", name, "--output", "out.urdf"],
        "catalogue": ["robots"],
        "gait file": ["check", name],
        "library": ["library", name],
    }.get(kind) or [word.replace("\x00", "") for word in given]
    done = subprocess.run(
        [sys.executable, "-m", "gaitopt", *words],
        capture_output=True, timeout=400, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    _judge_command(words, done.returncode, done.stderr.decode("utf-8", "replace"), outcome)


def _judge_command(words: list[str], code: object, errors: str, outcome: Outcome) -> None:
    outcome.result, outcome.message = f"exit code {code}", errors[:300]
    if code not in EXIT_CODES:
        outcome.findings.append(f"exit code: {code} of {words}: {errors[-300:]}")
    if match := _NOISE.search(errors):
        outcome.findings.append(
            f"output: {errors[max(0, match.start() - 60) :][:300]!r} of {words}"
        )
    if code in (2, 3) and not errors.strip():
        outcome.findings.append(f"output: nothing is said of exit code {code} by {words}")
