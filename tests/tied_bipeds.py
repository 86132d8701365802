"""Bipeds with joints that follow others: NAO's two hip yaws on one motor, and linkages."""

import functools
from xml.etree import ElementTree as ET

from synthetic_bipeds import ARM, SEVEN, SOLE, biped_urdf
from urdf_edits import joint

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
}
TIED = tuple(_MAKERS)


@functools.cache
def tied(name: str) -> Robot:
    """One of `TIED`."""
    return _MAKERS[name]()
