"""What a description says about the physics beside its rigid bodies: passive joints and gravity."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import field, replace

from gaitopt.dataclass import dataclass

STANDARD_GRAVITY = 9.81
"""Acceleration of free fall where a description gives none [m/s²]."""

TIES = "ties"
"""That joints follow others, among `PARTS`."""

LOOPS = "loops"
"""That loops of bodies are closed, among `PARTS`."""

PARTS = (
    "friction", "damping", "springs", "armature", "gravity-compensation", "gravity", TIES, LOOPS,
)  # fmt: skip
"""Parts of a description's physics that can be left out, each by itself."""

GENERATED = "<!-- Made by gaitopt: links without rotors. -->"
"""Marks descriptions that gaitopt makes itself, of bipeds which have no rotors on purpose."""


@dataclass(frozen=True)
class PassiveJoint:
    """What a joint does by itself; its motor must deliver these on top of the rigid bodies' torque.

    Attributes:
        damping: torque per rate [N·m·s/rad], then per |rate| rate [N·m·s²/rad²], and so on, as far
            as the description goes: an odd function, as MuJoCo has it.
        friction: Coulomb friction [N·m], against the motion.
        stiffness: of a spring: torque per angle from `rest` [N·m/rad], then per its square
            [N·m/rad²] and so on: a plain polynomial, again as MuJoCo has it.
        rest: angle at which the spring gives no torque [rad].
    """

    damping: tuple[float, ...] = ()
    friction: float = 0.0
    stiffness: tuple[float, ...] = ()
    rest: float = 0.0

    @property
    def idle(self) -> bool:
        """Whether it does nothing."""
        return not (any(self.damping) or self.friction or any(self.stiffness))


@dataclass(frozen=True)
class LoopFrames:
    """Two frames of a model that are held together, so that a loop of bodies is closed.

    Attributes:
        first, second: their names.
        axes: whether their axes are held together too, not their origins alone.
    """

    first: str
    second: str
    axes: bool


@dataclass(frozen=True)
class PointMass:
    """The part of a link whose weight is carried from outside.

    Attributes:
        mass: factor of compensation times the mass of the link [kg].
        centre: centre of mass in the frame of the link [m].
    """

    mass: float
    centre: tuple[float, float, float]


@dataclass(frozen=True)
class Physics:
    """Passive joints, gravity and its compensation, as the description has them.

    Attributes:
        joints: by joint name; those that do nothing may be left out.
        gravity: along the axes of the root link with every joint coordinate at zero [m/s²]; None
            where the description gives none: then `STANDARD_GRAVITY` along the robot's down.
        compensated: weight that is carried from outside, by name of the link.
    """

    joints: Mapping[str, PassiveJoint] = field(default_factory=dict)
    gravity: tuple[float, float, float] | None = None
    compensated: Mapping[str, PointMass] = field(default_factory=dict)

    def without(self, parts: Collection[str]) -> Physics:
        """Return the physics that is left when some of `PARTS` are left out."""
        changes: dict[str, object] = {}
        if "friction" in parts:
            changes["friction"] = 0.0
        if "damping" in parts:
            changes["damping"] = ()
        if "springs" in parts:
            changes |= {"stiffness": (), "rest": 0.0}
        joints = {name: replace(joint, **changes) for name, joint in self.joints.items()}  # type: ignore[arg-type]
        return Physics(
            joints=joints,
            gravity=None if "gravity" in parts else self.gravity,
            compensated={} if "gravity-compensation" in parts else self.compensated,
        )


def is_generated(text: str) -> bool:
    """Return whether a description was made by gaitopt."""
    return GENERATED in text[:200]
