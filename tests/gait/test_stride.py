"""Strides of two steps: sideways, in turns, and the straight ones that one step gives too."""

import json
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from example_robots import needs_example_robots
from numerics import relative_error
from reference_cases import biped
from strides import point_of

from gaitopt.catalogue.entries import robot_by_name
from gaitopt.design.audit import audit
from gaitopt.design.certificate import certify
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.requirements import motor_loops
from gaitopt.design.sensitivity import sensitivities
from gaitopt.design.starts import design_gait
from gaitopt.design.summary import motor_summaries, summarise
from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait import quantities
from gaitopt.gait.gait_file import STRIDE, load_gait, save_gait
from gaitopt.gait.grid import STRIDE_EDGES, parts
from gaitopt.gait.presets import humanoid_task, preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.stride import StrideLayout
from gaitopt.mechanics.forward_kinematics import YAW
from gaitopt.motions.export import json_text, stride_samples
from gaitopt.simulate.second_engine import second_engine
from gaitopt.view.figures import FIGURES
from gaitopt.view.page import curves, facts


@cache
def found(options=None, /, **changes):
    return design_gait(biped(), preset_task(**{"speed": 0.5, **changes}), options, starts=1)


@cache
def turning():
    return found(lateral_speed=0.1, turn_rate=0.3)


def test_refined_instants_stay_with_their_step():
    """Cost without them; rows at the instants that are of either step."""
    problem, x = point_of("every way")
    finer = problem.with_grid(problem.grid.with_instants(np.array([0.031, 0.777, 0.9, 0.42])))
    assert finer.values(x).cost == pytest.approx(problem.values(x).cost, rel=1e-13)
    block = next(b for b in finer.blocks if b.name == "torque")
    values = finer.values(x).rows[finer.rows_of("torque")].reshape(block.lower.shape)
    for second in (False, True):
        own = parts(finer.grid, STRIDE_EDGES)[second]
        steps = finer.models[second].grid.instants
        assert own.instants == pytest.approx(steps)
        torque = finer.steps(x)[second].read(quantities.TORQUE) / block.scale
        rows = (block.times > 0.5) == second
        assert values[rows] == pytest.approx(torque)
        assert block.times[rows] == pytest.approx(0.5 * (own.instants + second), abs=1e-11)


def embedded(problem, x):
    """Parameters of a stride that consists of a step and its mirror image."""
    layout = problem.layout
    assert isinstance(layout, StrideLayout)
    return layout.pack([x, x])


@needs_example_robots
@pytest.mark.parametrize("name", ["biped", "g1", "talos"])
def test_the_step_of_a_straight_walk_is_an_optimal_stride(name):
    """Same cost, same motion, KKT conditions of the stride, without solving it."""
    if name == "biped":
        robot, task = biped(), preset_task(speed=0.8)
    else:
        robot = robot_by_name(name)
        task = humanoid_task(robot, speed={"g1": 0.6, "talos": 0.5}[name])
    options = DesignOptions(refine=False, differences="none")
    one = design(robot, task, options)
    problem = WalkProblem(robot, replace(task, stride=True))
    x = embedded(problem, one.solution.x)
    certificate = certify(problem, x)
    assert problem.values(x).cost == pytest.approx(one.solution.cost, rel=1e-10)
    assert certificate.optimal, certificate.kkt
    assert certificate.refereed, certificate.referee
    for step in problem.steps(x):
        assert relative_error(step.motion, one.problem.step(one.solution.x).motion) < 1e-10


@pytest.mark.parametrize(
    ("options", "cost"),
    # Refined, limits are held at other instants, and exceeded by up to 5e-7 between them.
    [(DesignOptions(refine=False), 1e-8), (None, 1e-7)],
    ids=["at the samples", "refined"],
)
def test_a_straight_stride_solved_is_the_walk_of_one_step(options, cost):
    one, two = found(options, speed=0.8), found(options, speed=0.8, stride=True)
    assert two.proven
    assert two.solution.cost == pytest.approx(one.solution.cost, rel=cost)
    for step in two.gait.steps:
        assert relative_error(step.q, one.gait.q) < 1e-5
        assert relative_error(step.torque, one.gait.torque) < 1e-4


@pytest.mark.parametrize(
    ("options", "cost", "motion"),
    # Refined, limits are held at other instants by rounding, and exceeded by 2.5e-7 between them.
    [(DesignOptions(refine=False), 1e-8, 1e-6), (None, 1e-7, 1e-5)],
    ids=["at the samples", "refined"],
)
def test_turns_to_either_side_are_mirror_images(options, cost, motion):
    left, right = found(options, turn_rate=0.4), found(options, turn_rate=-0.4)
    assert left.solution.cost == pytest.approx(right.solution.cost, rel=cost)
    for one, other in zip(left.gait.steps, reversed(right.gait.steps), strict=True):
        assert relative_error(one.q, other.q) < motion
        assert relative_error(one.torque, other.torque) < motion
        assert relative_error(one.impulse, other.impulse) < motion


@pytest.mark.parametrize(
    "way",
    [
        {"speed": 0.0, "lateral_speed": 0.2},
        {"speed": 0.0, "turn_rate": 0.5},
        {"speed": -0.3, "turn_rate": 0.3},
        {"lateral_speed": 0.1, "turn_rate": 0.3},
    ],
)
def test_walks_of_every_way_are_certified_by_both_engines(way):
    design = found(**way)
    assert design.certificate.certified, design.certificate.verdict
    engine = second_engine(design.gait, 61)
    assert engine.instants == 122
    assert engine.agrees, engine
    cost = design.gait.cost_unit
    assert cost == ("N²·m²" if way.get("speed") == 0.0 and "turn_rate" in way else "N²·m·s")


@pytest.mark.parametrize(
    "way",
    [
        {"speed": 0.0, "lateral_speed": 0.2, "slope": 0.1},
        {"lateral_speed": -0.08, "stairs": 0.05, "duration": 0.6},
    ],
)
def test_walks_across_a_slope_and_stairs_are_certified_by_both_engines(way):
    design = found(**way)
    assert design.certificate.verdict == "certified"
    assert second_engine(design.gait, 61).agrees
    assert design.gait.lateral_speed == pytest.approx(way["lateral_speed"])
    steps = [step.step_length for step in design.problem.steps(design.solution.x)]
    if "stairs" in way:
        assert steps == pytest.approx([0.3, 0.3], abs=1e-9)
        trajectory = design.gait.trajectory
        sole = trajectory.at([0.0, 1.2]).sole[:, :, 2, 3]
        assert sole[1] - sole[0] == pytest.approx([0.1, 0.1], abs=1e-9)


@pytest.mark.parametrize(
    ("options", "cost"),
    [(DesignOptions(refine=False), 1e-8), (None, 1e-7)],  # as above
    ids=["at the samples", "refined"],
)
def test_a_straight_stride_uphill_is_the_walk_of_one_step(options, cost):
    one, two = found(options, slope=0.1), found(options, slope=0.1, stride=True)
    assert two.proven
    assert two.solution.cost == pytest.approx(one.solution.cost, rel=cost)


@pytest.mark.parametrize(("speed", "aside", "turn"), [(0.5, 0.1, 0.3), (-0.2, -0.1, 0.0)])
def test_a_stride_goes_where_it_is_asked_to(speed, aside, turn):
    """On the average of the ways seen from the middles of its two double supports."""
    trajectory = found(speed=speed, lateral_speed=aside, turn_rate=turn).gait.trajectory
    T = trajectory.step_duration
    logs = []
    for step in range(2):
        here, there = (_middle(trajectory, at) for at in (step, step + 2))
        logs.append(pin.log6(here.inverse() * there).vector / (2.0 * T))
    wanted = [speed, aside, 0.0, 0.0, 0.0, turn]
    assert np.mean(logs, axis=0) == pytest.approx(wanted, abs=1e-9)


def _middle(trajectory, step):
    """Place midway between the feet when a step begins, pointing midway between them."""
    soles = [pin.SE3(sole) for sole in trajectory.at(step * trajectory.step_duration).sole[0]]
    yaw = [pin.log3(sole.rotation)[2] for sole in soles]
    place = np.mean([sole.translation for sole in soles], axis=0)
    return pin.SE3(pin.utils.rotate("z", float(np.mean(yaw))), place)


def test_cost_is_over_the_path():
    gait = turning().gait
    T = gait.duration
    effort = 0.0
    for step in range(2):
        times = np.linspace(0.0, T, 1001)
        torque = gait.trajectory.at(step * T + times, before=times > 0.0).torque
        effort += float(np.trapezoid((torque**2).sum(axis=1), times))
    assert gait.cost == pytest.approx(effort / (2.0 * T * np.hypot(0.5, 0.1)), rel=1e-3)


def test_trunk_turns_with_the_walk():
    problem, x = point_of("every way, everything free")
    first, second = problem.steps(x)
    starts, turn = [step.geometry[8] for step in (first, second)], 0.4 * first.duration
    assert starts[1] - starts[0] == pytest.approx(2.0 * turn)
    s = problem.models[0].grid.instants
    heading = 0.5 * (starts[0] + s * (starts[1] - starts[0]))
    plain = WalkProblem(problem.robot, problem.task).models[0]
    read = plain._optional.values(plain._optional.placed(first.motion[0]))[quantities.TRUNK]
    assert first.read(quantities.TRUNK)[:, YAW] == pytest.approx(read[:, YAW] - heading)


def test_rows_of_the_second_step_name_the_joints_as_they_are():
    problem, _ = point_of("straight")
    block = next(b for b in problem.blocks if b.name == "torque")
    assert block.label(0, 0) == "right_ankle_roll torque"
    assert block.label(len(block.instants) - 1, 0) == "left_ankle_roll torque"
    assert block.describe(len(block.instants) - 1, 0).endswith("at 100.0 % of the stride")
    sides = next(b for b in problem.blocks if b.name == "clearance")
    assert sides.label(0, 0) == "swing foot toe left height"
    assert sides.label(len(sides.instants) - 1, 0) == "swing foot toe right height"
    once = next(b for b in problem.blocks if b.name == "impulse")
    assert once.describe(1, 0) == "second step:  vertical impact impulse"


def test_gait_file_holds_both_steps(tmp_path):
    gait = turning().gait
    path = save_gait(gait, tmp_path / "turn.npz")
    again = load_gait(path)
    assert again.second is not None
    assert again.second.q.tolist() == gait.second.q.tolist()
    assert again.way == "0.5 m/s, 0.1 m/s to the left, turning left at 0.3 rad/s"
    report = audit(again)
    assert report.passed, report.altered
    assert "second torque" in report.differences
    with np.load(path) as content:
        arrays = dict(content)
    assert json.loads(str(arrays["schedule"]))["symmetry"] == "stride"
    assert {member.name for member in STRIDE} < arrays.keys()


@pytest.mark.parametrize("name", ["second_q", "second_coefficients_0", "second_base_position"])
def test_a_second_step_that_was_changed_is_refused(tmp_path, name):
    path = save_gait(turning().gait, tmp_path / "turn.npz")
    with np.load(path) as content:
        arrays = dict(content)
    arrays[name] = arrays[name] + 0.01
    np.savez(path, **arrays)
    with pytest.raises(GaitFileError, match=f"'{name}' was changed"):
        load_gait(path)
    if name != "second_q":
        with pytest.raises(GaitFileError, match="is not that of its splines"):
            load_gait(path, verify=False)
    else:
        assert "second q" in audit(load_gait(path, verify=False)).altered


def test_a_second_step_must_fit_the_first():
    gait = turning().gait
    with pytest.raises(InputError, match="must be a single step"):
        replace(gait, second=gait)
    longer = replace(gait.second, time=2.0 * gait.second.time, knots=2.0 * gait.second.knots)
    with pytest.raises(InputError, match="must last as long as its first"):
        replace(gait, second=longer)


def test_trajectory_is_both_steps():
    design = turning()
    gait, trajectory = design.gait, design.gait.trajectory
    step = gait.second
    at = trajectory.at(gait.duration + step.time, before=step.time > 0.0)
    columns = trajectory.body.moving
    assert relative_error(at.q[:, columns], step.q @ gait.mirror.T) < 1e-12
    assert relative_error(at.torque[:, columns], step.torque @ gait.mirror.T) < 1e-9
    assert at.contact[:, 1].all()
    again = trajectory.at(2.0 * gait.duration + gait.time, before=gait.time > 0.0)
    assert relative_error(again.torque[:, columns], gait.torque) < 1e-9
    seam = trajectory.at([gait.duration] * 2, before=[True, False])
    assert relative_error(seam.q[1], seam.q[0]) < 1e-12
    assert relative_error(seam.base_position[1], seam.base_position[0]) < 1e-9
    rates = gait.rate_after
    assert relative_error(seam.dq[1][columns], rates) < 1e-9


def test_tables_count_both_steps():
    gait = turning().gait
    times = np.linspace(0.0, 2.0 * gait.duration, 4001)
    torque = np.abs(gait.trajectory.at(times).torque).max()
    motors = motor_summaries(gait)
    assert max(one["peak_torque_Nm"] for one in motors) == pytest.approx(torque, rel=2e-3)
    walk = summarise(gait)["walk"]
    assert (walk["lateral_speed_m_per_s"], walk["turn_rate_rad_per_s"]) == pytest.approx((0.1, 0.3))
    loops = motor_loops(gait)
    assert max(np.abs(loop.torque).max() for loop in loops) == pytest.approx(torque, rel=2e-3)
    assert loops[0].time[-1] == pytest.approx(4.0 * gait.duration)
    assert dict(facts(gait))["speed"] == gait.way
    assert curves(gait)["period"] == pytest.approx(2.0 * gait.duration)


@pytest.mark.parametrize("name", ["torques", "ground_force", "cop"])
def test_figures_draw_both_steps(name):
    straight, stride = (
        sum(len(axes.lines) + len(axes.collections) for axes in FIGURES[name](gait).axes)
        for gait in (found(speed=0.8).gait, turning().gait)
    )
    assert stride > straight


def test_tables_for_controllers_hold_both_steps():
    gait = turning().gait
    samples = stride_samples(gait)
    later = samples["step"] == 1
    assert samples["time"][later] == pytest.approx(gait.duration + gait.second.time)
    assert relative_error(samples["q"][later], gait.second.q @ gait.mirror.T) < 1e-15
    record = json.loads(json_text(gait, samples))
    assert (record["lateral_speed"], record["turn_rate"]) == pytest.approx((0.1, 0.3))
    assert len(record["splines"]["coefficients"]["right_knee"]) == 2


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"lateral_speed": np.nan}, "lateral_speed is nan m/s; it must be a finite number"),
        ({"turn_rate": np.inf}, "turn_rate is inf rad/s"),
        ({"stride": 1}, "stride is 1; it must be True or False"),
        ({"stride": True, "speed_as": "penalty"}, "has its speed as a constraint"),
        (
            {"turn_rate": 0.1, "double_support": 0.05, "touch_down": "impact"},
            "mirror images of each other; take touch_down 'gentle'",
        ),
        ({"turn_rate": 0.1, "slope": 0.1}, "on a slope a walk that turns .*; leave out turn_rate"),
        ({"turn_rate": 0.1, "stairs": 0.1}, "on stairs a walk that turns .*; leave out turn_rate"),
        ({"turn_rate": 0.1, "cross_slope": 0.1}, "on a slope a walk that turns"),
        ({"turn_rate": 2.0}, r"a turn of 0\.8 rad a step; give at most 0\.6 rad"),
    ],
)
def test_strides_that_are_none_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        preset_task(**changes)


def test_what_strides_cannot_yet_is_said():
    design = turning()
    with pytest.raises(InputError, match="not of strides of two steps"):
        sensitivities(design.problem, design.solution.x, design.certificate.multipliers)


def test_names_of_parameters_are_unique_and_tell_the_step():
    problem, _ = point_of("every way, everything free")
    names = problem.layout.names
    assert len(set(names)) == len(names) == problem.layout.size
    assert [n for n in names if not re.search("_at_|_rate_|pelvis|trunk|foot_s|step_l", n)] == [
        "foot_yaw", "duration",
    ]  # fmt: skip
    assert names.count("foot_spacing") == names.count("second_step_foot_spacing") == 1
