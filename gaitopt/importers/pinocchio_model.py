"""Parts of Pinocchio models: joints, names of frames, and bodies that can be.

A link may bear the name of a joint, as URDF and MJCF allow. Pinocchio finds frames by name alone,
and refuses a name that two of them have. A link keeps its name, for soles are asked for by it; the
frame of the joint gets a mark while anything but Pinocchio's own reduction looks for frames.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pinocchio as pin

from gaitopt.bounds import SIZE
from gaitopt.errors import RobotError
from gaitopt.importers.report import fault_error
from gaitopt.importers.xml_document import FileProblem
from gaitopt.nlp import Array

_JOINT_MARK, _LINK_MARK = " (joint)", " (link)"
_AXIS_ROUNDING = 1e-15  # of an axis: cos(pi/2) = 6e-17 as programs write it
MOST_JOINTS = 300
"""Joints that move: Pinocchio's workspaces grow with their cube, 0.2 GB a piece for so many."""
_MASSLESS_SHARE = 1e-12  # of the largest inertia that a joint moves: what rounding leaves of none
_MOMENT_ROUNDING = 1e-6  # relative: what the digits of a drawing leave of a flat plate or rod
_POINT_MASS_GYRATION = 1e-9  # m²: below this times its mass, an inertia is rounding
_LEAST_MOMENT_SHARE = 1e-12  # relative: keeps a moment of zero above zero when the axes are turned


def joint_model(axis: Array, slides: bool) -> pin.JointModel:
    """Return the joint that turns about an axis of any length (3,), or slides along it."""
    axis = axis / np.abs(axis).max()  # its square may be too large or too small for a number
    for unit, name in zip(np.eye(3), "XYZ", strict=True):
        if np.abs(axis - unit).max() < _AXIS_ROUNDING:
            return getattr(pin, f"JointModel{'P' if slides else 'R'}{name}")()
    kind = pin.JointModelPrismaticUnaligned if slides else pin.JointModelRevoluteUnaligned
    return kind(axis / np.linalg.norm(axis))


def joint_motions(model: pin.Model) -> Array:
    """Return the motion of all joints but the first per rate, each in its own frame, shape (n, 6).

    Linear before angular, of joints of one degree of freedom.
    """
    data = model.createData()
    pin.computeJointJacobians(model, data, pin.neutral(model))
    columns = [
        pin.getJointJacobian(model, data, joint, pin.LOCAL)[:, model.joints[joint].idx_v]
        for joint in range(2, model.njoints)
    ]
    return np.array(columns).reshape(-1, 6)


def mark_joint_frames(model: pin.Model) -> pin.Model:
    """Mark, in a model just read, the frames of joints whose name a link has; return the model."""
    links = {frame.name for frame in model.frames if frame.type == pin.FrameType.BODY}
    for frame in model.frames:
        if frame.type != pin.FrameType.BODY and frame.name in links:
            frame.name += _JOINT_MARK
    return model


def reduced(model: pin.Model, locked: list[int], q: Array) -> pin.Model:
    """Return the model without the locked joints, which stand at q (nq,) [rad].

    Pinocchio looks for the frames of joints under the names of the joints, so that here it is the
    links that are marked.
    """
    named = model.copy()
    marked = {
        f.name.removesuffix(_JOINT_MARK) for f in named.frames if f.name.endswith(_JOINT_MARK)
    }
    for frame in named.frames:
        if frame.name in marked:
            frame.name += _LINK_MARK
        frame.name = frame.name.removesuffix(_JOINT_MARK)
    without = pin.buildReducedModel(named, locked, q)
    for frame in without.frames:
        if frame.name in marked:
            frame.name += _JOINT_MARK
        frame.name = frame.name.removesuffix(_LINK_MARK)
    return without


def inertia_fault(mass: float, inertia: Array) -> str:
    """Return why no body has a mass [kg] and an inertia (3, 3) about its centre [kg·m²], or "".

    A point mass (no inertia) and a frame (nothing at all) are limits of bodies, and pass.
    """
    a, b, c = (float(moment) for moment in np.linalg.eigvalsh(inertia))
    slack = _POINT_MASS_GYRATION * mass + _MOMENT_ROUNDING * abs(c)
    moments = f"its principal moments are {a:.4g}, {b:.4g}, {c:.4g} kg·m²"
    if mass == 0.0 and max(abs(a), abs(c)) > 0.0:
        return (
            f"the mass is 0 kg, but {moments}; the mass must be above 0 "
            "(leave <inertial> out of a link without mass)"
        )
    if a < -slack:
        return (
            f"the inertia is not positive definite: {moments}; all must be above 0; check the "
            "signs, and that it is taken about the centre of mass"
        )
    if c > a + b + slack:
        return (
            f"the inertia cannot belong to a body of positive mass: {moments}; the largest must "
            "not exceed the sum of the other two; check that it is taken about the centre of mass"
        )
    return ""


def rigid_body(mass: float, centre: Array, inertia: Array) -> pin.Inertia:
    """Return a body of mass [kg], centre (3,) [m] and inertia (3, 3) [kg·m²] as they are.

    A rod's least moment is zero, and below zero by rounding where it is turned, added up or seen in
    a mirror: Pinocchio's constructor stops there. What no body can have is refused as it is read
    (`refuse_unsound`).
    """
    body = pin.Inertia.Zero()
    body.mass, body.lever, body.inertia = mass, centre, inertia
    return body


def sound_inertia(mass: float, inertia: Array) -> Array:
    """Return an inertia (3, 3) [kg·m²] of a mass [kg], moments below 0 by rounding raised.

    Pinocchio makes no body of the least negative moment. An inertia at fault is returned as it is.
    """
    moments, axes = np.linalg.eigh(inertia)
    least = _LEAST_MOMENT_SHARE * float(moments[2])
    if moments[0] >= least or inertia_fault(mass, inertia):
        return inertia
    raised: Array = (axes * np.maximum(moments, least)) @ axes.T
    return (raised + raised.T) / 2.0


def refuse_unsound(model: pin.Model, problems: Iterable[FileProblem]) -> None:
    """Refuse a robot with a body that cannot be, or a joint that moves no mass.

    Raises:
        RobotError: naming the link if one is at fault, else the body or the joint.
    """
    problems, faults = tuple(problems), []
    for joint in range(1, model.njoints):
        inertia = model.inertias[joint]
        body = "the trunk" if joint == 1 else f"the body moved by joint '{model.names[joint]}'"
        moment = float(np.abs(inertia.inertia).max())
        if not max(inertia.mass, moment, *np.abs(inertia.lever)) < SIZE:
            faults.append(
                f"{body}: its mass is {inertia.mass:.4g} kg, its largest moment {moment:.4g} "
                f"kg·m²; numbers from {SIZE:g} on describe no robot; correct the "
                "masses (kg), inertias (kg·m²) and lengths (m) of the file"
            )
        elif fault := inertia_fault(float(inertia.mass), np.array(inertia.inertia)):
            links = {frame.name for frame in model.frames if frame.parentJoint == joint}
            known = [str(p) for p in problems if p.kind == "inertia" and p.name in links]
            faults += known or [f"{body}: {fault}"]
    if faults:
        raise fault_error(faults)
    _refuse_idle(model)


def _refuse_idle(model: pin.Model) -> None:
    """Refuse a joint that moves no mass: no torque is right for it, and nothing can be solved."""
    # All joints bent by different angles, lest a mass just happen to lie on an axis.
    q = np.array(pin.neutral(model))
    q[7:] = 0.2 + 0.1 * np.arange(model.nq - 7)
    moved = np.diag(pin.crba(model, model.createData(), q))[6:]
    idle = [
        str(model.names[2 + int(row)])
        for row in np.flatnonzero(moved <= _MASSLESS_SHARE * moved.max())
    ]
    if idle:
        more = f", and so on for {len(idle) - 3} more" if len(idle) > 3 else ""
        also = f" (the same holds for {', '.join(idle[1:3])}{more})" if idle[1:] else ""
        raise RobotError(
            f"joint '{idle[0]}' moves no mass: neither the link it moves nor any beyond has one "
            f"away from its axis{also}; give the links of the legs their <inertial>: "
            "mass (kg), centre of mass (m) and inertia (kg·m²), or the joint its armature (kg·m²)"
        )


def put_joint(joint: pin.JointModel, q: Array, value: float) -> None:
    """Write the coordinate of a joint [rad or m] into a configuration (nq,) of its model."""
    place = slice(joint.idx_q, joint.idx_q + joint.nq)
    q[place] = value if joint.nq == 1 else (np.cos(value), np.sin(value))


def joint_coordinate(joint: pin.JointModel, q: Array) -> float:
    """Return the coordinate of a joint [rad or m] at a configuration (nq,) of its model.

    Pinocchio has cosine and sine of one without limits.
    """
    value = q[joint.idx_q : joint.idx_q + joint.nq]
    return float(value[0]) if joint.nq == 1 else float(np.arctan2(value[1], value[0]))
