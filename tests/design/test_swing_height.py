"""One constraint with its margin, declared in one file: everything else follows from that."""

import pytest

from gaitopt.cli.config import SCHEMA, read_config
from gaitopt.cli.request import make_request
from gaitopt.design.audit import audit, imposed
from gaitopt.design.options import DesignOptions
from gaitopt.design.starts import design_gait
from gaitopt.errors import NoGaitFoundError
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import task_from_record, task_record
from gaitopt.solvers import SQP


@pytest.fixture(scope="module")
def low(robot):
    """A walk whose swing foot stays below 5 cm; without that limit it swings to 6 cm."""
    return design_gait(robot, preset_task(swing_height=0.05), DesignOptions(SQP()), starts=1)


def test_it_holds_between_the_samples_too(low):
    worst = next(row for row in low.certificate.constraints if row.constraint == "swing height")
    assert low.certificate.certified
    assert (worst.equation, worst.unit, worst.limit) == ("3.2", "m", pytest.approx(0.05))
    assert worst.value == pytest.approx(0.05, abs=1e-7)  # it is active: refinement held it there
    assert low.gait.swing_sole[:, :, 2].max() <= 0.05 + 1e-7
    assert audit(low.gait).passed


def test_it_costs_something(robot, low):
    free = design_gait(robot, preset_task(), DesignOptions(SQP()), starts=1)
    assert free.gait.swing_sole[:, :, 2].max() > 0.055
    assert low.gait.cost > 1.01 * free.gait.cost


def test_option_key_help_and_record_follow(tmp_path, robot):
    declared = SCHEMA["margins"]["swing_height"]
    assert (declared.option, declared.unit) == ("--swing-height", "m")
    assert declared.help == "Largest height of the swing foot."
    path = tmp_path / "task.toml"
    path.write_text('[margins]\nswing_height = "5 cm"\n')
    assert read_config(path)["swing_height"] == pytest.approx(0.05)
    task = make_request({"swing_height": 0.07}, path).task
    assert task.margins.swing_height == 0.07
    assert task_from_record(task_record(task)) == task
    assert "swing_height 0.07, by default None" in imposed(WalkProblem(robot, task))


def test_the_diagnosis_names_it_and_turns_it(robot):
    """The profile of the clearance asks for 3 cm where this allows 2."""
    with pytest.raises(NoGaitFoundError) as found:
        design_gait(robot, preset_task(swing_height=0.02), DesignOptions(SQP()), starts=1)
    diagnosis = found.value.diagnosis
    assert {"swing height", "clearance"} & set(diagnosis.constraints)
    settings = {suggestion.setting: suggestion for suggestion in diagnosis.suggestions}
    assert "the largest height of the swing foot (swing_height) from 0.02 to" in (
        settings["swing_height"].sentence
    )
    assert settings["swing_height"].found.proven
