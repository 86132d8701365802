"""Change the robot and see what its motors must deliver: a longer shin, a heavier trunk."""

from dataclasses import dataclass

from gaitopt import Robot, biped13, design_gait, preset_task, summarise, urdf_text
from gaitopt.catalogue.parameters import changed


@dataclass(frozen=True)
class Variant:
    """A biped that differs from the paper's in some values, by the paths of its table."""

    name: str
    changes: dict[str, float]


spec = biped13()
shin, trunk = spec.geometry.d3, spec.links.torso.mass
VARIANTS = (
    Variant("as it is", {}),
    Variant("shin 2 cm longer", {"geometry.d3": shin + 0.02}),
    Variant("trunk 5 kg heavier", {"links.torso.mass": trunk + 5.0}),
)

print("variant               cost   knee: torque    power")
for variant in VARIANTS:
    robot = Robot.from_urdf(urdf_text(changed(spec, variant.changes)))
    found = design_gait(robot, preset_task("standard", robot, speed=0.8))
    knee = next(m for m in summarise(found.gait)["motors"] if m["joint"] == "knee")
    print(
        f"{variant.name:20} {found.gait.cost:6.0f} {knee['peak_torque_Nm']:9.1f} N·m "
        f"{knee['peak_power_W']:7.1f} W"
    )
