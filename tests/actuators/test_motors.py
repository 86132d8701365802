"""Motor tables: hand-computed figures at the joint, and refusals of what cannot be."""

import re

import numpy as np
import pytest
from places import ROOT

from gaitopt.actuators.motors import (
    catalogue_of,
    joint_motors,
    known_motors,
    motors_of,
    read_motors,
)
from gaitopt.errors import InputError, RobotError, SpecError

TABLE = """
[motors.example]
torque_constant = 0.1
resistance = "100mOhm"
inertia = 1e-4
peak_current = 60.0
continuous_current = 20.0
voltage = 48.0
no_load_speed = "4400rpm"
mass = 0.6

[[drives]]
joints = "*"
motor = "example"
ratio = 20
efficiency = 0.9
friction = 1.5

[[drives]]
joints = "knee"
motor = "ak80-6"
ratio = 6
"""


def changed(old, new):
    assert old in TABLE
    return TABLE.replace(old, new, 1)


def test_figures_at_the_joint_by_hand():
    table = motors_of(TABLE)
    hip, knee = table.at_joints
    assert hip.peak_torque == pytest.approx(0.1 * 20 * 0.9 * 60 - 1.5)
    assert hip.continuous_torque == pytest.approx(0.1 * 20 * 0.9 * 20 - 1.5)
    assert hip.stall_torque == pytest.approx(0.1 * 20 * 0.9 * 480 - 1.5)
    assert hip.no_load_speed == pytest.approx(4400 * 2 * np.pi / 60 / 20)
    assert hip.loss == pytest.approx(0.1 / 1.8**2)  # 1 A is 1.8 N·m and 0.1 W
    assert table.drives[0].armature == pytest.approx(0.04)
    assert knee.peak_torque == pytest.approx(13.104)
    assert table.drive("left_knee").motor.mass == 0.485
    assert table.drive("left_hip_yaw").motor.name == "example"
    half = 0.5 * hip.no_load_speed
    assert hip.torque_at(np.array([0.0, -half, hip.no_load_speed, 99.0])) == pytest.approx(
        [hip.peak_torque, hip.peak_torque, 0.0, 0.0]
    )
    near = 0.9 * hip.no_load_speed
    assert hip.torque_at(np.array([near])) == pytest.approx([0.1 * hip.stall_torque])


def test_known_motors_have_a_source_and_agree_with_their_published_peaks():
    motor = known_motors()["ak80-6"]
    assert all(one.source for one in known_motors().values())
    assert motor.torque_constant * motor.peak_current == pytest.approx(2.184)
    assert motor.torque_constant / np.sqrt(motor.resistance) == pytest.approx(0.2206, rel=1e-3)
    assert motor.no_load_speed == pytest.approx(251.2, rel=1e-3)


def test_motors_of_pairs():
    names, mirror = ("right_knee", "left_knee", "waist"), np.eye(3)[[1, 0, 2]]
    motors = motors_of(TABLE).at_joints
    found = joint_motors(motors, names, mirror)
    assert [one.joints for one in found] == ["knee", "knee", "*"]
    assert joint_motors(motors[1:], names, mirror)[2] is None
    uneven = (motors[0], motors[1]._replace(joints="left_knee"))
    with pytest.raises(SpecError, match="'right_knee' and 'left_knee' have different motors"):
        joint_motors(uneven, names, mirror)
    with pytest.raises(SpecError, match=r"'elbow', but no joint that moves.*right_knee"):
        joint_motors((motors[0]._replace(joints="elbow"),), names, mirror)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"4400rpm"', "4400", r"induces 440 V .* above its supply of 48 V.*\"2400rpm\""),
        ("torque_constant = 0.1", "torque_constant = 0.0001", "far below its supply of 48 V"),
        ("peak_current = 60.0", "peak_current = 600.0", "600 A cannot flow: 48 V drive 480 A"),
        ("continuous_current = 20.0", "continuous_current = 80", "80 A, above the peak of 60 A"),
        ("inertia = 1e-4", "inertia = -1e-4", r"inertia is -0.0001 kg·m²; it must be above 0"),
        ('"100mOhm"', '"100mW"', "resistance = '100mW' is wrong; give a number in Ω"),
        ("mass = 0.6", "", "mass is missing; give every figure"),
        ("mass = 0.6", "mas = 0.6", "unknown entry 'mas'; did you mean 'mass'"),
        ("mass = 0.6", "mass = nan", "mass is nan; it must be a finite number"),
        ("efficiency = 0.9", "efficiency = 90", "efficiency is 90; it must be a share, at most 1"),
        ("ratio = 20", "ratio = 0", "ratio is 0; it must be above 0"),
        ("friction = 1.5", "friction = -1", "friction is -1 N·m; it must be 0 or more"),
        ("friction = 1.5", "friction = 40", r"40 N·m, but .* 36 N·m .* no torque is left"),
        ('motor = "example"', 'motor = "exmple"', "there is no motor 'exmple'; .*there are ak80-6"),
        ('joints = "*"\n', "", "joints is missing"),
        ("[motors.example]", "[motor.example]", "unknown entry 'motor'; did you mean 'motors'"),
        ("ratio = 20", "ratio = ", "not TOML"),
        ("ratio = 20", "ratio = 1e30", r"ratio is 1e\+30; it must be from 0.01 to 10000"),
        ("ratio = 20", "ratio = 1e-4", "ratio is 0.0001; it must be from 0.01"),
        ("ratio = 20", "ratio = inf", "ratio is inf; it must be a finite number"),
        ("ratio = 20", "ratio = true", "ratio = 'True' is wrong; give a number"),
        ("ratio = 20", 'ratio = "6:1"', "ratio = '6:1' is wrong; give a number"),
        ("inertia = 1e-4", "inertia = 535", r'at most 1 kg·m², as in inertia = "535gcm2"'),
        ("inertia = 1e-4", "inertia = 0", "inertia is 0 kg·m²; it must be above 0"),
        ("mass = 0.6", "mass = 600", 'it must be at most 200 kg, as in mass = "600g"'),
        ("mass = 0.6", "mass = 1979-05-27", "mass = '1979-05-27' is wrong; give a number in kg"),
        ("mass = 0.6", 'mass = 0.6\nname = "x"', "unknown entry 'name'"),
        ("torque_constant = 0.1", "torque_constant = 100", r"4.608e\+04 V .* above its supply"),
        ("torque_constant = 0.1", 'torque_constant = "91mNm"', "give a number in N·m/A"),
        ('"100mOhm"', "100", "60 A cannot flow: 48 V drive 0.48 A through 100 Ω"),
        ('"100mOhm"', "0", "resistance is 0 Ω; it must be above 0"),
        ("voltage = 48.0", "voltage = -48", "voltage is -48 V; it must be above 0"),
        ("voltage = 48.0", "voltage = 48000", "far below its supply of 48000 V"),
        ("efficiency = 0.9", "efficiency = 0", "efficiency is 0; it must be above 0"),
        ("efficiency = 0.9", "efficiency = 1e-9", "no torque is left"),
        ("friction = 1.5", 'friction = "1.5kg"', "give a number in N·m, if you like with its unit"),
        ("friction = 1.5", "friction = 1e9", "friction is .*; it must be at most 10000 N·m"),
        ('motor = "example"', "motor = 3", "motor must be a text, got '3'"),
        ('motor = "example"', 'motor = ["example"]', "motor must be a text"),
        ('motor = "example"', "", r"motor is missing; give it in every \[\[drives\]\] entry"),
        ('joints = "*"', 'joints = ["a", "b"]', r"give each pattern a \[\[drives\]\] entry"),
        ('joints = "*"', 'joints = ""', "joints must be a pattern of joint names"),
        ("[motors.example]", "[motors]", "must hold tables|give a table"),
        ("[motors.example]", "gear = 3\n[motors.example]", "'gear': a catalogue is for gaitopt"),
    ],
)  # fmt: skip
def test_tables_that_cannot_be_are_refused_with_words(old, new, said):
    with pytest.raises(SpecError, match=said):
        motors_of(changed(old, new))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("drives = [1, 2]", "drive 1: give a table with joints, motor"),
        ("[drives]\njoints = '*'", r"write each drive as \[\[drives\]\]"),
        ("[[drives]]\njoints='*'\nmotor='ak80-6'\n" * 1001, "1001 drives are too many; give 1000"),
        ("motors = [1]\n[[drives]]\njoints = '*'", "'motors' must hold tables"),
        ("motors.one = 3\n[[drives]]\njoints = '*'", "motor 'one': give a table with source"),
        ("", "there are no drives"), ("motors = [", "not TOML"),
    ],
)  # fmt: skip
def test_whole_tables_that_cannot_be_are_refused(text, said):
    with pytest.raises(SpecError, match=said):
        motors_of(text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "there are no motors"), ("known = 3", "'known' a list"),
        ("known = [[1]]", r"there is no motor '\[1\]'; there are ak80-6"),
        ("known = [{a = 1}]", "there is no motor"), ('known = ["x"]', "there is no motor 'x'"),
        ('known = ["ak80-6"]\ngear = [1]', "'gear' must be a table"),
        ('known = ["ak80-6"]\n[gear]\nratios = 5', "ratios must be a list"),
        ('known = ["ak80-6"]\n[gear]\nratios = ["5"]', "ratio is '5'; it must be a finite"),
        ('known = ["ak80-6"]\n[gear]\nratios = [-5]', "ratio is -5; it must be above 0"),
        ('known = ["ak80-6"]\n[gear]\nratios = [1e30]', "it must be from 0.01 to 10000"),
        ('known = ["ak80-6"]\n[gear]\nratio = [5]', "did you mean 'ratios'"),
        ('known = ["ak80-6"]\n[gear]\nefficiency = 2', "it must be a share, at most 1"),
        ('known = ["ak80-6"]\n[gear]\nfriction = 1e30', "it must be at most 10000 N·m"),
        ("[[drives]]\njoints = '*'", "unknown entry 'drives': a table with them is for --motors"),
    ],
)  # fmt: skip
def test_catalogues_that_cannot_be_are_refused(text, said):
    with pytest.raises(SpecError, match=said):
        catalogue_of(text)


def test_the_example_is_a_table_that_says_it_is_one():
    table = read_motors(ROOT / "examples" / "motors.toml")
    assert {one.motor.name for one in table.drives} == {"example"}
    assert "no product" in table.drives[0].motor.source


def test_what_the_page_shows_runs(monkeypatch):
    text = (ROOT / "docs" / "motors.md").read_text("utf-8")
    blocks = re.findall(r"```(toml|python)\n(.*?)```", text, re.S)
    ((kind, table), (language, code), (_, gear)) = blocks
    motors, gears = catalogue_of(f"{table.partition('[[drives]]')[0]}\n{gear}")
    assert list(motors) == ["example"]
    assert gears == {"ratios": (4, 5, 6, 8, 10, 12, 15, 20, 25, 30), "efficiency": 0.9,
                     "friction": 0.3}  # fmt: skip
    assert (kind, language) == ("toml", "python")
    assert (ROOT / "examples" / "motors.toml").read_text("utf-8").endswith(table)
    monkeypatch.chdir(ROOT)
    names: dict[str, object] = {}
    exec(compile(code, "docs/motors.md", "exec"), names)
    assert names["task"].cost.motors == names["task"].constraints[0].motors == names["motors"]


def test_a_table_without_drives_or_without_a_file(tmp_path):
    with pytest.raises(SpecError, match="there are no drives"):
        motors_of(TABLE.split("[[drives]]")[0])
    with pytest.raises(RobotError, match="cannot read the motor table"):
        read_motors(tmp_path / "none.toml")
    (tmp_path / "motors.toml").write_text(TABLE)
    assert len(read_motors(tmp_path / "motors.toml").drives) == 2
    assert issubclass(SpecError, InputError)
