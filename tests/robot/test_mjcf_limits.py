"""Which limits of an MJCF file count: those of MuJoCo, that Pinocchio would take all."""

from xml.etree import ElementTree as ET

import numpy as np
import pytest
from mjcf_edits import at, edited, together

from gaitopt.robot.files.source import read_source

TEXT = """<mujoco><compiler angle='radian'/>
<default><joint range='-2 3' actuatorfrcrange='-70 80'/>
 <default class='own'><joint/><motor/></default></default>
<worldbody><body name='pelvis'><freejoint/>
 <inertial pos='0 0 0' mass='3' diaginertia='0.1 0.2 0.2'/>
 <body name='leg' pos='0 0.1 -0.2'><inertial pos='0 0 0' mass='2' diaginertia='0.1 0.1 0.15'/>
  <joint name='knee' axis='0 1 0' class='own'/>
 </body></body></worldbody>
<actuator><motor joint='knee' class='own' gear='4'/></actuator></mujoco>"""
INF = np.inf
OWN, CLASS = ".//worldbody//joint", ".//default/default/joint"


def limits(*edits):
    """The lower and upper limit [rad] and the torque limit [N·m] of the knee."""
    source = read_source(edited(TEXT, together(*edits)))
    assert source.problems == ()
    model = source.model()
    return model.lowerPositionLimit[7], model.upperPositionLimit[7], model.effortLimit[6]


@pytest.mark.parametrize("place", [OWN, CLASS])
@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({}, (-2.0, 3.0)),
        ({"range": "-1 1"}, (-1.0, 1.0)),
        ({"range": "-1 1", "limited": "true"}, (-1.0, 1.0)),
        ({"range": "-1 1", "limited": "auto"}, (-1.0, 1.0)),
        ({"range": "-1 1", "limited": "false"}, (-INF, INF)),
        ({"range": "1 -1", "limited": "false"}, (-INF, INF)),
        ({"range": "0 0", "limited": "false"}, (-INF, INF)),
        ({"range": "0 0", "limited": "auto"}, (-INF, INF)),
        ({"range": "0 0"}, (-INF, INF)),
        ({"limited": "false"}, (-INF, INF)),
    ],
)
def test_a_range_counts_as_limited_says(place, values, expected):
    assert limits(at(place, **values)) == (*expected, 70.0)


@pytest.mark.parametrize("place", [OWN, CLASS])
@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"actuatorfrcrange": "-1 1"}, 1.0),
        ({"actuatorfrcrange": "-1 1", "actuatorfrclimited": "true"}, 1.0),
        ({"actuatorfrcrange": "-1 1", "actuatorfrclimited": "false"}, INF),
        ({"actuatorfrcrange": "0 0"}, INF),
        ({"actuatorfrclimited": "false"}, INF),
    ],
)
def test_a_torque_range_counts_as_limited_says(place, values, expected):
    assert limits(at(place, **values)) == (-2.0, 3.0, expected)


@pytest.mark.parametrize("place", [".//actuator/motor", ".//default/default/motor"])
@pytest.mark.parametrize("kind", ["ctrl", "force"])
def test_a_range_of_a_motor_counts_as_limited_says(place, kind):
    given = at(place, **{f"{kind}range": "-5 5"})
    assert limits(given)[2] == 20.0
    assert limits(given, at(place, **{f"{kind}limited": "false"}))[2] == 70.0


def test_without_autolimits_only_what_says_so_is_limited():
    plain = at("compiler", autolimits="false")
    assert limits(plain) == (-INF, INF, INF)
    assert limits(plain, at(OWN, limited="true")) == (-2.0, 3.0, INF)
    assert limits(plain, at(CLASS, actuatorfrclimited="true")) == (-INF, INF, 70.0)


def test_a_range_that_counts_may_not_be_empty():
    text = edited(TEXT, at(OWN, range="0 0", limited="true"))
    (problem,) = read_source(text).problems
    assert (problem.kind, problem.name) == ("range", "knee")
    assert "the range is from 0 to 0 rad; lower must be below upper" in problem.text


def test_a_range_of_a_class_is_counted_from_the_posture_of_the_file():
    assert limits(at(OWN, ref="0.5")) == (-2.5, 2.5, 70.0)
    assert ET.fromstring(TEXT).find(OWN).get("range") is None
