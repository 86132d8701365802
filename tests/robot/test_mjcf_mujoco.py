"""MJCF files mean what MuJoCo says: kinematics, dynamics, limits, passive joints, shapes."""

import re
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from mesh_files import write_stl
from mjcf_edits import added, at, edited, together
from mjcf_generator import write_random_mjcf
from mjcf_oracle import Mapping, compare, mass_matrix, silent, silently_compiled
from places import CASES

from gaitopt.errors import RobotError
from gaitopt.importers.reader import read_source
from gaitopt.model.robot import Robot

SOUND = (
    "b_planar_root_joints", "base_mini", "default_joint_ref", "inertiafromgeom_true",
    "mj_geom_default_pos", "mj_root6", "mjcf_damping_stiffness", "mjcf_frame",
    "mjcf_general_fixed_gain", "mjcf_gravcomp", "mjcf_gravity", "mjcf_inertiagrouprange",
    "mjcf_joint_ref", "mjcf_massless_mesh_body", "mjcf_saved_by_mujoco_motor_general",
    "mjcf_visual_geom_mass",
)  # fmt: skip
SINGLE = 1e-9  # corners of meshes are of single precision in MuJoCo, and compared at a thousandth
TOLERANCE = 1e-11


def agree(path: Path, seed: int = 0, postures: int = 3) -> None:
    worst = compare(path, seed, postures).worst
    assert worst.pop("mesh (single precision)", 0.0) < SINGLE
    assert max(worst.values()) < TOLERANCE, worst


@pytest.mark.parametrize("name", SOUND)
def test_cases_are_what_mujoco_says(name):
    agree(CASES / f"{name}.xml", postures=20)


@pytest.mark.parametrize("seed", range(40))
def test_random_files_are_what_mujoco_says(tmp_path, seed):
    agree(write_random_mjcf(tmp_path, seed), seed)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("range_underscore", "line 1: joint 'left_knee': .*bad format .* .it is '0 2_6'"),
        ("body_inside_inertial", "line 1: body 'zz': MuJoCo refuses it: unrecognized element"),
    ],
)
def test_what_mujoco_refuses_is_refused(name, message):
    with pytest.raises(RobotError, match=f"^{message}"):
        read_source(CASES / f"{name}.xml")


def text(name: str = "base_mini") -> str:
    return (CASES / f"{name}.xml").read_text(encoding="utf-8")


def told(source, topic: str) -> str:
    return "; ".join(f"{f.subject} {f.text}" for f in source.findings() if f.topic == topic)


def test_masses_come_from_all_geoms_that_count():
    sums = {name: pin.computeTotalMass(read_source(text(name)).model()) for name in SOUND[1:]
            if name != "mjcf_massless_mesh_body"}  # fmt: skip
    assert sums["base_mini"] == pytest.approx(42.6)
    assert sums["mjcf_visual_geom_mass"] == pytest.approx(48.07, abs=0.01)
    assert sums["mjcf_inertiagrouprange"] < sums["mjcf_visual_geom_mass"]


def test_coordinates_are_mujocos_and_inspect_says_so():
    plain, shifted = (Robot.from_urdf(text(n)) for n in ("base_mini", "mjcf_joint_ref"))
    knees = [i for i, name in enumerate(shifted.joint_names) if "knee" in name]
    assert shifted.limits.lower[knees].tolist() == plain.limits.lower[knees].tolist() == [0, 0]
    assert dict(shifted.choices.posture) == {"left_knee": 0.5, "right_knee": 0.5}
    assert any("at their ref, not at 0: left_knee 0.5" in f.text for f in shifted.findings)
    # It stands as the file draws it: the same soles below the same hips.
    assert shifted.sole == plain.sole
    assert shifted.legs.reach == pytest.approx(plain.legs.reach)


@pytest.mark.parametrize("name", ["mjcf_saved_by_mujoco_motor_general", "mjcf_general_fixed_gain"])
def test_general_actuators_give_torque_limits(name):
    robot = Robot.from_urdf(text(name))
    expected = np.full(12, 150.0)
    if name.endswith("general"):
        expected = Robot.from_urdf(text()).limits.torque
    np.testing.assert_allclose(robot.limits.torque, expected)


@pytest.mark.parametrize("name", ["mj_root6", "b_planar_root_joints"])
def test_a_root_on_slides_and_hinges_floats(name):
    source = read_source(CASES / f"{name}.xml")
    assert source.model().joints[1].shortname() == "JointModelFreeFlyer"
    assert "floats; the joints that hold it in the file do not count" in told(source, "root")
    assert Robot.from_urdf(CASES / f"{name}.xml").mass > 0.0


@pytest.mark.parametrize("tag", ["weld", "connect"])
def test_a_root_that_an_equality_holds_floats_and_inspect_says_so(tag):
    anchor = " anchor='0 0 0.3'" if tag == "connect" else ""
    tie = f"<equality><{tag} body1='base'{anchor}/></equality>"
    source = read_source(edited(text(), added(".", tie)))
    assert f"what holds it in <equality> does not count: <{tag}>" in told(source, "root")
    assert source.model() == read_source(text()).model()


def test_the_robot_is_what_has_most_joints():
    ball = "<body name='ball'><freejoint/><geom size='0.1'/></body>"
    door = (
        "<body name='door' pos='3 0 0'><inertial pos='0 0 0' mass='9' diaginertia='1 1 1'/>"
        "<joint name='hinge' axis='0 0 1'/></body>"
    )
    source = read_source(edited(text(), added(".//worldbody", ball, door)))
    assert source.model() == read_source(text()).model()
    assert "'base' the file holds others" in told(source, "root")
    assert "'ball', 'door'" in told(source, "root")


def test_soles_come_from_geoms_with_the_place_of_their_class():
    robot = Robot.from_urdf(text("mj_geom_default_pos"))
    ankle = robot.model.jointPlacements[2].translation  # above the standing sole
    assert ankle[2] == pytest.approx(0.08)


def test_gravity_and_what_carries_weight():
    assert read_source(text()).physics.gravity is None
    assert read_source(text("mjcf_gravity")).physics.gravity == (0.0, 0.0, -1.62)
    carried = read_source(text("mjcf_gravcomp")).physics.compensated
    assert {name: mass.mass for name, mass in carried.items()} == {
        "left_knee_link": 2.5,
        "right_knee_link": 2.5,
    }


@pytest.mark.parametrize(("thigh", "carried"), [(-1.0, 0), (0.5, 2)])
def test_negative_compensation_counts_beside_a_positive_one(tmp_path, thigh, carried):
    made = text("mjcf_gravcomp").replace('gravcomp="1"', 'gravcomp="-1"')
    made = made.replace('gravcomp="-1"', f'gravcomp="{thigh}"', 1)
    assert len(read_source(made).physics.compensated) == carried
    path = tmp_path / "robot.xml"
    path.write_text(made, encoding="utf-8")
    agree(path)


def test_weight_that_motors_bear_is_not_carried_from_outside(tmp_path):
    made = text("mjcf_gravcomp").replace("<joint ", "<joint actuatorgravcomp='true' ", 2)
    assert len(read_source(text("mjcf_gravcomp")).physics.compensated) > 0
    path = tmp_path / "robot.xml"
    path.write_text(made, encoding="utf-8")
    agree(path)


def test_legs_drawn_at_unequal_refs_are_named():
    with pytest.raises(RobotError) as caught:
        Robot.from_urdf(text("default_joint_ref"))
    drawn = "'right_hip_yaw' at ref 0.3 rad, 'left_hip_yaw' at 0.3 rad, mirrored -0.3. Correct the"
    assert drawn in str(caught.value)
    assert "'right_knee' at ref" not in str(caught.value)
    # Followed, the advice works.
    odd = r'(name="left_\w+" axis="(?:0.0 0.0 1.0|1.0 0.0 0.0)")'
    shifted = re.sub(odd, r'\1 ref="-0.3"', text("default_joint_ref"))
    assert Robot.from_urdf(shifted).mass == pytest.approx(56.87)


@pytest.mark.parametrize("memory", ["1G", "100000G", "5000000000"])
def test_memory_of_simulations_is_not_asked_for(memory):
    asking = text().replace("</mujoco>", f"<size memory='{memory}'/></mujoco>")
    assert read_source(asking).model() == read_source(text()).model()


def test_bodies_beyond_all_places_are_refused():
    far = re.sub(r'<inertial pos="[^"]*"', '<inertial pos="0 0 4e10"', text(), count=1)
    with pytest.raises(
        RobotError, match=r"<inertial>: its pos is '0 0 4e10'; its numbers must be below"
    ):
        read_source(far)
    far = text().replace("<joint ", '<joint pos="0 2e11 0" ', 1)
    with pytest.raises(RobotError, match=r"its pos is '0 2e11 0'; its numbers must be below"):
        read_source(far)


def test_far_masses_round_in_mujoco(tmp_path):
    """The mass of a held root turns nothing, wherever it is; MuJoCo's mass matrix feels it."""
    held = re.sub(r"<freejoint[^>]*/>", "", text())
    far = re.sub(r'<inertial pos="[^"]*"', '<inertial pos="0.1 0.2 1e7"', held, count=1)
    matrices, own = [], []
    for made in (held, far):
        path = tmp_path / "robot.xml"
        path.write_text(made, encoding="utf-8")
        mapping = Mapping(read_source(path), silently_compiled(path))
        assert not mapping.free
        with silent():
            q, _ = mapping.randomise(np.random.default_rng(0))
        m, d, model = mapping.m, mapping.d, mapping.model
        matrices.append(mass_matrix(m, d)[np.ix_(mapping.dofs, mapping.dofs)])
        q[:7] = pin.neutral(model)[:7]
        own.append(pin.crba(model, model.createData(), q)[np.ix_(mapping.rows, mapping.rows)])
        agree(path)
    assert np.abs(own[1] - own[0]).max() < 1e-12
    assert np.abs(matrices[0] - own[0]).max() < 1e-12
    assert np.abs(matrices[1] - own[0]).max() > 1e-6


def test_passive_joints():
    joints = read_source(text("mjcf_damping_stiffness")).physics.joints
    assert len(joints) == 12
    knee = joints["left_knee"]
    assert (knee.damping, knee.friction, knee.stiffness, knee.rest) == ((5,), 3, (20,), 0.3)


MESH = "<asset><mesh name='shell' file='parts/shell.stl' scale='0.1 0.1 0.1'/></asset>"


def with_mesh(geom: str):
    return together(added(".", MESH), added(".//body[@name='base']", geom))


def test_a_mesh_that_no_mass_needs_may_be_missing(tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text(edited(text(), with_mesh("<geom type='mesh' mesh='shell'/>")), encoding="utf-8")
    source = read_source(path)
    assert "mesh files were not found: 'parts/shell.stl'; no mass" in told(source, "meshes")
    assert [p.file for p in source.mesh_problems()] == ["parts/shell.stl"]
    assert source.model() == read_source(text()).model()
    # Found later, it is shown where the file puts it.
    (tmp_path / "parts").mkdir()
    write_stl(tmp_path / "parts" / "shell.stl")
    for again in (read_source(path), read_source(source.text, [tmp_path])):
        shown = again.geometry(pin.GeometryType.VISUAL, {"base"})
        (item,) = shown.geometryObjects
        assert item.meshPath.endswith("shell.stl")
    agree(path)


def test_a_mesh_that_mujoco_alone_reads_is_shown(tmp_path):
    """Numbers without a digit before the point are none to the loader of other meshes."""
    corners = "v 0 0 0\nv .1 0 0\nv 0 .2 0\nv 0 0 .3\n"
    faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    (tmp_path / "shell.obj").write_text(corners + faces, encoding="utf-8")
    mesh = "<asset><mesh name='shell' file='shell.obj' scale='2 2 2' refpos='0.1 0 0'/></asset>"
    geom = "<geom type='mesh' mesh='shell' mass='1' pos='0 0 0.2'/>"
    edit = together(added(".", mesh), added(".//body[@name='base']", geom))
    path = tmp_path / "robot.xml"
    path.write_text(edited(text(), edit), encoding="utf-8")
    shown = read_source(path).geometry(pin.GeometryType.VISUAL, {"base"})
    assert np.ptp(shown.geometryObjects[0].geometry.vertices(), axis=0) == pytest.approx(
        [0.2, 0.4, 0.6]
    )
    agree(path)
    (tmp_path / "torn.obj").write_text(faces, encoding="utf-8")
    path.write_text(path.read_text("utf-8").replace("shell.obj", "torn.obj"), encoding="utf-8")
    with pytest.raises(RobotError, match=r"the mesh 'torn\.obj' cannot be read; write it again"):
        read_source(path).geometry(pin.GeometryType.VISUAL, {"base"})


def test_a_mesh_that_a_mass_needs_may_not(tmp_path):
    path = tmp_path / "robot.xml"
    edit = with_mesh("<body name='head'><geom type='mesh' mesh='shell' density='500'/></body>")
    path.write_text(edited(text(), edit), encoding="utf-8")
    told = r"^line \d+: body 'head': its mass comes from the mesh 'parts/shell.stl', which was not "
    with pytest.raises(RobotError, match=rf"{told}found; give the directory .*--package-dir"):
        read_source(path)
    (tmp_path / "else" / "parts").mkdir(parents=True)
    write_stl(tmp_path / "else" / "parts" / "shell.stl")
    found = read_source(path, [tmp_path / "else"])
    assert pin.computeTotalMass(found.model()) > 42.6
    # The text alone needs no mesh.
    assert read_source(found.text).model() == found.model()


def test_shapes_that_are_hidden_are_not_drawn():
    shapes = (
        "<geom name='skin' type='sphere' size='0.1' contype='0' conaffinity='0' group='2'/>",
        "<geom name='hull' type='box' size='0.1 0.1 0.1' group='3'/>",
        "<geom name='clear' type='box' size='0.2 0.1 0.1' rgba='1 1 1 0'/>",
    )
    source = read_source(edited(text(), added(".//body[@name='base']", *shapes)))
    drawn, touching = (
        [type(g.geometry).__name__ for g in source.geometry(kind, {"base"}).geometryObjects]
        for kind in (pin.GeometryType.VISUAL, pin.GeometryType.COLLISION)
    )
    assert (drawn, touching) == (["Sphere"], ["Box", "Box"])


def test_pairs_can_touch_whatever_their_masks():
    off = together(
        at(".//body[@name='left_ankle_roll_link']/geom", contype="0", conaffinity="0", name="sole"),
        added(".//worldbody", "<geom name='floor' type='plane' size='1 1 1'/>"),
    )
    foot = {"left_ankle_roll_link"}
    assert read_source(edited(text(), off)).geometry(pin.GeometryType.COLLISION, foot) is None
    pair = added(".", "<contact><pair geom1='sole' geom2='floor'/></contact>")
    source = read_source(edited(text(), together(off, pair)))
    assert source.geometry(pin.GeometryType.COLLISION, foot).ngeoms == 1


def test_nothing_is_written_or_printed(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    nan = at(".//joint[@name='left_knee']", range="nan 1")
    with pytest.raises(RobotError):
        read_source(edited(text(), nan))
    read_source(edited(text(), at("compiler", settotalmass="30")))
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")


def test_textures_and_terrain_need_no_files():
    def edit(root):
        asset = (
            "<asset><texture name='t' file='gone.png' type='2d'/><material name='m' texture='t'/>"
        )
        added(".", f"{asset}<hfield name='h' file='gone.png' size='1 1 1 1'/></asset>")(root)
        added(".//worldbody", "<geom type='hfield' hfield='h'/>")(root)
        at(".//body/geom", material="m")(root)

    assert read_source(edited(text(), edit)).model() == read_source(text()).model()


def test_mujocos_own_reading_of_the_normal_form_is_the_same(tmp_path, rng):
    path = write_random_mjcf(tmp_path, 7)
    source = read_source(path)
    normal = tmp_path / "normal.xml"
    normal.write_text(source.text.replace('data="1"', 'data="0"'), encoding="utf-8")
    assert silently_compiled(normal).nq == source.model().nq
    again = read_source(normal)  # through MuJoCo, as the mark is another
    pin.seed(1)
    q = pin.randomConfiguration(
        source.model(), -np.ones(source.model().nq), np.ones(again.model().nq)
    )
    masses = [pin.crba(s.model(), s.model().createData(), q) for s in (source, again)]
    np.testing.assert_allclose(masses[0], masses[1], rtol=1e-9, atol=1e-9)


def test_bodies_joints_and_sites_may_share_names():
    sites = "<site name='left_knee_link'/>", "<site name='left_knee'/>", "<site name='base'/>"
    source = read_source(edited(text(), added(".//body[@name='base']", *sites)))
    model = source.model()
    assert len({frame.name for frame in model.frames}) == model.nframes
    names = [f.name for f in model.frames if f.type == pin.FrameType.OP_FRAME]
    assert names == ["left_knee_link (site)", "left_knee (site)", "base (site)"]
    assert source.geometry(pin.GeometryType.COLLISION).ngeoms == 2
    assert Robot.from_urdf(source.text).mass == pytest.approx(42.6)


def test_what_brakes_the_root_is_left_out_and_told():
    def edit(root):
        base = root.find(".//body[@name='base']")
        base.remove(base.find("freejoint"))
        base.insert(0, ET.fromstring("<joint name='root' type='free'/>"))
        added(".", "<default><joint armature='0.02' damping='3'/></default>")(root)

    source = read_source(edited(text(), edit))
    assert "floats free: the armature, damping of what holds it" in told(source, "root")
    model = source.model()
    assert model.armature[:6].tolist() == [0.0] * 6
    assert set(model.armature[6:]) == {0.02}


def test_gait_files_of_the_first_version_hold_the_files_own_text(tmp_path):
    """Without includes, the meshes gone, all masses given: as 0.1 accepted them."""
    shown = with_mesh("<geom type='mesh' mesh='shell' contype='0' conaffinity='0'/>")
    old = edited(text(), shown)
    assert Robot.from_urdf(old).model == Robot.from_urdf(read_source(old).text).model
