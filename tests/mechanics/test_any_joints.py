"""Trees of joints: legs of five and of seven joints, a waist that turns, arms that swing."""

import numpy as np
import pinocchio as pin
import pytest
from motions import random_motion
from numerics import check_differences, check_jacobian, relative_error, steps
from pelvis_rooted import PelvisRooted
from synthetic_bipeds import FIVE, SOLE, SYNTHETIC, biped_urdf, synthetic
from urdf_edits import add_arm, edited_urdf
from walks import WALKS, walk

from gaitopt.errors import InputError, RobotError
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.mechanics.impact import Impact
from gaitopt.mechanics.inverse_kinematics import LegKinematics
from gaitopt.mechanics.single_support import SingleSupport
from gaitopt.model.joint_tree import JointTree, lock_upper_body
from gaitopt.model.robot import Robot
from gaitopt.model.symmetry import exchange_error

EXACT = 1e-10
WITH_ARMS = SYNTHETIC[:2]
OTHER_JOINTS = [name for name in WALKS if "joints" in name]


@pytest.fixture(params=SYNTHETIC)
def robot(request):
    return synthetic(request.param)


def unrooted(robot: Robot, seed: int = 0) -> PelvisRooted:
    """The same robot as Pinocchio reads it, free-flyer at its root link."""
    whole = pin.buildModelFromXML(robot.urdf, pin.JointModelFreeFlyer())
    others = robot.joint_names[robot.tree.legs.stop :]
    reduced = lock_upper_body(whole, robot.stance_sole, robot.swing_sole, moving=others)
    return PelvisRooted(reduced, robot.stance_sole, robot.joint_names, seed)


@pytest.mark.parametrize("seed", range(3))
def test_inverse_dynamics_agrees_with_the_unrooted_model(robot, seed):
    other = unrooted(robot, seed)
    motion = (a[None] for a in (other.angles, other.rates, other.accelerations))
    effort = SingleSupport(robot, 1).state(*motion).effort[0]
    expected = other.effort()
    for part in (slice(3), slice(3, 6), slice(6, None)):
        assert relative_error(effort[part], expected[part]) < EXACT


def test_mass_matrix_agrees_with_the_unrooted_model(robot):
    other = unrooted(robot)
    D = pin.crba(robot.model, robot.model.createData(), other.state(robot.model)[0])
    assert relative_error(D, other.mass_matrix()) < EXACT


def test_impact_agrees_with_the_unrooted_model(robot):
    """Pinocchio's own impulse dynamics, the landing sole held still, seen from the stance sole."""
    other = unrooted(robot)
    pin.computeJointJacobians(other.model, other.data, other.q)
    foot = other.model.getFrameId(robot.swing_sole)
    pin.updateFramePlacements(other.model, other.data)
    J = pin.getFrameJacobian(other.model, other.data, foot, pin.LOCAL)
    after = pin.impulseDynamics(other.model, other.data, other.q, other.v, J, 0.0, 0.0)
    state = Impact(robot).state(other.angles, other.rates)
    assert relative_error(state.rate_after, after[other.columns]) < EXACT
    assert relative_error(state.sole_twist, other.jacobian() @ after) < EXACT


def test_second_derivatives_of_the_effort(robot, rng):
    count, n = 2, robot.tree.size
    motion = random_motion(robot, rng, count)
    weights = rng.normal(size=(count, 6 + n))
    support = SingleSupport(robot, count)
    found = support.derivatives(*motion)[1].hessian(weights)

    def gradient(block):
        def value(change):
            parts = [m + change * (k == block) for k, m in enumerate(motion)]
            return (weights[:, None] @ support.derivatives(*parts)[1].effort)[:, 0]

        return value

    H = np.concatenate([found.qq, found.qv.swapaxes(1, 2), found.qa.swapaxes(1, 2)], axis=1)
    check_jacobian(gradient(0), H, np.zeros(n), step=1e-4)
    H = np.concatenate([found.qv, found.vv], axis=1)
    check_jacobian(lambda c: gradient(1)(c)[:, : 2 * n], H, np.zeros(n), step=1e-3)


@pytest.mark.parametrize("name", OTHER_JOINTS)
def test_derivatives_of_the_whole_walk(name):
    """Cost and all rows at once: gradient and Jacobian, then the Hessian of the Lagrangian."""
    problem, x = walk(name).problem, walk(name).x
    rng = np.random.default_rng(2)
    d = rng.normal(size=x.size) * problem.variables.scale
    y = rng.normal(size=problem.rows.lower.size)

    def values(at):
        v = problem.values(at)
        return np.append(v.rows, v.cost * problem.cost_scale)

    def gradient(at):
        p = problem.point(at)
        return (p.gradient * problem.cost_scale + y @ p.jacobian) * problem.variables.scale

    point = problem.point(x)
    slope = np.append(point.jacobian @ d, point.gradient @ d * problem.cost_scale)
    found = [(values(x + h * d) - values(x - h * d)) / (2.0 * h) for h in steps(1e-4, 3)]
    check_differences(slope, found)
    curved = problem.hessian(x, y, problem.cost_scale) @ d * problem.variables.scale
    found = [(gradient(x + h * d) - gradient(x - h * d)) / (2.0 * h) for h in steps(1e-4, 4)]
    check_differences(curved, found)


def test_the_walks_have_other_numbers_of_joints():
    assert {walk(name).problem.robot.tree.stance for name in OTHER_JOINTS} == {5, 6, 7}
    assert max(walk(name).problem.robot.tree.size for name in OTHER_JOINTS) == 21


@pytest.mark.parametrize(("name", "sign"), [(WITH_ARMS[0], -1.0), (WITH_ARMS[1], 1.0)])
def test_a_waist_is_its_own_mirror(name, sign):
    """A yaw changes its sign, a pitch does not, wherever the file is rooted."""
    robot = synthetic(name)
    row = robot.joint_names.index("waist")
    assert robot.mirror[row, row] == sign
    assert np.abs(robot.mirror[row]).sum() == 1.0


def test_arms_exchange_with_each_other(robot):
    E = robot.mirror
    np.testing.assert_array_equal(E @ E, np.eye(robot.tree.size))
    for row, name in enumerate(robot.joint_names):
        side, _, part = name.partition("_")
        other = {"left": "right", "right": "left"}.get(side)
        image = name if other is None else f"{other}_{part}"
        assert abs(E[row, robot.joint_names.index(image)]) == 1.0
    soles = robot.stance_sole, robot.swing_sole
    assert exchange_error(robot.model, E, *soles) < 1e-12
    wrong = E.copy()
    wrong[-1] *= -1.0
    assert exchange_error(robot.model, wrong, *soles) > 1e-4


def test_the_tree_says_what_moves_what():
    tree = synthetic("seven, waist and arms").tree
    waist = tree.names.index("waist")
    assert tree.parents[waist] == tree.pelvis - 1
    assert tree.path(tree.pelvis).sum() == 7
    assert tree.path(tree.swing_foot).sum() == 14
    assert tree.path(waist + 1).sum() == 8
    assert not tree.path(0).any()
    beyond = tree.beyond(np.ones((1, tree.size, 1)))[0, :, 0]
    assert beyond[waist] == 7.0  # itself and two arms of three joints
    assert beyond[0] == tree.size
    table = tree.symmetric(np.ones((tree.size, tree.size)))
    assert table[waist, tree.pelvis] == 0.0  # the first joint of the swing leg: another branch
    assert table[waist, 0] == table[0, waist] == 1.0


def test_a_tree_out_of_order_is_refused():
    with pytest.raises(RobotError, match="root the model at the stance sole first"):
        JointTree(("a", "b", "c"), (-1, 0, 0), 1, 2)


def test_redundant_legs_reach_their_targets():
    """With seven joints the search takes the shortest steps, and meets both targets."""
    kinematics = LegKinematics(synthetic("seven, waist and arms"))
    pelvis, sole = kinematics.flat_feet(0.2, kinematics.robot.legs.spacing)
    q = kinematics.solve(pelvis, sole)
    found = kinematics.placements(q)
    for target, place in zip((pelvis, sole), found, strict=True):
        np.testing.assert_allclose(place.homogeneous, target.homogeneous, atol=1e-9)
    assert np.abs(q[kinematics.robot.tree.legs.stop :]).max() == 0.0


def test_the_closed_form_is_refused_where_it_has_no_solution():
    with pytest.raises(InputError, match="this robot has 10 joints, 5 in each leg: take boundary"):
        WalkProblem(synthetic("five"), preset_task())


def test_a_joint_that_does_not_exist_cannot_move():
    whole = pin.buildModelFromXML(biped_urdf(FIVE), pin.JointModelFreeFlyer())
    with pytest.raises(RobotError, match="there is no joint 'tail' to be kept moving"):
        lock_upper_body(whole, "right_sole", "left_sole", moving=("tail",))


def test_joints_beside_detected_legs_can_move():
    """Legs of six joints are found by themselves; an arm in the mirror plane is kept on request."""
    urdf = edited_urdf(add_arm)
    robot, locked = Robot.from_urdf(urdf, moving=("shoulder",)), Robot.from_urdf(urdf)
    assert robot.joint_names == (*locked.joint_names, "shoulder")
    assert robot.mirror[-1, -1] == 1.0
    assert robot.limits.torque[-1] == 50.0
    assert robot.mass == pytest.approx(locked.mass, rel=1e-12)
    q = np.random.default_rng(0).uniform(-0.3, 0.3, (1, 13))
    q[0, -1] = 0.0
    rest = np.zeros((1, 13))
    held = SingleSupport(robot, 1).state(q, rest, rest).effort[0]
    rest = rest[:, 1:]
    whole = SingleSupport(locked, 1).state(q[:, :-1], rest, rest).effort[0]
    assert relative_error(held[:-1], whole) < 1e-12


@pytest.mark.parametrize("count", [4, 5], ids=["ankles pitch", "ankles roll too"])
@pytest.mark.parametrize("seed", range(8))
def test_legs_of_few_joints_reach_with_their_knees_forward(count, seed):
    """Of tilted axes a knee that bends backwards may bring a foot nearer that cannot turn."""
    rng = np.random.default_rng(seed)
    leg = tuple(
        (name, origin, np.asarray(axis) + rng.uniform(-0.04, 0.04, 3), mass)
        for name, origin, axis, mass in FIVE[:count]
    )
    soles = {"stance_sole": "right_sole", "swing_sole": "left_sole", "sole": SOLE}
    robot = Robot.from_urdf(biped_urdf(leg), **soles)
    legs, kinematics = robot.legs, LegKinematics(robot)
    for step in (0.0, 0.2, 0.35):
        wanted = kinematics.flat_feet(step, legs.stance_width)
        q = kinematics.solve(*wanted)
        assert (legs.flexion * (q[list(legs.knees)] - legs.straight)).min() > 0.3
        for found, target in zip(kinematics.placements(q), wanted, strict=True):
            assert np.linalg.norm(found.translation - target.translation) < 0.03
