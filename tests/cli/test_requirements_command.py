"""`gaitopt requirements`: tables, files and figure."""

import csv
import sys

import numpy as np
import openpyxl
import pytest
from scipy.integrate import trapezoid

from gaitopt.actuators.motors import read_motors
from gaitopt.cli.display import ABSENT
from gaitopt.cli.motors import difference_table
from gaitopt.design.requirements import FIGURES, MotorRequirement, motor_loops, requirement
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.view.comparison_figures import torque_speed_figure

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


@pytest.fixture(scope="module")
def slow(cli, tmp_path_factory):
    """A slower walk of the same robot."""
    directory = tmp_path_factory.mktemp("slow")
    quick = ("--solver", "sqp", "--starts", "1", "--no-refine", "--no-figures", "--no-page")
    assert cli("optimise", *quick, "--speed", "0.7", "-o", directory, "-q").exit_code == 0
    return directory / "gait.npz"


def test_tables_of_one_gait_and_of_two_fit_the_page(cli, gait_file, slow):
    result = cli("requirements", gait_file, slow, "--against", slow)
    assert result.exit_code == 0, result.stderr
    lines = result.stdout.splitlines()
    own = [line for line in lines if str(gait_file.parent) not in line and str(slow) not in line]
    assert max(map(len, own)) <= 80
    assert f"1: {gait_file}" in lines
    assert f"2: {slow}" in lines
    knee = next(line.split() for line in lines if line.startswith("knee"))
    loops = {one.motor: one for one in motor_loops(load_gait(gait_file))}
    found = requirement(loops["knee"], "")
    assert float(knee[1]) == pytest.approx(found.peak_torque, abs=0.06)
    less = next(line.split() for line in reversed(lines) if line.startswith("knee"))
    other = {one.motor: one for one in motor_loops(load_gait(slow))}
    theirs = requirement(other["knee"], "").peak_torque
    assert less[1] == f"{100.0 * (theirs / found.peak_torque - 1.0):+.1f}"
    heads = next(line for line in reversed(lines) if line.startswith("motor"))
    assert "%" in heads
    assert len(less) == len(FIGURES) - 1  # all but what goes with a peak, and the name
    assert "In which gait" not in cli("requirements", gait_file).stdout


def test_no_percentage_of_next_to_nothing_is_told():
    def asked(waist, knee):
        of = (("waist", waist), ("knee", knee))
        return [MotorRequirement(m, dict.fromkeys(FIGURES, v), {}, slides=False) for m, v in of]

    table = difference_table(asked(1e-6, 80.0), asked(7.0, 96.0))
    names, *changes = (list(column.cells) for column in table.columns)
    assert [str(name) for name in names] == ["waist", "knee"]
    assert {tuple(map(str, one)) for one in changes} == {(ABSENT, "+20.0")}


def test_files_hold_what_is_computed(cli, gait_file, slow, tmp_path):
    for suffix in ("csv", "toml", "xlsx"):
        path = tmp_path / f"r.{suffix}"
        assert cli("requirements", gait_file, slow, "-o", path).exit_code == 0
    loops = {one.motor: one for one in motor_loops(load_gait(slow))}
    found = requirement(loops["knee"], "")
    with (tmp_path / "r.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 6 * 3
    knee = next(r for r in rows if (r["motor"], r["gait"]) == ("knee", str(slow)))
    assert float(knee["peak_torque [N·m]"]) == found.peak_torque
    assert float(knee["peak_speed [rpm]"]) == pytest.approx(found.peak_speed * 9.549296585513721)
    whole = next(r for r in rows if (r["motor"], r["gait"]) == ("knee", "all"))
    assert whole["peak_torque in gait"] == str(gait_file)
    record = tomllib.loads((tmp_path / "r.toml").read_text())
    assert record["motors"]["knee"]["gaits"][str(slow)] == {
        name: getattr(found, name) for name in FIGURES
    }
    assert record["units"]["peak_power"] == "W"
    sheet = openpyxl.load_workbook(tmp_path / "r.xlsx").active
    assert [cell.value for cell in sheet[1]] == list(rows[0])
    assert sheet.max_row == 19


def test_the_figure_has_a_panel_for_each_motor(cli, gait_file, slow, tmp_path):
    result = cli("requirements", gait_file, slow, "--figure", tmp_path / "loops.svg")
    assert result.exit_code == 0, result.stderr
    assert "hip pitch" in (tmp_path / "loops.svg").read_text()
    loops = {"a": motor_loops(load_gait(gait_file)), "b": motor_loops(load_gait(slow))}
    panels = torque_speed_figure(loops).axes
    assert [panel.get_title(loc="left") for panel in panels[3:5]] == ["knee", "ankle pitch"]
    knee, (line, jumps) = loops["b"][3], panels[3].lines[2:4]
    drawn = line.get_ydata()
    assert drawn[~np.isnan(drawn)] == pytest.approx(knee.torque)
    # the two landings of a stride, which no line may seem to pass through
    starts, ends, apart = jumps.get_ydata().reshape(-1, 3).T
    assert np.isnan(apart).all()
    assert ends == pytest.approx(knee.torque[[*np.flatnonzero(np.diff(knee.time) < 1e-12) + 1, 0]])
    assert starts[-1] == knee.torque[-1]
    assert (np.abs(ends - starts) > 1.0).sum() == 2
    assert jumps.get_linestyle() == ":" != line.get_linestyle()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("-o", "r.txt"), "suffix must be one of .csv, .toml, .xlsx"),
        (("--figure", "r.gif"), "ends in .png, .svg or .pdf"),
    ],
)
def test_forms_there_are_not(cli, gait_file, words, said):
    result = cli("requirements", gait_file, *words)
    assert result.exit_code == 2
    assert said in result.stderr


def test_what_is_no_gait_or_given_twice(cli, gait_file, tmp_path):
    again = cli("requirements", gait_file, gait_file)
    assert again.exit_code == 2
    assert "is given twice" in again.stderr
    nothing = cli("requirements", tmp_path)
    assert nothing.exit_code == 2
    assert "no gait library" in nothing.stderr


def test_a_spreadsheet_without_its_library(cli, gait_file, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    result = cli("requirements", gait_file, "-o", tmp_path / "r.xlsx")
    assert result.exit_code == 2
    assert "gaitopt[tables]" in result.stderr


def test_a_spreadsheet_on_a_full_disk(cli, gait_file, tmp_path, monkeypatch):
    def full(*_):
        raise ValueError("IO_EFBIG")  # as lxml, in which openpyxl writes a temporary file

    monkeypatch.setattr(openpyxl.Workbook, "save", full)
    result = cli("requirements", gait_file, "-o", tmp_path / "r.xlsx")
    assert result.exit_code == 2
    assert "cannot make the table: IO_EFBIG; make room for files in" in result.stderr
    assert list(tmp_path.iterdir()) == [gait_file]


def test_a_gait_whose_name_a_spreadsheet_would_compute(cli, gait_file, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    save_gait(load_gait(gait_file), "=1+1.npz")
    assert cli("requirements", "=1+1.npz", "-o", "r.xlsx").exit_code == 0
    assert openpyxl.load_workbook("r.xlsx").active["B2"].value == "'=1+1.npz"


TABLE = """
[motors.example]
torque_constant = 0.1
resistance = 0.1
inertia = 1e-4
peak_current = 60.0
continuous_current = 20.0
voltage = 48.0
no_load_speed = "4400rpm"
mass = 0.6

[[drives]]
joints = "*"
motor = "example"
ratio = 6
efficiency = 0.9
"""


@pytest.fixture(scope="module")
def motors(tmp_path_factory):
    """A table of motors that the walk of 0.7 m/s just does with."""
    path = tmp_path_factory.mktemp("motors") / "motors.toml"
    path.write_text(TABLE)
    return path


@pytest.fixture(scope="module")
def driven(cli, motors, tmp_path_factory):
    """A certified walk within the envelope of its motors; its directory."""
    directory = tmp_path_factory.mktemp("driven") / "walk"
    words = ("--solver", "sqp", "--starts", "1", "--speed", "0.9", "--no-page", "--no-figures")
    result = cli("optimise", *words, "--motors", motors, "-o", directory, "-q")
    assert result.exit_code == 0, result.stderr
    return directory


def test_a_walk_keeps_to_the_envelope_of_its_motors(cli, motors, driven):
    gait = load_gait(driven / "gait.npz")
    table = read_motors(motors)
    peak = 0.1 * 6 * 0.9 * 60.0
    torque = np.abs(np.concatenate([one.torque for one in motor_loops(gait)]))
    assert torque.max() == pytest.approx(peak, rel=1e-4)  # it decides
    assert gait.trajectory.body.armature == pytest.approx(36e-4)
    plain, again = motor_loops(gait), motor_loops(gait, table)  # the rotors are there already
    assert again[3].torque == pytest.approx(plain[3].torque)
    assert cli("check", driven / "gait.npz").exit_code == 0
    more = ("--no-page", "--no-figures", "-q", "-o", driven.parent / "again")
    assert cli("optimise", "--config", driven / "task.toml", *more).exit_code == 0
    assert load_gait(driven.parent / "again" / "gait.npz").cost == pytest.approx(gait.cost)


def test_the_motors_side_of_the_gear(cli, motors, driven, gait_file, tmp_path):
    path, picture = tmp_path / "r.toml", tmp_path / "loops.svg"
    words = ("--motors", motors, "-o", path, "--figure", picture)
    result = cli("requirements", driven / "gait.npz", *words)
    assert result.exit_code == 0, result.stderr
    assert max(map(len, result.stdout.splitlines()[:20])) <= 80
    use = tomllib.loads(path.read_text())["motors"]["knee"]["before_gear"]
    use = use[str(driven / "gait.npz")]
    knee = motor_loops(load_gait(driven / "gait.npz"))[3]
    current = np.abs(knee.torque) / (0.1 * 6 * 0.9)
    assert use["peak_torque"] == pytest.approx(0.1 * current.max())
    assert use["peak_share"] == pytest.approx(current.max() / 60.0)
    assert use["copper_loss"] == pytest.approx(
        0.1 * trapezoid(current**2, knee.time) / knee.time[-1]
    )
    assert use["rms_share"] == pytest.approx(np.sqrt(use["copper_loss"] / 0.1) / 20.0)
    assert use["peak_speed"] == pytest.approx(6.0 * np.abs(knee.rate).max())
    line = knee.torque / (0.1 * 6 * 0.9 * 480.0) + knee.rate / (4400 * np.pi / 30 / 6)
    assert use["voltage_share"] == pytest.approx(np.abs(line).max())
    hot = {line.split(" takes")[0] for line in result.stdout.splitlines() if "continuous" in line}
    uses = tomllib.loads(path.read_text())["motors"].items()
    shares = {name: one["before_gear"][str(driven / "gait.npz")] for name, one in uses}
    over = {name for name, one in shares.items() if one["rms_share"] > 1.0}
    assert hot == {f"too much: {name}" for name in over}
    assert 0 < len(over) < len(shares)
    assert "envelope of the motor" in picture.read_text()
    # of a gait that was designed without rotors, those of the table are accelerated too
    bare, with_rotors = (
        motor_loops(load_gait(gait_file), t)[3] for t in (None, read_motors(motors))
    )
    added = with_rotors.torque - bare.torque
    assert added == pytest.approx(36e-4 * bare.acceleration)
    table = tmp_path / "r.csv"
    assert cli("requirements", gait_file, "--motors", motors, "-o", table).exit_code == 0
    with table.open(newline="") as stream:
        row = next(csv.DictReader(stream))
    assert float(row["ratio before gear"]) == 6.0


def test_motors_that_do_not_fit(cli, motors, gait_file, tmp_path):
    other = tmp_path / "other.toml"
    other.write_text(TABLE.replace('joints = "*"', 'joints = "elbow"'))
    for words in (("requirements", gait_file), ("optimise", "--speed", "0.7")):
        result = cli(*words, "--motors", other)
        assert result.exit_code == 2
        assert "elbow" in result.stderr
