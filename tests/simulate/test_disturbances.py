"""Disturbed walks: each disturbance is in the simulation, and of the size that is asked for."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from sample_gait import sample_gait

from gaitopt.design.walkability import WeakPoint
from gaitopt.errors import InputError
from gaitopt.simulate.battery import directions, largest_push, suspect
from gaitopt.simulate.disturbance import (
    NONE,
    Delay,
    Disturbance,
    Push,
    SensorNoise,
    StartError,
    disturbed_robot,
    disturbed_start,
    measured,
    pelvis,
)
from gaitopt.simulate.mujoco_model import simulated_robot
from gaitopt.simulate.walk import WalkOptions, simulate
from gaitopt.simulate.whole_body import WholeBodyController


@pytest.fixture(scope="module")
def gait():
    return sample_gait()


@pytest.fixture(scope="module")
def walking(gait):
    return simulated_robot(gait.trajectory.body)


class Limp:
    """Motors without torque; notes what is measured."""

    interval = 0.002

    def __init__(self, robot, *_):
        self.robot, self.seen = robot, []

    def touch_down(self, foot, time):
        pass

    def torque(self, time, qpos, qvel):
        self.seen.append((time, qpos, qvel))
        return np.zeros(len(self.robot.dof))


def fall(gait, disturbance):
    """Return what a limp robot's controller saw over a step."""
    made = []
    simulate(
        gait,
        WalkOptions(steps=1),
        lambda *about: made.append(Limp(*about)) or made[0],
        disturbance,
    )
    return made[0].seen


def test_masses_and_rotors_are_those_of_the_disturbance(walking):
    at = mujoco.MjData(walking.model)
    mujoco.mj_forward(walking.model, at)
    heavy = disturbed_robot(walking, Disturbance(mass=0.05, armature=0.02))
    assert heavy.mass == pytest.approx(1.05 * walking.mass, rel=1e-14)
    found = mujoco.MjData(heavy.model)
    mujoco.mj_forward(heavy.model, found)
    matrices = []
    for model, data in ((walking.model, at), (heavy.model, found)):
        matrices.append(np.zeros((model.nv, model.nv)))
        mujoco.mj_fullM(model, data, matrices[-1])
    rotors = np.zeros(walking.model.nv)
    rotors[walking.dof] = 0.02
    assert matrices[1] == pytest.approx(1.05 * matrices[0] + np.diag(rotors), rel=1e-12)
    assert disturbed_robot(walking, NONE) is walking


def test_contacts_five_times_slower_push_back_a_twenty_fifth(walking):
    """MuJoCo's reference acceleration of a contact at rest goes with one over its time squared."""
    pushed = []
    for robot in (walking, disturbed_robot(walking, Disturbance(contact_time=0.02))):
        data = mujoco.MjData(robot.model)
        data.qpos[2] -= 1e-4
        mujoco.mj_forward(robot.model, data)
        into = data.efc_pos[: data.nefc] < 0.0
        assert into.sum() >= 4  # corners of soles
        pushed.append(data.efc_aref[: data.nefc][into])
    assert pushed[0] == pytest.approx(25.0 * pushed[1], rel=1e-12)
    assert (pushed[1] > 0.0).all()


def test_a_start_off_the_cycle_stands_on_its_flat_sole(gait, walking, rng):
    data = mujoco.MjData(walking.model)
    error = StartError(angle=0.02, rate=0.2)
    data.qpos[:], data.qvel[:] = disturbed_start(walking, gait.trajectory, error, rng)
    mujoco.mj_forward(walking.model, data)
    place, site = gait.trajectory.advance(0), walking.site[0]
    assert data.site_xpos[site] == pytest.approx(place.translation, abs=1e-12)
    assert data.site_xmat[site] == pytest.approx(place.rotation.ravel(), abs=1e-12)
    J = np.zeros((6, walking.model.nv))
    mujoco.mj_jacSite(walking.model, data, J[:3], J[3:], site)
    assert J @ data.qvel == pytest.approx(np.zeros(6), abs=1e-12)
    start = gait.trajectory.at(0.0)
    off = data.qpos[walking.qpos] - start.q[0, walking.body.moving]
    assert 0.005 < np.std(off) < 0.05


def test_a_push_gives_its_momentum_and_turns_about_the_pelvis(gait, walking):
    """A limp robot with and without it: after a push at once, before anything else differs."""
    push = Push((9.0, -4.0, 3.0), step=0, phase=0.0, duration=0.002)
    (_, q, v), (_, _, pushed) = fall(gait, NONE)[1], fall(gait, Disturbance(push=push))[1]
    data = mujoco.MjData(walking.model)
    data.qpos[:], data.qvel[:] = q, v
    mujoco.mj_fwdPosition(walking.model, data)
    mass = np.zeros((walking.model.nv, walking.model.nv))
    mujoco.mj_fullM(walking.model, data, mass)
    J = np.zeros((3, walking.model.nv))
    mujoco.mj_jac(walking.model, data, J, None, pelvis(walking, data), walking.base)
    # the standing sole pushes back; along what moves without it the impulse is all there is
    standing = np.zeros((6, walking.model.nv))
    mujoco.mj_jacSite(walking.model, data, standing[:3], standing[3:], walking.site[0])
    free = np.linalg.svd(standing)[2][6:].T
    found = free.T @ mass @ (pushed - v)
    assert found == pytest.approx(free.T @ J.T @ push.impulse, abs=0.05)


def test_torques_arrive_late():
    way = Delay(0.005)
    for tick in range(5):
        way.send(0.002 * tick, np.array([float(tick)]))
        assert way.arrived(0.002 * tick)[0] == max(0.0, np.floor(tick - 2.5))
    assert way.arrived(0.009)[0] == 2.0
    at_once = Delay(0.0)
    at_once.send(0.0, np.array([1.0]))
    at_once.send(0.002, np.array([2.0]))
    assert at_once.arrived(0.002)[0] == 2.0


def test_sensors_err_by_their_noise(gait, walking, rng):
    data = mujoco.MjData(walking.model)
    data.qpos[:] = walking.position(gait.trajectory.at(0.0).configuration[0])
    noise = SensorNoise()
    seen = [measured(walking, data, noise, rng) for _ in range(400)]
    q, v = (np.array(part) for part in zip(*seen, strict=True))
    spread = {
        "angle": (q[:, walking.qpos] - data.qpos[walking.qpos]).std(),
        "rate": v[:, walking.dof].std(),
        "position": (q[:, :3] - data.qpos[:3]).std(),
        "velocity": v[:, :3].std(),
        "turning": v[:, 3:6].std(),
        "attitude": 2.0 * np.sqrt(np.mean(1.0 - (q[:, 3:7] @ data.qpos[3:7]) ** 2) / 3.0),
    }
    for name, found in spread.items():
        assert found == pytest.approx(getattr(noise, name), rel=0.1), name
    assert np.linalg.norm(q[:, 3:7], axis=1) == pytest.approx(1.0, abs=1e-12)


def test_seeds_make_walks_again(gait):
    noisy = Disturbance(noise=SensorNoise(), start=StartError(), seed=3)
    one, two, other = (fall(gait, d)[-1] for d in (noisy, noisy, replace(noisy, seed=4)))
    assert np.array_equal(one[1], two[1])
    assert not np.array_equal(one[1], other[1])


def test_every_second_step_is_higher(gait):
    """On raised ground the foot lands sooner than on ground that is lowered."""
    lowered, raised = (
        simulate(gait, WalkOptions(steps=1), disturbance=Disturbance(ground=h))
        for h in (-0.01, 0.01)
    )
    assert lowered.walked
    assert raised.walked
    assert raised.times[0] < lowered.times[0] - 0.01


def test_pushes_that_cannot_be_survived_count_as_none(gait):
    """A controller without torque survives none, at any size."""
    forward = directions(gait)["forward"]
    found = largest_push(gait, "forward", forward, None, lambda *about: Limp(*about), 1)
    assert found.impulse == 0.0
    assert found.walk is None
    assert np.isnan(found.speed)
    assert not found.unbounded


def test_directions_know_where_the_other_foot_is(gait):
    step, swing = gait.trajectory.advance(4), gait.trajectory.advance(5)
    across = (swing.translation - step.translation)[1]
    assert directions(gait)["to the swing side"][1] * across > 0.0
    assert directions(gait)["to the stance side"][1] * across < 0.0


def test_a_fall_points_to_what_was_tried():
    points = [
        WeakPoint("a", 3.0, 1.0, "", False, "lower --a"),
        WeakPoint("b", 1.5, 1.0, "", False, "lower --b"),
        WeakPoint("c", 1.1, 1.0, "", False, "lower --c"),
    ]
    assert suspect(("c", "b"), tuple(points)).name == "b"


@pytest.mark.parametrize(
    ("what", "message"),
    [
        ({"mass": -1.0}, "must be above -1"),
        ({"delay": -0.001}, "the delay of a disturbance is -0.001 s; it must be 0 or more"),
        ({"armature": float("nan")}, "armature of a disturbance is nan"),
        ({"seed": -1}, "the seed of a disturbance is -1; it"),
        ({"ground": float("inf")}, "must be finite"),
        ({"contact_time": 0.0}, "contact time 0 s must be above 0"),
    ],
)
def test_disturbances_without_a_meaning_are_refused(what, message):
    with pytest.raises(InputError, match=message):
        Disturbance(**what)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Push((1.0, float("nan"), 0.0)), "impulse of a push is .1.0, nan, 0.0. N·s at 0.5"),
        (lambda: Push((1.0, 0.0, 0.0), phase=1.5), "at 1.5 of a step; give finite numbers, and a"),
        (
            lambda: Push((1.0, 0.0, 0.0), duration=-1.0),
            "the duration of a push is -1 s; it must be",
        ),
        (lambda: Push((1.0, 0.0, 0.0), step=-1), "the step of a push is -1; it must be 0 or more"),
        (lambda: SensorNoise(turning=-1.0), "the turning of a noise is -1 rad/s; it"),
        (lambda: StartError(angle=float("nan")), "the angle of a start is nan rad"),
    ],
)
def test_parts_of_disturbances_without_a_meaning_are_refused(make, message):
    """They walked on, fell for no reason that was told, or ended in NumPy's words."""
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize(
    ("torque", "message"),
    [
        (
            lambda *_: 1 / 0,
            r"controller Wrong: ZeroDivisionError.* \(line \d+ of test_disturbances",
        ),
        (lambda *_: [1.0], r"the torques \[1.0\]; return one number for each of the \d+ motors"),
        (lambda *_: [[1.0], [1.0, 2.0]], r"the torques .*; return one number for each"),
        (lambda *_: ["1"] * 12, r"the torques .*; return one number for each"),
        (lambda *_: [None] * 12, r"the torques .*; return one number for each"),
        (
            lambda self, time, *_: [
                float("nan") if time > 0.01 and k == 3 else 0 for k in range(12)
            ],
            r"asks for nan N·m of right_hip_pitch at 0.012 s of the walk; return finite",
        ),
        (
            lambda *_: [float("inf")] * 12,
            "asks for inf N·m of [a-z_]+ and 11 more at 0 s of the walk",
        ),
    ],
)
def test_a_mistake_in_a_controller_of_ones_own_is_told(gait, torque, message):
    wrong = type("Wrong", (Limp,), {"__module__": __name__, "torque": torque})
    with pytest.raises(InputError, match=message):
        simulate(gait, WalkOptions(steps=1), wrong)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"interval": float("nan")}, "interval of the controller is nan s; give the time"),
        ({"interval": 0.0}, "interval of the controller is 0.0 s; .* above 0"),
        ({"interval": 1e18}, "interval of the controller is 1e.18 s; .*not above the 0.4 s"),
        ({"interval": "2ms"}, "interval of the controller is '2ms' s; give the time"),
        (
            {"__new__": lambda *_: None},
            "the controller is None, which has no interval and no torque",
        ),
    ],
)
def test_what_is_no_controller_is_refused(gait, changes, message):
    wrong = type("Wrong", (Limp,), {"__module__": __name__, **changes})
    with pytest.raises(InputError, match=message):
        simulate(gait, WalkOptions(steps=1), wrong)


def test_a_controller_may_write_into_its_array_again(gait):
    """Torques on their way were those of now: the delay had no effect."""

    class Thrifty(WholeBodyController):
        kept = np.zeros(12)

        def torque(self, *seen):
            self.kept[:] = super().torque(*seen)
            return self.kept

    walks = [
        simulate(gait, WalkOptions(steps=1), make, disturbance=Disturbance(delay=0.01)).torque
        for make in (Thrifty, WholeBodyController)
    ]
    assert np.array_equal(*walks)
