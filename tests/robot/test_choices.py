import json
import math
from dataclasses import fields

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.errors import RobotError
from gaitopt.model.import_options import (
    AXES,
    UNEQUAL,
    ImportOptions,
    LimitOverride,
    choices_from_record,
    choices_from_toml,
    choices_record,
)
from gaitopt.model.robot import Robot
from gaitopt.model.sole import Sole

quick = settings(deadline=None, derandomize=True, max_examples=40)
numbers = st.floats(0.01, 100.0)
names = st.text("abc_12 é", min_size=1, max_size=8)

SOLES = st.builds(lambda a, b, c, d: Sole(a, -b, c, -d), *[st.floats(0.001, 0.3)] * 4)
OVERRIDES = st.builds(
    LimitOverride,
    joints=names,
    torque=st.none() | numbers | st.just(math.inf),
    speed=st.none() | numbers | st.just(math.inf),
    lower=st.none() | st.floats(-3.0, -0.1) | st.just(-math.inf),
    upper=st.none() | st.floats(0.1, 3.0) | st.just(math.inf),
    armature=st.none() | st.floats(0.0, 1.0),
)
CHOICES = st.builds(
    ImportOptions,
    feet=st.none() | st.tuples(names, names),
    stance=st.sampled_from([None, "right", "left"]),
    stance_sole=st.none() | names,
    forward=st.none() | st.sampled_from(sorted(AXES)) | st.just((0.6, 0.8, 0.0)),
    up=st.none() | st.sampled_from(sorted(AXES)),
    posture=st.none() | names | st.dictionaries(names, st.floats(-3.0, 3.0), min_size=1),
    srdf=st.none() | names,
    rotors=st.booleans(),
    sole=st.none() | SOLES,
    sole_drop=st.none() | st.floats(0.01, 0.5),
    sole_placements=st.none() | st.just((tuple(map(float, range(12))), (0.1,) * 12)),
    limits=st.lists(OVERRIDES, max_size=3).map(tuple),
    unequal_limits=st.sampled_from(UNEQUAL),
    asymmetry=st.floats(0.0, 1.0),
    package_dirs=st.lists(names, max_size=2).map(tuple),
)


@quick
@given(CHOICES)
def test_a_record_is_plain_and_gives_the_same_choices(choices):
    record = json.loads(json.dumps(choices_record(choices), allow_nan=False))
    assert choices_from_record(record) == choices


def test_only_what_was_chosen_is_recorded():
    assert choices_record(ImportOptions(forward="-x", sole_drop=0.07)) == {
        "forward": "-x",
        "sole_drop": 0.07,
    }


TOML = """
feet = ["r_foot", "l_foot"]
forward = "-x"
unequal_limits = "tighter"
sole_drop = 0.035
[sole]
toe = 0.12
heel = -0.05
left = 0.03
right = -0.03
[posture]
waist_yaw = 0.1
[[limits]]
joints = "*knee*"
torque = 60
[[limits]]
joints = "*"
speed = "none"
lower = "none"
"""
READ = ImportOptions(
    feet=("r_foot", "l_foot"),
    forward="-x",
    unequal_limits="tighter",
    sole_drop=0.035,
    sole=Sole(0.12, -0.05, 0.03, -0.03),
    posture=(("waist_yaw", 0.1),),
    limits=(
        LimitOverride("*knee*", torque=60.0),
        LimitOverride("*", speed=math.inf, lower=-math.inf),
    ),
)


def test_a_toml_file_and_its_text_are_read(tmp_path):
    path = tmp_path / "robot.toml"
    path.write_text(TOML, encoding="utf-8")
    assert choices_from_toml(TOML) == choices_from_toml(path) == READ
    assert choices_from_toml(str(path)) == READ


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            'foward = "x"',
            r"unknown entry foward; did you mean 'forward'\? known are: feet, ",
        ),
        ("[sole]\ntoes = 1", r"unknown entry sole.toes; did you mean 'toe'\? known are: toe, heel"),
        ("[sole]\ntoe = 1", "sole.heel is missing; give toe, heel, left and right"),
        ("[sole]\ntoe = 'a'\nheel=0\nleft=1\nright=0", "toe = 'a' is wrong; give a number in m"),
        ("[[limits]]\njoints='*'\ntorqe=1", "unknown entry limits.torqe; did you mean 'torque'"),
        ("[[limits]]\ntorque=1", "limits: joints is missing"),
        ("[[limits]]\njoints='*k'\ntorque=-1", r"limits of '\*k': torque is -1; it must be > 0"),
        (
            "[[limits]]\njoints='*k'\nspeed='fast'",
            r"speed = 'fast' is wrong; give a number in rad/s",
        ),
        ("[[limits]]\njoints='a'\nlower=1\nupper=0.5", "from 1 to 0.5 rad; lower must be below"),
        (
            "[[limits]]\njoints='a'\nlower='20 cm'\nupper=0.1",
            "from 0.2 to 0.1 m; lower must be below",
        ),
        (
            "[[limits]]\njoints='a'\nlower='2 m'\narmature=2000",
            "armature is 2000 kg; it must be from 0 to 1000 kg",
        ),
        ("[[limits]]\njoints='a'\nlower=inf\nupper='2 m'", r"is inf m, .* travel \[m\], or"),
        ("[[limits]]\njoints='a'\nlower=inf", "'a': lower is inf rad, .* finite angle .*-inf in"),
        ("[[limits]]\njoints='a'\nupper=-inf", "'a': upper is -inf rad, which no joint can keep"),
        (
            "[[limits]]\njoints='a'\narmature=-0.1",
            "armature is -0.1 kg·m²; .* from 0 to 1000 kg·m²",
        ),
        ("[[limits]]\njoints='a'\narmature=inf", "armature is inf kg·m²; .* from 0 to 1000 kg·m²"),
        ("[[limits]]\njoints='a'\nspeed=1\nunits=3", "limits: units must be a list, got 3"),
        ("[limits]\njoints='a'", r"limits must be a list of tables \(\[\[limits\]\]\)"),
        ("forward = 'north'", "forward is 'north'; it must be one of 'x', 'y'"),
        ("up = [0, 0, 0]", r"up must be an axis name \(x, y, .*\) or three numbers, not all 0"),
        ("up = ['z']", r"up must be an axis name \(x, y, z, -x, -y, -z\) or three numbers"),
        ("forward = 3", r"forward must be an axis name \(x, .*\) or three numbers, .*; got 3"),
        ("feet = ['a']", "feet must be two names, right foot first, got 1: a"),
        ("feet = 'ab'", "feet must be a list, got 'ab'"),
        ("feet = [1, 2]", "feet must be a list of texts, got 1 in it; quote it"),
        ("feet = [['a'], ['b']]", r"feet must be a list of texts, got \['a'\] in it"),
        ("package_dirs = [3]", "package_dirs must be a list of texts, got 3 in it"),
        ("posture = 3", r"posture must be the name of a pose .* angles \[rad\] by joint .*got 3"),
        ("posture = true", "posture must be the name of a pose in the SRDF, .* got True"),
        ("posture = ['a']", r"posture must be the name of a pose in the SRDF, .* got \['a'\]"),
        ("posture = 2020-01-01", r"posture must be the name of a pose .* got datetime\.date"),
        (f"asymmetry = 1{400 * '0'}", "asymmetry is too large: 401 digits"),
        ("stance = 'both'", "stance is 'both'; it must be one of 'right', 'left'"),
        ("unequal_limits = 'x'", "unequal_limits is 'x'; it must be one of 'refuse', 'tighter'"),
        ("sole_drop = 70", "sole_drop is 70 m; it must be above 0 and below 1"),
        ("asymmetry = -1", "asymmetry is -1; it must be from 0 to 1"),
        ("[posture]\nwaist = 'bent'", "posture: waist = 'bent' is wrong; give a number in rad"),
        ("sole_placements = [[1], [2]]", "sole_placements must be 2 lists of 12 numbers"),
        ("rotors = 1", "rotors must be true or false, got 1"),
        ("srdf = 3", "srdf must be text, got 3"),
        ("a = [", "not TOML: .*; correct that line"),
    ],
)
def test_what_cannot_be_used_is_named(text, message):
    with pytest.raises(RobotError, match=f"^the choices: .*{message}"):
        choices_from_toml(text)


def test_paths_in_a_file_are_relative_to_it(tmp_path, monkeypatch):
    (tmp_path / "robot").mkdir()
    path = tmp_path / "robot" / "choices.toml"
    path.write_text(
        f'srdf = "poses/a.srdf"\nposture = "stand"\npackage_dirs = ["..", "{tmp_path}"]',
        encoding="utf-8",
    )
    monkeypatch.chdir(tmp_path)
    choices = choices_from_toml("robot/choices.toml")
    assert choices.srdf == str(tmp_path / "robot" / "poses" / "a.srdf")
    assert choices.package_dirs == (str(tmp_path / "robot" / ".."), str(tmp_path))
    path.write_text('srdf = "<robot/>"\nrotors = true', encoding="utf-8")
    assert choices_from_toml(path).srdf == "<robot/>"


def test_an_srdf_that_is_not_used_is_refused(tmp_path):
    with pytest.raises(RobotError, match=r"^the choices: an SRDF is .* nothing of it is used"):
        choices_from_toml('srdf = "a.srdf"\n[posture]\nwaist = 0.1')
    # A pose may still be asked for elsewhere.
    path = tmp_path / "choices.toml"
    path.write_text('srdf = "a.srdf"', encoding="utf-8")
    with pytest.raises(RobotError, match=r"name one of its poses .* or leave it out"):
        Robot.from_urdf(urdf_text(biped13()), choices=choices_from_toml(path))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(RobotError, match=r"cannot read the choices '.*none.toml'"):
        choices_from_toml(tmp_path / "none.toml")


def test_given_arguments_go_before():
    choices = ImportOptions(stance_sole="a", swing_sole="b").over(stance_sole="c", swing_sole=None)
    assert (choices.stance_sole, choices.swing_sole) == ("c", "b")


def test_every_choice_is_documented():
    assert ImportOptions.__doc__ is not None
    for entry in fields(ImportOptions):
        assert (
            f"{entry.name}:" in ImportOptions.__doc__ or f"{entry.name}," in ImportOptions.__doc__
        )


TABLES = {
    "limits": [{"joints": "*knee*", "torque": "40Nm", "speed": 3.0}],
    "inertias": [{"links": "*foot*", "mass": "900g"}],
    "proportions": [{"part": "thigh", "longer": "2cm"}],
    "payloads": [{"link": "torso", "mass": "10kg", "place": [0.1, 0.0, 0.2]}],
}


@pytest.mark.parametrize("name", TABLES)
def test_tables_in_python_are_those_of_a_file(name):
    made = ImportOptions(**{name: TABLES[name]})
    assert made == choices_from_record({name: TABLES[name]})
    assert ImportOptions(**{name: getattr(made, name)}) == made
    assert choices_record(made)[name]


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("value", ["10kg@torso", 3.0, ["thigh"], [None], [{"what": 1.0}]], ids=str)
def test_what_is_no_table_is_refused_in_python_too(name, value):
    with pytest.raises(RobotError, match=name):
        ImportOptions(**{name: value})
