"""Loads and gravity: the robot is the one whose file has them."""

from xml.etree import ElementTree as ET

import numpy as np
import pytest
from urdf_edits import edited_urdf

from gaitopt.cli.request import payload_of
from gaitopt.errors import InputError, RobotError
from gaitopt.gait import quantities
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import robot_of
from gaitopt.model.import_options import ImportOptions, Payload, choices_from_toml
from gaitopt.model.robot import Robot

MASS, PLACE, BOX = 7.5, (0.08, 0.0, 0.21), (0.3, 0.2, 0.4)
LOAD = Payload("torso", MASS, PLACE, BOX)


def written_into_the_file(root):
    """Fix a link with the box to the torso."""
    a, b, c = BOX
    ixx, iyy, izz = (MASS * (u**2 + v**2) / 12.0 for u, v in ((b, c), (a, c), (a, b)))
    root.append(
        ET.fromstring(
            f"<link name='load'><inertial><mass value='{MASS}'/><inertia ixx='{ixx!r}' "
            f"iyy='{iyy!r}' izz='{izz!r}' ixy='0' ixz='0' iyz='0'/></inertial></link>"
        )
    )
    root.append(
        ET.fromstring(
            "<joint name='strap' type='fixed'><parent link='torso'/><child link='load'/>"
            "<origin xyz='{} {} {}'/></joint>".format(*PLACE)
        )
    )


@pytest.fixture(scope="module")
def loaded(robot):
    return Robot.from_urdf(robot.urdf, choices=ImportOptions(payloads=(LOAD,)))


def test_a_load_is_the_same_mass_written_into_the_file(loaded):
    written = Robot.from_urdf(edited_urdf(written_into_the_file))
    for own, other in zip(loaded.model.inertias, written.model.inertias, strict=True):
        np.testing.assert_allclose(
            own.toDynamicParameters(), other.toDynamicParameters(), rtol=1e-12, atol=1e-12
        )
    task = preset_task("standard", speed=0.8)
    problems = [WalkProblem(one, task) for one in (loaded, written)]
    x = first_guess(problems[0])
    steps = [problem.step(x) for problem in problems]
    for name in (quantities.TORQUE, quantities.WRENCH):
        own, other = (step.read(name) for step in steps)
        np.testing.assert_allclose(own, other, atol=1e-12 * np.abs(other).max())


@pytest.mark.parametrize("name", ["torso", "pelvis"])
def test_torso_and_pelvis_are_words_for_links_of_any_robot(name):
    urdf = edited_urdf(lambda root: None).replace('"torso"', '"trunk_link"')
    robot = Robot.from_urdf(urdf, choices=ImportOptions(payloads=(Payload(name, 2.0),)))
    load = robot.choices.payloads[0]
    own = robot.multibody.centre[0]  # of trunk and load together
    assert load.link == "trunk_link"
    assert load.place == pytest.approx(own, abs=1e-12)  # at the link's own centre of mass


def test_a_gait_records_its_load_and_gravity(robot, tmp_path):
    choices = ImportOptions(payloads=(LOAD, Payload("pelvis", 1.0)), gravity=1.62)
    moon = Robot.from_urdf(robot.urdf, choices=choices)
    problem = WalkProblem(moon, preset_task("standard", speed=0.5, slope=0.05))
    path = save_gait(gait_at(problem, first_guess(problem), {}), tmp_path / "moon.npz")
    gait = load_gait(path)
    again = robot_of(gait)
    assert again.mass == moon.mass == pytest.approx(robot.mass + MASS + 1.0, rel=1e-14)
    assert np.linalg.norm(again.model.gravity.linear) == pytest.approx(1.62, rel=1e-15)
    assert np.array_equal(again.multibody.gravity, problem.robot.multibody.gravity)
    assert gait.fact("physics", "gravity_from") == "chosen"
    assert gait.fact("physics", "gravity_m_per_s2") == pytest.approx(1.62, rel=1e-15)


def test_the_weight_follows_gravity(robot):
    moon = Robot.from_urdf(robot.urdf, choices=ImportOptions(gravity=1.62))
    assert moon.weight == pytest.approx(robot.mass * 1.62)
    assert [f.text for f in moon.findings if f.topic == "gravity"] == [
        "1.62 m/s² downward, as chosen"
    ]


@pytest.mark.parametrize(
    ("text", "load"),
    [
        ("10kg@torso", Payload("torso", 10.0)),
        ("500g@left_hand", Payload("left_hand", 0.5)),
        ("3@torso:0.1,0,20cm", Payload("torso", 3.0, (0.1, 0.0, 0.2))),
        ("3@torso:0.1,0,0.2:0.3x20cmx0.1", Payload("torso", 3.0, (0.1, 0.0, 0.2), (0.3, 0.2, 0.1))),
    ],
)
def test_loads_are_read_from_the_command_line(text, load):
    assert payload_of(text) == load


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("10kg", "there is no link"),
        ("10kg@torso:1,2", "'1,2' is not three lengths"),
        ("10kg@torso:0,0,0:1x1x1:2", "more than place and box"),
        ("10N@torso", "give a number in kg"),
    ],
)
def test_what_is_no_load_is_told(text, reason):
    with pytest.raises(InputError, match="as in --payload 10kg@torso") as told:
        payload_of(text)
    assert reason in str(told.value)


@pytest.mark.parametrize(
    ("choices", "reason"),
    [
        (
            {"link": "torsso", "mass": 1.0},
            r"no link 'torsso'; did you mean 'torso'\? give one of torso, pelvis, left_hip_yaw",
        ),
        ({"link": "pelvs", "mass": 1.0}, "there is no link 'pelvs'; did you mean 'pelvis'"),
        ({"link": "torso", "mass": -1.0}, "mass is -1 kg; it must be > 0"),
        ({"link": "torso"}, "mass is missing"),
        ({"mass": 1.0}, "link is missing"),
        ({"link": "torso", "mass": 1.0, "box": [1.0, 1.0]}, "box has 2 numbers"),
        ({"link": "torso", "mass": 1.0, "box": [1.0, 1.0, -1.0]}, "no length may be negative"),
    ],
)
def test_choices_of_loads_are_checked(robot, choices, reason):
    entries = "\n".join(f"{name} = {value!r}" for name, value in choices.items())
    with pytest.raises(RobotError, match=reason.replace("(", r"\(")):
        Robot.from_urdf(robot.urdf, choices=choices_from_toml(f"[[payloads]]\n{entries}\n"))


@pytest.mark.parametrize(
    ("choices", "reason"),
    [
        ({"gravity": 0.0}, "needs at least 0.01"),
        ({"gravity": np.nan}, "gravity must be a number"),
        ({"gravity": 3.7, "without": ("gravity",)}, "leave out one of the two"),
    ],
)
def test_gravity_is_checked(choices, reason):
    with pytest.raises(RobotError, match=reason):
        ImportOptions(**choices)
