import copy

import pytest

from gaitopt.sweep.database import difference

RECORD = {
    "format": 3,
    "axes": {"speed": [0.9, 1.0]},
    "seeds": [[0], [1]],
    "first task": {"speed": 0.9, "margins": {"friction": 0.7}, "geometry": {"pelvis_yaw": 1.0}},
    "robot": {
        "digest": "a",
        "choices": {"forward": "x"},
        "spec": {"name": "biped13", "geometry": {"d3": 0.3}},
        "urdf": '<?xml version="1.0"?>\n<robot name="biped13"></robot>',
    },
    "options": {"solver": "sqp", "solver options": {"travel": {"tolerance": 1e-6}}, "refine": True},
}


def changed(*path, to):
    record = copy.deepcopy(RECORD)
    part = record
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = to
    return record


@pytest.mark.parametrize(
    ("path", "to", "said"),
    [
        (("robot", "urdf"), "<robot name='paper'/>", "robot 'biped13', asked for is 'paper'"),
        (("robot", "urdf"), "<robot name='biped13'> </robot>", "of another robot named 'biped13'"),
        (("robot", "choices", "forward"), "y", 'about its robot, forward is "x", asked for is "y"'),
        (
            ("axes",),
            {"speed": [0.9, 1.0], "friction": [0.5]},
            "is over speed, asked for is speed, friction",
        ),
        (("axes", "speed"), [0.9], "its values of speed are [0.9, 1.0], asked for are [0.9]"),
        (("seeds",), [[1]], "began at other points"),
        (("first task", "speed"), 1.0, "its speed is 0.9, asked for is 1.0"),
        (("first task", "margins", "friction"), None, "limit friction is 0.7, asked for is none"),
        (("first task", "geometry", "pelvis_yaw"), 2.0, "its pelvis_yaw is 1.0, asked for is 2.0"),
        (("options", "refine"), False, "its option refine is true, asked for is false"),
        (
            ("options", "solver options", "travel", "tolerance"),
            1e-5,
            "its solver option tolerance is 1e-06, asked for is 1e-05",
        ),
    ],
)
def test_what_differs_is_told_in_words(path, to, said):
    assert said in difference(RECORD, changed(*path, to=to))


def test_the_robot_comes_before_what_follows_from_it():
    other = changed("robot", "urdf", to="<robot name='paper'/>")
    other["first task"] = {"speed": 0.7}
    assert "robot 'biped13'" in difference(RECORD, other)


def test_a_robot_is_the_same_with_and_without_its_specification_unless_that_is_swept():
    other = changed("robot", "spec", to=None)
    other["robot"]["digest"] = "b"
    assert difference(RECORD, RECORD) is difference(RECORD, other) is None
    axes = {"geometry.d3": [0.3, 0.31]}
    swept, shins = changed("axes", to=axes), changed("robot", "spec", "geometry", "d3", to=0.29)
    assert "another robot" in difference(swept, {**other, "axes": axes})
    assert "geometry d3 is 0.3, asked for is 0.29" in difference(swept, {**shins, "axes": axes})


def test_of_a_library_of_version_0_1_only_options_count_that_both_have():
    older = changed("options", "solver options", to={"travel": {"tolerance": 1e-6, "gone": 1}})
    asked = changed("options", "solver options", to={"travel": {"tolerance": 1e-6, "new": 2}})
    assert "solver option" in difference(older, asked)
    assert difference({**older, "format": 2}, asked) is None
    asked["options"]["solver options"]["travel"]["tolerance"] = 1e-5
    assert "tolerance is 1e-06, asked for is 1e-05" in difference({**older, "format": 2}, asked)
