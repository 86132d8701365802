"""`gaitopt sweep` and `gaitopt library`."""

import io
import shutil
from dataclasses import replace

import pytest
from rich.console import Console
from sweeps import QUICK as LESS
from sweeps import SPEEDS, Counting, quick_task, run, vouch

from gaitopt.cli import sweep as sweep_module
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.sweep.executor import DIAGNOSE
from gaitopt.sweep.grid import Axis
from gaitopt.sweep.library import open_library
from gaitopt.sweep.scheduler import sweep

QUICK = ["--solver", "sqp", "--no-refine", "--samples", "15"]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    directory = tmp_path_factory.mktemp("cli") / "lib"
    result = run("sweep", "--speeds", "1.0,1.05", "--grid", "duration=0.4,0.42", *QUICK,
                 "-o", directory)  # fmt: skip
    return directory, result


@pytest.fixture(scope="module")
def begun_fast(tmp_path_factory):
    """The same, begun at the higher speed: of two optima 1e-4 apart it may find the other."""
    directory = tmp_path_factory.mktemp("fast") / "lib"
    words = ["--speeds", "1.0,1.05", "--grid", "duration=0.4,0.42", "--begin", "speed=1.05"]
    run("sweep", *words, *QUICK, "-o", directory)
    return directory


def test_a_grid_of_two_quantities(made):
    directory, result = made
    assert result.exit_code == 0  # without refinement, optimal at the samples is enough
    assert "of 4 gaits certified" in result.stdout
    names = sorted(path.name for path in (directory / "gaits").iterdir())
    assert names[0] == "speed=1,duration=0.4.npz"
    gait = load_gait(directory / "gaits" / "speed=1.05,duration=0.42.npz")
    assert gait.duration == pytest.approx(0.42)
    assert gait.speed == pytest.approx(1.05)


def test_a_sweep_that_is_done_says_that_nothing_was_computed(made):
    directory, first = made
    again = run("sweep", "--speeds", "1.0,1.05", "--grid", "duration=0.4,0.42", *QUICK,
                "-o", directory)  # fmt: skip
    assert again.stdout.splitlines()[0] == "all 4 were there; nothing was computed"
    assert again.stdout.splitlines()[1:] == first.stdout.splitlines()


def test_the_library_is_listed_and_filtered(made):
    directory, _ = made
    shown = run("library", directory, "--where", "speed>1.01", "--columns", "duration,cost")
    assert shown.exit_code == 0
    assert "2 of 4 gaits" in shown.stdout
    assert shown.stdout.split()[:3] == ["speed", "duration", "cost"]  # the axes are always there
    assert "0.42" in shown.stdout
    assert max(map(len, shown.stdout.splitlines())) < 40
    wrong = run("library", directory, "--columns", "velocity")
    assert wrong.exit_code == 2
    assert "no column 'velocity'" in wrong.stderr
    assert len(wrong.stderr.splitlines()) == 1
    assert len(wrong.stderr) < 200
    everything = run("library", directory, "--columns", "list").stdout.splitlines()
    assert {"speed [m/s]", "cost [N²·m·s]", "peak_torque.knee [N·m]", "kkt"} < set(everything)
    assert "slope.duration [N²·m·s per s]" in everything


FILE = """
[task]
samples = 15
speed = 0.9
[solver]
solver = "sqp"
refine = false
[sweep]
speeds = {speeds}
grid = {grid}
begin = {{ speed = 1.05 }}
"""


@pytest.mark.parametrize(
    ("speeds", "grid"),
    [('"1.0,1.05"', '{ duration = "0.4:0.42:0.02" }'), ("[1, 1.05]", '["duration=0.4,0.42"]')],
)
def test_a_configuration_file_has_a_section_for_sweeps(begun_fast, tmp_path, speeds, grid):
    """It asks for the sweep that was made by the command line: that is there, and done."""
    file = tmp_path / "task.toml"
    file.write_text(FILE.format(speeds=speeds, grid=grid))
    directory = shutil.copytree(begun_fast, tmp_path / "lib")
    with Counting() as jobs:
        assert run("sweep", "--config", file, "-o", directory, "--quiet").exit_code == 0
    assert jobs.done == []
    assert open_library(directory).grid.seeds == ((1, 0),)


def test_the_command_line_wins_over_the_section(tmp_path):
    file = tmp_path / "task.toml"
    file.write_text(FILE.format(speeds='"1.0"', grid="[]"))
    words = ["sweep", "--config", file, "--speeds", "1.05", "-o", tmp_path / "lib", "--quiet"]
    assert run(*words).exit_code == 0
    assert [axis.values for axis in open_library(tmp_path / "lib").grid.axes] == [(1.05,)]


@pytest.mark.parametrize(
    ("section", "said"),
    [
        ("speed = 1", "unknown entry in [sweep] 'speed'; did you mean 'speeds'?"),
        ("speeds = true", "sweep.speeds = 'True' is wrong; give a text"),
        ("workers = 'two'", "sweep.workers = 'two' is wrong; give a whole number"),
        ("grid = 3", "sweep.grid"),
        ("speeds = []", "sweep.speeds"),
    ],
)
def test_a_wrong_section_is_told(tmp_path, section, said):
    file = tmp_path / "task.toml"
    file.write_text(f"[sweep]\n{section}\n")
    refused = run("sweep", "--config", file, "-o", tmp_path / "lib")
    assert refused.exit_code == 2
    assert said in refused.stderr


@pytest.mark.parametrize("words", [(), ("--where", "speed>1.01")])
def test_tables_fit_80_columns_and_have_the_motors_first(made, words):
    directory, result = made
    for text in (result.stdout, run("library", directory, *words).stdout):
        table = [line for line in text.splitlines() if "gaits/" not in line]
        assert max(map(len, table)) <= 80
        heads = [line.split() for line in table]
        units = next(line for line in heads if line[:1] == ["m/s"])
        assert units[:8] == ["m/s", "s", *6 * ["N·m"]]
        assert units[8] == "N²·m·s"
        row = next(line for line in heads if line[:2] == ["1.05", "0.42"])
        assert all(len(figure.replace(".", "").lstrip("0")) <= 4 for figure in row[:9])


def test_two_libraries_are_compared(made, tmp_path):
    other = tmp_path / "weak"
    assert run("sweep", "--speeds", "1.05,1.1", "--grid", "duration=0.4,0.42", *QUICK,
               "--cop-margin", "0.03", "-o", other).exit_code == 0  # fmt: skip
    shown = run("library", made[0], other)
    lines = shown.stdout.splitlines()
    assert lines[:2] == [f"A: {made[0]}", f"B: {other}"]
    assert max(map(len, lines[2:])) <= 80
    rows = {tuple(line.split()[:2]): line.split()[2:] for line in lines}
    costs = [
        {(row["speed"], row["duration"]): row["cost"] for row in open_library(d).rows}
        for d in (made[0], other)
    ]
    a, b = (cost[1.05, 0.42] for cost in costs)
    assert rows["1.05", "0.42"][:3] == [f"{a:.4g}", f"{b:.4g}", f"{100.0 * (b / a - 1.0):+.1f}"]
    assert b > a
    assert rows["1", "0.4"][1:3] == ["-", "-"]
    assert rows["1.1", "0.4"][0] == "-"
    named = run("library", made[0], other, "--columns", "rms_torque.knee").stdout
    assert "torque" in named
    assert "cost" not in named
    figure = tmp_path / "both.svg"
    assert run("library", made[0], other, "--plot", figure).exit_code == 0
    assert b"dashed" in figure.read_bytes()


def test_what_cannot_be_compared_is_refused(made, swept):
    for words, said in (
        ((made[0], swept.directory), "over different quantities, speed, duration and speed"),
        ((made[0], made[0], made[0]), "3 libraries cannot be compared"),
        ((made[0], made[0], "--at", "speed=1"), "--at is a place in one library"),
    ):
        refused = run("library", *words)
        assert refused.exit_code == 2
        assert said in refused.stderr


def test_gaps_narrower_than_asked_for_are_told(tmp_path):
    shown = run("sweep", "--speeds", "1.0", *QUICK, "--leg-gap", "0.02", "-o", tmp_path / "lib")
    assert "leg_gap asks for 20.0 mm between the legs, but the robot has less" in shown.stdout


def test_the_library_is_drawn(made, tmp_path):
    figure = tmp_path / "library.png"
    assert run("library", made[0], "--plot", figure).exit_code == 0
    assert figure.read_bytes().startswith(b"\x89PNG")
    refused = run("library", made[0], "--plot", tmp_path / "library.xyz")
    assert refused.exit_code == 2
    assert "ends in .png" in refused.stderr


def test_a_gait_between(made, tmp_path):
    file = tmp_path / "between.npz"
    result = run("library", made[0], "--at", "speed=3.672km/h", "--at", "duration=0.41", "-o", file)
    assert result.exit_code == 0, result.stderr
    assert "plain interpolation of the parameters" in result.stdout
    assert load_gait(file).speed == pytest.approx(1.02)


def test_at_a_stored_place_it_is_the_stored_gait(made, tmp_path):
    file = tmp_path / "stored.npz"
    kept = made[0] / "gaits" / "speed=1.05,duration=0.42.npz"
    gait = load_gait(kept)
    proof = {**gait.fact("certificate"), "certified": True}
    directory = shutil.copytree(made[0], tmp_path / "lib")
    save_gait(replace(gait, meta={**gait.meta, "certificate": proof}),
              directory / "gaits" / kept.name)  # fmt: skip
    vouch(directory)
    where = ["--at", "speed=1.05", "--at", "duration=0.42", "-o", file]
    result = run("library", directory, *where)
    assert result.exit_code == 0, result.stderr
    said = "the stored gait of speed=1.05,duration=0.42; nothing was interpolated"
    assert said in result.stdout.splitlines()
    assert load_gait(file).q == pytest.approx(gait.q, abs=0.0)
    assert "is not certified; designed again from there" in run("library", made[0], *where).stdout


def test_a_value_that_is_missing_is_told(made):
    missing = run("library", made[0], "--at", "speed=1.0").stderr
    assert "needs a value of 'duration'; give a value of each of speed, duration" in missing


def test_a_value_given_twice_is_refused(made):
    twice = run("library", made[0], "--at", "speed=1.0", "--at", "speed=1.05")
    assert twice.exit_code == 2
    assert "--at gives speed twice" in twice.stderr


def test_missing_gaits_are_listed_and_made_anew(made, tmp_path):
    directory = shutil.copytree(made[0], tmp_path / "lib")
    (directory / "gaits" / "speed=1,duration=0.4.npz").unlink()
    shown = run("library", directory).stdout
    assert "file missing" in shown
    assert "1 gait has no usable file, see status; give the command of the sweep again" in shown
    again = run("sweep", "--speeds", "1.0,1.05", "--grid", "duration=0.4,0.42", *QUICK,
                "-o", directory)  # fmt: skip
    said = again.stdout.splitlines()
    assert said[0] == "made anew: gaits/speed=1,duration=0.4.npz (file missing)"
    assert again.exit_code == 0
    assert "file missing" not in run("library", directory).stdout


class Refusing(Counting):
    """Finishes no gait of the place where the trouble is, and finds no reason."""

    def run(self, job):
        outcome = super().run(job)
        if outcome.job.point != (1,):
            return outcome
        refusal = {"sentences": ["no reason"]} if outcome.job.kind == DIAGNOSE else None
        return replace(outcome, file=None, row=None, refusal=refusal)


def test_only_what_was_made_anew_is_told_as_such(swept, tmp_path):
    directory = shutil.copytree(swept.directory, tmp_path / "lib")
    for name in ("speed=0.95", "speed=1"):
        (directory / "gaits" / f"{name}.npz").unlink()
    words = ["sweep", "--speeds", "0.95:1.1:0.05", *QUICK, "-o", directory]
    with Refusing():
        tried = run(*words)
    assert tried.exit_code == 1, tried.stderr
    assert tried.stdout.splitlines()[:2] == [
        "made anew: gaits/speed=0.95.npz (file missing)",
        "could not be made anew: gaits/speed=1.npz (file missing)",
    ]
    again = run(*words)
    assert again.exit_code == 1
    assert again.stdout.splitlines()[0] == tried.stdout.splitlines()[1]


def test_an_interrupted_library_lists_what_is_to_come(robot, tmp_path):
    with Counting(most=2), pytest.raises(KeyboardInterrupt):
        sweep(robot, quick_task(), [SPEEDS], tmp_path / "l", LESS)
    shown = run("library", tmp_path / "l", "--columns", "status,cost")
    assert shown.exit_code == 0, shown.stderr
    assert shown.stdout.count("not computed") == 5
    assert "0 of 0 gaits; 4 of 4 points are not computed yet" in shown.stdout
    assert run("library", tmp_path / "l", "--where", "cost<4000").exit_code == 0


def test_a_library_made_in_python_goes_on(robot, swept):
    words = ["--speeds", "0.95:1.1:0.05", *QUICK, "-o", swept.directory]
    went_on = run("sweep", *words)
    assert went_on.exit_code in (0, 1), went_on.stderr
    assert went_on.stdout.startswith("all 4 were there; nothing was computed")
    other = run("sweep", *words, "--robot", "paper")
    assert other.exit_code == 2
    assert "it is of the robot 'biped13', asked for is 'paper'" in other.stderr


@pytest.mark.parametrize(
    ("wanted", "points", "got"), [(40, 4, 2), (2, 1, 1), (2, 9, 2), (200, 200, 2)]
)
def test_workers_are_no_more_than_there_is_use_for(monkeypatch, wanted, points, got):
    monkeypatch.setattr(sweep_module, "processors", lambda: 2)
    axes = [Axis("speed", tuple(0.5 + 1e-5 * i for i in range(points)))]
    errors = Console(file=io.StringIO())
    started = []
    monkeypatch.setattr(sweep_module, "local_workers", lambda *given: started.append(given))
    sweep_module.make_executor({"workers": wanted}, axes, errors, quiet=False)
    ((count, on_start),) = started
    assert count == got
    on_start()
    said = errors.file.getvalue()
    assert said.startswith(f"starting workers: {got}")
    assert (f"not {wanted}" in said) is (wanted != got)


def test_a_path_keeps_its_capitals(tmp_path):
    file = tmp_path / "Camel"
    file.write_text("x")
    refused = run("sweep", "--speeds", "1", "-o", file)
    assert refused.exit_code == 2
    assert f"'{file}' is a file" in refused.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "nothing to sweep over"),
        (["--speeds", "1:0:1"], "begins above its end"),
        (["--speeds", "0.8", "--grid", "speed=1,2"], "speed is swept over twice"),
        (["--speeds", "1.0", "--speed", "0.9"], "speed is swept over"),
        (["--grid", "duration"], "give NAME=RANGE"),
        (["--speeds", "0.8,0.9", "--begin", "speed=3"], "speed goes from 0.8 to 0.9"),
        (["--speeds", "1.0", "--workers", "2", "--scheduler", "tcp://x:1"], "exclude each other"),
        (["--grid", "geometry.d3=0.3,0.31", "--urdf", "urdf/biped13.urdf"], "specification"),
    ],
)
def test_what_cannot_be_swept_is_told(tmp_path, words, said):
    result = run("sweep", *words, "-o", tmp_path / "lib")
    assert result.exit_code == 2
    assert said in result.stderr
