"""A biped as gaitopt sees it: one chain rooted at the stance sole, and facts about it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Iterable
from dataclasses import replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TypeVar, cast

import numpy as np
import pinocchio as pin

from gaitopt.bounds import fixed
from gaitopt.dataclass import dataclass, made_anew
from gaitopt.importers.reader import read_source
from gaitopt.importers.report import Finding, as_before
from gaitopt.importers.source import Source
from gaitopt.model.chain import build_chain, size_doubts
from gaitopt.model.chain_physics import ChainPhysics
from gaitopt.model.coupling import Coupling, couple
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.importer import ImportedRobot, import_robot
from gaitopt.model.joint_limits import JointLimits
from gaitopt.model.joint_tree import JointTree, joint_tree
from gaitopt.model.leg_geometry import Legs, knee_doubts, measure_legs
from gaitopt.model.linkage import Linkage
from gaitopt.model.multibody import Multibody, multibody, protect
from gaitopt.model.reference_posture import posture_doubts
from gaitopt.model.scales import Scales
from gaitopt.model.sole import LEVEL, Sole
from gaitopt.nlp import Array
from gaitopt.settings import checked_arguments, checked_facts


@checked_facts
@dataclass(frozen=True, eq=False)
class Robot:
    """A biped with the right or left foot standing.

    Attributes:
        name: of the robot.
        urdf: text of its URDF.
        model: free-flyer at the stance sole (held still), then the stance leg from ankle to hip,
            the swing leg from hip to ankle, and other branches that move. Never modified.
        joint_names: URDF names of the m joints in that order that follow no other; signs are the
            URDF's. Without ties these are all n of `model`.
        mirror: the leg exchange E, shape (m, m).
        stance_sole, swing_sole: names of the sole frames.
        sole: the rectangle of either sole.
        limits: of the m joints, tied ones reflected to that which they follow.
        legs: hip and ankle centres, knees, reach.
        pelvis: name of the pelvis frame.
        physics: passive joints and carried weight, beside the rigid bodies; gravity, as `model` has
            it too.
        choices: every guess made explicit: with them, the text alone gives the same robot, without
            any mesh.
        findings: what was found, guessed and changed, for a person.
        multibody: the same robot on a floating base, with every joint of the file, as arrays.
        coupling: how all joints of `model` follow from those of `joint_names`.
        linkages: motors that turn joints of the right leg through loops of bodies of its file.
        down: direction of gravity in the axes of its soles, of unit length; see `on_ground`.
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
    pelvis: str
    physics: ChainPhysics
    choices: ImportOptions
    findings: tuple[Finding, ...]
    multibody: Multibody
    coupling: Coupling
    linkages: tuple[Linkage, ...] = ()
    down: tuple[float, float, float] = LEVEL

    def __post_init__(self) -> None:
        protect(self)

    __reduce__ = made_anew

    @classmethod
    @checked_arguments
    def from_urdf(
        cls,
        urdf: str | Path,
        *,
        choices: ImportOptions | None = None,
        stance_sole: str | None = None,
        swing_sole: str | None = None,
        sole: Sole | None = None,
        moving: Collection[str] = (),
    ) -> Robot:
        """Read a biped from a URDF or MJCF file, or its text; find out what is not fixed.

        Args:
            urdf: the text itself, or the path of a file.
            choices: what to take instead of what would be found; the other arguments go before it.
            stance_sole, swing_sole: names of the sole frames (x forward, y left, z up, in the
                plane of the sole).
            sole: rectangle of the sole.
            moving: joints beside the legs' that are not locked.

        Raises:
            RobotError: the URDF cannot be read, or is not a biped with two mirrored legs.
        """
        given = choices or ImportOptions()
        given = given.over(
            stance_sole=stance_sole, swing_sole=swing_sole, sole=sole, moving=tuple(moving) or None
        )
        source = read_source(urdf, given.package_dirs)
        return cls.from_reading(source, import_robot(source, given))

    @classmethod
    def from_reading(cls, source: Source, reading: ImportedRobot) -> Robot:
        """Return the biped of a reading.

        Raises:
            RobotError: a body of the file is unsound, the robot is not its own mirror image, or
                its sole is larger than its legs.
        """
        chain = build_chain(reading)
        names = [str(reading.model.names[j]) for j in reading.joints]
        limits = reading.limits.ordered([names.index(name) for name in chain.names])
        coupling = couple(chain.names, reading.ties, chain.mirror)
        legs = measure_legs(chain.lines, reading.sole_names, limits)
        doubts = (
            *knee_doubts(legs, limits, chain.names),
            *size_doubts(chain, legs.reach, reading.soles.sole, float(legs.ankles[:, 2].mean())),
        )
        moved = (*reading.legs, *reading.others)
        stands = posture_doubts(reading.model, reading.q, moved, reading.choices)
        odd = (Finding("file", f"line {p.line}", p.text, "warning") for p in reading.problems)
        return cls(
            name=chain.model.name,
            urdf=source.text,
            model=chain.model,
            joint_names=coupling.free_names,
            mirror=coupling.exchange(),
            stance_sole=reading.sole_names[0],
            swing_sole=reading.sole_names[1],
            sole=reading.soles.sole,
            limits=coupling.limits(limits),
            legs=legs,
            pelvis=chain.pelvis,
            physics=chain.physics,
            choices=reading.choices.over(package_dirs=source.mesh_directories()),
            findings=(*reading.findings, *chain.findings, *stands, *doubts, *odd),
            multibody=multibody(
                reading.model, reading.q, chain, coupling, reading.sole_names, reading.soles.sole
            ),
            coupling=coupling,
            linkages=reading.linkages,
        )

    def __repr__(self) -> str:
        """Return it in one line: the whole of it is pages long."""
        return (
            f"<Robot {self.name!r}: {fixed(self.mass, 2)} kg, legs {fixed(self.legs.reach, 3)} m, "
            f"stands on {self.stance_sole!r}>"
        )

    def as_before(self, findings: Iterable[Finding]) -> Robot:
        """Return the robot with its findings as an earlier reading has them, see `as_before`."""
        return replace(self, findings=as_before(self.findings, findings))

    @cached_property
    def mass(self) -> float:
        """Total mass [kg]."""
        return float(pin.computeTotalMass(self.model))

    @cached_property
    def weight(self) -> float:
        """Weight that the ground carries [N]: without what is carried from outside."""
        carried = self.physics.carried
        mass = self.mass - (0.0 if carried is None else float(carried.mass.sum()))
        return mass * float(np.linalg.norm(self.model.gravity.linear))

    @cached_property
    def scales(self) -> Scales:
        """Its lengths, forces and times over those of the thirteen-link biped."""
        gravity = float(np.linalg.norm(self.model.gravity.linear))
        return Scales.of_robot(self.legs.reach, self.weight, gravity)

    def on_ground(self, down: tuple[float, float, float]) -> Robot:
        """Return the robot on ground where gravity is turned in the axes of its soles.

        Args:
            down: direction of gravity there, of unit length; from the level, whatever the ground of
                this robot is.
        """
        return self if down == self.down else _on_ground(self, down)

    @cached_property
    def tree(self) -> JointTree:
        """The joints: which of them are in which leg, and what each of them moves."""
        frames = (self.model.frames[frame] for frame in (self.pelvis_frame, self.swing_frame))
        return joint_tree(self.model, *(int(frame.parentJoint) for frame in frames))

    @cached_property
    def pelvis_frame(self) -> int:
        """Index of the pelvis frame: x forward, y left, z up, origin midway between the hips."""
        return int(self.model.getFrameId(self.pelvis))

    @cached_property
    def swing_frame(self) -> int:
        """Index of the swing sole frame."""
        return int(self.model.getFrameId(self.swing_sole))


@lru_cache(maxsize=8)  # so that the walks of a robot share what is made of it once
def _on_ground(robot: Robot, down: tuple[float, float, float]) -> Robot:
    gravity = float(np.linalg.norm(robot.physics.gravity)) * np.array(down)
    model = pin.Model(robot.model)
    model.gravity = pin.Motion(gravity, np.zeros(3))
    return replace(
        robot,
        model=model,
        physics=replace(robot.physics, gravity=gravity),
        multibody=replace(robot.multibody, gravity=gravity),
        down=down,
    )


_ROBOTS = 8  # in as many threads, of which things are kept

T = TypeVar("T")


def cached_workspace(robot: Robot, make: Callable[[Robot], T]) -> T:
    """Return what a function makes of a robot, the same object at every call of a thread.

    Making one of Pinocchio's workspaces takes as long as forty evaluations of the torques in it,
    and the solution of one walk takes a dozen grids. What is kept here is scratch: results are
    copied out of it before anyone else works there. Ask for it where you use it.
    """
    made = _made(robot, threading.get_ident())
    if make not in made:
        made[make] = make(robot)
    return cast(T, made[make])


@lru_cache(maxsize=_ROBOTS)
def _made(robot: Robot, thread: int) -> dict[Callable[[Robot], object], object]:
    del robot, thread  # by which it is kept
    return {}
