"""Random MJCF files that use what the format has for a robot, each reproducible from its seed."""

from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

_SHAPES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}
_ROOTS = ("freejoint", "free", "fixed", "six", "planar", "nested", "ball")
_CORNERS = "0.01 0.02 0 0.2 0 0.01 0 0.15 0.03 0.02 0.01 0.1 0.12 0.11 0.09"


class _Generator:
    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.degrees = self.flip()
        self.auto = self.flip(0.7)
        self.count, self.joints, self.bodies = 0, [], []
        self.classes = ["main", "limb", "leaf"]

    def flip(self, chance: float = 0.5) -> bool:
        return bool(self.rng.random() < chance)

    def some(self, least: float, most: float) -> float:
        return float(self.rng.uniform(least, most))

    def text(self, *numbers: float) -> str:
        return " ".join(repr(round(float(n), 6)) for n in numbers)

    def vector(self, size: float = 0.3) -> str:
        return self.text(*self.rng.normal(0.0, size, 3))

    def angle(self, value: float) -> float:
        return float(np.degrees(value)) if self.degrees else value

    def pick(self, *options):
        return options[int(self.rng.integers(len(options)))]

    def name(self, kind: str) -> str:
        self.count += 1
        return f"{kind}{self.count}"

    def turn(self) -> dict[str, str]:
        """One of the ways to turn a frame."""
        kind = self.pick("none", "quat", "euler", "axisangle", "xyaxes", "zaxis")
        if kind == "quat":
            return {"quat": self.text(*self.rng.normal(size=4))}
        if kind == "euler":
            return {"euler": self.text(*(self.angle(a) for a in self.rng.normal(size=3)))}
        if kind == "axisangle":
            turn = self.angle(self.some(-2, 2))
            return {"axisangle": self.text(*self.rng.normal(size=3), turn)}
        if kind == "xyaxes":
            return {"xyaxes": self.text(*self.rng.normal(size=6))}
        return {"zaxis": self.vector(1.0)} if kind == "zaxis" else {}

    def polynomial(self, size: float) -> str:
        count = int(self.rng.integers(1, 4))
        return self.text(*(self.some(0, size) / 4**k for k in range(count)))

    def range(self, least: float, most: float) -> str:
        return self.text(-self.some(least, most), self.some(least, most))

    def document(self, folder: Path) -> ET.Element:
        root = ET.Element("mujoco", model=self.name("robot"))
        self.compiler(root)
        option = ET.SubElement(root, "option")
        if self.flip():
            option.set("gravity", self.pick("0 0 -1.62", "0.3 0 -9.7", "0 0 -9.81"))
        if self.flip(0.2):
            word = self.pick("gravity", "spring", "damper", "frictionloss", "equality")
            ET.SubElement(option, "flag", {word: "disable"})
        self.defaults(root)
        asset = ET.SubElement(root, "asset")
        mesh = ET.SubElement(asset, "mesh", name="rock", vertex=_CORNERS, scale="1 1.5 0.8")
        if self.flip():
            mesh.attrib.update(refpos=self.vector(0.1), refquat=self.text(*self.rng.normal(size=4)))
        ET.SubElement(asset, "material", name="paint", rgba="0.1 0.2 0.3 1")
        world = ET.SubElement(root, "worldbody")
        ET.SubElement(world, "geom", name="floor", type="plane", size="1 1 0.1")
        if self.flip(0.3):
            shelf = ET.SubElement(world, "body", name="shelf", pos="2 0 0")
            ET.SubElement(shelf, "geom", type="box", size="1 1 1")
        if self.flip(0.3):
            thing = ET.SubElement(world, "body", name="thing", pos="0 3 0")
            ET.SubElement(thing, "freejoint", name="thing_root")
            ET.SubElement(thing, "geom", size="0.1")
        self.robot(world)
        self.transmissions(root)
        self.split(root, folder)
        return root

    def compiler(self, root: ET.Element) -> None:
        compiler = ET.SubElement(root, "compiler", angle="degree" if self.degrees else "radian")
        compiler.set("autolimits", "true" if self.auto else "false")
        if self.flip():
            compiler.set("eulerseq", self.pick("xyz", "XYZ", "zyx", "ZxY"))
        if self.flip(0.3):
            compiler.set("inertiafromgeom", self.pick("true", "auto"))
        if self.flip(0.3):
            compiler.set("inertiagrouprange", "0 1")
        if self.flip(0.3):
            compiler.set("settotalmass", self.text(self.some(20, 80)))
        if self.flip(0.3):
            compiler.set("balanceinertia", "true")
        # A body without mass would be refused; see the tests of refusals.
        compiler.attrib.update(boundmass="0.01", boundinertia="0.001")

    def defaults(self, root: ET.Element) -> None:
        main = ET.SubElement(root, "default")
        ET.SubElement(main, "joint", armature=self.text(self.some(0, 0.1)), damping="0.3")
        ET.SubElement(main, "geom", density="700")
        limb = ET.SubElement(main, "default", {"class": "limb"})
        joint = ET.SubElement(limb, "joint", frictionloss="0.2", axis=self.vector(1.0))
        joint.set("range", self.text(self.angle(-1.1), self.angle(0.9)))
        if not self.auto:
            joint.set("limited", "true")
        if self.flip():
            joint.set("ref", self.text(self.angle(0.3)))
        ET.SubElement(limb, "geom", type="box", size="0.1 0.05 0.02", pos="0.03 0 -0.07")
        ET.SubElement(limb, "motor", gear="7", ctrlrange="-3 4", ctrllimited="true")
        leaf = ET.SubElement(limb, "default", {"class": "leaf"})
        ET.SubElement(leaf, "geom", contype="0", conaffinity="0", group="1", rgba="1 0 0 1")
        ET.SubElement(leaf, "position", kp="80", forcerange="-25 30", forcelimited="true")

    def robot(self, world: ET.Element) -> None:
        kind = self.pick(*_ROOTS)
        body = ET.SubElement(world, "body", name="trunk", pos=self.vector(), **self.turn())
        if kind == "freejoint":
            ET.SubElement(body, "freejoint", name="root")
        elif kind == "free":
            ET.SubElement(body, "joint", name="root", type="free", armature="0", damping="0")
        elif kind == "ball":
            ET.SubElement(body, "joint", name="root", type="ball", range="0 0", limited="false")
        elif kind in ("six", "planar", "nested"):
            axes = ("1 0 0", "0 1 0", "0 0 1")
            used = axes[::2] if kind == "planar" else axes
            carrier = body
            if kind == "nested":
                ET.SubElement(
                    body, "inertial", pos="0 0 0", mass="0.02", diaginertia="1e-3 1e-3 1e-3"
                )
            for axis in used:
                ET.SubElement(body, "joint", name=self.name("slide"), type="slide", axis=axis)
            if kind == "nested":
                body = ET.SubElement(carrier, "body", name="pelvis", pos=self.vector())
            for axis in axes[1:2] if kind == "planar" else axes:
                ET.SubElement(body, "joint", name=self.name("turn"), type="hinge", axis=axis)
        ET.SubElement(body, "inertial", pos=self.vector(0.1), mass="9", diaginertia="0.5 0.6 0.7")
        ET.SubElement(body, "geom", size="0.1", mass="3")
        for _ in range(int(self.rng.integers(2, 4))):
            self.limb(body, 0)

    def limb(self, parent: ET.Element, depth: int) -> None:
        holder = parent
        if self.flip(0.3):
            holder = ET.SubElement(parent, "frame", pos=self.vector(), **self.turn())
            if self.flip():
                holder.set("childclass", self.pick("limb", "leaf"))
        body = ET.SubElement(holder, "body", pos=self.vector(), **self.turn())
        if self.flip(0.8):
            body.set("name", self.name("body"))
        if self.flip(0.4):
            body.set("childclass", self.pick("limb", "leaf"))
        if self.flip(0.2):
            body.set("gravcomp", self.text(self.some(0, 1.2)))
        for _ in range(self.pick(0, 1, 1, 1, 2, 3) if depth else self.pick(1, 2)):
            self.joint(body)
        self.inertia(body)
        if self.flip(0.4):
            ET.SubElement(body, "site", name=self.name("site"), pos=self.vector(), **self.turn())
        for _ in range(self.pick(0, 1, 1, 2) if depth < 4 else 0):
            self.limb(body, depth + 1)

    def joint(self, body: ET.Element) -> None:
        kind = self.pick("hinge", "hinge", "hinge", "hinge", "slide", "ball")
        before = [other.get("type", "hinge") for other in body.findall("joint")]
        if "ball" in before:
            kind = "slide"
        elif kind == "ball" and "hinge" in before:
            kind = "hinge"
        joint = ET.SubElement(body, "joint", name=self.name("joint"))
        joint.set("pos", self.vector(0.1))
        if kind != "hinge" or self.flip():
            joint.set("type", kind)
        if kind == "ball":
            joint.attrib.update(range="0 0", limited="false")
            return
        self.joints.append(joint.get("name"))
        unit = self.angle if kind == "hinge" else float
        if self.flip(0.8):
            joint.set("axis", self.pick("1 0 0", "0 -1 0", self.vector(1.0)))
        if self.flip():
            joint.set("range", self.text(unit(-self.some(0.1, 2)), unit(self.some(0.1, 2))))
            if self.flip() or not self.auto:
                words = ("true", "false", "auto")
                joint.set("limited", self.pick(*words[: 3 if self.auto else 2]))
        if self.flip(0.3):
            joint.set("ref", self.text(unit(self.some(-0.5, 0.5))))
        if self.flip(0.4):
            joint.set("armature", self.text(self.some(0, 0.2)))
        if self.flip(0.4):
            joint.set("damping", self.polynomial(3))
        if self.flip(0.3):
            joint.attrib.update(stiffness=self.polynomial(20), springref=self.text(unit(0.2)))
        if self.flip(0.3):
            joint.set("frictionloss", self.text(self.some(0, 2)))
        if self.flip(0.3):
            joint.set("actuatorfrcrange", self.range(1, 60))
            joint.set("actuatorfrclimited", self.pick("true", "auto") if self.auto else "true")

    def inertia(self, body: ET.Element) -> None:
        if self.flip():
            inertial = ET.SubElement(
                body, "inertial", pos=self.vector(0.1), mass=self.text(self.some(0.2, 4))
            )
            a, b = self.some(0.01, 0.05), self.some(0.01, 0.05)
            if self.flip():
                inertial.set("diaginertia", self.text(a, b, self.some(abs(a - b), a + b)))
                inertial.attrib.update(self.turn())
            else:
                inertial.set("fullinertia", self.text(0.05, 0.06, 0.07, 0.004, -0.005, 0.003))
        for _ in range(self.pick(1, 1, 2)):
            self.geom(body)

    def geom(self, body: ET.Element) -> None:
        holder = body
        if self.flip(0.2):
            holder = ET.SubElement(body, "frame", pos=self.vector(0.1), **self.turn())
        geom = ET.SubElement(holder, "geom", pos=self.vector(0.1))
        kind = self.pick(*_SHAPES, "mesh", "class")
        if kind == "class":
            geom.attrib.pop("pos")
            geom.set("class", "limb")
        elif kind == "mesh":
            geom.attrib.update(type="mesh", mesh="rock", **self.turn())
        else:
            size = self.text(*self.rng.uniform(0.02, 0.1, _SHAPES[kind]))
            geom.attrib.update(type=kind, size=size)
            if kind in ("capsule", "cylinder") and self.flip():
                geom.attrib.pop("pos")
                geom.attrib.update({"class": "main", "size": size.split()[0]})
                geom.set("fromto", f"0 0 0 {self.vector(0.2)}")
            else:
                geom.attrib.update(self.turn())
        if self.flip(0.4):
            geom.set("mass", self.text(self.some(0.1, 2)))
        elif self.flip(0.4):
            geom.set("density", self.text(self.some(100, 2000)))
        if self.flip(0.3):
            geom.set("group", self.pick("0", "1", "2", "3"))
        if self.flip(0.3):
            geom.attrib.update(contype="0", conaffinity="0")
        if self.flip(0.2):
            geom.set("material", "paint")

    def transmissions(self, root: ET.Element) -> None:
        actuators = ET.SubElement(root, "actuator")
        tendons = ET.SubElement(root, "tendon")
        for name in self.joints:
            for _ in range(self.pick(0, 1, 1, 1, 2)):
                self.actuator(actuators, joint=name)
            if self.flip(0.15):
                tendon = ET.SubElement(tendons, "fixed", name=self.name("tendon"))
                ET.SubElement(tendon, "joint", joint=name, coef=self.text(self.some(0.5, 3)))
                if self.flip():
                    tendon.attrib.update(armature="0.05", damping="0.7", frictionloss="0.1")
                if self.flip():
                    tendon.attrib.update(stiffness="5", springlength="0.1")
                if self.flip():
                    tendon.attrib.update(
                        actuatorfrcrange=self.range(1, 9), actuatorfrclimited="true"
                    )
                self.actuator(actuators, tendon=tendon.get("name"))
        if len(self.joints) > 1 and self.flip(0.5):
            equality = ET.SubElement(root, "equality")
            ET.SubElement(
                equality, "joint", joint1=self.joints[0], joint2=self.joints[1],
                active=self.pick("true", "false"),
            )  # fmt: skip

    def actuator(self, actuators: ET.Element, **target: str) -> None:
        tag = self.pick("motor", "motor", "position", "velocity", "general", "damper")
        if tag == "damper" and not self.auto:
            tag = "motor"  # a damper must have a range, and cannot say that it counts
        actuator = ET.SubElement(actuators, tag, name=self.name("act"), **target)
        if self.flip(0.3) and tag in ("motor", "position"):
            actuator.set("class", "limb" if tag == "motor" else "leaf")
        if self.flip():
            actuator.set("gear", self.text(self.pick(1, -1) * self.some(0.5, 20)))
        if tag == "damper" or (tag in ("motor", "general") and self.flip(0.7)):
            least = 0.0 if tag == "damper" else -self.some(0.5, 5)
            actuator.set("ctrlrange", self.text(least, self.some(0.5, 5)))
            if tag != "damper":
                actuator.set("ctrllimited", "true")
        if self.flip(0.6):
            actuator.set("forcerange", self.range(0.5, 30))
            actuator.set("forcelimited", "true")
        if tag == "general":
            actuator.set("gainprm", self.text(self.some(0.5, 9)))
            if self.flip(0.3):
                actuator.set("dyntype", "filter")
                actuator.set("dynprm", "0.1")
        if self.flip(0.3):
            actuator.set("armature", self.text(self.some(0, 0.01)))
        if self.flip(0.2):
            actuator.set("damping", self.polynomial(0.1))

    def split(self, root: ET.Element, folder: Path) -> None:
        """Move sections into files of their own, one of which includes the other."""
        if not self.flip(0.5):
            return
        inner, outer = ET.Element("mujocoinclude"), ET.Element("mujocoinclude")
        for tag, place in (("actuator", inner), ("tendon", outer)):
            section = root.find(tag)
            root.remove(section)
            place.append(section)
        ET.SubElement(outer, "include", file="inner.xml")
        (folder / "inner.xml").write_text(ET.tostring(inner, encoding="unicode"), encoding="utf-8")
        (folder / "outer.xml").write_text(ET.tostring(outer, encoding="unicode"), encoding="utf-8")
        ET.SubElement(root, "include", file="outer.xml")


def write_random_mjcf(folder: Path, seed: int) -> Path:
    """Write a random robot and what it includes into a folder; return the main file."""
    root = _Generator(seed).document(folder)
    ET.indent(root)
    path = folder / "robot.xml"
    path.write_text(ET.tostring(root, encoding="unicode"), encoding="utf-8")
    return path
