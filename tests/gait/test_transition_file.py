"""The file of a transition: what is in it, that it comes back, and that changes are found."""

import json
import re
import zipfile

import numpy as np
import pytest
from gait_archives import changed, documented, holds_what_is_documented, written
from hypothesis import given, settings
from hypothesis import strategies as st
from places import DOCS
from transitions import from_rest, to_rest, walk

from gaitopt.design.transition import audit_transition
from gaitopt.errors import GaitFileError, GaitoptError
from gaitopt.gait.gait_file import altered_members, load_gait, save_gait
from gaitopt.gait.transition import (
    SHIFT,
    STANDING,
    end_members,
    load,
    load_transition,
    members_of,
    save_transition,
    step_members,
    transition_members,
)

DOCUMENT = (DOCS / "gait-file.md").read_text()


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return save_transition(from_rest().transition, tmp_path_factory.mktemp("file") / "start.npz")


@pytest.fixture(scope="module")
def members(path):
    with np.load(path) as content:
        return {name: content[name] for name in content.files}


@pytest.mark.parametrize("found", [from_rest, to_rest])
def test_a_transition_comes_back_as_it_was(found, tmp_path):
    result = found().transition
    path = save_transition(result, tmp_path / "x.npz")
    again = load_transition(path)
    for name, array in transition_members(result).items():
        assert np.array_equal(transition_members(again)[name], array), name
    assert save_transition(again, tmp_path / "y.npz").read_bytes() == path.read_bytes()
    assert again.meta == json.loads(json.dumps(dict(result.meta)))
    assert (again.words, again.cost, again.certified) == (result.words, result.cost, True)
    times = np.linspace(0.0, result.trajectory.period, 101)
    one, other = (part.trajectory.at(times) for part in (result, again))
    assert other.torque == pytest.approx(one.torque, abs=1e-9)
    assert other.configuration == pytest.approx(one.configuration, abs=1e-12)


def test_it_is_certified_again_from_its_parameters(path):
    found = audit_transition(load_transition(path))
    assert found.passed
    assert max(found.differences.values()) < 1e-9
    assert "after torque" in found.differences
    assert "step 2 q" in found.differences


def test_files_are_told_apart(path, tmp_path):
    gait = save_gait(walk(), tmp_path / "gait.npz")
    assert load(gait).cost == walk().cost
    with pytest.raises(GaitFileError, match="is for a transition"):
        load_transition(gait)
    with pytest.raises(GaitFileError, match="it is a transition, and this is for the gait"):
        load_gait(path)


def test_every_member_that_was_changed_is_named(members, tmp_path):
    for name in members:
        other = {**members, name: changed(name, members[name])}
        path = written(tmp_path / "x.npz", other, seal=False)
        named = (
            next(iter(members)) if name == "digest" else name
        )  # whose digest it is that was changed
        with pytest.raises(GaitFileError, match=f"'{named}' was changed after the file was"):
            load_transition(path)
        assert altered_members(path) == (named,)


_ALONE = ("digest", "meta", "after_meta", "after_multipliers", "after_bound_multipliers")


@pytest.mark.parametrize("part", ["robot_", "step_1_", "step_2_", "after_", ""])
def test_a_change_with_a_digest_of_its_own_is_refused_or_found_by_computing(
    members, tmp_path, part
):
    others = ("robot_", "step_", "after_")
    names = [n for n in members if (n.startswith(part) if part else not n.startswith(others))]
    assert len(names) > 5
    for name in [n for n in names if n not in _ALONE]:
        other = {**members, name: changed(name, members[name])}
        path = written(tmp_path / "x.npz", other, seal=True)
        assert altered_members(path) == ()
        try:
            found = audit_transition(load_transition(path))
        except GaitoptError:
            continue
        assert found.altered, name


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"step_1_torque": None}, "'step_1_torque' is missing"),
        ({"after_meta": None}, "'after_meta' is missing"),
        ({"standing_wrench": None}, "'standing_wrench' is missing"),
        ({"meta": np.array("{")}, "'meta' is not JSON"),
        ({"meta": np.array('{"format": 3}')}, "its format is 3, this gaitopt reads 2"),
        ({"after_meta": np.array("[1]")}, "'after_meta' is not a JSON object"),
        ({"step_2_q": np.full((31, 12), np.nan)}, "'step_2_q'"),
        ({"standing_q": np.zeros(11)}, r"'standing_q' has shape \(11,\); it must be \(12,\)"),
        ({"step_1_base_twist": None}, "'step_1_base_twist' is missing"),
        ({"schedule": np.array("{}")}, "this gaitopt reads no other"),
        ({"schedule": np.array("{")}, "'schedule' is not JSON"),
        ({"step_4_time": np.zeros(3)}, "'step_4_time'"),
        ({"robot_mass": np.zeros(13)}, "it has no mass"),
    ],
)
def test_a_file_that_holds_no_transition_is_refused(members, tmp_path, changes, reason):
    kept = {name: one for name, one in (members | changes).items() if one is not None}
    path = written(tmp_path / "x.npz", kept, seal=True)
    with pytest.raises(GaitFileError, match=reason):
        load_transition(path)


@settings(derandomize=True, deadline=None, max_examples=40)
@given(where=st.floats(0.0, 1.0), flip=st.integers(1, 255), cut=st.booleans())
def test_a_damaged_file_is_read_whole_or_refused(path, where, flip, cut):
    data = path.read_bytes()
    place = int(where * (len(data) - 1))
    other = path.with_name("damaged.npz")
    other.write_bytes(
        data[:place] if cut else data[:place] + bytes([data[place] ^ flip]) + data[place + 1 :]
    )
    try:
        found = load_transition(other)
    except GaitFileError:
        return
    assert not cut
    expected = from_rest().transition
    assert np.array_equal(found.steps[0].torque, expected.steps[0].torque)


@pytest.mark.parametrize(
    "record",
    [
        {"given": None}, {"given": {"durations": "soon", "free": True}}, {"task": None},
        {"given": {"durations": [0.4], "free": True}}, {"stretch": 7.0}, {"instants": ["x"]},
    ],
)  # fmt: skip
def test_a_record_that_is_none_is_refused_when_it_is_checked(members, tmp_path, record):
    meta = json.loads(str(members["meta"])) | record
    path = written(tmp_path / "x.npz", {**members, "meta": np.array(json.dumps(meta))}, seal=True)
    with pytest.raises(GaitFileError, match="cannot be used"):
        audit_transition(load_transition(path))


# --- the document ----------------------------------------------------------------------------


def test_the_document_lists_what_is_written():
    expected = [
        (m.name, m.kind, " × ".join(map(str, m.shape)) or "scalar", m.unit or "–", m.frame or "–")
        for m in (*STANDING, *SHIFT, *step_members(1), *end_members("before"))
    ]
    begins = [row[0] for row in documented()].index(STANDING[0].name)
    rows = documented()[begins : begins + len(expected)]
    assert [row[:5] for row in rows] == expected
    assert all(row[5] for row in rows)


def test_numpy_alone_reads_what_the_document_says(members):
    assert list(members) == [member.name for member in members_of(members)]
    known = {row[0]: row for row in documented()}
    for row in list(known.values()):
        name, kind, shape, *rest = row
        if name.startswith("step_1_"):
            sizes = re.sub(r"([Nm])1", r"\g<1>2", shape)
            known[name.replace("_1_", "_2_", 1)] = (name, kind, sizes, *rest)
        if name.startswith("before_"):
            sizes = shape.replace("_before", "_after")
            known[name.replace("before", "after", 1)] = (name, kind, sizes, *rest)
    sizes = holds_what_is_documented(members, [(name, *known[name][1:]) for name in members])
    assert sizes["J"] == 12
    meta = json.loads(str(members["meta"]))
    for key in (*meta, *meta["given"], *json.loads(str(members["schedule"]))["phases"][0]):
        assert f"`{key}`" in DOCUMENT, key


@pytest.mark.parametrize("found", [from_rest, to_rest])
def test_the_example_of_the_document_evaluates_the_motion(found, tmp_path, monkeypatch):
    code = re.findall(r"```python\n(.*?)```", DOCUMENT, flags=re.DOTALL)[1]
    assert "gaitopt" not in code
    result = found().transition
    save_transition(result, tmp_path / "start.npz")
    monkeypatch.chdir(tmp_path)
    space = {}
    exec(code, space)
    trajectory = result.trajectory
    times = np.linspace(0.0, result.duration, 151)[:-1]
    expected = trajectory.at(result.begins + times).q[:, trajectory.body.moving]
    assert np.array([space["q"](time) for time in times]) == pytest.approx(expected, abs=1e-12)


def test_the_archive_is_an_ordinary_one(path):
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
        assert {entry.date_time for entry in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
