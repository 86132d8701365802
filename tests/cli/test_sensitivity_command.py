"""`gaitopt sensitivity`: table, file, refusals."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from gaitopt.cli.sensitivity import report_of
from gaitopt.gait.gait_file import load_gait, save_gait


def test_a_table_says_what_changes_the_cost_most(cli, gait_file, tmp_path):
    result = cli("sensitivity", gait_file, "--most", "12", "-o", tmp_path / "s.csv")
    assert result.exit_code == 0, result.stderr
    lines = result.stdout.splitlines()
    table = [line for line in lines if not line.startswith(("note", "wrote"))]
    assert max(map(len, table)) <= 80
    report = report_of(load_gait(gait_file))
    speed = next(line for line in lines if line.startswith("speed ")).split()
    assert speed[1:3] == ["+0.1", "m/s"]
    assert float(speed[3]) == pytest.approx(100.0 * report.of("speed").share, abs=0.006)
    assert f"{len(report.found) - 12} more change it less" in result.stdout
    for text in report.doubts:
        assert f"note: {text}" in lines
    with (tmp_path / "s.csv").open(newline="", encoding="utf-8") as stream:
        rows = {row["name"]: row for row in csv.DictReader(stream)}
    assert list(rows) == [one.name for one in report.found]
    shin = report.of("shin")
    assert float(rows["shin"]["per_unit"]) == shin.per_unit
    assert (rows["shin"]["unit"], float(rows["shin"]["step"])) == ("m", 0.01)


def test_what_cannot_be_is_refused(cli, gait_file, tmp_path):
    for words, told in (
        (("--most", "0"), "show at least 1 line"),
        (("-o", tmp_path / "s.txt"), "ends in .csv"),
        (("-o", tmp_path / "no" / "s.csv"), "no directory"),
    ):
        result = cli("sensitivity", gait_file, *words)
        assert result.exit_code == 2
        assert told in " ".join(result.stderr.split())
    gait = load_gait(gait_file)
    moved = gait.parameters + 0.01 * np.eye(gait.parameters.size)[0]
    save_gait(replace(gait, parameters=moved), gait_file)
    result = cli("sensitivity", gait_file)
    assert result.exit_code == 2
    assert "not optimal" in " ".join(result.stderr.split())
    assert not list(tmp_path.glob("*.csv"))
