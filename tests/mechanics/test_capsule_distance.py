from xml.etree import ElementTree as ET

import coal
import numpy as np
import pinocchio as pin
import pytest
from motions import bent_posture, kinematics
from numerics import check_jacobian, relative_error
from places import CASES
from reference_cases import biped
from urdf_edits import edited_urdf, link

from gaitopt.mechanics.capsule_distance import CapsuleGaps, leg_pairs
from gaitopt.mechanics.forward_kinematics import ForwardKinematics
from gaitopt.model.robot import Robot

COUNT = 3


@pytest.fixture
def postures(robot, rng):
    return np.array([bent_posture(robot, rng) for _ in range(COUNT)])


@pytest.fixture(scope="module")
def pairs(robot):
    return leg_pairs(robot)


def gaps(robot, pairs, q):
    return CapsuleGaps(robot.tree, pairs).value(ForwardKinematics(robot.model).placed(q))


def derivatives(robot, pairs, q):
    axes = np.stack([kinematics(robot, angles).axes for angles in q])
    return CapsuleGaps(robot.tree, pairs).derivatives(
        ForwardKinematics(robot.model).placed(q), axes
    )


def coals_gap(robot, q, pair):
    """Distance of both capsules by coal, placed by Pinocchio."""
    at, parts = kinematics(robot, q), []
    for part in pair:
        ends = part.ends
        axis = ends[1] - ends[0]
        length, turn = np.linalg.norm(axis), np.eye(3)
        if length > 1e-9:
            up = np.array([0.0, 0.0, 1.0])
            turn = pin.Quaternion.FromTwoVectors(up, axis / length).matrix()
        placement = at.data.oMi[part.body + 1] * pin.SE3(turn, ends.mean(axis=0))
        parts += [
            coal.Capsule(part.radius, length),
            coal.Transform3s(placement.rotation, placement.translation),
        ]
    return coal.distance(*parts, coal.DistanceRequest(), coal.DistanceResult())


def test_gaps_are_coals(robot, pairs, postures):
    found = gaps(robot, pairs.kept, postures)
    for q, row in zip(postures, found, strict=True):
        expected = [coals_gap(robot, q, pair) for pair in pairs.kept]
        apart = row > 0.0  # where they overlap coal measures another thing
        assert apart.sum() > 20
        np.testing.assert_allclose(row[apart], np.array(expected)[apart], atol=1e-6)


def test_every_body_of_one_leg_meets_every_one_of_the_other(pairs):
    assert len(pairs.kept) + len(pairs.dropped) == 36
    assert "right_shin and left_shin" in pairs.names
    assert "right_foot and left_foot" in pairs.names
    assert all(a.body < 6 < b.body for a, b in pairs.kept)


def swell_hips(root):
    """A ball of 8 cm on the first link of each leg, 12 cm from the other one."""
    for side in ("left", "right"):
        ball = "<visual><geometry><sphere radius='0.08'/></geometry></visual>"
        link(root, f"{side}_hip_yaw_link").append(ET.fromstring(ball))


def test_bodies_that_cannot_part_are_left_out_and_named(pairs, postures):
    assert pairs.dropped == ()
    assert pairs.sentences == ()
    fat = Robot.from_urdf(edited_urdf(swell_hips))
    found = leg_pairs(fat)
    assert len(found.sentences) == 1
    assert "right_hip_yaw_link and left_hip_yaw_link" in found.sentences[0]
    assert "right_hip_yaw_link and left_hip_yaw_link" not in found.names
    assert "right_shin and left_shin" in found.names
    assert (gaps(fat, found.dropped, 0.0 * postures) < 0.0).all()


def hide_shins(root):
    for side in ("left", "right"):
        shin = link(root, f"{side}_shin")
        for visual in shin.findall("visual"):
            shin.remove(visual)


def test_bodies_without_a_shape_are_named():
    (said,) = leg_pairs(Robot.from_urdf(edited_urdf(hide_shins))).sentences
    assert said.startswith("taken as bars of 0.05 m radius between their joints")
    assert said.endswith(": right_shin, left_shin")


def test_slope(robot, pairs, postures):
    exact = derivatives(robot, pairs.kept, postures).jacobian
    check_jacobian(lambda d: gaps(robot, pairs.kept, postures + d), exact, np.zeros(12))


def test_joints_outside_a_pair_do_not_matter(robot, pairs, postures):
    """Both feet: all joints; both shins: not the ankles."""
    jacobian = derivatives(robot, pairs.kept, postures).jacobian
    feet = jacobian[:, pairs.names.index("right_foot and left_foot")]
    shins = jacobian[:, pairs.names.index("right_shin and left_shin")]
    assert np.abs(feet[:, [0, 11]]).max() > 1e-3
    assert np.abs(shins[:, [0, 1, 10, 11]]).max() == 0.0
    assert np.abs(shins[:, 2]).max() > 1e-3


def test_curvature(robot, pairs, postures, rng):
    """One pair at a time, away from where a nearest point reaches an end."""
    checked = 0
    for index in range(len(pairs.kept)):
        pair = pairs.kept[index : index + 1]
        share = np.stack(derivatives(robot, pair, postures).near.share, axis=1)
        inside = (share > 0.0) & (share < 1.0)
        near_an_end = inside & (np.minimum(share, 1.0 - share) < 0.02)
        weights = np.where(near_an_end.any(axis=1), 0.0, rng.uniform(0.5, 1.5, COUNT))[:, None]
        if not weights.any():
            continue
        H = derivatives(robot, pair, postures).hessian(weights)

        def gradient(d, pair=pair, weights=weights):
            return np.einsum("np,npj->nj", weights, derivatives(robot, pair, postures + d).jacobian)

        check_jacobian(gradient, H, np.zeros(12), step=1e-4)
        np.testing.assert_allclose(H, H.swapaxes(1, 2), atol=1e-12)
        checked += 1
    assert checked > 25


def test_the_legs_are_alike(robot, pairs, postures):
    """On the other foot and in the mirror every gap is that of the exchanged bodies."""
    left = biped("left")
    order = [robot.joint_names.index(n) for n in left.joint_names]
    there = leg_pairs(left)
    other = {"right": "left", "left": "right"}

    def exchanged(name):
        a, b = name.split(" and ")
        return " and ".join(other[n.split("_")[0]] + n[n.index("_") :] for n in (a, b))

    columns = [there.names.index(exchanged(name)) for name in pairs.names]
    found = gaps(left, there.kept, postures @ robot.mirror[order].T)[:, columns]
    assert relative_error(found, gaps(robot, pairs.kept, postures)) < 1e-9


def test_no_more_is_kept_than_the_standing_robot_has(pairs):
    asked = float(np.sort(pairs.standing)[[0, -1]].mean())
    kept = pairs.least(asked)
    assert kept.max() == asked
    least = pairs.standing - 1e-4
    np.testing.assert_array_equal(kept[kept < asked], least[least < asked])
    assert pairs.narrowed("leg_gap", "", 0.5 * float(pairs.standing.min())) == ""
    near = Robot.from_urdf(CASES / "hips_6mm_apart.urdf")
    found = leg_pairs(near)
    # Balls of 97 mm about hips that are 200 mm apart.
    assert found.standing.min() == pytest.approx(0.006, abs=1e-9)
    assert found.least(0.01).min() == pytest.approx(0.006 - found.hair, abs=1e-9)
    said = found.narrowed("leg_gap", "", 0.01)
    assert "has less when it stands; kept is what it has there: r1 and l1 6.0" in said
