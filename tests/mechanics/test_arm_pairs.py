"""Arms that must keep clear of trunk, thighs, loads and each other."""

import functools
from dataclasses import replace
from xml.etree import ElementTree as ET

import coal
import numpy as np
import pinocchio as pin
import pytest
from humanoids import add_arms, edits
from numerics import check_jacobian, relative_error
from urdf_edits import edited_urdf, link

from gaitopt.gait.step import ReducedDerivatives
from gaitopt.mechanics.capsule_distance import CapsuleGaps, arm_pairs, narrowed_gaps, pair_name
from gaitopt.mechanics.forward_kinematics import ForwardKinematics
from gaitopt.mechanics.inverse_kinematics import LegKinematics
from gaitopt.model.capsules import arm_bodies, arm_capsules, capsule_rows
from gaitopt.model.coupling import Coupling
from gaitopt.model.import_options import (
    ImportOptions,
    Payload,
    choices_from_record,
    choices_record,
)
from gaitopt.model.robot import Robot

COUNT = 4


def give_hands(root):
    """A torso 0.3 m wide as it can be touched, a bar as upper arm and a box as a hand."""
    shapes = {
        "torso": ("0 0 0.25", "<box size='0.2 0.3 0.5'/>"),
        "left_arm_2": ("0 0 -0.1", "<capsule radius='0.04' length='0.2'/>"),
        "right_arm_2": ("0 0 -0.1", "<capsule radius='0.04' length='0.2'/>"),
        "left_arm_3": ("0 0.01 -0.1", "<box size='0.05 0.03 0.2'/>"),
        "right_arm_3": ("0 -0.01 -0.1", "<box size='0.05 0.03 0.2'/>"),
    }
    for name, (at, shape) in shapes.items():
        text = f"<collision><origin xyz='{at}'/><geometry>{shape}</geometry></collision>"
        link(root, name).append(ET.fromstring(text))


@functools.cache
def armed(side="right", **choices):
    return Robot.from_urdf(
        edited_urdf(edits(add_arms(4, step=-0.22), give_hands)),
        choices=ImportOptions(moving=("*arm_joint*",), stance=side, **choices),
    )


def postures(robot, rng):
    q = rng.uniform(-0.6, 0.6, (COUNT, robot.tree.size))
    q[:, list(robot.legs.knees)] += 0.6
    return q


def derivatives(robot, pairs, q):
    model, data, axes = robot.model, robot.model.createData(), []
    for angles in q:
        full = pin.neutral(model)
        full[7:] = angles
        axes.append(pin.computeJointJacobians(model, data, full)[:, 6:].T.copy())
    placed = ForwardKinematics(model).placed(q)
    return CapsuleGaps(robot.tree, pairs).derivatives(placed, np.array(axes))


def coals_gap(robot, q, pair):
    data, full, parts = robot.model.createData(), pin.neutral(robot.model), []
    full[7:] = q
    pin.forwardKinematics(robot.model, data, full)
    for part in pair:
        axis = part.ends[1] - part.ends[0]
        length, turn = np.linalg.norm(axis), np.eye(3)
        if length > 1e-9:
            turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axis / length).matrix()
        at = data.oMi[part.body + 1] * pin.SE3(turn, part.ends.mean(axis=0))
        parts += [
            coal.Capsule(part.radius, length),
            coal.Transform3s(at.rotation, at.translation),
        ]
    return coal.distance(*parts, coal.DistanceRequest(), coal.DistanceResult())


def test_arms_meet_trunk_thighs_and_each_other():
    robot = armed()
    names = arm_pairs(robot).names
    assert {robot.tree.names[body - 1] for body in arm_bodies(robot)} == {
        f"{side}_arm_joint_{k}" for side in ("left", "right") for k in range(4)
    }
    assert "left_arm_3 and right_arm_3" in names
    for other in ("torso", "right_thigh", "left_thigh"):
        for side in ("left", "right"):
            touching = [n for n in names if n.startswith(other) and n.endswith(f"{side}_arm_3")]
            assert touching, (other, side)
    assert not any("shin" in name or "foot" in name for name in names)
    for body in arm_bodies(robot):
        assert not any(
            pair[0].body in arm_bodies(robot)
            and arm_bodies(robot)[pair[0].body] == arm_bodies(robot)[pair[1].body]
            for pair in arm_pairs(robot).kept
            if body == pair[1].body
        )


def test_shoulders_are_no_part_of_it(rng):
    """No posture takes them away from the trunk."""
    robot, capsules = armed(), {c.name: c for c in arm_capsules(armed())}
    names = arm_pairs(robot).names
    trunk = [name for name in capsules if name.startswith("torso")]
    beside = [n for n in trunk if f"{n} and left_arm_0" not in names]
    assert beside
    pairs = tuple((capsules[name], capsules["left_arm_0"]) for name in beside)
    q = rng.uniform(robot.limits.lower, robot.limits.upper, (300, robot.tree.size))
    gaps = CapsuleGaps(robot.tree, pairs).value(ForwardKinematics(robot.model).placed(q))
    assert gaps.max() < 2.0 * capsules["left_arm_0"].radius


def test_gaps_are_coals(rng):
    robot, found = armed(), arm_pairs(armed())
    q = postures(robot, rng)
    gaps = CapsuleGaps(robot.tree, found.kept).value(ForwardKinematics(robot.model).placed(q))
    assert (gaps > 0.0).sum() > 100
    for angles, row in zip(q, gaps, strict=True):
        for gap, pair in zip(row, found.kept, strict=True):
            if gap > 0.0:  # where they overlap coal measures another thing
                assert gap == pytest.approx(coals_gap(robot, angles, pair), abs=1e-6)


@pytest.mark.parametrize("tied", [False, True])
def test_what_is_asked_for_is_part_of_the_whole(rng, tied):
    robot, n = armed(), armed().tree.size
    found = derivatives(robot, arm_pairs(robot).kept, postures(robot, rng))
    if tied:  # the last joint follows the one before, by a curve
        free, n = np.arange(n - 1), n - 1
        ties = np.tile([0.0, 1.0, 0.0], (n + 1, 1))
        ties[-1] = 0.1, 0.5, 0.3
        coupling = Coupling(robot.tree.names, free, np.append(free, n - 1), ties, np.eye(n + 1))
        found = ReducedDerivatives(found, coupling.at(rng.normal(size=(COUNT, n))))
    whole = found.jacobian
    assert whole.shape[2] == n
    instants = np.sort(rng.integers(COUNT, size=30))
    entries = rng.integers(whole.shape[1], size=30)
    np.testing.assert_allclose(found.rows(instants, entries), whole[instants, entries], atol=1e-14)
    rates = rng.normal(size=(COUNT, n))
    moved = np.einsum("npj,nj->np", whole, rates)
    np.testing.assert_allclose(found.along(rates), moved, atol=1e-13)
    most = np.einsum("npj,nj->np", np.abs(whole), np.abs(rates))
    assert (found.most(np.abs(rates)) >= most * (1.0 - 1e-12)).all()
    weights = rng.normal(size=moved.shape) * (rng.random(moved.shape) < 0.1)
    gradient = np.einsum("np,npj->nj", weights, whole)
    np.testing.assert_allclose(found.vjp(weights), gradient, atol=1e-13)


def test_slope(rng):
    robot, pairs = armed(), arm_pairs(armed()).kept
    q = postures(robot, rng)
    check_jacobian(
        lambda d: derivatives(robot, pairs, q + d).value,
        derivatives(robot, pairs, q).jacobian,
        np.zeros(robot.tree.size),
    )


def test_curvature(rng):
    """Pairs with joints on both branches too: of a thigh and an arm, of both arms."""
    robot = armed()
    q, checked = postures(robot, rng), set()
    pairs = [p for p in arm_pairs(robot).kept if p[1].name.endswith(("arm_2", "arm_3"))]
    for pair in pairs:
        share = np.stack(derivatives(robot, (pair,), q).near.share, axis=1)
        inside = (share > 0.0) & (share < 1.0)
        weights = rng.uniform(0.5, 1.5, COUNT)
        weights[(inside & (np.minimum(share, 1.0 - share) < 0.02)).any(axis=1)] = 0.0
        if not weights.any():
            continue

        def gradient(d, pair=pair, weights=weights):
            jacobian = derivatives(robot, (pair,), q + d).jacobian
            return np.einsum("n,npj->nj", weights, jacobian)

        H = derivatives(robot, (pair,), q).hessian(weights[:, None])
        check_jacobian(gradient, H, np.zeros(robot.tree.size), step=1e-4)
        checked.add((pair[0].name.split(" (")[0], pair[1].name))
    assert {
        ("left_arm_3", "right_arm_3"), ("torso", "left_arm_3"), ("torso", "right_arm_3"),
        ("right_thigh", "left_arm_3"), ("left_thigh", "left_arm_3"),
    } <= checked  # fmt: skip


def test_both_sides_are_alike(rng):
    """In the mirror every gap is that of the exchanged bodies, whatever the shapes' own axes."""
    robot = armed()
    capsules = {c.name: c for c in arm_capsules(robot)}
    for name, one in capsules.items():
        if name.startswith("left_arm"):
            other = capsules["right" + name[len("left") :]]
            assert one.radius == other.radius
            flipped = other.ends * [1.0, -1.0, 1.0]
            np.testing.assert_allclose(one.ends, flipped, atol=1e-12)
    arms = [p for p in arm_pairs(robot).kept if p[0].body in arm_bodies(robot)]
    q = postures(robot, rng)
    there = CapsuleGaps(robot.tree, tuple(arms)).value(ForwardKinematics(robot.model).placed(q))
    image = ForwardKinematics(robot.model).placed(q @ robot.mirror.T)
    mirrored = CapsuleGaps(robot.tree, tuple(arms)).value(image)
    swap = {"left": "right", "right": "left"}
    order = [
        [pair_name(p) for p in arms].index(
            " and ".join(swap[n.split("_")[0]] + n[n.index("_") :] for n in (b.name, a.name))
        )
        for a, b in arms
    ]
    assert relative_error(mirrored[:, order], there) < 1e-9


def test_capsules_cover_all_of_a_shape(rng):
    """Points of a torso's box, which several capsules cover, nearer to its face than one would."""
    robot = armed()
    own = [c for c in arm_capsules(robot) if c.name.startswith("torso")]
    frame = robot.model.frames[robot.model.getFrameId("torso")].placement
    points = rng.uniform(-0.5, 0.5, (500, 3)) * [0.2, 0.3, 0.5] + [0.0, 0.0, 0.25]
    points = points @ np.array(frame.rotation).T + frame.translation
    share = np.linspace(0.0, 1.0, 200)[:, None]
    distances = [
        np.linalg.norm(
            points[:, None] - ((1.0 - share) * c.ends[0] + share * c.ends[1])[None], axis=2
        ).min(axis=1)
        - c.radius
        for c in own
    ]
    assert len(own) > 1
    assert np.min(distances, axis=0).max() < 1e-4
    assert max(c.radius for c in own) < np.hypot(0.1, 0.15)  # of the cylinder around the box


def test_loads_are_among_what_arms_avoid():
    load = Payload("torso", 4.0, (-0.2, 0.0, 0.3), (0.1, 0.4, 0.3))
    names = arm_pairs(armed(payloads=(load,))).names
    assert any("the load" in name and "left_arm_3" in name for name in names)
    assert not any("the load" in name for name in arm_pairs(armed()).names)


def test_arms_stand_in_the_robots_posture():
    raised = (("left_arm_joint_1", 0.3), ("right_arm_joint_1", -0.2))
    robot = armed(posture=raised)
    legs = LegKinematics(robot)
    q = dict(zip(robot.joint_names, legs.solve(*legs.flat_feet(0.0, 0.2)), strict=True))
    assert [q[name] for name, _ in raised] == [angle for _, angle in raised]
    assert q["left_arm_joint_0"] == 0.0
    there, usual = (arm_pairs(one) for one in (robot, armed()))
    assert there.names == usual.names
    assert np.abs(there.standing - usual.standing).max() > 0.05


def test_no_arms_no_pairs(robot):
    assert arm_capsules(robot) == ()
    assert arm_pairs(robot).kept == ()
    assert narrowed_gaps(robot, None, 0.01) == ()


def test_less_is_kept_where_arms_hang_nearer():
    """By no more than a hair less than standing has, overlaps too; and it is said."""
    found = arm_pairs(armed())
    widest = float(found.standing.max())
    np.testing.assert_allclose(found.least(widest + 1.0), found.standing - 1e-4, atol=1e-4)
    deeper = replace(found, standing=found.standing - 0.5)
    assert (deeper.least(0.01)[deeper.standing < 0.0] < deeper.standing[deeper.standing < 0]).all()
    (said,) = narrowed_gaps(armed(), None, widest)
    assert said.startswith("arm_gap asks for ")
    assert " mm around the arms, but the robot has less when it stands" in said


def test_capsules_are_the_same_from_their_record():
    robot = armed()
    chosen = robot.choices.over(arm_capsules=capsule_rows(arm_capsules(robot)), package_dirs=())
    again = Robot.from_urdf(robot.urdf, choices=choices_from_record(choices_record(chosen)))
    assert arm_capsules(again) == arm_capsules(robot)
    assert arm_pairs(again).names == arm_pairs(robot).names
