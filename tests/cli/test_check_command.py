"""`gaitopt check`: a gait file is believed only if everything in it follows from its parameters."""

import json
from dataclasses import replace

import numpy as np
import pytest
from places import CASES

from gaitopt import audit, load_gait, save_gait
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import array_names


def test_designed_gait_passes(cli, designed):
    result = cli("check", designed / "gait.npz")
    assert result.exit_code == 0, result.stderr
    assert "certified" in result.stdout
    assert "ground 223.158 = weight 223.158 N·s" in result.stdout


def test_unrefined_gait_is_not_certified(cli, quick, tmp_path):
    assert quick("-o", tmp_path, "-q").exit_code == 0
    result = cli("check", tmp_path / "gait.npz")
    assert result.exit_code == 1
    assert "optimal at the given samples only" in result.stdout
    assert "altered" not in result.stderr


@pytest.mark.parametrize(
    "name", [n for n in array_names() if n not in ("parameters", "time", "knots", "mirror")]
)
def test_altered_array_is_named(cli, gait_file, name):
    gait = load_gait(gait_file)
    values = np.array(getattr(gait, name))
    values.flat[np.abs(values).argmax()] *= 1.0 + 1e-7
    save_gait(replace(gait, **{name: values}), gait_file)
    result = cli("check", gait_file)
    assert result.exit_code == 1
    assert f"these differ: {name} (by 1.0e-07)" in result.stderr


def test_altered_parameters_are_caught(gait_file):
    gait = load_gait(gait_file)
    values = gait.parameters + np.eye(len(gait.parameters))[3] * 1e-6
    found = audit(replace(gait, parameters=values))
    assert {"q", "torque", "cop"} <= set(found.altered)
    assert not found.passed


@pytest.mark.parametrize(
    ("keys", "value", "caught"),
    [
        (("cost",), 3000.0, "cost"),
        (("mass",), 50.0, "mass"),
        (("limits", "torque"), [200.0] * 12, "limits"),
        (("task", "margins", "torque_limit"), 90.0, "limits"),
        (("task", "margins", "friction"), 0.5, "certificate"),
        (("certificate", "certified"), False, "certificate"),
    ],
)
def test_altered_record_is_named(cli, gait_file, keys, value, caught):
    gait = load_gait(gait_file)
    meta = json.loads(json.dumps(gait.meta))
    record = meta
    for key in keys[:-1]:
        record = record[key]
    record[keys[-1]] = value
    save_gait(replace(gait, meta=meta), gait_file)
    result = cli("check", gait_file)
    assert result.exit_code == 1
    assert caught in result.stderr


def test_another_robot_is_caught(cli, gait_file):
    gait = load_gait(gait_file)
    heavier = gait.urdf.replace('mass value="1.75"', 'mass value="1.76"')
    assert heavier != gait.urdf
    save_gait(replace(gait, urdf=heavier), gait_file)
    result = cli("check", gait_file)
    assert result.exit_code == 1
    assert "torque" in result.stderr
    assert "mass" in result.stderr


def without(gait_file, *names):
    gait = load_gait(gait_file)
    left = {k: v for k, v in gait.meta.items() if k not in names}
    save_gait(replace(gait, meta=left), gait_file)


@pytest.mark.parametrize(
    ("remove", "pattern"),
    [(["task"], "record of the task is missing"), (["sole", "choices"], "edge of the sole")],
)
def test_gait_without_its_task_or_robot_cannot_be_checked(cli, gait_file, remove, pattern):
    without(gait_file, *remove)
    result = cli("check", gait_file)
    assert result.exit_code == 2
    assert pattern in result.stderr


def test_gait_of_a_time_without_choices_passes(cli, gait_file):
    without(gait_file, "choices")
    assert cli("check", gait_file).exit_code == 0


def test_altered_sole_is_named(cli, gait_file):
    gait = load_gait(gait_file)
    wider = {**gait.fact("sole"), "left": 0.07}
    save_gait(replace(gait, meta={**gait.meta, "sole": wider}), gait_file)
    result = cli("check", gait_file)
    assert result.exit_code == 1
    assert "these differ: sole" in result.stderr


def test_a_walk_that_exceeds_limits_between_its_samples_is_not_certified(cli):
    """Designed at 5 samples; certified at 43 instants by version 0.1."""
    result = cli("check", CASES / "coarse5.npz")
    assert result.exit_code == 1
    assert "151.3 N·m" in result.stdout
    assert "its certificate says certified; computed now, the walk is not" in result.stderr
    assert "altered" not in result.stderr


def test_limits_that_the_file_brings_are_shown(cli, refined_design, tmp_path):
    """A reader sees that the gait is of motors that the robot has not."""
    problem = refined_design.problem
    margins = replace(problem.task.margins, torque_limit=1e9, friction=0.9)
    strong = WalkProblem(problem.robot, replace(problem.task, margins=margins), problem.grid)
    gait = gait_at(strong, refined_design.solution.x, {"certificate": {"certified": False}})
    result = cli("check", save_gait(gait, tmp_path / "strong.npz"))
    assert "torque_limit 1e+09 N·m for every joint, where the robot has 150" in result.stdout
    assert "friction 0.9, by default 0.7" in result.stdout


@pytest.mark.parametrize("name", ["stance_sole", "swing_sole_frame"])
def test_sole_names_that_are_not_computed_are_caught(cli, gait_file, name):
    save_gait(replace(load_gait(gait_file), **{name: "somewhere_else"}), gait_file)
    result = cli("check", gait_file)
    assert result.exit_code == 1
    assert name in result.stderr


def test_a_file_changed_by_other_programs_is_told(cli, gait_file):
    with np.load(gait_file) as content:
        members = {name: content[name] for name in content.files}
    members["torque"] = members["torque"] * 1.01
    np.savez(gait_file, **members)
    result = cli("check", gait_file)
    assert result.exit_code == 1
    assert "changed after gaitopt wrote the file: torque" in result.stderr
    assert "these differ: torque (by 9.9e-03)" in result.stderr
    assert cli("export", gait_file, "--output", gait_file.parent / "x.csv").exit_code == 2
