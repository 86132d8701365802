"""Limits of motors behind linkages: rows by hand, derivatives, records, walks that keep them."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from numerics import check_differences, steps
from places import EXAMPLES
from reference_cases import biped

from gaitopt.actuators.linkages import linkages_from_rows, read_linkages
from gaitopt.design.audit import audit
from gaitopt.design.design import design
from gaitopt.errors import InputError
from gaitopt.gait import quantities
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.motor_space import MotorSpace, driven_joints
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import task_from_record, task_record
from gaitopt.model.linkage import Linkage

RODS = read_linkages(EXAMPLES / "linkages.toml")
RATES = (
    Linkage(
        ("right_ankle_pitch", "right_ankle_roll"), ("inner", "outer"), ((1.0, 0.5), (1.0, -0.5)),
        (), (40.0, None), (None, 12.0), (90.0, 80.0), (None, (-1.0, 1.1)),
    ),
)  # fmt: skip


def problem(linkages, **changes):
    task = preset_task(speed=0.8, duration=0.4, **changes)
    return WalkProblem(biped(), replace(task, constraints=(MotorSpace(linkages=linkages),)))


@functools.cache
def somewhere(name):
    """A problem and a point where no rod is at its dead point."""
    found = problem({"rods": RODS, "rates": RATES}[name])
    x = perturbed(found, first_guess(found), 0.02, 3)
    return found, x


def read(found, x):
    step = found.step(x)
    values = (quantities.TORQUE, quantities.RATES, quantities.ANGLES)
    return tuple(step.read(one) for one in values)


def test_rows_of_rates_are_those_by_hand():
    found, x = somewhere("rates")
    block = found.blocks[-1]
    assert block.labels == tuple(
        f"{side}_ankle_pitch {what}"
        for side in ("right", "left")
        for what in (
            "torque of motor inner", "speed of motor outer", "power of motor inner",
            "power of motor outer", "angle of motor outer",
        )
    )  # fmt: skip
    torque, rate, q = read(found, x)
    rows = block.function.value(block.take(found.step(x).values))
    names = found.robot.joint_names
    for begin, side, sign in ((0, "right", 1.0), (5, "left", -1.0)):
        pitch, roll = (names.index(f"{side}_ankle_{axis}") for axis in ("pitch", "roll"))
        # Gamma_pitch = a + b, Gamma_roll = (a - b) / 2 of the motors' torques a and b
        a = torque[:, pitch] / 2.0 + sign * torque[:, roll]
        b = torque[:, pitch] / 2.0 - sign * torque[:, roll]
        v, w = (rate[:, pitch] + k * sign * rate[:, roll] / 2.0 for k in (1.0, -1.0))
        angle = q[:, pitch] - sign * q[:, roll] / 2.0
        by_hand = np.stack([a / 40.0, w / 12.0, a * v / 90.0, b * w / 80.0, angle / 1.1], axis=1)
        np.testing.assert_allclose(rows[:, begin : begin + 5], by_hand, atol=1e-12)
    upper, lower = (np.broadcast_to(end, rows.shape)[:, 4] for end in (block.upper, block.lower))
    np.testing.assert_allclose(upper, 1.0)
    np.testing.assert_allclose(lower, -1.0 / 1.1)


def test_motors_do_the_work_of_the_joints():
    """In every posture, whatever the geometry; and the legs are mirror images."""
    found, x = somewhere("rods")
    torque, rate, q = read(found, x)
    right, left = driven_joints(found.robot, RODS)[::-1]
    for group in (right, left):
        motors = group.values(torque, rate, q)
        rows = list(group.rows)
        work = (torque[:, rows] * rate[:, rows]).sum(axis=1)
        np.testing.assert_allclose(motors["power"].sum(axis=1), work, atol=1e-9)
        assert np.abs(work).max() > 1.0
    E = found.robot.mirror
    mirrored = right.values(torque @ E.T, rate @ E.T, q @ E.T)
    for what, values in left.values(torque, rate, q).items():
        np.testing.assert_allclose(mirrored[what], values, atol=1e-12)


def test_accelerations_of_the_motors_are_the_slopes_of_their_rates():
    found, _ = somewhere("rods")
    q, dq, ddq = np.random.default_rng(4).normal(
        scale=0.2, size=(3, 1, len(found.robot.joint_names))
    )
    for group in driven_joints(found.robot, RODS):
        rates = lambda t: group.values(dq, dq + t * ddq, q + t * dq + t * t / 2.0 * ddq)["speed"]  # noqa: E731, B023
        differences = [(rates(h) - rates(-h)) / (2.0 * h) for h in steps(1e-3, 4)]
        check_differences(group.accelerations(dq, ddq, q), differences)


@pytest.mark.parametrize("name", ["rods", "rates"])
def test_derivatives_of_the_rows(name):
    found, x = somewhere(name)
    rows = found.rows_of("motor space")
    y = np.zeros(found.rows.lower.size)
    y[rows] = np.random.default_rng(2).normal(size=rows.stop - rows.start)
    d = np.random.default_rng(1).normal(size=x.size) * found.variables.scale

    def value(at):
        return found.values(at).rows[rows]

    J = found.point(x).jacobian[rows]
    differences = [(value(x + h * d) - value(x - h * d)) / (2.0 * h) for h in steps(1e-4, 4)]
    check_differences(J @ d, differences)
    slopes = [
        ((found.point(x + h * d).jacobian - found.point(x - h * d).jacobian)[rows].T @ y[rows])
        / (2.0 * h)
        for h in steps(1e-4, 4)
    ]
    scale = found.variables.scale
    H = found.hessian(x, y, 0.0)
    check_differences(scale * (H @ d), [scale * slope for slope in slopes])


def test_a_walk_keeps_the_limits_of_its_motors(tmp_path):
    """The walk that does not know of them asks for twice the power."""
    free = design(biped(), preset_task(speed=0.8, duration=0.4)).gait
    groups = driven_joints(biped(), RODS)
    asked = [g.values(free.torque, free.dq, free.q)["power"].max() for g in groups]
    assert max(asked) > 2.0 * 60.0
    task = problem(RODS).task
    found = design(biped(), task)
    assert found.certificate.certified
    gait = found.gait
    assert gait.cost > free.cost
    needed = [g.values(gait.torque, gait.dq, gait.q) for g in groups]
    assert max(one["power"].max() for one in needed) == pytest.approx(60.0, rel=1e-6)
    assert max(np.abs(one["torque"]).max() for one in needed) < 40.0
    save_gait(gait, tmp_path / "gait.npz")
    assert audit(load_gait(tmp_path / "gait.npz")).passed


def test_it_is_recorded_and_read_again():
    for linkages in (RODS, RATES):
        task = problem(linkages).task
        assert task_from_record(task_record(task)) == task
        (before,) = linkages_from_rows([one[:-2] for one in linkages])  # rows without ranges
        assert before == linkages[0]._replace(range=(None, None))
    assert "motor space" not in [block.name for block in problem(()).blocks]


def changed(**values):
    return (RODS[0]._replace(**values),)


@pytest.mark.parametrize(
    ("linkages", "said"),
    [
        (changed(joints=("left_ankle_pitch", "left_toe")), "'left_toe', but no joint that moves"),
        (changed(joints=("left_ankle_roll", "left_ankle_pitch")), "give them from the pelvis on"),
        (changed(joints=("left_knee", "left_ankle_roll")), "do not follow each other"),
        ((*RODS, *RATES), "two linkages turn '.*_ankle_.*'; give the joints of one leg only, once"),
    ],
)
def test_what_does_not_fit_the_robot_is_told(linkages, said):
    with pytest.raises(InputError, match=said):
        problem(linkages)
