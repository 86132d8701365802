"""`gaitopt requirements`: tables, files and figure."""

import csv
import sys

import openpyxl
import pytest

from gaitopt.design.requirements import FIGURES, motor_loops, requirement
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.view.torque_speed import torque_speed_figure

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
    assert "In which gait" not in cli("requirements", gait_file).stdout


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
    line = panels[3].lines[1]
    assert line.get_ydata()[:-1] == pytest.approx(loops["b"][3].torque)


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


def test_a_gait_whose_name_a_spreadsheet_would_compute(cli, gait_file, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    save_gait(load_gait(gait_file), "=1+1.npz")
    assert cli("requirements", "=1+1.npz", "-o", "r.xlsx").exit_code == 0
    assert openpyxl.load_workbook("r.xlsx").active["B2"].value == "'=1+1.npz"
