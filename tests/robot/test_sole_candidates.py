"""Feet that are no rectangles: other rectangles are shown, and each can be chosen."""

import re
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from urdf_edits import edited_urdf, joint, link

from gaitopt.model.robot import Robot
from gaitopt.model.sole import Sole
from gaitopt.model.sole_detection import largest_rectangle

DROP = 0.105  # m from the ankle to the sole


def standing_on(points):
    """The biped on studs under both feet, mirrored, without sole frames in the file."""

    def edit(root):
        for side, sign in (("right", 1.0), ("left", -1.0)):
            root.remove(link(root, f"{side}_sole"))
            root.remove(joint(root, f"{side}_sole_joint"))
            foot = link(root, f"{side}_foot")
            for tag in ("visual", "collision"):
                for shape in foot.findall(tag):
                    foot.remove(shape)
            for x, y in points:
                foot.append(
                    ET.fromstring(
                        f"<collision><origin xyz='{x} {sign * y} {-DROP + 0.005}'/>"
                        "<geometry><sphere radius='0.005'/></geometry></collision>"
                    )
                )

    return edited_urdf(edit)


def shown(robot):
    """The share of the flat part that is told, and the rectangles that are."""
    for finding in robot.findings:
        found = re.search(r"the rectangle holds (\d+)% of the flat part", finding.text)
        if found:
            edges = re.findall(r"([-\d.e]+(?:,[-\d.e]+){3}) \((.*?)\)", finding.text)
            soles = {n: Sole(*(float(v) for v in e.split(","))) for e, n in edges}
            return int(found[1]), soles
    return 100, {}


def foot(rng):
    """A foot between a rectangle and an ellipse."""
    angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, 24))
    power = rng.uniform(0.1, 1.0)
    c, s = np.cos(angles), np.sin(angles)
    return np.column_stack(
        [
            rng.uniform(0.08, 0.13) * np.sign(c) * np.abs(c) ** power + 0.02,
            rng.uniform(0.03, 0.05) * np.sign(s) * np.abs(s) ** power,
        ]
    )


@pytest.mark.parametrize("seed", range(10))
def test_other_rectangles_are_shown_where_the_largest_leaves_out_a_tenth(seed):
    points = foot(np.random.default_rng(seed)).round(4)
    robot = Robot.from_urdf(standing_on(points))
    toe, heel, left, right = largest_rectangle(points)
    share = (toe - heel) * (left - right) / ConvexHull(points).volume
    told, soles = shown(robot)
    if share >= 0.9:
        assert (told, soles) == (100, {})
        return
    assert told == round(100 * share)
    long = np.ptp(points[:, 0])
    for name, sole in soles.items():
        if "length" in name:
            assert sole.toe - sole.heel >= 0.9 * long - 2e-4
        if "all of it" in name:
            assert sole.toe - sole.heel == pytest.approx(long, abs=2e-4)
    assert any("all of it" in name for name in soles)


def test_each_that_is_shown_can_be_chosen():
    text = standing_on(foot(np.random.default_rng(3)).round(4))
    robot = Robot.from_urdf(text)
    told, soles = shown(robot)
    assert told < 90
    assert len(soles) >= 2
    for sole in soles.values():
        chosen = Robot.from_urdf(text, sole=sole)
        assert chosen.sole == sole
        assert shown(chosen) == (100, {})
        assert chosen.legs.height == pytest.approx(robot.legs.height, abs=1e-9)


def test_the_largest_rectangle_of_a_length():
    diamond = np.array([[0.1, 0.0], [-0.1, 0.0], [0.0, 0.05], [0.0, -0.05]])
    toe, heel, left, right = largest_rectangle(diamond, (0.15, 0.0))
    assert (toe - heel, left - right) == pytest.approx((0.15, 0.025), rel=2e-2)
    toe, heel, left, right = largest_rectangle(diamond, (0.0, 0.08))
    assert (toe - heel, left - right) == pytest.approx((0.04, 0.08), rel=5e-2)


@pytest.mark.parametrize("degrees", [2, 10, 17, 30, 45, 60, 80])
def test_feet_turned_out_are_read_whatever_does_not_fit_into_them(degrees):
    """In a box turned far enough, no rectangle along the foot is nearly as wide as the whole."""
    turned = np.exp(1j * np.radians(-degrees))
    corners = turned * np.array([0.12 + 0.04j, 0.12 - 0.04j, -0.08 + 0.04j, -0.08 - 0.04j])
    points = np.column_stack([corners.real, corners.imag]).round(4)
    robot = Robot.from_urdf(standing_on(points))
    edges = largest_rectangle(points)
    assert robot.sole.length == pytest.approx(edges[0] - edges[1], abs=1e-6)
    _, soles = shown(robot)
    assert all(sole.width * sole.length > 0.0 for sole in soles.values())
    wide = largest_rectangle(points, (0.0, 0.9 * float(np.ptp(points[:, 1]))))
    if wide[0] == wide[1]:
        assert not any("width" in name for name in soles)


def test_round_feet_are_not_said_to_be_wider_than_long():
    angles = np.arange(16) * np.pi / 8
    points = 0.08 * np.column_stack([np.cos(angles), np.sin(angles)]) + (0.03, 0.0)
    robot = Robot.from_urdf(standing_on(points))
    assert robot.sole.length == pytest.approx(robot.sole.width)
    assert not [f for f in robot.findings if "wider than" in f.text]
