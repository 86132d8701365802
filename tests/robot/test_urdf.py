"""The URDF against closed forms, through three readers that do not know how it was written."""

import os
import shutil
import subprocess
import sys
from functools import cache
from itertools import product
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from places import ROOT
from robot.strategies import biped_specs

from gaitopt.catalogue.biped_spec import BipedSpec, biped13
from gaitopt.catalogue.parameters import changed
from gaitopt.catalogue.urdf_writer import LEG_LINKS, SIDES, urdf_text

LEG = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")
AXES = dict(zip(LEG, ("Z", "X", "Y", "Y", "Y", "X"), strict=True))
# A biped in which every length differs and the legs stand outboard of the hips.
ODD = changed(
    biped13(),
    {
        "geometry.l1": -0.11,
        "geometry.d1": 0.09,
        "geometry.d3": 0.31,
        "geometry.d4": 0.37,
        "geometry.l4": 0.023,
        "geometry.d7": 0.14,
        "links.thigh.com": [0.01, 0.02, -0.13],
        "links.thigh.inertia": [[0.04, 0.003, 0.001], [0.003, 0.05, 0.002], [0.001, 0.002, 0.03]],
    },
)


@cache
def model_of(spec: BipedSpec) -> pin.Model:
    return pin.buildModelFromXML(urdf_text(spec), pin.JointModelFreeFlyer())


def frames_at_zero(spec: BipedSpec) -> dict[str, np.ndarray]:
    model = model_of(spec)
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    return {frame.name: data.oMf[i].homogeneous for i, frame in enumerate(model.frames)}


def body(spec: BipedSpec, link: str) -> pin.Inertia:
    model = model_of(spec)
    return model.inertias[model.frames[model.getFrameId(link, pin.FrameType.BODY)].parentJoint]


@given(biped_specs())
@settings(derandomize=True, deadline=None, max_examples=25)
def test_pinocchio_reads_the_masses_and_where_the_soles_are(spec: BipedSpec) -> None:
    model, g = model_of(spec), spec.geometry
    assert (model.nq, model.nv, model.njoints) == (19, 18, 14)
    assert sum(part.mass for part in model.inertias) == pytest.approx(spec.total_mass, rel=1e-14)
    frames = frames_at_zero(spec)
    for side, sign in SIDES.items():
        sole = [-g.l1, sign * (g.d7 / 2 + g.l4), -(g.d1 + g.d3 + g.d4)]
        np.testing.assert_allclose(frames[f"{side}_sole"][:3, 3], sole, rtol=1e-14, atol=1e-14)
        np.testing.assert_array_equal(frames[f"{side}_sole"][:3, :3], np.eye(3))


def test_soles_of_the_preset_are_where_the_paper_puts_them() -> None:
    frames = frames_at_zero(biped13())
    np.testing.assert_allclose(frames["left_sole"][:3, 3], [0.137, 0.06, -0.705], rtol=1e-14)
    np.testing.assert_allclose(frames["right_sole"][:3, 3], [0.137, -0.06, -0.705], rtol=1e-14)


def test_axes_are_positive_and_in_order_on_both_sides() -> None:
    joints = list(model_of(biped13()).joints)[2:]
    names = list(model_of(biped13()).names)[2:]
    assert names == [f"{side}_{joint}" for side, joint in product(SIDES, LEG)]
    expected = [f"JointModelR{AXES[joint]}" for _, joint in product(SIDES, LEG)]
    assert [joint.shortname() for joint in joints] == expected


def test_foot_of_a_bent_leg_is_where_trigonometry_puts_it() -> None:
    model, g = model_of(ODD), ODD.geometry
    hip, knee, ankle = -0.5, 0.9, -0.2
    q = pin.neutral(model)
    for name, angle in (("hip_pitch", hip), ("knee", knee), ("ankle_pitch", ankle)):
        q[model.joints[model.getJointId(f"left_{name}")].idx_q] = angle
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    shin, foot = hip + knee, hip + knee + ankle
    x = -g.d4 * np.sin(hip) - g.d3 * np.sin(shin) - g.l1 * np.cos(foot) - g.d1 * np.sin(foot)
    z = -g.d4 * np.cos(hip) - g.d3 * np.cos(shin) + g.l1 * np.sin(foot) - g.d1 * np.cos(foot)
    sole = data.oMf[model.getFrameId("left_sole")].translation
    np.testing.assert_allclose(sole, [x, g.d7 / 2 + g.l4, z], rtol=1e-13)


BOXES = {
    "hip_yaw_link": (1.02, (0.08, 0.08, 0.08), (0, 0, 0)),
    "hip_roll_link": (1.02, (0.08, 0.08, 0.08), (0, 0, 0)),
    "thigh": (2.08, (0.10, 0.10, 0.3), (0, 0, -0.15)),
    "shin": (1.75, (0.08, 0.08, 0.3), (0, 0, -0.15)),
    "ankle": (0.65, (0.06, 0.06, 0.06), (0, 0, 0)),
    "foot": (1.64, (0.214, 0.136, 0.04), (0.137 - 0.107, 0, -0.105 + 0.02)),
}


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("link", BOXES)
def test_legs_have_the_mass_properties_of_their_boxes(side: str, link: str) -> None:
    mass, size, centre = BOXES[link]
    part, expected = body(biped13(), f"{side}_{link}"), pin.Inertia.FromBox(mass, *size)
    assert part.mass == mass
    np.testing.assert_allclose(part.lever, centre, atol=1e-15)
    np.testing.assert_allclose(part.inertia, expected.inertia, rtol=1e-14, atol=1e-18)


def test_torso_has_the_mass_properties_of_its_box() -> None:
    part, expected = body(biped13(), "torso"), pin.Inertia.FromBox(40.55, 0.2, 0.3, 0.595)
    assert part.mass == 40.55
    np.testing.assert_allclose(part.lever, [0, 0, 0.2975], rtol=1e-15)
    np.testing.assert_allclose(part.inertia, expected.inertia, rtol=1e-14, atol=1e-18)


@pytest.mark.parametrize("link", LEG_LINKS)
def test_right_leg_is_the_mirror_image_of_the_left(link: str) -> None:
    left, right = body(ODD, f"left_{link}"), body(ODD, f"right_{link}")
    flip = np.diag([1.0, -1.0, 1.0])
    assert right.mass == left.mass > 0
    np.testing.assert_array_equal(right.lever, flip @ left.lever)
    np.testing.assert_array_equal(right.inertia, flip @ left.inertia @ flip)


def test_limits_are_the_motors_and_mirror_roll_and_yaw() -> None:
    spec = changed(
        biped13(),
        {
            f"joints.{joint}.{key}": value + 0.01 * i
            for i, joint in enumerate(LEG)
            for key, value in {"torque": 90, "speed": 7, "lower": -0.3, "upper": 0.8}.items()
        },
    )
    model = model_of(spec)
    for (i, joint), side in product(enumerate(LEG), SIDES):
        index = model.joints[model.getJointId(f"{side}_{joint}")]
        low, high = -0.3 + 0.01 * i, 0.8 + 0.01 * i
        if side == "right" and AXES[joint] != "Y":
            low, high = -high, -low
        assert model.lowerPositionLimit[index.idx_q] == pytest.approx(low)
        assert model.upperPositionLimit[index.idx_q] == pytest.approx(high)
        assert model.effortLimit[index.idx_v] == pytest.approx(90 + 0.01 * i)
        assert model.velocityLimit[index.idx_v] == pytest.approx(7 + 0.01 * i)


@pytest.mark.parametrize("spec", [biped13(), ODD], ids=["preset", "odd"])
@pytest.mark.parametrize("side", SIDES)
def test_foot_collision_box_stands_exactly_on_the_sole(spec: BipedSpec, side: str) -> None:
    shapes = pin.buildGeomFromUrdfString(
        model_of(spec), urdf_text(spec), pin.GeometryType.COLLISION
    ).geometryObjects
    (shape,) = [shape for shape in shapes if shape.name.startswith(f"{side}_foot")]
    half, g = shape.geometry.halfSide, spec.geometry
    frames = frames_at_zero(spec)
    placement = frames[f"{side}_ankle_roll"] @ shape.placement.homogeneous
    corners = [
        placement @ [*(sign * half), 1.0] for sign in map(np.array, product((-1, 1), repeat=3))
    ]
    local = (np.linalg.inv(frames[f"{side}_sole"]) @ np.array(corners).T)[:3]
    low, high = (
        [-g.foot_length, -g.foot_width / 2, 0],
        [0, g.foot_width / 2, spec.links.foot.size[2]],
    )
    np.testing.assert_allclose(local.min(axis=1), low, atol=1e-15)
    np.testing.assert_allclose(local.max(axis=1), high, atol=1e-15)


@pytest.mark.parametrize("spec", [biped13(), ODD], ids=["preset", "odd"])
def test_yourdfpy_reads_it_alike(spec: BipedSpec, tmp_path: Path) -> None:
    yourdfpy = pytest.importorskip("yourdfpy")
    path = tmp_path / "biped.urdf"
    path.write_text(urdf_text(spec), encoding="utf-8")
    robot = yourdfpy.URDF.load(str(path), load_meshes=False)
    assert robot.validate(), robot.errors
    frames = frames_at_zero(spec)
    for frame in ("left_sole", "right_sole", "left_shin", "right_foot"):
        expected = np.linalg.inv(frames["torso"]) @ frames[frame]
        np.testing.assert_allclose(robot.get_transform(frame, "torso"), expected, atol=1e-14)
    total = sum(link.inertial.mass for link in robot.robot.links if link.inertial)
    assert total == pytest.approx(spec.total_mass, rel=1e-14)


def test_check_urdf_accepts_it(tmp_path: Path) -> None:
    path = tmp_path / "biped.urdf"
    path.write_text(urdf_text(ODD), encoding="utf-8")
    tool = Path(sys.executable).parent / "check_urdf"
    if not tool.exists():
        pytest.skip("check_urdf is not installed")
    run = subprocess.run([tool, path], capture_output=True, text=True, timeout=300, check=False)
    assert run.returncode == 0, run.stderr
    assert "root Link: torso has 2 child(ren)" in run.stdout
    assert "child(1):  right_sole" in run.stdout


def test_shapes_are_primitives_in_known_colours_on_every_link_with_mass() -> None:
    robot = ET.fromstring(urdf_text(biped13()))
    kinds = {shape.tag for geometry in robot.iter("geometry") for shape in geometry}
    assert kinds == {"box", "cylinder", "sphere"}
    named = {material.get("name") for material in robot.findall("material")}
    assert {material.get("name") for material in robot.iter("material")} == named
    for link in robot.findall("link"):
        assert (link.find("visual") is None) == (link.find("inertial") is None)
    tints = {
        side: {m.get("name") for m in robot.findall(f"link[@name='{side}_thigh']//material")}
        for side in SIDES
    }
    assert tints["left"] - tints["right"] == {"left"}
    assert tints["right"] - tints["left"] == {"right"}


@given(biped_specs())
@settings(derandomize=True, deadline=None, max_examples=25)
def test_no_shape_is_empty_and_no_number_is_negative_zero(spec: BipedSpec) -> None:
    text = urdf_text(spec)
    assert urdf_text(spec) == text
    assert "-0 " not in text
    assert '-0"' not in text
    for geometry in ET.fromstring(text).iter("geometry"):
        sizes = [float(n) for key, value in geometry[0].items() for n in value.split()]
        assert min(sizes) > 0.0


def test_the_file_in_the_repository_is_current() -> None:
    assert (ROOT / "urdf" / "biped13.urdf").read_bytes() == urdf_text(biped13()).encode()


def test_the_generator_notices_a_stale_file_and_renews_it(tmp_path: Path) -> None:
    script = Path(shutil.copytree(ROOT / "scripts", tmp_path / "scripts")) / "generate_urdf"
    target = tmp_path / "urdf" / "biped13.urdf"
    target.parent.mkdir()
    target.write_text(urdf_text(ODD), encoding="utf-8")
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    call = [sys.executable, script]
    codes = [
        subprocess.run([*call, *args], env=env, check=False, timeout=300).returncode
        for args in (["--check"], [], ["--check"])
    ]
    assert codes == [1, 0, 0]
    assert target.read_bytes() == urdf_text(biped13()).encode()
