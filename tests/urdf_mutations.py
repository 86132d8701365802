"""URDFs changed at random, and an independent reader of what they say."""

import math
import re
from dataclasses import dataclass, field
from xml.etree import ElementTree as ET

import numpy as np

_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
_NUMERIC = (
    "xyz", "rpy", "value", "ixx", "ixy", "ixz", "iyy", "iyz", "izz", "lower", "upper", "effort",
    "velocity", "damping", "friction", "size", "radius", "length", "rgba",
)  # fmt: skip
FORMS = (
    "{} ", " {}", "{}\t", "\n{}", "{}_0", "1_{}", "\u0664", "\u00a0{}", "0x1A", "0x1p3", "inf",
    "-inf", "nan", "1,5", "{}, 0", "{};", "", "1e", "{}e", "+{}", "--{}", ".", "{} 1", "{}f",
    "{}d0", "1e400", "1e-320", "1e3", "-{}", "1e7", "${{x}}", "{}%", "\uff11", "TRUE", "None",
)  # fmt: skip
_NAMES = ("universe", "root_joint", "", "a\tb", "\u202eevil", "base", "left_knee", "x" * 300)
_TYPES = ("fixed", "continuous", "prismatic", "floating", "planar", "Revolute", "ball", "")


def mutate_urdf(text: str, rng: np.random.Generator, times: int = 1) -> str:
    """A URDF changed at random in one place, or in several.

    Numbers are written as people and programs write them, elements doubled, lost, misspelt, moved;
    now and then the text itself is damaged.
    """
    for _ in range(times):
        if rng.random() < 0.05:
            text = damage(text, rng)
            continue
        try:
            root = ET.fromstring(text)
        except ET.ParseError:
            return text
        edits = (_number, _number, _number, _scale, double, drop, misspell, _name, _kind, move)
        edits[rng.integers(len(edits))](root, rng)
        text = ET.tostring(root, encoding="unicode")
    return text


def pick(items, rng):
    return items[rng.integers(len(items))]


def _numeric(root, rng):
    found = [(e, k) for e in root.iter() for k in e.attrib if k in _NUMERIC]
    return pick(found, rng) if found else (root, "value")


def _number(root, rng):
    element, key = _numeric(root, rng)
    words = element.get(key, "0").split() or ["0"]
    place = int(rng.integers(len(words)))
    words[place] = str(pick(FORMS, rng)).format(words[place])
    element.set(key, " ".join(words))


def _scale(root, rng):
    element, key = _numeric(root, rng)
    words = element.get(key, "0").split() or ["0"]
    place = int(rng.integers(len(words)))
    if _NUMBER.fullmatch(words[place]):
        words[place] = repr(float(words[place]) * float(rng.choice([-1.0, 0.0, 0.3, 1.1, 1e3])))
    element.set(key, " ".join(words))


def _parents(root):
    return [(parent, child) for parent in root.iter() for child in parent]


def double(root, rng):
    parent, child = pick(_parents(root), rng)
    parent.insert(int(rng.integers(len(parent) + 1)), child)


def drop(root, rng):
    parent, child = pick(_parents(root), rng)
    if rng.random() < 0.5 and child.attrib:
        child.attrib.pop(pick(list(child.attrib), rng))
    else:
        parent.remove(child)


def misspell(root, rng):
    _, child = pick(_parents(root), rng)
    if rng.random() < 0.5 and child.attrib:
        key = pick(list(child.attrib), rng)
        child.set(_typo(key, rng), child.attrib.pop(key))
    else:
        child.tag = _typo(child.tag, rng)


def _typo(word, rng):
    place = int(rng.integers(len(word)))
    return pick([word[:place] + word[place + 1 :], word.upper(), word + "s"], rng) or "x"


def _name(root, rng):
    named = [e for e in root if e.tag in ("link", "joint")]
    if named:
        element, new = pick(named, rng), str(pick(_NAMES, rng))
        old = element.get("name")
        element.set("name", new)
        for end in root.iter():
            if rng.random() < 0.8 and end.get("link") == old and element.tag == "link":
                end.set("link", new)


def _kind(root, rng):
    joints = root.findall("joint")
    if joints:
        pick(joints, rng).set("type", str(pick(_TYPES, rng)))


def move(root, rng):
    parent, child = pick(_parents(root), rng)
    parent.remove(child)
    parent.insert(int(rng.integers(len(parent) + 1)), child)


def damage(text, rng):
    place = int(rng.integers(len(text)))
    return pick(
        [text[:place], text[:place] + "<" + text[place:], text[:place] + text[place + 1 :]], rng
    )


@dataclass
class Body:
    """Links that move as one: mass, first and second moment in the frame of their joint."""

    mass: float = 0.0
    first: np.ndarray = field(default_factory=lambda: np.zeros(3))
    second: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))


@dataclass
class Facts:
    """What a URDF says, read by Python's XML and `float`, of numbers in strict form only."""

    bodies: dict[str, Body]
    places: dict[str, np.ndarray]
    limits: dict[str, tuple[float, float, float, float]]
    passive: dict[str, tuple[float, float]]


def strict_facts(text: str, angles: dict[str, float]) -> Facts:
    """The facts of a URDF whose joints stand at some angles; ValueError if a number is none.

    Written for tests: no line of it is shared with the package.
    """
    root = ET.fromstring(text)
    joints = {j.get("name"): j for j in root.findall("joint")}
    above = {j.find("child").get("link"): j for j in joints.values()}
    links = {e.get("name"): e for e in root.findall("link")}
    (base,) = [name for name in links if name not in above]
    facts = Facts({"": Body()}, {}, {}, {})
    waiting = [(base, "", np.eye(4), np.eye(4))]
    while waiting:
        name, mover, place, inside = waiting.pop()
        facts.places[name] = place
        _add(facts.bodies[mover], links[name].find("inertial"), inside)
        for joint in (j for j in joints.values() if j.find("parent").get("link") == name):
            step = _transform(joint.find("origin"))
            own, child = joint.get("name"), joint.find("child").get("link")
            if joint.get("type") == "fixed":
                waiting.append((child, mover, place @ step, inside @ step))
                continue
            facts.bodies[own] = Body()
            step = step @ _moved(joint, angles.get(own, 0.0))
            _read_joint(facts, joint)
            waiting.append((child, own, place @ step, np.eye(4)))
    return facts


def _value(text):
    word = text.strip(" \t\r\n")
    if not _NUMBER.fullmatch(word):
        raise ValueError(text)
    return float(word)


def _vector(text):
    values = [_value(word) for word in text.split()]
    if len(values) != 3:
        raise ValueError(text)
    return np.array(values)


def _transform(origin):
    matrix = np.eye(4)
    if origin is not None:
        roll, pitch, yaw = _vector(origin.get("rpy", "0 0 0"))
        matrix[:3, :3] = _turn([0, 0, 1], yaw) @ _turn([0, 1, 0], pitch) @ _turn([1, 0, 0], roll)
        matrix[:3, 3] = _vector(origin.get("xyz", "0 0 0"))
    return matrix


def _turn(axis, angle):
    """Rodrigues' formula."""
    axis = np.asarray(axis) / np.abs(axis).max()
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def _moved(joint, angle):
    matrix = np.eye(4)
    if joint.get("type") in ("revolute", "continuous", "prismatic"):
        axis = joint.find("axis")
        axis = np.array([1.0, 0.0, 0.0]) if axis is None else _vector(axis.get("xyz", ""))
        if joint.get("type") == "prismatic":
            axis = axis / np.abs(axis).max()
            matrix[:3, 3] = angle * axis / np.linalg.norm(axis)
        else:
            matrix[:3, :3] = _turn(axis, angle)
    return matrix


def _add(body, inertial, inside):
    if inertial is None:
        return
    mass = _value(inertial.find("mass").get("value"))
    x, xy, xz, y, yz, z = (
        _value(inertial.find("inertia").get(k)) for k in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    )
    tensor = np.array([[x, xy, xz], [xy, y, yz], [xz, yz, z]])
    place = inside @ _transform(inertial.find("origin"))
    turn, centre = place[:3, :3], place[:3, 3]
    body.mass += mass
    body.first = body.first + mass * centre
    about = turn @ tensor @ turn.T
    shift = centre @ centre * np.eye(3) - np.outer(centre, centre)
    body.second = body.second + about + mass * shift


def _read_joint(facts, joint):
    name, limit, dynamics = joint.get("name"), joint.find("limit"), joint.find("dynamics")
    if joint.get("type") not in ("revolute", "continuous", "prismatic"):
        return
    given = {} if limit is None else limit.attrib
    effort, velocity, lower, upper = (
        math.inf if "inf" in given.get(k, usual).lower() else _value(given.get(k, usual))
        for k, usual in (("effort", "inf"), ("velocity", "inf"), ("lower", "0"), ("upper", "0"))
    )
    if "-inf" in given.get("lower", "").lower():
        lower = -math.inf
    if "-inf" in given.get("upper", "").lower():
        upper = -math.inf
    if joint.get("type") == "continuous":
        lower, upper = -math.inf, math.inf
    facts.limits[name] = (effort, velocity, lower, upper)
    given = {} if dynamics is None else dynamics.attrib
    damping, friction = (_value(given.get(k, "0")) for k in ("damping", "friction"))
    facts.passive[name] = (damping, friction)
