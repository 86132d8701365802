"""A biped as gaitopt sees it: one chain rooted at the stance sole, and facts about it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.nlp import Array
from gaitopt.robot.legs import HIP_JOINTS, Legs, common_point, find_knee
from gaitopt.robot.limits import JointLimits, joint_limits
from gaitopt.robot.reroot import PELVIS_FRAME, lock_upper_body, reroot
from gaitopt.robot.soles import Sole, sole_from_collision
from gaitopt.robot.symmetry import exchange_error, joint_lines, leg_exchange
from gaitopt.robot.urdf_check import check_urdf

_SYMMETRY_TOLERANCE = 1e-6  # relative: a half step and its mirror must be the same motion


@dataclass(frozen=True, eq=False)
class Robot:
    """A biped with the right or left foot standing.

    Attributes:
        name: of the robot.
        urdf: text of its URDF.
        model: free-flyer at the stance sole (held still), then the stance leg from ankle to hip
            and the swing leg from hip to ankle. Never modified.
        joint_names: URDF names of the twelve joints in that order; signs are the URDF's.
        mirror: the leg exchange E, shape (12, 12).
        stance_sole, swing_sole: names of the sole frames.
        sole: the rectangle of either sole.
        limits: of the joints.
        legs: hip and ankle centres, knees, reach.
    """

    name: str
    urdf: str
    model: pin.Model
    joint_names: tuple[str, ...]
    mirror: Array
    stance_sole: str
    swing_sole: str
    sole: Sole
    limits: JointLimits
    legs: Legs

    @classmethod
    def from_urdf(
        cls,
        urdf: str | Path,
        *,
        stance_sole: str = "right_sole",
        swing_sole: str = "left_sole",
        sole: Sole | None = None,
    ) -> Robot:
        """Read a biped from URDF text or from a URDF file.

        Args:
            urdf: the text itself, or the path of a file.
            stance_sole, swing_sole: names of the sole frames (x forward, y left, z up, in the
                plane of the sole).
            sole: rectangle of the sole; by default the lower face of the foot's collision box.

        Raises:
            RobotError: the URDF cannot be read, or is not a biped with two mirrored six-joint legs.
        """
        text = _urdf_text(urdf)
        whole = _parse(text)
        reduced = lock_upper_body(whole, stance_sole, swing_sole)
        if sole is None:
            geometry = pin.buildGeomFromUrdfString(whole, text, pin.GeometryType.COLLISION)
            sole = sole_from_collision(whole, geometry, stance_sole)
        model = reroot(reduced, stance_sole, swing_sole)
        names = tuple(model.names[2:])
        pelvis, points, axes = _place_pelvis(model, whole)
        outward = np.repeat([-1.0, 1.0], 6)
        mirror = leg_exchange(names, points, axes, outward)
        _check_symmetry(model, mirror, stance_sole, swing_sole)
        return cls(
            name=model.name,
            urdf=text,
            model=model,
            joint_names=names,
            mirror=mirror,
            stance_sole=stance_sole,
            swing_sole=swing_sole,
            sole=sole,
            limits=joint_limits(model, names, mirror),
            legs=_legs(model, pelvis, points, axes, (stance_sole, swing_sole)),
        )

    @cached_property
    def mass(self) -> float:
        """Total mass [kg]."""
        return float(pin.computeTotalMass(self.model))

    @cached_property
    def pelvis_frame(self) -> int:
        """Index of the pelvis frame: axes of the root link, origin midway between the hips."""
        return int(self.model.getFrameId(PELVIS_FRAME))

    @cached_property
    def swing_frame(self) -> int:
        """Index of the swing sole frame."""
        return int(self.model.getFrameId(self.swing_sole))


def _urdf_text(urdf: str | Path) -> str:
    if isinstance(urdf, str) and urdf.lstrip().startswith("<"):
        return urdf
    path = Path(urdf)
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise RobotError(f"cannot read the URDF '{path}': {_reason(error)}") from error


def _reason(error: OSError | UnicodeDecodeError) -> str:
    if isinstance(error, UnicodeDecodeError):
        return "it is not UTF-8 text"
    return (error.strerror or str(error)).lower()


def _parse(text: str) -> pin.Model:
    check_urdf(text)
    try:
        return pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    except (ValueError, RuntimeError, IndexError) as error:
        raise RobotError(f"the URDF cannot be read: {error}") from error


def _place_pelvis(model: pin.Model, whole: pin.Model) -> tuple[pin.SE3, Array, Array]:
    """Add the pelvis frame midway between the hips; return it with the joint lines in it."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    root_name = next(
        f.name for f in whole.frames if f.type == pin.FrameType.BODY and f.name != "universe"
    )
    root = data.oMf[model.getFrameId(root_name)]
    points, axes = joint_lines(model, root)
    hips = [common_point(points[list(rows)], axes[list(rows)]) for rows in HIP_JOINTS]
    middle = (hips[0] + hips[1]) / 2.0
    pelvis = root * pin.SE3(np.eye(3), middle)
    frame = model.frames[model.getFrameId(root_name)]
    if model.existFrame(PELVIS_FRAME) and root_name != PELVIS_FRAME:
        raise RobotError(f"the URDF already has a frame '{PELVIS_FRAME}' that is not its root link")
    placement = frame.placement * pin.SE3(np.eye(3), middle)
    model.addFrame(
        pin.Frame(PELVIS_FRAME, frame.parentJoint, placement, pin.FrameType.OP_FRAME), False
    )
    return pelvis, points - middle, axes


def _check_symmetry(model: pin.Model, mirror: Array, stance_sole: str, swing_sole: str) -> None:
    error = exchange_error(model, mirror, stance_sole, swing_sole)
    if error > _SYMMETRY_TOLERANCE:
        raise RobotError(
            f"the robot differs from its mirror image by {error:.3g} (relative, placement of the "
            f"feet and kinetic energy); allowed is {_SYMMETRY_TOLERANCE:g}. Make the two legs and "
            "the trunk symmetric in the URDF"
        )


def _legs(
    model: pin.Model, pelvis: pin.SE3, points: Array, axes: Array, soles: tuple[str, str]
) -> Legs:
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    pelvis_joint = model.frames[model.getFrameId(PELVIS_FRAME)].parentJoint
    hips, ankles, knees = [], [], []
    for rows, hip_rows, ankle_rows, sole in zip(
        (range(6), range(6, 12)), HIP_JOINTS, ((0, 1), (10, 11)), soles, strict=True
    ):
        hip = common_point(points[list(hip_rows)], axes[list(hip_rows)])
        ankle = pelvis.act(common_point(points[list(ankle_rows)], axes[list(ankle_rows)]))
        hips.append(hip)
        frame = model.getFrameId(sole)
        ankles.append(data.oMf[frame].actInv(ankle))
        foot = model.frames[frame].parentJoint
        knees.append(
            find_knee(
                model,
                rows,
                (pelvis_joint, data.oMi[pelvis_joint].actInv(pelvis.act(hip))),
                (foot, data.oMi[foot].actInv(ankle)),
            )
        )
    straight = np.array([k[1] for k in knees])
    index = [k[0] for k in knees]
    span = np.array(model.upperPositionLimit[7:] + model.lowerPositionLimit[7:])[index]
    return Legs(
        hips=np.array(hips),
        ankles=np.array(ankles),
        knees=(index[0], index[1]),
        straight=straight,
        flexion=np.where(span >= 2.0 * straight, 1.0, -1.0),
        reach=max(k[2] for k in knees),
    )
