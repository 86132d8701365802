"""Inertias that stand in a URDF for want of better ones, or that no body of the link's size has."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from gaitopt.nlp import Array
from gaitopt.robot.urdf.description import Description, Link
from gaitopt.robot.urdf.values import UrdfProblem, printable

_FEWEST = 4  # links of one inertia
_MASSES = 3  # different masses among them: parts that are alike in both legs come in pairs
_MOST = 0.6  # of all links that have a mass
_POINT = 0.05  # of the robot's mass: lighter links may well be drawn as points
_MARGIN = 2.0  # of the largest inertia that fits: shapes leave out motors, and drawings fairings


def placeholder_problems(robot: Description) -> list[UrdfProblem]:
    """Return a problem for each inertia that many links share, and one for heavy links with none.

    Bodies of one inertia have one mass, or it is a coincidence; several masses are a program's
    default, and so is one inertia of most links.
    """
    heavy = [link for link in robot.links.values() if link.inertial is not None and link.mass > 0.0]
    groups: dict[bytes, list[Link]] = {}
    for link in heavy:
        assert link.inertial is not None  # as of all that are heavy
        groups.setdefault((link.inertial.inertia + 0.0).tobytes(), []).append(link)
    none = groups.pop(np.zeros((3, 3)).tobytes(), [])
    found = [
        _placeholder(links)
        for links in groups.values()
        if len(links) >= _FEWEST
        and (len({link.mass for link in links}) >= _MASSES or len(links) > _MOST * len(heavy))
    ]
    least = _POINT * sum(link.mass for link in heavy)
    return found + _points([link for link in none if link.mass > least])


def _points(links: list[Link]) -> list[UrdfProblem]:
    if not links:
        return []
    first = links[0]
    assert first.inertial is not None  # as of all that have a mass
    names = ", ".join(f"'{printable(link.name)}'" for link in links[1:4])
    text = f"it has a mass of {first.mass:.4g} kg but no inertia" + (
        f", nor have {names}{f' and {len(links) - 4} more' if len(links) > 4 else ''}"
        if names
        else ""
    )
    text += ": a point mass? Give the links their inertias"
    return [first.entry.problem("placeholder", text, first.inertial.element)]


def _placeholder(links: list[Link]) -> UrdfProblem:
    first = links[0]
    assert first.inertial is not None  # as of all in a group
    moments = np.diag(first.inertial.inertia)
    names = ", ".join(f"'{printable(link.name)}'" for link in links[1:4])
    more = f" and {len(links) - 4} more" if len(links) > 4 else ""
    light, heavy = (kind(link.mass for link in links) for kind in (min, max))
    masses = f"their masses go from {light:.4g} to {heavy:.4g} kg"
    if light == heavy:
        masses = "these are most of all links"
    text = (
        f"its inertia, {', '.join(f'{value:.4g}' for value in moments)} kg·m², is that of {names}"
        f"{more} too, though {masses}: a placeholder? "
        "Give the links their inertias"
    )
    return first.entry.problem("placeholder", text, first.inertial.element)


def radius_of_gyration(link: Link) -> float:
    """Return the largest about an axis through the centre of mass [m], 0 without mass."""
    if link.inertial is None or link.mass <= 0.0:
        return 0.0
    largest = float(np.linalg.eigvalsh(link.inertial.inertia)[2])
    return float(np.sqrt(max(largest, 0.0) / link.mass))


def oversized(robot: Description, diagonals: Mapping[str, float]) -> list[tuple[Link, float]]:
    """Return links whose inertia no mass within their shapes can have.

    Masses within a box are at most half its diagonal from its middle, so that the moment about
    their centre is at most mass times diagonal squared by four.

    Args:
        robot: links and joints.
        diagonals: of a box about the shapes of each link [m]; links without shapes are left out.

    Returns:
        The links, each with its inertia over the largest that fits.
    """
    found = []
    for name, diagonal in diagonals.items():
        if diagonal <= 0.0:
            continue
        ratio = (radius_of_gyration(robot.links[name]) / (diagonal / 2.0)) ** 2
        if ratio > _MARGIN:
            found.append((robot.links[name], ratio))
    return found


def size_of(robot: Description) -> float:
    """Return the diagonal of a box about all joints and centres of mass at angles of zero [m]."""
    places: list[Array] = []
    waiting = [(robot.root, np.zeros(3), np.eye(3))]
    below = robot.below
    while waiting:
        name, origin, rotation = waiting.pop()
        inertial = robot.links[name].inertial
        places.append(origin)
        if inertial is not None:
            places.append(origin + rotation @ np.array(inertial.pose.xyz))
        waiting += [
            (j.child, origin + rotation @ np.array(j.pose.xyz), rotation @ j.pose.rotation)
            for j in below[name]
        ]
    spread = np.ptp(np.array(places), axis=0)
    return float(np.linalg.norm(spread))
