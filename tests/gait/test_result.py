import pickle
from dataclasses import replace

import numpy as np
import pytest
from sample_gait import KNOTS, bare_gait, sample_gait

from gaitopt.errors import InputError
from gaitopt.gait.result import array_names


def test_the_facts_of_a_gait_follow_from_its_arrays():
    gait = sample_gait()
    assert gait.duration == pytest.approx(0.4)
    assert gait.step_length == pytest.approx(0.4, rel=1e-12)  # the swing foot travels 0.8 m
    assert gait.speed == pytest.approx(1.0, rel=1e-12)


def test_meta_is_read_by_path_and_may_be_absent():
    gait = sample_gait()
    assert gait.cost == pytest.approx(3346.48, abs=0.01)
    assert gait.number("task", "margins", "friction") == 0.7
    assert gait.number("certificate", "certified") is None
    assert gait.fact("certificate", "verdict") == "optimal to first order, verified"
    assert gait.joint_limit("torque").tolist() == [150.0] * 12
    bare = bare_gait()
    assert bare.cost is None
    assert bare.joint_limit("torque") is None
    assert bare.fact("no", "such", "key") is None


@pytest.mark.parametrize("huge", [10**400, 1e200, -(10**400)])
def test_facts_of_another_kind_than_theirs_are_absent(huge):
    odd = replace(
        sample_gait(), meta={"robot": {"a": 1}, "mass": huge, "limits": {"torque": [huge] * 12}}
    )
    assert odd.text("robot") is None
    assert odd.number("mass") is None
    assert odd.joint_limit("torque") is None
    assert sample_gait().text("robot") == sample_gait().fact("robot")


def test_arrays_are_copies_that_cannot_be_written():
    q = sample_gait().q.copy()
    gait = replace(sample_gait(), q=q)
    q[0, 0] = 7.0
    assert gait.q[0, 0] == sample_gait().q[0, 0]
    for name in array_names():
        with pytest.raises(ValueError, match="read-only"):
            getattr(gait, name)[...] = 1.0


def test_a_gait_goes_to_another_process():
    copy = pickle.loads(pickle.dumps(sample_gait()))
    assert np.array_equal(copy.torque, sample_gait().torque)
    assert copy.meta == sample_gait().meta
    gait = sample_gait()
    used = gait.trajectory.at(0.1).torque  # with what it has kept of that
    assert np.array_equal(pickle.loads(pickle.dumps(gait)).trajectory.at(0.1).torque, used)


def broken(name, index, value):
    array = np.array(getattr(sample_gait(), name))
    array[index] = value
    return {name: array}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (broken("torque", (3, 4), np.nan), r"'torque' holds NaN or infinity at \[3, 4\]"),
        (broken("torque", (3, 4), -1e160), "'torque' holds a number beyond 1e\\+50"),
        (
            {"time": sample_gait().time * 1e-60, "knots": KNOTS * 1e-60},
            "lasts 4e-61 s; it must last 1e-50 s",
        ),
        ({"q": np.ones((30, 12))}, r"'q' has shape \(30, 12\); it must be \(31, 12\)"),
        ({"q": np.ones(12)}, r"'q' has shape \(12,\); it must be N x J"),
        ({"cop": "here"}, "'cop' is not an array of numbers"),
        ({"knots": KNOTS + 1j}, "'knots' is not an array of numbers"),
        ({"knots": KNOTS.astype(str)}, "'knots' is not an array of numbers"),
        (broken("time", 5, 0.2), "'time' must increase from 0 s"),
        ({"knots": [0.0, 0.2, 0.2, 0.4]}, "'knots' must increase from 0 s"),
        ({"knots": [0.0, 1e-300, 0.2, 0.4]}, "'knots' must increase from 0 s"),
        ({"knots": [0.0, 0.2, 0.2, 0.4], "coefficients": None}, "'knots' must increase from 0 s"),
        ({"dq": np.ones((30, 12)), "coefficients": None}, r"'dq' has shape \(30, 12\)"),
        ({"knots": [0.0, 0.1, 0.3]}, "last knot is 0.3 s; it must be the end of the step, 0.4 s"),
        (broken("mirror", (0, 11), 0.5), "'mirror' E is not a leg exchange"),
        ({"parameter_names": ("a", "b")}, r"'parameters' has shape \(43,\); it must be \(2,\)"),
        ({"joint_names": ("a",) * 12}, "'joint_names' must be different texts"),
        ({"joint_names": ("a", "b")}, r"'q' has shape \(31, 12\); it must be \(31, 2\)"),
        ({"urdf": ""}, "'urdf' must be a non-empty text"),
        ({"meta": {"cost": float("nan")}}, "'meta' cannot be written as JSON"),
        ({"meta": {"limits": np.ones(3)}}, "'meta' cannot be written as JSON"),
    ],
)
def test_what_is_not_a_gait_is_refused(change, message):
    with pytest.raises(InputError, match=message):
        replace(sample_gait(), **change)
