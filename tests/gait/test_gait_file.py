import io
import json
import os
import re
import stat
import sys
import zipfile
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from first_walks import first_walk
from gait_archives import changed, documented, holds_what_is_documented, written
from humanoids import add_arms
from hypothesis import given, settings
from hypothesis import strategies as st
from places import CASES, DOCS
from sample_gait import bare_gait, sample_gait
from urdf_edits import edited_urdf

from gaitopt.atomic import write_atomically
from gaitopt.design.audit import audit
from gaitopt.design.summary import of_walk
from gaitopt.errors import GaitFileError, GaitoptError, InputError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.gait_file import (
    BENT,
    MEMBERS,
    PHASES,
    TIED,
    altered_members,
    gait_members,
    load_gait,
    save_gait,
)
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import array_names
from gaitopt.model.robot import Robot

DOCUMENT = DOCS / "gait-file.md"
WRITTEN = [member.name for member in MEMBERS]


@pytest.fixture
def path(tmp_path):
    return save_gait(sample_gait(), tmp_path / "gait.npz")


def rewritten(path, seal=True, **changes):
    """The file with some members replaced, or left out where the value is None."""
    with np.load(path) as content:
        members = {k: content[k] for k in content.files} | changes
    return written(path, {k: v for k, v in members.items() if v is not None}, seal)


@pytest.mark.parametrize("gait", [sample_gait(), bare_gait()])
def test_a_gait_comes_back_as_it_was(gait, tmp_path):
    again = load_gait(save_gait(gait, tmp_path / "x.npz"))
    for name in array_names():
        assert np.array_equal(getattr(again, name), getattr(gait, name)), name
    for name, array in gait_members(gait).items():
        assert np.array_equal(gait_members(again)[name], array), name
    for name in (
        "parameter_names", "joint_names", "urdf", "stance_sole", "swing_sole_frame", "meta"
    ):  # fmt: skip
        assert getattr(again, name) == getattr(gait, name), name


def test_numpy_alone_reads_the_file(path):
    with np.load(path, allow_pickle=False) as content:
        assert [member.name for member in MEMBERS] == content.files
        assert content["torque"].shape == (31, 12)
        assert list(content["joint_names"])[2] == "right_knee"
        assert str(content["urdf"]).lstrip().startswith("<")
        assert json.loads(str(content["meta"]))["task"]["speed"] == 1.0


def test_equal_gaits_give_equal_bytes(path, tmp_path):
    other = save_gait(load_gait(path), tmp_path / "other.npz")
    assert other.read_bytes() == path.read_bytes()
    changed = save_gait(replace(sample_gait(), meta={"cost": 1.5}), tmp_path / "changed.npz")
    assert changed.read_bytes() != path.read_bytes()


def test_the_name_is_used_as_given_and_an_old_file_is_replaced(tmp_path):
    target = tmp_path / "walk.gait"
    target.write_text("old")
    save_gait(sample_gait(), target)
    assert os.listdir(tmp_path) == ["walk.gait"]  # and no temporary file is left
    assert load_gait(target).speed == pytest.approx(1.0)


def test_a_new_file_gets_the_permissions_of_the_umask(tmp_path):
    old = os.umask(0o027)
    try:
        path = write_atomically(tmp_path / "f", b"x")
    finally:
        os.umask(old)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    target = tmp_path / "f"
    target.write_bytes(b"old")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="no space left on device"):
        write_atomically(target, b"new")
    assert target.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["f"]


@pytest.mark.parametrize("where", ["missing/gait.npz", ".", "x" * 300, "a\0b"])
def test_an_unwritable_path_is_refused(tmp_path, where):
    with pytest.raises(InputError, match="cannot write"):
        save_gait(sample_gait(), tmp_path / where)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "truncated, or not a gait file"),
        (b"hello", "truncated, or not a gait file"),
        (b"\x93NUMPY" + bytes(90), "truncated, or not a gait file"),
    ],
)
def test_a_foreign_file_is_refused(tmp_path, content, reason):
    path = tmp_path / "foreign.npz"
    path.write_bytes(content)
    with pytest.raises(GaitFileError, match=reason):
        load_gait(path)


@pytest.mark.parametrize(
    ("path", "reason"),
    [
        ("nothing.npz", "there is no such file"),
        (".", "is a directory; give one that"),
        ("walk", r"is a directory; there is the gait '.*walk.gait\.npz'; give one that"),
        (os.devnull, "it is no regular file; give one that"),
    ],
)
def test_what_is_no_file_is_refused(tmp_path, path, reason):
    (tmp_path / "walk").mkdir()
    (tmp_path / "walk" / "gait.npz").touch()
    with pytest.raises(GaitFileError, match=reason):
        load_gait(tmp_path / path)


def test_a_motion_is_told_from_a_damaged_gait(tmp_path):
    path = tmp_path / "walk-motion.npz"
    np.savez(path, fps=[50.0], joint_names=["knee"])
    with pytest.raises(GaitFileError, match="is a motion that gaitopt export wrote"):
        load_gait(path)
    np.savez(path, parameters=[0.0], joint_names=["knee"])
    with pytest.raises(GaitFileError, match="'meta' is missing; give one"):
        load_gait(path)


def test_another_zip_is_refused(tmp_path):
    path = tmp_path / "other.npz"
    np.savez(path, a=np.arange(3))
    with pytest.raises(GaitFileError, match="'meta' is missing"):
        load_gait(path)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("readme.txt", "hello")
    with pytest.raises(GaitFileError, match="'meta' is missing"):
        load_gait(path)


def test_pickled_content_is_refused(path):
    buffer = io.BytesIO()
    np.save(buffer, np.array([{"a": 1}], dtype=object), allow_pickle=True)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("extra.npy", buffer.getvalue())
    with pytest.raises(GaitFileError, match="damaged, or not a gait file"):
        load_gait(path)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"torque": None}, "'torque' is missing"),
        ({"urdf": None}, "'urdf' is missing"),
        ({"meta": None}, "'meta' is missing"),
        ({"meta": np.array("{")}, "'meta' is not JSON"),
        ({"meta": np.array("[1]")}, "'meta' is not a JSON object"),
        ({"meta": np.array('{"format": 3}')}, "its format is 3, this gaitopt reads 2"),
        ({"q": np.full((31, 12), np.inf)}, "'q' holds NaN or infinity"),
        ({"cop": np.zeros((31, 3))}, r"'cop' has shape \(31, 3\); it must be \(31, 2\)"),
        ({"joint_names": np.arange(12)}, "'joint_names' is of int64, not str"),
        ({"joint_names": np.array(["a"] * 12)}, "'joint_names' must be different texts"),
        ({"parameters": np.array(["a"] * 43)}, "'parameters' is of <U1, not float64"),
        ({"robot_parent": np.arange(12)}, "parent of a joint must be -1 or a joint before it"),
        ({"robot_parent": np.arange(12.0)}, "'robot_parent' is of float64, not int64"),
        ({"robot_moving": np.arange(12) + 1}, "a moving joint is not in its list"),
        ({"robot_moving": np.zeros(12, dtype=int)}, "a joint moves twice"),
        ({"robot_axis": np.zeros((12, 3))}, "axis of a joint has not the length 1"),
        ({"robot_placement": np.ones((12, 4, 4))}, "a placement is no rotation and shift"),
        ({"robot_mass": np.zeros(13)}, "it has no mass"),
        ({"robot_mass": np.full(13, 1e200)}, "'robot_mass' holds a number that is no SI value"),
        ({"robot_mass": -np.ones(13)}, "a body has a mass below 0"),
        ({"robot_inertia": -np.tile(np.eye(3), (13, 1, 1))}, "inertia should be positive"),
        ({"base_twist": np.zeros((31, 6))}, "'base_twist' is not that of its splines"),
        ({"schedule": np.array("{}")}, "this gaitopt reads no other"),
        ({"schedule": np.array("{")}, "'schedule' is not JSON"),
        ({"ground_normal": np.array([0.0, 0.1, 1.0])}, "its ground is not level"),
        ({"coefficients_0": np.zeros((5, 12))}, r"has shape \(5, 12\); it must be \(6, 12\)"),
    ],
)
def test_a_file_that_holds_no_gait_is_refused(path, changes, reason):
    with pytest.raises(GaitFileError, match=reason) as caught:
        load_gait(rewritten(path, **changes))
    assert str(path) in str(caught.value)


def test_a_locked_arm_may_have_an_inertia_that_no_body_has(tmp_path):
    """As Digit's elbows: only with the trunk is it a body, and the walk a file that is read."""

    def edit(root):
        add_arms(2)(root)
        for side in ("left", "right"):
            root.find(f"link[@name='{side}_arm_1']/inertial/inertia").set("ixx", "-0.001")

    gait = first_walk(Robot.from_urdf(edited_urdf(edit)))
    assert np.linalg.eigvalsh(gait.multibody.inertia).min() < -9e-4
    again = load_gait(save_gait(gait, tmp_path / "gait.npz"))
    assert np.array_equal(again.multibody.inertia, gait.multibody.inertia)


@pytest.fixture(scope="module")
def content(tmp_path_factory):
    path = save_gait(sample_gait(), tmp_path_factory.mktemp("file") / "gait.npz")
    return path, path.read_bytes()


@settings(derandomize=True, deadline=None, max_examples=60)
@given(where=st.floats(0.0, 1.0), flip=st.integers(1, 255), cut=st.booleans())
def test_a_damaged_file_is_read_whole_or_refused(content, where, flip, cut):
    path, data = content
    place = int(where * (len(data) - 1))
    damaged = (
        data[:place] if cut else data[:place] + bytes([data[place] ^ flip]) + data[place + 1 :]
    )
    other = path.with_name("damaged.npz")
    other.write_bytes(damaged)
    try:
        gait = load_gait(other)
    except GaitFileError:
        return
    assert not cut
    # a flip that is not noticed hit the zip's own records, not a number
    assert np.array_equal(gait.torque, sample_gait().torque)


# --- what was changed after the file was written ---------------------------------------------


@pytest.fixture(scope="module")
def designed(tmp_path_factory, refined_design):
    return save_gait(refined_design.gait, tmp_path_factory.mktemp("designed") / "gait.npz")


def with_changed(designed, tmp_path, name, seal):
    with np.load(designed) as content:
        members = {k: content[k] for k in content.files}
    return written(tmp_path / "gait.npz", {**members, name: changed(name, members[name])}, seal)


@pytest.mark.parametrize("name", WRITTEN)
def test_every_member_that_was_changed_is_named(designed, tmp_path, name):
    path = with_changed(designed, tmp_path, name, seal=False)
    named = "time" if name == "digest" else name  # whose digest it is that was changed
    with pytest.raises(GaitFileError, match=f"'{named}' was changed after the file was written"):
        load_gait(path)
    assert altered_members(path) == (named,)


@pytest.mark.parametrize("name", [n for n in WRITTEN if n not in ("digest", "meta")])
def test_a_change_with_a_digest_of_its_own_is_refused_or_found_by_computing(
    designed, tmp_path, name
):
    path = with_changed(designed, tmp_path, name, seal=True)
    assert altered_members(path) == ()
    try:
        found = audit(load_gait(path))
    except GaitoptError:
        return
    assert found.altered


COMPUTED = (
    "robot", "mass", "leg_length", "physics", "sole", "limits", "cost", "step_length", "duration",
)  # fmt: skip


def test_every_key_of_the_record_that_was_changed_is_noticed(designed, tmp_path):
    with np.load(designed) as content:
        members = {k: content[k] for k in content.files}
    record = json.loads(str(members["meta"]))
    assert {"task", "choices", "certificate", "instants", *COMPUTED} < set(record)
    for key in record:
        other = np.array(json.dumps({**record, key: "another"}))
        path = written(tmp_path / "gait.npz", {**members, "meta": other}, seal=False)
        with pytest.raises(GaitFileError):
            load_gait(path)
        if key not in COMPUTED:
            continue
        path = written(tmp_path / "gait.npz", {**members, "meta": other}, seal=True)
        assert audit(load_gait(path)).altered, key


def test_legs_of_another_number_of_joints_are_noticed(designed, tmp_path):
    with np.load(designed) as content:
        members = {k: content[k] for k in content.files}
    record = json.loads(str(members["meta"]))
    for count in (4, 5, 7):
        other = np.array(json.dumps({**record, "leg_joints": count}))
        path = written(tmp_path / "gait.npz", {**members, "meta": other}, seal=True)
        assert audit(load_gait(path)).altered == ("leg_joints",)


def test_numbers_of_another_width_are_read_or_refused_without_a_warning(designed, tmp_path):
    with np.load(designed) as content:
        members = {k: content[k] for k in content.files}
    for name, array in members.items():
        kinds = {"f": ("float16", "float32", ">f8", "longdouble"), "i": ("int8", ">i4")}
        for kind in kinds.get(array.dtype.kind, ()):
            most = 100 if kind == "int8" else 6e4
            narrow = {**members, name: array.clip(-most, most).astype(kind)}
            path = written(tmp_path / "gait.npz", narrow, seal=True)
            with suppress(GaitoptError):
                assert load_gait(path).time.dtype == members["time"].dtype


def test_without_digest_nothing_is_believed(designed, tmp_path):
    with np.load(designed) as content:
        members = {k: content[k] for k in content.files}
    for digest in ("[]", "{", "{}"):
        path = written(tmp_path / "x.npz", {**members, "digest": np.array(digest)}, seal=False)
        with pytest.raises(GaitFileError, match="was changed after the file was written"):
            load_gait(path)
        assert load_gait(path, verify=False).cost == pytest.approx(float(members_cost(members)))


def members_cost(members):
    return json.loads(str(members["meta"]))["cost"]


def test_multipliers_come_with_the_gait(designed, refined_design):
    gait, problem = load_gait(designed), refined_design.problem
    assert gait.multipliers.shape == problem.rows.lower.shape
    assert np.count_nonzero(gait.multipliers) > 10
    spoilt = replace(gait, multipliers=gait.multipliers[::-1])
    assert audit(spoilt).facts == ("multipliers",)
    with pytest.raises(InputError, match="2 multipliers of bounds on 43 parameters"):
        replace(gait, bound_multipliers=np.zeros(2))


# --- files of version 0.1 --------------------------------------------------------------------


def test_a_file_of_version_0_1_is_read_and_checked(tmp_path):
    gait = load_gait(CASES / "gait_format_1.npz")
    with np.load(CASES / "gait_format_1.npz") as content:
        assert json.loads(str(content["meta"]))["format"] == 1
        assert "digest" not in content
        for name in array_names():
            if name != "coefficients":
                assert np.array_equal(getattr(gait, name), content[name]), name
    assert altered_members(CASES / "gait_format_1.npz") == ()
    found = audit(gait)
    assert not found.altered  # though the certificate of today is stricter
    assert found.differences["coefficients"] < 1e-11
    again = load_gait(save_gait(gait, tmp_path / "new.npz"))
    assert again.multibody is not None
    assert again.multipliers is None
    assert not audit(again).altered


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("knots", np.zeros(0), "'knots' must increase from 0 s"),
        ("time", np.array("x"), "'time' is not an array of numbers"),
        ("cop", np.array(3.0), "'cop' is not an array of numbers"),
    ],
)
def test_damaged_files_of_version_0_1_are_told(tmp_path, name, value, message):
    with np.load(CASES / "gait_format_1.npz") as content:
        np.savez(tmp_path / "old.npz", **{**content, name: value})
    with pytest.raises(GaitFileError, match=message):
        load_gait(tmp_path / "old.npz")


def test_a_recorded_number_beyond_every_float_differs():
    gait = load_gait(CASES / "gait_format_1.npz")
    limits = {**gait.fact("limits"), "torque": [10**400]}
    assert audit(replace(gait, meta={**gait.meta, "limits": limits})).facts == ("limits",)


def test_a_foot_that_does_not_move_has_no_cost_of_transport():
    gait = load_gait(CASES / "gait_format_1.npz")
    still = replace(gait, swing_sole=np.zeros(gait.swing_sole.shape))
    assert still.step_length == 0.0
    assert of_walk(still)["walk"]["mechanical_cost_of_transport"] is None


# --- the document ----------------------------------------------------------------------------


def test_the_document_lists_what_is_written():
    expected = [
        (m.name, m.kind, " × ".join(map(str, m.shape)) or "scalar", m.unit or "–", m.frame or "–")
        for m in (*MEMBERS, *(member for part in (*PHASES, TIED, BENT) for member in part))
    ]
    rows = documented()[: len(expected)]  # the others: tests/gait/test_transition_file.py
    assert [row[:5] for row in rows] == expected
    assert all(row[5] for row in rows)


def test_the_file_holds_what_the_document_says(designed):
    with np.load(designed) as content:
        always = documented()[: len(MEMBERS)]  # the others: tests/gait/test_toe_off.py
        assert content.files == [row[0] for row in always]
        sizes = holds_what_is_documented(content, always)
        meta = json.loads(str(content["meta"]))
        schedule = json.loads(str(content["schedule"]))
    text = DOCUMENT.read_text()
    assert sizes["m"] == 4
    assert sizes["J"] == 12
    for key in (*meta, *schedule, *schedule["phases"][0]):
        assert f"`{key}`" in text, key


def test_the_example_of_the_document_evaluates_the_walk(designed, monkeypatch):
    code = re.search(r"```python\n(.*?)```", DOCUMENT.read_text(), flags=re.DOTALL)[1]
    assert "gaitopt" not in code
    assert len([line for line in code.splitlines() if line.strip()]) <= 16
    monkeypatch.chdir(designed.parent)
    space = {}
    exec(code, space)
    gait = load_gait(designed)
    times = np.linspace(0.0, 5.0 * gait.duration, 201)
    expected = gait.trajectory.at(times).q[:, gait.trajectory.body.moving]
    found = np.array([space["q"](time) for time in times])
    assert found == pytest.approx(expected, abs=1e-12)


# --- robots of other formats, and constraints of one's own -----------------------------------


def test_an_mjcf_gait_needs_no_mujoco_once_it_is_written(tmp_path, monkeypatch):
    from gaitopt.motions.export import export
    from gaitopt.view.page import page_text

    robot = Robot.from_urdf((CASES / "mjcf_damping_stiffness.xml").read_text())
    problem = WalkProblem(robot, preset_task("standard"))
    path = save_gait(gait_at(problem, first_guess(problem), {}), tmp_path / "gait.npz")
    for name in [n for n in sys.modules if n == "mujoco" or n.startswith("mujoco.")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    gait = load_gait(path)
    assert audit(gait).altered == ()
    assert gait.multibody.damping.any()
    assert "left_knee" in export(gait, tmp_path / "gait.csv").read_text()
    assert "MeshCat" in page_text(gait, steps=1)
