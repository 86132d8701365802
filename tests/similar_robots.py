"""Robots and tasks in other units of length, mass and gravity: their walks are the same, scaled.

Written for tests, by dimensional analysis alone: every number is multiplied by what its unit says.
"""

from dataclasses import dataclass, fields, replace
from xml.etree import ElementTree as ET

from gaitopt.gait.constraint import declared_margins
from gaitopt.gait.task import Task
from gaitopt.model.sole import Sole


@dataclass(frozen=True)
class Units:
    """How many times larger lengths, masses and accelerations are; times follow from them."""

    length: float = 1.0
    mass: float = 1.0
    gravity: float = 1.0

    @property
    def time(self):
        return (self.length / self.gravity) ** 0.5

    @property
    def force(self):
        return self.mass * self.gravity

    def of(self, unit):
        """How many times larger a quantity of a unit is."""
        return {
            "": 1.0, "rad": 1.0, "m": self.length, "s": self.time, "kg": self.mass,
            "N": self.force, "N·m": self.force * self.length, "m/s": self.length / self.time,
            "rad/s": 1.0 / self.time, "1/m": 1.0 / self.length,
            "kg·m²": self.mass * self.length**2,
            "N·m·s/rad": self.force * self.length * self.time,
            "N²·m·s": self.force**2 * self.length * self.time,
        }[unit]  # fmt: skip


def similar_urdf(text, units):
    """The URDF of a robot with every number in other units."""
    root = ET.fromstring(text)
    of = units.of
    by_tag = {
        "origin": {"xyz": of("m")},
        "mass": {"value": of("kg")},
        "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), of("kg·m²")),
        "box": {"size": of("m")},
        "cylinder": {"radius": of("m"), "length": of("m")},
        "sphere": {"radius": of("m")},
        "limit": {"effort": of("N·m"), "velocity": of("rad/s")},
        "dynamics": {"damping": of("N·m·s/rad"), "friction": of("N·m")},
        "rotorInertia": {None: of("kg·m²")},
    }
    for element in root.iter():
        for name, factor in by_tag.get(element.tag, {}).items():
            if name is None:
                element.text = repr(factor * float(element.text))
            elif name in element.attrib:
                words = element.get(name).split()
                element.set(name, " ".join(repr(factor * float(word)) for word in words))
    for mesh in root.iter("mesh"):
        scale = [units.length * float(word) for word in mesh.get("scale", "1 1 1").split()]
        mesh.set("scale", " ".join(map(repr, scale)))
    return ET.tostring(root, encoding="unicode")


def similar_sole(sole, units):
    return Sole(**{one.name: units.length * getattr(sole, one.name) for one in fields(sole)})


def _times(value, factor):
    return value if value is None or isinstance(value, bool) else factor * value


def similar_task(task, units):
    """The task of a walk with every number in other units."""
    margins = {
        name: _times(getattr(task.margins, name), units.of(declared.unit))
        for name, declared in declared_margins(task.margins).items()
    }
    geometry = tuple(
        replace(
            one,
            **{part: units.of(one.unit) * getattr(one, part) for part in _PARTS},
        )
        for one in task.geometry
    )
    own = {
        "speed": "m/s", "lateral_speed": "m/s", "turn_rate": "rad/s", "duration": "s",
        "double_support": "s", "toe_strip": "m", "heel_strip": "m", "stairs": "m",
    }  # fmt: skip
    mine = {name: _times(getattr(task, name), units.of(unit)) for name, unit in own.items()}
    return replace(
        Task(),
        **{one.name: getattr(task, one.name) for one in fields(task)}
        | mine
        | {"margins": replace(task.margins, **margins), "geometry": geometry},
    )


_PARTS = ("lower", "upper", "value")
