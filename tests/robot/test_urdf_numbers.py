"""Numbers of a URDF: one grammar, to the last digit, in every place where one stands."""

import re
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from places import CASES
from urdf_edits import edited_urdf, joint, link

from gaitopt.errors import RobotError
from gaitopt.importers.reader import read_source
from gaitopt.importers.xml_document import as_number, as_numbers

MEANT = {
    "40.55": 40.55, "40.55 ": 40.55, " 40.55": 40.55, "40.55\t": 40.55, "\n40.55\r\n": 40.55,
    "+40.55": 40.55, ".5": 0.5, "5.": 5.0, "4055e-2": 40.55, "0.4055E+02": 40.55,
    "0.1000000000000000055511151231257827": 0.1, "1e-310": 1e-310, "007": 7.0,
}  # fmt: skip
NOT_MEANT = (
    "", " ", "4_0", "\u0664", "\uff14\uff10", "40\u00a0", "0x28", "0x1p3", "nan", "1,5", "40,",
    "1e", "e5", ".", "+", "--4", "+-4", "4 0", "40f", "40d0", "40 kg", "${mass}", "True", "1e+",
    "1.2.3",
)  # fmt: skip


@pytest.mark.parametrize("text", MEANT)
def test_numbers_are_read_as_they_are_meant(text):
    assert as_number(text) == MEANT[text]


@pytest.mark.parametrize("text", NOT_MEANT)
def test_what_is_no_number_is_none(text):
    assert np.isnan(as_number(text))


@pytest.mark.parametrize("text", ["inf", " -Infinity", "+INF"])
def test_no_limit_may_be_said_in_words(text):
    assert np.isinf(as_number(text))


@pytest.mark.parametrize(
    ("text", "count"), [("1 2 3", 3), (" 1\t2\n3 ", 3), ("1\u00a02 3", 2), ("", 0), ("1 2", 2)]
)
def test_blanks_of_xml_part_numbers(text, count):
    assert len(as_numbers(text)) == count


PLACES = {
    "mass": ("link", "left_shin", "inertial/mass", "value", 1),
    "ixx": ("link", "left_shin", "inertial/inertia", "ixx", 1),
    "iyz": ("link", "left_shin", "inertial/inertia", "iyz", 1),
    "centre": ("link", "left_shin", "inertial/origin", "xyz", 3),
    "origin": ("joint", "left_knee", "origin", "xyz", 3),
    "turn": ("joint", "left_knee", "origin", "rpy", 3),
    "axis": ("joint", "left_knee", "axis", "xyz", 3),
    "lower": ("joint", "left_knee", "limit", "lower", 1),
    "effort": ("joint", "left_knee", "limit", "effort", 1),
    "velocity": ("joint", "left_knee", "limit", "velocity", 1),
    "damping": ("joint", "left_knee", "dynamics", "damping", 1),
    "friction": ("joint", "left_knee", "dynamics", "friction", 1),
    "soft": ("joint", "left_knee", "safety_controller", "soft_upper_limit", 1),
}


def with_number(place, change):
    """The generated biped, the last number in one place changed."""
    tag, name, path, attribute, count = PLACES[place]

    def edit(root):
        owner = {"link": link, "joint": joint}[tag](root, name)
        element = owner.find(path)
        if element is None:
            element = ET.SubElement(owner, path)
        words = element.get(attribute, " ".join(["0.25"] * count)).split()
        element.set(attribute, " ".join([*words[:-1], change(words[-1])]))

    return edited_urdf(edit)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("form", ["4_0", "\u0664", "0x28", "nan", "1,5", "1e", "40 kg", "4\u00a0"])
def test_every_number_is_refused_by_line_if_it_is_none(place, form, capfd):
    text = with_number(place, lambda _: form)
    owner = re.escape(f"{PLACES[place][0]} '{PLACES[place][1]}'")
    with pytest.raises(
        RobotError, match=rf"^line \d+: {owner}: .*(finite number|must be|no number)"
    ):
        read_source(text)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("form", ["{} ", "\t{}\n", "+{}"])
def test_every_number_is_read_as_it_is_meant(place, form):
    plain = read_source(with_number(place, lambda _: "0.25"))
    other = read_source(with_number(place, lambda _: form.format("0.25")))
    assert other.model() == plain.model()
    assert other.physics == plain.physics
    assert other.findings() == plain.findings()


def test_a_torso_with_a_blank_behind_its_mass_keeps_it():
    model = read_source(CASES / "mass_trailing_blank.urdf").model()
    assert pin.computeTotalMass(model) == pytest.approx(56.87)
    assert model.inertias[1].mass == 40.55


@pytest.mark.parametrize("count", [0, 1, 2, 4])
@pytest.mark.parametrize("place", ["centre", "origin", "turn", "axis"])
def test_vectors_have_three_numbers(place, count):
    tag, name, path, attribute, _ = PLACES[place]

    def edit(root):
        owner = {"link": link, "joint": joint}[tag](root, name)
        owner.find(path).set(attribute, " ".join(["1"] * count))

    with pytest.raises(RobotError, match=r"it must be three finite numbers"):
        read_source(edited_urdf(edit))


def test_a_digit_in_the_seventeenth_place_counts():
    mass = 3.0000000000000004
    model = read_source(with_number("mass", lambda _: repr(mass))).model()
    assert model.inertias[model.getJointId("left_knee")].mass == mass


def turned(version, **origin):
    def edit(root):
        root.attrib.update(version=version)
        placed = joint(root, "left_knee").find("origin")
        placed.attrib.clear()
        placed.attrib.update(xyz="0 0 -0.3", **origin)

    return edited_urdf(edit)


def test_a_quaternion_turns_as_it_does_in_version_1_2():
    text = turned("1.2", quat_xyzw="0.1 0.2 0.3 0.927362")
    ours, loaded = read_source(text).model(), pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    knee = ours.getJointId("left_knee")
    assert ours.jointPlacements[knee].isApprox(loaded.jointPlacements[knee], 1e-6)
    assert not np.allclose(ours.jointPlacements[knee].rotation, np.eye(3), atol=0.1)


@pytest.mark.parametrize(
    ("version", "origin", "message"),
    [
        ("1.0", {"quat_xyzw": "0 0 0 1"}, "counts from version 1.2"),
        ("1.2", {"quat_xyzw": "0 0 0 1", "rpy": "0 0 0"}, "both rpy and quat_xyzw"),
        ("1.2", {"quat_xyzw": "0 0 0 2"}, "has length 2; it must be 1"),
        ("1.2", {"quat_xyzw": "0 0 1"}, "must be four finite numbers"),
    ],
)
def test_a_quaternion_that_readers_take_differently_is_refused(version, origin, message):
    with pytest.raises(RobotError, match=message):
        read_source(turned(version, **origin))
