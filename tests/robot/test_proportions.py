"""Longer, wider and heavier robots: the finite change against the derivatives of `Anatomy`."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from example_robots import needs_example_robots

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.entries import description, entry_by_name
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.design.robot_changes import Anatomy
from gaitopt.errors import RobotError
from gaitopt.importers.reader import read_source
from gaitopt.model.import_options import (
    ImportOptions,
    PartChange,
    Payload,
    choices_from_record,
    choices_record,
)
from gaitopt.model.importer import import_robot
from gaitopt.model.robot import Robot

CHANGES = {
    "thigh": PartChange("thigh", longer=1.0), "shin": PartChange("shin", longer=1.0),
    "hip width": PartChange("hip_width", longer=1.0),
    "foot length": PartChange("foot", longer=1.0),
    "ankle height": PartChange("ankle_height", longer=1.0),
    "thigh mass": PartChange("thigh", heavier=1.0), "shin mass": PartChange("shin", heavier=1.0),
    "foot mass": PartChange("foot", heavier=1.0), "trunk mass": PartChange("trunk", heavier=1.0),
}  # fmt: skip
STEP = 1e-5


def changed(robot, one, size):
    own = replace(one, longer=size * one.longer, heavier=size * one.heavier)
    return Robot.from_urdf(robot.urdf, choices=robot.choices.over(proportions=(own,)))


def moments(robot):
    """Masses, first and second moments of the bodies and places of the joints, as in changes."""
    model = robot.model
    bodies = [model.inertias[j] for j in range(1, model.njoints)]
    mass = np.array([b.mass for b in bodies])
    first = np.stack([b.mass * b.lever for b in bodies])
    own = np.stack([0.5 * np.trace(b.inertia) * np.eye(3) - b.inertia for b in bodies])
    second = own + np.stack([b.mass * np.outer(b.lever, b.lever) for b in bodies])
    joints = np.stack([model.jointPlacements[j].translation for j in range(2, model.njoints)])
    return mass, first, second, joints


@pytest.fixture(scope="module", params=["biped13", "g1", "talos"])
def robot(request):
    if request.param == "biped13":
        return Robot.from_urdf(urdf_text(biped13()))
    source, choices = description(entry_by_name(request.param))
    return Robot.from_urdf(source, choices=choices)


@needs_example_robots
@pytest.mark.parametrize("name", CHANGES)
def test_a_small_change_is_the_derivative(robot, name):
    expected = next(one for one in Anatomy(robot).changes if one.name == name)
    ends = [changed(robot, CHANGES[name], side * STEP) for side in (1.0, -1.0)]
    rates = [(a - b) / (2.0 * STEP) for a, b in zip(*map(moments, ends), strict=True)]
    for found, what in zip(rates, ("mass", "first", "second", "joints"), strict=True):
        known = getattr(expected, what)
        scale = max(float(np.abs(known).max()), 1e-3)
        np.testing.assert_allclose(found, known, rtol=0.0, atol=2e-6 * scale, err_msg=what)
    edges = [np.array([getattr(end.sole, e) for e in ("toe", "heel")]) for end in ends]
    np.testing.assert_allclose((edges[0] - edges[1]) / (2.0 * STEP), expected.sole[:2], atol=1e-6)
    soles, ankles = (
        [get(end) for end in ends]
        for get in (lambda r: r.model.frames[r.swing_frame].placement.translation,
                    lambda r: r.legs.ankles)
    )  # fmt: skip
    np.testing.assert_allclose((soles[0] - soles[1]) / (2.0 * STEP), expected.swing_sole, atol=1e-6)
    np.testing.assert_allclose((ankles[0] - ankles[1]) / (2.0 * STEP), expected.ankles, atol=1e-6)
    reach = (ends[0].legs.reach - ends[1].legs.reach) / (2.0 * STEP)
    assert reach == pytest.approx(expected.reach, abs=1e-6)


@needs_example_robots
def test_a_large_change_keeps_what_it_must(robot):
    longer = changed(robot, CHANGES["shin"], 0.05)
    assert longer.mass == pytest.approx(robot.mass, rel=1e-12)
    np.testing.assert_allclose(np.diff(longer.legs.hips[:, 1]), np.diff(robot.legs.hips[:, 1]))
    assert longer.sole == robot.sole
    wider = changed(robot, CHANGES["hip width"], 0.04)
    assert abs(wider.legs.spacing) == pytest.approx(abs(robot.legs.spacing) + 0.04, abs=1e-9)
    heavier = changed(robot, CHANGES["foot mass"], 0.2)
    assert heavier.mass == pytest.approx(robot.mass + 0.4, rel=1e-12)
    back = changed(longer, CHANGES["shin"], 0.05)  # the choices replace, they do not add up
    assert back.legs.reach == pytest.approx(longer.legs.reach, rel=1e-12)
    assert pin.computeTotalMass(longer.model) == pytest.approx(float(longer.multibody.mass.sum()))
    feet = robot.choices.over(
        proportions=(PartChange("foot", 0.03), PartChange("ankle_height", 0.02))
    )
    shod = Robot.from_urdf(robot.urdf, choices=feet)
    again = Robot.from_urdf(shod.urdf, choices=shod.choices)  # nothing is changed twice
    for one in (shod, again):
        assert one.sole.length == pytest.approx(robot.sole.length + 0.03, abs=1e-12)
        np.testing.assert_allclose(one.legs.ankles[:, 2] - robot.legs.ankles[:, 2], 0.02, atol=1e-9)
        assert one.legs.reach == pytest.approx(robot.legs.reach, rel=1e-12)
        assert one.mass == pytest.approx(robot.mass, rel=1e-12)
    words = [f.text for f in longer.findings if f.topic == "proportions"]
    assert len(words) == 1
    assert "m as asked" in words[0]


def test_records_and_refusals():
    robot = Robot.from_urdf(urdf_text(biped13()))
    own = robot.choices.over(proportions=(PartChange("shin", 0.01), PartChange("foot", 0.0, 0.1)))
    assert choices_from_record(choices_record(own)) == own
    read = choices_from_record({"proportions": [{"part": "shin", "longer": "2cm"}]})
    assert read.proportions == (PartChange("shin", longer=0.02),)
    for record, told in (
        ({"part": "arm", "longer": 0.1}, "must be one of"), ({"longer": 0.1}, "part is missing"),
        ({"part": "shin"}, "nothing is changed"),
        ({"part": "trunk", "longer": 0.1}, "leave it out"),
        ({"part": "shin", "longer": float("nan")}, "number"),
        ({"part": "shin", "longer": "2kg"}, "is wrong"), ({"part": "shin", "longer": 1e9}, "most"),
        ({"part": "hip_width", "heavier": 1.0}, "leave it out"),
        ({"part": "ankle_height", "heavier": 1.0}, "leave it out"),
    ):  # fmt: skip
        with pytest.raises(RobotError, match=told):
            choices_from_record({"proportions": [record]})
    with pytest.raises(RobotError, match="given twice"):
        robot.choices.over(proportions=2 * (PartChange("shin", 0.01),))
    for one in (
        PartChange("shin", -0.29), PartChange("trunk", 0.0, -40.0), PartChange("foot", -0.2),
        PartChange("ankle_height", -0.1),
    ):  # fmt: skip
        with pytest.raises(RobotError, match="take away at most"):
            Robot.from_urdf(robot.urdf, choices=robot.choices.over(proportions=(one,)))


def test_a_load_does_not_grow_with_the_part_that_carries_it():
    source = read_source(urdf_text(biped13()))
    own = ImportOptions(proportions=(PartChange("shin", 0.05), PartChange("trunk", 0.0, 3.0)))
    loads = (
        Payload("torso", 5.0, (0.1, 0.0, 0.2), (0.3, 0.2, 0.1)),
        Payload("left_shin", 0.7, (0.0, 0.0, -0.2)), Payload("right_shin", 0.7, (0.0, 0.0, -0.2)),
    )  # fmt: skip
    resized = import_robot(source, own).model
    loaded = import_robot(source, own.over(payloads=loads)).model
    for load in loads:
        link = resized.frames[resized.getFrameId(load.link)]
        body = pin.Inertia.FromBox(load.mass, *load.box)
        body.lever = np.array(load.place)
        resized.inertias[link.parentJoint] += link.placement.act(body)
    for found, expected in zip(loaded.inertias, resized.inertias, strict=True):
        np.testing.assert_allclose(
            found.toDynamicParameters(), expected.toDynamicParameters(), rtol=1e-12, atol=1e-14
        )


def test_a_load_without_a_place_is_where_its_link_as_changed_has_its_mass():
    source = read_source(urdf_text(biped13()))
    own = ImportOptions(proportions=(PartChange("shin", 0.05),))
    shin = import_robot(source, own).model
    frame = shin.frames[shin.getFrameId("left_shin")]
    places = [
        import_robot(source, choices.over(payloads=(Payload("left_shin", 0.7),))).choices
        for choices in (own, ImportOptions())
    ]
    (changed_place,), (plain,) = ([one.place for one in each.payloads] for each in places)
    assert changed_place == pytest.approx(frame.inertia.lever, abs=1e-14)
    assert changed_place[2] < plain[2] - 0.01
