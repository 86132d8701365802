"""What a URDF says beside bodies, joints and shapes, and which inertias are too large, in words."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable

from gaitopt.robot.findings import Finding
from gaitopt.robot.physics import PassiveJoint
from gaitopt.robot.urdf.description import LIMITED, Description, Joint, limit_unit
from gaitopt.robot.urdf.doubts import oversized, radius_of_gyration, size_of
from gaitopt.robot.urdf.joints import range_of
from gaitopt.robot.urdf.rotors import Rotor
from gaitopt.robot.urdf.shapes import Kind

Measure = Callable[[Kind, Collection[str]], dict[str, float]]

_LOOKED_AT = 0.1  # of the robot's size: links that turn like smaller bodies are not measured
_COUNTS = 1e-5  # of mass times size squared of the robot: less inertia changes no walk
_SHOWN = 6  # names in one sentence
_ROUNDING = 1e-6  # rad: a soft limit this near to the hard one is the same


def passive_joints(robot: Description) -> dict[str, PassiveJoint]:
    """Return damping and friction of the joints that have any.

    Args:
        robot: links and joints.
    """
    return {
        name: PassiveJoint((joint.damping,) if joint.damping else (), joint.friction)
        for name, joint in robot.joints.items()
        if joint.damping or joint.friction
    }


def urdf_findings(
    robot: Description,
    rotors: Iterable[Rotor],
    measure: Measure,
) -> tuple[Finding, ...]:
    """Return what was found in a URDF beside what its model shows.

    Args:
        robot: links and joints.
        rotors: of its motors.
        measure: returns the diagonals of boxes about the shapes of a kind of some links [m].
    """
    return (*_rotors(rotors), *_soft_limits(robot), *_large_inertias(robot, measure))


def _rotors(rotors: Iterable[Rotor]) -> list[Finding]:
    groups: dict[tuple[float, float, bool], list[str]] = {}
    for rotor in rotors:
        groups.setdefault((rotor.inertia, rotor.reduction, rotor.given), []).append(rotor.joint)
    findings = []
    for (inertia, reduction, given), joints in groups.items():
        armature = inertia * reduction**2
        text = f"armature {armature:.4g} kg·m²: rotor inertia {inertia:.4g} kg·m² of the file"
        if given:
            text += f", times the reduction {reduction:g} squared" if reduction != 1.0 else ""
        else:
            text += "; it gives no reduction, which is taken as 1"
        findings.append(Finding("armature", _names(joints), text, "found" if given else "warning"))
    return findings


def _soft_limits(robot: Description) -> list[Finding]:
    tighter = [joint for joint in robot.joints.values() if _is_tighter(joint)]
    if not tighter:
        return []
    first = tighter[0]
    assert first.limits.soft is not None  # as of all that are tighter
    low, high = first.limits.soft
    lower, upper = range_of(first)
    unit = limit_unit(first.kind, "lower")
    text = (
        "safety_controller keeps them within narrower ranges, which are not imposed here "
        f"('{first.name}': {low:g} to {high:g} of {lower:g} to {upper:g} {unit}); "
        "give such a range to walk within it"
    )
    return [Finding("limits", _names([joint.name for joint in tighter]), text, "warning")]


def _is_tighter(joint: Joint) -> bool:
    if joint.kind not in LIMITED or joint.limits.soft is None:
        return False
    low, high = joint.limits.soft
    lower, upper = range_of(joint)
    return low < high and (low > lower + _ROUNDING or high < upper - _ROUNDING)


def _large_inertias(robot: Description, measure: Measure) -> list[Finding]:
    size, mass = size_of(robot), sum(link.mass for link in robot.links.values())
    turning = {
        name: radius_of_gyration(link)
        for name, link in robot.links.items()
        if link.mass * radius_of_gyration(link) ** 2 > _COUNTS * mass * size**2
    }
    suspects = [n for n, radius in turning.items() if size > 0.0 and radius > _LOOKED_AT * size]
    touched = measure("collision", suspects) if suspects else {}
    doubtful = {link.name for link, _ in oversized(robot, touched)}
    unseen = [name for name in suspects if name in doubtful or name not in touched]
    drawn = measure("visual", unseen) if unseen else {}
    measured = {
        name: max(touched.get(name, 0.0), drawn.get(name, 0.0))
        for name in suspects
        if name in doubtful or name in drawn
    }
    findings = []
    for link, ratio in sorted(oversized(robot, measured), key=lambda pair: -pair[1]):
        text = (
            f"its inertia is {ratio:.3g} times the largest that a body of {link.mass:.4g} kg "
            f"within its shapes, {measured[link.name]:.3g} m across, can have; check its unit "
            "(kg·m²), and that it is taken about the centre of mass"
        )
        findings.append(Finding("inertia", link.name, text, "warning"))
    for name in unseen:
        if name not in measured and turning[name] > size / 2.0:
            text = (
                f"its inertia is that of a body which reaches {turning[name]:.3g} m from its "
                f"centre of mass, but the robot is {size:.3g} m across; check its unit (kg·m²)"
            )
            findings.append(Finding("inertia", name, text, "warning"))
    return _few(findings)


def _few(findings: list[Finding]) -> list[Finding]:
    """Return the findings, of many only the first, which then speaks for all."""
    if len(findings) < 3:
        return findings
    first = findings[0]
    names = _names([finding.subject for finding in findings])
    text = f"'{first.subject}': {first.text}; the same or the like holds for the others"
    return [Finding(first.topic, names, text, first.how)]


def _names(names: list[str]) -> str:
    shown = ", ".join(names[:_SHOWN])
    return shown + (f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else "")
