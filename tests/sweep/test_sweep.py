import csv
import json
import os
import signal
import subprocess
import sys
import textwrap
import time
from dataclasses import replace
from pathlib import Path

import pytest
from sweeps import QUICK, SPEEDS, Counting, quick_task

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.design.design import design
from gaitopt.design.starts import many_starts
from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait.gait_file import load_gait
from gaitopt.solvers import solver_by_name
from gaitopt.sweep.executor import TRAVEL
from gaitopt.sweep.grid import Axis
from gaitopt.sweep.library import open_library
from gaitopt.sweep.scheduler import sweep
from gaitopt.sweep.table import CERTIFIED, INFEASIBLE, NOT_COMPUTED, awaited_row, write_index

HERE = Path(__file__).parent


def costs(library):
    return {row["speed"]: row["cost"] for row in library.rows}


def test_every_gait_is_as_good_as_one_from_a_first_guess(robot, swept):
    for speed, cost in costs(swept).items():
        cold = design(robot, quick_task(speed=speed), QUICK)
        assert cost <= cold.solution.cost * (1.0 + 1e-6)


def test_the_index_is_what_the_gaits_say(swept):
    with (swept.directory / "index.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert [float(line["speed"]) for line in lines] == list(SPEEDS.values)
    for point, line in zip(sorted(swept.points.order), lines, strict=True):
        gait = load_gait(swept.directory / line["file"])
        assert float(line["cost"]) == pytest.approx(gait.cost, rel=1e-12)
        assert gait.speed == pytest.approx(float(line["speed"]), rel=1e-6)
        assert float(line["kkt"]) < 1e-6
        assert gait.fact("sweep", "values") == swept.points.values(point)
        peaks = [float(v) for k, v in line.items() if k.startswith("peak_torque.")]
        assert len(peaks) == 6
        assert max(peaks) == pytest.approx(abs(gait.torque).max(), rel=1e-9)


def test_the_index_opens_as_parquet(swept):
    parquet = pytest.importorskip("pyarrow.parquet", reason="the extra 'tables' is not installed")
    table = parquet.read_table(swept.directory / "index.parquet")
    assert table["cost"].to_pylist() == [row["cost"] for row in swept.rows]


def test_a_parquet_index_without_gaits_has_its_columns(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="the extra 'tables' is not installed")
    write_index([awaited_row({"speed": 0.8}), awaited_row({"speed": 0.9})], tmp_path)
    table = parquet.read_table(tmp_path / "index.parquet")
    assert table["speed"].to_pylist() == [0.8, 0.9]
    assert str(table.schema.field("cost").type) == "double"
    assert str(table.schema.field("origin").type) == "string"


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


def test_an_interrupted_sweep_goes_on_and_computes_nothing_twice(robot, swept, tmp_path):
    whole = Counting()
    sweep(robot, quick_task(), [SPEEDS], tmp_path / "whole", QUICK, crew=whole)
    before = Counting(most=6)
    with pytest.raises(KeyboardInterrupt):
        sweep(robot, quick_task(), [SPEEDS], tmp_path / "part", QUICK, crew=before)
    after = Counting()
    library = sweep(robot, quick_task(), [SPEEDS], tmp_path / "part", QUICK, crew=after)
    assert len(before.done) == 6
    assert len(before.done) + len(after.done) == len(whole.done)
    assert costs(library) == pytest.approx(costs(swept), rel=1e-9)
    again = Counting()
    sweep(robot, quick_task(), [SPEEDS], tmp_path / "part", QUICK, crew=again)
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
        ({"robot": None}, "robot is None, .* give a Robot"),
        ({"task": "fast"}, "task is 'fast', .* give a Task"),
        ({"crew": 3}, "crew is 3, .* give a Crew"),
        ({"directory": 3}, "directory is 3, .* give a path"),
        ({"options": 3}, "options is 3, .* give DesignOptions"),
        ({"spec": "biped13"}, "spec is 'biped13', .* give a BipedSpec"),
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
    said = library.state.refusals[(1,)]["sentences"]
    assert any("0.08 m from every edge leaves no room" in sentence for sentence in said)


def test_entries_of_a_specification_can_be_swept(robot, tmp_path):
    axis = Axis("links.torso.mass", (38.0, 40.55))
    library = sweep(robot, quick_task(), [axis], tmp_path / "l", QUICK, spec=biped13())
    light, heavy = library.rows
    assert light["cost"] < heavy["cost"]
    gaits = [library.gait(point) for point in sorted(library.points.order)]
    difference = gaits[1].number("mass") - gaits[0].number("mass")
    assert difference == pytest.approx(2.55, rel=1e-9)
    slope = 0.5 * (light["slope.links.torso.mass"] + heavy["slope.links.torso.mass"])
    assert heavy["cost"] - light["cost"] == pytest.approx(2.55 * slope, rel=0.05)


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
    sys.path[:0] = [{tests!r}, {here!r}]
    from reference_cases import biped
    from sweeps import QUICK, SPEEDS, quick_task
    from gaitopt.errors import InputError
    from gaitopt.sweep.scheduler import sweep
    def fill(advance):
        if {limit}:
            resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
    try:
        sweep(biped(), quick_task(), [SPEEDS], {directory!r}, QUICK, on_advance=fill)
    except InputError as error:
        sys.exit(str(error))
"""


def done_in(journal: Path) -> int:
    """Return of how many jobs a journal has the outcome."""
    return sum("seconds" in json.loads(line) for line in journal.read_text().splitlines())


def script(directory: Path, limit: int = 0) -> list[str]:
    text = textwrap.dedent(SCRIPT).format(
        tests=str(HERE.parent), here=str(HERE), directory=str(directory), limit=limit
    )
    return [sys.executable, "-c", text]


@pytest.mark.skipif(os.name != "posix", reason="kill -9 is POSIX")
def test_kill_9_loses_at_most_the_work_in_flight(robot, swept, tmp_path):
    directory = tmp_path / "lib"
    process = subprocess.Popen(script(directory))
    journal = directory / "journal.jsonl"
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline and process.poll() is None:
        if journal.exists() and journal.read_bytes().count(b"\n") >= 3:
            break
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    kept = done_in(journal)
    assert kept >= 3
    crew = Counting()
    library = sweep(robot, quick_task(), [SPEEDS], directory, QUICK, crew=crew)
    assert kept + len(crew.done) == done_in(journal)
    assert sum(job.kind == TRAVEL and job.point == (1,) for job in crew.done) <= 1
    assert costs(library) == pytest.approx(costs(swept), rel=1e-9)


@pytest.mark.skipif(os.name != "posix", reason="file-size limits are POSIX")
@pytest.mark.parametrize("full", ["journal", "gait"])
def test_a_full_disk_is_told_and_leaves_nothing_half_written(robot, swept, tmp_path, full):
    directory = tmp_path / "lib"
    journal = (swept.directory / "journal.jsonl").stat().st_size
    gait = min(path.stat().st_size for path in swept.directory.glob("gaits/*.npz"))
    limit = {"journal": journal // 3, "gait": gait - 1}[full]
    assert limit > journal or full == "journal"
    run = subprocess.run(script(directory, limit), capture_output=True, text=True, check=False)
    assert run.returncode == 1
    assert "file too large" in run.stderr
    assert "give the same command again to go on" in run.stderr
    assert list(directory.glob("**/.*.tmp")) == []
    for path in directory.glob("gaits/*"):
        load_gait(path)
    kept = done_in(directory / "journal.jsonl")
    assert kept >= 2
    crew = Counting()
    library = sweep(robot, quick_task(), [SPEEDS], directory, QUICK, crew=crew)
    assert kept + len(crew.done) == done_in(directory / "journal.jsonl")
    assert costs(library) == pytest.approx(costs(swept), rel=1e-9)


def test_a_library_can_be_read_while_it_is_made(robot, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        sweep(robot, quick_task(), [SPEEDS], tmp_path / "l", QUICK, crew=Counting(most=2))
    library = open_library(tmp_path / "l")
    assert [row["status"] for row in library.rows] == 4 * [NOT_COMPUTED]
    with (library.directory / "index.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert [(line["speed"], line["status"]) for line in lines] == [
        (str(speed), NOT_COMPUTED) for speed in SPEEDS.values
    ]
    assert {"cost", "kkt", "slope.speed", "origin"} < set(lines[0])
    assert sum(f is not None for f in library.state.footings.values()) == 2


def test_an_interrupted_round_of_comparison_goes_on_as_it_began(robot, tmp_path):
    """The pairs of a round are written down before the first of them is tried."""
    whole = Counting()
    sweep(robot, quick_task(), [SPEEDS], tmp_path / "whole", QUICK, crew=whole)
    before = next(n for n, job in enumerate(whole.done) if job.near and not job.patient)
    crew = Counting(most=before)
    with pytest.raises(KeyboardInterrupt):
        sweep(robot, quick_task(), [SPEEDS], tmp_path / "part", QUICK, crew=crew)
    state = open_library(tmp_path / "part").state
    assert whole.done[before].point in state.due
    other = state.due[whole.done[before].point]
    assert SPEEDS.values[other[0]] == pytest.approx(float(whole.done[before].near[0][2][6:]))
    state.take({"point": whole.done[before].point, "tried": [[other, 1.0]]})
    assert whole.done[before].point not in state.due


def test_a_narrow_sweep_finds_what_a_single_design_finds(robot, tmp_path):
    """At 0.9 m/s the best walk comes from a slower one, which the sweep does not have."""
    task, options = quick_task(speed=0.9), replace(QUICK, refine=True)
    alone = many_starts(robot, task, options).design
    library = sweep(robot, task, [Axis("speed", (0.9, 1.0))], tmp_path / "l", options)
    assert library.rows[0]["cost"] == pytest.approx(alone.solution.cost, rel=1e-6)


def test_a_library_of_another_format_is_refused(swept, tmp_path):
    manifest = json.loads((swept.directory / "manifest.json").read_text())
    (tmp_path / "manifest.json").write_text(json.dumps({**manifest, "format": 1}))
    with pytest.raises(GaitFileError, match="of another format than 2"):
        open_library(tmp_path)
