"""What is compiled against the plain path, which Newton-Euler, MuJoCo and differences check."""

import copy
import os
import pickle
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields

import numpy as np
import pytest
from changed_robots import changed
from motions import bent_posture
from synthetic_bipeds import SYNTHETIC, synthetic
from tied_bipeds import TIED, tied
from walks import walk

from gaitopt.contact import Hinge, ToeLine
from gaitopt.errors import UnreachableError
from gaitopt.gait.double_support import InverseKinematicsSupport, JointAngleSupport
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.mechanics import compiled
from gaitopt.mechanics.capsule_distance import nearest
from gaitopt.mechanics.forward_kinematics import ForwardKinematics
from gaitopt.mechanics.impact import Impact
from gaitopt.mechanics.inverse_dynamics_hessian import DynamicsHessian, WeightedDynamics
from gaitopt.mechanics.inverse_kinematics import LegKinematics
from gaitopt.mechanics.single_support import SingleSupport, by_pinocchio, corners_plainly
from gaitopt.model.robot import Robot, cached_workspace

ROBOTS = ("biped", "on a slope, with rotors", *SYNTHETIC)
COUNTS = (1, 2, 3, 4, 5, 31)  # four instants are computed together
DOWN = (0.48, -0.36, -0.8)
CLOSE = 1e-13  # of the largest entry


@pytest.fixture(params=ROBOTS)
def any_robot(request, robot):
    return made(request.param, robot)


def made(name: str, robot: Robot) -> Robot:
    """Return one of `ROBOTS`, from the biped."""
    if name in SYNTHETIC:
        return synthetic(name)
    if name == "biped":
        return robot
    rotors = changed(robot, {"armature": np.linspace(0.01, 0.2, robot.tree.size)}, 1.0)
    return rotors.on_ground(DOWN)


def random_motion(robot: Robot, count: int, seed: int = 0) -> np.ndarray:
    """Return q, dq, ddq, shape (3, N, n)."""
    size = np.array([1.0, 4.0, 30.0])[:, None, None]
    return size * np.random.default_rng(seed).normal(size=(3, count, robot.tree.size))


def check(found, expected, close: float = CLOSE) -> None:
    for one, other in zip(found, expected, strict=True):
        assert one.shape == other.shape
        assert np.abs(one - other).max(initial=0.0) <= close * np.abs(other).max(initial=0.0)


def test_kernels_are_built_where_there_is_a_compiler():
    assert compiled.BUILT or not (shutil.which("g++") or shutil.which("clang++"))


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("derivatives", [False, True])
def test_inverse_dynamics(any_robot, count, derivatives):
    motion = random_motion(any_robot, count)
    found = compiled.bodies_of(any_robot).inverse_dynamics(*motion, derivatives)
    check(found, by_pinocchio(any_robot, motion, derivatives))


@pytest.mark.parametrize("derivatives", [False, True])
def test_corners_of_the_swing_sole(any_robot, derivatives):
    _, foot, _, axes = by_pinocchio(any_robot, random_motion(any_robot, 5), derivatives)
    points = np.random.default_rng(1).normal(size=(4, 3))
    found = compiled.bodies_of(any_robot).foot_points(foot, axes, points)
    check(found, corners_plainly(any_robot, foot, axes, points))


def test_tables_of_other_shapes_are_refused(robot):
    motion = random_motion(robot, 3)
    with pytest.raises(ValueError, match=r"axes must have shape \(3, 12, 6, \)"):
        compiled.bodies_of(robot).foot_points(
            np.zeros((3, 4, 3)), np.zeros((2, 12, 6)), np.zeros((4, 3))
        )
    with pytest.raises(ValueError, match=r"dq must have shape \(3, 12, \)"):
        compiled.bodies_of(robot).inverse_dynamics(motion[0], motion[1, :2], motion[2], True)


WALKS = {
    "standard": {},
    "a stride": {"lateral_speed": 0.1},
    "heel to toe": {"heel_strike": 0.15, "toe_off": 0.2},
    "with a double support": {"double_support": 0.2},
}


@pytest.mark.parametrize("name", WALKS)
def test_rows_and_their_derivatives(robot, monkeypatch, name):
    task = preset_task("standard", speed=0.8, samples=13, **WALKS[name])
    found = []
    for wanted in (True, False):
        monkeypatch.setattr(compiled, "WANTED", wanted)
        problem = WalkProblem(robot, task)
        x = first_guess(problem)
        point = problem.point(x)
        found.append((point.rows, point.jacobian, point.gradient, problem.values(x + 1e-3).rows))
    for one, other in zip(*found, strict=True):
        assert np.abs(one - other).max() <= 1e-12 * np.abs(other).max()


def test_linear_rows_are_their_matrix_times_what_they_read():
    random = np.random.default_rng(0)
    first, second = random.normal(size=(4, 3, 5)), random.normal(size=(4, 2, 5))
    both, each = random.normal(size=(2, 5)), random.normal(size=(2, 1, 3))
    rows = compiled.linear_rows()
    rows.add(1, [0, 1], [3, 2], [0, 1, 2, 3], both)
    rows.add(9, [0], [3], [3, 1], each)
    side_by_side = np.concatenate([first, second], axis=1)
    expected = np.concatenate([(both @ side_by_side).reshape(8, 5), (each @ first[[3, 1]])[:, 0]])
    slopes, values = np.full((12, 5), np.nan), np.full(12, np.nan)
    rows.of([first, second], slopes)
    rows.of([first[:, :, 0], second[:, :, 0]], values)
    for begin, end in ((0, 3), (8, 10), (10, 12), (11, 12)):
        some = np.full((end - begin, 5), np.nan)
        rows.of([first, second], some, begin)
        np.testing.assert_array_equal(some, slopes[begin:end])
    check([slopes[1:11], values[1:11]], [expected, expected[:, 0]])
    assert np.isnan(slopes[[0, 11]]).all()  # nobody's


@pytest.mark.parametrize(
    ("quantity", "found"),
    [
        (np.zeros((3, 3, 5)), np.zeros((12, 5))),  # an instant too few
        (np.zeros((4, 2, 5)), np.zeros((12, 5))),
        (np.zeros((4, 3, 4)), np.zeros((12, 5))),
        (np.zeros((4, 3, 10))[:, :, ::2], np.zeros((12, 5))),
        (np.zeros((4, 3)), np.zeros((12, 5))),
        (np.zeros((4, 3, 5)), np.zeros((12, 10))[:, ::2]),
        (np.zeros((4, 3, 5)), np.zeros((12, 5, 1))),
    ],
)
def test_linear_rows_refuse_what_they_cannot_read(quantity, found):
    rows = compiled.linear_rows()
    rows.add(9, [0], [3], [3, 1], np.ones((1, 3)))
    with pytest.raises(ValueError, match=r"quantity 0 has another shape|found must be rows"):
        rows.of([quantity], found)
    with pytest.raises(ValueError, match="give 1 quantities"):
        rows.of([], np.zeros((12, 5)))
    with pytest.raises(ValueError, match="in the order of their numbers"):
        rows.add(10, [0], [1], [0], np.ones((1, 1)))


@pytest.mark.parametrize("number", [-(2**63), -1, 2**62, 2**63 - 1])
def test_numbers_beyond_all_tables_are_refused(number):
    rows = compiled.linear_rows()
    rows.add(0, [0], [3], [0], np.ones((1, 3)))
    with pytest.raises(ValueError, match=r"rows are numbered from 0|give 1 quantities"):
        rows.of([], np.zeros((1, 5)), number)
    with pytest.raises(ValueError, match="in the order of their numbers"):
        rows.add(number, [0], [3], [0], np.ones((1, 3)))
    quantity = max(-(2**31), min(number, 2**31 - 1)) - (number == -1)
    with pytest.raises(ValueError, match="there are not so many quantities"):
        compiled.kernels.Placing(
            [1, 0], [0], [quantity], np.ones((1, 7)), np.ones((2, 3)), np.ones((2, 3))
        )


def test_tables_of_any_layout_are_read(robot):
    """Also of another order of bytes, between other numbers, or at an address of no double."""
    bodies, motion = compiled.bodies_of(robot), random_motion(robot, 5)
    expected = bodies.inverse_dynamics(*motion, True)
    unaligned = np.zeros(motion.nbytes + 1, np.uint8)[1:].view(float).reshape(motion.shape)
    unaligned[...] = motion
    fixed = motion.copy()
    fixed.flags.writeable = False
    for one in (np.asfortranarray(motion), motion.astype(">f8"), unaligned, fixed):
        for found, table in zip(bodies.inverse_dynamics(*one, True), expected, strict=True):
            np.testing.assert_array_equal(found, table)


def test_threads_compute_together(robot):
    """Kernels keep nothing between calls."""
    bodies, motions = compiled.bodies_of(robot), [random_motion(robot, 31, k) for k in range(8)]
    alone = [bodies.inverse_dynamics(*motion, True) for motion in motions]
    with ThreadPoolExecutor(4) as threads:
        for _ in range(20):
            together = threads.map(lambda motion: bodies.inverse_dynamics(*motion, True), motions)
            for found, expected in zip(together, alone, strict=True):
                for table, other in zip(found, expected, strict=True):
                    np.testing.assert_array_equal(table, other)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_finite_stays_so(robot, value):
    motion = random_motion(robot, 5)
    motion[0, 2, 3] = value
    effort, *_ = compiled.bodies_of(robot).inverse_dynamics(*motion, False)
    assert not np.isfinite(effort[2]).any()
    assert np.isfinite(effort[[0, 1, 3, 4]]).all()


@pytest.mark.parametrize("asked", ["0", "1"])
def test_the_plain_path_can_be_asked_for(asked):
    say = "from gaitopt.mechanics import compiled; print(compiled.in_use() == compiled.BUILT)"
    done = subprocess.run(
        [sys.executable, "-c", say],
        env={**os.environ, "GAITOPT_COMPILED": asked},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.strip() == str(asked == "1" or not compiled.BUILT)


@pytest.mark.parametrize("count", COUNTS)
def test_forward_kinematics(any_robot, count):
    q = random_motion(any_robot, count)[0]
    found = compiled.bodies_of(any_robot).placed(q)
    check([found], [ForwardKinematics(any_robot.model).placed(q).frames])


def segments_at(rng) -> tuple[np.ndarray, np.ndarray]:
    """Segments of any kind, their ends (c, 2, 3): also points, and two that are parallel."""
    ends = rng.normal(size=(9, 2, 3))
    ends[3, 1], ends[4, 1] = ends[3, 0], ends[4, 0]  # points
    ends[6] = ends[5] + 0.3
    ends[8] = ends[7][::-1] * 0.5
    return ends, np.array([*np.ndindex(9, 9)]).T


@pytest.mark.parametrize("count", COUNTS)
def test_nearest_points_of_segments(rng, count):
    ends, sides = segments_at(rng)
    frames = ForwardKinematics(synthetic("five").model).placed(rng.normal(size=(count, 10))).frames
    carriers = np.array([0, 2, 5, 7, 10, 3, 3, 4, 4])  # those that are parallel stay so
    world = np.einsum("cnij,cej->cnei", frames[carriers][:, :, :3, :3], ends)
    world += frames[carriers][:, :, None, :3, 3]
    first, second = (world[side].reshape(-1, 2, 3) for side in sides)
    along = ends[:, 1] - ends[:, 0]
    expected = nearest(first, second)
    found = compiled.kernels.nearest(
        frames, carriers, np.concatenate([ends[:, 0], along], axis=1), sides,
        (along**2).sum(axis=1)[sides],
    )  # fmt: skip
    s, t = expected.share
    check([found[11:]], [expected.between.T])  # of parallel ones the nearest points are rounding
    apart = np.abs(found[6:8] - np.stack([s, t])).max(axis=0) > 1e-9
    p, q = expected.along
    sine = np.linalg.norm(np.cross(p, q), axis=1)
    assert not apart[sine > 1e-6].any()


@pytest.mark.parametrize(
    ("carriers", "sides", "said"),
    [([11], [[0], [0]], "carriers must be from 0 to 10"), ([0], [[0], [1]], "sides must be")],
)
def test_numbers_of_nothing_are_refused(carriers, sides, said):
    frames = ForwardKinematics(synthetic("five").model).placed(np.zeros((2, 10))).frames
    with pytest.raises(ValueError, match=said):
        compiled.kernels.nearest(frames, carriers, np.ones((1, 6)), sides, np.ones((2, 1)))


@pytest.fixture
def both_paths(monkeypatch):
    """Call something by the kernels, then by the plain path."""

    def run(call):
        found = []
        for wanted in (True, False):
            monkeypatch.setattr(compiled, "WANTED", wanted)
            assert compiled.in_use() == wanted
            found.append(call())
        return found

    return run


@pytest.mark.parametrize("count", COUNTS)
def test_inverse_dynamics_hessian(any_robot, both_paths, rng, count):
    motion = random_motion(any_robot, count)
    *_, axes = by_pinocchio(any_robot, motion, True)
    base, weights = (rng.normal(size=(count, k)) for k in (6, 6 + any_robot.tree.size))
    at = WeightedDynamics(axes, *motion, 10.0 * base, weights)
    tables = both_paths(lambda: DynamicsHessian(any_robot).of(at))
    check(*([getattr(one, each.name) for each in fields(one)] for one in tables))


@pytest.mark.parametrize("count", COUNTS)
def test_corner_hessian(any_robot, both_paths, rng, count):
    motion = random_motion(any_robot, count)
    _, derivatives = SingleSupport(any_robot, count).derivatives(*motion)
    weights = rng.normal(size=(count, 4, 3))
    check(*([one] for one in both_paths(lambda: derivatives.corner_hessian(weights))))


def test_hessians_refuse_tables_of_other_shapes(robot):
    kernels, still = compiled.bodies_of(robot), np.zeros((3, 12))
    with pytest.raises(ValueError, match=r"weights must have shape \(3, 18, \)"):
        kernels.inverse_dynamics_hessian(still, still, still, np.zeros((3, 6)), still)
    with pytest.raises(ValueError, match=r"jacobian must have shape \(3, 4, 3, 12, \)"):
        compiled.kernels.corner_hessian(np.zeros((3, 12, 6)), np.zeros((3, 4, 3, 11)), still)


@pytest.mark.parametrize("name", ["biped", "six, waist and arms"])
@pytest.mark.parametrize("reach", [0.3, 0.8, 3.0])
def test_inverse_kinematics(robot, both_paths, rng, name, reach):
    """From near postures to such as no leg meets: the same angles or the same refusal."""
    robot = robot if name == "biped" else synthetic(name)

    def solve(targets):
        try:
            return LegKinematics(robot).solve(*targets)
        except UnreachableError as error:
            return str(error)

    for _ in range(12):
        q = bent_posture(robot, rng)
        q[robot.tree.legs] += rng.uniform(-reach, reach, 12)
        targets = LegKinematics(robot).placements(q)
        found, expected = both_paths(lambda targets=targets: solve(targets))
        if isinstance(expected, str):
            assert found == expected
        else:
            np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12)


PLACED = np.array([0.52, 0.07, -0.3, 0.1, 0.15, 0.4, 0.05, -0.04, 0.06, 0.4])
TOE, HEEL = Hinge(np.zeros(3), np.eye(3)[1]), Hinge(np.array([-0.2, 0.0, 0.0]), np.eye(3)[1])
STANDS = [{}, {"rise": 0.05}, {"hinge": TOE}, {"hinge": TOE, "landing": HEEL, "rise": -0.05}]


@pytest.mark.parametrize("form", [InverseKinematicsSupport, JointAngleSupport])
@pytest.mark.parametrize("feet", STANDS)
def test_double_support(robot, both_paths, rng, form, feet):
    support = form(robot, **feet)
    at = np.append(PLACED, [0.1, 0.2])
    q = bent_posture(robot, rng)

    def evaluate():
        support._last = None
        posture = support.posture(at[: support.count], q)
        slopes = support.derivatives(posture)
        weights = [np.cos(np.arange(k)) for k in (q.size, 6, slopes.gaps.shape[0] * 6)]
        H = support.hessian(
            posture, slopes, weights[0], weights[1].reshape(2, 3), weights[2].reshape(-1, 6)
        )
        placed = (one.homogeneous for one in (posture.pelvis, posture.sole))
        found = posture.pelvis_axes, posture.sole_axes, posture.legs, posture.points, *placed
        return *found, slopes.q_start, slopes.legs, slopes.gaps, H

    for found, expected in zip(*both_paths(evaluate), strict=True):
        size = np.abs(expected).max(initial=0.0)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12 * size)


def test_a_leg_that_is_singular_is_refused(robot, both_paths):
    support = InverseKinematicsSupport(robot)
    posture = support.posture(PLACED, np.zeros(0))
    axes, slopes = np.ones((12, 6)), np.zeros((12, support.count))

    def refused():
        with pytest.raises(UnreachableError, match="a leg is singular"):
            support.slopes(posture, axes)
        with pytest.raises(UnreachableError, match="a leg is singular"):
            support.curvature(posture, np.zeros((2, 3)), axes, slopes, np.arange(12.0))

    both_paths(refused)


LANDINGS = {  # on a line of the sole, or flat; from a stance sole that turns, or rests
    "flat": (False, False),
    "flat, turning": (False, True),
    "line": (True, False),
    "line, turning": (True, True),
}


@pytest.fixture(params=[*ROBOTS, *(name for name in TIED if "bent" not in name)])
def landing_robot(request, robot):
    return tied(request.param) if request.param in TIED else made(request.param, robot)


@pytest.fixture(params=LANDINGS)
def landing(request, landing_robot, rng):
    """An impact, and arguments of `state`."""
    line, turning = LANDINGS[request.param]
    hinge, n = ToeLine(0.01).hinge(landing_robot.sole), len(landing_robot.joint_names)
    at = rng.normal(0.0, 0.3, n), rng.normal(0.0, 2.0, n), 1.7 * hinge.twist if turning else None
    return Impact(landing_robot, hinge if line else None), at


def test_impact(landing, both_paths):
    impact, at = landing
    (state, slopes), (expected, others) = both_paths(lambda: impact.derivatives(*at))
    tables = "kkt", "axes", "frame"
    check(*([getattr(one, name) for name in tables] for one in (slopes, others)))
    # what two good solutions of a system may differ by
    close = np.finfo(float).eps * np.linalg.cond(slopes.kkt)
    check([slopes.inputs, slopes.inverse], [others.inputs, others.inverse], close)
    check([result(state, slopes)], [result(expected, slopes)], close)
    alone, _ = both_paths(lambda: impact.state(*at))
    np.testing.assert_array_equal(result(alone, slopes), result(state, slopes))


def result(state, slopes):
    """V+, I and, on a line, w."""
    return np.array([*state.velocity, *state.impulse, state.turn_rate])[: len(slopes.kkt)]


def test_hessian_of_the_impact(landing, both_paths, rng):
    impact, (posture, rate, sole) = landing
    state, slopes = impact.derivatives(posture, rate, sole)
    weights = rng.normal(size=len(slopes.kkt))
    one, other = both_paths(lambda: impact.weighted(posture, rate, state, slopes, weights, sole))
    inertial = cached_workspace(impact.robot, DynamicsHessian).of(one.dynamics)
    assert (one.kernel is not None, other.kernel) == (True, None)
    check([one.hessian(inertial)], [other.hessian(inertial)])


def test_joints_that_follow_by_a_bend_take_the_plain_path():
    robot = tied("bent elbows and shanks")
    at = np.zeros((2, len(robot.joint_names)))
    assert Impact(robot).derivatives(*at)[1].bent is not None


def test_impacts_refuse_tables_of_other_shapes(robot):
    kernel = compiled.landing_of(robot, None)
    with pytest.raises(ValueError, match=r"rate must have shape \(12, \)"):
        kernel.impact(np.zeros(12), np.zeros(11), None, True)
    with pytest.raises(ValueError, match=r"twist must have shape \(6, \)"):
        kernel.impact(np.zeros(12), np.zeros(12), np.zeros(5), True)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_an_impact_that_is_not_finite_stays_so(robot, value):
    posture, rate = np.full(12, 0.1), np.zeros(12)
    posture[3] = value
    assert not np.isfinite(Impact(robot).state(posture, rate).velocity).any()


def test_kernels_of_other_sources_are_not_used():
    say = (
        "from gaitopt.mechanics import kernels; kernels.SOURCES += 1; "
        "from gaitopt.mechanics import compiled; print(compiled.in_use())"
    )
    done = subprocess.run([sys.executable, "-c", say], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
    assert "install gaitopt again" in done.stderr


DESIGN = """
from gaitopt import biped13, design_gait, urdf_text
from gaitopt.gait.presets import preset_task
from gaitopt.mechanics import compiled
from gaitopt.model.robot import Robot
biped = Robot.from_urdf(urdf_text(biped13()), stance_sole="right_sole", swing_sole="left_sole")
found = design_gait(biped, preset_task("standard", speed=0.8), starts=1)
print(compiled.in_use(), found.certificate.verdict, repr(float(found.gait.cost)))
"""


def test_a_design_by_the_plain_path_is_the_same():
    said = [
        subprocess.run(
            [sys.executable, "-c", DESIGN],
            env={**os.environ, "GAITOPT_COMPILED": asked},
            capture_output=True, text=True, check=True,
        ).stdout.split()
        for asked in "01"
    ]  # fmt: skip
    (plain, verdict, cost), (fast, *proof, by_kernels) = said
    assert (plain, fast) == ("False", str(compiled.BUILT))
    assert proof == [verdict]
    assert float(by_kernels) == pytest.approx(float(cost), rel=1e-9)


def test_tables_of_another_double_support_are_refused(robot):
    bodies, support = compiled.bodies_of(robot), InverseKinematicsSupport(robot)
    posture = support.posture(PLACED, np.zeros(0))
    chains, search = support._chains(posture), (40, 1e-7, 0.5)
    with pytest.raises(ValueError, match=r"geometry must have shape \(9, \)"):
        support._compiled.at(PLACED[:8])
    with pytest.raises(ValueError, match=r"targets must have shape \(2, 4, 4, \)"):
        bodies.close_legs(np.zeros(12), np.zeros((2, 3, 4)), *search)
    with pytest.raises(ValueError, match="the legs must have six joints each"):
        compiled.bodies_of(synthetic("five")).close_legs(np.zeros(12), np.zeros((2, 4, 4)), *search)
    with pytest.raises(ValueError, match=r"joint axes must have shape \(12, 6, \)"):
        compiled.kernels.support_slopes(*chains, np.zeros((7, 6)))
    with pytest.raises(ValueError, match=r"drives must have shape \(6, 10, \)"):
        compiled.kernels.support_slopes(chains[0], chains[1][:5], *chains[2:], np.zeros((0, 6)))
    with pytest.raises(ValueError, match=r"rates must have shape \(12, 10, \)"):
        compiled.kernels.support_hessian(
            *chains, np.zeros((12, 6)), np.zeros((11, 10)), np.zeros(12), np.zeros((2, 3))
        )


def test_walks_whose_feet_turn_are_copied_and_pickled():
    at = walk("upright, heel strike, toe off, everything free")
    values = at.problem.values(at.x)
    for again in (copy.deepcopy(at.problem), pickle.loads(pickle.dumps(at.problem))):
        found = again.values(at.x)
        assert found.cost == values.cost
        np.testing.assert_array_equal(found.rows, values.rows)
