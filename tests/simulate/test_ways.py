"""Walks in every way under feedback: turns, sideways, backward, on heel and toe, on both feet.

Margins are those that leave feedback room; a few steps are enough to see the way.
"""

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from gaitopt.cli.optimise import fragile_lines
from gaitopt.design.options import DesignOptions
from gaitopt.design.starts import design_gait
from gaitopt.design.walkability import LANDING, PRESSURE, weak_points
from gaitopt.errors import InputError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.simulate.battery import directions
from gaitopt.simulate.mujoco_model import simulated_robot
from gaitopt.simulate.reference import Reference, both_feet, step_samples
from gaitopt.simulate.second_engine import second_engine
from gaitopt.simulate.stability import stability
from gaitopt.simulate.walk import WalkOptions, designed_speed, simulate, squared_torque, way_of
from gaitopt.simulate.whole_body import whole_body_walks

TASKS = {
    "turn": ("robust", {"speed": 0.4, "lateral_speed": 0.1, "turn_rate": 0.4, "duration": 0.5}),
    "backward": ("robust", {"speed": -0.4}),
    "in place": ("robust", {"speed": 0.0, "turn_rate": 0.5, "duration": 0.5}),
    "heel and toe": (
        "humanoid",
        {"speed": 1.0, "duration": 0.5, "heel_strike": 0.15, "toe_off": 0.7},
    ),
    "both feet": (
        "robust",
        {
            "speed": 0.8, "duration": 0.5, "double_support": 0.05, "boundary": "closed",
        },
    ),
}  # fmt: skip

GIVEN = DesignOptions(toe_begin="given")


@pytest.fixture(scope="module")
def gaits(robot):
    return {
        name: design_gait(robot, preset_task(preset, robot, **task), GIVEN, starts=1).gait
        for name, (preset, task) in TASKS.items()
    }


@pytest.fixture(scope="module")
def make():
    """Make controllers; those of the last walk share its reference."""
    return whole_body_walks()


@pytest.fixture(params=TASKS)
def gait(request, gaits):
    return gaits[request.param]


def test_it_walks_as_designed(gait, make):
    walk = simulate(gait, WalkOptions(steps=4), make)
    assert walk.walked
    assert walk.speed == pytest.approx(designed_speed(gait), rel=0.05, abs=0.01)
    assert walk.times.mean() == pytest.approx(gait.duration, rel=0.03)
    assert abs(walk.drift) < 0.03
    assert walk.turn_rate == pytest.approx(gait.turn_rate, abs=0.03)


def test_no_preset_is_advised_that_walks_on_heel_and_toe_seldom_keep(gaits):
    heeled = " ".join(fragile_lines(gaits["heel and toe"]))
    assert "raise --" in heeled
    assert "--preset" not in heeled


def test_squared_torque_is_the_cost_of_the_whole_walk(gait):
    assert squared_torque(gait) == pytest.approx(gait.cost, rel=0.02)


def test_way_and_pushes_turn_with_the_walk(gaits):
    """After two steps everything is turned by the stride."""
    gait = gaits["turn"]
    stride = gait.trajectory.advance(2) * gait.trajectory.advance(0).inverse()
    for early, late in zip(way_of(gait, 1), way_of(gait, 3), strict=True):
        assert late == pytest.approx(stride.rotation @ early, abs=1e-12)
    pushes = directions(gait)
    assert np.cross(pushes["forward"], [0.0, 0.0, 1.0]) @ pushes["backward"] == pytest.approx(0.0)
    turned = np.arctan2(pushes["forward"][1], pushes["forward"][0])
    assert turned == pytest.approx(0.4 * gait.duration * 3.5, abs=0.2)
    along, left = way_of(gait, 0)
    first, second = (gait.trajectory.advance(k).rotation[:, 0] for k in (-1, 0))
    assert (first + second) @ left / ((first + second) @ along) == pytest.approx(-0.1 / 0.4)


@pytest.mark.parametrize("name", ["heel and toe", "both feet"])
def test_tasks_move_as_their_rates_say(gaits, name):
    """By central differences between the instants of the reference, away from its jumps."""
    gait = gaits[name]
    trajectory = gait.trajectory
    robot = simulated_robot(trajectory.body)
    reference = Reference(robot, trajectory)
    for foot in (0, 1):
        targets = reference.targets[foot]
        for k in np.linspace(20, len(targets) - 20, 9).astype(int):
            before, here, after = targets[k - 1 : k + 2]
            kinds = [(t.turn is None, t.behind is None) for t in (before, here, after)]
            if len(set(kinds)) > 1:
                continue
            h = 2.0 * reference.interval
            change = (after.com_velocity - before.com_velocity) / h
            assert change == pytest.approx(here.com_acceleration, abs=2e-2)
            change = (after.sole_twist - before.sole_twist) / h
            assert change == pytest.approx(here.sole_acceleration, abs=2e-1)
            if here.turn is not None:
                turned = (after.turn.angle - before.turn.angle) / h
                assert turned == pytest.approx(here.turn.rate, abs=1e-3)
                change = (after.turn.rate - before.turn.rate) / h
                assert change == pytest.approx(here.turn.acceleration, abs=1e-1)


def test_steps_begin_with_what_both_feet_do(gaits):
    gait = gaits["both feet"]
    both = both_feet(gait.trajectory)
    assert both == pytest.approx(0.05)
    samples = step_samples(gait.trajectory, 1, 101)
    assert samples.contact[:10].all()  # both stand for a tenth of the step
    assert samples.contact[11:].sum(axis=1).tolist() == [1] * 90
    assert (samples.standing[11:] == 1).all()
    late = step_samples(gait.trajectory, 0, 101).q[-1, gait.trajectory.body.moving]
    assert late == pytest.approx(
        gait.trajectory.at(gait.duration - both).q[0, gait.trajectory.body.moving], abs=1e-9
    )
    assert both_feet(gaits["turn"].trajectory) == 0.0


def test_the_controller_turns_with_the_walk(gaits, make):
    """A stride later, everything turned about the vertical, it asks for the same torques."""
    gait = gaits["turn"]
    trajectory = gait.trajectory
    robot = simulated_robot(trajectory.body)
    controller = make(robot, trajectory, None)
    at = trajectory.at(0.1)
    qpos = robot.position(at.configuration[0])
    qvel = robot.velocity(at.configuration[0], at.velocity[0])
    qvel[robot.dof[0]] += 0.1
    early = controller.torque(0.1, qpos, qvel)
    for foot in (1, 0):
        controller.touch_down(foot, 0.0)
    stride = trajectory.advance(2) * trajectory.advance(0).inverse()
    x, y, z, w = pin.Quaternion(stride.rotation).coeffs()
    turned, fast = qpos.copy(), qvel.copy()
    turned[:3] = stride.act(qpos[:3])
    mujoco.mju_mulQuat(turned[3:7], np.array([w, x, y, z]), qpos[3:7])
    fast[:3] = stride.rotation @ qvel[:3]
    assert controller.torque(0.1, turned, fast) == pytest.approx(early, abs=1e-6)


def test_feet_roll_and_rise_as_designed(gaits, make):
    gait = gaits["heel and toe"]
    walk = simulate(gait, WalkOptions(steps=1, frames=200.0), make)
    robot = simulated_robot(gait.trajectory.body)
    data, rolled, rose = mujoco.MjData(robot.model), 0, 0
    for row in walk.motion[walk.motion[:, 0] < gait.duration]:
        data.qpos[:] = row[1:]
        mujoco.mj_kinematics(robot.model, data)
        R = data.site_xmat[robot.site[0]].reshape(3, 3)
        designed = gait.trajectory.at(row[0]).sole[0, 0]
        pitch, wanted = (np.arctan2(-m[2, 0], m[2, 2]) for m in (R, designed))
        assert pitch == pytest.approx(wanted, abs=0.03)
        rolled, rose = rolled + (pitch < -0.05), rose + (pitch > 0.05)
    assert rolled >= 3
    assert rose >= 5


@pytest.mark.parametrize("name", ["turn", "backward"])
def test_the_landing_speed_holds_to_the_end_of_the_swing(gaits, name):
    gait = gaits[name]
    asked = gait.number("task", "margins", "landing_speed")
    slowest = {point.name: point.value for point in weak_points(gait)}[LANDING]
    assert asked <= slowest < 1.01 * asked  # it is what the walk presses on


def test_weak_points_are_of_what_lands_and_stands(gaits):
    """The heel lands alone; who lands at zero speed beside a foot that stands needs no speed."""
    rolling = {point.name: point.value for point in weak_points(gaits["heel and toe"])}
    assert rolling[LANDING] > -1e-3  # toes on their way up do not land
    assert rolling[PRESSURE] > 4e-3  # strips at heel and toe are edges by design
    assert LANDING not in {point.name for point in weak_points(gaits["both feet"])}


def test_heels_of_both_steps_roll_as_their_own_impacts_leave_them(robot):
    """The trajectory of a stride has the torques of its samples, and MuJoCo the impacts of both."""
    changes = {"duration": 0.5, "heel_strike": 0.15, "toe_off": 0.7, "turn_rate": 0.3}
    problem = WalkProblem(robot, preset_task("standard", **changes))
    x = perturbed(problem, first_guess(problem), 0.02, 3)
    x[problem.layout.names.index("second_step_landing_angle")] += 0.03
    gait = gait_at(problem, x, {})
    for number, step in enumerate(gait.steps):
        E = gait.mirror if number else np.eye(len(gait.mirror))
        at = gait.trajectory.at(number * gait.duration)
        torque = at.torque[0, gait.trajectory.body.moving]
        assert torque == pytest.approx(E @ step.torque[0], rel=1e-9)
    assert second_engine(gait, 5).agrees


@pytest.mark.parametrize("name", ["turn", "heel and toe", "both feet"])
def test_no_multipliers_where_they_are_not_defined(gaits, name):
    with pytest.raises(InputError, match="multipliers are those of walks on flat feet"):
        stability(gaits[name])
