"""Walks on slopes and stairs, judged by laws that know no walk."""

import json
from dataclasses import dataclass, replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from numerics import relative_error
from places import CASES
from synthetic_bipeds import MOVING, SOLE, synthetic

from gaitopt.cli.request import make_request
from gaitopt.design.audit import audit
from gaitopt.design.certificate import ask_referee, on_fine_grid
from gaitopt.design.conflict import contradictions
from gaitopt.design.design import design
from gaitopt.errors import InputError
from gaitopt.gait import quantities
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.parameters import set_geometry
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import ground_of
from gaitopt.gait.terrain import Profile, Slope, Stairs, Terrain, ground_record
from gaitopt.importers.physics import PassiveJoint, Physics
from gaitopt.importers.reader import read_source
from gaitopt.mechanics.forward_kinematics import ForwardKinematics, Trunk
from gaitopt.mechanics.spatial import upright
from gaitopt.model.import_options import ImportOptions, Payload
from gaitopt.model.importer import import_robot
from gaitopt.model.robot import Robot
from gaitopt.model.sole import Sole
from gaitopt.sweep.grid import parse_axis
from gaitopt.tolerances import MOMENTUM, REFEREE

SLOPES = (0.1, -0.17)
STAIRS = (0.12, -0.1)
GROUNDS = (*({"slope": angle} for angle in SLOPES), *({"stairs": rise} for rise in STAIRS))
LOAD = Payload("torso", 6.0, (0.05, 0.0, 0.2), (0.2, 0.3, 0.2))


def damped():
    """The small biped with linear damping in every joint, and a load."""
    source = read_source(CASES / "base_mini.urdf")
    joints = {str(n): PassiveJoint((1.5,)) for n in source.model().names[2:]}
    source.__dict__["physics"] = Physics(joints, (0.0, 0.0, -9.7), {})
    return Robot.from_reading(source, import_robot(source, ImportOptions()))


def loaded(robot):
    return Robot.from_urdf(robot.urdf, choices=ImportOptions(payloads=(LOAD,)))


def proven(robot, **ground):
    """A walk at its first guess, seen at the instants of the proof."""
    task = preset_task("standard", speed=0.5, duration=0.6, **ground)
    problem = WalkProblem(robot, task)
    problem = on_fine_grid(problem)
    return problem, problem.step(first_guess(problem))


@pytest.mark.parametrize("slope", SLOPES)
def test_a_slope_is_the_level_with_gravity_turned(robot, slope):
    """The same motion, once told the slope, once on level ground with another gravity."""
    problem = WalkProblem(robot, preset_task("standard", speed=0.8, slope=slope))
    x = first_guess(problem)
    model = pin.Model(robot.model)
    model.gravity = pin.Motion(9.81 * np.array([-np.sin(slope), 0.0, -np.cos(slope)]), np.zeros(3))
    turned = WalkProblem(replace(robot, model=model), preset_task("standard", speed=0.8))
    own, other = problem.step(x), turned.step(x)
    for name in (quantities.TORQUE, quantities.WRENCH):
        assert relative_error(own.read(name), other.read(name)) < 1e-12
    assert np.array_equal(own.impact.impulse, other.impact.impulse)


@pytest.mark.parametrize("ground", GROUNDS, ids=str)
@pytest.mark.parametrize("make", [loaded, lambda _: damped()], ids=["loaded", "damped"])
def test_the_motors_raise_the_weight_and_pay_for_what_is_lost(robot, make, ground):
    """Work of the motors over a step = m g h + loss of the impact + losses of the joints."""
    problem, step = proven(make(robot), **ground)
    robot, (q, dq, _) = problem.robot, step.motion
    weights = step.duration * problem.grid.weights
    work = weights @ (step.read(quantities.TORQUE) * dq).sum(axis=1)
    passive = robot.physics.passive
    lost = 0.0 if passive is None else weights @ (dq**2 @ passive.damping[:, 0])
    data, end = robot.model.createData(), np.concatenate([pin.neutral(robot.model)[:7], step.q_end])
    M = pin.crba(robot.model, data, end)[6:, 6:]
    before = step.rate_before @ M @ step.rate_before / 2.0
    start = np.concatenate([pin.neutral(robot.model)[:7], q[0]])
    M = pin.crba(robot.model, data, start)[6:, 6:]
    after = dq[0] @ M @ dq[0] / 2.0  # the next step begins like this one
    task = problem.task
    raised = robot.weight * (step.step_length * np.sin(task.slope) + task.stairs)
    assert min(before - after, abs(raised)) > 0.1
    assert abs(work - (raised + before - after + lost)) < 1e-9 * abs(raised)


@pytest.mark.parametrize("ground", GROUNDS, ids=str)
@pytest.mark.parametrize("make", [loaded, lambda _: damped()], ids=["loaded", "damped"])
def test_newton_and_euler_agree(robot, make, ground):
    problem, step = proven(make(robot), **ground)
    verdict = ask_referee(problem.robot, step, problem.grid)
    assert 0.0 < verdict.worst < REFEREE
    assert 0.0 < verdict.momentum < MOMENTUM
    other = ask_referee(problem.robot.on_ground(Slope(0.01).down), step, problem.grid)
    assert other.torque > REFEREE  # a referee on other ground objects


@pytest.mark.parametrize(
    "ground", [*GROUNDS, *({"slope": angle, "toe_off": 0.7} for angle in SLOPES)], ids=str
)
def test_mujoco_asks_for_the_same(robot, ground):
    """MuJoCo's inverse dynamics: what it asks for at the base is the ground's wrench."""
    agrees_with_mujoco(loaded(robot), ground)


@pytest.mark.parametrize("ground", GROUNDS, ids=str)
def test_mujoco_asks_for_the_same_of_arms_and_a_waist_with_a_load(ground):
    bare = synthetic("seven, waist and arms")
    load = replace(LOAD, place=(0.05, 0.01, 0.2))
    choices = ImportOptions(
        payloads=(load,), moving=("waist", *MOVING), stance_sole="right_sole",
        swing_sole="left_sole", sole=SOLE, asymmetry=0.1,
    )  # fmt: skip
    robot = Robot.from_urdf(bare.urdf, choices=choices)
    assert robot.mass == pytest.approx(bare.mass + LOAD.mass)
    assert robot.tree.size > 2 * 7
    agrees_with_mujoco(robot, {**ground, "boundary": "lifted"})


def agrees_with_mujoco(robot, ground):
    task = preset_task("standard", speed=0.5, duration=0.6, **ground)
    problem = WalkProblem(robot, task)
    gait = gait_at(problem, perturbed(problem, first_guess(problem), 0.05, 4), {})
    body = gait.trajectory.body
    model = mujoco.MjModel.from_xml_string(mjcf(body))
    at = mujoco.MjData(model)
    # the last one in the turn of the stance foot, where there is one
    samples = gait.trajectory.at(np.array([0.1, 0.45, 0.8]) * gait.duration)
    for row in range(3):
        base = pin.XYZQUATToSE3(samples.configuration[row, :7])
        x, y, z, w = samples.base_quaternion[row]
        at.qpos[:] = [*samples.base_position[row], w, x, y, z, *samples.q[row]]
        twist, acceleration = samples.base_twist[row], samples.base_acceleration[row]
        v, omega = twist[:3], twist[3:]
        linear = base.rotation @ (acceleration[:3] + np.cross(omega, v))
        at.qvel[:] = [*(base.rotation @ v), *omega, *samples.dq[row]]
        at.qacc[:] = [*linear, *acceleration[3:], *samples.ddq[row]]
        mujoco.mj_inverse(model, at)
        moved = samples.sole[row, 0]
        wrench = samples.wrench[row, 0]
        force = moved[:3, :3] @ wrench[:3]
        size = np.abs(at.qfrc_inverse).max()
        assert at.qfrc_inverse[:3] == pytest.approx(force, abs=1e-9 * size)
        about = moved[:3, :3] @ wrench[3:] + np.cross(moved[:3, 3] - base.translation, force)
        assert base.rotation @ at.qfrc_inverse[3:6] == pytest.approx(about, abs=1e-9 * size)
        jacobian = np.zeros((6, model.nv))
        mujoco.mj_jac(
            model, at, jacobian[:3], jacobian[3:], moved[:3, 3], 1 + body.sole_joint[0] + 1
        )
        on_sole = np.concatenate([force, moved[:3, :3] @ wrench[3:]])
        torque = at.qfrc_inverse[6:] - (jacobian.T @ on_sole)[6:]
        assert torque == pytest.approx(samples.torque[row], abs=1e-9 * size)


def mjcf(body):
    """A robot's arrays as MJCF, gravity included; its joints are in the order of the arrays."""
    children = {
        row: [k for k, p in enumerate(body.parent) if p == row]
        for row in range(-1, len(body.parent))
    }

    def quaternion(matrix):
        x, y, z, w = pin.Quaternion(matrix).coeffs()
        return f"{w!r} {x!r} {y!r} {z!r}".replace("np.float64(", "").replace(")", "")

    def numbers(values):
        return " ".join(repr(float(v)) for v in np.ravel(values))

    def inertial(row):
        i = body.inertia[row]
        full = numbers([i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]])
        return (
            f"<inertial pos='{numbers(body.centre[row])}' mass='{float(body.mass[row])!r}' "
            f"fullinertia='{full}'/>"
        )

    def link(row):
        place = body.placement[row]
        inside = "".join(link(child) for child in children[row])
        return (
            f"<body pos='{numbers(place[:3, 3])}' quat='{quaternion(place[:3, :3])}'>"
            f"{inertial(row + 1)}<joint axis='{numbers(body.axis[row])}' "
            f"armature='{float(body.armature[row])!r}'/>{inside}</body>"
        )

    return (
        f"<mujoco><option gravity='{numbers(body.gravity)}'/>"
        "<compiler angle='radian' balanceinertia='false'/>"
        f"<worldbody><body>{inertial(0)}<freejoint/>{''.join(map(link, children[-1]))}</body>"
        "</worldbody></mujoco>"
    )


def test_the_trunk_leans_against_the_vertical(robot):
    """On a slope the same posture leans by the slope's angle less, seen from the vertical."""
    problem, step = proven(robot, slope=0.1)
    kinematics = [Trunk(one) for one in (problem.robot, robot)]
    placed = ForwardKinematics(robot.model).placed(step.motion[0])
    own, level = (trunk.value(placed)[:, 1] for trunk in kinematics)
    assert own == pytest.approx(level - 0.1, abs=5e-3)  # exact without roll and yaw


@pytest.fixture(scope="module")
def uphill(robot):
    return design(robot, preset_task("standard", speed=0.8, slope=0.1))


def test_a_walk_uphill_is_certified_and_checked_again(uphill, tmp_path):
    gait = load_gait(save_gait(uphill.gait, tmp_path / "uphill.npz"))
    assert uphill.certificate.certified
    assert audit(gait).passed
    bare = replace(gait, multibody=None)  # the robot is read again, and turned
    assert np.array_equal(bare.trajectory.body.gravity, gait.trajectory.body.gravity)


def test_steps_along_the_slope_rise(uphill):
    trajectory = uphill.gait.trajectory
    lifted = upright(trajectory.body.gravity)
    samples = trajectory.at(np.array([0.0, 2.0 * trajectory.step_duration]))
    way = lifted @ (samples.base_position[1] - samples.base_position[0])
    length = 2.0 * uphill.gait.step_length
    assert way == pytest.approx([length * np.cos(0.1), 0.0, length * np.sin(0.1)], abs=1e-9)
    assert lifted @ trajectory.body.gravity == pytest.approx([0.0, 0.0, -9.81], abs=1e-12)
    assert ground_of(uphill.gait).words == "uphill, 10 % (5.73°)"


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"slope": 1.2}, "must be between -1 and 1 rad"),
        ({"slope": np.nan}, "slope is nan rad"),
        ({"slope": "10%"}, "slope is '10%' rad"),
    ],
)
def test_no_slope_is_told(changes, reason):
    with pytest.raises(InputError, match=reason):
        preset_task("standard", **changes)


def test_feet_that_turn_out_are_refused_on_a_slope():
    task = preset_task("standard")
    geometry = set_geometry(task.geometry, {"foot_yaw": {"value": 0.1}})
    with pytest.raises(InputError, match="on a slope the feet point ahead"):
        replace(task, slope=0.1, geometry=geometry)


def actual_height(x, rise, tread, edge):
    """Height of stairs with sharp edges [m]; at an edge the higher of both treads."""
    number = np.floor((x - edge) / tread) + 1.0
    return np.maximum(rise * number, rise * np.where((x - edge) % tread == 0.0, number - 1, number))


@pytest.mark.parametrize("rise", STAIRS)
@pytest.mark.parametrize("nosing", [None, 0.03])
def test_the_height_that_is_kept_is_never_below_the_stairs(robot, rise, nosing):
    stairs = Stairs(rise).profile(robot.sole, 0.3, nosing)
    x = np.linspace(-0.6, 0.55, 4001)
    value = stairs.height(x)[0]
    actual = actual_height(x, rise, 0.3, stairs.edge)
    assert (value >= actual - 1e-12).all()
    standing = np.linspace(robot.sole.heel, robot.sole.toe, 50)
    for number in (-1, 0, 1):  # feet stand on level treads
        assert stairs.height(standing + 0.3 * number)[0] == pytest.approx(rise * number, abs=1e-12)


@pytest.mark.parametrize("rise", STAIRS)
def test_derivatives_of_the_height(robot, rise):
    stairs = Stairs(rise).profile(robot.sole, 0.32, 0.05)
    x = np.linspace(-0.35, 0.35, 23) + 1e-3
    step = 1e-6
    (low, slope_low, _), (high, slope_high, _) = (stairs.height(x + d) for d in (-step, step))
    _, slope, curvature = stairs.height(x)
    assert slope == pytest.approx((high - low) / (2 * step), abs=1e-6)
    assert curvature == pytest.approx((slope_high - slope_low) / (2 * step), abs=1e-4)
    assert np.abs(curvature).max() > 1.0


@pytest.fixture(scope="module")
def upstairs(robot):
    return design(robot, preset_task("standard", speed=0.5, duration=0.7, stairs=0.17))


def test_a_walk_upstairs_is_certified_and_checked_again(upstairs, tmp_path):
    gait = load_gait(save_gait(upstairs.gait, tmp_path / "upstairs.npz"))
    assert upstairs.certificate.certified
    assert audit(gait).passed
    assert ground_of(gait).words == "upstairs, 170 mm for 350 mm"


def test_steps_upstairs_rise_by_that_of_the_stairs(upstairs):
    trajectory = upstairs.gait.trajectory
    at = trajectory.at(np.arange(5) * trajectory.step_duration)
    feet = at.sole[np.arange(5), at.contact.argmax(axis=1)]
    assert np.diff(feet[:, :3, 3], axis=0)[:, [0, 2]] == pytest.approx(
        np.tile([0.35, 0.17], (4, 1)), abs=1e-9
    )
    assert np.diff(at.base_position[::2, 2]) == pytest.approx(0.34, abs=1e-9)


def test_the_whole_swing_sole_stays_above_the_stairs(upstairs, robot):
    """Against stairs with sharp edges, at instants and points that nothing was held at."""
    gait, task = upstairs.gait, upstairs.problem.task
    edge = ground_of(gait).outline[-1, 0]
    assert edge == Stairs(0.17).profile(robot.sole, task.step_length, None).edge
    samples = gait.trajectory.at(np.linspace(0.01, 0.99, 301) * gait.duration)
    sole = samples.sole[:, 1]
    share = np.linspace(robot.sole.heel, robot.sole.toe, 120)
    for side in (robot.sole.left, robot.sole.right):
        along = np.stack([share, np.full(120, side), np.zeros(120)])
        points = sole[:, :3, :3] @ along + sole[:, :3, 3:]
        ground = actual_height(points[:, 0], 0.17, 0.35, edge)
        assert (points[:, 2] - ground).min() > -1.1e-3  # points between corners give a millimetre
    assert task.margins.clearance == 0.03


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"stairs": 0.8}, "must be between -0.5 and 0.5 m"),
        ({"stairs": np.nan}, "stairs is nan m"),
        ({"stairs": 0.1, "slope": 0.1}, "a walk has one ground: give a slope or stairs"),
        ({"stairs": 0.1, "toe_off": 0.7}, "give toe_off or stairs, not both"),
        ({"stairs": 0.1, "speed_as": "penalty"}, "fix the duration, and take the speed"),
    ],
)
def test_no_stairs_are_told(changes, reason):
    with pytest.raises(InputError, match=reason):
        preset_task("standard", **changes)


def test_small_soles_stand_on_small_treads():
    """Stairs of a tenth of the size are refused where those of the whole size are."""
    sole = Sole(toe=0.14, heel=-0.08, left=0.05, right=-0.05)
    small = Sole(*(0.1 * edge for edge in (sole.toe, sole.heel, sole.left, sole.right)))
    treads = Stairs(0.1).profile(sole, 0.25, None), Stairs(0.01).profile(small, 0.025, None)
    assert (treads[1].begin, treads[1].length) == pytest.approx(
        (0.1 * treads[0].begin, 0.1 * treads[0].length)
    )
    for rise, one, step in ((0.1, sole, 0.235), (0.01, small, 0.0235)):
        with pytest.raises(InputError, match="too short for a sole"):
            Stairs(rise).profile(one, step, None)


def test_treads_shorter_than_the_sole_are_refused(robot):
    task = preset_task("standard", speed=0.5, duration=0.4, stairs=0.1)
    with pytest.raises(InputError, match=r"too short for a sole of 0.214 m .* at least 0.234 m"):
        WalkProblem(robot, task)


@pytest.mark.parametrize(
    ("text", "angle"),
    [
        ("10%", np.arctan(0.1)),
        ("-10 %", -np.arctan(0.1)),
        ("6deg", np.pi / 30.0),
        ("-0.1", -0.1),
        ("0.1 rad", 0.1),
    ],
)
def test_slopes_are_read_as_people_write_them(text, angle, tmp_path):
    config = tmp_path / "walk.toml"
    config.write_text(f'[task]\nslope = "{text}"\n[robot]\npayload = ["2kg@torso"]\n')
    request = make_request({}, config)
    assert request.task.slope == pytest.approx(angle, rel=1e-15)
    assert request.robot.choices.payloads[0].mass == 2.0
    assert parse_axis("slope", text).values == pytest.approx((angle,), abs=1e-10)


def test_a_slope_steeper_than_friction_holds_is_told(robot):
    task = preset_task("standard", speed=0.5, slope=-0.3, friction=0.3)
    ((constraint, said),) = contradictions(WalkProblem(robot, task))
    assert constraint == "friction"
    assert said.startswith("a slope of 30.9 % asks for a coefficient of friction of at least 0.309")
    enough = replace(task, margins=replace(task.margins, friction=0.31))
    assert contradictions(WalkProblem(robot, enough)) == ()


@dataclass(frozen=True)
class Odd(Terrain):
    """A ground that says anything."""

    name = "odd"
    gravity: object = (0.0, 0.0, -1.0)
    said: object = "odd ground"
    shape: object = None

    @property
    def shaped(self):
        return self.shape is not None

    def words(self, step):
        return told(self.said)

    @property
    def down(self):
        return told(self.gravity)

    def profile(self, sole, step, nosing):
        return told(self.shape)


def told(value):
    if isinstance(value, Exception):
        raise value
    return value


class Broken(Profile):
    """A ground whose height cannot be computed."""

    length = 0.1

    def height(self, x):
        return 1 / 0


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (
            {"gravity": (0.0, 0.0, -2.0)},
            r"gravity points along \(0.0, 0.0, -2.0\); give a tuple of",
        ),
        ({"gravity": (0.0, 0.0, 1.0)}, "of unit length, no farther than 1 rad from"),
        ({"gravity": (0.0, 0.0, np.nan)}, "gravity points along"),
        ({"gravity": (0.0, -1.0)}, "gravity points along"),
        ({"gravity": np.array([0.0, 0.0, -1.0])}, "gravity points along array"),
        ({"gravity": "down"}, "gravity points along 'down'"),
        ({"gravity": ZeroDivisionError("no")}, "the terrain 'odd': ZeroDivisionError: no"),
        ({"said": ZeroDivisionError("no")}, "the terrain 'odd': ZeroDivisionError: no"),
        ({"shape": ZeroDivisionError("no")}, "the terrain 'odd': ZeroDivisionError: no"),
        ({"shape": Broken()}, "the terrain 'odd': ZeroDivisionError: division by zero"),
        ({"said": 3}, "the words of the terrain 'odd' are 3; give a text"),
    ],
)
def test_a_ground_that_is_none_is_refused(robot, values, said):
    with pytest.raises(InputError, match=said):
        WalkProblem(robot, preset_task(terrain=Odd(**values)))


def test_a_ground_of_ones_own_is_a_slope_where_gravity_points_so(robot):
    own = {"terrain": Odd((-float(np.sin(0.1)), 0.0, -float(np.cos(0.1))))}, {"slope": 0.1}
    walks = [WalkProblem(robot, preset_task(**ground)) for ground in own]
    costs = [walk.values(first_guess(walk)).cost for walk in walks]
    assert costs[0] == pytest.approx(costs[1], rel=1e-12)


class Hills(Profile):
    """Flat hills between the footprints, as a sum that is rounded by the shape of x."""

    length = 0.1
    heights = 1e-4 * np.arange(1.0, 10.0) / 9.0

    def height(self, x):
        d = (x[..., None] % 0.4 - np.linspace(0.09, 0.11, 9)) / 0.02
        v = np.maximum(1.0 - d**2, 0.0)
        parts = v**4, -8.0 * d * v**3 / 0.02, (48.0 * d**2 * v**2 - 8.0 * v**3) / 0.02**2
        return tuple(part @ self.heights for part in parts)


def test_a_ground_whose_height_is_a_sum_is_taken(robot):
    """Its sums of arrays of two shapes differ in the last digit."""
    WalkProblem(robot, preset_task(terrain=Odd(shape=Hills())))


def test_a_ground_in_single_precision_is_recorded(robot):
    ground = Odd(gravity=(np.float32(0.0), np.float32(0.0), np.float32(-1.0)))
    assert json.loads(json.dumps(ground_record(ground, robot.sole, 0.4, None)))["down"][2] == -1.0
