"""Bipeds with joints that follow others: NAO's two hip yaws on one motor, linkages, and bends."""

import functools
from xml.etree import ElementTree as ET

from mjcf_edits import added, at, edited, together
from mjcf_text import mjcf_text
from synthetic_bipeds import ARM, SEVEN, SOLE, biped_urdf
from urdf_edits import joint

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.importers.reader import read_source
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.robot import Robot

NAO_LEG = (("hip_yaw_pitch", (0.0, 0.05, -0.085), (0.0, 1.0, -1.0), 0.07), *SEVEN[1:4], *SEVEN[5:])
"""Six joints whose first is at 45 degrees between yaw and pitch; the right one's axis is turned
round, as in NAO's own file, so that both hips turn by the same angle."""


def mimic(root: ET.Element, name: str, master: str, **numbers: float) -> None:
    """Make a joint follow another."""
    more = {key: repr(value) for key, value in numbers.items()}
    ET.SubElement(joint(root, name), "mimic", {"joint": master, **more})


def nao_like(multiplier: float = 1.0, **numbers: float) -> str:
    """A URDF of a biped with NAO's coupling: both hip yaw-pitches are one motor."""
    root = ET.fromstring(biped_urdf(NAO_LEG))
    axis = joint(root, "right_hip_yaw_pitch").find("axis")
    axis.set("xyz", " ".join(repr(-float(n)) for n in axis.get("xyz").split()))
    mimic(root, "right_hip_yaw_pitch", "left_hip_yaw_pitch", multiplier=multiplier, **numbers)
    return ET.tostring(root, encoding="unicode")


def linked() -> str:
    """A URDF whose arms' elbows and shank twists follow a shoulder and the ankle of their side."""
    root = ET.fromstring(biped_urdf(SEVEN, ARM, "yaw"))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        mimic(root, f"{side}_elbow", f"{side}_shoulder_pitch", multiplier=1.5, offset=-0.3 * sign)
        mimic(root, f"{side}_shank_twist", f"{side}_ankle_roll", multiplier=0.25)
    return ET.tostring(root, encoding="unicode")


FOOT = 'type="box" size="0.1 0.05 0.01" pos="0.03 0 -0.06"'
FOOT_OF_SEVEN = 'type="box" size="0.11 0.055 0.01" pos="0.04 0 -0.06"'
TWIST = (0.02, 0.4, 0.12, -0.1, 0.1)
"""Of the left shank's twist in the ankle's roll; on the right the even powers change sign."""
ELBOW = (-0.3, 1.2, 0.25, -0.1, 0.02)
"""Of the left elbow in the pitch of its shoulder, likewise."""


@functools.cache
def plain_mjcf() -> str:
    """The biped in MJCF."""
    return mjcf_text(read_source(urdf_text(biped13())).model(), foot_geom=FOOT)


def equality(joint: str, master: str, coefficients: tuple[float, ...]) -> str:
    """A tie of two joints in MJCF."""
    words = " ".join(map(repr, coefficients))
    return f"<joint joint1='{joint}' joint2='{master}' polycoef='{words}'/>"


@functools.cache
def bent() -> str:
    """The biped of `linked` in MJCF, its elbows and shank twists tied by fourth powers."""
    plain = mjcf_text(read_source(biped_urdf(SEVEN, ARM, "yaw")).model(), foot_geom=FOOT_OF_SEVEN)
    parts = []
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for follower, master, left in (
            ("shank_twist", "ankle_roll", TWIST),
            ("elbow", "shoulder_pitch", ELBOW),
        ):
            seen = tuple(c * sign ** (k + 1) for k, c in enumerate(left))
            parts.append(equality(f"{side}_{follower}", f"{side}_{master}", seen))
    ranges = (
        at(f".//joint[@name='{side}_{name}']", range="-0.6 0.6")
        for side in ("left", "right")
        for name in ("ankle_roll", "shoulder_pitch")
    )
    return edited(plain, together(added(".", f"<equality>{''.join(parts)}</equality>"), *ranges))


def read(urdf: str, moving: tuple[str, ...] = (), **choices: object) -> Robot:
    """The robot of a text."""
    return Robot.from_urdf(
        urdf,
        stance_sole="right_sole",
        swing_sole="left_sole",
        sole=SOLE,
        moving=moving,
        choices=ImportOptions(**choices),
    )


_MAKERS = {
    "NAO's hips": lambda: read(nao_like()),
    "elbows and shanks": lambda: read(linked(), ("arms", "waist")),
    "bent elbows and shanks": lambda: Robot.from_urdf(bent(), moving=("arms", "waist")),
}
TIED = tuple(_MAKERS)


@functools.cache
def tied(name: str) -> Robot:
    """One of `TIED`."""
    return _MAKERS[name]()
