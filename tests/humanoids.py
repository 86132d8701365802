"""The biped's URDF with other roots, names, arms and toes: humanoids that nobody prepared."""

from collections.abc import Callable
from xml.etree import ElementTree as ET

Edit = Callable[[ET.Element], None]

_INERTIAL = (
    "<inertial><origin xyz='0 0 -0.1'/><mass value='{mass}'/>"
    "<inertia ixx='0.01' iyy='0.01' izz='0.002' ixy='0' ixz='0' iyz='0'/></inertial>"
)
_LIMIT = "<limit effort='40' velocity='6' lower='-1.2' upper='1.4'/>"


def edits(*parts: Edit) -> Edit:
    """All edits, one after another."""

    def edit(root: ET.Element) -> None:
        for part in parts:
            part(root)

    return edit


def new_root(rpy: str, xyz: str = "0.02 -0.01 0.3", *, waist: str = "fixed") -> Edit:
    """Put the torso on another link, turned, by a fixed or a revolute joint."""

    def edit(root: ET.Element) -> None:
        add_link(root, "base", 0.0)
        add_joint(root, "waist", "base", "torso", xyz=xyz, rpy=rpy, kind=waist, axis="0 0 1")

    return edit


def add_link(root: ET.Element, name: str, mass: float) -> None:
    """Add a link; without inertia if it has no mass."""
    inertial = _INERTIAL.format(mass=mass) if mass > 0.0 else ""
    root.append(ET.fromstring(f"<link name='{name}'>{inertial}</link>"))


def add_joint(
    root: ET.Element,
    name: str,
    parent: str,
    child: str,
    *,
    xyz: str,
    rpy: str = "0 0 0",
    kind: str = "revolute",
    axis: str = "0 1 0",
) -> None:
    """Add a joint, with limits if it is not fixed."""
    root.append(
        ET.fromstring(
            f"<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>"
            f"<origin xyz='{xyz}' rpy='{rpy}'/><axis xyz='{axis}'/>{_LIMIT}</joint>"
        )
    )


def add_arms(joints: int, *, step: float = -0.05) -> Edit:
    """Two mirrored arms of that many joints that hang beside the torso."""

    def edit(root: ET.Element) -> None:
        for side, sign in (("left", 1.0), ("right", -1.0)):
            parent, xyz = "torso", f"0 {sign * 0.25} 0.45"
            for k in range(joints):
                axis = ("0 1 0", f"{sign} 0 0", f"0 0 {sign}")[k % 3]
                add_link(root, f"{side}_arm_{k}", 0.5)
                add_joint(
                    root, f"{side}_arm_joint_{k}", parent, f"{side}_arm_{k}", xyz=xyz, axis=axis
                )
                parent, xyz = f"{side}_arm_{k}", f"0 0 {step}"

    return edit


def add_toes(count: int = 1) -> Edit:
    """Hinged toes on both feet."""

    def edit(root: ET.Element) -> None:
        for side, sign in (("left", 1.0), ("right", -1.0)):
            for k in range(count):
                add_link(root, f"{side}_toes_{k}", 0.1)
                add_joint(
                    root,
                    f"{side}_toe_{k}",
                    f"{side}_foot",
                    f"{side}_toes_{k}",
                    xyz=f"0.12 {sign * 0.03 * k} -0.09",
                )

    return edit


def rename(changes: dict[str, str]) -> Edit:
    """Replace parts of all names, in both directions at once."""

    def edit(root: ET.Element) -> None:
        for element in root.iter():
            for key in ("name", "link"):
                value = element.get(key)
                if value is not None:
                    element.set(key, _renamed(value, changes))

    return edit


def _renamed(name: str, changes: dict[str, str]) -> str:
    for old, new in changes.items():
        if old in name:
            return name.replace(old, new)
    return name
