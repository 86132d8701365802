import csv
import math
import os
import signal
import subprocess
import sys
import textwrap
import time
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sweeps import QUICK, SPEEDS, Counting, costs, gaits, quick_task, seconds

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.parameters import changed
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.design.design import design
from gaitopt.design.starts import many_starts
from gaitopt.errors import GaitFileError, GaitoptError, InputError
from gaitopt.gait.gait_file import load_gait
from gaitopt.model.import_options import ImportOptions, LimitOverride, Payload, choices_record
from gaitopt.model.robot import Robot
from gaitopt.model.sole import Sole
from gaitopt.solvers import solver_by_name
from gaitopt.sweep.database import Database
from gaitopt.sweep.executor import CONTINUE
from gaitopt.sweep.grid import Axis, RobotSource
from gaitopt.sweep.library import MISSING, open_library
from gaitopt.sweep.scheduler import sweep
from gaitopt.sweep.table import CERTIFIED, INFEASIBLE, NOT_COMPUTED, bare_row, write_table

HERE = Path(__file__).parent


def test_every_gait_is_as_good_as_one_from_a_first_guess(robot, swept):
    for speed, cost in costs(swept).items():
        cold = design(robot, quick_task(speed=speed), QUICK)
        assert cost <= cold.solution.cost * (1.0 + 1e-6)


def test_the_index_is_what_the_gaits_say(swept):
    with (swept.directory / "index.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert [float(line["speed"]) for line in lines] == list(SPEEDS.values)
    for point, line in zip(sorted(swept.grid.order), lines, strict=True):
        gait = load_gait(swept.directory / line["file"])
        assert float(line["cost"]) == pytest.approx(gait.cost, rel=1e-12)
        assert gait.speed == pytest.approx(float(line["speed"]), rel=1e-6)
        assert float(line["kkt"]) < 1e-6
        assert gait.fact("sweep", "values") == swept.grid.values(point)
        peaks = [float(v) for k, v in line.items() if k.startswith("peak_torque.")]
        assert len(peaks) == 6
        assert max(peaks) == pytest.approx(abs(gait.torque).max(), rel=1e-9)


def test_the_index_opens_as_parquet(swept):
    parquet = pytest.importorskip("pyarrow.parquet", reason="the extra 'tables' is not installed")
    table = parquet.read_table(swept.directory / "index.parquet")
    assert table["cost"].to_pylist() == [row["cost"] for row in swept.rows]


def test_a_parquet_index_without_gaits_has_its_columns(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="the extra 'tables' is not installed")
    rows = [bare_row({"speed": speed}, NOT_COMPUTED, "") for speed in (0.8, 0.9)]
    write_table(rows, tmp_path)
    table = parquet.read_table(tmp_path / "index.parquet")
    assert table["speed"].to_pylist() == [0.8, 0.9]
    assert str(table.schema.field("cost").type) == "double"
    assert str(table.schema.field("origin").type) == "string"


def test_a_parquet_index_has_values_and_types_of_the_rows(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="the extra 'tables' is not installed")
    rows = [
        {
            "speed": 1.0,
            "status": "certified",
            "certified": True,
            "iterations": 3,
            "cost": 1.0 / 3.0,
        },
        {"speed": 2, "status": "not computed", "verdict": 'says "no",\nand why', "kkt": math.inf},
    ]
    write_table(rows, tmp_path)
    table = parquet.read_table(tmp_path / "index.parquet")
    assert table.to_pylist() == [{n: row.get(n) for n in table.column_names} for row in rows]
    kinds = {name: str(table.schema.field(name).type) for name in table.column_names}
    assert kinds.pop("certified") == "bool"
    assert kinds.pop("iterations") == "int64"
    assert (kinds.pop("status"), kinds.pop("verdict")) == ("string", "string")
    assert set(kinds.values()) == {"double"}


def test_slopes_foretell_the_next_cost(swept):
    """Along a branch: of neighbours one of which came from the other."""
    followed = 0
    for left, right in zip(swept.rows, swept.rows[1:], strict=False):
        names = {f"speed={row['speed']:.10g}" for row in (left, right)}
        if names & {left["origin"], right["origin"]}:
            rise = 0.5 * (left["slope.speed"] + right["slope.speed"]) * 0.05
            assert right["cost"] - left["cost"] == pytest.approx(rise, rel=0.1)
            followed += 1
    assert followed >= 2


def test_an_interrupted_sweep_goes_on_and_computes_nothing_twice(
    robot, swept, swept_jobs, tmp_path
):
    with Counting(most=6) as before, pytest.raises(KeyboardInterrupt):
        sweep(robot, quick_task(), [SPEEDS], tmp_path / "part", QUICK)
    with Counting() as after:
        library = sweep(robot, quick_task(), [SPEEDS], tmp_path / "part", QUICK)
    assert len(before.done) == 6
    assert len(before.done) + len(after.done) == len(swept_jobs)
    assert costs(library) == pytest.approx(costs(swept), rel=1e-9)
    with Counting() as again:
        sweep(robot, quick_task(), [SPEEDS], tmp_path / "part", QUICK)
    assert again.done == []


def test_a_library_is_not_mixed_with_another(robot, swept):
    with pytest.raises(InputError, match=r"limit friction is 0\.7, asked for is 0\.6"):
        sweep(robot, quick_task(friction=0.6), [SPEEDS], swept.directory, QUICK)
    other = Axis("speed", (0.95, 1.0))
    with pytest.raises(InputError, match="its values of speed are"):
        sweep(robot, quick_task(), [other], swept.directory, QUICK)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"axes": SPEEDS}, "give a list of Axis"),
        ({"axes": ["speed"]}, "give a list of Axis"),
        ({"axes": 3}, "give a list of Axis"),
        ({"robot": None}, "robot is None; give a Robot"),
        ({"task": "fast"}, "task is 'fast'; give a Task"),
        ({"directory": 3}, "directory is 3; give a text or a path"),
        ({"options": 3}, "options is 3; give DesignOptions"),
        ({"spec": "biped13"}, "spec is 'biped13'; give a BipedSpec"),
    ],
)
def test_what_cannot_be_swept_is_refused(robot, tmp_path, changes, said):
    good = {"robot": robot, "task": quick_task(), "axes": [SPEEDS], "directory": tmp_path / "l"}
    with pytest.raises(InputError, match=said):
        sweep(**(good | changes))
    assert not (tmp_path / "l").exists()


def test_a_directory_with_other_things_is_left_alone(robot, tmp_path):
    (tmp_path / "thesis.tex").write_text("x")
    with pytest.raises(InputError, match=r"holds 'thesis\.tex' but no sweep"):
        sweep(robot, quick_task(), [SPEEDS], tmp_path, QUICK)
    assert [p.name for p in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_point_without_a_gait_is_explained(robot, tmp_path):
    axis = Axis("cop_margin", (0.02, 0.08))  # the sole is 0.14 m wide
    solver = solver_by_name("sqp", max_iterations=60)
    options = replace(QUICK, solver=solver, diagnose=True)
    library = sweep(robot, quick_task(), [axis], tmp_path / "l", options, seed={"cop_margin": 0.0})
    assert [row["status"] for row in library.rows] == [CERTIFIED, INFEASIBLE] or [
        row["status"] for row in library.rows
    ] == ["not certified", INFEASIBLE]
    said = library.states[(1,)].refusal["sentences"]
    assert any("0.08 m from every edge leaves no room" in sentence for sentence in said)


def test_entries_of_a_specification_can_be_swept(robot, tmp_path):
    axis = Axis("links.torso.mass", (38.0, 40.55))
    library = sweep(robot, quick_task(), [axis], tmp_path / "l", QUICK, spec=biped13())
    light, heavy = library.rows
    assert light["cost"] < heavy["cost"]
    gaits = [library.gait(point) for point in sorted(library.grid.order)]
    difference = gaits[1].number("mass") - gaits[0].number("mass")
    assert difference == pytest.approx(2.55, rel=1e-9)
    slope = 0.5 * (light["slope.links.torso.mass"] + heavy["slope.links.torso.mass"])
    assert heavy["cost"] - light["cost"] == pytest.approx(2.55 * slope, rel=0.05)


@pytest.mark.parametrize(
    "given",
    [
        {"limits": (LimitOverride("knee", speed=7.0),), "gravity": 1.62},
        {"payloads": (Payload("torso", 4.0), Payload("pelvis", 1.0, (0.1, 0.0, 0.2)))},
        {"sole": Sole(toe=0.01, heel=-0.15, left=0.04, right=-0.05)},
    ],
)
def test_what_was_chosen_about_a_robot_holds_for_every_specification(given):
    asked, changes = ImportOptions(**given), {"foot_length": 0.25, "trunk_height": 0.5}
    base = Robot.from_urdf(urdf_text(biped13()), choices=asked)
    found = RobotSource(base.urdf, base.choices, biped13(), tuple(changes.items())).build()
    alone = Robot.from_urdf(urdf_text(changed(biped13(), changes)), choices=asked)
    assert choices_record(found.choices) == choices_record(alone.choices)
    assert found.sole == alone.sole
    assert (found.sole != base.sole) == ("sole" not in given)  # the foot is longer
    np.testing.assert_array_equal(found.limits.speed, alone.limits.speed)
    for own, other in zip(found.model.inertias, alone.model.inertias, strict=True):
        np.testing.assert_allclose(
            own.toDynamicParameters(), other.toDynamicParameters(), rtol=1e-12, atol=1e-14
        )


def test_a_limit_that_bounds_a_parameter_has_its_price_too(robot, tmp_path):
    axis = Axis("step_width", (0.165, 0.17))
    narrow, wide = sweep(robot, quick_task(), [axis], tmp_path / "l", QUICK).rows
    slope = 0.5 * (narrow["slope.step_width"] + wide["slope.step_width"])
    assert slope < -1000.0
    assert wide["cost"] - narrow["cost"] == pytest.approx(0.005 * slope, rel=0.02)


def test_a_specification_is_needed_for_that(robot, tmp_path):
    with pytest.raises(InputError, match="entry of a specification"):
        sweep(robot, quick_task(), [Axis("geometry.d3", (0.3, 0.31))], tmp_path, QUICK)


SCRIPT = """
    import resource, sys
    from pathlib import Path
    sys.path[:0] = [{tests!r}, {here!r}]
    from reference_cases import biped
    from sweeps import QUICK, SPEEDS, quick_task
    from gaitopt.errors import InputError
    from gaitopt.sweep import library
    from gaitopt.sweep.scheduler import sweep
    directory = Path({directory!r})
    if {full!r}:
        library.HELD = 0.0  # s: each result is written before the next, however quick the machine
    def fill(progress):
        limit = 0
        if {full!r} == "database":  # it holds one point and cannot grow, but a gait file fits
            limit = (directory / "library.sqlite").stat().st_size
        if {full!r} == "gait" and progress.stage == "finishing":  # the next is about as large
            limit = max(path.stat().st_size for path in directory.glob("gaits/*.npz")) // 2
        if limit:
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    try:
        sweep(biped(), quick_task(), [SPEEDS], directory, QUICK, on_progress=fill)
    except InputError as error:
        sys.exit(str(error))
"""


def script(directory: Path, full: str = "") -> list[str]:
    text = textwrap.dedent(SCRIPT).format(
        tests=str(HERE.parent), here=str(HERE), directory=str(directory), full=full
    )
    return [sys.executable, "-c", text]


@pytest.mark.skipif(os.name != "posix", reason="kill -9 is POSIX")
def test_kill_9_loses_at_most_the_work_in_flight(robot, swept, tmp_path):
    directory = tmp_path / "lib"
    process = subprocess.Popen(script(directory))
    deadline = time.monotonic() + 300.0
    while time.monotonic() < deadline and process.poll() is None:
        with suppress(GaitFileError):
            if sum(state.explored for state in open_library(directory).states.values()) >= 2:
                break
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    kept = {name for name, spent in seconds(directory).items() if spent > 0.0}
    assert len(kept) >= 2
    with Counting() as jobs:
        library = sweep(robot, quick_task(), [SPEEDS], directory, QUICK)
    first = [job for job in jobs.done if job.kind == CONTINUE and not job.cold_start]
    assert not [j for j in first if j.substeps and library.grid.name(j.point) in kept]
    assert costs(library) == pytest.approx(costs(swept), rel=1e-9)


@pytest.mark.skipif(os.name != "posix", reason="kill -9 is POSIX")
def test_kill_9_at_any_moment_leaves_a_library_that_opens_and_goes_on(robot, swept, tmp_path):
    """Killed again and again, a little later each time; whatever was known stays known."""
    directory, known = tmp_path / "lib", {}
    for attempt in range(6):
        process = subprocess.Popen(script(directory))
        wait = 0.15 * attempt
        while process.poll() is None and not (directory / "library.sqlite").exists():
            time.sleep(0.005)
        time.sleep(wait)
        process.kill()
        process.wait()
        with suppress(GaitFileError):  # killed before it had begun
            library = open_library(directory)
            assert not [f for f in library.faults.values() if f != MISSING]
            now = {point: state.seconds for point, state in library.states.items()}
            assert all(now[point] >= spent for point, spent in known.items())
            known = now
    library = sweep(robot, quick_task(), [SPEEDS], directory, QUICK)
    found = gaits(directory)
    assert len(found) == len(SPEEDS.values)
    assert found == gaits(swept.directory)
    assert costs(library) == costs(swept)
    assert list(directory.glob("**/.*.tmp")) == list(directory.glob("*-journal")) == []


@pytest.mark.skipif(os.name != "posix", reason="file-size limits are POSIX")
@pytest.mark.parametrize("full", ["database", "gait"])
def test_a_full_disk_is_told_and_leaves_nothing_half_written(robot, swept, tmp_path, full):
    directory = tmp_path / "lib"
    run = subprocess.run(script(directory, full), capture_output=True, text=True, check=False)
    assert run.returncode == 1
    assert {"database": "library.sqlite'", "gait": ".npz'"}[full] in run.stderr
    assert {"database": "; 0 gaits are kept in", "gait": "; 1 gait is kept in"}[full] in run.stderr
    assert "cannot write" in run.stderr
    assert "give the same command again to go on" in run.stderr
    assert list(directory.glob("**/.*.tmp")) == []
    for path in directory.glob("gaits/*"):
        load_gait(path)
    kept = seconds(directory)
    assert any(kept.values())
    with Counting() as jobs:
        library = sweep(robot, quick_task(), [SPEEDS], directory, QUICK)
    first = [job for job in jobs.done if job.kind == CONTINUE and job.substeps]
    assert not [job for job in first if kept.get(library.grid.name(job.point), 0.0) > 0.0]
    assert costs(library) == pytest.approx(costs(swept), rel=1e-9)


def test_a_library_that_is_moved_away_is_told(robot, tmp_path):
    directory = tmp_path / "lib"

    def move(progress):
        if directory.exists():
            directory.rename(tmp_path / "moved")

    with pytest.raises(InputError, match="was removed or moved meanwhile; put it back and give"):
        sweep(robot, quick_task(), [SPEEDS], directory, QUICK, on_progress=move)
    assert not directory.exists()
    (tmp_path / "moved").rename(directory)
    assert len(sweep(robot, quick_task(), [SPEEDS], directory, QUICK).rows) == 4


def test_a_library_can_be_read_while_it_is_made(robot, tmp_path):
    with Counting(most=2), pytest.raises(KeyboardInterrupt):
        sweep(robot, quick_task(), [SPEEDS], tmp_path / "l", QUICK)
    library = open_library(tmp_path / "l")
    assert [row["status"] for row in library.rows] == 4 * [NOT_COMPUTED]
    with (library.directory / "index.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert [(line["speed"], line["status"]) for line in lines] == [
        (str(speed), NOT_COMPUTED) for speed in SPEEDS.values
    ]
    assert {"cost", "kkt", "slope.speed", "origin"} < set(lines[0])
    assert sum(state.walk is not None for state in library.states.values()) == 2


def test_an_interrupted_round_of_comparison_goes_on_as_it_began(robot, swept_jobs, tmp_path):
    """The pairs of a round are written down before the first of them is tried."""
    before = next(n for n, job in enumerate(swept_jobs) if job.neighbours and not job.substeps)
    with Counting(most=before), pytest.raises(KeyboardInterrupt):
        sweep(robot, quick_task(), [SPEEDS], tmp_path / "part", QUICK)
    states = open_library(tmp_path / "part").states
    here = states[swept_jobs[before].point]
    assert here.due is not None
    assert SPEEDS.values[here.due[0]] == float(swept_jobs[before].neighbours[0].name[6:])
    with Counting(most=1), pytest.raises(KeyboardInterrupt):
        sweep(robot, quick_task(), [SPEEDS], tmp_path / "part", QUICK)
    assert open_library(tmp_path / "part").states[swept_jobs[before].point].due is None


def test_a_narrow_sweep_finds_what_a_single_design_finds(robot, tmp_path):
    """At 0.9 m/s the best walk comes from a slower one, which the sweep does not have."""
    task, options = quick_task(speed=0.9), replace(QUICK, refine=True)
    alone = many_starts(robot, task, options).design
    library = sweep(robot, task, [Axis("speed", (0.9, 1.0))], tmp_path / "l", options)
    assert library.rows[0]["cost"] == pytest.approx(alone.solution.cost, rel=1e-6)


@pytest.mark.parametrize(
    ("form", "advice"), [(4, "is 4, .* reads 3; install a newer gaitopt"), (2, "is 2, .*; make")]
)
def test_a_library_of_another_format_is_refused(swept, tmp_path, form, advice):
    with Database(tmp_path) as database:
        database.write({}, {**swept.record, "format": form})
    with pytest.raises(GaitFileError, match=advice):
        open_library(tmp_path)


def test_any_executor_of_the_standard_library_finds_the_same(robot, swept, tmp_path):
    with ThreadPoolExecutor(2) as pool:
        library = sweep(robot, quick_task(), [SPEEDS], tmp_path / "l", QUICK, executor=pool)
        assert pool.submit(abs, -1).result() == 1  # it is left open
    assert costs(library) == pytest.approx(costs(swept), rel=1e-9)


def test_an_executor_that_breaks_down_is_told(robot, tmp_path):
    class Broken:
        def submit(self, function, job):
            future = Future()
            future.set_exception(BrokenExecutor("a process died."))
            return future

    with pytest.raises(GaitoptError, match="a process died; what was finished is kept"):
        sweep(robot, quick_task(), [SPEEDS], tmp_path / "l", QUICK, executor=Broken())
