"""From standing to a walk, back, and from walk to walk."""

from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from reference_cases import biped
from strides import check_slopes
from synthetic_bipeds import synthetic
from transitions import ALONE, from_rest, to_rest, walk

from gaitopt.contact import AFTER
from gaitopt.design.audit import problem_of
from gaitopt.design.transition import (
    design_transition,
    standing_torque,
    transition_problem,
)
from gaitopt.errors import InputError, NoGaitFoundError
from gaitopt.gait import quantities
from gaitopt.gait.initial_guess import first_guess, perturbed, transition_guess
from gaitopt.gait.parameters import FOOT_YAW, GEOMETRY, set_geometry
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.transition_problem import (
    TransitionProblem,
    TransitionTask,
    centre_of_mass,
    junction_of,
    standing,
    step_durations,
    wrench_standing,
)
from gaitopt.motions.export import export_transition
from gaitopt.motions.motion import motion
from gaitopt.simulate.mujoco_model import simulated_robot


def problem_between(robot, task, ends, steps, free):
    """A transition of a walk that is a first guess, and a point of it near its own."""
    cycle = WalkProblem(robot, task)
    at = junction_of(cycle, first_guess(cycle))
    still = standing(cycle.robot, at.geometry)
    begin, finish = ({"walk": at, "rest": still}[end] for end in ends)
    asked = TransitionTask(task, begin, finish, step_durations(begin, finish, steps), free)
    problem = TransitionProblem(cycle.robot, asked)
    return problem, perturbed(problem, transition_guess(problem), 0.05, seed=5)


@pytest.mark.parametrize(
    ("ends", "steps", "free", "changes"),
    [
        (("rest", "walk"), 2, True, {}),
        (("walk", "rest"), 3, False, {"boundary": "lifted"}),
        (("walk", "walk"), 2, True, {"trunk_yaw": 0.2, "swing_tilt": 0.3}),
    ],
)
def test_slopes_and_hessians_are_those_of_the_transition(ends, steps, free, changes):
    check_slopes(*problem_between(biped(), preset_task(speed=0.8, **changes), ends, steps, free))


def test_slopes_with_every_geometric_quantity_free():
    free = set_geometry(GEOMETRY, {
        "pelvis_roll": {"free": True, "value": 0.03}, "foot_yaw": {"free": True, "value": -0.1},
    })  # fmt: skip
    task = preset_task(speed=0.8, geometry=free, trunk_yaw=0.2)
    check_slopes(*problem_between(biped(), task, ("rest", "walk"), 2, True))


def test_a_walk_is_a_transition_to_itself():
    """Its own steps, one after another, are those of the transition, to the last digit."""
    gait = walk()
    problem = transition_problem(gait, gait, steps=3, durations=gait.duration, postures=2)
    x = problem.layout.pack([gait.parameters] * 3)
    cycle = problem_of(gait).with_grid(problem.task.grid)
    assert problem.values(x).cost == pytest.approx(cycle.values(gait.parameters).cost * gait.speed)
    (step,) = cycle.steps(gait.parameters)
    for other in problem.steps(x):
        for what in (quantities.TORQUE, quantities.WRENCH, quantities.RATES, quantities.IMPULSE):
            assert other.read(what) == pytest.approx(step.read(what), rel=1e-8, abs=1e-7)
    rows = problem.values(x).rows
    assert (rows >= problem.rows.lower - 1e-7).all()
    assert (rows <= problem.rows.upper + 1e-7).all()
    assert problem.begin_gap(x) == pytest.approx((0.0, 0.0), abs=1e-12)


def test_a_robot_stands_evenly_on_both_feet():
    problem = WalkProblem(biped(), preset_task(speed=0.5))
    walked = problem.step(first_guess(problem)).geometry.copy()
    for yaw in (0.0, -0.2):
        walked[FOOT_YAW] = yaw
        still = standing(problem.robot, walked)
        assert problem.model.exchange @ still.q == pytest.approx(still.q, abs=1e-12)
        placements = problem.model.boundary.kinematics.placements(still.q)
        sole = placements[1]
        assert sole.translation[2] == pytest.approx(0.0, abs=1e-12)
        assert pin.log3(sole.rotation) == pytest.approx([0.0, 0.0, yaw], abs=1e-12)
        middle = 0.5 * (problem.robot.sole.toe + problem.robot.sole.heel)
        own = np.array([middle, 0.5 * (problem.robot.sole.left + problem.robot.sole.right), 0.0])
        other = sole.act(own * [1.0, -1.0, 1.0])
        centre = centre_of_mass(problem.robot, still.q)
        assert centre[:2] == pytest.approx(0.5 * (own + other)[:2], abs=1e-12)
        assert np.linalg.norm(problem.robot.legs.ankles[0] - hip(still, problem)) == pytest.approx(
            0.96 * problem.robot.legs.reach
        )


def hip(still, problem):
    pelvis, _ = problem.model.boundary.kinematics.placements(still.q)
    return pelvis.act(problem.robot.legs.hips[0])


def test_torques_at_rest_hold_the_weight():
    """By virtual work of gravity alone: a stretch of both legs does the work of both knees."""
    problem = WalkProblem(biped(), preset_task(speed=0.5))
    walked = problem.step(first_guess(problem)).geometry
    robot, moved = problem.robot, 1e-5
    low, high = (standing(robot, walked, 0.9 + sign * moved) for sign in (-1.0, 1.0))
    torque = standing_torque(robot, standing(robot, walked, 0.9).q)
    rise = centre_of_mass(robot, high.q)[2] - centre_of_mass(robot, low.q)[2]
    assert torque @ (high.q - low.q) == pytest.approx(robot.weight * rise, rel=1e-6)
    assert wrench_standing(robot)[2] == pytest.approx(robot.weight / 2.0)


@pytest.mark.parametrize("found", [from_rest, to_rest])
def test_a_transition_is_certified(found):
    result = found()
    assert result.certificate.certified, result.certificate.verdict
    assert result.certificate.rear_foot_lifts
    assert result.transition.certified
    assert len(result.transition.steps) == 2
    assert result.transition.step_lengths == pytest.approx(result.transition.meta["step_lengths"])


@pytest.mark.parametrize("found", [from_rest, to_rest])
def test_the_motion_is_continuous_where_it_must_be(found):
    """Angles and feet always; rates too where there is no impact; at rest nothing moves."""
    result, gait = found().transition, walk()
    trajectory = result.trajectory
    ends = trajectory.period * np.array([0.0, 1.0])
    joins = np.cumsum([phase.duration for phase in trajectory.phases])[:-1]
    before, after = trajectory.at(joins, before=True), trajectory.at(joins)
    assert after.q == pytest.approx(before.q, abs=1e-12)
    assert after.base_position == pytest.approx(before.base_position, abs=1e-12)
    assert after.sole == pytest.approx(before.sole, abs=1e-12)
    rests = 0 if result.before is None else len(joins) - 1
    assert after.velocity[rests] == pytest.approx(before.velocity[rests], abs=1e-10)
    others = np.delete(np.arange(len(joins)), rests)
    jumps = np.abs(after.dq - before.dq).max(axis=1)[others]
    assert (jumps > 0.1).all()  # by the impacts of the walk and of the steps
    still = trajectory.at(ends).velocity[0 if result.before is None else 1]
    assert np.abs(still).max() < 1e-12
    whole = trajectory.at(np.linspace(0.0, trajectory.period, 401))
    lowest = (whole.sole[:, :, 2, 3]).min()
    assert lowest > -1e-9
    own = gait.trajectory.at(np.linspace(0.0, 2.0 * gait.duration, 41)[1:-1])
    begin = 0.0 if result.after is None else trajectory.period - 2.0 * gait.duration
    walked = trajectory.at(begin + own.time)
    if (begin > 0.0 and len(result.steps) % 2 == 0) or begin == 0.0:
        assert walked.q == pytest.approx(own.q, abs=1e-9)
        assert walked.dq == pytest.approx(own.dq, abs=1e-8)
        assert walked.torque == pytest.approx(own.torque, abs=1e-7)


def mujocos_torques(trajectory, times):
    """Largest error of torques and of the balance of the base, over the largest torque."""
    robot = simulated_robot(trajectory.body)
    robot.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    data, worst = mujoco.MjData(robot.model), 0.0
    samples = trajectory.at(times)
    for k in range(len(times)):
        q, v = samples.configuration[k], samples.velocity[k]
        data.qpos[:], data.qvel[:] = robot.position(q), robot.velocity(q, v)
        data.qacc[:] = robot.acceleration(q, v, samples.acceleration[k])
        mujoco.mj_inverse(robot.model, data)
        needed = data.qfrc_inverse.copy()
        for foot in np.flatnonzero(samples.contact[k]):
            R = data.site_xmat[robot.site[foot]].reshape(3, 3)
            wrench = samples.wrench[k, foot].reshape(2, 3) @ R.T
            needed -= robot.sole_jacobian(data, foot).T @ wrench.ravel()
        left = needed @ robot.free(data.qpos)
        stated = samples.torque[k, trajectory.body.moving]
        worst = max(worst, np.abs(left[:6]).max(), np.abs(left[6:] - stated).max())
    assert samples.contact.all(axis=1).any()  # both feet where it rests
    return worst / np.abs(samples.torque).max()


@pytest.mark.parametrize("found", [from_rest, to_rest])
def test_mujocos_inverse_dynamics_agrees(found):
    trajectory = found().transition.trajectory
    times = np.linspace(0.0, trajectory.period, 201)
    assert mujocos_torques(trajectory, times) < 1e-9


def test_steps_that_a_transition_has_not_are_refused():
    trajectory = from_rest().transition.trajectory
    count = len(trajectory.phases)
    at_its_end = trajectory.at(trajectory.period)
    place = trajectory.advance(count - 1).homogeneous
    assert place == pytest.approx(at_its_end.sole[0, at_its_end.standing[0]], abs=1e-9)
    for step in (-1, count):
        with pytest.raises(InputError, match=f"there is no step {step} of {count}"):
            trajectory.advance(step)


def test_certificate_tells_of_a_beginning_that_is_none():
    result = from_rest()
    moved = replace(result.problem.transition.begin, rate=np.full(12, 1e-3))
    problem = TransitionProblem(
        result.problem.robot, replace(result.problem.transition, begin=moved)
    )
    from gaitopt.design.transition import certify_transition

    problem.given = result.problem.given  # what is evaluated begins at rest all the same
    other = certify_transition(problem, result.solution.x)
    assert not other.refereed


def test_from_walk_to_walk():
    """Steps between two speeds, from the durations of one to those of the other."""
    slow = walk(0.7, duration=0.5)
    found = design_transition(slow, walk(), steps=2, options=replace(ALONE, refine=False))
    assert found.certificate.optimal
    assert found.certificate.refereed
    assert found.problem.transition.durations == pytest.approx((0.5 - 0.1 / 3, 0.4 + 0.1 / 3))
    assert found.transition.words == "from 0.7 m/s to 1 m/s"


def test_one_step_is_too_few():
    with pytest.raises(NoGaitFoundError, match=r"1 steps.*give more --steps"):
        design_transition(None, walk(), steps=1, durations=0.4, options=ALONE)


@pytest.mark.parametrize(
    ("ends", "asked", "words"),
    [
        ((None, None), {}, "give at least one"),
        ((None, walk), {"steps": 0}, "give 1 to 8"),
        ((None, walk), {"steps": 2.0}, "give 1 to 8"),
        ((None, walk), {"durations": [0.4, 0.4]}, "one for all or one for each"),
        ((None, walk), {"durations": 1e300}, "one for all or one for each"),
        ((None, walk), {"stretch": 2.0}, "give one from 0.5"),
        ((walk, None), {"margins": {"torque_limit": 1.0}}, "nearer to 1"),
    ],
)
def test_refusals(ends, asked, words):
    before, after = (one and one() for one in ends)
    with pytest.raises(InputError, match=words):
        transition_problem(before, after, **asked)


def test_a_gait_whose_samples_are_not_its_own_is_refused():
    gait = walk()
    other = replace(gait, q=gait.q + 1e-3)
    with pytest.raises(InputError, match="gaitopt check"):
        transition_problem(None, other)


def test_motion_is_exported_and_read_back(tmp_path):
    result = from_rest().transition
    path = export_transition(result, tmp_path / "m.npz", format="mujoco", rate=100.0)
    with np.load(path) as content:
        qpos, contact = content["qpos"], content["foot_contact"]
    samples = motion(result, 100.0, joints="mujoco").samples
    assert qpos[:, :3] == pytest.approx(samples.base_position)
    rest = samples.time < result.begins - 1e-6
    assert contact[rest].all()
    assert not contact[~rest].all(axis=1).any()
    assert np.ptp(qpos[rest], axis=0) == pytest.approx(0.0, abs=1e-12)
    assert (np.diff(samples.step) >= 0).all()
    with pytest.raises(InputError, match="another format"):
        export_transition(result, tmp_path / "m.yaml", format="bezier")


def test_steps_share_the_instants_of_a_refined_grid():
    problem, x = problem_between(biped(), preset_task(speed=0.8), ("rest", "walk"), 3, False)
    finer = problem.with_grid(problem.grid.with_instants(np.array([0.05, 0.4, 0.93])))
    assert finer.values(x).cost == pytest.approx(problem.values(x).cost, rel=1e-12)
    block = next(b for b in finer.blocks if b.name == "torque")
    values = finer.values(x).rows[finer.rows_of("torque")].reshape(block.lower.shape)
    for k, step in enumerate(finer.steps(x)):
        begin, end = finer.edges[k : k + 2]
        rows = (block.times > begin + (k > 0) * AFTER / 2) & (block.times <= end)
        rows |= (block.times == 0.0) & (k == 0)
        assert values[rows] == pytest.approx(step.read(quantities.TORQUE) / block.scale)


def test_slopes_of_a_robot_with_other_joints():
    robot, task = synthetic("seven, waist and arms"), preset_task(speed=0.4, boundary="lifted")
    check_slopes(*problem_between(robot, task, ("rest", "walk"), 2, True))
