"""`gaitopt transition`: what it says, writes and refuses."""

import numpy as np
import pytest
from reference_cases import biped

from gaitopt import save_gait
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.gait.presets import preset_task
from gaitopt.solvers import solver_by_name


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    options = DesignOptions(solver=solver_by_name("sqp"))
    gait = design(biped(), preset_task(speed=1.0), options).gait
    return save_gait(gait, tmp_path_factory.mktemp("walk") / "gait.npz")


def test_it_writes_the_motion_and_says_what_it_found(cli, walk, tmp_path):
    path = tmp_path / "start.npz"
    result = cli("transition", "standing", walk, "--steps", 2, "--output", path)
    assert result.exit_code == 0, result.output
    assert "from standing to 1 m/s, 2 steps" in result.stdout
    assert "certified" in result.stdout
    with np.load(path) as content:
        assert content["foot_contact"][0].all()
        assert content["qpos"][-1, 0] - content["qpos"][0, 0] > 0.8  # steps and a stride


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("standing", "standing", "-o", "m.npz"), "give at least one"),
        (("standing", "nowhere.npz", "-o", "m.npz"), "there is no such file"),
        (("standing", "WALK", "-o", "m.csv"), "end in .npz"),
        (("standing", "WALK", "-o", "m.yaml", "--format", "bezier"), "one with samples"),
        (("standing", "WALK", "-o", "WALK"), "is one of the gaits"),
        (("standing", "WALK", "-o", "m.npz", "--duration", "soon"), "give seconds"),
        (("standing", "WALK", "-o", "m.npz", "--duration", "nan"), "from 0.05 to 5.0 s"),
        (("standing", "WALK", "-o", "m.npz", "--steps", "9"), "give 1 to 8"),
        (("standing", "WALK", "-o", "m.npz", "--stretch", "0.1"), "from 0.5 to 0.999"),
    ],
)
def test_refusals(cli, walk, tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    result = cli("transition", *(walk if word == "WALK" else word for word in words))
    assert result.exit_code == 2
    assert said in " ".join(result.output.split())
    assert not list(tmp_path.iterdir())
