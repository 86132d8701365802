"""The same robot written as another URDF: other names, frames, axes, splits, root, mirror image.

Written for tests: no line of it is shared with the package. Each takes the root of a tree and a
random generator, and changes nothing that a walk depends on.
"""

from xml.etree import ElementTree as ET

import numpy as np

_TURNING = ("revolute", "continuous")
_MOMENTS = (
    ("ixx", 0, 0),
    ("ixy", 0, 1),
    ("ixz", 0, 2),
    ("iyy", 1, 1),
    ("iyz", 1, 2),
    ("izz", 2, 2),
)


def _vector(text):
    return np.array([float(word) for word in text.split()])


def _text(values):
    return " ".join(repr(float(value)) for value in values)


def _rotation(rpy):
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def _angles(R):
    pitch = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    if abs(np.cos(pitch)) < 1e-9:
        return np.array([np.arctan2(-R[1, 2], R[1, 1]), pitch, 0.0])
    return np.array([np.arctan2(R[2, 1], R[2, 2]), pitch, np.arctan2(R[1, 0], R[0, 0])])


def _place(element):
    origin, T = element.find("origin"), np.eye(4)
    if origin is not None:
        T[:3, :3] = _rotation(_vector(origin.get("rpy", "0 0 0")))
        T[:3, 3] = _vector(origin.get("xyz", "0 0 0"))
    return T


def _put(element, T):
    origin = element.find("origin")
    if origin is None:
        origin = ET.SubElement(element, "origin")
    origin.set("xyz", _text(T[:3, 3]))
    origin.set("rpy", _text(_angles(T[:3, :3])))


def _at(R=None, p=(0.0, 0.0, 0.0)):
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = np.eye(3) if R is None else R, p
    return T


def _turn(rng):
    Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return Q * np.linalg.det(Q)


def _axis(joint):
    axis = joint.find("axis")
    if axis is None:
        axis = ET.SubElement(joint, "axis", xyz="1 0 0")
    return axis


def _tensor(inertia):
    T = np.zeros((3, 3))
    for name, i, j in _MOMENTS:
        T[i, j] = T[j, i] = float(inertia.get(name, "0"))
    return T


def _root_link(root):
    children = {joint.find("child").get("link") for joint in root.findall("joint")}
    return next(link for link in root.findall("link") if link.get("name") not in children)


def _move_link(root, link, D):
    """Write all that a link carries in another frame, at D in its own."""
    name, back = link.get("name"), np.linalg.inv(D)
    for part in link:
        if part.tag in ("inertial", "visual", "collision"):
            _put(part, back @ _place(part))
    for joint in root.findall("joint"):
        if joint.find("parent").get("link") == name:
            _put(joint, back @ _place(joint))
        if joint.find("child").get("link") == name:
            _put(joint, _place(joint) @ D)
            if joint.get("type") in (*_TURNING, "prismatic"):
                axis = _axis(joint)
                axis.set("xyz", _text(D[:3, :3].T @ _vector(axis.get("xyz"))))


def _fix(root, name, parent, child, T):
    joint = ET.SubElement(root, "joint", name=name, type="fixed")
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    _put(joint, T)


def shuffled(root, rng):
    """Links and joints in another order."""
    own = [part for part in root if part.tag in ("link", "joint")]
    for part in own:
        root.remove(part)
    for k in rng.permutation(len(own)):
        root.append(own[k])


def named_otherwise(scheme):
    """Return what names links and joints by a scheme of kind, number and old name."""

    def rewrite(root, rng):
        del rng
        new = {}
        for kind in ("link", "joint"):
            for k, part in enumerate(root.findall(kind)):
                new[kind, part.get("name")] = scheme(kind, k, part.get("name"))
                part.set("name", new[kind, part.get("name")])
        for joint in root.findall("joint"):
            for end in (joint.find("parent"), joint.find("child")):
                end.set("link", new["link", end.get("link")])
            for mimic in joint.findall("mimic"):
                mimic.set("joint", new["joint", mimic.get("joint")])

    return rewrite


def frames_elsewhere(root, rng):
    """Frames of links turned at random, and moved along the axes of their joints."""
    links = {link.get("name"): link for link in root.findall("link")}
    carriers = {joint.find("parent").get("link") for joint in root.findall("joint")}
    for joint in root.findall("joint"):
        child = joint.find("child").get("link")
        if child not in carriers and joint.get("type") == "fixed":
            continue  # a frame as those of soles, which means something
        axis = _vector(_axis(joint).get("xyz"))
        slide = 0.05 * axis / np.linalg.norm(axis) if joint.get("type") in _TURNING else np.zeros(3)
        _move_link(root, links[child], _at(_turn(rng), rng.uniform(-1.0, 1.0) * slide))


def axes_reversed(root, rng):
    """Axes of some joints reversed, with their ranges and what follows them."""
    turned = set()
    for joint in root.findall("joint"):
        if joint.get("type") in _TURNING and rng.random() < 0.6:
            turned.add(joint.get("name"))
            _axis(joint).set("xyz", _text(-_vector(_axis(joint).get("xyz"))))
            limit = joint.find("limit")
            if limit is not None and "lower" in limit.attrib:
                ends = float(limit.get("lower")), float(limit.get("upper"))
                limit.set("lower", repr(-ends[1]))
                limit.set("upper", repr(-ends[0]))
    for joint in root.findall("joint"):
        for mimic in joint.findall("mimic"):
            own = -1.0 if joint.get("name") in turned else 1.0
            other = -1.0 if mimic.get("joint") in turned else 1.0
            for name, usual, sign in (("multiplier", "1", own * other), ("offset", "0", own)):
                mimic.set(name, repr(sign * float(mimic.get(name, usual))))


def inertias_turned(root, rng):
    """Inertias given in other axes."""
    for link in root.findall("link"):
        for inertial in link.findall("inertial"):
            R = _turn(rng)
            tensor = R.T @ _tensor(inertial.find("inertia")) @ R
            _put(inertial, _place(inertial) @ _at(R))
            for name, i, j in _MOMENTS:
                inertial.find("inertia").set(name, repr(float(tensor[i, j])))


def links_split(root, rng):
    """Half the mass of some links on others, welded to them."""
    for link in root.findall("link"):
        whole = link.find("inertial")
        if whole is None or rng.random() < 0.5:
            continue
        whole.find("mass").set("value", repr(0.5 * float(whole.find("mass").get("value"))))
        for name, _, _ in _MOMENTS:
            moment = 0.5 * float(whole.find("inertia").get(name, "0"))
            whole.find("inertia").set(name, repr(moment))
        half, T = ET.fromstring(ET.tostring(whole)), _at(_turn(rng), 0.1 * rng.normal(size=3))
        _put(half, np.linalg.inv(T) @ _place(half))
        other = ET.SubElement(root, "link", name=f"{link.get('name')}_half")
        other.append(half)
        _fix(root, f"{link.get('name')}_weld", link.get("name"), other.get("name"), T)


def frames_between(root, rng):
    """Links without mass before and behind some joints."""
    for joint in root.findall("joint"):
        name = joint.get("name")
        parent, child = joint.find("parent"), joint.find("child")
        if rng.random() < 0.4:
            ET.SubElement(root, "link", name=f"{name}_behind")
            _fix(root, f"{name}_stiff", f"{name}_behind", child.get("link"), np.eye(4))
            child.set("link", f"{name}_behind")
        if rng.random() < 0.4:
            D = _at(_turn(rng), 0.05 * rng.normal(size=3))
            ET.SubElement(root, "link", name=f"{name}_before")
            _fix(root, f"{name}_mounting", parent.get("link"), f"{name}_before", _place(joint) @ D)
            _put(joint, np.linalg.inv(D))
            parent.set("link", f"{name}_before")


def root_turned(*rows):
    """Return what turns the root link: its axes are the rows of a matrix in the new ones."""

    def rewrite(root, rng):
        del rng
        _move_link(root, _root_link(root), _at(np.array(rows, dtype=float)))

    return rewrite


def root_moved(root, rng):
    """The root link elsewhere on the same body."""
    _move_link(root, _root_link(root), _at(p=0.3 * rng.normal(size=3)))


def welded_to_world(root, rng):
    """The robot on a link of the world, somewhere."""
    name = _root_link(root).get("name")
    ET.SubElement(root, "link", name="somewhere")
    _fix(root, "put_there", "somewhere", name, _at(p=rng.normal(size=3)))


def mirrored(root, rng):
    """The mirror image in the plane y = 0; names stay."""
    del rng
    S = np.diag([1.0, -1.0, 1.0])
    for part in root.iter():
        if (
            part.tag in ("inertial", "visual", "collision", "joint")
            and part.find("origin") is not None
        ):
            T = _place(part)
            _put(part, _at(S @ T[:3, :3] @ S, S @ T[:3, 3]))
    for inertia in root.iter("inertia"):
        for name in ("ixy", "iyz"):
            inertia.set(name, repr(-float(inertia.get(name, "0"))))
    for mesh in root.iter("mesh"):
        mesh.set("scale", _text(S @ _vector(mesh.get("scale", "1 1 1"))))
    for joint in root.findall("joint"):
        if joint.get("type") in _TURNING:
            _axis(joint).set("xyz", _text(-S @ _vector(_axis(joint).get("xyz"))))


def all_at_once(root, rng):
    """One after another."""
    for rewrite in (inertias_turned, frames_elsewhere, axes_reversed, links_split, frames_between):
        rewrite(root, rng)
    shuffled(root, rng)


def _side_last(kind, number, name):
    del kind, number
    side, _, rest = name.partition("_")
    return f"{rest}_{side[0]}" if side in ("left", "right") else name


def _other_side(kind, number, name):
    del kind, number
    return name.replace("left", "?").replace("right", "left").replace("?", "right")


REWRITINGS = {
    "shuffled": shuffled,
    "numbered": named_otherwise(lambda kind, k, name: f"{kind}{k}"),
    "upper case": named_otherwise(lambda kind, k, name: name.upper()),
    "prefixed": named_otherwise(lambda kind, k, name: f"robot/{name}"),
    "sides at the end": named_otherwise(_side_last),
    "sides exchanged": named_otherwise(_other_side),
    "frames elsewhere": frames_elsewhere,
    "axes reversed": axes_reversed,
    "inertias turned": inertias_turned,
    "links split": links_split,
    "frames between": frames_between,
    "x to the left": root_turned([0, 1, 0], [-1, 0, 0], [0, 0, 1]),
    "backwards": root_turned([-1, 0, 0], [0, -1, 0], [0, 0, 1]),
    "y up": root_turned([1, 0, 0], [0, 0, -1], [0, 1, 0]),
    "x up": root_turned([0, 1, 0], [0, 0, 1], [1, 0, 0]),
    "root moved": root_moved,
    "welded to world": welded_to_world,
    "mirrored": mirrored,
    "all at once": all_at_once,
}


def rewritten(text, how, seed):
    """The text of a URDF written otherwise."""
    root = ET.fromstring(text)
    REWRITINGS[how](root, np.random.default_rng(seed))
    return ET.tostring(root, encoding="unicode")
