"""The checks that loaders of URDFs do not make."""

from __future__ import annotations

import re

import pytest

from gaitopt.errors import RobotError
from gaitopt.robot.model import Robot
from gaitopt.robot.presets import biped13
from gaitopt.robot.urdf import urdf_text
from gaitopt.robot.urdf_check import check_urdf

TEXT = urdf_text(biped13())


def edited(pattern: str, replacement: str) -> str:
    text, count = re.subn(pattern, replacement, TEXT, count=1)
    assert count == 1
    return text


DAMAGE = {
    r"link 'torso': the mass is -40\.55 kg; it must be above 0": edited(
        r'mass value="40.55"', 'mass value="-40.55"'
    ),
    r"link 'torso': the mass is 0 kg": edited(r'mass value="40.55"', 'mass value="0"'),
    r"link 'torso': mass is 'nan'; it must be a finite number": edited(
        r'mass value="40.55"', 'mass value="nan"'
    ),
    r"link 'torso': the inertia is not positive definite": edited(r'ixx="1\.5', 'ixx="-1.5'),
    r"link 'torso': the inertia cannot belong to a body": edited(r'ixx="1\.5', 'ixx="100.5'),
    r"link 'torso': no ixx is given": edited(r'ixx="[^"]*" ', ""),
    r"joint 'left_hip_yaw': the range is from 3 to": edited(r'lower="[^"]*"', 'lower="3"'),
    r"not well-formed XML: .*line": TEXT[:-200],
    r"the file holds <html>": "<html></html>",
}


@pytest.mark.parametrize("message", DAMAGE)
def test_damage_is_named(message: str, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(RobotError, match=message):
        Robot.from_urdf(DAMAGE[message])
    assert capfd.readouterr().err == ""


def test_a_sound_urdf_passes() -> None:
    check_urdf(TEXT)
    assert Robot.from_urdf(TEXT).mass == pytest.approx(biped13().total_mass)
