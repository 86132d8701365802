"""Small edits of a URDF's text, to make robots that are wrong in one known way."""

from collections.abc import Callable
from xml.etree import ElementTree as ET

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.urdf_writer import urdf_text


def edited_urdf(edit: Callable[[ET.Element], None]) -> str:
    """The biped's URDF after `edit` has changed its tree."""
    root = ET.fromstring(urdf_text(biped13()))
    edit(root)
    return ET.tostring(root, encoding="unicode")


def joint(root: ET.Element, name: str) -> ET.Element:
    """A joint by its name."""
    return _named(root, "joint", name)


def link(root: ET.Element, name: str) -> ET.Element:
    """A link by its name."""
    return _named(root, "link", name)


def set_limit(name: str, **values: float) -> Callable[[ET.Element], None]:
    """An edit that changes attributes of a joint's limit."""

    def edit(root: ET.Element) -> None:
        limit = joint(root, name).find("limit")
        assert limit is not None
        limit.attrib.update({key: repr(value) for key, value in values.items()})

    return edit


def scale_mass(name: str, factor: float) -> Callable[[ET.Element], None]:
    """An edit that scales the mass of a link."""

    def edit(root: ET.Element) -> None:
        mass = link(root, name).find("inertial/mass")
        assert mass is not None
        mass.set("value", repr(factor * float(mass.attrib["value"])))

    return edit


def add_arm(root: ET.Element) -> None:
    """Hang a two kilogram arm on the torso by a revolute joint."""
    root.append(
        ET.fromstring(
            "<link name='arm'><inertial><origin xyz='0 0 -0.2'/><mass value='2.0'/>"
            "<inertia ixx='0.02' iyy='0.02' izz='0.001' ixy='0' ixz='0' iyz='0'/></inertial></link>"
        )
    )
    root.append(
        ET.fromstring(
            "<joint name='shoulder' type='revolute'><parent link='torso'/><child link='arm'/>"
            "<origin xyz='0 0 0.4'/><axis xyz='0 1 0'/>"
            "<limit effort='50' velocity='5' lower='-1' upper='1'/></joint>"
        )
    )


def _named(root: ET.Element, tag: str, name: str) -> ET.Element:
    found = next(e for e in root.findall(tag) if e.get("name") == name)
    assert found is not None
    return found
