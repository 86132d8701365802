import re

import numpy as np
import pytest
from motions import kinematics
from reference_cases import biped

from gaitopt.design.design import checked_start
from gaitopt.errors import UnreachableError
from gaitopt.gait import quantities
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.parameters import GEOMETRY, GEOMETRY_NAMES, set_geometry
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem


def guess_for(robot, **changes):
    problem = WalkProblem(robot, preset_task(**changes))
    return problem, first_guess(problem)


@pytest.mark.parametrize("speed", [0.4, 1.0, 1.5])
@pytest.mark.parametrize("postures", [1, 2, 4])
def test_it_walks_at_the_speed_asked_for(robot, speed, postures):
    problem, x = guess_for(robot, speed=speed, postures=postures)
    step = problem.step(x)
    assert step.step_length / step.duration == pytest.approx(speed)
    assert np.isfinite(problem.values(x).cost)


def test_the_swing_foot_is_lifted_level_over_the_ground(robot):
    problem, x = guess_for(robot, postures=3, clearance=0.04)
    heights = []
    for q in x[problem.layout.knots].reshape(-1, 12):
        sole = kinematics(robot, q).frame(robot.swing_frame)
        np.testing.assert_allclose(sole.rotation, np.eye(3), atol=1e-9)
        heights.append(sole.translation[2])
    assert min(heights) > 0.04 * np.sin(np.pi / 4.0) ** 2
    assert heights[1] == max(heights)


def test_the_pelvis_stands_midway_between_the_feet(robot):
    problem, x = guess_for(robot)
    step = problem.step(x)
    sole = step.posture.sole.translation
    pelvis = step.posture.pelvis.translation
    ankle = robot.legs.ankles[0]
    assert pelvis[1] == pytest.approx(sole[1] / 2.0)
    assert pelvis[0] == pytest.approx(ankle[0] + sole[0] / 2.0)
    np.testing.assert_allclose(*np.linalg.norm(step.posture.legs, axis=1), rtol=0.02)


def test_the_trunk_leans_forward_a_little(robot):
    problem, x = guess_for(robot)
    assert 0.0 < x[problem.layout.index("trunk_pitch")] < 0.2


def test_it_keeps_clear_of_the_stance_foot(robot):
    problem, x = guess_for(robot, lateral_gap=0.02)
    rows = problem.rows_of("lateral")
    slack = problem.values(x).rows[rows] - problem.rows.lower[rows]
    nodes = problem.grid.nodes
    assert slack.reshape(nodes, 4)[[0, -1]].min() > 0.0


def test_on_the_other_foot_it_is_the_mirror_image():
    """A narrow robot's swing foot keeps clear on its own side, whichever foot stands."""
    task = preset_task(lateral_gap=0.03)
    right, left = (WalkProblem(biped(side), task) for side in ("right", "left"))
    one, other = right.step(first_guess(right)), left.step(first_guess(left))
    expected = one.read(quantities.CORNERS).reshape(-1, 4, 3)[:, [1, 0, 3, 2]] * [1.0, -1.0, 1.0]
    np.testing.assert_allclose(
        other.read(quantities.CORNERS).reshape(-1, 4, 3), expected, atol=1e-9
    )


def test_the_foot_slows_down_before_it_lands(robot):
    problem, x = guess_for(robot)
    step = problem.step(x)
    last = (step.q_end - x[problem.layout.knots].reshape(-1, 12)[-1]) / (step.duration / 3.0)
    assert 0.0 < step.rate_before @ last / (last @ last) < 1.0


def test_fixed_quantities_keep_their_value(robot):
    values = {"trunk_pitch": 0.11, "foot_spacing": 0.19, "foot_yaw": 0.15, "pelvis_roll": 0.02}
    table = set_geometry(GEOMETRY, {n: {"free": False, "value": v} for n, v in values.items()})
    problem, x = guess_for(robot, geometry=table)
    geometry = dict(zip([q.name for q in GEOMETRY], problem.step(x).geometry, strict=True))
    assert {n: geometry[n] for n in values} == values


@pytest.mark.parametrize("stance", ["right", "left"])
@pytest.mark.parametrize("more", [{}, {"slope": 0.1}, {"lateral_speed": 0.1}, {"toe_off": 0.7}])
@pytest.mark.parametrize("spacing", [0.3, 0.5, 0.8])
def test_the_pelvis_is_midway_and_low_enough_where_the_spacing_is_fixed(spacing, more, stance):
    robot = biped(stance)
    value = spacing * robot.legs.side
    table = set_geometry(GEOMETRY, {"foot_spacing": {"free": False, "value": value}})
    problem, x = guess_for(robot, speed=0.6, geometry=table, **more)
    for step in problem.steps(x):
        legs = np.linalg.norm(step.posture.legs, axis=1)
        middle = 0.5 * step.posture.sole.translation[1]
        assert step.posture.pelvis.translation[1] == pytest.approx(middle)
        assert legs.max() < 0.996 * robot.legs.reach
        assert step.geometry[GEOMETRY_NAMES.index("foot_spacing")] == value


HELD = [
    ("pelvis_height", 1.2, {}), ("pelvis_height", -1.0, {}), ("pelvis_height", 1e18, {}),
    ("pelvis_height", 1.2, {"heel_strike": 0.2}), ("pelvis_height", 0.9, {"boundary": "lifted"}),
    ("pelvis_height", 0.8, {"turn_rate": 0.3}), ("pelvis_forward", 2.0, {}),
    ("pelvis_lateral", -1.0, {}), ("foot_spacing", 2.0, {}),
]  # fmt: skip


@pytest.mark.parametrize(("name", "value", "more"), HELD)
def test_up_to_where_a_quantity_can_be_held_is_told(robot, name, value, more):
    """It said to lower the pelvis, which was held."""

    def guess(value):
        table = set_geometry(GEOMETRY, {name: {"free": False, "value": value}})
        return guess_for(robot, geometry=table, **more)

    with pytest.raises(UnreachableError, match=rf"^{name} is held at .* out of reach") as caught:
        guess(value)
    told = str(caught.value)
    assert "lower the pelvis" not in told
    found = re.search(r"hold it at (\S+) m at (most|least), better near (\S+), or let", told)
    end, own = float(found[1]), float(found[3])
    assert found[2] == ("most" if value > own else "least")
    for sound in (end, own):
        guess(sound)
    with pytest.raises(UnreachableError):
        guess(end + 0.002 * np.sign(value - own))


def test_what_is_held_together_out_of_reach_is_named(robot):
    held = {
        "pelvis_height": {"free": False, "value": 1.2},
        "foot_spacing": {"free": False, "value": 2},
    }
    with pytest.raises(UnreachableError, match="; held are pelvis_height, foot_spacing: let them"):
        guess_for(robot, geometry=set_geometry(GEOMETRY, held))


def test_a_walk_to_begin_with_whose_pelvis_is_then_held_too_high_is_told(robot):
    _, x = guess_for(robot)
    table = set_geometry(GEOMETRY, {"pelvis_height": {"free": False, "value": 1.2}})
    problem = WalkProblem(robot, preset_task(geometry=table))
    with pytest.raises(UnreachableError, match=r"hold it at 0\.\d+ m at most"):
        checked_start(problem, np.delete(x, problem.layout.shape.start))


def test_feet_held_where_no_leg_reaches_are_told(robot):
    table = set_geometry(GEOMETRY, {"foot_spacing": {"free": False, "value": 1.3}})
    with pytest.raises(UnreachableError, match=r"aside of its hip, .*; hold it at 1.213 m at"):
        guess_for(robot, geometry=table)
    with pytest.raises(UnreachableError, match=r"give a smaller lateral_gap"):
        guess_for(robot, lateral_gap=1.3)


@pytest.mark.parametrize(
    ("name", "value"),
    [("pelvis_height", 0.52), ("pelvis_lateral", 0.07), ("pelvis_forward", -0.17),
     ("trunk_pitch", 0.11), ("foot_spacing", 0.19), ("pelvis_yaw", 0.03)],
)  # fmt: skip
def test_a_first_guess_that_is_given_is_used(robot, name, value):
    usual, x = guess_for(robot)
    assert abs(x[usual.layout.index(name)] - value) > 0.005
    table = set_geometry(GEOMETRY, {name: {"value": value}})
    problem, x = guess_for(robot, geometry=table)
    assert x[problem.layout.index(name)] == value
    bounded = set_geometry(table, {name: {"lower": value + 0.01, "upper": value + 0.2}})
    problem, x = guess_for(robot, geometry=bounded)
    assert x[problem.layout.index(name)] == value + 0.01


def test_bounds_are_kept(robot):
    table = set_geometry(GEOMETRY, {"pelvis_height": {"lower": 0.4, "upper": 0.55}})
    problem, x = guess_for(robot, geometry=table)
    assert x[problem.layout.index("pelvis_height")] == 0.55
    assert (x >= problem.variables.lower).all()
    assert (x <= problem.variables.upper).all()


def test_a_step_longer_than_the_legs_is_refused(robot):
    with pytest.raises(
        UnreachableError,
        match=r"a step of 1\.600 m \(4 m/s for 0\.4 s\) is longer than the legs can span: at most "
        r"1\.164 m; ask for a lower speed or a shorter step duration",
    ):
        guess_for(robot, speed=4.0)


@pytest.mark.parametrize("more", [{}, {"double_support": 0.05}, {"stairs": 0.1}], ids=str)
def test_no_clearance_is_too_high_to_begin_with(robot, more):
    """Its rows are violated there, and the diagnosis says by how much it must be lower."""
    problem = WalkProblem(robot, preset_task(clearance=10.0, **more))
    rows = problem.values(first_guess(problem)).rows
    assert np.isfinite(rows).all()
    short = (rows - problem.rows.lower)[problem.rows_of("clearance")]
    assert short.min() < -5.0  # m, over the scale of the rows


def test_noise_is_on_the_joints_only_and_repeats(robot):
    problem, x = guess_for(robot)
    noisy = perturbed(problem, x, 0.2, seed=7)
    np.testing.assert_array_equal(noisy, perturbed(problem, x, 0.2, seed=7))
    np.testing.assert_array_equal(noisy[problem.layout.shape], x[problem.layout.shape])
    noise = (noisy - x)[: problem.layout.rates.stop]
    assert np.std(noise) == pytest.approx(0.2, rel=0.3)
    assert np.abs(perturbed(problem, x, 0.2, seed=8) - noisy).max() > 0.05
    assert (x == first_guess(problem)).all()
