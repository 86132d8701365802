"""Walks across a slope: strides whose two steps find gravity on either side."""

import functools
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from numerics import relative_error
from reference_cases import biped

from gaitopt.design.audit import audit
from gaitopt.design.certificate import ask_referee, on_fine_grid
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.errors import InputError
from gaitopt.gait import quantities
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import ground_of
from gaitopt.gait.terrain import Slope
from gaitopt.motions.motion import motion
from gaitopt.simulate.second_engine import second_engine
from gaitopt.simulate.stability import stability
from gaitopt.simulate.walk import WalkOptions, simulate

ACROSS = 0.1
WAY = {"speed": 0.6, "duration": 0.5}


@functools.cache
def found(options=None, **changes):
    return design(biped(), preset_task("standard", **{**WAY, **changes}), options)


def somewhere(**changes):
    """A stride off its first guess, seen at the instants of the proof."""
    task = preset_task("standard", speed=0.5, duration=0.6, **changes)
    problem = WalkProblem(biped(), task)
    problem = on_fine_grid(problem)
    return problem, perturbed(problem, first_guess(problem), 0.03, 2)


def test_each_step_is_the_level_one_with_gravity_turned_to_its_side():
    problem, x = somewhere(cross_slope=ACROSS, slope=0.05)
    right, left = np.sin(0.05), np.sin(ACROSS)
    up = np.sqrt(1.0 - right**2 - left**2)
    for step, side in zip(problem.steps(x), (-1.0, 1.0), strict=True):
        model = pin.Model(biped().model)
        model.gravity = pin.Motion(9.81 * np.array([-right, side * left, -up]), np.zeros(3))
        data = model.createData()
        for k in range(0, len(step.motion[0]), 40):
            q, v, a = (np.zeros(size) for size in (model.nq, model.nv, model.nv))
            q[6], (q[7:], v[6:], a[6:]) = 1.0, step.motion[:, k]
            effort = pin.rnea(model, data, q, v, a)
            np.testing.assert_allclose(step.read(quantities.WRENCH)[k], effort[:6], atol=1e-9)
            size = np.abs(effort).max()
            assert np.abs(step.read(quantities.TORQUE)[k] - effort[6:]).max() < 1e-12 * size
            assert np.abs(step.read(quantities.WRENCH)[k] - effort[:6]).max() < 1e-12 * size


def test_the_motors_raise_the_weight_and_pay_for_the_impacts():
    """Over a stride, 1e-9: across alone nothing is raised."""
    for slope in (0.0, 0.05):
        problem, x = somewhere(cross_slope=ACROSS, slope=slope)
        robot, steps = problem.robot, problem.steps(x)
        data, neutral = robot.model.createData(), pin.neutral(robot.model)[:7]
        work = lost = raised = 0.0
        for k, step in enumerate(steps):
            weights = step.duration * problem.models[k].grid.weights
            dq = step.motion[1]
            work += weights @ (step.read(quantities.TORQUE) * dq).sum(axis=1)
            ends = [np.concatenate([neutral, q]) for q in (step.posture.q_start, step.q_end)]
            begins = problem.models[k].exchange @ steps[1 - k].impact.rate_after
            for sign, q, rate in ((-1.0, ends[0], begins), (1.0, ends[1], step.rate_before)):
                M = pin.crba(robot.model, data, q)[6:, 6:]
                lost += sign * rate @ M @ rate / 2.0
            start, end = (np.array(pin.centerOfMass(robot.model, data, q)) for q in ends)
            # the parameters are no walk yet: what the mass rises by is that of the motion itself
            raised -= robot.mass * problem.models[k].robot.model.gravity.linear @ (end - start)
        assert lost > 0.1
        assert abs(work - (raised + lost)) < 1e-9 * abs(work)


def test_newton_and_euler_agree_and_object_to_other_ground():
    problem, x = somewhere(cross_slope=ACROSS)
    steps = problem.steps(x)
    for step, model in zip(steps, problem.models, strict=True):
        verdict = ask_referee(model.robot, step, model.grid, starts=(step, step))
        assert verdict.torque < 1e-10
        assert verdict.wrench < 1e-10
    other = ask_referee(problem.robot, steps[1], problem.models[1].grid)
    assert other.torque > 1e-3  # that of the other side


def test_walks_across_are_certified_mirror_images(tmp_path):
    left, right = found(cross_slope=ACROSS), found(cross_slope=-ACROSS)
    for walk in (left, right):
        assert walk.certificate.certified, walk.certificate.verdict
        engine = second_engine(walk.gait, 31)
        assert engine.agrees
        assert engine.largest < 1e-9
    at_samples = DesignOptions(refine=False)
    one, other = (found(at_samples, cross_slope=tilt).gait.cost for tilt in (ACROSS, -ACROSS))
    assert one == pytest.approx(other, rel=1e-9)
    # Between samples limits may be exceeded by less than 1e-6, by either walk where it likes.
    assert left.gait.cost == pytest.approx(right.gait.cost, rel=1e-5)
    # A minimum is flat: costs that agree so leave motions apart by the root of that.
    for one, other in zip(left.gait.steps, reversed(right.gait.steps), strict=True):
        assert relative_error(one.torque, other.torque) < 1e-3
    assert left.gait.cost > found().gait.cost
    first, second = left.gait.steps
    assert relative_error(first.torque, second.torque) > 0.1
    save_gait(left.gait, tmp_path / "gait.npz")
    again = load_gait(tmp_path / "gait.npz")
    assert audit(again).passed
    assert ground_of(again).words == "rising to the left, 10 % (5.73°)"


def test_a_stride_uphill_is_the_walk_uphill():
    ways = {"speed": 0.8, "duration": 0.4, "slope": 0.1}
    one, two = found(**ways), found(**ways, stride=True)
    assert two.certificate.certified
    assert two.gait.cost == pytest.approx(one.gait.cost, rel=1e-6)


def test_the_pelvis_stands_upright_in_double_support():
    """Its roll is told against the vertical; in the axes of the soles it leans uphill."""
    problem, _ = somewhere(cross_slope=ACROSS)
    rolls = [layout.geometry[7].value for layout in problem.layout.steps]
    assert problem.layout.geometry[7].name == "pelvis_roll"
    assert rolls == pytest.approx([-ACROSS, ACROSS])


def test_exported_feet_stand_beside_each_other_up_the_slope():
    gait = found(cross_slope=ACROSS).gait
    sampled = motion(gait, 100.0)
    heights = sampled.samples.sole[0, :, 2, 3]  # z against gravity; the right foot stands
    soles = gait.trajectory.at(np.zeros(1)).sole[0, :, :3, 3]
    apart = np.abs(np.diff(soles, axis=0))[0]
    assert apart[1] > 0.05
    assert heights == pytest.approx([0.0, apart[1] * np.sin(ACROSS)], abs=1e-9)
    down = ground_of(gait).down
    assert down[1] == pytest.approx(-np.sin(ACROSS))


def test_slopes_that_are_none_are_refused():
    for changes, reason in (
        ({"cross_slope": 1.2}, "cross_slope is 1.2 rad; it must be between -1 and 1 rad"),
        ({"cross_slope": np.nan}, "cross_slope is nan rad"),
        ({"cross_slope": 0.1, "stairs": 0.1}, "a walk has one ground"),
        ({"slope": 0.9, "cross_slope": 0.9}, "too steep together"),
    ):
        with pytest.raises(InputError, match=reason):
            preset_task("standard", **changes)


@pytest.mark.parametrize("across", [ACROSS, -ACROSS])
def test_it_walks_across_under_feedback(across):
    """Down the hill is where it would drift: half a foot at most."""
    task = preset_task("robust", biped(), speed=0.8, cross_slope=across)
    walk = simulate(design(biped(), task).gait, WalkOptions(steps=8))
    assert walk.walked, walk.ending
    assert abs(walk.speed / walk.designed_speed - 1.0) < 0.02
    assert walk.cost < 1.1 * walk.designed_cost
    assert abs(walk.drift) < 0.05


def test_what_walks_across_cannot_yet_is_said():
    gait = found(cross_slope=ACROSS).gait
    with pytest.raises(InputError, match="multipliers are those of walks"):
        stability(gait)


def test_a_slope_across_alone_and_with_another():
    assert Slope(0.1).down == (-np.sin(0.1), 0.0, -np.cos(0.1))
    both = Slope(-0.1, 0.2)
    assert np.linalg.norm(both.down) == pytest.approx(1.0, abs=1e-15)
    assert both.words(0.3) == "downhill, 10 % (5.73°), rising to the left, 20.3 % (11.5°)"
    assert Slope(0.0, -0.2).words(0.3) == "rising to the right, 20.3 % (11.5°)"
    task = replace(preset_task("standard"), cross_slope=0.1)
    assert task.steps == 2
    assert task.on(Slope(0.0)).steps == 1
