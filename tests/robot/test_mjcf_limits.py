"""Which limits of an MJCF file count: those of MuJoCo, that Pinocchio would take all."""

from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest
from mjcf_edits import added, at, edited, together

from gaitopt.errors import RobotError
from gaitopt.importers.reader import read_source

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


def test_without_autolimits_everything_must_say_whether_it_is_limited():
    plain = at("compiler", autolimits="false")
    with pytest.raises(RobotError, match=r"joint 'knee': .*joint has `range` but not `limited`"):
        limits(plain)
    said = {"limited": "true", "actuatorfrclimited": "true"}
    assert limits(plain, at(CLASS, **said)) == (-2.0, 3.0, 70.0)
    assert limits(plain, at(CLASS, **said), at(OWN, limited="false")) == (-INF, INF, 70.0)


def test_a_range_that_counts_may_not_be_empty():
    with pytest.raises(RobotError, match=r"joint 'knee': MuJoCo .*should be smaller"):
        read_source(edited(TEXT, at(OWN, range="0 0", limited="true")))


def test_a_range_is_one_of_mujocos_coordinate():
    assert limits(at(OWN, ref="0.5")) == (-2.0, 3.0, 70.0)
    assert ET.fromstring(TEXT).find(OWN).get("range") is None


KNEE = "joint='knee'"
MUSCLE = f"<muscle {KNEE} force='300' lengthrange='0.1 1' gear='1'/>"


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        ([f"<motor {KNEE} forcerange='-5 6' gear='3'/>"], 15.0),
        ([f"<motor {KNEE} forcerange='-5 6' gear='-3'/>"], 15.0),
        ([f"<motor {KNEE} ctrlrange='-5 6' forcerange='-4 9' gear='3'/>"], 12.0),
        ([f"<general {KNEE} ctrlrange='-1 1' gear='50' gainprm='3'/>"], 150.0),
        ([f"<general {KNEE} ctrlrange='-1 2' biastype='affine' biasprm='-0.5'/>"], 1.5),
        ([f"<position {KNEE} kp='9' forcerange='-7 7'/>"], 7.0),
        ([f"<position {KNEE} kp='9' ctrlrange='-7 7'/>"], INF),  # no bound of the force
        ([f"<velocity {KNEE} kv='9' forcerange='-7 7' gear='2'/>"], 14.0),
        ([f"<damper {KNEE} kv='9' ctrlrange='0 7'/>", f"<motor {KNEE} ctrlrange='-3 3'/>"], 3.0),
        ([f"<motor {KNEE} forcerange='-5 5'/>", f"<motor {KNEE} ctrlrange='-3 3'/>"], 8.0),
        ([f"<motor {KNEE} forcerange='-5 5'/>", f"<position {KNEE} kp='9'/>"], INF),
        ([f"<general {KNEE} dyntype='filter' dynprm='0.1' ctrlrange='-2 2' gear='4'/>"], 8.0),
        ([f"<general {KNEE} dyntype='integrator' actrange='-2 2' gear='4'/>"], 8.0),
        ([f"<intvelocity {KNEE} kp='9' actrange='-2 2' forcerange='-7 7' gear='-2'/>"], 14.0),
        ([f"<cylinder {KNEE} area='0.01' ctrlrange='-500 500' gear='-2'/>"], 10.0),
        ([MUSCLE, MUSCLE.replace("gear='1'", "gear='-1'")], 300.0),
        ([MUSCLE, MUSCLE.replace("gear='1'", "gear='-0.5' forcerange='-80 0'")], 40.0),
    ],
)
def test_the_ranges_of_all_actuators_add_up(texts, expected):
    without = [at(".//actuator/motor", joint="other"), added(".//body", OTHER)]
    free = at(CLASS, range="0 0", actuatorfrcrange="0 0")
    text = edited(TEXT, together(free, *without, added(".//actuator", *texts)))
    source = read_source(text)
    assert source.model().effortLimit[6] == expected
    clamped = edited(text, at(OWN, actuatorfrcrange="-6 6"))
    assert read_source(clamped).model().effortLimit[6] == min(6.0, expected)


OTHER = (
    "<body name='arm'><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>"
    "<joint name='other' axis='0 1 0'/></body>"
)


def test_a_tendon_passes_the_force_on():
    tendon = (
        "<tendon><fixed name='t' actuatorfrcrange='-4 4'><joint joint='knee' coef='2'/></fixed>"
        "</tendon>"
    )
    pulls = added(".//actuator", "<motor tendon='t' gear='3' forcerange='-9 9'/>")
    without = [at(".//actuator/motor", joint="other"), added(".//body", OTHER)]
    free = at(CLASS, range="0 0", actuatorfrcrange="0 0")
    text = edited(TEXT, together(free, *without, added(".", tendon), pulls))
    assert read_source(text).model().effortLimit[6] == 24.0


@pytest.mark.parametrize("others", ["", "<joint joint='other' coef='1'/>"])
def test_the_range_of_a_tendon_is_told_to_be_left_out(others):
    tendon = f"<fixed name='t' range='-1 1'><joint joint='knee' coef='2'/>{others}</fixed>"
    text = edited(TEXT, together(added(".//body", OTHER), added(".", f"<tendon>{tendon}</tendon>")))
    told = [f.text for f in read_source(text).notes if f.subject == "tendon 't'"]
    assert told == ["the range of this tendon is left out"]
    free = edited(text, at(".//fixed", limited="false"))
    assert not [f for f in read_source(free).notes if f.subject == "tendon 't'"]


@pytest.mark.parametrize("flag", ["equality", "limit", "spring", "damper", "frictionloss"])
def test_what_a_flag_switches_off_is_told(flag):
    told = f"<flag> in <option> switches off {flag}: what the file has of it does not count"
    text = edited(TEXT, added(".", f"<option><flag {flag}='disable'/></option>"))
    assert [f.text for f in read_source(text).notes if "<flag>" in f.text] == [told]
    assert not [f for f in read_source(TEXT).notes if "<flag>" in f.text]


MUSCLES = together(
    at(CLASS, actuatorfrcrange="0 0"),
    at(".//actuator/motor", joint="other"),
    added(".//body", OTHER),
)


def test_a_muscle_pulls_as_mujoco_says_at_its_best_length():
    source = read_source(edited(TEXT, together(MUSCLES, added(".//actuator", MUSCLE))))
    (joint,) = [j for j in source.compiled.joints if j.name == "knee"]
    model = mujoco.MjModel.from_xml_string(
        edited(TEXT, together(MUSCLES, added(".//actuator", MUSCLE)))
    )
    gain = model.actuator_gainprm[1, :9]
    best = max(
        abs(mujoco.mju_muscleGain(length, 0.0, model.actuator_lengthrange[1], 1.0, gain))
        for length in np.linspace(0.1, 1.0, 2001)
    )
    assert joint.least == pytest.approx(-best, rel=1e-6)
    assert joint.most == 0.0
    assert any("muscles count with their pull at rest" in f.text for f in source.notes)
    assert any("does not reach to both sides of 0" in p.text for p in source.problems)


@pytest.mark.parametrize(
    "words",
    [
        "motorconst='0.1' resistance='0.5' ctrlrange='-24 24' gear='50'",
        "motorconst='0.1 0.2' resistance='0.5' ctrlrange='-24 12' gear='-20'",
        "nominal='24 5 300' ctrlrange='-24 24' gear='10'",
        "motorconst='0.1' resistance='0.5' saturation='0 10 0' ctrlrange='-24 24' gear='9'",
        "motorconst='0.1' resistance='0.5' saturation='3 10 0' ctrlrange='-24 24'",
    ],
)
def test_a_dc_motor_counts_with_its_torque_at_rest(words):
    text = edited(TEXT, together(MUSCLES, added(".//actuator", f"<dcmotor {KNEE} {words}/>")))
    source, model = read_source(text), mujoco.MjModel.from_xml_string(text)
    forces, data, knee = [], mujoco.MjData(model), model.joint("knee").dofadr[0]
    for sign in (-1e3, 1e3):
        data.ctrl[1] = sign
        mujoco.mj_forward(model, data)
        forces.append(data.qfrc_actuator[knee])
    (joint,) = [j for j in source.compiled.joints if j.name == "knee"]
    assert [joint.least, joint.most] == pytest.approx(sorted(forces), rel=1e-12)
    assert any("DC motors count with their torque at rest" in f.text for f in source.notes)


def test_motors_that_the_options_switch_off_are_told():
    group = "<option actuatorgroupdisable='1'/>"
    text = edited(TEXT, together(at(".//actuator/motor", group="1"), added(".", group)))
    assert any("switches them off" in f.text for f in read_source(text).notes)
    flag = edited(TEXT, added(".", "<option><flag actuation='disable'/></option>"))
    assert read_source(flag).model().effortLimit[6] == 70.0
    assert any("switches all motors off" in f.text for f in read_source(flag).notes)
