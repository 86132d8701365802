"""`gaitopt sweep` and `gaitopt library`."""

import pytest
from typer.testing import CliRunner

from gaitopt.cli.app import app
from gaitopt.gait.result_file import load_gait

QUICK = ["--solver", "sqp", "--no-refine", "--samples", "15"]


def run(*words):
    return CliRunner().invoke(app, [str(word) for word in words], catch_exceptions=False)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    directory = tmp_path_factory.mktemp("cli") / "lib"
    result = run("sweep", "--speeds", "1.0,1.05", "--grid", "duration=0.4,0.42", *QUICK,
                 "-o", directory)  # fmt: skip
    return directory, result


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
    assert {"speed", "cost", "slope.duration", "peak_torque.knee"} < set(everything)


def test_the_library_is_drawn(made, tmp_path):
    figure = tmp_path / "library.png"
    assert run("library", made[0], "--plot", figure).exit_code == 0
    assert figure.read_bytes().startswith(b"\x89PNG")
    refused = run("library", made[0], "--plot", tmp_path / "library.xyz")
    assert refused.exit_code == 2
    assert "ends in .png" in refused.stderr


def test_a_gait_between(made, tmp_path):
    file = tmp_path / "between.npz"
    result = run("library", made[0], "--at", "speed=1.02", "--at", "duration=0.41", "-o", file)
    assert result.exit_code == 0, result.stderr
    assert "plain interpolation of the parameters" in result.stdout
    assert load_gait(file).speed == pytest.approx(1.02)


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
