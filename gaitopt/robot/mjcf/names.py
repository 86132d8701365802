"""Whether the names of an MJCF file tell bodies and joints apart, and are those that are meant."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element

from gaitopt.robot.files.xml_lines import XmlTree, where
from gaitopt.robot.mjcf.numbers import ACTUATORS
from gaitopt.robot.urdf.values import Entry

_FLAGS = ("true", "false")
_WORDS: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "compiler": {
        "angle": ("radian", "degree"),
        "autolimits": _FLAGS,
        "balanceinertia": _FLAGS,
        "inertiafromgeom": (*_FLAGS, "auto"),
    },
    "joint": {
        "type": ("hinge", "slide", "ball", "free"),
        "limited": (*_FLAGS, "auto"),
        "actuatorfrclimited": (*_FLAGS, "auto"),
    },
    "geom": {
        "type": (
            "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "plane", "hfield", "sdf",
        ),
    },
    **dict.fromkeys(
        ACTUATORS, dict.fromkeys(("ctrllimited", "forcelimited"), (*_FLAGS, "auto"))
    ),
}  # fmt: skip


def check_names(tree: XmlTree, robot: Element) -> None:
    """Refuse bodies or joints of one name, actuators of no joint, and words with no meaning.

    Args:
        tree: of a whole document.
        robot: its body that moves.

    Raises:
        RobotError: naming the line, the element, and what to do.
    """
    _check_words(tree)
    _check_differ(tree, robot, "body", ("body",))
    joints = _check_differ(tree, robot, "joint", ("joint", "freejoint"))
    for actuator in [e for section in tree.root.findall("actuator") for e in section]:
        name = actuator.get("joint")
        if name is not None and name not in joints:
            # Its torque limit would be lost.
            raise Entry(tree, actuator).refusal(
                f"there is no joint '{name}' in the robot; correct the name, or remove it"
            )


def _check_words(tree: XmlTree) -> None:
    for element in tree.root.iter():
        for attribute, words in _WORDS.get(element.tag, {}).items():
            word = element.get(attribute, words[0])
            if word not in words:
                allowed = " or ".join(f"'{word}'" for word in words)
                raise Entry(tree, element).refusal(
                    f"its {attribute} is '{word}'; it must be {allowed}; correct it"
                )


def _check_differ(tree: XmlTree, robot: Element, kind: str, tags: tuple[str, ...]) -> set[str]:
    """Return the names of the bodies or of the joints."""
    found: dict[str, Element] = {}
    for element in robot.iter():
        name = element.get("name") if element.tag in tags else None
        if name is not None and name in found:
            first = where(tree.line(found[name]), tree.file(found[name]))
            raise Entry(tree, element).refusal(
                f"another {kind} has this name ({first}); rename one of them"
            )
        if name is not None:
            found[name] = element
    return set(found)
