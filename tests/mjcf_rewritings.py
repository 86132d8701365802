"""The same robot written as another MJCF file: other frames, units, classes, names, mirror image.

The counterpart of `urdf_rewritings`, for files without meshes; no line of it is shared with the
package. Each takes the root of MuJoCo's own text of a file and a random generator.
"""

from pathlib import Path
from xml.etree import ElementTree as ET

import mujoco
import numpy as np

_NUMBERS = ("armature", "frictionloss", "damping", "stiffness")
_OF_CLASSES = (*_NUMBERS, "range", "axis", "ref", "springref", "actuatorfrcrange")
_MIRROR = np.array([1.0, -1.0, 1.0])


def _vector(text):
    return np.array([float(word) for word in text.split()])


def _text(values):
    return " ".join(repr(float(value)) for value in np.atleast_1d(values))


def _times(first, other):
    result = np.zeros(4)
    mujoco.mju_mulQuat(result, first, other)
    return result


def _turned(quat, vector):
    result = np.zeros(3)
    mujoco.mju_rotVecQuat(result, vector, quat)
    return result


def _place(element):
    assert not {"axisangle", "euler", "xyaxes", "zaxis"} & element.attrib.keys()
    quat = _vector(element.get("quat", "1 0 0 0"))
    return _vector(element.get("pos", "0 0 0")), quat / np.linalg.norm(quat)


def _seen_from(pos, quat, element):
    """Give an element its place in a frame that lies at `pos` and `quat` where it was."""
    own, turn = _place(element)
    back = quat * [1.0, -1.0, -1.0, -1.0]
    element.set("pos", _text(_turned(back, own - pos)))
    if element.tag == "joint":
        element.set("axis", _text(_turned(back, _vector(element.get("axis")))))
    else:
        element.set("quat", _text(_times(back, turn)))


def _anywhere(rng):
    quat = rng.normal(size=4)
    return 0.2 * rng.normal(size=3), quat / np.linalg.norm(quat)


def _parents(root):
    return [root.find("worldbody"), *root.iter("body")]


def _joints(root):
    return [j for j in root.find("worldbody").iter("joint") if j.get("type") != "free"]


def shuffled(root, rng):
    """Bodies in another order, and motors."""
    for parent in [*_parents(root), *root.findall("actuator")]:
        inner = [e for e in parent if parent.tag == "actuator" or e.tag == "body"]
        for element in inner:
            parent.remove(element)
        parent.extend(inner[k] for k in rng.permutation(len(inner)))


def in_frames(root, rng):
    """Every body stands in a frame of its own."""
    for parent in _parents(root):
        for k, body in enumerate(list(parent)):
            if body.tag == "body":
                pos, quat = _anywhere(rng)
                frame = ET.Element("frame", pos=_text(pos), quat=_text(quat))
                _seen_from(pos, quat, body)
                parent[k] = frame
                frame.append(body)


def bodies_turned(root, rng):
    """Every body but the root has other axes, and its origin elsewhere."""
    for body in list(root.iter("body"))[1:]:
        pos, quat = _anywhere(rng)
        own, turn = _place(body)
        body.set("pos", _text(own + _turned(turn, pos)))
        body.set("quat", _text(_times(turn, quat)))
        for element in body:
            _seen_from(pos, quat, element)


def in_degrees(root, rng):
    compiler = root.find("compiler")
    assert compiler.get("angle") == "radian"
    compiler.set("angle", "degree")
    for joint in _joints(root):
        for name in {"range", "ref", "springref"} & joint.attrib.keys():
            joint.set(name, _text(np.degrees(_vector(joint.get(name)))))


def axes_reversed(root, rng):
    """Some joints turn the other way, and their motors."""
    turned = [joint for joint in _joints(root) if rng.random() < 0.5]
    for joint in turned:
        for name in {"axis", "ref", "springref"} & joint.attrib.keys():
            joint.set(name, _text(-_vector(joint.get(name))))
        for name in {"range", "actuatorfrcrange"} & joint.attrib.keys():
            joint.set(name, _text(-_vector(joint.get(name))[::-1]))
    for motor in root.findall("actuator/*"):
        if motor.get("joint") in {joint.get("name") for joint in turned}:
            motor.set("gear", _text(-_vector(motor.get("gear", "1"))))


def in_classes(root, rng):
    """What a joint is stands in a class of its own, inside one with other numbers."""
    outer = ET.SubElement(ET.SubElement(root, "default"), "default", {"class": "outer"})
    ET.SubElement(outer, "joint", dict.fromkeys(_NUMBERS, "7"))
    for k, joint in enumerate(_joints(root)):
        names = [name for name in _OF_CLASSES if name in joint.attrib]
        own = ET.SubElement(outer, "default", {"class": f"own{k}"})
        ET.SubElement(own, "joint", {name: joint.attrib.pop(name) for name in names})
        joint.set("class", f"own{k}")


def named_otherwise(scheme):
    def rewrite(root, rng):
        named = [element for element in root.iter() if element.get("name")]
        new = {(e.tag, e.get("name")): scheme(k, e.get("name")) for k, e in enumerate(named)}
        for element in root.iter():
            for tag, name in list(element.attrib.items()):
                kind = element.tag if tag == "name" else tag
                element.set(tag, new.get((kind, name), name))

    return rewrite


def masses_apart(root, rng):
    """What weighs is a body of its own, fixed to the one that has the joint."""
    for body in list(root.iter("body")):
        inertial = body.find("inertial")
        pos, quat = _anywhere(rng)
        body.remove(inertial)
        for geom in body.findall("geom"):
            geom.set("mass", "0")
        own = ET.SubElement(body, "body", pos=_text(pos), quat=_text(quat))
        _seen_from(pos, quat, inertial)
        own.append(inertial)


def mirrored(root, rng):
    """The robot in a mirror: left is right."""
    for element in root.find("worldbody").iter():
        if "pos" in element.attrib:
            element.set("pos", _text(_MIRROR * _vector(element.get("pos"))))
        if "quat" in element.attrib:
            element.set("quat", _text(_vector(element.get("quat")) * [1.0, -1.0, 1.0, -1.0]))
    for joint in _joints(root):
        joint.set("axis", _text(-_MIRROR * _vector(joint.get("axis"))))


REWRITINGS = {
    "by MuJoCo": lambda root, rng: None,
    "shuffled": shuffled,
    "in frames": in_frames,
    "bodies turned": bodies_turned,
    "in degrees": in_degrees,
    "axes reversed": axes_reversed,
    "in classes": in_classes,
    "numbered": named_otherwise(lambda k, name: f"n{k}"),
    "sides exchanged": named_otherwise(
        lambda k, name: name.replace("left", "?").replace("right", "left").replace("?", "right")
    ),
    "masses apart": masses_apart,
    "mirrored": mirrored,
}


def rewritten(path: Path, how: str, seed: int) -> str:
    """The text of an MJCF file written otherwise."""
    spec = mujoco.MjSpec.from_file(str(path))
    spec.compile()
    root = ET.fromstring(spec.to_xml())
    joints = {joint.name: joint for joint in spec.joints}
    for element in _joints(root):  # what classes say, to be changed joint by joint
        joint = joints[element.get("name")]
        for name in (*_NUMBERS, "axis", "pos"):
            element.set(name, _text(getattr(joint, name)))
    REWRITINGS[how](root, np.random.default_rng(seed))
    return ET.tostring(root, encoding="unicode")
