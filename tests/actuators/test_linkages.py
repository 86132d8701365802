"""Motors that turn joints in common: exact derivatives, MuJoCo's own loops, and what is refused."""

from operator import attrgetter

import mujoco
import numpy as np
import pytest
from numerics import check_jacobian
from places import EXAMPLES

from gaitopt.actuators.linkages import (
    DEAD,
    JointPair,
    check_linkage,
    linkages_from_rows,
    linkages_of,
    motor_angles,
    read_linkages,
)
from gaitopt.errors import SpecError

EXAMPLE = EXAMPLES / "linkages.toml"
PLACES = np.tile(np.eye(4), (2, 1, 1))
PLACES[0, :3, 3] = 0.0, 0.0, -0.3
PLACES[1, :3, 3] = 0.01, 0.0, -0.02
PLACES[1, :3, :3] = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
ANKLE = JointPair(PLACES, np.array([[0.0, 1.0, 0.0], [0.1, -1.0, 0.0] / np.sqrt(1.01)]))
POSTURES = np.array([[0.0, 0.0], [0.35, -0.2], [-0.5, 0.25], [0.2, 0.3]])
RATES = """
[[linkages]]
joints = ["left_ankle_pitch", "left_ankle_roll"]
[[linkages.motors]]
name = "inner"
rates = [1.0, 0.5]
torque = "40Nm"
[[linkages.motors]]
name = "outer"
rates = [1.0, -0.5]
speed = "120rpm"
"""


def example():
    (linkage,) = read_linkages(EXAMPLE)
    return linkage


def test_angles_of_motors_and_their_derivatives():
    linkage = example()
    at = motor_angles(linkage, ANKLE, POSTURES)
    assert np.abs(at.angle[0]).max() < 1e-14
    assert np.abs(at.angle[1:]).min() > 0.03

    def read(part):
        return lambda q: attrgetter(part)(motor_angles(linkage, ANKLE, q[None]))[0]

    for k, q in enumerate(POSTURES):
        check_jacobian(read("angle"), at.jacobian[k], q)
        check_jacobian(read("jacobian"), at.first[k], q)
        check_jacobian(read("first"), at.second[k], q)
        check_jacobian(read("reach.cosine"), at.reach.first[k], q)
        reach = lambda q: motor_angles(linkage, ANKLE, q[None]).reach.first[0]  # noqa: E731
        check_jacobian(reach, at.reach.second[k], q)


def test_beyond_the_dead_point_angles_go_on_evenly():
    """A search may pass there: no rod reaches at two radians."""
    q = np.array([[2.0, 1.5], [1.6, 0.3]])
    at = motor_angles(example(), ANKLE, q)
    assert (np.abs(at.reach.cosine).max(axis=1) > DEAD).all()
    for part in (at.angle, at.jacobian, at.first, at.second):
        assert np.isfinite(part).all()


def loop_model(linkage):
    """MuJoCo's model of the linkage: cranks on the shin, rods on balls, closed at the foot."""

    def text(values):
        return " ".join(repr(float(v)) for v in values)

    cranks, closed = "", ""
    for k, rod in enumerate(linkage.rods):
        centre, end, tip = map(np.array, (rod.crank_centre, rod.crank_end, rod.rod_end))
        cranks += (
            f"<body name='crank{k}' pos='{text(centre)}'><joint name='motor{k}' type='hinge' "
            f"axis='{text(rod.crank_axis)}'/><geom size='0.01' mass='0.1'/>"
            f"<body name='rod{k}' pos='{text(end - centre)}'><joint name='ball{k}' type='ball'/>"
            f"<geom size='0.01' mass='0.1'/></body></body>"
        )
        closed += f"<connect body1='rod{k}' body2='foot' anchor='{text(tip - end)}'/>"
    quat = [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]
    return mujoco.MjModel.from_xml_string(
        "<mujoco><compiler angle='radian'/><worldbody><body name='shin'>"
        f"<geom size='0.05' mass='2'/>{cranks}"
        f"<body name='talus' pos='{text(PLACES[0, :3, 3])}'>"
        f"<joint name='pitch' axis='{text(ANKLE.axis[0])}'/><geom size='0.02' mass='0.2'/>"
        f"<body name='foot' pos='{text(PLACES[1, :3, 3])}' quat='{text(quat)}'>"
        f"<joint name='roll' axis='{text(ANKLE.axis[1])}'/><geom size='0.05' mass='1'/>"
        f"</body></body></body></worldbody><equality>{closed}</equality></mujoco>"
    )


def test_mujoco_closes_the_same_loops():
    """At our angles of the cranks its connections have no residual; its rates of them are J's."""
    linkage = example()
    model = loop_model(linkage)
    data = mujoco.MjData(model)
    dofs = {model.joint(k).name: int(model.jnt_dofadr[k]) for k in range(model.njnt)}
    for q in POSTURES:
        at = motor_angles(linkage, ANKLE, q[None])
        mujoco.mj_resetData(model, data)
        for name, angle in (
            ("pitch", q[0]), ("roll", q[1]), ("motor0", at.angle[0, 0]), ("motor1", at.angle[0, 1]),
        ):  # fmt: skip
            data.joint(name).qpos[:] = angle
        mujoco.mj_kinematics(model, data)
        for k, rod in enumerate(linkage.rods):
            rest = np.subtract(rod.rod_end, rod.crank_end)
            R = data.body(f"crank{k}").xmat.reshape(3, 3)
            foot = data.body("foot")
            tip = np.append(rod.rod_end, 1.0)
            for place in PLACES:
                tip = np.linalg.solve(place, tip)
            there = foot.xpos + foot.xmat.reshape(3, 3) @ tip[:3] - data.body(f"rod{k}").xpos
            turned = R.T @ there
            axis = np.cross(rest, turned)
            angle = np.arctan2(np.linalg.norm(axis), rest @ turned)
            quat = np.zeros(4)
            mujoco.mju_axisAngle2Quat(quat, axis / (np.linalg.norm(axis) or 1.0), angle)
            data.joint(f"ball{k}").qpos[:] = quat
        mujoco.mj_forward(model, data)
        held = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        assert held.sum() == 6
        assert np.abs(data.efc_pos[held]).max() < 1e-12
        J = data.efc_J.reshape(-1, model.nv)[held]
        joints = [dofs["pitch"], dofs["roll"]]
        others = [d for d in range(model.nv) if d not in joints]
        rates, *_ = np.linalg.lstsq(J[:, others], -J[:, joints], rcond=1e-9)
        assert np.abs(J[:, others] @ rates + J[:, joints]).max() < 1e-12
        found = rates[[others.index(dofs[f"motor{k}"]) for k in (0, 1)]]
        np.testing.assert_allclose(found, at.jacobian[0], atol=1e-9)


def test_rates_make_a_constant_jacobian():
    (linkage,) = linkages_of(RATES)
    assert linkage.torque == (40.0, None)
    assert linkage.speed == (None, pytest.approx(4.0 * np.pi))
    at = motor_angles(linkage, ANKLE, POSTURES)
    np.testing.assert_array_equal(at.jacobian[2], [[1.0, 0.5], [1.0, -0.5]])
    np.testing.assert_allclose(at.angle, POSTURES @ [[1.0, 1.0], [0.5, -0.5]])
    assert not at.first.any()
    assert linkages_from_rows(linkages_from_rows((linkage,))) == (linkage,)
    assert linkages_from_rows([list(map(list, example()[:-1]))]) == (example(),)


def test_a_single_joint_may_have_a_rod_too():
    """As of knees: a gear that depends on the angle."""
    one = EXAMPLE.read_text("utf-8").split('[[linkages.motors]]\nname = "outer"')[0]
    (linkage,) = linkages_of(one.replace(', "left_ankle_roll"', ""))
    pair = JointPair(PLACES[:1], ANKLE.axis[:1])
    q = np.array([[0.3]])
    at = motor_angles(linkage, pair, q)
    check_jacobian(lambda q: motor_angles(linkage, pair, q[None]).angle[0], at.jacobian[0], q[0])


def changed(old, new):
    text = EXAMPLE.read_text("utf-8")
    assert old in text
    return text.replace(old, new, 1)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "there are no linkages; say which motors turn which joints, as in"),
        ("linkages = 3", "there are no linkages"),
        ("linkages = [3]", "give a table with joints and motors"),
        ("cranks = 1", "unknown entry 'cranks'; there are linkages"),
        (changed('["left_ankle_pitch", "left_ankle_roll"]', "3"), "joints must be a list of one"),
        (changed(', "left_ankle_roll"', ""), "give as many .* as joints, 1"),
        (changed('name = "outer"', 'name = "inner"'), "give every motor a name of its own"),
        (changed("crank_axis = [0, 1, 0]", "rates = [1, 1]"), "give every motor either rates"),
        (changed("crank_axis = [0, 1, 0]\n", ""), "motor 'inner': crank_axis is missing"),
        (changed("crank_axis = [0, 1, 0]", "crank_axis = [0, 0, 0]"), "crank_axis has no"),
        (changed("crank_axis = [0, 1, 0]", "crank_axis = [1, 0, 0]"), "the crank has no length"),
        (changed("[-0.06, -0.035, -0.32]", "[-0.06, -0.03, -0.10]"), "the rod has no length"),
        (changed("[-0.06, -0.035, -0.32]", '["-6cm", "x", 0]'), "rod_end: .* is wrong; give"),
        (changed("[-0.06, -0.035, -0.32]", "[nan, 0, 0]"), "numbers must be finite"),
        (changed("[-0.06, -0.035, -0.32]", "[1, 2]"), "rod_end must be a list of 3 numbers"),
        (changed('"40Nm"', '"40kg"'), "torque = '40kg' is wrong; give a number in N·m"),
        (changed('"40Nm"', "-1"), "torque is -1 N·m; it must be from 1e-06 to 1e[+]06"),
        (changed('"40Nm"', "inf"), "torque is inf N·m"),
        (RATES.replace("[1.0, -0.5]", "[2.0, 1.0]"), "move the joints in one way only"),
        (RATES.replace("[1.0, -0.5]", "[0.0, 0.0]"), "move the joints in one way only"),
        (
            RATES.replace('torque = "40Nm"', "").replace('speed = "120rpm"', ""),
            "give the motors limits: torque, speed, power, range",
        ),
        (changed('"40Nm"', '"40Nm"\nrange = ["-1rad", 0]'), "range of 'inner' is from -1 to 0 rad"),
        (changed('"40Nm"', '"40Nm"\nrange = 3'), "range of 'inner' must be a list of 2 numbers"),
        ("[[linkages]", "TOML"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_table_is_told(text, said):
    with pytest.raises(SpecError, match=said):
        linkages_of(text)


@pytest.mark.parametrize("rows", [3, [3], [[1] * 7], [[["a"], ["m"], [[1.0]], [], [1.0], [], []]]])
def test_rows_of_a_file_are_checked(rows):
    with pytest.raises(SpecError):
        linkages_from_rows(rows)


def test_a_rod_in_line_with_its_crank_is_refused():
    (linkage,) = linkages_of(changed("[-0.06, -0.035, -0.32]", "[-0.20, -0.03, -0.10]"))
    with pytest.raises(SpecError, match="the rod of motor 'inner' is at its dead point"):
        check_linkage(linkage, ANKLE)
    check_linkage(example(), ANKLE)


def test_rods_that_do_the_same_are_refused():
    text = EXAMPLE.read_text("utf-8")
    same = text.split("[[linkages.motors]]")[1].split("\n", 1)[1].replace('"inner"', '"twin"')
    twice = "[[linkages.motors]]".join([*text.split("[[linkages.motors]]")[:2], "\n" + same])
    (linkage,) = linkages_of(twice)
    with pytest.raises(SpecError, match="move the joints in one way only"):
        check_linkage(linkage, ANKLE)
