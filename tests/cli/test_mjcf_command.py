"""`gaitopt export --format mjcf`."""

import mujoco
import pytest

from gaitopt.simulate.mujoco_model import START


def test_the_command_writes_it(cli, designed, tmp_path):
    file = tmp_path / "walk.xml"
    result = cli("export", designed / "gait.npz", "--format", "mjcf", "--rate", "20", "-o", file)
    assert result.exit_code == 0, result.stderr
    model = mujoco.MjModel.from_xml_path(str(file))
    assert model.nu == 12
    assert model.key(START).time[0] == 0.0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--joints", "mujoco"), "--joints has no effect here: it acts only without --format mjcf"),
        (("--both-legs",), "--both-legs has no effect here"),
        (("-o", "walk.json"), "end in .xml"),
    ],
)
def test_bad_words_are_refused(cli, designed, words, message):
    result = cli("export", designed / "gait.npz", "--format", "mjcf", *words)
    assert result.exit_code == 2
    assert message in result.stderr
